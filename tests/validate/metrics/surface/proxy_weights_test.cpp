#include "validate/metrics/surface/proxy_weights.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "skin/deform/skinning.h"
#include "validate/calibrate/calibration_body.h"

namespace backbend::validate {
namespace {

std::vector<skin::Influences> proxies(const skin::Character& character,
                                      const skin::Anatomy& anatomy) {
  const skin::SpineDriver driver(character, anatomy);
  const auto made = proxy_weights(character, anatomy, driver, skin::rest_mesh(character));
  if (!made) throw std::runtime_error("no proxy");
  return *made;
}

double sum_of(const skin::Influences& influences) {
  double sum = 0.0;
  for (const float weight : influences.weight) sum += weight;
  return sum;
}

TEST(ProxyWeights, AreLinearBetweenTheJointsOfAStraightSpine) {
  const auto body = tube_body(6);
  const skin::Character& character = body->character();
  const std::vector<skin::Influences> made = proxies(character, body->stage().anatomy());
  int looked_at = 0;
  for (std::size_t v = 0; v < made.size(); ++v) {
    EXPECT_NEAR(sum_of(made[v]), 1.0, 1e-6);
    const glm::vec3 p = character.bind_position[v];
    // The torso's own vertices between hips (0.9) and neck (1.5), bones of 0.1, clear of the arms.
    if (std::abs(p.x) > 0.11 || p.y < 0.91 || p.y > 1.35) continue;
    const double along = (p.y - 0.9) / 0.1;
    double mean = 0.0;
    for (int k = 0; k < skin::kMaxInfluences; ++k) mean += made[v].joint[k] * made[v].weight[k];
    EXPECT_NEAR(mean, along, 0.01) << "height " << p.y;  // joint k stands at k bones
    ++looked_at;
  }
  EXPECT_GT(looked_at, 1000);
}

TEST(ProxyWeights, DoNotDependOnHowBadTheSpinesOwnWeightsWereAndLeaveArmsAlone) {
  const auto body = tube_body(6);
  skin::Character worse = body->character();
  const std::vector<skin::Influences> clean = proxies(worse, body->stage().anatomy());
  std::size_t arms = 0;
  for (skin::Influences& influences : worse.influences) {  // rigid: the heaviest joint takes all
    influences.weight = {1.0f};
  }
  const std::vector<skin::Influences> again = proxies(worse, body->stage().anatomy());
  for (std::size_t v = 0; v < clean.size(); ++v) {
    EXPECT_EQ(again[v].joint[0], clean[v].joint[0]) << v;
    EXPECT_NEAR(again[v].weight[0], clean[v].weight[0], 1e-6) << v;
    if (body->character().influences[v].joint[0] > 7) {
      EXPECT_EQ(clean[v].weight[0], 1.0f);
      EXPECT_EQ(clean[v].joint[0], body->character().influences[v].joint[0]);
      ++arms;
    }
  }
  EXPECT_GT(arms, 100u);
}

/// Adds a square sheet, 0.2 wide, `off` behind the trunk's surface, of 25 vertices that two joints
/// move, the second with so much of it. Its first vertex.
std::size_t add_sheet(skin::Character& character, float off, float second,
                      std::uint16_t joint = 3) {
  const std::size_t first = character.vertex_count();
  const float behind = std::ranges::min(character.bind_position, {}, &glm::vec3::z).z - off;
  skin::Influences influences;
  influences.joint = {joint, 4};
  influences.weight = {1.0f - second, second};
  for (int k = 0; k < 25; ++k) {
    const int column = k % 5, row = k / 5;
    const glm::vec2 across(0.05f * static_cast<float>(column), 0.05f * static_cast<float>(row));
    character.bind_position.emplace_back(across.x - 0.1f, 1.1f + across.y, behind);
    character.bind_normal.emplace_back(0.0f, 0.0f, -1.0f);
    character.influences.push_back(influences);
    character.place.push_back(character.place_count++);
    const auto at = static_cast<std::uint32_t>(first) + static_cast<std::uint32_t>(k);
    if (column == 4 || row == 4) continue;
    character.triangles.emplace_back(at, at + 5, at + 1);
    character.triangles.emplace_back(at + 1, at + 5, at + 6);
  }
  return first;
}

TEST(ProxyWeights, LeaveARigidPackAsItIsAndBendWhatLiesClose) {
  const auto body = tube_body(6);
  for (const float off : {0.01f, 0.1f})
    for (const float second : {0.0f, 0.01f, 0.3f}) {
      SCOPED_TRACE(std::to_string(off) + " " + std::to_string(second));
      skin::Character packed = body->character();
      const std::size_t first = add_sheet(packed, off, second);
      const std::vector<skin::Influences> made = proxies(packed, body->stage().anatomy());
      std::size_t kept = 0;
      for (std::size_t v = first; v < made.size(); ++v)
        kept += made[v].joint == packed.influences[v].joint &&
                made[v].weight == packed.influences[v].weight;
      EXPECT_EQ(kept, off > 0.05f && second < 0.1f ? 25u : 0u);
    }
}

TEST(ProxyWeights, BendAPackThatIsBoundFarFromWhereItIs) {
  const auto body = tube_body(6);
  for (const std::uint16_t joint : {std::uint16_t{0}, std::uint16_t{3}}) {  // the hips at 0.9
    skin::Character packed = body->character();
    const std::size_t first = add_sheet(packed, 0.1f, 0.0f, joint);
    const std::vector<skin::Influences> made = proxies(packed, body->stage().anatomy());
    EXPECT_EQ(made[first].joint == packed.influences[first].joint, joint == 3) << joint;
  }
}

TEST(ProxyWeights, AJointOfNoLengthOnASpineJointIsTheSpines) {
  const auto body = tube_body(6);
  const std::vector<skin::Influences> clean = proxies(body->character(), body->stage().anatomy());
  skin::Character split = body->character();
  const auto spine = static_cast<std::size_t>(body->stage().anatomy().spine[3]);
  skin::Node leaf = split.nodes[spine];
  leaf.name += "_bind";
  leaf.parent = static_cast<int>(spine);
  split.nodes.push_back(leaf);
  const auto of_spine = static_cast<std::uint16_t>(
      std::ranges::find(split.joints, static_cast<int>(spine), &skin::SkinJoint::node) -
      split.joints.begin());
  skin::SkinJoint joint = split.joints[of_spine];
  joint.node = static_cast<int>(split.nodes.size()) - 1;
  split.joints.push_back(joint);
  int moved = 0;
  for (skin::Influences& influences : split.influences)
    for (int k = 0; k < skin::kMaxInfluences; ++k)
      if (influences.weight[k] > 0.0f && influences.joint[k] == of_spine) {
        influences.joint[k] = static_cast<std::uint16_t>(split.joints.size() - 1);
        ++moved;
        break;
      }
  EXPECT_GT(moved, 100);
  const std::vector<skin::Influences> made = proxies(split, body->stage().anatomy());
  for (std::size_t v = 0; v < clean.size(); ++v) {
    EXPECT_EQ(made[v].joint, clean[v].joint) << v;
    EXPECT_EQ(made[v].weight, clean[v].weight) << v;
  }
}

TEST(ProxyWeights, KeepTheirSumWhereNotAllFit) {
  const auto body = tube_body(6);
  skin::Character crowded = body->character();
  // Of a vertex half way between two joints, seven joints that are not the spine's take 0.7.
  const auto half_way = std::ranges::find_if(crowded.bind_position, [](const glm::vec3& p) {
    return std::abs(p.x) < 0.05f && std::abs(p.y - 1.15f) < 0.012f;
  });
  ASSERT_NE(half_way, crowded.bind_position.end());
  const auto v = static_cast<std::size_t>(half_way - crowded.bind_position.begin());
  ASSERT_GE(crowded.joints.size(), 14u);
  skin::Influences& all = crowded.influences[v];
  all = {};
  all.joint[0] = 3;
  all.weight[0] = 0.3f;
  for (int k = 1; k < 8; ++k) {
    all.joint[k] = static_cast<std::uint16_t>(6 + k);
    all.weight[k] = 0.1f + 0.001f * static_cast<float>(k - 4);
  }
  const skin::Influences made = proxies(crowded, body->stage().anatomy())[v];
  for (const float weight : made.weight) EXPECT_GT(weight, 0.0f);
  EXPECT_NEAR(sum_of(made), 1.0, 1e-6);
  EXPECT_EQ(std::ranges::count(made.joint, 7), 0) << "the lightest of the nine";
  EXPECT_NEAR(made.weight[0] + made.weight[1], 0.3 / 0.903, 1e-5);
}

}  // namespace
}  // namespace backbend::validate
