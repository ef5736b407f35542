// The shift between a body's limbs and their bones is found, and none where the limbs show none.
#include "skin/anatomy/limb_shift.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>
#include <set>

#include "skin/body/body.h"
#include "tests/source_folder.h"

namespace backbend::skin {
namespace {

/// The bundled human with few vertices.
const Character& body() {
  static const Character made =
      make_body(read_body_description(source_folder() / "scenes/characters/human.toml"), {4000});
  return made;
}

/// The same with its skeleton moved away from the body, which is bound to it as it is.
Character with_skeleton_moved(const glm::dvec3& by) {
  Character character = body();
  const glm::dmat4 motion = glm::translate(glm::dmat4(1.0), by);
  for (Node& node : character.nodes) node.world_from_node = motion * node.world_from_node;
  for (auto& joint : character.joints)
    joint.joint_from_mesh = joint.joint_from_mesh * glm::inverse(motion);
  return character;
}

TEST(LimbShift, IsWhatTheSkeletonWasMovedByTheOtherWayRound) {
  const Character& still = body();
  const Anatomy anatomy = find_anatomy(still);
  for (const glm::dvec3& way : {anatomy.up, anatomy.forward, -anatomy.forward, anatomy.left}) {
    const glm::dvec3 by = 0.1 * anatomy.height * way;
    const Character moved = with_skeleton_moved(by);
    const auto found = find_limb_shift(moved, find_anatomy(moved));
    ASSERT_TRUE(found.has_value());
    EXPECT_LT(glm::distance(found->shift, -by), 0.02 * anatomy.height);
    EXPECT_GT(found->beside, 1.0);
    EXPECT_GE(found->node, 0);
  }
}

TEST(LimbShift, OfAFigureWhoseBonesLieInItsLimbsStaysInside) {
  const Character& still = body();
  const auto found = find_limb_shift(still, find_anatomy(still));
  if (found) {
    EXPECT_LT(found->beside, 0.5);
  }
}

TEST(LimbShift, OfVeilsThatTrailBehindTheLimbsLeavesTheBonesInside) {
  Character character = body();
  const Anatomy anatomy = find_anatomy(character);
  const auto at = [&](int node) {
    return glm::dvec3(character.nodes[static_cast<std::size_t>(node)].world_from_node[3]);
  };
  // What is behind a limb's bones trails far behind them, all else of the limb stays.
  std::size_t trailing = 0;
  for (const auto* limb :
       {&anatomy.left_arm, &anatomy.right_arm, &anatomy.left_leg, &anatomy.right_leg})
    for (std::size_t k = 0; k + 1 < limb->size(); ++k) {
      const glm::dvec3 from = at((*limb)[k]), along = glm::normalize(at((*limb)[k + 1]) - from);
      for (std::size_t v = 0; v < character.vertex_count(); ++v) {
        const Influences& influences = character.influences[v];
        if (character.joints[influences.joint[0]].node != (*limb)[k]) continue;
        glm::vec3& p = character.bind_position[v];
        const glm::dvec3 off = glm::dvec3(p) - from;
        if (glm::dot(off - glm::dot(off, along) * along, anatomy.forward) > 0.0) continue;
        p -= glm::vec3(0.2 * anatomy.height * anatomy.forward);
        ++trailing;
      }
    }
  ASSERT_GT(trailing, 10u);
  const auto found = find_limb_shift(character, anatomy);
  ASSERT_TRUE(found.has_value());
  EXPECT_LT(glm::dot(found->shift, anatomy.forward), -0.05 * anatomy.height);  // the limbs' middles
  EXPECT_LT(found->beside, 1.0);
}

TEST(LimbShift, ThatLegsDoNotShowThoughItIsAlongThemIsNone) {
  Character character = body();
  const Anatomy anatomy = find_anatomy(character);
  for (std::size_t v = 0; v < character.vertex_count(); ++v)
    for (const auto* arm : {&anatomy.left_arm, &anatomy.right_arm})
      if (std::ranges::find(*arm, character.joints[character.influences[v].joint[0]].node) !=
          arm->end())
        character.bind_position[v] += glm::vec3(0.12 * anatomy.height * anatomy.up);
  EXPECT_FALSE(find_limb_shift(character, anatomy).has_value());
}

TEST(LimbShift, IsNotToldByBonesThatLeadAtAFewPlaces) {
  // The skeleton stands beside the body; all but some places of each limb's bone go with the hips.
  const auto is_told = [](std::size_t kept) {
    const Anatomy still = find_anatomy(body());
    Character character = with_skeleton_moved(0.1 * still.height * still.forward);
    const Anatomy anatomy = find_anatomy(character);
    const auto leads = [&](std::uint16_t joint) {
      std::vector<std::size_t> own;
      std::set<std::uint32_t> places;
      for (std::size_t v = 0; v < character.vertex_count(); ++v)
        if (character.influences[v].joint[0] == joint && places.insert(character.place[v]).second)
          own.push_back(v);
      return own;
    };
    const auto joint_of = [&](int node) {
      std::uint16_t j = 0;
      while (character.joints[j].node != node) ++j;
      return j;
    };
    const std::uint16_t hips = joint_of(anatomy.spine.front());
    for (const auto* limb :
         {&anatomy.left_arm, &anatomy.right_arm, &anatomy.left_leg, &anatomy.right_leg})
      for (const int node : *limb) {
        const std::uint16_t joint = joint_of(node);
        const std::vector<std::size_t> own = leads(joint);
        std::set<std::size_t> stay;
        for (std::size_t k = 0; k < kept && !own.empty(); ++k)
          stay.insert(own[k * own.size() / kept]);
        for (std::size_t v = 0; v < character.vertex_count(); ++v)
          for (std::size_t k = 0; k < kMaxInfluences; ++k) {
            Influences& influences = character.influences[v];
            if (influences.weight[k] <= 0.0f || influences.joint[k] != joint) continue;
            if (stay.count(v) > 0) continue;
            influences = {};
            influences.joint[0] = hips;
            influences.weight[0] = 1.0f;
          }
      }
    return find_limb_shift(character, anatomy).has_value();
  };
  EXPECT_TRUE(is_told(12));
  EXPECT_FALSE(is_told(5));
}

TEST(LimbShift, OfAFigureWithoutLimbsIsNone) {
  const Character& still = body();
  Anatomy anatomy = find_anatomy(still);
  for (auto* limb : {&anatomy.left_arm, &anatomy.right_arm, &anatomy.left_leg, &anatomy.right_leg})
    limb->clear();
  EXPECT_FALSE(find_limb_shift(still, anatomy).has_value());
}

}  // namespace
}  // namespace backbend::skin
