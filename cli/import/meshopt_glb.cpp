#include "cli/import/meshopt_glb.h"

#include <meshoptimizer.h>

#include <string>

#include "cli/import/compressed_glb.h"
#include "skin/gltf/asset_folder.h"
#include "skin/gltf/glb_container.h"

namespace backbend::import {
namespace {

using skin::CharacterError;
using skin::Json;
using Bytes = std::vector<std::uint8_t>;

/// What one buffer view says of its data.
struct Packed {
  std::size_t count = 0, stride = 0;
  std::string mode, filter;
};

[[noreturn]] void refuse(const std::string& why) { throw CharacterError(why); }

/// Throws where the extension allows no such sizes: the library only asserts them.
Packed packed_of(const Json& extension) {
  const Packed out{extension.at("count").get<std::size_t>(),
                   extension.at("byteStride").get<std::size_t>(),
                   extension.at("mode").get<std::string>(), extension.value("filter", "NONE")};
  const bool attributes = out.mode == "ATTRIBUTES";
  if (!attributes && out.mode != "TRIANGLES" && out.mode != "INDICES")
    refuse("unknown mode of compression " + out.mode);
  const bool stride = attributes ? out.stride % 4 == 0 && out.stride > 0 && out.stride <= 256
                                 : out.stride == 2 || out.stride == 4;
  if (!stride || out.count > skin::kMaxFileBytes / out.stride ||
      (out.mode == "TRIANGLES" && out.count % 3 != 0))
    refuse(std::to_string(out.count) + " elements of " + std::to_string(out.stride) +
           " bytes in mode " + out.mode);
  const bool filter =
      out.filter == "NONE" ||
      (attributes &&
       ((out.filter == "OCTAHEDRAL" && (out.stride == 4 || out.stride == 8)) ||
        (out.filter == "QUATERNION" && out.stride == 8) || out.filter == "EXPONENTIAL"));
  if (!filter)
    refuse("filter " + out.filter + " on elements of " + std::to_string(out.stride) + " bytes");
  return out;
}

Bytes decode(const Packed& packed, const CompressedGlb::Run& from) {
  Bytes out(packed.count * packed.stride);
  const int error =
      packed.mode == "ATTRIBUTES" ? meshopt_decodeVertexBuffer(out.data(), packed.count,
                                                               packed.stride, from.data, from.size)
      : packed.mode == "TRIANGLES"
          ? meshopt_decodeIndexBuffer(out.data(), packed.count, packed.stride, from.data, from.size)
          : meshopt_decodeIndexSequence(out.data(), packed.count, packed.stride, from.data,
                                        from.size);
  if (error != 0) refuse("damaged data, or of a later version");
  if (packed.filter == "OCTAHEDRAL")
    meshopt_decodeFilterOct(out.data(), packed.count, packed.stride);
  else if (packed.filter == "QUATERNION")
    meshopt_decodeFilterQuat(out.data(), packed.count, packed.stride);
  else if (packed.filter == "EXPONENTIAL")
    meshopt_decodeFilterExp(out.data(), packed.count, packed.stride);
  return out;
}

}  // namespace

std::vector<std::uint8_t> decompress_meshopt(const std::vector<std::uint8_t>& glb) {
  CompressedGlb file(glb);
  Json& views = file.document.json.at("bufferViews");
  for (std::size_t i = 0; i < views.size(); ++i) {
    const std::string place = "/bufferViews/" + std::to_string(i) + ": ";
    Json view = views[i];
    const bool packed =
        view.contains("extensions") && view["extensions"].contains(skin::kMeshoptExtension);
    // The other buffers only hold the place of what is packed.
    if (!packed && view.at("buffer") != 0) refuse(place + "data outside of the .glb file");
    if (!packed) continue;
    try {
      const Json extension = view["extensions"][skin::kMeshoptExtension];
      const Bytes plain = decode(packed_of(extension), file.run_of(extension));
      file.document.add_view(plain.data(), plain.size(), 0);
    } catch (const CharacterError& error) {
      refuse(place + error.what());
    }
    const Json added = views.back();
    views.erase(views.size() - 1);
    view["extensions"].erase(skin::kMeshoptExtension);
    if (view["extensions"].empty()) view.erase("extensions");
    for (const char* key : {"buffer", "byteOffset", "byteLength"}) view[key] = added[key];
    views[i] = std::move(view);
  }
  return file.finish(skin::kMeshoptExtension);
}

}  // namespace backbend::import
