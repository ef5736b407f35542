#include "solver/walk.h"

namespace backbend::solver {

Walk walk_from(const Curve& curve, std::span<const double> bone, double from_arc,
               std::vector<glm::dvec3>& joint, std::vector<double>* arc) {
  joint.resize(bone.size() + 1);
  if (arc) arc->assign(bone.size() + 1, from_arc);
  // A curve that is one point goes nowhere: there the chain stays too.
  if (curve.tangent(1.0) == glm::dvec3(0.0)) {
    joint.assign(bone.size() + 1, curve.point(1.0));
    return {from_arc, from_arc};
  }
  Curve::Step step{curve.at_arc(from_arc), from_arc};
  for (std::size_t k = 0;; ++k) {
    joint[k] = step.place.position;
    if (arc) (*arc)[k] = step.arc;
    if (k == bone.size()) break;
    step = curve.step_to_distance(step.place.position, step.arc, bone[k]);
  }
  return {from_arc, step.arc};
}

Walk walk_led(const Curve& curve, const Curve& backwards, std::span<const double> bone, double lead,
              double slide, std::vector<glm::dvec3>& joint, std::vector<double>* arc) {
  double from = slide;
  if (lead > 0.0) {
    const std::vector<double> reversed(bone.rbegin(), bone.rend());
    from += lead * (curve.length() - walk_from(backwards, reversed, 0.0, joint).to_arc);
  }
  return walk_from(curve, bone, from, joint, arc);
}

}  // namespace backbend::solver
