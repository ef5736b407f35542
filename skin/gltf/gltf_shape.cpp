#include "skin/gltf/gltf_shape.h"

#include <array>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>

#include "skin/character/character.h"
#include "skin/character/printable.h"

namespace backbend::skin {
namespace {

using nlohmann::json;

enum class Kind {
  index,  // whole, 0 .. 2^31-1
  size,   // whole, 0 or more
  text,
  truth,
  numbers,     // array of numbers
  indices,     // array of indices
  index_map,   // object of indices
  index_maps,  // array of those
  object,
  objects,  // array of objects
};

struct Rule {
  std::string_view of;  // kind of object: the top-level array's name, or a path below one
  std::string_view member;
  Kind kind;
  bool required = false;
};

constexpr std::array kRules = {
    Rule{"", "scene", Kind::index},
    Rule{"", "scenes", Kind::objects},
    Rule{"", "nodes", Kind::objects},
    Rule{"", "meshes", Kind::objects},
    Rule{"", "skins", Kind::objects},
    Rule{"", "accessors", Kind::objects},
    Rule{"", "bufferViews", Kind::objects},
    Rule{"", "buffers", Kind::objects},
    Rule{"", "materials", Kind::objects},
    Rule{"", "textures", Kind::objects},
    Rule{"scenes", "nodes", Kind::indices},
    Rule{"nodes", "name", Kind::text},
    Rule{"nodes", "children", Kind::indices},
    Rule{"nodes", "mesh", Kind::index},
    Rule{"nodes", "skin", Kind::index},
    Rule{"nodes", "matrix", Kind::numbers},
    Rule{"nodes", "translation", Kind::numbers},
    Rule{"nodes", "rotation", Kind::numbers},
    Rule{"nodes", "scale", Kind::numbers},
    Rule{"nodes", "weights", Kind::numbers},
    Rule{"meshes", "name", Kind::text},
    Rule{"meshes", "weights", Kind::numbers},
    Rule{"meshes", "primitives", Kind::objects, true},
    Rule{"meshes/primitives", "attributes", Kind::index_map, true},
    Rule{"meshes/primitives", "indices", Kind::index},
    Rule{"meshes/primitives", "material", Kind::index},
    Rule{"meshes/primitives", "mode", Kind::index},
    Rule{"meshes/primitives", "targets", Kind::index_maps},
    Rule{"skins", "joints", Kind::indices, true},
    Rule{"skins", "inverseBindMatrices", Kind::index},
    Rule{"skins", "skeleton", Kind::index},
    Rule{"accessors", "bufferView", Kind::index},
    Rule{"accessors", "byteOffset", Kind::size},
    Rule{"accessors", "componentType", Kind::index, true},
    Rule{"accessors", "count", Kind::size, true},
    Rule{"accessors", "type", Kind::text, true},
    Rule{"accessors", "normalized", Kind::truth},
    Rule{"accessors", "sparse", Kind::object},
    Rule{"accessors/sparse", "count", Kind::index, true},
    Rule{"accessors/sparse", "indices", Kind::object, true},
    Rule{"accessors/sparse", "values", Kind::object, true},
    Rule{"accessors/sparse/indices", "bufferView", Kind::index, true},
    Rule{"accessors/sparse/indices", "byteOffset", Kind::index},
    Rule{"accessors/sparse/indices", "componentType", Kind::index, true},
    Rule{"accessors/sparse/values", "bufferView", Kind::index, true},
    Rule{"accessors/sparse/values", "byteOffset", Kind::index},
    Rule{"bufferViews", "buffer", Kind::index, true},
    Rule{"bufferViews", "byteLength", Kind::size, true},
    Rule{"bufferViews", "byteOffset", Kind::size},
    Rule{"bufferViews", "byteStride", Kind::index},
    Rule{"materials", "name", Kind::text},
};

bool is_index(const json& value) {
  return value.is_number_unsigned() &&
         value.get<std::uint64_t>() <= std::numeric_limits<std::int32_t>::max();
}

// The objects of a glTF document in all: nodes, accessors, primitives and their like. A film
// character with all its clips has some ten thousand; each costs about a kilobyte to read.
constexpr std::size_t kMostObjects = std::size_t{1} << 17;

class ShapeCheck {
 public:
  explicit ShapeCheck(const std::string& file) : file_(file) {}

  /// Checks the members of one object against the rules of its kind, and what lies below.
  void object(const json& value, std::string_view kind, const std::string& path) {
    if (++objects_ > kMostObjects)
      fail(path, "more than " + std::to_string(kMostObjects) + " objects in the document");
    for (const Rule& rule : kRules) {
      if (rule.of != kind) continue;
      const std::string place = path + "/" + std::string(rule.member);
      const auto found = value.find(rule.member);
      if (found == value.end()) {
        if (rule.required) fail(place, "missing");
        continue;
      }
      member(*found, rule, place);
    }
  }

 private:
  [[noreturn]] void fail(const std::string& place, const std::string& cause) const {
    throw CharacterError(file_ + ": " + place + ": " + cause);
  }
  /// `value` as a short text, for "... is not an index".
  static std::string shown(const json& value) {
    return value.is_structured() ? value.type_name() : printable(value.dump());
  }

  void member(const json& value, const Rule& rule, const std::string& place) {
    switch (rule.kind) {
      case Kind::index:
        return index(value, place);
      case Kind::size:
        if (!value.is_number_unsigned()) fail(place, shown(value) + " is not a size");
        return;
      case Kind::text:
        if (!value.is_string()) fail(place, shown(value) + " is not text");
        return;
      case Kind::truth:
        if (!value.is_boolean()) fail(place, shown(value) + " is neither true nor false");
        return;
      case Kind::numbers:
        return each(value, place, [&](const json& entry, const std::string& at) {
          if (!entry.is_number()) fail(at, shown(entry) + " is not a number");
        });
      case Kind::indices:
        return each(value, place,
                    [&](const json& entry, const std::string& at) { index(entry, at); });
      case Kind::index_map:
        return index_map(value, place);
      case Kind::index_maps:
        return each(value, place,
                    [&](const json& entry, const std::string& at) { index_map(entry, at); });
      case Kind::object:
        return nested(value, rule, place);
      case Kind::objects:
        return each(value, place,
                    [&](const json& entry, const std::string& at) { nested(entry, rule, at); });
    }
  }

  void index(const json& value, const std::string& place) const {
    if (!is_index(value)) fail(place, shown(value) + " is not an index");
  }

  void index_map(const json& value, const std::string& place) const {
    if (!value.is_object()) fail(place, shown(value) + " is not an object");
    for (const auto& [key, entry] : value.items()) index(entry, place + "/" + printable(key));
  }

  template <typename Check>
  void each(const json& value, const std::string& place, Check check) const {
    if (!value.is_array()) fail(place, shown(value) + " is not an array");
    for (std::size_t k = 0; k < value.size(); ++k) check(value[k], place + "/" + std::to_string(k));
  }

  void nested(const json& value, const Rule& rule, const std::string& place) {
    if (!value.is_object()) fail(place, shown(value) + " is not an object");
    const std::string kind = rule.of.empty()
                                 ? std::string(rule.member)
                                 : std::string(rule.of) + "/" + std::string(rule.member);
    object(value, kind, place);
  }

  const std::string& file_;
  std::size_t objects_ = 0;
};

}  // namespace

void check_gltf_shape(const nlohmann::json& root, const std::string& file) {
  ShapeCheck(file).object(root, "", "");
}

}  // namespace backbend::skin
