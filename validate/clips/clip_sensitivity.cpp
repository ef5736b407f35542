#include "validate/clips/clip_sensitivity.h"

#include <algorithm>
#include <cmath>

#include "validate/judge/judge_recorded.h"
#include "validate/metrics/chain/clip_flip.h"
#include "validate/sweeps/sweep.h"
#include "validate/text/shell_word.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

/// Degrees of a jump that every sweep of a rig should show.
constexpr double kCoarseDeg = 10.0;
/// So many sweeps are named one by one.
constexpr Index kNamed = 6;

/// The smallest jump that is surely found anywhere in a sweep, at any joint by itself.
double smallest_found(const RigRecord& record, const SweepRecord& sweep) {
  double most = 0.0;
  for (Index j = 0; j < sweep.flips.detectable_deg.size(); ++j)
    if (record.recording->watched[j].against != WatchedJoint::Against::hips)
      most = std::max(most, sweep.flips.detectable_deg[j]);
  return sweep.flips.detectable_deg.empty() ? std::nan("") : most;
}

bool is_coarse(const RigRecord& record, const SweepRecord& sweep) {
  return sweep.sweep.step_deg > 0.0 && !(smallest_found(record, sweep) <= kCoarseDeg);
}

std::string degrees_text(double deg) {
  return std::isfinite(deg) && deg <= kAnyJump_deg ? number_text(deg, 1) + " deg" : "none";
}

std::string jumps_line(const RigRecord& record) {
  double calm = 0.0, most = 0.0;
  bool any = false;
  std::string busiest, restless;
  for (const SweepRecord& sweep : record.sweeps)
    for (Index j = 0; j < sweep.flips.detectable_deg.size(); ++j) {
      const double deg = sweep.flips.detectable_deg[j];
      const bool is_sum = record.recording->watched[j].against == WatchedJoint::Against::hips;
      if (!std::isfinite(deg) || is_sum) continue;
      any = true;
      if (sweep.flips.calm_deg[j] > calm) {
        calm = sweep.flips.calm_deg[j];
        restless = record.recording->watched[j].name;
      }
      if (deg > most) {
        most = deg;
        busiest = record.recording->watched[j].name;
      }
    }
  if (!any) return "flips: no sweep has the five frames that tell a jump from motion";
  if (calm > kAnyJump_deg)
    return "flips: not found in at least half of the frames: " + restless +
           " moves so unevenly from frame to frame that a jump of any size would hide there";
  return "flips: jumps from " + number_text(calm, 1) +
         " deg are found in at least half of the frames, at any joint; where its own motion is "
         "liveliest, " +
         busiest + " hides those below " + number_text(std::min(most, kAnyJump_deg), 1);
}

/// The smallest jump that is surely found in each sweep of controls, the coarsest first.
std::string sweeps_line(const RigRecord& record) {
  std::vector<std::pair<double, std::string>> sweeps;
  for (const SweepRecord& sweep : record.sweeps)
    if (sweep.sweep.step_deg > 0.0) {
      const double deg = smallest_found(record, sweep);
      sweeps.emplace_back(std::isfinite(deg) ? deg : 360.0, sweep.sweep.name);
    }
  if (sweeps.empty()) return {};
  std::ranges::stable_sort(sweeps, [](const auto& a, const auto& b) { return a.first > b.first; });
  std::string text;
  for (Index i = 0; i < std::min(kNamed, sweeps.size()); ++i)
    text += (text.empty() ? "" : ", ") + sweeps[i].second + " " + degrees_text(sweeps[i].first);
  if (sweeps.size() > kNamed)
    text += ", " + std::to_string(sweeps.size() - kNamed) + " more from " +
            degrees_text(sweeps.back().first) + " to " + degrees_text(sweeps[kNamed].first);
  return "flips by sweep: the smallest jump that is surely found: " + text;
}

std::string coarse_line(const RigRecord& record) {
  std::string text;
  for (const SweepRecord& sweep : record.sweeps)
    if (is_coarse(record, sweep))
      text += (text.empty() ? "" : ", ") + sweep.sweep.name + " (a frame every " +
              number_text(sweep.sweep.step_deg, 2) + " deg)";
  return text.empty() ? text
                      : "too coarse for jumps of " + number_text(kCoarseDeg, 0) +
                            " deg, which may hide there: " + text +
                            "; the rig itself, asked live, is bisected";
}

bool any_controls(const RigRecord& record) {
  return std::ranges::any_of(record.sweeps,
                             [](const SweepRecord& sweep) { return !sweep.sweep.channel.empty(); });
}

/// The widest limit that any joint was held to by its share of the spine's turn; 0 where none was.
double widest_share_limit(const RigRecord& record) {
  double widest = 0.0;
  for (const SweepRecord& sweep : record.sweeps)
    for (const auto& share : sweep.shares)
      if (share.joint >= 0) widest = std::max(widest, share.limit_deg);
  return widest;
}

std::string kinks_line(const RigRecord& record) {
  const double limit = widest_share_limit(record);
  if (any_controls(record))
    return limit > 0.0 ? "kinks: one joint beyond its share of the bend is found from " +
                             number_text(limit, 1) + " deg in every sweep"
                       : "";
  // As counter_turns() needs them.
  constexpr Index kLeastJoints = 3;
  const bool has_shares = record.recording->share_joints >= kLeastJoints &&
                          std::ranges::any_of(record.sweeps, [](const SweepRecord& sweep) {
                            return sweep.shares.size() >= kLeastFrames;
                          });
  if (!has_shares) return {};
  return "kinks: no control is recorded, so one joint that bends more than its neighbours may be "
         "how the rig shares its bend; it is found only as a corner of " +
         number_text(clip_limits().of("BB010").value, 1) + " deg" +
         (limit > 0.0 ? ", or from " + number_text(limit, 1) + " deg where its neighbours turn back"
                      : "");
}

}  // namespace

std::vector<std::string> clip_sensitivity(const RigRecord& record) {
  std::vector<std::string> out = {jumps_line(record), sweeps_line(record), coarse_line(record),
                                  kinks_line(record)};
  std::erase(out, std::string());
  return out;
}

bool is_better_asked_live(const RigRecord& record) {
  return !any_controls(record) || std::ranges::any_of(record.sweeps, [&](const SweepRecord& sweep) {
    return is_coarse(record, sweep);
  });
}

std::string live_command(const skin::Clip& clip, const std::filesystem::path& character) {
  // `Blender 3.4.1, hero.blend`: the program and its file, as the bridges write them.
  const std::size_t comma = clip.source.rfind(", ");
  const std::string file = comma == std::string::npos ? "" : clip.source.substr(comma + 2);
  const auto is = [&](const char* ending) { return file.ends_with(ending); };
  const std::string rig = is(".blend")             ? "blender:" + file
                          : is(".ma") || is(".mb") ? "maya:" + file
                                                   : "command:PROGRAM";
  const std::string body = character.empty() ? "CHARACTER" : character.string();
  return "backbend check " + shell_word(body) + " --rig " + shell_word(rig);
}

}  // namespace backbend::validate
