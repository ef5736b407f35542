#include "solver/systems/three_bone.h"

#include <cassert>

#include "solver/curves/box_course.h"
#include "solver/curves/curve.h"
#include "solver/math/rotation.h"
#include "solver/rig/box_solver.h"
#include "solver/rig/chain_measures.h"
#include "solver/rig/option_reader.h"
#include "solver/systems/fk_bones.h"
#include "solver/systems/system_base.h"

namespace backbend::solver {
namespace {

class ThreeBone final : public SystemBase, public BoxSolver {
 public:
  ThreeBone(const SystemSpec& spec, const RestChain& chain) : bones_(chain, spec.system) {
    name_ = spec.system;
    options_ = OptionReader(spec).finish();
    for (const char* control : {"lower", "middle", "top"}) add_rotation(control);
    name_chain({"lower", "middle", "top", "tip"});
    fill(bones_.rest, Detail::all, rest_);
    measure_arc_fraction();
  }

  SpinePose solve(std::span<const double> control) const override {
    SpinePose pose;
    solve_into(control, Detail::all, pose);
    return pose;
  }

  void solve_into(std::span<const double> control, Detail detail, SpinePose& pose) const override {
    assert(control.size() == channels_.size());
    fill(bones_.pose(control), detail, pose);
  }

  std::vector<double> controls_for(const BodyPose& body, Mapping mapping) const override {
    return fk_controls_for(body, mapping);
  }

  std::vector<BoxReal> controls_for(const BodyBox& body, Mapping mapping) const override {
    return fk_controls(body.twist, -body.side, -body.back, mapping);
  }

  void solve_box(std::span<const BoxReal> control, BoxPose& pose) const override {
    const FkBones::BoxPose bones = bones_.pose(control);
    const BoxTurn& top = bones.turn[2];
    pose.rate = {bones.turn[0].rate, bones.turn[1].rate, top.rate, top.rate};
  }

  std::string why_no_places() const override { return {}; }

  void place_box(std::span<const BoxReal> control, BoxPlaces& places) const override {
    const FkBones::BoxPose bones = bones_.pose(control);
    const BoxTurn& top = bones.turn[2];
    places.turn = {bones.turn[0], bones.turn[1], top, top};
    places.position.assign(bones.joint.begin(), bones.joint.end());
    places.hip = {BoxTurn(), bones_.rest.joint[0], bones.joint[0]};
    places.chest = places.arms = {top, bones_.rest.joint[3], bones.joint[3]};
    places.ends_on_chest = places.arms_follow_chest = true;
  }

  std::string why_no_course() const override { return {}; }

  void course_over(const BodyBox& body, Mapping mapping, std::size_t points,
                   BoxCourse& course) const override {
    const FkBones::BoxPose bones = bones_.pose_from_middle(controls_for(body, mapping));
    const auto step = FkBones::five_steps(bones);
    course = held_course(BoxTangents(bspline_legs({step.begin(), step.end()}), 64), points,
                         arc_fraction_, {bones.bone.begin(), bones.bone.end()},
                         {bones.turn.begin(), bones.turn.end()});
  }

  std::string_view why_without(BodyChannel channel) const override {
    return channel == BodyChannel::hip ? kNoHipControl : "its controls turn and do not move";
  }

  /// Three bones have no curve of their own. What an animator means by them is the smooth line
  /// that the thesis draws: the clamped cubic B-spline of root, bone centres and tip.
  std::vector<glm::dvec3> intended_curve(std::span<const double> control,
                                         std::size_t count) const override {
    return equal_arc_points(Curve::bspline(FkBones::five_points(bones_.pose(control))), count);
  }

 private:
  void fill(const FkBones::Pose& bones, Detail detail, SpinePose& pose) const {
    pose.position.assign(bones.joint.begin(), bones.joint.end());
    pose.turn.assign({bones.turn[0], bones.turn[1], bones.turn[2], bones.turn[2]});
    pose.flip_margin.clear();  // forward kinematics has no singular pose
    pose.flags.clear();
    pose.hip = {kNoTurn, bones_.rest.joint[0], bones.joint[0]};
    pose.chest = {bones.turn[2], bones_.rest.joint[3], bones.joint[3]};
    pose.arms = pose.chest;
    MeasureWriter measures(pose);
    if (detail == Detail::all) add_chain_measures(pose.position, measures);
  }

  FkBones bones_;
};

}  // namespace

std::unique_ptr<SpineSystem> build_three_bone(const SystemSpec& spec, const RestChain& chain) {
  return std::make_unique<ThreeBone>(spec, chain);
}

}  // namespace backbend::solver
