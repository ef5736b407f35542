#include "skin/body/body.h"

#include <glm/ext/matrix_transform.hpp>

#include "skin/body/body_build.h"

namespace backbend::skin {
namespace {

void add_skeleton(const BodyDescription& body, Character& character) {
  for (std::size_t i = 0; i < body.joints.size(); ++i) {
    const BodyJoint& joint = body.joints[i];
    Node node;
    node.name = joint.name;
    node.parent = joint.parent;
    node.file_node = static_cast<int>(i);
    node.world_from_node = glm::translate(glm::dmat4(1.0), joint.at);
    const glm::dvec3 base =
        joint.parent < 0 ? glm::dvec3(0.0) : body.joints[static_cast<std::size_t>(joint.parent)].at;
    node.parent_from_node = glm::translate(glm::dmat4(1.0), joint.at - base);
    character.nodes.push_back(node);
    character.joints.push_back({static_cast<int>(i), glm::translate(glm::dmat4(1.0), -joint.at)});
  }
}

void add_mesh(const BodyDescription& body, const SkinnedHalf& half, Character& character) {
  const std::vector<glm::dvec3>& position = half.mesh.position;
  std::vector<std::uint32_t> twin(position.size());
  const auto add = [&](const glm::dvec3& p, const glm::dvec3& n, const Influences& w) {
    character.bind_position.emplace_back(p);
    character.bind_normal.emplace_back(n);
    character.influences.push_back(w);
  };
  for (std::size_t v = 0; v < position.size(); ++v) {
    add(position[v], half.normal[v], half.weights[v]);
  }
  for (std::size_t v = 0; v < position.size(); ++v) {
    twin[v] = static_cast<std::uint32_t>(v);
    if (position[v].x == 0.0) continue;
    twin[v] = static_cast<std::uint32_t>(character.bind_position.size());
    Influences w = half.weights[v];
    for (std::size_t k = 0; k < kMaxInfluences; ++k) {
      if (w.weight[k] > 0.0f) w.joint[k] = static_cast<std::uint16_t>(body.joints[w.joint[k]].twin);
    }
    const glm::dvec3 flip(-1, 1, 1);
    add(position[v] * flip, half.normal[v] * flip, w);
  }
  for (const auto& t : half.mesh.triangle) {
    character.triangles.emplace_back(t[0], t[1], t[2]);
  }
  for (const auto& t : half.mesh.triangle) {
    character.triangles.emplace_back(twin[static_cast<std::size_t>(t[0])],
                                     twin[static_cast<std::size_t>(t[2])],
                                     twin[static_cast<std::size_t>(t[1])]);
  }
}

}  // namespace

Character make_body(const BodyDescription& body, const BodyOptions& options) {
  if (!body.symmetric) throw CharacterError(body.file_name + ": not a symmetric description");
  Character character;
  character.name = body.name;
  character.file_name = body.file_name;
  character.content_hash_low = body.content_hash_low;
  character.content_hash_high = body.content_hash_high;
  character.materials.push_back(body.material);
  add_skeleton(body, character);
  add_mesh(body, build_half(body, options), character);
  const auto vertex_count = static_cast<std::uint32_t>(character.vertex_count());
  character.parts.push_back(
      {body.name, 0, 0, static_cast<std::uint32_t>(character.triangles.size()), 0, vertex_count});
  character.place.resize(vertex_count);
  for (std::uint32_t v = 0; v < vertex_count; ++v) character.place[v] = v;
  character.place_count = vertex_count;
  return character;
}

}  // namespace backbend::skin
