#pragma once
#include <glm/vec3.hpp>
#include <vector>

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

 private:
  glm::dvec3 point(double u) const;
  glm::dvec3 derivative(double u) const;
  glm::dvec3 second(double u) const;
  double parameter(double arc) const;

  std::vector<double> knot_;                // chord-length parameter of each point
  std::vector<glm::dvec3> point_, moment_;  // values and second derivatives at the knots
  std::vector<double> sample_, arc_;        // parameter and arc length of a fine table
  std::vector<glm::dvec3> place_;           // curve points of that table
  double longest_ = 0.0;                    // distance between two of them
};

/// Cubic spline of one number: a section's size along a loft. Constant beyond its ends, which it
/// reaches level, so that its slope never jumps.
class BodyProfile {
 public:
  BodyProfile() = default;
  /// Needs one or more places, rising.
  BodyProfile(std::vector<double> at, std::vector<double> value);
  /// Value and slope.
  double operator()(double at, double* slope) const;

 private:
  std::vector<double> at_, value_, moment_;
};

}  // namespace backbend::skin
