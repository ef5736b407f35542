#pragma once
#include <glm/mat4x4.hpp>
#include <map>
#include <string>

namespace backbend::import {

/// By node, in the file's unit: where not the identity.
using GeometricTransforms = std::map<std::string, glm::dmat4, std::less<>>;

/// Takes the geometric transforms of an FBX's nodes, which move a node's mesh and nothing below it,
/// out of its bytes: 3ds Max writes them where a pivot was moved. Assimp moves the nodes below,
/// too, and, by version, not what joints move. Empty for text and for versions before 7, and nodes
/// of one name whose transforms differ are left as they are. A file whose records reach beyond it,
/// or beyond what holds them, has none: Assimp says what is wrong with it.
GeometricTransforms take_geometric_transforms(std::string& fbx);

}  // namespace backbend::import
