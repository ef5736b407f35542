#pragma once
#include <array>
#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <span>
#include <vector>

#include "skin/character/character.h"

namespace backbend::skin {

/// A joint's motion from rest to pose, split into a stretch and then a rigid motion.
struct DualQuaternion {
  glm::quat turn{1.0f, 0.0f, 0.0f, 0.0f};
  glm::quat shift{0.0f, 0.0f, 0.0f, 0.0f};  // the dual part: half of translation x turn
  glm::mat3 added_stretch{0.0f};            // stretch minus identity
  bool stretches = false;                   // added_stretch is not zero
};

/// All joints of a character in one pose.
struct JointMotions {
  std::vector<DualQuaternion> joint;
  bool stretch = false;  // some joint does
};

/// `rest` and `world_from_node` have one matrix per node that `joints` speak of.
JointMotions joint_motions(const std::vector<SkinJoint>& joints,
                           const std::vector<glm::dmat4>& rest,
                           const std::vector<glm::dmat4>& world_from_node);

/// One vertex at rest, moved by the blend of its joints' motions.
void blend_dual_quaternions(const JointMotions& motions, const Influences& influences,
                            glm::vec3& position, glm::vec3& normal);

/// A character laid out for skinning many poses: the same bits as skin() with dual quaternions.
///
/// Eight vertices that follow each other are blended at once; the mesh at rest, which dual
/// quaternions move, is made once. Where a joint stretches, vertices are blended one by one. Built
/// once per character, then immutable: skin() may be called on many threads, and uses TBB itself.
class DualQuaternionPlan {
 public:
  explicit DualQuaternionPlan(const Character& character);

  /// As backbend::skin::skin(). `out` is resized; reuse it from pose to pose to save its making.
  void skin(const std::vector<glm::dmat4>& world_from_node, PosedMesh& out) const;

 private:
  using Joints = std::array<std::uint16_t, 8>;  // of eight vertices, the last one repeated
  struct Block {
    std::uint32_t joints = 0;  // its first entry of joints_; its weights are the same entries
    std::uint8_t count = 0;    // joints of the vertex that has most
    std::uint8_t alike = 0;    // bit k: the k-th joint of all eight is the same
  };
  struct Motion;
  template <bool kWhole>
  void skin_block(const Motion* motions, std::size_t block, glm::vec3* position,
                  glm::vec3* normal) const;

  std::vector<SkinJoint> joint_;
  std::vector<glm::dmat4> rest_node_;
  std::vector<Influences> influences_;
  PosedMesh rest_;
  std::vector<Block> blocks_;
  std::vector<Joints> joints_;
  std::vector<float> weights_;  // eight for each entry of joints_
  std::vector<float> data_;     // of each block at rest: eight x, y, z, normal x, y, z
};

}  // namespace backbend::skin
