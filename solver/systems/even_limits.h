#pragma once
#include <array>
#include <string>
#include <vector>

#include "solver/rig/limits.h"
#include "solver/systems/even_shape.h"

namespace backbend::solver {

/// Keeps each joint of an `even` spine inside a range of motion: what a joint cannot take goes to
/// the joints that have room, in proportion to their weights, so the chest still gets all of a
/// channel while the spine as a whole can give it. Top is served first, Middle has what is left.
///
/// Joint j lies between arc fractions end[j - 1] and end[j]: hips to the first bone's middle, bone
/// to bone, the last bone's middle to the tip.
class EvenLimits {
 public:
  EvenLimits(const EvenWeights& weights, std::vector<double> ends,
             std::vector<RangeOfMotion> range_deg);

  struct Result {
    std::vector<AngleShare> share;   // one per joint
    UpperChannels lost{};            // of each channel, radians: what no joint could take
    std::vector<std::string> flags;  // which joints are at which limit
    int joints_at_limit = 0;
  };
  /// Within the limits exactly what there would be without them. Continuous in the channels.
  Result apply(const UpperChannels& channel) const;

  const std::vector<double>& ends() const { return end_; }
  /// Upper bound of a frame's turn per turn of a channel: a Top channel also moves Middle's shares.
  static double gain_bound() { return 2.0; }

 private:
  std::vector<double> end_;
  std::vector<std::array<double, kUpperChannels>> from_, step_;  // weight before, over each joint
  std::vector<std::array<double, 3>> low_, high_;                // radians; axial, side, bend
};

}  // namespace backbend::solver
