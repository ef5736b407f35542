// The anatomy of skeletons under the names of the common rigs, what hints do, and when it refuses.
#include "skin/anatomy/anatomy.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_inverse.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <tuple>

#include "skin/anatomy/body_kind.h"
#include "skin/character/joint_names.h"
#include "tests/skin/stick_figure.h"

namespace backbend::skin {
namespace {

using Names = std::vector<std::string>;

Names names_of(const Character& character, const std::vector<int>& nodes) {
  Names out;
  for (const int node : nodes) out.push_back(character.nodes[static_cast<std::size_t>(node)].name);
  return out;
}

/// The stick figure with its joints called as in some rig.
Character renamed(const std::map<std::string, std::string>& names) {
  Character character = stick_figure();
  for (Node& node : character.nodes)
    if (const auto found = names.find(node.name); found != names.end()) node.name = found->second;
  return character;
}

struct Convention {
  const char* rig;
  std::map<std::string, std::string> names;  // from the stick figure's
};

const Convention kConventions[] = {
    {"Mixamo",
     {{"hips", "mixamorig:Hips"},
      {"spine_1", "mixamorig:Spine"},
      {"spine_2", "mixamorig:Spine2"},
      {"neck", "mixamorig:Neck"},
      {"head", "mixamorig:Head"},
      {"clavicle.L", "mixamorig:LeftShoulder"},
      {"arm.L", "mixamorig:LeftArm"},
      {"hand.L", "mixamorig:LeftHand"},
      {"clavicle.R", "mixamorig:RightShoulder"},
      {"arm.R", "mixamorig:RightArm"},
      {"hand.R", "mixamorig:RightHand"},
      {"thigh.L", "mixamorig:LeftUpLeg"},
      {"shin.L", "mixamorig:LeftLeg"},
      {"foot.L", "mixamorig:LeftFoot"},
      {"thigh.R", "mixamorig:RightUpLeg"},
      {"shin.R", "mixamorig:RightLeg"},
      {"foot.R", "mixamorig:RightFoot"}}},
    {"Unreal",
     {{"scene", "root"},
      {"hips", "pelvis"},
      {"spine_1", "spine_01"},
      {"spine_2", "spine_02"},
      {"neck", "neck_01"},
      {"clavicle.L", "clavicle_l"},
      {"arm.L", "upperarm_l"},
      {"hand.L", "hand_l"},
      {"clavicle.R", "clavicle_r"},
      {"arm.R", "upperarm_r"},
      {"hand.R", "hand_r"},
      {"thigh.L", "thigh_l"},
      {"shin.L", "calf_l"},
      {"foot.L", "foot_l"},
      {"thigh.R", "thigh_r"},
      {"shin.R", "calf_r"},
      {"foot.R", "foot_r"}}},
    {"Biped",
     {{"scene", "Bip01"},
      {"hips", "Bip01 Pelvis"},
      {"spine_1", "Bip01 Spine"},
      {"spine_2", "Bip01 Spine1"},
      {"neck", "Bip01 Neck"},
      {"head", "Bip01 Head"},
      {"clavicle.L", "Bip01 L Clavicle"},
      {"arm.L", "Bip01 L UpperArm"},
      {"hand.L", "Bip01 L Hand"},
      {"clavicle.R", "Bip01 R Clavicle"},
      {"arm.R", "Bip01 R UpperArm"},
      {"hand.R", "Bip01 R Hand"},
      {"thigh.L", "Bip01 L Thigh"},
      {"shin.L", "Bip01 L Calf"},
      {"foot.L", "Bip01 L Foot"},
      {"thigh.R", "Bip01 R Thigh"},
      {"shin.R", "Bip01 R Calf"},
      {"foot.R", "Bip01 R Foot"}}},
    {"Vrm",
     {{"hips", "J_Bip_C_Hips"},
      {"spine_1", "J_Bip_C_Spine"},
      {"spine_2", "J_Bip_C_UpperChest"},
      {"neck", "J_Bip_C_Neck"},
      {"head", "J_Bip_C_Head"},
      {"clavicle.L", "J_Bip_L_Shoulder"},
      {"arm.L", "J_Bip_L_UpperArm"},
      {"hand.L", "J_Bip_L_Hand"},
      {"clavicle.R", "J_Bip_R_Shoulder"},
      {"arm.R", "J_Bip_R_UpperArm"},
      {"hand.R", "J_Bip_R_Hand"},
      {"thigh.L", "J_Bip_L_UpperLeg"},
      {"shin.L", "J_Bip_L_LowerLeg"},
      {"foot.L", "J_Bip_L_Foot"},
      {"thigh.R", "J_Bip_R_UpperLeg"},
      {"shin.R", "J_Bip_R_LowerLeg"},
      {"foot.R", "J_Bip_R_Foot"}}},
    {"AdvancedSkeleton",
     {{"hips", "Root_M"},
      {"spine_1", "Spine1_M"},
      {"spine_2", "Chest_M"},
      {"neck", "Neck_M"},
      {"head", "Head_M"},
      {"clavicle.L", "Scapula_L"},
      {"arm.L", "Shoulder_L"},
      {"hand.L", "Wrist_L"},
      {"clavicle.R", "Scapula_R"},
      {"arm.R", "Shoulder_R"},
      {"hand.R", "Wrist_R"},
      {"thigh.L", "Hip_L"},
      {"shin.L", "Knee_L"},
      {"foot.L", "Ankle_L"},
      {"thigh.R", "Hip_R"},
      {"shin.R", "Knee_R"},
      {"foot.R", "Ankle_R"}}},
    {"Rigify",
     {{"scene", "rig"},
      {"hips", "DEF-spine"},
      {"spine_1", "DEF-spine.001"},
      {"spine_2", "DEF-spine.003"},
      {"neck", "DEF-spine.004"},
      {"head", "DEF-spine.006"},
      {"clavicle.L", "DEF-shoulder.L"},
      {"arm.L", "DEF-upper_arm.L"},
      {"hand.L", "DEF-hand.L"},
      {"clavicle.R", "DEF-shoulder.R"},
      {"arm.R", "DEF-upper_arm.R"},
      {"hand.R", "DEF-hand.R"},
      {"thigh.L", "DEF-thigh.L"},
      {"shin.L", "DEF-shin.L"},
      {"foot.L", "DEF-foot.L"},
      {"thigh.R", "DEF-thigh.R"},
      {"shin.R", "DEF-shin.R"},
      {"foot.R", "DEF-foot.R"}}},
    {"Daz",
     {{"hips", "hip"},
      {"spine_1", "abdomenLower"},
      {"spine_2", "chestUpper"},
      {"neck", "neckLower"},
      {"clavicle.L", "lCollar"},
      {"arm.L", "lShldrBend"},
      {"hand.L", "lHand"},
      {"clavicle.R", "rCollar"},
      {"arm.R", "rShldrBend"},
      {"hand.R", "rHand"},
      {"thigh.L", "lThighBend"},
      {"shin.L", "lShin"},
      {"foot.L", "lFoot"},
      {"thigh.R", "rThighBend"},
      {"shin.R", "rShin"},
      {"foot.R", "rFoot"}}},
    {"MGear",
     {{"scene", "world_ctl"},
      {"hips", "spine_C0_pelvis_jnt"},
      {"spine_1", "spine_C0_01_jnt"},
      {"spine_2", "spine_C0_02_jnt"},
      {"neck", "neck_C0_0_jnt"},
      {"head", "neck_C0_head_jnt"},
      {"clavicle.L", "shoulder_L0_shoulder_jnt"},
      {"arm.L", "arm_L0_0_jnt"},
      {"hand.L", "arm_L0_end_jnt"},
      {"clavicle.R", "shoulder_R0_shoulder_jnt"},
      {"arm.R", "arm_R0_0_jnt"},
      {"hand.R", "arm_R0_end_jnt"},
      {"thigh.L", "leg_L0_0_jnt"},
      {"shin.L", "leg_L0_1_jnt"},
      {"foot.L", "leg_L0_end_jnt"},
      {"thigh.R", "leg_R0_0_jnt"},
      {"shin.R", "leg_R0_1_jnt"},
      {"foot.R", "leg_R0_end_jnt"}}},
    {"HumanIk",
     {{"scene", "Reference"},
      {"hips", "Hips"},
      {"spine_1", "Spine"},
      {"spine_2", "Spine1"},
      {"neck", "Neck"},
      {"head", "Head"},
      {"clavicle.L", "LeftShoulder"},
      {"arm.L", "LeftArm"},
      {"hand.L", "LeftHand"},
      {"clavicle.R", "RightShoulder"},
      {"arm.R", "RightArm"},
      {"hand.R", "RightHand"},
      {"thigh.L", "LeftUpLeg"},
      {"shin.L", "LeftLeg"},
      {"foot.L", "LeftFoot"},
      {"thigh.R", "RightUpLeg"},
      {"shin.R", "RightLeg"},
      {"foot.R", "RightFoot"}}},
    {"MakeHuman",
     {{"hips", "root"},
      {"spine_1", "spine05"},
      {"spine_2", "spine01"},
      {"neck", "neck01"},
      {"head", "head"},
      {"clavicle.L", "clavicle.L"},
      {"arm.L", "upperarm01.L"},
      {"hand.L", "wrist.L"},
      {"clavicle.R", "clavicle.R"},
      {"arm.R", "upperarm01.R"},
      {"hand.R", "wrist.R"},
      {"thigh.L", "upperleg01.L"},
      {"shin.L", "lowerleg01.L"},
      {"foot.L", "foot.L"},
      {"thigh.R", "upperleg01.R"},
      {"shin.R", "lowerleg01.R"},
      {"foot.R", "foot.R"}}},
    {"NoNamesAtAll",
     {{"hips", "#1"},
      {"spine_1", "#2"},
      {"spine_2", "#3"},
      {"neck", "#4"},
      {"head", "#5"},
      {"clavicle.L", "#6"},
      {"arm.L", "#7"},
      {"hand.L", "#8"},
      {"thigh.L", "#9"},
      {"shin.L", "#10"},
      {"foot.L", "#11"},
      {"clavicle.R", "#12"},
      {"arm.R", "#13"},
      {"hand.R", "#14"},
      {"thigh.R", "#15"},
      {"shin.R", "#16"},
      {"foot.R", "#17"}}},
};

/// The reason that starts so, or "".
std::string reason_of(const Anatomy& anatomy, const std::string& start) {
  for (const std::string& reason : anatomy.reasons)
    if (reason.starts_with(start)) return reason;
  return "";
}

class NamedAs : public ::testing::TestWithParam<Convention> {};

TEST_P(NamedAs, TheSameFigureHasTheSameAnatomy) {
  const Character plain = stick_figure();
  const Anatomy expected = find_anatomy(plain);
  const Character character = renamed(GetParam().names);
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_EQ(anatomy.spine, expected.spine);
  EXPECT_EQ(anatomy.chest_index, expected.chest_index);
  EXPECT_EQ(anatomy.left_arm, expected.left_arm);
  EXPECT_EQ(anatomy.right_arm, expected.right_arm);
  EXPECT_EQ(anatomy.left_leg, expected.left_leg);
  EXPECT_EQ(anatomy.right_leg, expected.right_leg);
  EXPECT_EQ(anatomy.forward, expected.forward);
}

INSTANTIATE_TEST_SUITE_P(Anatomy, NamedAs, ::testing::ValuesIn(kConventions),
                         [](const auto& test) { return test.param.rig; });

TEST(Anatomy, OfTheStickFigureIsAsDrawn) {
  const Character character = stick_figure();
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_EQ(names_of(character, anatomy.spine),
            (Names{"hips", "spine_1", "spine_2", "neck", "head"}));
  EXPECT_EQ(anatomy.chest_index, 2u);
  EXPECT_EQ(anatomy.chest, stick_node(character, "spine_2"));
  EXPECT_EQ(anatomy.neck_index, 3u);
  EXPECT_EQ(names_of(character, anatomy.left_arm), (Names{"clavicle.L", "arm.L", "hand.L"}));
  EXPECT_EQ(names_of(character, anatomy.right_leg), (Names{"thigh.R", "shin.R", "foot.R"}));
  EXPECT_EQ(anatomy.up, glm::dvec3(0, 1, 0));
  EXPECT_EQ(anatomy.forward, glm::dvec3(0, 0, 1));
  EXPECT_EQ(anatomy.left, glm::dvec3(1, 0, 0));
  EXPECT_NEAR(anatomy.spine_length, 0.5 * 2 / 3, 1e-12);  // two of three steps to the neck
  EXPECT_EQ(reason_of(anatomy, "chest: "), "chest: 'spine_2', which both arms hang from");
}

TEST(Anatomy, TurnsWithTheCharacter) {
  // Z-up data, facing -Y, as a file with odd axes has it.
  Character character = stick_figure();
  const glm::dmat4 turn =
      glm::rotate(glm::dmat4(1.0), 1.5707963267948966, glm::dvec3(1.0, 0.0, 0.0));
  for (Node& node : character.nodes) node.world_from_node = turn * node.world_from_node;
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_EQ(anatomy.up, glm::dvec3(0, 0, 1));
  EXPECT_EQ(anatomy.forward, glm::dvec3(0, -1, 0));
  EXPECT_EQ(anatomy.left, glm::dvec3(1, 0, 0));
}

/// The stick figure on feet of four vertices each, that reach further forward than back, in
/// trousers that are blown far back.
Character on_feet(const std::map<std::string, std::string>& names) {
  Character character = renamed(names);
  const Character plain = stick_figure();
  for (const char* foot : {"foot.L", "foot.R"}) {
    const int node = stick_node(plain, foot);
    glm::dvec4& ankle = character.nodes[static_cast<std::size_t>(node)].world_from_node[3];
    for (const double z : {-0.06, 0.0, 0.1, 0.18}) {
      const std::size_t first = character.vertex_count();
      stick_vertex(character, node);
      for (std::size_t v = first; v < first + 3; ++v)
        character.bind_position[v] = glm::vec3(ankle.x, 0.0, z);
    }
    for (int k = 0; k < 4; ++k) {
      const std::size_t first = character.vertex_count();
      stick_vertex(character, character.nodes[static_cast<std::size_t>(node)].parent);
      for (std::size_t v = first; v < first + 3; ++v)
        character.bind_position[v] = glm::vec3(ankle.x, 0.3, -0.4);
    }
    ankle.y = 0.09;  // above the soles; their vertices are bound to where it stood
    for (SkinJoint& joint : character.joints)
      if (joint.node == node)
        joint.joint_from_mesh =
            glm::affineInverse(character.nodes[static_cast<std::size_t>(node)].world_from_node);
  }
  return character;
}

TEST(Anatomy, SeesWhereAFigureFacesByItsSolesOrNamesHoweverItStands) {
  const Anatomy expected = find_anatomy(stick_figure());
  for (int a = 0; a < 6; ++a)
    for (int b = 0; b < 6; ++b) {
      if (a % 3 == b % 3) continue;
      glm::dvec3 up(0.0), forward(0.0);
      up[a % 3] = a < 3 ? 1.0 : -1.0;
      forward[b % 3] = b < 3 ? 1.0 : -1.0;
      const glm::dvec3 left = glm::cross(up, forward);
      for (const double aside : {0.0, 0.3, 0.75}) {  // turned about up; more than 30 deg is oblique
        const glm::dvec3 ahead = std::cos(aside) * forward + std::sin(aside) * left;
        const glm::dvec3 beside = glm::cross(up, ahead);
        const bool oblique = aside > 0.53;
        // Without names limbs are pairs only across one of the world's axes.
        const auto& nameless = kConventions[std::size(kConventions) - 1].names;
        Character character = on_feet(oblique ? kConventions[0].names : nameless);
        const glm::dmat4 turn(glm::dvec4(beside, 0), glm::dvec4(up, 0), glm::dvec4(ahead, 0),
                              glm::dvec4(0.3, -2, 5, 1));
        for (Node& node : character.nodes) node.world_from_node = turn * node.world_from_node;
        const Anatomy anatomy = find_anatomy(character);
        EXPECT_LT(glm::distance(anatomy.up, up), 1e-12) << a << b << aside;
        EXPECT_LT(glm::distance(anatomy.forward, oblique ? ahead : forward), 1e-12)
            << a << b << aside;
        EXPECT_LT(glm::distance(anatomy.left, oblique ? beside : left), 1e-12) << a << b << aside;
        EXPECT_EQ(anatomy.left_arm, expected.left_arm);
        EXPECT_EQ(anatomy.right_leg, expected.right_leg);
      }
    }
}

TEST(Anatomy, TakesTheAxisAcrossFromItsLegsWhereNothingTellsTheFront) {
  // Nameless, upright along +Z, without feet: the standard's front is up.
  for (const int axis : {0, 1}) {
    Character character;
    character.file_name = "nameless.glb";
    const auto add = [&](int parent, double aside, double height) {
      glm::dvec3 at(0.0, 0.0, height);
      at[axis] = aside;
      const int node =
          add_node(character, "#" + std::to_string(character.nodes.size()), parent, at);
      stick_vertex(character, node);
      return node;
    };
    const int hips = add(-1, 0.0, 1.0);
    for (int k = 1, parent = hips; k < 5; ++k) parent = add(parent, 0.0, 1.0 + 0.2 * k);
    character.nodes.back().name = "head";
    for (const double side : {0.1, -0.1})
      for (int k = 0, parent = hips; k < 3; ++k) parent = add(parent, side, 0.9 - 0.45 * k);
    const Anatomy anatomy = find_anatomy(character);
    ASSERT_EQ(anatomy.up, glm::dvec3(0, 0, 1)) << axis;
    EXPECT_EQ(std::abs(anatomy.left[axis]), 1.0) << axis;
    EXPECT_EQ(anatomy.forward, glm::cross(anatomy.left, anatomy.up)) << axis;
  }
}

TEST(Anatomy, TakesTheSidesOfNamelessLimbsFromWhereTheFigureFaces) {
  // The same figure and its mirror image, whose right limbs stand first in the file; facing either
  // way.
  for (const double side : {1.0, -1.0})
    for (const double ahead : {1.0, -1.0}) {
      Character character = on_feet(kConventions[std::size(kConventions) - 1].names);
      const glm::dmat4 flip = glm::scale(glm::dmat4(1.0), glm::dvec3(side, 1.0, ahead));
      for (Node& node : character.nodes) node.world_from_node = flip * node.world_from_node;
      const Anatomy anatomy = find_anatomy(character);
      EXPECT_LT(glm::distance(anatomy.forward, glm::dvec3(0, 0, ahead)), 1e-12) << side << ahead;
      EXPECT_LT(glm::distance(anatomy.left, glm::dvec3(ahead, 0, 0)), 1e-12) << side << ahead;
      for (const auto* limb : {&anatomy.left_arm, &anatomy.left_leg})
        EXPECT_GT(
            ahead * character.nodes[static_cast<std::size_t>(limb->back())].world_from_node[3].x,
            0.0);
    }
}

TEST(Anatomy, KnowsSomeoneWhoSitsFromSomeoneWhoLies) {
  Character character = stick_figure();
  for (Node& node : character.nodes)
    if (node.name.rfind("shin", 0) == 0 || node.name.rfind("foot", 0) == 0)
      node.world_from_node =  // thighs forward
          glm::translate(glm::dmat4(1.0), glm::dvec3(node.world_from_node[3].x, 0.88,
                                                     0.88 - node.world_from_node[3].y));
  EXPECT_EQ(find_anatomy(character).up, glm::dvec3(0, 1, 0));
  // Crouched: the back leans by 40 degrees, too.
  const double height = 0.9;  // of the hips
  for (Node& node : character.nodes) {
    glm::dvec4& place = node.world_from_node[3];
    if (place.y <= height || std::abs(place.x) > 0.3) continue;
    place.z += (place.y - height) * std::tan(40.0 * M_PI / 180.0);
  }
  const Anatomy crouched = find_anatomy(character);
  EXPECT_EQ(crouched.up, glm::dvec3(0, 1, 0));
  EXPECT_TRUE(crouched.sure());
}

TEST(Anatomy, OfABodyThatLiesIsDoubtfulAndAsAPersonConfirmsIt) {
  Character character = stick_figure();
  const glm::dmat4 lie(glm::dvec4(1, 0, 0, 0), glm::dvec4(0, 0, -1, 0), glm::dvec4(0, 1, 0, 0),
                       glm::dvec4(0, 0, 0, 1));  // its head along -Z, its face up
  for (Node& node : character.nodes) node.world_from_node = lie * node.world_from_node;
  const Anatomy found = find_anatomy(character);
  EXPECT_EQ(found.up, glm::dvec3(0, 0, -1));
  ASSERT_EQ(found.doubts.size(), 1u);
  EXPECT_EQ(found.doubts.front(), "up is -Z: away from the feet, 90 deg from the standard's +Y");
  AnatomyHints hints;
  hints.confirmed = true;
  EXPECT_TRUE(find_anatomy(character, hints).sure());
  EXPECT_EQ(find_anatomy(character, hints).up, found.up);
  hints.confirmed_up = "+Y";
  const Anatomy confirmed = find_anatomy(character, hints);
  EXPECT_TRUE(confirmed.sure());
  EXPECT_EQ(confirmed.up, glm::dvec3(0, 1, 0));
  // A confirmation does not replace what is beyond doubt: another export would go unnoticed.
  hints.confirmed_up = "+Z";
  EXPECT_EQ(find_anatomy(stick_figure(), hints).up, glm::dvec3(0, 1, 0));
  AnatomyHints specified;
  specified.up = "+Y";
  EXPECT_TRUE(find_anatomy(character, specified).sure());
  EXPECT_EQ(find_anatomy(character, specified).up, glm::dvec3(0, 1, 0));
}

TEST(Anatomy, FacesAsItIsSpecifiedWhateverIsFound) {
  AnatomyHints hints;
  hints.forward = "-Z";
  const Anatomy turned = find_anatomy(stick_figure(), hints);
  EXPECT_EQ(turned.forward, glm::dvec3(0, 0, -1));
  EXPECT_EQ(turned.left, glm::dvec3(-1, 0, 0));
  EXPECT_EQ(turned.found_forward, glm::dvec3(0, 0, 1));
  EXPECT_EQ(reason_of(turned, "faces "), "faces -Z: as specified");
  hints.forward = "+Y";
  EXPECT_THROW(find_anatomy(stick_figure(), hints), CharacterError);  // along up
  hints.forward = "backwards";
  EXPECT_THROW(find_anatomy(stick_figure(), hints), CharacterError);
}

TEST(Anatomy, WhoseLimbsPointDifferentWaysFacesAsAPersonConfirms) {
  Character character = stick_figure();
  for (Node& node : character.nodes) {
    const bool leg = node.world_from_node[3].y < 0.9;
    const double turn = (leg ? 10.0 : 50.0) * M_PI / 180.0;
    node.world_from_node =
        glm::rotate(glm::dmat4(1.0), turn, glm::dvec3(0, 1, 0)) * node.world_from_node;
  }
  const Anatomy found = find_anatomy(character);
  ASSERT_EQ(found.doubts.size(), 1u);
  EXPECT_EQ(found.doubts.front(), "which way it faces: pairs of joints point different ways");
  AnatomyHints hints;
  hints.confirmed = true;
  hints.confirmed_up = "+Y";
  for (const auto& [forward, axis] :
       {std::pair("+X", glm::dvec3(1, 0, 0)), std::pair("+Z", glm::dvec3(0, 0, 1))}) {
    hints.confirmed_forward = forward;
    const Anatomy confirmed = find_anatomy(character, hints);
    EXPECT_TRUE(confirmed.sure());
    EXPECT_EQ(confirmed.forward, axis);
  }
}

TEST(Anatomy, KnowsAnAnimalWhoseFeetHangElsewhereFromAFigureThatStandsUpright) {
  // Its hind legs end at the hocks, behind the hips, as those of a figure along +Z would below
  // them; but its tail reaches further that way, and nobody stands on that.
  Character character;
  character.file_name = "rat.glb";
  const auto add = [&](const char* name, int parent, double x, double y, double z) {
    const int node = add_node(character, name, parent, {x, y, z});
    stick_vertex(character, node);
    return node;
  };
  const int root = add("root", -1, 0.0, 0.0, 0.0);
  const int hips = add("hips", root, 0.0, 1.0, -0.5);
  const int back = add("spine", hips, 0.0, 1.05, 0.0);
  const int chest = add("chest", back, 0.0, 1.05, 0.5);
  const int neck = add("neck", chest, 0.0, 1.1, 0.8);
  add("head", neck, 0.0, 1.1, 1.0);
  for (int k = 1, parent = hips; k < 5; ++k)
    parent = add(("tail" + std::to_string(k)).c_str(), parent, 0.0, 1.0 - 0.2 * k, -0.5 - 0.5 * k);
  for (const double side : {0.1, -0.1}) {
    const std::string end = side > 0.0 ? ".L" : ".R";
    const int thigh = add(("thigh" + end).c_str(), hips, side, 0.9, -0.5);
    add(("shin" + end).c_str(), thigh, side, 0.6, -1.1);
    const int arm = add(("upper_arm" + end).c_str(), chest, side, 0.9, 0.5);
    add(("forearm" + end).c_str(), arm, side, 0.4, 0.5);
    add(("foot" + end).c_str(), root, side, 0.0, -1.1);
  }
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_EQ(anatomy.up, glm::dvec3(0, 1, 0));
  EXPECT_EQ(anatomy.forward, glm::dvec3(0, 0, 1));
  EXPECT_TRUE(anatomy.sure());  // it stands on its forelegs
}

TEST(Anatomy, TakesShouldersThatHangFromTheNeck) {
  Character character = stick_figure();
  for (Node& node : character.nodes)
    if (node.name.rfind("clavicle", 0) == 0) node.parent = stick_node(character, "neck");
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_EQ(names_of(character, anatomy.left_arm), (Names{"clavicle.L", "arm.L", "hand.L"}));
  EXPECT_EQ(anatomy.spine[anatomy.chest_index], stick_node(character, "neck"));
  EXPECT_EQ(anatomy.chest, stick_node(character, "neck"));
  EXPECT_EQ(anatomy.neck_index, anatomy.chest_index);
  const SpineDriver driver(character, anatomy);
  EXPECT_TRUE(driver.arms_follow_chest());
}

TEST(Anatomy, OfAPelvisAndABellyThatHangBesideEachOtherHasTheLegsBelow) {
  // Names that say nothing but left and right: which limbs are legs is told by where they are.
  const std::pair<const char*, const char*> names[] = {
      {"hips", "a"}, {"spine_", "b"}, {"neck", "c"}, {"clavicle", "d"}, {"arm", "e"},
      {"hand", "f"}, {"thigh", "g"},  {"shin", "h"}, {"foot", "i"}};
  for (const std::string common : {"a scene", "a joint", "nothing"}) {
    SCOPED_TRACE(common);
    Character character = stick_figure();
    const int scene = stick_node(character, "scene"), hips = stick_node(character, "hips");
    const int root = common == "a joint"   ? add_node(character, "j", scene, glm::dvec3(0.0))
                     : common == "a scene" ? scene
                                           : -1;
    if (common == "a joint") {
      character.joints.push_back({root, glm::dmat4(1.0)});
      character.nodes[static_cast<std::size_t>(hips)].parent = root;
    }
    const int pelvis = add_node(character, "k", root, {0.0, 0.9, 0.0});
    stick_vertex(character, pelvis);
    for (const char* thigh : {"thigh.L", "thigh.R"})
      character.nodes[static_cast<std::size_t>(stick_node(character, thigh))].parent = pelvis;
    for (Node& node : character.nodes)
      for (const auto& [part, letter] : names)
        if (node.name.starts_with(part)) node.name.replace(0, std::string(part).size(), letter);
    const Anatomy anatomy = find_anatomy(character);
    EXPECT_EQ(names_of(character, anatomy.spine), (Names{"a", "b1", "b2", "c", "head"}));
    EXPECT_EQ(names_of(character, anatomy.left_arm), (Names{"d.L", "e.L", "f.L"}));
    EXPECT_EQ(names_of(character, anatomy.left_leg), (Names{"g.L", "h.L", "i.L"}));
    EXPECT_EQ(character.nodes[static_cast<std::size_t>(anatomy.chest)].name, "b2");
    EXPECT_TRUE(anatomy.sure());
  }
}

TEST(Anatomy, SaysWhatTheChestWasToldBy) {
  const auto with_arms_on = [](const char* left, const char* right) {
    Character character = stick_figure();
    character.nodes[static_cast<std::size_t>(stick_node(character, "clavicle.L"))].parent =
        stick_node(character, left);
    character.nodes[static_cast<std::size_t>(stick_node(character, "clavicle.R"))].parent =
        stick_node(character, right);
    return character;
  };
  EXPECT_EQ(reason_of(find_anatomy(with_arms_on("spine_2", "neck")), "chest: "),
            "chest: 'spine_2', the lower of the joints that the arms hang from; 'neck' goes on "
            "from it, so that neither shoulder leaves the other");
  // By the middle between their roots, at 1.35: spine_2 stands at 1.23, the neck at 1.4, and no arm
  // goes with a neck for being nearer to it.
  EXPECT_EQ(reason_of(find_anatomy(with_arms_on("scene", "scene")), "chest: "),
            "chest: 'spine_2', the spine joint nearest to where the arms start; they hang from "
            "'scene', beside the spine");
  EXPECT_EQ(reason_of(find_anatomy(with_arms_on("hips", "hips")), "chest: "),
            "chest: 'spine_2', the spine joint nearest to where the arms start; they hang from "
            "'hips', the hips");
  Character low = with_arms_on("hips", "hips");
  for (Node& node : low.nodes)
    for (const char* part : {"clavicle", "arm", "hand"})
      if (node.name.starts_with(part)) node.world_from_node[3].y = 0.95;
  const Anatomy at_the_hips = find_anatomy(low);
  EXPECT_EQ(at_the_hips.chest, -1);
  EXPECT_EQ(reason_of(at_the_hips, "chest: "),
            "chest: 'neck', the first joint called neck; the arms start at the hips, which leaves "
            "no spine below them");
  EXPECT_FALSE(SpineDriver(low, at_the_hips).arms_follow_chest());
}

/// A fish: fins on the first joint of a long tail, and a short neck the other way.
TEST(Anatomy, DrivesAFishBeyondItsFins) {
  Character character;
  character.file_name = "fish.glb";
  const auto add = [&](const std::string& name, int parent, const glm::dvec3& at) {
    const int node = add_node(character, name, parent, at);
    stick_vertex(character, node);
    return node;
  };
  const int pelvis = add("pelvis", -1, {0, 1, 0});
  add("head", add("neck", pelvis, {0, 1, 0.2}), {0, 1, 0.4});
  int last = pelvis;
  for (int k = 1; k <= 5; ++k) {
    last = add("tail_" + std::to_string(k), last, {0, 1, -0.4 * k});
    if (k == 1)
      for (const double side : {1.0, -1.0}) {
        const std::string end = side > 0.0 ? "_l" : "_r";
        const int fin = add("front_fin_0" + end, last, {0.1 * side, 1, -0.4});
        add("front_fin_1" + end, fin, {0.5 * side, 1, -0.5});
      }
  }
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_EQ(anatomy.chest, stick_node(character, "tail_1"));
  EXPECT_EQ(anatomy.spine[anatomy.chest_index], stick_node(character, "tail_5"));
  EXPECT_EQ(
      reason_of(anatomy, "driven: "),
      "driven: on from there to 'tail_5', the end of the chain: a fish bends behind its fins");
  EXPECT_FALSE(SpineDriver(character, anatomy).arms_follow_chest());
}

/// A joint with a vertex of its own, `way` from its parent.
int hang(Character& character, const std::string& name, int parent, const glm::dvec3& way) {
  const glm::dvec3 from(character.nodes[static_cast<std::size_t>(parent)].world_from_node[3]);
  const int node = add_node(character, name, parent, from + way);
  stick_vertex(character, node);
  return node;
}

TEST(Anatomy, FollowsALimbPastStubsToWhereItForks) {
  const Anatomy plain = find_anatomy(stick_figure());
  // Beside the forearm of 0.5 a branch of less than half of that is a helper, one of more a fork.
  for (const double branch : {0.24, 0.26}) {
    Character character = stick_figure();
    for (const double side : {1.0, -1.0}) {
      const std::string end = side > 0.0 ? ".L" : ".R";
      const int half =
          hang(character, "extra" + end, stick_node(character, "arm" + end), {0, 0, 0.5 * branch});
      hang(character, "extra2" + end, half, {0, 0, 0.5 * branch});
    }
    const Anatomy anatomy = find_anatomy(character);
    EXPECT_EQ(anatomy.left_arm.size(), plain.left_arm.size() - (branch > 0.25 ? 1 : 0)) << branch;
    EXPECT_EQ(anatomy.right_arm.size(), anatomy.left_arm.size());
    EXPECT_EQ(anatomy.left_arm[1], stick_node(character, "arm.L"));
  }
  // A foot of 0.83 m of leg goes on where the longer of two branches is a quarter of that or more.
  for (const double toe : {0.2, 0.215}) {
    Character character = stick_figure();
    for (const double side : {1.0, -1.0}) {
      const std::string end = side > 0.0 ? ".L" : ".R";
      const int foot = stick_node(character, "foot" + end);
      hang(character, "q" + end, foot, {0, 0, toe});
      hang(character, "p" + end, foot, {0, 0, -0.05});
    }
    const Anatomy anatomy = find_anatomy(character);
    ASSERT_EQ(anatomy.left_leg.size(), plain.left_leg.size() + (toe > 0.2075 ? 1 : 0)) << toe;
    if (toe > 0.2075) {
      EXPECT_EQ(anatomy.left_leg.back(), stick_node(character, "q.L"));
    }
  }
  // Fingers, twist joints, controls and end markers are no limb's next joint; a hand is the last.
  for (const char* name : {"index_finger", "forearm_twist", "ik_ctrl"}) {
    Character character = stick_figure();
    for (const double side : {1.0, -1.0}) {
      const std::string end = side > 0.0 ? ".L" : ".R";
      hang(character, name + end, stick_node(character, "arm" + end), {0.3 * side, 0, 0.3});
      hang(character, "more" + end, stick_node(character, "hand" + end), {0.2 * side, 0, 0});
    }
    EXPECT_EQ(find_anatomy(character).left_arm, plain.left_arm) << name;
    EXPECT_EQ(find_anatomy(character).right_arm, plain.right_arm) << name;
  }
}

TEST(Anatomy, TakesATailFromWhereItLeavesTheBody) {
  Character character = stick_figure();
  const int stub = hang(character, "stub", stick_node(character, "hips"), {0, 0.02, -0.1});
  std::vector<int> tail{stub};
  for (int k = 1; k <= 3; ++k)
    tail.push_back(hang(character, "tail_" + std::to_string(k), tail.back(), {0, -0.02, -0.12}));
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_EQ(anatomy.tail, tail);
  EXPECT_EQ(anatomy.spine, find_anatomy(stick_figure()).spine);
  character.nodes[static_cast<std::size_t>(stub)].name = "tail_ctrl";
  for (std::size_t k = 1; k < tail.size(); ++k)
    character.nodes[static_cast<std::size_t>(tail[k])].name = "bit" + std::to_string(k);
  EXPECT_TRUE(find_anatomy(character).tail.empty());
}

TEST(Anatomy, LetsALooseJointGoWithTheNearestThatItTouches) {
  const double size = 1.4 + 0.02;  // hand to hand and a vertex beside; the height is 1.47 at most
  for (const double share : {0.028, 0.032}) {
    Character character = stick_figure();
    const int foot = stick_node(character, "foot.L");
    const int loose =
        hang(character, "loose", stick_node(character, "scene"),
             glm::dvec3(character.nodes[static_cast<std::size_t>(foot)].world_from_node[3]) +
                 glm::dvec3(0, 0, share * 1.47));
    const Anatomy anatomy = find_anatomy(character);
    ASSERT_LT(size, anatomy.height);
    ASSERT_EQ(anatomy.followers.size(), share < 0.03 ? 1u : 0u) << anatomy.height;
    if (share > 0.03) continue;
    EXPECT_EQ(anatomy.followers[0].node, loose);
    EXPECT_EQ(anatomy.followers[0].leader, foot);
  }
  // Of two in reach the nearer; what hangs from a loose joint comes along and is none of its own.
  Character character = stick_figure();
  const int spine = stick_node(character, "spine_2"), neck = stick_node(character, "neck");
  character.nodes[static_cast<std::size_t>(neck)].world_from_node[3] =
      character.nodes[static_cast<std::size_t>(spine)].world_from_node[3] +
      glm::dvec4(0, 0.05, 0, 0);
  const int loose =
      hang(character, "loose", stick_node(character, "scene"),
           glm::dvec3(character.nodes[static_cast<std::size_t>(spine)].world_from_node[3]) +
               glm::dvec3(0.0, 0.03, 0.0));
  hang(character, "lower", loose, {0, -0.03, 0});
  const Anatomy anatomy = find_anatomy(character);
  ASSERT_EQ(anatomy.followers.size(), 1u);
  EXPECT_EQ(anatomy.followers[0].leader, neck);
}

TEST(Anatomy, TakesTheLongestOfSeveralPairsThatAreCalledArms) {
  const Anatomy expected = find_anatomy(stick_figure());
  for (const char* parent : {"spine_1", "neck"})  // before the arms in the file's order, and behind
    for (const char* part : {"arm_small", "leg_small"}) {
      Character character = stick_figure();
      for (const double side : {1.0, -1.0}) {
        int above = stick_node(character, parent);
        for (int k = 0; k < 2; ++k) {
          above = add_node(
              character, std::string(part) + (k == 0 ? "" : "_lower") + (side > 0.0 ? ".L" : ".R"),
              above, {(0.1 + 0.15 * k) * side, 1.2, 0.05});
          stick_vertex(character, above);
        }
      }
      const Anatomy anatomy = find_anatomy(character);
      EXPECT_EQ(anatomy.left_arm, expected.left_arm) << parent << part;
      EXPECT_EQ(anatomy.right_arm, expected.right_arm);
      EXPECT_EQ(anatomy.left_leg, expected.left_leg) << parent << part;
      EXPECT_EQ(anatomy.right_leg, expected.right_leg);
    }
}

/// The stick figure again, `scale` as large, its names behind `pony_`; below the node of that name,
/// or as a tree of its own.
void add_second_figure(Character& character, const std::string& below, const glm::dvec3& at,
                       double scale) {
  const Character one = stick_figure();
  std::vector<int> copy(one.nodes.size(), below.empty() ? -1 : stick_node(character, below));
  for (std::size_t n = 1; n < one.nodes.size(); ++n) {  // not the scene
    const Node& node = one.nodes[n];
    copy[n] = add_node(character, "pony_" + node.name, copy[static_cast<std::size_t>(node.parent)],
                       at + scale * glm::dvec3(node.world_from_node[3]));
    stick_vertex(character, copy[n]);
  }
}

TEST(Anatomy, OfTheFigureWithTheSpineIsItsOwnWhateverOtherFigureTheFileHolds) {
  Character alone = stick_figure();
  stick_vertex(alone, stick_node(alone, "scene"));  // both hang from a joint, too
  const Anatomy expected = find_anatomy(alone);
  for (const char* below : {"", "scene"})
    for (const double scale : {0.8, 2.0})
      for (const double beside : {0.1, 3.0}) {  // its hips touch the thigh of the first, or not
        SCOPED_TRACE(std::string(below) + " " + std::to_string(scale));
        Character character = alone;
        add_second_figure(character, below, {beside, 0.9 * (1.0 - scale), 0.0}, scale);
        hang(character, "pony_tail", stick_node(character, "pony_hips"), {0.0, 0.0, -0.3});
        const Anatomy anatomy = find_anatomy(character);
        EXPECT_EQ(anatomy.spine, expected.spine);
        EXPECT_EQ(anatomy.left_arm, expected.left_arm);
        EXPECT_EQ(anatomy.right_arm, expected.right_arm);
        EXPECT_EQ(anatomy.left_leg, expected.left_leg);
        EXPECT_EQ(anatomy.right_leg, expected.right_leg);
        EXPECT_EQ(anatomy.tail, expected.tail);
        EXPECT_EQ(anatomy.chest_index, expected.chest_index);
        EXPECT_TRUE(anatomy.followers.empty());
        EXPECT_TRUE(anatomy.sure());
        EXPECT_EQ(reason_of(anatomy, "another figure: "),
                  "another figure: 'pony_hips' has limbs of its own, and is left out");
      }
}

TEST(Anatomy, OfAFigureWithTwoPairsOfWingsOnARootOfTheirOwnIsOneFigures) {
  Character character = stick_figure();
  const int root = add_node(character, "wings", -1, {0.0, 1.3, -0.1});
  stick_vertex(character, root);
  for (const double side : {1.0, -1.0})
    for (const std::string name : {"wing_front", "wing_back"}) {
      const std::string end = side > 0.0 ? ".L" : ".R";
      const int near = hang(character, name + end, root, {0.1 * side, 0.0, 0.0});
      hang(character, name + "_tip" + end, near, {0.6 * side, 0.1, 0.0});
    }
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_TRUE(anatomy.other_figures.empty());
  EXPECT_EQ(anatomy.left_arm, find_anatomy(stick_figure()).left_arm);
}

TEST(Anatomy, OfAFigureWhoseSkeletonIsThereTwiceIsOneFigures) {
  Character character = stick_figure();
  add_second_figure(character, "", glm::dvec3(0.0), 1.0);
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_EQ(reason_of(anatomy, "another figure: "), "");
  ASSERT_FALSE(anatomy.followers.empty());
  EXPECT_EQ(anatomy.followers.front().leader, stick_node(character, "hips"));
}

TEST(Anatomy, IsOverriddenByHints) {
  const Character character = stick_figure();
  AnatomyHints hints;
  hints.hip = "spine_1";
  hints.chest = "spine_2";
  const Anatomy anatomy = find_anatomy(character, hints);
  EXPECT_EQ(names_of(character, anatomy.spine), (Names{"spine_1", "spine_2", "neck", "head"}));
  EXPECT_EQ(anatomy.chest_index, 1u);

  AnatomyHints spine;
  spine.spine = {"hips", "spine_2", "head"};
  spine.left_arm = {"arm.L"};
  spine.right_arm = {"arm.R", "hand.R"};
  const Anatomy given = find_anatomy(character, spine);
  EXPECT_EQ(names_of(character, given.spine), (Names{"hips", "spine_2", "head"}));
  EXPECT_EQ(names_of(character, given.left_arm), (Names{"arm.L"}));
  EXPECT_EQ(names_of(character, given.right_arm), (Names{"arm.R", "hand.R"}));
}

AnatomyHints between(const std::string& hip, const std::string& chest) {
  AnatomyHints hints;
  hints.hip = hip;
  hints.chest = chest;
  return hints;
}
AnatomyHints along(const Names& spine) {
  AnatomyHints hints;
  hints.spine = spine;
  return hints;
}

std::string refusal(const Character& character, const AnatomyHints& hints = {}) {
  try {
    find_anatomy(character, hints);
    return "";
  } catch (const CharacterError& error) {
    return error.what();
  }
}

TEST(Anatomy, TakesArmsThatAreNamedBesideTheirClaviclesAsItFoundThem) {
  Character character = stick_figure();
  for (Node& node : character.nodes)
    if (node.name.starts_with("arm")) node.parent = stick_node(character, "scene");
  const Anatomy found = find_anatomy(character);
  ASSERT_EQ(names_of(character, found.left_arm), (Names{"clavicle.L", "arm.L", "hand.L"}));
  AnatomyHints hints;
  hints.left_arm = names_of(character, found.left_arm);
  hints.right_arm = names_of(character, found.right_arm);
  const Anatomy again = find_anatomy(character, hints);
  EXPECT_EQ(again.left_arm, found.left_arm);
  EXPECT_EQ(again.followers.size(), found.followers.size());
  hints.left_arm = {"arm.L", "clavicle.L"};
  EXPECT_NE(refusal(character, hints).find("does not hang from"), std::string::npos);
}

TEST(Anatomy, RefusesHintsThatDoNotFitAndNamesTheNearest) {
  const Character character = stick_figure();
  EXPECT_NE(refusal(character, between("hip", ""))
                .find("no joint is called 'hip'; the nearest is 'hips'"),
            std::string::npos);
  EXPECT_NE(refusal(character, between("Schwanzwurzel", ""))
                .find("no joint is called 'Schwanzwurzel'; backbend inspect shows all"),
            std::string::npos);
  const struct {
    const char *wrong, *meant;
  } slips[] = {{"spin_1", "spine_1"},       {"spinee_2", "spine_2"}, {"sceme", "scene"},
               {"clavicl.L", "clavicle.L"}, {"hin.R", "shin.R"},     {"xthighy.L", "thigh.L"},
               {"fo.L", "foot.L"}};
  for (const auto& slip : slips)
    EXPECT_NE(refusal(character, between(slip.wrong, ""))
                  .find("the nearest is '" + std::string(slip.meant) + "'"),
              std::string::npos)
        << slip.wrong << ": " << refusal(character, between(slip.wrong, ""));
  EXPECT_NE(refusal(character, along({"hips", "foot.L", "hand.L"})).find("does not hang from"),
            std::string::npos);
  EXPECT_NE(refusal(character, along({"neck"})).find("expected two joints or more"),
            std::string::npos);
  EXPECT_NE(refusal(character, between("spine_2", "hips")).find("is not above"), std::string::npos);
  EXPECT_NE(refusal(character, between("foot.L", "")).find("does not hang from the hips"),
            std::string::npos);
  Character twins = stick_figure();
  twins.nodes[3].name = "spine_1";
  EXPECT_NE(refusal(twins, between("spine_1", "")).find("several joints"), std::string::npos);
  EXPECT_EQ(refusal(twins, between("#2", "")), "");  // a number is always its own
}

/// Joints without names or symmetry: a table with odd legs.
Character furniture() {
  Character character;
  character.file_name = "table.glb";
  const auto add = [&](int parent, const glm::dvec3& at) {
    stick_vertex(
        character,
        add_node(character, std::string("#").append(std::to_string(character.nodes.size())), parent,
                 at));
  };
  add(-1, {0, 1, 0});
  add(0, {1, 0.2, 0.3});
  add(0, {-0.4, 0.1, 1.3});
  add(0, {-1.2, 0.6, -0.2});
  return character;
}

TEST(Anatomy, RefusesToGuessAndAsksForNames) {
  const std::string error = refusal(furniture());
  EXPECT_NE(error.find("table.glb: uncertain spine"), std::string::npos) << error;
  EXPECT_NE(error.find("--hip and --chest"), std::string::npos) << error;
  EXPECT_EQ(refusal(furniture(), between("#0", "#2")), "");
}

/// The stick figure with `name` hung from `parent` (none: -1), standing where it stood; parents
/// stay before their children.
void hang(Character& character, const std::string& name, const std::string& parent) {
  character.nodes[static_cast<std::size_t>(stick_node(character, name))].parent =
      parent.empty() ? -1 : stick_node(character, parent);
}

TEST(Anatomy, RefusesASkeletonWhoseHierarchyWasLost) {
  Character character = stick_figure();
  for (const char* name : {"hips", "spine_1", "spine_2", "neck", "head"})
    hang(character, name, "scene");
  const std::string error = refusal(character);
  EXPECT_NE(error.find("could be the hips"), std::string::npos) << error;
  // Where the common root is a joint of the body, it could be the hips but for the others' names.
  stick_vertex(character, stick_node(character, "scene"));
  const std::string told = refusal(character);
  EXPECT_NE(told.find("do not stand between"), std::string::npos) << told;
  EXPECT_NE(told.find("--hip and --chest"), std::string::npos) << told;
}

TEST(Anatomy, RefusesAHeadThatHangsFromTheHipsBesideAVertebra) {
  const auto told = [](const char* hips, double height) {
    Character character = stick_figure(1);
    for (const char* name : {"head", "clavicle.L", "clavicle.R"}) hang(character, name, "hips");
    const auto node = [&](const char* name) -> Node& {
      return character.nodes[static_cast<std::size_t>(stick_node(character, name))];
    };
    node("neck").name = "scarf";
    node("spine_1").world_from_node[3].y = height;
    node("hips").name = hips;
    return refusal(character);
  };
  for (const char* hips : {"hips", "spine_0"}) {
    const std::string error = told(hips, 1.15);
    EXPECT_NE(error.find("'spine_1' do not stand between"), std::string::npos) << error;
    EXPECT_EQ(told(hips, 0.5), "");  // a tail's
  }
}

/// A box figure: one joint each for hips, torso, head, arms and legs, and what they move.
/// `head` hangs from the torso; below it a mesh of its own where it is an object that has one.
Character box_figure(const std::string& arm, double arm_length, bool head_is_object = false) {
  Character character;
  character.file_name = "box.glb";
  const auto add = [&](const std::string& name, int parent, const glm::dvec3& at,
                       const glm::dvec3& end) {
    const int node = add_node(character, name, parent, at);
    stick_vertex(character, node);
    stick_vertex(character, node);
    for (std::size_t v = character.vertex_count() - 3; v < character.vertex_count(); ++v)
      character.bind_position[v] += glm::vec3(end - at);
    return node;
  };
  const int hips = add("hips", -1, {0, 0.8, 0}, {0, 0.9, 0});
  const int torso = add("torso", hips, {0, 1.0, 0}, {0, 1.3, 0});
  const int object = head_is_object ? add_node(character, "head", torso, {0, 1.4, 0}) : torso;
  add(head_is_object ? "Cube.001" : "head", object, {0, 1.4, 0}, {0, 1.7, 0});
  for (const double side : {1.0, -1.0}) {
    const std::string end = side > 0.0 ? ".L" : ".R";
    add(arm + end, torso, {0.25 * side, 1.3, 0}, {(0.25 + arm_length) * side, 1.3, 0});
    add("leg" + end, hips, {0.1 * side, 0.8, 0}, {0.1 * side, 0.0, 0});
  }
  return character;
}

TEST(Anatomy, TakesArmsAndLegsOfOneJoint) {
  const Character character = box_figure("arm", 0.6);
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_TRUE(anatomy.sure()) << anatomy.doubts.front();
  EXPECT_EQ(names_of(character, anatomy.left_arm), Names{"arm.L"});
  EXPECT_EQ(names_of(character, anatomy.right_arm), Names{"arm.R"});
  EXPECT_EQ(names_of(character, anatomy.left_leg), Names{"leg.L"});
  EXPECT_EQ(names_of(character, anatomy.right_leg), Names{"leg.R"});
  EXPECT_EQ(anatomy.chest, stick_node(character, "torso"));
  EXPECT_EQ(anatomy.forward, glm::dvec3(0, 0, 1));
  EXPECT_EQ(body_kind(character, anatomy).kind, BodyKind::human);
}

TEST(Anatomy, TakesTheMeshOfAnObjectThatIsCalledHeadForTheHead) {
  const Character character = box_figure("arm", 0.6, true);
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_TRUE(anatomy.sure()) << anatomy.doubts.front();
  EXPECT_EQ(names_of(character, anatomy.spine), (Names{"hips", "torso", "Cube.001"}));
  EXPECT_EQ(reason_of(anatomy, "head: "), "head: 'head' by its name");
}

TEST(Anatomy, TakesAClavicleForAnArmOnlyWhereItMovesOne) {
  const Character with = box_figure("shoulder", 0.6), without = box_figure("shoulder", 0.1);
  EXPECT_EQ(names_of(with, find_anatomy(with).left_arm), Names{"shoulder.L"});
  EXPECT_TRUE(find_anatomy(without).left_arm.empty());
}

TEST(Anatomy, TakesNoJointBesideALimbOfSeveralForOne) {
  Character character = stick_figure();
  const int torso = stick_node(character, "spine_1");
  for (const double side : {1.0, -1.0}) {
    const int node = add_node(character, side > 0.0 ? "armour_arm.L" : "armour_arm.R", torso,
                              {0.1 * side, 1.3, 0});
    stick_vertex(character, node);
    for (std::size_t v = character.vertex_count() - 3; v < character.vertex_count(); ++v)
      character.bind_position[v].x += 0.6f * static_cast<float>(side);
  }
  EXPECT_EQ(names_of(character, find_anatomy(character).left_arm),
            (Names{"clavicle.L", "arm.L", "hand.L"}));
}

TEST(Anatomy, DoubtsANeckThatIsAllThereIsAboveTheArms) {
  Character character = box_figure("arm", 0.6);
  EXPECT_TRUE(find_anatomy(character).sure());
  // The torso is the uppermost joint: what is left to bend is the neck.
  for (const char* name : {"leg.L", "leg.R"}) hang(character, name, "torso");
  character.nodes[static_cast<std::size_t>(stick_node(character, "hips"))].name = "root";
  character.nodes[static_cast<std::size_t>(stick_node(character, "torso"))].name = "hips";
  const Anatomy anatomy = find_anatomy(character);
  ASSERT_EQ(anatomy.doubts.size(), 1u);
  EXPECT_NE(anatomy.doubts[0].find("nothing bends between hips and chest"), std::string::npos);
  AnatomyHints hints;
  hints.confirmed = true;
  EXPECT_TRUE(find_anatomy(character, hints).sure());
}

/// A figure that is built from its chest: spine and hips hang from it downwards, neck and arms
/// beside them.
Character built_from_the_chest() {
  Character character;
  character.file_name = "doll.glb";
  const auto add = [&](const std::string& name, int parent, const glm::dvec3& at) {
    const int node = add_node(character, name, parent, at);
    stick_vertex(character, node);
    return node;
  };
  const int chest = add("chest", -1, {0, 1.25, 0});
  const int spine = add("spine", chest, {0, 1.1, 0});
  const int hips = add("hips", spine, {0, 0.95, 0});
  add("head", add("neck", chest, {0, 1.5, 0}), {0, 1.6, 0});
  for (const double side : {1.0, -1.0}) {
    const std::string end = side > 0.0 ? ".L" : ".R";
    add("hand" + end, add("arm" + end, chest, {0.2 * side, 1.4, 0}), {0.7 * side, 1.4, 0});
    add("foot" + end, add("thigh" + end, hips, {0.1 * side, 0.9, 0}), {0.1 * side, 0.05, 0});
  }
  return character;
}

TEST(Anatomy, TakesAPelvisBesideTheLegsForTheTailsAlone) {
  Character character = stick_figure();
  const int hips = stick_node(character, "hips");
  character.nodes[static_cast<std::size_t>(hips)].name = "spine";
  const int pelvis = add_node(character, "pelvis.C", hips, {0, 1.0, -0.2});
  stick_vertex(character, pelvis);
  stick_vertex(character, add_node(character, "tail", pelvis, {0, 0.9, -0.6}));
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_EQ(names_of(character, anatomy.spine),
            (Names{"spine", "spine_1", "spine_2", "neck", "head"}));
}

TEST(Anatomy, GoesUpAndDownASkeletonThatIsBuiltFromTheChest) {
  const Character character = built_from_the_chest();
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_EQ(names_of(character, anatomy.spine), (Names{"hips", "spine", "chest", "neck", "head"}));
  EXPECT_EQ(names_of(character, anatomy.left_arm), (Names{"arm.L", "hand.L"}));
  // Bent, the body stays together: legs on the hips, arms and head on the end of the chain.
  const SpineDriver driver(character, anatomy);
  const auto system = solver::build_system({"even", {}}, driver.rest_chain());
  const auto rest = driver.drive(*system, system->rest());
  for (std::size_t n = 0; n < rest.size(); ++n)
    EXPECT_EQ(rest[n], character.nodes[n].world_from_node);
  const auto pose = system->solve(system->controls_for({.extension = 1.0}, solver::Mapping::chest));
  const auto world = driver.drive(*system, pose);
  const auto at = [&](const char* name) {
    return glm::dvec3(world[static_cast<std::size_t>(stick_node(character, name))][3]);
  };
  EXPECT_NEAR(glm::distance(at("hips"), at("foot.L")), std::hypot(0.1, 0.9), 1e-9);
  EXPECT_NEAR(glm::distance(at("hips"), glm::dvec3(0, 0.95, 0)), 0.0, 1e-9);
  EXPECT_EQ(anatomy.chest, stick_node(character, "chest"));
  EXPECT_NEAR(glm::distance(at("chest"), pose.position.back()), 0.0, 1e-9);
  EXPECT_NEAR(glm::distance(at("neck"), at("arm.L")), std::hypot(0.2, 0.1), 1e-9);
}

TEST(Anatomy, FindsTheHeadWherePelvisAndRibcageHangBesideEachOther) {
  Character character;
  character.file_name = "parted.glb";
  const auto add = [&](int parent, const glm::dvec3& at) {
    const int node = add_node(character, "#" + std::to_string(character.nodes.size()), parent, at);
    stick_vertex(character, node);
    return node;
  };
  const int centre = add(-1, {0, 1.0, 0});
  const int pelvis = add(centre, {0, 0.97, 0});
  const int low = add(centre, {0, 1.1, 0}), high = add(low, {0, 1.3, 0});
  const int neck = add(high, {0, 1.5, 0}), head = add(neck, {0, 1.6, 0});
  for (const double side : {1.0, -1.0}) {
    add(add(high, {0.2 * side, 1.4, 0}), {0.7 * side, 1.4, 0});
    add(add(pelvis, {0.1 * side, 0.9, 0}), {0.1 * side, 0.05, 0});
  }
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_EQ(anatomy.spine, (std::vector<int>{centre, low, high, neck, head}));
  EXPECT_EQ(anatomy.left_arm.size(), 2u);
}

TEST(Anatomy, ReadsASkeletonWithoutAForkFromEndToEnd) {
  Character character;
  character.file_name = "rope.glb";
  for (int k = 0; k < 6; ++k) {
    stick_vertex(character,
                 add_node(character, "#" + std::to_string(k), k - 1, {0.0, 0.2 * k, 0.0}));
  }
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_EQ(anatomy.spine, (std::vector<int>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(anatomy.chest_index, 5u);
  EXPECT_EQ(anatomy.chest, -1);
  EXPECT_TRUE(anatomy.left_arm.empty());
  EXPECT_NEAR(anatomy.spine_length, 1.0, 1e-12);
}

/// Joints in a row that lean forward, and a vertex on each.
Character row_of_joints(const Names& names) {
  Character character;
  character.file_name = "row.glb";
  for (int k = 0; k < static_cast<int>(names.size()); ++k)
    stick_vertex(character, add_node(character, names[static_cast<std::size_t>(k)], k - 1,
                                     {0.1 * k, 0.3 * k, 0.0}));
  return character;
}

TEST(Anatomy, NeedsTwoJointsForASpineAndNoMore) {
  EXPECT_NE(refusal(row_of_joints({"hips"})), "");  // one alone bends nothing
  const Anatomy anatomy = find_anatomy(row_of_joints({"hips", "#"}));
  EXPECT_EQ(anatomy.spine, (std::vector<int>{0, 1}));
  EXPECT_EQ(anatomy.chest_index, 1u);
  EXPECT_EQ(anatomy.head, 1);
  EXPECT_NEAR(anatomy.spine_length, std::hypot(0.1, 0.3), 1e-12);
}

/// A chest's lid or a door is two joints in a row as well.
TEST(Anatomy, AFewJointsWithoutNamesAreNoSureSpine) {
  EXPECT_NE(refusal(row_of_joints({"Bottom", "Top"})).find("no joint is named head"),
            std::string::npos);
  EXPECT_NE(refusal(row_of_joints({"#0", "#1", "#2"})), "");
  EXPECT_EQ(find_anatomy(row_of_joints({"#0", "#1", "#2", "#3"})).spine.size(), 4u);
  EXPECT_EQ(find_anatomy(row_of_joints({"#0", "#1", "head"})).spine.size(), 3u);
}

/// A snake along +Z, its head at the end of +Z, built from the head or from the tail; a jaw hangs
/// from the head.
Character snake(bool from_head) {
  const Names names = {"Tail", "Body3", "Body2", "Body1", "Neck", "Head"};
  Character character;
  character.file_name = "snake.glb";
  const auto add = [&](const std::string& name, int parent, double z) {
    stick_vertex(character, add_node(character, name, parent, glm::dvec3(0.0, 0.1, z)));
  };
  for (int k = 0; k < 6; ++k) {
    const int at = from_head ? 5 - k : k;
    add(names[static_cast<std::size_t>(at)], k - 1, 0.4 * at);
  }
  add("Jaw", from_head ? 0 : 5, 2.1);
  return character;
}

TEST(Anatomy, OfASnakeIsTheSameWhicheverEndItIsBuiltFrom) {
  const Names expected = {"Tail", "Body3", "Body2", "Body1", "Neck", "Head"};
  for (const bool from_head : {false, true}) {
    const Character character = snake(from_head);
    const Anatomy anatomy = find_anatomy(character);
    EXPECT_EQ(names_of(character, anatomy.spine), expected);
    EXPECT_EQ(names_of(character, {anatomy.spine[anatomy.chest_index]}), Names{"Neck"});
    EXPECT_EQ(anatomy.forward, glm::dvec3(0, 0, 1));
    EXPECT_TRUE(anatomy.followers.empty());
    // Driven, the jaw stays on the head, and the head goes with the end of the chain.
    const SpineDriver driver(character, anatomy);
    const auto system = solver::build_system({"even", {}}, driver.rest_chain());
    const auto pose =
        system->solve(system->controls_for({.extension = 1.0}, solver::Mapping::chest));
    const auto world = driver.drive(*system, pose);
    const auto at = [&](const char* name) {
      return glm::dvec3(world[static_cast<std::size_t>(stick_node(character, name))][3]);
    };
    EXPECT_NEAR(glm::distance(at("Neck"), pose.position.back()), 0.0, 1e-9);
    EXPECT_NEAR(glm::distance(at("Head"), at("Jaw")), 0.1, 1e-9);
    EXPECT_NEAR(glm::distance(at("Head"), at("Neck")), 0.4, 1e-9);
  }
}

TEST(Anatomy, OfASnakeOfAHeadAndOneJointIsNotGuessed) {
  for (const bool longer : {false, true}) {
    Character character;
    character.file_name = "snake.glb";
    int last = -1;
    for (const char* name : {"Head", "Body1", "Body2"}) {
      if (std::string(name) == "Body2" && !longer) break;
      last = add_node(character, name, last, {0.0, 0.1, 2.0 - 0.4 * (last + 1)});
      stick_vertex(character, last);
    }
    stick_vertex(character, add_node(character, "Jaw", 0, {0.0, 0.1, 2.1}));
    if (longer) {
      EXPECT_EQ(names_of(character, find_anatomy(character).spine),
                (Names{"Body2", "Body1", "Head"}));
    } else {
      EXPECT_THROW(find_anatomy(character), CharacterError);
    }
  }
}

TEST(Anatomy, IgnoresControlsAndEndMarkers) {
  Character character = stick_figure();
  const auto add = [&](const char* name, int parent, const glm::dvec3& at) {
    stick_vertex(character, add_node(character, name, parent, at));
  };
  add("ik_foot.L", 0, {0.1, 0.05, 0.0});
  add("ik_foot.R", 0, {-0.1, 0.05, 0.0});
  add("head_end", stick_node(character, "head"), {0.0, 1.7, 0.0});
  add("head_ctrl", 0, {0.0, 1.9, 0.0});
  add("twist.L", stick_node(character, "arm.L"), {0.4, 1.35, 0.0});
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_EQ(names_of(character, anatomy.spine),
            (Names{"hips", "spine_1", "spine_2", "neck", "head"}));
  EXPECT_EQ(names_of(character, anatomy.left_arm), (Names{"clavicle.L", "arm.L", "hand.L"}));
}

TEST(Anatomy, PrefersBonesThatAreMarkedAsDeformingToTheMechanismBesideThem) {
  Character character;
  character.file_name = "beast.glb";
  const auto control = [&](const std::string& name, int parent, const glm::dvec3& at) {
    const int node = add_node(character, name, parent, at);
    character.joints.push_back({node, glm::inverse(character.nodes.back().world_from_node)});
    return node;
  };
  const auto bone = [&](const std::string& name, int parent, const glm::dvec3& at) {
    const int node = add_node(character, name, parent, at);
    stick_vertex(character, node);
    return node;
  };
  const int root = control("root", -1, glm::dvec3(0.0));
  // What an animator holds, hips first, with a head that carries a bone of its own.
  int held = control("hips", root, {0, 1.0, -0.6});
  held = control("torso", held, {0, 1.0, -0.3});
  held = control("chest", held, {0, 1.0, 0.2});
  const int ribs = held;
  held = control("neck", held, {0, 1.1, 0.5});
  held = control("head", held, {0, 1.5, 0.8});
  bone("DEF-skull", held, {0, 1.55, 0.85});
  bone("DEF-skull.001", held, {0, 1.6, 0.85});
  bone("saddle", ribs, {0, 1.1, 0.0});  // added by hand, without the mark
  int last = root;
  Names spine;
  for (const auto& [name, y, z] :
       {std::tuple("DEF-spine.001", 1.0, -0.6), std::tuple("DEF-spine.002", 1.0, -0.3),
        std::tuple("DEF-spine.003", 1.0, 0.0), std::tuple("DEF-spine.004", 1.0, 0.2),
        std::tuple("DEF-neck", 1.1, 0.5), std::tuple("DEF-head", 1.5, 0.8)}) {
    last = bone(name, last, {0, y, z});
    spine.push_back(name);
  }
  for (const double side : {1.0, -1.0}) {
    const std::string end = side > 0.0 ? ".L" : ".R";
    const int shoulder = control("ORG-shoulder" + end, ribs, {0.1 * side, 0.9, 0.25});
    const int arm = bone("DEF-shoulder" + end, shoulder, {0.1 * side, 0.9, 0.25});
    bone("DEF-hand" + end, bone("DEF-arm" + end, arm, {0.15 * side, 0.7, 0.25}),
         {0.15 * side, 0.0, 0.25});
    const int pelvis = control("ORG-pelvis" + end, root, {0.1 * side, 0.9, -0.6});
    const int thigh = bone("DEF-thigh" + end, pelvis, {0.12 * side, 0.8, -0.6});
    bone("DEF-foot" + end, thigh, {0.15 * side, 0.0, -0.6});
  }
  EXPECT_EQ(names_of(character, find_anatomy(character).spine), spine);
}

TEST(Anatomy, FindsTheHeadByTheNeckOfAFigureWithoutLegs) {
  for (const bool has_child : {true, false}) {
    Character genie;
    const auto bone = [&](const std::string& name, int parent, const glm::dvec3& at) {
      const int node = add_node(genie, name, parent, at);
      stick_vertex(genie, node);
      return node;
    };
    const int core = bone("Core", -1, {0, 1.0, 0});
    const int torso = bone("Torso", core, {0, 1.3, 0});
    const int neck = bone("Neck", torso, {0, 1.5, 0});
    if (has_child) bone("joint4", neck, {0, 1.6, 0});
    for (const double side : {1.0, -1.0}) {
      const std::string which = side > 0.0 ? "Left" : "Right";
      const int arm = bone(which + "_Arm", torso, {0.2 * side, 1.4, 0});
      bone(which + "_Wrist", bone(which + "_Elbow", arm, {0.45 * side, 1.4, 0}),
           {0.7 * side, 1.4, 0});
    }
    const Anatomy anatomy = find_anatomy(genie);
    Names spine{"Core", "Torso", "Neck"};
    if (has_child) spine.push_back("joint4");
    EXPECT_EQ(names_of(genie, anatomy.spine), spine);
    EXPECT_EQ(names_of(genie, anatomy.left_arm), (Names{"Left_Arm", "Left_Elbow", "Left_Wrist"}));
  }
}

TEST(Anatomy, FindsTheHeadByTheFaceThatHangsFromIt) {
  // Arms and legs hang from one joint, and the head is called after the body.
  const auto goblin_with = [](const char* left_ear, const char* right_ear, bool on_head) {
    Character goblin;
    const auto bone = [&](const std::string& name, int parent, const glm::dvec3& at) {
      const int node = add_node(goblin, name, parent, at);
      stick_vertex(goblin, node);
      return node;
    };
    const int base = bone("Base", -1, {0, 0.0, 0.4});
    const int body = bone("Body", base, {0, 0.4, 0});
    for (const double side : {1.0, -1.0}) {
      const std::string end = side > 0.0 ? ".L" : ".R";
      bone("Foot" + end,
           bone("Calf" + end, bone("Thigh" + end, body, {0.13 * side, 0.4, 0}),
                {0.13 * side, 0.24, 0}),
           {0.13 * side, 0.05, 0});
      bone("Forearm" + end, bone("Bicep" + end, body, {0.25 * side, 0.62, 0}),
           {0.32 * side, 0.46, 0});
    }
    const int head = bone("Body.001", body, {0, 0.64, 0});
    bone(left_ear, head, {0.27, 1.0, -0.1});
    bone(right_ear, on_head ? head : base, {-0.27, 1.0, -0.1});
    return goblin;
  };
  const Character goblin = goblin_with("Ear.L", "Ear.R", true);
  const Anatomy anatomy = find_anatomy(goblin);
  EXPECT_EQ(names_of(goblin, anatomy.spine), (Names{"Body", "Body.001"}));
  EXPECT_EQ(reason_of(anatomy, "head: "), "head: 'Body.001', which carries the face");
  EXPECT_EQ(names_of(goblin, anatomy.left_arm), (Names{"Bicep.L", "Forearm.L"}));
  // A joint that arms hang from is not a head, whatever eye it carries.
  Character robot = goblin;
  for (const char* bicep : {"Bicep.L", "Bicep.R"})
    robot.nodes[static_cast<std::size_t>(stick_node(robot, bicep))].parent =
        stick_node(robot, "Body.001");
  EXPECT_THROW(find_anatomy(robot), CharacterError);
  EXPECT_THROW(find_anatomy(goblin_with("Bow.L", "Bow.R", true)), CharacterError);
  EXPECT_THROW(find_anatomy(goblin_with("Ear.L", "Ear.R", false)), CharacterError);
}

TEST(Anatomy, TakesAPairAboveTwoPairsOfLimbsForEarsWhereNoNameTells) {
  const auto beast_with = [](const char* ear, int beyond = 0, double rise = 0.4) {
    Character beast;
    int count = 0;
    const auto bone = [&](int parent, const glm::dvec3& at, const char* name = nullptr) {
      const int node = add_node(beast, name ? name : "Bone." + std::to_string(count++), parent, at);
      stick_vertex(beast, node);
      return node;
    };
    const int hips = bone(-1, {0, 0.5, -0.5}), back = bone(hips, {0, 0.5, 0.0});
    const int shoulders = bone(back, {0, 0.5, 0.4}), head = bone(shoulders, {0, 0.8, 0.7});
    for (const double side : {1.0, -1.0}) {
      for (const int body : {hips, shoulders}) {
        const double z = body == hips ? -0.5 : 0.4;
        bone(bone(bone(body, {0.1 * side, 0.45, z}), {0.12 * side, 0.25, z}),
             {0.12 * side, 0.0, z});
      }
      const std::string name = std::string(ear) + (side > 0.0 ? ".L" : ".R");
      bone(bone(bone(head, {0.05 * side, 0.9, 0.7}, *ear ? name.c_str() : nullptr),
                {(0.25 - 0.375 * rise) * side, 0.9 + 0.5 * rise, 0.7}),
           {(0.52 - rise) * side, 0.9 + rise, 0.7});
    }
    int last = head;  // a jaw, or the neck of a body with wings
    for (int i = 0; i < beyond; ++i) last = bone(last, {0, 0.8, 0.85 + 0.15 * i});
    return beast;
  };
  const Character beast = beast_with("");
  const Anatomy anatomy = find_anatomy(beast);
  EXPECT_EQ(names_of(beast, anatomy.spine), (Names{"Bone.0", "Bone.1", "Bone.2", "Bone.3"}));
  EXPECT_EQ(reason_of(anatomy, "head: "),
            "head: 'Bone.3', which a pair hangs from above two pairs of limbs");
  for (const int root : {anatomy.left_arm.front(), anatomy.right_arm.front()})
    EXPECT_EQ(beast.nodes[static_cast<std::size_t>(root)].parent, stick_node(beast, "Bone.2"));
  EXPECT_THROW(find_anatomy(beast_with("arm")), CharacterError);
  const auto spine_of = [&](int beyond, double rise) {
    const Character other = beast_with("", beyond, rise);
    return names_of(other, find_anatomy(other).spine).size();
  };
  EXPECT_EQ(spine_of(1, 0.4), 4u);
  EXPECT_EQ(spine_of(1, 0.0), 5u);  // as arms or wings do
  EXPECT_EQ(spine_of(2, 0.4), 6u);
}

TEST(Anatomy, PairsLimbsWithoutNamesThatWerePlacedByHand) {
  // Arms of four joints, of which one reaches `share` as far as the other.
  const auto spine_with = [](double share) {
    Character figure;
    const auto bone = [&](int parent, const glm::dvec3& at) {
      const int node = add_node(figure, "Bone." + std::to_string(figure.nodes.size()), parent, at);
      stick_vertex(figure, node);
      return node;
    };
    const int hips = bone(-1, {0, 1.0, 0}), chest = bone(hips, {0, 1.4, 0});
    bone(bone(chest, {0, 1.6, 0}), {0, 1.75, 0});
    for (const double side : {1.0, -1.0}) {
      int arm = chest, leg = hips;
      for (int k = 0; k < 4; ++k) {
        const double reach = (0.15 + 0.15 * k) * (side > 0.0 ? 1.0 : share);
        arm = bone(arm, {0.1 * side + reach * side, 1.4, 0});
        leg = bone(leg, {0.15 * side, 0.95 - 0.3 * k, 0});
      }
    }
    return find_anatomy(figure).spine.size();
  };
  EXPECT_EQ(spine_with(1.0), 4u);
  EXPECT_EQ(spine_with(0.87), 4u);
  EXPECT_ANY_THROW(spine_with(0.8));
}

TEST(JointNames, AreReadWhateverTheirDialect) {
  const auto part = [](const char* name) { return read_joint_name(name).part; };
  const auto side = [](const char* name) { return read_joint_name(name).side; };
  EXPECT_EQ(part("mixamorig:LeftUpLeg"), BodyPart::leg);
  EXPECT_EQ(side("mixamorig:LeftUpLeg"), Side::left);
  EXPECT_EQ(part("Bip01 R Clavicle"), BodyPart::clavicle);
  EXPECT_EQ(side("Bip01 R Clavicle"), Side::right);
  EXPECT_EQ(part("LHipJoint"), BodyPart::leg);  // a hip with a side is a leg's
  EXPECT_EQ(side("LHipJoint"), Side::left);
  EXPECT_EQ(part("pelvis"), BodyPart::hip);
  EXPECT_EQ(part("Lefthand"), BodyPart::hand);
  EXPECT_EQ(side("Lefthand"), Side::left);
  EXPECT_EQ(part("lowerback"), BodyPart::spine);
  EXPECT_EQ(part("Armature"), BodyPart::root);
  EXPECT_EQ(part("J_Bip_C_UpperChest"), BodyPart::spine);
  EXPECT_EQ(part("Spine_Middle"), BodyPart::spine);
  EXPECT_EQ(part("middle_01_l"), BodyPart::finger);
  EXPECT_EQ(part("#12"), BodyPart::none);
  EXPECT_EQ(part("tete_014"), BodyPart::head);
  EXPECT_EQ(part("cou"), BodyPart::neck);
  EXPECT_EQ(part("Becken"), BodyPart::hip);
  EXPECT_EQ(part("epaule_L"), BodyPart::clavicle);
  EXPECT_EQ(part("Rodilla.R"), BodyPart::leg);
  EXPECT_EQ(part("T\u00eate"), BodyPart::head);
  EXPECT_EQ(part("Te\u0302te"), BodyPart::head) << "an accent that stands after its letter";
  EXPECT_EQ(part("Pesco\u00e7o"), BodyPart::neck);
  EXPECT_EQ(part("\u00c9paule.L"), BodyPart::clavicle);
  EXPECT_EQ(side("\u00c9paule.L"), Side::left);
  EXPECT_EQ(part("\xc3"), BodyPart::none) << "cut short";
  EXPECT_EQ(part("course"), BodyPart::none) << "only as a word of its own";
  EXPECT_TRUE(read_joint_name("HeadTop_End").end);
  EXPECT_TRUE(read_joint_name("IKFrontLeg.L").control);
  EXPECT_TRUE(read_joint_name("BackLeg.R").back);
  // In one case, too.
  EXPECT_TRUE(read_joint_name("IKFRONTLEG.L").control);
  EXPECT_TRUE(read_joint_name("IKFRONTLEG.L").front);
  EXPECT_TRUE(read_joint_name("BACKSHOULDER.L").back);
  EXPECT_TRUE(read_joint_name("leftbackleg").back);
  EXPECT_TRUE(read_joint_name("foreleg_r").front);
  EXPECT_FALSE(read_joint_name("FOREARM.L").front);
  EXPECT_FALSE(read_joint_name("backbone").back);
  EXPECT_EQ(part("FOREARM.L"), BodyPart::arm);
  EXPECT_EQ(read_joint_name("hand_l").without_side, read_joint_name("hand_r").without_side);
  EXPECT_NE(read_joint_name("leg01.L").without_side, read_joint_name("leg02.R").without_side);
}

TEST(VertexRegions, FollowTheJointWithTheLargestWeight) {
  const Character character = stick_figure();
  const Anatomy anatomy = find_anatomy(character);
  const auto regions = vertex_regions(character, anatomy);
  const auto of = [&](const char* name) {  // three vertices a joint, `scene` has none
    return regions[static_cast<std::size_t>(3 * (stick_node(character, name) - 1))];
  };
  EXPECT_EQ(of("hips"), Region::torso);
  EXPECT_EQ(of("spine_2"), Region::torso);
  EXPECT_EQ(of("neck"), Region::head);
  EXPECT_EQ(of("head"), Region::head);
  EXPECT_EQ(of("hand.L"), Region::arm_left);
  EXPECT_EQ(of("clavicle.R"), Region::arm_right);
  EXPECT_EQ(of("foot.L"), Region::leg_left);
  EXPECT_EQ(of("thigh.R"), Region::leg_right);
  EXPECT_EQ(region_name(Region::arm_left), "arm_L");
  EXPECT_EQ(region_name(Region::other), "other");
}

TEST(VertexRegions, CountTheFirstNodeOfAFileThatIsTheHips) {
  Character character;
  const int hips = add_node(character, "hips", -1, {0, 0.9, 0});
  add_node(character, "spine", hips, {0, 1.1, 0});
  Anatomy anatomy;
  anatomy.spine = {hips, 1};
  anatomy.chest_index = 1;
  EXPECT_EQ(node_regions(character, anatomy), (std::vector<Region>{Region::torso, Region::torso}));
}

TEST(VertexRegions, OfLooseJointsAndWhatHangsFromThemAreTheirLeaders) {
  Character character = stick_figure();
  const int scene = stick_node(character, "scene"), foot = stick_node(character, "foot.L");
  const glm::dvec3 at(character.nodes[static_cast<std::size_t>(foot)].world_from_node[3]);
  const int far = hang(character, "far", scene, {2.0, 1.0, 0.5});
  const int loose = hang(character, "loose", scene, at + glm::dvec3(0.01, 0, 0));
  const int below = hang(character, "below", loose, {0, 0, 0.2});
  const int lowest = hang(character, "lowest", below, {0, 0, 0.2});
  const int tail = hang(character, "tail_1", stick_node(character, "hips"), {0, 0, -0.2});
  const int tip = hang(character, "tail_2", tail, {0, 0, -0.2});
  const Anatomy anatomy = find_anatomy(character);
  ASSERT_EQ(anatomy.followers.size(), 1u);
  const std::vector<Region> regions = node_regions(character, anatomy);
  const auto of = [&](int node) { return regions[static_cast<std::size_t>(node)]; };
  for (const int node : {loose, below, lowest}) EXPECT_EQ(of(node), Region::leg_left) << node;
  EXPECT_EQ(of(far), Region::other);
  EXPECT_EQ(of(scene), Region::other);
  EXPECT_EQ(of(tail), Region::tail);
  EXPECT_EQ(of(tip), Region::tail);
  // Where the spine ends below a head of its own, all of it is torso.
  Anatomy headless = anatomy;
  headless.spine.pop_back();
  headless.head = -1;
  EXPECT_EQ(node_regions(character, headless)[static_cast<std::size_t>(headless.spine.back())],
            Region::torso);
}

TEST(Anatomy, OfANeckThatHangsBesideTheSpineIsNotSure) {
  // Controls carry neck, arms and legs; the vertebrae that move the skin are a chain beside them.
  Character character = stick_figure(3);
  const int scene = stick_node(character, "scene");
  for (const char* name : {"neck", "clavicle.L", "clavicle.R", "thigh.L", "thigh.R"}) {
    Node& node = character.nodes[static_cast<std::size_t>(stick_node(character, name))];
    node.parent = scene;
    node.parent_from_node = node.world_from_node;
  }
  const std::vector<std::string> vertebrae = {"hips", "spine_1", "spine_2", "spine_3"};
  for (std::size_t k = 0; k < vertebrae.size(); ++k)
    character.nodes[static_cast<std::size_t>(stick_node(character, vertebrae[k]))].name =
        "def_" + std::to_string(k);
  const Anatomy found = find_anatomy(character);
  EXPECT_EQ(character.nodes[static_cast<std::size_t>(found.spine.front())].name, "neck");
  EXPECT_FALSE(found.sure());
  AnatomyHints hints;
  hints.spine = {"def_0", "def_1", "def_2", "def_3"};
  EXPECT_TRUE(find_anatomy(character, hints).sure());
}

}  // namespace
}  // namespace backbend::skin
