#include "validate/evidence/image_readings.h"

#include <gtest/gtest.h>

#include <cmath>

#include "validate/calibrate/calibration_body.h"
#include "validate/calibrate/faults.h"
#include "validate/measure/arm_pose.h"

namespace backbend::validate {
namespace {

/// A round body of 24 bones bent backwards, before the cameras.
class Readings : public testing::Test {
 protected:
  Readings()
      : body_(tube_body(24)),
        rig_(body_->stage().build({"even", {{"bones", 48.0}}})),
        photographer_(body_->stage(), render::bounds_of(body_->stage().rest().position)) {
    spine_ = rig_->solve(
        rig_->controls_for({radians_from(40.0), 0.0, 0.0, 0.0}, solver::Mapping::chest));
  }
  PoseViews views(const solver::SpinePose& spine) {
    return take_views(photographer_, body_->stage().pose(*rig_, spine));
  }

  std::unique_ptr<CalibrationBody> body_;
  std::unique_ptr<solver::SpineSystem> rig_;
  Photographer photographer_;
  solver::SpinePose spine_;
};

TEST_F(Readings, OfOnePoseTwiceShowNoDifference) {
  const PoseViews a = views(spine_), b = views(spine_);
  EXPECT_EQ(normal_change(a, b).value, 0.0);
  EXPECT_EQ(normal_change(a, b).pixels, 0.0);
  EXPECT_EQ(tilt_jump(a, b).value, 0.0);
  EXPECT_EQ(narrowing(a, b).value, 0.0);
  EXPECT_EQ(arm_shift(a, b).value, 0.0);
  EXPECT_EQ(outline_shift(a, b).value, 0.0);
}

TEST_F(Readings, ArmShiftGrowsWithTheShift) {
  const auto shifted = [&](double by) {
    solver::SpinePose moved = spine_;
    inject_arm_drift(moved, glm::dvec3(0.0), {0.0, by, 0.0});
    const auto carried_by = [&](const solver::RigidMotion& motion) {
      return take_views(photographer_, pose_with_arms(body_->stage(), *rig_, spine_, motion));
    };
    return arm_shift(carried_by(moved.arms), carried_by(spine_.chest));
  };
  // The body of 1.8 fills a picture 240 pixels high: some 120 of them stand for a length of 1.
  const ImageReading far = shifted(0.1);
  EXPECT_GT(far.value, 6.0);
  EXPECT_LT(far.value, 30.0);
  EXPECT_GT(far.pixels, 0.0);
  EXPECT_FALSE(far.camera.empty());
  EXPECT_NEAR(shifted(0.02).value, 0.2 * far.value, 1.0);
  EXPECT_GT(shifted(0.004).value, 0.2);
}

TEST_F(Readings, ArmsCarriedByTheChestStandWhereTheMeshHasThem) {
  // `even` leaves nothing between the chest control and the chain's end, which the arms hang from.
  EXPECT_LT(arm_shift(take_views(photographer_,
                                 pose_with_arms(body_->stage(), *rig_, spine_, spine_.arms)),
                      views(spine_))
                .value,
            0.05);
}

TEST_F(Readings, ATiltThatJumpsIsAKinkAndAnotherCleanRigHasNone) {
  solver::SpinePose kinked = spine_;
  inject_kink(kinked, rig_->arc_fraction(), 0.5, {radians_from(-20.0), 0.0, 0.0});
  const ImageReading kink = tilt_jump(views(kinked), views(spine_));
  // Of a kink of 20 degrees an eighth of the spine to either side shows most.
  EXPECT_GT(kink.value, 12.0);
  EXPECT_LT(kink.value, 22.0);
  EXPECT_GT(kink.pixels, 0.0);
  const auto other = body_->stage().build({"even", {{"bones", 49.0}}});
  const solver::SpinePose clean = other->solve(
      other->controls_for({radians_from(40.0), 0.0, 0.0, 0.0}, solver::Mapping::chest));
  const PoseViews there = take_views(photographer_, body_->stage().pose(*other, clean));
  EXPECT_LT(tilt_jump(views(spine_), there).value, kVisibleTiltDeg);
}

TEST_F(Readings, NarrowingIsTheShareOfTheWidthThatIsMissing) {
  const BodyMetrics& metrics = body_->metrics();
  PosedCharacter posed = body_->stage().pose(*rig_, spine_);
  const PoseViews clean = take_views(photographer_, posed);
  const SlicePose slices = pose_slices(metrics.slices(), posed.mesh.position);
  inject_slice_loss(posed.mesh.position, slices, 32, 0.36, 0.1);
  // A slice that keeps 64 % of its area keeps 80 % of its width; a row of pixels sees it slanting.
  const double seen = narrowing(take_views(photographer_, posed), clean).value;
  EXPECT_GT(seen, 12.0);
  EXPECT_LT(seen, 30.0);
}

TEST_F(Readings, MotionIsSeenWhereTheOutlineStaysAndAnEvenOneHasNoChange) {
  // A round body that rolls about its own axis looks the same; its surface moves.
  const auto posed = [&](double roll) {
    solver::SpinePose spine = spine_;
    inject_roll(spine, rig_->rest(), rig_->arc_fraction(), 0.3, 0.7, radians_from(roll));
    return body_->stage().pose(*rig_, spine);
  };
  const PosedCharacter a = posed(0.0), b = posed(5.0), c = posed(10.0), popped = posed(40.0);
  const PoseViews at_b = take_views(photographer_, b, &a);
  const PoseViews at_c = take_views(photographer_, c, &b);
  const PoseViews at_popped = take_views(photographer_, popped, &b);
  EXPECT_GT(motion(at_b).value, kVisibleMotionPx);
  EXPECT_LT(motion(take_views(photographer_, a, &a)).value, 1e-3);
  EXPECT_LT(motion_change(at_b, at_c).value, 0.2 * motion(at_c).value);
  EXPECT_GT(motion_change(at_b, at_popped).value, 0.5 * motion(at_popped).value);
}

TEST_F(Readings, AReadingThatNoCameraCanMakeIsNone) {
  const PoseViews posed = views(spine_);
  PoseViews empty = posed;
  for (PoseViews::View& view : empty.view)
    for (render::Layer& layer : view.frame.layers) std::ranges::fill(layer.data, 0.0f);
  EXPECT_TRUE(std::isnan(arm_shift(posed, empty).value));
  EXPECT_TRUE(arm_shift(posed, empty).camera.empty());
  EXPECT_TRUE(std::isnan(outline_shift(posed, empty).value));
}

/// The changes of a sweep that gets faster and faster, with some noise.
std::vector<double> accelerating() {
  std::vector<double> change{0.0};
  for (int i = 1; i < 61; ++i)
    change.push_back(0.5 + 0.0005 * i * i + 0.01 * ((i * 7919) % 11) / 11.0);
  return change;
}

TEST(PopScores, AFastButSmoothSweepHasNone) {
  for (const double score : pop_scores(accelerating())) EXPECT_LT(score, kPopScore);
  std::vector<double> two_speeds = accelerating();
  for (std::size_t i = 30; i < two_speeds.size(); ++i) two_speeds[i] *= 3.0;
  for (const double score : pop_scores(two_speeds)) EXPECT_LT(score, kPopScore);
}

TEST(PopScores, AStepThatStandsOutIsFoundWhereverItIs) {
  for (const std::size_t at : {2u, 3u, 31u, 59u, 60u}) {
    std::vector<double> change = accelerating();
    change[at] += 1.0;
    const std::vector<double> score = pop_scores(change);
    for (std::size_t i = 0; i < score.size(); ++i)
      EXPECT_EQ(score[i] > kPopScore, i == at) << i << " of a jump at " << at;
  }
}

TEST(PopScores, AQuietSweepDoesNotMakeAWhisperAPop) {
  std::vector<double> change(40, 0.2);
  change[20] += 0.9 * kLeastPopPx;
  for (const double score : pop_scores(change)) EXPECT_LT(score, kPopScore);
  change[20] = 0.2 + 1.1 * kLeastPopPx;
  EXPECT_GT(pop_scores(change)[20], kPopScore);
  EXPECT_TRUE(pop_scores({}).empty());
  // Eleven poses have nine motions' changes: too few to say what is usual.
  EXPECT_EQ(pop_scores(std::vector<double>{0, 0, 1, 1, 1, 9, 1, 1, 1, 1, 1}),
            std::vector<double>(11, 0.0));
}

}  // namespace
}  // namespace backbend::validate
