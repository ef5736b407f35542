#include "skin/gltf/gltf_weights.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "skin/character/printable.h"
#include "skin/gltf/asset_folder.h"
#include "skin/gltf/glb_container.h"
#include "skin/gltf/gltf_accessor.h"

namespace backbend::skin {
namespace {

using Bytes = std::vector<std::uint8_t>;
using nlohmann::ordered_json;
using Index = std::size_t;

constexpr Index kSetJoints = 4;  // of one JOINTS_n

constexpr int kByte = 5121, kShort = 5123, kFloat = 5126;  // glTF 2.0, componentType

Index size_of(int type) { return type == kByte ? 1 : type == kShort ? 2 : 4; }

Index components_of(const std::string& type) {
  if (type == "SCALAR") return 1;
  if (type == "VEC2") return 2;
  if (type == "VEC3") return 3;
  if (type == "MAT3") return 9;
  return type == "MAT4" ? 16 : 4;
}

std::uint32_t read_u32(const Bytes& bytes, Index at) {
  return std::uint32_t{bytes[at]} | std::uint32_t{bytes[at + 1]} << 8 |
         std::uint32_t{bytes[at + 2]} << 16 | std::uint32_t{bytes[at + 3]} << 24;
}

void append_u32(Bytes& bytes, Index value) {
  for (int shift = 0; shift < 32; shift += 8)
    bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}

/// Weights in whole steps that sum to `whole`: rounded down, and the steps that are left go to
/// those that lost most (the first of equals).
std::array<std::uint32_t, kMaxInfluences> in_steps(const Influences& influences,
                                                   std::uint32_t whole) {
  std::array<std::uint32_t, kMaxInfluences> out{};
  std::array<std::pair<double, Index>, kMaxInfluences> lost{};
  double sum = 0.0;
  for (const float w : influences.weight) sum += w;
  std::uint32_t used = 0;
  for (Index k = 0; k < kMaxInfluences; ++k) {
    const double exact = sum > 0.0 ? influences.weight[k] / sum * whole : 0.0;
    out[k] = static_cast<std::uint32_t>(exact);
    used += out[k];
    lost[k] = {out[k] - exact, k};
  }
  std::sort(lost.begin(), lost.end());
  for (Index k = 0; used < whole && k < kMaxInfluences; ++k, ++used) ++out[lost[k].second];
  return out;
}

class WeightWriter {
 public:
  WeightWriter(const GltfDocument& document, const WeightedGltf& from)
      : document_(document), from_(from), accessors_(*document.model, document.file) {
    file_ = read_regular_file(document.file);
    const GltfContainer container = open_gltf_container(document.file, file_);
    is_glb_ = file_.size() >= 4 && read_u32(file_, 0) == kGlbMagic;
    try {
      root_ = ordered_json::parse(container.json_text);
      refuse_compressed();
      load_buffers(container);
    } catch (const ordered_json::exception&) {
      fail("the file changed while it was read");
    }
    before_ = buffers_;
  }

  Bytes write(std::span<const Influences> influences, const std::vector<bool>& changed) {
    const ordered_json accessors = root_.value("accessors", ordered_json::array());
    const auto each_changed = [&](const auto& act) {
      for (const WeightSource& source : from_.sources)
        for (std::uint32_t v = 0; v < source.vertex_count; ++v)
          if (changed[source.first_vertex + v]) act(source, v, influences[source.first_vertex + v]);
    };
    each_changed([&](const WeightSource& source, std::uint32_t v, const Influences& vertex) {
      for (const std::uint32_t number : numbers_of(source, v, vertex))
        for (const int joints : source.joints)
          largest_[joints] = std::max(largest_[joints], number);
    });
    each_changed([&](const WeightSource& source, std::uint32_t v, const Influences& vertex) {
      store(source, v, vertex);
    });
    compare(accessors);
    return is_glb_ && !rebuilt_ ? patched() : packed();
  }

 private:
  [[noreturn]] void fail(const std::string& cause) const {
    throw CharacterError(document_.file + ": " + cause);
  }

  void refuse_compressed() const {
    for (const auto& name : root_.value("extensionsUsed", ordered_json::array()))
      if (name == kDracoExtension || name == kMeshoptExtension)
        fail("the mesh is compressed (" + printable(name.get<std::string>()) +
             "), so its weights cannot be replaced; export without compression");
  }

  void load_buffers(const GltfContainer& container) {
    const auto& model = *document_.model;
    Index number = 0;
    for (const auto& buffer : root_.value("buffers", ordered_json::array())) {
      if (number >= model.buffers.size()) fail("the file changed while it was read");
      buffers_.push_back(model.buffers[number].data);
      const auto uri = buffer.find("uri");
      const bool in_file = number == 0 && is_glb_ && uri == buffer.end() && container.binary;
      if (in_file && !std::equal(buffers_[0].begin(), buffers_[0].end(), container.binary->begin(),
                                 container.binary->begin() +
                                     static_cast<std::ptrdiff_t>(
                                         std::min(buffers_[0].size(), container.binary->size()))))
        fail("the file changed while it was read");
      if (!in_file) rebuilt_ = true;
      ++number;
    }
    if (!is_glb_) rebuilt_ = true;
  }

  /// Where the elements of an accessor are.
  struct Place {
    Index buffer = 0, offset = 0, stride = 0;
    int type = 0;
  };

  ordered_json& accessor(int number) { return root_["accessors"][static_cast<Index>(number)]; }

  Place place_of(const ordered_json& entry) const {
    const ordered_json& view = root_.at("bufferViews").at(entry.at("bufferView").get<Index>());
    Place out;
    out.type = entry.at("componentType").get<int>();
    out.buffer = view.at("buffer").get<Index>();
    out.offset = view.value("byteOffset", Index{0}) + entry.value("byteOffset", Index{0});
    const Index element = size_of(out.type) * components_of(entry.at("type").get<std::string>());
    out.stride = view.value("byteStride", element);
    return out;
  }

  /// Gives an accessor bytes of its own at the end of the first buffer, in `type`.
  void move_out(int number, int type) {
    ordered_json& entry = accessor(number);
    const std::string place = "/accessors/" + std::to_string(number);
    const Index count = accessors_.count(number, place);
    const int old_type = entry.at("componentType").get<int>();
    Bytes data(count * kSetJoints * size_of(type));
    if (old_type == kFloat || entry.value("normalized", false)) {
      const std::vector<float> values = accessors_.numbers(number, 4, place);
      for (Index k = 0; k < values.size(); ++k) {
        if (type == kFloat) std::memcpy(data.data() + 4 * k, &values[k], sizeof(float));
        if (type == kByte) put(data, k, type, std::lround(values[k] * 255.0f));
        if (type == kShort) put(data, 2 * k, type, std::lround(values[k] * 65535.0f));
      }
    } else {
      const std::vector<std::uint32_t> values = accessors_.integers(number, 4, place);
      for (Index k = 0; k < values.size(); ++k) put(data, size_of(type) * k, type, values[k]);
    }
    if (buffers_.empty()) fail(place + ": a file without a buffer");
    Bytes& end = buffers_.front();
    end.resize((end.size() + 3) / 4 * 4);
    ordered_json& views = root_["bufferViews"];
    entry["bufferView"] = views.size();
    entry.erase("byteOffset");
    entry.erase("sparse");
    entry["componentType"] = type;
    views.push_back({{"buffer", 0},
                     {"byteOffset", end.size()},
                     {"byteLength", data.size()},
                     {"byteStride", kSetJoints * size_of(type)},
                     {"target", 34962}});
    end.insert(end.end(), data.begin(), data.end());
    rebuilt_ = true;
    ours_.insert(number);
  }

  static void put(Bytes& bytes, Index at, int type, long value) {
    bytes[at] = static_cast<std::uint8_t>(value);
    if (type == kShort) bytes[at + 1] = static_cast<std::uint8_t>(value >> 8);
  }

  /// Where an accessor's elements can be written, made ready once.
  const Place& ready(int number) {
    if (const auto known = place_.find(number); known != place_.end()) return known->second;
    ordered_json& entry = accessor(number);
    const int type = entry.at("componentType").get<int>();
    if (type != kByte && type != kShort && type != kFloat)
      fail("/accessors/" + std::to_string(number) + ": weights and joints in component type " +
           std::to_string(type));
    if (type == kByte && largest_[number] > 255) {
      move_out(number, kShort);
    } else if (entry.contains("sparse") || !entry.contains("bufferView")) {
      move_out(number, type);
    }
    for (const char* bound : {"min", "max"})
      if (entry.contains(bound)) {  // true no more, and not asked for here
        entry.erase(bound);
        rebuilt_ = true;
      }
    ours_.insert(number);
    return place_[number] = place_of(entry);
  }

  /// The numbers that the file gives a vertex's joints.
  std::array<std::uint32_t, kMaxInfluences> numbers_of(const WeightSource& source,
                                                       std::uint32_t element,
                                                       const Influences& influences) const {
    const auto vertex = [&] { return "vertex " + std::to_string(source.first_vertex + element); };
    std::array<std::uint32_t, kMaxInfluences> number{};
    Index used = 0;
    for (Index k = 0; k < kMaxInfluences && influences.weight[k] > 0.0f; ++k, ++used) {
      const auto found = std::find(source.joint.begin(), source.joint.end(), influences.joint[k]);
      if (found == source.joint.end()) fail(vertex() + ": its skin has no such joint");
      number[k] = static_cast<std::uint32_t>(found - source.joint.begin());
    }
    if (used > kSetJoints * source.joints.size())
      fail(vertex() + ": " + plural(used, "joint") + " in " + plural(source.joints.size(), "set") +
           " of four");
    return number;
  }

  void store(const WeightSource& source, std::uint32_t element, const Influences& influences) {
    const auto number = numbers_of(source, element, influences);
    for (Index set = 0; set < source.joints.size(); ++set) {
      const Place joints = ready(source.joints[set]);
      const Place weights = ready(source.weights[set]);
      // Instances of one mesh share their stored vertices: what the first has counts.
      if (!written_.insert({source.joints[set], element}).second) continue;
      const auto steps = in_steps(influences, weights.type == kByte ? 255 : 65535);
      for (Index k = 0; k < kSetJoints; ++k) {
        const Index from = kSetJoints * set + k;
        const std::uint32_t joint = from < kMaxInfluences ? number[from] : 0;
        Bytes& j = buffers_[joints.buffer];
        put(j, joints.offset + element * joints.stride + k * size_of(joints.type), joints.type,
            joint);
        Bytes& w = buffers_[weights.buffer];
        const Index at = weights.offset + element * weights.stride + k * size_of(weights.type);
        const float share = from < kMaxInfluences ? influences.weight[from] : 0.0f;
        if (weights.type == kFloat)
          std::memcpy(w.data() + at, &share, sizeof share);
        else
          put(w, at, weights.type, from < kMaxInfluences ? steps[from] : 0);
      }
    }
  }

  /// Every accessor that is none of the weights' must have the bytes that it had.
  void compare(const ordered_json& old) const {
    for (Index number = 0; number < old.size(); ++number) {
      if (ours_.count(static_cast<int>(number)) > 0) continue;
      const ordered_json& entry = old[number];
      const auto same = [&](Index view_number, Index offset, Index element, Index count,
                            bool strided) {
        const ordered_json& view = root_.at("bufferViews").at(view_number);
        const Index buffer = view.at("buffer").get<Index>();
        const Index first = view.value("byteOffset", Index{0}) + offset;
        const Index stride = strided ? view.value("byteStride", element) : element;
        for (Index i = 0; i < count; ++i) {
          const auto at = static_cast<std::ptrdiff_t>(first + i * stride);
          if (first + i * stride + element > before_[buffer].size()) break;
          if (!std::equal(before_[buffer].begin() + at,
                          before_[buffer].begin() + at + static_cast<std::ptrdiff_t>(element),
                          buffers_[buffer].begin() + at))
            fail("/accessors/" + std::to_string(number) +
                 ": shares its bytes with the weights; export the file again");
        }
      };
      const Index element = size_of(entry.at("componentType").get<int>()) *
                            components_of(entry.at("type").get<std::string>());
      if (entry.contains("bufferView"))
        same(entry["bufferView"].get<Index>(), entry.value("byteOffset", Index{0}), element,
             entry.at("count").get<Index>(), true);
      if (!entry.contains("sparse")) continue;
      const ordered_json& sparse = entry["sparse"];
      const Index count = sparse.at("count").get<Index>();
      same(sparse.at("indices").at("bufferView").get<Index>(),
           sparse["indices"].value("byteOffset", Index{0}),
           size_of(sparse["indices"].at("componentType").get<int>()), count, false);
      same(sparse.at("values").at("bufferView").get<Index>(),
           sparse["values"].value("byteOffset", Index{0}), element, count, false);
    }
  }

  /// The file's own bytes with the binary chunk's replaced.
  Bytes patched() const {
    Bytes out = file_;
    for (Index at = 12; at + 8 <= out.size();) {
      const Index size = read_u32(out, at);
      if (read_u32(out, at + 4) == kChunkBin) {
        std::copy(buffers_.front().begin(), buffers_.front().end(),
                  out.begin() + static_cast<std::ptrdiff_t>(at + 8));
        break;
      }
      at += 8 + size;
    }
    return out;
  }

  /// One GLB of JSON, all buffers and all pictures.
  Bytes packed() {
    Bytes binary;
    std::vector<Index> start;
    for (const Bytes& buffer : buffers_) {
      start.push_back(binary.size());
      binary.insert(binary.end(), buffer.begin(), buffer.end());
      binary.resize((binary.size() + 3) / 4 * 4);
    }
    if (root_.contains("bufferViews"))
      for (ordered_json& view : root_["bufferViews"]) {
        const Index buffer = view.at("buffer").get<Index>();
        const Index offset = start.at(buffer) + view.value("byteOffset", Index{0});
        view["buffer"] = 0;
        if (offset > 0 || view.contains("byteOffset")) view["byteOffset"] = offset;
      }
    embed_images(binary);
    if (!binary.empty()) root_["buffers"] = ordered_json::array({{{"byteLength", binary.size()}}});
    std::string text = root_.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
    text.resize((text.size() + 3) / 4 * 4, ' ');
    binary.resize((binary.size() + 3) / 4 * 4);
    if (text.size() + binary.size() + 28 >= kMaxFileBytes) fail("more than 2 GiB as one GLB");
    Bytes out;
    append_u32(out, kGlbMagic);
    append_u32(out, 2);
    append_u32(out, 12 + 8 + text.size() + (binary.empty() ? 0 : 8 + binary.size()));
    append_u32(out, text.size());
    append_u32(out, kChunkJson);
    out.insert(out.end(), text.begin(), text.end());
    if (binary.empty()) return out;
    append_u32(out, binary.size());
    append_u32(out, kChunkBin);
    out.insert(out.end(), binary.begin(), binary.end());
    return out;
  }

  /// Pictures in files beside the .gltf go into the GLB: its folder may be another.
  void embed_images(Bytes& binary) {
    if (!root_.contains("images")) return;
    Index number = 0;
    for (ordered_json& image : root_["images"]) {
      const Index i = number++;
      const auto uri = image.find("uri");
      if (uri == image.end() || i >= document_.images.size()) continue;
      const Bytes& bytes = document_.images[i].bytes;
      if (uri->get<std::string>().rfind("data:", 0) == 0 || bytes.size() < 4) continue;
      static const std::uint8_t kPng[] = {0x89, 'P', 'N', 'G'}, kJpeg[] = {0xFF, 0xD8, 0xFF};
      const bool png = std::equal(std::begin(kPng), std::end(kPng), bytes.begin());
      const bool jpeg = std::equal(std::begin(kJpeg), std::end(kJpeg), bytes.begin());
      if (!png && !jpeg) continue;  // stays a reference, as other formats must
      image.erase("uri");
      image["mimeType"] = png ? "image/png" : "image/jpeg";
      image["bufferView"] = root_["bufferViews"].size();
      root_["bufferViews"].push_back(
          {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", bytes.size()}});
      binary.insert(binary.end(), bytes.begin(), bytes.end());
      binary.resize((binary.size() + 3) / 4 * 4);
    }
  }

  const GltfDocument& document_;
  const WeightedGltf& from_;
  GltfAccessors accessors_;
  Bytes file_;
  ordered_json root_;
  bool is_glb_ = false;
  bool rebuilt_ = false;  // the JSON or the chunks are no longer the file's
  std::vector<Bytes> buffers_, before_;
  std::map<int, Place> place_;
  std::map<int, std::uint32_t> largest_;  // joint number to be written, by accessor
  std::set<int> ours_;
  std::set<std::pair<int, std::uint32_t>> written_;
};

}  // namespace

Bytes encode_with_weights(const GltfDocument& document, const WeightedGltf& from,
                          std::span<const Influences> influences,
                          const std::vector<bool>& changed) {
  return WeightWriter(document, from).write(influences, changed);
}

}  // namespace backbend::skin
