#include "skin/gltf/usd_writer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "skin/gltf/usd_names.h"
#include "skin/gltf/usd_skeleton.h"
#include "tests/skin/stick_figure.h"

namespace backbend::skin {
namespace {

std::vector<glm::dmat4> rest_of(const Character& character) {
  std::vector<glm::dmat4> world;
  for (const Node& node : character.nodes) world.push_back(node.world_from_node);
  return world;
}

GlbAnimation still(const Character& character, std::size_t frames = 1) {
  GlbAnimation animation;
  for (std::size_t f = 0; f < frames; ++f) {
    animation.time.push_back(static_cast<float>(f) / 24.0f);
    animation.world_from_node.push_back(rest_of(character));
  }
  return animation;
}

/// A stick figure with triangles, so that there is something to write.
Character usd_figure() {
  Character character = stick_figure();
  character.triangles = {{0, 1, 2}};
  character.parts = {{"body", 0, 0, 1, 0, static_cast<std::uint32_t>(character.vertex_count())}};
  return character;
}

std::size_t count(const std::string& text, const std::string& word) {
  std::size_t found = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1))
    ++found;
  return found;
}

TEST(UsdNames, AreIdentifiersOfLettersDigitsAndUnderscores) {
  EXPECT_EQ(usd_identifier("spine_01", "x"), "spine_01");
  EXPECT_EQ(usd_identifier("mixamorig:Hips", "x"), "mixamorig_Hips");
  EXPECT_EQ(usd_identifier("2nd", "x"), "_2nd");
  EXPECT_EQ(usd_identifier("a.L\n\"b", "x"), "a_L__b");
  EXPECT_EQ(usd_identifier("\xc3\xa9", "x"), "__");
  EXPECT_EQ(usd_identifier("", "x"), "x");
}

TEST(UsdNames, ThatCollideAreToldApartEvenWhereTheNextNameIsTakenToo) {
  UniqueNames names;
  EXPECT_EQ(names.take("a_2"), "a_2");
  EXPECT_EQ(names.take("a"), "a");
  EXPECT_EQ(names.take("a"), "a_3");
  EXPECT_EQ(names.take("a"), "a_4");
}

TEST(UsdNames, InQuotesHoldNoQuoteBackslashOrControlThatActs) {
  EXPECT_EQ(usd_string("a\"b\\c\nd"), "\"a'b/c?d\"");
}

TEST(UsdSkeleton, KeepsWhatSkinningComputes) {
  Character character = usd_figure();
  // A bind space of its own: centimetres, turned; and one joint bound a second time.
  const glm::dmat4 mesh =
      glm::scale(glm::rotate(glm::translate(glm::dmat4(1.0), {0.1, 0.2, 0.3}), 0.5, {0, 0, 1}),
                 glm::dvec3(0.01));
  for (SkinJoint& joint : character.joints) joint.joint_from_mesh *= mesh;
  character.joints.push_back(character.joints.front());
  character.joints.back().joint_from_mesh *= glm::scale(glm::dmat4(1.0), glm::dvec3(2.0));
  const UsdSkeleton skeleton = usd_skeleton(character, still(character), true);
  ASSERT_EQ(skeleton.of_skin.size(), character.joints.size() + 1);
  for (std::size_t j = 0; j < character.joints.size(); ++j) {
    const SkinJoint& joint = character.joints[j];
    const glm::dmat4 world = character.nodes[static_cast<std::size_t>(joint.node)].world_from_node;
    const glm::dmat4 ours = world * joint.joint_from_mesh;
    // Rest frames are rigid and nothing else moves: skeleton_from_joint at rest is the node's, up
    // to the rigid frame that both sides of the product share.
    const std::size_t at = skeleton.of_skin[j];
    EXPECT_EQ(skeleton.path[at].find("_bind_") != std::string::npos,
              j + 1 == character.joints.size());
    glm::dmat4 theirs(1.0);
    for (std::size_t i = 0; i < skeleton.path.size(); ++i) {
      const std::string& path = skeleton.path[i];
      const bool above = skeleton.path[at] == path || skeleton.path[at].starts_with(path + "/");
      if (!above) continue;
      theirs = theirs * glm::translate(glm::dmat4(1.0), skeleton.rest[i].translation) *
               glm::mat4_cast(skeleton.rest[i].rotation) *
               glm::scale(glm::dmat4(1.0), skeleton.rest[i].scale);
    }
    theirs = theirs * glm::inverse(skeleton.bind[at]) * skeleton.geom_bind;
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 4; ++r) EXPECT_NEAR(theirs[c][r], ours[c][r], 1e-12) << j;
  }
  // Vertices without weight stay where bind space has them.
  const glm::dmat4 still_joint =
      glm::inverse(skeleton.bind[skeleton.of_skin.back()]) * skeleton.geom_bind;
  for (int c = 0; c < 4; ++c) EXPECT_NEAR(still_joint[c][c], 1.0, 1e-12);
}

TEST(UsdSkeleton, RefusesABindMatrixThatCannotBeInverted) {
  Character character = usd_figure();
  character.joints[0].joint_from_mesh = glm::scale(glm::dmat4(1.0), glm::dvec3(1, 1, 0));
  EXPECT_THROW(usd_skeleton(character, still(character), false), CharacterError);
}

TEST(UsdText, WritesAValueThatNeverChangesOnceAndSamplesOtherwise) {
  const Character character = usd_figure();
  GlbAnimation animation = still(character, 3);
  const std::string resting = usd_text(character, animation, {}).text;
  EXPECT_EQ(count(resting, ".timeSamples"), 0u);
  // The whole body turns: rotations are sampled, scales are not.
  animation.world_from_node[2] = rest_of(character);
  const glm::dmat4 turn = glm::rotate(glm::dmat4(1.0), 0.3, {0, 1, 0});
  for (glm::dmat4& world : animation.world_from_node[2]) world = turn * world;
  const std::string turning = usd_text(character, animation, {}).text;
  EXPECT_EQ(count(turning, "half3[] scales = ["), 1u);
  const std::string samples = turning.substr(turning.find("quatf[] rotations.timeSamples = {"));
  for (const char* sample : {"1001: [", "1002: [", "1003: ["})
    EXPECT_EQ(count(samples, sample), 1u) << sample;
  EXPECT_NE(turning.find("endTimeCode = 1003"), std::string::npos);
}

TEST(UsdText, CountsScalesThatHalfPrecisionCannotHold) {
  const Character character = usd_figure();
  GlbAnimation animation = still(character, 2);
  EXPECT_EQ(usd_text(character, animation, {}).rounded_scales, 0u);
  for (glm::dmat4& world : animation.world_from_node[1])
    world = glm::scale(glm::dmat4(1.0), glm::dvec3(1.5)) * world;  // 1.5 is exact
  EXPECT_EQ(usd_text(character, animation, {}).rounded_scales, 0u);
  for (glm::dmat4& world : animation.world_from_node[1])
    world = glm::scale(glm::dmat4(1.0), glm::dvec3(1.1 / 1.5)) * world;
  const UsdText rounded = usd_text(character, animation, {});
  EXPECT_GT(rounded.rounded_scales, 0u);
  EXPECT_LT(rounded.worst_scale_error, std::ldexp(1.0, -11));  // half a unit in the last of 11 bits
  EXPECT_GT(rounded.worst_scale_error, 1e-5);
}

TEST(UsdText, HasAMeshForEachPartUnderNamesThatNoReaderRefuses) {
  Character character = usd_figure();
  const auto vertices = static_cast<std::uint32_t>(character.vertex_count());
  character.triangles = {{0, 1, 2}, {0, 2, 3}, {1, 2, 3}};
  character.parts = {{"Skeleton", 0, 0, 1, 0, vertices},
                     {"a b", 0, 1, 1, 0, vertices},
                     {"a:b", 0, 2, 1, 0, vertices},
                     {"none", 0, 3, 0, 0, vertices}};
  const std::string text = usd_text(character, still(character), {}).text;
  for (const char* mesh : {"def Mesh \"Skeleton_2\"", "def Mesh \"a_b\"", "def Mesh \"a_b_2\""})
    EXPECT_EQ(count(text, mesh), 1u) << mesh;
  EXPECT_EQ(count(text, "def Mesh"), 3u);
}

}  // namespace
}  // namespace backbend::skin
