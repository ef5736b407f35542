#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "solver/rig/spine_system.h"

namespace backbend::solver {

/// Control values of many poses of one rig, channel by channel: those of channel c stand at
/// value[c * count .. (c + 1) * count), in the units of SpineSystem::channels().
struct CrowdControls {
  std::span<const double> value;
  std::size_t count = 0;

  double at(std::size_t channel, std::size_t pose) const { return value[channel * count + pose]; }
};

/// Many solved poses of one rig as a structure of arrays: what skinning a crowd needs. Row r holds
/// one number of every pose, at row(r)[pose]. Same spaces, units and joint order as SpinePose.
class CrowdPose {
 public:
  /// Makes room; memory is used again. What stood here is lost.
  void resize(std::size_t joints, std::size_t poses) {
    joints_ = joints;
    poses_ = poses;
    value_.resize((7 * joints + 7) * poses);
    flagged_.resize(poses);
  }
  std::size_t joint_count() const { return joints_; }
  std::size_t pose_count() const { return poses_; }

  /// `axis` 0..2: x, y, z of a joint's origin.
  std::span<double> position(std::size_t joint, std::size_t axis) { return row(7 * joint + axis); }
  std::span<const double> position(std::size_t joint, std::size_t axis) const {
    return row(7 * joint + axis);
  }
  /// `part` 0..3: w, x, y, z of a joint's unit turn from rest.
  std::span<double> turn(std::size_t joint, std::size_t part) { return row(7 * joint + 3 + part); }
  std::span<const double> turn(std::size_t joint, std::size_t part) const {
    return row(7 * joint + 3 + part);
  }
  /// What the arm roots follow: `posed_origin` and `turn` of SpinePose::arms; its rest_origin is
  /// that of SpineSystem::rest().
  std::span<double> arms_origin(std::size_t axis) { return position(joints_, axis); }
  std::span<const double> arms_origin(std::size_t axis) const { return position(joints_, axis); }
  std::span<double> arms_turn(std::size_t part) { return turn(joints_, part); }
  std::span<const double> arms_turn(std::size_t part) const { return turn(joints_, part); }

  /// 1 for each pose that needed a documented fallback (SpinePose::flags says which).
  std::span<std::uint8_t> flagged() { return flagged_; }
  std::span<const std::uint8_t> flagged() const { return flagged_; }

 private:
  std::span<double> row(std::size_t r) { return {value_.data() + r * poses_, poses_}; }
  std::span<const double> row(std::size_t r) const { return {value_.data() + r * poses_, poses_}; }

  std::size_t joints_ = 0, poses_ = 0;
  std::vector<double> value_;
  std::vector<std::uint8_t> flagged_;
};

/// Solves many poses of a rig at once, each bit for bit what SpineSystem::solve() gives for its
/// controls alone, however many there are. Needs one value per channel and pose. Poses do not
/// depend on each other, so callers may split a crowd across threads.
void solve_crowd(const SpineSystem& system, const CrowdControls& control, CrowdPose& out);

/// Poses of a crowd that follow each other, [first, last).
struct PoseRange {
  std::size_t first = 0, last = 0;
};

/// Solves a part of a crowd into its place in `out`, which has room for all of the crowd already
/// (CrowdPose::resize()): for callers that look at something else in between.
void solve_crowd(const SpineSystem& system, const CrowdControls& control, PoseRange range,
                 CrowdPose& out);

/// A SpineSystem is one of these too if it has a faster way with crowds than one by one.
class CrowdSolver {
 public:
  /// As the function of that name for a part of a crowd.
  virtual void solve_crowd(const CrowdControls& control, PoseRange range, CrowdPose& out) const = 0;

 protected:
  ~CrowdSolver() = default;
};

/// Solves poses of a crowd one by one: what is done for other systems, and the way out for poses
/// that a faster way leaves alone. Holds memory from pose to pose.
class OneByOne {
 public:
  explicit OneByOne(const SpineSystem& system) : system_(system) {}
  /// Pose number `pose`; `out` has room already.
  void solve(const CrowdControls& control, std::size_t pose, CrowdPose& out);

 private:
  const SpineSystem& system_;
  std::vector<double> own_;
  SpinePose solved_;
};

}  // namespace backbend::solver
