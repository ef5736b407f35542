#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "solver/rig/spine_system.h"

namespace backbend::validate {

/// Names of the body channels, in the order that tables show them.
inline constexpr std::string_view kChannels[] = {"extension", "flexion", "side",
                                                 "twist",     "hip",     "stretch"};
/// Those that every rig has, and that an envelope says something of.
inline constexpr std::span<const std::string_view, 4> kBendChannels(kChannels, 4);

/// A body pose in degrees, as people write it; `stretch` in per cent of the distance between hips
/// and chest at rest, -30 compresses it by 30 %.
struct PoseDegrees {
  double extension = 0, flexion = 0, side = 0, twist = 0, hip = 0, stretch = 0;

  double* find(std::string_view channel);
  const double* find(std::string_view channel) const;
  solver::BodyPose radians() const;
  /// `extension 114.3, side 10`: only channels that are not 0; `rest` for none.
  std::string text() const;
};

/// Reads `extension=90,side=10`, or `rest`. Throws solver::RigError naming an unknown channel (with
/// the nearest name), a missing or a non-finite number, or a stretch that leaves nothing (-95 or
/// less).
PoseDegrees parse_pose(std::string_view text);
inline constexpr double kLeastStretch = -95.0;  // per cent

/// The part of a pose that a rig has no control for: `stretch: its controls turn and do not move`.
/// Empty where it can take all of it.
std::string why_not_taken(const solver::SpineSystem& system, const PoseDegrees& pose);

/// A pose that a path goes through, and how many degrees of control lead there.
struct Waypoint {
  double control_deg = 0;
  PoseDegrees pose;
};

/// A path through pose space. A straight one starts, at control 0, in `start` and turns
/// `per_degree` of each channel for each degree of control; one with waypoints is straight between
/// them, and goes on straight beyond the last.
struct Sweep {
  std::string name;     // `extension`, `compound`
  std::string channel;  // the leading channel, whose degrees the control counts; `path`: waypoints
  double from_deg = 0, to_deg = 0, step_deg = 2;
  PoseDegrees per_degree;
  PoseDegrees start{};
  std::vector<Waypoint> through{};  // empty, or at least two by rising control
  bool corner = false;              // leads from rest to a corner of the envelope
  bool watched = true;              // small pictures follow its motion; else only its findings

  std::size_t pose_count() const;
  double control_at(std::size_t pose) const;
  PoseDegrees pose_at(double control_deg) const;
};

/// A sweep of one channel. A per cent of `stretch` counts as a degree of control.
Sweep channel_sweep(std::string_view channel, double from_deg, double to_deg, double step_deg);

/// The path through these poses, in order. A degree of control is a degree of the channel that
/// changes most on its leg; poses that follow their like are left out. Throws solver::RigError
/// where fewer than two remain.
Sweep path_sweep(std::string name, std::span<const PoseDegrees> poses, double step_deg);

/// A seeded path through `legs` random poses of a box: bends from -90 (flexion) to 120 (extension),
/// 60 to either side, 120 of twist to either side. The same on every machine.
inline constexpr std::string_view kRandomWalk = "walk";  // its name
Sweep random_walk(std::uint64_t seed, int legs, double step_deg);

/// Specification 8, Sweeps: what stresses a rig beyond the standard sweeps (envelope.h). The grid
/// covers pose space: extension at every pair of side and twist, a sweep each.
std::vector<Sweep> stress_sweeps();
std::vector<Sweep> grid_sweeps();

std::string_view mapping_name(solver::Mapping mapping);
std::optional<solver::Mapping> find_mapping(std::string_view name);

/// A number as people read it: at most `decimals` digits after the point, no trailing zeros.
std::string number_text(double value, int decimals = 3);

}  // namespace backbend::validate
