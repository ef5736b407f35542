#include "validate/clips/arm_leap.h"

#include <algorithm>
#include <span>
#include <vector>

#include "validate/clips/clip_measure.h"
#include "validate/metrics/math/median.h"

namespace backbend::validate {

using Index = std::size_t;

namespace {

/// The turn of a joint against another in a step, degrees; 0 where it does not stand out from those
/// around it.
double leap_of(const ClipBody& body, const skin::ClipSweep& range, Index to, int joint, int base) {
  constexpr Index kAround = 8;
  constexpr double kStandsOut = 5.0;
  const auto turn_at = [&](Index frame) {
    const Index f = range.first + frame;
    return glm::conjugate(body.turn(f, base)) * body.turn(f, joint);
  };
  const auto step = [&](Index end) {
    return degrees(angle_between(turn_at(end - 1), turn_at(end)));
  };
  std::vector<double> around;
  for (Index end = to > kAround ? to - kAround : 1; end < range.count && end <= to + kAround; ++end)
    if (end != to) around.push_back(step(end));
  const double here = step(to);
  return here >= kStandsOut * upper_median(around) ? here : 0.0;
}

}  // namespace

std::optional<ArmLeap> arm_leap(const skin::Character& character, const skin::Anatomy& anatomy,
                                const ClipBody& body, const skin::ClipSweep& range, std::size_t to,
                                int node) {
  constexpr double kOfHand = 1.0 / 3.0, kOfOther = 1.25, kMostDeg = 15.0, kStillDeg = 1.0;
  std::optional<ArmLeap> most;
  const auto& spine = anatomy.spine;
  if (node != spine.front() && std::ranges::find(spine, node) != spine.end()) return most;
  const auto offer = [&](int joint, double turn_deg, double share) {
    const double explains_deg = std::min(share * turn_deg, kMostDeg);
    if (turn_deg > 0.0 && (!most || explains_deg > most->explains_deg))
      most = {character.nodes[static_cast<Index>(joint)].name, turn_deg, explains_deg};
  };
  // Fingers snap with every grip.
  constexpr Index kToHand = 4;
  for (const std::vector<int>* arm : {&anatomy.left_arm, &anatomy.right_arm}) {
    if (arm->empty() || arm->front() == node) continue;
    const std::span<const int> counted(arm->data(), std::min(arm->size(), kToHand));
    const auto own_leap = [&](int joint) {
      return leap_of(body, range, to, joint, character.nodes[static_cast<Index>(joint)].parent);
    };
    if (node == spine.front()) {
      const int above = spine_above(character, anatomy, arm->front());
      offer(counted.back(), leap_of(body, range, to, counted.back(), above < 0 ? node : above),
            kOfHand);
    } else if (own_leap(arm->front()) < kStillDeg) {
      for (const int joint : counted) offer(joint, own_leap(joint), kOfOther);
    }
  }
  return most;
}

}  // namespace backbend::validate
