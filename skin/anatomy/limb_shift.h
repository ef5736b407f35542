#pragma once
#include <optional>

#include "skin/anatomy/anatomy.h"

namespace backbend::skin {

/// A shift that takes the bones of all limbs to the middles of what they move.
struct LimbShift {
  glm::dvec3 shift{0.0};  // world space, file units
  // Where the bones lie in what they move, along the shift: 0 in its middle, 1 on its surface, the
  // median of the limbs' bones by their length. Not the weighted middle: a wing's or a sleeve's
  // lies far from the bone that it encloses.
  double beside = 0.0;
  int node = -1;  // the joint of the bone that lies farthest beside
};

/// The shift between a character's limbs and their bones at rest, by least squares over the bones'
/// distances from the middles of what they move (across each bone, by its length). Bones shorter
/// than 0.06 of the height count for nothing, nor do those that lead at fewer than six places, or
/// across which the shift hardly goes.
/// Nullopt where the bones do not agree on one shift, or lie in too few directions to tell one, or
/// where those along the shift have what they move around their own middles (legs below a shoulder
/// that lies low in its flesh).
std::optional<LimbShift> find_limb_shift(const Character& character, const Anatomy& anatomy);

}  // namespace backbend::skin
