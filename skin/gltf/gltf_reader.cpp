#include "skin/gltf/gltf_reader.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_inverse.hpp>

#include "skin/character/matrix_facts.h"
#include "skin/character/printable.h"
#include "skin/character/weld.h"
#include "skin/deform/skinning.h"
#include "skin/gltf/gltf_document.h"
#include "skin/gltf/gltf_geometry.h"
#include "skin/gltf/gltf_materials.h"
#include "skin/gltf/gltf_skeleton.h"
#include "skin/gltf/gltf_weights.h"
#include "skin/gltf/rest_pose.h"

namespace backbend::skin {
namespace {

/// Vertices that no joint moves would collapse into the origin: they stay where they were bound,
/// on the topmost node above their skin.
void hold_unweighted(Character& character, const GltfGeometry& geometry) {
  std::size_t held = 0, first = 0;
  std::vector<int> anchor(geometry.skins.size(), -1);  // into Character::joints
  for (std::size_t v = 0; v < character.vertex_count(); ++v) {
    Influences& influences = character.influences[v];
    if (influences.weight[0] > 0.0f) continue;
    const auto s = static_cast<std::size_t>(geometry.vertex_skin[v]);
    if (anchor[s] < 0) {
      int top = geometry.skins[s].node.front();
      while (character.nodes[static_cast<std::size_t>(top)].parent >= 0)
        top = character.nodes[static_cast<std::size_t>(top)].parent;
      const glm::dmat4& world = character.nodes[static_cast<std::size_t>(top)].world_from_node;
      if (!is_invertible(world) || character.joints.size() > 65535)
        throw CharacterError(character.file_name + ": vertex " + std::to_string(v) +
                             " has no weights and its skeleton no usable root");
      anchor[s] = static_cast<int>(character.joints.size());
      character.joints.push_back(
          {top, glm::affineInverse(world) * geometry.skins[s].world_from_mesh});
    }
    influences.joint[0] = static_cast<std::uint16_t>(anchor[s]);
    influences.weight[0] = 1.0f;
    character.unweighted.push_back(static_cast<std::uint32_t>(v));
    if (held++ == 0) first = v;
  }
  if (held > 0)
    character.warnings.push_back(
        {"vertices_unweighted", std::to_string(held) + " of " +
                                    std::to_string(character.vertex_count()) +
                                    " vertices have no weight (first: vertex " +
                                    std::to_string(first) + "): they stay at their rest place"});
}

/// Where each vertex stands with the skin at bind, in the world: one point for all the vertices of
/// a place, whatever their weights.
std::vector<glm::vec3> bind_points(const Character& character, const GltfGeometry& geometry) {
  std::vector<glm::vec3> out(character.vertex_count());
  for (std::size_t v = 0; v < out.size(); ++v) {
    const int skin = geometry.vertex_skin[v];
    const auto& joint = character.joints[character.influences[v].joint[0]];
    const glm::dmat4 place =
        skin >= 0 ? geometry.skins[static_cast<std::size_t>(skin)].world_from_mesh
                  : character.nodes[static_cast<std::size_t>(joint.node)].world_from_node;
    out[v] = glm::vec3(place * glm::dvec4(glm::dvec3(character.bind_position[v]), 1.0));
  }
  return out;
}

/// Numbers that are finite each may still leave the range of float together.
void check_finite(const std::string& file, const Character& character) {
  const PosedMesh rest = rest_mesh(character);
  for (std::size_t v = 0; v < character.vertex_count(); ++v) {
    const glm::vec3& p = rest.position[v];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
      throw CharacterError(file + ": vertex " + std::to_string(v) +
                           " does not stand at a finite place at rest");
  }
}

/// What a character has without its mesh, and where its nodes stood in the file.
Character start_character(const GltfDocument& document, std::vector<int>& index_of_file_node) {
  Character character;
  const std::filesystem::path file(document.file);
  character.name = file.stem().string();
  character.file_name = file.filename().string();
  character.content_hash_low = document.content_hash_low;
  character.content_hash_high = document.content_hash_high;
  character.images = document.images;
  character.warnings = document.warnings;
  character.materials = read_materials(*document.model, character.images.size());
  GltfNodes nodes = read_nodes(*document.model, document.file);
  character.nodes = std::move(nodes.nodes);
  index_of_file_node = std::move(nodes.index_of_file_node);
  return character;
}

bool has_skin(const GltfGeometry& geometry) {
  return std::any_of(geometry.vertex_skin.begin(), geometry.vertex_skin.end(),
                     [](int skin) { return skin >= 0; });
}

/// A singular bind matrix has no inverse: the joint's place is unknown. One
/// of a joint that moves nothing does no harm.
void check_bind_matrices(const std::string& file, const GltfGeometry& geometry,
                         Character& character) {
  std::vector<bool> moves(character.joints.size(), false);
  for (const Influences& influences : character.influences)
    for (std::size_t k = 0; k < kMaxInfluences && influences.weight[k] > 0.0f; ++k)
      moves[influences.joint[k]] = true;
  for (std::size_t s = 0; s < geometry.skins.size(); ++s)
    for (std::size_t j = 0; j < geometry.skins[s].node.size(); ++j) {
      const int node = geometry.skins[s].node[j];
      const glm::dmat4& matrix = geometry.skins[s].joint_from_mesh[j];
      if (is_invertible(matrix)) continue;
      const std::string story = "/skins/" + std::to_string(s) + "/joints/" + std::to_string(j) +
                                ": joint " +
                                in_quotes(character.nodes[static_cast<std::size_t>(node)].name) +
                                " has a singular inverse bind matrix (it flattens the body)";
      for (std::size_t n = 0; n < character.joints.size(); ++n)
        if (moves[n] && character.joints[n].node == node &&
            character.joints[n].joint_from_mesh == matrix)
          throw CharacterError(file + ": " + story +
                               ": bind it again, with the scale of mesh and armature applied");
      character.warnings.push_back({"ibm_singular", story + "; it moves nothing"});
    }
}

void finish_character(const GltfDocument& document, GltfGeometry& geometry, Character& character) {
  check_bind_matrices(document.file, geometry, character);
  for (Warning& warning : settle_rest_pose(character, geometry.skins, geometry.vertex_skin))
    character.warnings.push_back(std::move(warning));
  hold_unweighted(character, geometry);
  check_finite(document.file, character);
  Places places = weld(bind_points(character, geometry));
  character.place = std::move(places.place);
  character.place_count = places.count;
  if (character.place_count < 2)
    throw CharacterError(document.file + ": all " + std::to_string(character.vertex_count()) +
                         " vertices lie in one place: a body without extent");
}

}  // namespace

Character read_character(const std::filesystem::path& file) {
  return read_character(load_gltf(file));
}

WeightedGltf read_weighted(const GltfDocument& document) {
  std::vector<int> index_of_file_node;
  Character character = start_character(document, index_of_file_node);
  GltfGeometry geometry =
      read_geometry(*document.model, document.file, index_of_file_node, character);
  if (character.triangles.empty())
    throw NoMeshError(document.file +
                      ": no triangles to judge; backbend body makes a body for a skeleton");
  if (!has_skin(geometry))
    throw CharacterError(document.file + ": no mesh with a skin: nothing follows a skeleton");
  finish_character(document, geometry, character);
  return {std::move(character), geometry.weight_sources, geometry.off_sum};
}

Character read_character(const GltfDocument& document) { return read_weighted(document).character; }

Character read_skeleton(const GltfDocument& document) {
  std::vector<int> index_of_file_node;
  Character character = start_character(document, index_of_file_node);
  Character bare = character;
  GltfGeometry geometry =
      read_geometry(*document.model, document.file, index_of_file_node, character);
  if (!character.triangles.empty() && has_skin(geometry)) {
    finish_character(document, geometry, character);
    return character;
  }
  if (bare.nodes.size() < 2) throw CharacterError(document.file + ": no skeleton");
  for (std::size_t n = 0; n < bare.nodes.size(); ++n)
    bare.joints.push_back({static_cast<int>(n), glm::dmat4(1.0)});
  return bare;
}

}  // namespace backbend::skin
