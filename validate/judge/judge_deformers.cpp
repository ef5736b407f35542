#include "validate/judge/judge_deformers.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "validate/live/external_rig.h"
#include "validate/tasks/progress.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

constexpr std::string_view kCode = "BB037";
// A fault moves the surface by the limit within so many degrees of control.
constexpr double kAtOnce_deg = 0.5;
constexpr int kHalvings = 20;  // of the whole sweep
// Of a change that stays in one half: smooth motion halves.
constexpr double kStays = 0.7;
// Up to this share of the spine's length mesh findings under linear blending speak of the rig, too.
constexpr double kTrustedBlending = 0.01;

/// The surface at one pose, against linear blending of the same joints.
struct Surface {
  std::vector<glm::vec3> offset, blended;  // of each vertex
};

/// Part of a sweep over which the offset changes.
struct Stretch {
  double from = 0.0, to = 0.0;  // control, degrees
  Surface before, after;
  double change = 0.0, blended = 0.0;  // the largest of a vertex; of the same one under blending
  int vertex = -1;

  double width() const { return std::abs(to - from); }
};

double moved(const std::vector<glm::vec3>& a, const std::vector<glm::vec3>& b, Index v) {
  return glm::distance(glm::dvec3(a[v]), glm::dvec3(b[v]));
}

void measure(Stretch& stretch) {
  stretch.change = 0.0;
  for (Index v = 0; v < stretch.before.offset.size(); ++v) {
    const double here = moved(stretch.before.offset, stretch.after.offset, v);
    if (here > stretch.change) {
      stretch.change = here;
      stretch.vertex = static_cast<int>(v);
    }
  }
  if (stretch.vertex >= 0)
    stretch.blended =
        moved(stretch.before.blended, stretch.after.blended, static_cast<Index>(stretch.vertex));
}

/// Vertices that move at least half as far as the one that moves farthest.
int patch_of(const Stretch& stretch) {
  int count = 0;
  for (Index v = 0; v < stretch.before.offset.size(); ++v)
    count += moved(stretch.before.offset, stretch.after.offset, v) >= 0.5 * stretch.change ? 1 : 0;
  return count;
}

/// Asks one rig for its surface along one sweep.
class SweepSurface {
 public:
  SweepSurface(const RigRecord& rig, const JudgeContext& context, const SweepRecord& sweep)
      : rig_(rig), stage_(context.stage), sweep_(sweep) {}

  std::vector<Surface> at(const std::vector<double>& controls) const {
    std::vector<std::vector<double>> asked;
    for (const double control : controls)
      asked.push_back(controls_at(*rig_.system, sweep_.sweep.pose_at(control), rig_.mapping));
    rig_.system->prepare(asked, solver::Detail::all);
    std::vector<Surface> out(controls.size());
    oneapi::tbb::parallel_for(Index{0}, asked.size(), [&](Index i) {
      const PosedCharacter posed = stage_.pose(*rig_.system, asked[i]);
      out[i].blended = posed.blended->position;
      for (Index v = 0; v < posed.mesh.position.size(); ++v)
        out[i].offset.push_back(posed.mesh.position[v] - out[i].blended[v]);
    });
    return out;
  }

  /// Both halves of each.
  std::vector<std::pair<Stretch, Stretch>> halve(std::vector<Stretch> whole) const {
    std::vector<double> middle;
    for (const Stretch& each : whole) middle.push_back(0.5 * (each.from + each.to));
    std::vector<Surface> surface = at(middle);
    std::vector<std::pair<Stretch, Stretch>> out;
    for (Index i = 0; i < whole.size(); ++i) {
      Stretch low{whole[i].from, middle[i], std::move(whole[i].before), surface[i]};
      Stretch high{middle[i], whole[i].to, std::move(surface[i]), std::move(whole[i].after)};
      measure(low);
      measure(high);
      out.emplace_back(std::move(low), std::move(high));
    }
    return out;
  }

 private:
  const RigRecord& rig_;
  const Stage& stage_;
  const SweepRecord& sweep_;
};

bool holds_flip(const SweepRecord& sweep, const Stretch& stretch) {
  const double span = sweep.sweep.to_deg - sweep.sweep.from_deg;
  const double low = std::min(stretch.from, stretch.to), high = std::max(stretch.from, stretch.to);
  const double around = std::abs(span) * std::ldexp(1.0, -kHalvings);
  return std::ranges::any_of(sweep.flips.jumps, [&](const Jump& jump) {
    const double a = sweep.sweep.from_deg + span * jump.before;
    const double b = sweep.sweep.from_deg + span * jump.after;
    return std::max(a, b) >= low - around && std::min(a, b) <= high + around;
  });
}

/// A change of at least `limit` within half a degree.
struct Pop {
  Stretch closest;       // as near as the change could be held
  double size = 0.0;     // within half a degree
  double blended = 0.0;  // what the joints move the vertex by meanwhile
  double from = 0.0, to = 0.0;
  double whole = 0.0;  // from `from` to `to`, where haste goes on
  bool jump = false;
};

Pop follow(const SweepSurface& surface, Stretch stretch, double narrowest) {
  Pop pop;
  pop.size = pop.whole = stretch.change;
  pop.blended = stretch.blended;
  pop.from = stretch.from;
  pop.to = stretch.to;
  while (stretch.width() > narrowest) {
    poll_interrupt();
    std::vector<Stretch> one;
    const double parent = stretch.change;
    Stretch kept = stretch;
    one.push_back(std::move(stretch));
    auto [low, high] = std::move(surface.halve(std::move(one)).front());
    stretch = std::move(low.change >= high.change ? low : high);
    if (stretch.change < kStays * parent) {
      pop.closest = std::move(kept);
      return pop;
    }
  }
  pop.jump = true;
  pop.size = pop.whole = stretch.change;
  pop.from = stretch.from;
  pop.to = stretch.to;
  pop.closest = std::move(stretch);
  return pop;
}

std::vector<Pop> find_pops(const SweepSurface& surface, const SweepRecord& sweep, double limit,
                           std::vector<Surface> at_pose) {
  const double narrowest =
      std::abs(sweep.sweep.to_deg - sweep.sweep.from_deg) * std::ldexp(1.0, -kHalvings);
  std::vector<Stretch> wide, close;
  const auto sort_in = [&](Stretch&& stretch) {
    if (stretch.change > limit)
      (stretch.width() > kAtOnce_deg ? wide : close).push_back(std::move(stretch));
  };
  for (Index i = 0; i + 1 < at_pose.size(); ++i) {
    Stretch stretch{sweep.poses[i].control_deg, sweep.poses[i + 1].control_deg, at_pose[i],
                    at_pose[i + 1]};
    measure(stretch);
    sort_in(std::move(stretch));
  }
  at_pose.clear();
  while (!wide.empty()) {
    poll_interrupt();
    std::vector<Stretch> now = std::move(wide);
    wide.clear();
    for (auto& [low, high] : surface.halve(std::move(now))) {
      sort_in(std::move(low));
      sort_in(std::move(high));
    }
  }
  std::ranges::sort(close, {}, [](const Stretch& each) { return std::min(each.from, each.to); });
  std::vector<Pop> out;
  for (Stretch& stretch : close) {
    Pop pop = follow(surface, std::move(stretch), narrowest);
    if (holds_flip(sweep, pop.closest)) continue;
    // Where joints make haste, what blending only comes near to makes it, too.
    if (!pop.jump && pop.size - pop.blended <= limit) continue;
    // Haste that goes on is one.
    const bool goes_on =
        !out.empty() && !pop.jump && !out.back().jump &&
        std::min(std::abs(out.back().to - pop.from), std::abs(out.back().from - pop.to)) < 1e-9;
    if (!goes_on) {
      out.push_back(std::move(pop));
      continue;
    }
    Pop& before = out.back();
    before.whole += pop.whole;
    (std::abs(before.to - pop.from) < 1e-9 ? before.to : before.from) =
        std::abs(before.to - pop.from) < 1e-9 ? pop.to : pop.from;
    if (pop.size > before.size) {
      before.size = pop.size;
      before.closest = std::move(pop.closest);
    }
  }
  return out;
}

Finding pop_finding(const RigRecord& rig, const JudgeContext& context, const SweepRecord& sweep,
                    const Pop& pop) {
  const double length = context.stage.anatomy().spine_length;
  const double at = pop.jump ? pop.closest.to : 0.5 * (pop.closest.from + pop.closest.to);
  Finding finding = start_finding(rig, context, sweep, kCode, sweep.sweep.pose_at(at), at);
  finding.value = 100.0 * pop.size / length;
  finding.vertex = pop.closest.vertex;
  const std::string channel = sweep.sweep.channel + " ";
  const auto mm = [](double metres) { return number_text(1000.0 * metres, 1) + " mm"; };
  finding.detail = "the surface " +
                   (pop.jump ? "jumps by " + mm(pop.size) + " at " + channel + number_text(at, 3)
                             : "moves by " + mm(pop.whole) + " from " + channel +
                                   number_text(pop.from, 2) + " to " + number_text(pop.to, 2)) +
                   " (" + std::to_string(patch_of(pop.closest)) +
                   " vertices), where its joints move it by " + mm(pop.closest.blended) +
                   ": a shape, lattice or other deformer of the rig";
  finding.geometry["before_deg"] = pop.jump ? pop.closest.from : pop.from;
  finding.geometry["after_deg"] = pop.jump ? pop.closest.to : pop.to;
  finding.geometry["size_mm"] = 1000.0 * pop.whole;
  return finding;
}

}  // namespace

DeformerJudgement judge_deformers(const RigRecord& rig, const JudgeContext& context) {
  DeformerJudgement out;
  const ExternalRig* external = external_rig(*rig.system);
  if (!external || !external->gives_points()) return out;
  out.measured = true;
  const double limit =
      context.limits.of(kCode).value / 100.0 * context.stage.anatomy().spine_length;
  Coverage coverage{std::string(kCode), 0, 0, 0, 0};
  std::vector<Finding> compound;
  double sum = 0.0;
  Index count = 0;
  for (const SweepRecord& sweep : rig.sweeps) {
    poll_interrupt();
    ++coverage.planned;
    if (!std::ranges::all_of(sweep.poses, &PoseRecord::taken)) {
      ++coverage.not_applicable;
      continue;
    }
    // Nothing can be said of a rig that gives another surface when it is asked again.
    if (external->has_memory()) {
      ++coverage.not_measured;
      continue;
    }
    ++coverage.measured;
    const SweepSurface surface(rig, context, sweep);
    std::vector<double> controls;
    for (const PoseRecord& pose : sweep.poses) controls.push_back(pose.control_deg);
    std::vector<Surface> at_pose = surface.at(controls);
    for (Index i = 0; i < at_pose.size(); ++i) {
      for (Index v = 0; v < at_pose[i].offset.size(); ++v) {
        if (external->point_of_vertex()[v] < 0) continue;
        const double off = glm::length(glm::dvec3(at_pose[i].offset[v]));
        sum += off;
        ++count;
        if (off > out.blending.largest)
          out.blending = {off, 0.0, sweep.poses[i].body, static_cast<int>(v)};
      }
    }
    const bool alone = std::ranges::any_of(
        kBendChannels, [&](std::string_view channel) { return moves_alone(sweep.sweep, channel); });
    for (const Pop& pop : find_pops(surface, sweep, limit, std::move(at_pose)))
      (alone ? out.findings : compound).push_back(pop_finding(rig, context, sweep, pop));
  }
  out.blending.mean = count > 0 ? sum / static_cast<double>(count) : 0.0;
  // The pose of one control is easier to set than a compound that shows the same.
  const auto by_size = [](const Finding& a, const Finding& b) {
    if (a.inside_envelope != b.inside_envelope) return a.inside_envelope;
    return a.value > b.value;
  };
  std::ranges::stable_sort(out.findings, by_size);
  std::ranges::stable_sort(compound, by_size);
  std::ranges::move(compound, std::back_inserter(out.findings));
  out.coverage.push_back(std::move(coverage));
  return out;
}

void cut_headroom(const RigRecord& rig, const std::vector<Finding>& findings,
                  std::vector<Headroom>& headroom) {
  for (const Finding& finding : findings) {
    const SweepRecord* sweep = sweep_of(rig, finding);
    if (sweep == nullptr) continue;
    const double dirty_from = std::min(std::abs(finding.geometry.at("before_deg")),
                                       std::abs(finding.geometry.at("after_deg")));
    for (Headroom& each : headroom) {
      if (!moves_alone(sweep->sweep, each.channel)) continue;
      double clean = 0.0;
      for (const PoseRecord& pose : sweep->poses)
        if (std::abs(pose.control_deg) <= dirty_from)
          clean = std::max(clean, std::abs(pose.control_deg));
      each.clean_to_deg = std::min(each.clean_to_deg, clean);
    }
  }
}

std::string blending_text(const BlendingDistance& distance, double spine_length,
                          const std::string& place) {
  const auto mm = [](double metres) { return number_text(1000.0 * metres, 2) + " mm"; };
  std::string text = "LBS against your deformers: largest " + mm(distance.largest);
  if (distance.vertex >= 0)
    text += " at " + distance.pose.text() + (place.empty() ? "" : " (" + place + ")");
  return text + ", mean " + mm(distance.mean) +
         (distance.largest <= kTrustedBlending * spine_length
              ? ": alike"
              : ": what is measured on the mesh is measured on the rig's own points");
}

}  // namespace backbend::validate
