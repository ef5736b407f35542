#include "validate/verdicts/booking.h"

#include <gtest/gtest.h>

#include <limits>

namespace backbend::validate {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const Check& kKink = *find_check("BB011");
const Check& kArea = *find_check("BB030");

TEST(BookMeshFinding, WithinTheLimitNobodyIsBlamed) {
  const Booking b = book_mesh_finding(kKink, 8.0, {.value = 7.0, .ideal = 1.0, .proxy = kNan});
  EXPECT_EQ(b.verdict, Verdict::pass);
  EXPECT_EQ(b.owner, Owner::none);
  EXPECT_FALSE(b.decides);
}

TEST(BookMeshFinding, WhatTheIdealBendWouldShowTooIsTheWeightsAndDoesNotDecide) {
  Booking b = book_mesh_finding(kKink, 8.0, {.value = 12.0, .ideal = 11.5, .proxy = kNan});
  EXPECT_EQ(b.verdict, Verdict::fail);
  EXPECT_EQ(b.owner, Owner::weights);
  EXPECT_FALSE(b.decides);
  b = book_mesh_finding(kArea, 0.75, {.value = 0.70, .ideal = 0.71, .proxy = kNan});
  EXPECT_EQ(b.owner, Owner::weights);
  EXPECT_FALSE(b.decides);
}

TEST(BookMeshFinding, WhatTheIdealBendWouldNotShowIsTheSolversAndDecides) {
  Booking b = book_mesh_finding(kKink, 8.0, {.value = 12.0, .ideal = 3.0, .proxy = kNan});
  EXPECT_EQ(b.owner, Owner::solver);
  EXPECT_TRUE(b.decides);
  b = book_mesh_finding(kArea, 0.75, {.value = 0.40, .ideal = 0.72, .proxy = kNan});
  EXPECT_EQ(b.owner, Owner::solver);  // both fail, but one is far worse
  EXPECT_TRUE(b.decides);
}

TEST(BookMeshFinding, WhatOnlyCleanWeightsCureIsTheWeights) {
  Booking b = book_mesh_finding(kKink, 8.0, {.value = 12.0, .ideal = 10.0, .proxy = 2.0});
  EXPECT_EQ(b.owner, Owner::weights);
  EXPECT_TRUE(b.decides);
  // The ideal bend does with these weights: a flipped spine is not excused by better ones.
  b = book_mesh_finding(kKink, 8.0, {.value = 12.0, .ideal = 3.0, .proxy = 2.0});
  EXPECT_EQ(b.owner, Owner::solver);
  EXPECT_TRUE(b.decides);
}

TEST(BookMeshFinding, APoseTooMuchForTheBodyIsNeverBookedToTheRig) {
  const Booking b = book_mesh_finding(
      kKink, 8.0, {.value = 60.0, .ideal = 3.0, .proxy = kNan, .infeasible = 1.2});
  EXPECT_EQ(b.owner, Owner::pose);
  EXPECT_FALSE(b.decides);
}

TEST(BookMeshFinding, WhereWeightsAreJudgedTheirFaultsDecide) {
  const Booking b = book_mesh_finding(
      kArea, 0.75, {.value = 0.71, .ideal = 0.71, .proxy = kNan, .judging_weights = true});
  EXPECT_EQ(b.owner, Owner::weights);
  EXPECT_TRUE(b.decides);
}

TEST(BookMeshFinding, WhereWeightsAreJudgedUnderABadRigItsFaultsStayTheSolvers) {
  // Arms that a rig pulls off the chest stay off with any weights.
  const Booking b = book_mesh_finding(
      kKink, 8.0, {.value = 21.8, .ideal = 0.0, .proxy = 21.8, .judging_weights = true});
  EXPECT_EQ(b.owner, Owner::solver);
  EXPECT_TRUE(b.decides);
}

TEST(BookMeshFinding, WithoutAnIdealTheFindingStands) {
  const Booking b = book_mesh_finding(kKink, 8.0, {.value = 12.0, .ideal = kNan, .proxy = kNan});
  EXPECT_EQ(b.verdict, Verdict::fail);
  EXPECT_TRUE(b.decides);
  EXPECT_EQ(book_mesh_finding(kKink, 8.0, {.value = kNan, .ideal = 1.0}).verdict,
            Verdict::not_measured);
}

}  // namespace
}  // namespace backbend::validate
