#include "validate/sweeps/sweep.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <glm/trigonometric.hpp>
#include <random>
#include <utility>

#include "solver/rig/nearest_name.h"

namespace backbend::validate {
namespace {

std::vector<std::string> channel_names() { return {std::begin(kChannels), std::end(kChannels)}; }

double parse_number(std::string_view text, std::string_view channel) {
  double value = 0.0;
  const char* first = text.data();
  if (!text.empty() && text.front() == '+') ++first;
  const auto [end, error] = std::from_chars(first, text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) {
    throw solver::RigError("pose: '" + std::string(text) +
                           "' is not a finite number of degrees for '" + std::string(channel) +
                           "'");
  }
  return value;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

}  // namespace

const double* PoseDegrees::find(std::string_view channel) const {
  if (channel == "extension") return &extension;
  if (channel == "flexion") return &flexion;
  if (channel == "side") return &side;
  if (channel == "twist") return &twist;
  if (channel == "hip") return &hip;
  if (channel == "stretch") return &stretch;
  return nullptr;
}

double* PoseDegrees::find(std::string_view channel) {
  return const_cast<double*>(std::as_const(*this).find(channel));
}

solver::BodyPose PoseDegrees::radians() const {
  return {glm::radians(extension), glm::radians(flexion), glm::radians(side),
          glm::radians(twist),     glm::radians(hip),     1.0 + stretch / 100.0};
}

std::string PoseDegrees::text() const {
  std::string result;
  for (const std::string_view channel : kChannels) {
    const double value = *find(channel);
    if (value == 0.0) continue;
    if (!result.empty()) result += ", ";
    result += std::string(channel) + " " + number_text(value);
  }
  return result.empty() ? "rest" : result;
}

PoseDegrees parse_pose(std::string_view text) {
  PoseDegrees pose;
  if (trimmed(text) == "rest") return pose;
  while (!text.empty()) {
    const std::size_t comma = text.find(',');
    const std::string_view item = trimmed(text.substr(0, comma));
    text = comma == std::string_view::npos ? std::string_view{} : text.substr(comma + 1);
    if (item == "rest") continue;  // every channel at 0, as a pose's own text says it
    const std::size_t equals = item.find('=');
    if (equals == std::string_view::npos) {
      throw solver::RigError("pose: '" + std::string(item) + "' is not channel=degrees");
    }
    const std::string_view channel = trimmed(item.substr(0, equals));
    double* value = pose.find(channel);
    if (value == nullptr) {
      throw solver::RigError("pose: no channel '" + std::string(channel) + "'" +
                             solver::did_you_mean(channel, channel_names()) +
                             " (extension, flexion, side, twist, hip, stretch)");
    }
    *value = parse_number(trimmed(item.substr(equals + 1)), channel);
  }
  if (!(pose.stretch > kLeastStretch))
    throw solver::RigError("pose: stretch " + number_text(pose.stretch) +
                           " leaves no spine (per cent, above " + number_text(kLeastStretch) + ")");
  return pose;
}

std::string why_not_taken(const solver::SpineSystem& system, const PoseDegrees& pose) {
  const auto without = [&](std::string_view channel, double value, solver::BodyChannel which) {
    const std::string_view why = value == 0.0 ? "" : system.why_without(which);
    return why.empty() ? "" : std::string(channel) + ": " + std::string(why);
  };
  if (std::string why = system.why_not_mapped(pose.radians()); !why.empty()) return why;
  const std::string hip = without("hip", pose.hip, solver::BodyChannel::hip);
  return hip.empty() ? without("stretch", pose.stretch, solver::BodyChannel::stretch) : hip;
}

std::size_t Sweep::pose_count() const {
  return static_cast<std::size_t>(std::floor(std::abs(to_deg - from_deg) / step_deg + 1e-9)) + 1;
}

double Sweep::control_at(std::size_t pose) const {
  const double direction = to_deg >= from_deg ? 1.0 : -1.0;
  return from_deg + direction * step_deg * static_cast<double>(pose);
}

PoseDegrees Sweep::pose_at(double control_deg) const {
  PoseDegrees pose;
  if (through.empty()) {
    for (const std::string_view channel : kChannels)
      *pose.find(channel) = *start.find(channel) + *per_degree.find(channel) * control_deg;
    return pose;
  }
  // The leg that holds the control; the last one goes on.
  const auto next =
      std::find_if(through.begin() + 1, through.end() - 1,
                   [&](const Waypoint& point) { return control_deg < point.control_deg; });
  const Waypoint &a = *(next - 1), &b = *next;
  const double share = (control_deg - a.control_deg) / (b.control_deg - a.control_deg);
  for (const std::string_view channel : kChannels)
    *pose.find(channel) = std::lerp(*a.pose.find(channel), *b.pose.find(channel), share);
  return pose;
}

Sweep path_sweep(std::string name, std::span<const PoseDegrees> poses, double step_deg) {
  Sweep sweep{std::move(name), "path", 0, 0, step_deg, {}};
  for (const PoseDegrees& pose : poses) {
    double leg = 0.0;
    if (!sweep.through.empty())
      for (const std::string_view channel : kChannels)
        leg =
            std::max(leg, std::abs(*pose.find(channel) - *sweep.through.back().pose.find(channel)));
    if (!sweep.through.empty() && leg == 0.0) continue;
    sweep.to_deg += leg;
    sweep.through.push_back({sweep.to_deg, pose});
  }
  if (sweep.through.size() < 2)
    throw solver::RigError("path '" + sweep.name + "': it needs two poses that differ");
  return sweep;
}

Sweep random_walk(std::uint64_t seed, int legs, double step_deg) {
  std::mt19937_64 bits(seed);  // its numbers are the standard's; distributions are each library's
  const auto between = [&](double low, double high) {
    return std::round(low + (high - low) * static_cast<double>(bits() >> 11) * 0x1p-53);
  };
  std::vector<PoseDegrees> poses(1);
  double bend_before = 0.0;
  for (int i = 0; i < legs; ++i) {
    const double bend = between(-90, 120), side = between(-60, 60), twist = between(-120, 120);
    const PoseDegrees pose{std::max(bend, 0.0), std::max(-bend, 0.0), side, twist};
    if (bend * bend_before < 0.0) {
      // No pose bends both ways: the path passes the upright one in between.
      const double share = bend_before / (bend_before - bend);
      const PoseDegrees& last = poses.back();
      poses.push_back(
          {0, 0, std::lerp(last.side, side, share), std::lerp(last.twist, twist, share)});
    }
    poses.push_back(pose);
    bend_before = bend;
  }
  Sweep walk = path_sweep(std::string(kRandomWalk), poses, step_deg);
  walk.watched = false;  // it turns a corner every few poses
  return walk;
}

Sweep channel_sweep(std::string_view channel, double from_deg, double to_deg, double step_deg) {
  Sweep sweep{std::string(channel), std::string(channel), from_deg, to_deg, step_deg, {}};
  *sweep.per_degree.find(channel) = 1.0;
  return sweep;
}

std::vector<Sweep> stress_sweeps() {
  const auto named = [](const char* name, Sweep sweep) {
    sweep.name = name;
    return sweep;
  };
  Sweep compound = channel_sweep("extension", 0, 180, 2);
  compound.name = "compound";
  compound.per_degree.side = 0.5;
  compound.per_degree.twist = 0.5;
  return {channel_sweep("extension", 0, 180, 2),
          channel_sweep("flexion", 0, 180, 2),
          channel_sweep("side", -120, 120, 4),
          channel_sweep("twist", -360, 360, 6),
          compound,
          random_walk(1, 12, 8),
          named("hip_chest", channel_sweep("hip", -60, 60, 4)),
          named("compress", channel_sweep("stretch", 0, -40, 2)),
          channel_sweep("stretch", 0, 40, 2)};
}

std::vector<Sweep> grid_sweeps() {
  std::vector<Sweep> sweeps;
  for (int side = -60; side <= 60; side += 30) {
    for (int twist = -90; twist <= 90; twist += 45) {
      Sweep sweep = channel_sweep("extension", 0, 150, 15);
      sweep.name = "grid side " + std::to_string(side) + " twist " + std::to_string(twist);
      sweep.start.side = side;
      sweep.start.twist = twist;
      sweep.watched = false;  // 15 degrees between two poses is too coarse to judge motion
      sweeps.push_back(std::move(sweep));
    }
  }
  return sweeps;
}

std::string_view mapping_name(solver::Mapping mapping) {
  return mapping == solver::Mapping::chest ? "chest" : "spread";
}

std::optional<solver::Mapping> find_mapping(std::string_view name) {
  if (name == "chest") return solver::Mapping::chest;
  if (name == "spread") return solver::Mapping::spread;
  return std::nullopt;
}

std::string number_text(double value, int decimals) {
  if (!std::isfinite(value)) return "not measured";
  char buffer[512];  // 1e308 in full
  const auto result = std::to_chars(std::begin(buffer), std::end(buffer), value,
                                    std::chars_format::fixed, decimals);
  std::string text(buffer, result.ptr);
  if (text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  return text == "-0" ? "0" : text;
}

}  // namespace backbend::validate
