#include "skin/inspect.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "skin/gltf_reader.h"
#include "tests/skin/shared_characters.h"
#include "tests/skin/stick_figure.h"

namespace backbend::skin {
namespace {

using nlohmann::json;

json inspect(const Character& character) {
  const Anatomy anatomy = find_anatomy(character);
  return json::parse(inspect_json(character, anatomy));
}

TEST(Inspect, GivesTheDocumentedKeys) {
  const Character character = stick_figure();
  const json root = inspect(character);
  EXPECT_EQ(root["schema"], "backbend.inspect/1");
  EXPECT_EQ(root["spine"], json({"hips", "spine_1", "spine_2", "neck", "head"}));
  EXPECT_EQ(root["chest"], "neck");
  EXPECT_EQ(root["arms"]["left"], json({"clavicle.L", "arm.L", "hand.L"}));
  EXPECT_EQ(root["arms"]["right"][0], "clavicle.R");
  EXPECT_EQ(root["legs"]["left"][0], "thigh.L");
  EXPECT_EQ(root["driven"]["joints"].size(), 4u);
  EXPECT_EQ(root["driven"]["arms_follow"], "chest");
  EXPECT_NEAR(root["driven"]["joints"][1]["fraction"].get<double>(), 1.0 / 3.0, 1e-12);
  EXPECT_EQ(root["vertices"], character.vertex_count());
  EXPECT_TRUE(root["meshes"].is_array());
  EXPECT_TRUE(root["weights"]["bleed"].is_array());
  EXPECT_TRUE(root["warnings"].empty());
  EXPECT_EQ(root["skeleton"].size(), character.nodes.size());
}

TEST(Inspect, CarriesTheImportsWarningsByCode) {
  Character character = stick_figure();
  character.warnings.push_back({"weights_renormalised", "as told"});
  const json root = inspect(character);
  EXPECT_EQ(root["warnings"][0]["code"], "weights_renormalised");
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_NE(inspect_text(character, anatomy).find("weights_renormalised: as told"),
            std::string::npos);
}

TEST(Inspect, IsFitForATerminalWhateverTheNames) {
  Character character = stick_figure();
  character.nodes[static_cast<std::size_t>(stick_node(character, "hand.L"))].name =
      "hand\x1b[2J\n\xff.L";
  const Anatomy anatomy = find_anatomy(character);
  for (const char c : inspect_text(character, anatomy))
    EXPECT_TRUE(c == '\n' || static_cast<unsigned char>(c) >= 0x20);
  EXPECT_TRUE(json::accept(inspect_json(character, anatomy)));
}

TEST(Inspect, SaysTheSameEachTime) {
  const Character character = stick_figure();
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_EQ(inspect_json(character, anatomy), inspect_json(character, anatomy));
  EXPECT_EQ(inspect_text(character, anatomy), inspect_text(character, anatomy));
}

TEST(Inspect, NamesJointsWithoutANameByTheirNumber) {
  REQUIRE_CHARACTER("cesium_man.glb");
  const json root = inspect(read_character(shared_character("cesium_man.glb")));
  EXPECT_EQ(root["spine"], json({"#2", "#11", "#12", "#19", "#20"}));
  EXPECT_EQ(root["weights"]["off_sum"], 210);
  EXPECT_NEAR(root["weights"]["worst_sum"].get<double>(), 0.18, 0.01);
}

}  // namespace
}  // namespace backbend::skin
