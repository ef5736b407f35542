#pragma once
#include "skin/anatomy/anatomy.h"
#include "skin/body/body.h"

namespace backbend::skin {

/// A plain body around any skeleton: trunk, neck and head along its spine, limbs along its limbs,
/// fingers and toes along what hangs from hands and feet, as thick as the distances between hips,
/// shoulders and joints suggest. The skeleton's mesh is not looked at.
///
/// Joint k is node k of the skeleton. In the description's own space the body is +Y up, faces +Z,
/// and the largest extent of its spine and limbs is 1.75; BodyDescription::world_from_body leads
/// back.
BodyDescription describe_body(const Character& skeleton, const Anatomy& anatomy);

/// The skeleton with that body as its only mesh, bound where it stands at rest. Whole and closed,
/// four weights a vertex; not mirrored, for a skeleton need not be. Throws CharacterError where the
/// joints leave no room for a body.
Character make_proxy_body(const Character& skeleton, const Anatomy& anatomy,
                          const BodyOptions& options = {});

}  // namespace backbend::skin
