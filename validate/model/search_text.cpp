#include "validate/model/search_text.h"

#include <cmath>

#include "validate/text/number_text.h"
#include "validate/verdicts/checks.h"

namespace backbend::validate {
namespace {

/// Two digits after the point, never more than it is.
std::string floored_percent(double share) {
  return shortest(std::floor(10000.0 * share + 1e-9) / 100.0) + " %";
}

}  // namespace

std::string hunt_summary(const PoseHunt& hunt) {
  std::string notes;
  for (const std::string& note : hunt.notes) notes += (notes.empty() ? "" : "; ") + note;
  if (hunt.evaluations == 0) return notes.empty() ? "" : "not searched: " + notes;
  std::string found, known;
  for (const HuntedPose& each : hunt.worst) {
    const Check* check = find_check(each.code);
    if (each.sweep >= 0)
      found += (found.empty() ? ": " : "; ") + each.code + " " +
               (check == nullptr ? "" : std::string(check->name) + " ") + significant(each.value) +
               " " + each.unit + " (limit " + significant(each.limit) + ") at " + each.pose;
    else if (each.over)
      known += (known.empty() ? "" : ", ") + each.code;
  }
  std::string text =
      "searched " + std::to_string(hunt.evaluations) + " poses of " + hunt.box + found;
  if (!known.empty()) text += "; over the limit as in the sweeps, which judge it: " + known;
  return notes.empty() ? text : text + "; " + notes;
}

std::string certified_summary(const CleanVolume& volume) {
  if (volume.box.empty()) return "";
  if (!volume.proved) return "nothing certified (" + volume.not_proved + ")";
  std::string text = "certified " + floored_percent(volume.certified) +
                     " (no joint jumps or turns more than " + significant(volume.gain) +
                     " times as fast as a channel";
  if (volume.no_jump > volume.certified) text += "; no jump in " + floored_percent(volume.no_jump);
  if (volume.refuted > 0.0) text += "; refuted " + floored_percent(volume.refuted);
  return text + ")";
}

std::string sampled_summary(const CleanVolume& volume) {
  if (volume.poses == 0) return "";
  return std::to_string(volume.clean) + " of " + std::to_string(volume.poses) +
         " random poses clean (" + significant(100.0 * kVolumeConfidence) + " % sure: at least " +
         floored_percent(volume.at_least) + " of the volume)";
}

std::string volume_summary(const CleanVolume& volume) {
  const std::string certified = certified_summary(volume), sampled = sampled_summary(volume);
  return certified.empty() || sampled.empty() ? certified + sampled
                                              : certified + "; searched: " + sampled;
}

}  // namespace backbend::validate
