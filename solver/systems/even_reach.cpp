#include "solver/systems/even_reach.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "solver/math/rotation.h"

namespace backbend::solver {
namespace {

using glm::dvec3;

// Square of the damping, in spine lengths: smaller reaches further and turns faster. At 1/32 a Top
// bend of 150 degrees on ten bones comes back to about a third of its gap.
constexpr double kDamping = 1.0 / 32.0;
// Gaps are taken in full while small and never beyond half a spine length.
constexpr double kFarthestGap = 0.5;
// The last part of a joint's room is given out ever more slowly, so that it ends without a corner.
const double kSoftRoom = radians(5.0);
// Rounds off |angle| at 0 from above.
const double kSoftAngle = radians(0.5);

/// x / (1 + (|x| / most)^4)^(1/4): x while small, never longer than `most`, Lipschitz 1 in x and in
/// `most`.
template <class Vector>
double saturation(const Vector& squared, double most) {
  const double ratio = squared / (most * most);
  return 1.0 / std::sqrt(std::sqrt(1.0 + ratio * ratio));
}

double soft_size(double angle) { return std::sqrt(angle * angle + kSoftAngle * kSoftAngle); }

}  // namespace

double reach_bump(int which, double s) {
  const double u = s * (1.0 - s);
  const double lean = 16.0 * u * u;
  return which == 0 ? lean : lean * 2.0 * (1.0 - 2.0 * s);
}

glm::dvec3 ReachField::at(double s) const {
  return reach_bump(0, s) * v[0] + reach_bump(1, s) * v[1];
}

EvenReach::EvenReach(double reach, double max_joint, const std::array<double, 6>& peak_step,
                     int bones)
    : reach_(reach), max_joint_(max_joint), peak_step_(peak_step) {
  for (int k = 0; k <= bones; ++k) {
    const double from = k == 0 ? 0.0 : (k - 0.5) / bones;
    const double to = k == bones ? 1.0 : (k + 0.5) / bones;
    bump_step_ = std::max(bump_step_, std::hypot(reach_bump(0, to) - reach_bump(0, from),
                                                 reach_bump(1, to) - reach_bump(1, from)));
  }
}

double EvenReach::room(const std::array<double, 6>& upper) const {
  double left = max_joint_;
  for (int ch = 0; ch < 6; ++ch) left -= peak_step_[ch] * soft_size(upper[ch]);
  if (!(left > 0.0)) return 0.0;
  return left * (left / (left + kSoftRoom)) / bump_step_;
}

ReachField EvenReach::field(const dvec3& gap, const std::array<dvec3, 2>& moment,
                            const std::array<double, 6>& upper) const {
  ReachField field;
  const double most = room(upper);
  if (off() || most == 0.0) return field;
  const dvec3 step = (reach_ * saturation(glm::dot(gap, gap), kFarthestGap)) * gap;
  glm::dmat3 normal(kDamping);
  for (const dvec3& m : moment) {
    normal += glm::dmat3(glm::dot(m, m)) - glm::outerProduct(m, m);
  }
  const dvec3 pull = glm::inverse(normal) * step;
  for (int i = 0; i < 2; ++i) field.v[i] = glm::cross(moment[i], pull);
  const double held =
      saturation(glm::dot(field.v[0], field.v[0]) + glm::dot(field.v[1], field.v[1]), most);
  for (dvec3& v : field.v) v *= held;
  return field;
}

double EvenReach::joint_share(const ReachField& field) const {
  return bump_step_ *
         std::sqrt(glm::dot(field.v[0], field.v[0]) + glm::dot(field.v[1], field.v[1]));
}

double EvenReach::gain_bound(int channel, const EvenWeight& weight, double lever) const {
  if (off()) return 1.0;
  // Midpoint sums of smooth functions on 0..1; 1e-3 of them is far above their error.
  constexpr int kSteps = 2000;
  double chest = 0.0, moment[2] = {0.0, 0.0};
  for (int i = 0; i < kSteps; ++i) {
    const double s = (i + 0.5) / kSteps, w = weight(s) / kSteps;
    chest += w;
    for (int b = 0; b < 2; ++b) moment[b] += w * std::abs(reach_bump(b, s));
  }
  const double step_rate = reach_ * (chest + lever);
  const double step_most = reach_ * kFarthestGap;
  const double field_rate = step_rate / (2.0 * std::sqrt(kDamping)) +
                            1.25 * std::hypot(moment[0], moment[1]) * step_most / kDamping;
  return 1.0 + 1.001 * field_rate + peak_step_[channel] / bump_step_;
}

}  // namespace backbend::solver
