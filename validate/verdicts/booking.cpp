#include "validate/verdicts/booking.h"

#include <algorithm>
#include <cmath>

namespace backbend::validate {

Booking book_mesh_finding(const Check& check, double limit, const MeshContext& context) {
  Booking out;
  out.verdict = judge(check, context.value, limit);
  if (out.verdict != Verdict::fail) return out;
  if (context.infeasible >= 1.0) return {Verdict::fail, Owner::pose, false};
  if (!std::isfinite(context.ideal)) return {Verdict::fail, check.owner, check.decides};
  const double worse =
      check.sense == Sense::at_most ? context.value - context.ideal : context.ideal - context.value;
  const bool ideal_is_as_bad =
      judge(check, context.ideal, limit) == Verdict::fail && worse <= 0.1 * std::abs(limit);
  if (ideal_is_as_bad)
    return {Verdict::fail, Owner::weights, check.decides && context.judging_weights};
  const bool only_weights_cure_it = judge(check, context.proxy, limit) == Verdict::pass &&
                                    judge(check, context.ideal, limit) == Verdict::fail;
  return {Verdict::fail, only_weights_cure_it ? Owner::weights : Owner::solver, check.decides};
}

}  // namespace backbend::validate
