// The solids around a skeleton follow its joints, whatever it is, and the same in any world.
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

}  // namespace
}  // namespace backbend::skin
