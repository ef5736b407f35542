// The whole road on a character: solve, drive, skin, measure. The character is made here, a round
// body with two straight arms, so that what is measured can be told beforehand.
#include "validate/metrics/surface/body_metrics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/matrix_inverse.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "validate/evidence/metric_heat.h"
#include "validate/judge/place.h"
#include "validate/metrics/surface/torso.h"

namespace backbend::validate {
namespace {

using solver::BodyPose;
using solver::Mapping;

/// A tube of radius 0.12 from hips (y 0.8) to neck (y 1.4) on six spine joints, capped by a head,
/// with an arm to each side at y 1.3. The arms hang from the neck, which ends the driven chain, or
/// from the joint below.
struct Figure {
  skin::Character character;
  skin::Anatomy anatomy;

  explicit Figure(int chest = 6) {
    add_joint("hips", -1, {0, 0.8, 0});
    for (int i = 1; i <= 5; ++i)
      add_joint("spine" + std::to_string(i), i - 1, {0, 0.8 + 0.1 * i, 0});
    add_joint("neck", 5, {0, 1.4, 0});  // 6
    add_joint("head", 6, {0, 1.5, 0});  // 7
    add_arm("l", 1.0, chest);           // 8..10
    add_arm("r", -1.0, chest);          // 11..13
    anatomy.spine = {0, 1, 2, 3, 4, 5, 6, 7};
    anatomy.chest = chest;
    anatomy.chest_index = static_cast<std::size_t>(chest);
    anatomy.neck_index = 6;
    anatomy.head = 7;
    anatomy.left_arm = {8, 9, 10};
    anatomy.right_arm = {11, 12, 13};
    anatomy.height = 1.0;
    anatomy.spine_length = 0.1 * chest;
    add_tube({0, 0.7, 0}, {0, 1, 0}, 0.9, 0.12, 90, 32, [](double along) {
      const double bone = std::clamp((along - 0.1) / 0.1 - 0.5, 0.0, 6.0);
      const int below = std::min(static_cast<int>(bone), 5);
      return std::tuple(below, below + 1, bone - below);
    });
    for (int side : {0, 1})
      add_tube({side ? -0.12 : 0.12, 1.3, 0}, {side ? -1.0 : 1.0, 0, 0}, 0.6, 0.04, 24, 12,
               [side](double along) {
                 return along < 0.3 ? std::tuple(side ? 12 : 9, side ? 13 : 10, 0.0)
                                    : std::tuple(side ? 12 : 9, side ? 13 : 10, 1.0);
               });
    character.place_count = static_cast<std::uint32_t>(character.bind_position.size());
  }

 private:
  void add_joint(const std::string& name, int parent, const glm::dvec3& at) {
    skin::Node node;
    node.name = name;
    node.parent = parent;
    node.world_from_node = glm::translate(glm::dmat4(1.0), at);
    node.parent_from_node =
        parent < 0 ? node.world_from_node
                   : glm::inverse(character.nodes[parent].world_from_node) * node.world_from_node;
    character.joints.push_back(
        {static_cast<int>(character.nodes.size()), glm::inverse(node.world_from_node)});
    character.nodes.push_back(node);
  }
  void add_arm(const std::string& side, double sign, int chest) {
    const int first = static_cast<int>(character.nodes.size());
    add_joint("clavicle_" + side, chest, {0.03 * sign, 1.3, 0});
    add_joint("upperarm_" + side, first, {0.14 * sign, 1.3, 0});
    add_joint("hand_" + side, first + 1, {0.6 * sign, 1.3, 0});
  }
  template <typename Weights>
  void add_tube(const glm::dvec3& from, const glm::dvec3& along, double length, double radius,
                int rings, int sides, Weights weights) {
    const auto first = static_cast<std::uint32_t>(character.bind_position.size());
    const glm::dvec3 a = std::abs(along.y) > 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 b = glm::cross(along, a);
    const auto add = [&](double at, const glm::dvec3& offset, const glm::dvec3& normal) {
      const auto [below, above, share] = weights(at);
      character.bind_position.push_back(glm::vec3(from + along * at + offset));
      character.bind_normal.push_back(glm::vec3(normal));
      character.place.push_back(static_cast<std::uint32_t>(character.place.size()));
      skin::Influences i;
      i.joint = {static_cast<std::uint16_t>(share > 0.5 ? above : below),
                 static_cast<std::uint16_t>(share > 0.5 ? below : above)};
      i.weight = {static_cast<float>(std::max(share, 1.0 - share)),
                  static_cast<float>(std::min(share, 1.0 - share))};
      character.influences.push_back(i);
    };
    for (int r = 0; r <= rings; ++r)
      for (int k = 0; k < sides; ++k) {
        const double angle = 2.0 * kPi * k / sides;
        const glm::dvec3 normal = a * std::cos(angle) + b * std::sin(angle);
        add(length * r / rings, radius * normal, normal);
      }
    add(0.0, glm::dvec3(0), -along);
    add(length, glm::dvec3(0), along);
    const auto at = [&](int r, int k) {
      return first + static_cast<std::uint32_t>(r * sides + k % sides);
    };
    for (int r = 0; r < rings; ++r)
      for (int k = 0; k < sides; ++k) {
        character.triangles.push_back({at(r, k), at(r, k + 1), at(r + 1, k)});
        character.triangles.push_back({at(r, k + 1), at(r + 1, k + 1), at(r + 1, k)});
      }
    const std::uint32_t bottom = at(rings, sides - 1) + 1;
    for (int k = 0; k < sides; ++k) {
      character.triangles.push_back({bottom, at(0, k + 1), at(0, k)});
      character.triangles.push_back({bottom + 1, at(rings, k), at(rings, k + 1)});
    }
  }
};

struct Measured {
  Figure figure{};
  skin::SpineDriver driver{figure.character, figure.anatomy};
  BodyMetrics metrics{figure.character, figure.anatomy, driver};

  BodyMeasures pose(const std::string& system, const BodyPose& body,
                    std::map<std::string, solver::OptionValue> options = {}) const {
    const auto rig = build_system({system, std::move(options)}, driver.rest_chain());
    const std::vector<double> control = rig->controls_for(body, Mapping::chest);
    const solver::SpinePose pose = rig->solve(control);
    const skin::PosedMesh mesh = skin::skin(figure.character, driver.drive(*rig, pose));
    return metrics.measure(rig_at_rest(*rig), control, pose, mesh, body.twist);
  }
};

TEST(BodyMetrics, TakeTheArmsOffAndKeepTheTorsoWhole) {
  const Measured m;
  EXPECT_EQ(m.metrics.slices().measured(), 64u);
  const std::vector<std::uint8_t> torso =
      torso_mask(m.figure.character, m.figure.anatomy, m.figure.character.bind_position);
  for (std::size_t v = 0; v < torso.size(); ++v) {
    const glm::vec3& p = m.figure.character.bind_position[v];
    if (std::abs(p.x) > 0.2f) {
      EXPECT_FALSE(torso[v]) << v;
    }
    // The arms are tubes of their own, which begin inside the torso's.
    const auto& joint = m.figure.character.joints[m.figure.character.influences[v].joint[0]];
    const bool of_arm = std::ranges::count(m.figure.anatomy.left_arm, joint.node) +
                            std::ranges::count(m.figure.anatomy.right_arm, joint.node) >
                        0;
    if (of_arm) {
      EXPECT_FALSE(torso[v]) << v;
    } else if (std::abs(p.x) < 0.121f && p.y > 0.85f && p.y < 1.35f) {
      EXPECT_TRUE(torso[v]) << v;
    }
  }
  EXPECT_NEAR(glm::length(m.metrics.rest_slices().area[20]), kPi * 0.12 * 0.12, 1e-3);
}

TEST(BodyMetrics, AtRestEverythingIsIdeal) {
  const Measured m;
  for (const char* system : {"three_bone", "curve", "isner", "even"}) {
    const BodyMeasures b = m.pose(system, {});
    EXPECT_LT(b.chain.kink_deg, 1e-6) << system;
    EXPECT_LT(b.slices.kink_worst_deg, 1e-2) << system;
    EXPECT_NEAR(b.slices.least_area_ratio, 1.0, 1e-5) << system;
    EXPECT_NEAR(b.surface.stretch, 1.0, 1e-3) << system;
    EXPECT_LT(b.arm_drift, 1e-6) << system;
    EXPECT_EQ(b.surface.inverted, 0u) << system;
  }
}

TEST(BodyMetrics, TheIdealBendComparedWithItselfIsADraw) {
  const Measured m;
  const BodyMeasures even = m.pose("even", {.extension = 1.2});
  const MeshExcess excess = mesh_excess(even, even, m.metrics.window());
  EXPECT_EQ(excess.kink_deg, 0.0);
  EXPECT_EQ(excess.area_loss, 0.0);
  EXPECT_EQ(excess.strain, 0.0);
}

TEST(BodyMetrics, TheOvershootingChainIsSeenOnTheMeshToo) {
  const Measured m;
  const BodyPose body{.extension = radians_from(90.0)};
  const BodyMeasures ideal = m.pose("even", body);
  const BodyMeasures bad = m.pose("curve", body, {{"length", std::string("rest")}});
  const BodyMeasures good = m.pose("curve", body);
  EXPECT_GT(mesh_excess(bad, ideal, m.metrics.window()).kink_deg, 20.0);
  EXPECT_LT(mesh_excess(good, ideal, m.metrics.window()).kink_deg, 8.0);
  EXPECT_LT(ideal.slices.kink_worst_deg, 8.0);
}

TEST(BodyMetrics, AFlippedTopWringsTheMeshAndThrowsTheArms) {
  const Measured m;
  const BodyMeasures before = m.pose("isner", {.extension = radians_from(99.0)});
  const BodyMeasures after = m.pose("isner", {.extension = radians_from(120.0)});
  EXPECT_GT(after.slices.twist_jump_worst_deg, 90.0);
  EXPECT_LT(before.slices.twist_jump_worst_deg, 1.0);
  EXPECT_LT(after.slices.least_area_ratio, 0.3);
  EXPECT_GT(before.slices.least_area_ratio, 0.7);
  EXPECT_GT(after.arm_drift, 0.5);
}

TEST(BodyMetrics, ArmsOnTheTopControlDoNotDriftAndOnTheEffectorTheyDo) {
  const Measured m;
  const BodyPose body{.extension = radians_from(60.0)};
  EXPECT_LT(m.pose("even", body).arm_drift, 1e-5);
  EXPECT_LT(m.pose("curve", body, {{"arms", std::string("top")}}).arm_drift, 1e-5);
  EXPECT_GT(m.pose("curve", body).arm_drift, 0.003);
}

// On the mesh the arms ride on the ribs: what is read is where the rig's own arm parent would have
// taken them.
TEST(BodyMetrics, APlantedArmDriftIsReadWithItsSize) {
  const Measured m;
  const auto rig = build_system({"even", {}}, m.driver.rest_chain());
  const std::vector<double> control = rig->controls_for({.extension = 0.7}, Mapping::chest);
  const solver::SpinePose clean = rig->solve(control);
  const auto read = [&](const solver::SpinePose& pose) {
    const skin::PosedMesh mesh = skin::skin(m.figure.character, m.driver.drive(*rig, pose));
    return m.metrics.measure(rig_at_rest(*rig), control, pose, mesh, 0.0).arm_drift;
  };
  EXPECT_LT(read(clean), 1e-9);
  for (const double shift : {0.001, 0.01, 0.05}) {
    solver::SpinePose pose = clean;
    pose.arms.posed_origin += glm::dvec3(0.0, 0.6 * shift, 0.8 * shift);
    EXPECT_NEAR(read(pose), shift, 1e-9);  // the figure is 1 high
  }
  // Turned about the line through the chain's end along Y: the hand's tip stands 0.72 aside, its
  // radius is 0.04.
  for (const double turn : {0.01, 0.1}) {
    solver::SpinePose pose = clean;
    pose.arms.turn = clean.arms.turn * rotation({0.0, turn, 0.0});
    EXPECT_NEAR(read(pose), 2.0 * std::sin(0.5 * turn) * std::hypot(0.72, 0.04), 1e-6);
  }
}

TEST(BodyMetrics, SlicesGoOnAsFarAsTheLastJointBends) {
  // The chain ends at y 1.3, the neck starts at 1.4: 1.2 of the chain's length.
  const Measured m{Figure(5)};
  EXPECT_NEAR(m.metrics.slices().slice.front().s, 0.05, 1e-6);
  EXPECT_NEAR(m.metrics.slices().slice.back().s, 0.95 * 1.2, 1e-6);
  Finding last;
  last.slice = 63;
  PlaceNames(m.figure.character, m.figure.anatomy, &m.metrics).name({}, last);
  EXPECT_EQ(last.between, (std::array<std::string, 2>{"spine5", "neck"}));
  // Beyond the chest nothing is measured: a twist that ends there is not wringing above it.
  const BodyMeasures still = m.pose("even", {});
  EXPECT_LT(still.slices.kink_worst_deg, 1e-2);
  const BodyMeasures twisted = m.pose("even", {.twist = radians_from(30.0)});
  EXPECT_GT(twisted.slices.measured, 60u);
  EXPECT_GT(twisted.slices.least_area_ratio, 0.95);
  // A surface that is torn between ribs and neck is seen, though no joint of the chain is there.
  const auto torn = [](const Measured& on) {
    const auto rig = build_system({"even", {}}, on.driver.rest_chain());
    const std::vector<double> control = rig->controls_for({}, Mapping::chest);
    const solver::SpinePose pose = rig->solve(control);
    skin::PosedMesh mesh = skin::skin(on.figure.character, on.driver.drive(*rig, pose));
    const glm::dvec3 pivot(0, 1.345, 0);
    const glm::dquat turn = rotation({0.0, 0.0, 0.5});
    for (glm::vec3& p : mesh.position)
      if (p.y > pivot.y && std::abs(p.x) < 0.121f)
        p = glm::vec3(pivot + turn * (glm::dvec3(p) - pivot));
    return on.metrics.measure(rig_at_rest(*rig), control, pose, mesh, 0.0).surface.strain_most;
  };
  Figure to_the_chest(5);
  to_the_chest.anatomy.neck_index = 0;
  EXPECT_LT(torn(Measured{to_the_chest}), 1.1);
  EXPECT_GT(torn(m), 2.0);
}

TEST(BodyMetrics, APropAroundTheBodyIsNoSliceOfIt) {
  // A hoop around the chest, on a node of its own that hangs from the hips.
  constexpr std::uint32_t kRows = 4, kSides = 24;
  const auto slices_of_hoop = [&](bool is_part) {
    Figure hooped(5);
    skin::Character& character = hooped.character;
    const int hips = hooped.anatomy.spine.front();
    skin::Node hoop = character.nodes[static_cast<std::size_t>(hips)];
    hoop.name = "hoop";
    hoop.parent = hips;
    hoop.parent_from_node = glm::dmat4(1.0);
    const int node = static_cast<int>(character.nodes.size());
    character.nodes.push_back(hoop);
    character.joints.push_back({node, glm::affineInverse(hoop.world_from_node)});
    skin::Influences influences;
    influences.joint[0] = static_cast<std::uint16_t>(character.joints.size() - 1);
    influences.weight[0] = 1.0f;
    const auto first = static_cast<std::uint32_t>(character.vertex_count());
    for (std::uint32_t r = 0; r <= kRows; ++r)
      for (std::uint32_t k = 0; k < kSides; ++k) {
        const double angle = 2.0 * 3.14159265358979 * k / kSides;
        character.bind_position.emplace_back(0.3 * std::cos(angle), 1.1 + 0.05 * r,
                                             -0.3 * std::sin(angle));
        character.bind_normal.emplace_back(std::cos(angle), 0.0, -std::sin(angle));
        character.influences.push_back(influences);
        character.place.push_back(character.place_count++);
      }
    for (std::uint32_t r = 0; r < kRows; ++r)
      for (std::uint32_t k = 0; k < kSides; ++k) {
        const std::uint32_t a = first + r * kSides + k, b = first + r * kSides + (k + 1) % kSides;
        character.triangles.emplace_back(a, b, a + kSides);
        character.triangles.emplace_back(b, b + kSides, a + kSides);
      }
    character.parts.clear();
    if (is_part) {
      skin::Part part;
      part.first_vertex = first;
      part.vertex_count = (kRows + 1) * kSides;
      character.parts.push_back(part);
    }
    const Measured measured{hooped};
    return std::ranges::count_if(measured.metrics.slices().slice, [&](const Slice& slice) {
      return !slice.ring.empty() && slice.ring.front().a >= first;
    });
  };
  EXPECT_EQ(slices_of_hoop(true), 0);
  EXPECT_GT(slices_of_hoop(false), 10);  // of the body's own part it is a dress
}

// What moves as one body is left out of the search: it must not be where anything happens.
TEST(BodyMetrics, FindTheSameSelfIntersectionsAsTryingTheWholeMesh) {
  const Measured m;
  const skin::Character& character = m.figure.character;
  const SelfIntersection whole(character.bind_position, character.triangles, character.place);
  double most = 0.0;
  for (const char* system : {"even", "isner", "curve"})
    for (const BodyPose& body : {BodyPose{.extension = 1.0}, BodyPose{.extension = 3.1},
                                 BodyPose{.flexion = 2.9, .twist = 0.8}, BodyPose{.side = 2.5}}) {
      const auto rig = build_system({system, {}}, m.driver.rest_chain());
      const solver::SpinePose pose = rig->solve(rig->controls_for(body, Mapping::chest));
      const skin::PosedMesh mesh = skin::skin(character, m.driver.drive(*rig, pose));
      const double expected = whole.measure(mesh.position).area;
      EXPECT_NEAR(m.pose(system, body).crossing, expected, 1e-9) << system;
      most = std::max(most, expected);
    }
  EXPECT_GT(most, 0.01);
  EXPECT_EQ(m.pose("even", {.extension = 0.5}).crossing, 0.0);
}

/// One pose measured as what its nodes make of it, and as a mesh whose parts may be deformed.
struct BothWays {
  BodyMeasures blended, deformed;
};
BothWays both_ways(const Measured& m, const std::string& system, const BodyPose& body) {
  const auto rig = build_system({system, {}}, m.driver.rest_chain());
  const std::vector<double> control = rig->controls_for(body, Mapping::chest);
  const solver::SpinePose pose = rig->solve(control);
  const std::vector<glm::dmat4> world = m.driver.drive(*rig, pose);
  const skin::PosedMesh mesh = skin::skin(m.figure.character, world);
  const auto measured = [&](Deformers deformers) {
    return m.metrics.measure(rig_at_rest(*rig), control, pose, mesh, body.twist, false,
                             Crossing::measured, world, deformers);
  };
  return {measured(Deformers::none), measured(Deformers::added)};
}

TEST(BodyMetrics, OfPartsThatMoveAsOneAreThoseOfTheWholeMesh) {
  const Measured m;
  const MeshRest& mesh = m.metrics.mesh();
  ASSERT_TRUE(mesh.open_reason.empty());
  EXPECT_LT(mesh.bending_blocks, mesh.block.size() * 3 / 4);
  EXPECT_LT(mesh.bending_corners, mesh.vertex.size() * 3 / 4);
  // The hips' end, the head, and the arms, which go with it.
  ASSERT_EQ(mesh.piece.size(), 2u);
  for (const MeshRest::Piece& piece : mesh.piece) EXPECT_GT(piece.rim_count, 30u);
  std::size_t inverted = 0;
  for (const char* system : {"even", "isner", "three_bone"})
    for (const BodyPose& body :
         {BodyPose{}, BodyPose{.extension = 1.0}, BodyPose{.extension = 3.1},
          BodyPose{.flexion = 2.9, .twist = 0.8}, BodyPose{.side = 2.5}, BodyPose{.twist = 3.0}}) {
      const auto [own, whole] = both_ways(m, system, body);
      const std::string what = system + std::string(" ") + std::to_string(body.extension) + " " +
                               std::to_string(body.side) + " " + std::to_string(body.twist);
      EXPECT_EQ(own.surface.inverted, whole.surface.inverted) << what;
      EXPECT_EQ(own.surface.inverted_area, whole.surface.inverted_area) << what;
      EXPECT_EQ(own.surface.inverted_vertex, whole.surface.inverted_vertex) << what;
      EXPECT_EQ(own.surface.strain, whole.surface.strain) << what;
      EXPECT_EQ(own.surface.strain_most, whole.surface.strain_most) << what;
      EXPECT_NEAR(own.surface.stretch, whole.surface.stretch, 1e-5) << what;
      EXPECT_NEAR(own.surface.dihedral_deg, whole.surface.dihedral_deg, 0.02) << what;
      EXPECT_NEAR(own.surface.volume_change, whole.surface.volume_change, 1e-6) << what;
      EXPECT_EQ(own.crossing, whole.crossing) << what;
      inverted += whole.surface.inverted;
      if (whole.surface.stretch > 1.01) {
        EXPECT_EQ(own.surface.stretch_vertex, whole.surface.stretch_vertex) << what;
      }
      if (whole.surface.dihedral_deg > 1.0) {
        EXPECT_EQ(own.surface.dihedral_vertex, whole.surface.dihedral_vertex) << what;
      }
    }
  EXPECT_GT(inverted, 100u);
}

// A studio's own rig moves the limbs, too: nothing may be taken for granted of them.
TEST(BodyMetrics, OfAnArmThatARigBringsIntoTheOtherAreThoseOfTheWholeMesh) {
  const Measured m;
  const skin::Character& character = m.figure.character;
  const auto rig = build_system({"even", {}}, m.driver.rest_chain());
  const std::vector<double> control = rig->controls_for({.extension = 0.3}, Mapping::chest);
  const auto with = [&](double arm_turn, double scale) {
    solver::SpinePose pose = rig->solve(control);
    std::vector<glm::dmat4> world = m.driver.drive(*rig, pose);
    const glm::dmat4 shoulder = world[9];
    const glm::dmat4 by =
        shoulder *
        glm::scale(glm::rotate(glm::dmat4(1.0), arm_turn, glm::dvec3(0, 0, 1)), glm::dvec3(scale)) *
        glm::inverse(shoulder);
    for (const std::size_t n : {9, 10}) world[n] = by * world[n];
    auto body = std::make_shared<solver::WholeBody>();
    body->world_from_node = world;
    pose.body = body;
    const skin::PosedMesh mesh = skin::skin(character, world);
    const auto measured = [&](std::span<const glm::dmat4> nodes) {
      return m.metrics.measure(rig_at_rest(*rig), control, pose, mesh, 0.0, false,
                               Crossing::measured, nodes);
    };
    const BodyMeasures own = measured(world), whole = measured({});
    EXPECT_EQ(own.crossing, whole.crossing);
    EXPECT_EQ(own.surface.stretch, whole.surface.stretch);
    EXPECT_NEAR(own.surface.volume_change, whole.surface.volume_change, 1e-6);
    const SelfIntersection plain(character.bind_position, character.triangles, character.place);
    EXPECT_EQ(own.crossing, plain.measure(mesh.position).area);
    return own;
  };
  EXPECT_EQ(with(0.0, 1.0).crossing, 0.0);
  EXPECT_GT(with(2.9, 1.0).crossing, 0.005);
  EXPECT_NEAR(with(0.0, 1.3).surface.stretch, 1.3, 1e-3);
}

TEST(RigidParts, HoldWhereAllOfAPartMovesAsOneRigidBody) {
  const Measured m;
  const RigidParts parts(m.figure.character, m.driver);
  const auto rig = build_system({"isner", {}}, m.driver.rest_chain());
  std::vector<glm::dmat4> world = m.driver.drive(
      *rig, rig->solve(rig->controls_for({.extension = 1.0, .twist = 0.4}, Mapping::chest)));
  EXPECT_TRUE(parts.hold(world));
  // As a program gives them that keeps single precision.
  std::vector<glm::dmat4> rounded;
  for (const glm::dmat4& node : world) rounded.emplace_back(glm::mat4(node));
  EXPECT_TRUE(parts.hold(rounded));
  // All the body as one: still rigid; grown, mirrored or with one hand apart: not.
  const auto changed = [&](const glm::dmat4& by, std::size_t first) {
    std::vector<glm::dmat4> out = world;
    for (std::size_t n = first; n < out.size(); ++n) out[n] = by * out[n];
    return out;
  };
  EXPECT_TRUE(parts.hold(changed(glm::translate(glm::dmat4(1.0), glm::dvec3(3, 1, 0)), 0)));
  EXPECT_FALSE(parts.hold(changed(glm::scale(glm::dmat4(1.0), glm::dvec3(1.01)), 0)));
  EXPECT_FALSE(parts.hold(changed(glm::scale(glm::dmat4(1.0), glm::dvec3(-1, 1, 1)), 0)));
  EXPECT_FALSE(parts.hold(changed(glm::translate(glm::dmat4(1.0), glm::dvec3(0, 1e-4, 0)), 13)));
  // Vertices between two vertebrae belong to none.
  EXPECT_GT(std::ranges::count(parts.of_vertex(), -1), 500);
  EXPECT_GT(std::ranges::count_if(parts.of_vertex(), [](int part) { return part >= 0; }), 500);
}

TEST(BodyMetrics, TheUsualExitsAreNotMeasuredAndNotGood) {
  const Measured m;
  const auto rig = build_system({"even", {}}, m.driver.rest_chain());
  const std::vector<double> control = rig->controls_for({.side = 0.5}, Mapping::chest);
  solver::SpinePose pose = rig->solve(control);
  skin::PosedMesh mesh = skin::skin(m.figure.character, m.driver.drive(*rig, pose));
  mesh.position[40].x = std::nanf("");
  BodyMeasures b = m.metrics.measure(rig_at_rest(*rig), control, pose, mesh, 0.0);
  EXPECT_EQ(b.surface.not_finite, 1u);
  EXPECT_EQ(b.slices.measured, 0u);
  pose.position[3].y = std::nan("");
  b = m.metrics.measure(rig_at_rest(*rig), control, pose, mesh, 0.0);
  EXPECT_FALSE(b.chain.finite);
  EXPECT_TRUE(std::isnan(b.arm_drift));
}

/// A finding at a slice of the middle between two spine joints, or at a vertex.
Finding at_slice(int slice, const char* code = "BB011") {
  Finding finding;
  finding.code = code;
  finding.slice = slice;
  return finding;
}

TEST(PlaceNames, ASliceLiesBetweenTheSpineJointsAroundIt) {
  const Measured m;
  const PlaceNames names(m.figure.character, m.figure.anatomy, &m.metrics);
  for (int slice : {0, 20, 40, 63}) {
    Finding finding = at_slice(slice);
    names.name({}, finding);
    // Slices run from 0.05 to 0.95 of the spine, whose seven joints stand a sixth apart.
    const double joint = 6.0 * (0.05 + 0.9 * slice / 63.0);
    const auto below = static_cast<std::size_t>(joint);
    EXPECT_EQ(finding.between[0], m.figure.character.nodes[below].name) << slice;
    EXPECT_EQ(finding.between[1], m.figure.character.nodes[below + 1].name) << slice;
    EXPECT_EQ(finding.joint, finding.between[joint - static_cast<double>(below) < 0.5 ? 0 : 1]);
    EXPECT_EQ(finding.side, "") << "without the pose nothing stands out";
  }
}

TEST(PlaceNames, TheSideOfASliceIsWhereTheSkinTurnsOrNarrowsMost) {
  const Measured m;
  const PlaceNames names(m.figure.character, m.figure.anatomy, &m.metrics);
  const SpineSlices& slices = m.metrics.slices();
  const double middle = 0.8 + 0.6 * slices.slice[32].s;
  // A dent of the surface toward the axis, on one side only.
  const auto dented = [&](const glm::vec3& toward) {
    std::vector<glm::vec3> position = m.metrics.rest_position();
    for (glm::vec3& p : position)
      if (std::abs(p.y - middle) < 0.02 && glm::dot(p, toward) > 0.06f) p -= 0.05f * toward;
    return position;
  };
  const std::pair<glm::vec3, const char*> sides[] = {
      {{1, 0, 0}, "left"}, {{-1, 0, 0}, "right"}, {{0, 0, 1}, "front"}, {{0, 0, -1}, "back"}};
  for (const auto& [toward, side] : sides)
    for (const char* code : {"BB011", "BB030"}) {
      Finding finding = at_slice(32, code);
      names.name(dented(toward), finding);
      EXPECT_EQ(finding.side, side) << code;
      const auto point = names.point(dented(toward), {}, finding);
      ASSERT_TRUE(point);
      EXPECT_GT(glm::dot(*point, glm::dvec3(toward)), 0.03) << "the mark stands on its side";
      EXPECT_NEAR(point->y, middle, 0.02);
    }
  Finding even = at_slice(32);
  names.name(m.metrics.rest_position(), even);
  EXPECT_EQ(even.side, "");
}

TEST(PlaceNames, AVertexHasTheJointThatMovesItItsSideAndItsMesh) {
  Measured m;
  const auto count = static_cast<std::uint32_t>(m.figure.character.vertex_count());
  const std::uint32_t arms = count - 2 * (25 * 12 + 2);  // the two arms come last
  skin::Part body, sleeves;
  body.name = "body";
  body.vertex_count = arms;
  sleeves.name = "sleeves";
  sleeves.first_vertex = arms;
  sleeves.vertex_count = count - arms;
  m.figure.character.parts = {body, sleeves};
  const PlaceNames names(m.figure.character, m.figure.anatomy, &m.metrics);
  Finding hand;
  hand.vertex = static_cast<int>(count - 1);  // the right arm's end
  names.name({}, hand);
  EXPECT_EQ(hand.joint, "hand_r");
  EXPECT_EQ(hand.side, "right");
  EXPECT_EQ(hand.part, "sleeves");
  EXPECT_EQ(hand.between[0], "");
  // The vertex of the torso's tube that is nearest to its left, half way up.
  std::size_t nearest = 0;
  const auto& rest = m.metrics.rest_position();
  for (std::size_t v = 0; v < arms; ++v)
    if (glm::distance(rest[v], {0.12f, 1.05f, 0}) < glm::distance(rest[nearest], {0.12f, 1.05f, 0}))
      nearest = v;
  Finding waist;
  waist.vertex = static_cast<int>(nearest);
  names.name({}, waist);
  EXPECT_EQ(waist.between, (std::array<std::string, 2>{"spine2", "spine3"}));
  EXPECT_EQ(waist.side, "left");
  EXPECT_EQ(waist.part, "body");
  EXPECT_EQ(names.point(rest, {}, waist), glm::dvec3(rest[nearest]));
}

TEST(PlaceNames, AJointKeepsItsNameAndStandsWhereItsNodeIs) {
  const Measured m;
  const PlaceNames names(m.figure.character, m.figure.anatomy, nullptr);
  Finding finding;
  finding.joint = "clavicle_l";
  names.name({}, finding);
  EXPECT_EQ(finding.joint, "clavicle_l");
  EXPECT_EQ(finding.side, "left");
  std::vector<glm::dmat4> world;
  for (const skin::Node& node : m.figure.character.nodes) world.push_back(node.world_from_node);
  EXPECT_EQ(names.point({}, world, finding), glm::dvec3(0.03, 1.3, 0));
  Finding nowhere;
  names.name({}, nowhere);
  EXPECT_EQ(names.point({}, world, nowhere), std::nullopt);
  Finding no_such = at_slice(5000);
  names.name({}, no_such);  // of another body: stays a number
  EXPECT_EQ(no_such.joint, "");
}

TEST(MetricHeat, IsHottestWhereTheFindingsOwnMetricIs) {
  const Figure figure;
  const Stage stage(figure.character, figure.anatomy);
  const BodyMetrics body(stage.character(), stage.anatomy(), stage.driver());
  const auto rig = stage.build({"three_bone", {}});
  const std::vector<double> control = rig->controls_for({.extension = 1.2}, Mapping::chest);
  const PosedCharacter posed = stage.pose(*rig, control);
  const BodyMeasures measured =
      body.measure(rig_at_rest(*rig), control, posed.spine, posed.mesh, 0.0);
  Finding finding;
  finding.code = "BB011";
  finding.limit = 2.0;
  finding.slice = measured.slices.kink_slice;
  const VertexHeat kink = metric_heat(stage, body, {*rig, control, posed}, finding);
  ASSERT_EQ(kink.value.size(), posed.mesh.position.size());
  const double s = body.slices().slice[static_cast<std::size_t>(finding.slice)].s;
  float there = 0.0f, middle = 0.0f;
  for (std::size_t v = 0; v < kink.value.size(); ++v) {
    if (std::abs(body.coordinate()[v] - s) < body.slices().spacing)
      there = std::max(there, kink.value[v]);
    if (std::abs(body.coordinate()[v] - 0.1) < 0.05) middle = std::max(middle, kink.value[v]);
  }
  EXPECT_GT(there, 0.8f * kink.high);
  EXPECT_LT(middle, 0.5f * kink.high) << "far from the kink it is cooler";
  EXPECT_NEAR(kink.high, measured.slices.kink_worst_deg, 0.2 * measured.slices.kink_worst_deg);
  EXPECT_EQ(kink.value.back(), 0.0f) << "the right hand has no kink";

  finding.code = "BB032";
  finding.limit = 1.5;
  finding.vertex = measured.surface.strain_vertex;
  const VertexHeat strain = metric_heat(stage, body, {*rig, control, posed}, finding);
  EXPECT_FLOAT_EQ(strain.value[static_cast<std::size_t>(finding.vertex)], strain.high);

  finding.code = "BB020";
  const VertexHeat arms = metric_heat(stage, body, {*rig, control, posed}, finding);
  EXPECT_EQ(arms.value.front(), 0.0f) << "the hips are not of an arm";
  const auto drifting = stage.build({"isner", {}});
  const std::vector<double> bent = drifting->controls_for({.extension = 1.0}, Mapping::chest);
  const PosedCharacter drifted = stage.pose(*drifting, bent);
  const BodyMeasures drift =
      body.measure(rig_at_rest(*drifting), bent, drifted.spine, drifted.mesh, 0.0);
  ASSERT_GT(drift.arm_drift, 0.01);
  EXPECT_NEAR(metric_heat(stage, body, {*drifting, bent, drifted}, finding).high,
              100.0 * drift.arm_drift, drift.arm_drift)
      << "the largest is the metric's value";
  EXPECT_TRUE(
      metric_heat(stage, body, {*rig, control, posed, 0.0, false, true}, finding).value.empty())
      << "a clip's arms cannot be posed otherwise";
  finding.code = "BB041";
  EXPECT_TRUE(metric_heat(stage, body, {*rig, control, posed}, finding).value.empty());
}

}  // namespace
}  // namespace backbend::validate
