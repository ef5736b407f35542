#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "skin/anatomy/anatomy.h"

namespace backbend::skin {

/// Something about a file that does not fit together, found before any pose.
struct ImportFact {
  std::string code;         // stable word: `body_size`, `body_place`, `body_axis`, `joint_outside`
  bool impossible = false;  // no rig of this file can be judged; else it is only doubtful
  std::string message;      // what was found, in numbers, and the likely cure
};

/// Whether body and skeleton of a character belong together: size, place and axes.
///
/// Each joint's share of the body is compared with its bone: over all joints the middles of the
/// vertices they move are fitted to the middles of their bones by a scale and a shift (least
/// squares, weighted by the vertices). A body of another unit than its skeleton has a scale far
/// from 1, one that stands beside it a shift, one with other axes no fit but after a quarter turn.
/// Nothing is said of fewer than three joints with weight, or where the joints lie in one place;
/// nor of the size where the joints of 80 % of the weight stand amid the vertices that they move.
/// Props (nodes_of_props()) do not count.
std::vector<ImportFact> check_import(const Character& character);

/// Throws CharacterError, one line with the cure, where check_import() finds the impossible.
void require_possible_import(const Character& character);

/// One joint whose inverse bind matrix does not fit those of the joints around it, in a character
/// as it was read.
struct JointBindOff {
  int node = -1;
  double angle_deg = 0.0;    // of the bind pose against where the joints around it put it
  double shift = 0.0;        // of its vertices, at most, in the file's unit
  std::uint32_t vertex = 0;  // that one
};

/// All of those, the largest shift first; see find_bind_off() for how they are told from a pose.
std::vector<JointBindOff> joints_bound_off(const Character& character);

}  // namespace backbend::skin
