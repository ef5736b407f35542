#pragma once
#include <array>
#include <glm/vec3.hpp>
#include <span>

#include "solver/math/inline_vector.h"

namespace backbend::solver {

/// One cubic piece of a curve by its Bezier points, and the parameter range that it covers.
struct CubicPiece {
  std::array<glm::dvec3, 4> cv;
  double u0, u1;

  glm::dvec3 point(double t) const;              // t = 0..1 along the piece
  glm::dvec3 derivative(double t) const;         // d point / d t
  glm::dvec3 second_derivative(double t) const;  // d2 point / d t2
  /// The control polygon's length, each side by the sum of its coordinates: what "vanishes" is
  /// measured against.
  double size() const;
};

/// Arc length along a part of a cubic piece, as a function of x = -1..1 over the part.
///
/// The speed is the root of a quartic in x. It is sampled at the 16 Gauss points, expanded in
/// Legendre polynomials and integrated term by term; the series' tail tells whether the part was
/// short enough. In powers of x the sum keeps its digits, because an accepted series falls faster
/// than the powers' coefficients grow.
struct ArcPart {
  static constexpr int kTerms = 8;

  int piece;
  double t0, t1;                        // of the piece
  double start;                         // arc length of the curve before this part
  double length;                        // of this part
  double at_zero;                       // arc length at x = 0, from the part's start
  std::array<double, kTerms> odd;       // by x, x^3, ..
  std::array<double, kTerms> even;      // by x^2, x^4, ..
  std::array<double, 5> speed_squared;  // by powers of x; speed is d arc / d x
  double first_slope, last_slope;       // dx / d arc at the ends, capped to keep a guess monotone

  /// Arc length from the part's start to x.
  double arc(double x) const;
  double t(double x) const { return 0.5 * ((t0 + t1) + (t1 - t0) * x); }
  double x(double t) const { return (2.0 * t - (t0 + t1)) / (t1 - t0); }
};

using ArcTable = InlineVector<ArcPart, 8>;

/// The parts that a curve's pieces need, in order; returns the curve's length. Good to 1e-12 of it
/// for smooth curves and 1e-9 through cusps.
double measure_pieces(std::span<const CubicPiece> pieces, ArcTable& table);

/// x on a part for an arc length from its start; clamped to the part.
double invert(const ArcPart& part, double goal);
/// Four at once; each result has the bits of invert() alone.
void invert_four(const std::array<const ArcPart*, 4>& part, const std::array<double, 4>& goal,
                 std::array<double, 4>& x);

}  // namespace backbend::solver
