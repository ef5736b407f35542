#pragma once
#include <string>

#include "validate/model/report.h"

namespace backbend::validate {

/// What a run searched for a rig's worst poses, and what it found that its sweeps do not show:
/// `searched 177 poses of extension 0..60, side -45..45 (seed 1): mesh kink 31 deg (limit 25) at
/// extension 40, side 30`. Never that a rig is clean. Empty: nothing was asked.
std::string hunt_summary(const PoseHunt& hunt);

/// How much of the envelope is clean: the certified share of the joints, and what random poses say
/// of everything, each for itself. Empty: nothing was asked.
std::string volume_summary(const CleanVolume& volume);

/// The second of the two alone: `58 of 59 random poses clean (95 % sure: at least 92.22 % of the
/// volume)`.
std::string sampled_summary(const CleanVolume& volume);
/// The first alone: `certified 100 % (no joint jumps or turns more than 8 times as fast as a
/// channel)`.
std::string certified_summary(const CleanVolume& volume);

}  // namespace backbend::validate
