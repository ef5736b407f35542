// How a solved spine moves a skeleton: a stick figure whose answers can be worked out by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <random>

#include "skin/anatomy.h"
#include "skin/matrix_facts.h"
#include "tests/skin/stick_figure.h"

namespace backbend::skin {
namespace {

using solver::build_system;
using solver::SpinePose;
using solver::SpineSystem;

glm::dmat4 rest_of(const Character& character, const std::string& name) {
  return character.nodes[static_cast<std::size_t>(stick_node(character, name))].world_from_node;
}

/// A driven stick figure.
struct Driven {
  Character character = stick_figure();
  Anatomy anatomy = find_anatomy(character);
  SpineDriver driver{character, anatomy};
  std::unique_ptr<SpineSystem> system;

  explicit Driven(const std::string& name)
      : system(build_system({name, {}}, driver.rest_chain())) {}

  std::vector<glm::dmat4> pose(const solver::BodyPose& body, SpinePose* out = nullptr) const {
    const SpinePose solved = system->solve(system->controls_for(body, solver::Mapping::chest));
    if (out) *out = solved;
    return driver.drive(*system, solved);
  }
  glm::dmat4 of(const std::vector<glm::dmat4>& world, const std::string& name) const {
    return world[static_cast<std::size_t>(stick_node(character, name))];
  }
};

double apart(const glm::dmat4& a, const glm::dmat4& b) {
  double most = 0.0;
  for (int c = 0; c < 4; ++c) most = std::max(most, glm::length(a[c] - b[c]));
  return most;
}

class EverySystem : public ::testing::TestWithParam<const char*> {};

TEST_P(EverySystem, LeavesTheSkeletonExactlyAtRest) {
  const Driven rig(GetParam());
  const auto world = rig.driver.drive(*rig.system, rig.system->rest());
  for (std::size_t n = 0; n < world.size(); ++n)
    EXPECT_EQ(world[n], rig.character.nodes[n].world_from_node) << rig.character.nodes[n].name;
}

TEST_P(EverySystem, MovesEveryNodeRigidly) {
  const Driven rig(GetParam());
  const auto world = rig.pose({.extension = 1.0, .side = 0.3, .twist = 0.5});
  for (std::size_t n = 0; n < world.size(); ++n) {
    const glm::dmat3 axes = glm::transpose(glm::dmat3(world[n])) * glm::dmat3(world[n]);
    const glm::dmat3 rest(rig.character.nodes[n].world_from_node);
    EXPECT_LT(apart(glm::dmat4(axes), glm::dmat4(glm::transpose(rest) * rest)), 1e-12);
  }
}

TEST_P(EverySystem, CarriesArmsLegsAndHeadAsThePoseSays) {
  const Driven rig(GetParam());
  SpinePose pose;
  const auto world = rig.pose({.extension = 0.8, .twist = 0.4}, &pose);
  EXPECT_TRUE(rig.driver.arms_follow_chest());
  const auto moved = [&](const solver::RigidMotion& motion, const char* name) {
    return apart(rig.of(world, name),
                 rigid_matrix(motion.turn, motion.rest_origin, motion.posed_origin) *
                     rest_of(rig.character, name));
  };
  EXPECT_LT(moved(pose.arms, "clavicle.L"), 1e-12);
  EXPECT_LT(moved(pose.arms, "hand.R"), 1e-12);
  EXPECT_LT(moved(pose.hip, "hips"), 1e-12);
  EXPECT_LT(moved(pose.hip, "foot.L"), 1e-12);
  // The head keeps its place on the neck, which goes with the chain's last joint.
  const glm::dmat4 neck = rig.of(world, "neck"), head = rig.of(world, "head");
  const glm::dmat4 at_rest =
      glm::inverse(rest_of(rig.character, "neck")) * rest_of(rig.character, "head");
  EXPECT_LT(apart(glm::inverse(neck) * head, at_rest), 1e-12);
  EXPECT_EQ(rig.of(world, "scene"), rest_of(rig.character, "scene"));
}

INSTANTIATE_TEST_SUITE_P(Driver, EverySystem,
                         ::testing::Values("three_bone", "curve", "isner", "stretchy", "even",
                                           "spline_ik", "matrix_blend"));

TEST(SpineDriver, HandsTheChainFromTheHipsToTheBaseOfTheNeck) {
  const Driven rig("even");
  const solver::RestChain& chain = rig.driver.rest_chain();
  ASSERT_EQ(chain.joint.size(), 4u);  // hips, spine_1, spine_2, neck
  EXPECT_EQ(chain.joint.front(), origin(rest_of(rig.character, "hips")));
  EXPECT_EQ(chain.joint.back(), origin(rest_of(rig.character, "neck")));
  EXPECT_EQ(chain.left, glm::dvec3(1.0, 0.0, 0.0));
}

TEST(SpineDriver, SetsAJointBetweenTwoOfTheSystemsByArcFraction) {
  // spine_1 stands at a third of the chain (see stick_figure.h); ten bones of `even` have joints at
  // 0.3 and 0.4, so it is a third of the way from the one to the other.
  const Driven rig("even");
  SpinePose pose;
  const auto world = rig.pose({.extension = 1.2}, &pose);
  const glm::dvec3 expected = glm::mix(pose.position[3], pose.position[4], 1.0 / 3.0);
  EXPECT_LT(glm::distance(origin(rig.of(world, "spine_1")), expected), 1e-9);
  const glm::dquat turn = glm::slerp(pose.turn[3], pose.turn[4], 1.0 / 3.0);
  EXPECT_LT(apart(glm::dmat4(glm::dmat3(rig.of(world, "spine_1"))),
                  glm::dmat4(glm::mat3_cast(turn) * glm::dmat3(rest_of(rig.character, "spine_1")))),
            1e-9);
}

TEST(SpineDriver, EndsWithTheChainsLastJoint) {
  const Driven rig("even");
  SpinePose pose;
  const auto world = rig.pose({.extension = 2.0, .twist = 1.0}, &pose);
  EXPECT_LT(glm::distance(origin(rig.of(world, "neck")), pose.position.back()), 1e-9);
}

TEST(SpineDriver, IsTheSameFigureInAnotherWorld) {
  // Turn, move and scale the character: the posed one turns, moves and scales with it.
  const Driven rig("even");
  const auto world = rig.pose({.extension = 1.0, .side = 0.4});
  glm::dmat4 other = glm::translate(glm::dmat4(1.0), glm::dvec3(3.0, -2.0, 5.0));
  other = glm::rotate(other, 1.5707963267948966, glm::dvec3(0.0, 1.0, 0.0));
  other = glm::scale(other, glm::dvec3(100.0));
  Character moved = stick_figure();
  for (Node& node : moved.nodes) node.world_from_node = other * node.world_from_node;
  const Anatomy anatomy = find_anatomy(moved);
  EXPECT_NEAR(anatomy.forward.x, 1.0, 1e-12);  // +Z turned a quarter about Y
  const SpineDriver driver(moved, anatomy);
  const auto system = build_system({"even", {}}, driver.rest_chain());
  const auto there = driver.drive(
      *system,
      system->solve(system->controls_for({.extension = 1.0, .side = 0.4}, solver::Mapping::chest)));
  for (std::size_t n = 0; n < world.size(); ++n)
    EXPECT_LT(apart(there[n], other * world[n]), 1e-9 * 100.0) << moved.nodes[n].name;
}

class WithSpineJoints : public ::testing::TestWithParam<int> {};

TEST_P(WithSpineJoints, ASkeletonIsDrivenWhateverTheCount) {
  const Character character = stick_figure(GetParam());
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_EQ(anatomy.chest_index, static_cast<std::size_t>(GetParam()) + 1);
  const SpineDriver driver(character, anatomy);
  const auto system = build_system({"even", {}}, driver.rest_chain());
  const SpinePose pose =
      system->solve(system->controls_for({.extension = 1.0}, solver::Mapping::chest));
  const auto world = driver.drive(*system, pose);
  // Every spine joint lies on the posed chain: a sequence of ever higher arc along it.
  double last = -1.0;
  for (std::size_t k = 0; k <= anatomy.chest_index; ++k) {
    const glm::dvec3 p = origin(world[static_cast<std::size_t>(anatomy.spine[k])]);
    double nearest = 1e9, at = 0.0;
    for (std::size_t i = 0; i + 1 < pose.joint_count(); ++i)
      for (double t = 0.0; t <= 1.0; t += 0.001) {
        const double d = glm::distance(p, glm::mix(pose.position[i], pose.position[i + 1], t));
        if (d < nearest) {
          nearest = d;
          at = static_cast<double>(i) + t;
        }
      }
    EXPECT_LT(nearest, 1e-3);
    EXPECT_GT(at, last);
    last = at;
  }
}

INSTANTIATE_TEST_SUITE_P(Driver, WithSpineJoints, ::testing::Values(0, 1, 2, 5, 12, 20));

TEST(SpineDriver, CarriesALooseJointWithWhatItTouches) {
  Character character = stick_figure();
  // A jaw on the scene's root, at the head: no bone carries it.
  const glm::dmat4 at_head = rest_of(character, "head");
  character.nodes.push_back({.name = "jaw",
                             .parent = 0,
                             .file_node = 99,
                             .parent_from_node = at_head,
                             .world_from_node = at_head});
  const auto jaw = static_cast<int>(character.nodes.size()) - 1;
  stick_vertex(character, jaw);
  const Anatomy anatomy = find_anatomy(character);
  ASSERT_EQ(anatomy.followers.size(), 1u);
  EXPECT_EQ(anatomy.followers[0].node, jaw);
  const SpineDriver driver(character, anatomy);
  const auto system = build_system({"even", {}}, driver.rest_chain());
  const auto world = driver.drive(
      *system, system->solve(system->controls_for({.extension = 1.0}, solver::Mapping::chest)));
  EXPECT_LT(apart(world[static_cast<std::size_t>(jaw)],
                  world[static_cast<std::size_t>(stick_node(character, "head"))]),
            1e-12);
}

TEST(SpineDriver, LeavesWhatNothingCarriesAndSaysSo) {
  Character character = stick_figure();
  const glm::dmat4 far = glm::translate(glm::dmat4(1.0), glm::dvec3(0.9, 1.0, 0.9));
  character.nodes.push_back({.name = "lamp",
                             .parent = 0,
                             .file_node = 99,
                             .parent_from_node = far,
                             .world_from_node = far});
  const auto lamp = static_cast<int>(character.nodes.size()) - 1;
  stick_vertex(character, lamp);
  const Anatomy anatomy = find_anatomy(character);
  const SpineDriver driver(character, anatomy);
  EXPECT_TRUE(driver.static_nodes()[static_cast<std::size_t>(lamp)]);
  EXPECT_FALSE(driver.static_nodes()[static_cast<std::size_t>(stick_node(character, "head"))]);
}

}  // namespace
}  // namespace backbend::skin
