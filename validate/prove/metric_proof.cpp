#include "validate/prove/metric_proof.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include "solver/math/rotation.h"
#include "validate/measure/metric_table.h"
#include "validate/metrics/surface/body_metrics.h"
#include "validate/prove/chain_bounds.h"
#include "validate/prove/kink_bounds.h"
#include "validate/prove/proof.h"
#include "validate/prove/surface_bounds.h"

namespace backbend::validate {
namespace {

constexpr std::string_view kProvable[] = {"BB010", "BB020", "BB021", "BB030",
                                          "BB033", "BB041", "BB047"};
constexpr std::string_view kKink = "BB010";  // of which the chain's course is asked, not its places
constexpr std::size_t kParts = 256;
constexpr std::size_t kTwist = 2;  // axis of a box of body channels

bool holds(const MetricClaim& claim, double bound) {
  return claim.check->sense == Sense::at_least ? bound >= claim.limit : bound <= claim.limit;
}
/// The worse of two values.
double worse(const MetricClaim& claim, double a, double b) {
  return claim.check->sense == Sense::at_least ? std::min(a, b) : std::max(a, b);
}
/// What no value is better than.
double best(const MetricClaim& claim) {
  const double far = std::numeric_limits<double>::infinity();
  return claim.check->sense == Sense::at_least ? far : -far;
}

/// Keeps a measured value where it is worse than those before; of equal ones the first.
void take_worst(const MetricClaim& claim, double value, const std::array<double, kProofAxes>& pose,
                ClaimResult& into) {
  if (into.measured && (value == into.worst || worse(claim, value, into.worst) != value)) return;
  into.measured = true;
  into.worst = value;
  into.pose = pose;
}

bool asks_kink(const MetricQuestion& q) {
  return std::ranges::any_of(q.claim, [](const MetricClaim& c) { return c.check->code == kKink; });
}
bool asks_skin(const MetricQuestion& q) {
  return std::ranges::any_of(
      q.claim, [](const MetricClaim& c) { return c.check->subject == Subject::mesh; });
}
bool asks_places(const MetricQuestion& q) {
  return std::ranges::any_of(q.claim, [](const MetricClaim& c) { return c.check->code != kKink; });
}

/// What is left to prove of a box on the way down to its parts.
struct Left {
  std::vector<bool> open;                         // of each claim
  std::vector<std::uint32_t> triangle;            // that may turn over
  std::vector<std::vector<std::uint32_t>> slice;  // of each claim: that may be below its limit
  std::vector<double> least;  // of each claim: the least bound of the slices that may not
};

class Search {
 public:
  explicit Search(const MetricQuestion& question)
      : q_(question),
        solver_(box_solver_of(*question.system)),
        controls_(question.box, *question.system, question.mapping),
        at_rest_(rig_at_rest(*question.system)),
        rest_excess_(rest_excess(question.system->rest(), at_rest_.curve)),
        of_places_(asks_places(question)) {
    if (!q_.stage) return;
    body_.emplace(q_.stage->character(), q_.stage->anatomy(), q_.stage->driver());
    if (asks_skin(q_)) surface_.emplace(*q_.stage, *body_);
  }

  Left everything() const {
    const std::size_t claims = q_.claim.size();
    Left all{std::vector<bool>(claims, true), {}, {}, {}};
    if (surface_) {
      all.triangle = surface_->triangles();
      all.slice.assign(claims, surface_->slices());
      all.least.assign(claims, std::numeric_limits<double>::infinity());
    }
    return all;
  }

  /// Looks at a box and its parts.
  void look_at(const SubBox& part, Left left, MetricProof& out) const {
    if (interrupt_pending()) return;
    ++out.looked_at;
    const double share = share_of(part, q_.box);
    const Told told = bound(part, share, left, out);
    if (std::none_of(left.open.begin(), left.open.end(), [](bool open) { return open; })) return;
    const int axis = widest_axis(part, q_.smallest, told.idle);
    if (axis < 0 || told.broken) {
      measure(part, share, left, out);
      return;
    }
    const auto half = halves(part, axis);
    look_at(half[0], left, out);
    look_at(half[1], std::move(left), out);
  }

 private:
  using Idle = std::array<bool, kProofAxes>;
  struct Told {
    Idle idle{};          // the axes along which no smaller part would tell more of what is left
    bool broken = false;  // every pose breaks all of it
  };

  /// Certifies what can be, and takes it out of what is left.
  Told bound(const SubBox& part, double share, Left& left, MetricProof& out) const {
    solver::BoxPlaces places;
    if (of_places_)
      solver_.place_box(controls_over(q_.box, *q_.system, solver_, q_.mapping, part), places);
    std::optional<RelativeMotions> motions;
    if (surface_ && of_places_)
      motions.emplace(q_.stage->driver().motions_over(*q_.system, places), surface_->pairs());
    double inverted = -1.0;  // the same for all claims about it
    Idle still{};            // of the chain's course
    bool only_course = true, broken = true;
    for (std::size_t i = 0; i < q_.claim.size(); ++i) {
      if (!left.open[i]) continue;
      const MetricClaim& claim = q_.claim[i];
      const std::string_view code = claim.check->code;
      double bound = 0.0;
      std::optional<double> least;
      if (code == "BB033") {
        if (inverted < 0.0) inverted = 100.0 * surface_->keep_unproved(*motions, left.triangle);
        bound = inverted;
      } else if (code == "BB030") {
        // Slices that were told apart in a larger box are bounded by what was proved there.
        const SurfaceBounds::LeastArea area =
            surface_->keep_small(*motions, claim.limit, left.slice[i]);
        left.least[i] = std::min(left.least[i], area.taken_out);
        bound = std::min(left.least[i], area.left_in);
      } else if (code == kKink) {
        solver::BoxCourse course;
        solver_.course_over(body_over(q_.box, part), q_.mapping, at_rest_.curve.size(), course);
        const solver::Interval kink =
            kink_over(course, rest_excess_, at_rest_.curve.size(), claim.limit);
        bound = kink.hi;
        least = kink.lo;
        still = course.still;
      } else {
        bound = most_of_chain(code, *q_.system, places);
      }
      if (!holds(claim, bound)) {
        only_course = only_course && code == kKink;
        broken = broken && least && !holds(claim, *least);
        continue;
      }
      left.open[i] = false;
      out.claim[i].certified += share;
      out.claim[i].bound = worse(claim, out.claim[i].bound, bound);
    }
    return {only_course ? still : Idle{}, broken};
  }

  /// Measures the pose in the middle of a box that is not split.
  void measure(const SubBox& part, double share, const Left& left, MetricProof& out) const {
    std::array<double, kProofAxes> pose{};
    for (std::size_t j = 0; j < pose.size(); ++j) pose[j] = 0.5 * part.low[j] + 0.5 * part.high[j];
    const std::vector<double> control = controls_.at(pose);
    UndecidedBox box{part, std::vector<ClaimState>(q_.claim.size(), ClaimState::certified)};
    solver::SpinePose spine;
    BodyMeasures measured;
    if (q_.stage && of_places_) {  // a kink needs no skin
      PosedCharacter posed = q_.stage->pose(*q_.system, control);
      measured =
          body_->measure(at_rest_, control, posed.spine, posed.mesh, solver::radians(pose[kTwist]),
                         false, Crossing::left_out, posed.world_from_node);
      spine = std::move(posed.spine);
    } else {
      q_.system->solve_into(control, solver::Detail::joints, spine);
      const std::vector<glm::dvec3> intended =
          q_.system->intended_curve(control, at_rest_.curve.size());
      measured.chain = measure_chain({spine, q_.system->rest(), intended, at_rest_.curve});
    }
    const auto value_of = [&](const MetricClaim& claim) {
      const Metric& metric = *metric_of(claim.check->code);
      return metric.from_chain ? metric.from_chain({*q_.system, spine, measured.chain}).value
                               : metric.from_body({*body_, measured}).value;
    };
    for (std::size_t i = 0; i < q_.claim.size(); ++i) {
      if (!left.open[i]) continue;
      const MetricClaim& claim = q_.claim[i];
      ClaimResult& own = out.claim[i];
      const double value = value_of(claim);
      // Nothing measured breaks nothing.
      const bool breaks = judge(*claim.check, value, claim.limit) == Verdict::fail;
      box.state[i] = breaks ? ClaimState::refuted : ClaimState::open;
      (breaks ? own.refuted : own.open) += share;
      if (std::isfinite(value)) take_worst(claim, value, pose, own);
    }
    out.undecided.push_back(std::move(box));
  }

  const MetricQuestion& q_;
  const solver::BoxSolver& solver_;
  PoseOfBox controls_;
  RigAtRest at_rest_;
  std::vector<glm::dvec3> rest_excess_;
  bool of_places_;
  std::optional<BodyMetrics> body_;
  std::optional<SurfaceBounds> surface_;
};

/// Axes along which no part will have to be split, as the box's middle shows. Of use for the order
/// of work only: nothing is proved by it.
std::array<bool, kProofAxes> idle_axes(const MetricQuestion& q) {
  const solver::BoxSolver& solver = box_solver_of(*q.system);
  if (asks_places(q) || !solver.why_no_course().empty()) return {};
  constexpr double kShare = 1e-4;
  SubBox middle = whole_of(q.box);
  for (std::size_t j = 0; j < middle.low.size(); ++j) {
    const double at = 0.5 * (middle.low[j] + middle.high[j]);
    const double reach = kShare * (middle.high[j] - middle.low[j]);
    middle.low[j] = at - reach;
    middle.high[j] = at + reach;
  }
  solver::BoxCourse course;
  solver.course_over(body_over(q.box, middle), q.mapping, kCurvePoints, course);
  return course.still;
}

/// The box in equal parts, to be looked at side by side.
std::vector<SubBox> parts_of(const MetricQuestion& q) {
  const std::array<bool, kProofAxes> idle = idle_axes(q);
  std::vector<SubBox> part{whole_of(q.box)};
  while (part.size() < kParts) {
    std::vector<SubBox> finer;
    for (const SubBox& p : part) {
      const int axis = widest_axis(p, q.smallest, idle);
      if (axis < 0) return part;
      const auto half = halves(p, axis);
      finer.insert(finer.end(), half.begin(), half.end());
    }
    part = std::move(finer);
  }
  return part;
}

void add(const MetricQuestion& q, const MetricProof& part, MetricProof& all) {
  for (std::size_t i = 0; i < q.claim.size(); ++i) {
    ClaimResult& sum = all.claim[i];
    const ClaimResult& own = part.claim[i];
    sum.certified += own.certified;
    sum.refuted += own.refuted;
    sum.open += own.open;
    sum.bound = worse(q.claim[i], sum.bound, own.bound);
    if (own.measured) take_worst(q.claim[i], own.worst, own.pose, sum);
  }
  all.undecided.insert(all.undecided.end(), part.undecided.begin(), part.undecided.end());
  all.looked_at += part.looked_at;
}

}  // namespace

MetricProof nothing_yet(const MetricQuestion& question) {
  MetricProof proof;
  for (const MetricClaim& claim : question.claim) proof.claim.emplace_back().bound = best(claim);
  return proof;
}

MetricClaim read_claim(const std::string& text) {
  const std::string code = text.substr(0, text.find('='));
  MetricClaim claim{find_check(code), 0.0};
  if (std::find(std::begin(kProvable), std::end(kProvable), code) == std::end(kProvable)) {
    std::string all;
    for (const std::string_view known : kProvable)
      all += (all.empty() ? "" : ", ") + std::string(known);
    throw ProofError("--bound '" + text + "': expected one of " + all +
                     ", with a limit where it is not the check's own: BB030=0.8");
  }
  claim.limit = claim.check->limit;
  if (code.size() == text.size()) return claim;
  const char* const begin = text.data() + code.size() + 1;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(begin, end, claim.limit);
  if (error != std::errc() || stop != end || !(claim.limit >= 0.0) || !std::isfinite(claim.limit))
    throw ProofError("--bound '" + text + "': the limit is not a number of 0 or more");
  return claim;
}

MetricParts parts_not_looked_at(const MetricQuestion& question) {
  return MetricParts(parts_of(question).size());
}

MetricProof prove_metrics(const MetricQuestion& question, MetricParts& parts, Progress& progress) {
  const solver::BoxSolver& solver = box_solver_of(*question.system);
  if (question.box.of_controls)
    throw ProofError("limits of checks are proved over body channels, not over a rig's controls");
  for (const std::string& why : {asks_places(question) ? solver.why_no_places() : std::string(),
                                 asks_skin(question) ? solver.why_no_skin() : std::string(),
                                 asks_kink(question) ? solver.why_no_course() : std::string()}) {
    if (!why.empty()) throw ProofError(std::string(question.system->name()) + ": " + why);
  }
  for (const MetricClaim& claim : question.claim) {
    if (claim.check->subject == Subject::mesh && !question.stage)
      throw ProofError(std::string(claim.check->code) + " is about a mesh: name a --character");
  }
  const Search search(question);
  const std::vector<SubBox> part = parts_of(question);
  assert(parts.size() == part.size());
  progress.start("parts of the box", part.size());
  oneapi::tbb::parallel_for(std::size_t{0}, part.size(), [&](std::size_t i) {
    if (!parts[i]) {
      MetricProof own = nothing_yet(question);
      search.look_at(part[i], search.everything(), own);
      if (interrupt_pending()) return;
      parts[i] = std::move(own);
    }
    progress.step();
  });
  poll_interrupt();
  progress.finish();
  MetricProof all = nothing_yet(question);
  for (const auto& own : parts) add(question, *own, all);
  for (ClaimResult& claim : all.claim) {
    // The sum of many shares is rounded; all certified is exactly 1.
    if (claim.refuted + claim.open == 0.0) claim.certified = 1.0;
  }
  return all;
}

}  // namespace backbend::validate
