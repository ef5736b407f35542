#include "validate/judge/torso_facts.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "validate/calibrate/calibration_body.h"

namespace backbend::validate {
namespace {

/// Every vertex on the joint that weighs most there.
skin::Character rigid(skin::Character body) {
  for (skin::Influences& each : body.influences) {
    const auto most = std::ranges::max_element(each.weight) - each.weight.begin();
    const auto joint = each.joint[static_cast<std::size_t>(most)];
    each = {};
    each.joint[0] = joint;
    each.weight[0] = 1.0f;
  }
  return body;
}

/// The same without the triangles that reach from one joint's vertices to another's.
skin::Character in_pieces(skin::Character body) {
  std::erase_if(body.triangles, [&](const glm::uvec3& t) {
    const auto joint = [&](unsigned v) { return body.influences[v].joint[0]; };
    return joint(t.x) != joint(t.y) || joint(t.x) != joint(t.z);
  });
  if (!body.parts.empty())
    body.parts.front().triangle_count = static_cast<std::uint32_t>(body.triangles.size());
  return body;
}

TEST(TorsoInPieces, IsARobotsWhosePlatesNoTriangleJoins) {
  const auto skin = tube_body(6);
  ASSERT_LE(skin->character().parts.size(), 1u);
  EXPECT_FALSE(torso_in_pieces(skin->stage()));
  const skin::Character stiff = rigid(skin->character());
  // Skin that was bound rigidly is one surface: what opens there is a fault.
  EXPECT_FALSE(torso_in_pieces(CalibrationBody(stiff, skin->stage().anatomy()).stage()));
  const CalibrationBody robot(in_pieces(stiff), skin->stage().anatomy());
  ASSERT_LT(robot.character().triangles.size(), stiff.triangles.size());
  EXPECT_TRUE(torso_in_pieces(robot.stage()));
}

TEST(TorsoInPieces, IsOneOfPlatesThatLieOverEachOther) {
  // Each plate is blended between its joints, and none reaches along most of the torso.
  const auto skin = tube_body(6);
  const skin::Anatomy& anatomy = skin->stage().anatomy();
  const auto height = [&](const glm::vec3& p) { return glm::dot(glm::dvec3(p), anatomy.up); };
  double low = 1e9, high = -1e9;
  for (std::size_t k = 0; k <= anatomy.chest_index; ++k) {
    const glm::vec3 joint(
        skin->character().nodes[static_cast<std::size_t>(anatomy.spine[k])].world_from_node[3]);
    low = std::min(low, height(joint));
    high = std::max(high, height(joint));
  }
  const auto cut_at = [&](std::initializer_list<double> fractions) {
    skin::Character body = skin->character();
    std::erase_if(body.triangles, [&](const glm::uvec3& t) {
      return std::ranges::any_of(fractions, [&](double fraction) {
        const double at = low + fraction * (high - low);
        const auto above = [&](unsigned v) {
          return height(skin->stage().rest().position[v]) > at;
        };
        return above(t.x) != above(t.y) || above(t.x) != above(t.z);
      });
    });
    if (!body.parts.empty())
      body.parts.front().triangle_count = static_cast<std::uint32_t>(body.triangles.size());
    return torso_in_pieces(CalibrationBody(std::move(body), anatomy).stage());
  };
  EXPECT_TRUE(cut_at({0.45}));
  EXPECT_TRUE(cut_at({0.3, 0.7}));
  EXPECT_FALSE(cut_at({0.2})) << "a shirt over trousers";
}

TEST(RowsPerBone, GrowsWithTheVerticesAlongTheBones) {
  const auto few = tube_body(24), many = tube_body(8);
  EXPECT_GT(rows_per_bone(few->stage()), 2.5);
  EXPECT_NEAR(rows_per_bone(many->stage()), 3.0 * rows_per_bone(few->stage()),
              0.3 * rows_per_bone(many->stage()));
}

}  // namespace
}  // namespace backbend::validate
