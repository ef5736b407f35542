#include "cli/import/draco_glb.h"

#include <draco/compression/decode.h>

#include <cstring>
#include <map>
#include <memory>
#include <string>

#include "cli/import/compressed_glb.h"
#include "skin/gltf/glb_container.h"

namespace backbend::import {
namespace {

using skin::CharacterError;
using skin::Json;
using Bytes = std::vector<std::uint8_t>;

std::size_t components_of(const Json& accessor) {
  static const std::map<std::string, std::size_t> known = {
      {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}};
  const auto found = known.find(accessor.at("type").get<std::string>());
  if (found == known.end()) throw CharacterError("an accessor of a type that vertices do not have");
  return found->second;
}

/// Each vertex begins on four bytes, as glTF has it.
std::size_t stride_of(std::size_t size) { return (size + 3) / 4 * 4; }

/// One attribute of all points, in components of T.
template <typename T>
Bytes values_of(const draco::Mesh& mesh, const draco::PointAttribute& attribute,
                std::size_t components) {
  const std::size_t stride = stride_of(components * sizeof(T));
  Bytes out(mesh.num_points() * stride);
  for (std::uint32_t p = 0; p < mesh.num_points(); ++p) {
    T value[4] = {};
    if (!attribute.ConvertValue<T>(attribute.mapped_index(draco::PointIndex(p)),
                                   static_cast<std::int8_t>(components), value))
      throw CharacterError("Draco has a value that does not fit its accessor");
    std::memcpy(out.data() + p * stride, value, components * sizeof(T));
  }
  return out;
}

class Decompressor {
 public:
  explicit Decompressor(const Bytes& glb) : file_(glb), document_(file_.document) {}

  Bytes run() {
    for (Json& mesh : document_.json.at("meshes"))
      for (Json& primitive : mesh.at("primitives"))
        if (primitive.contains("extensions") &&
            primitive["extensions"].contains(skin::kDracoExtension))
          decompress(primitive);
    return file_.finish(skin::kDracoExtension);
  }

 private:
  void decompress(Json& primitive) {
    const Json compressed = primitive["extensions"][skin::kDracoExtension];
    const std::unique_ptr<draco::Mesh> mesh = decode(compressed.at("bufferView"));
    for (const auto& [name, id] : compressed.at("attributes").items()) {
      const auto accessor = primitive.at("attributes").at(name).get<std::size_t>();
      const draco::PointAttribute* attribute =
          mesh->GetAttributeByUniqueId(id.get<std::uint32_t>());
      if (attribute == nullptr) throw CharacterError("Draco has no data for " + name);
      take_attribute(*mesh, *attribute, accessor);
    }
    if (primitive.contains("indices")) take_triangles(*mesh, primitive["indices"]);
    primitive["extensions"].erase(skin::kDracoExtension);
  }

  std::unique_ptr<draco::Mesh> decode(std::size_t view) {
    const auto [data, size] = file_.run_of(document_.json.at("bufferViews").at(view));
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(data), size);
    auto mesh = draco::Decoder().DecodeMeshFromBuffer(&buffer);
    if (!mesh.ok()) throw CharacterError(mesh.status().error_msg_string());
    return std::move(mesh).value();
  }

  void take_attribute(const draco::Mesh& mesh, const draco::PointAttribute& attribute,
                      std::size_t index) {
    Json& accessor = document_.json.at("accessors").at(index);
    expect_count(accessor, mesh.num_points());
    const std::size_t components = components_of(accessor);
    if (attribute.num_components() != static_cast<int>(components))
      throw CharacterError("Draco has other components than accessor " + std::to_string(index));
    switch (accessor.at("componentType").get<int>()) {
      case 5120:
        return store(index, values_of<std::int8_t>(mesh, attribute, components), components);
      case skin::kGlUnsignedByte:
        return store(index, values_of<std::uint8_t>(mesh, attribute, components), components);
      case 5122:
        return store(index, values_of<std::int16_t>(mesh, attribute, components), 2 * components);
      case skin::kGlUnsignedShort:
        return store(index, values_of<std::uint16_t>(mesh, attribute, components), 2 * components);
      case skin::kGlUnsignedInt:
        return store(index, values_of<std::uint32_t>(mesh, attribute, components), 4 * components);
      case skin::kGlFloat:
        return store(index, values_of<float>(mesh, attribute, components), 4 * components);
      default:
        throw CharacterError("accessor " + std::to_string(index) + ": unknown component type");
    }
  }

  void take_triangles(const draco::Mesh& mesh, std::size_t index) {
    std::vector<std::uint32_t> corners;
    for (std::uint32_t f = 0; f < mesh.num_faces(); ++f)
      for (const draco::PointIndex& corner : mesh.face(draco::FaceIndex(f)))
        corners.push_back(corner.value());
    Json& accessor = document_.json.at("accessors").at(index);
    expect_count(accessor, corners.size());
    accessor["componentType"] = skin::kGlUnsignedInt;
    accessor["bufferView"] = document_.add_view(
        corners.data(), corners.size() * sizeof(std::uint32_t), skin::kIndexTarget);
    accessor.erase("byteOffset");
  }

  /// `size`: bytes of a vertex, without what fills it up.
  void store(std::size_t index, const Bytes& values, std::size_t size) {
    const int view = document_.add_view(values.data(), values.size(), skin::kVertexTarget);
    if (stride_of(size) != size)
      document_.json["bufferViews"][static_cast<std::size_t>(view)]["byteStride"] = stride_of(size);
    Json& accessor = document_.json["accessors"][index];
    accessor["bufferView"] = view;
    accessor.erase("byteOffset");
  }

  static void expect_count(const Json& accessor, std::size_t count) {
    if (accessor.at("count") != count)
      throw CharacterError("Draco has " + std::to_string(count) + " elements where the file says " +
                           accessor.at("count").dump());
  }

  CompressedGlb file_;
  skin::GlbDocument& document_;
};

}  // namespace

std::vector<std::uint8_t> decompress_draco(const std::vector<std::uint8_t>& glb) {
  return Decompressor(glb).run();
}

}  // namespace backbend::import
