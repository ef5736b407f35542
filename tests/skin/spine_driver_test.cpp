// How a solved spine moves a skeleton: a stick figure whose answers can be worked out by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <random>

#include "skin/anatomy.h"
#include "skin/matrix_facts.h"
#include "skin/skinning.h"
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

TEST(SpineDriver, TakesJointsInOnePlaceForOneWhateverTheUnit) {
  for (const double unit : {1.0, 1e-5, 1e5}) {
    for (const double step : {0.0, 1e-7, 1e-5}) {  // of the chain's length, between two joints
      Character character = stick_figure();
      const Anatomy found = find_anatomy(character);
      Node& second = character.nodes[static_cast<std::size_t>(found.spine[2])];
      second.world_from_node[3] =
          character.nodes[static_cast<std::size_t>(found.spine[1])].world_from_node[3] +
          glm::dvec4(0, 0.5 * step, 0, 0);
      for (Node& node : character.nodes)
        node.world_from_node[3] *= glm::dvec4(unit, unit, unit, 1.0);
      Anatomy anatomy = found;
      anatomy.spine_length *= unit;
      const SpineDriver driver(character, anatomy);
      EXPECT_EQ(driver.rest_chain().joint.size(), step == 1e-5 ? 4u : 3u) << unit << " " << step;
    }
  }
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

/// A spine of 1 to 20 joints under every system whose bones can be counted.
class WithAnyCounts : public ::testing::TestWithParam<int> {};

TEST_P(WithAnyCounts, TheRestIsExactAndEveryOtherBoneKeepsItsPlace) {
  const Character character = stick_figure(GetParam());
  const Anatomy anatomy = find_anatomy(character);
  const SpineDriver driver(character, anatomy);
  const PosedMesh rest = rest_mesh(character);
  std::vector<bool> driven(character.nodes.size(), false);
  for (std::size_t k = 0; k <= anatomy.chest_index; ++k)
    driven[static_cast<std::size_t>(anatomy.spine[k])] = true;
  const std::pair<const char*, const char*> counted[] = {
      {"even", "bones"},      {"curve", "bones"},        {"stretchy", "bones"},
      {"spline_ik", "bones"}, {"matrix_blend", "bones"}, {"isner", "vertebrae"}};
  for (const auto& [name, option] : counted)
    for (const double bones : {1.0, 2.0, 3.0, 7.0, 10.0, 19.0, 20.0, 40.0}) {
      SCOPED_TRACE(std::string(name) + " of " + std::to_string(bones));
      const auto system = build_system({name, {{option, bones}}}, driver.rest_chain());
      const auto still = driver.drive(*system, system->rest());
      const PosedMesh at_rest = skin(character, still);
      ASSERT_EQ(at_rest.position, rest.position);  // bit for bit: nothing is displaced
      ASSERT_EQ(at_rest.normal, rest.normal);
      // Solved with every control at rest: the same.
      const auto solved =
          driver.drive(*system, system->solve(system->controls_for({}, solver::Mapping::chest)));
      ASSERT_EQ(skin(character, solved).position, rest.position);
      const auto world = driver.drive(
          *system, system->solve(system->controls_for({.extension = 0.9, .side = 0.2, .twist = 0.3},
                                                      solver::Mapping::chest)));
      for (std::size_t n = 0; n < world.size(); ++n) {
        const int parent = character.nodes[n].parent;
        // The clavicles go with the chest control, not with the joint that they hang from.
        if (driven[n] || parent < 0 || static_cast<int>(n) == anatomy.left_arm[0] ||
            static_cast<int>(n) == anatomy.right_arm[0])
          continue;
        const auto p = static_cast<std::size_t>(parent);
        ASSERT_LT(apart(glm::inverse(world[p]) * world[n],
                        glm::inverse(character.nodes[p].world_from_node) *
                            character.nodes[n].world_from_node),
                  1e-12)
            << character.nodes[n].name;
      }
    }
}

INSTANTIATE_TEST_SUITE_P(Driver, WithAnyCounts, ::testing::Range(1, 21));

// The thesis's rig leaves its last bone behind the Top control: arms that hang from the one stand
// elsewhere than arms that hang from the other, on the mesh as on the chain.
TEST(SpineDriver, ArmsHangOnTheMeshFromWhatTheOptionSays) {
  const Character character = stick_figure(4);
  const Anatomy anatomy = find_anatomy(character);
  const SpineDriver driver(character, anatomy);
  const PosedMesh rest = rest_mesh(character);
  const auto in_arms = [&](std::size_t v) {
    const std::string& name = character
                                  .nodes[static_cast<std::size_t>(
                                      character.joints[character.influences[v].joint[0]].node)]
                                  .name;
    return name.starts_with("clavicle") || name.starts_with("arm") || name.starts_with("hand");
  };
  PosedMesh by[2];
  SpinePose pose[2];
  for (const int top : {0, 1}) {
    const auto system = build_system({"curve", {{"arms", std::string(top ? "top" : "effector")}}},
                                     driver.rest_chain());
    pose[top] = system->solve(
        system->controls_for({.extension = 1.2, .twist = 0.4}, solver::Mapping::chest));
    by[top] = skin(character, driver.drive(*system, pose[top]));
  }
  // What the arms hang from is a rigid motion; with `top` it is the chest control's.
  EXPECT_LT(
      apart(
          rigid_matrix(pose[1].arms.turn, pose[1].arms.rest_origin, pose[1].arms.posed_origin),
          rigid_matrix(pose[1].chest.turn, pose[1].chest.rest_origin, pose[1].chest.posed_origin)),
      1e-12);
  std::size_t arms = 0;
  for (std::size_t v = 0; v < character.vertex_count(); ++v) {
    if (!in_arms(v)) {
      EXPECT_EQ(by[0].position[v], by[1].position[v]) << v;
      continue;
    }
    ++arms;
    for (const int top : {0, 1}) {
      const auto& motion = pose[top].arms;
      const glm::dmat4 moved = rigid_matrix(motion.turn, motion.rest_origin, motion.posed_origin);
      const glm::dvec3 expected(moved * glm::dvec4(glm::dvec3(rest.position[v]), 1.0));
      EXPECT_LT(glm::distance(glm::dvec3(by[top].position[v]), expected), 1e-6);
    }
    // The drift: 6.2 degrees of turn are a tenth of the distance, centimetres at the hand.
    EXPECT_GT(glm::distance(by[0].position[v], by[1].position[v]), 0.002f) << v;
  }
  EXPECT_GE(arms, 6u);
}

/// A spine of two joints: arms that hang from the lower go with the upper where they are nearer it.
TEST(SpineDriver, ArmsThatHangFromTheHipsGoWithTheChestFromAboveTheMiddle) {
  for (const double height : {1.25, 1.5, 1.75}) {
    Character character;
    const int hips = add_node(character, "hips", -1, {0, 1, 0});
    Anatomy anatomy;
    anatomy.spine = {hips, add_node(character, "chest", hips, {0, 2, 0})};
    anatomy.chest_index = 1;
    anatomy.left_arm = {add_node(character, "arm.L", hips, {0.25, height, 0})};
    anatomy.right_arm = {add_node(character, "arm.R", hips, {-0.25, height, 0})};
    EXPECT_EQ(SpineDriver(character, anatomy).arms_follow_chest(), height > 1.5) << height;
  }
}

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
