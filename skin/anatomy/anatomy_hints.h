#pragma once
#include <string>
#include <vector>

#include "skin/anatomy/anatomy.h"

namespace backbend::skin {

/// What the hints about the spine say, as nodes; -1 and empty where they say nothing.
struct HintedSpine {
  std::vector<int> chain;
  int hip = -1, chest = -1;
};

struct HintedArms {
  std::vector<int> left, right;
};

/// The node with that name: joints before other nodes, `#12` for the file's node 12, and names
/// whose namespaces differ only where no other fits. Throws CharacterError where there is none
/// (naming the nearest name) or where several share it.
int node_named(const Character& character, const std::string& name);

/// A name that node_named() takes for each node: its own, or `#12` where others share that.
std::vector<std::string> reference_names(const Character& character);
/// That of one node.
std::string reference_name(const Character& character, int node);

/// The way between two nodes of one tree, both included: up from `from`, then down to `to`. Empty
/// where they stand in different trees.
std::vector<int> path_between(const Character& character, int from, int to);

/// Throws CharacterError for an unknown name, a chain of one joint, or one whose joints do not hang
/// from each other, upwards or downwards, in the order given.
HintedSpine resolve_spine_hints(const Character& character, const AnatomyHints& hints);
HintedArms resolve_arm_hints(const Character& character, const AnatomyHints& hints);

}  // namespace backbend::skin
