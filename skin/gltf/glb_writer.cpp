#include "skin/gltf/glb_writer.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "skin/gltf/glb_writer_document.h"
#include "skin/gltf/glb_writer_skeleton.h"
#include "skin/gltf/rigid_parts.h"
#include "skin/gltf/skin_layout.h"
#include "skin/gltf/written_influences.h"

namespace backbend::skin {
namespace {

/// What a mesh's vertices need of the skin that it hangs on.
struct SkinOfMesh {
  const SkinLayout& layout;
  std::size_t skin = 0;
  std::size_t joint_count = 0;  // of the character: WrittenInfluences' joint that never moves
  int sets = 1;                 // of four influences

  std::size_t place(std::size_t joint) const {
    return joint == joint_count ? layout.joints[skin].size() : layout.place(skin, joint);
  }
};

template <typename Index>
void add_joints(GlbDocument& document, Json& attributes,
                std::span<const WrittenInfluences> influences, const SkinOfMesh& skin,
                int component_type) {
  for (int set = 0; set < skin.sets; ++set) {
    std::vector<Index> joint;
    std::vector<float> weight;
    for (const WrittenInfluences& one : influences) {
      for (int k = 4 * set; k < 4 * set + 4; ++k) {
        const bool used = k < one.count;
        joint.push_back(used
                            ? static_cast<Index>(skin.place(one.joint[static_cast<std::size_t>(k)]))
                            : Index{0});
        weight.push_back(used ? one.weight[static_cast<std::size_t>(k)] : 0.0f);
      }
    }
    const int j = document.add_accessor<Index>(joint, component_type, "VEC4", kVertexTarget);
    const int w = document.add_accessor<float>(weight, kGlFloat, "VEC4", kVertexTarget);
    // Four numbers make one element.
    document.json["accessors"][static_cast<std::size_t>(j)]["count"] = influences.size();
    document.json["accessors"][static_cast<std::size_t>(w)]["count"] = influences.size();
    attributes[set == 0 ? "JOINTS_0" : "JOINTS_1"] = j;
    attributes[set == 0 ? "WEIGHTS_0" : "WEIGHTS_1"] = w;
  }
}

/// One primitive per part that `is_in` names, each with its own vertices; -1 where none has
/// triangles.
template <typename IsIn, typename AddMore>
int add_mesh(GlbDocument& document, const Character& character,
             const std::vector<glm::vec3>& position, const std::vector<glm::vec3>& normal,
             const IsIn& is_in, const AddMore& add_more) {
  Json primitives = Json::array();
  for (std::size_t p = 0; p < character.parts.size(); ++p) {
    const Part& part = character.parts[p];
    if (part.triangle_count == 0 || !is_in(p)) continue;
    const std::span<const glm::vec3> places(position.data() + part.first_vertex, part.vertex_count);
    for (const glm::vec3& p : places) {
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
        throw CharacterError("part `" + part.name + "`: vertex " +
                             std::to_string(&p - places.data() + part.first_vertex) +
                             " is not finite");
      }
    }
    Json attributes;
    const int at = document.add_accessor<glm::vec3>(places, kGlFloat, "VEC3", kVertexTarget);
    document.add_bounds<glm::vec3>(at, places, 3);
    attributes["POSITION"] = at;
    std::vector<glm::vec3> unit(normal.begin() + part.first_vertex,
                                normal.begin() + part.first_vertex + part.vertex_count);
    for (glm::vec3& n : unit) {
      const glm::dvec3 d(n);
      const double length = glm::length(d);
      n = std::isfinite(length) && length > 1e-20 ? glm::vec3(d / length) : glm::vec3(0, 1, 0);
    }
    attributes["NORMAL"] = document.add_accessor<glm::vec3>(unit, kGlFloat, "VEC3", kVertexTarget);
    if (!character.uv.empty()) {
      const std::span<const glm::vec2> uv(character.uv.data() + part.first_vertex,
                                          part.vertex_count);
      attributes["TEXCOORD_0"] =
          document.add_accessor<glm::vec2>(uv, kGlFloat, "VEC2", kVertexTarget);
    }
    add_more(part, attributes);
    std::vector<std::uint32_t> index;
    for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count;
         ++t) {
      for (int k = 0; k < 3; ++k) index.push_back(character.triangles[t][k] - part.first_vertex);
    }
    Json primitive = {{"attributes", attributes}};
    primitive["indices"] =
        document.add_accessor<std::uint32_t>(index, kGlUnsignedInt, "SCALAR", kIndexTarget);
    if (part.material >= 0 &&
        static_cast<std::size_t>(part.material) < character.materials.size()) {
      primitive["material"] = part.material;
    }
    primitives.push_back(std::move(primitive));
  }
  if (primitives.empty()) return -1;
  Json mesh;
  if (!character.name.empty()) mesh["name"] = character.name;
  mesh["primitives"] = std::move(primitives);
  return document.append("meshes", std::move(mesh));
}

}  // namespace

std::vector<std::uint8_t> encode_glb(const Character& given, const GlbAnimation* animation) {
  const WrittenSkin written = written_skin(given);
  const Character character = with_rigid_parts_at_rest(given);
  GlbDocument document;
  const int sets = std::ranges::any_of(written.influences,
                                       [](const WrittenInfluences& one) { return one.count > 4; })
                       ? 2
                       : 1;
  const SkinLayout layout = lay_out_skins(character, written.influences);
  const std::vector<int> skins =
      add_skeleton(document, character, animation, layout, written.unskinned);
  add_materials(document, character, false);
  const bool small = character.joints.size() + 1 <= 256;
  bool any = false;
  for (std::size_t s = 0; s < skins.size(); ++s) {
    const SkinOfMesh own{layout, s, character.joints.size(), sets};
    const int mesh = add_mesh(
        document, character, character.bind_position, character.bind_normal,
        [&](std::size_t part) { return layout.of_part[part] == s; },
        [&](const Part& part, Json& attributes) {
          const auto influences =
              std::span(written.influences).subspan(part.first_vertex, part.vertex_count);
          if (small) {
            add_joints<std::uint8_t>(document, attributes, influences, own, kGlUnsignedByte);
          } else {
            add_joints<std::uint16_t>(document, attributes, influences, own, kGlUnsignedShort);
          }
        });
    if (mesh < 0) continue;
    any = true;
    Json node;
    if (!character.name.empty())
      node["name"] = character.name + "_mesh" + (s == 0 ? "" : "_" + std::to_string(s + 1));
    node["mesh"] = mesh;
    node["skin"] = skins[s];
    const int index = document.append("nodes", std::move(node));
    document.json["scenes"][0]["nodes"].push_back(index);
  }
  if (!any) throw CharacterError(character.file_name + ": no triangles to write");
  return document.finish();
}

std::vector<std::uint8_t> encode_posed_glb(const Character& character, const PosedMesh& posed,
                                           std::span<const glm::vec3> color) {
  const std::size_t n = character.vertex_count();
  if (posed.position.size() != n || posed.normal.size() != n ||
      (!color.empty() && color.size() != n)) {
    throw CharacterError(character.file_name + ": a pose of " +
                         std::to_string(posed.position.size()) + " vertices for a mesh of " +
                         std::to_string(n));
  }
  GlbDocument document;
  document.json["scene"] = 0;
  document.json["scenes"] = Json::array({{{"nodes", {0}}}});
  add_materials(document, character, !color.empty());
  const int mesh = add_mesh(
      document, character, posed.position, posed.normal, [](std::size_t) { return true; },
      [&](const Part& part, Json& attributes) {
        if (color.empty()) return;
        std::vector<glm::vec4> own;
        for (std::uint32_t v = part.first_vertex; v < part.first_vertex + part.vertex_count; ++v) {
          const glm::vec3 c = color[v];
          // A colour that is not a number would make the file invalid: black.
          const auto channel = [](float x) { return x >= 0.0f ? std::min(x, 1.0f) : 0.0f; };
          own.emplace_back(channel(c.x), channel(c.y), channel(c.z), 1.0f);
        }
        attributes["COLOR_0"] =
            document.add_accessor<glm::vec4>(own, kGlFloat, "VEC4", kVertexTarget);
      });
  if (mesh < 0) throw CharacterError(character.file_name + ": no triangles to write");
  Json node;
  if (!character.name.empty()) node["name"] = character.name;
  node["mesh"] = mesh;
  document.append("nodes", std::move(node));
  return document.finish();
}

}  // namespace backbend::skin
