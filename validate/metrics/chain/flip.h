#pragma once
#include <cstddef>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "validate/metrics/math/rotation.h"

namespace backbend::validate {

/// A rig at one point of a sweep, as the flip detector sees it. `turn` is required, the others are
/// empty or have one entry per joint, the same at every point of the sweep.
struct FlipSample {
  std::vector<glm::dquat> turn;      // world rotation of each joint, unit
  std::vector<glm::dvec3> position;  // joint origins; empty: only rotations are watched
  std::vector<glm::dvec3> bone;      // world direction along the bone, unit; tells the class
  std::vector<double> margin;        // radians to the joint's nearest singular pose
  glm::dquat base{1, 0, 0, 0}, end{1, 0, 0, 0};  // hip's and chest's own turn; tell the class
  // The last so many joints hang from the chain: they are searched for jumps, and have no gain.
  std::size_t hanging = 0;
};

/// The rig as a function of t, 0..1 over the sweep (and past 1, where settings ask). Must be pure;
/// the sample is reused.
using FlipRig = std::function<void(double t, FlipSample& sample)>;

struct FlipSettings {
  int intervals = 90;          // of the sweep: poses - 1
  int intervals_beyond = 0;    // searched past t = 1, for a jump exactly at the sweep's end
  double control_deg = 180.0;  // degrees of control from t = 0 to 1; 0: gains are not measured
  double gain_limit = 8.0;     // above it a stretch is listed as steep
  double smallest_deg = 1.0;   // jumps below are not looked for
  double length = 1.0;         // reference length for positions: that of the spine at rest
  double smallest_shift =
      0.01;             // jumps of position below this share of `length` are not looked for
  int bisections = 20;  // of the whole sweep: an interval is sure at 2^-20
  std::vector<double> fraction{};  // arc fraction of each joint, 0 hips .. 1 chest; tells the class
  std::size_t budget = 400'000;    // samples; beyond it the sweep is not certified, and one
                                   // jump is told where there is any
};

enum class FlipClass {
  up_vector,     // half a turn about the bone: an up vector passed the tangent
  hemisphere,    // all joints at once by 360 x fraction: a quaternion went the other way round
  double_cover,  // the same, one turn later: q and -q taken for different
  roll_wrap,     // twist about the bone read back as a principal value
  spike,         // one pose alone differs from both its neighbours
  pop,           // positions jump, orientations do not
  other
};
std::string_view name_of(FlipClass kind);

/// One joint's share in a jump.
struct JointJump {
  std::size_t joint = 0;
  double size_deg = 0.0;
  double shift = 0.0;             // of the joint's origin, share of the reference length
  glm::dvec3 axis{0.0};           // world, unit; zero where only the position jumps
  double axis_to_bone_deg = 0.0;  // 0: about the bone; NaN without bones
  // Of recorded motion: the largest turn that the motion around would explain there, and after how
  // many frames the joint is back; 0: the turn holds.
  double expected_deg = 0.0;
  std::size_t frames_out = 0;
};

/// A place of the sweep where the rig is not continuous.
struct Jump {
  double t = 0.0;                    // middle of the interval that holds it
  double before = 0.0, after = 0.0;  // the interval: poses on both sides, at most 2^-20 apart
  FlipClass kind = FlipClass::other;
  std::size_t pose = 0;           // of recorded motion, in place of t: the last pose before it
  std::vector<JointJump> joints;  // largest first; of recorded motion as they are watched
  double size_deg() const { return joints.empty() ? 0.0 : joints.front().size_deg; }
};

/// A place where the rig is continuous but too fast.
struct SteepSpot {
  std::size_t joint = 0;
  double t = 0.0;
  double gain = 0.0;  // degrees of turn per degree of control
};

struct FlipReport {
  std::vector<Jump> jumps;            // by rising t
  std::vector<SteepSpot> steep;       // joints over the gain limit at their fastest, by joint
  std::vector<double> gain;           // per joint of the chain: the fastest outside jumps; NaN
                                      // without control
  std::vector<double> interval_gain;  // per interval of the sweep, over all joints, jumps included
  std::vector<double> least_margin_deg;  // per joint; empty where the rig reports none
  std::vector<double> least_margin_t;
  double smallest_deg = 0.0;  // jumps below this were not looked for
  double smallest_gap = 0.0;  // two jumps that cancel within this share of the sweep may
                              // hide each other where no margin betrays them
  std::size_t samples = 0;
  bool finite = true;  // false: a sample was not finite, at `not_finite_t`
  double not_finite_t = 0.0;
  bool certified = true;  // false: the budget ran out or a sample was not finite
  // Of recorded motion, per joint: the smallest jump that is found at its busiest place, and in the
  // calmer half of its steps; infinite where there are too few poses. And the pose of not_finite_t.
  std::vector<double> detectable_deg, calm_deg;
  std::size_t not_finite_pose = 0;
};

/// Finds every jump of a rig over a sweep and proves the rest continuous at its resolution.
///
/// Motion that is continuous halves when its interval is halved, however fast; a jump stays. Each
/// interval is therefore split where its two halves differ by more than smooth motion explains,
/// where its gain stands out, or where a flip margin says that it may hold a singular pose, until
/// the halves agree or the interval is 2^-bisections of the sweep. What then still turns by
/// `smallest_deg` is a jump. No interval counts as clean before its quarters were compared.
///
/// Sizes are corrected by the motion on both sides, so that they are those of the jump alone.
/// Throws nothing; a sample that is not finite ends the search (`finite`, `certified`).
FlipReport find_flips(const FlipRig& rig, const FlipSettings& settings);

}  // namespace backbend::validate
