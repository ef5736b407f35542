#pragma once
#include <string>
#include <vector>

#include "skin/weights/weight_faults.h"
#include "validate/judge/judge.h"
#include "validate/metrics/surface/body_metrics.h"
#include "validate/metrics/surface/weight_hygiene.h"

namespace backbend::validate {

/// What a character's file was found to be before any pose.
struct InputJudgement {
  std::vector<Finding> findings;
  std::vector<Coverage> coverage;  // each check is asked once, on the file
  std::vector<std::string> notes;  // why a check has no meaning for this character
};

/// What a character's weights are without any pose.
struct InputReading {
  WeightHygiene hygiene;
  skin::WeightFaults faults;
};
InputReading read_input(const Stage& stage);

/// What is wrong with the character's file whatever the pose, as findings of one rig, so that every
/// form of the report shows them where the rig's others are: weight sums, unweighted and stray
/// vertices, weight on far joints and on the other side's, asymmetry, order along the spine, seams,
/// joints whose bind pose is off, and joints that stand beside the body or past their neighbour. Of
/// one check the three worst joints are findings. They decide only where the character itself is on
/// trial (`judges_weights`).
InputJudgement judge_input(const RigRecord& rig, const JudgeContext& context,
                           const InputReading& weights, const BodyMetrics& body,
                           bool judges_weights);

}  // namespace backbend::validate
