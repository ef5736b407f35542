#pragma once
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "solver/curves/box_tangents.h"
#include "solver/curves/curve.h"
#include "solver/math/interval.h"

namespace backbend::solver {

/// How a chain lies on the curve that it is meant to follow, at every pose of a box: its joints
/// stand on the curve, in order, or are held against joints that do; or each bone is held against a
/// chord. Lengths are in any one unit, which may change with the pose.
struct BoxCourse {
  /// Between two neighbouring joints.
  struct Stretch {
    Interval bone;        // length of the bone
    Interval arc;         // length of the curve
    double bend = 0.0;    // the most that the curve bends, radians per unit; infinite: unknown
    double corner = 0.0;  // sum of the curve's corners, those at both ends included, radians
  };
  std::vector<Stretch> stretch;  // first bone first
  bool from_last = false;        // the other way round: from the last joint to the first
  double before = 0.0;           // the curve's length before the first joint

  /// Of a chain of equal bones that goes from the same first joint and aims each bone at the next
  /// joint of the stretches.
  struct Beside {
    Interval bone;               // length of each bone
    std::vector<Interval> past;  // by joint: how far past the stretches' joint it stands, along the
                                 // bone that ends there; the first by 0
    Interval end;                // of the curve: from the last stretch's end to the place that is
                                 // nearest to the last joint
    double apart = 0.0;          // the most between these two where the place is not the end itself
  };
  std::optional<Beside> beside;

  /// Of a chain whose joints stand anywhere. What its stretches say, where it has some, holds too.
  struct Held {
    /// One that is not at an end, in a frame of its own.
    struct Joint {
      std::array<BoxVector, 2> bone;   // below and above it
      std::array<BoxVector, 2> chord;  // of the curve, from and to where the ends of these bones
                                       // belong on it, or shorter than that
      std::optional<BoxTurn> turn;     // of the joint before it, from rest; none: unknown
      // How far each chord may be off, both ends together, because the check's curve is cut into as
      // many straight pieces as were asked for.
      std::array<double, 2> astray{};
    };
    std::vector<Joint> joint;
  };
  std::optional<Held> held;

  // Where more is known than the bends: the curve itself, and the unit in lengths of the curve.
  std::optional<BoxTangents> curve;
  Interval unit = 1.0;

  /// Variables that change nothing of it.
  std::array<bool, kBoxVariables> still{};
};

/// A stretch of a curve with length `arc` that bends by at most `bend` radians per unit and has
/// corners only at its ends. Its chord is at least as long as that of a circular arc of the same
/// length and bend (Schur's theorem).
BoxCourse::Stretch stretch_along(const Interval& arc, double bend, double corner = 0.0);
/// The same with corners anywhere: no tangent of it is further than half of its whole turning from
/// the direction in the middle.
BoxCourse::Stretch stretch_over_corners(const Interval& arc, double bend, double corner);
/// A stretch without corners whose bone has a known length.
BoxCourse::Stretch stretch_under(const Interval& bone, double bend);

/// A chain whose bones, `scale` times as long as these, are walked along a curve from its start,
/// and straight on past its end. In units of `scale`.
BoxCourse walked_course(BoxTangents curve, std::span<const double> bone,
                        const Interval& scale = 1.0);
/// A chain whose joints stand at these shares of the first `used` of a curve's length, in units of
/// that.
BoxCourse course_at_shares(BoxTangents curve, const Interval& used, std::span<const double> share);

/// A chain whose bones keep their lengths, held against chords of a curve from its start to its
/// end, which is seen as `points` points. `share`: of the chain's length, up to each joint; `turn`
/// of each joint.
BoxCourse held_course(const BoxTangents& curve, std::size_t points, std::span<const double> share,
                      const std::vector<BoxVector>& bone, const std::vector<BoxTurn>& turn);
/// The same of a chain whose joints are the points of an interpolating curve. `step`: for each
/// joint but the last, all steps from joint to joint in a frame in which those at the joint hardly
/// move.
BoxCourse course_through_joints(const CurveMap& map, std::size_t points,
                                std::span<const double> share,
                                const std::vector<std::vector<BoxVector>>& step);

/// A chain of equal bones that chase places at equal shares of a curve's length, as BoxChase goes;
/// `bone` in even bones, that is the curve's length over `bones`. In units of the curve's length.
BoxCourse chased_course(BoxTangents curve, std::size_t bones, const BoxReal& bone);

}  // namespace backbend::solver
