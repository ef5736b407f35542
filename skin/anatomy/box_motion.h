#pragma once
#include <glm/vec3.hpp>

#include "solver/math/box_number.h"

namespace backbend::skin {

/// A rigid motion over a box of poses: p goes to posed_origin + turn (p - rest_origin).
struct BoxMotion {
  solver::BoxTurn turn;
  glm::dvec3 rest_origin{0.0};
  solver::BoxVector posed_origin;
};

}  // namespace backbend::skin
