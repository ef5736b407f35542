#pragma once
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>
#include <vector>

#include "skin/character/character.h"

namespace backbend::skin {

using Json = nlohmann::ordered_json;

/// A glTF document under construction: its JSON, and the one buffer that its accessors read.
class GlbDocument {
 public:
  GlbDocument();

  /// Values of one accessor, tightly packed. `type` is SCALAR, VEC2, ... `target` 0: none.
  template <typename T>
  int add_accessor(std::span<const T> values, int component_type, std::string_view type,
                   int target = 0, bool normalized = false) {
    const int view = add_view(values.data(), values.size_bytes(), target);
    return describe(view, values.size(), component_type, type, normalized);
  }
  /// Gives an accessor the lowest and highest value of each component.
  template <typename T>
  void add_bounds(int accessor, std::span<const T> values, int components) {
    Json low = Json::array(), high = Json::array();
    for (int c = 0; c < components; ++c) {
      float lowest = component(values[0], c), highest = lowest;
      for (const T& v : values) {
        lowest = std::min(lowest, component(v, c));
        highest = std::max(highest, component(v, c));
      }
      low.push_back(lowest);
      high.push_back(highest);
    }
    json["accessors"][static_cast<std::size_t>(accessor)]["min"] = low;
    json["accessors"][static_cast<std::size_t>(accessor)]["max"] = high;
  }
  int add_view(const void* data, std::size_t size, int target);
  /// Appends to a top-level array, which comes into being with its first entry; the new index.
  int append(const char* array, Json entry);
  /// The file's bytes. Throws CharacterError beyond 4 GB.
  std::vector<std::uint8_t> finish();

  Json json;

 private:
  template <typename T>
  static float component(const T& v, int c) {
    if constexpr (std::is_arithmetic_v<T>) {
      return static_cast<float>(v);
    } else {
      return v[c];
    }
  }
  int describe(int view, std::size_t count, int component_type, std::string_view type,
               bool normalized);

  std::vector<std::uint8_t> binary_;
};

constexpr int kGlUnsignedByte = 5121, kGlUnsignedShort = 5123, kGlUnsignedInt = 5125,
              kGlFloat = 5126;
constexpr int kVertexTarget = 34962, kIndexTarget = 34963;

/// Writes a character's images, textures and materials. With `vertex_color`, base colours are
/// white.
void add_materials(GlbDocument& document, const Character& character, bool vertex_color);

}  // namespace backbend::skin
