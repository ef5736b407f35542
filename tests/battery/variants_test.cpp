// The battery's own means: variants that must leave a body sound, and faults of known size.
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <map>

#include "skin/body/body.h"
#include "skin/character/matrix_facts.h"
#include "skin/deform/skinning.h"
#include "tests/battery/body_variants.h"
#include "tests/battery/motion_faults.h"
#include "tests/battery/weight_faults.h"
#include "tests/skin/body_figure.h"
#include "validate/metrics/math/rotation.h"

namespace backbend::battery {
namespace {

using Index = std::size_t;
using skin::Character;

const Character& figure() {
  static const Character body = welded(skin::make_body(skin::figure()));
  return body;
}

/// The figure has no head to tell its spine by.
skin::Anatomy anatomy_of(const Character& body) {
  skin::AnatomyHints hints;
  hints.hip = "hips";
  hints.chest = "chest";
  return skin::find_anatomy(body, hints);
}

double farthest(const std::vector<glm::vec3>& a, const std::vector<glm::vec3>& b) {
  double most = a.size() == b.size() ? 0.0 : 1e9;
  for (Index v = 0; v < std::min(a.size(), b.size()); ++v)
    most = std::max(most, static_cast<double>(glm::distance(a[v], b[v])));
  return most;
}

void expect_whole_weights(const Character& body) {
  for (Index v = 0; v < body.vertex_count(); ++v) {
    double sum = 0.0;
    for (const float w : body.influences[v].weight) sum += w;
    ASSERT_NEAR(sum, 1.0, 1e-5) << v;
  }
}

/// Edges that do not have exactly two triangles.
int open_edges(const Character& body) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const glm::uvec3& t : body.triangles)
    for (int k = 0; k < 3; ++k)
      ++edges[{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])}];
  return static_cast<int>(
      std::ranges::count_if(edges, [](const auto& each) { return each.second != 2; }));
}

int node_named(const Character& body, const std::string& name) {
  for (Index n = 0; n < body.nodes.size(); ++n)
    if (body.nodes[n].name == name) return static_cast<int>(n);
  ADD_FAILURE() << "no node " << name;
  return 0;
}

TEST(Variants, ADecimatedBodyIsClosedAndWhole) {
  Character body = figure();
  ASSERT_EQ(open_edges(body), 0);
  decimate(body, 700);
  EXPECT_LT(body.vertex_count(), 1000u);
  EXPECT_GE(body.vertex_count(), 700u);
  EXPECT_EQ(open_edges(body), 0);
  expect_whole_weights(body);
}

TEST(Variants, ASubdividedBodyIsClosedAndWhole) {
  Character body = figure();
  const Index triangles = body.triangles.size();
  subdivide(body);
  EXPECT_EQ(body.triangles.size(), 4 * triangles);
  EXPECT_EQ(open_edges(body), 0);
  expect_whole_weights(body);
}

TEST(Variants, WeightsStaySums) {
  Character body = figure();
  smooth_weights(body, 5);
  expect_whole_weights(body);
  limit_influences(body, 3);
  expect_whole_weights(body);
  quantise_weights(body);
  expect_whole_weights(body);
  EXPECT_EQ(body.influences[0].weight[3], 0.0f);
}

TEST(Variants, TheWorldSeesNoOtherBindSpace) {
  Character body = figure();
  change_bind_space(
      body, glm::rotate(glm::scale(glm::dmat4(1.0), glm::dvec3(100.0)), 1.0, glm::dvec3(1, 0, 0)));
  EXPECT_LT(farthest(skin::rest_mesh(body).position, skin::rest_mesh(figure()).position), 1e-5);
}

TEST(Variants, PartsOfSeveralBindSpacesAreBroughtIntoOne) {
  Character body = figure();
  const Index vertices = body.vertex_count(), joints = body.joints.size();
  // The upper half of the vertices as a part of its own, in centimetres.
  const glm::dmat4 metres = glm::scale(glm::dmat4(1.0), glm::dvec3(0.01));
  body.parts.front().vertex_count = static_cast<std::uint32_t>(vertices / 2);
  skin::Part coat = body.parts.front();
  coat.first_vertex = static_cast<std::uint32_t>(vertices / 2);
  coat.vertex_count = static_cast<std::uint32_t>(vertices - vertices / 2);
  body.parts.push_back(coat);
  for (Index j = 0; j < joints; ++j)
    body.joints.push_back({body.joints[j].node, body.joints[j].joint_from_mesh * metres});
  for (Index v = vertices / 2; v < vertices; ++v) {
    body.bind_position[v] *= 100.0f;
    for (std::uint16_t& joint : body.influences[v].joint)
      joint = static_cast<std::uint16_t>(joint + joints);
  }
  const std::vector<glm::vec3> wanted = skin::rest_mesh(figure()).position;
  ASSERT_LT(farthest(skin::rest_mesh(body).position, wanted), 1e-5);
  Character one = bound_in_one_space(body);
  EXPECT_LT(farthest(skin::rest_mesh(one).position, wanted), 1e-5);
  EXPECT_LT(farthest(one.bind_position, figure().bind_position), 1e-5);

  body.joints[joints + 2].joint_from_mesh *= metres;  // of no part's space
  EXPECT_THROW(bound_in_one_space(body), std::runtime_error);
}

TEST(Variants, AScaledBodyStandsScaled) {
  Character body = figure();
  scale(body, 40.0);
  std::vector<glm::vec3> wanted = skin::rest_mesh(figure()).position;
  for (glm::vec3& p : wanted) p *= 40.0f;
  EXPECT_LT(farthest(skin::rest_mesh(body).position, wanted), 1e-3);
}

TEST(Variants, AMirroredBodySwapsItsSides) {
  Character body = figure();
  mirror(body, glm::dvec3(1, 0, 0));
  std::vector<glm::vec3> wanted = skin::rest_mesh(figure()).position;
  for (glm::vec3& p : wanted) p.x = -p.x;
  EXPECT_LT(farthest(skin::rest_mesh(body).position, wanted), 1e-5);
  const auto arm = static_cast<Index>(node_named(body, "arm_L"));
  EXPECT_GT(body.nodes[arm].world_from_node[3].x, 0.1);
}

TEST(Variants, AResampledSpineHasTheJointsAskedForAndTheSameRest) {
  const skin::Anatomy anatomy = anatomy_of(figure());
  for (const Index wanted : {3, 4, 7, 10}) {
    Character body = figure();
    EXPECT_EQ(resample_spine(body, anatomy, wanted), wanted);
    EXPECT_LT(farthest(skin::rest_mesh(body).position, skin::rest_mesh(figure()).position), 1e-5);
    expect_whole_weights(body);
    EXPECT_EQ(hips_to_chest(body, anatomy_of(body)).size(), wanted);
  }
  // More pieces than the surface has rows for would move nothing.
  Character body = figure();
  EXPECT_LT(resample_spine(body, anatomy, 24), 24u);
  expect_whole_weights(body);
}

class Motions : public testing::Test {
 protected:
  const Character& body = figure();
  skin::Anatomy anatomy = anatomy_of(body);
  std::vector<int> chain = hips_to_chest(body, anatomy);
  Motion sweep = sweep_motion(body, anatomy, chain, {.extension = 40, .seconds = 2});

  glm::dquat turn_of(const Motion& motion, Index frame, int node) const {
    const glm::dmat4 world = world_of(body, motion.local[frame])[static_cast<Index>(node)];
    return glm::quat_cast(
        glm::dmat3(world * glm::inverse(body.nodes[static_cast<Index>(node)].world_from_node)));
  }
};

TEST_F(Motions, ASweepTurnsTheChestAsFarAsAsked) {
  const Index middle = sweep.frame_count() / 2;
  const glm::dvec3 turn = validate::rotation_vector(turn_of(sweep, middle, chain.back()));
  EXPECT_NEAR(validate::degrees(glm::length(turn)), 40.0, 0.01);
  EXPECT_LT(glm::dot(turn, anatomy.left), 0.0);  // backwards
  EXPECT_NEAR(sweep.control_deg[middle][0], 40.0, 0.01);
  EXPECT_NEAR(validate::rotation_vector(turn_of(sweep, 0, chain.back())).x, 0.0, 1e-9);
}

TEST_F(Motions, HalfTheSpeedTakesTwiceTheTime) {
  const Motion slow = resampled(sweep, 0.5, 1.5, 60.0, 0.5);
  EXPECT_EQ(slow.frame_count(), 121u);
  EXPECT_NEAR(slow.time.back(), 2.0, 1e-9);
  EXPECT_NEAR(slow.control_deg.back()[0], sweep.control_deg[45][0], 1e-9);
}

TEST_F(Motions, AClipFileHoldsTheMotion) {
  const skin::Clip clip = skin::parse_backbend_clip("a.clip", clip_bytes(body, sweep));
  ASSERT_EQ(clip.frame_count(), sweep.frame_count());
  ASSERT_EQ(clip.joint_count(), body.nodes.size());
  const auto world = world_of(body, sweep.local[20]);
  for (Index j = 0; j < world.size(); ++j)
    EXPECT_LT(
        glm::distance(skin::origin(clip.world[20 * world.size() + j]), skin::origin(world[j])),
        1e-5);
}

TEST_F(Motions, AStepTurnsOneJointFromItsFrameOn) {
  Motion faulted = sweep;
  validate::Draw draw(1, 1);
  const MotionFault fault = plant(faulted, body, anatomy, chain, "step", 20.0, draw);
  ASSERT_EQ(fault.joints.size(), 1u);
  const int node = node_named(body, *fault.joints.begin());
  const auto at = static_cast<Index>(fault.frame);
  const auto apart = [&](Index frame) {
    return validate::degrees(
        validate::angle_between(turn_of(faulted, frame, node), turn_of(sweep, frame, node)));
  };
  EXPECT_NEAR(apart(at - 1), 0.0, 1e-6);
  EXPECT_NEAR(apart(at), 20.0, 1e-6);
  EXPECT_NEAR(apart(sweep.frame_count() - 1), 20.0, 1e-6);
}

TEST_F(Motions, AKinkLeavesTheChestWhereItWas) {
  Motion faulted = sweep;
  validate::Draw draw(1, 2);
  const MotionFault fault = plant(faulted, body, anatomy, chain, "kink", 10.0, draw);
  ASSERT_FALSE(fault.joints.empty());
  const Index middle = sweep.frame_count() / 2;
  EXPECT_NEAR(validate::degrees(validate::angle_between(turn_of(faulted, middle, chain.back()),
                                                        turn_of(sweep, middle, chain.back()))),
              0.0, 1e-6);
}

TEST(WeightFaults, EachKindChangesWhatItSaysAndNoMore) {
  const skin::Anatomy anatomy = anatomy_of(figure());
  for (const WeightFaultKind& kind : weight_fault_kinds()) {
    Character body = figure();
    validate::Draw draw(3, 7);
    const WeightFault fault = plant(body, anatomy, kind.name, kind.sizes.back(), draw);
    if (fault.joints.empty()) continue;  // a figure without hands and head has no place for some
    const auto touched = std::ranges::count(fault.touched, true);
    EXPECT_GT(touched, 0) << kind.name;
    expect_whole_weights(body);
    for (Index v = 0; v < figure().vertex_count(); ++v)
      if (!fault.touched[v]) {
        EXPECT_EQ(body.influences[v].joint, figure().influences[v].joint) << kind.name;
        EXPECT_EQ(body.influences[v].weight, figure().influences[v].weight) << kind.name;
      }
  }
}

}  // namespace
}  // namespace backbend::battery
