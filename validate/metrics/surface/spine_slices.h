#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "validate/metrics/surface/spine_coordinate.h"

namespace backbend::validate {

/// One point of a slice: on the edge between two vertices, fixed in the material.
struct SlicePoint {
  std::uint32_t a = 0, b = 0;  // vertices
  float share = 0.0f;          // 0 at a, 1 at b
};

/// A point of a ring between its points `from` and `from + 1` (the last joins the first).
struct LinePoint {
  std::uint32_t from = 0;
  float share = 0.0f;
  bool surface = true;     // false: on a straight line across a gap
  glm::dvec3 offset{0.0};  // from the ring's centre at rest
};
constexpr int kLineCount = 16;

/// Slices of which the spine moves less than this share give no measure of the spine's bend.
constexpr double kSpineSlice = 0.25;

/// A ring of the torso's surface that stood at one place along the spine at rest.
///
/// Its points go round counter-clockwise as seen from the chest. Where the arms (or other parts
/// that are not torso) have been taken off, the ring is closed by a straight line.
///
/// Centre and direction count each point by how much the spine moves it: what arms and legs carry
/// says nothing about the spine. The area is that of the whole ring.
struct Slice {
  double s = 0.0;            // arc fraction, 0 hips .. 1 chest
  double spine_share = 1.0;  // of the ring; below kSpineSlice it is no measure of the spine's bend
  std::vector<SlicePoint> ring;  // empty: the torso has no ring there
  // How far the spine stands outside the surface, in radii of a disc of the cross-section's area; 0
  // inside, NaN where no ring is near.
  double outside = std::numeric_limits<double>::quiet_NaN();
  double beside_radius = 0.0;  // that radius, where the spine stands outside; 0 elsewhere
  // Whether another ring of like size stands beside it: halves that were mirrored, not joined.
  bool is_half = false;
  std::vector<double> weight;  // of each point in the centre, by length at rest and share; sum 1
  std::vector<double> cosine;  // weight times the cosine of the point's angle from `left`
  // Where the ring crosses kLineCount half-planes around the spine at rest, the first toward
  // `left`: points of material lines along the torso. Empty where the ring is.
  std::vector<LinePoint> line;
};

/// Slices to either side of one that its direction along the torso is taken over.
constexpr int kDirectionReach = 3;

/// Slices of a torso, evenly spaced along the spine.
struct SpineSlices {
  std::vector<Slice> slice;
  double spacing = 0.0;          // between neighbours, arc fraction
  double spine_length = 0.0;     // of the rest chain
  std::size_t measured() const;  // slices with a ring
};

/// Cuts `count` slices between two arc fractions of a torso. `left` (any direction not along the
/// spine) is where each slice's own direction points at rest. A slice is the outermost ring around
/// the spine: of the closed rings, and of the open pieces together, that go round the line, the one
/// with the largest area. RestMesh::rigid ones are taken only where no other goes round. Where none
/// does, the spine stands outside the body: by Slice::outside from the largest closed ring that the
/// spine moves, if one is within three of its radii; within a quarter of one that ring is the
/// slice.
SpineSlices cut_slices(const RestMesh& mesh, const SpineLine& line,
                       std::span<const float> coordinate, const glm::dvec3& left, int count,
                       double from = 0.05, double to = 0.95);

/// Where the slices are in a pose. One entry per slice; NaN for those without a ring.
struct SlicePose {
  std::vector<glm::dvec3> centre;
  std::vector<glm::dvec3> area;       // vector area: normal times area, toward the chest at rest
  std::vector<glm::dvec3> direction;  // unit, square to the area: the material's `left`
  std::vector<glm::dvec3> line;       // kLineCount points a slice
};
SlicePose pose_slices(const SpineSlices& slices, std::span<const glm::vec3> position);

}  // namespace backbend::validate
