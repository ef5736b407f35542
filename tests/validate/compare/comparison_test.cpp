#include "validate/compare/comparison.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "validate/compare/surface_match.h"
#include "validate/sweeps/sweep.h"

namespace backbend::validate {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
/// The limits of the table of checks.
constexpr double kKinkLimit = 2.0, kAreaLimit = 0.75;

/// One extension sweep, a degree a pose, of a chain kink (deg) and a slice area (ratio).
RigResult rig(std::vector<double> kink, std::vector<double> area) {
  RigResult result;
  result.character = "human";
  result.mapping = "chest";
  SweepSeries sweep;
  sweep.sweep = sweep.channel = "extension";
  for (std::size_t i = 0; i < kink.size(); ++i) sweep.control_deg.push_back(static_cast<double>(i));
  sweep.pose_deg["extension"] = sweep.control_deg;
  sweep.metric = {{"chain_kink", std::move(kink)}, {"slice_area", std::move(area)}};
  sweep.metric_limit = {{"chain_kink", kKinkLimit}, {"slice_area", kAreaLimit}};
  result.sweeps = {sweep};
  return result;
}

std::string marks(const Comparison& comparison) { return comparison.sweeps.front().marks; }

TEST(Comparing, ARigWithItselfIsADraw) {
  const RigResult same = rig({0, 1, 5, 90}, {1, 0.9, 0.4, 0.1});
  const Comparison comparison = compare_results(same, same, "x", "y");
  EXPECT_EQ(marks(comparison), "====");
  EXPECT_EQ(comparison.same, 4);
  EXPECT_EQ(comparison.ahead, "");
  EXPECT_TRUE(comparison.worst_of_a.empty());
  EXPECT_TRUE(comparison.worst_of_b.empty());
  EXPECT_EQ(comparison_verdict(comparison), "a draw");
}

TEST(Comparing, SaysTheSameFromBothSides) {
  const RigResult a = rig({0, 5, 0, 3, 9}, {1, 1, 0.5, 0.2, 1});
  const RigResult b = rig({0, 0, 0, 9, 3}, {1, 1, 0.9, 0.9, 1});
  const Comparison there = compare_results(a, b, "a", "b"), back = compare_results(b, a, "b", "a");
  EXPECT_EQ(marks(there), "=--x-");
  EXPECT_EQ(marks(back), "=++x+");
  EXPECT_EQ(there.b_better, back.a_better);
  EXPECT_EQ(there.mixed, 1);
  EXPECT_EQ(there.ahead, "b");
  EXPECT_EQ(back.ahead, "a");
  EXPECT_EQ(there.worst_of_a.size(), back.worst_of_b.size());
}

TEST(Comparing, RandomPosesSayHowSureTheyAre) {
  // Of a hundred poses the first forty are over the limit on one side.
  std::vector<double> kink(100, 0.0);
  std::fill_n(kink.begin(), 40, 9.0);
  RigResult clean = rig(std::vector<double>(100, 0.0), std::vector<double>(100, 1.0));
  RigResult faulted = rig(kink, std::vector<double>(100, 1.0));
  EXPECT_EQ(compare_results(clean, faulted, "clean", "faulted").sampled, "");
  clean.sweeps[0].sweep = faulted.sweeps[0].sweep = kRandomWalk;
  // Ten stretches, four of them better all through: 0.4 +- 2.262 sqrt(0.24 / 9).
  EXPECT_EQ(compare_results(clean, faulted, "clean", "faulted").sampled,
            "clean is better in 40 % of random poses (95 %: 3 to 77 %), worse in 0 % of random "
            "poses (95 %: 0 to 0 %)");
}

TEST(Comparing, LowerIsWorseWhereTheLimitIsALeast) {
  const Comparison comparison = compare_results(rig({0}, {0.9}), rig({0}, {0.5}), "whole", "wrung");
  EXPECT_EQ(marks(comparison), "+");
  ASSERT_EQ(comparison.worst_of_b.size(), 1u);
  EXPECT_EQ(comparison.worst_of_b.front().code, "BB030");
  EXPECT_EQ(comparison.b_over, 1);
  EXPECT_EQ(comparison.a_over, 0);
}

TEST(Comparing, WhatNeitherSideIsOverDoesNotDecideAPose) {
  const Comparison comparison = compare_results(rig({0}, {1}), rig({1.5}, {1}), "a", "b");
  EXPECT_EQ(marks(comparison), "=");
  // It still counts for the metric.
  EXPECT_EQ(comparison.metrics.front().code, "BB010");
  EXPECT_EQ(comparison.metrics.front().a_better, 1);
}

TEST(Comparing, DifferencesWithinTheToleranceAreNone) {
  const double tolerance = comparison_tolerance(kKinkLimit);
  const auto against = [&](double more) {
    return marks(compare_results(rig({4}, {1}), rig({4 + more}, {1}), "a", "b"));
  };
  EXPECT_EQ(against(0.99 * tolerance), "=");
  EXPECT_EQ(against(1.01 * tolerance), "+");
  EXPECT_EQ(against(-1.01 * tolerance), "-");
}

TEST(Comparing, WhatWasNotMeasuredIsNeitherBetterNorWorse) {
  const Comparison comparison = compare_results(rig({kNone, kNone, 9}, {1, kNone, kNone}),
                                                rig({9, 9, kNone}, {1, 0.1, 0.1}), "a", "b");
  EXPECT_EQ(marks(comparison), "=??");
  EXPECT_EQ(comparison.paired, 1);
  EXPECT_EQ(comparison.unpaired, 2);
}

TEST(Comparing, PosesWithoutAPartnerAreCounted) {
  const Comparison comparison =
      compare_results(rig({0, 0, 0}, {1, 1, 1}), rig({0, 0, 0, 0, 0}, {1, 1, 1, 1, 1}), "a", "b");
  EXPECT_EQ(comparison.paired, 3);
  EXPECT_EQ(comparison.unpaired, 2);
  RigResult other = rig({0, 0}, {1, 1});
  other.sweeps.push_back(other.sweeps.front());
  other.sweeps.back().sweep = "side";
  EXPECT_EQ(compare_results(rig({0, 0}, {1, 1}), other, "a", "b").unpaired, 2);
}

TEST(Comparing, PathsToWhatASearchFoundAreEachRigsOwn) {
  const auto with_find = [](double kink) {
    RigResult result = rig({0, 1}, {1, 1});
    SweepSeries path = rig({0, kink}, {1, 1}).sweeps.front();
    path.sweep = "hunt even BB010";
    result.sweeps.push_back(path);
    result.hunt.worst = {{"BB010", "deg", "side 1", kink, kKinkLimit, true, 1}};
    return result;
  };
  const Comparison comparison = compare_results(with_find(90), with_find(5), "a", "b");
  EXPECT_EQ(comparison.paired, 2);
  EXPECT_EQ(comparison.unpaired, 0);
  EXPECT_EQ(comparison.a_over, 0);
  EXPECT_EQ(comparison.sweeps.size(), 1u);
}

TEST(Comparing, SaysTheVolumeOfBothSides) {
  Report report;
  report.rigs = {rig({0, 1}, {1, 1}), rig({0, 9}, {1, 1})};
  report.rigs[1].role = Role::reference;
  report.rigs[0].volume = {"side -1..1", true, 1.0, 1.0, 0.0, 8.0, "", 59, 59, 0.95};
  report.rigs[1].volume = {"side -1..1", false, 0.0, 0.0, 0.0, 8.0, "not on boxes", 59, 0, 0.0};
  report.comparisons = {compare_results(report.rigs[0], report.rigs[1], "even", "curve")};
  const std::string text = comparison_summary(report);
  EXPECT_NE(text.find("Volume of even: certified 100 %"), std::string::npos) << text;
  EXPECT_NE(text.find("59 of 59 random poses clean (95 % sure: at least 95 % of the volume)"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("Volume of curve: nothing certified (not on boxes); searched: 0 of 59"),
            std::string::npos)
      << text;
}

TEST(Comparing, TheWorstPosesAreOfDifferentFaults) {
  const Comparison comparison = compare_results(rig({50, 60, 70, 65}, {0.1, 1, 1, 1}),
                                                rig({0, 0, 0, 0}, {1, 1, 1, 1}), "a", "b");
  ASSERT_EQ(comparison.worst_of_a.size(), 2u);
  EXPECT_EQ(comparison.worst_of_a[0].pose, "extension 2");
  EXPECT_EQ(comparison.worst_of_a[0].code, "BB010");
  EXPECT_EQ(comparison.worst_of_a[0].a, 70.0);
  EXPECT_EQ(comparison.worst_of_a[1].code, "BB030");
}

TEST(Comparing, FilesAreCalledByTheirNamesWhereThoseTellThemApart) {
  EXPECT_EQ(side_labels("show/hero_v012.glb", "show/hero_v013.glb"),
            (std::pair<std::string, std::string>("hero_v012.glb", "hero_v013.glb")));
  EXPECT_EQ(side_labels("v012/hero.glb", "v013/hero.glb"),
            (std::pair<std::string, std::string>("v012/hero.glb", "v013/hero.glb")));
  EXPECT_EQ(side_labels("runs/monday/", "runs/tuesday"),
            (std::pair<std::string, std::string>("runs/monday/", "runs/tuesday")));
}

TEST(Comparing, FewerPosesOverALimitAreAhead) {
  // b is better in more poses, but fails in one more.
  const Comparison comparison =
      compare_results(rig({9, 9, 0}, {1, 1, 1}), rig({8, 8, 3}, {1, 1, 1}), "a", "b");
  EXPECT_EQ(comparison.b_better, 2);
  EXPECT_EQ(comparison.a_better, 1);
  EXPECT_EQ(comparison.ahead, "a");
}

std::vector<glm::vec3> cloud(unsigned seed, int count) {
  std::mt19937 bits(seed);
  std::uniform_real_distribution<float> at(-0.25f, 0.25f);
  std::vector<glm::vec3> points = {{0, 0, 0}, {0, 1, 0}};
  while (static_cast<int>(points.size()) < count)
    points.push_back({at(bits), 0.5f + 2.0f * at(bits), at(bits)});
  return points;
}

TEST(SurfaceMatch, FindsABodyAgainInAnotherOrderUnitAndPlace) {
  const std::vector<glm::vec3> body = cloud(1, 3000);
  std::vector<glm::vec3> other(body.rbegin(), body.rend());
  for (glm::vec3& point : other) point = 100.0f * point + glm::vec3{7, -3, 2};
  EXPECT_EQ(surface_match(body, other), 1.0);
}

TEST(SurfaceMatch, SaysHowMuchIsNotThere) {
  const std::vector<glm::vec3> body = cloud(1, 2000);
  std::vector<glm::vec3> other = body;
  // A quarter of the points stand off by two hundredths of the height, inside the same bounds.
  for (std::size_t i = 500; i < 1000; ++i) other[i].x += other[i].x > 0 ? -0.02f : 0.02f;
  const double match = surface_match(other, body);
  EXPECT_GT(match, 0.74);
  EXPECT_LT(match, 0.78);
  EXPECT_TRUE(std::isnan(surface_match({}, body)));
}

}  // namespace
}  // namespace backbend::validate
