#pragma once
#include <glm/vec3.hpp>
#include <vector>

#include "skin/character/character.h"
#include "skin/character/joint_names.h"

namespace backbend::skin {

/// Two branches that mirror each other: arms, legs, ears. Siblings, but for limbs whose sides hang
/// from different nodes: `parent` is then the nearest node above both, or the root above the left
/// one. Indices into Character::nodes.
struct MirrorPair {
  int parent = -1;            // the lowest node above both
  int left = -1, right = -1;  // where no name tells the sides: in order of the file
  bool named = false;         // the names tell left from right
};

/// What a skeleton looks like, whatever it is called. Per node of the character, at rest.
struct SkeletonShape {
  std::vector<NameFacts> name;
  std::vector<std::vector<int>> children;
  std::vector<bool> is_joint;        // moves vertices, or could
  std::vector<bool> is_mechanism;    // by its name no bone that deforms, in a rig that names these
  std::vector<double> weight;        // vertices moved, in sum of weights
  std::vector<double> weight_below;  // of the node and all its descendants
  std::vector<glm::dvec3> position;
  std::vector<int> farthest;  // the descendant joint farthest away, but for props (itself if none)
  std::vector<double> reach;  // distance to it
  std::vector<bool> is_prop;  // of nodes_of_props()
  std::vector<bool> is_scenery;    // a prop without a joint above it, out of the body's box
  std::vector<glm::vec3> rest;     // [vertices] the mesh at rest
  std::vector<bool> is_scene;      // [vertices] of scenery
  glm::dvec3 low{0.0}, high{0.0};  // the box of all others
  double size = 0.0;               // the box's largest side
  std::vector<MirrorPair> pairs;
};

/// Measures a character's skeleton. Throws CharacterError where it has no joints.
SkeletonShape measure_skeleton(const Character& character);

/// Measures the box and the size of all vertices but those left out; zero of none.
void measure_box(SkeletonShape& shape, const std::vector<bool>& left_out);

/// Nodes from `top` down to `bottom`, both included; empty where `top` is not above `bottom`.
std::vector<int> path_down(const Character& character, int top, int bottom);

}  // namespace backbend::skin
