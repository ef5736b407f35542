// Which of two poses is the rest: each threshold from both sides, on a skeleton of uneven bones.
#include "skin/gltf/rest_pose.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_inverse.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "skin/character/matrix_facts.h"

namespace backbend::skin {
namespace {

using glm::dmat4;
using glm::dvec3;

const dmat4 kUnmoved(1.0);

/// `bones` + 1 joints in a bent chain under a bare root, one vertex on each, bound where they
/// stand. A node `prop` that nothing binds hangs on the third joint, and one more vertex is rigid.
struct Rig {
  Character character;
  BoundSkin skin;
  std::vector<int> vertex_skin;

  explicit Rig(int bones = 4) {
    const auto add = [&](const char* name, int parent, const dmat4& local) {
      Node node;
      node.name = name;
      node.parent = parent;
      node.parent_from_node = local;
      node.world_from_node =
          parent < 0 ? local
                     : character.nodes[static_cast<std::size_t>(parent)].world_from_node * local;
      character.nodes.push_back(node);
      return static_cast<int>(character.nodes.size()) - 1;
    };
    int parent = add("root", -1, glm::translate(kUnmoved, dvec3(0.3, 0.1, -0.2)));
    for (int k = 0; k <= bones; ++k) {
      const double turn = 0.2 + 0.1 * k;
      parent = add("joint", parent,
                   glm::rotate(glm::translate(kUnmoved, dvec3(0.05 * k, 1.0 + 0.1 * k, 0.02)), turn,
                               glm::normalize(dvec3(1, 0.4, k))));
      skin.node.push_back(parent);
    }
    add("prop", skin.node[2], glm::translate(kUnmoved, dvec3(0.4, 0.2, 0.1)));
    skin.world_from_mesh = glm::translate(kUnmoved, dvec3(0.1, 0.2, 0.3));
    for (std::size_t j = 0; j < skin.node.size(); ++j) {
      const dmat4& world = character.nodes[static_cast<std::size_t>(skin.node[j])].world_from_node;
      skin.joint_from_mesh.push_back(glm::affineInverse(world) * skin.world_from_mesh);
      vertex(static_cast<int>(j), dvec3(world[3]) - dvec3(0.1, 0.2, 0.3));
      vertex_skin.push_back(0);
    }
    vertex(0, dvec3(500, 0, 0));  // rigid: no measure of the skinned size
    vertex_skin.push_back(-1);
  }
  void vertex(int joint, const dvec3& at) {
    character.bind_position.emplace_back(at);
    Influences one;
    one.joint[0] = static_cast<std::uint16_t>(joint);
    one.weight[0] = 1.0f;
    character.influences.push_back(one);
  }
  void bind() {
    character.joints.clear();
    for (std::size_t j = 0; j < skin.node.size(); ++j)
      character.joints.push_back({skin.node[j], skin.joint_from_mesh[j]});
  }
  std::vector<Warning> settle() {
    bind();
    std::vector<BoundSkin> skins = {skin};
    std::vector<Warning> out = settle_rest_pose(character, skins, vertex_skin);
    skin = skins.front();
    return out;
  }
  dmat4 bound(std::size_t j) const {
    return skin.world_from_mesh * glm::affineInverse(skin.joint_from_mesh[j]);
  }
  /// Binds joint j, and all below it, as if it stood a motion away.
  void bind_from(std::size_t first, const dmat4& motion) {
    for (std::size_t j = first; j < skin.node.size(); ++j)
      skin.joint_from_mesh[j] = glm::affineInverse(motion * bound(j)) * skin.world_from_mesh;
  }
  double size() const {
    dvec3 low(1e9), high(-1e9);
    for (std::size_t v = 0; v + 1 < character.bind_position.size(); ++v) {
      low = glm::min(low, dvec3(character.bind_position[v]));
      high = glm::max(high, dvec3(character.bind_position[v]));
    }
    return std::max({high.x - low.x, high.y - low.y, high.z - low.z});
  }
};

std::string code_of(const std::vector<Warning>& warnings) {
  return warnings.size() == 1 ? warnings[0].code : std::to_string(warnings.size());
}

dmat4 turn_about(const dmat4& joint, double angle) {
  return glm::translate(kUnmoved, dvec3(joint[3])) *
         glm::rotate(kUnmoved, angle, glm::normalize(dvec3(0.3, 1, -0.5))) *
         glm::translate(kUnmoved, -dvec3(joint[3]));
}

TEST(RestPose, OfASkeletonThatStandsAsBoundIsLeftAlone) {
  Rig rig;
  const std::vector<Node> before = rig.character.nodes;
  EXPECT_TRUE(rig.settle().empty());
  for (std::size_t n = 0; n < before.size(); ++n)
    EXPECT_EQ(rig.character.nodes[n].world_from_node, before[n].world_from_node);
}

TEST(RestPose, IsTheBindPoseFromAHundredthOfTheSizeOn) {
  const double size = Rig().size();
  for (const auto& [share, code] :
       {std::pair(0.0095, "0"), std::pair(0.0105, "rest_is_bind_pose")}) {
    Rig rig;
    rig.bind_from(0, glm::translate(kUnmoved, glm::normalize(dvec3(2, -1, 2)) * (share * size)));
    EXPECT_EQ(code_of(rig.settle()), code) << share;
  }
}

TEST(RestPose, MovesEveryBoundNodeAndWhatHangsOnIt) {
  Rig rig;
  const std::vector<Node> before = rig.character.nodes;
  rig.bind_from(2, turn_about(rig.bound(2), 0.7));
  const auto warnings = rig.settle();
  ASSERT_EQ(code_of(warnings), "rest_is_bind_pose");
  const auto& nodes = rig.character.nodes;
  for (std::size_t j = 0; j < rig.skin.node.size(); ++j) {
    const Node& node = nodes[static_cast<std::size_t>(rig.skin.node[j])];
    for (int c = 0; c < 4; ++c)
      EXPECT_LT(glm::distance(node.world_from_node[c], rig.bound(j)[c]), 1e-12) << j;
  }
  for (const Node& node : nodes) {
    const dmat4 parent =
        node.parent < 0 ? kUnmoved : nodes[static_cast<std::size_t>(node.parent)].world_from_node;
    for (int c = 0; c < 4; ++c)
      EXPECT_LT(glm::distance((parent * node.parent_from_node)[c], node.world_from_node[c]), 1e-12)
          << node.name;
  }
  EXPECT_EQ(nodes.back().parent_from_node, before.back().parent_from_node);
  EXPECT_GT(glm::distance(nodes.back().world_from_node[3], before.back().world_from_node[3]), 0.1);
  EXPECT_EQ(nodes[0].world_from_node, before[0].world_from_node);
  // How far apart they were: the vertex that moved furthest, of the skinned size.
  double farthest = 0.0;
  for (std::size_t j = 2; j < rig.skin.node.size(); ++j)
    farthest = std::max(
        farthest, glm::distance(before[static_cast<std::size_t>(rig.skin.node[j])].world_from_node *
                                    rig.skin.joint_from_mesh[j] *
                                    glm::dvec4(dvec3(rig.character.bind_position[j]), 1.0),
                                rig.skin.world_from_mesh *
                                    glm::dvec4(dvec3(rig.character.bind_position[j]), 1.0)));
  const double told = std::stod(warnings[0].message.substr(warnings[0].message.find(" are ") + 5));
  EXPECT_NEAR(told, 100.0 * farthest / rig.size(), 0.005 * told) << warnings[0].message;
}

TEST(RestPose, AsksThatHalfOfTheBonesAreAsLongAndTheJointsAsLarge) {
  const struct {
    const char* what;
    std::size_t first;  // this joint and those below it are changed
    std::size_t last;
    double along, scale;  // of each bone, of each joint
    const char* code;
  } cases[] = {
      {"bones 4 % longer", 1, 4, 1.04, 1.0, "rest_is_bind_pose"},
      {"bones 6 % longer", 1, 4, 1.06, 1.0, "bind_pose_unusable"},
      {"bones 6 % shorter", 1, 4, 0.94, 1.0, "bind_pose_unusable"},
      {"two of four bones longer", 3, 4, 1.5, 1.0, "rest_is_bind_pose"},
      {"three of four bones longer", 2, 4, 1.5, 1.0, "bind_pose_unusable"},
      {"joints 4 % larger", 0, 4, 1.0, 1.04, "rest_is_bind_pose"},
      {"joints 6 % larger", 0, 4, 1.0, 1.06, "bind_pose_unusable"},
      {"joints 6 % smaller", 0, 4, 1.0, 0.94, "bind_pose_unusable"},
  };
  for (const auto& c : cases) {
    Rig rig;
    rig.bind_from(0, turn_about(rig.bound(0), 0.5));  // another pose anyway
    std::vector<dmat4> world;
    for (std::size_t j = 0; j < rig.skin.node.size(); ++j) world.push_back(rig.bound(j));
    dvec3 shift(0.0);
    for (std::size_t j = 0; j < world.size(); ++j) {
      const bool changed = j >= c.first && j <= c.last;
      if (j > 0 && changed) shift += (c.along - 1.0) * dvec3(rig.bound(j)[3] - rig.bound(j - 1)[3]);
      world[j][3] += glm::dvec4(shift, 0.0);
      if (changed) world[j] = glm::scale(world[j], dvec3(c.scale));
    }
    for (std::size_t j = 0; j < world.size(); ++j)
      rig.skin.joint_from_mesh[j] = glm::affineInverse(world[j]) * rig.skin.world_from_mesh;
    const std::vector<Node> before = rig.character.nodes;
    EXPECT_EQ(code_of(rig.settle()), c.code) << c.what;
    if (std::string(c.code) != "bind_pose_unusable") continue;
    for (std::size_t n = 0; n < before.size(); ++n)
      EXPECT_EQ(rig.character.nodes[n].world_from_node, before[n].world_from_node) << c.what;
  }
}

/// A clip's first frame in which a joint is squashed: all bones above it are shorter in the world.
TEST(RestPose, IsTheBindPoseWhereTheNodesAreSquashed) {
  Rig rig;
  auto& nodes = rig.character.nodes;
  const auto squashed = static_cast<std::size_t>(rig.skin.node[0]);
  const std::size_t top = static_cast<std::size_t>(rig.skin.node.back());
  const dmat4 before = nodes[top].world_from_node;
  nodes[squashed].parent_from_node =
      glm::scale(nodes[squashed].parent_from_node, dvec3(1.4, 0.7, 1.4));
  for (std::size_t n = squashed; n < nodes.size(); ++n)
    nodes[n].world_from_node =
        nodes[n].parent < 0 ? nodes[n].parent_from_node
                            : nodes[static_cast<std::size_t>(nodes[n].parent)].world_from_node *
                                  nodes[n].parent_from_node;
  EXPECT_EQ(code_of(rig.settle()), "rest_is_bind_pose");
  for (int c = 0; c < 4; ++c)
    EXPECT_LT(glm::distance(nodes[top].world_from_node[c], before[c]), 1e-9);
}

/// A clip whose first frame lies down: its root leans, and would lean the bind pose.
TEST(RestPose, StandsAlongTheAxesAsTheMeshesNodeSaysWhateverTheRootsPose) {
  const auto lean_of = [](double node_turn, double node_scale, double root_turn) {
    Rig rig;
    auto& nodes = rig.character.nodes;
    const dmat4 lean = glm::rotate(kUnmoved, root_turn, dvec3(0, 0, 1));
    for (Node& node : nodes) node.world_from_node = lean * node.world_from_node;
    nodes[0].parent_from_node = lean * nodes[0].parent_from_node;
    rig.skin.world_from_mesh = lean * rig.skin.world_from_mesh;
    rig.bind_from(2, turn_about(rig.bound(2), 0.7));
    Node mesh;
    mesh.name = "mesh";
    mesh.world_from_node = mesh.parent_from_node =
        glm::rotate(glm::scale(kUnmoved, dvec3(node_scale)), node_turn, dvec3(1, 0, 0));
    nodes.push_back(mesh);
    rig.skin.mesh_node = static_cast<int>(nodes.size()) - 1;
    const dmat4 from_root = rig.skin.world_from_mesh;
    const std::vector<Warning> warnings = rig.settle();
    EXPECT_EQ(code_of(warnings), "rest_is_bind_pose");
    const bool stood = dvec3(rig.skin.world_from_mesh[1]) != dvec3(from_root[1]);
    EXPECT_EQ(warnings[0].message.find(", stood up by ") != std::string::npos, stood);
    const std::size_t top = static_cast<std::size_t>(rig.skin.node.back());
    for (int c = 0; c < 4; ++c)
      EXPECT_LT(
          glm::distance(nodes[top].world_from_node[c], rig.bound(rig.skin.node.size() - 1)[c]),
          1e-9);
    return glm::distance(dvec3(rig.skin.world_from_mesh[1]), dvec3(from_root[1]));
  };
  EXPECT_NEAR(lean_of(0.0, 1.0, 0.5), 2.0 * std::sin(0.25), 1e-9);
  EXPECT_NEAR(lean_of(0.0, 1.0, 0.04), 2.0 * std::sin(0.02), 1e-9);
  const double lies = std::acos(-1.0) / 2.0;
  EXPECT_GT(lean_of(lies, 1.0, 0.5), 0.5) << "the first frame lies";
  EXPECT_LT(lean_of(lies, 1.0, 0.04), 1e-9) << "the mesh's node says nothing";
  EXPECT_LT(lean_of(0.3, 1.0, 0.5), 1e-9) << "the mesh's node stands askew itself";
  EXPECT_LT(lean_of(0.0, 1.5, 0.5), 1e-9) << "another size";
}

TEST(RestPose, TakesTheFirstUsableBindOfANode) {
  Rig rig;
  rig.bind_from(1, turn_about(rig.bound(1), 0.4));
  // The second skin binds the same nodes elsewhere, the third joint alone as a flat matrix first.
  BoundSkin other = rig.skin;
  rig.skin.joint_from_mesh[2] = glm::scale(kUnmoved, dvec3(1, 1, 0));
  rig.bind();
  std::vector<BoundSkin> skins = {rig.skin, other};
  settle_rest_pose(rig.character, skins, rig.vertex_skin);
  for (std::size_t j = 0; j < rig.skin.node.size(); ++j) {
    const dmat4 expected = other.world_from_mesh * glm::affineInverse(other.joint_from_mesh[j]);
    EXPECT_LT(
        glm::distance(
            rig.character.nodes[static_cast<std::size_t>(rig.skin.node[j])].world_from_node[3],
            expected[3]),
        1e-12)
        << j;
  }
}

TEST(PlaceAtBind, IsWhereTheJointAboveMostOthersPutsTheMesh) {
  // Two trees: one of three joints, listed first, one of four.
  std::vector<Node> nodes(8);
  const int parent[] = {-1, 0, 1, -1, 3, 4, 4, 0};
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    nodes[n].parent = parent[n];
    nodes[n].world_from_node =
        glm::translate(kUnmoved, dvec3(0.1 * static_cast<double>(n), 0.3, -0.2));
  }
  BoundSkin skin;
  skin.node = {5, 1, 2, 0, 6, 4, 3};
  for (std::size_t j = 0; j < skin.node.size(); ++j)
    skin.joint_from_mesh.push_back(glm::translate(kUnmoved, dvec3(0, static_cast<double>(j), 0.5)));
  EXPECT_EQ(place_at_bind(nodes, skin), nodes[3].world_from_node * skin.joint_from_mesh[6]);
  // Without a usable matrix there, the next below it; of two above as many, the first listed.
  skin.joint_from_mesh[6] = glm::scale(kUnmoved, dvec3(1, 0, 1));
  EXPECT_EQ(place_at_bind(nodes, skin), nodes[0].world_from_node * skin.joint_from_mesh[3]);
  skin.joint_from_mesh[3][3][0] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(place_at_bind(nodes, skin), nodes[4].world_from_node * skin.joint_from_mesh[5]);
  for (dmat4& m : skin.joint_from_mesh) m = dmat4(0.0);
  EXPECT_EQ(place_at_bind(nodes, skin), kUnmoved);
}

}  // namespace
}  // namespace backbend::skin
