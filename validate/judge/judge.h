#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "validate/measure/measure.h"
#include "validate/model/report.h"
#include "validate/verdicts/limits.h"

namespace backbend::validate {

/// What judging needs to know beside the measurements.
struct JudgeContext {
  const Stage& stage;
  const LimitSet& limits;
  const Envelope& envelope;
  std::string character;  // the words that name it and its joints in reproduce lines
};

/// Every finding of one rig or recording: flips one by one, for the other checks the worst pose of
/// each sweep where a limit is exceeded, inside the envelope if anywhere there. Worst first.
std::vector<Finding> judge_rig(const RigRecord& rig, const JudgeContext& context);

/// How far a pose inside the envelope goes beyond the end of one channel, by taking several at
/// once: the root of the sum of squared shares of what each channel needs, at least 1. 1.73 in a
/// corner of three channels. Outside, and where everything that is swept counts: 1.
double compound_load(const Envelope& envelope, const PoseDegrees& pose);

/// A limit at a pose of that load. Limits on the mesh were set at the ends of single channels: what
/// grows with the bend may be so much more in a compound pose (angles and strains in proportion,
/// shares of folded or crossing area with its square, a slice's loss of area in proportion). Other
/// limits stay.
double limit_at(std::string_view code, double limit, double load);

/// A finding of a check at a pose of one of the rig's sweeps, with everything but its value and its
/// story.
Finding start_finding(const RigRecord& rig, const JudgeContext& context, const SweepRecord& sweep,
                      std::string_view code, const PoseDegrees& pose, double control_deg);
/// The same at one of the sweep's own poses.
Finding start_finding(const RigRecord& rig, const JudgeContext& context, const SweepRecord& sweep,
                      std::string_view code, std::size_t pose);

/// The sweep that a finding of the rig is of; null for none.
const SweepRecord* sweep_of(const RigRecord& rig, const Finding& finding);

/// A joint that leaves its share of the bend over some poses of a sweep, or turns too far and other
/// joints turn back: kink, or roll where it turns about its own bone. `shares`: one per pose; empty
/// where they were not measured. At the pose that is furthest over its limit.
std::optional<Finding> share_finding(const RigRecord& rig, const JudgeContext& context,
                                     const SweepRecord& sweep, std::span<const ShareExcess> shares);

/// Puts a channel's answer into its finding: BB049.
void set_response(const ChannelResponse& response, Finding& finding);

/// The command that renders a character (the words that name it and its joints), the chain of it
/// that was driven, under a rig at a pose.
std::string command_for(const RigRecord& rig, const std::string& character, DrivenChain chain,
                        const PoseDegrees& pose);

/// Puts the place of a metric into the finding: a joint by its name, a slice or a vertex by its
/// number. Metrics of the whole body have none.
void set_place(const Metric& metric, int place, const std::vector<std::string>& joint_names,
               Finding& finding);

/// Per body channel: the largest angle up to which no deciding check fails, over the sweeps that
/// move that channel alone. A channel that the envelope needs and no sweep moves is not measured.
/// `findings`: of this rig, with their owners: what only the skeleton or the pose is to blame for
/// does not count against it inside the envelope, as it does not decide either.
std::vector<Headroom> headroom_of(const RigRecord& rig, const JudgeContext& context,
                                  const std::vector<Finding>& findings);

/// The poses of the sweeps to the envelope's corners, and of those around jumps that the search
/// between the sweeps found, as far as they lie inside the envelope: how many are clean, as in
/// headroom_of().
Corners corners_of(const RigRecord& rig, const JudgeContext& context,
                   const std::vector<Finding>& findings);

/// How many poses of a sweep of the rig are clean, as in headroom_of().
int clean_poses(const RigRecord& rig, const SweepRecord& sweep, const JudgeContext& context,
                const std::vector<Finding>& findings);

/// Planned, measured and not measured, for every check that is measured at poses.
std::vector<Coverage> coverage_of(const RigRecord& rig);

/// The plotted values of a rig; NaN where a metric does not apply to a pose. Of a recording all
/// that was measured.
std::vector<SweepSeries> series_of(const RigRecord& rig, const LimitSet& limits);

/// Everything that a report says of a rig but its verdict. `findings`: as for headroom_of().
RigResult result_of(const RigRecord& rig, const JudgeContext& context,
                    const std::vector<Finding>& findings);

/// Whether a value of this metric means anything at this pose of the rig.
bool is_applicable(const RigRecord& rig, const Metric& metric, const PoseRecord& pose);

/// The joint's name in the pose, or an empty text for -1.
std::string joint_name(const RigRecord& rig, int joint);

}  // namespace backbend::validate
