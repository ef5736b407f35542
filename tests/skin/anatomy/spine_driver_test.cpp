// How a solved spine moves a skeleton: a stick figure whose answers can be worked out by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <random>

#include "skin/anatomy/anatomy.h"
#include "skin/character/matrix_facts.h"
#include "skin/deform/skinning.h"
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
  Character character;
  Anatomy anatomy = find_anatomy(character);
  SpineDriver driver{character, anatomy};
  std::unique_ptr<SpineSystem> system;

  explicit Driven(const std::string& name, int spine_joints = 2)
      : character(stick_figure(spine_joints)),
        system(build_system({name, {}}, driver.rest_chain())) {}

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
  EXPECT_LT(moved(pose.hip, "hips"), 1e-12);
  EXPECT_LT(moved(pose.hip, "foot.L"), 1e-12);
  // What hangs above goes rigidly with the chain's last joint, as the chest does.
  const solver::RigidMotion end{pose.turn.back(), rig.system->rest().position.back(),
                                pose.position.back()};
  for (const char* name : {"spine_2", "neck", "head", "clavicle.L", "hand.R"})
    EXPECT_LT(moved(end, name), 1e-12) << name;
  EXPECT_EQ(rig.of(world, "scene"), rest_of(rig.character, "scene"));
}

INSTANTIATE_TEST_SUITE_P(Driver, EverySystem,
                         ::testing::Values("three_bone", "curve", "isner", "stretchy", "even",
                                           "spline_ik", "matrix_blend"));

TEST(SpineDriver, HandsTheChainFromTheHipsToWhereTheArmsHang) {
  const Driven rig("even");
  const solver::RestChain& chain = rig.driver.rest_chain();
  ASSERT_EQ(chain.joint.size(), 3u);  // hips, spine_1, spine_2
  EXPECT_EQ(chain.joint.front(), origin(rest_of(rig.character, "hips")));
  EXPECT_EQ(chain.joint.back(), origin(rest_of(rig.character, "spine_2")));
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
          glm::dvec4(0, found.spine_length * step, 0, 0);
      for (Node& node : character.nodes)
        node.world_from_node[3] *= glm::dvec4(unit, unit, unit, 1.0);
      Anatomy anatomy = found;
      anatomy.spine_length *= unit;
      const SpineDriver driver(character, anatomy);
      EXPECT_EQ(driver.rest_chain().joint.size(), step == 1e-5 ? 3u : 2u) << unit << " " << step;
    }
  }
}

TEST(SpineDriver, SetsAJointBetweenTwoOfTheSystemsByArcFraction) {
  // Of three, spine_1 stands at a third of the chain to spine_3 (see stick_figure.h); ten bones of
  // `even` have joints at 0.3 and 0.4, so it is a third of the way from the one to the other.
  const Driven rig("even", 3);
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
  EXPECT_LT(glm::distance(origin(rig.of(world, "spine_2")), pose.position.back()), 1e-9);
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
  // The arms hang from the last spine joint. Without any they hang from the hips, far below where
  // they start: the neck is the nearest joint there.
  EXPECT_EQ(anatomy.chest_index, static_cast<std::size_t>(std::max(GetParam(), 1)));
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
        if (driven[n] || parent < 0) continue;  // the clavicles are among the others
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

// Whatever a rig would move arms with, on the mesh they ride on the joint that they hang from: the
// shoulder blades stay on the ribs. What the rig's own way amounts to is the metrics' to say.
TEST(SpineDriver, ArmsStayOnTheRibsWhateverTheRigMovesThemWith) {
  const Character character = stick_figure(4);
  const Anatomy anatomy = find_anatomy(character);
  const SpineDriver driver(character, anatomy);
  std::vector<glm::dmat4> by[2];
  SpinePose pose[2];
  for (const int top : {0, 1}) {
    const auto system = build_system({"curve", {{"arms", std::string(top ? "top" : "effector")}}},
                                     driver.rest_chain());
    pose[top] = system->solve(
        system->controls_for({.extension = 1.2, .twist = 0.4}, solver::Mapping::chest));
    by[top] = driver.drive(*system, pose[top]);
  }
  // The two rigs part ways: the thesis's leaves its last bone behind the Top control.
  EXPECT_GT(glm::distance(pose[0].arms.apply({0.7, 1.35, 0}), pose[1].arms.apply({0.7, 1.35, 0})),
            0.002);
  EXPECT_EQ(by[0], by[1]);
  for (const char* arm : {"clavicle.L", "clavicle.R"}) {
    const auto node = static_cast<std::size_t>(stick_node(character, arm));
    const auto ribs = static_cast<std::size_t>(stick_node(character, "spine_4"));
    EXPECT_LT(apart(glm::inverse(by[0][ribs]) * by[0][node],
                    glm::inverse(rest_of(character, "spine_4")) * rest_of(character, arm)),
              1e-12);
  }
}

/// Clavicles on two joints, on helpers, on the neck: each keeps its place on what it hangs from.
TEST(SpineDriver, ArmsThatHangFromSeveralJointsAreNotTornOff) {
  const struct {
    const char *left, *right, *chest;
  } cases[] = {{"spine_2", "spine_4", "spine_2"},
               {"spine_4", "spine_3", "spine_3"},
               {"neck", "neck", "neck"},
               {"spine_1", "spine_1", "spine_1"},
               {"spine_4", "neck", "spine_4"}};
  for (const auto& each : cases)
    for (const bool helper : {false, true}) {
      SCOPED_TRACE(std::string(each.left) + " " + each.right + (helper ? " by a helper" : ""));
      Character character = stick_figure(4);
      for (const bool left : {true, false}) {
        const int parent = stick_node(character, left ? each.left : each.right);
        const int clavicle = stick_node(character, left ? "clavicle.L" : "clavicle.R");
        if (helper) {
          const glm::dmat4 at = character.nodes[static_cast<std::size_t>(parent)].world_from_node;
          Node between = character.nodes[static_cast<std::size_t>(parent)];
          between.name = left ? "girdle_a" : "girdle_b";
          between.parent = parent;
          between.world_from_node = glm::translate(at, glm::dvec3(0, 0.01, -0.05));
          character.nodes.insert(character.nodes.begin() + clavicle, between);
          for (std::size_t n = 0; n < character.nodes.size(); ++n)
            if (n != static_cast<std::size_t>(clavicle) && character.nodes[n].parent >= clavicle)
              ++character.nodes[n].parent;
          for (SkinJoint& joint : character.joints) joint.node += joint.node >= clavicle ? 1 : 0;
          character.nodes[static_cast<std::size_t>(clavicle) + 1].parent = clavicle;
        } else {
          character.nodes[static_cast<std::size_t>(clavicle)].parent = parent;
        }
      }
      const Anatomy anatomy = find_anatomy(character);
      EXPECT_EQ(anatomy.chest, stick_node(character, each.chest));
      EXPECT_EQ(anatomy.spine[anatomy.chest_index], anatomy.chest);
      const SpineDriver driver(character, anatomy);
      EXPECT_TRUE(driver.arms_follow_chest());
      const auto system = build_system({"even", {}}, driver.rest_chain());
      const auto world =
          driver.drive(*system, system->solve(system->controls_for({.extension = 1.0, .side = 0.3},
                                                                   solver::Mapping::chest)));
      for (const int root : {anatomy.left_arm[0], anatomy.right_arm[0]}) {
        const auto n = static_cast<std::size_t>(root);
        const auto p = static_cast<std::size_t>(character.nodes[n].parent);
        EXPECT_LT(apart(glm::inverse(world[p]) * world[n],
                        glm::inverse(character.nodes[p].world_from_node) *
                            character.nodes[n].world_from_node),
                  1e-12);
      }
    }
}

/// Forelegs on a mechanism joint beside the spine, as planted feet have them.
TEST(SpineDriver, ArmsThatHangBesideTheSpineRideOnTheNearestJoint) {
  Character character = stick_figure(4);
  for (const char* arm : {"clavicle.L", "clavicle.R"})
    character.nodes[static_cast<std::size_t>(stick_node(character, arm))].parent =
        stick_node(character, "scene");
  // spine_4 stands at 1.3, the neck at 1.4, the clavicles at 1.35 less a thousandth.
  for (const char* arm : {"clavicle.L", "clavicle.R"})
    character.nodes[static_cast<std::size_t>(stick_node(character, arm))].world_from_node[3].y =
        1.349;
  const Anatomy lower = find_anatomy(character);
  EXPECT_EQ(lower.chest, stick_node(character, "spine_4"));
  const SpineDriver driver(character, lower);
  EXPECT_TRUE(driver.arms_follow_chest());
  const auto system = build_system({"even", {}}, driver.rest_chain());
  const auto world = driver.drive(
      *system, system->solve(system->controls_for({.extension = 1.0}, solver::Mapping::chest)));
  const auto at = [&](const char* name) {
    return world[static_cast<std::size_t>(stick_node(character, name))];
  };
  EXPECT_LT(apart(glm::inverse(at("spine_4")) * at("clavicle.L"),
                  glm::inverse(rest_of(character, "spine_4")) * rest_of(character, "clavicle.L")),
            1e-12);
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
