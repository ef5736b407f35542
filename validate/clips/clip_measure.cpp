#include "validate/clips/clip_measure.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "skin/matrix_facts.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;
using skin::origin;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
// A clavicle that turns by less than this over a whole clip was not animated: float files round a
// hundredth of it.
constexpr double kAnimatedDeg = 0.05;

/// The nearest spine joint that a node hangs from, -1 for none.
int spine_above(const skin::Character& character, const skin::Anatomy& anatomy, int node) {
  for (node = character.nodes[static_cast<Index>(node)].parent; node >= 0;
       node = character.nodes[static_cast<Index>(node)].parent)
    if (std::find(anatomy.spine.begin(), anatomy.spine.end(), node) != anatomy.spine.end())
      return node;
  return -1;
}

std::vector<int> arm_roots(const skin::Anatomy& anatomy) {
  std::vector<int> roots;
  for (const auto* arm : {&anatomy.left_arm, &anatomy.right_arm})
    if (!arm->empty()) roots.push_back(arm->front());
  return roots;
}

std::vector<double> times_of(const skin::Clip& clip, const skin::ClipSweep& range) {
  const auto begin = clip.time.begin() + static_cast<std::ptrdiff_t>(range.first);
  return {begin, begin + static_cast<std::ptrdiff_t>(range.count)};
}

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The control that moves furthest over a sweep: what its frames are named by.
int leading_control(const skin::Clip& clip, const skin::ClipSweep& range) {
  int best = -1;
  double widest = 0.0;
  for (Index c = 0; c < clip.control.size(); ++c) {
    double low = kNan, high = kNan;
    for (Index f = range.first; f < range.first + range.count; ++f) {
      const double value = clip.control_value[f * clip.control.size() + c];
      low = std::fmin(low, value);
      high = std::fmax(high, value);
    }
    if (high - low > widest) {
      widest = high - low;
      best = static_cast<int>(c);
    }
  }
  return best;
}

class ArmMeasures {
 public:
  ArmMeasures(const skin::Character& character, const skin::Anatomy& anatomy, const ClipBody& body)
      : character_(character), anatomy_(anatomy), body_(body) {
    for (const int root : arm_roots(anatomy))
      if (spine_above(character, anatomy, root) >= 0) roots_.push_back(root);
  }

  bool any() const { return !roots_.empty(); }

  bool clavicles_rest() const {
    for (const int root : roots_) {
      const int parent = character_.nodes[static_cast<Index>(root)].parent;
      glm::dquat first(1, 0, 0, 0);
      for (Index f = 0; f < body_.frame_count(); ++f) {
        const glm::dquat turn = glm::conjugate(body_.turn(f, parent)) * body_.turn(f, root);
        if (f == 0) first = turn;
        if (!(degrees(angle_between(first, turn)) <= kAnimatedDeg)) return false;
      }
    }
    return true;
  }

  void measure(const skin::ClipSweep& range, const std::vector<double>& time, bool drift,
               std::vector<PoseRecord>& poses) const {
    for (const int root : roots_) {
      const int carrier = spine_above(character_, anatomy_, root);
      std::vector<glm::dvec3> path;
      // Against the clip's first frame: a pose that the clip holds throughout is no drift.
      const glm::dquat held = glm::conjugate(body_.turn(0, carrier)) * body_.turn(0, root);
      for (Index i = 0; i < range.count; ++i) {
        const Index f = range.first + i;
        const std::vector<glm::dmat4>& world = body_.world_from_node(f);
        const glm::dquat chest = body_.turn(f, carrier);
        path.push_back(glm::conjugate(chest) * (origin(world[static_cast<Index>(root)]) -
                                                origin(world[static_cast<Index>(carrier)])));
        if (drift) {
          const double deg = degrees(angle_between(chest * held, body_.turn(f, root)));
          Measured& value = poses[i].at(MetricId::arm_drift);
          if (!(deg <= value.value)) value.value = deg;
        }
      }
      const std::vector<double> pops = path_pops(path, time);
      for (Index i = 0; i < range.count; ++i) {
        Measured& value = poses[i].at(MetricId::arm_shift);
        const double percent = 100.0 * pops[i] / anatomy_.spine_length;
        if (!(percent <= value.value)) value.value = percent;
      }
    }
  }

 private:
  const skin::Character& character_;
  const skin::Anatomy& anatomy_;
  const ClipBody& body_;
  std::vector<int> roots_;
};

void measure_frame(const ClipBody& body, const ClipSystem& system, const RigAtRest& at_rest,
                   const BodyMetrics* metrics, Index frame, PoseRecord& record) {
  record.control = {static_cast<double>(frame)};
  record.body.twist = system.twist_deg(frame);
  const solver::SpinePose& pose = system.pose(frame);
  if (metrics != nullptr) {
    PosedCharacter posed;
    posed.spine = pose;
    posed.mesh = body.mesh(frame);
    measure_pose(*metrics, at_rest, posed, record);
  } else {
    const auto curve = system.intended_curve(record.control, kCurvePoints);
    const ChainMeasures chain =
        measure_chain({pose, system.rest(), curve, at_rest.curve, record.body.twist});
    record.at(MetricId::non_finite) = {chain.finite ? 0.0 : 1.0, -1};
    if (chain.finite) {
      record.at(MetricId::uneven_twist) = {chain.uneven_twist, -1};
      record.at(MetricId::uneven_bend) = {chain.max_over_mean, chain.max_turn_joint};
      record.at(MetricId::length_change) = {100.0 * chain.length_change, -1};
    }
  }
  // What only a control can say; arms are measured over the whole sweep.
  for (const MetricId id :
       {MetricId::lost_twist, MetricId::end_gap, MetricId::flip_margin, MetricId::gain,
        MetricId::arm_slide, MetricId::arm_drift, MetricId::arm_shift, MetricId::chain_twist_jump,
        MetricId::self_intersection})
    record.at(id) = {};
  int joint = -1;
  const double corner = system.corner_deg(frame, joint);
  record.at(MetricId::chain_kink) = {corner, joint};
}

}  // namespace

std::vector<WatchedJoint> watched_joints(const skin::Character& character,
                                         const skin::Anatomy& anatomy) {
  std::vector<WatchedJoint> out;
  const auto watch = [&](int node, int base) {
    out.push_back({node, base, character.nodes[static_cast<Index>(node)].name});
  };
  for (Index k = 1; k < anatomy.spine.size(); ++k) watch(anatomy.spine[k], anatomy.spine[k - 1]);
  for (const int root : arm_roots(anatomy))
    if (const int base = spine_above(character, anatomy, root); base >= 0) watch(root, base);
  return out;
}

std::vector<glm::dquat> watched_turns(const ClipBody& body,
                                      const std::vector<WatchedJoint>& watched,
                                      const skin::ClipSweep& range) {
  std::vector<glm::dquat> out;
  for (Index f = range.first; f < range.first + range.count; ++f)
    for (const WatchedJoint& joint : watched)
      out.push_back(glm::conjugate(body.turn(f, joint.base)) * body.turn(f, joint.node));
  return out;
}

std::vector<double> path_pops(const std::vector<glm::dvec3>& path, const std::vector<double>& time,
                              const ClipSettings& settings) {
  const Index n = path.size();
  std::vector<double> out(n, kNan);
  if (n < 5) return out;
  std::vector<glm::dvec3> step;
  std::vector<double> duration, change;
  for (Index f = 0; f + 1 < n; ++f) {
    step.push_back(path[f + 1] - path[f]);
    duration.push_back(time[f + 1] - time[f]);
  }
  const Index last = step.size() - 1;
  const auto pace = [&](Index k) { return step[k] / duration[k]; };
  for (Index f = 0; f <= last; ++f) {
    const auto beyond = [&](const glm::dvec3& expected) {
      return glm::length(step[f] - expected * duration[f]);
    };
    // At the ends the neighbours stand on one side: their pace, or where it leads.
    const auto at_end = [&](Index one, Index two) {
      return std::min({beyond(pace(one)), beyond(pace(two)), beyond(2.0 * pace(one) - pace(two))});
    };
    change.push_back(f == 0      ? at_end(1, 2)
                     : f == last ? at_end(last - 1, last - 2)
                                 : beyond(0.5 * (pace(f - 1) + pace(f + 1))));
  }
  out[0] = 0.0;
  for (Index f = 0; f <= last; ++f) {
    std::vector<double> around;
    for (std::ptrdiff_t k = static_cast<std::ptrdiff_t>(f) - settings.reach;
         k <= static_cast<std::ptrdiff_t>(f) + settings.reach; ++k)
      if (k >= 0 && k <= static_cast<std::ptrdiff_t>(last) &&
          std::abs(k - static_cast<std::ptrdiff_t>(f)) > 1)
        around.push_back(change[static_cast<Index>(k)]);
    out[f + 1] = std::max(0.0, change[f] - settings.outlier * median(around));
  }
  return out;
}

ClipRecord measure_clip(const skin::Character& character, const skin::Anatomy& anatomy,
                        const skin::Clip& clip, const ClipBody& body, const ClipSystem& system,
                        const BodyMetrics* metrics, Progress& progress) {
  ClipRecord record;
  record.watched = watched_joints(character, anatomy);
  record.has_corners = system.rest().position.size() >= ClipSystem::kLeastForCorners;
  record.has_mesh = metrics != nullptr;
  record.open_mesh = metrics != nullptr && !metrics->mesh().open_reason.empty();
  const ArmMeasures arms(character, anatomy, body);
  record.has_arms = arms.any() && body.fit() != ClipFit::points;
  record.clavicles_rest = record.has_arms && arms.clavicles_rest();
  const RigAtRest at_rest = rig_at_rest(system);
  progress.start("frames", clip.frame_count());
  for (const skin::ClipSweep& range : clip.sweeps) {
    poll_interrupt();
    ClipSweepRecord sweep;
    sweep.range = range;
    const int control = leading_control(clip, range);
    if (control >= 0) sweep.control = clip.control[static_cast<Index>(control)];
    sweep.poses.resize(range.count);
    oneapi::tbb::parallel_for(Index{0}, range.count, [&](Index i) {
      PoseRecord& pose = sweep.poses[i];
      measure_frame(body, system, at_rest, metrics, range.first + i, pose);
      pose.control_deg = static_cast<double>(i);
      if (control >= 0) {
        const double value = clip.control_value[(range.first + i) * clip.control.size() +
                                                static_cast<Index>(control)];
        if (std::isfinite(value)) pose.control_deg = value;
      }
      progress.step();
    });
    const std::vector<double> time = times_of(clip, range);
    if (record.has_arms) arms.measure(range, time, record.clavicles_rest, sweep.poses);
    const std::vector<glm::dquat> turns = watched_turns(body, record.watched, range);
    sweep.flips = find_clip_flips({record.watched.size(), turns, time});
    record.sweeps.push_back(std::move(sweep));
  }
  progress.finish();
  return record;
}

}  // namespace backbend::validate
