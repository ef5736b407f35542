// draco_pack < GLB > GLB: compresses the meshes of a .glb with Draco, without rounding and with the
// vertices in their order. A program of its own: Debian 12's libdraco carries another tinygltf,
// which must not meet ours.
#include <draco/compression/encode.h>

#include <cstdio>
#include <cstring>
#include <iostream>
#include <iterator>
#include <map>
#include <stdexcept>
#include <string>

#include "skin/gltf/glb_container.h"
#include "skin/gltf/glb_writer_document.h"

namespace backbend {
namespace {

using skin::Json;
using Index = std::size_t;

const std::map<std::string, int> kComponents = {
    {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}};
const std::map<int, std::pair<draco::DataType, Index>> kTypes = {{5121, {draco::DT_UINT8, 1}},
                                                                 {5123, {draco::DT_UINT16, 2}},
                                                                 {5125, {draco::DT_UINT32, 4}},
                                                                 {5126, {draco::DT_FLOAT32, 4}}};

/// The tightly packed elements of an accessor, and the size of one.
struct Elements {
  const std::uint8_t* data;
  Index count, size;
};

Elements elements_of(const Json& root, const std::vector<std::uint8_t>& binary, Index accessor) {
  const Json& a = root.at("accessors").at(accessor);
  const Json& view = root.at("bufferViews").at(a.at("bufferView").get<Index>());
  const Index begin = view.value("byteOffset", Index{0}) + a.value("byteOffset", Index{0});
  const auto components = static_cast<Index>(kComponents.at(a.at("type")));
  return {binary.data() + begin, a.at("count"),
          components * kTypes.at(a.at("componentType").get<int>()).second};
}

std::uint32_t corner_at(const Elements& from, Index i) {
  std::uint32_t out = 0;
  std::memcpy(&out, from.data + i * from.size, from.size);  // little-endian
  return out;
}

std::vector<std::uint8_t> with_draco(const std::vector<std::uint8_t>& glb) {
  const skin::GltfContainer container = skin::open_gltf_container("plain.glb", glb);
  const std::vector<std::uint8_t>& binary = *container.binary;
  skin::GlbDocument out;
  out.json = Json::parse(container.json_text);
  out.add_view(binary.data(), binary.size(), 0);
  const Json plain = out.json;
  for (Json& mesh : out.json["meshes"])
    for (Json& primitive : mesh["primitives"]) {
      draco::Mesh to;
      Json attributes;
      for (const auto& [name, accessor] : primitive["attributes"].items()) {
        const Elements from = elements_of(plain, binary, accessor);
        const Json& a = plain["accessors"][accessor.get<Index>()];
        to.set_num_points(static_cast<std::uint32_t>(from.count));
        draco::GeometryAttribute kind;
        kind.Init(name == "POSITION" ? draco::GeometryAttribute::POSITION
                                     : draco::GeometryAttribute::GENERIC,
                  nullptr, static_cast<std::int8_t>(kComponents.at(a["type"])),
                  kTypes.at(a["componentType"].get<int>()).first, a.value("normalized", false),
                  static_cast<std::int64_t>(from.size), 0);
        const int id = to.AddAttribute(kind, true, static_cast<std::uint32_t>(from.count));
        for (Index i = 0; i < from.count; ++i)
          to.attribute(id)->SetAttributeValue(
              draco::AttributeValueIndex(static_cast<std::uint32_t>(i)), from.data + i * from.size);
        attributes[name] = to.attribute(id)->unique_id();
        out.json["accessors"][accessor.get<Index>()].erase("bufferView");
      }
      const Elements corners = elements_of(plain, binary, primitive["indices"]);
      for (Index f = 0; f < corners.count / 3; ++f) {
        draco::Mesh::Face face;
        for (Index k = 0; k < 3; ++k) face[k] = draco::PointIndex(corner_at(corners, 3 * f + k));
        to.AddFace(face);
      }
      out.json["accessors"][primitive["indices"].get<Index>()].erase("bufferView");
      draco::Encoder encoder;
      encoder.SetEncodingMethod(draco::MESH_SEQUENTIAL_ENCODING);
      draco::EncoderBuffer compressed;
      const draco::Status status = encoder.EncodeMeshToBuffer(to, &compressed);
      if (!status.ok()) throw std::runtime_error(status.error_msg_string());
      primitive["extensions"][skin::kDracoExtension] = {
          {"bufferView", out.add_view(compressed.data(), compressed.size(), 0)},
          {"attributes", attributes}};
    }
  out.json["extensionsUsed"] = out.json["extensionsRequired"] = {skin::kDracoExtension};
  return out.finish();
}

}  // namespace
}  // namespace backbend

int main() {
  const std::string in{std::istreambuf_iterator<char>(std::cin), {}};
  const std::vector<std::uint8_t> out = backbend::with_draco({in.begin(), in.end()});
  return std::fwrite(out.data(), 1, out.size(), stdout) == out.size() ? 0 : 1;
}
