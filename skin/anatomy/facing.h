#pragma once
#include <array>
#include <string>
#include <string_view>

#include "skin/anatomy/anatomy.h"
#include "skin/anatomy/skeleton_shape.h"

namespace backbend::skin {

constexpr std::array<std::string_view, 6> kAxisNames = {"+X", "-X", "+Y", "-Y", "+Z", "-Z"};

/// `-Z` for a unit vector along an axis of the world; "" for an oblique one.
std::string axis_name(const glm::dvec3& direction);

/// Sets up, left and forward of an anatomy whose spine and limbs stand already, and says why.
///
/// Up: away from the feet; +Y (the standard's) without legs. Left: by names, else by forward.
/// Forward: by left, else where the soles lie before the ankles or the head of a level body before
/// the hips, else +Z (the standard's). Directions within 30 degrees of a world axis are that axis.
/// Others count only where legs and back agree on up, and all named pairs on left; else the
/// standard's up and the nearest axis do. An up that is not the standard's is doubtful, and so are
/// pairs that point different ways: there what a person confirmed counts. AnatomyHints::up and
/// forward count always; what was found stands beside them in the anatomy. Throws CharacterError
/// for a name that is not an axis, and for a forward that is along up.
void find_facing(const Character& character, const SkeletonShape& shape, const AnatomyHints& hints,
                 Anatomy& anatomy);

}  // namespace backbend::skin
