// Bodies that do not fit their skeletons are found, by size, place and axes; healthy ones are not.
#include "skin/anatomy/import_checks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_inverse.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "skin/anatomy/driver_coverage.h"
#include "skin/character/part_owners.h"
#include "skin/gltf/gltf_reader.h"
#include "tests/skin/planted_weights.h"
#include "tests/skin/shared_characters.h"
#include "tests/skin/stick_figure.h"

namespace backbend::skin {
namespace {

/// The stick figure with its body moved, the skeleton left where it was.
Character moved_body(const glm::dmat4& motion) {
  Character character = stick_figure(3);
  for (glm::vec3& p : character.bind_position)
    p = glm::vec3(motion * glm::dvec4(glm::dvec3(p), 1.0));
  return character;
}

std::string code_of(const Character& character) {
  const auto facts = check_import(character);
  return facts.empty() ? "" : facts.front().code + (facts.front().impossible ? "!" : "");
}

TEST(ImportChecks, SayNothingOfABodyThatFits) {
  EXPECT_EQ(code_of(stick_figure()), "");
  EXPECT_EQ(code_of(stick_figure(8)), "");
  EXPECT_EQ(code_of(scaled(stick_figure(), 0.01)), "");
  EXPECT_EQ(code_of(scaled(stick_figure(), 100.0)), "");
  EXPECT_EQ(code_of(moved_body(glm::scale(glm::dmat4(1.0), glm::dvec3(1.3)))), "");
}

TEST(ImportChecks, RefuseABodyOfAnotherSize) {
  for (const double factor : {0.002, 0.01, 1.0 / 2.54, 2.54, 10.0, 100.0, 1000.0}) {
    const Character character = moved_body(glm::scale(glm::dmat4(1.0), glm::dvec3(factor)));
    EXPECT_EQ(code_of(character), "body_size!") << factor;
    EXPECT_THROW(require_possible_import(character), CharacterError);
    EXPECT_FALSE(find_anatomy(character).sure());
  }
  const auto facts = check_import(moved_body(glm::scale(glm::dmat4(1.0), glm::dvec3(100.0))));
  EXPECT_NE(facts.front().message.find("about 88 times"), std::string::npos)
      << facts.front().message;
  EXPECT_NE(facts.front().message.find("centimetres and metres"), std::string::npos);
  EXPECT_NE(facts.front().message.find("apply transforms"), std::string::npos);
  // In between nobody knows.
  const glm::dvec3 middle(0.0, 0.9, 0.0);
  const Character doubtful = moved_body(glm::translate(glm::dmat4(1.0), middle) *
                                        glm::scale(glm::dmat4(1.0), glm::dvec3(2.1)) *
                                        glm::translate(glm::dmat4(1.0), -middle));
  EXPECT_EQ(code_of(doubtful), "body_size");
  EXPECT_NO_THROW(require_possible_import(doubtful));
  EXPECT_FALSE(find_anatomy(doubtful).sure());
}

TEST(ImportChecks, RefuseABodyBesideItsSkeletonOrOnItsBack) {
  EXPECT_EQ(code_of(moved_body(glm::translate(glm::dmat4(1.0), glm::dvec3(2.0, 0, 0)))),
            "body_place!");
  EXPECT_EQ(code_of(moved_body(glm::translate(glm::dmat4(1.0), glm::dvec3(0, 0, 0.5)))),
            "body_place");
  EXPECT_EQ(code_of(moved_body(
                glm::rotate(glm::dmat4(1.0), -0.5 * 3.14159265358979, glm::dvec3(1, 0, 0)))),
            "body_axis!");
}

/// A monster of boxes: head, trunk and limbs of one joint each, the head the largest.
Character box_figure(double factor) {
  Character character;
  character.file_name = "boxes.glb";
  const int root = add_node(character, "root", -1, glm::dvec3(0.0));
  const auto add = [&](const std::string& name, int parent, const glm::dvec3& joint,
                       const glm::dvec3& low, const glm::dvec3& high, int steps) {
    const int node = add_node(character, name, parent, joint);
    character.joints.push_back({node, glm::translate(glm::dmat4(1.0), -joint)});
    Influences influences;
    influences.joint[0] = static_cast<std::uint16_t>(character.joints.size() - 1);
    influences.weight[0] = 1.0f;
    for (int k = 0; k < 8 * steps; ++k) {
      const glm::dvec3 corner(k & 1 ? high.x : low.x, k & 2 ? high.y : low.y,
                              k & 4 ? high.z : low.z);
      character.bind_position.emplace_back(factor * corner);
      character.bind_normal.emplace_back(0.0f, 0.0f, 1.0f);
      character.influences.push_back(influences);
      character.place.push_back(character.place_count++);
    }
    return node;
  };
  const int trunk = add("body", root, {0, 0.75, 0}, {-0.4, 0.7, -0.3}, {0.4, 1.8, 0.3}, 3);
  add("head", trunk, {0, 1.75, 0}, {-0.6, 1.7, -0.6}, {0.6, 3.6, 0.6}, 20);
  for (const double side : {1.0, -1.0}) {
    const std::string end = side > 0.0 ? ".L" : ".R";
    add("arm" + end, trunk, {0.45 * side, 1.7, 0}, {1.1 * side - 0.7, 1.5, -0.1},
        {1.1 * side + 0.7, 1.75, 0.1}, 6);
    add("leg" + end, root, {0.28 * side, 0.75, 0}, {0.28 * side - 0.1, 0.0, -0.1},
        {0.28 * side + 0.1, 0.78, 0.1}, 12);
  }
  return character;
}

TEST(ImportChecks, SayNothingOfTheSizeWhereJointsStandAmidWhatTheyMove) {
  EXPECT_EQ(code_of(box_figure(1.0)), "");
  EXPECT_EQ(code_of(box_figure(2.54)), "body_size!");
  EXPECT_EQ(code_of(box_figure(0.2)), "body_size!");
}

/// The figure with a part of its own: points around a place that a new node moves.
Character with_part(const char* parent, const glm::dvec3& pivot, const glm::dvec3& at, double reach,
                    std::uint32_t count = 20) {
  Character character = stick_figure(3);
  const int node = add_node(character, "prop", parent ? stick_node(character, parent) : -1, pivot);
  character.joints.push_back({node, glm::translate(glm::dmat4(1.0), -pivot)});
  Part part;
  part.first_vertex = static_cast<std::uint32_t>(character.vertex_count());
  part.vertex_count = count;
  character.parts.push_back(part);
  Influences influences;
  influences.joint[0] = static_cast<std::uint16_t>(character.joints.size() - 1);
  influences.weight[0] = 1.0f;
  for (std::uint32_t k = 0; k < count; ++k) {
    character.bind_position.emplace_back(at + reach * glm::dvec3(std::cos(k), 0.0, std::sin(k)));
    character.bind_normal.emplace_back(0.0f, 1.0f, 0.0f);
    character.influences.push_back(influences);
    character.place.push_back(character.place_count++);
  }
  return character;
}

TEST(Props, OfAHandWithAPivotAnywhereChangeNothing) {
  const Anatomy bare = find_anatomy(stick_figure(3));
  for (const bool of_two_materials : {false, true}) {
    Character character = with_part("hand.R", {2.5, 0.3, -4.0}, {-0.7, 1.3, 0.0}, 0.1);
    if (of_two_materials) {
      Part& barrel = character.parts.front();
      barrel.vertex_count = 8;
      Part stock = barrel;
      stock.first_vertex += 8;
      stock.vertex_count = 12;
      character.parts.push_back(stock);
    }
    const Anatomy armed = find_anatomy(character);
    EXPECT_TRUE(armed.sure());
    EXPECT_EQ(armed.left, bare.left);
    EXPECT_EQ(armed.forward, bare.forward);
    EXPECT_EQ(armed.spine, bare.spine);
    EXPECT_TRUE(armed.other_figures.empty());
  }
}

TEST(Props, MayHaveMoreVerticesThanTheBody) {
  const auto body = static_cast<std::uint32_t>(stick_figure(3).vertex_count());
  const Character armed = with_part("hand.R", {0.0, 0.0, 0.0}, {-0.7, 1.3, 0.0}, 0.1, 3 * body);
  EXPECT_EQ(code_of(armed), "");
  EXPECT_TRUE(find_anatomy(armed).sure());
  EXPECT_EQ(std::ranges::count(nodes_of_props(armed), true), 1);
  // Not where the body is of such parts itself, a fine head among them: a part for each joint.
  Character robot = with_part("head", {0.0, 1.5, 0.0}, {0.0, 1.6, 0.0}, 0.1, 3 * body);
  for (std::uint32_t v = 0; v < body; ++v) robot.parts.push_back({"piece", 0, 0, 0, v, 1});
  for (Influences& influences : robot.influences) influences.weight = {1.0f};
  EXPECT_EQ(std::ranges::count(nodes_of_props(robot), true), 0);
}

TEST(Props, OfTheSceneAreLeftOut) {
  const Anatomy bare = find_anatomy(stick_figure(3));
  const Character on_floor = with_part(nullptr, {0.0, -1.0, 0.0}, {0.0, -1.0, 0.0}, 40.0);
  const Anatomy found = find_anatomy(on_floor);
  EXPECT_TRUE(found.sure());
  EXPECT_EQ(found.spine, bare.spine);
  EXPECT_EQ(found.left_arm, bare.left_arm);
  EXPECT_EQ(found.right_leg, bare.right_leg);
  EXPECT_EQ(found.height, bare.height);
  EXPECT_EQ(found.other_figures, std::vector<int>{stick_node(on_floor, "prop")});
  // A floor does not hide that the body stands beside its skeleton.
  Character beside = on_floor;
  for (std::uint32_t v = 0; v < beside.parts.front().first_vertex; ++v)
    beside.bind_position[v].x += 2.0f;
  EXPECT_EQ(code_of(beside), "body_place!");
  // One that touches the body, such as a wig, stays.
  const Anatomy wig = find_anatomy(with_part(nullptr, {0.0, 1.5, 0.0}, {0.0, 1.5, 0.0}, 0.02));
  EXPECT_TRUE(wig.other_figures.empty());
  // Nor is hair that was never bound to the head scenery.
  const Anatomy loose = find_anatomy(with_part(nullptr, {0.0, 0.0, 0.0}, {0.0, 1.5, 0.0}, 0.02));
  EXPECT_TRUE(loose.other_figures.empty());
}

TEST(ImportChecks, NameAJointOutsideTheBody) {
  Character character = stick_figure(3);
  const int hand = stick_node(character, "hand.L");
  Node& node = character.nodes[static_cast<std::size_t>(hand)];
  node.world_from_node[3] = glm::dvec4(0.7, 2.2, 0.0, 1.0);
  for (SkinJoint& joint : character.joints)
    if (joint.node == hand) joint.joint_from_mesh = glm::affineInverse(node.world_from_node);
  const auto facts = check_import(character);
  ASSERT_FALSE(facts.empty());
  EXPECT_EQ(facts.back().code, "joint_outside");
  EXPECT_FALSE(facts.back().impossible);
  EXPECT_NE(facts.back().message.find("hand.L"), std::string::npos);
}

/// A strip of skin over the whole stick figure, so that all its joints are of one skin.
Character one_skin() {
  Character character = stick_figure(4);
  for (std::size_t v = 0; v < character.vertex_count(); ++v) {
    Influences& influences = character.influences[v];
    influences.joint[1] = character.influences[(v + 3) % character.vertex_count()].joint[0];
    influences.weight = {0.7f, 0.3f};
  }
  return character;
}

TEST(BindOff, IsFoundWithItsJointAndAngle) {
  EXPECT_TRUE(joints_bound_off(one_skin()).empty());
  for (const char* name : {"spine_2", "clavicle.L", "shin.R"})
    for (const double angle : {1.0, 5.0, 20.0}) {
      Character character = one_skin();
      turn_bind(character, stick_node(character, name), angle);
      const auto off = joints_bound_off(character);
      ASSERT_EQ(off.size(), 1u) << name << angle;
      EXPECT_EQ(off[0].node, stick_node(character, name));
      EXPECT_NEAR(off[0].angle_deg, angle, 1e-6);
      EXPECT_GT(off[0].shift, 0.0);
    }
}

TEST(BindOff, IsFoundInABodyOfRigidPiecesOfOnePart) {
  const auto turned = [](bool one_part) {
    Character character = stick_figure(4);
    const auto count = static_cast<std::uint32_t>(character.vertex_count());
    if (one_part)
      character.parts = {{"body", 0, 0, count / 3, 0, count}};
    else
      for (std::uint32_t v = 0; v < count; v += 3)
        character.parts.push_back({"piece", 0, v / 3, 1, v, 3});
    EXPECT_TRUE(joints_bound_off(character).empty());
    turn_bind(character, stick_node(character, "spine_2"), 5.0);
    return joints_bound_off(character);
  };
  const auto off = turned(true);
  ASSERT_EQ(off.size(), 1u);
  EXPECT_NEAR(off[0].angle_deg, 5.0, 1e-6);
  EXPECT_TRUE(turned(false).empty());  // each may have a skin of its own
}

TEST(BindOff, OfALastJointIsAnotherPlaceAndNotAnotherPose) {
  for (const char* name : {"head", "hand.L", "foot.R"}) {
    Character character = one_skin();
    const int node = stick_node(character, name);
    turn_bind(character, node, 10.0);
    EXPECT_TRUE(joints_bound_off(character).empty()) << name;
    character = one_skin();
    for (SkinJoint& joint : character.joints)
      if (joint.node == node)
        joint.joint_from_mesh =
            glm::translate(glm::dmat4(1.0), glm::dvec3(0.0, 0.05, 0.0)) * joint.joint_from_mesh;
    const auto off = joints_bound_off(character);
    ASSERT_EQ(off.size(), 1u) << name;
    EXPECT_EQ(off[0].node, node);
  }
}

TEST(BindOff, AreNoHipsThatTurnBelowAStillTrunk) {
  // About the way to the spine, which is turned back: the legs are carried along.
  const auto turned = [](bool with_legs) {
    Character character = one_skin();
    const int hips = stick_node(character, "hips");
    const glm::dvec3 at(character.nodes[static_cast<std::size_t>(hips)].world_from_node[3]);
    const glm::dmat4 turn = glm::translate(glm::dmat4(1.0), at) *
                            glm::rotate(glm::dmat4(1.0), 0.1, glm::dvec3(0.0, 1.0, 0.0)) *
                            glm::translate(glm::dmat4(1.0), -at);
    const auto move = [&](const char* name) {
      glm::dmat4& world =
          character.nodes[static_cast<std::size_t>(stick_node(character, name))].world_from_node;
      world = turn * world;
    };
    // The hips' parent is bound, too, and stays.
    Influences& any = character.influences.front();
    const int above = character.nodes[static_cast<std::size_t>(hips)].parent;
    character.joints.push_back(
        {above,
         glm::affineInverse(character.nodes[static_cast<std::size_t>(above)].world_from_node)});
    any.joint[1] = static_cast<std::uint16_t>(character.joints.size() - 1);
    move("hips");
    if (with_legs)
      for (const char* leg : {"thigh", "shin", "foot"})
        for (const char* side : {".L", ".R"}) move((std::string(leg) + side).c_str());
    return joints_bound_off(character);
  };
  EXPECT_TRUE(turned(true).empty());
  const auto off = turned(false);
  ASSERT_EQ(off.size(), 1u);
  EXPECT_NEAR(off[0].angle_deg, glm::degrees(0.1), 1e-6);
}

TEST(BindOff, IsNoPoseInWhichTheSkinWasBound) {
  // Every joint turned about its own origin, and what hangs from it along.
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Character character = one_skin();
    for (std::size_t n = 0; n < character.nodes.size(); ++n) {
      const double turn = 0.4 * std::sin(static_cast<double>(seed * 31 + n * 17));
      const glm::dvec3 at(character.nodes[n].world_from_node[3]);
      const glm::dmat4 motion =
          glm::translate(glm::dmat4(1.0), at) *
          glm::rotate(glm::dmat4(1.0), turn,
                      glm::normalize(glm::dvec3(1.0, std::sin(n + 1.0), std::cos(seed * n)))) *
          glm::translate(glm::dmat4(1.0), -at);
      std::vector<bool> below(character.nodes.size(), false);
      below[n] = true;
      for (std::size_t m = n; m < character.nodes.size(); ++m) {
        const int parent = character.nodes[m].parent;
        if (parent >= 0 && below[static_cast<std::size_t>(parent)]) below[m] = true;
        if (below[m])
          character.nodes[m].world_from_node = motion * character.nodes[m].world_from_node;
      }
    }
    EXPECT_TRUE(joints_bound_off(character).empty()) << seed;
  }
}

TEST(Facing, OfLeaningLegsIsTheFormats) {
  // Hind legs that end well before the hips, as foxes and deer stand: 34 degrees.
  Character character = stick_figure(3);
  for (const char* name : {"shin.L", "shin.R", "foot.L", "foot.R"}) {
    glm::dvec4& at =
        character.nodes[static_cast<std::size_t>(stick_node(character, name))].world_from_node[3];
    at.z += (0.88 - at.y) * std::tan(0.593);
  }
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_EQ(anatomy.up, glm::dvec3(0, 1, 0));
  EXPECT_EQ(anatomy.forward, glm::dvec3(0, 0, 1));
}

TEST(Facing, ThatIsNotTheFormatsIsNotSure) {
  Character character = stick_figure(3);
  const glm::dmat4 over = glm::rotate(glm::dmat4(1.0), 0.5 * 3.14159265358979, glm::dvec3(1, 0, 0));
  for (Node& node : character.nodes) node.world_from_node = over * node.world_from_node;
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_NEAR(anatomy.up.z, 1.0, 1e-12);
  EXPECT_FALSE(anatomy.sure());
  EXPECT_TRUE(find_anatomy(stick_figure(3)).sure());
}

TEST(Limbs, WhoseNamesAnExporterNumberedAreFound) {
  Character character = stick_figure(3);
  int number = 10;
  for (Node& node : character.nodes) {
    std::string& name = node.name;
    if (name.ends_with(".L"))
      name = "b_Left" + name.substr(0, name.size() - 2);
    else if (name.ends_with(".R"))
      name = "b_Right" + name.substr(0, name.size() - 2);
    name += "_" + std::to_string(++number);
  }
  const Anatomy found = find_anatomy(character), expected = find_anatomy(stick_figure(3));
  EXPECT_EQ(found.left_arm, expected.left_arm);
  EXPECT_EQ(found.right_leg, expected.right_leg);
}

/// A stick figure whose arms and legs hang elsewhere than on the body.
Character with_limbs_on(const std::string& root_of_left, const std::string& root_of_right) {
  Character character = stick_figure(3);
  const auto root = [&](const std::string& name) {
    return name == "scene" ? stick_node(character, "scene")
                           : add_node(character, name, -1, glm::dvec3(0.0));
  };
  const int left = root(root_of_left);
  const int right = root_of_right == root_of_left ? left : root(root_of_right);
  for (const char* limb : {"clavicle", "thigh"}) {
    const auto node = [&](const char* side) -> Node& {
      return character
          .nodes[static_cast<std::size_t>(stick_node(character, std::string(limb) + side))];
    };
    node(".L").parent = left;
    node(".R").parent = right;
  }
  // Skin from the body to each limb, as weights run in any character.
  const auto share = [&](const char* a, const char* b) {
    std::uint16_t joint_b = 0;
    for (std::size_t j = 0; j < character.joints.size(); ++j)
      if (character.joints[j].node == stick_node(character, b))
        joint_b = static_cast<std::uint16_t>(j);
    for (Influences& influences : character.influences)
      if (character.joints[influences.joint[0]].node == stick_node(character, a)) {
        influences.joint[1] = joint_b;
        influences.weight = {0.6f, 0.4f};
      }
  };
  share("clavicle.L", "spine_3");
  share("clavicle.R", "spine_3");
  share("thigh.L", "hips");
  share("thigh.R", "hips");
  // Parents stand before their children: the figure anew, in that order.
  Character sorted = character;
  std::vector<int> place(character.nodes.size(), -1);
  sorted.nodes.clear();
  while (sorted.nodes.size() < character.nodes.size())
    for (std::size_t n = 0; n < character.nodes.size(); ++n) {
      const int parent = character.nodes[n].parent;
      if (place[n] >= 0 || (parent >= 0 && place[static_cast<std::size_t>(parent)] < 0)) continue;
      place[n] = static_cast<int>(sorted.nodes.size());
      sorted.nodes.push_back(character.nodes[n]);
      if (parent >= 0) sorted.nodes.back().parent = place[static_cast<std::size_t>(parent)];
    }
  for (SkinJoint& joint : sorted.joints) joint.node = place[static_cast<std::size_t>(joint.node)];
  return sorted;
}

TEST(Limbs, OnRootsBesideTheSpineAreFoundAndNotStatic) {
  for (const auto& [left, right] : std::vector<std::pair<std::string, std::string>>{
           {"scene", "scene"}, {"mechanism", "mechanism"}, {"limbs_a", "limbs_b"}}) {
    const Character character = with_limbs_on(left, right);
    const Anatomy anatomy = find_anatomy(character);
    const auto first = [&](const std::vector<int>& chain) {
      return chain.empty() ? "" : character.nodes[static_cast<std::size_t>(chain.front())].name;
    };
    EXPECT_EQ(first(anatomy.left_arm), "clavicle.L") << left;
    EXPECT_EQ(first(anatomy.right_arm), "clavicle.R") << left;
    EXPECT_EQ(first(anatomy.left_leg), "thigh.L") << left;
    EXPECT_EQ(driver_coverage(character, anatomy).unreached.size(), 0u) << left;
  }
}

TEST(Limbs, OfASecondCopyOfTheSkeletonGoWithTheFirst) {
  // The arms' mesh came with a skeleton of its own: `hips.001` and so on, at the same places.
  Character character = stick_figure(3);
  const std::size_t count = character.nodes.size();
  std::vector<int> copy(count, -1);
  for (std::size_t n = 1; n < count; ++n) {
    const Node from = character.nodes[n];
    copy[n] = add_node(character, from.name + ".001",
                       from.parent > 0 ? copy[static_cast<std::size_t>(from.parent)] : -1,
                       glm::dvec3(from.world_from_node[3]));
  }
  for (SkinJoint& joint : character.joints) {
    const std::string& name = character.nodes[static_cast<std::size_t>(joint.node)].name;
    if (name.starts_with("arm") || name.starts_with("hand") || name.starts_with("spine_2"))
      joint.node = copy[static_cast<std::size_t>(joint.node)];
  }
  for (std::size_t n = count; n < character.nodes.size(); ++n)
    character.joints.push_back(
        {static_cast<int>(n), glm::affineInverse(character.nodes[n].world_from_node)});
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_TRUE(driver_coverage(character, anatomy).unreached.empty());
}

class RealImports : public ::testing::TestWithParam<const char*> {};

TEST_P(RealImports, FitTheirSkeletons) {
  REQUIRE_CHARACTER(GetParam());
  const Character character = read_character(shared_character(GetParam()));
  EXPECT_TRUE(find_anatomy(character).sure());
  EXPECT_TRUE(joints_bound_off(character).empty());
  for (const double factor : {1.0, 0.01, 100.0})
    EXPECT_EQ(code_of(scaled(character, factor)), "") << factor;
  for (const double factor : {0.002, 0.01, 0.3, 3.28, 100.0}) {
    Character broken = character;
    for (SkinJoint& joint : broken.joints)  // the body alone
      joint.joint_from_mesh =
          glm::affineInverse(broken.nodes[static_cast<std::size_t>(joint.node)].world_from_node) *
          glm::scale(glm::dmat4(1.0), glm::dvec3(factor)) *
          broken.nodes[static_cast<std::size_t>(joint.node)].world_from_node *
          joint.joint_from_mesh;
    EXPECT_EQ(code_of(broken), "body_size!") << factor;
  }
}

INSTANTIATE_TEST_SUITE_P(Files, RealImports,
                         ::testing::Values("mh_male_13k.glb", "mh_female_cmu_13k.glb",
                                           "quaternius_female_24k.glb", "bunny.glb",
                                           "cesium_man.glb", "apatosaurus.glb", "alpaca.glb",
                                           "snake.glb", "shark.glb"));

}  // namespace
}  // namespace backbend::skin
