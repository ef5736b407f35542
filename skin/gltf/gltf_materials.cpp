#include "skin/gltf/gltf_materials.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>

namespace backbend::skin {
namespace {

/// A factor of the file, kept within 0..1; `otherwise` where it is no number.
float unit_factor(double value, float otherwise) {
  return std::isfinite(value) ? static_cast<float>(std::clamp(value, 0.0, 1.0)) : otherwise;
}

int image_of(const tinygltf::Model& model, int texture, std::size_t image_count) {
  if (texture < 0 || static_cast<std::size_t>(texture) >= model.textures.size()) return -1;
  const tinygltf::Texture& from = model.textures[static_cast<std::size_t>(texture)];
  int image = from.source;
  // The WebP picture stands in an extension, beside or instead of the plain source.
  if (const auto webp = from.extensions.find("EXT_texture_webp");
      webp != from.extensions.end() && webp->second.Has("source"))
    image = webp->second.Get("source").GetNumberAsInt();
  return image >= 0 && static_cast<std::size_t>(image) < image_count ? image : -1;
}

}  // namespace

std::vector<Material> read_materials(const tinygltf::Model& model, std::size_t image_count) {
  std::vector<Material> out;
  for (const tinygltf::Material& from : model.materials) {
    const auto& pbr = from.pbrMetallicRoughness;
    Material to;
    to.name = from.name.empty() ? "material_" + std::to_string(out.size()) : from.name;
    to.base_color = glm::vec4(1.0f);
    for (std::size_t c = 0; c < 4 && c < pbr.baseColorFactor.size(); ++c)
      to.base_color[static_cast<int>(c)] = unit_factor(pbr.baseColorFactor[c], 1.0f);
    to.roughness = unit_factor(pbr.roughnessFactor, 1.0f);
    to.metallic = unit_factor(pbr.metallicFactor, 1.0f);
    for (std::size_t c = 0; c < 3 && c < from.emissiveFactor.size(); ++c)
      to.emissive[static_cast<int>(c)] = unit_factor(from.emissiveFactor[c], 0.0f);
    to.base_color_image = image_of(model, pbr.baseColorTexture.index, image_count);
    to.metallic_roughness_image = image_of(model, pbr.metallicRoughnessTexture.index, image_count);
    to.normal_image = image_of(model, from.normalTexture.index, image_count);
    to.double_sided = from.doubleSided;
    out.push_back(std::move(to));
  }
  out.push_back({.name = "default"});
  return out;
}

}  // namespace backbend::skin
