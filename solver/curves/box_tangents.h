#pragma once
#include <array>
#include <optional>
#include <vector>

#include "solver/curves/box_curve.h"
#include "solver/math/box_number.h"

namespace backbend::solver {

/// The unit tangent of a curve of cubic Bezier pieces, asked by arc length, over a box of poses of
/// any size.
///
/// Each piece is cut into panels, and on each the tangent and what moves it are enclosed. No place
/// is solved for: it is on one of the panels that may hold it, and what is said of it holds on all
/// of them. So widths grow gently with the box, where Newton's operator stops at a size.
class BoxTangents {
 public:
  /// The three legs of a piece's Bezier polygon. Taken from the curve's points, these would be as
  /// wide as all that lies between the curve's start and the piece.
  using Legs = std::array<BoxVector, 3>;

  /// Pieces in order, which have the same direction where they meet. Not finite where the speed may
  /// vanish.
  BoxTangents(const std::vector<Legs>& piece, int panels);

  bool is_finite() const { return finite_; }
  const BoxReal& length() const { return length_; }
  /// Variables that turn no tangent: the curve keeps its shape.
  std::array<bool, kBoxVariables> still() const;

  /// The mean of the tangent over the arc between two shares of the length, 0 to 1: the chord
  /// between them over its arc's length.
  BoxStep mean_between(double from, double to) const;

  /// The tangent, and d tangent / d arc length, at any pose and anywhere between two arc lengths,
  /// past the end included. Need is_finite().
  IntervalVector tangent_over(const Interval& arc) const;
  IntervalVector bend_over(const Interval& arc) const;
  /// The most that the curve bends anywhere, radians per length.
  double most_bend() const { return most_bend_; }

  /// A joint of a chain that is walked along the curve and its straight continuation past the end.
  struct Joint {
    Interval arc;           // from the curve's start
    BoxSlopes slope{};      // of the arc
    IntervalVector turned;  // its tangent less that of the joint before
  };
  /// The joint a bone's length on from another one, as walk_from() lays it. None where it was not
  /// proved that the curve turns by less than a radian on the way. Needs is_finite().
  ///
  /// An arc is longer than its chord by no more than on a circle of the curve's largest bend
  /// (Schur's theorem). With the unit chord c between arcs s and t, and T' the tangent's motion at
  /// a fixed arc: (c . T(t)) t' = (c . T(s)) s' - (t - s) c . (the mean of T' between); and c is
  /// within the bone's own bend of every tangent between, to which its T' is square.
  std::optional<Joint> walked(const Joint& from, double bone) const;

  struct Place {
    BoxVector tangent;
    BoxReal piece;  // which piece, and the parameter on it; the number of pieces past the end
  };
  Place at(const Joint& joint) const;

 private:
  struct Panel {
    BoxVector tangent, at_share;  // at a fixed parameter; at a fixed share of the length
    IntervalVector bend;
    Interval speed, arc, share, piece;
    BoxSlopes arc_slope;  // of the arc up to a fixed parameter
  };
  void add_panels(const Legs& legs, const BoxArc& arc, double number, const BoxReal& before,
                  const BoxReal& after);

  /// What holds on all panels that have a part of an arc.
  template <class Of>
  IntervalVector panels_over(const Interval& arc, const Of& of) const;

  std::vector<Panel> panel_;
  BoxReal length_;
  BoxVector end_;                  // the tangent there
  BoxCurve middle_;                // the curve at the box's middle
  std::optional<BoxCurve> whole_;  // of boxes so small that places solved for are the narrower
  double most_bend_ = 0.0;         // radians per length, anywhere and at every pose
  BoxRates most_turn_{};           // of the tangent at a fixed arc length, anywhere
  bool finite_ = true;
};

/// The tangents of one cubic Bezier.
BoxTangents bezier_tangents(const std::array<BoxVector, 4>& cv, int panels = 192);

/// The legs of the pieces of a clamped uniform cubic B-spline of four or more CVs, as
/// Curve::bspline() has them, from the steps between its CVs.
std::vector<BoxTangents::Legs> bspline_legs(const std::vector<BoxVector>& step);

}  // namespace backbend::solver
