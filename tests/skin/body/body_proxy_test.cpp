#include "skin/body/body_proxy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <string>

#include "skin/deform/skinning.h"
#include "tests/skin/stick_figure.h"

namespace backbend::skin {
namespace {

const BodyOptions kSmall{4000};

double volume(const Character& body) {
  double sum = 0.0;
  for (const glm::uvec3& t : body.triangles) {
    sum += glm::dot(glm::dvec3(body.bind_position[t.x]),
                    glm::cross(glm::dvec3(body.bind_position[t.y]),
                               glm::dvec3(body.bind_position[t.z]))) /
           6.0;
  }
  return sum;
}

std::size_t open_edges(const Character& body) {
  std::map<std::pair<unsigned, unsigned>, int> sides;
  for (const glm::uvec3& t : body.triangles) {
    for (int k = 0; k < 3; ++k) ++sides[{t[k], t[(k + 1) % 3]}];
  }
  std::size_t wrong = 0;
  for (const auto& [side, count] : sides) {
    const auto back = sides.find({side.second, side.first});
    if (count != 1 || back == sides.end() || back->second != 1) ++wrong;
  }
  return wrong;
}

/// A skeleton in another world: turned, scaled and moved.
Character moved(Character c, const glm::dmat4& world) {
  for (Node& node : c.nodes) {
    node.world_from_node = world * node.world_from_node;
    if (node.parent < 0) node.parent_from_node = node.world_from_node;
  }
  return c;
}

/// Of the vertices that the named joint moves most: their mean, and how many there are.
std::pair<glm::dvec3, int> led_by(const Character& body, const std::string& joint) {
  glm::dvec3 sum(0.0);
  int count = 0;
  for (std::size_t v = 0; v < body.vertex_count(); ++v) {
    const int node = body.joints[body.influences[v].joint[0]].node;
    if (body.nodes[static_cast<std::size_t>(node)].name != joint) continue;
    sum += glm::dvec3(body.bind_position[v]);
    ++count;
  }
  return {count > 0 ? sum / static_cast<double>(count) : sum, count};
}

TEST(BodyProxy, IsAClosedBodyAroundTheSkeleton) {
  const Character figure = stick_figure(4);
  const Character body = make_proxy_body(figure, find_anatomy(figure), kSmall);
  EXPECT_EQ(open_edges(body), 0u);
  EXPECT_GT(volume(body), 0.0);
  EXPECT_NEAR(static_cast<double>(body.vertex_count()), 4000, 0.15 * 4000);
  const PosedMesh rest = rest_mesh(body);
  for (std::size_t v = 0; v < body.vertex_count(); ++v) {
    ASSERT_LT(glm::distance(rest.position[v], body.bind_position[v]), 1e-5f);
    float sum = 0.0f;
    for (const float w : body.influences[v].weight) sum += w;
    ASSERT_NEAR(sum, 1.0f, 3e-7f);
    ASSERT_EQ(body.influences[v].weight[4], 0.0f);
  }
}

TEST(BodyProxy, LetsEachPartFollowItsOwnJoint) {
  const Character figure = stick_figure(4);
  const Character body = make_proxy_body(figure, find_anatomy(figure), kSmall);
  for (const char* joint : {"hips", "spine_2", "head", "arm.L", "arm.R", "thigh.L", "shin.R"}) {
    const auto [middle, count] = led_by(body, joint);
    EXPECT_GT(count, 20) << joint;
    const glm::dvec3 place(
        figure.nodes[static_cast<std::size_t>(stick_node(figure, joint))].world_from_node[3]);
    EXPECT_LT(glm::distance(middle, place), 0.35) << joint;
    const char side = std::string(joint).back();
    if (side == 'L') {
      EXPECT_GT(middle.x, 0.0) << joint;
    } else if (side == 'R') {
      EXPECT_LT(middle.x, 0.0) << joint;
    }
  }
}

TEST(BodyProxy, IsTheSameBodyInAnotherWorld) {
  const Character figure = stick_figure(3);
  const Anatomy anatomy = find_anatomy(figure);
  const double here = volume(make_proxy_body(figure, anatomy, kSmall));
  // Centimetres, Z up, facing -Y, somewhere else.
  const glm::dmat4 world = glm::translate(glm::dmat4(1.0), glm::dvec3(500, -200, 30)) *
                           glm::rotate(glm::dmat4(1.0), glm::radians(90.0), glm::dvec3(1, 0, 0)) *
                           glm::scale(glm::dmat4(1.0), glm::dvec3(100.0));
  Anatomy turned = anatomy;
  turned.up = {0, 0, 1};
  turned.forward = {0, -1, 0};
  turned.left = {1, 0, 0};
  const Character there = make_proxy_body(moved(figure, world), turned, kSmall);
  EXPECT_EQ(open_edges(there), 0u);
  // Another grid cuts the same solids: 4000 vertices show their volume to half a per cent.
  // (The volume is taken about a vertex: floats far from the origin would drown it.)
  Character near = there;
  const glm::vec3 origin = there.bind_position[0];
  for (glm::vec3& p : near.bind_position) p -= origin;
  EXPECT_NEAR(volume(near) / 1e6, here, 0.005 * here);
  const auto [head, count] = led_by(there, "head");
  EXPECT_GT(count, 20);
  EXPECT_NEAR(head.z, 30 + 160, 25);
}

// An anatomy whose left is its mirror image's: what is put around it is not inside out.
TEST(BodyProxy, OfAMirroredSkeletonIsNotInsideOut) {
  const Character figure = stick_figure(3);
  Anatomy anatomy = find_anatomy(figure);
  anatomy.left = -anatomy.left;
  const Character there = make_proxy_body(
      moved(figure, glm::scale(glm::dmat4(1.0), glm::dvec3(-1, 1, 1))), anatomy, kSmall);
  EXPECT_EQ(open_edges(there), 0u);
  EXPECT_GT(volume(there), 0.0);
}

// The chest of a captured skeleton can end well below the shoulders.
TEST(BodyProxy, ReachesUpToTheShoulders) {
  Character figure = stick_figure(4);
  Anatomy anatomy = find_anatomy(figure);
  const auto top = [&] {
    double highest = 0.0;  // of the trunk's sections as thick as half its thickest
    for (const BodyGroup& group : describe_body(figure, anatomy).groups)
      if (group.name == "trunk") {
        double most = 0.0;
        for (const BodySection& each : group.parts[0].sections) most = std::max(most, each.outer);
        for (const BodySection& each : group.parts[0].sections)
          if (each.outer > 0.6 * most) highest = std::max(highest, each.at);
      }
    return highest;
  };
  const double whole = top();
  anatomy.chest_index = 2;
  EXPECT_GT(top(), 0.9 * whole);
}

TEST(BodyProxy, OfALimbThatEndsInABoneGoesToTheBonesEnd) {
  Character figure = stick_figure(4);
  const Anatomy anatomy = find_anatomy(figure);
  const auto lowest = [&] {
    double low = 1e9;
    for (const BodyGroup& group : describe_body(figure, anatomy).groups)
      if (group.name == "left leg")
        for (const glm::dvec3& p : group.parts[0].axis) low = std::min(low, p.y);
    return low;
  };
  const double before = lowest();
  const int last = anatomy.left_leg.back();
  const glm::dvec3 ankle(figure.nodes[static_cast<std::size_t>(last)].world_from_node[3]);
  for (const Node& node : figure.nodes) ASSERT_NE(node.parent, last);
  Node end;
  end.name = "end";
  end.parent = last;
  end.world_from_node[3] = glm::dvec4(ankle - glm::dvec3(0.0, 0.45, 0.0), 1.0);
  figure.nodes.push_back(end);
  EXPECT_LT(lowest(), before - 0.3);
}

TEST(BodyProxy, RefusesASkeletonOfOnePoint) {
  Character figure = stick_figure(3);
  const Anatomy anatomy = find_anatomy(figure);
  for (Node& node : figure.nodes) node.world_from_node[3] = glm::dvec4(1, 2, 3, 1);
  EXPECT_THROW(make_proxy_body(figure, anatomy, kSmall), CharacterError);
}

}  // namespace
}  // namespace backbend::skin
