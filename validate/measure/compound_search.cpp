#include "validate/measure/compound_search.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "validate/live/external_rig.h"
#include "validate/measure/measure.h"
#include "validate/metrics/chain/rig_probe.h"

namespace backbend::validate {
namespace {

constexpr double kLattice_deg = 15.0;  // of side and twist
// A program that is asked takes milliseconds a pose. Of poses on paths: what the standard sweeps'
// box has. Of those between them: a path with a jump or two takes fifteen for each of its poses,
// one along singular poses any number.
constexpr double kMostPoses = 4000.0;
constexpr std::size_t kMostAskedOfPose = 40;
constexpr double kStep_deg = 5.0;  // along the bend
constexpr double kAround_deg = 16.0, kAroundStep_deg = 2.0;

/// From -end to end in equal steps of at most `step`.
std::vector<double> lattice(double end, double step) {
  const int steps = static_cast<int>(std::ceil(end / step - 1e-9));
  std::vector<double> values;
  for (int i = -steps; i <= steps; ++i) values.push_back(steps == 0 ? 0.0 : end * i / steps);
  return values;
}

/// How wide the cells of side and twist are, for at most so many poses.
double lattice_step(const Envelope& box, double most_poses) {
  const double poses_of_path = (box.extension + box.flexion) / kStep_deg + 1.0;
  double step = kLattice_deg;
  const auto poses = [&] {
    return static_cast<double>(lattice(box.side, step).size() * lattice(box.twist, step).size()) *
           poses_of_path;
  };
  while (poses() > most_poses && step < std::max(box.side, box.twist)) step += kLattice_deg;
  return step;
}

/// The paths of the search: flexion's end, rest, extension's end, at one side and twist.
std::vector<Sweep> paths_in(const Envelope& box, double step) {
  std::vector<Sweep> paths;
  if (box.extension == 0.0 && box.flexion == 0.0) return paths;
  for (const double side : lattice(box.side, step)) {
    for (const double twist : lattice(box.twist, step)) {
      if (side == 0.0 && twist == 0.0) continue;  // the single channels' own sweeps
      const PoseDegrees poses[] = {
          {0, box.flexion, side, twist}, {0, 0, side, twist}, {box.extension, 0, side, twist}};
      paths.push_back(path_sweep("search", poses, kStep_deg));
    }
  }
  return paths;
}

struct FoundJump {
  const Sweep* path = nullptr;
  double control_deg = 0, size_deg = 0;
  double distance = 0;  // from rest, 1 at the box's border
};

double distance_from_rest(const PoseDegrees& pose, const Envelope& box) {
  double most = 0.0;
  for (const std::string_view channel : kBendChannels)
    if (box.needs(channel) > 0.0)
      most = std::max(most, std::abs(*pose.find(channel)) / box.needs(channel));
  return most;
}

Sweep around(const FoundJump& jump) {
  Sweep sweep = *jump.path;
  sweep.from_deg = std::max(0.0, jump.control_deg - kAround_deg);
  sweep.to_deg = std::min(jump.path->to_deg, jump.control_deg + kAround_deg);
  sweep.step_deg = kAroundStep_deg;
  sweep.corner = true;
  sweep.watched = false;
  const PoseDegrees at = sweep.pose_at(jump.control_deg);
  sweep.name = kJumpSweep;
  for (const std::string_view channel : kBendChannels)
    if (const double value = std::round(*at.find(channel)); value != 0.0)
      sweep.name += " " + std::string(channel) + " " + number_text(value);
  return sweep;
}

std::string box_text(const Envelope& box) {
  return "extension 0.." + number_text(box.extension) + ", flexion 0.." + number_text(box.flexion) +
         ", side +-" + number_text(box.side) + ", twist +-" + number_text(box.twist);
}

}  // namespace

Envelope search_box(const Envelope& envelope, const std::vector<Sweep>& sweeps) {
  Envelope box = reach_of(*find_envelope("sweep"), sweeps);
  box.extension = std::max(box.extension, envelope.extension);
  box.flexion = std::max(box.flexion, envelope.flexion);
  box.side = std::max(box.side, envelope.side);
  box.twist = std::max(box.twist, envelope.twist);
  return box;
}

FoundJumps search_compound(const solver::SpineSystem& system, solver::Mapping mapping,
                           const Envelope& box, Progress* progress) {
  const bool external = external_rig(system) != nullptr;
  const double most = external ? kMostPoses : std::numeric_limits<double>::infinity();
  const std::vector<Sweep> paths = paths_in(box, lattice_step(box, most));
  if (progress) progress->start("search", paths.size());
  std::vector<FlipReport> flips(paths.size());
  oneapi::tbb::parallel_for(std::size_t{0}, paths.size(), [&](std::size_t i) {
    const Sweep& path = paths[i];
    const auto control = [&](double t) {
      return controls_at(system, path.pose_at(path.to_deg * t), mapping);
    };
    const int intervals = static_cast<int>(path.pose_count()) - 1;
    prepare_search(system, control, intervals);
    FlipSettings settings = flip_settings(system, intervals, path.to_deg);
    if (external) {
      settings.budget = kMostAskedOfPose * path.pose_count();
      settings.smallest_deg = kSmallestAsked_deg;
    }
    flips[i] = find_flips(probe(system, control), settings);
    if (progress) progress->step();
  });
  FoundJumps found;
  found.summary.box = paths.empty() ? "" : box_text(box);
  found.summary.paths = static_cast<int>(paths.size());
  std::vector<FoundJump> jumps;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    found.summary.poses += static_cast<int>(paths[i].pose_count());
    found.summary.with_jumps += flips[i].jumps.empty() ? 0 : 1;
    found.summary.unsure += flips[i].certified ? 0 : 1;
    for (const Jump& jump : flips[i].jumps) {
      const double control = paths[i].to_deg * jump.t;
      jumps.push_back({&paths[i], control, jump.size_deg(),
                       distance_from_rest(paths[i].pose_at(control), box)});
    }
  }
  if (jumps.empty()) return found;
  const auto nearest = std::ranges::min_element(jumps, {}, &FoundJump::distance);
  const auto largest = std::ranges::max_element(jumps, {}, &FoundJump::size_deg);
  found.around.push_back(around(*nearest));
  if (Sweep second = around(*largest); second.name != found.around.front().name)
    found.around.push_back(std::move(second));
  return found;
}

}  // namespace backbend::validate
