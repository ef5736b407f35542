#pragma once
#include <vector>

#include "skin/anatomy.h"

namespace backbend::skin {

/// What the hints about the spine say, as nodes; -1 and empty where they say nothing.
struct HintedSpine {
  std::vector<int> chain;
  int hip = -1, chest = -1;
};

struct HintedArms {
  std::vector<int> left, right;
};

/// The node with that name. Throws CharacterError where there is none (naming the nearest name) or
/// where several share it.
int node_named(const Character& character, const std::string& name);

/// Throws CharacterError for an unknown name, a chain of one joint, or one whose joints do not hang
/// from each other in the order given.
HintedSpine resolve_spine_hints(const Character& character, const AnatomyHints& hints);
HintedArms resolve_arm_hints(const Character& character, const AnatomyHints& hints);

}  // namespace backbend::skin
