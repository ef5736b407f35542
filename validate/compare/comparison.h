#pragma once
#include <string>
#include <utility>
#include <vector>

#include "validate/model/report.h"

namespace backbend::validate {

/// Compares two rigs (or one rig on two characters, or two clips) pose by pose: poses of the sweep
/// of one name with the same control are a pair, and of each pair every deciding metric that both
/// sides have. `a` and `b` become the labels, so they should say what differs.
///
/// A metric is better on one side where it differs by more than a twentieth of its limit: above
/// what calibration saw between two clean rigs, and below what anybody would call a fault. Of a
/// pose only what is over its limit on one side counts: the pose is better where some such metric
/// is better and none worse, and mixed where each side is better in one, so that no gain hides a
/// loss. Over all poses that side is ahead which has fewer poses with something over its limit,
/// and, where these are equal, more better poses. A side against itself is a draw.
Comparison compare_results(const RigResult& a, const RigResult& b, std::string a_label,
                           std::string b_label);

/// Every proposed rig of the report against every reference rig on the same character under the
/// same mapping, in the report's order.
std::vector<Comparison> compare_with_references(const Report& report);

/// What two files or folders are called beside each other: by their names alone, or as they are
/// given where these are the same.
std::pair<std::string, std::string> side_labels(const std::string& a, const std::string& b);

/// What a metric's value may differ by and still count as the same.
double comparison_tolerance(double limit);

/// How one comparison ended, in a few words: `curve is ahead`, `a draw`.
std::string comparison_verdict(const Comparison& comparison);

/// The last word of a comparison: who is ahead, by how many poses over a limit, and what each side
/// is short of over the sweeps. Of several comparisons a sentence each.
std::string comparison_summary(const Report& report);

}  // namespace backbend::validate
