#pragma once
#include <glm/mat4x4.hpp>
#include <optional>
#include <vector>

#include "skin/character/character.h"

namespace backbend::skin {

/// The box that a body fills: what a difference between two motions is measured on.
struct BodyBox {
  glm::dvec3 low{0.0}, high{0.0};
  double size() const;  // its largest side
};

/// Motions that carry no point of a box further apart than this share of its size agree: the
/// rounding of stored matrices is far below, and an angle of 0.3 degrees at a limb's root above.
constexpr double kMotionsAgree = 0.002;

/// World from mesh as a joint of the character makes it at rest.
glm::dmat4 rest_motion(const Character& character, std::size_t joint);

/// How far two motions carry one point of a box apart at most.
double apart(const glm::dmat4& a, const glm::dmat4& b, const BodyBox& box);

/// A joint whose bind pose does not fit the joints around it.
struct BindOff {
  int node = -1;
  double angle_deg = 0.0;  // between where its bind matrix and where the others put it
  /// World from mesh as the joints around it have it.
  glm::dmat4 agreed{1.0};
};

/// One joint of a skin with the motion that its node and bind matrix make of the mesh.
struct BoundJoint {
  int node = -1;
  glm::dmat4 world_from_mesh{1.0};  // finite
};

/// The joints of one skin that were bound wrongly.
///
/// A skin may be bound in another pose than its nodes stand in: then every joint is turned about
/// its own origin, and what hangs from it comes along. So a joint is off where it stands apart from
/// the joint above it while what hangs from it agrees with that one again; and a last joint where
/// it is the only one of the skin that stands apart, at another place. One that carries all that
/// hangs from it, two joints or more, to where it stands is turned, not bound wrongly. `box` is in
/// the mesh's space. Differences below kMotionsAgree are none.
std::vector<BindOff> find_bind_off(const std::vector<Node>& nodes,
                                   const std::vector<BoundJoint>& joints, const BodyBox& box);

}  // namespace backbend::skin
