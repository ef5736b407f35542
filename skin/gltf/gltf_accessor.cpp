#include "skin/gltf/gltf_accessor.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "skin/character/character.h"

namespace backbend::skin {
namespace {

// Past this a character is a mistake: 64 Mi elements are 30 times the heaviest film body.
constexpr std::uint64_t kMaxElements = std::uint64_t{1} << 26;
// An accessor without stored bytes is zeros: its count is bounded by nothing but this.
constexpr std::uint64_t kMaxUnstoredElements = std::uint64_t{1} << 22;
// glTF allows 252; what matters is that count x stride stays far from 64 bits.
constexpr std::uint64_t kMaxStride = std::uint64_t{1} << 16;

int component_size(int type) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return 4;
    default:
      return 0;
  }
}

int component_count(int type) {
  switch (type) {
    case TINYGLTF_TYPE_SCALAR:
      return 1;
    case TINYGLTF_TYPE_VEC2:
      return 2;
    case TINYGLTF_TYPE_VEC3:
      return 3;
    case TINYGLTF_TYPE_VEC4:
      return 4;
    case TINYGLTF_TYPE_MAT4:
      return 16;
    default:
      return 0;
  }
}

/// `count` elements of `element` bytes, `stride` apart, from `first`.
struct Run {
  const std::uint8_t* first = nullptr;
  std::uint64_t stride = 0;
  std::uint64_t count = 0;
};

template <typename T>
T load(const std::uint8_t* bytes) {
  T value;  // accessors of careless exporters are not aligned
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

std::uint32_t load_unsigned(int type, const std::uint8_t* bytes) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return *bytes;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return load<std::uint16_t>(bytes);
    default:
      return load<std::uint32_t>(bytes);
  }
}

float load_number(int type, bool normalised, const std::uint8_t* bytes) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return load<float>(bytes);
    case TINYGLTF_COMPONENT_TYPE_BYTE: {
      const float value = load<std::int8_t>(bytes);
      return normalised ? std::max(value / 127.0f, -1.0f) : value;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return normalised ? static_cast<float>(*bytes) / 255.0f : static_cast<float>(*bytes);
    case TINYGLTF_COMPONENT_TYPE_SHORT: {
      const float value = load<std::int16_t>(bytes);
      return normalised ? std::max(value / 32767.0f, -1.0f) : value;
    }
    default: {
      const float value = load<std::uint16_t>(bytes);
      return normalised ? value / 65535.0f : value;
    }
  }
}

bool is_unsigned(int type) {
  return type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
         type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
         type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

/// Errors and bounds of one reference into the buffers.
class Bounds {
 public:
  Bounds(const tinygltf::Model& model, const std::string& file, std::string place)
      : model_(model), file_(file), place_(std::move(place)) {}

  [[noreturn]] void fail(const std::string& member, const std::string& cause) const {
    throw CharacterError(file_ + ": " + place_ + member + ": " + cause);
  }

  /// `count` elements of `element` bytes from `offset` in a buffer view; `strided` if the view's
  /// byteStride counts.
  Run run(const std::string& member, std::int64_t view_index, std::int64_t offset,
          std::uint64_t element, std::uint64_t count, bool strided) const {
    if (view_index < 0 || static_cast<std::uint64_t>(view_index) >= model_.bufferViews.size())
      fail(member, "buffer view " + std::to_string(view_index) + " does not exist");
    const auto& view = model_.bufferViews[static_cast<std::size_t>(view_index)];
    if (view.buffer < 0 || static_cast<std::size_t>(view.buffer) >= model_.buffers.size())
      fail(member, "buffer " + std::to_string(view.buffer) + " does not exist");
    const auto& data = model_.buffers[static_cast<std::size_t>(view.buffer)].data;
    if (view.byteOffset > data.size() || view.byteLength > data.size() - view.byteOffset)
      fail(member, "buffer view " + std::to_string(view_index) + " runs past its buffer");

    const std::uint64_t stride = strided && view.byteStride != 0 ? view.byteStride : element;
    if (stride < element || stride > kMaxStride)
      fail(member, "byteStride " + std::to_string(stride) + " for elements of " +
                       std::to_string(element) + " bytes");
    // count <= 2^26 and stride <= 2^16: the product cannot overflow 64 bits.
    const std::uint64_t needed = count == 0 ? 0 : (count - 1) * stride + element;
    if (offset < 0 || static_cast<std::uint64_t>(offset) > view.byteLength ||
        needed > view.byteLength - static_cast<std::uint64_t>(offset))
      fail(member,
           std::to_string(count) + " elements run past buffer view " + std::to_string(view_index));
    return {data.data() + view.byteOffset + offset, stride, count};
  }

 private:
  const tinygltf::Model& model_;
  const std::string& file_;
  std::string place_;
};

}  // namespace

struct GltfAccessors::Source {
  std::uint64_t count = 0;
  int components = 0;
  int component_type = 0;
  bool normalised = false;
  Run base;  // nothing stored: zeros
  int sparse_type = 0;
  Run sparse_index, sparse_value;
  std::string place;
};

GltfAccessors::GltfAccessors(const tinygltf::Model& model, std::string file)
    : model_(model), file_(std::move(file)) {}

std::size_t GltfAccessors::count(int accessor, const std::string& place) const {
  if (accessor < 0 || static_cast<std::size_t>(accessor) >= model_.accessors.size())
    throw CharacterError(file_ + ": " + place + ": accessor " + std::to_string(accessor) +
                         " does not exist");
  return model_.accessors[static_cast<std::size_t>(accessor)].count;
}

GltfAccessors::Source GltfAccessors::open(int accessor, int components,
                                          const std::string& place) const {
  Source source;
  source.count = count(accessor, place);
  source.place = "/accessors/" + std::to_string(accessor);
  const Bounds bounds(model_, file_, source.place);
  const auto& entry = model_.accessors[static_cast<std::size_t>(accessor)];
  source.component_type = entry.componentType;
  source.components = components;
  source.normalised = entry.normalized;
  if (component_count(entry.type) != components)
    bounds.fail("/type", "not what " + place + " needs");
  const auto size = static_cast<std::uint64_t>(component_size(entry.componentType));
  if (size == 0) bounds.fail("/componentType", std::to_string(entry.componentType) + " is none");
  const std::uint64_t limit = entry.bufferView < 0 ? kMaxUnstoredElements : kMaxElements;
  if (source.count > limit)
    bounds.fail("/count", std::to_string(source.count) + " elements, more than the " +
                              std::to_string(limit) + " that are read");

  const std::uint64_t element = size * static_cast<std::uint64_t>(components);
  if (entry.bufferView >= 0)
    source.base = bounds.run("", entry.bufferView, static_cast<std::int64_t>(entry.byteOffset),
                             element, source.count, true);
  if (entry.sparse.isSparse) {
    const auto& sparse = entry.sparse;
    if (sparse.count < 0 || static_cast<std::uint64_t>(sparse.count) > source.count)
      bounds.fail("/sparse/count", std::to_string(sparse.count) + " of " +
                                       std::to_string(source.count) + " elements");
    const auto changed = static_cast<std::uint64_t>(sparse.count);
    source.sparse_type = sparse.indices.componentType;
    if (!is_unsigned(source.sparse_type))
      bounds.fail("/sparse/indices/componentType", "not an unsigned integer");
    source.sparse_index =
        bounds.run("/sparse/indices", sparse.indices.bufferView,
                   static_cast<std::int64_t>(sparse.indices.byteOffset),
                   static_cast<std::uint64_t>(component_size(source.sparse_type)), changed, false);
    source.sparse_value =
        bounds.run("/sparse/values", sparse.values.bufferView,
                   static_cast<std::int64_t>(sparse.values.byteOffset), element, changed, false);
  }
  return source;
}

template <typename Value, typename Decode>
std::vector<Value> GltfAccessors::gather(const Source& source, Decode decode) const {
  const auto components = static_cast<std::size_t>(source.components);
  const auto size = static_cast<std::size_t>(component_size(source.component_type));
  std::vector<Value> out(source.count * components);
  const auto copy = [&](const Run& run, std::uint64_t from, std::uint64_t to) {
    const std::uint8_t* element = run.first + from * run.stride;
    for (std::size_t c = 0; c < components; ++c)
      out[to * components + c] = decode(element + c * size);
  };
  for (std::uint64_t i = 0; i < source.base.count; ++i) copy(source.base, i, i);
  for (std::uint64_t i = 0; i < source.sparse_index.count; ++i) {
    const std::uint32_t target = load_unsigned(
        source.sparse_type, source.sparse_index.first + i * source.sparse_index.stride);
    if (target >= source.count)
      throw CharacterError(file_ + ": " + source.place + "/sparse/indices: element " +
                           std::to_string(target) + " of " + std::to_string(source.count));
    copy(source.sparse_value, i, target);
  }
  return out;
}

std::vector<float> GltfAccessors::numbers(int accessor, int components,
                                          const std::string& place) const {
  const Source source = open(accessor, components, place);
  if (source.component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
    throw CharacterError(file_ + ": " + source.place + "/componentType: 32-bit integers where " +
                         place + " needs numbers");
  auto out = gather<float>(source, [&](const std::uint8_t* bytes) {
    return load_number(source.component_type, source.normalised, bytes);
  });
  const auto bad =
      std::find_if_not(out.begin(), out.end(), [](float x) { return std::isfinite(x); });
  if (bad != out.end())
    throw CharacterError(file_ + ": " + place + ": element " +
                         std::to_string((bad - out.begin()) / components) + " of " + source.place +
                         (std::isnan(*bad) ? " is not a number" : " is infinite"));
  return out;
}

std::vector<std::uint32_t> GltfAccessors::integers(int accessor, int components,
                                                   const std::string& place) const {
  const Source source = open(accessor, components, place);
  if (!is_unsigned(source.component_type) || source.normalised)
    throw CharacterError(file_ + ": " + source.place +
                         "/componentType: not the unsigned integers that " + place + " needs");
  return gather<std::uint32_t>(source, [&](const std::uint8_t* bytes) {
    return load_unsigned(source.component_type, bytes);
  });
}

double GltfAccessors::quantisation_slack(int accessor, const std::string& place) const {
  count(accessor, place);  // refuses an accessor that does not exist
  switch (model_.accessors[static_cast<std::size_t>(accessor)].componentType) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 0.5 / 255.0;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 0.5 / 65535.0;
    default:
      return 0.0;
  }
}

}  // namespace backbend::skin
