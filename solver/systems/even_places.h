#pragma once
#include <span>
#include <vector>

namespace backbend::solver {

/// Where an `even` spine is read, as arc fractions 0 hips .. 1 chest: where joints stand, and where
/// the frame is read that each of them carries. Both lists are as long, and both end at 1.
struct EvenPlaces {
  std::vector<double> joint, frame;

  int bones() const { return int(joint.size()) - 1; }
};

/// `bones` equal bones: joint k stands at k / bones and carries the frame at its bone's middle, the
/// tip that at 1.
EvenPlaces equal_bones(int bones);

/// The same spine at joints of its own. Each carries the frame that lies as far ahead of it as it
/// does with equal bones: half a bone, and from the last bone's start on less and less. `joint`
/// rises from 0 to 1.
EvenPlaces joints_at(std::span<const double> joint, int bones);

}  // namespace backbend::solver
