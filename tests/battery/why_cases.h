#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "validate/calibrate/draw.h"
#include "validate/why/why.h"

namespace backbend::battery {

/// Two versions of a body, and which ingredients of the later one were spoiled; others differ, too,
/// and do no harm.
struct WhyCase {
  validate::Version before, after;
  validate::IngredientSet spoiled = 0;
  std::string what;  // `weights: half torso one up; hidden: vertices in another order`
  // The earlier version with one of the spoiled ingredients, for each.
  std::vector<std::pair<validate::Ingredient, validate::Version>> alone;
};

/// Spoils one ingredient, or two where `two`, of a welded() body, and hides it among harmless
/// changes: the vertices' order, vertices split or merged, the space that the mesh is stored in,
/// weights within rounding. Nullopt where the body has no place for what was drawn.
std::optional<WhyCase> draw_why_case(const skin::Character& sound, const skin::AnatomyHints& hints,
                                     bool two, validate::Draw& draw);

}  // namespace backbend::battery
