#pragma once
#include <glm/vec3.hpp>

namespace backbend::validate {

inline const glm::dvec3 kX(1, 0, 0), kY(0, 1, 0), kZ(0, 0, 1);

}  // namespace backbend::validate
