#pragma once
#include "validate/stage/stage.h"

namespace backbend::validate {

/// The longest bone of the spine up to the chest, as a share of that spine's length.
double longest_bone(const Stage& stage);

/// Vertices along each bone of the spine up to the chest: a bone's length over the usual edge's
/// that runs along the spine, of the surface that it moves. 0 for a torso without such edges.
double rows_per_bone(const Stage& stage);

/// Whether no triangle of the mesh reaches from what hangs below a joint of the spine, up to the
/// chest, to what hangs from it and above: a robot's or a doll's torso of pieces, each on its own
/// joint. Joints without weight, and those above one, are not asked. Nor does it where no connected
/// piece of the surface reaches along 0.6 of the spine up to the chest: plates over each other.
bool torso_in_pieces(const Stage& stage);

}  // namespace backbend::validate
