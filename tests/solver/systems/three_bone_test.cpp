// The baseline: R1, R2, R46, R54, R158.
#include "tests/solver/rig_fixture.h"

namespace backbend::solver {
namespace {

using namespace rigs;

TEST(ThreeBone, StraightChainGivesTheClosedFormJoints) {  // R1
  const auto fk = build("three_bone");
  const SpinePose b = fk->solve(pose_b());
  expect_near(b.position[1], {0, std::sqrt(3.0), 1}, 1e-12);
  expect_near(b.position[2], {0, 1 + std::sqrt(3.0), 1 + std::sqrt(3.0)}, 1e-12);
  expect_near(b.position[3], {0, 1 + std::sqrt(3.0), 3 + std::sqrt(3.0)}, 1e-12);
  expect_near(fk->solve(pose_c()).position[3], {0, -2, -2 * std::sqrt(3.0)}, 1e-12);
  expect_near(fk->solve(pose_f()).position[3], {0, 4 - std::sqrt(3.0), -1}, 1e-12);
}

TEST(ThreeBone, LowerCarriesEverythingRigidly) {  // R2
  for (const RestChain& chain : {straight(), curved()}) {
    const auto fk = build("three_bone", {}, chain);
    const SpinePose pose = fk->solve(pose_deg({30, -50, 70}, {0, 0, 0}, {0, 0, 0}));
    const dquat r = pose.turn[0];
    for (std::size_t i = 0; i < 4; ++i) {
      expect_near(pose.position[i], chain.joint[0] + r * (chain.joint[i] - chain.joint[0]), 1e-12);
      EXPECT_LT(angle_between(pose.turn[i], r), 1e-12);
    }
  }
}

TEST(ThreeBone, SignsAreTheSpecifications) {  // the axis test: fails if any axis is swapped
  const auto fk = build("three_bone");
  const auto tip = [&](const BodyPose& body) {
    return fk->solve(fk->controls_for(body, Mapping::chest)).position[3];
  };
  EXPECT_GT(tip({.flexion = radians(40)}).z, 1.0);     // forward is +Z
  EXPECT_LT(tip({.extension = radians(40)}).z, -1.0);  // a backbend goes to -Z
  EXPECT_GT(tip({.side = radians(40)}).x, 1.0);        // the character's left is +X
  // Twist to the left turns the chest's front from +Z toward +X.
  const SpinePose twisted = fk->solve(fk->controls_for({.twist = radians(40)}, Mapping::chest));
  expect_near(twisted.chest.turn * dvec3(0, 0, 1),
              {std::sin(radians(40)), 0, std::cos(radians(40))}, 1e-12);
}

TEST(ThreeBone, SpreadPutsHalfOnMiddleAndHalfOnTop) {
  const auto fk = build("three_bone");
  const BodyPose body{.extension = 0.8, .flexion = 0.2, .side = 0.3, .twist = 7.0};
  EXPECT_EQ(
      fk->controls_for(body, Mapping::spread),
      (std::vector<double>{0, 0, 0, 3.5, -0.15, 0.5 * (0.2 - 0.8), 3.5, -0.15, 0.5 * (0.2 - 0.8)}));
}

TEST(ThreeBone, ALongChainIsCutAtThirdsOfItsArc) {
  RestChain chain;
  for (int i = 0; i <= 19; ++i) chain.joint.push_back({0, 0.3 * i, 0.02 * i * (19 - i)});
  const auto fk = build("three_bone", {}, chain);
  ASSERT_EQ(fk->rest().joint_count(), 4u);
  expect_near(fk->rest().position[0], chain.joint.front(), 0.0);
  expect_near(fk->rest().position[3], chain.joint.back(), 0.0);
  double arc = 0.0, third = 0.0;
  for (std::size_t i = 1; i < chain.joint.size(); ++i)
    arc += glm::length(chain.joint[i] - chain.joint[i - 1]);
  // The arc of the drawn polyline up to the first cut, by walking it.
  const dvec3 cut = fk->rest().position[1];
  for (std::size_t i = 1; i < chain.joint.size(); ++i) {
    const dvec3 a = chain.joint[i - 1], b = chain.joint[i];
    const double along = glm::dot(cut - a, glm::normalize(b - a));
    if (along >= 0 && along <= glm::length(b - a) &&
        glm::length(a + along * glm::normalize(b - a) - cut) < 1e-9) {
      third += along;
      break;
    }
    third += glm::length(b - a);
  }
  EXPECT_NEAR(third, arc / 3.0, 1e-9);
}

TEST(ThreeBone, ADrawnChainOfFourJointsIsTakenAsItIs) {
  const auto fk = build("three_bone", {}, curved());
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(fk->rest().position[i], curved().joint[i]);
}

TEST(ThreeBone, RefusesChainsThatAreNone) {
  EXPECT_THROW(build("three_bone", {}, {.joint = {{0, 0, 0}}}), RigError);
  EXPECT_THROW(build("three_bone", {}, {.joint = {{0, 0, 0}, {0, 0, 0}, {0, 1, 0}, {0, 2, 0}}}),
               RigError);
  EXPECT_THROW(build("three_bone", {}, {.joint = {{0, 0, 0}, {0, std::nan(""), 0}}}), RigError);
  EXPECT_THROW(build("three_bone", {}, {.joint = {{0, 0, 0}, {0, 1, 0}}, .left = {0, 0, 0}}),
               RigError);
}

TEST(ThreeBone, ABoneAlongTheLeftAxisStillHasAFrame) {
  const auto fk = build("three_bone", {}, {.joint = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}});
  const SpinePose pose = fk->solve(pose_b());
  for (const dquat& q : pose.turn) EXPECT_NEAR(glm::length(q), 1.0, 1e-12);
}

}  // namespace
}  // namespace backbend::solver
