// What is too much for a character is refused at the first one too many, with the limit said.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "skin/clip/clip.h"
#include "skin/gltf/gltf_reader.h"
#include "skin/gltf/gltf_shape.h"
#include "skin/gltf/gltf_skins.h"
#include "tests/skin/gltf_fixture.h"

namespace backbend::skin {
namespace {

using nlohmann::json;

std::string refusal(const GltfFixture& file) {
  const TemporaryFolder folder;
  try {
    read_character(file.write_glb(folder));
    return "";
  } catch (const CharacterError& error) {
    return error.what();
  }
}

TEST(GltfLimits, ADocumentHas131072ObjectsAtMost) {
  // The document itself is one.
  for (const std::size_t nodes : {std::size_t{131071}, std::size_t{131072}}) {
    json root;
    root["nodes"] = std::vector<json>(nodes, json::object());
    if (nodes == 131071) {
      EXPECT_NO_THROW(check_gltf_shape(root, "a.gltf"));
      continue;
    }
    try {
      check_gltf_shape(root, "a.gltf");
      ADD_FAILURE() << nodes;
    } catch (const CharacterError& error) {
      EXPECT_STREQ(error.what(), "a.gltf: /nodes/131071: more than 131072 objects in the document");
    }
  }
}

TEST(GltfLimits, ANodeHas2048NodesAboveItAtMost) {
  for (const int above : {2048, 2049}) {
    GltfFixture file = strip();
    // hip, then a chain below the chest: hip and chest are the first two above the last.
    int parent = 1;
    for (int k = 2; k <= above; ++k) {
      const int node = static_cast<int>(file.root["nodes"].size());
      file.root["nodes"][static_cast<std::size_t>(parent)]["children"] = {node};
      file.root["nodes"].push_back({{"name", "n"}});
      parent = node;
    }
    const std::string told = refusal(file);
    EXPECT_EQ(told.find("/nodes/2050: more than 2048 nodes above it") != std::string::npos,
              above > 2048)
        << told;
    EXPECT_EQ(told.empty(), above == 2048) << told;
  }
}

TEST(GltfLimits, AnAccessorHasAsManyElementsAsMemoryWillHold) {
  GltfFixture file = strip();
  const auto bind = file.root["skins"][0]["inverseBindMatrices"].get<std::size_t>();
  file.root["accessors"][bind]["count"] = 67108865;
  EXPECT_NE(refusal(file).find("/count: 67108865 elements, more than the 67108864 that are read"),
            std::string::npos)
      << refusal(file);
  file.root["accessors"][bind]["count"] = 67108864;  // few enough, but not there
  EXPECT_NE(refusal(file).find("run past buffer view"), std::string::npos) << refusal(file);
  file.root["accessors"][bind].erase("bufferView");
  file.root["accessors"][bind]["count"] = 4194305;
  EXPECT_NE(refusal(file).find("/count: 4194305 elements, more than the 4194304 that are read"),
            std::string::npos)
      << refusal(file);
}

TEST(GltfLimits, TrianglesThatNothingIsStoredForAreCountedBeforeTheyAreRead) {
  GltfFixture file = strip();
  json& primitives = file.root["meshes"][0]["primitives"];
  primitives[0].erase("indices");
  json& position = file.root["accessors"][file.attributes()["POSITION"].get<std::size_t>()];
  position.erase("bufferView");  // all of them are zero then
  position["count"] = 1048576;
  for (int k = 1; k < 10; ++k) primitives.push_back(primitives[0]);
  // Three for each of the 1048576 vertices that a file may ask for without storing them.
  EXPECT_NE(refusal(file).find("/primitives/9: 3495250 triangles, too many for its vertices"),
            std::string::npos)
      << refusal(file);
}

TEST(GltfLimits, ACharacterHas65535JointsAtMost) {
  Character character;
  character.file_name = "a.glb";
  character.nodes.resize(65536);
  JointNumbers numbers(character);
  for (int n = 0; n < 65535; ++n)
    ASSERT_EQ(numbers.number(n, glm::dmat4(1.0)), static_cast<std::uint32_t>(n));
  EXPECT_EQ(numbers.number(77, glm::dmat4(1.0)), 77u);  // known already
  EXPECT_THROW(numbers.number(65535, glm::dmat4(1.0)), CharacterError);
  EXPECT_THROW(numbers.number(77, glm::dmat4(2.0)), CharacterError);
  EXPECT_EQ(character.joints.size(), 65535u);
}

TEST(GltfLimits, AClipsHeaderHas32MebibytesAtMost) {
  for (const std::size_t length : {std::size_t{33554432}, std::size_t{33554433}}) {
    std::vector<std::uint8_t> bytes(length, ' ');
    bytes.push_back('\n');
    try {
      parse_backbend_clip("a.clip", bytes);
      ADD_FAILURE() << length;
    } catch (const CharacterError& error) {
      EXPECT_EQ(std::string(error.what()) == "a.clip: a header of 33554433 bytes",
                length == 33554433)
          << error.what();
    }
  }
}

}  // namespace
}  // namespace backbend::skin
