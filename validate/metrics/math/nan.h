#pragma once
#include <glm/vec3.hpp>
#include <limits>

namespace backbend::validate {

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();  // not measured
inline constexpr glm::dvec3 kNowhere(kNan);

}  // namespace backbend::validate
