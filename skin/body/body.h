#pragma once
#include <functional>

#include "skin/body/body_description.h"
#include "skin/character/character.h"

namespace backbend::skin {

struct BodyOptions {
  int vertices = 0;  // wanted, reached within a few per cent; 0: what the description says
  // Called between the steps of the work, from any thread; what it throws ends the work.
  std::function<void()> poll = [] {};
};

/// Builds a body: one closed, manifold, mirror-symmetric mesh around the description's skeleton,
/// with at most four weights a vertex. The same bytes for the same description and options, for any
/// number of threads.
///
/// The surface is the zero set of smoothly joined solids (body_shape.h), found on a grid
/// (body_grid.h), made even (body_remesh.h), and mirrored; weights follow the joints that each
/// solid names and are diffused over the surface (body_weights.h).
///
/// Throws CharacterError where the solids do not make one closed surface.
Character make_body(const BodyDescription& description, const BodyOptions& options = {});

}  // namespace backbend::skin
