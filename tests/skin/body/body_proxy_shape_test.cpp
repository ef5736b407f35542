// The solids around a skeleton, without making the mesh, are as thick as a body with such joints
// is.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <map>

#include "skin/body/body_proxy.h"
#include "skin/body/body_shape.h"
#include "skin/body/index.h"
#include "tests/skin/proxy_figures.h"

namespace backbend::skin {
namespace {

using namespace figures;

/// How far the surface is from `from` towards `way`.
double reach(const BodyShape& shape, const glm::dvec3& from, const glm::dvec3& way) {
  double s = 0.0;
  while (s < 1.0 && shape.value(from + s * way) < 0.0) s += 5e-4;
  return s;
}

TEST(ProxySolids, OfAHumanHasAHumansMeasures) {
  const Figure f = human();
  const BodyDescription body = describe_body(f.character, f.anatomy);
  const BodyShape shape(body);
  // In metres of the figure: the description's largest extent, foot to head, is 1.75.
  const double scale = 1.75 / (1.53 - 0.02);
  const glm::dvec3 hips = body.joints[z(f.anatomy.spine[0])].at;
  const auto at = [&](double x, double y, double zz) {
    return hips + scale * glm::dvec3(x, y - 0.93, zz);
  };
  const glm::dvec3 left(1, 0, 0), up(0, 1, 0), front(0, 0, 1);
  // Half breadths and depths, metres: ANSUR II's women, by and large; what is not a landmark may be
  // a third off.
  const struct {
    const char* what;
    glm::dvec3 from, way;
    double expected;
  } cases[] = {
      {"waist, breadth", at(0, 1.1, 0.01), left, 0.125},
      {"waist, depth", at(0, 1.1, 0.01), front, 0.085},
      {"waist, depth behind", at(0, 1.1, 0.01), -front, 0.085},
      {"hips, breadth", at(0, 0.95, 0), left, 0.165},
      {"hips, depth", at(0, 0.95, 0), front, 0.10},
      {"hips, depth behind", at(0, 0.95, 0), -front, 0.10},
      {"ribs, breadth", at(0, 1.26, 0.0), left, 0.145},
      {"ribs, depth", at(0, 1.26, 0.0), front, 0.10},
      {"ribs, depth behind", at(0, 1.26, 0.0), -front, 0.10},
      {"upper chest, depth", at(0, 1.37, -0.03), front, 0.08},
      {"neck, breadth", at(0, 1.47, -0.03), left, 0.055},
      {"neck, depth behind", at(0, 1.47, -0.03), -front, 0.06},
      {"head, breadth", at(0, 1.61, 0.01), left, 0.075},
      {"head, length before", at(0, 1.61, 0.01), front, 0.10},
      {"head, length behind", at(0, 1.61, 0.01), -front, 0.095},
      {"head, top", at(0, 1.61, 0.01), up, 0.10},
      {"thigh", at(0.092, 0.7, 0.003), front, 0.08},
      {"thigh, aside", at(0.092, 0.7, 0.003), left, 0.08},
      {"knee", at(0.1, 0.48, 0.01), front, 0.055},
      {"calf", at(0.102, 0.34, -0.005), front, 0.055},
      {"ankle", at(0.105, 0.09, -0.029), -front, 0.036},
      {"upper arm", at(0.285, 1.305, -0.045), front, 0.045},
      {"elbow", at(0.40, 1.24, -0.05), front, 0.038},
      {"forearm", at(0.47, 1.2, -0.04), front, 0.04},
      {"wrist", at(0.6, 1.126, -0.021), front, 0.027},
  };
  for (const auto& c : cases) {
    ASSERT_LT(shape.value(c.from), 0.0) << c.what;
    EXPECT_NEAR(reach(shape, c.from, c.way) / scale, c.expected, 0.35 * c.expected) << c.what;
  }
  // The crown, the soles and the tips of the fingers.
  EXPECT_NEAR(reach(shape, body.joints[z(f.anatomy.head)].at, up) / scale, 0.19, 0.05);
  EXPECT_NEAR((hips.y - shape.low().y) / scale, 0.93, 0.03);
  EXPECT_NEAR((shape.high().x - 3.0) / scale, 0.745, 0.02);
  // Between the legs, and between arm and trunk, there is air.
  for (const double y : {0.25, 0.48, 0.7}) EXPECT_GT(shape.value(at(0, y, 0)), 0.0) << y;
  EXPECT_GT(shape.value(at(0.3, 1.1, 0.0)), 0.01);
}

TEST(ProxySolids, OfADogIsDeepestAtTheRibsAndThinsTowardsTheTail) {
  const Figure f = dog();
  const BodyDescription body = describe_body(f.character, f.anatomy);
  const BodyShape shape(body);
  const double scale = 1.75 / (0.76 + 0.46);
  const auto half = [&](int joint, const glm::dvec3& way) {
    return reach(shape, body.joints[z(joint)].at, way) / scale;
  };
  const glm::dvec3 left(1, 0, 0), up(0, 1, 0);
  // A dog with a back of half a metre: 0.2 m wide at most, 0.25 m deep at the chest.
  EXPECT_NEAR(half(f.anatomy.spine[2], -up), 0.11, 0.04);
  EXPECT_NEAR(half(f.anatomy.spine[2], left), 0.085, 0.03);
  EXPECT_NEAR(half(f.anatomy.spine[1], left), 0.085, 0.03);
  EXPECT_GT(half(f.anatomy.spine[2], -up), half(f.anatomy.spine[2], up));
  EXPECT_NEAR(half(f.anatomy.spine[5], left), 0.045, 0.02);
  double thicker = 0.2;
  for (const int joint : f.anatomy.tail) {
    const double here = half(joint, left);
    EXPECT_LT(here, thicker + 1e-9);
    thicker = here;
  }
  EXPECT_LT(thicker, 0.02);
  EXPECT_LT(group_of(body, "tail")->parts[0].soften, group_of(body, "trunk")->parts[0].soften);
  // The head goes forwards from its joint.
  const BodySolid& head = group_of(body, "head")->parts[0];
  const glm::dvec3 joint = body.joints[z(f.anatomy.head)].at;
  EXPECT_NEAR(head.radii.x / scale, 0.045, 0.015);
  EXPECT_NEAR(head.radii.y / scale, 0.045, 0.015);
  EXPECT_NEAR(head.radii.z / scale, 0.08, 0.025);
  EXPECT_GT(head.center.z, joint.z + 0.3 * head.radii.z);
  EXPECT_LT(head.center.z, joint.z + head.radii.z);
  EXPECT_NEAR(head.center.x, joint.x, 1e-12);
  EXPECT_NEAR(head.center.y, joint.y, 0.3 * head.radii.y);
  for (const bool left_side : {true, false}) {
    // A hind leg's last bone is half a leg: the leg goes on to its end.
    const auto& hind = left_side ? f.anatomy.left_leg : f.anatomy.right_leg;
    const BodyGroup& leg = *group_of(body, left_side ? "left leg" : "right leg");
    EXPECT_EQ(leg.parts[0].axis.back(), body.joints[z(hind.back())].at);
    // A foreleg ends at the wrist: a stub goes on as its last bone does.
    const auto& fore = left_side ? f.anatomy.left_arm : f.anatomy.right_arm;
    const BodyGroup& arm = *group_of(body, left_side ? "left arm" : "right arm");
    const BodySolid& stub = arm.parts.back();
    const glm::dvec3 wrist = body.joints[z(fore.back())].at,
                     elbow = body.joints[z(fore[fore.size() - 2])].at;
    const double thick = arm.parts[0].sections.back().outer;
    ASSERT_EQ(stub.shape, BodySolid::Shape::cone);
    EXPECT_EQ(stub.joints, std::vector{fore.back()});
    EXPECT_EQ(stub.axis[0], wrist);
    EXPECT_LT(glm::distance(glm::normalize(stub.axis[1] - wrist), glm::normalize(wrist - elbow)),
              1e-9);
    EXPECT_NEAR(glm::distance(stub.axis[1], wrist), 3.0 * thick, 1.5 * thick);
    EXPECT_NEAR(stub.radius.x, thick, 0.25 * thick);
    EXPECT_EQ(stub.radius.y, stub.radius.x);
  }
}

TEST(ProxySolids, OfASnakeIsEvenlyThickToTheNeckAndThinsInTheTail) {
  const Figure f = snake();
  const BodyDescription body = describe_body(f.character, f.anatomy);
  const BodyShape shape(body);
  const double length = 1.75,
               at_rest = reach(shape, body.joints[z(f.anatomy.spine[4])].at, {0, 1, 0});
  // As a snake's: a thirtieth to a fiftieth of the whole, half of it to either side.
  EXPECT_GT(at_rest, 0.5 * length / 50.0);
  EXPECT_LT(at_rest, length / 30.0);
  for (int k = 0; k <= 5; ++k)
    EXPECT_NEAR(reach(shape, body.joints[z(f.anatomy.spine[z(k)])].at, {0, 1, 0}), at_rest,
                0.15 * at_rest)
        << k;
  double thicker = 1.1 * at_rest;
  for (std::size_t k = 0; k < f.anatomy.tail.size(); ++k) {
    const double here = reach(shape, body.joints[z(f.anatomy.tail[k])].at, {0, 1, 0});
    EXPECT_LE(here, thicker + 1e-9) << k;
    thicker = here;
  }
  EXPECT_NEAR(reach(shape, body.joints[z(f.anatomy.tail[2])].at, {0, 1, 0}), 0.85 * at_rest,
              0.15 * at_rest);
  EXPECT_NEAR(reach(shape, body.joints[z(f.anatomy.tail[4])].at, {0, 1, 0}), 0.6 * at_rest,
              0.2 * at_rest);
  EXPECT_LT(thicker, 0.3 * at_rest);
  // A flat head, wider and longer than the neck behind it.
  const BodySolid& head = group_of(body, "head")->parts[0];
  EXPECT_LT(head.radii.y, 0.9 * at_rest);
  EXPECT_GT(head.radii.x, at_rest);
  EXPECT_GT(head.radii.z, 1.4 * at_rest);
  EXPECT_LT(head.radii.z, 2.2 * at_rest);
  EXPECT_GT(head.center.z, body.joints[z(f.anatomy.head)].at.z);
  EXPECT_NEAR(head.center.x, body.joints[z(f.anatomy.head)].at.x, 1e-12);
  EXPECT_NEAR(head.center.y, body.joints[z(f.anatomy.head)].at.y, 0.5 * at_rest);

  // A root that stands apart from body and tail is inside neither: the body starts where the tail
  // comes nearest.
  Figure apart = f;
  Character& c = apart.character;
  c.nodes[z(apart.anatomy.spine[0])].world_from_node[3] = glm::dvec4(0, 0.6, 0.3, 1);
  const BodyDescription other = describe_body(c, apart.anatomy);
  EXPECT_NE(group_of(other, "trunk")->parts[0].joints.front(), apart.anatomy.spine[0]);
  EXPECT_EQ(other.core, group_of(other, "trunk")->parts[0].joints.front());
  EXPECT_EQ(group_of(other, "tail")->parts[0].joints.front(), other.core);
  // Without a tail it ends in itself.
  Figure short_one = f;
  short_one.anatomy.tail.clear();
  const BodyDescription tailless = describe_body(short_one.character, short_one.anatomy);
  EXPECT_EQ(group_of(tailless, "tail"), nullptr);
  const auto& sections = group_of(tailless, "trunk")->parts[0].sections;
  EXPECT_LT(sections.front().outer, 0.8 * sections[1].outer);
  EXPECT_GT(sections.front().outer, 0.4 * sections[1].outer);
}

TEST(ProxySolids, OfAFishIsAFishs) {
  const Figure f = fish();
  const BodyDescription body = describe_body(f.character, f.anatomy);
  const BodyShape shape(body);
  const double length = 1.75;
  const auto half = [&](int joint, const glm::dvec3& way) {
    return reach(shape, body.joints[z(joint)].at, way);
  };
  const glm::dvec3 left(1, 0, 0), up(0, 1, 0);
  // Higher than wide from the hips on, thinnest before the fin that ends it, which stands upright.
  const int hips = f.anatomy.spine[0];
  EXPECT_GT(half(hips, up), 1.05 * half(hips, left));
  EXPECT_LT(half(hips, up), 0.12 * length);
  double thicker = half(hips, left) + 1e-9;
  for (std::size_t k = 1; k + 1 < f.anatomy.spine.size(); ++k) {
    const double here = half(f.anatomy.spine[k], left);
    EXPECT_LT(here, thicker) << k;
    thicker = here;
  }
  const int end = f.anatomy.spine.back(), before = f.anatomy.spine[3];
  EXPECT_GT(half(end, up), 2.0 * half(before, up));
  EXPECT_GT(half(end, -up), 1.5 * half(before, -up));
  EXPECT_LT(half(end, left), 0.25 * half(end, up));
  // It runs on beyond its head, as far as it is thick, where no joint marks the snout.
  const BodySolid& fore = group_of(body, "fore")->parts[0];
  const glm::dvec3 head = body.joints[z(f.anatomy.head)].at;
  EXPECT_EQ(fore.axis.front(), body.joints[z(hips)].at);
  EXPECT_EQ(fore.joints.back(), f.anatomy.head);
  EXPECT_GT(fore.axis.back().z - head.z, 0.8 * half(hips, up));
  EXPECT_LT(fore.axis.back().z - head.z, 1.6 * half(hips, up));
  EXPECT_GT(half(f.anatomy.head, left), 0.25 * half(hips, left));
  EXPECT_LT(half(f.anatomy.head, left), 0.9 * half(hips, left));
  Figure marked = f;
  marked.add("ear", marked.anatomy.head, {0, 0.1, 0.4});
  marked.add("snout", marked.anatomy.head, {0, 0.02, 0.66});
  marked.add("gill", marked.anatomy.head, {0, 0.3, 0.45});  // square to the way out: no tip
  const BodyDescription with = describe_body(marked.character, marked.anatomy);
  EXPECT_EQ(group_of(with, "fore")->parts[0].axis.back(), with.joints[with.joints.size() - 2].at);
  // Fins: flat, wide near their root, their flat side across the body.
  for (const char* name : {"left arm", "right arm"}) {
    const BodySolid& fin = group_of(body, name)->parts[0];
    for (const BodySection& s : fin.sections) {
      EXPECT_LT(s.front, 0.4 * s.outer);
      EXPECT_GT(s.front, 0.2 * s.outer);
      EXPECT_EQ(s.front, s.back);
    }
    EXPECT_GT(fin.sections[0].outer, 0.15 * BodyCurve(fin.axis).length());
    EXPECT_LT(fin.sections[0].outer, 0.3 * BodyCurve(fin.axis).length());
    const glm::dvec3 out = glm::normalize(fin.axis.back() - fin.axis.front());
    EXPECT_NEAR(glm::dot(fin.front, out), 0.0, 1e-9);
    EXPECT_LT(std::abs(fin.front.z), 0.3);
    EXPECT_GT(std::abs(fin.front.y), 0.8);
  }
  EXPECT_EQ(group_of(body, "head"), nullptr);
}

}  // namespace
}  // namespace backbend::skin
