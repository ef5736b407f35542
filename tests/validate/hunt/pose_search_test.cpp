#include "validate/hunt/pose_search.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>

#include <cmath>

#include "validate/hunt/local_model.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;
using Point = std::vector<double>;

double square(const Point& a, const Point& b) {
  double sum = 0.0;
  for (Index i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

SearchOutcome search_of(const std::function<double(const Point&)>& badness,
                        const std::function<float(const Point&)>& motion, Index evaluations,
                        std::uint64_t seed = 1) {
  SearchSettings settings;
  settings.evaluations = evaluations;
  settings.seed = seed;
  return search(settings, [&](std::span<SearchPoint> points) {
    oneapi::tbb::parallel_for(Index{0}, points.size(), [&](Index i) {
      points[i].badness = {badness(points[i].at)};
      points[i].motion = {motion(points[i].at)};
    });
  });
}

float still(const Point&) { return 0.0f; }

TEST(PoseSearch, LooksAtThePointsThatItIsGivenFirstAndCountsThem) {
  SearchSettings settings;
  settings.axes = 2;
  settings.first = {{0.25, 0.75}, {0.5, 0.125}, {1.0, 0.0}};
  // Also where these are all that may be looked at, and where little is left.
  for (const Index evaluations : {3, 4, 5, 9, 20, 60}) {
    settings.evaluations = evaluations;
    const SearchOutcome outcome = search(settings, [](std::span<SearchPoint> points) {
      for (SearchPoint& point : points) {
        point.badness = {point.at[0]};
        point.motion = {static_cast<float>(point.at[1])};
      }
    });
    ASSERT_LE(outcome.points.size(), evaluations);
    EXPECT_GE(outcome.points.size() + 12, evaluations);  // less than one more poll is left over
    for (Index i = 0; i < settings.first.size(); ++i)
      EXPECT_EQ(outcome.points[i].at, settings.first[i]);
    EXPECT_EQ(outcome.worst.front(), 2u);  // nothing is worse than the border
  }
}

TEST(LocalModel, GivesAQuadraticBackExactlyAndItsOwnErrorAsSpread) {
  std::vector<double> points, values;
  const auto value = [](double x, double y) { return 3.0 - x + 2.0 * y + x * y - 4.0 * y * y; };
  for (int i = 0; i < 40; ++i) {
    const double x = 0.5 + 0.5 * std::sin(2.7 * i), y = 0.5 + 0.5 * std::cos(1.3 * i);
    points.insert(points.end(), {x, y});
    values.push_back(value(x, y));
  }
  const LocalModel model(2, points);
  const auto estimate = model.at(std::array{0.3, 0.6});
  double sum = 0.0, squares = 0.0;
  for (const auto& [i, share] : estimate.weight) {
    sum += share * values[i];
    squares += share * share;
  }
  EXPECT_NEAR(sum, value(0.3, 0.6), 1e-6);
  EXPECT_DOUBLE_EQ(estimate.spread, std::sqrt(1.0 + squares));
}

TEST(LocalModel, LeavesOutThePointItIsToldToAndAsksForEnough) {
  const LocalModel model(1, {0.0, 0.1, 0.2, 0.3, 0.4, 0.5});
  for (const auto& [i, share] : model.at(std::array{0.2}, 2).weight) EXPECT_NE(i, 2u);
  EXPECT_TRUE(LocalModel(1, {0.0, 1.0}).at(std::array{0.5}).weight.empty());
}

// The region above 1 is a ball of radius 0.0134: a hundred-thousandth of the cube.
TEST(PoseSearch, ClimbsToATopThatFailsInAHundredThousandthOfTheBox) {
  const Point top{0.31, 0.72, 0.55};
  const double rise = std::exp(0.0134 * 0.0134 / (2 * 0.08 * 0.08));
  const auto bump = [&](const Point& at) {
    return 0.3 * at[0] + rise * std::exp(-square(at, top) / (2 * 0.08 * 0.08)) - 0.3 * top[0];
  };
  const SearchOutcome out = search_of(bump, still, 2000);
  ASSERT_TRUE(out.worst[0].has_value());
  EXPECT_GT(out.points[*out.worst[0]].badness[0], 1.0);
}

// Nothing of the objective is above its own trend, but the motion differs from what is around it.
TEST(PoseSearch, FollowsMotionThatDiffersFromItsSurroundings) {
  const Point top{0.62, 0.27, 0.44};
  const auto bump = [&](const Point& at) { return std::exp(-square(at, top) / (2 * 0.05 * 0.05)); };
  const SearchOutcome out = search_of(
      [&](const Point& at) { return std::max(0.6 * at[0], 1.01 * bump(at)); },
      [&](const Point& at) { return static_cast<float>(20.0 * at[1] + 10.0 * bump(at)); }, 3000);
  EXPECT_GT(out.points[*out.worst[0]].badness[0], 1.0);
}

TEST(PoseSearch, BisectsAJumpThatStays) {
  const auto jumps = [](const Point& at) { return at[0] + at[1] + at[2] > 2.8; };
  const SearchOutcome out = search_of(
      [](const Point&) { return 0.0; },
      [&](const Point& at) { return jumps(at) ? 90.0f : static_cast<float>(at[0]); }, 1000);
  ASSERT_FALSE(out.suspects.empty());
  const Suspect& found = out.suspects.front();
  EXPECT_TRUE(found.jumps);
  EXPECT_NE(jumps(found.before), jumps(found.after));
  EXPECT_LT(std::sqrt(square(found.before, found.after)), 1e-3);
}

TEST(PoseSearch, TakesASteepSlopeForNoJump) {
  const SearchOutcome out = search_of(
      [](const Point&) { return 0.0; },
      [](const Point& at) { return static_cast<float>(30.0 * std::tanh(40.0 * (at[0] - 0.5))); },
      1000);
  for (const Suspect& suspect : out.suspects) EXPECT_FALSE(suspect.jumps);
}

TEST(PoseSearch, SpendsWhatItWasGivenAndNoMore) {
  for (const Index evaluations : {100, 377, 1000}) {
    const auto out = search_of([](const Point& at) { return at[0] * at[1]; }, still, evaluations);
    EXPECT_EQ(out.points.size(), evaluations);
  }
}

TEST(PoseSearch, IsTheSameForAnyNumberOfThreadsAndAnotherForAnotherSeed) {
  const auto wave = [](const Point& at) {
    return std::sin(9 * at[0]) * std::cos(7 * at[1]) * at[2];
  };
  const auto points_with = [&](Index threads, std::uint64_t seed) {
    const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism,
                                            threads);
    std::vector<Point> at;
    for (const SearchPoint& point : search_of(wave, still, 600, seed).points)
      at.push_back(point.at);
    return at;
  };
  EXPECT_EQ(points_with(1, 5), points_with(4, 5));
  EXPECT_NE(points_with(1, 5), points_with(1, 6));
}

TEST(PoseSearch, KeepsObjectivesThatSayNothingHereOutOfTheWorst) {
  const SearchOutcome out = search_of(
      [](const Point& at) {
        return at[0] > 0.5 ? std::numeric_limits<double>::quiet_NaN() : at[0];
      },
      still, 400);
  ASSERT_TRUE(out.worst[0].has_value());
  EXPECT_NEAR(out.points[*out.worst[0]].badness[0], 0.5, 0.01);
}

TEST(LargestGap, ShrinksAsPointsAreAdded) {
  std::vector<SearchPoint> points{{{0.0, 0.0}, {}, {}}};
  const SearchGap one = largest_gap(2, points);
  EXPECT_NEAR(one.radius, std::sqrt(2.0), 0.05);  // the corner across
  points.push_back({{1.0, 1.0}, {}, {}});
  const SearchGap two = largest_gap(2, points);
  EXPECT_NEAR(two.radius, 1.0, 0.05);  // the other corners
  EXPECT_NEAR(two.share, 3.14159 / 4.0, 0.05);
}

}  // namespace
}  // namespace backbend::validate
