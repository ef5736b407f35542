#include "validate/sweeps/named_pose.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace backbend::validate {
namespace {

constexpr double kStep_deg = 5.0;
constexpr int kFewest = 2, kMost = 24;  // steps
constexpr int kDecimals = 6;            // a flip's place is told to 1e-5 degrees

}  // namespace

Sweep named_pose(const std::string& name, const PoseDegrees& from, const PoseDegrees& at) {
  std::vector<PoseDegrees> poses{from};
  const double before = from.extension - from.flexion, after = at.extension - at.flexion;
  if (before * after < 0.0) {
    // The upright pose between the two: on a straight line both channels would bend at once.
    const double share = before / (before - after);
    PoseDegrees upright;
    for (const std::string_view channel : {"side", "twist", "hip", "stretch"})
      *upright.find(channel) = std::lerp(*from.find(channel), *at.find(channel), share);
    poses.push_back(upright);
  }
  poses.push_back(at);
  Sweep sweep = path_sweep(name, poses, 1.0);
  const int steps =
      std::clamp(static_cast<int>(std::ceil(sweep.to_deg / kStep_deg)), kFewest, kMost);
  sweep.step_deg = sweep.to_deg / steps;
  sweep.corner = true;
  sweep.watched = false;  // too few poses to follow
  return sweep;
}

std::string pose_words(const PoseDegrees& pose) {
  std::string text;
  for (const std::string_view channel : kChannels)
    if (const double value = *pose.find(channel); value != 0.0)
      text +=
          (text.empty() ? "" : ",") + std::string(channel) + "=" + number_text(value, kDecimals);
  return text.empty() ? "rest" : text;
}

PoseDegrees in_file_digits(const PoseDegrees& pose) { return parse_pose(pose_words(pose)); }

}  // namespace backbend::validate
