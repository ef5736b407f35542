#pragma once
#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "solver/math/arc_lanes.h"
#include "solver/math/arc_length.h"
#include "solver/math/inline_vector.h"

namespace backbend::solver {

struct BoxVector;

/// Where a curve is at one place: `overrun` is how far past the end (> 0) or before the start (< 0)
/// the place lies on the straight continuation along the end tangent.
struct CurvePoint {
  glm::dvec3 position{0.0};
  glm::dvec3 tangent{0.0};  // unit
  double u = 0.0;           // parameter, 0..1; clamped where the place is past an end
  double overrun = 0.0;
};

/// How the knots of an interpolating curve are spaced: by distance, evenly, by the root of
/// distance.
enum class KnotRule { chord, uniform, centripetal };

/// Knots for points in order: from 0, one each, increasing. Throws RigError where two neighbouring
/// points coincide (any rule) or fewer than two are given.
std::vector<double> make_knots(std::span<const glm::dvec3> point, KnotRule rule);

/// A curve of cubic pieces, parameter 0..1, that knows its arc length. A value: immutable, free of
/// any space or unit but its points'.
///
/// Arc length is good to 1e-12 of the whole for smooth curves and 1e-9 through cusps (ArcPart).
///
/// Every curve is scaled bit for bit with its points by powers of two.
class Curve {
 public:
  /// One cubic Bezier segment.
  static Curve bezier(const std::array<glm::dvec3, 4>& cv);
  /// Clamped uniform cubic B-spline; two or three CVs give a line or a parabola. The parameter is
  /// the knot parameter over its range. Needs cv.size() >= 2.
  static Curve bspline(std::span<const glm::dvec3> cv);
  /// Natural cubic spline through every point at its knot: second derivative zero at both ends.
  /// The parameter is the knot over its range. Needs >= 2 points and as many increasing knots.
  static Curve interpolating(std::span<const glm::dvec3> point, std::span<const double> knot);
  /// Straight from point to point; the parameter is the point's index over its range.
  static Curve polyline(std::span<const glm::dvec3> point);

  glm::dvec3 point(double u) const;              // u is clamped to 0..1
  glm::dvec3 derivative(double u) const;         // d point / d u
  glm::dvec3 second_derivative(double u) const;  // one-sided (to the right) at a joint of pieces
  /// Unit tangent. Where the derivative vanishes, the direction in which the curve leaves the
  /// place (arrives, at u = 1); zero only if the whole curve is one point.
  glm::dvec3 tangent(double u) const;

  double length() const { return length_; }
  /// Arc length from the start to `u`.
  double arc_at(double u) const;
  /// The place at arc length `s` from the start; straight along the end tangents outside 0..length.
  CurvePoint at_arc(double s) const;
  CurvePoint at_fraction(double fraction) const { return at_arc(fraction * length_); }
  /// at_arc().position for each of `s`, bit for bit, but faster than one by one.
  void points_at_arcs(std::span<const double> s, std::span<glm::dvec3> out) const;

  /// The first place at or after arc length `from_arc` that is `distance` from `centre`, on the
  /// curve or on its continuation past the end; `arc` is its arc length, past length() on the
  /// continuation. Bones that are walked along a curve meet it here.
  ///
  /// Needs distance >= 0 and `centre` no farther than that from the place at `from_arc`. A curve
  /// that is one point has no continuation: its end is returned.
  struct Step {
    CurvePoint place;
    double arc = 0.0;
  };
  Step step_to_distance(const glm::dvec3& centre, double from_arc, double distance) const;

  /// The parameter of the point of the curve nearest to `p`. Of several equally near, the smallest.
  double closest_parameter(const glm::dvec3& p) const;

  /// The cubic pieces in order; their parameter ranges join to 0..1.
  std::span<const CubicPiece> pieces() const { return piece_.all(); }

 private:
  friend class CurveMap;
  struct Local {
    int piece;
    double t;
  };

  Curve() = default;
  CubicPiece& add_piece(double u0, double u1);
  void measure();
  Local locate(double u) const;
  Step step_past_end(const glm::dvec3& centre, double distance) const;
  const ArcPart& part_at(double s) const;
  Local invert(double s) const;
  double to_u(const Local& at) const;
  glm::dvec3 tangent_at(const Local& at) const;

  InlineVector<CubicPiece, 4> piece_;
  ArcTable arc_;
  double length_ = 0.0;
};

/// Curves of one kind through a fixed number of points, drawn again and again: every kind of curve
/// here is linear in its points, so its pieces' Bezier points are weighted sums of them.
class CurveMap {
 public:
  enum class Kind { bspline, interpolating, polyline };
  /// `knot` is for interpolating curves, one for each of the points.
  CurveMap(Kind kind, std::size_t point_count, std::span<const double> knot = {});

  /// The curve of point_count() points.
  Curve draw(std::span<const glm::dvec3> point) const;
  /// Its pieces over a box of poses.
  std::vector<std::array<BoxVector, 4>> draw(std::span<const BoxVector> point) const;
  /// The legs of its pieces' polygons over a box of poses, from the steps between the points:
  /// point_count() - 1 of them.
  std::vector<std::array<BoxVector, 3>> legs(std::span<const BoxVector> step) const;
  /// The pieces of four curves side by side; `piece` holds piece_count() of them.
  void draw(std::span<const LaneVector> point, std::span<ArcLanes::Piece> piece) const;
  std::size_t point_count() const { return point_count_; }
  std::size_t piece_count() const { return range_.size(); }

 private:
  struct Range {
    double u0, u1;
  };
  std::size_t point_count_;
  std::vector<Range> range_;    // of each piece
  std::vector<double> weight_;  // [piece][Bezier point][point]
};

/// `count` >= 2 points at equal arc steps, both ends included.
std::vector<glm::dvec3> equal_arc_points(const Curve& curve, std::size_t count);

}  // namespace backbend::solver
