#include "validate/calibrate/calibrate.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>

#include "tests/temporary_folder.h"
#include "validate/calibrate/faults.h"
#include "validate/metrics/chain/rig_probe.h"
#include "validate/metrics/math/nan.h"

namespace backbend::validate {
namespace {

TEST(Draw, IsTheSameEverywhereAndSpreadsEvenly) {
  Draw draw(7, 3);
  EXPECT_EQ(draw.uniform(0.0, 1.0), Draw(7, 3).uniform(0.0, 1.0));
  EXPECT_NE(Draw(7, 3).uniform(0.0, 1.0), Draw(7, 4).uniform(0.0, 1.0));
  EXPECT_NE(Draw(7, 3).uniform(0.0, 1.0), Draw(8, 3).uniform(0.0, 1.0));
  double sum = 0.0, square = 0.0;
  constexpr int kCount = 20000;
  for (int i = 0; i < kCount; ++i) {
    const double x = draw.uniform(0.0, 1.0);
    sum += x;
    square += x * x;
  }
  // Standard errors: 0.29 / sqrt(20000) = 0.002.
  EXPECT_NEAR(sum / kCount, 0.5, 0.01);
  EXPECT_NEAR(square / kCount, 1.0 / 3.0, 0.01);
}

TEST(ThresholdFrom, StandsAQuarterAboveTheLargestAndNeverBelowItsFloor) {
  EXPECT_EQ(threshold_from({0.1, 0.4, 0.2}, 0.1), 0.5);
  EXPECT_EQ(threshold_from({0.0, 0.01}, 0.1), 0.1);
  EXPECT_TRUE(std::isnan(threshold_from({0.1, kNan}, 0.1)));
  EXPECT_TRUE(std::isnan(threshold_from({}, 0.1)));
}

TEST(RocArea, IsTheChanceThatAFaultReadsHigher) {
  EXPECT_EQ(roc_area({1, 2, 3}, {4, 5}), 1.0);
  EXPECT_EQ(roc_area({4, 5}, {1, 2}), 0.0);
  EXPECT_EQ(roc_area({1, 2}, {1, 2}), 0.5);
  EXPECT_EQ(roc_area({1, 3}, {2}), 0.5);
  EXPECT_EQ(roc_area({1, 2}, {kNan}), 0.0);
  EXPECT_TRUE(std::isnan(roc_area({}, {1})));
}

TEST(JudgeDetector, FindsTheSmallestSizeFromWhichAllAreFound) {
  const std::vector<double> clean(500, 0.1);
  const FaultTrial one{1.0, std::vector<double>(100, 0.2), 0},
      two{2.0, std::vector<double>(100, 0.9), 90}, four{4.0, std::vector<double>(100, 2.0), 100};
  Sensitivity s = judge_detector("d", "BB010", "b", "deg", 2.0, 0.5, clean, {four, one, two});
  EXPECT_EQ(s.smallest, 2.0);
  EXPECT_EQ(s.false_alarms, 0u);
  EXPECT_TRUE(s.ok());
  ASSERT_EQ(s.hits.size(), 3u);
  EXPECT_EQ(s.hits[1].found, 100u);
  EXPECT_EQ(s.hits[1].placed, 90u);

  FaultTrial hole = four;  // a larger fault that is missed spoils the smaller ones
  hole.value.assign(100, 0.1);
  s = judge_detector("d", "BB010", "b", "deg", 2.0, 0.5, clean, {one, two, hole});
  EXPECT_TRUE(std::isnan(s.smallest));
  EXPECT_FALSE(s.ok());
}

TEST(JudgeDetector, AFalseAlarmOrAnUnmeasuredCleanPoseIsNeverOk) {
  const FaultTrial found{1.0, std::vector<double>(100, 0.9), 100};
  std::vector<double> clean(500, 0.1);
  EXPECT_TRUE(judge_detector("d", "c", "b", "deg", 1.0, 0.5, clean, {found}).ok());
  clean[3] = 0.6;
  EXPECT_EQ(judge_detector("d", "c", "b", "deg", 1.0, 0.5, clean, {found}).false_alarms, 1u);
  clean[3] = kNan;
  EXPECT_FALSE(judge_detector("d", "c", "b", "deg", 1.0, 0.5, clean, {found}).ok());
  clean[3] = 0.1;
  EXPECT_FALSE(judge_detector("d", "c", "b", "deg", 1.0, kNan, clean, {found}).ok());
}

/// A straight chain of ten bones with its fractions.
struct Straight {
  solver::SpinePose pose;
  std::vector<double> fraction;
  Straight() {
    for (int i = 0; i <= 10; ++i) {
      pose.position.push_back({0.0, 0.1 * i, 0.0});
      pose.turn.emplace_back(1, 0, 0, 0);
      fraction.push_back(0.1 * i);
    }
    pose.chest = pose.arms = {{1, 0, 0, 0}, {0, 1, 0}, {0, 1, 0}};
  }
};

TEST(InjectKink, BendsOneJointAndKeepsTheWholeBend) {
  Straight s;
  inject_kink(s.pose, s.fraction, 0.5, {radians_from(10.0), 0, 0});
  const glm::dvec3 first = s.pose.position[1] - s.pose.position[0];
  const glm::dvec3 last = s.pose.position[10] - s.pose.position[9];
  EXPECT_NEAR(degrees(angle_between(first, glm::dvec3(0, 1, 0))), 0.0, 1e-9);
  // Ten parts are taken off at joints 1 .. 10, the tenth at the tip, which bends no bone.
  EXPECT_NEAR(degrees(angle_between(last, glm::dvec3(0, 1, 0))), 1.0, 1e-9);
  EXPECT_NEAR(degrees(angle_between(s.pose.turn[10], glm::dquat(1, 0, 0, 0))), 0.0, 1e-9);
  EXPECT_NEAR(degrees(angle_between(s.pose.chest.turn, glm::dquat(1, 0, 0, 0))), 0.0, 1e-9);
  EXPECT_NEAR(chain_length(s.pose.position), 1.0, 1e-12);
  const auto turn = [&](int i) {
    return degrees(angle_between(s.pose.position[i] - s.pose.position[i - 1],
                                 s.pose.position[i + 1] - s.pose.position[i]));
  };
  EXPECT_NEAR(turn(5), 9.0, 1e-9);
  EXPECT_NEAR(turn(4), 1.0, 1e-9);
}

TEST(InjectRoll, TurnsOnlyTheJointsBetween) {
  Straight s;
  const solver::SpinePose rest = s.pose;
  inject_roll(s.pose, rest, s.fraction, 0.35, 0.55, radians_from(7.0));
  for (int i = 0; i <= 10; ++i)
    EXPECT_NEAR(degrees(angle_between(s.pose.turn[i], rest.turn[i])), i == 4 || i == 5 ? 7.0 : 0.0,
                1e-9);
}

TEST(InjectFlip, IsFoundAtItsPlaceWithItsSize) {
  const FlipRig smooth = [](double t, FlipSample& sample) {
    sample.turn = {rotation(glm::dvec3(t, 0, 0)), rotation(glm::dvec3(0, t, 0))};
  };
  const FlipReport report =
      find_flips(inject_flip(smooth, 1, 0.3, glm::dvec3(0, 0, radians_from(12.0))), FlipSettings{});
  ASSERT_EQ(report.jumps.size(), 1u);
  EXPECT_NEAR(report.jumps[0].t, 0.3, 1e-6);
  EXPECT_NEAR(report.jumps[0].size_deg(), 12.0, 0.01);
}

TEST(InjectSliceLoss, TakesTheShareOfTheAreaAndNothingFurtherOff) {
  const auto body = tube_body(8);
  const BodyMetrics& metrics = body->metrics();
  std::vector<glm::vec3> position = skin::rest_mesh(body->character()).position;
  const SlicePose before = pose_slices(metrics.slices(), position);
  inject_slice_loss(position, before, 30, 0.2, 0.05);
  const SlicePose after = pose_slices(metrics.slices(), position);
  const auto ratio = [&](std::size_t r) {
    return glm::length(after.area[r]) / glm::length(before.area[r]);
  };
  EXPECT_NEAR(ratio(30), 0.8, 0.01);
  EXPECT_EQ(ratio(10), 1.0);
  EXPECT_EQ(ratio(50), 1.0);
}

TEST(TubeBody, IsACleanCharacter) {
  const auto body = tube_body(24);
  EXPECT_EQ(body->bones(), 24);
  EXPECT_EQ(body->metrics().slices().measured(), 64u);
  EXPECT_TRUE(body->metrics().mesh().open_reason.empty());
  EXPECT_TRUE(body->driver().arms_follow_chest());
}

CalibrationPlan small_plan() {
  CalibrationPlan plan;
  plan.clean_poses = 40;
  plan.fault_poses = 20;
  plan.chain_bones = {24};
  return plan;
}

TEST(Calibrate, FindsEveryFaultOfItsTargetSizeAndFlagsNoCleanPose) {
  const auto body = tube_body(22);
  const CalibrationBody* bodies[] = {body.get()};
  std::vector<std::string> told;
  std::size_t planned = 0;
  std::atomic<std::size_t> done{0};
  CalibrationWatch watch;
  watch.on_stage = [&](const std::string& stage, std::size_t steps) {
    told.push_back(stage);
    planned += steps;
  };
  watch.on_step = [&] { ++done; };
  const CalibrationReport report = calibrate(small_plan(), bodies, watch);
  EXPECT_EQ(told.size(), 5u);  // no slices in pictures of so fine a spine
  EXPECT_EQ(done, planned);
  EXPECT_EQ(report.detectors.size(), 15u);
  for (const Sensitivity& s : report.detectors) {
    EXPECT_TRUE(s.ok()) << s.detector << " on " << s.body << ": smallest " << s.smallest
                        << ", false alarms " << s.false_alarms;
    EXPECT_GT(s.clean, 0u);
    if (s.clean_agreement.cases() > 0) {  // pictures name no place
      EXPECT_EQ(s.clean_agreement.neither, s.clean) << s.detector;
      EXPECT_EQ(s.hits.back().agreement.both, s.hits.back().tried) << s.detector;
      continue;
    }
    // What is found is found where it was put.
    EXPECT_GE(s.hits.back().placed, s.hits.back().found * 9 / 10) << s.detector;
  }
  EXPECT_TRUE(report.ok());
  EXPECT_EQ(detector_lines(report).size(), report.detectors.size());
  EXPECT_EQ(detector_lines(report)[0], "flip  10 bones: from 1.2 deg, 0 of 40 clean poses flagged");
}

TEST(Calibrate, TriesChainsOfAsFewAsThreeBonesAndNothingThatTheyCannotShow) {
  CalibrationPlan plan = small_plan();
  plan.clean_poses = 200;  // few bones scatter more
  plan.chain_bones = {3, 5};
  std::set<std::string> tried;
  for (const Sensitivity& s : calibrate(plan, {}).detectors) {
    EXPECT_TRUE(s.ok()) << s.detector << " " << s.body << " " << s.smallest;
    tried.insert(s.code + " " + s.body);
  }
  const std::set<std::string> expected{"BB001 10 bones", "BB010 3 bones", "BB020 3 bones",
                                       "BB021 3 bones",  "BB010 5 bones", "BB014 5 bones",
                                       "BB020 5 bones",  "BB021 5 bones"};
  EXPECT_EQ(tried, expected);
}

TEST(Calibrate, SaysTheSameOnOneThreadAndOnMany) {
  CalibrationPlan plan = small_plan();
  plan.clean_poses = 10;
  plan.fault_poses = 4;
  const auto body = tube_body(6);
  const CalibrationBody* bodies[] = {body.get()};
  const std::string many = calibration_json(calibrate(plan, bodies));
  const oneapi::tbb::global_control one(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(calibration_json(calibrate(plan, bodies)), many);
}

TEST(Calibrate, EndsWhereItsWatcherThrows) {
  CalibrationWatch watch;
  watch.on_step = [] { throw std::runtime_error("enough"); };
  EXPECT_THROW(calibrate(small_plan(), {}, watch), std::runtime_error);
}

/// A folder for one test's calibration.json, with a report of one detector stored in it.
class LastCalibration : public testing::Test {
 protected:
  LastCalibration() {
    report_.date = "2026-11-20";
    report_.detectors = {judge_detector("chain kink", "BB010", "24 bones", "deg", 1.0, 0.5,
                                        std::vector<double>(500, 0.1),
                                        {{1.0, std::vector<double>(100, 0.9), 100}})};
  }
  std::filesystem::path file() const { return folder_ / "calibration.json"; }
  void write(const std::string& text) const { std::ofstream(file()) << text; }
  std::string line(const std::string& today) const { return last_calibration(file(), today); }

  const TemporaryFolder folder_;
  CalibrationReport report_;
};

TEST_F(LastCalibration, SaysItsDayItsAgeAndWhatItFound) {
  EXPECT_EQ(line("2026-11-22"),
            "no whole calibration beside the history yet: 'backbend calibrate' makes one");
  write(calibration_json(report_));
  EXPECT_EQ(line("2026-11-21"),
            "whole calibration of 2026-11-20, 1 day ago, on 1 bodies and chains: each detector "
            "found its target, 0 of 500 clean poses flagged");
  EXPECT_EQ(line("2026-11-27").find("repeat it"), std::string::npos);
  EXPECT_NE(line("2026-11-28").find("8 days ago (repeat it every week)"), std::string::npos);
  EXPECT_EQ(line("2026-11-19").rfind("whole calibration of 2026-11-20, on 1 bodies", 0), 0u);
  report_.detectors[0].smallest = kNan;
  write(calibration_json(report_));
  EXPECT_NE(line("2026-11-21").find("NOT at their target: chain kink on 24 bones"),
            std::string::npos);
}

TEST_F(LastCalibration, ThatIsDamagedIsRefusedByName) {
  report_.date = "";
  for (const std::string& text :
       {std::string("{"), std::string("{\"schema\": \"other\"}"), calibration_json(report_)}) {
    write(text);
    try {
      line("2026-11-22");
      ADD_FAILURE() << text;
    } catch (const CalibrationError& error) {
      EXPECT_NE(std::string(error.what()).find("calibration.json: not a calibration"),
                std::string::npos)
          << error.what();
    }
  }
}

TEST(Calibrate, OfNothingIsNotOk) { EXPECT_FALSE(CalibrationReport().ok()); }

}  // namespace
}  // namespace backbend::validate
