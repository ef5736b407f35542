#include "skin/deform/skinning.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>

#include "skin/deform/dual_quaternions.h"
#include "skin/deform/linear_blend.h"
#include "skin/deform/rest_matrices.h"

namespace backbend::skin {
namespace {

constexpr std::size_t kVerticesOfTask = 2048;  // far more work than a task costs

PosedMesh linear(const Character& character, const std::vector<glm::dmat4>& world_from_node) {
  assert(world_from_node.size() == character.nodes.size());
  const JointMatrices joints = joint_matrices(character.joints, world_from_node);
  PosedMesh out;
  out.position.resize(character.vertex_count());
  out.normal.resize(character.vertex_count());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, character.vertex_count(), kVerticesOfTask),
                    [&](const auto& range) {
                      for (std::size_t v = range.begin(); v != range.end(); ++v)
                        blend_vertex(joints, character.influences[v], character.bind_position[v],
                                     character.bind_normal[v], out.position[v], out.normal[v]);
                    });
  return out;
}

PosedMesh dual_quaternion(const Character& character,
                          const std::vector<glm::dmat4>& world_from_node) {
  PosedMesh out = rest_mesh(character);
  const JointMotions motions =
      joint_motions(character.joints, rest_matrices(character), world_from_node);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, character.vertex_count(), kVerticesOfTask),
                    [&](const auto& range) {
                      for (std::size_t v = range.begin(); v != range.end(); ++v)
                        blend_dual_quaternions(motions, character.influences[v], out.position[v],
                                               out.normal[v]);
                    });
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
