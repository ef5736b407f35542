#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace backbend::validate {

/// A character's mesh at rest, as the mesh metrics need it. All spans must outlive the call.
struct RestMesh {
  std::span<const glm::vec3> position;   // world space, one per vertex
  std::span<const glm::vec3> normal;     // unit, one per vertex
  std::span<const glm::uvec3> triangle;  // vertex indices
  std::span<const std::uint32_t> place;  // vertices at one place share a number; one per vertex
  std::uint32_t place_count = 0;
  std::span<const std::uint8_t> torso;  // 1: belongs to the torso; arms, legs, head do not
  std::span<const float> spine_share;   // 0..1: how much of a vertex the spine moves; empty: all
  std::span<const glm::dvec3> spine;    // rest joints hips .. chest, two or more
  std::span<const std::uint8_t> rigid = {};  // rigid_pieces(), one per vertex; empty: none
};

/// A smooth line along the spine's joints, from the first to the last and straight on beyond both.
/// Parameter: arc fraction of the joints' polyline, 0 hips .. 1 chest, the same as on the chain.
///
/// It is the polyline averaged over a fifth of its length, and so passes the joints in between at a
/// small distance: joints often zigzag more than the body around them, and planes square to a line
/// that zigzags would cut each other inside the body.
class SpineLine {
 public:
  explicit SpineLine(std::span<const glm::dvec3> joint);

  double length() const { return length_; }  // of the joints' polyline
  glm::dvec3 point(double s) const;
  glm::dvec3 tangent(double s) const;  // unit

  struct Foot {
    double s = 0.0;
    bool sure = true;  // false: so deep inside a bend that its place along the spine is not unique
  };
  /// Where along the line a point stands: the plane square to the line there holds it.
  Foot foot(const glm::dvec3& p) const;

 private:
  std::vector<glm::dvec3> point_, tangent_;  // samples
  std::vector<double> s_;
  double length_ = 0.0;
};

/// Where each place of the mesh stands along the spine. Places off the torso have NaN.
///
/// It is the foot on the spine line; where that is not unique (inside a strong bend at rest), the
/// harmonic field that fills the gap from its sure neighbours, which has no value beyond theirs.
std::vector<float> spine_coordinate(const RestMesh& mesh, const SpineLine& line);

}  // namespace backbend::validate
