#include "skin/anatomy/mirror_image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/trigonometric.hpp>
#include <string>
#include <vector>

#include "tests/skin/stick_figure.h"

namespace backbend::skin {
namespace {

TEST(MirroredNodes, ArePairedWhereLimbsStartInTheMiddleUnderNamesWithoutSides) {
  // As Blender numbers bones: both clavicles start at the spine, and no name tells a side.
  Character figure = stick_figure();
  const int chest = stick_node(figure, "spine_2");
  const glm::dvec3 at(figure.nodes[static_cast<std::size_t>(chest)].world_from_node[3]);
  const int one = add_node(figure, "Bone.004", chest, at);
  const int one_out = add_node(figure, "Bone.005", one, at + glm::dvec3(0.2, 0.1, 0.0));
  const int two = add_node(figure, "Bone.008", chest, at);
  const int two_out = add_node(figure, "Bone.009", two, at + glm::dvec3(-0.2, 0.1, 0.0));
  for (const int node : {one, one_out, two, two_out}) stick_vertex(figure, node);
  const std::vector<int> image =
      mirrored_nodes(figure, mirror_of(figure, find_anatomy(stick_figure())));
  const auto of = [&](int node) { return image[static_cast<std::size_t>(node)]; };
  EXPECT_EQ(of(one), two);
  EXPECT_EQ(of(two), one);
  EXPECT_EQ(of(one_out), two_out);
  EXPECT_EQ(of(two_out), one_out);
  for (const char* name : {"hips", "spine_1", "spine_2", "neck", "head"})
    EXPECT_EQ(of(stick_node(figure, name)), stick_node(figure, name)) << name;
  EXPECT_EQ(of(stick_node(figure, "clavicle.L")), stick_node(figure, "clavicle.R"));
}

TEST(MirroredNodes, AreOfOneArmatureWhereAFileHasTwoOfTheSameNames) {
  const Character one = stick_figure();
  const auto count = static_cast<int>(one.nodes.size());
  const Mirror mirror = mirror_of(one, find_anatomy(one));
  // The other moves nothing, or another mesh; it stands first.
  for (const bool moves : {false, true}) {
    Character two = one;
    for (Node& node : two.nodes)
      if (node.parent >= 0) node.parent += count;
    two.nodes.insert(two.nodes.begin(), one.nodes.begin(), one.nodes.end());
    for (SkinJoint& joint : two.joints) joint.node += count;
    if (moves) two.joints.insert(two.joints.end(), one.joints.begin(), one.joints.end());
    const std::vector<int> image = mirrored_nodes(two, mirror);
    for (const char* name : {"clavicle", "arm", "hand", "thigh"}) {
      const int left = stick_node(one, std::string(name) + ".L"),
                right = stick_node(one, std::string(name) + ".R");
      EXPECT_EQ(image[static_cast<std::size_t>(left + count)], right + count) << name << moves;
      EXPECT_EQ(image[static_cast<std::size_t>(right + count)], left + count) << name << moves;
    }
  }
}

TEST(SurfaceMirror, TakesABodyThatLeansToASideOntoItself) {
  const Character figure = stick_figure();
  const Anatomy anatomy = find_anatomy(figure);
  // An egg of points, leaning by `degrees` around the forward axis and shifted.
  const auto egg = [](double degrees, const glm::dvec3& shift) {
    std::vector<glm::dvec3> out;
    const double a = glm::radians(degrees);
    for (int row = 1; row < 20; ++row)
      for (int k = 0; k < 24; ++k) {
        const double up = 0.085 * row, round = glm::radians(15.0 * k),
                     wide = 0.3 * std::sin(up / 1.7 * 3.14159) * (1.0 + 0.2 * std::cos(round));
        const double x = wide * std::sin(round), z = wide * std::cos(round);
        out.push_back(shift + glm::dvec3(x * std::cos(a) - up * std::sin(a),
                                         x * std::sin(a) + up * std::cos(a), z));
      }
    return out;
  };
  const Mirror straight = surface_mirror(figure, anatomy, egg(0.0, {}));
  EXPECT_EQ(straight.left, mirror_of(figure, anatomy).left);
  EXPECT_EQ(straight.middle, mirror_of(figure, anatomy).middle);
  const glm::dvec3 shift(0.02, 0.0, 0.0);
  const Mirror leaning = surface_mirror(figure, anatomy, egg(4.0, shift));
  const double a = glm::radians(4.0);
  EXPECT_NEAR(glm::distance(leaning.left, glm::dvec3(std::cos(a), std::sin(a), 0.0)), 0.0, 1e-6);
  EXPECT_NEAR(glm::dot(leaning.middle - shift, leaning.left), 0.0, 1e-6);
  // Nothing to hold a mirror against.
  EXPECT_EQ(surface_mirror(figure, anatomy, {}).left, mirror_of(figure, anatomy).left);
}

TEST(SpineIsInTheMiddle, UnlessAJointIsFarOff) {
  Character figure = stick_figure(3);
  const Anatomy anatomy = find_anatomy(figure);
  const Mirror mirror = mirror_of(figure, anatomy);
  EXPECT_TRUE(spine_is_in_the_middle(figure, anatomy, mirror));
  auto& place =
      figure.nodes[static_cast<std::size_t>(stick_node(figure, "spine_2"))].world_from_node[3];
  place.x += 0.015 * anatomy.spine_length;
  EXPECT_TRUE(spine_is_in_the_middle(figure, anatomy, mirror));
  place.x += 0.01 * anatomy.spine_length;
  EXPECT_FALSE(spine_is_in_the_middle(figure, anatomy, mirror));
  const glm::dmat3 axes = body_axes(anatomy, mirror);
  EXPECT_NEAR(glm::distance(axes[0], glm::dvec3(1, 0, 0)), 0.0, 1e-9);
  EXPECT_NEAR(glm::distance(axes[1], glm::dvec3(0, 1, 0)), 0.0, 1e-9);
  EXPECT_NEAR(glm::distance(axes[2], glm::dvec3(0, 0, 1)), 0.0, 1e-9);
}

}  // namespace
}  // namespace backbend::skin
