#include "skin/anatomy/driven_nodes.h"

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "tests/skin/stick_figure.h"

namespace backbend::skin {
namespace {

using Kind = DrivenNode::Kind;

/// What each named joint does.
std::map<std::string, DrivenNode> by_name(const Character& character) {
  const Anatomy anatomy = find_anatomy(character);
  std::map<std::string, DrivenNode> out;
  for (const DrivenNode& each : driven_nodes(character, anatomy))
    out[character.nodes[static_cast<std::size_t>(each.node)].name] = each;
  return out;
}

TEST(DrivenNodes, TheSpineIsDrivenAndLimbsFollowIt) {
  const Character character = stick_figure();
  auto nodes = by_name(character);
  for (const char* joint : {"hips", "spine_1", "spine_2"})
    EXPECT_EQ(nodes.at(joint).kind, Kind::driven) << joint;
  for (const char* joint : {"thigh.L", "shin.R"}) {
    EXPECT_EQ(nodes.at(joint).kind, Kind::follows) << joint;
    EXPECT_EQ(nodes.at(joint).leader, stick_node(character, "hips")) << joint;
  }
  EXPECT_EQ(nodes.at("head").kind, Kind::follows);
  EXPECT_EQ(nodes.at("hand.L").kind, Kind::follows);
  EXPECT_FALSE(nodes.contains("scene")) << "no joint of the skin, no node of the spine";
}

TEST(DrivenNodes, WhatHangsFromNothingThatMovesIsStill) {
  Character character = stick_figure();
  const int prop = add_node(character, "prop", stick_node(character, "scene"), {2.0, 0.3, 0.0});
  stick_vertex(character, prop);
  const auto nodes = by_name(character);
  EXPECT_EQ(nodes.at("prop").kind, Kind::still);
  EXPECT_EQ(nodes.at("prop").leader, -1);
}

TEST(DrivenNodes, AreSaidInALineEachAndAsJson) {
  Character character = stick_figure();
  const Anatomy anatomy = find_anatomy(character);
  const auto nodes = driven_nodes(character, anatomy);
  const std::string text = driven_text(character, nodes);
  EXPECT_NE(text.find("thigh.L"), std::string::npos);
  EXPECT_NE(text.find("follows hips"), std::string::npos) << text;
  EXPECT_EQ(static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')), nodes.size());
  const auto json = nlohmann::json::parse(driven_json(character, nodes));
  EXPECT_EQ(json["schema"], "backbend.driven/1");
  EXPECT_EQ(json["joints"].size(), nodes.size());
  EXPECT_EQ(json["joints"][0]["motion"], "driven");
  EXPECT_TRUE(json["joints"][0]["leader"].is_null());
}

}  // namespace
}  // namespace backbend::skin
