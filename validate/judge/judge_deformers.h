#pragma once
#include <string>
#include <vector>

#include "validate/judge/judge.h"

namespace backbend::validate {

/// How far linear blending of a rig's joints is from the rig's own points, over the poses of its
/// sweeps. Lengths as the character has them.
struct BlendingDistance {
  double largest = 0.0, mean = 0.0;  // the mean is of all vertices and poses
  PoseDegrees pose;                  // of the largest
  int vertex = -1;
};

/// What the deformers of a studio's own rig do beside its joints.
struct DeformerJudgement {
  bool measured = false;  // the rig gives points
  BlendingDistance blending;
  std::vector<Finding> findings;  // BB037
  std::vector<Coverage> coverage;
};

/// Places where the surface jumps and the joints do not (BB037). The offset of every vertex from
/// linear blending of the same joints is compared between neighbouring poses; where it changes by
/// more than the limit, the interval is halved, by the rig itself, down to half a degree. What
/// changes by the limit within half a degree is a finding; it is halved on until the change no
/// longer stays in one half, at most to 2^-20 of the sweep, and is a jump where it stays in one to
/// the end. Flips of the chain (BB001) are left out. Nothing where the rig gives no points.
DeformerJudgement judge_deformers(const RigRecord& rig, const JudgeContext& context);

/// No channel is clean beyond a jump of the surface that it makes alone.
void cut_headroom(const RigRecord& rig, const std::vector<Finding>& findings,
                  std::vector<Headroom>& headroom);

/// `LBS against your deformers: largest 61.3 mm at extension 42 (...), mean 0.4 mm: ...`. `place`
/// says where the vertex is.
std::string blending_text(const BlendingDistance& distance, double spine_length,
                          const std::string& place);

}  // namespace backbend::validate
