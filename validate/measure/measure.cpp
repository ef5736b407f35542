#include "validate/measure/measure.h"

#include <oneapi/tbb/parallel_for.h>

#include <cmath>
#include <glm/trigonometric.hpp>

#include "validate/live/external_rig.h"
#include "validate/metrics/chain/human_range.h"
#include "validate/metrics/chain/rig_probe.h"
#include "validate/sweeps/external_spec.h"

namespace backbend::validate {
namespace {

void record_chain(const solver::SpineSystem& system, const solver::SpinePose& pose,
                  const ChainMeasures& chain, PoseRecord& record) {
  record.at(MetricId::non_finite) = {chain.finite ? 0.0 : 1.0, -1};
  if (!chain.finite) return;
  record.arms = chain.arms;
  for (const Metric& metric : metric_table())
    if (metric.from_chain != nullptr)
      record.at(metric.id) = metric.from_chain({system, pose, chain});
}

void record_mesh(const BodyReading& reading, PoseRecord& record) {
  const MeshMeasures& surface = reading.pose.surface;
  if (surface.not_finite > 0) {
    record.at(MetricId::non_finite).value += static_cast<double>(surface.not_finite);
    return;
  }
  for (const Metric& metric : metric_table())
    if (metric.from_body != nullptr) record.at(metric.id) = metric.from_body(reading);
}

std::vector<PoseRecord> plan_poses(const solver::SpineSystem& system, solver::Mapping mapping,
                                   const Sweep& sweep, const Envelope& envelope) {
  std::vector<PoseRecord> poses(sweep.pose_count());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i].control_deg = sweep.control_at(i);
    poses[i].body = sweep.pose_at(poses[i].control_deg);
    poses[i].inside = envelope.contains(poses[i].body);
    poses[i].taken = why_not_taken(system, poses[i].body).empty();
    poses[i].control = controls_at(system, poses[i].body, mapping);
  }
  return poses;
}

/// The gain of a pose is that of the faster of its two intervals.
void record_gain(SweepRecord& record) {
  const std::vector<double>& gain = record.flips.interval_gain;
  for (std::size_t i = 0; i < record.poses.size(); ++i) {
    double value = std::numeric_limits<double>::quiet_NaN();
    if (i > 0 && i - 1 < gain.size()) value = gain[i - 1];
    if (i < gain.size()) value = std::isnan(value) ? gain[i] : std::max(value, gain[i]);
    record.poses[i].at(MetricId::gain) = {value, -1};
  }
}

/// How much of the back, from the sacrum to the first thoracic vertebra, the driven chain is: it
/// ends where the arms hang, below the base of the neck.
double share_of_back(const Stage& stage) {
  const skin::Anatomy& anatomy = stage.anatomy();
  double driven = 0.0, back = 0.0;
  for (std::size_t k = 1; k <= std::max(anatomy.chest_index, anatomy.neck_index); ++k) {
    const auto at = [&](std::size_t joint) {
      return glm::dvec3(stage.character()
                            .nodes[static_cast<std::size_t>(anatomy.spine[joint])]
                            .world_from_node[3]);
    };
    back += glm::distance(at(k - 1), at(k));
    if (k == anatomy.chest_index) driven = back;
  }
  return back > 0.0 ? driven / back : 1.0;
}

/// What is left when every control is back at rest. A system remembers nothing, so one solve says
/// it for the whole rig.
Measured return_to_rest(const solver::SpineSystem& system) {
  const solver::SpinePose& rest = system.rest();
  std::vector<double> neutral;
  for (const solver::Channel& channel : system.channels()) neutral.push_back(channel.rest);
  const PoseDifference left_over =
      pose_difference(system.solve(neutral), rest, chain_length(rest.position));
  return {100.0 * left_over.shift, left_over.joint};
}

/// The pose that a rig's return to rest is noted at: the first that it can take, inside the
/// envelope if one is.
PoseRecord* pose_for_rest(RigRecord& rig) {
  PoseRecord* found = nullptr;
  for (SweepRecord& sweep : rig.sweeps)
    for (PoseRecord& pose : sweep.poses)
      if (pose.taken && (found == nullptr || (pose.inside && !found->inside))) found = &pose;
  return found;
}

/// How far the axis about which the chain's end turns strays from that of the chest control. Of a
/// pose: the worse of the two intervals that it ends.
void record_predictability(const solver::SpineSystem& system, SweepRecord& sweep) {
  std::vector<solver::SpinePose> pose;
  for (const PoseRecord& record : sweep.poses) pose.push_back(system.solve(record.control));
  std::vector<double> stray;
  for (std::size_t i = 1; i < pose.size(); ++i) {
    stray.push_back(response(pose[i - 1].chest.turn, pose[i].chest.turn, pose[i - 1].turn.back(),
                             pose[i].turn.back())
                        .axis_deg);
  }
  for (std::size_t i = 0; i < pose.size() && !stray.empty(); ++i) {
    const double before = stray[i > 0 ? i - 1 : 0], after = stray[std::min(i, stray.size() - 1)];
    // Not std::max: NaN must be kept.
    const double worse = before >= after || std::isnan(before) ? before : after;
    sweep.poses[i].at(MetricId::predictability) = {worse, -1};
  }
}

constexpr double kInPlane = 1e-9;  // of the chain's length: rounding of a symmetric file

/// RigRecord::in_plane of a rig on a character.
std::unique_ptr<solver::SpineSystem> build_in_plane(const Stage& stage,
                                                    const solver::SystemSpec& spec) {
  if (is_external(spec)) return nullptr;
  solver::RestChain chain = stage.rest_chain();
  const glm::dvec3 left = stage.anatomy().left, origin = chain.joint.front();
  double off = 0.0;
  for (glm::dvec3& p : chain.joint) {
    const double aside = glm::dot(p - origin, left);
    off = std::max(off, std::abs(aside));
    p -= aside * left;
  }
  if (off <= kInPlane * chain_length(stage.rest_chain().joint)) return nullptr;
  try {
    return solver::build_system(spec, chain);
  } catch (const solver::RigError&) {
    return nullptr;  // a spine that lies across: flat, its bones have no length
  }
}

RigRecord start(const Stage& stage, const RigPlan& plan, solver::Mapping mapping,
                const std::vector<Sweep>& sweeps, const Envelope& envelope) {
  RigRecord rig;
  rig.plan = plan;
  rig.mapping = mapping;
  rig.system = stage.build(plan.spec);
  rig.in_plane = build_in_plane(stage, plan.spec);
  for (const Sweep& sweep : sweeps) {
    SweepRecord record;
    record.sweep = sweep;
    record.poses = plan_poses(*rig.system, mapping, sweep, envelope);
    rig.sweeps.push_back(std::move(record));
  }
  if (PoseRecord* pose = pose_for_rest(rig)) pose->rest_noted = true;
  return rig;
}

void measure_flips(RigRecord& rig) {
  oneapi::tbb::parallel_for(std::size_t{0}, rig.sweeps.size(), [&](std::size_t i) {
    take_flips(rig.sweeps[i], search_flips(rig, rig.sweeps[i].sweep));
  });
}

}  // namespace

void measure_pose_behaviour(const Stage& stage, const RigRecord& rig, PoseRecord& record) {
  const solver::SpineSystem& system = *rig.system;
  const solver::SpinePose& rest = system.rest();
  const double length = chain_length(rest.position);
  const glm::dvec3 left = stage.anatomy().left;
  const solver::SpinePose pose = system.solve(record.control);

  PoseDegrees other_side = record.body;
  other_side.side = -other_side.side;
  other_side.twist = -other_side.twist;
  const auto asymmetry = [&](const solver::SpineSystem& of, const solver::SpinePose& here) {
    const solver::SpinePose image = of.solve(controls_at(of, other_side, rig.mapping));
    return pose_difference(here, mirrored(image, left, rest.position.front()), length);
  };
  const PoseDifference off = asymmetry(system, pose);
  // A rest spine off its middle plane is off it in the pose and in the mirror image, and a bend
  // increases the difference. Solved on the spine laid into the plane, the rig shows what is its
  // own.
  const double own =
      pose_difference(rest, mirrored(rest, left, rest.position.front()), length).shift;
  Measured mirror{std::max(0.0, off.shift - 2.0 * own), off.joint};
  if (mirror.value > 0.0 && rig.in_plane) {
    const PoseDifference flat = asymmetry(*rig.in_plane, rig.in_plane->solve(record.control));
    if (flat.shift < mirror.value) mirror = {flat.shift, flat.joint};
  }
  record.at(MetricId::mirror) = {100.0 * mirror.value, mirror.place};

  std::vector<double> level = system.arc_fraction();
  for (double& l : level) l *= share_of_back(stage);
  const RangeUse use = human_range_use(pose, rest, level, left);
  record.at(MetricId::range_of_motion) = {use.ratio, use.joint};
}

void measure_behaviour(const Stage& stage, RigRecord& rig) {
  const Measured left_over = return_to_rest(*rig.system);
  oneapi::tbb::parallel_for(std::size_t{0}, rig.sweeps.size(), [&](std::size_t s) {
    SweepRecord& sweep = rig.sweeps[s];
    for (PoseRecord& pose : sweep.poses)
      if (pose.rest_noted) pose.at(MetricId::return_to_rest) = left_over;
    oneapi::tbb::parallel_for(std::size_t{0}, sweep.poses.size(), [&](std::size_t i) {
      if (sweep.poses[i].at(MetricId::non_finite).value == 0.0)
        measure_pose_behaviour(stage, rig, sweep.poses[i]);
    });
    record_predictability(*rig.system, sweep);
  });
}

std::vector<double> controls_at(const solver::SpineSystem& system, const PoseDegrees& pose,
                                solver::Mapping mapping) {
  return system.controls_for(pose.radians(), mapping);
}

/// A program takes milliseconds a pose, and a path along its singular poses jumps everywhere.
constexpr std::size_t kMostAsked = 20'000;

FlipReport search_flips(const RigRecord& rig, const Sweep& sweep) {
  if (const ExternalRig* external = external_rig(*rig.system); external && external->has_memory()) {
    FlipReport none;  // every pose would be a jump: nothing can be said
    none.certified = false;
    return none;
  }
  const double span = sweep.to_deg - sweep.from_deg;
  const auto path = [&](double t) {
    return controls_at(*rig.system, sweep.pose_at(sweep.from_deg + span * t), rig.mapping);
  };
  const int intervals = static_cast<int>(sweep.pose_count()) - 1;
  prepare_search(*rig.system, path, intervals);
  FlipSettings settings = flip_settings(*rig.system, intervals, std::abs(span));
  if (external_rig(*rig.system) != nullptr) settings.budget = kMostAsked;
  return find_flips(probe(*rig.system, path), settings);
}

void take_flips(SweepRecord& record, FlipReport flips) {
  record.flips = std::move(flips);
  record_gain(record);
}

solver::SpinePose measure_chain_pose(const RigAtRest& rig, PoseRecord& record) {
  const solver::SpineSystem& system = *rig.system;
  solver::SpinePose pose = system.solve(record.control);
  const auto intended = system.intended_curve(record.control, kCurvePoints);
  record_chain(system, pose,
               measure_chain({pose, system.rest(), intended, rig.curve, record.body.twist,
                              asked_length(rig, intended, record.body.stretch != 0.0)}),
               record);
  return pose;
}

RigRecord measure_chain_only(const Stage& stage, const RigPlan& plan, solver::Mapping mapping,
                             const std::vector<Sweep>& sweeps, const Envelope& envelope) {
  RigRecord rig = start(stage, plan, mapping, sweeps, envelope);
  const RigAtRest at_rest = rig_at_rest(*rig.system);
  for (SweepRecord& sweep : rig.sweeps) {
    for (PoseRecord& record : sweep.poses) {
      measure_chain_pose(at_rest, record);
    }
  }
  measure_behaviour(stage, rig);
  measure_flips(rig);
  return rig;
}

void measure_pose(const BodyMetrics& body, const RigAtRest& rig, const PosedCharacter& posed,
                  PoseRecord& record, Crossing crossing) {
  const BodyMeasures measures =
      body.measure(rig, record.control, posed.spine, posed.mesh, glm::radians(record.body.twist),
                   record.body.stretch != 0.0, crossing, posed.world_from_node,
                   posed.blended ? Deformers::added : Deformers::none);
  record_chain(*rig.system, posed.spine, measures.chain, record);
  record_mesh({body, measures}, record);
}

RigRecord plan_rig(const Stage& stage, const BodyMetrics& body, const RigPlan& plan,
                   solver::Mapping mapping, const std::vector<Sweep>& sweeps,
                   const Envelope& envelope) {
  RigRecord rig = start(stage, plan, mapping, sweeps, envelope);
  rig.has_mesh = true;
  rig.surface = body.scope();
  const ExternalRig* external = external_rig(*rig.system);
  rig.has_arms = stage.driver().arms_follow_chest() && (!external || external->moves_arms());
  return rig;
}

void measure_poses(const Stage& stage, const BodyMetrics& body, const RigRecord& rig,
                   const RigAtRest& at_rest, std::span<PoseRecord> poses, Progress& progress) {
  std::vector<std::vector<double>> controls;
  for (const PoseRecord& pose : poses) controls.push_back(pose.control);
  rig.system->prepare(controls, solver::Detail::all);
  oneapi::tbb::parallel_for(std::size_t{0}, poses.size(), [&](std::size_t i) {
    const PosedCharacter posed = stage.pose(*rig.system, poses[i].control);
    measure_pose(body, at_rest, posed, poses[i]);
    poses[i].bounds = stage.bounds(posed.mesh);
    progress.step();
  });
}

RigRecord measure_rig(const Stage& stage, const BodyMetrics& body, const RigPlan& plan,
                      solver::Mapping mapping, const std::vector<Sweep>& sweeps,
                      const Envelope& envelope, Progress& progress) {
  RigRecord rig = plan_rig(stage, body, plan, mapping, sweeps, envelope);
  const RigAtRest at_rest = rig_at_rest(*rig.system);
  for (SweepRecord& sweep : rig.sweeps) {
    poll_interrupt();
    measure_poses(stage, body, rig, at_rest, sweep.poses, progress);
  }
  measure_behaviour(stage, rig);
  measure_flips(rig);
  return rig;
}

}  // namespace backbend::validate
