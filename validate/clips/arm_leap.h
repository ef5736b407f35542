#pragma once
#include <optional>
#include <string>

#include "skin/clip/clip.h"
#include "validate/clips/clip_body.h"

namespace backbend::validate {

/// A joint of an arm that leaps in one step of a clip.
struct ArmLeap {
  std::string joint;
  double turn_deg = 0.0;
  double explains_deg = 0.0;  // the largest jump of the watched joint that goes with it
};

/// What leap of an arm goes with a jump of `node`, the hips or an arm's first joint, in the step of
/// a sweep that ends at frame `to`: of all leaps the one that explains most. None of other joints.
///
/// A rig that flips takes along what hangs from the joint; an animator who lets a blow land from
/// one frame to the next turns the whole figure. A leap is a turn that stands out from the steps
/// around it, five times their median, of up to eight on either side:
///
/// - in the hips, of a hand against its arm's base on the spine. It explains a third: what is only
///   carried along does not turn against its base, and what inverse kinematics hold in place turns
///   back by as much as the jump;
/// - in an arm's first joint, of any joint of the other arm against the joint above. It explains as
///   much and a quarter more, but nothing where the other arm's first joint leaps, too: both may
///   flip at once.
///
/// Nothing explains more than 15 degrees: a flip that matters is wider, and lively game animation
/// leaps often. Legs explain nothing: they snap with every step of a walk.
std::optional<ArmLeap> arm_leap(const skin::Character& character, const skin::Anatomy& anatomy,
                                const ClipBody& body, const skin::ClipSweep& range, std::size_t to,
                                int node);

}  // namespace backbend::validate
