#include "solver/rig/limits.h"

#include <algorithm>
#include <array>

namespace backbend::solver {
namespace {

constexpr double kLumbarShare = 0.38;
constexpr int kLumbar = 5, kThoracic = 12;

constexpr double edge(int level) {
  return level <= kLumbar ? kLumbarShare * level / kLumbar
                          : kLumbarShare + (1.0 - kLumbarShare) * (level - kLumbar) / kThoracic;
}

constexpr SpineLevel level(int index, const char* name, const RangeOfMotion& range) {
  return {name, edge(index), edge(index + 1), range};
}

// name, then flexion, extension, side, axial.
constexpr std::array<SpineLevel, kLumbar + kThoracic> kLevels{
    level(0, "L5-S1", {10.0, 7.8, 5.5, 1.4}),    level(1, "L4-L5", {8.9, 5.8, 5.7, 2.2}),
    level(2, "L3-L4", {7.5, 3.7, 5.7, 2.6}),     level(3, "L2-L3", {6.5, 4.3, 7.0, 2.6}),
    level(4, "L1-L2", {5.8, 4.3, 4.9, 2.3}),     level(5, "T12-L1", {4.65, 3.9, 4.575, 3.025}),
    level(6, "T11-T12", {3.5, 3.5, 4.25, 3.75}), level(7, "T10-T11", {3.5, 3.5, 4.25, 3.75}),
    level(8, "T9-T10", {3.5, 3.5, 4.25, 5.5}),   level(9, "T8-T9", {3.5, 3.5, 4.25, 5.5}),
    level(10, "T7-T8", {3.5, 3.5, 4.25, 5.5}),   level(11, "T6-T7", {3.5, 3.5, 5.5, 5.5}),
    level(12, "T5-T6", {3.5, 3.5, 5.5, 5.5}),    level(13, "T4-T5", {3.5, 3.5, 5.5, 5.5}),
    level(14, "T3-T4", {3.5, 3.5, 5.5, 5.5}),    level(15, "T2-T3", {3.5, 3.5, 5.5, 5.5}),
    level(16, "T1-T2", {7.0, 7.0, 5.5, 5.5}),
};

}  // namespace

std::span<const SpineLevel> human_levels() { return kLevels; }

RangeOfMotion human_range(double from, double to) {
  RangeOfMotion sum;
  for (const SpineLevel& l : kLevels) {
    const double part =
        std::max(0.0, std::min(to, l.to) - std::max(from, l.from)) / (l.to - l.from);
    sum.flexion += part * l.range.flexion;
    sum.extension += part * l.range.extension;
    sum.side += part * l.range.side;
    sum.axial += part * l.range.axial;
  }
  return sum;
}

std::vector<double> human_twist_density(int count) {
  std::vector<double> density(count);
  for (int i = 0; i < count; ++i) {
    const double s = double(i) / (count - 1);
    const auto at = std::find_if(kLevels.begin(), kLevels.end() - 1,
                                 [&](const SpineLevel& l) { return s < l.to; });
    density[i] = at->range.axial / (at->to - at->from);
  }
  return density;
}

}  // namespace backbend::solver
