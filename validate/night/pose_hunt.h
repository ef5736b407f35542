#pragma once
#include <functional>
#include <string>
#include <vector>

#include "validate/files/ledger.h"
#include "validate/judge/judge.h"
#include "validate/measure/measure.h"

namespace backbend::validate {

/// A character whose rigs were measured over their sweeps.
struct HuntedCharacter {
  const Stage& stage;
  const BodyMetrics& body;
  std::string content;               // its file's, as parts of a job name it
  const std::vector<Sweep>& sweeps;  // the suite's: where everything that is swept counts, they
                                     // say how far the box goes
  std::function<const JudgeContext&(const RigRecord&)> context_of;
};

/// Searches the envelope of each rig for its worst poses (hunt/hunt.h), with as many evaluations as
/// the plan's share of the poses that the rig's sweeps measure. A third of them, and at least as
/// many as the plan says, are drawn at random, the same for every rig; they are kept for
/// judge_samples(). What can be proved of the joints over the envelope is proved, too.
///
/// Where a check fails, and no sweep shows it at all or nearly as bad, the rig is measured on the
/// path from rest to that pose, as on a named pose of a suite: a sweep that is named by
/// hunt_name(). No other figure of the record changes. Returns false where results are missing
/// (Mode::merge), all of them noted. Results do not depend on threads or shards.
bool hunt_rigs(const HuntedCharacter& character, const HuntPlan& plan,
               std::vector<RigRecord>& records, Ledger& ledger, Progress& progress);

/// Takes value, pose and limit of a hunt's flips from their measured paths. Where a path shows
/// none, the search saw what no measure confirms: nothing was found, and the path is removed unless
/// another find is on it. Needs a rig that has no findings yet: they refer to sweeps by number.
void confirm_flips(RigRecord& rig, const LimitSet& limits);

/// `hunt even BB011`; of a second flip `hunt even BB001 2`. The same from night to night.
std::string hunt_name(const RigRecord& rig, const std::string& code, int number);

/// Fills in how many of a rig's random poses are clean, as in headroom_of().
void judge_samples(const Stage& stage, const BodyMetrics& body, bool judges_weights,
                   const JudgeContext& context, RigRecord& rig);

/// Takes away findings on the paths of a hunt that it was not after, where another sweep shows the
/// check nearly as bad: a path to the worst kink says little new of the volume.
void drop_repeats(const RigRecord& rig, std::vector<Finding>& findings);

}  // namespace backbend::validate
