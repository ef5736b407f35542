#include "skin/weights/inspect.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>

#include "skin/gltf/gltf_reader.h"
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
  EXPECT_EQ(root["chest"], "spine_2");
  EXPECT_EQ(root["arms"]["left"], json({"clavicle.L", "arm.L", "hand.L"}));
  EXPECT_EQ(root["arms"]["right"][0], "clavicle.R");
  EXPECT_EQ(root["legs"]["left"][0], "thigh.L");
  EXPECT_EQ(root["driven"]["joints"].size(), 3u);
  EXPECT_EQ(root["driven"]["end"], "spine_2");
  EXPECT_EQ(root["driven"]["why"], "chest: 'spine_2', which both arms hang from");
  EXPECT_EQ(root["left"], json({1.0, 0.0, 0.0}));
  EXPECT_EQ(root["up"], json({0.0, 1.0, 0.0}));
  EXPECT_EQ(root["forward"], json({0.0, 0.0, 1.0}));
  EXPECT_EQ(root["driven"]["arms_follow"], "chest");
  EXPECT_NEAR(root["driven"]["joints"][1]["fraction"].get<double>(), 0.5, 1e-12);
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

/// The stick figure with a tail, ten helpers, a loose foot, a prop that nothing moves, and weights
/// that are wrong in every way that is looked for.
Character dirty_figure() {
  Character character = stick_figure();
  const auto add = [&](const std::string& name, const char* parent, const glm::dvec3& at) {
    stick_vertex(character, add_node(character, name, stick_node(character, parent), at));
  };
  add("tail_1", "hips", {0.0, 0.9, -0.2});
  add("tail_2", "tail_1", {0.0, 0.9, -0.5});
  for (int k = 1; k <= 10; ++k)
    add("fix_" + std::to_string(k), "spine_1", {0.05, 1.0 + 0.01 * k, 0.04});
  add("toe.L", "scene", {0.1, 0.04, 0.02});
  add("prop", "scene", {2.0, 0.5, 0.0});
  const auto joint_of = [&](const char* name) {
    const int node = stick_node(character, name);
    return static_cast<std::uint16_t>(std::ranges::find(character.joints, node, &SkinJoint::node) -
                                      character.joints.begin());
  };
  const auto vertex_of = [&](const char* name) { return std::size_t{3} * joint_of(name); };
  Influences& long_list = character.influences[vertex_of("spine_2")];
  long_list.joint = {joint_of("spine_2"), joint_of("hips"), joint_of("neck"), joint_of("head"),
                     joint_of("spine_1")};
  long_list.weight = {0.5f, 0.25f, 0.125f, 0.1171875f, 0.0078125f};
  Influences& one_sided = character.influences[vertex_of("hand.L") + 1];
  one_sided.joint[1] = joint_of("arm.L");
  one_sided.weight = {0.75f, 0.25f};
  // Seven helpers on both ends of a strip from the hand to the arm, of which its middle knows
  // nothing.
  const std::size_t hand = vertex_of("hand.R"), arm = vertex_of("arm.R");
  character.triangles.emplace_back(hand, hand + 1, arm);
  character.influences[hand + 2].weight[0] = 0.3f;
  character.influences[arm + 1].weight[0] = 0.482f;
  for (std::uint16_t k = 1; k <= 7; ++k) {
    const auto fix = static_cast<std::uint16_t>(joint_of("fix_1") + k - 1);
    character.influences[hand + 2].joint[k] = character.influences[arm + 1].joint[k] = fix;
    character.influences[hand + 2].weight[k] = 0.1f;
    character.influences[arm + 1].weight[k] = 0.05f + 0.006f * static_cast<float>(k);
  }
  character.unweighted = {static_cast<std::uint32_t>(vertex_of("foot.R"))};
  character.renormalised_vertices = 1210;
  character.worst_weight_sum = 0.875;
  character.warnings.push_back({"weights_renormalised", "as told"});
  Part body;
  body.name = "body";
  body.vertex_count = static_cast<std::uint32_t>(character.vertex_count());
  body.triangle_count = static_cast<std::uint32_t>(character.triangles.size());
  character.parts.push_back(body);
  character.materials.emplace_back();
  character.materials.back().name = "clay";
  return character;
}

TEST(Inspect, SaysAllOfADirtyFigure) {
  const Character character = dirty_figure();
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_EQ(inspect_text(character, anatomy), R"(stick.glb
  body     1 part, 93 vertices at 93 places, 32 triangles, 31 joints
  size     height 1.48, spine 0.3333 (reference length), in the file's unit
  axes     up +Y, faces +Z, its left +X
  spine    hips > spine_1 > spine_2 > neck > head   sure
  chest    spine_2
  arms     clavicle.L > arm.L > hand.L
           clavicle.R > arm.R > hand.R
  legs     thigh.L > shin.L > foot.L
           thigh.R > shin.R > foot.R
  tail     tail_1 > tail_2
  why      head: 'head' by its name
           hips: 'hips' by its name
           up +Y: away from the feet
           faces +Z: left and right by the joints' names
           arms: 'clavicle.L' and 'clavicle.R' by their names
           chest: 'spine_2', which both arms hang from
           loose joint 'toe.L' goes with 'foot.L', which it touches
  driven   by arc fraction: hips 0, spine_1 0.5, spine_2 1
           arms go with the chest, which they hang from
           10 helper joints, 76.9 % of torso weight, that go with their parents: fix_1, fix_2, fix_3, fix_4, fix_5, fix_6, fix_7, fix_8 and 2 more
           1 joint, 3.2 % of all weight, that nothing moves: prop
  weights  vertices moved 88 by 1, 1 by 2, 1 by 5, 2 by 8 joints
           sums: 1 210 vertices off, worst 0.875
           unweighted: 1, tiny (below 0.01): 1, more than 4 joints: 3
           symmetry: 40.9 % of places have a mirror image, 6 of them weighted differently by over 5 % (worst 70 %, vertex 23)
           on the other side: none
           far from its area: none
           left against right: none
           out of order along the spine: none
           off their bones along the spine: none
           different at one place: none
           hard border between vertebrae: not applicable, of 0 borders between joints of the spine 0 are soft, 2 and most are needed
           bleed: fix_7 weighs 1 place apart from its area (largest 0.092, vertex 37)
           bleed: fix_6 weighs 1 place apart from its area (largest 0.086, vertex 37)
           bleed: fix_5 weighs 1 place apart from its area (largest 0.08, vertex 37)
           bleed: fix_4 weighs 1 place apart from its area (largest 0.074, vertex 37)
           bleed: fix_3 weighs 1 place apart from its area (largest 0.068, vertex 37)
           bleed: fix_2 weighs 1 place apart from its area (largest 0.062, vertex 37)
           bleed: 1 joint more, see --json
  warning  weights_renormalised: as told
  skeleton (weight in vertices)
    scene  (no joint)
      hips  [hips]  3.3
        spine_1  [spine]  3
          spine_2  [chest]  2.5
            neck  [spine]  3.1
              head  [head]  3.1
            clavicle.L  [arm L]  3
              arm.L  [arm L]  3.3
                hand.L  [arm L]  2.8
            clavicle.R  [arm R]  3
              arm.R  [arm R]  2.5
                hand.R  [arm R]  2.3
          fix_1  3.2
          fix_2  3.2
          fix_3  3.2
          fix_4  3.2
          fix_5  3.2
          fix_6  3.2
          fix_7  3.2
          fix_8  3
          fix_9  3
          fix_10  3
        thigh.L  [leg L]  3
          shin.L  [leg L]  3
            foot.L  [leg L]  3
        thigh.R  [leg R]  3
          shin.R  [leg R]  3
            foot.R  [leg R]  2
        tail_1  [tail]  3
          tail_2  [tail]  3
      toe.L  3
      prop  3)");
  const json root = json::parse(inspect_json(character, anatomy));
  EXPECT_EQ(root["weights"],
            json::parse(
                R"({"bleed":[{"joint":"fix_1","largest":0.0560000017285347,"places":1,"vertex":37},
{"joint":"fix_2","largest":0.06199999898672104,"places":1,"vertex":37},{"joint":"fix_3",
"largest":0.06800000369548798,"places":1,"vertex":37},{"joint":"fix_4",
"largest":0.07400000095367432,"places":1,"vertex":37},{"joint":"fix_5",
"largest":0.07999999821186066,"places":1,"vertex":37},{"joint":"fix_6",
"largest":0.085999995470047,"places":1,"vertex":37},{"joint":"fix_7",
"largest":0.09200000017881393,"places":1,"vertex":37}],"faults":{"asymmetry":{"joints":0,"worst":[]},"bind_off":[],
"borders":{"not_applicable":"of 0 borders between joints of the spine 0 are soft, 2 and most are needed"},
"far":{"joints":0,"worst":[]},"levels":{"joints":0,"worst":[]},
"order":{"joints":0,"worst":[]},"seams":{"joints":0,"worst":[]},
"wrong_side":{"joints":0,"worst":[]}},"more_than_four":3,
"most_influences":8,"off_sum":1210,"symmetry":{"asymmetric_places":6,
"mirrored_share":0.40860215053763443,"worst":0.6999999992549419,"worst_vertex":23},"tiny":1,
"tiny_below":0.009999999776482582,"unweighted":1,"vertices_by_influences":[1,88,1,0,0,1,0,0,
2],"worst_sum":0.875})"));
  EXPECT_EQ(root["driven"], json::parse(R"({"arms_follow":"chest","end":"spine_2",
"why":"chest: 'spine_2', which both arms hang from","followers":[{"goes_with":"foot.L","joint":"toe.L"}],
"helper_torso_share":0.7692307692307692,"helpers":["fix_1","fix_2","fix_3","fix_4","fix_5",
"fix_6","fix_7","fix_8","fix_9","fix_10"],"joints":[{"fraction":0.0,"name":"hips"},
{"fraction":0.49999999999999983,"name":"spine_1"},{"fraction":1.0,"name":"spine_2"}],"unreached":["prop"],
"unreached_share":0.0322580645109604})"));
  EXPECT_EQ(root["meshes"],
            json::parse(R"([{"material":"clay","name":"body","triangles":32,"vertices":93}])"));
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
