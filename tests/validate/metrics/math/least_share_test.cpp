#include "validate/metrics/math/least_share.h"

#include <gtest/gtest.h>

#include <cmath>

namespace backbend::validate {
namespace {

// A share is bisected to 2^-60; sums of a thousand terms keep ten digits.
constexpr double kTolerance = 1e-9;

TEST(LeastShare, OfAllGoodIsTheRootOfTheDoubtAndNearlyTheRuleOfThree) {
  for (const int count : {1, 10, 59, 1000}) {
    const double share = least_share(count, count, 0.95);
    EXPECT_NEAR(share, std::pow(0.05, 1.0 / count), kTolerance) << count;
    EXPECT_GE(share, 1.0 - 3.0 / count) << count;
  }
}

TEST(LeastShare, SolvesTheBinomialsTail) {
  // One bad of two: the chance that one or more of two are good is 1 - (1 - p)^2.
  EXPECT_NEAR(least_share(1, 2, 0.95), 1.0 - std::sqrt(0.95), kTolerance);
  // Two bad of three: 1 - (1 - p)^3.
  EXPECT_NEAR(least_share(1, 3, 0.95), 1.0 - std::cbrt(0.95), kTolerance);
  // One bad of three: p^3 + 3 p^2 (1 - p) = 0.05.
  const double p = least_share(2, 3, 0.95);
  EXPECT_NEAR(p * p * (3.0 - 2.0 * p), 0.05, kTolerance);
}

TEST(LeastShare, OfNoneGoodOrNoneDrawnIsNothing) {
  EXPECT_EQ(least_share(0, 50, 0.95), 0.0);
  EXPECT_EQ(least_share(0, 0, 0.95), 0.0);
}

TEST(LeastShare, GrowsWithWhatIsGoodAndFallsWithTheConfidence) {
  EXPECT_LT(least_share(90, 100, 0.95), least_share(91, 100, 0.95));
  EXPECT_LT(least_share(90, 100, 0.95), 0.90);
  EXPECT_LT(least_share(90, 100, 0.99), least_share(90, 100, 0.95));
}

}  // namespace
}  // namespace backbend::validate
