// The stretchy spine, requirement by requirement (research/seeds.md 2g), on its own fixtures: rest
// CVs straight up to 6, twenty bones.
#include <array>
#include <cmath>

#include "solver/curves/curve.h"
#include "tests/solver/rig_fixture.h"

namespace backbend::solver {
namespace {

using namespace rigs;
using Cvs = std::array<dvec3, 4>;

const Cvs kRest{dvec3(0, 0, 0), {0, 2, 0}, {0, 4, 0}, {0, 6, 0}};
const Cvs kLong{dvec3(0, 0, 0), {0, 3, 0}, {0, 6, 0}, {0, 9, 0}};
const Cvs kShort{dvec3(0, 0, 0), {0, 1.5, 0}, {0, 3, 0}, {0, 4.5, 0}};
const Cvs kBent{dvec3(0, 0, 0), {0, 3, 0}, {0, 5, 3}, {0, 4, 7}};
const Cvs kCrazy{dvec3(0, 0, 0), {0, 9, 0}, {3, -3, 5}, {0, 6, 0}};
const Cvs kPoint{dvec3(1, 1, 1), {1, 1, 1}, {1, 1, 1}, {1, 1, 1}};

RestChain drawn(const Cvs& cv = kRest) {
  RestChain chain;
  chain.curve.assign(cv.begin(), cv.end());
  return chain;
}

struct Scalars {
  double stretchiness = 1.0, lead = 0.0, compression = 0.0, slide = 0.0;
};

SpinePose solved(const Cvs& cv, const Scalars& scalars, Options options = {}) {
  const auto system = build("stretchy", std::move(options), drawn());
  std::vector<double> control;
  for (const dvec3& p : cv) control.insert(control.end(), {p.x, p.y, p.z});
  for (const double s : {scalars.stretchiness, scalars.lead, scalars.compression, scalars.slide}) {
    control.push_back(s);
  }
  return system->solve(control);
}

Options carved(const char* reading = "span") { return {{"form", "carve"}, {"carve", reading}}; }

double sum_of_bones(const SpinePose& pose) { return measure(pose, "chain_length"); }

TEST(Stretchy, ABodysStretchIsTheSameWhereverItsCurveStands) {
  const dvec3 away(3.0, -2.0, 5.0);
  Cvs moved = kRest;
  for (dvec3& p : moved) p += away;
  const auto here = build("stretchy", {}, drawn()), there = build("stretchy", {}, drawn(moved));
  for (const Mapping mapping : {Mapping::chest, Mapping::spread})
    for (const double stretch : {0.8, 1.0, 1.3}) {
      const BodyPose body{.extension = 0.4, .side = 0.1, .twist = 0.2, .stretch = stretch};
      const SpinePose a = here->solve(here->controls_for(body, mapping));
      const SpinePose b = there->solve(there->controls_for(body, mapping));
      for (std::size_t i = 0; i < a.joint_count(); ++i)
        expect_near(b.position[i], a.position[i] + away, 1e-9);
    }
}

TEST(Stretchy, RatioBlendsBetweenTheRestLengthAndTheCurves) {  // R69
  for (const auto& [cv, s, ratio] : {std::tuple{kLong, 0.0, 1.0},
                                     {kLong, 0.5, 1.25},
                                     {kLong, 1.0, 1.5},
                                     {kShort, 0.0, 1.0},
                                     {kShort, 0.5, 0.875},
                                     {kShort, 1.0, 0.75},
                                     {kBent, 0.0, 1.0},
                                     {kBent, 0.5, 1.281546},
                                     {kBent, 1.0, 1.563092},
                                     {kCrazy, 1.0, 1.725738}}) {
    EXPECT_NEAR(measure(solved(cv, {.stretchiness = s}), "ratio"), ratio, 1e-6);
  }
}

TEST(Stretchy, BonesAddUpToTheRatioTimesTheirRest) {  // R70, R72, R85
  for (const Cvs& cv : {kLong, kShort, kBent, kCrazy}) {
    EXPECT_NEAR(sum_of_bones(solved(cv, {.stretchiness = 0.0})), 6.0, 1e-9);
    const SpinePose pose = solved(cv, {.stretchiness = 0.5});
    EXPECT_NEAR(sum_of_bones(pose), 6.0 * measure(pose, "ratio"), 1e-9);
  }
  EXPECT_NEAR(measure(solved(kLong, {.stretchiness = 0.5}), "bone_length"), 0.375, 1e-12);
  EXPECT_NEAR(measure(solved(kLong, {.stretchiness = 0.0}), "end_gap"), 3.0, 1e-9);
  EXPECT_NEAR(measure(solved(kShort, {.stretchiness = 0.0}), "end_gap"), 1.5, 1e-9);
}

TEST(Stretchy, HasTwentyBonesUnlessAsked) {  // R75
  EXPECT_EQ(build("stretchy", {}, drawn())->rest().joint_count(), 21u);
  EXPECT_EQ(build("stretchy", {{"bones", 7.0}}, drawn())->rest().joint_count(), 8u);
}

TEST(Stretchy, EveryBoneGetsTheSameRatio) {  // R162: also where the rest bones differ
  const auto system = build("stretchy", {{"bones", 5.0}}, drawn(kCrazy));
  const auto& rest = system->rest().position;
  std::vector<double> control = rest_controls(*system);
  for (std::size_t i = 0; i < 12; ++i) control[i] *= 1.5;
  const SpinePose pose = system->solve(control);
  for (int k = 0; k < 5; ++k) {
    EXPECT_NEAR(glm::length(pose.position[k + 1] - pose.position[k]),
                1.5 * glm::length(rest[k + 1] - rest[k]), 1e-9);
  }
}

TEST(Stretchy, ACollapsedCurveIsFiniteAndSaysSo) {  // R71
  for (const Options& form : {Options{}, carved(), carved("literal")}) {
    for (const double s : {0.0, 0.5, 1.0}) {
      const SpinePose pose = solved(kPoint, {.stretchiness = s}, form);
      EXPECT_NEAR(measure(pose, "ratio"), 1.0 - s, 1e-12);
      for (std::size_t i = 0; i < pose.joint_count(); ++i) {
        EXPECT_TRUE(std::isfinite(glm::length(pose.position[i])));
        EXPECT_LE(angle_between(pose.turn[i], kNoTurn), 1e-12);  // frames fall back to rest
      }
      ASSERT_FALSE(pose.flags.empty());
      EXPECT_NE(pose.flags.front().find("single point"), std::string::npos);
    }
  }
}

TEST(Stretchy, OrdinarySplineIkMissesTheControlWhenBent) {  // R76 (oracle): the chain overruns
  EXPECT_NEAR(measure(solved(kBent, {}), "end_gap"), 0.003458, 1e-5);
  EXPECT_NEAR(measure(solved(kCrazy, {}), "end_gap"), 0.441563, 1e-4);
  EXPECT_NEAR(measure(solved(kLong, {}), "end_gap"), 0.0, 1e-9);
}

TEST(Stretchy, CarvedPointsAreEquallySpacedByArc) {  // R77
  const SpinePose pose = solved(kBent, {.stretchiness = 0.5, .lead = 0.3}, carved());
  ASSERT_EQ(pose.joint_count(), 21u);
  const Curve curve = Curve::bezier(kBent);
  const double u1 = measure(pose, "u1"), u2 = measure(pose, "u2");
  for (int k = 0; k <= 20; ++k) {
    expect_near(pose.position[k], curve.at_fraction(u1 + (u2 - u1) * k / 20.0).position, 1e-12);
  }
}

TEST(Stretchy, LiteralCarveUsesThePrintedRatio) {  // R78
  for (const auto& [cv, ratio] : {std::pair{kShort, 0.75}, {kLong, 1.25}}) {
    const double s = ratio == 1.25 ? 0.5 : 1.0;
    const SpinePose pose = solved(cv, {.stretchiness = s, .lead = 0.5}, carved("literal"));
    EXPECT_NEAR(measure(pose, "u1"), 0.5 * (1.0 - ratio), 1e-12);
    EXPECT_NEAR(measure(pose, "u2") - measure(pose, "u1"), ratio, 1e-12);
  }
  // ... and so breaks its own promise on a shorter curve (R80).
  const SpinePose shorter = solved(kShort, {}, carved("literal"));
  EXPECT_NEAR(measure(shorter, "u2"), 0.75, 1e-12);
  EXPECT_NEAR(measure(shorter, "end_gap"), 1.125, 1e-9);
}

TEST(Stretchy, SpanCarveTakesTheFractionOfTheCurrentCurve) {  // R79
  for (const auto& [lead, u1, u2] :
       {std::tuple{0.0, 0.0, 2.0 / 3.0}, {0.5, 1.0 / 6.0, 5.0 / 6.0}, {1.0, 1.0 / 3.0, 1.0}}) {
    const SpinePose pose = solved(kLong, {.stretchiness = 0.0, .lead = lead}, carved());
    EXPECT_NEAR(measure(pose, "u1"), u1, 1e-12);
    EXPECT_NEAR(measure(pose, "u2"), u2, 1e-12);
    EXPECT_NEAR(sum_of_bones(pose), 6.0, 1e-9);
  }
  EXPECT_NEAR(sum_of_bones(solved(kLong, {.stretchiness = 0.5}, carved())), 7.5, 1e-9);
}

TEST(Stretchy, FullyStretchedCarveSitsOnBothControlsHoweverWildTheCurve) {  // R80
  for (const Cvs& cv : {kRest, kLong, kShort, kBent, kCrazy}) {
    for (const double lead : {0.0, 0.5, 1.0}) {
      const SpinePose pose = solved(cv, {.lead = lead}, carved());
      EXPECT_LT(measure(pose, "start_gap"), 1e-9);
      EXPECT_LT(measure(pose, "end_gap"), 1e-9);
    }
  }
}

TEST(Stretchy, LeadChoosesTheEndThatStaysPut) {  // R81, W7: in both forms
  for (const Options& form : {Options{}, carved()}) {
    for (const auto& [lead, start, end] :
         {std::tuple{0.0, 0.0, 3.0}, {0.5, 1.5, 1.5}, {1.0, 3.0, 0.0}}) {
      const SpinePose pose = solved(kLong, {.stretchiness = 0.0, .lead = lead}, form);
      EXPECT_NEAR(measure(pose, "start_gap"), start, 1e-9);
      EXPECT_NEAR(measure(pose, "end_gap"), end, 1e-9);
    }
    EXPECT_NEAR(measure(solved(kBent, {.stretchiness = 0.2, .lead = 1.0}, form), "end_gap"), 0.0,
                1e-7);
  }
}

TEST(Stretchy, CompressionShortensTowardsTheLeadEnd) {  // R82, W7: in both forms
  for (const Options& form : {Options{}, carved()}) {
    for (const auto& [lead, start, end] : {std::tuple{0.0, 0.0, 1.5}, {1.0, 1.5, 0.0}}) {
      const SpinePose pose = solved(kRest, {.lead = lead, .compression = 0.25}, form);
      EXPECT_NEAR(sum_of_bones(pose), 4.5, 1e-9);
      EXPECT_NEAR(measure(pose, "start_gap"), start, 1e-9);
      EXPECT_NEAR(measure(pose, "end_gap"), end, 1e-9);
    }
  }
}

TEST(Stretchy, SlideMovesTheSpineAndNeverItsLength) {  // A17
  for (const Options& form : {Options{}, carved()}) {
    double before = -1.0;
    for (double slide = 0.0; slide <= 0.6; slide += 0.05) {
      const SpinePose pose = solved(kLong, {.stretchiness = 0.0, .slide = slide}, form);
      EXPECT_NEAR(sum_of_bones(pose), 6.0, 1e-9);
      EXPECT_NEAR(measure(pose, "start_gap"), std::min(9.0 * slide, 3.0), 1e-9);
      EXPECT_EQ(!pose.flags.empty(), 9.0 * slide > 3.0 + 1e-9);  // stopped at the curve's end
      EXPECT_GE(measure(pose, "start_gap"), before);
      before = measure(pose, "start_gap");
    }
  }
}

TEST(Stretchy, ASpineLongerThanItsCurveIsCutOrRunsOn) {  // A16
  const SpinePose cut = solved(kShort, {.stretchiness = 0.0}, carved());
  EXPECT_NEAR(sum_of_bones(cut), 4.5, 1e-9);
  EXPECT_NEAR(measure(cut, "u2"), 4.0 / 3.0, 1e-12);  // reported before the cut
  EXPECT_FALSE(cut.flags.empty());
  Options extend = carved();
  extend["past_end"] = "extend";
  const SpinePose on = solved(kShort, {.stretchiness = 0.0}, extend);
  EXPECT_NEAR(sum_of_bones(on), 6.0, 1e-9);
  EXPECT_NEAR(measure(on, "end_gap"), 1.5, 1e-9);
}

TEST(Stretchy, LimitsOfTheRatio) {  // W13, A20, W15
  const SpinePose most = solved(kLong, {}, {{"max_ratio", 1.2}});
  EXPECT_NEAR(measure(most, "ratio"), 1.2, 1e-12);
  EXPECT_NEAR(sum_of_bones(most), 7.2, 1e-9);
  EXPECT_NEAR(measure(solved(kShort, {}, {{"no_squash", true}}), "ratio"), 1.0, 1e-12);
  Cvs stretched = kRest;
  for (dvec3& p : stretched) p *= 1.44;
  EXPECT_NEAR(measure(solved(stretched, {}), "volume"), 1.0 / 1.2, 1e-9);
}

TEST(Stretchy, ConstantsAreTakenAtCreation) {  // R67, R163, A19: two constants
  const auto system = build("stretchy", {}, drawn(kCrazy));
  // Chords of a bent rest curve are shorter than its arc, and the ratio still uses the arc.
  EXPECT_NEAR(measure(system->rest(), "rest_curve_length"), 10.354427, 1e-6);
  EXPECT_LT(sum_of_bones(system->rest()), 10.354427);
  EXPECT_NEAR(measure(system->rest(), "ratio"), 1.0, 1e-12);
  std::vector<double> control = rest_controls(*system);
  control[10] += 3.0;
  const SpinePose pose = system->solve(control);
  EXPECT_NEAR(measure(pose, "rest_curve_length"), 10.354427, 1e-6);
}

TEST(Stretchy, ClampsStretchinessAndSaysSo) {  // R68
  EXPECT_NEAR(measure(solved(kLong, {.stretchiness = 1.5}), "ratio"), 1.5, 1e-12);
  EXPECT_FALSE(solved(kLong, {.stretchiness = 1.5}).flags.empty());
  EXPECT_TRUE(solved(kLong, {.stretchiness = 1.0}).flags.empty());
  EXPECT_THROW(build("stretchy", {{"stretchiness", 1.5}}), RigError);
}

TEST(Stretchy, RestCurvesWithoutFourCvsAreRefused) {
  RestChain three;
  three.curve = {{0, 0, 0}, {0, 1, 0}, {0, 2, 0}};
  EXPECT_THROW(build("stretchy", {}, three), RigError);
  EXPECT_THROW(build("stretchy", {}, drawn(kPoint)), RigError);
}

TEST(Stretchy, FramesFollowTheChainWithoutRoll) {
  // In a planar bend the side axis stays where it was, to the last joint.
  const SpinePose pose = solved(kBent, {});
  for (const dquat& q : pose.turn) expect_near(q * kAxisX, kAxisX, 1e-12);
  EXPECT_NEAR((pose.turn.back() * kAxisY).z,
              glm::normalize(pose.position[20] - pose.position[19]).z, 1e-12);
}

TEST(Stretchy, EveryJumpIsWhereTheMarginVanishes) {
  // The chest folds back over the hips: bones double back on those before, and the frames jump.
  const auto system = build("stretchy", {{"bones", 8.0}, {"stretchiness", 0.0}});
  auto control = rest_controls(*system);
  control[channel(*system, "chest_move.y")] = -9.0;
  control[channel(*system, "chest_move.x")] = 0.02;
  const auto jumps = find_jumps(*system, control, "chest.rz", 100.0, 260.0, 1.0);
  ASSERT_FALSE(jumps.empty());
  for (const Jump& j : jumps) {
    control[channel(*system, "chest.rz")] = radians(j.at_deg);
    EXPECT_LT(system->solve(control).flip_margin[j.joint], 1e-3) << j.joint << " at " << j.at_deg;
  }
  for (const double margin : system->rest().flip_margin) EXPECT_GT(degrees(margin), 90.0);
}

TEST(Stretchy, TwistIsSpreadPastAnyTurnWhenAsked) {  // W8: twenty bones, two turns, no flip
  const auto system = build("stretchy", {{"twist", "spread"}});
  const auto at = [&](double deg) {
    std::vector<double> control = rest_controls(*system);
    control[channel(*system, "chest.rx")] = radians(deg);
    return control;
  };
  EXPECT_LE(largest_step_deg(*system, at, 0.0, 720.0, 1.0), 1.01);
  EXPECT_NEAR(turn_between_deg(system->solve(at(90.0)), system->rest(), 9), 45.0, 1e-9);
  EXPECT_NEAR(turn_between_deg(system->solve(at(90.0)), system->rest(), 20), 90.0, 1e-9);
}

TEST(Stretchy, OnACharacterHipAndChestPlaceTheCurve) {
  const auto system = build("stretchy");
  std::vector<double> control = rest_controls(*system);
  control[channel(*system, "chest.rz")] = radians(-90.0);
  const SpinePose pose = system->solve(control);
  // Chest in place, its handle 0.4 x 6 back along where it points: straight back (-Z).
  const Curve curve = Curve::bezier({dvec3(0, 0, 0), {0, 2.4, 0}, {0, 6, 2.4}, {0, 6, 0}});
  EXPECT_NEAR(measure(pose, "curve_length"), curve.length(), 1e-9);
  expect_near(pose.chest.posed_origin, {0, 6, 0}, 1e-12);
  control[channel(*system, "chest_move.y")] = 3.0;
  expect_near(system->solve(control).chest.posed_origin, {0, 9, 0}, 1e-12);
}

TEST(Stretchy, HipsCarryTheStartOfTheChain) {
  const auto system = build("stretchy", {{"twist", "spread"}});
  std::vector<double> control = rest_controls(*system);
  control[channel(*system, "hip.rx")] = radians(40.0);
  const SpinePose pose = system->solve(control);
  // The hips have turned by 40, the chest by nothing: the chain unwinds on the way up.
  EXPECT_NEAR(turn_between_deg(pose, system->rest(), 0), 38.0, 1e-9);
  EXPECT_NEAR(turn_between_deg(pose, system->rest(), 20), 0.0, 1e-9);
  control[channel(*system, "chest.rx")] = radians(40.0);
  for (const dquat& q : system->solve(control).turn) {
    EXPECT_LE(angle_between(q, turn_about(kAxisY, radians(40.0))), 1e-12);
  }
}

TEST(Stretchy, WhereAllCvsGoTheChainGoes) {
  const dvec3 there(1.0, -2.0, 3.0);
  Cvs moved = kBent;
  for (dvec3& cv : moved) cv += there;
  for (const Options& form : {Options{}, carved()}) {
    const SpinePose a = solved(kBent, {.stretchiness = 0.5}, form);
    const SpinePose b = solved(moved, {.stretchiness = 0.5}, form);
    expect_near(b.position.front(), moved[0], 1e-9);
    for (std::size_t i = 0; i < a.joint_count(); ++i)
      expect_near(b.position[i], a.position[i] + there, 1e-9);
  }
}

TEST(Stretchy, BodyPosesMeanTheSameForCvsAndForAChest) {
  const auto cvs =
      build("stretchy", {{"depth", std::vector<double>{1.0 / 3.0, 1.0 / 3.0}}}, drawn());
  const auto joints = build("stretchy", {{"depth", std::vector<double>{1.0 / 3.0, 1.0 / 3.0}}});
  for (const Mapping mapping : {Mapping::chest, Mapping::spread}) {
    for (const BodyPose& body : {BodyPose{.extension = 0.9}, BodyPose{.side = 0.5, .twist = 0.7}}) {
      const SpinePose a = cvs->solve(cvs->controls_for(body, mapping));
      const SpinePose b = joints->solve(joints->controls_for(body, mapping));
      for (std::size_t i = 0; i < a.joint_count(); ++i) {
        expect_near(a.position[i], b.position[i], 1e-9);
      }
    }
  }
  EXPECT_LT(
      joints->solve(joints->controls_for({.extension = 0.9}, Mapping::spread)).position.back().z,
      -1.0);
}

TEST(Stretchy, IntendedCurveIsThePartThatTheChainTakes) {
  const auto system = build("stretchy", carved(), drawn());
  std::vector<double> control = rest_controls(*system);
  control[channel(*system, "lead")] = 1.0;
  control[channel(*system, "compression")] = 0.25;
  const auto point = system->intended_curve(control, 4);
  expect_near(point.front(), {0, 1.5, 0}, 1e-9);
  expect_near(point[1], {0, 3.0, 0}, 1e-9);
  expect_near(point.back(), {0, 6, 0}, 1e-9);
}

}  // namespace
}  // namespace backbend::solver
