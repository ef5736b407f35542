#pragma once
#include <optional>
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "skin/character/character.h"

namespace backbend::validate {

/// The character's weights with those of the spine made clean: what a vertex of the torso holds on
/// driven spine joints goes to the two joints that it stands between, in the proportion of its
/// distance from them along the spine. A joint that stands in a spine joint's place and goes with
/// it is that joint. Shares of arms, legs and head stay as they were, and so does every vertex off
/// the torso and every rigid prop that stands off the body: no painter would bend a pack.
///
/// `rest_position`: the mesh at rest, world space, one per vertex. Nothing where a driven spine
/// joint, or what stands in its place, moves no skin, so that the proportion cannot be given to it.
std::optional<std::vector<skin::Influences>> proxy_weights(const skin::Character& character,
                                                           const skin::Anatomy& anatomy,
                                                           const skin::SpineDriver& driver,
                                                           const skin::PosedMesh& rest);

}  // namespace backbend::validate
