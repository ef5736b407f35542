// A small version of hunt_battery: one planted fault of each kind, and a sound rig.
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include "skin/body/body.h"
#include "tests/battery/body_variants.h"
#include "tests/battery/pose_faults.h"
#include "tests/skin/body_figure.h"
#include "validate/hunt/hunt.h"
#include "validate/sweeps/named_pose.h"

namespace backbend::battery {
namespace {

using namespace validate;

/// `even` on a small figure, in the box of a human's envelope.
class HuntFaults : public ::testing::Test {
 protected:
  static const Stage& stage() {
    static const std::unique_ptr<const Stage> made = [] {
      skin::AnatomyHints hints;
      hints.hip = "hips";
      hints.chest = "chest";
      return std::make_unique<const Stage>(skin::make_body(skin::figure()), hints);
    }();
    return *made;
  }
  static const BodyMetrics& body() {
    static const BodyMetrics made(stage().character(), stage().anatomy(), stage().driver());
    return made;
  }

  std::unique_ptr<solver::SpineSystem> sound() const { return stage().build(plan_.spec); }

  Hunt hunt(const PoseFault* fault, const std::string& check, std::size_t evaluations = 2500,
            std::uint64_t seed = 1) const {
    const HuntScene scene{
        stage(),   body(),
        envelope_, limits_,
        plan_,     solver::Mapping::chest,
        "figure",  [&] {
                            return fault ? with_fault(sound(), box_, *fault) : sound(); }};
    Progress silent(Progress::Style::none);
    return hunt_poses(scene, {box_, check, evaluations, seed}, silent);
  }

  /// The fault as strong as makes it pass the limit at its edge; small, so in proportion.
  PoseFault fitted(PoseFault fault) const {
    const double limit = limits_.of(fault.code).value;
    double low = 0.0, high = 1.0;
    for (int i = 0; i < 40; ++i) {
      fault.amount = 0.5 * (low + high);
      (value_at(fault, fault.edge) < limit ? low : high) = fault.amount;
    }
    return fault;
  }
  double value_at(const PoseFault& fault, const std::vector<double>& at) const {
    const auto system = with_fault(sound(), box_, fault);
    PoseRecord pose;
    pose.body = box_.pose_at(at);
    pose.control = controls_at(*system, pose.body, solver::Mapping::chest);
    measure_chain_pose(rig_at_rest(*system), pose);
    return pose
        .at(fault.code == "BB010"   ? MetricId::chain_kink
            : fault.code == "BB014" ? MetricId::chain_twist_jump
                                    : MetricId::arm_drift)
        .value;
  }

  static constexpr double kShare = 2e-5;  // of the box: 5 of 100 random searches as long find it
  const Envelope envelope_ = *find_envelope("human");
  const ControlBox box_ = find_box("envelope", envelope_);
  const LimitSet limits_;
  const RigPlan plan_{"even", {"even", {}}, Role::proposed, std::nullopt};
};

TEST_F(HuntFaults, ACornerThatFlipsAndHoldsIsFoundWithItsBorder) {
  Draw draw(4, 1);
  const PoseFault fault = draw_corner_flip(3, kShare, sound()->rest().joint_count(), draw);
  const Hunt found = hunt(&fault, "BB001");
  ASSERT_EQ(found.finds.size(), 1u);
  const HuntFind& find = found.finds.front();
  EXPECT_EQ(find.finding.code, "BB001");
  EXPECT_EQ(find.finding.joint, sound()->joint_names()[fault.joint]);
  EXPECT_NEAR(find.finding.value, glm::degrees(fault.amount), 0.5);
  // The path crosses the border.
  EXPECT_NE(fault.strength(box_.point_of(find.from)), fault.strength(box_.point_of(find.pose)));
  EXPECT_TRUE(find.finding.inside_envelope);
}

TEST_F(HuntFaults, ABumpAndARidgeAreClimbed) {
  for (const std::uint64_t seed : {1, 2}) {
    for (const bool ridge : {false, true}) {
      Draw draw(seed, ridge ? 2 : 1);
      const std::size_t joints = sound()->rest().joint_count();
      const PoseFault fault = fitted(ridge ? draw_ridge(kShare, 0.1, joints, draw)
                                           : draw_bump(kShare, 0.1, joints, draw));
      const Hunt found = hunt(&fault, fault.code);
      ASSERT_EQ(found.finds.size(), 1u) << fault.kind << " " << fault.code << " " << seed;
      EXPECT_GE(fault.strength(box_.point_of(found.finds.front().pose)), fault.level);
    }
  }
}

TEST_F(HuntFaults, ASoundRigHasNone) {
  const Hunt found = hunt(nullptr, "", 1000);
  for (const HuntFind& find : found.finds)
    EXPECT_NE(find.finding.owner, Owner::solver)
        << find.finding.code << " " << find.finding.value << " " << find.finding.detail;
  EXPECT_LE(found.evaluations, 1000u);
  EXPECT_GT(found.worst.size(), 10u);
}

TEST_F(HuntFaults, AFindIsWhatMeasuringItsNamedPoseSays) {
  Draw draw(1, 1);
  PoseFault fault = draw_bump(1e-3, 0.1, sound()->rest().joint_count(), draw);
  fault.code = "BB020";
  fault = fitted(fault);
  const Hunt found = hunt(&fault, "BB020");
  ASSERT_EQ(found.finds.size(), 1u);
  const HuntFind& find = found.finds.front();
  RigRecord rig = plan_rig(stage(), body(), plan_, solver::Mapping::chest,
                           {named_pose("tomorrow", {}, find.pose)}, envelope_);
  rig.system = with_fault(sound(), box_, fault);
  Progress silent(Progress::Style::none);
  measure_poses(stage(), body(), rig, rig_at_rest(*rig.system), rig.sweeps.front().poses, silent);
  EXPECT_EQ(rig.sweeps.front().poses.back().at(MetricId::arm_drift).value, find.finding.value);
  // A region of so many degrees about its pose: a ball of radius 0.062 of each axis.
  for (const BoxAxis& axis : box_.axes) {
    EXPECT_GT(find.width_deg.at(axis.name), 0.08 * axis.width()) << axis.name;
    EXPECT_LT(find.width_deg.at(axis.name), 0.14 * axis.width()) << axis.name;
  }
}

TEST_F(HuntFaults, TheSameIsFoundByAnyNumberOfThreads) {
  Draw draw(7, 1);
  const PoseFault fault = draw_corner_flip(3, 1e-4, sound()->rest().joint_count(), draw);
  const auto words_with = [&](std::size_t threads) {
    const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism,
                                            threads);
    std::string words;
    for (const HuntFind& find : hunt(&fault, "", 600).finds)
      words += find.finding.code + " " + pose_words(find.from) + " " + pose_words(find.pose) + " " +
               std::to_string(find.finding.value) + "\n";
    return words;
  };
  const std::string one = words_with(1);
  EXPECT_FALSE(one.empty());
  EXPECT_EQ(one, words_with(3));
}

}  // namespace
}  // namespace backbend::battery
