#include "validate/calibrate/body_poses.h"

#include <algorithm>
#include <cmath>

namespace backbend::validate {
namespace {

// Poses nearer than this to folding are not clean, whatever the rig does.
constexpr double kFeasible = 0.9;

constexpr int kMostBones = 64;  // of `even`

}  // namespace

std::unique_ptr<solver::SpineSystem> BodyPoses::build(int bones) const {
  return body_.stage().build({"even", {{"bones", static_cast<double>(bones)}}});
}

BodyPoses::BodyPoses(const CalibrationBody& body)
    : body_(body),
      // Joints at least twice as fine as the body's own: a fault between two of those is whole.
      rig_(build(std::clamp(2 * body.bones(), 20, kMostBones - 1))),
      other_(build(std::clamp(2 * body.bones(), 20, kMostBones - 1) + 1)),
      rig_rest_(rig_at_rest(*rig_)),
      other_rest_(rig_at_rest(*other_)) {}

Case BodyPoses::draw_case(Draw& draw) const {
  Case c;
  // A body as thick as a ball is asked for less and less.
  for (double share = 1.0;; share *= 0.9) {
    const solver::BodyPose wide = random_pose(draw);
    c.pose = {share * wide.extension, share * wide.flexion, share * wide.side, share * wide.twist};
    c.control = rig_->controls_for(c.pose, solver::Mapping::chest);
    c.chain = rig_->solve(c.control);
    c.clean = measure(c, posed(c).mesh);
    if (c.clean.slices.infeasible < kFeasible || share < 0.01) return c;
  }
}

// No detector reads crossings.
BodyMeasures BodyPoses::measure(const Case& c, const skin::PosedMesh& mesh) const {
  return body_.metrics().measure(rig_rest_, c.control, c.chain, mesh, c.pose.twist, false,
                                 Crossing::left_out);
}

PosedCharacter BodyPoses::posed_by_other(const Case& c) const {
  return body_.stage().pose(*other_, other_->controls_for(c.pose, solver::Mapping::chest));
}

BodyMeasures BodyPoses::measure_other(const Case& c, const PosedCharacter& other) const {
  const std::vector<double> control = other_->controls_for(c.pose, solver::Mapping::chest);
  return body_.metrics().measure(other_rest_, control, other.spine, other.mesh, c.pose.twist, false,
                                 Crossing::left_out);
}

FaultPlace BodyPoses::fault_place(Draw& draw) const {
  const int bones = body_.bones();
  const int lowest = std::max(1, static_cast<int>(std::ceil(0.3 * bones)));
  const int highest = std::max(lowest, static_cast<int>(std::floor(0.7 * bones)));
  const std::size_t joint =
      static_cast<std::size_t>(lowest) + draw.index(static_cast<std::size_t>(highest - lowest + 1));
  // Bones need not be of one length: a stretch of the mean length may hold no joint at all.
  const std::vector<double>& fraction = body_.driver().joint_fractions();
  return {0.5 * (fraction[joint - 1] + fraction[joint]),
          0.5 * (fraction[joint] + fraction[joint + 1]), fraction[joint]};
}

}  // namespace backbend::validate
