#pragma once
#include <glm/gtc/quaternion.hpp>
#include <optional>
#include <vector>

#include "skin/gltf/glb_writer.h"
#include "skin/gltf/glb_writer_document.h"
#include "skin/gltf/skin_layout.h"

namespace backbend::skin {

/// Translation, rotation and scale: what a glTF node can say. matrix = T R S.
struct NodeTransform {
  glm::dvec3 translation{0.0};
  glm::dquat rotation{1.0, 0.0, 0.0, 0.0};
  glm::dvec3 scale{1.0};
};

/// The parts of a matrix, or nullopt where it shears by more than `slack` (cosine of the angle
/// between two axes) or flattens.
std::optional<NodeTransform> split_transform(const glm::dmat4& matrix, double slack = 1e-5);

/// A skeleton as it goes into a file: local transforms at rest and at each frame, and the inverse
/// binds that belong to them.
struct WrittenSkeleton {
  std::vector<NodeTransform> rest;                 // [node]
  std::vector<std::vector<NodeTransform>> frames;  // [frame][node]
  std::vector<glm::dmat4> joint_from_mesh;         // [joint of the character]
};

/// The joint frames that a file gets: those of the character where no node shears, else rigid ones;
/// or rigid ones where no node is flattened, so that only a motion that scales brings in scales.
enum class JointFrames { as_they_are, rigid };

/// Throws CharacterError as encode_glb() says.
WrittenSkeleton prepare_skeleton(const Character& character, const GlbAnimation* animation,
                                 JointFrames frames = JointFrames::as_they_are);

/// Writes nodes, skins and animation; the number of each skin of the layout. `unskinned` asks for
/// the joint that never moves, which is the last of each skin. Node numbers are the character's.
std::vector<int> add_skeleton(GlbDocument& document, const Character& character,
                              const GlbAnimation* animation, const SkinLayout& layout,
                              bool unskinned);

}  // namespace backbend::skin
