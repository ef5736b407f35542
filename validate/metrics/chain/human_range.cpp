#include "validate/metrics/chain/human_range.h"

#include <algorithm>
#include <array>

namespace backbend::validate {
namespace {

constexpr double kLumbarShare = 0.38;

// From the sacrum up. Thoracic figures are half of the published totals of both directions.
constexpr std::array<MotionRange, 5> kLumbar{{
    {10.0, 7.8, 5.5, 1.4},  // L5-S1
    {8.9, 5.8, 5.7, 2.2},
    {7.5, 3.7, 5.7, 2.6},
    {6.5, 4.3, 7.0, 2.6},
    {5.8, 4.3, 4.9, 2.3},  // L1-L2
}};
constexpr MotionRange kLowerThoracic{3.5, 3.5, 4.25, 3.75};  // T12-L1 .. T10-T11
constexpr MotionRange kMiddleThoracic{3.5, 3.5, 4.25, 5.5};  // T9-T10 .. T7-T8
constexpr MotionRange kUpperThoracic{3.5, 3.5, 5.5, 5.5};    // T6-T7 .. T2-T3
constexpr MotionRange kFirstThoracic{7.0, 7.0, 5.5, 5.5};    // T1-T2
constexpr std::array<MotionRange, 12> kThoracic{kLowerThoracic,  kLowerThoracic,  kLowerThoracic,
                                                kMiddleThoracic, kMiddleThoracic, kMiddleThoracic,
                                                kUpperThoracic,  kUpperThoracic,  kUpperThoracic,
                                                kUpperThoracic,  kUpperThoracic,  kFirstThoracic};

void add(MotionRange& sum, const MotionRange& level, double share) {
  sum.flexion += share * level.flexion;
  sum.extension += share * level.extension;
  sum.lateral += share * level.lateral;
  sum.axial += share * level.axial;
}

template <std::size_t N>
void add_region(MotionRange& sum, const std::array<MotionRange, N>& region, double low, double high,
                double from, double to) {
  const double step = (high - low) / static_cast<double>(N);
  for (std::size_t i = 0; i < N; ++i) {
    const double a = low + step * static_cast<double>(i), b = a + step;
    const double inside = std::min(b, to) - std::max(a, from);
    if (inside > 0.0) add(sum, region[i], inside / step);
  }
}

}  // namespace

MotionRange human_range(double from, double to) {
  MotionRange sum;
  add_region(sum, kLumbar, 0.0, kLumbarShare, from, to);
  add_region(sum, kThoracic, kLumbarShare, 1.0, from, to);
  return sum;
}

RangeUse human_range_use(const solver::SpinePose& pose, const solver::SpinePose& rest,
                         std::span<const double> fraction, const glm::dvec3& left) {
  RangeUse out;
  const std::size_t n = pose.turn.size();
  const auto middle = [&](std::size_t i) {  // of the bone that turn i belongs to
    return i + 1 < n ? 0.5 * (fraction[i] + fraction[i + 1]) : fraction[i];
  };
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double from = middle(i), to = middle(i + 1);
    const glm::dvec3 along = rest.position[i + 1] - rest.position[i];
    if (!(to > from) || glm::length(along) == 0.0) continue;
    const MotionRange range = human_range(from, to);
    // In rest axes of the lower bone: the part about the bone is axial, about left a nod.
    const glm::dvec3 turn = rotation_vector(glm::conjugate(pose.turn[i]) * pose.turn[i + 1]);
    const glm::dvec3 up = glm::normalize(along);
    const glm::dvec3 side = glm::normalize(left - glm::dot(left, up) * up);
    const double nod = degrees(glm::dot(turn, side)), axial = degrees(glm::dot(turn, up)),
                 lateral = degrees(glm::dot(turn, glm::cross(side, up)));
    const struct {
      double used, range;
      std::string_view name;
    } uses[] = {{nod, range.flexion, "flexion"},
                {-nod, range.extension, "extension"},
                {std::abs(lateral), range.lateral, "lateral"},
                {std::abs(axial), range.axial, "axial"}};
    for (const auto& use : uses)
      if (use.range > 0.0 && use.used / use.range > out.ratio)
        out = {use.used / use.range, static_cast<int>(i + 1), use.name};
  }
  return out;
}

}  // namespace backbend::validate
