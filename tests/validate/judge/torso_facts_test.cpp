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

TEST(RowsPerBone, GrowsWithTheVerticesAlongTheBones) {
  const auto few = tube_body(24), many = tube_body(8);
  EXPECT_GT(rows_per_bone(few->stage()), 2.5);
  EXPECT_NEAR(rows_per_bone(many->stage()), 3.0 * rows_per_bone(few->stage()),
              0.3 * rows_per_bone(many->stage()));
}

}  // namespace
}  // namespace backbend::validate
