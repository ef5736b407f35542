// What of a surface is torso, on skeletons of a few joints with a vertex where one is asked about.
#include "validate/metrics/surface/torso.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

namespace backbend::validate {
namespace {

struct Body {
  skin::Character character;
  skin::Anatomy anatomy;

  int joint(int parent, const glm::dvec3& at) {
    skin::Node node;
    node.parent = parent;
    node.world_from_node = glm::translate(glm::dmat4(1.0), at);
    character.nodes.push_back(node);
    const int number = static_cast<int>(character.nodes.size()) - 1;
    character.joints.push_back({number, glm::inverse(node.world_from_node)});
    return number;
  }
  /// A vertex at a place, on one joint with this weight and on another with the rest.
  void vertex(const glm::dvec3& at, int joint, double weight = 1.0, int other = 0) {
    skin::Influences influences;
    influences.joint = {static_cast<std::uint16_t>(joint), static_cast<std::uint16_t>(other)};
    influences.weight = {static_cast<float>(weight), static_cast<float>(1.0 - weight)};
    character.bind_position.push_back(glm::vec3(at));
    character.influences.push_back(influences);
    character.place.push_back(character.place_count++);
  }
  /// A triangle of the three vertices that were added last.
  void triangle() {
    const std::uint32_t end = character.place_count;
    character.triangles.push_back({end - 3, end - 2, end - 1});
  }
  std::vector<int> torso() const {
    const auto mask = torso_mask(character, anatomy, character.bind_position);
    return {mask.begin(), mask.end()};
  }
};

/// Hips, spine, neck and head along +Y, with arms behind clavicles and legs behind pelvis halves.
struct Human : Body {
  int hips = joint(-1, {0, 1, 0}), spine = joint(hips, {0, 1.25, 0}),
      neck = joint(spine, {0, 1.5, 0}), head = joint(neck, {0, 1.6, 0}),
      clavicle = joint(spine, {0.03, 1.45, 0}), arm = joint(clavicle, {0.2, 1.45, 0}),
      hand = joint(arm, {0.7, 1.45, 0}), pelvis = joint(hips, {0.05, 0.98, 0}),
      thigh = joint(pelvis, {0.1, 0.9, 0}), foot = joint(thigh, {0.1, 0.1, 0}),
      tail = joint(hips, {0, 0.95, -0.1}), jaw = joint(hips, {0, 1.58, 0.1}),
      tongue = joint(jaw, {0, 1.58, 0.15});

  Human() {
    anatomy.spine = {hips, spine, neck, head};
    anatomy.chest_index = 2;
    anatomy.head = head;
    anatomy.left_arm = {clavicle, arm, hand};
    anatomy.left_leg = {pelvis, thigh, foot};
    anatomy.tail = {tail};
    anatomy.followers = {{jaw, head}};
  }
};

TEST(Torso, IsWhatNeitherHeadNorLimbsNorFollowersMoveMost) {
  Human body;
  body.vertex({0, 1.1, 0.1}, body.hips);
  body.vertex({0, 1.55, 0.05}, body.neck);
  body.vertex({0, 1.65, 0.05}, body.head);
  body.vertex({0, 1.55, 0.05}, body.head, 0.5, body.neck);  // half is not most
  body.vertex({0, 1.55, 0.05}, body.head, 0.51, body.neck);
  body.vertex({0, 0.9, -0.2}, body.tail);
  body.vertex({0, 1.5, 0.2}, body.jaw);
  body.vertex({0, 1.5, 0.2}, body.tongue);
  EXPECT_EQ(body.torso(), (std::vector{1, 1, 0, 1, 0, 0, 0, 0}));
}

TEST(Torso, HoldsNoPieceThatALimbMovesAsAWhole) {
  for (const bool pad : {true, false}) {  // a shoulder pad; one whose rim the chest moves
    Human body;
    body.vertex({0.15, 1.5, 0}, body.arm);
    body.vertex({0.19, 1.5, 0}, body.arm, 0.6, body.spine);
    body.vertex({0.16, 1.5, 0.05}, pad ? body.arm : body.spine);
    body.triangle();
    body.vertex({0.19, 1.3, 0}, body.arm);  // of no surface
    const int in = pad ? 0 : 1;
    EXPECT_EQ(body.torso(), (std::vector{in, in, in, 1}));
  }
}

TEST(Torso, EndsAtThePlaneThroughAShoulderAndWhereverTheForearmWeighsMost) {
  Human body;
  body.vertex({0.1, 1.45, 0}, body.clavicle);  // in front of the shoulder's plane
  body.vertex({0.19, 1.3, 0}, body.arm);       // behind it, although the arm's
  body.vertex({0.21, 1.45, 0}, body.arm);      // beyond
  body.vertex({0.21, 1.3, 0}, body.spine);     // beyond, and none of the arm's
  body.vertex({0.21, 1.45, 0}, body.arm, 0.5, body.spine);
  body.vertex({0.21, 1.45, 0}, body.arm, 0.51, body.spine);
  body.vertex({0.1, 1.4, 0}, body.hand, 0.51, body.spine);  // hangs down beside the ribs
  body.vertex({0.1, 1.4, 0}, body.hand, 0.5, body.spine);
  EXPECT_EQ(body.torso(), (std::vector{1, 1, 0, 1, 1, 0, 0, 1}));
  // Without a clavicle the arm itself is the first joint, and its own plane the cut.
  body.anatomy.left_arm = {body.arm, body.hand};
  EXPECT_EQ(body.torso(), (std::vector{1, 1, 0, 1, 1, 0, 0, 1}));
  // A first joint that stands as far aside as a shoulder is one, three joints or not.
  body.anatomy.left_arm = {body.clavicle, body.arm, body.hand};
  body.character.nodes[static_cast<std::size_t>(body.clavicle)].world_from_node[3].x = 0.15;
  EXPECT_EQ(body.torso(), (std::vector{1, 0, 0, 1, 1, 0, 0, 1}));
}

TEST(Torso, EndsAtTheHipsJointsOfLegsButNotOfLegsThatRunOnFromTheSpine) {
  Human body;
  body.vertex({0.1, 0.92, 0.05}, body.thigh);
  body.vertex({0.1, 0.88, 0.05}, body.thigh);
  body.vertex({0.1, 0.5, 0.05}, body.foot);
  // Upright, legs run on from the spine: torso to the end of the spine's own reach.
  EXPECT_EQ(body.torso(), (std::vector{1, 1, 1}));
  // On all fours they do not.
  for (const int joint : {body.spine, body.neck, body.head}) {
    glm::dvec4& at = body.character.nodes[static_cast<std::size_t>(joint)].world_from_node[3];
    at = {0, 1, at.y - 1.0, 1};
  }
  EXPECT_EQ(body.torso(), (std::vector{1, 0, 0}));
  body.anatomy.left_leg = {body.thigh, body.foot};  // without a pelvis half
  EXPECT_EQ(body.torso(), (std::vector{1, 0, 0}));
}

TEST(Torso, OfABodyThatIsBuiltFromItsHeadIsTheSame) {
  Body snake;  // head first, the body hangs from it; a jaw beside
  const int head = snake.joint(-1, {0, 0, 2}), neck = snake.joint(head, {0, 0, 1.8});
  const int middle = snake.joint(neck, {0, 0, 1}), end = snake.joint(middle, {0, 0, 0});
  const int jaw = snake.joint(head, {0, -0.1, 2.1});
  snake.anatomy.spine = {end, middle, neck, head};
  snake.anatomy.chest_index = 2;
  snake.anatomy.head = head;
  for (const int joint : {head, neck, middle, end, jaw}) snake.vertex({0, 0.1, 1}, joint);
  EXPECT_EQ(snake.torso(), (std::vector{0, 1, 1, 1, 0}));
}

TEST(SpineShares, AreWhatNoLimbWeighs) {
  Human body;
  body.vertex({0, 1, 0}, body.spine);
  body.vertex({0, 1, 0}, body.clavicle, 0.25, body.spine);
  body.vertex({0, 1, 0}, body.hand, 0.75, body.head);
  body.vertex({0, 1, 0}, body.foot, 0.625, body.clavicle);
  body.vertex({0, 1, 0}, body.tail);
  EXPECT_EQ(spine_shares(body.character, body.anatomy),
            (std::vector{1.0f, 0.75f, 0.25f, 0.0f, 1.0f}));
}

}  // namespace
}  // namespace backbend::validate
