#include "validate/hunt/hunt.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <glm/trigonometric.hpp>

#include "skin/anatomy/body_kind.h"
#include "solver/rig/nearest_name.h"
#include "validate/calibrate/draw.h"
#include "validate/hunt/flip_hunt.h"
#include "validate/hunt/point_records.h"
#include "validate/hunt/pose_search.h"
#include "validate/judge/judge.h"
#include "validate/judge/owner.h"
#include "validate/judge/place.h"
#include "validate/live/external_rig.h"
#include "validate/sweeps/external_spec.h"
#include "validate/sweeps/named_pose.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

constexpr double kFlipShare = 0.15;   // of the evaluations: for following the gain
constexpr int kWidthHalvings = 6;     // of the last step across a fault's border
constexpr double kFirstWidth = 2e-3;  // of an axis
constexpr Index kSurfaceSamples = 96;
constexpr std::uint64_t kSampleStream = 7;  // of the draws: not those of the search

/// What a path shows and a pose alone does not.
bool is_of_a_path(MetricId metric) {
  return metric == MetricId::gain || metric == MetricId::predictability ||
         metric == MetricId::return_to_rest;
}

/// The body is too thick for the pose: its surface must fold, whatever the rig does.
bool is_infeasible(const PoseRecord& pose) { return pose.at(MetricId::feasibility).value >= 1.0; }

/// What a finding says beside the place on its path, which is only how it was confirmed.
std::string without_path(const std::string& detail) {
  if (const std::size_t at = detail.find(" at path "); at != std::string::npos)
    return detail.substr(0, at);
  if (!detail.starts_with("beyond the limit from path")) return detail;
  const std::size_t end = detail.find_first_of(";(");
  if (end == std::string::npos) return {};
  return detail.substr(detail.find_first_not_of("; ", end));
}

/// The metrics that the search climbs.
std::vector<const Metric*> objectives_of(const RigRecord& rig, const std::string& check) {
  std::vector<const Metric*> out;
  for (const Metric& metric : metric_table()) {
    const Check& row = metric.check();
    if (is_of_a_path(metric.id)) continue;
    // A flip margin leads to flips, whether it is asked for or not.
    const bool leads = metric.id == MetricId::flip_margin &&
                       (check.empty() || check == "BB001" || check == "BB002") &&
                       !rig.system->rest().flip_margin.empty();
    if (check.empty() ? row.decides || leads : row.code == check || leads) out.push_back(&metric);
  }
  return out;
}

/// What the chain does, and the points that a studio's rig gives beside it: rotations in degrees,
/// lengths in per cent of the spine. Smooth wherever the rig is.
std::vector<float> motion_of(const solver::SpinePose& pose, const solver::SpinePose& rest,
                             double length, const PosedCharacter* body) {
  std::vector<float> out;
  const auto add_turn = [&](const glm::dquat& below, const glm::dquat& turn) {
    glm::dquat q = glm::conjugate(below) * turn;
    if (q.w < 0.0) q = -q;
    for (const double part : {q.x, q.y, q.z})
      out.push_back(static_cast<float>(glm::degrees(2.0 * part)));
  };
  const auto add_shift = [&](const glm::dquat& frame, const glm::dvec3& shift) {
    const glm::dvec3 local = glm::conjugate(frame) * shift;
    for (int i = 0; i < 3; ++i) out.push_back(static_cast<float>(100.0 * local[i] / length));
  };
  for (Index j = 0; j < pose.turn.size(); ++j) {
    add_turn(j == 0 ? pose.hip.turn : pose.turn[j - 1], pose.turn[j]);
    if (j > 0) add_shift(pose.turn[j - 1], pose.position[j] - pose.position[j - 1]);
  }
  add_turn(pose.chest.turn, pose.arms.turn);
  add_shift(pose.chest.turn, pose.arms.posed_origin - pose.chest.apply(rest.arms.posed_origin));
  if (body != nullptr && body->blended) {
    const auto &own = body->mesh.position, &blended = body->blended->position;
    const Index stride = std::max<Index>(1, own.size() / kSurfaceSamples);
    for (Index v = 0; v < own.size(); v += stride)
      for (int i = 0; i < 3; ++i)
        out.push_back(static_cast<float>(100.0 * (own[v][i] - blended[v][i]) / length));
  }
  return out;
}

class Hunter {
 public:
  Hunter(const HuntScene& scene, const HuntSettings& settings,
         const std::function<void(Index)>& on_step)
      : scene_(scene), settings_(settings), on_step_(on_step), rig_(record({})) {
    if (const ExternalRig* external = external_rig(*rig_.system);
        external && external->has_memory())
      throw solver::RigError("rig '" + scene.plan.name +
                             "' remembers earlier poses: its poses cannot be searched one by one");
    at_rest_ = rig_at_rest(*rig_.system);
    objectives_ = objectives_of(rig_, settings.check);
    needs_mesh_ = std::ranges::any_of(
        objectives_, [](const Metric* metric) { return metric->check().subject == Subject::mesh; });
    needs_behaviour_ = std::ranges::any_of(objectives_, [](const Metric* metric) {
      return metric->id == MetricId::mirror || metric->id == MetricId::range_of_motion;
    });
    for (const Metric* each : objectives_)
      needs_crossing_ |= each->id == MetricId::self_intersection;
  }

  Hunt run() {
    const bool with_flips =
        settings_.check.empty() || settings_.check == "BB001" || settings_.check == "BB002";
    const Index for_flips = with_flips ? evaluations_for_flips() : 0;
    const SearchOutcome outcome = search_box(settings_.evaluations - for_flips);
    if (with_flips) find_jumps(outcome, for_flips);
    take_worst(outcome);
    std::ranges::stable_sort(hunt_.finds, [](const HuntFind& a, const HuntFind& b) {
      const auto rank = [](const HuntFind& find) {
        return std::pair(!find.finding.inside_envelope, find.finding.verdict != Verdict::fail);
      };
      if (rank(a) != rank(b)) return rank(a) < rank(b);
      const auto by = [](const Finding& f) {
        return excess(*find_check(f.code), f.value, f.limit);
      };
      return by(a.finding) > by(b.finding);
    });
    return std::move(hunt_);
  }

  BoxSearch look_around() {
    const Index for_flips = evaluations_for_flips();
    const SearchOutcome outcome = search_box(settings_.evaluations - for_flips);
    BoxSearch out;
    if (for_flips > 0) {
      FlipHunt flips = flip_hunt(for_flips);
      out.jumps = flips.paths(outcome.suspects, least_margin(outcome));
      hunt_.evaluations += flips.spent();
    }
    for (Index k = 0; k < objectives_.size(); ++k) {
      const Check& check = objectives_[k]->check();
      if (!check.decides || !outcome.worst[k]) continue;
      const PoseDegrees pose =
          in_file_digits(hunt_.box.pose_at(outcome.points[*outcome.worst[k]].at));
      if (pose_words(pose) == "rest") continue;
      out.worst.push_back({std::string(check.code), worst_[k].value, worst_[k].limit, pose});
    }
    std::ranges::sort(out.worst, {}, &HuntWorst::code);
    out.box = std::move(hunt_.box);
    out.evaluations = hunt_.evaluations;
    out.samples = std::move(samples_);
    out.gap_volume = hunt_.gap_volume;
    out.notes = std::move(hunt_.notes);
    return out;
  }

 private:
  /// What is held back from the poses that follow the samples.
  Index evaluations_for_flips() const {
    return static_cast<Index>(kFlipShare *
                              static_cast<double>(settings_.evaluations - settings_.samples));
  }

  SearchOutcome search_box(Index evaluations) {
    hunt_.box = settings_.box;
    drop_axes_that_are_not_taken();
    worst_.resize(objectives_.size());
    SearchSettings search_settings;
    search_settings.axes = hunt_.box.axes.size();
    search_settings.objectives = objectives_.size();
    search_settings.evaluations = evaluations;
    search_settings.seed = settings_.seed;
    search_settings.origin = hunt_.box.point_of({});
    Draw draw(settings_.seed, kSampleStream);
    for (Index n = 0; n < settings_.samples; ++n) {
      std::vector<double>& point = search_settings.first.emplace_back();
      for (Index a = 0; a < search_settings.axes; ++a) point.push_back(draw.uniform(0.0, 1.0));
    }
    SearchOutcome outcome = search(search_settings, [&](std::span<SearchPoint> points) {
      look(points);
      on_step_(points.size());
    });
    hunt_.evaluations = outcome.points.size();
    const SearchGap gap = largest_gap(search_settings.axes, outcome.points);
    hunt_.gap = gap.radius;
    hunt_.gap_volume = gap.share;
    return outcome;
  }

  /// The rig's record over some sweeps, nothing of it measured.
  RigRecord record(const std::vector<Sweep>& sweeps) const {
    RigRecord rig =
        plan_rig(scene_.stage, scene_.body, scene_.plan, scene_.mapping, sweeps, scene_.envelope);
    if (scene_.build) {
      rig.system = scene_.build();
      rig.in_plane.reset();  // of another system
    }
    return rig;
  }

  void drop_axes_that_are_not_taken() {
    std::erase_if(hunt_.box.axes, [&](const BoxAxis& axis) {
      ControlBox only{"", {axis}, {}};
      for (const double end : {0.0, 1.0}) {
        const std::string why =
            why_not_taken(*rig_.system, only.pose_at(std::array<double, 1>{end}));
        if (why.empty()) continue;
        hunt_.notes.push_back("not searched: " + why);
        return true;
      }
      return false;
    });
    if (hunt_.box.axes.empty())
      throw solver::RigError("rig '" + scene_.plan.name + "' takes no channel of the box");
  }

  PoseRecord planned(const PoseDegrees& body) const {
    PoseRecord pose;
    pose.body = body;
    pose.inside = scene_.envelope.contains(body);
    pose.control = controls_at(*rig_.system, body, rig_.mapping);
    return pose;
  }

  /// Measures points, or takes them from the ledger, where a stopped hunt of the same question
  /// asked for the same ones.
  void look(std::span<SearchPoint> points) {
    poll_interrupt();
    const std::string unit = "hunted " + std::to_string(looks_++);
    if (settings_.ledger != nullptr)
      if (const auto found = settings_.ledger->find(unit); found && unpack_points(*found, points))
        return;
    measure_points(points);
    if (settings_.ledger != nullptr) settings_.ledger->keep(unit, pack_points(points));
  }

  void measure_points(std::span<SearchPoint> points) {
    const double length = chain_length(rig_.system->rest().position);
    std::vector<PoseRecord> poses;
    std::vector<std::vector<double>> controls;
    for (const SearchPoint& point : points) {
      poses.push_back(planned(hunt_.box.pose_at(point.at)));
      controls.push_back(poses.back().control);
    }
    rig_.system->prepare(controls, solver::Detail::all);
    oneapi::tbb::parallel_for(Index{0}, points.size(), [&](Index i) {
      PoseRecord& pose = poses[i];
      if (needs_mesh_) {
        const PosedCharacter posed = scene_.stage.pose(*rig_.system, pose.control);
        measure_pose(scene_.body, at_rest_, posed, pose,
                     needs_crossing_ ? Crossing::measured : Crossing::left_out);
        pose.bounds = scene_.stage.bounds(posed.mesh);
        points[i].motion = motion_of(posed.spine, rig_.system->rest(), length, &posed);
      } else {
        points[i].motion =
            motion_of(measure_chain_pose(at_rest_, pose), rig_.system->rest(), length, nullptr);
      }
      if (needs_behaviour_ && pose.at(MetricId::non_finite).value == 0.0)
        measure_pose_behaviour(scene_.stage, rig_, pose);
      points[i].badness = badness_of(pose);
    });
    for (Index i = 0; i < points.size(); ++i)
      for (Index k = 0; k < objectives_.size(); ++k) {
        const double badness = points[i].badness[k];
        if (!std::isfinite(badness) || !(badness > worst_[k].badness)) continue;
        const Metric& metric = *objectives_[k];
        worst_[k] = {badness, poses[i].at(metric.id).value,
                     limit_at(metric.code, scene_.limits.of(metric.code).value,
                              compound_load(scene_.envelope, poses[i].body))};
      }
    // They are the first that are looked at, all at once.
    if (settings_.samples > 0 && samples_.empty()) {
      assert(points.size() == settings_.samples);
      samples_ = std::move(poses);
    }
  }

  std::vector<double> badness_of(const PoseRecord& pose) const {
    const double load = compound_load(scene_.envelope, pose.body);
    std::vector<double> out;
    for (const Metric* metric : objectives_) {
      const Check& check = metric->check();
      double value = std::numeric_limits<double>::quiet_NaN();
      if (is_applicable(rig_, *metric, pose) && std::isfinite(pose.at(metric->id).value)) {
        value = excess(check, pose.at(metric->id).value,
                       limit_at(check.code, scene_.limits.of(check.code).value, load));
        if (is_infeasible(pose) && check.subject == Subject::mesh &&
            metric->id != MetricId::feasibility)
          value = std::numeric_limits<double>::quiet_NaN();
      }
      out.push_back(value);
    }
    return out;
  }

  /// What `check` says of the last pose of a sweep, or of the jumps on it.
  std::vector<Finding> judged(const Sweep& sweep, RigRecord* keep = nullptr) {
    RigRecord rig = record({sweep});
    const RigAtRest at_rest = rig_at_rest(*rig.system);
    Progress silent(Progress::Style::none);
    std::vector<PoseRecord>& poses = rig.sweeps.front().poses;
    const std::vector<PoseRecord> last(poses.end() - 1, poses.end());
    poses = last;
    measure_poses(scene_.stage, scene_.body, rig, at_rest, poses, silent);
    measure_behaviour(scene_.stage, rig);
    take_flips(rig.sweeps.front(), search_flips(rig, sweep));
    hunt_.confirmations += 1 + rig.sweeps.front().flips.samples;
    const JudgeContext context{scene_.stage, scene_.limits, scene_.envelope, scene_.character};
    std::vector<Finding> findings = judge_rig(rig, context);
    book_owners(scene_.stage, scene_.body, rig, true, findings);
    const PlaceNames places(scene_.stage.character(), scene_.stage.anatomy(), &scene_.body);
    for (Finding& finding : findings) {
      if (is_external(scene_.plan.spec) && finding.owner == Owner::solver)
        finding.owner = Owner::rig;
      finding.detail = without_path(finding.detail);
      places.name(finding.slice >= 0
                      ? scene_.stage.pose(*rig.system, poses.front().control).mesh.position
                      : std::vector<glm::vec3>{},
                  finding);
    }
    if (keep != nullptr) *keep = std::move(rig);
    return findings;
  }

  std::vector<std::pair<std::string, double>> controls_of(const PoseDegrees& body) const {
    const std::vector<double> value = controls_at(*rig_.system, body, rig_.mapping);
    std::vector<std::pair<std::string, double>> out;
    for (Index c = 0; c < value.size(); ++c) {
      const solver::Channel& channel = rig_.system->channels()[c];
      if (value[c] == channel.rest) continue;
      out.emplace_back(channel.name, channel.kind == solver::Channel::Kind::rotation
                                         ? glm::degrees(value[c])
                                         : value[c]);
    }
    return out;
  }

  /// The worst pose of each objective, and where it fails a find.
  void take_worst(const SearchOutcome& outcome) {
    for (Index k = 0; k < objectives_.size(); ++k) {
      const Metric& metric = *objectives_[k];
      const std::string code(metric.code);
      if (!outcome.worst[k]) {
        hunt_.notes.push_back(code + " does not apply, or was not measured, at any pose");
        continue;
      }
      const SearchPoint& point = outcome.points[*outcome.worst[k]];
      const PoseDegrees pose = in_file_digits(hunt_.box.pose_at(point.at));
      if (pose.text() == "rest") continue;  // nothing leads there, and it is measured at its file
      const Sweep sweep = named_pose("hunt", {}, pose);
      RigRecord rig;
      const std::vector<Finding> findings = judged(sweep, &rig);
      const PoseRecord& measured = rig.sweeps.front().poses.front();
      const double limit =
          limit_at(code, scene_.limits.of(code).value, compound_load(scene_.envelope, pose));
      hunt_.worst.push_back({code, measured.at(metric.id).value, limit, pose});
      const auto found = std::ranges::find(findings, code, &Finding::code);
      const bool leads_only = metric.id == MetricId::flip_margin && settings_.check != code;
      if (leads_only) continue;
      HuntFind find;
      if (found != findings.end()) {
        find.finding = *found;
      } else {
        // A check that never decides has no finding; a user who asks for it is told all the same.
        const Check& check = *find_check(code);
        if (settings_.check != code || check.decides ||
            judge(check, hunt_.worst.back().value, limit) != Verdict::fail)
          continue;
        find.finding =
            start_finding(rig, {scene_.stage, scene_.limits, scene_.envelope, scene_.character},
                          rig.sweeps.front(), code, pose, sweep.to_deg);
        find.finding.value = hunt_.worst.back().value;
        find.finding.limit = limit;
        find.finding.verdict = Verdict::stress;
        find.finding.detail = "advisory: it decides nothing by itself";
        set_place(metric, measured.at(metric.id).place, rig_.system->joint_names(), find.finding);
      }
      find.pose = pose;
      find.controls = controls_of(pose);
      measure_width(k, point.at, find);
      hunt_.finds.push_back(std::move(find));
    }
    std::ranges::sort(hunt_.worst, {}, &HuntWorst::code);
  }

  /// How far along each axis, both ways from a pose, an objective goes on failing.
  void measure_width(Index objective, const std::vector<double>& at, HuntFind& find) {
    struct Side {
      Index axis;
      double direction, good = 0.0, bad = 0.0;  // offsets: fails up to `bad`, not at `good`
      bool open = true;                         // no place that passes was met yet
      bool at_box = false;
    };
    std::vector<Side> sides;
    for (Index a = 0; a < at.size(); ++a)
      for (const double direction : {-1.0, 1.0}) sides.push_back({a, direction});
    const auto room = [&](const Side& side) {
      return side.direction > 0.0 ? 1.0 - at[side.axis] : at[side.axis];
    };
    double step = kFirstWidth;
    for (int round = 0, halvings = 0; halvings < kWidthHalvings; ++round) {
      std::vector<SearchPoint> points;
      std::vector<Side*> asked;
      std::vector<double> offset;
      bool any_open = false;
      for (Side& side : sides) {
        if (side.at_box) continue;
        double to = 0.5 * (side.bad + side.good);
        if (side.open) {
          to = std::min(step, room(side));
          any_open = true;
          if (to <= side.bad) {
            side.at_box = true;
            continue;
          }
        }
        std::vector<double> p = at;
        p[side.axis] += side.direction * to;
        points.push_back({std::move(p), {}, {}});
        asked.push_back(&side);
        offset.push_back(to);
      }
      if (points.empty()) break;
      look(points);
      hunt_.confirmations += points.size();
      for (Index i = 0; i < asked.size(); ++i) {
        Side& side = *asked[i];
        const bool fails = points[i].badness[objective] > 1.0;
        if (fails) {
          side.bad = offset[i];
        } else {
          side.good = offset[i];
          side.open = false;
        }
      }
      step *= 2.0;
      if (!any_open) ++halvings;
    }
    for (Index a = 0; a < at.size(); ++a) {
      double width = 0.0;
      bool at_box = false;
      for (const Side& side : sides)
        if (side.axis == a) {
          width += side.bad;
          at_box |= side.at_box;
        }
      find.width_deg[hunt_.box.axes[a].name] = width * hunt_.box.axes[a].width();
      if (at_box) find.ends_at_box.push_back(hunt_.box.axes[a].name);
    }
  }

  std::optional<std::vector<double>> least_margin(const SearchOutcome& outcome) const {
    for (Index k = 0; k < objectives_.size(); ++k)
      if (objectives_[k]->id == MetricId::flip_margin && outcome.worst[k])
        return outcome.points[*outcome.worst[k]].at;
    return std::nullopt;
  }

  FlipHunt flip_hunt(Index evaluations) const {
    return {*rig_.system, rig_.mapping, hunt_.box, scene_.limits.of("BB002").value, evaluations};
  }

  void find_jumps(const SearchOutcome& outcome, Index evaluations) {
    FlipHunt flips = flip_hunt(evaluations);
    const std::vector<FlipPath> paths = flips.paths(outcome.suspects, least_margin(outcome));
    hunt_.evaluations += flips.spent();
    std::vector<HuntFind> found;
    for (const FlipPath& path : paths) {
      poll_interrupt();
      if (found.size() == kMostFlips) break;
      RigRecord rig;
      std::vector<Finding> findings = judged(named_pose("hunt", path.from, path.to), &rig);
      std::erase_if(findings, [&](const Finding& f) {
        return (f.code != "BB001" && f.code != "BB002") ||
               (!settings_.check.empty() && f.code != settings_.check);
      });
      if (findings.empty()) continue;
      HuntFind find;
      find.finding = findings.front();
      find.from = path.from;
      find.pose = path.to;
      const bool known = std::ranges::any_of(found, [&](const HuntFind& other) {
        return other.finding.code == find.finding.code &&
               other.finding.joint == find.finding.joint && near(other.pose, find.pose);
      });
      if (known) continue;
      find.controls = controls_of(find.pose);
      flips.measure_width(path, find.finding.code == "BB001", find.width_deg);
      found.push_back(std::move(find));
    }
    hunt_.confirmations += flips.confirmations();
    std::ranges::move(found, std::back_inserter(hunt_.finds));
  }

  /// Whether two poses are within a tenth of the box of each other.
  bool near(const PoseDegrees& a, const PoseDegrees& b) const {
    const std::vector<double> p = hunt_.box.point_of(a), q = hunt_.box.point_of(b);
    for (Index i = 0; i < p.size(); ++i)
      if (std::abs(p[i] - q[i]) > 0.1) return false;
    return true;
  }

  static constexpr Index kMostFlips = 5;

  const HuntScene& scene_;
  const HuntSettings& settings_;
  const std::function<void(Index)>& on_step_;
  RigRecord rig_;
  RigAtRest at_rest_{};
  std::vector<const Metric*> objectives_;
  struct Seen {
    double badness = -std::numeric_limits<double>::infinity(), value = 0.0, limit = 0.0;
  };
  std::vector<Seen> worst_;          // by objective, of all that was measured in this process
  std::vector<PoseRecord> samples_;  // the poses that were drawn
  Index looks_ = 0;
  bool needs_mesh_ = false, needs_behaviour_ = false, needs_crossing_ = false;
  Hunt hunt_;
};

}  // namespace

std::vector<std::string> huntable_checks() {
  std::vector<std::string> codes{"BB001", "BB002"};
  for (const Metric& metric : metric_table())
    if (!is_of_a_path(metric.id)) codes.emplace_back(metric.code);
  std::ranges::sort(codes);
  return codes;
}

Hunt hunt_poses(const HuntScene& scene, const HuntSettings& settings, Progress& progress) {
  progress.start("hunt", settings.evaluations);
  const std::function<void(Index)> on_step = [&](Index count) { progress.step(count); };
  Hunt hunt = Hunter(scene, settings, on_step).run();
  progress.finish();
  return hunt;
}

BoxSearch search_poses(const HuntScene& scene, const HuntSettings& settings,
                       const std::function<void(std::size_t)>& on_step) {
  return Hunter(scene, settings, on_step).look_around();
}

}  // namespace backbend::validate
