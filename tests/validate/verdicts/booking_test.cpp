#include "validate/verdicts/booking.h"
#include "validate/metrics/math/nan.h"

#include <gtest/gtest.h>

#include <limits>

namespace backbend::validate {
namespace {

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

TEST(BookMeshFinding, AKinkInAPoseThatHardlyLeavesTheInnerSideAnyLengthIsThePoses) {
  MeshContext facts{.value = 73.1,
                    .ideal = 73.1,
                    .proxy = 38.0,
                    .ideal_proxy = 38.0,
                    .infeasible = 0.89,
                    .judging_weights = true,
                    .bones = 3};
  EXPECT_EQ(book_mesh_finding(kKink, 25.0, facts).owner, Owner::pose);
  EXPECT_FALSE(book_mesh_finding(kKink, 25.0, facts).decides);
  facts.infeasible = 0.7;
  EXPECT_EQ(book_mesh_finding(kKink, 25.0, facts).owner, Owner::weights);
  EXPECT_TRUE(book_mesh_finding(kKink, 25.0, facts).decides);
  // What the ideal bend does not show stays the rig's.
  facts.infeasible = 0.89;
  facts.ideal = 5.0;
  EXPECT_EQ(book_mesh_finding(kKink, 25.0, facts).owner, Owner::solver);
  EXPECT_TRUE(book_mesh_finding(kKink, 25.0, facts).decides);
  // Of other checks only where the surface must fold.
  facts = {.value = 0.1,
           .ideal = 0.1,
           .proxy = 0.9,
           .ideal_proxy = 0.9,
           .infeasible = 0.89,
           .judging_weights = true};
  EXPECT_EQ(book_mesh_finding(kArea, 0.75, facts).owner, Owner::weights);
}

TEST(BookMeshFinding, WhereWeightsAreJudgedTheirFaultsDecide) {
  const Booking b = book_mesh_finding(
      kArea, 0.75, {.value = 0.55, .ideal = 0.55, .proxy = kNan, .judging_weights = true});
  EXPECT_EQ(b.owner, Owner::weights);
  EXPECT_TRUE(b.decides);
}

TEST(BookMeshFinding, WeightsDecideInACompoundPoseAtTheSameMultipleOfTheLossThatItsLimitAllows) {
  const auto decides = [](double limit, double value) {
    return book_mesh_finding(
               kArea, limit,
               {.value = value, .ideal = value, .proxy = kNan, .judging_weights = true})
        .decides;
  };
  // A loss of 0.25 is allowed, and 1.6 times that decides; in the compound pose 0.433.
  EXPECT_FALSE(decides(0.75, 0.61));
  EXPECT_TRUE(decides(0.75, 0.59));
  EXPECT_FALSE(decides(0.567, 0.32));
  EXPECT_TRUE(decides(0.567, 0.29));
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

TEST(BookMeshFinding, WhatCleanWeightsAndTheIdealBendShareIsTheSkeletonsAndNeverDecides) {
  // Clean weights fail, too.
  Booking b = book_mesh_finding(
      kKink, 25.0,
      {.value = 33.0, .ideal = 33.0, .proxy = 31.0, .ideal_proxy = 31.0, .judging_weights = true});
  EXPECT_EQ(b.owner, Owner::skeleton);
  EXPECT_FALSE(b.decides);
  // They pass, but within a tenth of the limit of the character's own.
  b = book_mesh_finding(
      kKink, 25.0,
      {.value = 26.0, .ideal = 26.0, .proxy = 24.0, .ideal_proxy = 24.0, .judging_weights = true});
  EXPECT_EQ(b.owner, Owner::skeleton);
  b = book_mesh_finding(
      kArea, 0.75,
      {.value = 0.70, .ideal = 0.70, .proxy = 0.71, .ideal_proxy = 0.71, .judging_weights = true});
  EXPECT_EQ(b.owner, Owner::skeleton);
}

TEST(BookMeshFinding, WhatCleanWeightsCureIsTheWeightsAndDecidesWhereItIsPlain) {
  MeshContext facts{
      .value = 62.0, .ideal = 62.0, .proxy = 12.0, .ideal_proxy = 12.0, .judging_weights = true};
  EXPECT_EQ(book_mesh_finding(kKink, 25.0, facts).owner, Owner::weights);
  EXPECT_TRUE(book_mesh_finding(kKink, 25.0, facts).decides);
  // Healthy weights that were cut down exceed the limit, too.
  facts.value = facts.ideal = 33.0;
  EXPECT_EQ(book_mesh_finding(kKink, 25.0, facts).verdict, Verdict::fail);
  EXPECT_EQ(book_mesh_finding(kKink, 25.0, facts).owner, Owner::weights);
  EXPECT_FALSE(book_mesh_finding(kKink, 25.0, facts).decides);
}

TEST(BookMeshFinding, WeightsNearlyAsGoodAsCleanOnesAreNotToBlameOnWhicheverSideOfTheLimit) {
  // 36 is 1.53 times 23.6, which passes; 39 is more than 1.6 times.
  MeshContext facts{
      .value = 36.0, .ideal = 36.0, .proxy = 23.6, .ideal_proxy = 23.6, .judging_weights = true};
  EXPECT_EQ(book_mesh_finding(kKink, 25.0, facts).owner, Owner::skeleton);
  facts.value = facts.ideal = 39.0;
  EXPECT_EQ(book_mesh_finding(kKink, 25.0, facts).owner, Owner::weights);
}

TEST(BookMeshFinding, SlicesOfASurfaceOfOneVertexABoneAreFacetsAndNeverDecide) {
  MeshContext facts{.value = 120.0,
                    .ideal = 120.0,
                    .proxy = 12.0,
                    .ideal_proxy = 12.0,
                    .judging_weights = true,
                    .bones = 10,
                    .rows_per_bone = 1.0};
  EXPECT_EQ(book_mesh_finding(kKink, 25.0, facts).owner, Owner::skeleton);
  EXPECT_FALSE(book_mesh_finding(kKink, 25.0, facts).decides);
  facts.rows_per_bone = 3.0;
  EXPECT_EQ(book_mesh_finding(kKink, 25.0, facts).owner, Owner::weights);
  EXPECT_TRUE(book_mesh_finding(kKink, 25.0, facts).decides);
  // A rig that is worse than the ideal bend is no matter of facets.
  facts.rows_per_bone = 1.0;
  facts.ideal = 5.0;
  EXPECT_EQ(book_mesh_finding(kKink, 25.0, facts).owner, Owner::solver);
}

TEST(BookMeshFinding, SeparatePiecesOfATorsoAreToTurnAgainstAndIntoEachOther) {
  MeshContext facts{.value = 79.6,
                    .ideal = 79.6,
                    .proxy = 13.7,
                    .ideal_proxy = 13.7,
                    .judging_weights = true,
                    .bones = 3,
                    .in_pieces = true};
  for (const char* code : {"BB011", "BB036", "BB034"}) {
    EXPECT_EQ(book_mesh_finding(*find_check(code), 25.0, facts).owner, Owner::skeleton) << code;
    EXPECT_FALSE(book_mesh_finding(*find_check(code), 25.0, facts).decides) << code;
  }
  // What the ideal bend does not show stays the rig's.
  facts.ideal = 5.0;
  EXPECT_EQ(book_mesh_finding(kKink, 25.0, facts).owner, Owner::solver);
}

TEST(BookMeshFinding, TwoBonesCannotShareATwist) {
  MeshContext facts{.value = 0.3,
                    .ideal = 0.3,
                    .proxy = 0.9,
                    .ideal_proxy = 0.9,
                    .judging_weights = true,
                    .bones = 2};
  EXPECT_EQ(book_mesh_finding(kArea, 0.75, facts).owner, Owner::skeleton);
  EXPECT_FALSE(book_mesh_finding(kArea, 0.75, facts).decides);
  facts.bones = 3;
  EXPECT_EQ(book_mesh_finding(kArea, 0.75, facts).owner, Owner::weights);
  EXPECT_TRUE(book_mesh_finding(kArea, 0.75, facts).decides);
  facts.value = facts.ideal = 0.65;  // below the limit, and not plainly
  EXPECT_EQ(book_mesh_finding(kArea, 0.75, facts).verdict, Verdict::fail);
  EXPECT_FALSE(book_mesh_finding(kArea, 0.75, facts).decides);
}

TEST(BookMeshFinding, SlicesOfASpineOfTwoBonesAreItsOwn) {
  MeshContext facts{
      .value = 63.0, .ideal = 63.0, .proxy = 12.0, .ideal_proxy = 12.0, .judging_weights = true};
  for (const int bones : {1, 2}) {
    facts.bones = bones;
    EXPECT_EQ(book_mesh_finding(kKink, 25.0, facts).owner, Owner::skeleton) << bones;
    EXPECT_FALSE(book_mesh_finding(kKink, 25.0, facts).decides) << bones;
  }
  facts.bones = kLeastBonesForSlices;
  EXPECT_EQ(book_mesh_finding(kKink, 25.0, facts).owner, Owner::weights);
  facts.longest_bone = 0.56;
  EXPECT_EQ(book_mesh_finding(kKink, 25.0, facts).owner, Owner::skeleton) << "one bone is the most";
  facts.longest_bone = 0.4;
  EXPECT_EQ(book_mesh_finding(kKink, 25.0, facts).owner, Owner::weights);
  // Another check is asked of any spine, and a rig that is worse than the ideal bend stays to
  // blame.
  facts.bones = 2;
  facts.ideal_proxy = 1.0;
  EXPECT_EQ(book_mesh_finding(*find_check("BB032"), 20.0, facts).owner, Owner::weights);
  facts.ideal = facts.ideal_proxy = 12.0;
  EXPECT_EQ(book_mesh_finding(kKink, 25.0, facts).owner, Owner::solver);
}

TEST(BookMeshFinding, AHeadOnTheSecondBoneRunsIntoTheBodyWhateverTheWeights) {
  MeshContext facts{.value = 14.2,
                    .ideal = 14.2,
                    .proxy = 0.0,
                    .ideal_proxy = 0.0,
                    .judging_weights = true,
                    .bones = 2};
  const Check& crossing = *find_check("BB034");
  EXPECT_EQ(book_mesh_finding(crossing, 2.16, facts).owner, Owner::skeleton);
  EXPECT_FALSE(book_mesh_finding(crossing, 2.16, facts).decides);
  facts.bones = kLeastBonesForSlices;
  EXPECT_EQ(book_mesh_finding(crossing, 2.16, facts).owner, Owner::weights);
  EXPECT_TRUE(book_mesh_finding(crossing, 2.16, facts).decides);
}

TEST(IsRestShape, IsWhatTheIdealBendShowsOnTheSameRestSpine) {
  const Check& kink = *find_check("BB010");
  EXPECT_TRUE(is_rest_shape(kink, 2.0, 2.5, 2.5));
  EXPECT_TRUE(is_rest_shape(kink, 2.0, 2.6, 2.5));
  EXPECT_FALSE(is_rest_shape(kink, 2.0, 3.0, 2.5)) << "worse than the ideal bend";
  EXPECT_FALSE(is_rest_shape(kink, 2.0, 2.5, 1.9)) << "the ideal bend passes";
  EXPECT_FALSE(is_rest_shape(*find_check("BB020"), 0.5, 0.6, 0.6)) << "arms drift on any shape";
}

TEST(BookMeshFinding, AWeakSkeletonDoesNotExcuseWeightsThatAreFarWorseThanCleanOnes) {
  const Booking b = book_mesh_finding(
      kKink, 25.0,
      {.value = 63.0, .ideal = 63.0, .proxy = 30.0, .ideal_proxy = 30.0, .judging_weights = true});
  EXPECT_EQ(b.owner, Owner::weights);
  EXPECT_TRUE(b.decides);
}

TEST(BookMeshFinding, ABodyThatIsInItsOwnWayWithCleanWeightsTooIsThePoses) {
  const Check& crossing = *find_check("BB034");
  MeshContext facts{
      .value = 9.0, .ideal = 9.0, .proxy = 3.0, .ideal_proxy = 3.0, .judging_weights = true};
  EXPECT_EQ(book_mesh_finding(crossing, 2.0, facts).owner, Owner::pose);
  EXPECT_FALSE(book_mesh_finding(crossing, 2.0, facts).decides);
  facts.proxy = facts.ideal_proxy = 1.0;
  EXPECT_EQ(book_mesh_finding(crossing, 2.0, facts).owner, Owner::weights);
  EXPECT_TRUE(book_mesh_finding(crossing, 2.0, facts).decides);
}

TEST(BookMeshFinding, AWeakSkeletonDoesNotExcuseARigThatIsWorseThanTheIdeal) {
  const Booking b = book_mesh_finding(
      kKink, 25.0, {.value = 63.0, .ideal = 30.0, .proxy = 60.0, .ideal_proxy = 29.0});
  EXPECT_EQ(b.owner, Owner::solver);
  EXPECT_TRUE(b.decides);
}

TEST(BookMeshFinding, AStudiosRigThatSharesABendUnevenlyIsNotToBlameForWhatEveryShareShows) {
  MeshContext context;
  context.bones = 3;
  context.ideal = 40.0;  // of BB011's 25
  context.proxy = context.ideal_proxy = 38.0;
  for (const double value : {45.0, 53.0, 60.0}) {
    context.value = value;
    context.own_shares = true;
    const Booking booking = book_mesh_finding(*find_check("BB011"), 25.0, context);
    EXPECT_EQ(booking.owner, value < 54.0 ? Owner::skeleton : Owner::solver) << value;
    EXPECT_EQ(booking.decides, value > 54.0) << value;
    context.own_shares = false;  // ours: held against the ideal bend itself
    EXPECT_EQ(book_mesh_finding(*find_check("BB011"), 25.0, context).owner, Owner::solver) << value;
  }
  // Of an area that is kept, its loss counts.
  context = {.value = 0.48, .ideal = 0.6, .own_shares = true};
  context.ideal_proxy = 0.62;
  EXPECT_FALSE(book_mesh_finding(*find_check("BB030"), 0.75, context).decides);
  context.value = 0.3;
  EXPECT_TRUE(book_mesh_finding(*find_check("BB030"), 0.75, context).decides);
  // Where the plain share passes near the limit, the rig's own may be a little beyond it.
  context = {.value = 30.0, .ideal = 24.0, .own_shares = true};
  EXPECT_FALSE(book_mesh_finding(*find_check("BB011"), 25.0, context).decides);
  context.ideal = 18.0;
  EXPECT_TRUE(book_mesh_finding(*find_check("BB011"), 25.0, context).decides);
}

TEST(JointsNeeded, ShareAKinkOutAndKeepASlice) {
  EXPECT_EQ(joints_needed(kKink, 25.0, 45.0, 5), 9);  // 5 x 45 / 25
  // A slice keeps cos^2 of half the twist between two joints: 0.25 at 120 degrees, 0.75 at 60.
  EXPECT_EQ(joints_needed(kArea, 0.75, 0.25, 4), 8);
  EXPECT_EQ(joints_needed(kKink, 25.0, 20.0, 5), 0);                 // nothing is missing
  EXPECT_EQ(joints_needed(*find_check("BB032"), 20.0, 40.0, 5), 0);  // no such rule
}

TEST(Judge, TakesAValueAsReportsPrintIt) {
  const Check& twist = *find_check("BB036");
  EXPECT_EQ(judge(twist, 15.004, 15.0), Verdict::pass);  // reads 15
  EXPECT_EQ(judge(twist, 15.006, 15.0), Verdict::fail);  // reads 15.01
  EXPECT_EQ(judge(kArea, 0.749996, 0.75), Verdict::pass);
  EXPECT_EQ(judge(kArea, 0.7494, 0.75), Verdict::fail);
  EXPECT_EQ(judge(*find_check("BB061"), 1.0, 0.0), Verdict::fail);
  EXPECT_EQ(judge(twist, kNan, 15.0), Verdict::not_measured);
}

}  // namespace
}  // namespace backbend::validate
