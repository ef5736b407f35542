#pragma once
#include <array>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "validate/prove/moving.h"
#include "validate/prove/proof_box.h"

namespace backbend::validate {

struct ProofQuestion;

/// The channels of a part of a box of body channels, radians: extension, side, twist.
struct MovingChannels {
  explicit MovingChannels(const SubBox& part);

  /// What a chest control gets, of all or a part, without its twist: angles about its X, Y and Z.
  std::array<MovingNumber, 3> chest_swing(double part) const;

  std::array<MovingNumber, 3> angle;
  Reach reach;
};

/// Which channels of a box of body channels vary.
std::array<bool, 3> varying_channels(const ProofBox& box);

/// X along the bone, Y forward, Z to the left as far as it is across the bone: a control's axes at
/// rest. Throws ProofError where `left` lies along the bone.
glm::dmat3 axes_of(const glm::dvec3& bone, const glm::dvec3& left);

Vec fixed(const glm::dvec3& v);
/// What has these coordinates on the axes, and the coordinates of what is there.
MovingVector from_axes(const glm::dmat3& axes, const MovingVector& v);
MovingVector on_axes(const glm::dmat3& axes, const MovingVector& v);
Vec on_axes(const glm::dmat3& axes, const Vec& v);

/// Turned about coordinate axis 0, 1 or 2.
MovingVector turned(const MovingVector& v, std::size_t axis, const MovingNumber& angle);

/// Turned by Euler angles about X, then Y, then Z of these axes.
MovingVector turned(const glm::dmat3& axes, const std::array<MovingNumber, 3>& euler,
                    const MovingVector& v);

/// The three bones of a chain (its own, or the thirds of its length) under their controls: Top
/// turns the last bone and, under spread, Middle the last two, by half each.
class MovingSpine {
 public:
  explicit MovingSpine(const ProofQuestion& question);

  bool spread() const { return spread_; }
  const glm::dmat3& axes(std::size_t bone) const { return axes_[bone]; }
  std::array<MovingVector, 3> bones(const MovingChannels& channels) const;
  /// How far each is from what it is at rest.
  std::array<MovingVector, 3> moves(const MovingChannels& channels) const;

 private:
  bool spread_;
  std::array<glm::dmat3, 3> axes_;
  std::array<Vec, 3> rest_;
};

/// The legs of a Bezier curve from hips to chest, whose handles lie on the controls' X axes,
/// `depth` of the distance at rest long.
class HipChestLegs {
 public:
  HipChestLegs(const ProofQuestion& question, const std::vector<double>& depth);

  bool spread() const { return spine_.spread(); }
  /// The controls' at rest.
  const glm::dmat3& axes() const { return axes_; }
  /// The curve's at rest.
  double length() const { return length_; }
  std::vector<MovingVector> over(const MovingChannels& channels) const;

 private:
  MovingSpine spine_;
  glm::dmat3 axes_;
  double length_;
  std::vector<double> depth_;
};

/// Of length 1; on axes of which the first is about along the vector.
MovingVector unit(const MovingVector& v);

/// Axes of which the first points along `x` and the others are as near to `like`'s as they can be.
///
/// A bone's vectors are enclosed on axes of its own: what is known well about it, and what is known
/// less along it, so stays apart. On the axes of space both would grow from bone to bone (the
/// wrapping effect).
glm::dmat3 axes_along(const glm::dvec3& x, const glm::dmat3& like);

/// A frame that is carried from bone to bone by the shortest arc.
///
/// About the bone it turns as far as the arcs roll it: from a to b, unit vectors, by
/// (b x a) . (a' + b') / (1 + a . b), for the arc is a half turn about a and then one about a + b.
/// Across the bone it turns as the bone does.
class MovingFrame {
 public:
  MovingFrame(const glm::dvec3& axis, const Reach& reach) : bone_(fixed(axis)), reach_(reach) {}

  /// On to a bone of any length, given on `axes`. False where it may be opposite to the last.
  bool go(const glm::dmat3& axes, const MovingVector& bone);
  /// The last bone's unit vector, on its axes.
  const MovingVector& bone() const { return bone_; }
  /// How fast the frame turns with a channel, rolled about its bone by so much more.
  solver::Interval rate(std::size_t channel, const solver::Interval& more) const;
  /// The most of that over the channels that vary; infinite where it could not be enclosed.
  double fastest(const std::array<bool, 3>& varies,
                 const std::array<solver::Interval, 3>& more = {}) const;

 private:
  glm::dmat3 axes_{1.0};
  MovingVector bone_;  // unit, on `axes_`
  Reach reach_;
  std::array<solver::Interval, 3> roll_{};
};

}  // namespace backbend::validate
