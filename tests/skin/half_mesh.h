#pragma once
// Round solids, and what a surface is asked: the tests of every step from solids to a mesh.
#include <cstddef>
#include <vector>

#include "skin/body/body.h"
#include "skin/body/body_connectivity.h"
#include "skin/body/index.h"

namespace backbend::skin {

constexpr double kPi = 3.14159265358979323846;

/// Melts with nothing, holds no joint.
BodySolid ball(const glm::dvec3& center, double radius);
/// Those parts in one group, without a joint.
BodyDescription body_of(std::vector<BodySolid> parts);

/// A large ball that melts with a small one, wholly beside the mirror plane.
inline const glm::dvec3 kLarge(1.0, 0.1, -0.2), kSmall(1.33, 0.1, -0.2);
BodyDescription two_balls();

/// Both sides of x = 0 as one mesh: the half's vertices, then the images of those off the plane.
HalfMesh mirrored(const HalfMesh& half);

/// V - E + F; -1000 where an edge does not run exactly once each way.
long euler(const HalfMesh& mesh);

/// Above 0 where triangles are anticlockwise from outside.
double volume(const HalfMesh& mesh);

double smallest_angle_deg(const HalfMesh& mesh);

}  // namespace backbend::skin
