#include "solver/curves/walk.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "solver/math/rotation.h"

namespace backbend::solver {
namespace {

/// Of WalkDetail, for one bone from `from` to where it meets the curve.
double meeting_margin(const glm::dvec3& from, const CurvePoint& meeting) {
  const glm::dvec3 bone = meeting.position - from;
  const double length = glm::length(bone);
  if (!(length > 0.0)) return kPi;
  const double slant = 2.0 * std::max(0.0, glm::dot(bone, meeting.tangent) / length);
  return kPi * std::min(1.0, slant * slant);
}

}  // namespace

Walk walk_from(const Curve& curve, std::span<const double> bone, double from_arc,
               std::vector<glm::dvec3>& joint, WalkDetail* detail) {
  joint.resize(bone.size() + 1);
  if (detail) {
    detail->arc.assign(bone.size() + 1, from_arc);
    detail->margin.assign(bone.size() + 1, kPi);
  }
  // A curve that is one point goes nowhere: there the chain stays too.
  if (curve.tangent(1.0) == glm::dvec3(0.0)) {
    joint.assign(bone.size() + 1, curve.point(1.0));
    return {from_arc, from_arc};
  }
  Curve::Step step{curve.at_arc(from_arc), from_arc};
  for (std::size_t k = 0;; ++k) {
    joint[k] = step.place.position;
    if (detail) {
      detail->arc[k] = step.arc;
      if (k > 0) {
        detail->margin[k] =
            std::min(detail->margin[k - 1], meeting_margin(joint[k - 1], step.place));
      }
    }
    if (k == bone.size()) break;
    step = curve.step_to_distance(step.place.position, step.arc, bone[k]);
  }
  return {from_arc, step.arc};
}

Walk walk_led(const Curve& curve, const Curve& backwards, std::span<const double> bone, double lead,
              double slide, std::vector<glm::dvec3>& joint, WalkDetail* detail) {
  double from = slide, back_margin = kPi;
  if (lead > 0.0) {
    const std::vector<double> reversed(bone.rbegin(), bone.rend());
    from += lead * (curve.length() - walk_from(backwards, reversed, 0.0, joint, detail).to_arc);
    if (detail) back_margin = detail->margin.back();
  }
  const Walk walk = walk_from(curve, bone, from, joint, detail);
  if (detail) {
    for (double& margin : detail->margin) margin = std::min(margin, back_margin);
  }
  return walk;
}

}  // namespace backbend::solver
