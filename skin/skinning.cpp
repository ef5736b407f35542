#include "skin/skinning.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/gtc/matrix_inverse.hpp>

#include "skin/linear_blend.h"
#include "skin/matrix_facts.h"

namespace backbend::skin {
namespace {

// A joint that stretches by less does not stretch: float matrices of rigid motions round so far.
constexpr float kNoStretch = 1e-6f;
constexpr std::size_t kGrain = 2048;  // vertices a task: far more work than a task costs

PosedMesh linear(const Character& character, const std::vector<glm::dmat4>& world_from_node) {
  assert(world_from_node.size() == character.nodes.size());
  const JointMatrices joints = joint_matrices(character.joints, world_from_node);
  PosedMesh out;
  out.position.resize(character.vertex_count());
  out.normal.resize(character.vertex_count());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, character.vertex_count(), kGrain),
                    [&](const auto& range) {
                      for (std::size_t v = range.begin(); v != range.end(); ++v)
                        blend_vertex(joints, character.influences[v], character.bind_position[v],
                                     character.bind_normal[v], out.position[v], out.normal[v]);
                    });
  return out;
}

/// A joint's motion from rest to pose, split into a stretch and then a rigid motion.
struct DualQuaternion {
  glm::quat turn{1.0f, 0.0f, 0.0f, 0.0f};
  glm::quat shift{0.0f, 0.0f, 0.0f, 0.0f};  // the dual part: half of translation x turn
  glm::mat3 added_stretch{0.0f};            // stretch minus identity
  bool stretches = false;                   // added_stretch is not zero
};

/// The rotation nearest to `m`, by Newton's iteration on its inverse transpose.
/// Source: N. Higham, "Computing the Polar Decomposition with Applications", 1986.
glm::dmat3 nearest_rotation(glm::dmat3 m) {
  for (int step = 0; step < 32; ++step) {
    const glm::dmat3 next = 0.5 * (m + glm::inverseTranspose(m));
    double change = 0.0;
    for (int c = 0; c < 3; ++c) change += glm::length(next[c] - m[c]);
    m = next;
    if (change < 1e-15) break;
  }
  return m;
}

DualQuaternion motion(const glm::dmat4& from_rest) {
  DualQuaternion out;
  // A mirrored or collapsed joint has no rotation to blend: all of it is stretch then.
  const bool turns = is_invertible(from_rest) && glm::determinant(glm::dmat3(from_rest)) > 0.0;
  const glm::dmat3 rotation = turns ? nearest_rotation(glm::dmat3(from_rest)) : glm::dmat3(1.0);
  const glm::dquat turn = glm::normalize(glm::quat_cast(rotation));
  const glm::dvec3 shift = origin(from_rest);
  out.turn = glm::quat(turn);
  out.shift = glm::quat(0.5 * (glm::dquat(0.0, shift.x, shift.y, shift.z) * turn));
  out.added_stretch = glm::mat3(glm::transpose(rotation) * glm::dmat3(from_rest) - glm::dmat3(1.0));
  float most = 0.0f;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) most = std::max(most, std::abs(out.added_stretch[c][r]));
  out.stretches = !(most <= kNoStretch);
  if (!out.stretches) out.added_stretch = glm::mat3(0.0f);
  return out;
}

/// One vertex at rest, moved by the blend of its joints' motions; without `kStretch` none of them
/// stretches.
template <bool kStretch>
void blend_dual_quaternions(const std::vector<DualQuaternion>& motions,
                            const Influences& influences, glm::vec3& position, glm::vec3& normal) {
  const glm::quat& lead = motions[influences.joint[0]].turn;
  glm::quat turn(0.0f, 0.0f, 0.0f, 0.0f), shift(0.0f, 0.0f, 0.0f, 0.0f);
  // Summed as what it adds to the identity, so that rest comes out exactly.
  glm::mat3 stretch(1.0f);
  for (std::size_t k = 0; k < kMaxInfluences && influences.weight[k] > 0.0f; ++k) {
    const DualQuaternion& joint = motions[influences.joint[k]];
    // q and -q are one rotation: take the one on the side of the largest weight.
    const float weight =
        glm::dot(lead, joint.turn) < 0.0f ? -influences.weight[k] : influences.weight[k];
    turn = turn + weight * joint.turn;
    shift = shift + weight * joint.shift;
    if constexpr (kStretch) stretch += influences.weight[k] * joint.added_stretch;
  }
  const float size = std::sqrt(glm::dot(turn, turn));
  if (!(size > 0.0f)) return;
  turn = turn / size;
  shift = shift / size;
  const glm::quat moved = 2.0f * (shift * glm::conjugate(turn));
  if constexpr (kStretch) {
    position = stretch * position;
    normal = normal_matrix(glm::dmat4(stretch)) * normal;
  }
  position = turn * position + glm::vec3(moved.x, moved.y, moved.z);
  normal = unit_or_up(turn * normal);
}

PosedMesh dual_quaternion(const Character& character,
                          const std::vector<glm::dmat4>& world_from_node) {
  PosedMesh out = rest_mesh(character);
  std::vector<DualQuaternion> motions(character.joints.size());
  for (std::size_t j = 0; j < motions.size(); ++j) {
    const auto node = static_cast<std::size_t>(character.joints[j].node);
    const glm::dmat4& rest = character.nodes[node].world_from_node;
    motions[j] = motion(world_from_node[node] == rest || !is_invertible(rest)
                            ? glm::dmat4(1.0)
                            : world_from_node[node] * glm::affineInverse(rest));
  }
  const bool stretches = std::any_of(motions.begin(), motions.end(),
                                     [](const DualQuaternion& joint) { return joint.stretches; });
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, character.vertex_count(), kGrain), [&](const auto& range) {
        const auto blend = stretches ? blend_dual_quaternions<true> : blend_dual_quaternions<false>;
        for (std::size_t v = range.begin(); v != range.end(); ++v)
          blend(motions, character.influences[v], out.position[v], out.normal[v]);
      });
  return out;
}

std::vector<glm::dmat4> rest_matrices(const Character& character) {
  std::vector<glm::dmat4> out(character.nodes.size());
  for (std::size_t n = 0; n < out.size(); ++n) out[n] = character.nodes[n].world_from_node;
  return out;
}

}  // namespace

PosedMesh skin(const Character& character, const std::vector<glm::dmat4>& world_from_node,
               SkinningMethod method) {
  return method == SkinningMethod::linear ? linear(character, world_from_node)
                                          : dual_quaternion(character, world_from_node);
}

PosedMesh rest_mesh(const Character& character) {
  return linear(character, rest_matrices(character));
}

}  // namespace backbend::skin
