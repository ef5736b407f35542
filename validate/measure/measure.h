#pragma once
#include <algorithm>
#include <array>
#include <bitset>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "render/trace/cameras.h"
#include "validate/measure/metric_table.h"
#include "validate/metrics/chain/bend_shares.h"
#include "validate/metrics/chain/chain.h"
#include "validate/metrics/chain/flip.h"
#include "validate/metrics/surface/body_metrics.h"
#include "validate/model/report.h"
#include "validate/stage/stage.h"
#include "validate/sweeps/suite.h"
#include "validate/tasks/progress.h"

namespace backbend::validate {

struct PoseRecord {
  double control_deg = 0.0;
  PoseDegrees body;
  bool inside = true;       // the envelope
  bool taken = true;        // false: the rig has no control for it, and nothing of it is applicable
  bool rest_noted = false;  // the one pose of a rig that carries its return to rest (BB044)
  std::vector<double> control;
  std::optional<int> frame;  // of a recording: the file's own number, and its second
  double time_s = 0.0;
  std::array<Measured, kMetricCount> metric;
  std::bitset<kMetricCount> left_out;  // metrics that say nothing of this pose, or were not asked
  ArmDrift arms;
  render::Bounds bounds;  // of the posed body, world space; set by measure_poses() and hunts

  const Measured& at(MetricId id) const { return metric[static_cast<std::size_t>(id)]; }
  Measured& at(MetricId id) { return metric[static_cast<std::size_t>(id)]; }
};

/// The part of a body channel's angle that arrives at the chest of a rig.
struct ChannelResponse {
  std::string channel;       // extension, flexion, side or twist
  double asked_deg = 0.0;    // of the channel
  double arrived_deg = 0.0;  // about the channel's axis; negative: the other way round
  double other_deg = 0.0;    // about the axes that the channel does not turn about
  std::size_t pose = 0;      // of a recorded sweep: where it was read
  double from_deg = 0.0;     // of the channel: where what was asked for begins
  /// 1: all that was asked for, and nothing else. What turns farther than asked, about this axis or
  /// others, is less by the square of how much farther.
  double share() const {
    const double turned = arrived_deg * arrived_deg + other_deg * other_deg;
    return arrived_deg * asked_deg / std::max(asked_deg * asked_deg, turned);
  }
};

struct SweepRecord {
  Sweep sweep;  // of a recording: its name, leading channel (empty: none is known to move), and
                // step_deg: how far its channels go from frame to frame; 0: only time is known
  std::vector<PoseRecord> poses;
  FlipReport flips;
  // Of a recording: false where it is too short to be searched for jumps, beside one that is not;
  // what each frame has beyond its share of the bend, and the answer of the one channel that moves.
  bool searched = true;
  std::vector<ShareExcess> shares;
  std::optional<ChannelResponse> response;
};

/// A joint of a recording whose turns are searched for jumps.
struct WatchedJoint {
  enum class Against {
    below,  // the joint below it on the chain, or the spine joint that it hangs from
    hips,   // what all joints up to it add up to: small jumps of many joints in one direction
    world   // the hips themselves
  };
  int node = -1, base = -1;  // base: -1 for the world
  Against against = Against::below;
  std::string name;
};

/// What is known of motion that was recorded and not solved here: its frames are the samples, all
/// of them count, and nobody can be asked what lies between.
struct Recording {
  Owner owner = Owner::rig;           // of the motion
  std::string command;                // that judges it again
  std::vector<WatchedJoint> watched;  // the joints that FlipReport counts; entry k is spine joint k
  std::size_t share_joints = 0;       // spine joints above the hips whose shares are compared
  std::vector<std::string> notes;     // what was left out, a line each
  /// A pose of it bent evenly, with the same ends and weights, measured; empty without a body.
  std::function<PoseRecord(const PoseRecord&)> even_bend;
};

/// Everything measured on one rig under one mapping, or on a recording, which has none.
struct RigRecord {
  RigPlan plan;
  solver::Mapping mapping = solver::Mapping::chest;
  std::unique_ptr<solver::SpineSystem> system;
  // A rig of ours on the rest chain laid into the body's middle plane, by which its own mirror
  // asymmetry is told from the skeleton's. Null: the chain lies there, or it cannot be built so.
  std::unique_ptr<solver::SpineSystem> in_plane;
  std::vector<SweepRecord> sweeps;
  CompoundSearch search;            // of the poses between the sweeps
  PoseHunt hunt;                    // what was searched for the worst poses, and
  CleanVolume volume;               // how much of the envelope is clean
  std::vector<PoseRecord> samples;  // the random poses that the latter is judged by
  bool has_mesh = false;            // the surface was measured too
  SurfaceScope surface;             // what may be asked of it
  bool has_arms = true;             // that the chest carries
  std::optional<Recording> recording;

  /// `chest` or `even`; empty for a recording.
  std::string_view mapping_text() const { return recording ? "" : mapping_name(mapping); }
};

/// Measures the chain alone, over the given sweeps. Every metric of the chain is filled, here and
/// by measure_rig().
RigRecord measure_chain_only(const Stage& stage, const RigPlan& plan, solver::Mapping mapping,
                             const std::vector<Sweep>& sweeps, const Envelope& envelope);

/// Measures chain and mesh. Poses are independent of each other, and of the number of threads.
RigRecord measure_rig(const Stage& stage, const BodyMetrics& body, const RigPlan& plan,
                      solver::Mapping mapping, const std::vector<Sweep>& sweeps,
                      const Envelope& envelope, Progress& progress);

/// The same in steps that may be done in any order, and elsewhere: every pose planned and none
/// measured; some poses measured; the jumps of one sweep found, and taken into its record.
RigRecord plan_rig(const Stage& stage, const BodyMetrics& body, const RigPlan& plan,
                   solver::Mapping mapping, const std::vector<Sweep>& sweeps,
                   const Envelope& envelope);
void measure_poses(const Stage& stage, const BodyMetrics& body, const RigRecord& rig,
                   const RigAtRest& at_rest, std::span<PoseRecord> poses, Progress& progress);
FlipReport search_flips(const RigRecord& rig, const Sweep& sweep);
void take_flips(SweepRecord& record, FlipReport flips);

/// Fills chain and mesh metrics of one pose whose body and control are set.
void measure_pose(const BodyMetrics& body, const RigAtRest& rig, const PosedCharacter& posed,
                  PoseRecord& record, Crossing crossing = Crossing::measured);

/// Fills the chain metrics alone of one pose whose body and control are set, and gives the pose.
solver::SpinePose measure_chain_pose(const RigAtRest& rig, PoseRecord& record);

/// Fills mirror asymmetry and range of motion of one pose whose chain is finite.
void measure_pose_behaviour(const Stage& stage, const RigRecord& rig, PoseRecord& record);

/// Fills what poses owe to the rig alone: mirror asymmetry, return to rest, predictability, a
/// human's range of motion. Poses whose chain is not finite keep NaN.
void measure_behaviour(const Stage& stage, RigRecord& rig);

/// The control values of a rig for a body pose.
std::vector<double> controls_at(const solver::SpineSystem& system, const PoseDegrees& pose,
                                solver::Mapping mapping);

}  // namespace backbend::validate
