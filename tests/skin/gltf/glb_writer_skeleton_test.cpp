// What a node can say of a matrix, and whole characters of every kind through a file and back.
#include "skin/gltf/glb_writer_skeleton.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "skin/deform/skinning.h"
#include "skin/gltf/gltf_reader.h"
#include "tests/skin/gltf_fixture.h"

namespace backbend::skin {
namespace {

using glm::dmat4;
using glm::dvec3;

const dmat4 kIdentity(1.0);

dmat4 matrix_of(const NodeTransform& t) {
  return glm::translate(kIdentity, t.translation) * glm::mat4_cast(t.rotation) *
         glm::scale(kIdentity, t.scale);
}
double apart(const dmat4& a, const dmat4& b) {
  double most = 0.0;
  for (int c = 0; c < 4; ++c) most = std::max(most, glm::distance(a[c], b[c]));
  return most;
}
const dmat4 kTurned = glm::rotate(glm::translate(kIdentity, dvec3(0.3, -2.0, 5.0)), 1.9,
                                  glm::normalize(dvec3(1, -2, 0.7)));

TEST(SplitTransform, GivesTheMatrixBackMirroredOrNot) {
  for (const dvec3& scale : {dvec3(2, 0.5, 3), dvec3(-2, 0.5, 3), dvec3(2, 0.5, -3),
                             dvec3(-1, -0.25, -4), dvec3(1, 1, 1), dvec3(1e-6, 2, 1)}) {
    const dmat4 matrix = glm::scale(kTurned, scale);
    const auto split = split_transform(matrix);
    ASSERT_TRUE(split);
    EXPECT_LT(apart(matrix_of(*split), matrix), 1e-12);
    EXPECT_NEAR(glm::length(split->rotation), 1.0, 1e-12);
    EXPECT_EQ(split->translation, dvec3(0.3, -2.0, 5.0));
    EXPECT_GT(split->scale.y, 0.0);
    EXPECT_GT(split->scale.z, 0.0);
    EXPECT_EQ(split->scale.x < 0.0, scale.x * scale.y * scale.z < 0.0);
  }
}

TEST(SplitTransform, CallsAScaleOfOneButForRoundingOne) {
  for (const double off : {0.0, 1e-12, -5e-10}) {
    const auto split = split_transform(glm::scale(kTurned, dvec3(1.0 + off, 2.0, 1.0 - off)));
    ASSERT_TRUE(split);
    EXPECT_EQ(split->scale.x, 1.0);
    EXPECT_EQ(split->scale.z, 1.0);
    EXPECT_NE(split->scale.y, 1.0);
  }
  const auto mirrored = split_transform(glm::scale(kTurned, dvec3(-1.0 - 1e-12, 1.0, 1.0)));
  EXPECT_EQ(mirrored->scale, dvec3(-1, 1, 1));
  EXPECT_NE(split_transform(glm::scale(kTurned, dvec3(1.0 + 1e-8, 1, 1)))->scale.x, 1.0);
}

TEST(SplitTransform, HasNoneForWhatShearsOrFlattens) {
  for (int a = 0; a < 3; ++a) {
    dmat4 flat = kTurned;
    flat[a] *= 1e-13;
    EXPECT_FALSE(split_transform(flat));
    flat[a] = glm::dvec4(std::nan(""));
    EXPECT_FALSE(split_transform(flat));
    for (int b = 0; b < 3; ++b) {
      if (a == b) continue;
      for (const double sign : {1.0, -1.0}) {
        dmat4 sheared = kTurned;  // the cosine between the two is about the share of the other
        sheared[a] += sign * 2e-5 * kTurned[b];
        EXPECT_FALSE(split_transform(sheared)) << a << b;
        EXPECT_TRUE(split_transform(sheared, 1e-4));
        sheared[a] = kTurned[a] + sign * 0.5e-5 * kTurned[b];
        EXPECT_TRUE(split_transform(sheared)) << a << b;
      }
    }
  }
}

/// A chain whose second node shears: no file can say how it and what is below it stand.
Character sheared() {
  Character c;
  c.file_name = "sheared.glb";
  const dmat4 local[] = {glm::scale(kIdentity, dvec3(1.0, 2.0, 0.5)),
                         glm::rotate(glm::translate(kIdentity, dvec3(0.1, 0.4, 0.2)), 0.8,
                                     glm::normalize(dvec3(1, 2, 3))) *
                             glm::scale(kIdentity, dvec3(1.0, 2.0, 0.5)) *
                             glm::rotate(kIdentity, 0.6, glm::normalize(dvec3(2, -1, 1))),
                         glm::rotate(glm::translate(kIdentity, dvec3(0.3, 0.5, -0.2)), -1.2,
                                     glm::normalize(dvec3(-1, 0.5, 2)))};
  for (int n = 0; n < 3; ++n) {
    Node node;
    node.name = "n" + std::to_string(n);
    node.parent = n - 1;
    node.world_from_node = n == 0 ? local[0] : c.nodes.back().world_from_node * local[n];
    c.nodes.push_back(node);
    c.joints.push_back({n, glm::inverse(node.world_from_node) * glm::scale(kIdentity, dvec3(1.5))});
  }
  return c;
}

TEST(PrepareSkeleton, PutsSquareFramesAtTheSameOriginsWhereNodesShear) {
  const Character c = sheared();
  const WrittenSkeleton written = prepare_skeleton(c, nullptr);
  dmat4 world = kIdentity;
  for (std::size_t n = 0; n < 3; ++n) {
    world = world * matrix_of(written.rest[n]);
    const dmat4& rest = c.nodes[n].world_from_node;
    EXPECT_LT(glm::distance(world[3], rest[3]), 1e-12);
    const dvec3 x(world[0]), y(world[1]), zed(world[2]);
    // X as it was, Y in the plane of the two, Z across.
    EXPECT_LT(glm::distance(x, glm::normalize(dvec3(rest[0]))), 1e-12) << n;
    EXPECT_NEAR(glm::length(y), 1.0, 1e-12);
    EXPECT_NEAR(glm::dot(x, y), 0.0, 1e-12);
    EXPECT_GT(glm::dot(y, dvec3(rest[1])), 0.0);
    EXPECT_NEAR(glm::dot(y, glm::cross(dvec3(rest[0]), dvec3(rest[1]))), 0.0, 1e-12);
    EXPECT_LT(glm::distance(zed, glm::cross(x, y)), 1e-12);
    // The skin stands as it stood.
    EXPECT_LT(apart(world * written.joint_from_mesh[n], rest * c.joints[n].joint_from_mesh), 1e-12);
  }
}

TEST(PrepareSkeleton, RefusesWhatNoFileCanSay) {
  const auto refused = [](const Character& c, const GlbAnimation* a, const std::string& words) {
    try {
      prepare_skeleton(c, a);
      ADD_FAILURE() << words << ": passed";
    } catch (const CharacterError& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  };
  for (int k = 0; k < 16; ++k) {
    Character c = sheared();
    c.nodes[1].world_from_node[k / 4][k % 4] = std::nan("");
    refused(c, nullptr, "node `n1`: rest matrix is not finite");
    c = sheared();
    c.joints[2].joint_from_mesh[k / 4][k % 4] = INFINITY;
    refused(c, nullptr, "node `n2`: inverse bind matrix is not finite");
  }
  Character flat = sheared();
  flat.nodes[1].world_from_node[1] = glm::dvec4(0.0);
  refused(flat, nullptr, "node `n1`: flattened to nothing");
  for (int a = 0; a < 3; ++a) {  // two axes that nearly fall together
    flat = sheared();
    dmat4& frame = flat.nodes[1].world_from_node;
    const glm::dvec4 other = frame[(a + 1) % 3];
    frame[a] = 2.0 * other + 1e-7 * frame[a];
    refused(flat, nullptr, "node `n1`: flattened to nothing");
    frame[a] = 2.0 * other + 1e-4 * sheared().nodes[1].world_from_node[a];
    EXPECT_NO_THROW(prepare_skeleton(flat, nullptr)) << a;
  }
  const Character c = sheared();
  GlbAnimation a;
  a.name = "walk";
  for (int f = 0; f < 2; ++f) {
    a.time.push_back(0.5f * static_cast<float>(f));
    std::vector<dmat4> world;
    for (const Node& node : c.nodes) world.push_back(node.world_from_node);
    a.world_from_node.push_back(world);
  }
  EXPECT_NO_THROW(prepare_skeleton(c, &a));
  GlbAnimation bad = a;
  bad.world_from_node[1][2] = glm::rotate(kIdentity, 0.4, dvec3(0, 0, 1)) *
                              glm::scale(kIdentity, dvec3(2, 1, 1)) * bad.world_from_node[1][2];
  refused(c, &bad, "node `n2`: sheared by the motion");
  bad = a;
  bad.time.pop_back();
  refused(c, &bad, "animation `walk`: 1 times for 2 frames");
  bad.time.clear();
  bad.world_from_node.clear();
  refused(c, &bad, "0 times for 0 frames");
  bad = a;
  bad.time = {-0.25f, 0.5f};
  refused(c, &bad, "frame 0: times do not rise from 0");
  bad.time = {0.0f, std::numeric_limits<float>::infinity()};
  refused(c, &bad, "frame 1: times do not rise from 0");
  bad.time = {0.5f, 0.5f};
  refused(c, &bad, "frame 1: times do not rise from 0");
  bad = a;
  bad.world_from_node[1].pop_back();
  refused(c, &bad, "frame 1: 2 matrices for 3 nodes");
  bad = a;
  bad.world_from_node[0][1][3][2] = std::nan("");
  refused(c, &bad, "frame 0: the matrix of node `n1` is not finite");
}

/// A character of `joints` joints on two roots, two parts, pictures and materials of every kind.
Character rich(int joints) {
  Character c;
  c.name = "rich";
  c.file_name = "rich.glb";
  for (int n = 0; n < joints; ++n) {
    Node node;
    node.name = "j" + std::to_string(n);
    node.parent = n == 0 || n == 3 ? -1 : n == 7 ? 2 : n - 1;
    node.parent_from_node =
        glm::rotate(glm::translate(kIdentity, dvec3(0.01 * n, 0.1 + 0.02 * (n % 5), 0.03)),
                    0.1 + 0.01 * (n % 7), glm::normalize(dvec3(1, n % 3, 2)));
    if (n % 4 == 1) node.parent_from_node = glm::scale(node.parent_from_node, dvec3(1.25));
    if (n % 4 == 2) node.parent_from_node = glm::scale(node.parent_from_node, dvec3(0.8));
    node.world_from_node = node.parent < 0
                               ? node.parent_from_node
                               : c.nodes[static_cast<std::size_t>(node.parent)].world_from_node *
                                     node.parent_from_node;
    c.nodes.push_back(node);
    c.joints.push_back({n, glm::inverse(node.world_from_node)});
  }
  const auto count = static_cast<std::uint32_t>(joints);
  const std::uint32_t vertices[] = {9, 7};
  std::uint32_t v = 0;
  for (std::uint32_t p = 0; p < 2; ++p) {
    Part part{"part" + std::to_string(p),
              static_cast<int>(2 - 2 * p),
              static_cast<std::uint32_t>(c.triangles.size()),
              0,
              v,
              vertices[p]};
    for (std::uint32_t k = 0; k < vertices[p]; ++k, ++v) {
      c.bind_position.emplace_back(0.1f * static_cast<float>(v), std::sin(static_cast<float>(v)),
                                   0.3f - 0.02f * static_cast<float>(v * v));
      c.bind_normal.push_back(glm::normalize(glm::vec3(std::cos(static_cast<float>(v)), 0.4f,
                                                       std::sin(2.0f * static_cast<float>(v)))));
      c.uv.emplace_back(0.05f * static_cast<float>(v), 1.0f - 0.03f * static_cast<float>(v));
      Influences w;
      const std::uint32_t used = 1 + v % 6;
      float sum = 0.0f;
      for (std::uint32_t i = 0; i < used; ++i) {
        w.joint[i] = static_cast<std::uint16_t>((v * 31 + i * 7 + count - 5) % count);
        w.weight[i] = static_cast<float>(1u << (used - i));
        sum += w.weight[i];
      }
      for (float& each : w.weight) each /= sum;
      c.influences.push_back(w);
    }
    for (std::uint32_t k = 0; k + 2 < vertices[p]; ++k)
      c.triangles.emplace_back(part.first_vertex + k, part.first_vertex + k + 2,
                               part.first_vertex + k + 1);
    part.triangle_count = static_cast<std::uint32_t>(c.triangles.size()) - part.first_triangle;
    c.parts.push_back(part);
  }
  const auto picture = [&](const char* name, std::initializer_list<int> bytes) {
    EncodedImage image;
    image.name = name;
    for (const int b : bytes) image.bytes.push_back(static_cast<std::uint8_t>(b));
    c.images.push_back(image);
  };
  picture("a", {0x89, 'P', 'N', 'G', 13, 10, 26, 10, 1, 2, 3});
  picture("b", {0xFF, 0xD8, 0xFF, 0xE0, 5, 6});
  picture("c", {'R', 'I', 'F', 'F', 9, 0, 0, 0, 'W', 'E', 'B', 'P', 1});
  Material first, second, third;
  first.name = "skin";
  first.base_color = {0.1f, 0.2f, 0.3f, 0.4f};
  first.roughness = 0.6f;
  first.metallic = 0.7f;
  first.emissive = {0.15f, 0.25f, 0.35f};
  first.base_color_image = 0;
  first.metallic_roughness_image = 1;
  first.normal_image = 2;
  second.name = "plain";
  second.double_sided = true;
  third.name = "cloth";
  third.base_color_image = 2;
  third.normal_image = 0;
  third.emissive = {0.0f, 0.0f, 0.5f};
  c.materials = {first, second, third};
  return c;
}

TEST(GlbWriter, BringsEveryPropertyOfACharacterThroughAFile) {
  // 255 joints and the one that never moves fit a byte, 256 do not.
  for (const int joints : {12, 255, 256, 300}) {
    const Character c = rich(joints);
    const std::vector<std::uint8_t> glb = encode_glb(c);
    // Both chunks end on four bytes, whatever stands in them.
    std::uint32_t text = 0, binary = 0;
    std::memcpy(&text, glb.data() + 12, 4);
    std::memcpy(&binary, glb.data() + 20 + text, 4);
    EXPECT_EQ(text % 4, 0u);
    EXPECT_EQ(binary % 4, 0u);
    EXPECT_EQ(28 + text + binary, glb.size());
    const TemporaryFolder folder;
    write_file(folder / "rich.glb", glb);
    const Character read = read_character(folder / "rich.glb");
    for (const Warning& warning : read.warnings) ADD_FAILURE() << warning.message;
    ASSERT_EQ(read.vertex_count(), c.vertex_count());
    EXPECT_EQ(read.bind_position, c.bind_position);
    EXPECT_EQ(read.uv, c.uv);
    EXPECT_EQ(read.triangles, c.triangles);
    ASSERT_EQ(read.parts.size(), c.parts.size());
    for (std::size_t p = 0; p < c.parts.size(); ++p) {
      EXPECT_EQ(read.parts[p].material, c.parts[p].material);
      EXPECT_EQ(read.parts[p].first_vertex, c.parts[p].first_vertex);
      EXPECT_EQ(read.parts[p].vertex_count, c.parts[p].vertex_count);
      EXPECT_EQ(read.parts[p].first_triangle, c.parts[p].first_triangle);
      EXPECT_EQ(read.parts[p].triangle_count, c.parts[p].triangle_count);
    }
    const auto name_of = [](const Character& from, std::size_t joint) {
      return from.nodes[static_cast<std::size_t>(from.joints[joint].node)].name;
    };
    for (std::size_t v = 0; v < c.vertex_count(); ++v) {
      EXPECT_LT(glm::distance(read.bind_normal[v], c.bind_normal[v]), 1e-6f);
      for (std::size_t k = 0; k < kMaxInfluences; ++k) {
        EXPECT_NEAR(read.influences[v].weight[k], c.influences[v].weight[k], 1e-7f) << v;
        if (c.influences[v].weight[k] > 0.0f) {
          EXPECT_EQ(name_of(read, read.influences[v].joint[k]),
                    name_of(c, c.influences[v].joint[k]));
        }
      }
    }
    const PosedMesh here = rest_mesh(c), there = rest_mesh(read);
    for (std::size_t v = 0; v < c.vertex_count(); ++v)
      EXPECT_LT(glm::distance(here.position[v], there.position[v]), 1e-4f) << v;
    ASSERT_EQ(read.materials.size(), 4u);  // the reader's default stands behind
    for (std::size_t m = 0; m < 3; ++m) {
      const Material &a = c.materials[m], &b = read.materials[m];
      EXPECT_EQ(b.name, a.name);
      for (int k = 0; k < 4; ++k) EXPECT_FLOAT_EQ(b.base_color[k], a.base_color[k]);
      for (int k = 0; k < 3; ++k) EXPECT_FLOAT_EQ(b.emissive[k], a.emissive[k]);
      EXPECT_FLOAT_EQ(b.roughness, a.roughness);
      EXPECT_FLOAT_EQ(b.metallic, a.metallic);
      EXPECT_EQ(b.base_color_image, a.base_color_image);
      EXPECT_EQ(b.metallic_roughness_image, a.metallic_roughness_image);
      EXPECT_EQ(b.normal_image, a.normal_image);
      EXPECT_EQ(b.double_sided, a.double_sided);
    }
    ASSERT_EQ(read.images.size(), c.images.size());
    for (std::size_t i = 0; i < c.images.size(); ++i)
      EXPECT_EQ(read.images[i].bytes, c.images[i].bytes) << i;
  }
}

TEST(GlbWriter, MergesAJointThatAVertexNamesTwiceAndMakesSumsOne) {
  Character c = rich(12);
  c.influences[2] = {};
  c.influences[2].joint = {9, 4, 9, 1, 4, 9};
  c.influences[2].weight = {0.25f, 0.125f, 0.5f, 0.25f, 0.125f, 0.25f};  // 1.5 in all
  const TemporaryFolder folder;
  write_file(folder / "rich.glb", encode_glb(c));
  const Character read = read_character(folder / "rich.glb");
  EXPECT_TRUE(read.warnings.empty());
  const float expected[] = {1.0f / 1.5f, 0.25f / 1.5f, 0.25f / 1.5f, 0.0f};
  for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(read.influences[2].weight[k], expected[k], 1e-6f);
  EXPECT_EQ(
      read.nodes[static_cast<std::size_t>(read.joints[read.influences[2].joint[0]].node)].name,
      "j9");
  for (const float bad : {-0.1f, std::numeric_limits<float>::infinity()}) {
    Character broken = c;
    broken.influences[3].weight[0] = bad;
    EXPECT_THROW(encode_glb(broken), CharacterError);
  }
  Character broken = c;
  broken.influences[3].joint[0] = 12;
  EXPECT_THROW(encode_glb(broken), CharacterError);
  for (int axis = 0; axis < 3; ++axis) {
    broken = c;
    broken.bind_position[11][axis] = std::nanf("");
    try {
      encode_glb(broken);
      ADD_FAILURE() << axis;
    } catch (const CharacterError& error) {
      EXPECT_STREQ(error.what(), "part `part1`: vertex 11 is not finite");
    }
  }
}

}  // namespace
}  // namespace backbend::skin
