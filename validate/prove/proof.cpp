#include "validate/prove/proof.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "validate/prove/refute.h"

namespace backbend::validate {
namespace {

using solver::BoxReal;
using solver::Interval;

/// Rest frames and stored quaternions are rotations but for rounding, which bounds of gains do not
/// know of; this covers it many times.
constexpr double kSlack = 1e-12;

/// Bounds that are rounded outward are not 0 where nothing turns.
constexpr double kNoGain = 1e-9;

struct Place {
  std::uint32_t node;
  SubBox box;
};

/// Leaves that are to be looked at, in the order in which the search makes them: what is left of
/// one round, and what there is already of the next. A round is of boxes with as many looks above.
std::array<std::vector<Place>, 2> pending_of(const ProofTree& tree, const ProofBox& whole) {
  struct Step {
    Place place;
    std::size_t round;
  };
  std::vector<Step> stack{{{0, whole_of(whole)}, 0}}, pending;
  std::size_t first = std::numeric_limits<std::size_t>::max();
  while (!stack.empty()) {
    const Step step = stack.back();
    stack.pop_back();
    const ProofNode& node = tree.node[step.place.node];
    if (node.state == BoxState::pending) {
      pending.push_back(step);
      first = std::min(first, step.round);
    }
    if (node.state != BoxState::split) continue;
    const auto half = halves(step.place.box, node.axis);
    const std::size_t round = step.round + (node.looked_at ? 1 : 0);
    stack.push_back({{node.first + 1, half[1]}, round});
    stack.push_back({{node.first, half[0]}, round});
  }
  std::array<std::vector<Place>, 2> rounds;
  for (const Step& step : pending) rounds[step.round == first ? 0 : 1].push_back(step.place);
  return rounds;
}

/// What one box came to.
struct Outcome {
  double bound = 0.0;
  bool splits = false;
  std::array<bool, kProofAxes> idle{};
  std::optional<Refutation> refutation;
};

BoxReal variable_of(const ProofAxis& axis, int j, double low, double high, bool angle) {
  Interval range(low, high);
  if (angle) range = range * solver::kPiInterval / Interval(180.0);
  if (!axis.varies()) return BoxReal(range);
  return BoxReal::variable(j, range.lo, range.hi);
}

}  // namespace

bool ProofTree::is_complete() const {
  return std::none_of(node.begin(), node.end(),
                      [](const ProofNode& n) { return n.state == BoxState::pending; });
}

void each_leaf(const ProofTree& tree, const ProofBox& whole,
               const std::function<void(const SubBox&, const ProofNode&)>& visit) {
  std::vector<Place> stack{{0, whole_of(whole)}};
  while (!stack.empty()) {
    const Place place = stack.back();
    stack.pop_back();
    const ProofNode& node = tree.node[place.node];
    if (node.state != BoxState::split) {
      visit(place.box, node);
      continue;
    }
    const auto half = halves(place.box, node.axis);
    stack.push_back({node.first + 1, half[1]});
    stack.push_back({node.first, half[0]});
  }
}

ProofShares shares_of(const ProofTree& tree, const ProofBox& whole) {
  ProofShares shares;
  each_leaf(tree, whole, [&](const SubBox& box, const ProofNode& node) {
    const double share = share_of(box, whole);
    switch (node.state) {
      case BoxState::certified:
        shares.certified += share;
        ++shares.certified_boxes;
        break;
      case BoxState::refuted:
      case BoxState::steep:
        shares.refuted += share;
        ++shares.refuted_boxes;
        break;
      default:
        shares.open += share;
        ++shares.open_boxes;
    }
    const bool no_jump = node.state == BoxState::certified || node.state == BoxState::steep ||
                         node.state == BoxState::smooth;
    if (no_jump) shares.no_jump += share;
  });
  return shares;
}

const solver::BoxSolver& box_solver_of(const solver::SpineSystem& system) {
  const std::string name(system.name());
  const auto* solver = dynamic_cast<const solver::BoxSolver*>(&system);
  if (!solver) {
    throw ProofError(name +
                     ": its solver does not run on boxes of poses yet, so nothing can be "
                     "proved of it; docs/prove.md lists the systems that do");
  }
  if (const std::string why = solver->why_not_on_boxes(); !why.empty()) {
    throw ProofError(name + ": " + why);
  }
  return *solver;
}

void check_controls(const ProofBox& box, const solver::SpineSystem& system,
                    const solver::BoxSolver& solver) {
  if (!box.of_controls) return;
  for (const ProofAxis& axis : box.axis) {
    const std::string why = solver.why_fixed(axis.channel);
    if (axis.varies() && !why.empty())
      throw ProofError(std::string(system.name()) + ": " + axis.channel + " " + why);
  }
}

std::array<bool, kProofAxes> PartGain::idle() const {
  std::array<bool, kProofAxes> still{};
  for (std::size_t j = 0; j < still.size(); ++j) still[j] = along[j] < kNoGain || only_rolls[j];
  return still;
}

solver::BodyBox body_over(const ProofBox& whole, const SubBox& part) {
  const auto own = [&](std::size_t j) {
    return variable_of(whole.axis[j], int(j), part.low[j], part.high[j], true);
  };
  return {own(0), own(1), own(2)};
}

std::vector<BoxReal> controls_over(const ProofBox& whole, const solver::SpineSystem& system,
                                   const solver::BoxSolver& solver, solver::Mapping mapping,
                                   const SubBox& part) {
  if (!whole.of_controls) return solver.controls_for(body_over(whole, part), mapping);
  std::vector<BoxReal> control;
  for (const solver::Channel& c : system.channels()) {
    control.emplace_back(c.rest);
    for (std::size_t j = 0; j < whole.axis.size(); ++j) {
      if (whole.axis[j].channel != c.name) continue;
      control.back() = variable_of(whole.axis[j], int(j), part.low[j], part.high[j],
                                   c.kind == solver::Channel::Kind::rotation);
    }
  }
  return control;
}

PartGain gain_over(const ProofQuestion& question, const solver::SpineSystem& system,
                   const solver::BoxSolver& solver, const SubBox& part) {
  const ProofBox& whole = question.box;
  solver::BoxPose pose;
  if (whole.of_controls) {
    solver.solve_box(controls_over(whole, system, solver, question.mapping, part), pose);
  } else {
    solver.solve_body_box(body_over(whole, part), question.mapping, pose);
  }

  PartGain most;
  most.only_rolls = pose.only_rolls;
  for (std::size_t j = 0; j < whole.axis.size(); ++j) {
    if (!whole.axis[j].varies()) continue;
    // Rates are radians for half the part's width; gains are degrees for a degree, or for a unit.
    const Interval half = Interval(0.5) * (Interval(part.high[j]) - Interval(part.low[j]));
    for (const solver::BoxRates& rate : pose.rate) {
      const Interval gain =
          Interval(rate[j]) * Interval(180.0) / solver::kPiInterval / half * Interval(1.0 + kSlack);
      most.along[j] = gain.is_finite() ? std::max(most.along[j], gain.hi)
                                       : std::numeric_limits<double>::infinity();
    }
  }
  return most;
}

namespace {

/// PartGain::idle(); of a part too wide for bounds, of the axes that were not split yet, whether
/// nothing turns along them through its middle. What is split does not touch the proof.
std::array<bool, kProofAxes> idle_axes(const ProofQuestion& question,
                                       const solver::SpineSystem& system,
                                       const solver::BoxSolver& solver, const SubBox& part,
                                       const PartGain& gain) {
  std::array<bool, kProofAxes> idle = gain.idle();
  if (std::isfinite(gain.most())) return idle;
  for (std::size_t j = 0; j < question.box.axis.size(); ++j) {
    const ProofAxis& axis = question.box.axis[j];
    if (!axis.varies() || part.low[j] != axis.low || part.high[j] != axis.high) continue;
    SubBox line = part;
    for (std::size_t k = 0; k < line.low.size(); ++k)
      if (k != j) line.low[k] = line.high[k] = 0.5 * part.low[k] + 0.5 * part.high[k];
    idle[j] = gain_over(question, system, solver, line).idle()[j];
  }
  return idle;
}

}  // namespace

void prove(const ProofQuestion& question, const solver::SpineSystem& system, ProofTree& tree,
           Progress& progress) {
  const solver::BoxSolver& solver = box_solver_of(system);
  check_controls(question.box, system, solver);
  const Refuter refuter(question, system);
  constexpr std::size_t kChunk = 2048;

  auto [level, next] = pending_of(tree, question.box);
  // How many boxes it takes is not known before; how much of the volume is decided is.
  constexpr std::size_t kSteps = 1000;
  double decided = 0.0;
  std::size_t shown = 0;
  progress.start("thousandths of the box", kSteps);
  std::vector<Outcome> outcome;
  using Idle = std::array<bool, kProofAxes>;
  const std::function<void(const Place&, int, const Idle&)> split =
      [&](const Place& place, int levels, const Idle& idle) {
        const int axis = levels > 0 ? widest_axis(place.box, question.smallest, idle) : -1;
        if (axis < 0) {
          next.push_back(place);
          return;
        }
        const auto first = static_cast<std::uint32_t>(tree.node.size());
        tree.node.resize(tree.node.size() + 2);
        ProofNode& node = tree.node[place.node];
        node.state = BoxState::split;
        node.axis = static_cast<std::int8_t>(axis);
        node.first = first;
        const auto half = halves(place.box, axis);
        split({first, half[0]}, levels - 1, idle);
        split({first + 1, half[1]}, levels - 1, idle);
      };
  const auto settle = [&](const Place& place, Outcome& own) {
    ProofNode& node = tree.node[place.node];
    ++tree.looked_at;
    if (own.bound <= question.gain) {
      node.state = BoxState::certified;
      tree.gain_bound = std::max(tree.gain_bound, own.bound);
    } else if (own.splits) {
      node.looked_at = true;
      // Far from certified: a third of the width, or so, is looked at next.
      const int levels = own.bound > 3.0 * question.gain ? kProofAxes : 1;
      split(place, levels, own.idle);
    } else {
      const bool no_jump = std::isfinite(own.bound);
      if (own.refutation) {
        node.state = no_jump ? BoxState::steep : BoxState::refuted;
        node.refutation = static_cast<std::uint32_t>(tree.refutation.size());
        tree.refutation.push_back(std::move(*own.refutation));
      } else {
        node.state = no_jump ? BoxState::smooth : BoxState::open;
      }
    }
  };
  while (!level.empty()) {
    for (std::size_t first = 0; first < level.size(); first += kChunk) {
      poll_interrupt();
      const std::size_t count = std::min(kChunk, level.size() - first);
      // Whether a box may still be split does not depend on how many are looked at side by side.
      const std::uint64_t before = tree.looked_at;
      outcome.assign(count, {});
      const std::size_t waiting = level.size() - first + next.size();
      oneapi::tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
        const SubBox& box = level[first + i].box;
        Outcome& own = outcome[i];
        const PartGain gain = gain_over(question, system, solver, box);
        own.bound = gain.most();
        if (own.bound <= question.gain) return;
        own.idle = idle_axes(question, system, solver, box, gain);
        const bool room = before + waiting + (1 << kProofAxes) * (i + 1) <= question.boxes;
        own.splits =
            room && !solver.has_fixed_gain() && widest_axis(box, question.smallest, own.idle) >= 0;
        if (!own.splits) own.refutation = refuter.search(box);
      });
      for (std::size_t i = 0; i < count; ++i) settle(level[first + i], outcome[i]);
      for (std::size_t i = 0; i < count; ++i) {
        const Place& place = level[first + i];
        if (!outcome[i].splits) decided += share_of(place.box, question.box);
      }
      const auto now = std::min(kSteps, static_cast<std::size_t>(decided * double(kSteps) + 0.5));
      if (now > shown) progress.step(now - shown);
      shown = std::max(shown, now);
    }
    level.swap(next);
    next.clear();
  }
  progress.finish();
}

}  // namespace backbend::validate
