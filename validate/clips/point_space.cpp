#include "validate/clips/point_space.h"

#include <algorithm>
#include <cmath>

#include "validate/metrics/surface/rigid_fit.h"
#include "validate/sweeps/sweep.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

// Body lengths over cache lengths.
constexpr double kUnits[] = {1.0, 0.01, 100.0, 0.001, 1000.0, 0.0254, 1.0 / 0.0254, 0.1, 10.0};
constexpr double kNearUnit = 1.25;
// Turned by more than this from its own axes, and by less from the others, a body stands in those.
constexpr double kTurnedDeg = 60.0, kNearDeg = 45.0;

/// (x, y, z) with +Z up and -Y ahead is (x, z, -y) with +Y up and +Z ahead.
const glm::dmat3 kFromZUp(1, 0, 0, 0, 0, -1, 0, 1, 0);

const PointSpace& find_space(double scale, bool z_up) {
  for (const PointSpace& each : point_spaces())
    if (each.scale == scale && (each.turn != glm::dmat3(1.0)) == z_up) return each;
  return point_spaces().front();
}

}  // namespace

const std::vector<PointSpace>& point_spaces() {
  static const std::vector<PointSpace> spaces = [] {
    std::vector<PointSpace> out;
    for (const bool z_up : {false, true})
      for (const double unit : kUnits) {
        PointSpace& space = out.emplace_back();
        space.scale = unit;
        std::string what;
        if (z_up) {
          space.turn = kFromZUp;
          what = "+Z is taken for up";
        }
        if (unit != 1.0)
          what += (what.empty() ? "" : ", and ") + std::string("lengths ") + number_text(unit, 4) +
                  " times";
        if (!what.empty())
          space.note = "the cache has other axes or another unit than the body: " + what;
      }
    return out;
  }();
  return spaces;
}

const PointSpace& space_in_order(std::span<const glm::vec3> rest, std::span<const glm::vec3> frame,
                                 double length_ratio) {
  double scale = 1.0, nearest = kNearUnit;
  for (const double unit : kUnits) {
    const double off = std::max(unit * length_ratio, 1.0 / (unit * length_ratio));
    if (off < nearest) {
      nearest = off;
      scale = unit;
    }
  }
  std::vector<glm::dvec3> from, to;
  for (Index v = 0; v < rest.size(); ++v) {
    from.emplace_back(rest[v]);
    to.emplace_back(scale * glm::dvec3(frame[v]));
  }
  const glm::dquat turn = fit_rigid(from, to, std::vector<double>(from.size(), 1.0)).turn;
  const glm::dquat z_up = glm::conjugate(glm::quat_cast(kFromZUp));  // from the body's axes
  const bool is_z_up = degrees(angle_between(turn, glm::dquat(1, 0, 0, 0))) > kTurnedDeg &&
                       degrees(angle_between(turn, z_up)) < kNearDeg;
  return find_space(scale, is_z_up);
}

}  // namespace backbend::validate
