#pragma once
#include <string>

namespace backbend::import {

/// The bytes of a binary FBX in which the names of its limb nodes (joints) are each their own: the
/// second "joint5" is "joint5.001", as Blender counts. Maya lets joints below different parents
/// have one name, and Assimp tells them by nothing else. Throws skin::CharacterError for text FBX,
/// for versions before 7 (which join nodes by name), and where records reach beyond the file.
std::string with_unique_joint_names(const std::string& fbx);

}  // namespace backbend::import
