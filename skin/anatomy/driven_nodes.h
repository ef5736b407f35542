#pragma once
#include <string>
#include <vector>

#include "skin/anatomy/anatomy.h"

namespace backbend::skin {

/// What our rigs do with one joint.
struct DrivenNode {
  enum class Kind {
    driven,   // a joint of the spine that the rig turns by itself
    follows,  // goes rigidly with `leader`
    rides,    // goes with a place between two spine joints: forelegs, fins
    still     // nothing moves it
  };
  int node = -1;
  Kind kind = Kind::still;
  int leader = -1;            // into Character::nodes; -1: none
  double torso_weight = 0.0;  // share of the torso's weight, 0..1, of a joint that keeps its place
                              // on its leader here and may move in the artist's own rig; else 0
};

/// One entry for each joint of the skin and each node of the spine, in the skeleton's order. Told
/// from how SpineDriver moves the nodes in a pose with every channel.
std::vector<DrivenNode> driven_nodes(const Character& character, const Anatomy& anatomy);

/// The same for a person, one joint a line with a summary first; and as one JSON object
/// (`"joints": [{"name", "motion": "driven" | "follows" | "rides" | "still", "leader",
/// "torso_weight"}]`).
std::string driven_text(const Character& character, const std::vector<DrivenNode>& nodes);
std::string driven_json(const Character& character, const std::vector<DrivenNode>& nodes);

}  // namespace backbend::skin
