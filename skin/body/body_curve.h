#pragma once
#include <array>
#include <glm/vec3.hpp>
#include <vector>

#include "skin/body/body_lanes.h"

namespace backbend::skin {

/// Natural cubic spline through points, by arc length: the axis of a limb.
///
/// Two points make a straight line. Beyond its ends the curve goes on straight.
class BodyCurve {
 public:
  BodyCurve() = default;
  /// Needs two or more points, neighbours apart.
  explicit BodyCurve(const std::vector<glm::dvec3>& points);

  double length() const { return arc_.back(); }
  glm::dvec3 at(double arc) const;
  /// Unit tangent.
  glm::dvec3 tangent(double arc) const;
  /// The curve point nearest to a place.
  struct Foot {
    double arc = 0.0;  // below 0 or above length() beyond the ends
    glm::dvec3 at{0.0}, tangent{0.0};
  };
  Foot nearest(const glm::dvec3& p) const;
  /// The same for four places at once: in each lane the bits of one alone.
  struct Feet {
    Lanes arc;
    LaneVector at, tangent;
  };
  Feet feet(const LaneVector& p) const;

 private:
  /// The curve at a parameter; beyond the ends it goes on straight.
  struct Local {
    LaneVector point, derivative, second;
  };
  Local local(Lanes u) const;
  glm::dvec3 point(double u) const;
  glm::dvec3 derivative(double u) const;
  double parameter(double arc) const;
  Lanes nearest_in_table(const LaneVector& p) const;

  /// What the curve is made of between two knots.
  struct Piece {
    double h;
    glm::dvec3 from, to, moment_from, moment_to, chord;
  };
  struct Edge {
    glm::dvec3 from, along;
    double length2;
  };
  struct Ball {
    glm::dvec3 center;
    double radius;
  };
  static constexpr std::size_t kBlock = 8;  // edges within one ball

  std::vector<double> knot_;                // chord-length parameter of each point
  std::vector<glm::dvec3> point_, moment_;  // values and second derivatives at the knots
  std::vector<Piece> piece_;                // between those
  std::vector<double> sample_, arc_;        // parameter and arc length of a fine table
  std::vector<Edge> edge_;                  // between curve points of that table
  std::vector<Ball> ball_;                  // around each kBlock of them
};

/// Cubic spline of one number: a section's size along a loft. Constant beyond its ends, which it
/// reaches level, so that its slope never jumps.
class BodyProfile {
 public:
  BodyProfile() = default;
  /// Needs one or more places, rising.
  BodyProfile(std::vector<double> at, const std::vector<double>& value);
  /// Value and slope.
  double operator()(double at, double* slope) const;
  /// Those of `yes` in the lanes that `which` holds for, of `no` in the others. Both have the same
  /// places.
  static Lanes choose(Lanes::Mask which, const BodyProfile& yes, const BodyProfile& no, Lanes at,
                      Lanes* slope);

 private:
  std::vector<double> at_;
  std::vector<std::array<double, 4>> piece_;  // both values and both moments of each interval
};

}  // namespace backbend::skin
