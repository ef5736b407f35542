#include "cli/import/compressed_glb.h"

#include "skin/gltf/glb_container.h"

namespace backbend::import {

using skin::CharacterError;
using skin::Json;

CompressedGlb::CompressedGlb(const std::vector<std::uint8_t>& glb) {
  skin::GltfContainer container = skin::open_gltf_container("the file", glb);
  document.json = Json::parse(container.json_text);
  if (!container.binary || document.json.at("buffers").at(0).contains("uri"))
    throw CharacterError("compressed data outside of the .glb file");
  binary = std::move(*container.binary);
  document.add_view(binary.data(), binary.size(), 0);
}

CompressedGlb::Run CompressedGlb::run_of(const Json& place) const {
  const auto begin = place.value("byteOffset", std::size_t{0});
  const auto size = place.at("byteLength").get<std::size_t>();
  if (place.at("buffer") != 0 || begin > binary.size() || size > binary.size() - begin)
    throw CharacterError("compressed data beyond the file's end");
  return {binary.data() + begin, size};
}

std::vector<std::uint8_t> CompressedGlb::finish(const std::string& extension) {
  for (const char* list : {"extensionsRequired", "extensionsUsed"}) {
    if (!document.json.contains(list)) continue;
    Json others = Json::array();
    for (const Json& each : document.json[list])
      if (each != extension) others.push_back(each);
    if (others.empty())
      document.json.erase(list);
    else
      document.json[list] = std::move(others);
  }
  return document.finish();
}

}  // namespace backbend::import
