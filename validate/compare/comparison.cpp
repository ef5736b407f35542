#include "validate/compare/comparison.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "validate/measure/measure.h"
#include "validate/metrics/math/median.h"
#include "validate/model/search_text.h"
#include "validate/sweeps/sweep.h"
#include "validate/verdicts/checks.h"

namespace backbend::validate {
namespace {

/// How many poses of each side are shown as its worst.
constexpr std::size_t kDamning = 3;

/// The deciding checks that are measured at poses, by the name of their metric.
const Check* check_of(const std::string& name) {
  const Metric* metric = metric_named(name);
  return metric != nullptr && metric->check().decides ? &metric->check() : nullptr;
}

const std::vector<double>* values_of(const SweepSeries& sweep, const std::string& metric) {
  const auto found = sweep.metric.find(metric);
  return found == sweep.metric.end() ? nullptr : &found->second;
}

double limit_of(const SweepSeries& sweep, const std::string& metric, const Check& check) {
  const auto found = sweep.metric_limit.find(metric);
  return found != sweep.metric_limit.end() && std::isfinite(found->second) ? found->second
                                                                           : check.limit;
}

/// In channels where the series says them, else by its control: `extension 90, side 10`.
std::string pose_text(const SweepSeries& sweep, std::size_t index) {
  PoseDegrees pose;
  for (const auto& [channel, degrees] : sweep.pose_deg)
    if (double* value = pose.find(channel)) *value = degrees[index];
  if (!sweep.pose_deg.empty()) return pose.text();
  return sweep.sweep + " " + number_text(sweep.control_deg[index], 3);
}

/// Poses are the same where their controls agree to this, degrees.
constexpr double kSameControl = 1e-6;

/// For each pose of `a` its partner in `b`, -1 for none. Controls may rise or fall.
std::vector<int> partners(const SweepSeries& a, const SweepSeries& b) {
  std::map<long long, int> at;
  const auto key = [](double control) { return std::llround(control / kSameControl); };
  for (std::size_t i = 0; i < b.control_deg.size(); ++i)
    at.emplace(key(b.control_deg[i]), static_cast<int>(i));
  std::vector<int> result;
  for (const double control : a.control_deg) {
    const auto found = at.find(key(control));
    result.push_back(found == at.end() ? -1 : found->second);
  }
  return result;
}

/// A difference that speaks against one side, and how much of the limit it is.
struct Candidate {
  ComparedPose pose;
  double share = 0;
};

/// The worst differences, at most one of a sweep and a metric, so that neighbours of one bad spot
/// do not fill the list.
std::vector<ComparedPose> worst_of(std::vector<Candidate> candidates) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& x, const Candidate& y) { return x.share > y.share; });
  std::vector<ComparedPose> result;
  std::set<std::string> codes;
  for (const bool again : {false, true}) {
    // A second round fills up with codes that were shown already, at other poses.
    for (const Candidate& each : candidates) {
      if (result.size() == kDamning) return result;
      if ((again || codes.insert(each.pose.code).second) &&
          std::none_of(result.begin(), result.end(), [&](const ComparedPose& shown) {
            return shown.code == each.pose.code && shown.at.sweep == each.pose.at.sweep;
          }))
        result.push_back(each.pose);
    }
  }
  return result;
}

struct MetricTally {
  MetricComparison row;
  std::vector<double> gain;  // how much better a is, per pose
};

/// Everything that is counted while the poses are gone through.
struct MetricTallies {
  std::map<std::string, MetricTally> metric;  // by name
  std::vector<Candidate> against_a, against_b;
};

/// Compares the pose of `a` that `at` says with pose `j` of `b`; returns its mark.
char compare_pose(const SweepSeries& a, const PoseRef& at, const SweepSeries& b, std::size_t j,
                  MetricTallies& tally, Comparison& comparison) {
  const auto i = static_cast<std::size_t>(at.pose);
  bool a_better = false, b_better = false, compared = false, a_over = false, b_over = false;
  for (const auto& [name, values] : a.metric) {
    const Check* check = check_of(name);
    const std::vector<double>* others = values_of(b, name);
    if (check == nullptr || others == nullptr) continue;
    const double x = values[i], y = (*others)[j];
    if (!std::isfinite(x) || !std::isfinite(y)) continue;
    const double limit = limit_of(a, name, *check);
    const double tolerance = comparison_tolerance(limit);
    const double gain = check->sense == Sense::at_most ? y - x : x - y;
    compared = true;
    const bool fails_a = judge(*check, x, limit) == Verdict::fail;
    const bool fails_b = judge(*check, y, limit) == Verdict::fail;
    a_over = a_over || fails_a;
    b_over = b_over || fails_b;
    MetricTally& row = tally.metric[name];
    row.row = {name,
               std::string(check->code),
               std::string(check->unit),
               tolerance,
               row.row.a_better,
               row.row.b_better,
               row.row.same,
               0.0};
    row.gain.push_back(gain);
    if (std::abs(gain) <= tolerance) {
      ++row.row.same;
      continue;
    }
    ++(gain > 0 ? row.row.a_better : row.row.b_better);
    if (!fails_a && !fails_b) continue;
    (gain > 0 ? a_better : b_better) = true;
    ComparedPose pose{a.sweep,
                      pose_text(a, i),
                      at,
                      a.control_deg[i],
                      std::string(check->code),
                      std::string(check->unit),
                      x,
                      y,
                      limit,
                      {},
                      {},
                      {},
                      {}};
    (gain > 0 ? tally.against_b : tally.against_a)
        .push_back(
            {std::move(pose), std::abs(excess(*check, x, limit) - excess(*check, y, limit))});
  }
  if (!compared) return '?';
  ++comparison.paired;
  comparison.a_over += a_over ? 1 : 0;
  comparison.b_over += b_over ? 1 : 0;
  if (a_better && b_better) {
    ++comparison.mixed;
    return 'x';
  }
  if (a_better) {
    ++comparison.a_better;
    return '+';
  }
  if (b_better) {
    ++comparison.b_better;
    return '-';
  }
  ++comparison.same;
  return '=';
}

/// `even is better in 62 % of random poses (95 %: 44 to 80 %)`. Neighbouring poses of a walk are no
/// draws of their own, so its stretches are: the interval is Student's over ten of them.
std::string sampled_text(const Comparison& comparison) {
  constexpr int kStretches = 10;
  constexpr double kStudent = 2.262;  // 95 % of nine degrees of freedom
  const auto walk =
      std::ranges::find(comparison.sweeps, std::string(kRandomWalk), &SweepComparison::sweep);
  if (walk == comparison.sweeps.end()) return "";
  std::string marks = walk->marks;
  std::erase(marks, '?');
  if (marks.size() < 5 * kStretches) return "";
  const auto share = [&](char mark) {
    double sum = 0.0, square = 0.0;
    for (std::size_t k = 0; k < kStretches; ++k) {
      const std::size_t first = k * marks.size() / kStretches,
                        end = (k + 1) * marks.size() / kStretches;
      const double here =
          static_cast<double>(std::count(marks.begin() + static_cast<long>(first),
                                         marks.begin() + static_cast<long>(end), mark)) /
          static_cast<double>(end - first);
      sum += here;
      square += here * here;
    }
    const double mean = sum / kStretches;
    const double variance = std::max(0.0, square / kStretches - mean * mean) / (kStretches - 1);
    const double either = kStudent * std::sqrt(variance);
    const auto percent = [](double value) {
      return number_text(100.0 * std::clamp(value, 0.0, 1.0), 0);
    };
    return percent(mean) + " % of random poses (95 %: " + percent(mean - either) + " to " +
           percent(mean + either) + " %)";
  };
  return comparison.a + " is better in " + share('+') + ", worse in " + share('-');
}

/// Each rig has its own paths to what a search found on it.
bool is_hunted(const RigResult& rig, std::size_t sweep) {
  return std::ranges::find(rig.hunt.worst, static_cast<int>(sweep), &HuntedPose::sweep) !=
         rig.hunt.worst.end();
}

}  // namespace

std::pair<std::string, std::string> side_labels(const std::string& a, const std::string& b) {
  const std::string first = std::filesystem::path(a).filename().string();
  const std::string second = std::filesystem::path(b).filename().string();
  if (first == second || first.empty() || second.empty()) return {a, b};
  return {first, second};
}

double comparison_tolerance(double limit) { return 0.05 * std::abs(limit); }

Comparison compare_results(const RigResult& a, const RigResult& b, std::string a_label,
                           std::string b_label) {
  Comparison comparison;
  comparison.a = std::move(a_label);
  comparison.b = std::move(b_label);
  comparison.character = a.character;
  comparison.mapping = a.mapping;
  MetricTallies tally;
  std::size_t seen = 0, poses_of_b = 0;
  for (std::size_t s = 0; s < b.sweeps.size(); ++s)
    if (!is_hunted(b, s)) poses_of_b += b.sweeps[s].control_deg.size();
  for (std::size_t s = 0; s < a.sweeps.size(); ++s) {
    if (is_hunted(a, s)) continue;
    const SweepSeries& sweep = a.sweeps[s];
    // Two clips of one sweep each are the same motion whatever it is called.
    const bool alone = a.sweeps.size() == 1 && b.sweeps.size() == 1;
    const auto other = std::find_if(b.sweeps.begin(), b.sweeps.end(), [&](const SweepSeries& each) {
      return alone || each.sweep == sweep.sweep;
    });
    if (other == b.sweeps.end()) {
      comparison.unpaired += static_cast<int>(sweep.control_deg.size());
      continue;
    }
    const std::vector<int> partner = partners(sweep, *other);
    std::string marks;
    for (std::size_t i = 0; i < partner.size(); ++i) {
      char mark = '?';
      if (partner[i] >= 0) {
        ++seen;
        mark = compare_pose(sweep, {-1, static_cast<int>(s), static_cast<int>(i)}, *other,
                            static_cast<std::size_t>(partner[i]), tally, comparison);
      }
      if (mark == '?') ++comparison.unpaired;
      marks += mark;
    }
    comparison.sweeps.push_back({sweep.sweep, sweep.pose_deg, sweep.control_deg, marks});
  }
  comparison.unpaired += static_cast<int>(poses_of_b - std::min(seen, poses_of_b));
  for (auto& [name, each] : tally.metric) {
    each.row.median_gain = median(each.gain);
    comparison.metrics.push_back(each.row);
  }
  // What differs most often first.
  std::stable_sort(comparison.metrics.begin(), comparison.metrics.end(),
                   [](const MetricComparison& x, const MetricComparison& y) {
                     return x.a_better + x.b_better > y.a_better + y.b_better;
                   });
  comparison.worst_of_a = worst_of(std::move(tally.against_a));
  comparison.worst_of_b = worst_of(std::move(tally.against_b));
  const auto ahead = [](int of_a, int of_b) { return of_a > of_b ? "a" : of_b > of_a ? "b" : ""; };
  comparison.ahead = ahead(comparison.b_over, comparison.a_over);
  if (comparison.ahead.empty()) comparison.ahead = ahead(comparison.a_better, comparison.b_better);
  comparison.sampled = sampled_text(comparison);
  return comparison;
}

std::vector<Comparison> compare_with_references(const Report& report) {
  std::vector<Comparison> result;
  for (const RigResult& a : report.rigs) {
    if (a.role != Role::proposed) continue;
    for (const RigResult& b : report.rigs) {
      if (b.role == Role::reference && b.character == a.character && b.mapping == a.mapping)
        result.push_back(compare_results(a, b, a.rig, b.rig));
    }
  }
  return result;
}

std::string comparison_verdict(const Comparison& comparison) {
  if (comparison.paired == 0) return "nothing could be compared";
  if (comparison.ahead.empty()) return "a draw";
  return (comparison.ahead == "a" ? comparison.a : comparison.b) + " is ahead";
}

namespace {

/// `extension (clean to 94 of 180), corners (71 %)`; `nothing` where a side is clean throughout.
std::string shortfalls(const RigResult& rig) {
  std::string text;
  const auto add = [&](const std::string& each) { text += (text.empty() ? "" : ", ") + each; };
  for (const Headroom& h : rig.headroom) {
    if (!h.measured)
      add(h.channel + " (not measured)");
    else if (h.clean_to_deg < h.needs_deg)
      add(h.channel + " (clean to " + number_text(h.clean_to_deg, 0) + " of " +
          number_text(h.needs_deg, 0) + ")");
  }
  const Corners& c = rig.corners;
  if (!c.covered())
    add("corners (not measured)");
  else if (c.clean < c.poses)
    add("corners (" + number_text(std::floor(c.clean_percent()), 0) + " % clean)");
  return text.empty() ? "nothing" : text;
}

/// What a side is short of, and how much of the envelope's volume is clean.
std::string side_summary(const Report& report, const Comparison& comparison, Role role,
                         const std::string& label) {
  for (const RigResult& rig : report.rigs) {
    if (rig.role != role || rig.mapping != comparison.mapping) continue;
    const std::string volume = volume_summary(rig.volume);
    return " " + label + " is short of " + shortfalls(rig) + "." +
           (volume.empty() ? "" : " Volume of " + label + ": " + volume + ".");
  }
  return "";
}

}  // namespace

std::string comparison_summary(const Report& report) {
  std::string text;
  for (const Comparison& c : report.comparisons) {
    if (!text.empty()) text += " ";
    if (c.paired == 0) {
      text += c.a + " and " + c.b + ": nothing could be compared.";
      continue;
    }
    const bool swap = c.ahead == "b";
    const std::string &first = swap ? c.b : c.a, &second = swap ? c.a : c.b;
    const int first_over = swap ? c.b_over : c.a_over, second_over = swap ? c.a_over : c.b_over;
    text += first + (c.ahead.empty() ? " and " + second + ": a draw" : " is ahead of " + second) +
            ": over a limit in " + std::to_string(first_over) + " of " + std::to_string(c.paired) +
            " poses, " + second + " in " + std::to_string(second_over) + ".";
    text += side_summary(report, c, Role::proposed, c.a);
    text += side_summary(report, c, Role::reference, c.b);
  }
  return text;
}

}  // namespace backbend::validate
