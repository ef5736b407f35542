// What a skinned glTF file may hold, each on a strip of ten vertices whose answer is known.
#include "skin/gltf/gltf_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "skin/deform/skinning.h"
#include "tests/skin/gltf_fixture.h"

namespace backbend::skin {
namespace {

using nlohmann::json;

Character read(const GltfFixture& file) {
  const TemporaryFolder folder;
  return read_character(file.write_glb(folder));
}

const Warning* warning(const Character& character, const std::string& code) {
  const auto found = std::find_if(character.warnings.begin(), character.warnings.end(),
                                  [&](const Warning& w) { return w.code == code; });
  return found == character.warnings.end() ? nullptr : &*found;
}

float weight_of(const Character& character, std::size_t vertex, const std::string& joint) {
  const Influences& influences = character.influences[vertex];
  for (std::size_t k = 0; k < kMaxInfluences; ++k) {
    const int node = character.joints[influences.joint[k]].node;
    if (influences.weight[k] > 0.0f &&
        character.nodes[static_cast<std::size_t>(node)].name == joint)
      return influences.weight[k];
  }
  return 0.0f;
}

/// The strip's own rest positions, whatever route they took through the file.
void expect_strip(const Character& character, float tolerance = 0.0f) {
  ASSERT_EQ(character.vertex_count(), 10u);
  const PosedMesh rest = rest_mesh(character);
  for (std::size_t v = 0; v < 10; ++v) {
    EXPECT_NEAR(rest.position[v].x, v % 2 == 0 ? -0.5f : 0.5f, tolerance) << v;
    EXPECT_NEAR(rest.position[v].y, 0.5f * static_cast<float>(v / 2), tolerance) << v;
    EXPECT_NEAR(rest.position[v].z, 0.0f, tolerance) << v;
  }
}

TEST(GltfReader, ReadsAPlainCharacterWithoutAWarning) {
  const Character character = read(strip());
  EXPECT_TRUE(character.warnings.empty());
  EXPECT_EQ(character.name, "test");
  EXPECT_EQ(character.file_name, "test.glb");
  ASSERT_EQ(character.joints.size(), 2u);
  EXPECT_EQ(character.nodes[1].name, "chest");
  EXPECT_EQ(character.nodes[1].parent, 0);
  EXPECT_EQ(character.triangles.size(), 8u);
  EXPECT_EQ(character.uv.size(), 10u);
  EXPECT_EQ(character.place_count, 10u);
  EXPECT_EQ(character.parts.at(0).name, "strip");
  EXPECT_EQ(character.materials.at(static_cast<std::size_t>(character.parts[0].material)).name,
            "default");
  EXPECT_FLOAT_EQ(weight_of(character, 2, "hip"), 0.75f);
  EXPECT_FLOAT_EQ(weight_of(character, 2, "chest"), 0.25f);
  expect_strip(character);
}

TEST(GltfReader, PutsTheLargestWeightFirst) {
  const Character character = read(strip());
  for (const Influences& influences : character.influences)
    for (std::size_t k = 1; k < kMaxInfluences; ++k)
      EXPECT_GE(influences.weight[k - 1], influences.weight[k]);
}

TEST(GltfReader, ReadsNormalisedWeightsLikeFloatOnes) {
  GltfFixture bytes = strip(), shorts = strip();
  std::vector<std::uint8_t> w8;
  std::vector<std::uint16_t> w16;
  for (int row = 0; row < 5; ++row)
    for (int side = 0; side < 2; ++side) {
      const auto chest8 = static_cast<std::uint8_t>(std::lround(255 * 0.25 * row));
      const auto chest16 = static_cast<std::uint16_t>(std::lround(65535 * 0.25 * row));
      w8.insert(w8.end(), {static_cast<std::uint8_t>(255 - chest8), chest8, 0, 0});
      w16.insert(w16.end(), {static_cast<std::uint16_t>(65535 - chest16), chest16, 0, 0});
    }
  bytes.attributes()["WEIGHTS_0"] = bytes.add(w8, kUnsignedByte, "VEC4", 4, true);
  shorts.attributes()["WEIGHTS_0"] = shorts.add(w16, kUnsignedShort, "VEC4", 4, true);
  const Character from_bytes = read(bytes), from_shorts = read(shorts);
  for (std::size_t v = 0; v < 10; ++v) {
    const float chest = 0.25f * static_cast<float>(v / 2);
    EXPECT_NEAR(weight_of(from_bytes, v, "chest"), chest, 0.5f / 255.0f + 1e-6f);
    EXPECT_NEAR(weight_of(from_shorts, v, "chest"), chest, 0.5f / 65535.0f + 1e-6f);
  }
  EXPECT_TRUE(from_bytes.warnings.empty());
  EXPECT_TRUE(from_shorts.warnings.empty());
}

TEST(GltfReader, DoesNotBlameEightBitsForTheirRounding) {
  // 85 + 85 + 84 of 255 is 254/255: as near to a third each as a byte gets.
  GltfFixture file = strip();
  std::vector<std::uint8_t> weights, joints;
  for (int v = 0; v < 10; ++v) {
    weights.insert(weights.end(), {127, 127, 0, 0});
    joints.insert(joints.end(), {0, 1, 0, 0});
  }
  file.attributes()["WEIGHTS_0"] = file.add(weights, kUnsignedByte, "VEC4", 4, true);
  EXPECT_TRUE(read(file).warnings.empty());
}

TEST(GltfReader, RenormalisesAndNamesTheWorstSum) {
  GltfFixture file = strip();
  std::vector<float> weights;
  for (int v = 0; v < 10; ++v) {
    const float hip = v == 3 ? 0.4f : 0.5f;
    weights.insert(weights.end(), {hip, 0.5f, 0.0f, 0.0f});
  }
  file.attributes()["WEIGHTS_0"] = file.add(weights, kFloat, "VEC4", 4);
  const Character character = read(file);
  const Warning* found = warning(character, "weights_renormalised");
  ASSERT_TRUE(found);
  EXPECT_NE(found->message.find("worst 0.9, vertex 3"), std::string::npos) << found->message;
  EXPECT_NEAR(weight_of(character, 3, "hip"), 0.4f / 0.9f, 1e-6f);
}

TEST(GltfReader, SeesASumThatIsOffByAThousandth) {
  GltfFixture file = strip();
  std::vector<float> weights;
  for (int v = 0; v < 10; ++v) weights.insert(weights.end(), {0.5f, 0.501f, 0.0f, 0.0f});
  file.attributes()["WEIGHTS_0"] = file.add(weights, kFloat, "VEC4", 4);
  EXPECT_TRUE(warning(read(file), "weights_renormalised"));
}

TEST(GltfReader, KeepsVerticesWithoutWeightAtTheirRestPlace) {
  GltfFixture file = strip();
  std::vector<float> weights;
  for (int v = 0; v < 10; ++v)
    weights.insert(weights.end(), {v == 9 ? 0.0f : 1.0f, 0.0f, 0.0f, 0.0f});
  file.attributes()["WEIGHTS_0"] = file.add(weights, kFloat, "VEC4", 4);
  const Character character = read(file);
  EXPECT_TRUE(warning(character, "vertices_unweighted"));
  EXPECT_EQ(character.unweighted, std::vector<std::uint32_t>{9});
  expect_strip(character);
}

TEST(GltfReader, HoldsVerticesWithoutWeightOnTheTopmostNodeAboveTheirSkin) {
  for (const bool below : {false, true}) {
    GltfFixture file = strip();
    std::vector<float> weights(40, 0.0f);
    for (std::size_t v = 0; v < 8; ++v) weights[4 * v] = 1.0f;
    file.attributes()["WEIGHTS_0"] = file.add(weights, kFloat, "VEC4", 4);
    file.root["skins"][0]["joints"] = {1, 0};  // the lower one last
    std::string top = "hip";
    if (below) {
      top = "rig";
      file.root["nodes"].push_back({{"name", top}, {"children", {0}}, {"scale", {2.0, 2.0, 2.0}}});
      file.root["scenes"][0]["nodes"] = {3, 2};
    }
    const Character character = read(file);
    EXPECT_EQ(character.unweighted, (std::vector<std::uint32_t>{8, 9}));
    for (const std::size_t v : {8u, 9u}) {
      const Influences& held = character.influences[v];
      EXPECT_EQ(held.weight[0], 1.0f);
      EXPECT_EQ(
          character.nodes[static_cast<std::size_t>(character.joints[held.joint[0]].node)].name,
          top);
      EXPECT_EQ(character.influences[8].joint, character.influences[9].joint);
    }
  }
}

TEST(GltfReader, ReadsTwoSetsAsEightInfluences) {
  GltfFixture file = strip();
  std::vector<float> first, second;
  std::vector<std::uint16_t> joints;
  for (int v = 0; v < 10; ++v) {
    first.insert(first.end(), {0.25f, 0.0f, 0.0f, 0.0f});
    second.insert(second.end(), {0.0f, 0.0f, 0.0f, 0.75f});
    joints.insert(joints.end(), {0, 0, 0, 1});
  }
  file.attributes()["WEIGHTS_0"] = file.add(first, kFloat, "VEC4", 4);
  file.attributes()["WEIGHTS_1"] = file.add(second, kFloat, "VEC4", 4);
  file.attributes()["JOINTS_1"] = file.add(joints, kUnsignedShort, "VEC4", 4);
  const Character character = read(file);
  EXPECT_TRUE(character.warnings.empty());
  EXPECT_FLOAT_EQ(weight_of(character, 0, "hip"), 0.25f);
  EXPECT_FLOAT_EQ(weight_of(character, 0, "chest"), 0.75f);
}

TEST(GltfReader, KeepsTheEightLargestOfTwelveInfluences) {
  GltfFixture file = strip();
  std::vector<int> joints{0, 1};
  for (int k = 0; k < 10; ++k) {  // ten more joints, all at the hip
    file.root["nodes"].push_back({{"name", "extra_" + std::to_string(k)}});
    file.root["nodes"][0]["children"].push_back(3 + k);
    joints.push_back(3 + k);
  }
  file.root["skins"] = {{{"joints", joints}}};
  for (int set = 0; set < 3; ++set) {
    std::vector<float> weights;
    std::vector<std::uint8_t> numbers;
    for (int v = 0; v < 10; ++v)
      for (int k = 0; k < 4; ++k) {
        weights.push_back(static_cast<float>(4 * set + k + 1) / 78.0f);  // 1 + .. + 12 = 78
        numbers.push_back(static_cast<std::uint8_t>(4 * set + k));
      }
    const std::string number = std::to_string(set);
    file.attributes()["WEIGHTS_" + number] = file.add(weights, kFloat, "VEC4", 4);
    file.attributes()["JOINTS_" + number] = file.add(numbers, kUnsignedByte, "VEC4", 4);
  }
  const Character character = read(file);
  const Warning* cut = warning(character, "influences_cut");
  ASSERT_TRUE(cut);
  EXPECT_NE(cut->message.find("12.8 %"), std::string::npos) << cut->message;  // 10 of 78
  EXPECT_NEAR(character.influences[0].weight[0], 12.0f / 68.0f, 1e-6f);
  EXPECT_NEAR(character.influences[0].weight[7], 5.0f / 68.0f, 1e-6f);
}

TEST(GltfReader, ReadsInterleavedAttributes) {
  GltfFixture file = strip();
  std::vector<float> both;
  for (int v = 0; v < 10; ++v)
    both.insert(both.end(), {static_cast<float>(v % 2) - 0.5f, 0.5f * static_cast<float>(v / 2),
                             0.0f, 0.0f, 0.0f, 1.0f});
  const int view = file.add_view(both);
  file.root["bufferViews"].back()["byteStride"] = 24;
  for (const char* name : {"POSITION", "NORMAL"}) {
    file.root["accessors"].push_back({{"bufferView", view},
                                      {"byteOffset", name[0] == 'P' ? 0 : 12},
                                      {"componentType", kFloat},
                                      {"type", "VEC3"},
                                      {"count", 10}});
    file.attributes()[name] = file.root["accessors"].size() - 1;
  }
  const Character character = read(file);
  expect_strip(character);
  EXPECT_EQ(character.bind_normal[9], glm::vec3(0.0f, 0.0f, 1.0f));
}

json sparse_of(GltfFixture& file) {
  const int indices = file.add_view(std::vector<std::uint8_t>{4, 5});
  const int values = file.add_view(std::vector<float>{-0.5f, 7.0f, 0.0f, 0.5f, 7.0f, 0.0f});
  return {{"count", 2},
          {"indices", {{"bufferView", indices}, {"componentType", kUnsignedByte}}},
          {"values", {{"bufferView", values}}}};
}

TEST(GltfReader, AppliesSparseAccessorsOverTheirBase) {
  GltfFixture file = strip();
  file.root["accessors"][file.attributes()["POSITION"].get<std::size_t>()]["sparse"] =
      sparse_of(file);
  const Character character = read(file);
  EXPECT_EQ(character.bind_position[4], glm::vec3(-0.5f, 7.0f, 0.0f));
  EXPECT_EQ(character.bind_position[5], glm::vec3(0.5f, 7.0f, 0.0f));
  EXPECT_EQ(character.bind_position[6], glm::vec3(-0.5f, 1.5f, 0.0f));
}

template <typename T>
void expect_sparse(int type) {
  GltfFixture file = strip();
  const int indices = file.add_view(std::vector<T>{2, 4, 9});
  const int values = file.add_view(std::vector<float>{7, 1, 2, 8, 3, 4, 9, 5, 6});
  file.root["accessors"][file.attributes()["POSITION"].get<std::size_t>()]["sparse"] = {
      {"count", 3},
      {"indices", {{"bufferView", indices}, {"componentType", type}}},
      {"values", {{"bufferView", values}}}};
  const Character character = read(file);
  EXPECT_EQ(character.bind_position[2], glm::vec3(7, 1, 2));
  EXPECT_EQ(character.bind_position[4], glm::vec3(8, 3, 4));
  EXPECT_EQ(character.bind_position[9], glm::vec3(9, 5, 6));
}

TEST(GltfReader, TakesSparseIndicesOfEverySize) {
  expect_sparse<std::uint8_t>(kUnsignedByte);
  expect_sparse<std::uint16_t>(kUnsignedShort);
  expect_sparse<std::uint32_t>(kUnsignedInt);
}

/// Positions of the strip whose first coordinates are `values`, as `T`s behind each other.
template <typename T>
std::vector<float> read_as(int type, bool normalised, const std::vector<T>& values) {
  GltfFixture file = strip();
  std::vector<T> position;
  for (std::size_t v = 0; v < 10; ++v) {
    position.push_back(values[v % values.size()]);
    position.push_back(static_cast<T>(v));
    position.push_back(static_cast<T>(2 * v));
    if (sizeof(T) < 4) position.push_back(T{0});  // rows start on four bytes
  }
  const std::size_t row = sizeof(T) < 4 ? 4 : 3;
  file.attributes()["POSITION"] = file.add(position, type, "VEC3", row, normalised);
  if (row == 4) file.root["bufferViews"].back()["byteStride"] = 4 * sizeof(T);
  file.root["extensionsRequired"] = {"KHR_mesh_quantization"};
  const Character character = read(file);
  std::vector<float> out;
  for (std::size_t v = 0; v < values.size(); ++v) out.push_back(character.bind_position[v].x);
  return out;
}

// glTF 2.0, 3.11: f = c / 127 for signed bytes, not below -1, and their like.
TEST(GltfReader, DecodesEveryTypeOfNumber) {
  using Floats = std::vector<float>;
  const std::vector<std::int8_t> bytes = {-128, -127, -64, 0, 1, 127};
  EXPECT_EQ(read_as(kByte, false, bytes), (Floats{-128, -127, -64, 0, 1, 127}));
  EXPECT_EQ(read_as(kByte, true, bytes), (Floats{-1, -1, -64 / 127.0f, 0, 1 / 127.0f, 1}));
  const std::vector<std::uint8_t> whole_bytes = {0, 1, 128, 255};
  EXPECT_EQ(read_as(kUnsignedByte, false, whole_bytes), (Floats{0, 1, 128, 255}));
  EXPECT_EQ(read_as(kUnsignedByte, true, whole_bytes), (Floats{0, 1 / 255.0f, 128 / 255.0f, 1}));
  const std::vector<std::int16_t> shorts = {-32768, -32767, -300, 0, 1, 32767};
  EXPECT_EQ(read_as(kShort, false, shorts), (Floats{-32768, -32767, -300, 0, 1, 32767}));
  EXPECT_EQ(read_as(kShort, true, shorts), (Floats{-1, -1, -300 / 32767.0f, 0, 1 / 32767.0f, 1}));
  const std::vector<std::uint16_t> whole_shorts = {0, 1, 258, 65535};
  EXPECT_EQ(read_as(kUnsignedShort, false, whole_shorts), (Floats{0, 1, 258, 65535}));
  EXPECT_EQ(read_as(kUnsignedShort, true, whole_shorts),
            (Floats{0, 1 / 65535.0f, 258 / 65535.0f, 1}));
  EXPECT_EQ(read_as(kFloat, false, Floats{-2.5f, 0.0f, 7.25f}), (Floats{-2.5f, 0.0f, 7.25f}));
}

TEST(GltfReader, TakesAnAccessorWithoutABaseForZeros) {
  GltfFixture file = strip();
  const json sparse = sparse_of(file);
  auto& accessor = file.root["accessors"][file.attributes()["POSITION"].get<std::size_t>()];
  accessor.erase("bufferView");
  accessor["sparse"] = sparse;
  const Character character = read(file);
  EXPECT_EQ(character.bind_position[0], glm::vec3(0.0f));
  EXPECT_EQ(character.bind_position[5], glm::vec3(0.5f, 7.0f, 0.0f));
}

TEST(GltfReader, TakesTheDequantisationFromTheInverseBinds) {
  // Positions / 2 in 16 bits; every inverse bind matrix doubles them, as KHR_mesh_quantization
  // demands of skinned meshes. Node pose and bind pose agree, so this is no odd rest pose.
  GltfFixture file = strip();
  std::vector<std::int16_t> position;
  for (int v = 0; v < 10; ++v) {
    position.push_back(static_cast<std::int16_t>(std::lround(32767 * (0.5 * (v % 2) - 0.25))));
    position.push_back(static_cast<std::int16_t>(std::lround(32767 * (0.25 * (v / 2)))));
    position.push_back(0);
    position.push_back(0);  // rows start on four bytes
  }
  file.attributes()["POSITION"] = file.add(position, kShort, "VEC3", 4, true);
  file.root["bufferViews"].back()["byteStride"] = 8;
  std::vector<float> bind(32, 0.0f);
  for (std::size_t j = 0; j < 2; ++j) {
    for (std::size_t k = 0; k < 3; ++k) bind[16 * j + 5 * k] = 2.0f;
    bind[16 * j + 15] = 1.0f;
  }
  bind[16 + 13] = -1.0f;
  file.root["skins"][0]["inverseBindMatrices"] = file.add(bind, kFloat, "MAT4", 16);
  file.root["extensionsRequired"] = {"KHR_mesh_quantization"};
  const Character character = read(file);
  EXPECT_TRUE(character.warnings.empty());
  expect_strip(character, 2.0f / 32767.0f);
}

TEST(GltfReader, TakesAbsentInverseBindsForIdentities) {
  GltfFixture file = strip();
  file.root["skins"][0].erase("inverseBindMatrices");
  file.root["nodes"][1]["translation"] = {0.0, 0.0, 0.0};
  const Character character = read(file);
  EXPECT_EQ(character.joints[1].joint_from_mesh, glm::dmat4(1.0));
  expect_strip(character);
}

TEST(GltfReader, IgnoresTheNodeOfASkinnedMeshButNotTheAncestorsOfItsJoints) {
  GltfFixture file = strip();
  file.root["nodes"][2]["translation"] = {100.0, 0.0, 0.0};
  file.root["nodes"].push_back(
      {{"name", "up"}, {"translation", {0.0, 5.0, 0.0}}, {"children", {0}}});
  file.root["scenes"][0]["nodes"] = {3, 2};
  const PosedMesh rest = rest_mesh(read(file));
  EXPECT_EQ(rest.position[0], glm::vec3(-0.5f, 5.0f, 0.0f));
}

TEST(GltfReader, HangsMeshesWithoutASkinOnTheirNode) {
  GltfFixture file = strip();
  json prop = file.root["meshes"][0];
  prop["name"] = "hat";
  prop["primitives"][0]["attributes"].erase("JOINTS_0");
  prop["primitives"][0]["attributes"].erase("WEIGHTS_0");
  file.root["meshes"].push_back(prop);
  file.root["nodes"].push_back({{"name", "hat"}, {"mesh", 1}, {"translation", {0.0, 2.0, 0.0}}});
  file.root["nodes"][1]["children"] = {3};
  const Character character = read(file);
  ASSERT_EQ(character.vertex_count(), 20u);
  EXPECT_EQ(character.parts.size(), 2u);
  EXPECT_EQ(weight_of(character, 10, "hat"), 1.0f);
  EXPECT_EQ(rest_mesh(character).position[10], glm::vec3(-0.5f, 3.0f, 0.0f));
}

TEST(GltfReader, MergesSkinsAndSharesTheJointsThatTheyShare) {
  GltfFixture file = strip();
  file.root["skins"].push_back(file.root["skins"][0]);
  file.root["skins"][1]["joints"] = {1, 0};
  file.root["skins"][1].erase("inverseBindMatrices");
  file.root["skins"].push_back(file.root["skins"][0]);
  file.root["nodes"].push_back({{"name", "twin"}, {"mesh", 0}, {"skin", 2}});
  file.root["scenes"][0]["nodes"].push_back(3);
  const Character character = read(file);
  EXPECT_EQ(character.vertex_count(), 20u);
  EXPECT_EQ(character.place_count, 10u);  // the twin stands in the same places
  EXPECT_EQ(character.influences[12].joint, character.influences[2].joint);
}

TEST(GltfReader, ReadsOneVertexBufferOnceForPrimitivesThatShareIt) {
  GltfFixture file = strip();
  auto& primitives = file.root["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);
  const Character character = read(file);
  EXPECT_EQ(character.vertex_count(), 10u);
  ASSERT_EQ(character.parts.size(), 2u);
  EXPECT_EQ(character.parts[1].first_vertex, 0u);
  EXPECT_EQ(character.parts[1].first_triangle, 8u);
  EXPECT_EQ(character.triangles[8], character.triangles[0]);
}

TEST(GltfReader, UnrollsStripsAndFans) {
  for (const int mode : {5, 6}) {
    GltfFixture file = strip();
    file.root["meshes"][0]["primitives"][0]["mode"] = mode;
    file.root["meshes"][0]["primitives"][0]["indices"] =
        file.add(std::vector<std::uint8_t>{0, 1, 2, 3}, kUnsignedByte, "SCALAR", 1);
    const Character character = read(file);
    ASSERT_EQ(character.triangles.size(), 2u);
    // glTF 2.0, 3.7.2.1: strip p_i = (v_i, v_i+(1+i%2), v_i+(2-i%2)); fan (v_i+1, v_i+2, v_0).
    const glm::uvec3 first = mode == 5 ? glm::uvec3(0, 1, 2) : glm::uvec3(1, 2, 0);
    const glm::uvec3 second = mode == 5 ? glm::uvec3(1, 3, 2) : glm::uvec3(2, 3, 0);
    EXPECT_EQ(character.triangles[0], first);
    EXPECT_EQ(character.triangles[1], second);
    file.root["meshes"][0]["primitives"][0]["indices"] =
        file.add(std::vector<std::uint8_t>{4, 1, 2}, kUnsignedByte, "SCALAR", 1);
    EXPECT_EQ(read(file).triangles,
              std::vector{mode == 5 ? glm::uvec3(4, 1, 2) : glm::uvec3(1, 2, 4)});
  }
}

// A list, a strip, a fan and lines on vertex buffers of their own, a buffer shared by two, some
// with texture coordinates and some without; under a root that mirrors, and one that does not.
TEST(GltfReader, PutsPrimitivesOfEveryKindBehindEachOther) {
  for (const bool mirrored : {false, true}) {
    GltfFixture file = strip();
    const json base = file.root["meshes"][0]["primitives"][0];
    const auto copy_of = [&](std::size_t vertices, float aside) {
      std::vector<float> position, normal, weights;
      std::vector<std::uint8_t> joints;
      for (std::size_t v = 0; v < vertices; ++v) {
        position.insert(position.end(), {aside + 0.1f * static_cast<float>(v * v),
                                         0.2f * static_cast<float>(v), aside});
        normal.insert(normal.end(), {0.0f, 0.6f, 0.8f});
        weights.insert(weights.end(), {0.25f, 0.75f, 0.0f, 0.0f});
        joints.insert(joints.end(), {0, 1, 0, 0});
      }
      json out;
      out["attributes"] = {{"POSITION", file.add(position, kFloat, "VEC3", 3)},
                           {"NORMAL", file.add(normal, kFloat, "VEC3", 3)},
                           {"WEIGHTS_0", file.add(weights, kFloat, "VEC4", 4)},
                           {"JOINTS_0", file.add(joints, kUnsignedByte, "VEC4", 4)}};
      return out;
    };
    json fan = copy_of(6, 3.0f), band = copy_of(5, 4.0f), lines = copy_of(4, 5.0f);
    fan["mode"] = 6;
    fan["indices"] =
        file.add(std::vector<std::uint16_t>{5, 0, 2, 1, 4}, kUnsignedShort, "SCALAR", 1);
    band["mode"] = 5;  // without indices: its vertices in order
    std::vector<float> uv;
    for (int v = 0; v < 5; ++v) uv.insert(uv.end(), {0.25f * static_cast<float>(v), 0.5f});
    band["attributes"]["TEXCOORD_0"] = file.add(uv, kFloat, "VEC2", 2);
    lines["mode"] = 1;
    json again = fan;
    again["mode"] = 4;
    again["indices"] = file.add(std::vector<std::uint8_t>{3, 4, 5}, kUnsignedByte, "SCALAR", 1);
    json bare = base;
    bare["attributes"].erase("TEXCOORD_0");
    file.root["meshes"][0]["primitives"] = {fan, bare, lines, band, again};
    if (mirrored) {
      file.root["nodes"].push_back({{"scale", {-1.0, 1.0, 1.0}}, {"children", {0}}});
      file.root["scenes"][0]["nodes"] = {3, 2};
    }
    const Character character = read(file);
    EXPECT_TRUE(warning(character, "not_triangles"));
    const struct {
      const char* name;
      std::uint32_t first_triangle, triangles, first_vertex, vertices;
    } parts[] = {{"strip.0", 0, 3, 0, 6},
                 {"strip.1", 3, 8, 6, 10},
                 {"strip.3", 11, 3, 16, 5},
                 {"strip.4", 14, 1, 0, 6}};
    ASSERT_EQ(character.parts.size(), std::size(parts));
    for (std::size_t p = 0; p < std::size(parts); ++p) {
      EXPECT_EQ(character.parts[p].name, parts[p].name);
      EXPECT_EQ(character.parts[p].first_triangle, parts[p].first_triangle) << p;
      EXPECT_EQ(character.parts[p].triangle_count, parts[p].triangles) << p;
      EXPECT_EQ(character.parts[p].first_vertex, parts[p].first_vertex) << p;
      EXPECT_EQ(character.parts[p].vertex_count, parts[p].vertices) << p;
    }
    std::vector<glm::uvec3> expected = {{0, 2, 5}, {2, 1, 5}, {1, 4, 5}};
    for (std::uint32_t row = 0; row < 4; ++row) {
      const std::uint32_t a = 6 + 2 * row;
      expected.emplace_back(a, a + 1, a + 2);
      expected.emplace_back(a + 2, a + 1, a + 3);
    }
    expected.insert(expected.end(), {{16, 17, 18}, {17, 19, 18}, {18, 19, 20}, {3, 4, 5}});
    if (mirrored)
      for (glm::uvec3& t : expected) std::swap(t.y, t.z);
    EXPECT_EQ(character.triangles, expected);
    ASSERT_EQ(character.vertex_count(), 21u);
    ASSERT_EQ(character.uv.size(), 21u);
    for (std::size_t v = 0; v < 21; ++v) {
      const auto k = static_cast<float>(v) - 16.0f;
      EXPECT_EQ(character.uv[v], v < 16 ? glm::vec2(0.0f) : glm::vec2(0.25f * k, 0.5f)) << v;
      const float x = v < 6 ? 3.0f + 0.1f * static_cast<float>(v * v) : 4.0f + 0.1f * k * k;
      if (v < 6 || v >= 16) {
        EXPECT_FLOAT_EQ(character.bind_position[v].x, x) << v;
        EXPECT_EQ(character.bind_normal[v], glm::vec3(0.0f, 0.6f, 0.8f));
        EXPECT_EQ(weight_of(character, v, "chest"), 0.75f);
      }
    }
  }
}

TEST(GltfReader, WindsTrianglesOutwardsUnderAMirroringRoot) {
  for (const double size : {-1.0, -0.3, 0.3, 3.0}) {
    GltfFixture file = strip();
    file.root["nodes"].push_back({{"name", "rigid"}, {"mesh", 0}});
    file.root["nodes"].push_back({{"scale", {size, 0.5, 1.0}}, {"children", {0, 2, 3}}});
    file.root["scenes"][0]["nodes"] = {4};
    const Character character = read(file);
    ASSERT_EQ(character.triangles.size(), 16u);
    const PosedMesh rest = rest_mesh(character);
    for (const glm::uvec3& t : character.triangles) {
      const glm::vec3 face = glm::cross(rest.position[t.y] - rest.position[t.x],
                                        rest.position[t.z] - rest.position[t.x]);
      EXPECT_GT(glm::dot(face, rest.normal[t.x]), 0.0f) << size << " " << t.x;
    }
  }
}

TEST(GltfReader, AppliesMorphTargetsWithTheNodesWeightsBeforeTheMeshs) {
  GltfFixture file = strip();
  std::vector<float> delta;
  for (int v = 0; v < 10; ++v) delta.insert(delta.end(), {0.0f, 0.0f, 1.0f});
  const int target = file.add(delta, kFloat, "VEC3", 3);
  file.root["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", target}}};
  EXPECT_EQ(read(file).bind_position[0].z, 0.0f);  // no weights: 0
  file.root["meshes"][0]["weights"] = {0.5};
  const Character by_mesh = read(file);
  EXPECT_EQ(by_mesh.bind_position[0].z, 0.5f);
  EXPECT_TRUE(warning(by_mesh, "morphs_applied"));
  file.root["nodes"][2]["weights"] = {0.25};
  EXPECT_EQ(read(file).bind_position[0].z, 0.25f);
}

TEST(GltfReader, ComputesNormalsThatAreMissing) {
  GltfFixture file = strip();
  file.attributes().erase("NORMAL");
  const Character character = read(file);
  EXPECT_TRUE(warning(character, "normals_computed"));
  for (const glm::vec3& n : character.bind_normal) EXPECT_EQ(n, glm::vec3(0.0f, 0.0f, 1.0f));
}

TEST(GltfReader, WeldsVerticesThatStandAtOnePlaceWhateverTheirWeights) {
  GltfFixture file = strip();
  std::vector<float> position;
  for (int v = 0; v < 10; ++v)  // rows 2 and 3 on one another
    position.insert(position.end(), {static_cast<float>(v % 2) - 0.5f,
                                     v / 2 == 3 ? 1.0f : 0.5f * static_cast<float>(v / 2), 0.0f});
  file.attributes()["POSITION"] = file.add(position, kFloat, "VEC3", 3);
  const Character character = read(file);
  EXPECT_EQ(character.place_count, 8u);
  EXPECT_EQ(character.place[6], character.place[4]);
  EXPECT_NE(character.place[5], character.place[4]);
}

TEST(GltfReader, TakesTheBindPoseForTheRestWhenTheNodesHoldAnother) {
  // The chest turned a quarter about X in the nodes: the upper rows lean out of the plane there.
  GltfFixture file = strip();
  file.root["nodes"][1]["rotation"] = {std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5)};
  const Character character = read(file);
  EXPECT_TRUE(warning(character, "rest_is_bind_pose"));
  expect_strip(character, 1e-6f);
}

TEST(GltfReader, KeepsTheNodePoseWhereTheBindsDescribeNoSkeleton) {
  GltfFixture file = strip();
  std::vector<float> bind(32, 0.0f);
  for (std::size_t k = 0; k < 8; ++k) bind[16 * (k / 4) + 5 * (k % 4)] = 1.0f;
  bind[16 + 13] = -3.0f;  // a chest three units up: three times the nodes' bone
  file.root["skins"][0]["inverseBindMatrices"] = file.add(bind, kFloat, "MAT4", 16);
  const Character character = read(file);
  EXPECT_TRUE(warning(character, "bind_pose_unusable"));
  EXPECT_EQ(character.nodes[1].world_from_node[3], glm::dvec4(0.0, 1.0, 0.0, 1.0));
}

TEST(GltfReader, NamesNodesWithoutANameByTheirNumber) {
  GltfFixture file = strip();
  file.root["nodes"][1].erase("name");
  EXPECT_EQ(read(file).nodes[1].name, "#1");
}

TEST(GltfReader, SetsParentsBeforeChildrenWhateverTheFilesOrder) {
  GltfFixture file = strip();
  file.root["nodes"][0] = {{"name", "chest"}, {"translation", {0.0, 1.0, 0.0}}};
  file.root["nodes"][1] = {{"name", "hip"}, {"children", {0}}};
  file.root["scenes"][0]["nodes"] = {1, 2};
  file.root["skins"][0]["joints"] = {1, 0};
  const Character character = read(file);
  EXPECT_EQ(character.nodes[0].name, "hip");
  EXPECT_EQ(character.nodes[1].parent, 0);
  expect_strip(character);
}

TEST(GltfReader, FollowsPercentEncodedUrisAndDataUris) {
  const TemporaryFolder folder;
  GltfFixture file = strip();
  write_file(folder / "my body.bin", file.buffer);
  expect_strip(read_character(file.write_gltf(folder, "my%20body.bin")));

  const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<std::uint8_t> bytes = file.buffer;
  while (bytes.size() % 3 != 0) bytes.push_back(0);
  std::string base64;
  for (std::size_t k = 0; k < bytes.size(); k += 3) {
    const unsigned three = static_cast<unsigned>(bytes[k] << 16 | bytes[k + 1] << 8 | bytes[k + 2]);
    for (int shift = 18; shift >= 0; shift -= 6) base64 += digits[three >> shift & 63];
  }
  file.root["buffers"] = {
      {{"byteLength", bytes.size()}, {"uri", "data:application/octet-stream;base64," + base64}}};
  expect_strip(read_character(file.write_gltf(folder)));
}

TEST(GltfReader, HashesEveryByteItRead) {
  const TemporaryFolder folder;
  GltfFixture file = strip();
  const Character first = read_character(file.write_gltf(folder));
  const Character again = read_character(file.write_gltf(folder));
  EXPECT_EQ(first.content_hash_low, again.content_hash_low);
  EXPECT_EQ(first.content_hash_high, again.content_hash_high);
  file.buffer[0] ^= 1;  // in the external buffer only
  const Character other = read_character(file.write_gltf(folder));
  EXPECT_NE(first.content_hash_low, other.content_hash_low);
}

TEST(GltfReader, ReadsMaterialsAndKeepsPicturesEncoded) {
  GltfFixture file = strip();
  const int picture = file.add_view(std::vector<std::uint8_t>{0x89, 'P', 'N', 'G', 1, 2, 3, 4});
  file.root["images"] = {{{"bufferView", picture}, {"mimeType", "image/png"}, {"name", "skin"}},
                         {{"uri", "absent.png"}}};
  file.root["textures"] = {{{"source", 0}}, {{"source", 1}}, {{"source", 9}}};
  file.root["materials"] = {{{"name", "skin"},
                             {"doubleSided", true},
                             {"normalTexture", {{"index", 2}}},
                             {"pbrMetallicRoughness",
                              {{"baseColorFactor", {0.1, 0.2, 0.3, 1.0}},
                               {"roughnessFactor", 0.25},
                               {"metallicFactor", 0.0},
                               {"baseColorTexture", {{"index", 0}}}}}}};
  file.root["meshes"][0]["primitives"][0]["material"] = 0;
  const Character character = read(file);
  const Material& material = character.materials.at(0);
  EXPECT_EQ(material.base_color, glm::vec4(0.1f, 0.2f, 0.3f, 1.0f));
  EXPECT_EQ(material.roughness, 0.25f);
  EXPECT_TRUE(material.double_sided);
  EXPECT_EQ(material.base_color_image, 0);
  EXPECT_EQ(material.normal_image, -1);
  EXPECT_EQ(character.images.at(0).bytes.size(), 8u);
  EXPECT_EQ(character.images.at(0).bytes[1], 'P');
  EXPECT_TRUE(warning(character, "image_missing"));
}

TEST(GltfReader, KeepsMaterialsWithinTheirRangesAndPicturesWithinTheFile) {
  GltfFixture file = strip();
  const int picture = file.add_view(std::vector<std::uint8_t>{0x89, 'P', 'N', 'G', 1, 2, 3, 4});
  const json image = {{"bufferView", picture}, {"mimeType", "image/png"}};
  file.root["images"] = {image, image};
  const json webp = {{"extensions", {{"EXT_texture_webp", {{"source", 1}}}}}};
  file.root["textures"] = {{{"source", 1}}, {{"source", 2}}, webp};
  file.root["materials"] = {{{"emissiveFactor", {0.25, 2.0, -1.0}},
                             {"normalTexture", {{"index", 3}}},
                             {"pbrMetallicRoughness",
                              {{"baseColorFactor", {-0.5, 0.75, 1.5, 0.125}},
                               {"roughnessFactor", -3},
                               {"metallicFactor", 7.0},
                               {"baseColorTexture", {{"index", 2}}},
                               {"metallicRoughnessTexture", {{"index", 0}}}}}},
                            {{"normalTexture", {{"index", 1}}}}};
  const Character character = read(file);
  ASSERT_EQ(character.materials.size(), 3u);
  const Material& first = character.materials[0];
  EXPECT_EQ(first.name, "material_0");
  EXPECT_EQ(first.base_color, glm::vec4(0.0f, 0.75f, 1.0f, 0.125f));
  EXPECT_EQ(first.emissive, glm::vec3(0.25f, 1.0f, 0.0f));
  EXPECT_EQ(first.roughness, 0.0f);
  EXPECT_EQ(first.metallic, 1.0f);
  EXPECT_EQ(first.base_color_image, 1);
  EXPECT_EQ(first.metallic_roughness_image, 1);
  EXPECT_EQ(first.normal_image, -1);  // the file has three textures
  EXPECT_FALSE(first.double_sided);
  const Material& second = character.materials[1];  // the standard's defaults
  EXPECT_EQ(second.name, "material_1");
  EXPECT_EQ(second.base_color, glm::vec4(1.0f));
  EXPECT_EQ(second.emissive, glm::vec3(0.0f));
  EXPECT_EQ(second.roughness, 1.0f);
  EXPECT_EQ(second.metallic, 1.0f);
  EXPECT_EQ(second.base_color_image, -1);
  EXPECT_EQ(second.normal_image, -1);         // and two pictures
  EXPECT_EQ(character.parts[0].material, 2);  // it names none: ours
  EXPECT_EQ(character.materials[2].name, "default");
}

}  // namespace
}  // namespace backbend::skin
