#pragma once
#include <string>
#include <vector>

#include "skin/anatomy/skeleton_shape.h"
#include "skin/character/character.h"

namespace backbend::skin {

/// Where the spine's path through a skeleton starts and ends, or why nobody could tell.
struct SpineEnds {
  int hip = -1, head = -1;           // nodes; -1 where nothing was found
  std::vector<std::string> reasons;  // one line for each choice
  std::string doubt;                 // empty where the choice is sure
};

/// A pair of limbs on the body (not on the head, not fingers), and what its names say.
struct LimbPair {
  MirrorPair pair;
  enum class Kind { unknown, arm, leg } kind = Kind::unknown;
};

/// The limbs of a skeleton: pairs that reach far, or that are called arm, leg or fin.
std::vector<LimbPair> find_limbs(const Character& character, const SkeletonShape& shape, int head);

/// The head by name, -1 where no joint is called so.
int head_by_name(const SkeletonShape& shape);

/// Finds hips and head: by name where the name fits the tree, else by where the limbs branch off.
SpineEnds find_spine_ends(const Character& character, const SkeletonShape& shape,
                          const std::vector<LimbPair>& limbs);

/// A node that stands for the scene, not the body: it moves no vertex and lies at the origin of the
/// world or outside the mesh.
bool is_scene_root(const SkeletonShape& shape, int node);

}  // namespace backbend::skin
