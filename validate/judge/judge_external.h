#pragma once
#include <string>
#include <vector>

#include "validate/judge/judge.h"

namespace backbend::validate {

/// The part of a body channel's angle that arrives at the chest of a rig: read over the first 30
/// degrees of one channel alone, far from every branch, as the sum of the turns of the chain's
/// joints, each against the one below, in the hips' axes. Axes are those of the body at rest:
/// `left` for extension (which turns about it backwards) and flexion; the line from hips to chest
/// for twist, to the left; the one across both for side, to the left.
ChannelResponse channel_response(const solver::SpineSystem& system, solver::Mapping mapping,
                                 std::string_view channel, const glm::dvec3& left);

/// What is asked of a studio's own rig beside its sweeps.
struct ExternalJudgement {
  std::vector<Finding> findings;
  std::vector<Coverage> coverage;  // to be added to that of the rig
  /// How far the chest follows a channel that it does not follow to the end; 0: the report cannot
  /// speak of the channel's angles at all.
  struct AnsweredTo {
    std::string channel;
    double to_deg;
  };
  std::vector<AnsweredTo> answered_to;
};

/// Limits for a studio's own rig: of its kinks (BB010) another default, for it is held against its
/// own joints and not against a curve that it should follow.
LimitSet external_limits(LimitSet limits);

/// Whether the mapping's controls are the right ones, and the chest follows them to the end of each
/// sweep (BB049: each channel that the envelope needs is tried by itself), whether the rig has a
/// memory (BB044, ExternalRig::memory()), and joints that leave their share of the spine's bend in
/// a part of a sweep (BB010, share_excess()). Nothing for a rig of ours.
ExternalJudgement judge_external(const RigRecord& rig, const JudgeContext& context);

/// How close the search for jumps of a studio's own rig looked: its evaluations, the smallest jump,
/// and for each channel the width below which a jump that goes and comes back can be missed. Such a
/// rig reports no flip margin that would betray it. Empty for a rig of ours, and where no sweep was
/// searched.
std::string resolution_note(const RigRecord& rig);

}  // namespace backbend::validate
