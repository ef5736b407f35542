#pragma once
#include <string>
#include <string_view>

namespace backbend::skin {

enum class Side { none, left, right };

/// What a joint's name says it is. `none`: nothing that we know a word for.
enum class BodyPart {
  none,
  root,   // world, armature, reference: not a bone of the body
  hip,    // pelvis
  spine,  // torso, chest, back, ribs
  neck,
  head,
  face,      // jaw, eye, ear, tongue, hair: on the head
  clavicle,  // shoulder, collar, scapula
  arm,
  hand,
  finger,
  leg,
  foot,
  tail,
  fin,  // or wing: a limb that is neither arm nor leg by name
  breast,
};

/// A joint's name taken apart.
struct NameFacts {
  BodyPart part = BodyPart::none;
  Side side = Side::none;
  bool front = false, back = false;  // of a quadruped's limb
  bool control = false;              // IK, pole target, controller: not of the deforming chain
  bool helper = false;               // twist or roll joint beside the chain
  bool end = false;                  // tip, leaf, nub: marks where the last bone ends
  bool tip = false;                  // an end that is called so
  std::string without_side;          // lower case, side words removed: equal for a left-right pair
};

/// Reads `LeftUpLeg`, `clavicle.R`, `mixamorig:Spine1`, `Bip01 L Thigh`, `J_Bip_C_Neck`, `hand_l`
/// and their like, whatever namespace, case or separator. A name alone proves nothing: callers
/// weigh it with topology and geometry.
NameFacts read_joint_name(std::string_view name);

}  // namespace backbend::skin
