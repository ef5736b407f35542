#pragma once
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <span>
#include <vector>

#include "skin/character/character.h"

namespace backbend::skin {

/// What linear blending needs of one joint in one pose, column after column, rounded to float:
/// where bind-space points go (4 columns) and where normals go (3 columns).
struct alignas(16) JointMatrix {
  float point[4][4];
  float normal[3][4];
};

/// All joints of a character in one pose. `uneven` where some joint's normals go another way than
/// its points: it scales unevenly or mirrors.
struct JointMatrices {
  std::vector<JointMatrix> joint;
  bool uneven = false;
};

/// `world_from_node` has one matrix per node that `joints` speak of.
JointMatrices joint_matrices(const std::vector<SkinJoint>& joints,
                             std::span<const glm::dmat4> world_from_node);

/// What turns normals under `m`: its 3x3 part where that turns and scales evenly, else the inverse
/// transpose, scaled to the same size so that blends between the two kinds weigh fairly.
glm::mat3 normal_matrix(const glm::dmat4& m);

/// Unit length; +Y for a vector without length.
glm::vec3 unit_or_up(const glm::vec3& v);

/// One vertex by linear blending. The sum runs in the order of the joints' numbers, each step a
/// fused multiply-add: the blocks of SkinningPlan do the same, so that the bits agree.
void blend_vertex(const JointMatrices& joints, const Influences& influences,
                  const glm::vec3& bind_position, const glm::vec3& bind_normal, glm::vec3& position,
                  glm::vec3& normal);

}  // namespace backbend::skin
