#include "skin/deform/skinning.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <algorithm>

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_inverse.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "skin/character/matrix_facts.h"
#include "skin/deform/dual_quaternions.h"
#include "skin/deform/skinning_plan.h"

namespace backbend::skin {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// `joints` nodes on one root, all at the origin, and vertices with `influences` random joints
/// each.
Character random_character(std::size_t vertices, int joints, int influences, unsigned seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f), positive(0.05f, 1.0f);
  Character character;
  for (int j = 0; j < joints; ++j) {
    character.nodes.push_back({.name = "joint", .parent = j == 0 ? -1 : 0, .file_node = j});
    character.joints.push_back({.node = j});
  }
  for (std::size_t v = 0; v < vertices; ++v) {
    character.bind_position.emplace_back(unit(rng), 2.0f * unit(rng), unit(rng));
    character.bind_normal.push_back(
        glm::normalize(glm::vec3(unit(rng), unit(rng), unit(rng) + 2.0f)));
    Influences set;
    float sum = 0.0f;
    const auto first = static_cast<unsigned>(rng() % static_cast<unsigned>(joints));
    for (int k = 0; k < influences; ++k) {
      const auto slot = static_cast<std::size_t>(k);
      set.joint[slot] = static_cast<std::uint16_t>((first + static_cast<unsigned>(k)) %
                                                   static_cast<unsigned>(joints));
      set.weight[slot] = positive(rng);
      sum += set.weight[slot];
    }
    for (float& weight : set.weight) weight /= sum;
    std::sort(set.weight.begin(), set.weight.end(), std::greater<>());
    character.influences.push_back(set);
  }
  return character;
}

glm::dmat4 random_motion(std::mt19937& rng) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const glm::dquat turn =
      glm::normalize(glm::dquat(unit(rng), unit(rng), unit(rng), unit(rng) + 1e-3));
  return rigid_matrix(turn, {unit(rng), unit(rng), unit(rng)}, {unit(rng), unit(rng), unit(rng)});
}

std::vector<glm::dmat4> random_motions(std::size_t count, unsigned seed) {
  std::mt19937 rng(seed);
  std::vector<glm::dmat4> out;
  for (std::size_t k = 0; k < count; ++k) out.push_back(random_motion(rng));
  return out;
}

/// The definition, in double precision.
glm::dvec3 reference(const Character& character, const std::vector<glm::dmat4>& world,
                     std::size_t v) {
  glm::dvec3 out(0.0);
  for (std::size_t k = 0; k < kMaxInfluences; ++k) {
    const auto& joint = character.joints[character.influences[v].joint[k]];
    out += static_cast<double>(character.influences[v].weight[k]) *
           glm::dvec3(world[static_cast<std::size_t>(joint.node)] * joint.joint_from_mesh *
                      glm::dvec4(glm::dvec3(character.bind_position[v]), 1.0));
  }
  return out;
}

class WithInfluences : public ::testing::TestWithParam<int> {};

TEST_P(WithInfluences, SkinningIsTheWeightedSumOfTheJointsMotions) {
  const Character character = random_character(3001, 9, GetParam(), 1);
  const auto world = random_motions(character.nodes.size(), 2);
  const PosedMesh posed = skin(character, world);
  for (std::size_t v = 0; v < character.vertex_count(); ++v) {
    // Coordinates up to 4: a dozen float operations, each off by at most 2^-24 of that.
    ASSERT_NEAR(glm::distance(glm::dvec3(posed.position[v]), reference(character, world, v)), 0.0,
                2e-6)
        << v;
    ASSERT_NEAR(glm::length(posed.normal[v]), 1.0f, 1e-6f) << v;
  }
}

INSTANTIATE_TEST_SUITE_P(Each, WithInfluences, ::testing::Values(1, 2, 3, 4, 5, 8));

TEST_P(WithInfluences, APlanGivesTheSameBits) {
  for (const std::size_t vertices : {1u, 7u, 8u, 100u, 5003u}) {
    const Character character = random_character(vertices, 9, GetParam(), 21);
    const SkinningPlan plan(character);
    PosedMesh posed;
    for (const bool uneven : {false, true}) {
      auto world = random_motions(character.nodes.size(), 22);
      if (uneven) world[1] = glm::scale(world[1], glm::dvec3(1.0, 2.0, 0.5));
      plan.skin(world, posed);
      const PosedMesh plain = skin(character, world);
      EXPECT_EQ(posed.position, plain.position);
      EXPECT_EQ(posed.normal, plain.normal);
    }
  }
}

// As many joints as influences: every vertex has the same set, so the blocks stand in rows, in one
// run a tile; 40 011 vertices make tiles of more than the least size, the last one and its last
// block partly filled.
TEST_P(WithInfluences, APlanGivesTheSameBitsWhereNeighboursShareTheirJoints) {
  for (const std::size_t vertices : {8u, 16u, 24u, 33u, 1024u, 40011u}) {
    Character character = random_character(vertices, GetParam(), GetParam(), 26);
    for (std::size_t v = 0; v < vertices; v += 5) character.bind_normal[v] = glm::vec3(0.0f);
    const SkinningPlan plan(character);
    PosedMesh posed;
    for (const bool uneven : {false, true}) {
      auto world = random_motions(character.nodes.size(), 27);
      if (uneven) world[0] = glm::scale(world[0], glm::dvec3(1.0, 2.0, 0.5));
      plan.skin(world, posed);
      const PosedMesh plain = skin(character, world);
      EXPECT_EQ(posed.position, plain.position) << vertices;
      EXPECT_EQ(posed.normal, plain.normal) << vertices;
      EXPECT_EQ(posed.normal[0], glm::vec3(0.0f, 1.0f, 0.0f));
    }
  }
}

// Vertices of one to all influences, one of none, and neighbours that share all of their joints.
TEST_P(WithInfluences, ADualQuaternionPlanGivesTheSameBits) {
  for (const std::size_t vertices : {1u, 7u, 8u, 100u, 5003u}) {
    for (const std::size_t joints : {9u, static_cast<unsigned>(GetParam())}) {
      Character character = random_character(vertices, joints, GetParam(), 31);
      for (std::size_t v = 0; v < vertices; v += 3)
        character.influences[v].weight[v % static_cast<std::size_t>(GetParam())] = 0.0f;
      for (std::size_t v = 4; v < vertices; v += 11) character.influences[v].weight.fill(0.0f);
      const DualQuaternionPlan plan(character);
      PosedMesh posed;
      for (const bool stretched : {false, true}) {
        auto world = random_motions(character.nodes.size(), 32);
        if (stretched) world[0] = glm::scale(world[0], glm::dvec3(1.0, 2.0, 0.5));
        plan.skin(world, posed);
        const PosedMesh plain = skin(character, world, SkinningMethod::dual_quaternion);
        EXPECT_EQ(posed.position, plain.position) << vertices << " " << joints;
        EXPECT_EQ(posed.normal, plain.normal) << vertices << " " << joints;
      }
    }
  }
}

/// A plan's result on one thread and on as many as there are.
template <class Plan>
void expect_same_for_any_threads() {
  const Character character = random_character(20011, 40, 4, 24);
  const auto world = random_motions(character.nodes.size(), 25);
  const Plan plan(character);
  PosedMesh one, many;
  {
    const tbb::global_control single(tbb::global_control::max_allowed_parallelism, 1);
    plan.skin(world, one);
  }
  plan.skin(world, many);
  EXPECT_EQ(one.position, many.position);
  EXPECT_EQ(one.normal, many.normal);
}

TEST(DualQuaternionPlan, IsTheSameOnOneThreadAndOnMany) {
  expect_same_for_any_threads<DualQuaternionPlan>();
}

TEST(SkinningPlan, WastesLittleWhereManyVerticesShareTheirJoints) {
  const Character character = random_character(8000, 10, 4, 23);
  const SkinningPlan plan(character);
  // Ten sets of joints in each of eight tiles: each wastes at most three lanes or leaves four
  // vertices over.
  EXPECT_LE(plan.padded_share(), 240.0 / 8000.0);
  EXPECT_LE(plan.single_share(), 320.0 / 8000.0);
}

TEST(SkinningPlan, IsTheSameOnOneThreadAndOnMany) { expect_same_for_any_threads<SkinningPlan>(); }

TEST(Skinning, GivesTheMeshBackBitForBitUnderIdentities) {
  const Character character = random_character(500, 3, 1, 3);
  EXPECT_EQ(rest_mesh(character).position, character.bind_position);
}

TEST(Skinning, KeepsEveryLengthWhenAllJointsMoveAsOne) {
  const Character character = random_character(400, 5, 4, 4);
  std::mt19937 rng(5);
  const glm::dmat4 motion = random_motion(rng);
  for (const auto method : {SkinningMethod::linear, SkinningMethod::dual_quaternion}) {
    const PosedMesh posed = skin(character, std::vector<glm::dmat4>(5, motion), method);
    for (std::size_t v = 1; v < character.vertex_count(); ++v) {
      EXPECT_NEAR(glm::distance(posed.position[v], posed.position[v - 1]),
                  glm::distance(character.bind_position[v], character.bind_position[v - 1]), 4e-6f);
      const glm::vec3 turned = glm::mat3(motion) * character.bind_normal[v];
      EXPECT_NEAR(glm::distance(posed.normal[v], turned), 0.0f, 2e-6f);
    }
  }
}

TEST(Skinning, IsTheSameOnOneThreadAndOnMany) {
  const Character character = random_character(20011, 40, 4, 6);
  const auto world = random_motions(character.nodes.size(), 7);
  for (const auto method : {SkinningMethod::linear, SkinningMethod::dual_quaternion}) {
    PosedMesh one;
    {
      const tbb::global_control single(tbb::global_control::max_allowed_parallelism, 1);
      one = skin(character, world, method);
    }
    const tbb::global_control many(tbb::global_control::max_allowed_parallelism, 8);
    const PosedMesh other = skin(character, world, method);
    EXPECT_EQ(one.position, other.position);
    EXPECT_EQ(one.normal, other.normal);
  }
}

TEST(Skinning, IsTheSameForReorderedVertices) {
  const Character character = random_character(777, 12, 4, 8);
  Character reversed = character;
  std::reverse(reversed.bind_position.begin(), reversed.bind_position.end());
  std::reverse(reversed.bind_normal.begin(), reversed.bind_normal.end());
  std::reverse(reversed.influences.begin(), reversed.influences.end());
  const auto world = random_motions(character.nodes.size(), 9);
  PosedMesh a = skin(character, world);
  const PosedMesh b = skin(reversed, world);
  std::reverse(a.position.begin(), a.position.end());
  std::reverse(a.normal.begin(), a.normal.end());
  EXPECT_EQ(a.position, b.position);
  EXPECT_EQ(a.normal, b.normal);
}

TEST(Skinning, TurnsNormalsByTheInverseTransposeUnderUnevenScale) {
  Character character = random_character(1, 1, 1, 10);
  character.bind_normal[0] = glm::normalize(glm::vec3(1.0f, 1.0f, 0.0f));
  const auto world = std::vector{glm::scale(glm::dmat4(1.0), glm::dvec3(2.0, 1.0, 1.0))};
  // A plane x + y = c becomes x/2 + y = c.
  const glm::vec3 expected = glm::normalize(glm::vec3(0.5f, 1.0f, 0.0f));
  EXPECT_NEAR(glm::distance(skin(character, world).normal[0], expected), 0.0f, 1e-6f);
}

TEST(Skinning, KeepsNormalsOutwardUnderAMirror) {
  Character character = random_character(1, 1, 1, 11);
  character.bind_normal[0] = {1.0f, 0.0f, 0.0f};
  const auto world = std::vector{glm::scale(glm::dmat4(1.0), glm::dvec3(-1.0, 1.0, 1.0))};
  EXPECT_EQ(skin(character, world).normal[0], glm::vec3(-1.0f, 0.0f, 0.0f));
}

/// A vertex at radius 1 about Y, half on each of two joints, the second twisted by `angle`.
float twisted_radius(double angle, SkinningMethod method) {
  Character character = random_character(1, 2, 2, 12);
  character.bind_position[0] = {1.0f, 0.0f, 0.0f};
  character.influences[0].joint = {0, 1};
  character.influences[0].weight = {0.5f, 0.5f};
  const std::vector world = {glm::dmat4(1.0),
                             glm::rotate(glm::dmat4(1.0), angle, glm::dvec3(0.0, 1.0, 0.0))};
  return glm::length(skin(character, world, method).position[0]);
}

TEST(Skinning, CollapsesUnderTwistAsTheTheoryOfLinearBlendingSays) {
  // Two unit vectors `angle` apart have a mean of length cos(angle / 2): Kavan 2014, part I.
  for (int degrees = 0; degrees <= 170; degrees += 10) {
    const double angle = degrees * kPi / 180.0;
    EXPECT_NEAR(twisted_radius(angle, SkinningMethod::linear), std::cos(angle / 2.0), 1e-6);
    EXPECT_NEAR(twisted_radius(angle, SkinningMethod::dual_quaternion), 1.0, 1e-6);
  }
}

TEST(DualQuaternionSkinning, DoesNotCareForTheSignOfAQuaternion) {
  // Rotations near a full turn have quaternions near -1; blended with +1 they would cancel.
  const double angle = 358.0 * kPi / 180.0;
  EXPECT_NEAR(twisted_radius(angle, SkinningMethod::dual_quaternion), 1.0, 1e-6);
}

TEST(DualQuaternionSkinning, IsTheRestMeshAtRest) {
  Character character = random_character(300, 6, 4, 13);
  std::mt19937 rng(14);
  for (Node& node : character.nodes) node.world_from_node = random_motion(rng);
  for (std::size_t j = 0; j < character.joints.size(); ++j)
    character.joints[j].joint_from_mesh = glm::affineInverse(character.nodes[j].world_from_node);
  std::vector<glm::dmat4> rest;
  for (const Node& node : character.nodes) rest.push_back(node.world_from_node);
  EXPECT_EQ(skin(character, rest, SkinningMethod::dual_quaternion).position,
            rest_mesh(character).position);
}

/// One vertex at rest at `at`, on joints whose rests are anywhere.
Character resting(const glm::dvec3& at, int joints) {
  Character character = random_character(1, joints, joints, 31);
  std::mt19937 rng(32);
  for (std::size_t j = 0; j < character.joints.size(); ++j) {
    character.nodes[j].world_from_node = random_motion(rng);
    character.joints[j].joint_from_mesh = glm::affineInverse(character.nodes[j].world_from_node);
  }
  character.bind_position[0] = glm::vec3(at);
  return character;
}

TEST(DualQuaternionSkinning, OfOneJointIsItsMotionWhateverThatIs) {
  const glm::dvec3 at(0.4, -0.7, 1.1);
  std::mt19937 rng(33);
  for (const glm::dvec3& scale : {glm::dvec3(1, 1, 1), glm::dvec3(2, 1, 0.5), glm::dvec3(0.7, 3, 1),
                                  glm::dvec3(1, 1, -1), glm::dvec3(1.00001, 1, 1)})
    for (int i = 0; i < 20; ++i) {
      const Character character = resting(at, 1);
      const glm::dmat4 motion = glm::scale(random_motion(rng), scale);
      const PosedMesh posed = skin(character, {motion * character.nodes[0].world_from_node},
                                   SkinningMethod::dual_quaternion);
      const glm::dvec3 expected(motion * glm::dvec4(at, 1.0));
      EXPECT_LT(glm::distance(glm::dvec3(posed.position[0]), expected), 5e-6) << scale.x;
      const glm::dvec3 rest(rest_mesh(character).normal[0]);
      const glm::dvec3 normal = glm::normalize(glm::inverseTranspose(glm::dmat3(motion)) * rest) *
                                (glm::determinant(glm::dmat3(motion)) < 0.0 ? -1.0 : 1.0);
      EXPECT_GT(std::abs(glm::dot(glm::dvec3(posed.normal[0]), normal)), 1.0 - 1e-5) << scale.x;
    }
}

TEST(DualQuaternionSkinning, HalfWayBetweenTwoScrewsIsTheScrewBetweenThem) {
  // About one axis through one point, and along it: the mean of two such motions is the motion by
  // the mean angle and shift. Kavan 2008, section 4: linear blending of two keeps to the screw.
  std::mt19937 rng(34);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int i = 0; i < 30; ++i) {
    const glm::dvec3 axis = glm::normalize(glm::dvec3(unit(rng), unit(rng), unit(rng))),
                     pivot(unit(rng), unit(rng), unit(rng)), at(unit(rng), unit(rng), unit(rng));
    const auto screw = [&](double angle, double shift) {
      return glm::translate(glm::dmat4(1.0), pivot + shift * axis) *
             glm::rotate(glm::dmat4(1.0), angle, axis) * glm::translate(glm::dmat4(1.0), -pivot);
    };
    const double a = 1.5 * unit(rng), b = a + 2.8 * unit(rng), s = unit(rng), t = unit(rng);
    Character character = resting(at, 2);
    character.influences[0].weight = {0.5f, 0.5f};
    const PosedMesh posed = skin(character,
                                 {screw(a, s) * character.nodes[0].world_from_node,
                                  screw(b, t) * character.nodes[1].world_from_node},
                                 SkinningMethod::dual_quaternion);
    const glm::dmat4 half = screw(0.5 * (a + b), 0.5 * (s + t));
    EXPECT_LT(glm::distance(glm::dvec3(posed.position[0]), glm::dvec3(half * glm::dvec4(at, 1.0))),
              5e-6);
    EXPECT_LT(glm::distance(glm::dvec3(posed.normal[0]),
                            glm::dmat3(half) * glm::dvec3(rest_mesh(character).normal[0])),
              5e-6);
    // A stretch is blended before: half of what each adds.
    const glm::dmat4 long_one = glm::scale(glm::dmat4(1.0), glm::dvec3(3.0, 1.0, 1.0));
    const PosedMesh stretched = skin(character,
                                     {screw(a, s) * character.nodes[0].world_from_node,
                                      screw(b, t) * long_one * character.nodes[1].world_from_node},
                                     SkinningMethod::dual_quaternion);
    EXPECT_LT(glm::distance(glm::dvec3(stretched.position[0]),
                            glm::dvec3(half * glm::dvec4(2.0 * at.x, at.y, at.z, 1.0))),
              1e-5);
  }
}

TEST(DualQuaternionSkinning, CarriesEvenScaleOfAJoint) {
  Character character = random_character(50, 1, 1, 15);
  const std::vector world = {glm::scale(glm::dmat4(1.0), glm::dvec3(3.0))};
  const PosedMesh posed = skin(character, world, SkinningMethod::dual_quaternion);
  for (std::size_t v = 0; v < 50; ++v)
    EXPECT_NEAR(glm::distance(posed.position[v], 3.0f * character.bind_position[v]), 0.0f, 2e-6f);
}

TEST(DualQuaternionSkinning, OfRigidJointsIsTheSameBesideOneThatStretches) {
  const Character character = random_character(200, 2, 1, 17);
  std::mt19937 rng(18);
  const glm::dmat4 rigid = random_motion(rng);
  const auto posed = [&](double scale) {
    const std::vector world = {rigid, glm::scale(rigid, glm::dvec3(scale))};
    return skin(character, world, SkinningMethod::dual_quaternion);
  };
  const PosedMesh alone = posed(1.0), beside = posed(2.0);
  std::size_t rigid_vertices = 0;
  for (std::size_t v = 0; v < 200; ++v) {
    if (character.influences[v].joint[0] != 0) {
      EXPECT_NE(alone.position[v], beside.position[v]) << v;
      continue;
    }
    ++rigid_vertices;
    // One goes through a stretch of nothing, the other through none: roundings of numbers near 1.
    EXPECT_LT(glm::distance(alone.position[v], beside.position[v]), 2e-6f) << v;
    EXPECT_LT(glm::distance(alone.normal[v], beside.normal[v]), 2e-6f) << v;
  }
  EXPECT_GT(rigid_vertices, 50u);
}

TEST(Skinning, IsFiniteForAJointThatCollapsed) {
  const Character character = random_character(20, 2, 2, 16);
  const std::vector world = {glm::dmat4(1.0), glm::scale(glm::dmat4(1.0), glm::dvec3(0.0))};
  for (const auto method : {SkinningMethod::linear, SkinningMethod::dual_quaternion}) {
    const PosedMesh posed = skin(character, world, method);
    for (std::size_t v = 0; v < 20; ++v) {
      EXPECT_TRUE(std::isfinite(posed.position[v].x + posed.normal[v].x)) << v;
      EXPECT_NEAR(glm::length(posed.normal[v]), 1.0f, 1e-5f) << v;
    }
  }
}

}  // namespace
}  // namespace backbend::skin
