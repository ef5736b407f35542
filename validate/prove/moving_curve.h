#pragma once
#include <array>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "validate/prove/moving_pose.h"

namespace backbend::validate {

/// A curve of cubic pieces over a part of a box of poses: its parameter goes by 1 in each. For
/// checkers, written apart from the solver's curves.
class MovingCurve {
 public:
  /// The clamped uniform cubic B-spline, from the steps between its points, three or more (of
  /// three: the Bezier curve). Its lengths are enclosed on `panels` of each piece, the tighter the
  /// more. Past its end it goes straight on.
  MovingCurve(const std::vector<MovingVector>& step, const Reach& reach, int panels);

  /// Its length. Not finite where it could not be enclosed.
  const MovingNumber& length() const { return length_; }

  struct Place {
    MovingNumber u;
    /// How fast it slides along the curve with each channel, by length.
    std::array<solver::Interval, 3> slides{};
  };
  Place start() const { return {MovingNumber(solver::Interval(0.0)), {}}; }
  Place end() const { return {MovingNumber(solver::Interval(end_)), {}}; }
  /// The place at a length from the start; nothing where it could not be enclosed.
  std::optional<Place> place_at(const MovingNumber& length) const;
  /// The place that `part` of `parts` equal parts of the length come to.
  std::optional<Place> share(int part, int parts) const;
  /// The first place behind another that is a bone's length away from it; nothing where it could
  /// not be enclosed. `axes`: the first about along the bone.
  std::optional<Place> step(const Place& from, const MovingNumber& bone,
                            const glm::dmat3& axes) const;
  /// From one place to a later one, on these axes.
  MovingVector way(const Place& from, const Place& to, const glm::dmat3& axes) const;
  /// The same, with the place `to` known to be `arc` of the curve's length behind `from`.
  MovingVector way(const Place& from, const Place& to, const MovingNumber& arc,
                   const glm::dmat3& axes) const;
  /// About the same at the part's middle.
  glm::dvec3 way_about(const Place& from, const Place& to) const;
  /// The curve's derivative by its parameter at a place, on these axes; about that at the middle.
  MovingVector velocity(const Place& place, const glm::dmat3& axes) const;
  glm::dvec3 velocity_about(const Place& place) const;

 private:
  using Interval = solver::Interval;
  /// A velocity as a quadratic Bezier curve.
  using Piece = std::array<MovingVector, 3>;

  /// Velocities, and how they change with the parameter: of values, centers or one channel's
  /// derivatives.
  template <class Part>
  static Vec at(const Piece& piece, const Interval& t, const Part& part);
  template <class Part>
  static Vec change_at(const Piece& piece, const Interval& t, const Part& part);
  /// Over a u that holds the joint of two pieces, of both.
  template <class Of>
  Vec over(const Interval& u, const Of& of) const;
  template <class Part>
  Vec at(const Interval& u, const Part& part) const {
    return over(u, [&](const Piece& piece, const Interval& t) { return at(piece, t, part); });
  }
  /// Of velocities between two places.
  template <class Part>
  Vec integral(const Interval& from, const Interval& to, const Part& part) const;

  MovingNumber length_of(const Piece& piece, double from, double to, int depth) const;
  MovingNumber length_between(double from, double to) const;
  double last_piece() const { return static_cast<double>(piece_.size() - 1); }
  bool turns_far(const Interval& u) const;

  std::vector<Piece> piece_;  // the last goes straight on
  double end_;
  Reach reach_;
  int panels_;
  std::vector<MovingNumber> panel_;  // their lengths
  MovingNumber length_;
};

}  // namespace backbend::validate
