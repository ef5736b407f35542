// Every real character against what characters.json says of it: counts, size, spine and arms.
#include "tests/skin/shared_characters.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "skin/anatomy/limb_shift.h"
#include "skin/deform/skinning.h"
#include "skin/gltf/gltf_reader.h"
#include "skin/weights/inspect.h"

namespace backbend::skin {
namespace {

using nlohmann::json;

json facts_of(const std::string& file) {
  std::ifstream stream(shared_character("characters.json"));
  for (const json& entry : json::parse(stream))
    if (entry["file"] == file) return entry;
  throw std::runtime_error("characters.json does not know " + file);
}

std::vector<std::string> node_names(const Character& character, const std::vector<int>& nodes) {
  std::vector<std::string> out;
  for (const int node : nodes) out.push_back(character.nodes[static_cast<std::size_t>(node)].name);
  return out;
}

std::string axis_name(const glm::dvec3& v) {
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(v[axis]) > 0.999)
      return std::string(v[axis] > 0 ? "+" : "-") + static_cast<char>('X' + axis);
  return "oblique";
}

bool warned(const Character& character, const std::string& code) {
  for (const Warning& warning : character.warnings)
    if (warning.code == code) return true;
  return false;
}

class EveryCharacter : public ::testing::TestWithParam<const char*> {};

TEST_P(EveryCharacter, HasTheSpineArmsAndFacingThatItsAuthorGaveIt) {
  REQUIRE_CHARACTER(GetParam());
  const json facts = facts_of(GetParam());
  const Character character = read_character(shared_character(GetParam()));
  const Anatomy anatomy = find_anatomy(character);

  EXPECT_EQ(node_names(character, anatomy.spine), facts["spine"].get<std::vector<std::string>>());
  const json arms = facts["arms"];
  EXPECT_EQ(node_names(character, anatomy.left_arm),
            arms.value("left", std::vector<std::string>{}));
  EXPECT_EQ(node_names(character, anatomy.right_arm),
            arms.value("right", std::vector<std::string>{}));
  if (facts.contains("extra") && facts["extra"].contains("tail")) {
    EXPECT_EQ(node_names(character, anatomy.tail),
              facts["extra"]["tail"].get<std::vector<std::string>>());
  }
  EXPECT_EQ(axis_name(anatomy.forward), facts["forward"].get<std::string>());
  EXPECT_EQ(axis_name(anatomy.up), facts["up"].get<std::string>());
  EXPECT_NEAR(glm::length(glm::cross(anatomy.up, anatomy.forward) - anatomy.left), 0.0, 1e-12);
  EXPECT_TRUE(anatomy.sure());
}

TEST_P(EveryCharacter, HasItsCountsAndASkeletonInHierarchyOrder) {
  REQUIRE_CHARACTER(GetParam());
  const json facts = facts_of(GetParam());
  const Character character = read_character(shared_character(GetParam()));
  EXPECT_EQ(character.vertex_count(), facts["vertices"].get<std::size_t>());
  EXPECT_EQ(character.triangles.size(), facts["triangles"].get<std::size_t>());
  EXPECT_EQ(character.joints.size(), facts["joints"].get<std::size_t>());
  EXPECT_EQ(character.parts.size(), facts["primitives"].get<std::size_t>());
  for (std::size_t n = 0; n < character.nodes.size(); ++n)
    EXPECT_LT(character.nodes[n].parent, static_cast<int>(n));
  for (const Influences& influences : character.influences) {
    double sum = 0.0;
    for (const float weight : influences.weight) sum += weight;
    ASSERT_NEAR(sum, 1.0, 4e-7);  // eight floats near 1, each rounded once
  }
}

TEST_P(EveryCharacter, StandsAtRestWhereItsBindPoseIsItsSizeAndPlaces) {
  REQUIRE_CHARACTER(GetParam());
  const json facts = facts_of(GetParam());
  const Character character = read_character(shared_character(GetParam()));
  const PosedMesh rest = rest_mesh(character);
  glm::vec3 low = rest.position[0], high = low;
  for (const glm::vec3& p : rest.position) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  // characters.json measured the node pose, to three digits; where the bind pose is the rest the
  // size may differ by as much as the two poses do.
  const bool bind_is_rest = warned(character, "rest_is_bind_pose");
  for (int axis = 0; axis < 3; ++axis) {
    const double size = facts["size"][static_cast<std::size_t>(axis)];
    EXPECT_NEAR(high[axis] - low[axis], size, (bind_is_rest ? 0.08 : 0.003) * size) << axis;
  }
  const auto places = facts["places"].get<double>();
  EXPECT_NEAR(character.place_count, places, bind_is_rest ? 0.01 * places : 0.0);
}

TEST_P(EveryCharacter, HasTheBonesOfItsLimbsInsideOfThem) {
  REQUIRE_CHARACTER(GetParam());
  const Character character = read_character(shared_character(GetParam()));
  const auto shift = find_limb_shift(character, find_anatomy(character));
  if (shift) {
    EXPECT_LT(shift->beside, 0.6);
  }
}

INSTANTIATE_TEST_SUITE_P(Shared, EveryCharacter,
                         ::testing::Values("alpaca.glb", "apatosaurus.glb", "bunny.glb",
                                           "cesium_man.glb", "mh_female_cmu_13k.glb",
                                           "mh_female_cmu_49_08_baked.glb", "mh_male_13k.glb",
                                           "mh_male_214k.glb", "quaternius_female_24k.glb",
                                           "shark.glb", "snake.glb"),
                         [](const auto& test) {
                           const std::string file = test.param;
                           return file.substr(0, file.find('.'));
                         });

TEST(SharedCharacters, WarnOfWhatTheirAuthorsGotWrong) {
  REQUIRE_CHARACTER("cesium_man.glb");
  EXPECT_TRUE(warned(read_character(shared_character("cesium_man.glb")), "weights_renormalised"));
  for (const char* file : {"apatosaurus.glb", "snake.glb", "alpaca.glb"})
    EXPECT_TRUE(warned(read_character(shared_character(file)), "rest_is_bind_pose")) << file;
  EXPECT_TRUE(warned(read_character(shared_character("alpaca.glb")), "skeleton_hint_wrong"));
  EXPECT_TRUE(read_character(shared_character("mh_male_13k.glb")).warnings.empty());
}

/// What `inspect --json` says against all that characters.json knows of.
TEST(SharedCharacters, ChestIsWhereTheArmsHang) {
  REQUIRE_CHARACTER("characters.json");
  std::ifstream stream(shared_character("characters.json"));
  std::size_t checked = 0;
  for (const json& facts : json::parse(stream)) {
    const auto file = facts["file"].get<std::string>();
    SCOPED_TRACE(file);
    const Character character = read_character(shared_character(file));
    const json said = json::parse(inspect_json(character, find_anatomy(character)));
    EXPECT_EQ(said["chest"], facts["chest"]);
    EXPECT_EQ(said["spine"], facts["spine"]);
    // The chain is driven to there; a fish's goes on, a body without arms has it by other signs.
    const std::string end = file == "shark.glb"   ? "tail_tip"
                            : file == "snake.glb" ? "Neck"
                                                  : facts["chest"].get<std::string>();
    EXPECT_EQ(said["driven"]["end"], end);
    EXPECT_NE(said["driven"]["why"], "");
    ++checked;
  }
  EXPECT_GE(checked, 11u);
}

TEST(SharedCharacters, NeckStartsAtItsLowestJoint) {
  REQUIRE_CHARACTER("mh_male_13k.glb");
  const auto neck = [](const char* file) {
    const Character character = read_character(shared_character(file));
    const Anatomy anatomy = find_anatomy(character);
    return node_names(character, anatomy.spine)[anatomy.neck_index];
  };
  EXPECT_EQ(neck("mh_male_13k.glb"), "neck01");
  EXPECT_EQ(neck("mh_female_cmu_13k.glb"), "Neck");
  EXPECT_EQ(neck("quaternius_female_24k.glb"), "neck_01");
  EXPECT_EQ(neck("cesium_man.glb"), "#19");  // no names: the first joint above the arms
  EXPECT_EQ(neck("alpaca.glb"), "Neck1");
  EXPECT_EQ(neck("snake.glb"), "Neck");
}

TEST(SharedCharacters, AreFoundByShapeAloneWhenTheirNamesAreTakenAway) {
  for (const char* file : {"mh_male_13k.glb", "mh_female_cmu_13k.glb", "quaternius_female_24k.glb",
                           "bunny.glb", "alpaca.glb"}) {
    REQUIRE_CHARACTER(file);
    Character character = read_character(shared_character(file));
    const Anatomy named = find_anatomy(character);
    for (Node& node : character.nodes)
      node.name = std::string("#").append(std::to_string(node.file_node));
    const Anatomy unnamed = find_anatomy(character);
    // Past the neck a leaf joint cannot be told from a head without its name.
    ASSERT_GE(unnamed.spine.size(), named.spine.size()) << file;
    // Nor can a neck above the arms from more of the back: an animal's may start lower.
    EXPECT_LE(unnamed.neck_index, named.neck_index) << file;
    EXPECT_GE(unnamed.neck_index + 1, named.neck_index) << file;
    EXPECT_EQ(unnamed.chest, named.chest) << file;
    for (std::size_t k = 0; k < named.spine.size(); ++k)
      EXPECT_EQ(unnamed.spine[k], named.spine[k]) << file << " joint " << k;
    EXPECT_EQ(unnamed.left_arm.front(), named.left_arm.front()) << file;
    EXPECT_EQ(unnamed.right_arm.front(), named.right_arm.front()) << file;
    EXPECT_EQ(axis_name(unnamed.forward), axis_name(named.forward)) << file;
  }
}

}  // namespace
}  // namespace backbend::skin
