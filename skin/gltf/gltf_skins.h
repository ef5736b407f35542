#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "skin/character/character.h"
#include "skin/gltf/gltf_accessor.h"
#include "skin/gltf/rest_pose.h"

namespace backbend::skin {

/// Numbers the joints of a character: one for each node and inverse bind matrix, so that skins
/// which share both share the number.
class JointNumbers {
 public:
  explicit JointNumbers(Character& character);
  /// The number of this pair in Character::joints; a new one is added. Throws CharacterError past
  /// the 65535 that Influences can count.
  std::uint32_t number(int node, const glm::dmat4& joint_from_mesh);

 private:
  Character& character_;
  std::vector<std::vector<std::uint32_t>> of_node_;
};

/// The skins of a file, and the number in Character::joints of each of their joints.
struct GltfSkins {
  std::vector<BoundSkin> skin;
  std::vector<std::vector<std::uint32_t>> number;
  std::vector<Warning> warnings;
};

/// Throws CharacterError for a joint that does not exist or stands twice in a skin, and for too few
/// inverse bind matrices.
GltfSkins read_skins(const tinygltf::Model& model, const std::string& file,
                     const GltfAccessors& accessors, const std::vector<int>& index_of_file_node,
                     const std::vector<Node>& nodes, JointNumbers& numbers);

}  // namespace backbend::skin
