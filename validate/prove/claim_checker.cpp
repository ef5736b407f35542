#include "validate/prove/claim_checker.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "solver/math/interval.h"
#include "validate/prove/proof.h"

namespace backbend::validate {
namespace {

using solver::Interval;
using solver::OptionValue;

/// Rest frames are rotations but for rounding.
constexpr double kRounding = 1e-12;

class SumChecker final : public ClaimChecker {
 public:
  explicit SumChecker(double most) : most_(most) {}
  double gain_over(const SubBox&) const override { return most_; }

 private:
  double most_;
};

template <class Value>
const Value* option(const solver::SpineSystem& system, const std::string& key) {
  const auto found = system.options().find(key);
  return found == system.options().end() ? nullptr : std::get_if<Value>(&found->second);
}

/// How far the last joint of a chain turns for a turn of 1 of each control; joints below turn less.
std::map<std::string, Interval> whole_shares(const ProofQuestion& q,
                                             const solver::SpineSystem& system) {
  std::map<std::string, Interval> share;
  for (const solver::Channel& c : system.channels()) {
    share[c.name] = c.kind == solver::Channel::Kind::rotation ? Interval(1.0) : Interval(0.0);
  }
  if (q.rig.system != "neck") return share;
  const auto sum = [&](const char* key) {
    Interval all(0.0);
    if (const auto* list = option<std::vector<double>>(system, key)) {
      for (const double s : *list) all = all + Interval(s);
    }
    const auto* gains = option<std::string>(system, "gains");
    return gains && *gains == "normalised" ? Interval(1.0) : all;
  };
  share["base_z"] = sum("z_weights");
  share["base_y"] = sum("base_weights");
  share["top_y"] = sum("top_weights");
  return share;
}

}  // namespace

void checker_knows(const ProofQuestion& question, const std::string& what) {
  throw ProofError(question.rig.system + ": the checker knows " + what);
}

void check_body_channels(const ProofQuestion& question) {
  if (question.box.of_controls)
    checker_knows(question, "body channels only, not the rig's own controls");
}

std::unique_ptr<ClaimChecker> sum_checker(const ProofQuestion& q,
                                          const solver::SpineSystem& system) {
  const auto refuse = [&](const char* why) { throw ProofError(q.rig.system + ": " + why); };
  // even.md, section 6: a channel of the top control also moves what the middle one has left.
  const auto* named = option<std::string>(system, "limits");
  const bool limited = named && *named != "none";
  if (const auto* limits = option<std::vector<double>>(system, "limits");
      limits && !limits->empty()) {
    refuse("no checker knows limits");
  }
  if (const auto* reach = option<double>(system, "reach"); reach && *reach > 0.0) {
    refuse("no checker knows reach above 0");
  }
  // A body channel moves one control by itself, or two by halves; the neck's are divided by the
  // controls' whole shares, so that the head turns by what is asked.
  Interval most(q.box.of_controls ? 0.0 : 1.0);
  if (q.box.of_controls) {
    const auto share = whole_shares(q, system);
    for (const ProofAxis& a : q.box.axis) {
      if (a.varies()) most = Interval(std::max(most.hi, share.at(a.channel).hi));
    }
  }
  if (limited) most = most * Interval(2.0);
  return std::make_unique<SumChecker>((most * Interval(1.0 + kRounding)).hi);
}

std::unique_ptr<ClaimChecker> claim_checker(const ProofQuestion& question,
                                            const solver::SpineSystem& system) {
  const std::string& name = question.rig.system;
  if (name == "even" || name == "three_bone" || name == "neck")
    return sum_checker(question, system);
  if (name == "matrix_blend") return blend_checker(question, system);
  if (name == "isner") return isner_checker(question, system);
  if (name == "curve") return curve_checker(question, system);
  if (name == "snake") return snake_checker(question, system);
  if (name == "spline_ik" || name == "stretchy") return hip_chest_checker(question, system);
  throw ProofError(name +
                   ": no checker that is independent of the search knows this system yet; "
                   "docs/prove.md lists those that do");
}

}  // namespace backbend::validate
