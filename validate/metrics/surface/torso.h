#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "skin/character/character.h"

namespace backbend::validate {

/// Which vertices may be part of a slice of the torso: all but those that arms, head, tail, or legs
/// that stand across the spine, move by more than half. One byte a vertex, 0 or 1.
///
/// An arm begins after its clavicle, if it has one. Shoulder blades, hips and the tops of legs that
/// run on from the spine stay in, whichever joint moves them most: without them the rings of chest
/// and pelvis would gape. Such legs further down form rings of their own, which do not go round the
/// spine and so are never part of a slice; an animal's legs would be cut lengthwise, and are out.
/// So are connected pieces that such limbs move as a whole, a shoulder pad. `rest_position`: the
/// mesh at rest, world space, one per vertex.
std::vector<std::uint8_t> torso_mask(const skin::Character& character, const skin::Anatomy& anatomy,
                                     std::span<const glm::vec3> rest_position);

/// How much of each vertex the spine moves: one minus the weights of arms (clavicles included) and
/// legs. One entry a vertex, 0..1.
std::vector<float> spine_shares(const skin::Character& character, const skin::Anatomy& anatomy);

}  // namespace backbend::validate
