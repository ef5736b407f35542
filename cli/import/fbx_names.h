#pragma once
#include <optional>
#include <string>

namespace backbend::import {

/// The bytes of a binary FBX in which the names of its limb nodes (joints) are each their own: the
/// second "joint5" is "joint5.001", as Blender counts. Maya lets joints below different parents
/// have one name, and Assimp tells them by nothing else. None for text and for versions before 7,
/// which join nodes by name. Throws skin::CharacterError where records reach beyond the file.
std::optional<std::string> with_unique_joint_names(const std::string& fbx);

}  // namespace backbend::import
