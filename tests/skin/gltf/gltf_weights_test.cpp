#include "skin/gltf/gltf_weights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "skin/gltf/gltf_reader.h"
#include "skin/weights/weight_export.h"
#include "tests/skin/gltf_fixture.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;
using Bytes = std::vector<std::uint8_t>;

class GltfWeights : public testing::Test {
 protected:
  Bytes bytes_of(const std::filesystem::path& file) const {
    std::ifstream in(file, std::ios::binary);
    return Bytes(std::istreambuf_iterator<char>(in), {});
  }
  /// The file with vertex 4 at 3 parts chest and 1 part hip.
  Bytes changed(const std::filesystem::path& file) const {
    const GltfDocument document = load_gltf(file);
    const WeightedGltf from = read_weighted(document);
    std::vector<Influences> influences = from.character.influences;
    influences[4] = vertex_;
    std::vector<bool> which(influences.size(), false);
    which[4] = true;
    return encode_with_weights(document, from, influences, which);
  }
  Character read_back(const Bytes& glb) const {
    return read_character(load_gltf({"changed.glb", glb, glb}));
  }
  /// All but vertex 4 is as in the file, and that is as asked.
  void expect_one_changed(const std::filesystem::path& file, const Bytes& glb, float slack) const {
    const Character old = read_character(file), now = read_back(glb);
    ASSERT_EQ(old.vertex_count(), now.vertex_count());
    for (Index v = 0; v < old.vertex_count(); ++v) {
      EXPECT_EQ(old.bind_position[v], now.bind_position[v]);
      const Influences& expected = v == 4 ? vertex_ : old.influences[v];
      for (Index k = 0; k < 2; ++k) {
        EXPECT_EQ(now.influences[v].joint[k], expected.joint[k]) << v;
        EXPECT_NEAR(now.influences[v].weight[k], expected.weight[k], slack) << v;
      }
    }
    EXPECT_EQ(now.renormalised_vertices, 0u);
  }

  TemporaryFolder folder_;
  Influences vertex_{{1, 0}, {0.75f, 0.25f}};
};

TEST_F(GltfWeights, ChangesNoByteOutsideTheVerticesThatChange) {
  const GltfFixture fixture = strip();
  const auto file = fixture.write_glb(folder_);
  const Bytes before = bytes_of(file), after = changed(file);
  expect_one_changed(file, after, 1e-7f);
  ASSERT_EQ(before.size(), after.size());
  const Index binary = before.size() - fixture.buffer.size();
  std::vector<std::pair<Index, Index>> ours;
  for (const char* name : {"JOINTS_0", "WEIGHTS_0"}) {
    const auto& attributes = fixture.root["meshes"][0]["primitives"][0]["attributes"];
    const auto& accessor = fixture.root["accessors"][attributes[name].get<Index>()];
    const auto& view = fixture.root["bufferViews"][accessor["bufferView"].get<Index>()];
    const Index element = view["byteLength"].get<Index>() / accessor["count"].get<Index>();
    const Index first = binary + view["byteOffset"].get<Index>() + 4 * element;
    ours.emplace_back(first, first + element);
  }
  Index differing = 0;
  for (Index i = 0; i < before.size(); ++i) {
    if (before[i] == after[i]) continue;
    ++differing;
    EXPECT_TRUE(std::ranges::any_of(
        ours, [&](const auto& range) { return i >= range.first && i < range.second; }))
        << "byte " << i;
  }
  EXPECT_GT(differing, 0u);
}

TEST_F(GltfWeights, KeepsEightBitWeightsAndTheirSumOf255) {
  GltfFixture fixture = strip();
  const Character as_float = read_character(fixture.write_glb(folder_, "float.glb"));
  std::vector<std::uint8_t> weights;
  for (const Influences& each : as_float.influences) {
    std::uint8_t of_joint[2] = {};
    for (Index k = 0; k < 2; ++k)
      of_joint[each.joint[k]] += static_cast<std::uint8_t>(each.weight[k] * 255.0f);
    of_joint[0] = static_cast<std::uint8_t>(255 - of_joint[1]);
    weights.insert(weights.end(), {of_joint[0], of_joint[1], 0, 0});
  }
  fixture.attributes()["WEIGHTS_0"] = fixture.add(weights, kUnsignedByte, "VEC4", 4, true);
  const auto file = fixture.write_glb(folder_);
  const Bytes after = changed(file);
  EXPECT_EQ(after.size(), bytes_of(file).size());
  expect_one_changed(file, after, 0.5f / 255.0f);
}

TEST_F(GltfWeights, MakesOneGlbOfAGltfAndItsBuffer) {
  const auto file = strip().write_gltf(folder_);
  const Bytes after = changed(file);
  ASSERT_GE(after.size(), 4u);
  EXPECT_EQ(std::string(after.begin(), after.begin() + 4), "glTF");
  expect_one_changed(file, after, 1e-7f);
}

TEST_F(GltfWeights, GivesSparseWeightsBytesOfTheirOwn) {
  GltfFixture fixture = strip();
  const int accessor = fixture.attributes()["WEIGHTS_0"];
  const int indices = fixture.add_view(std::vector<std::uint16_t>{0, 7});
  const int values =
      fixture.add_view(std::vector<float>{0.5f, 0.5f, 0.0f, 0.0f, 0.25f, 0.75f, 0.0f, 0.0f});
  fixture.root["accessors"][static_cast<Index>(accessor)]["sparse"] = {
      {"count", 2},
      {"indices", {{"bufferView", indices}, {"componentType", kUnsignedShort}}},
      {"values", {{"bufferView", values}}}};
  const auto file = fixture.write_glb(folder_);
  expect_one_changed(file, changed(file), 1e-7f);
}

TEST_F(GltfWeights, RefusesCompressedMeshes) {
  GltfFixture fixture = strip();
  fixture.root["extensionsUsed"] = {"EXT_meshopt_compression"};
  const auto file = fixture.write_glb(folder_);
  EXPECT_THROW(changed(file), CharacterError);
}

TEST_F(GltfWeights, RefusesWeightsWhoseBytesSomethingElseUses) {
  GltfFixture fixture = strip();
  const int weights = fixture.attributes()["WEIGHTS_0"];
  fixture.root["accessors"].push_back(fixture.root["accessors"][static_cast<Index>(weights)]);
  fixture.attributes()["COLOR_0"] = fixture.root["accessors"].size() - 1;
  const auto file = fixture.write_glb(folder_);
  EXPECT_THROW(changed(file), CharacterError);
}

TEST_F(GltfWeights, NamesVerticesWhoseSumsAreOff) {
  GltfFixture fixture = strip();
  std::vector<float> weights;
  for (int v = 0; v < 10; ++v) {
    const float sum = v == 3 || v == 8 ? 0.9f : 1.0f;
    weights.insert(weights.end(), {0.5f * sum, 0.5f * sum, 0.0f, 0.0f});
  }
  fixture.attributes()["WEIGHTS_0"] = fixture.add(weights, kFloat, "VEC4", 4);
  const WeightedGltf read = read_weighted(load_gltf(fixture.write_glb(folder_)));
  EXPECT_EQ(read.off_sum, (std::vector<std::uint32_t>{3, 8}));
  ASSERT_EQ(read.sources.size(), 1u);
  EXPECT_EQ(read.sources[0].vertex_count, 10u);
}

// What other programs are given.

TEST_F(GltfWeights, MayaAndJsonHoldEveryVertexAndBlenderTheChangedOnes) {
  GltfFixture fixture = strip();
  fixture.root["nodes"][0]["name"] = "hip <a> & \"b\"";
  Character character = read_character(fixture.write_glb(folder_));
  std::vector<bool> which(character.vertex_count(), false);
  which[4] = true;
  character.influences[4] = vertex_;
  const WeightExport from{character, character.influences, which};

  const std::string xml = maya_weights_xml(from);
  EXPECT_NE(xml.find("source=\"hip &lt;a&gt; &amp; &quot;b&quot;\""), std::string::npos) << xml;
  EXPECT_NE(xml.find("<point index=\"4\" value=\"0.750000\"/>"), std::string::npos);
  EXPECT_NE(xml.find("size=\"10\" max=\"10\">"), std::string::npos);

  const auto json = nlohmann::json::parse(weights_json(from));
  EXPECT_EQ(json["schema"], "backbend.weights/1");
  const auto& mesh = json["objDDic"][0];
  EXPECT_EQ(mesh["vertexCount"], 10);
  EXPECT_EQ(mesh["changed"], nlohmann::json({4}));
  std::vector<double> sum(10, 0.0);
  for (const auto& [joint, weights] : mesh["weights"].items())
    for (const auto& [vertex, weight] : weights.items())
      sum[static_cast<Index>(std::stoi(vertex))] += weight.get<double>();
  for (const double each : sum) EXPECT_NEAR(each, 1.0, 2e-6);
  EXPECT_NEAR(mesh["weights"]["chest"]["4"].get<double>(), 0.75, 1e-6);

  const std::string script = blender_weights_script(from);
  EXPECT_NE(script.find("[[4,["), std::string::npos) << "only vertex 4";
  EXPECT_EQ(script.find("[5,["), std::string::npos);
}

}  // namespace
}  // namespace backbend::skin
