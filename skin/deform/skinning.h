#pragma once
#include <vector>

#include "skin/character/character.h"

namespace backbend::skin {

enum class SkinningMethod { linear, dual_quaternion };

/// Skins a character: out[v] = sum of weight * world_from_node[joint.node] * joint_from_mesh *
/// bind.
///
/// `world_from_node` has one matrix per node of the character. Normals use the inverse transpose
/// where a joint scales unevenly or mirrors, and are unit length. The result does not depend on the
/// number of threads. For many poses of one character build a SkinningPlan
/// (skin/deform/skinning_plan.h): the same bits, several times faster. Source: glTF 2.0
/// specification, "Skinned Mesh Attributes"; L. Kavan et al., "Geometric Skinning with Approximate
/// Dual Quaternion Blending", 2008.
PosedMesh skin(const Character& character, const std::vector<glm::dmat4>& world_from_node,
               SkinningMethod method = SkinningMethod::linear);

/// The character at rest: skinned with the rest matrices of its nodes.
PosedMesh rest_mesh(const Character& character);

}  // namespace backbend::skin
