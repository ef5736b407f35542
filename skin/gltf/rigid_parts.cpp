#include "skin/gltf/rigid_parts.h"

#include <algorithm>
#include <glm/matrix.hpp>

#include "skin/character/matrix_facts.h"
#include "skin/gltf/bind_agreement.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;

constexpr double kSame = 1e-6;  // of an axis, between two motions

/// The joint that alone moves all vertices of a part; -1 for none.
int only_joint(const Character& character, const Part& part) {
  const auto first = character.influences.begin() + part.first_vertex;
  const auto last = first + part.vertex_count;
  if (first == last) return -1;
  const std::uint16_t joint = first->joint[0];
  const bool alone = std::all_of(first, last, [&](const Influences& influences) {
    return influences.weight[0] > 0.0f && !(influences.weight[1] > 0.0f) &&
           influences.joint[0] == joint;
  });
  return alone ? joint : -1;
}

}  // namespace

Character with_rigid_parts_at_rest(Character character) {
  std::vector<int> joint_of;  // of each part
  std::vector<double> weight(character.joints.size(), 0.0);
  for (const Part& part : character.parts) {
    joint_of.push_back(only_joint(character, part));
    if (joint_of.back() >= 0) continue;
    for (Index v = part.first_vertex; v < Index{part.first_vertex} + part.vertex_count; ++v)
      for (Index k = 0; k < kMaxInfluences && character.influences[v].weight[k] > 0.0f; ++k)
        weight[character.influences[v].joint[k]] += character.influences[v].weight[k];
  }
  const auto main = std::ranges::max_element(weight);
  if (main == weight.end() || !(*main > 0.0)) return character;
  const glm::dmat4 place = rest_motion(character, static_cast<Index>(main - weight.begin()));
  if (!is_finite(place) || !is_invertible(place)) return character;
  std::vector<glm::dmat4> moved(character.joints.size(), glm::dmat4(1.0));
  std::vector<bool> moves(character.joints.size(), false);
  for (const int joint : joint_of) {
    const auto j = static_cast<Index>(joint);
    if (joint < 0 || moves[j] || weight[j] > 0.0) continue;
    const glm::dmat4& world =
        character.nodes[static_cast<Index>(character.joints[j].node)].world_from_node;
    const glm::dmat4 motion = rest_motion(character, j);
    if (!is_finite(motion) || !is_invertible(motion) || !is_invertible(world) ||
        same_motion(motion, place, kSame, 1.0))
      continue;
    moved[j] = glm::inverse(place) * motion;
    if (glm::determinant(glm::dmat3(moved[j])) < 0.0) continue;
    moves[j] = true;
    character.joints[j].joint_from_mesh = glm::inverse(world) * place;
  }
  for (Index k = 0; k < character.parts.size(); ++k) {
    const auto j = static_cast<Index>(joint_of[k]);
    if (joint_of[k] < 0 || !moves[j]) continue;
    const Part& part = character.parts[k];
    const glm::dmat3 turn = glm::transpose(glm::inverse(glm::dmat3(moved[j])));
    for (Index v = part.first_vertex; v < Index{part.first_vertex} + part.vertex_count; ++v) {
      character.bind_position[v] =
          glm::vec3(moved[j] * glm::dvec4(glm::dvec3(character.bind_position[v]), 1.0));
      character.bind_normal[v] = glm::vec3(turn * glm::dvec3(character.bind_normal[v]));
    }
  }
  return character;
}

}  // namespace backbend::skin
