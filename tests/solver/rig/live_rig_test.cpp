// Rigs that follow, or do not, the chain they were drawn on: R28 and W5 of research/seeds.md.
#include "solver/rig/live_rig.h"

#include <algorithm>
#include <cmath>

#include "solver/rig/solve_file.h"
#include "tests/solver/rig_fixture.h"

namespace backbend::solver {
namespace {

using namespace rigs;

RestChain scaled(RestChain chain, double by) {
  for (dvec3& p : chain.joint) p *= by;
  return chain;
}

/// Pose E on the three controls, what else a system has at rest.
std::vector<double> pose_e_of(const SpineSystem& system) {
  std::vector<double> control = rest_controls(system);
  const std::vector<double> e = pose_e();
  std::copy(e.begin(), e.end(), control.begin());
  return control;
}

std::string as_file(const LiveRig& rig) {
  return pose_to_json(rig.system(), rig.system().solve(pose_e_of(rig.system())));
}

TEST(LiveRig, AFrozenRigForgetsTheDrawingAndALiveOneFollowsIt) {  // R28
  LiveRig frozen({"curve", {}}, straight());
  LiveRig live({"curve", {}}, straight(), Drawing::live);
  const std::string before = as_file(frozen);
  EXPECT_EQ(as_file(live), before);
  EXPECT_FALSE(frozen.redraw(curved()));
  EXPECT_TRUE(live.redraw(curved()));
  EXPECT_EQ(as_file(frozen), before);
  EXPECT_NE(as_file(live), before);
  EXPECT_EQ(as_file(live), as_file(LiveRig({"curve", {}}, curved())));
}

TEST(LiveRig, TwiceTheChainIsTwiceTheRigUnderTheSameNames) {  // W5
  for (const char* system : {"three_bone", "curve", "even"}) {
    LiveRig rig({system, {}}, curved(), Drawing::live);
    const SpinePose before = rig.system().solve(pose_e_of(rig.system()));
    const auto names = rig.system().joint_names();
    const auto fractions = rig.system().arc_fraction();
    ASSERT_TRUE(rig.redraw(scaled(curved(), 2.0)));
    const SpinePose after = rig.system().solve(pose_e_of(rig.system()));
    for (std::size_t i = 0; i < before.joint_count(); ++i) {
      expect_near(after.position[i], 2.0 * before.position[i], 1e-9);
      EXPECT_LT(angle_between(after.turn[i], before.turn[i]), 1e-9);
    }
    EXPECT_EQ(rig.system().joint_names(), names);
    EXPECT_EQ(rig.system().arc_fraction(), fractions);  // what places joints and their weights
  }
}

TEST(LiveRig, ForgetsEveryEarlierDrawing) {
  LiveRig rig({"even", {}}, straight(), Drawing::live);
  const std::string before = as_file(rig);
  for (const double by : {3.0, 0.25, 7.0}) EXPECT_TRUE(rig.redraw(scaled(curved(), by)));
  EXPECT_TRUE(rig.redraw(straight()));
  EXPECT_EQ(as_file(rig), before);
}

TEST(LiveRig, IsNotBuiltAnewForTheSameChain) {
  LiveRig rig({"even", {}}, straight(), Drawing::live);
  const SpineSystem* built = &rig.system();
  EXPECT_FALSE(rig.redraw(straight()));
  EXPECT_EQ(&rig.system(), built);
  RestChain turned = straight();
  turned.left = {0, 0, 1};
  EXPECT_TRUE(rig.redraw(turned));
}

TEST(LiveRig, StaysAsItWasWhereNoRigCanBeBuilt) {
  LiveRig rig({"curve", {}}, straight(), Drawing::live);
  const std::string before = as_file(rig);
  EXPECT_THROW(rig.redraw({.joint = {{0, 0, 0}, {0, 0, 0}}}), RigError);
  RestChain broken = straight();
  broken.joint[1].x = std::nan("");
  EXPECT_THROW(rig.redraw(broken), RigError);
  EXPECT_EQ(as_file(rig), before);
  EXPECT_EQ(rig.chain().joint, straight().joint);
}

TEST(LiveRig, RefusesADrawingThatWouldRenameItsJoints) {
  // The neck has one vertebra per drawn joint.
  LiveRig neck({"neck", {}}, straight(), Drawing::live);
  const std::size_t count = neck.system().rest().joint_count();
  RestChain longer = straight();
  longer.joint.push_back({0, 8, 0});
  EXPECT_THROW(neck.redraw(longer), RigError);
  EXPECT_EQ(neck.system().rest().joint_count(), count);
}

}  // namespace
}  // namespace backbend::solver
