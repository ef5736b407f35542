#pragma once
#include <glm/vec3.hpp>
#include <span>

namespace backbend::validate {

/// The share of `b`'s points that have one of `a`'s near: within a two-hundredth of the height,
/// both clouds moved to the middle of their bounds and scaled to one height (y up), so that neither
/// unit nor the order or names of anything matters. NaN where either is empty or has no height.
double surface_match(std::span<const glm::vec3> a, std::span<const glm::vec3> b);

}  // namespace backbend::validate
