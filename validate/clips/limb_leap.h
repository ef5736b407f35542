#pragma once
#include <optional>
#include <string>

#include "skin/clip/clip.h"
#include "validate/clips/clip_body.h"

namespace backbend::validate {

/// A joint of an arm or leg that leaps in one step of a clip.
struct LimbLeap {
  std::string joint;
  double turn_deg = 0.0;
  double explains_deg = 0.0;  // the largest jump of the watched joint that goes with it
};

/// What leap of a limb goes with a jump of `node`, a joint of the spine or an arm's first, in the
/// step of a sweep that ends at frame `to`: of all leaps the one that explains most.
///
/// A rig that flips takes along what hangs from the joint; an animator who lets a blow land from
/// one frame to the next turns the whole figure. A leap is a turn that stands out from the steps
/// around it, five times their median, of up to eight on either side:
///
/// - of a limb that hangs elsewhere, of one of its joints against the joint above. It explains as
///   much and a quarter more. An arm whose first joint leaps does not count: both may flip at once;
/// - of a limb that hangs from the joint, of its last joint against its base on the spine. It
///   explains a third: what is only carried along does not turn against its base, and what inverse
///   kinematics hold in place turns back by as much as the jump.
///
/// Nothing explains more than 15 degrees: a flip that matters is wider, and of lively game
/// animation one step in twenty leaps.
std::optional<LimbLeap> limb_leap(const skin::Character& character, const skin::Anatomy& anatomy,
                                  const ClipBody& body, const skin::ClipSweep& range,
                                  std::size_t to, int node);

}  // namespace backbend::validate
