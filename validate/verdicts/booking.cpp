#include "validate/verdicts/booking.h"

#include <algorithm>
#include <cmath>

namespace backbend::validate {
namespace {

bool compares_slices(const Check& check) {
  return check.code == "BB011" || check.code == "BB012" || check.code == "BB036";
}

/// How many times over the limit weights alone decide; of a share that is kept, of its loss.
double weights_factor(const Check& check) {
  if (check.code == "BB012" || check.code == "BB034") return 3.0;
  if (check.code == "BB030") return 1.6;
  if (check.code == "BB011") return 2.4;
  return compares_slices(check) || check.code == "BB033" ? 2.0 : 1.0;
}

}  // namespace

bool is_rest_shape(const Check& check, double limit, double value, double ideal) {
  if (check.code != "BB010" && check.code != "BB014") return false;
  return judge(check, ideal, limit) == Verdict::fail && value - ideal <= 0.1 * limit;
}

Booking book_mesh_finding(const Check& check, double limit, const MeshContext& context) {
  Booking out;
  out.verdict = judge(check, context.value, limit);
  if (out.verdict != Verdict::fail) return out;
  if (context.infeasible >= kInfeasible) return {Verdict::fail, Owner::pose, false};
  if (!std::isfinite(context.ideal)) return {Verdict::fail, check.owner, check.decides};
  const double worse =
      check.sense == Sense::at_most ? context.value - context.ideal : context.ideal - context.value;
  const auto beyond_rest = [&](double value) {
    return check.sense == Sense::at_most ? value : 1.0 - value;
  };
  const bool ideal_is_as_bad =
      context.own_shares
          ? beyond_rest(context.value) <= kUnevenShares * beyond_rest(context.ideal)
          : judge(check, context.ideal, limit) == Verdict::fail && worse <= 0.1 * std::abs(limit);
  if (ideal_is_as_bad && std::isfinite(context.ideal_proxy)) {
    const bool at_most = check.sense == Sense::at_most;
    const double gap =
        at_most ? context.ideal - context.ideal_proxy : context.ideal_proxy - context.ideal;
    const bool as_bad = gap <= 0.1 * std::abs(limit);
    const bool far_worse = at_most ? context.ideal > kWorseThanClean * context.ideal_proxy
                                   : context.ideal * kWorseThanClean < context.ideal_proxy;
    if (as_bad || !far_worse) return {Verdict::fail, Owner::skeleton, false};
  }
  const bool short_spine = (context.bones > 0 && context.bones < kLeastBonesForSlices) ||
                           context.longest_bone > kLongestBoneForSlices;
  const bool coarse = context.rows_per_bone < kLeastRowsForSlices;
  if (ideal_is_as_bad && compares_slices(check) && (short_spine || coarse || context.in_pieces))
    return {Verdict::fail, Owner::skeleton, false};
  // Stiff pieces that lie against each other at rest run into each other in any bend.
  if (ideal_is_as_bad && context.in_pieces && check.code == "BB034")
    return {Verdict::fail, Owner::skeleton, false};
  if (ideal_is_as_bad && short_spine &&
      (check.code == "BB030" || check.code == "BB033" || check.code == "BB034"))
    return {Verdict::fail, Owner::skeleton, false};
  // Skin that runs through skin with clean weights and the ideal bend, too: a head that is too big
  // for its neck, a cape against the legs.
  if (ideal_is_as_bad && check.code == "BB034" &&
      judge(check, context.ideal_proxy, limit) == Verdict::fail)
    return {Verdict::fail, Owner::pose, false};
  if (ideal_is_as_bad && context.infeasible >= infeasible_from(check))
    return {Verdict::fail, Owner::pose, false};
  if (ideal_is_as_bad) {
    const bool plain = judge(check, context.value, weights_limit(check, limit)) == Verdict::fail;
    return {Verdict::fail, Owner::weights, check.decides && context.judging_weights && plain};
  }
  const bool only_weights_cure_it = judge(check, context.proxy, limit) == Verdict::pass &&
                                    judge(check, context.ideal, limit) == Verdict::fail;
  return {Verdict::fail, only_weights_cure_it ? Owner::weights : Owner::solver, check.decides};
}

double infeasible_from(const Check& check) { return check.code == "BB011" ? 0.8 : kInfeasible; }

double weights_limit(const Check& check, double limit) {
  const double factor = weights_factor(check);
  return check.sense == Sense::at_most ? limit * factor : 1.0 - (1.0 - limit) * factor;
}

bool is_of_weights(const Finding& finding) {
  return finding.verdict == Verdict::fail &&
         (finding.owner == Owner::weights || finding.code == "BB060" || finding.code == "BB061" ||
          finding.code == "BB062");
}

int joints_needed(const Check& check, double limit, double value, int joints) {
  if (!std::isfinite(value) || judge(check, value, limit) != Verdict::fail) return 0;
  if (check.code == "BB011" || check.code == "BB036")
    return static_cast<int>(std::ceil(joints * value / limit));
  if (check.code == "BB030" && value > 0.0 && limit < 1.0)
    return static_cast<int>(
        std::ceil(joints * std::acos(std::sqrt(value)) / std::acos(std::sqrt(limit))));
  return 0;
}

}  // namespace backbend::validate
