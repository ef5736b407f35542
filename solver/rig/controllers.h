#pragma once
#include <array>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "solver/rig/spine_system.h"

namespace backbend::solver {

/// The picture of one controller: straight lines in rig space, for x-ray renders. Controllers are
/// drawn only there; no other picture knows of them.
struct ControllerShape {
  std::string name;  // of the control: `top`, `hip`
  int color = 0;     // 0, 1, 2: one colour each for what is low, middle and high
  std::vector<std::array<glm::dvec3, 2>> line;
};

/// The controllers of a rig in a pose: square outlines across the bone with an arrow forward.
///
/// Where the rig has the three traditional controls, one square per bone of the drawn chain, its
/// edge as long as the bone (the thesis's controllers). Else one at the hip and one at the chest,
/// their edge a third of the spine; the neck and the snake get one at each end and one at every
/// eighth joint. `chain` and `control` are what the system was built on and solved for.
std::vector<ControllerShape> controller_shapes(const SpineSystem& system, const RestChain& chain,
                                               std::span<const double> control);

}  // namespace backbend::solver
