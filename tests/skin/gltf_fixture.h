#pragma once
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/temporary_folder.h"

namespace backbend::skin {

void write_file(const std::filesystem::path& file, const std::vector<std::uint8_t>& bytes);

constexpr int kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123,
              kUnsignedInt = 5125, kFloat = 5126;

/// A glTF file under construction: the JSON to edit, and one buffer.
class GltfFixture {
 public:
  nlohmann::json root;
  std::vector<std::uint8_t> buffer;

  /// Appends the values as a buffer view of their own; returns the view's number.
  template <typename T>
  int add_view(const std::vector<T>& values) {
    while (buffer.size() % 4 != 0) buffer.push_back(0);
    const std::size_t offset = buffer.size();
    buffer.resize(offset + values.size() * sizeof(T));
    std::memcpy(buffer.data() + offset, values.data(), values.size() * sizeof(T));
    root["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", values.size() * sizeof(T)}});
    return static_cast<int>(root["bufferViews"].size()) - 1;
  }
  /// Appends the values and an accessor over them; returns the accessor's number.
  template <typename T>
  int add(const std::vector<T>& values, int component_type, const std::string& type,
          std::size_t components, bool normalised = false) {
    const int view = add_view(values);
    root["accessors"].push_back({{"bufferView", view},
                                 {"componentType", component_type},
                                 {"type", type},
                                 {"count", values.size() / components}});
    if (normalised) root["accessors"].back()["normalized"] = true;
    return static_cast<int>(root["accessors"].size()) - 1;
  }

  nlohmann::json& attributes(int mesh = 0, int primitive = 0);

  std::vector<std::uint8_t> glb() const;
  std::filesystem::path write_glb(const TemporaryFolder& folder,
                                  const std::string& name = "test.glb") const;
  /// A .gltf beside `NAME.bin`, referred to by `uri` (the file's name by default).
  std::filesystem::path write_gltf(const TemporaryFolder& folder,
                                   const std::string& uri = "") const;
};

/// A strip of ten vertices along +Y, x = -0.5 and 0.5 at y = 0, 0.5, 1, 1.5, 2, on two joints:
/// `hip` at the origin and its child `chest` at y = 1. Weights go over from the one to the other:
/// 1, 0.75, 0.5, 0.25, 0 for the hip. Nodes: 0 hip, 1 chest, 2 the mesh. Facing +Z.
GltfFixture strip();

}  // namespace backbend::skin
