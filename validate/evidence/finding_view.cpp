#include "validate/evidence/finding_view.h"

#include <algorithm>
#include <cmath>

namespace backbend::validate {

render::Facing FindingView::facing(const render::Facing& body) const {
  return opposite ? render::Facing{body.up, -body.forward} : body;
}

FindingView view_of(const PoseDegrees& pose, const Finding& finding) {
  // What a human can do, degrees: a side bend of 45 is as much as an extension of 60.
  constexpr double kBend = 60.0, kSide = 45.0, kTwist = 60.0;
  const double bend =
      std::max({std::abs(pose.extension), std::abs(pose.flexion), std::abs(pose.hip)}) / kBend;
  const double side = std::abs(pose.side) / kSide, twist = std::abs(pose.twist) / kTwist;
  const bool right = finding.side == "right", front = finding.side == "front";
  if (twist > bend && twist > side) {
    // The camera stands behind the left shoulder; its opposite before the right one.
    const bool opposite = front || right;
    return {"three_quarter", opposite, opposite ? "front three-quarter" : "three-quarter"};
  }
  if (side > bend)
    return front ? FindingView{"front", false, "front"} : FindingView{"back", false, "back"};
  return {"profile", right, right ? "right profile" : "profile"};
}

}  // namespace backbend::validate
