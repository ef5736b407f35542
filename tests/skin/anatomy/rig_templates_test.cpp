// The names of the common rigs, on skeletons hung together as those rigs hang theirs.
#include "skin/anatomy/rig_templates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>

#include "skin/anatomy/anatomy.h"
#include "tests/skin/stick_figure.h"

namespace backbend::skin {
namespace {

/// One joint of a rig: its name, whose child it is (by name, "" for a root) and where it stands.
struct Joint {
  const char* name;
  const char* parent;
  glm::dvec3 at;
};

struct Rig {
  const char* name;
  std::vector<Joint> joints;
  const char *hip, *neck, *head, *left_arm, *left_leg;
};

Character built(const Rig& rig) {
  Character character;
  character.file_name = std::string(rig.name) + ".glb";
  for (const Joint& joint : rig.joints) {
    const int parent = *joint.parent ? stick_node(character, joint.parent) : -1;
    stick_vertex(character, add_node(character, joint.name, parent, joint.at));
  }
  return character;
}

// Where the joints of a standing human are.
constexpr glm::dvec3 kFloor{0, 0, 0}, kHips{0, 0.95, 0}, kLow{0, 1.05, 0}, kMiddle{0, 1.15, 0},
    kHigh{0, 1.3, 0}, kNeck{0, 1.48, 0}, kNeck2{0, 1.53, 0}, kHead{0, 1.6, 0};
constexpr glm::dvec3 kCollarL{0.03, 1.43, 0}, kCollarR{-0.03, 1.43, 0}, kArmL{0.18, 1.43, 0},
    kArmR{-0.18, 1.43, 0}, kHandL{0.7, 1.43, 0}, kHandR{-0.7, 1.43, 0};
constexpr glm::dvec3 kLegL{0.1, 0.9, 0}, kLegR{-0.1, 0.9, 0}, kFootL{0.1, 0.05, 0},
    kFootR{-0.1, 0.05, 0};

const Rig kRigs[] = {
    {"mgear",
     {{"root_C0_0_jnt", "", kFloor},
      {"spine_C0_pelvis_jnt", "root_C0_0_jnt", kHips},
      {"spine_C0_01_jnt", "spine_C0_pelvis_jnt", kLow},
      {"spine_C0_02_jnt", "spine_C0_01_jnt", kHigh},
      {"neck_C0_01_jnt", "spine_C0_02_jnt", kNeck},
      {"neck_C0_02_jnt", "neck_C0_01_jnt", kNeck2},
      {"neck_C0_head_jnt", "neck_C0_02_jnt", kHead},
      {"shoulder_L0_0_jnt", "spine_C0_02_jnt", kCollarL},
      {"arm_L0_upperarm_jnt", "shoulder_L0_0_jnt", kArmL},
      {"arm_L0_hand_jnt", "arm_L0_upperarm_jnt", kHandL},
      {"shoulder_R0_0_jnt", "spine_C0_02_jnt", kCollarR},
      {"arm_R0_upperarm_jnt", "shoulder_R0_0_jnt", kArmR},
      {"arm_R0_hand_jnt", "arm_R0_upperarm_jnt", kHandR},
      {"leg_L0_thigh_jnt", "spine_C0_pelvis_jnt", kLegL},
      {"foot_L0_0_jnt", "leg_L0_thigh_jnt", kFootL},
      {"leg_R0_thigh_jnt", "spine_C0_pelvis_jnt", kLegR},
      {"foot_R0_0_jnt", "leg_R0_thigh_jnt", kFootR}},
     "spine_C0_pelvis_jnt",
     "neck_C0_01_jnt",
     "neck_C0_head_jnt",
     "shoulder_L0_0_jnt",
     "leg_L0_thigh_jnt"},
    {"advanced_skeleton",
     {{"Root_M", "", kHips},
      {"Spine1_M", "Root_M", kLow},
      {"Chest_M", "Spine1_M", kHigh},
      {"Neck_M", "Chest_M", kNeck},
      {"Head_M", "Neck_M", kHead},
      {"Scapula_L", "Chest_M", kCollarL},
      {"Shoulder_L", "Scapula_L", kArmL},
      {"Wrist_L", "Shoulder_L", kHandL},
      {"Scapula_R", "Chest_M", kCollarR},
      {"Shoulder_R", "Scapula_R", kArmR},
      {"Wrist_R", "Shoulder_R", kHandR},
      {"Hip_L", "Root_M", kLegL},
      {"Ankle_L", "Hip_L", kFootL},
      {"Hip_R", "Root_M", kLegR},
      {"Ankle_R", "Hip_R", kFootR}},
     "Root_M",
     "Neck_M",
     "Head_M",
     "Scapula_L",
     "Hip_L"},
    {"mixamo",
     {{"mixamorig7:Hips", "", kHips},
      {"mixamorig7:Spine", "mixamorig7:Hips", kLow},
      {"mixamorig7:Spine2", "mixamorig7:Spine", kHigh},
      {"mixamorig7:Neck", "mixamorig7:Spine2", kNeck},
      {"mixamorig7:Head", "mixamorig7:Neck", kHead},
      {"mixamorig7:LeftShoulder", "mixamorig7:Spine2", kCollarL},
      {"mixamorig7:LeftArm", "mixamorig7:LeftShoulder", kArmL},
      {"mixamorig7:LeftHand", "mixamorig7:LeftArm", kHandL},
      {"mixamorig7:RightShoulder", "mixamorig7:Spine2", kCollarR},
      {"mixamorig7:RightArm", "mixamorig7:RightShoulder", kArmR},
      {"mixamorig7:RightHand", "mixamorig7:RightArm", kHandR},
      {"mixamorig7:LeftUpLeg", "mixamorig7:Hips", kLegL},
      {"mixamorig7:LeftFoot", "mixamorig7:LeftUpLeg", kFootL},
      {"mixamorig7:RightUpLeg", "mixamorig7:Hips", kLegR},
      {"mixamorig7:RightFoot", "mixamorig7:RightUpLeg", kFootR}},
     "mixamorig7:Hips",
     "mixamorig7:Neck",
     "mixamorig7:Head",
     "mixamorig7:LeftShoulder",
     "mixamorig7:LeftUpLeg"},
    {"humanik",
     {{"hero:Reference", "", kFloor},
      {"hero:Hips", "hero:Reference", kHips},
      {"hero:Spine", "hero:Hips", kLow},
      {"hero:Spine1", "hero:Spine", kHigh},
      {"hero:Neck", "hero:Spine1", kNeck},
      {"hero:Head", "hero:Neck", kHead},
      {"hero:LeftShoulder", "hero:Spine1", kCollarL},
      {"hero:LeftArm", "hero:LeftShoulder", kArmL},
      {"hero:LeftHand", "hero:LeftArm", kHandL},
      {"hero:RightShoulder", "hero:Spine1", kCollarR},
      {"hero:RightArm", "hero:RightShoulder", kArmR},
      {"hero:RightHand", "hero:RightArm", kHandR},
      {"hero:LeftUpLeg", "hero:Hips", kLegL},
      {"hero:LeftFoot", "hero:LeftUpLeg", kFootL},
      {"hero:RightUpLeg", "hero:Hips", kLegR},
      {"hero:RightFoot", "hero:RightUpLeg", kFootR}},
     "hero:Hips",
     "hero:Neck",
     "hero:Head",
     "hero:LeftShoulder",
     "hero:LeftUpLeg"},
    // All of the spine is called spine, neck and head too.
    {"rigify",
     {{"root", "", kFloor},
      {"DEF-spine", "root", kHips},
      {"DEF-spine.001", "DEF-spine", kLow},
      {"DEF-spine.002", "DEF-spine.001", kMiddle},
      {"DEF-spine.003", "DEF-spine.002", kHigh},
      {"DEF-spine.004", "DEF-spine.003", kNeck},
      {"DEF-spine.005", "DEF-spine.004", kNeck2},
      {"DEF-spine.006", "DEF-spine.005", kHead},
      {"DEF-shoulder.L", "DEF-spine.003", kCollarL},
      {"DEF-upper_arm.L", "DEF-shoulder.L", kArmL},
      {"DEF-hand.L", "DEF-upper_arm.L", kHandL},
      {"DEF-shoulder.R", "DEF-spine.003", kCollarR},
      {"DEF-upper_arm.R", "DEF-shoulder.R", kArmR},
      {"DEF-hand.R", "DEF-upper_arm.R", kHandR},
      {"DEF-thigh.L", "DEF-spine", kLegL},
      {"DEF-foot.L", "DEF-thigh.L", kFootL},
      {"DEF-thigh.R", "DEF-spine", kLegR},
      {"DEF-foot.R", "DEF-thigh.R", kFootR}},
     "DEF-spine",
     "DEF-spine.004",
     "DEF-spine.006",
     "DEF-shoulder.L",
     "DEF-thigh.L"},
    {"unreal",
     {{"root", "", kFloor},
      {"pelvis", "root", kHips},
      {"spine_01", "pelvis", kLow},
      {"spine_02", "spine_01", kMiddle},
      {"spine_03", "spine_02", kHigh},
      {"neck_01", "spine_03", kNeck},
      {"head", "neck_01", kHead},
      {"clavicle_l", "spine_03", kCollarL},
      {"upperarm_l", "clavicle_l", kArmL},
      {"hand_l", "upperarm_l", kHandL},
      {"clavicle_r", "spine_03", kCollarR},
      {"upperarm_r", "clavicle_r", kArmR},
      {"hand_r", "upperarm_r", kHandR},
      {"thigh_l", "pelvis", kLegL},
      {"foot_l", "thigh_l", kFootL},
      {"thigh_r", "pelvis", kLegR},
      {"foot_r", "thigh_r", kFootR}},
     "pelvis",
     "neck_01",
     "head",
     "clavicle_l",
     "thigh_l"},
    // Thighs hang from the spine, collars from the neck; an FBX writer has escaped the spaces.
    {"biped",
     {{"Bip001", "", kHips},
      {"Bip001FBXASC032Pelvis", "Bip001", kHips},
      {"Bip001FBXASC032Spine", "Bip001FBXASC032Pelvis", kLow},
      {"Bip001FBXASC032Spine1", "Bip001FBXASC032Spine", kHigh},
      {"Bip001FBXASC032Neck", "Bip001FBXASC032Spine1", kNeck},
      {"Bip001FBXASC032Head", "Bip001FBXASC032Neck", kHead},
      {"Bip001FBXASC032LFBXASC032Clavicle", "Bip001FBXASC032Neck", kCollarL},
      {"Bip001FBXASC032LFBXASC032UpperArm", "Bip001FBXASC032LFBXASC032Clavicle", kArmL},
      {"Bip001FBXASC032LFBXASC032Hand", "Bip001FBXASC032LFBXASC032UpperArm", kHandL},
      {"Bip001FBXASC032RFBXASC032Clavicle", "Bip001FBXASC032Neck", kCollarR},
      {"Bip001FBXASC032RFBXASC032UpperArm", "Bip001FBXASC032RFBXASC032Clavicle", kArmR},
      {"Bip001FBXASC032RFBXASC032Hand", "Bip001FBXASC032RFBXASC032UpperArm", kHandR},
      {"Bip001FBXASC032LFBXASC032Thigh", "Bip001FBXASC032Spine", kLegL},
      {"Bip001FBXASC032LFBXASC032Foot", "Bip001FBXASC032LFBXASC032Thigh", kFootL},
      {"Bip001FBXASC032RFBXASC032Thigh", "Bip001FBXASC032Spine", kLegR},
      {"Bip001FBXASC032RFBXASC032Foot", "Bip001FBXASC032RFBXASC032Thigh", kFootR}},
     "Bip001FBXASC032Pelvis",
     "Bip001FBXASC032Neck",
     "Bip001FBXASC032Head",
     "Bip001FBXASC032LFBXASC032Clavicle",
     "Bip001FBXASC032LFBXASC032Thigh"},
    {"vrm",
     {{"Root", "", kFloor},
      {"J_Bip_C_Hips", "Root", kHips},
      {"J_Bip_C_Spine", "J_Bip_C_Hips", kLow},
      {"J_Bip_C_Chest", "J_Bip_C_Spine", kMiddle},
      {"J_Bip_C_UpperChest", "J_Bip_C_Chest", kHigh},
      {"J_Bip_C_Neck", "J_Bip_C_UpperChest", kNeck},
      {"J_Bip_C_Head", "J_Bip_C_Neck", kHead},
      {"J_Bip_L_Shoulder", "J_Bip_C_UpperChest", kCollarL},
      {"J_Bip_L_UpperArm", "J_Bip_L_Shoulder", kArmL},
      {"J_Bip_L_Hand", "J_Bip_L_UpperArm", kHandL},
      {"J_Bip_R_Shoulder", "J_Bip_C_UpperChest", kCollarR},
      {"J_Bip_R_UpperArm", "J_Bip_R_Shoulder", kArmR},
      {"J_Bip_R_Hand", "J_Bip_R_UpperArm", kHandR},
      {"J_Bip_L_UpperLeg", "J_Bip_C_Hips", kLegL},
      {"J_Bip_L_Foot", "J_Bip_L_UpperLeg", kFootL},
      {"J_Bip_R_UpperLeg", "J_Bip_C_Hips", kLegR},
      {"J_Bip_R_Foot", "J_Bip_R_UpperLeg", kFootR}},
     "J_Bip_C_Hips",
     "J_Bip_C_Neck",
     "J_Bip_C_Head",
     "J_Bip_L_Shoulder",
     "J_Bip_L_UpperLeg"},
    // The chain counts down; the thighs hang from a pelvis of their own.
    {"makehuman",
     {{"root", "", kHips},
      {"spine05", "root", kLow},
      {"spine03", "spine05", kMiddle},
      {"spine01", "spine03", kHigh},
      {"neck01", "spine01", kNeck},
      {"neck02", "neck01", kNeck2},
      {"head", "neck02", kHead},
      {"clavicle.L", "spine01", kCollarL},
      {"shoulder01.L", "clavicle.L", kArmL},
      {"wrist.L", "shoulder01.L", kHandL},
      {"clavicle.R", "spine01", kCollarR},
      {"shoulder01.R", "clavicle.R", kArmR},
      {"wrist.R", "shoulder01.R", kHandR},
      {"pelvis.L", "root", {0.05, 0.93, 0}},
      {"upperleg01.L", "pelvis.L", kLegL},
      {"foot.L", "upperleg01.L", kFootL},
      {"pelvis.R", "root", {-0.05, 0.93, 0}},
      {"upperleg01.R", "pelvis.R", kLegR},
      {"foot.R", "upperleg01.R", kFootR}},
     "root",
     "neck01",
     "head",
     "clavicle.L",
     "pelvis.L"},
};

class EveryRig : public ::testing::TestWithParam<Rig> {};

TEST_P(EveryRig, IsKnownByItsNames) {
  const Rig& rig = GetParam();
  const Character character = built(rig);
  const auto match = find_template(character);
  ASSERT_TRUE(match);
  EXPECT_EQ(match->name, rig.name);
  EXPECT_EQ(match->hip, stick_node(character, rig.hip));
  EXPECT_EQ(match->neck, stick_node(character, rig.neck));
  EXPECT_EQ(match->head, stick_node(character, rig.head));
  EXPECT_EQ(require_template(character, rig.name).hip, match->hip);
}

TEST_P(EveryRig, IsDrivenFromItsHipsToWhereItsArmsHang) {
  const Rig& rig = GetParam();
  const Character character = built(rig);
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_EQ(anatomy.spine.front(), stick_node(character, rig.hip));
  const int clavicle = stick_node(character, rig.left_arm);
  const int ribs = character.nodes[static_cast<std::size_t>(clavicle)].parent;
  EXPECT_EQ(anatomy.chest, ribs);
  EXPECT_EQ(anatomy.spine[anatomy.chest_index], ribs);
  EXPECT_EQ(anatomy.spine[anatomy.neck_index], stick_node(character, rig.neck));
  EXPECT_EQ(anatomy.head, stick_node(character, rig.head));
  EXPECT_EQ(anatomy.left_arm.front(), stick_node(character, rig.left_arm));
  EXPECT_EQ(anatomy.left_leg.front(), stick_node(character, rig.left_leg));
  const std::string known = "names: as " + std::string(find_template(character)->title);
  EXPECT_TRUE(std::any_of(anatomy.reasons.begin(), anatomy.reasons.end(), [&](const auto& reason) {
    return reason.compare(0, known.size(), known) == 0;
  })) << known;
  const SpineDriver driver(character, anatomy);
  EXPECT_TRUE(driver.arms_follow_chest());
}

/// Without one of the joints that matter it is nobody's rig, and says which joint is missed.
TEST_P(EveryRig, IsNotTakenForItselfWithoutItsNeck) {
  const Rig& rig = GetParam();
  Character character = built(rig);
  for (Node& node : character.nodes)
    if (node.name.find("eck") != std::string::npos || node.name.find("e.00") != std::string::npos)
      node.name = "unknown" + std::to_string(node.file_node);
  EXPECT_FALSE(find_template(character));
  try {
    require_template(character, rig.name);
    FAIL();
  } catch (const CharacterError& error) {
    EXPECT_NE(std::string(error.what()).find("base of the neck"), std::string::npos)
        << error.what();
  }
}

INSTANTIATE_TEST_SUITE_P(RigTemplates, EveryRig, ::testing::ValuesIn(kRigs),
                         [](const auto& test) { return test.param.name; });

/// HumanIK's names are borrowed by captures whose neck has a joint more, below the one of that
/// name.
TEST(RigTemplates, ALowerJointOfTheNeckIsItsBase) {
  Rig rig = *std::find_if(std::begin(kRigs), std::end(kRigs),
                          [](const Rig& each) { return std::string(each.name) == "humanik"; });
  const auto neck = std::find_if(rig.joints.begin(), rig.joints.end(), [&](const Joint& joint) {
    return std::string(joint.name) == rig.neck;
  });
  const Joint lower{"lowerneck", neck->parent, {0, 1.44, 0}};
  neck->parent = "lowerneck";
  rig.joints.insert(neck, lower);
  const Character character = built(rig);
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_EQ(character.nodes[static_cast<std::size_t>(anatomy.spine[anatomy.neck_index])].name,
            "lowerneck");
}

TEST(RigTemplates, AreEachTried) {
  std::vector<std::string_view> tried;
  for (const Rig& rig : kRigs) tried.emplace_back(rig.name);
  EXPECT_EQ(tried, template_names());
}

TEST(RigTemplates, AreRefusedByNameWhereUnknown) {
  try {
    require_template(stick_figure(), "mixamoo");
    FAIL();
  } catch (const CharacterError& error) {
    EXPECT_NE(std::string(error.what()).find("mixamo,"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace backbend::skin
