// The solids around a skeleton, without making the mesh: as thick as a body with such joints is,
// around every joint, and the same in any world.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <string>

#include "skin/body_proxy.h"
#include "skin/body_shape.h"

namespace backbend::skin {
namespace {

std::size_t z(int i) { return static_cast<std::size_t>(i); }

struct Figure {
  Character character;
  Anatomy anatomy;

  int add(const std::string& name, int parent, const glm::dvec3& at) {
    Node node;
    node.name = name;
    node.parent = parent;
    node.world_from_node[3] = glm::dvec4(at, 1.0);
    character.nodes.push_back(node);
    return static_cast<int>(character.nodes.size()) - 1;
  }
  std::vector<int> chain(const std::string& name, int parent, const std::vector<glm::dvec3>& at) {
    std::vector<int> out;
    for (std::size_t k = 0; k < at.size(); ++k)
      out.push_back(add(name + std::to_string(k), k == 0 ? parent : out.back(), at[k]));
    return out;
  }
};

/// A woman of 1.72 m in metres, arms held 30 degrees down, hands with two fingers each, one of
/// them of three bones, the last one tiny; feet that turn off forwards to a toe.
Figure human() {
  Figure f;
  const int root = f.add("world", -1, {0, 0, 0});
  f.anatomy.spine = f.chain("spine", root,
                            {{0, 0.93, 0},
                             {0, 1.03, 0.012},
                             {0, 1.13, 0.014},
                             {0, 1.25, 0.0},
                             {0, 1.42, -0.04},
                             {0, 1.47, -0.03},
                             {0, 1.53, 0.0}});
  f.anatomy.chest_index = 4;
  f.anatomy.head = f.anatomy.spine.back();
  for (const double s : {1.0, -1.0}) {
    const std::string end = s > 0.0 ? "_L" : "_R";
    auto& arm = s > 0.0 ? f.anatomy.left_arm : f.anatomy.right_arm;
    arm = f.chain("arm" + end, f.anatomy.spine[3],
                  {{0.02 * s, 1.38, 0.01},
                   {0.17 * s, 1.37, -0.04},
                   {0.40 * s, 1.24, -0.05},
                   {0.61 * s, 1.12, -0.02}});
    const auto finger =
        f.chain("index" + end, arm.back(),
                {{0.69 * s, 1.07, 0.01}, {0.73 * s, 1.045, 0.015}, {0.742 * s, 1.04, 0.016}});
    f.add("thumb" + end, arm.back(), {0.64 * s, 1.09, 0.035});
    f.add("pole" + end, arm.back(), {0.6 * s, 1.1, -0.7});  // no finger: it stands a leg away
    auto& leg = s > 0.0 ? f.anatomy.left_leg : f.anatomy.right_leg;
    leg = f.chain("leg" + end, f.anatomy.spine[0],
                  {{0.09 * s, 0.88, 0.0},
                   {0.10 * s, 0.48, 0.01},
                   {0.105 * s, 0.08, -0.03},
                   {0.115 * s, 0.02, 0.09}});
    f.add("toe" + end, leg.back(), {0.117 * s, 0.015, 0.15});
  }
  return f;
}

/// A dog: a level back from the hips forwards, a long neck, four legs, a tail.
Figure dog() {
  Figure f;
  f.anatomy.spine = f.chain("spine", -1,
                            {{0, 0.60, -0.35},
                             {0, 0.62, -0.20},
                             {0, 0.62, -0.02},
                             {0, 0.61, 0.15},
                             {0, 0.66, 0.28},
                             {0, 0.75, 0.38},
                             {0, 0.83, 0.46}});
  f.anatomy.chest_index = 3;
  f.anatomy.head = f.anatomy.spine.back();
  f.anatomy.tail = f.chain("tail", f.anatomy.spine[0],
                           {{0, 0.58, -0.42}, {0, 0.50, -0.55}, {0, 0.43, -0.65}, {0, 0.4, -0.76}});
  for (const double s : {1.0, -1.0}) {
    (s > 0.0 ? f.anatomy.left_leg : f.anatomy.right_leg) = f.chain("hind", f.anatomy.spine[0],
                                                                   {{0.07 * s, 0.55, -0.36},
                                                                    {0.08 * s, 0.34, -0.30},
                                                                    {0.08 * s, 0.17, -0.45},
                                                                    {0.08 * s, 0.03, -0.43}});
    (s > 0.0 ? f.anatomy.left_arm : f.anatomy.right_arm) =
        f.chain("fore", f.anatomy.spine[3],
                {{0.08 * s, 0.50, 0.16}, {0.085 * s, 0.31, 0.10}, {0.085 * s, 0.09, 0.12}});
  }
  return f;
}

/// A snake whose root stands beside its body, with a tail behind the spine's first joint.
Figure snake() {
  Figure f;
  std::vector<glm::dvec3> front, back;
  for (int k = 0; k <= 9; ++k) front.emplace_back(0.03 * std::sin(0.8 * k), 0.05, 0.12 * k);
  for (int k = 1; k <= 8; ++k) back.emplace_back(0.02 * std::sin(0.5 * k), 0.05, -0.12 * k);
  f.anatomy.spine = f.chain("spine", -1, front);
  f.anatomy.chest_index = 7;
  f.anatomy.head = f.anatomy.spine.back();
  f.anatomy.tail = f.chain("tail", f.anatomy.spine[0], back);
  return f;
}

/// A fish: hips in the middle, the spine runs to the tail's fin, the head is before the hips.
Figure fish() {
  Figure f;
  f.anatomy.spine = f.chain(
      "spine", -1, {{0, 0, 0}, {0, 0.01, -0.2}, {0, 0, -0.45}, {0, -0.01, -0.7}, {0, 0, -0.9}});
  f.anatomy.chest_index = 4;
  const auto front = f.chain("neck", f.anatomy.spine[0], {{0, 0.01, 0.24}, {0, 0.0, 0.45}});
  f.anatomy.head = front.back();
  for (const double s : {1.0, -1.0})
    (s > 0.0 ? f.anatomy.left_arm : f.anatomy.right_arm) =
        f.chain("fin", f.anatomy.spine[0], {{0.12 * s, -0.03, 0.2}, {0.3 * s, -0.07, 0.08}});
  return f;
}

const BodyGroup* group_of(const BodyDescription& body, const std::string& name) {
  for (const BodyGroup& group : body.groups)
    if (group.name == name) return &group;
  return nullptr;
}

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

TEST(ProxySolids, OfAHumanFollowsItsJoints) {
  const Figure f = human();
  const BodyDescription body = describe_body(f.character, f.anatomy);
  const auto node = [&](const std::string& name) {
    for (std::size_t n = 0; n < f.character.nodes.size(); ++n)
      if (f.character.nodes[n].name == name) return static_cast<int>(n);
    return -1;
  };
  std::vector<std::string> names;
  for (const BodyGroup& group : body.groups) names.push_back(group.name);
  EXPECT_EQ(names, (std::vector<std::string>{"trunk", "left arm", "right arm", "left leg",
                                             "right leg", "head"}));
  EXPECT_EQ(body.groups[0].parts[0].joints, f.anatomy.spine);
  EXPECT_EQ(body.core, f.anatomy.spine[0]);
  EXPECT_FALSE(body.symmetric);
  EXPECT_EQ(group_of(body, "head")->parts[0].joints, std::vector{f.anatomy.head});
  for (const std::string end : {"_L", "_R"}) {
    const BodyGroup& arm = *group_of(body, end == "_L" ? "left arm" : "right arm");
    // The collar bone is no part of the free arm, and hangs apart: trunk to collar, collar to arm.
    EXPECT_EQ(arm.parts[0].joints, (std::vector{node("arm" + end + "1"), node("arm" + end + "2"),
                                                node("arm" + end + "3")}));
    EXPECT_EQ(arm.parts[0].axis.size(), 3u);
    std::map<std::pair<int, int>, const BodySolid*> bones;
    for (std::size_t p = 1; p < arm.parts.size(); ++p) {
      const BodySolid& part = arm.parts[p];
      ASSERT_EQ(part.shape, BodySolid::Shape::cone);
      ASSERT_EQ(part.axis.size(), 2u);
      int from = -1, to = -1;
      for (std::size_t n = 0; n < body.joints.size(); ++n) {
        if (body.joints[n].at == part.axis[0]) from = static_cast<int>(n);
        if (body.joints[n].at == part.axis[1]) to = static_cast<int>(n);
      }
      bones[{from, to}] = &part;
      EXPECT_EQ(part.joints, std::vector{body.joints[z(to)].parent == from ? from : to});
    }
    const std::pair<std::string, std::string> expected[] = {
        {"arm" + end + "0", "arm" + end + "1"},
        {"arm" + end + "3", "index" + end + "0"},
        {"index" + end + "0", "index" + end + "1"},
        {"index" + end + "1", "index" + end + "2"},
        {"arm" + end + "3", "thumb" + end}};
    std::size_t found = 0;
    const double wrist = arm.parts[0].sections.back().outer;
    for (const auto& [from, to] : expected) {
      const auto bone = bones.find({node(from), node(to)});
      ASSERT_NE(bone, bones.end()) << from;
      ++found;
      if (from.rfind("arm" + end + "0", 0) == 0) continue;
      // A finger: thinner than the wrist, not thinner than a third of it or than a child's.
      EXPECT_LE(bone->second->radius.x, 0.76 * wrist);
      EXPECT_GE(bone->second->radius.x, std::max(0.34 * wrist, 0.0075));
      EXPECT_EQ(bone->second->radius.x, bone->second->radius.y);
    }
    // And one to the collar bone from the spine, where that is away from it.
    for (const auto& [ends, part] : bones)
      if (ends.second == node("arm" + end + "0")) ++found;
    EXPECT_EQ(bones.size(), found);
    EXPECT_EQ(bones.count({node("arm" + end + "3"), node("pole" + end)}), 0u);

    // The leg ends at the ankle; foot and toe are bones beyond it.
    const BodyGroup& leg = *group_of(body, end == "_L" ? "left leg" : "right leg");
    EXPECT_EQ(leg.parts[0].joints, (std::vector{node("leg" + end + "0"), node("leg" + end + "1"),
                                                node("leg" + end + "2")}));
    EXPECT_EQ(leg.parts[0].axis.back(), body.joints[z(node("leg" + end + "2"))].at);
    const auto ends_at = [&](const std::string& name) {
      return std::any_of(leg.parts.begin() + 1, leg.parts.end(), [&](const BodySolid& part) {
        return part.axis[1] == body.joints[z(node(name))].at;
      });
    };
    EXPECT_TRUE(ends_at("leg" + end + "3"));
    EXPECT_TRUE(ends_at("toe" + end));
  }
}

/// What holds for the solids of any body: sizes that are sizes, chains with their transitions, and
/// a surface around every joint of it that is not far from them.
void expect_plausible(const Figure& f, const BodyDescription& body, double slack) {
  const BodyShape shape(body);
  glm::dvec3 low(1e9), high(-1e9);
  const auto inside = [&](const std::vector<int>& chain) {
    for (const int node : chain) {
      const glm::dvec3& p = body.joints[z(node)].at;
      EXPECT_LT(shape.value(p), -0.002) << f.character.nodes[z(node)].name;
      low = glm::min(low, p);
      high = glm::max(high, p);
    }
  };
  const Anatomy& a = f.anatomy;
  for (const auto* chain :
       {&a.spine, &a.left_arm, &a.right_arm, &a.left_leg, &a.right_leg, &a.tail})
    inside(*chain);
  const glm::dvec3 extent = high - low;
  EXPECT_NEAR(std::max({extent.x, extent.y, extent.z}), 1.75, 1e-9);
  inside({a.head});
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LT(shape.high()[axis], high[axis] + slack) << axis;
    // The box is the same on both sides of x = 0.
    EXPECT_GT(axis == 0 ? low.x : shape.low()[axis], axis == 0 ? 0.0 : low[axis] - slack) << axis;
  }
  EXPECT_GT(low.x, slack);  // wholly beside the mirror plane
  for (const BodyGroup& group : body.groups) {
    EXPECT_GE(group.blend, 0.0);
    EXPECT_LT(group.blend, 0.15) << group.name;
    EXPECT_EQ(group.blend == 0.0, group.name == "trunk") << group.name;
    for (const BodySolid& part : group.parts) {
      EXPECT_FALSE(part.joints.empty());
      EXPECT_GT(part.soften, 0.0) << group.name;
      EXPECT_LT(part.soften, 0.13) << group.name;
      EXPECT_GT(part.blend, 0.0);
      EXPECT_LT(part.blend, 0.12) << group.name;
      if (part.shape == BodySolid::Shape::ellipsoid) {
        for (int axis = 0; axis < 3; ++axis) EXPECT_GT(part.radii[axis], 0.02);
        continue;
      }
      if (part.shape == BodySolid::Shape::cone) {
        EXPECT_GE(part.radius.x, 0.0075);
        EXPECT_LT(part.radius.x, 0.12) << group.name;
        continue;
      }
      ASSERT_GE(part.sections.size(), 3u);
      for (std::size_t k = 0; k < part.sections.size(); ++k) {
        const BodySection& s = part.sections[k];
        if (k > 0) {
          EXPECT_GT(s.at, part.sections[k - 1].at) << group.name;
        }
        EXPECT_EQ(s.outer, s.inner);
        for (const double radius : {s.outer, s.front, s.back}) {
          EXPECT_GE(radius, 0.005) << group.name << k;
          EXPECT_LT(radius, 0.3) << group.name << k;
        }
        EXPECT_EQ(s.square, 2.0);
      }
      const double length = BodyCurve(part.axis).length();
      EXPECT_NEAR(part.sections.back().at, length, 1e-9) << group.name;
      EXPECT_LE(part.sections.front().at, 1e-9);
      EXPECT_GT(part.sections.front().at, -0.2);
      for (const double cap : {part.cap.x, part.cap.y}) {
        EXPECT_GT(cap, 0.0);
        EXPECT_LT(cap, 0.2);
      }
      // The depth's direction is never near the axis.
      EXPECT_NEAR(glm::length(part.front), 1.0, 1e-9);
      for (int k = 0; k <= 32; ++k)
        EXPECT_GT(
            glm::length(glm::cross(BodyCurve(part.axis).tangent(length * k / 32.0), part.front)),
            0.35);
      if (part.transition.empty()) continue;
      ASSERT_EQ(part.transition.size(), part.joints.size() - 1);
      for (std::size_t i = 0; i < part.transition.size(); ++i) {
        const auto bone = [&](std::size_t k) {
          return glm::distance(body.joints[z(part.joints[k])].at,
                               body.joints[z(part.joints[k + 1])].at);
        };
        EXPECT_GT(part.transition[i], 0.01);
        EXPECT_LE(part.transition[i], 0.5 * bone(i) + 1e-12);
        if (i + 2 < part.joints.size()) {
          EXPECT_LE(part.transition[i], 0.5 * bone(i + 1) + 1e-12);
        }
        EXPECT_LE(part.transition[i], part.sections.front().outer);
      }
    }
  }
  // World and description say the same of every joint.
  for (std::size_t n = 0; n < body.joints.size(); ++n) {
    EXPECT_EQ(body.joints[n].parent, f.character.nodes[n].parent);
    EXPECT_EQ(body.joints[n].twin, static_cast<int>(n));
    EXPECT_LT(glm::distance(glm::dvec3(body.world_from_body * glm::dvec4(body.joints[n].at, 1.0)),
                            glm::dvec3(f.character.nodes[n].world_from_node[3])),
              1e-9);
  }
}

TEST(ProxySolids, IsPlausibleAroundAnySkeleton) {
  const struct {
    const char* name;
    Figure (*make)();
    double slack;
  } cases[] = {
      {"human", human, 0.25}, {"dog", dog, 0.3}, {"snake", snake, 0.13}, {"fish", fish, 0.3}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.name);
    const Figure f = c.make();
    expect_plausible(f, describe_body(f.character, f.anatomy), c.slack);
  }
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

/// All numbers of a description, in a frame.
std::vector<double> numbers(const BodyDescription& body, bool mirrored) {
  std::vector<double> out;
  const auto place = [&](const glm::dvec3& p) {
    out.insert(out.end(), {mirrored ? 6.0 - p.x : p.x, p.y, p.z});
  };
  for (const BodyGroup& group : body.groups) {
    out.push_back(group.blend);
    for (const BodySolid& part : group.parts) {
      out.insert(out.end(), {part.blend, part.soften, part.cap.x, part.cap.y, part.radius.x});
      for (const glm::dvec3& p : part.axis) place(p);
      if (part.shape == BodySolid::Shape::ellipsoid) place(part.center);
      for (const BodySection& s : part.sections)
        out.insert(out.end(), {s.at, s.outer, s.inner, s.front, s.back});
      out.insert(out.end(), part.transition.begin(), part.transition.end());
      out.insert(out.end(), {part.radii.x, part.radii.y, part.radii.z});
    }
  }
  return out;
}

TEST(ProxySolids, IsTheSameInAnyWorldAndMirrorsWithItsSkeleton) {
  for (Figure (*make)() : {human, dog, snake, fish}) {
    Figure f = make();
    // Nothing on one side as on the other, so that sides cannot be mixed up.
    for (std::size_t n = 0; n < f.character.nodes.size(); ++n)
      f.character.nodes[n].world_from_node[3].x *= 1.0 + 0.003 * static_cast<double>(n);
    const std::vector<double> here = numbers(describe_body(f.character, f.anatomy), false);

    Figure there = f;
    const glm::dmat4 world =
        glm::translate(glm::dmat4(1.0), glm::dvec3(5, -2, 30)) *
        glm::rotate(glm::dmat4(1.0), 1.1, glm::normalize(glm::dvec3(1, 2, -1))) *
        glm::scale(glm::dmat4(1.0), glm::dvec3(37.0));
    for (Node& node : there.character.nodes) node.world_from_node = world * node.world_from_node;
    const glm::dmat3 turn(glm::rotate(glm::dmat4(1.0), 1.1, glm::normalize(glm::dvec3(1, 2, -1))));
    there.anatomy.up = turn * there.anatomy.up;
    there.anatomy.left = turn * there.anatomy.left;
    there.anatomy.forward = turn * there.anatomy.forward;
    const std::vector<double> turned =
        numbers(describe_body(there.character, there.anatomy), false);
    ASSERT_EQ(turned.size(), here.size());
    for (std::size_t i = 0; i < here.size(); ++i) ASSERT_NEAR(turned[i], here[i], 1e-9) << i;

    // The mirror image of the skeleton, whose left and right are called as before.
    Figure image = f;
    const glm::dmat4 flip = glm::scale(glm::dmat4(1.0), glm::dvec3(-1, 1, 1));
    for (Node& node : image.character.nodes) node.world_from_node = flip * node.world_from_node;
    const std::vector<double> flipped =
        numbers(describe_body(image.character, image.anatomy), true);
    ASSERT_EQ(flipped.size(), here.size());
    for (std::size_t i = 0; i < here.size(); ++i) ASSERT_NEAR(flipped[i], here[i], 1e-9) << i;
  }
}

TEST(ProxySolids, TakesJointsThatFallTogetherForOne) {
  Figure f = human();
  const BodyDescription body = describe_body(f.character, f.anatomy);
  Figure twice = f;
  const int copy =
      twice.add("copy", twice.anatomy.spine[2],
                glm::dvec3(twice.character.nodes[z(f.anatomy.spine[2])].world_from_node[3]));
  twice.anatomy.spine.insert(twice.anatomy.spine.begin() + 3, copy);
  ++twice.anatomy.chest_index;
  EXPECT_EQ(numbers(describe_body(twice.character, twice.anatomy), false), numbers(body, false));
  // A chest on the hips has no length to go by.
  Figure flat = f;
  flat.anatomy.chest_index = 0;
  EXPECT_THROW(describe_body(flat.character, flat.anatomy), CharacterError);
  flat.anatomy.spine.resize(1);
  EXPECT_THROW(describe_body(flat.character, flat.anatomy), CharacterError);
}

TEST(ProxySolids, OfASpineThatEndsInTheChestNarrowsToItsEnd) {
  for (Figure (*make)() : {human, dog}) {
    Figure f = make();
    // The shoulders stand at the spine's end: nothing of it is a neck.
    f.anatomy.spine.resize(make == human ? 5 : 4);
    f.anatomy.chest_index = f.anatomy.spine.size() - 1;
    f.anatomy.head = f.anatomy.spine.back();
    const BodyDescription body = describe_body(f.character, f.anatomy);
    expect_plausible(f, body, 0.35);
    const auto& sections = group_of(body, "trunk")->parts[0].sections;
    const BodySection &ribs = sections[sections.size() - 2], &end = sections.back();
    EXPECT_LT(end.outer, 0.8 * ribs.outer);
    EXPECT_GT(end.outer, 0.4 * ribs.outer);
    for (const double depth : {end.front, end.back}) {
      EXPECT_LT(depth, 1.1 * end.outer);
      EXPECT_GT(depth, 0.75 * end.outer);
    }
  }
}

TEST(ProxySolids, ReachDownToHipsThatLieBelowTheSpine) {
  Figure f = human();
  const auto low_end = [&](double raised) {
    Figure other = f;
    other.character.nodes[z(f.anatomy.spine[0])].world_from_node[3].y += raised;
    const BodyDescription body = describe_body(other.character, other.anatomy);
    return group_of(body, "trunk")->parts[0].sections.front().at;
  };
  // A tenth of the back below the spine, or a third and more of the way down to the hip joints.
  const double scale = 1.75 / (1.53 - 0.02), back = scale * 0.5;
  EXPECT_NEAR(low_end(0.0), -0.1 * back, 0.02 * back);
  EXPECT_NEAR(low_end(-0.08), -0.1 * (back + 0.08 * scale), 0.02 * back);  // below its legs
  EXPECT_LT(low_end(0.2), -0.25 * 0.25 * scale);
  EXPECT_GT(low_end(0.2), -0.5 * 0.25 * scale);
}

TEST(ProxySolids, HaveAnAxisThatKeepsItsEndsAndSmoothsItsKinks) {
  for (Figure (*make)() : {human, dog}) {
    Figure f = make();
    // A back that turns off by a right angle in its middle.
    const std::vector<glm::dvec3> bent = {{0, 0.9, 0},    {0, 1.05, 0},   {0, 1.2, 0},
                                          {0, 1.2, 0.15}, {0, 1.2, 0.32}, {0, 1.2, 0.45},
                                          {0, 1.2, 0.6}};
    for (std::size_t k = 0; k < bent.size(); ++k)
      f.character.nodes[z(f.anatomy.spine[k])].world_from_node[3] = glm::dvec4(bent[k], 1.0);
    const BodyDescription body = describe_body(f.character, f.anatomy);
    const std::vector<glm::dvec3>& axis = group_of(body, "trunk")->parts[0].axis;
    const auto at = [&](std::size_t k) { return body.joints[z(f.anatomy.spine[k])].at; };
    ASSERT_EQ(axis.size(), 9u);
    EXPECT_LT(glm::distance(axis.front(), at(0)), 1e-12);
    EXPECT_LT(glm::distance(axis.back(), at(6)), 1e-12);
    double whole = 0.0;
    for (std::size_t k = 1; k < 7; ++k) whole += glm::distance(at(k - 1), at(k));
    double turned = 0.0;
    for (std::size_t k = 1; k < axis.size(); ++k) {
      // Cut into even pieces, and off the bones by no more than the corner is rounded.
      EXPECT_NEAR(glm::distance(axis[k - 1], axis[k]), whole / 8.0, 0.3 * whole / 8.0) << k;
      double off = INFINITY;
      for (std::size_t b = 1; b < 7; ++b)
        for (int s = 0; s <= 100; ++s)
          off = std::min(off, glm::distance(axis[k], glm::mix(at(b - 1), at(b), s / 100.0)));
      EXPECT_LT(off, 0.04 * whole);
      if (k < 2) continue;
      const double turn =
          glm::degrees(std::acos(std::clamp(glm::dot(glm::normalize(axis[k] - axis[k - 1]),
                                                     glm::normalize(axis[k - 1] - axis[k - 2])),
                                            -1.0, 1.0)));
      EXPECT_LT(turn, 65.0) << k;
      turned += turn;
    }
    EXPECT_NEAR(turned, 90.0, 3.0);
  }
  // A stub that turns off at the start is straightened: the axis comes from where it goes on.
  Figure f = human();
  f.character.nodes[z(f.anatomy.spine[0])].world_from_node[3] = glm::dvec4(0, 1.02, 0.1, 1);
  const BodyDescription body = describe_body(f.character, f.anatomy);
  const std::vector<glm::dvec3>& axis = group_of(body, "trunk")->parts[0].axis;
  EXPECT_LT(glm::distance(axis[1] - axis[0], axis[2] - axis[1]), 1e-12);
  EXPECT_GT(glm::normalize(axis[1] - axis[0]).y, 0.6);
}

TEST(ProxySolids, EndInAStubThatHangsWhereNoBoneSaysWhither) {
  for (const bool parentless : {false, true}) {
    Figure f = dog();
    const int wrist = f.anatomy.left_arm.back();
    const glm::dvec3 at(f.character.nodes[z(wrist)].world_from_node[3]);
    // A wrist that hangs from a helper in its own place, or from nothing at all.
    f.character.nodes[z(wrist)].parent =
        parentless ? -1 : f.add("helper", f.anatomy.left_arm[1], at);
    const BodyDescription body = describe_body(f.character, f.anatomy);
    const BodySolid& stub = group_of(body, "left arm")->parts.back();
    const glm::dvec3 way = stub.axis[1] - stub.axis[0];
    EXPECT_LT(glm::distance(glm::normalize(way), glm::dvec3(0, -1, 0)), 1e-9);
    const BodySolid& other = group_of(body, "right arm")->parts.back();
    EXPECT_GT(glm::length(glm::normalize(other.axis[1] - other.axis[0]) - glm::normalize(way)),
              0.05);
  }
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
