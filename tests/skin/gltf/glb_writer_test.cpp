#include "skin/gltf/glb_writer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <limits>
#include <nlohmann/json.hpp>

#include "skin/deform/skinning.h"
#include "skin/gltf/gltf_reader.h"
#include "skin/gltf/rigid_parts.h"
#include "skin/gltf/skin_layout.h"
#include "tests/skin/gltf_fixture.h"

namespace backbend::skin {
namespace {

using glm::dmat4;
using glm::dvec3;
using nlohmann::json;

const dmat4 kOne(1.0);

/// A strip of two quads on a chain of three turned and scaled nodes under a bare root.
Character strip_character() {
  Character c;
  c.name = "strip";
  c.file_name = "strip.test";
  const auto add_node = [&c](const char* name, int parent, const dmat4& local) {
    Node node;
    node.name = name;
    node.parent = parent;
    node.parent_from_node = local;
    node.world_from_node =
        parent < 0 ? local : c.nodes[static_cast<std::size_t>(parent)].world_from_node * local;
    c.nodes.push_back(node);
  };
  add_node("root", -1, glm::scale(kOne, dvec3(2.0)));
  add_node("lower", 0, glm::rotate(glm::translate(kOne, dvec3(0, 0.1, 0)), 0.7, dvec3(0, 0, 1)));
  add_node(
      "upper", 1,
      glm::rotate(glm::translate(kOne, dvec3(0.3, 0, 0)), -0.4, dvec3(1, 2, 0) / std::sqrt(5.0)));
  for (const int node : {1, 2}) {
    c.joints.push_back(
        {node, glm::inverse(c.nodes[static_cast<std::size_t>(node)].world_from_node)});
  }
  for (int row = 0; row < 3; ++row) {
    for (int side = 0; side < 2; ++side) {
      c.bind_position.emplace_back(0.2f * static_cast<float>(side), 0.5f * static_cast<float>(row),
                                   0.1f);
      c.bind_normal.emplace_back(0.0f, 0.0f, 1.0f);
      Influences w;
      w.joint = {0, 1};
      w.weight = {1.0f - 0.4f * static_cast<float>(row), 0.4f * static_cast<float>(row)};
      c.influences.push_back(w);
    }
  }
  for (unsigned row = 0; row < 2; ++row) {
    c.triangles.emplace_back(2 * row, 2 * row + 1, 2 * row + 3);
    c.triangles.emplace_back(2 * row, 2 * row + 3, 2 * row + 2);
  }
  Material clay;
  clay.name = "clay";
  c.materials.push_back(clay);
  c.parts.push_back({"strip", 0, 0, 4, 0, 6});
  return c;
}

json header_of(const std::vector<std::uint8_t>& glb) {
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, 4);
  return json::parse(glb.begin() + 20, glb.begin() + 20 + length);
}

/// Floats of an accessor.
std::vector<float> floats(const std::vector<std::uint8_t>& glb, int accessor) {
  const json root = header_of(glb);
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, 4);
  const json& a = root["accessors"][static_cast<std::size_t>(accessor)];
  const json& view = root["bufferViews"][a["bufferView"].get<std::size_t>()];
  std::vector<float> out(view["byteLength"].get<std::size_t>() / 4);
  std::memcpy(out.data(), glb.data() + 20 + length + 8 + view["byteOffset"].get<std::size_t>(),
              4 * out.size());
  return out;
}

Character read_back(const std::vector<std::uint8_t>& glb) {
  const TemporaryFolder folder;
  write_file(folder / "written.glb", glb);
  return read_character(folder / "written.glb");
}

/// The node's local matrix at a frame: its rest transform where a channel says nothing.
dmat4 local_at(const std::vector<std::uint8_t>& glb, std::size_t node, std::size_t frame) {
  const json root = header_of(glb);
  const json& entry = root["nodes"][node];
  std::map<std::string, std::vector<float>> value{
      {"translation", {0, 0, 0}}, {"rotation", {0, 0, 0, 1}}, {"scale", {1, 1, 1}}};
  for (auto& [path, v] : value) {
    if (entry.contains(path)) v = entry[path].get<std::vector<float>>();
  }
  if (root.contains("animations")) {
    const json& animation = root["animations"][0];
    for (const json& channel : animation["channels"]) {
      if (channel["target"]["node"] != node) continue;
      const json& sampler = animation["samplers"][channel["sampler"].get<std::size_t>()];
      const std::vector<float> all = floats(glb, sampler["output"]);
      auto& v = value[channel["target"]["path"]];
      const std::size_t n = v.size();
      v.assign(all.begin() + static_cast<long>(frame * n),
               all.begin() + static_cast<long>((frame + 1) * n));
    }
  }
  const auto &t = value["translation"], &r = value["rotation"], &s = value["scale"];
  return glm::translate(kOne, dvec3(t[0], t[1], t[2])) *
         glm::mat4_cast(glm::dquat(r[3], r[0], r[1], r[2])) *
         glm::scale(kOne, dvec3(s[0], s[1], s[2]));
}

std::vector<dmat4> world_at(const std::vector<std::uint8_t>& glb, std::size_t frame) {
  const json root = header_of(glb);
  const std::size_t n = root["nodes"].size();
  std::vector<int> parent(n, -1);
  for (std::size_t i = 0; i < n; ++i) {
    if (!root["nodes"][i].contains("children")) continue;
    for (const json& child : root["nodes"][i]["children"])
      parent[child.get<std::size_t>()] = static_cast<int>(i);
  }
  std::vector<dmat4> world(n);
  for (std::size_t i = 0; i < n; ++i) {
    world[i] = local_at(glb, i, frame);
    for (int p = parent[i]; p >= 0; p = parent[static_cast<std::size_t>(p)]) {
      world[i] = local_at(glb, static_cast<std::size_t>(p), frame) * world[i];
    }
  }
  return world;
}

/// Where the file's own numbers put each vertex in a frame: glTF's skinning, in double.
std::vector<dvec3> skinned_at(const std::vector<std::uint8_t>& glb, std::size_t frame) {
  const json root = header_of(glb);
  const json& attributes = root["meshes"][0]["primitives"][0]["attributes"];
  const std::vector<float> position = floats(glb, attributes["POSITION"]);
  const std::vector<float> weight = floats(glb, attributes["WEIGHTS_0"]);
  const std::vector<float> packed = floats(glb, attributes["JOINTS_0"]);
  const std::vector<float> bind = floats(glb, root["skins"][0]["inverseBindMatrices"]);
  const std::vector<dmat4> world = world_at(glb, frame);
  std::vector<dvec3> out;
  for (std::size_t v = 0; v < position.size() / 3; ++v) {
    std::array<std::uint8_t, 4> joint{};
    std::memcpy(joint.data(), &packed[v], 4);
    dvec3 sum(0.0);
    for (std::size_t k = 0; k < 4; ++k) {
      dmat4 inverse_bind;
      for (int i = 0; i < 16; ++i)
        inverse_bind[i / 4][i % 4] = bind[16 * joint[k] + static_cast<std::size_t>(i)];
      const auto node = root["skins"][0]["joints"][joint[k]].get<std::size_t>();
      const glm::dvec4 p(position[3 * v], position[3 * v + 1], position[3 * v + 2], 1.0);
      sum += static_cast<double>(weight[4 * v + k]) * dvec3(world[node] * inverse_bind * p);
    }
    out.push_back(sum);
  }
  return out;
}

double worst(const dmat4& a, const dmat4& b) {
  double most = 0.0;
  for (int c = 0; c < 4; ++c) {
    for (int r = 0; r < 4; ++r) most = std::max(most, std::abs(a[c][r] - b[c][r]));
  }
  return most;
}

/// The upper node turns about its own axis by `step` a frame.
GlbAnimation spin(const Character& c, double step, int frames) {
  GlbAnimation out;
  for (int f = 0; f < frames; ++f) {
    out.time.push_back(static_cast<float>(f) / 24.0f);
    std::vector<dmat4> world;
    for (const Node& node : c.nodes) world.push_back(node.world_from_node);
    world[2] = world[2] * glm::rotate(kOne, step * f, dvec3(0.6, 0.0, 0.8));
    out.world_from_node.push_back(world);
  }
  return out;
}

TEST(EncodeGlb, BindsARigidPartWhereItStandsAtRest) {
  Character c = strip_character();
  Node hat;
  hat.name = "hat";
  hat.parent = 2;
  hat.parent_from_node = glm::scale(
      glm::rotate(glm::translate(kOne, dvec3(0.1, 0.5, -0.2)), 1.1, dvec3(0, 1, 0)), dvec3(3.0));
  hat.world_from_node = c.nodes[2].world_from_node * hat.parent_from_node;
  c.nodes.push_back(hat);
  c.joints.push_back({3, kOne});  // a mesh on a node
  Influences on_hat;
  on_hat.joint[0] = 2;
  on_hat.weight[0] = 1.0f;
  for (const glm::vec3 at : {glm::vec3(0), glm::vec3(0.1f, 0, 0), glm::vec3(0, 0, 0.1f)}) {
    c.bind_position.push_back(at);
    c.bind_normal.emplace_back(0.0f, 1.0f, 0.0f);
    c.influences.push_back(on_hat);
  }
  c.triangles.emplace_back(6, 8, 7);
  c.parts.push_back({"hat", 0, 4, 1, 6, 3});
  const Character back = read_back(encode_glb(c));
  EXPECT_TRUE(back.warnings.empty()) << back.warnings.front().message;
  const PosedMesh rest = rest_mesh(c), written = rest_mesh(back);
  for (std::size_t v = 0; v < 9; ++v) {
    EXPECT_LT(glm::distance(written.position[v], rest.position[v]), 1e-5f) << v;
    EXPECT_LT(glm::distance(written.normal[v], rest.normal[v]), 1e-5f) << v;
  }
  const auto world = [](const Character& one, const char* name) {
    return std::ranges::find(one.nodes, name, &Node::name)->world_from_node;
  };
  EXPECT_LT(glm::distance(dvec3(world(back, "hat")[3]), dvec3(hat.world_from_node[3])), 1e-5);
  // Bound at rest, the hat still goes with its node.
  std::vector<dmat4> turned;
  for (const Node& node : c.nodes)
    turned.push_back(glm::rotate(kOne, 0.8, dvec3(1, 0, 0)) * node.world_from_node);
  const Character bound = with_rigid_parts_at_rest(c);
  const PosedMesh before = skin(c, turned), after = skin(bound, turned);
  for (std::size_t v = 0; v < 9; ++v)
    EXPECT_LT(glm::distance(after.position[v], before.position[v]), 1e-5f) << v;
}

TEST(GlbWriter, WritesWhatTheReaderReadsBack) {
  const Character c = strip_character();
  const Character read = read_back(encode_glb(c));
  EXPECT_EQ(read.bind_position, c.bind_position);
  EXPECT_EQ(read.bind_normal, c.bind_normal);
  EXPECT_EQ(read.triangles, c.triangles);
  ASSERT_EQ(read.joints.size(), c.joints.size());
  for (std::size_t v = 0; v < c.vertex_count(); ++v) {
    for (std::size_t k = 0; k < 2; ++k) {
      // The reader puts the largest weight first.
      for (std::size_t m = 0; m < 2; ++m) {
        if (read.influences[v].weight[m] > 0.0f &&
            read.influences[v].joint[m] == c.influences[v].joint[k]) {
          EXPECT_NEAR(read.influences[v].weight[m], c.influences[v].weight[k], 1e-7f);
        }
      }
    }
  }
  const PosedMesh here = rest_mesh(c), there = rest_mesh(read);
  for (std::size_t v = 0; v < c.vertex_count(); ++v) {
    EXPECT_LT(glm::distance(here.position[v], there.position[v]), 1e-6f);
  }
  EXPECT_TRUE(read.warnings.empty());
}

/// glTF wants unit normals; where there is none to make one of, any will do.
TEST(GlbWriter, MakesNormalsUnit) {
  Character c = strip_character();
  const float infinite = std::numeric_limits<float>::infinity();
  c.bind_normal = {{0, 0, 3}, {0.25f, 0, 0},    {0, 1e-8f, 1e-8f},
                   {0, 0, 0}, {0, infinite, 0}, {0, 0, std::nanf("")}};
  const std::vector<std::uint8_t> glb = encode_glb(c);
  const std::vector<float> normal =
      floats(glb, header_of(glb)["meshes"][0]["primitives"][0]["attributes"]["NORMAL"]);
  const float half = std::sqrt(0.5f);
  const float expected[] = {0, 0, 1, 1, 0, 0, 0, half, half, 0, 1, 0, 0, 1, 0, 0, 1, 0};
  ASSERT_EQ(normal.size(), std::size(expected));
  for (std::size_t k = 0; k < normal.size(); ++k) EXPECT_NEAR(normal[k], expected[k], 1e-6) << k;
}

TEST(GlbWriter, GivesTheSameBytesForTheSameCharacter) {
  const Character c = strip_character();
  const GlbAnimation a = spin(c, 0.3, 5);
  EXPECT_EQ(encode_glb(c, &a), encode_glb(c, &a));
}

TEST(GlbWriter, PutsChunksWhereTheSpecificationWantsThem) {
  const std::vector<std::uint8_t> glb = encode_glb(strip_character());
  std::uint32_t word[5];
  std::memcpy(word, glb.data(), sizeof word);
  EXPECT_EQ(word[0], 0x46546C67u);
  EXPECT_EQ(word[1], 2u);
  EXPECT_EQ(word[2], glb.size());
  EXPECT_EQ(word[3] % 4, 0u);
  std::uint32_t binary = 0;
  std::memcpy(&binary, glb.data() + 20 + word[3], 4);
  EXPECT_EQ(20 + word[3] + 8 + binary, glb.size());
  EXPECT_EQ(header_of(glb)["buffers"][0]["byteLength"], binary);
}

TEST(GlbWriter, KeepsEveryWorldMatrixOfTheMotion) {
  const Character c = strip_character();
  const GlbAnimation a = spin(c, 0.9, 9);
  const std::vector<std::uint8_t> glb = encode_glb(c, &a);
  for (std::size_t f = 0; f < a.time.size(); ++f) {
    const std::vector<dmat4> world = world_at(glb, f);
    for (std::size_t i = 0; i < c.nodes.size(); ++i) {
      // Floats of size 1 through three levels of scale 2.
      EXPECT_LT(worst(world[i], a.world_from_node[f][i]), 2e-6) << f << " " << i;
    }
  }
}

TEST(GlbWriter, KeepsMovesAndScalesByThemselves) {
  const Character c = strip_character();
  for (const std::string& path : {std::string("translation"), std::string("scale")}) {
    GlbAnimation a = spin(c, 0.0, 5);
    for (std::size_t f = 0; f < a.time.size(); ++f) {
      const double by = 0.25 * static_cast<double>(f);
      const dmat4 change = path == "scale" ? glm::scale(kOne, dvec3(1.0 + by, 1.0, 1.0 - 0.5 * by))
                                           : glm::translate(kOne, dvec3(0.0, by, 0.0));
      a.world_from_node[f][2] = c.nodes[2].world_from_node * change;
    }
    const std::vector<std::uint8_t> glb = encode_glb(c, &a);
    const json channels = header_of(glb)["animations"][0]["channels"];
    EXPECT_TRUE(std::any_of(channels.begin(), channels.end(), [&](const json& channel) {
      return channel["target"]["path"] == path && channel["target"]["node"] == 2;
    }));
    for (std::size_t f = 0; f < a.time.size(); ++f)
      EXPECT_LT(worst(world_at(glb, f)[2], a.world_from_node[f][2]), 2e-6) << path << f;
  }
}

TEST(GlbWriter, WritesOnlyTheNodesThatMove) {
  const Character c = strip_character();
  const GlbAnimation a = spin(c, 0.9, 4);
  const json animation = header_of(encode_glb(c, &a))["animations"][0];
  ASSERT_EQ(animation["channels"].size(), 1u);
  EXPECT_EQ(animation["channels"][0]["target"]["node"], 2);
  EXPECT_EQ(animation["channels"][0]["target"]["path"], "rotation");
  const GlbAnimation still = spin(c, 0.0, 4);
  EXPECT_FALSE(header_of(encode_glb(c, &still)).contains("animations"));
}

TEST(GlbWriter, TurnsTheShortWayFromKeyToKey) {
  // 40 steps of 50 degrees pass the quaternions' sign change five times.
  const Character c = strip_character();
  const GlbAnimation a = spin(c, glm::radians(50.0), 40);
  const std::vector<std::uint8_t> glb = encode_glb(c, &a);
  const json sampler = header_of(glb)["animations"][0]["samplers"][0];
  EXPECT_EQ(sampler["interpolation"], "LINEAR");
  const std::vector<float> q = floats(glb, sampler["output"]);
  for (std::size_t f = 1; f < 40; ++f) {
    float dot = 0.0f;
    for (std::size_t k = 0; k < 4; ++k) dot += q[4 * f + k] * q[4 * f - 4 + k];
    EXPECT_NEAR(dot, std::cos(glm::radians(25.0f)), 1e-5f) << f;
  }
}

TEST(GlbWriter, WritesAShearedSkeletonSoThatTheSkinStandsTheSame) {
  // An uneven scale above a turned node shears what is below: no node can say that.
  Character c = strip_character();
  c.nodes[0].parent_from_node = c.nodes[0].world_from_node = glm::scale(kOne, dvec3(1.0, 2.0, 0.5));
  for (std::size_t i = 1; i < 3; ++i) {
    c.nodes[i].world_from_node = c.nodes[i - 1].world_from_node * c.nodes[i].parent_from_node;
    c.joints[i - 1].joint_from_mesh = glm::inverse(c.nodes[i].world_from_node);
  }
  GlbAnimation a;
  for (int f = 0; f < 3; ++f) {
    a.time.push_back(static_cast<float>(f));
    std::vector<dmat4> world;
    for (std::size_t i = 0; i < 3; ++i) {
      // Rigid motions in the world, as a spine gives them.
      const dmat4 motion = glm::rotate(glm::translate(kOne, dvec3(0, 0.1 * f, 0)),
                                       0.5 * f * static_cast<double>(i), dvec3(1, 0, 0));
      world.push_back(motion * c.nodes[i].world_from_node);
    }
    a.world_from_node.push_back(world);
  }
  const std::vector<std::uint8_t> glb = encode_glb(c, &a);
  for (std::size_t f = 0; f < 3; ++f) {
    const std::vector<dvec3> there = skinned_at(glb, f);
    const PosedMesh here = skin(c, a.world_from_node[f]);
    for (std::size_t v = 0; v < c.vertex_count(); ++v) {
      EXPECT_LT(glm::distance(dvec3(here.position[v]), there[v]), 3e-6) << f << " " << v;
    }
  }
}

TEST(GlbWriter, GivesAVertexWithoutWeightsAJointThatNeverMoves) {
  Character c = strip_character();
  c.influences[5] = Influences{};
  const GlbAnimation a = spin(c, 1.0, 3);
  const std::vector<std::uint8_t> glb = encode_glb(c, &a);
  for (std::size_t f = 0; f < 3; ++f) {
    EXPECT_LT(glm::distance(skinned_at(glb, f)[5], dvec3(c.bind_position[5])), 1e-6);
  }
  EXPECT_EQ(header_of(glb)["skins"][0]["joints"].size(), 3u);
}

TEST(GlbWriter, NamesANodeOnceInTheSkinThoughTwoBindMatricesHangOnIt) {
  Character c = strip_character();
  c.joints.push_back({2, c.joints[1].joint_from_mesh * glm::translate(kOne, dvec3(0, 0.1, 0))});
  c.influences[4].joint = {0, 2};
  const std::vector<std::uint8_t> glb = encode_glb(c);
  const json joints = header_of(glb)["skins"][0]["joints"];
  EXPECT_NE(joints[1], joints[2]);
  const PosedMesh here = rest_mesh(c);
  EXPECT_LT(glm::distance(skinned_at(glb, 0)[4], dvec3(here.position[4])), 1e-6);
}

/// A coat, bound in another space than the body below it: both go by the same nodes.
TEST(GlbWriter, GivesPartsThatAreBoundInSeveralSpacesASkinEach) {
  Character c = strip_character();
  const auto vertices = static_cast<std::uint32_t>(c.vertex_count());
  const auto triangles = static_cast<std::uint32_t>(c.triangles.size());
  const auto joints = static_cast<std::uint16_t>(c.joints.size());
  const dmat4 space = glm::scale(glm::translate(kOne, dvec3(0, 0.5, 0.1)), dvec3(0.01));
  for (std::uint16_t j = 0; j < joints; ++j)
    c.joints.push_back({c.joints[j].node, c.joints[j].joint_from_mesh * space});
  for (std::uint32_t v = 0; v < vertices; ++v) {
    c.bind_position.emplace_back(glm::inverse(space) * glm::dvec4(dvec3(c.bind_position[v]), 1.0));
    c.bind_normal.push_back(c.bind_normal[v]);
    Influences coat = c.influences[v];
    for (std::uint16_t& joint : coat.joint) joint = static_cast<std::uint16_t>(joint + joints);
    c.influences.push_back(coat);
  }
  for (std::uint32_t t = 0; t < triangles; ++t)
    c.triangles.push_back(c.triangles[t] + glm::uvec3(vertices));
  c.parts.push_back({"coat", 0, triangles, triangles, vertices, vertices});

  const std::vector<std::uint8_t> glb = encode_glb(c);
  const json header = header_of(glb);
  EXPECT_EQ(header["skins"].size(), 2u);
  EXPECT_EQ(header["nodes"].size(), c.nodes.size() + 2);  // a mesh on each skin
  const Character read = read_back(glb);
  EXPECT_TRUE(read.warnings.empty());
  EXPECT_EQ(read.nodes.size(), c.nodes.size() + 2);
  ASSERT_EQ(read.joints.size(), c.joints.size());
  const PosedMesh here = rest_mesh(c), there = rest_mesh(read);
  const auto of_lower = [](const Character& of, std::size_t v) {
    float sum = 0.0f;
    for (std::size_t k = 0; k < kMaxInfluences; ++k)
      if (of.nodes[static_cast<std::size_t>(of.joints[of.influences[v].joint[k]].node)].name ==
          "lower")
        sum += of.influences[v].weight[k];
    return sum;
  };
  for (std::size_t v = 0; v < c.vertex_count(); ++v) {
    EXPECT_LT(glm::distance(here.position[v], there.position[v]), 1e-6f) << v;
    EXPECT_FLOAT_EQ(of_lower(read, v), of_lower(c, v)) << v;
  }
}

TEST(LayOutSkins, PutsPartsAndJointsWhereOthersMoveTheMeshAsTheyDo) {
  Character c;
  for (int n = 0; n < 5; ++n) c.nodes.emplace_back();
  const auto bound = [&](int node, double at) {
    c.joints.push_back({node, glm::translate(kOne, dvec3(at, 0, 0))});
  };
  bound(0, 0), bound(1, 0), bound(0, 1), bound(1, 1), bound(2, 1), bound(1, 2);
  bound(3, 5), bound(4, 1);
  const auto part = [&](std::uint16_t joint) {
    c.parts.push_back({"part", 0, 0, 0, static_cast<std::uint32_t>(c.vertex_count()), 1});
    c.bind_position.emplace_back(0.0f);
    c.influences.emplace_back();
    c.influences.back().joint[0] = joint;
    c.influences.back().weight[0] = 1.0f;
  };
  part(0), part(2), part(0), part(6), part(7);
  const SkinLayout layout = lay_out_skins(c, written_skin(c).influences);
  const std::vector<std::vector<std::size_t>> expected = {{0, 1}, {2, 3, 4, 7}, {6}};
  EXPECT_EQ(layout.joints, expected);  // and no room for the third of node 1
  EXPECT_EQ(layout.of_part, (std::vector<std::size_t>{0, 1, 0, 2, 1}));
  EXPECT_EQ(layout.place(1, 4), 2u);
  EXPECT_EQ(layout.place(0, 4), SkinLayout::kNone);
}

TEST(GlbWriter, WritesEightInfluencesAsTwoSets) {
  Character c = strip_character();
  for (int j = 0; j < 5; ++j) c.joints.push_back({2, c.joints[1].joint_from_mesh});
  c.influences[0].joint = {0, 1, 2, 3, 4, 5};
  c.influences[0].weight = {0.3f, 0.2f, 0.2f, 0.1f, 0.1f, 0.1f};
  const json attributes = header_of(encode_glb(c))["meshes"][0]["primitives"][0]["attributes"];
  EXPECT_TRUE(attributes.contains("JOINTS_1"));
  EXPECT_TRUE(attributes.contains("WEIGHTS_1"));
  EXPECT_FALSE(
      header_of(encode_glb(strip_character()))["meshes"][0]["primitives"][0]["attributes"].contains(
          "JOINTS_1"));
}

TEST(GlbWriter, RefusesMotionsThatNoFileCanSay) {
  const Character c = strip_character();
  const auto refused = [&c](const GlbAnimation& a, const std::string& message) {
    try {
      encode_glb(c, &a);
      ADD_FAILURE() << message << ": passed";
    } catch (const CharacterError& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
  };
  GlbAnimation a = spin(c, 0.1, 3);
  a.time[2] = a.time[1];
  refused(a, "frame 2: times do not rise");
  a = spin(c, 0.1, 3);
  a.time.pop_back();
  refused(a, "2 times for 3 frames");
  a = spin(c, 0.1, 3);
  a.world_from_node[1].pop_back();
  refused(a, "frame 1: 2 matrices for 3 nodes");
  a = spin(c, 0.1, 3);
  a.world_from_node[1][2][0][0] = std::numeric_limits<double>::quiet_NaN();
  refused(a, "`upper` is not finite");
  a = spin(c, 0.1, 3);
  a.world_from_node[1][2][0] += 0.5 * a.world_from_node[1][2][1];
  refused(a, "`upper`: sheared by the motion");
  Character broken = c;
  broken.influences[3].weight[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(encode_glb(broken), CharacterError);
}

TEST(GlbWriter, WritesAPoseWithAColourForEachVertex) {
  const Character c = strip_character();
  PosedMesh posed = rest_mesh(c);
  posed.position[3] += glm::vec3(0.0f, 0.25f, 0.0f);
  std::vector<glm::vec3> color(6, glm::vec3(0.25f, 0.5f, 1.0f));
  color[2] = glm::vec3(std::numeric_limits<float>::quiet_NaN(), -1.0f, 7.0f);
  const std::vector<std::uint8_t> glb = encode_posed_glb(c, posed, color);
  const json root = header_of(glb);
  EXPECT_FALSE(root.contains("skins"));
  const json& attributes = root["meshes"][0]["primitives"][0]["attributes"];
  const std::vector<float> position = floats(glb, attributes["POSITION"]);
  EXPECT_EQ(position[3 * 3 + 1], posed.position[3].y);
  const std::vector<float> written = floats(glb, attributes["COLOR_0"]);
  EXPECT_EQ(written[0], 0.25f);
  EXPECT_EQ(written[1], 0.5f);
  EXPECT_EQ(std::vector<float>(written.begin() + 8, written.begin() + 12),
            (std::vector<float>{0.0f, 0.0f, 1.0f, 1.0f}));
  // Vertex colours are multiplied with the material's colour, which must not tint them.
  EXPECT_EQ(root["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"],
            json({1.0, 1.0, 1.0, 1.0}));
  color.pop_back();
  EXPECT_THROW(encode_posed_glb(c, posed, color), CharacterError);
  EXPECT_NO_THROW(encode_posed_glb(c, posed, {}));
  PosedMesh fewer = posed;
  fewer.normal.pop_back();
  EXPECT_THROW(encode_posed_glb(c, fewer, {}), CharacterError);
  fewer = posed;
  fewer.position.pop_back();
  EXPECT_THROW(encode_posed_glb(c, fewer, {}), CharacterError);
}

}  // namespace
}  // namespace backbend::skin
