#include "skin/anatomy/body_kind.h"

#include <gtest/gtest.h>

#include <glm/gtc/quaternion.hpp>

#include "tests/skin/shared_characters.h"
#include "tests/skin/stick_figure.h"

#include "skin/gltf/gltf_reader.h"

namespace backbend::skin {
namespace {

TEST(BodyKind, OfArmsOnAnUprightSpineIsAHuman) {
  const Character character = stick_figure(4);
  const BodyKindChoice choice = body_kind(character, find_anatomy(character));
  EXPECT_EQ(choice.kind, BodyKind::human);
  EXPECT_NE(choice.reason.find("arms on an upright spine"), std::string::npos) << choice.reason;
}

TEST(BodyKind, WithoutArmsAndLegsIsASnake) {
  const Character character = stick_figure(4);
  Anatomy anatomy = find_anatomy(character);
  for (auto* limb : {&anatomy.left_arm, &anatomy.right_arm, &anatomy.left_leg, &anatomy.right_leg})
    limb->clear();
  EXPECT_EQ(body_kind(character, anatomy).kind, BodyKind::snake);
}

/// The stick figure's anatomy seen as one that lies along its spine.
TEST(BodyKind, OfALyingBackIsAnAnimalUntilTheNeckIsMostOfTheWay) {
  const Character character = stick_figure(4);
  Anatomy anatomy = find_anatomy(character);
  anatomy.up = anatomy.forward;  // hips at 0.9, neck at 1.4, head at 1.5: a back that lies
  EXPECT_EQ(body_kind(character, anatomy).kind, BodyKind::animal);
  anatomy.chest_index = 1;  // hips to the first spine joint: the rest is neck
  const BodyKindChoice choice = body_kind(character, anatomy);
  EXPECT_EQ(choice.kind, BodyKind::long_neck);
  EXPECT_NE(choice.reason.find(" % of the way from hips to head"), std::string::npos);
}

class KindOf : public testing::TestWithParam<std::pair<const char*, BodyKind>> {};

TEST_P(KindOf, IsWhatAnybodyWouldCallIt) {
  REQUIRE_CHARACTER(GetParam().first);
  const Character character = read_character(shared_character(GetParam().first));
  const BodyKindChoice choice = body_kind(character, find_anatomy(character));
  EXPECT_EQ(choice.kind, GetParam().second) << name_of(choice.kind) << ": " << choice.reason;
}

INSTANTIATE_TEST_SUITE_P(Shared, KindOf,
                         testing::Values(std::pair{"mh_male_13k.glb", BodyKind::human},
                                         std::pair{"mh_female_cmu_13k.glb", BodyKind::human},
                                         std::pair{"quaternius_female_24k.glb", BodyKind::human},
                                         std::pair{"cesium_man.glb", BodyKind::human},
                                         std::pair{"apatosaurus.glb", BodyKind::long_neck},
                                         std::pair{"alpaca.glb", BodyKind::long_neck},
                                         std::pair{"snake.glb", BodyKind::snake}));

}  // namespace
}  // namespace backbend::skin
