#include "validate/clips/clip_measure.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

#include "skin/anatomy/mirror_image.h"
#include "skin/character/ancestor.h"
#include "skin/character/matrix_facts.h"
#include "validate/clips/arm_leap.h"
#include "validate/clips/clip_frames.h"
#include "validate/metrics/chain/chain_corner.h"
#include "validate/metrics/math/median.h"
#include "validate/metrics/math/nan.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;
using skin::origin;

// A clavicle that turns by less than this over a whole clip was not animated: float files round a
// hundredth of it.
constexpr double kAnimatedDeg = 0.05;

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

/// Whether a control's name speaks of an arm or shoulder.
bool names_an_arm(const std::string& control) {
  std::string lower;
  for (const char c : control)
    lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const char* word : {"clav", "collar", "shoulder", "shld", "scap", "arm", "elbow", "wrist",
                           "hand", "finger", "wing", "foreleg", "front"})
    if (lower.find(word) != std::string::npos) return true;
  return false;
}

/// Where the joints that others hang from stand, and how the arm roots turn, against what carries
/// them.
class JointMeasures {
 public:
  JointMeasures(const skin::Character& character, const skin::Anatomy& anatomy,
                const skin::Clip& clip, const ClipBody& body,
                const std::vector<WatchedJoint>& watched)
      : character_(character), anatomy_(anatomy), clip_(clip), body_(body), watched_(watched) {
    for (const int root : arm_roots(anatomy))
      if (const int base = spine_above(character, anatomy, root); base >= 0)
        for (Index w = 0; w < watched.size(); ++w)
          if (watched[w].node == root && watched[w].base == base) arms_.push_back(w);
    // The one that carries the others moves where the body goes; so does one that stands where the
    // hips do.
    for (Index w = 1; w < anatomy.spine.size(); ++w)
      if (!carries_all(watched[w].node) && !(w == 1 && stands_with_hips(watched[w].node)))
        spine_.push_back(w);
    calmest_ = calmest_frame();
    if (body.fit() != ClipFit::points) moving_joints_ = count_moving_joints();
  }

  bool any_arms() const { return !arms_.empty(); }

  bool clavicles_rest() const {
    for (const Index arm : arms_) {
      const int root = watched_[arm].node;
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

  /// Whether the clip's controls say that nobody moved an arm in a sweep; `reason`: why not.
  bool controls_leave_arms(const skin::ClipSweep& range, std::string& reason) const {
    bool moves = false;
    for (Index c = 0; c < clip_.control.size(); ++c) {
      if (!(control_range(clip_, range, c) > 0.0)) continue;
      moves = true;
      if (names_an_arm(clip_.control[c])) {
        reason = "the arms are animated by " + clip_.control[c];
        return false;
      }
    }
    if (!moves) reason = "the clavicles are animated, and no control is recorded that says by what";
    return moves;
  }

  void measure_drift(const skin::ClipSweep& range, std::vector<PoseRecord>& poses) const {
    for (const Index arm : arms_) {
      const int root = watched_[arm].node, carrier = watched_[arm].base;
      // Against the pose of the controls at rest, else the clip's first: a pose that the clip
      // holds throughout does not count as drift.
      const glm::dquat held =
          glm::conjugate(body_.turn(calmest_, carrier)) * body_.turn(calmest_, root);
      for (Index i = 0; i < range.count; ++i) {
        const Index f = range.first + i;
        const double deg =
            degrees(angle_between(body_.turn(f, carrier) * held, body_.turn(f, root)));
        Measured& value = poses[i].at(MetricId::arm_drift);
        if (!(deg <= value.value)) value = {deg, static_cast<int>(arm)};
      }
    }
  }

  /// Joints that leave their place on their parent, percent of the spine's length. `place` of the
  /// measure is the watched joint.
  void measure_slides(const skin::ClipSweep& range, const std::vector<double>& time,
                      bool arms_are_still, std::vector<PoseRecord>& poses) const {
    const auto report = [&](Index frame, double length, Index joint) {
      const double percent = 100.0 * length / anatomy_.spine_length;
      Measured& value = poses[frame].at(MetricId::arm_shift);
      if (!(percent <= value.value)) value = {percent, static_cast<int>(joint)};
    };
    for (Index i = 0; i < range.count; ++i) report(i, 0.0, spine_.empty() ? 0 : spine_.front());
    const std::vector<std::vector<double>> arm = arm_slides(range);
    const double wide = (arms_are_still ? kSlide : kKeyedSlide) * anatomy_.spine_length;
    const auto slides = [&](const std::vector<double>& way) {
      return *std::max_element(way.begin(), way.end()) > wide;
    };
    // Several joints that move on their parents were moved by somebody (a shrug, a cartoon's
    // stretched neck), unless the controls say otherwise: then only pops count, from a
    // quarter of the joint's whole way on.
    const bool made = !arms_are_still && moving_joints_ > 1;
    constexpr double kOfOwnWay = 0.25;
    const auto report_pops = [&](Index joint, int base) {
      std::vector<glm::dvec3> path;
      for (Index i = 0; i < range.count; ++i)
        path.push_back(place(range.first + i, watched_[joint].node, base));
      const std::vector<double> pops = path_pops(path, time);
      const double own = made ? kOfOwnWay * widest(joint) : 0.0;
      for (Index i = 0; i < range.count; ++i)
        if (!(pops[i] < own)) report(i, pops[i], joint);  // too few frames: not a number
    };
    for (Index a = 0; a < arms_.size(); ++a) {
      if (!made && slides(arm[a])) {
        for (Index i = 0; i < range.count; ++i) report(i, arm[a][i], arms_[a]);
      } else {
        report_pops(arms_[a], watched_[arms_[a]].base);
      }
    }
    const std::vector<std::vector<double>> spine = spine_slides(range);
    for (Index k = 0; k < spine_.size(); ++k) {
      if (made || (!arms_are_still && !slides(spine[k]))) {
        report_pops(spine_[k], parent(spine_[k]));
        continue;
      }
      for (Index i = 0; i < range.count; ++i) {
        std::vector<double> others;
        for (Index j = 0; j < spine_.size(); ++j)
          if (j != k) others.push_back(spine[j][i]);
        // A chain whose joints all move on their parents (a stretching one, one laid along a
        // curve) has none that slides alone.
        constexpr double kAlone = 3.0;
        if (spine[k][i] > kAlone * upper_median(others)) report(i, spine[k][i], spine_[k]);
      }
    }
  }

 private:
  bool carries_all(int node) const {
    return std::ranges::all_of(
        anatomy_.spine, [&](int other) { return skin::is_ancestor(character_, node, other); });
  }

  bool stands_with_hips(int node) const {
    constexpr double kWithHips = 0.01;  // of the spine
    const auto at = [&](int which) {
      return origin(character_.nodes[static_cast<Index>(which)].world_from_node);
    };
    return glm::distance(at(node), at(anatomy_.spine.front())) <= kWithHips * anatomy_.spine_length;
  }

  // What a float file rounds a joint's place by, and what nobody sees; shares of the spine.
  static constexpr double kSamePlace = 0.001, kSlide = 0.02, kMoves = 0.005;
  // Where no control says that the body was left alone: an animator slides a neck so far.
  static constexpr double kKeyedSlide = 0.03;

  /// The frame whose controls are nearest to rest; the first where none is recorded.
  Index calmest_frame() const {
    Index best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (Index f = 0; f < body_.frame_count(); ++f) {
      double sum = 0.0;
      for (Index c = 0; c < clip_.control.size(); ++c) {
        const double value = control_value(clip_, f, c);
        if (std::isfinite(value)) sum += std::abs(value);
      }
      if (sum < least) {
        least = sum;
        best = f;
      }
    }
    return best;
  }

  /// Where a node stands against another, in its axes.
  glm::dvec3 place(Index frame, int node, int base) const {
    const std::vector<glm::dmat4>& world = body_.world_from_node(frame);
    return glm::conjugate(body_.turn(frame, base)) *
           (origin(world[static_cast<Index>(node)]) - origin(world[static_cast<Index>(base)]));
  }
  int parent(Index joint) const {
    return character_.nodes[static_cast<Index>(watched_[joint].node)].parent;
  }

  /// Where a joint belongs on its parent: of rest, first, last and middle place the one that most
  /// frames of the clip hold.
  glm::dvec3 usual_place(Index joint) const {
    return usual_place(watched_[joint].node, parent(joint));
  }
  glm::dvec3 usual_place(int node, int base) const {
    std::vector<glm::dvec3> all;
    for (Index f = 0; f < body_.frame_count(); ++f) all.push_back(place(f, node, base));
    glm::dvec3 middle;
    for (int c = 0; c < 3; ++c) {
      std::vector<double> values;
      for (const glm::dvec3& p : all) values.push_back(p[c]);
      middle[c] = upper_median(values);
    }
    const glm::dvec3 rest = origin(character_.nodes[static_cast<Index>(node)].world_from_node) -
                            origin(character_.nodes[static_cast<Index>(base)].world_from_node);
    glm::dvec3 best = rest;
    std::ptrdiff_t most = -1;
    for (const glm::dvec3& candidate : {rest, all.front(), all.back(), middle}) {
      const std::ptrdiff_t here = std::count_if(all.begin(), all.end(), [&](const glm::dvec3& p) {
        return glm::distance(p, candidate) <= kSamePlace * anatomy_.spine_length;
      });
      if (here > most) {
        most = here;
        best = candidate;
      }
    }
    return best;
  }

  /// How far a joint gets from its usual place on its parent anywhere in the file.
  double widest(Index joint) const { return widest(watched_[joint].node, parent(joint)); }
  double widest(int node, int base) const {
    const glm::dvec3 usual = usual_place(node, base);
    double out = 0.0;
    for (Index f = 0; f < body_.frame_count(); ++f)
      out = std::max(out, glm::distance(place(f, node, base), usual));
    return out;
  }

  /// Watched joints, and thighs, that leave their place on their parent anywhere in the file by
  /// more than what nobody sees. Joints of captured motion keep it; in keyed motion that
  /// translates, several move.
  Index count_moving_joints() const {
    const skin::ClipSweep whole{"", 0, body_.frame_count()};
    const double seen = kMoves * anatomy_.spine_length;
    Index count = 0;
    for (const auto& slides : {arm_slides(whole), spine_slides(whole)})
      for (const std::vector<double>& way : slides)
        count += !way.empty() && *std::max_element(way.begin(), way.end()) > seen;
    for (const auto* leg : {&anatomy_.left_leg, &anatomy_.right_leg}) {
      // One on a control of its own, beside the spine, moves with every step.
      if (leg->empty() || spine_above(character_, anatomy_, leg->front()) < 0) continue;
      count +=
          widest(leg->front(), character_.nodes[static_cast<Index>(leg->front())].parent) > seen;
    }
    return count;
  }

  std::vector<std::vector<double>> arm_slides(const skin::ClipSweep& range) const {
    std::vector<std::vector<double>> out;
    for (const Index arm : arms_) {
      const glm::dvec3 usual = usual_place(arm);
      std::vector<double>& way = out.emplace_back();
      for (Index i = 0; i < range.count; ++i)
        way.push_back(
            glm::distance(place(range.first + i, watched_[arm].node, parent(arm)), usual));
    }
    return out;
  }

  /// Of the joints above the hips, with the stretch taken off that most of them share.
  std::vector<std::vector<double>> spine_slides(const skin::ClipSweep& range) const {
    std::vector<glm::dvec3> usual;
    for (const Index joint : spine_) usual.push_back(usual_place(joint));
    std::vector<std::vector<double>> out(spine_.size());
    for (Index i = 0; i < range.count; ++i) {
      std::vector<glm::dvec3> now;
      std::vector<double> ratio;
      for (Index k = 0; k < spine_.size(); ++k) {
        now.push_back(place(range.first + i, watched_[spine_[k]].node, parent(spine_[k])));
        if (glm::length(usual[k]) > 0.01 * anatomy_.spine_length)
          ratio.push_back(glm::length(now[k]) / glm::length(usual[k]));
      }
      const double stretch = ratio.empty() ? 1.0 : upper_median(ratio);
      for (Index k = 0; k < spine_.size(); ++k)
        out[k].push_back(glm::distance(now[k], stretch * usual[k]));
    }
    return out;
  }

  const skin::Character& character_;
  const skin::Anatomy& anatomy_;
  const skin::Clip& clip_;
  const ClipBody& body_;
  const std::vector<WatchedJoint>& watched_;
  std::vector<Index> arms_, spine_;  // into watched_
  Index calmest_ = 0;
  Index moving_joints_ = 0;
};

/// Whether a joint hangs from one that stands where `chest` does at rest: rigs that keep mechanism
/// and deforming joints side by side hang their arms from the former.
bool hangs_from_twin(const skin::Character& character, const skin::Anatomy& anatomy, int joint,
                     int chest) {
  constexpr double kSamePlace = 1e-3;  // of the spine's length
  const auto place = [&](int node) {
    return skin::origin(character.nodes[static_cast<Index>(node)].world_from_node);
  };
  for (int above = character.nodes[static_cast<Index>(joint)].parent; above >= 0;
       above = character.nodes[static_cast<Index>(above)].parent)
    if (glm::distance(place(above), place(chest)) <= kSamePlace * anatomy.spine_length) return true;
  return false;
}

/// How many joints of the spine lie between hips and chest, the chest itself included where the
/// arms hang from it.
Index joints_with_shares(const skin::Character& character, const skin::Anatomy& anatomy) {
  Index last = anatomy.chest_index;
  const int chest = anatomy.spine[last];
  bool carries = false;
  for (const int root : arm_roots(anatomy))
    carries = carries || spine_above(character, anatomy, root) == chest ||
              hangs_from_twin(character, anatomy, root, chest);
  return !carries && last > 0 ? last - 1 : last;
}

/// Whether the body has arms or legs and they keep their rest pose throughout a sweep: an animator
/// poses them, too; a test of the spine does not.
bool limbs_rest(const skin::Character& character, const skin::Anatomy& anatomy,
                const ClipBody& body, const skin::ClipSweep& range) {
  constexpr double kAtRestDeg = 0.5;
  bool any = false;
  for (const auto* limb :
       {&anatomy.left_arm, &anatomy.right_arm, &anatomy.left_leg, &anatomy.right_leg})
    for (const int joint : *limb) {
      const int parent = character.nodes[static_cast<Index>(joint)].parent;
      if (parent < 0) continue;
      any = true;
      for (Index f = range.first; f < range.first + range.count; ++f)
        if (!(degrees(angle_between(body.turn(f, parent), body.turn(f, joint))) <= kAtRestDeg))
          return false;
    }
  return any;
}

std::vector<ShareExcess> shares_of(const Stage& stage, const ClipBody& body,
                                   const skin::ClipSweep& range, const Recording& recording,
                                   bool of_controls) {
  const skin::Character& character = stage.character();
  const skin::Anatomy& anatomy = stage.anatomy();
  std::vector<glm::dvec3> turn;
  for (Index f = range.first; f < range.first + range.count; ++f)
    for (Index k = 1; k <= recording.share_joints; ++k) {
      const WatchedJoint& joint = recording.watched[k];
      turn.push_back(
          rotation_vector(glm::conjugate(body.turn(f, joint.base)) * body.turn(f, joint.node)));
    }
  // Without controls, how the joints share the motion is up to the animator.
  const bool of_rig = of_controls || limbs_rest(character, anatomy, body, range);
  const skin::Mirror mirror = skin::mirror_of(character, anatomy);
  MotionFacts facts{of_controls,
                    of_rig && skin::spine_is_in_the_middle(character, anatomy, mirror)};
  for (Index k = 0; k <= recording.share_joints; ++k)  // the spine from the hips on
    facts.rest_place.push_back(
        skin::origin(character.nodes[static_cast<Index>(anatomy.spine[k])].world_from_node));
  return joint_excess(turn, recording.share_joints, skin::body_axes(anatomy, mirror), facts);
}

/// Degrees that any joint of the chain turns by for each degree of control; a pose has the larger
/// of its two intervals, as in a sweep of a rig.
void measure_gain(const ClipSystem& system, const skin::ClipSweep& range,
                  const std::vector<double>& travel, std::vector<PoseRecord>& poses) {
  const auto offer = [&](Index pose, double gain) {
    Measured& value = poses[pose].at(MetricId::gain);
    if (!(gain <= value.value)) value = {gain, -1};
  };
  for (Index i = 1; i < range.count; ++i) {
    const solver::SpinePose &from = system.pose(range.first + i - 1),
                            &to = system.pose(range.first + i);
    double most = 0.0;
    for (Index k = 0; k < to.turn.size(); ++k)
      most = std::fmax(most, degrees(angle_between(from.turn[k], to.turn[k])));
    const double gain = most / (travel[i] - travel[i - 1]);
    offer(i - 1, gain);
    offer(i, gain);
  }
}

/// Where a clip holds its controls, frames are compared by them: a rig answers alike from degree to
/// degree, so smaller jumps can be told than from second to second.
constexpr double kSmallestWithControlsDeg = 5.0;

/// Whether a joint turns back from frame to frame: over two frames it goes much less far than in
/// its two steps. Motion that is held and leaps on, as in blocking, does not; nor is it said of a
/// few frames, which may be the keys themselves.
bool shakes(std::span<const glm::dquat> turns, Index joints, Index joint) {
  constexpr double kLeftOver = 0.7;
  constexpr Index kFewFrames = 16;
  if (turns.size() < kFewFrames * joints) return false;
  double steps = 0.0, over_two = 0.0;
  for (Index f = 2; f * joints < turns.size(); ++f) {
    const auto at = [&](Index frame) { return turns[frame * joints + joint]; };
    steps += angle_between(at(f - 2), at(f - 1)) + angle_between(at(f - 1), at(f));
    over_two += angle_between(at(f - 2), at(f));
  }
  return over_two < kLeftOver * steps;
}

/// Takes out of a sweep's jumps those that hold and go with an arm's leap, and says so.
void leave_to_leaps(const skin::Character& character, const skin::Anatomy& anatomy,
                    const ClipBody& body, const skin::ClipSweep& range, Recording& recording,
                    SweepRecord& sweep) {
  std::erase_if(sweep.flips.jumps, [&](Jump& jump) {
    const Index to = jump.pose + 1;
    std::erase_if(jump.joints, [&](const JointJump& joint) {
      if (joint.frames_out > 0) return false;
      const WatchedJoint& watched = recording.watched[joint.joint];
      const std::optional<ArmLeap> leap =
          arm_leap(character, anatomy, body, range, to, watched.node);
      if (!leap || joint.size_deg > leap->explains_deg) return false;
      recording.notes.push_back(
          range.name + ", frame " +
          std::to_string(sweep.poses[to].frame.value_or(static_cast<int>(to))) + ": " +
          watched.name + " jumps by " + number_text(joint.size_deg, 3) + " deg with " +
          leap->joint + ", which turns by " + number_text(leap->turn_deg, 3) +
          " deg in that step: the motion, not a flip (BB001)");
      return true;
    });
    return jump.joints.empty();
  });
}

/// Jumps of a sweep from its frame `skipped` on; poses are those of the whole sweep. `along`: its
/// seconds, or how far its controls have gone.
FlipReport find_flips(const ClipBody& body, const std::vector<WatchedJoint>& watched,
                      const skin::ClipSweep& range, const std::vector<double>& along, Index skipped,
                      const ClipSettings& settings) {
  const std::vector<glm::dquat> turns = watched_turns(body, watched, range);
  const std::span<const glm::dquat> all(turns);
  FlipReport out = find_clip_flips({watched.size(), all.subspan(skipped * watched.size()),
                                    std::span<const double>(along).subspan(skipped)},
                                   settings);
  for (Jump& jump : out.jumps) jump.pose += skipped;
  out.not_finite_pose += skipped;
  for (Index w = 0; w < out.calm_deg.size(); ++w)
    if (watched[w].against != WatchedJoint::Against::hips && out.calm_deg[w] > kAnyJump_deg &&
        shakes(all.subspan(skipped * watched.size()), watched.size(), w))
      out.certified = false;
  return out;
}

/// Whether a metric says something of all poses of a sweep.
void set_applies(MetricId id, bool applies, std::vector<PoseRecord>& poses) {
  for (PoseRecord& pose : poses) pose.left_out[static_cast<Index>(id)] = !applies;
}

/// Motion that a rig solved, or nobody knows what; see Owner.
Owner owner_of_motion(const skin::Clip& clip) {
  return clip.control.empty() && !clip.joint.empty() ? Owner::motion : Owner::rig;
}

/// A frame of the clip bent evenly, measured.
PoseRecord measure_even_bend(const Stage& stage, const ClipBody& body, const ClipSystem& system,
                             const BodyMetrics& metrics, Index frame) {
  const std::vector<glm::dmat4> even =
      even_bend(stage.character(), stage.anatomy(), system, body, frame);
  const ClipSystem ideal(stage.character(), stage.anatomy(), even);
  PosedCharacter posed;
  posed.spine = ideal.pose(0);
  posed.mesh = body.blended(even);
  posed.world_from_node = even;
  PoseRecord out;
  out.control = {0.0};
  out.body.twist = ideal.twist_deg(0);
  measure_pose(metrics, rig_at_rest(ideal), posed, out, Crossing::left_out);
  return out;
}

}  // namespace

int spine_above(const skin::Character& character, const skin::Anatomy& anatomy, int node) {
  for (node = character.nodes[static_cast<Index>(node)].parent; node >= 0;
       node = character.nodes[static_cast<Index>(node)].parent)
    if (std::find(anatomy.spine.begin(), anatomy.spine.end(), node) != anatomy.spine.end())
      return node;
  return -1;
}

SweepRecord plan_sweep(const skin::Clip& clip, const skin::ClipSweep& range) {
  SweepRecord out;
  out.sweep.name = range.name;
  out.sweep.step_deg = 0.0;
  const std::optional<Index> control = leading_control(clip, range);
  if (control) out.sweep.channel = clip.control[*control];
  out.poses.resize(range.count);
  for (Index i = 0; i < range.count; ++i) {
    PoseRecord& pose = out.poses[i];
    const Index f = range.first + i;
    pose.control = {static_cast<double>(f)};
    pose.control_deg = static_cast<double>(i);
    if (control) {
      const double value = control_value(clip, f, *control);
      if (std::isfinite(value)) pose.control_deg = value;
    }
    if (clip.frame_number[f] < 0) continue;
    pose.frame = clip.frame_number[f];
    pose.time_s = clip.time[f];
  }
  return out;
}

void measure_frame(const ClipBody& body, const ClipSystem& system, const RigAtRest& at_rest,
                   const BodyMetrics* metrics, PoseRecord& record) {
  const Index frame = frame_of(record);
  record.body.twist = system.twist_deg(frame);
  const solver::SpinePose& pose = system.pose(frame);
  if (metrics != nullptr) {
    PosedCharacter posed;
    posed.spine = pose;
    posed.mesh = body.mesh(frame);
    if (!body.has_points()) posed.world_from_node = body.world_from_node(frame);
    measure_pose(*metrics, at_rest, posed, record, Crossing::left_out);
  } else {
    const auto curve = system.intended_curve(record.control, kCurvePoints);
    const ChainMeasures chain =
        measure_chain({pose, system.rest(), curve, at_rest.curve, record.body.twist});
    record.at(MetricId::non_finite) = {chain.finite ? 0.0 : 1.0, -1};
    for (const Metric& metric : metric_table())
      if (chain.finite && metric.from_chain != nullptr && metric.of_frames)
        record.at(metric.id) = metric.from_chain({system, pose, chain});
  }
  // What only a control can say; arms are measured over the whole sweep.
  for (const Metric& metric : metric_table())
    if (!metric.of_frames) {
      record.at(metric.id) = {};
      record.left_out.set(static_cast<Index>(metric.id));
    }
  int joint = -1;
  const double corner = system.corner_deg(frame, joint);
  record.at(MetricId::chain_kink) = {corner, joint};
  if (system.rest().position.size() >= kLeastForCorners)
    record.left_out.reset(static_cast<Index>(MetricId::chain_kink));
}

std::vector<WatchedJoint> watched_joints(const skin::Character& character,
                                         const skin::Anatomy& anatomy) {
  std::vector<WatchedJoint> out;
  using Against = WatchedJoint::Against;
  const auto watch = [&](int node, int base, Against against) {
    out.push_back({node, base, against, character.nodes[static_cast<Index>(node)].name});
  };
  watch(anatomy.spine.front(), -1, Against::world);
  for (Index k = 1; k < anatomy.spine.size(); ++k)
    watch(anatomy.spine[k], anatomy.spine[k - 1], Against::below);
  for (const int root : arm_roots(anatomy))
    if (const int base = spine_above(character, anatomy, root); base >= 0)
      watch(root, base, Against::below);
  for (Index k = 2; k < anatomy.spine.size(); ++k)
    watch(anatomy.spine[k], anatomy.spine.front(), Against::hips);
  return out;
}

std::vector<glm::dquat> watched_turns(const ClipBody& body,
                                      const std::vector<WatchedJoint>& watched,
                                      const skin::ClipSweep& range) {
  std::vector<glm::dquat> out;
  for (Index f = range.first; f < range.first + range.count; ++f)
    for (const WatchedJoint& joint : watched)
      out.push_back(joint.base < 0
                        ? body.hips_turn(f)
                        : glm::conjugate(body.turn(f, joint.base)) * body.turn(f, joint.node));
  return out;
}

std::size_t rest_lead(const skin::Anatomy& anatomy, const ClipBody& body,
                      const skin::ClipSweep& range) {
  // A tenth of a degree: what exporters round. A lead is a leap: no body that starts from rest
  // halves the pace of most of its joints at once.
  constexpr double kAtRestDeg = 0.1, kWider = 1.5, kLeap = 3.0, kLeastDeg = 1.0, kSameWidth = 0.03;
  constexpr Index kLongest = 8;
  const auto turn = [&](Index i, Index k) {
    const Index f = range.first + i;
    return k == 0 ? body.hips_turn(f)
                  : glm::conjugate(body.turn(f, anatomy.spine[k - 1])) *
                        body.turn(f, anatomy.spine[k]);
  };
  // All of the spine at rest in the first frame, or, in a cut, by one share of the way from there.
  const auto leaves_rest = [&](Index lead) {
    const glm::dquat rest(1, 0, 0, 0);
    double widest = 0.0, share = 0.0;
    for (Index k = 0; k < anatomy.spine.size(); ++k)
      if (const double whole = angle_between(rest, turn(lead, k)); whole > widest) {
        widest = whole;
        share = angle_between(rest, turn(0, k)) / whole;
      }
    for (Index k = 1; k < anatomy.spine.size(); ++k) {
      // Frame `lead` may be a part of a step into the motion, and several of the clip's joints may
      // be one here.
      const glm::dquat on_the_way = glm::slerp(rest, turn(lead, k), share);
      const double step = angle_between(turn(lead, k), turn(lead + 1, k));
      if (!(degrees(angle_between(turn(0, k), on_the_way) - step) <= kAtRestDeg)) return false;
    }
    return true;
  };
  const auto arms_leave_rest = [&](Index lead) {
    return std::ranges::all_of(
        std::array{&anatomy.left_arm, &anatomy.right_arm}, [&](const std::vector<int>* arm) {
          if (arm->size() < 2) return false;
          const auto upper = [&](Index i) {
            const Index f = range.first + i;
            return glm::conjugate(body.turn(f, (*arm)[0])) * body.turn(f, (*arm)[1]);
          };
          const double left = degrees(angle_between(upper(0), upper(1)));
          return degrees(angle_between(glm::dquat(1, 0, 0, 0), upper(0))) <= kAtRestDeg &&
                 left > kLeastDeg &&
                 left > kWider * degrees(angle_between(upper(lead), upper(lead + 1)));
        });
  };
  for (Index lead = 1; lead <= kLongest && lead + kLeastFrames < range.count; ++lead) {
    if (!leaves_rest(lead)) continue;
    Index leave = 0, leap = 0;
    bool hips = false;
    for (Index k = 0; k < anatomy.spine.size(); ++k) {
      const auto step = [&](Index i) { return angle_between(turn(i, k), turn(i + 1, k)); };
      bool leaves = degrees(step(0)) > kLeastDeg && step(0) > kWider * step(lead);
      for (Index i = 1; i + 1 < lead; ++i)
        leaves = leaves && std::abs(step(i) - step(0)) <= kSameWidth * step(0);
      leave += leaves;
      hips = hips || (k == 0 && leaves);
      leap += k > 0 && leaves && step(0) > kLeap * step(lead);
    }
    if (hips && 2 * leave > anatomy.spine.size()) return lead;
    // Hips that stand as they are bound; the arms show that it was a reference pose.
    if (arms_leave_rest(lead) && 2 * (leave + 2) > anatomy.spine.size() + 2) return lead;
    // Of a motion that was laid on a body whose hips are held.
    if (leap > 2 && leap + 1 == anatomy.spine.size()) return lead;
  }
  return 0;
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
    std::vector<double> around, coordinate[3];
    for (std::ptrdiff_t k = static_cast<std::ptrdiff_t>(f) - settings.reach;
         k <= static_cast<std::ptrdiff_t>(f) + settings.reach; ++k) {
      if (k < 0 || k > static_cast<std::ptrdiff_t>(last)) continue;
      for (int c = 0; c < 3; ++c) coordinate[c].push_back(pace(static_cast<Index>(k))[c]);
      if (std::abs(k - static_cast<std::ptrdiff_t>(f)) > 1)
        around.push_back(change[static_cast<Index>(k)]);
    }
    // A thrust has one fastest step between two fast ones; a pop that goes back at once, too, is
    // then as large as it is, not half as large again.
    const glm::dvec3 usual(upper_median(coordinate[0]), upper_median(coordinate[1]),
                           upper_median(coordinate[2]));
    double beside = 0.0;
    for (const Index k : {f == 0 ? f + 1 : f - 1, f == last ? f - 1 : f + 1})
      beside = std::max(beside, glm::length(step[k] - usual * duration[k]));
    out[f + 1] = std::max(0.0, change[f] - settings.outlier * upper_median(around) - 0.5 * beside);
  }
  return out;
}

RigRecord measure_clip(const Stage& stage, const skin::Clip& clip, const ClipBody& body,
                       const BodyMetrics* metrics, Progress& progress) {
  const skin::Character& character = stage.character();
  const skin::Anatomy& anatomy = stage.anatomy();
  auto made = std::make_unique<ClipSystem>(character, anatomy, body);
  const ClipSystem& system = *made;
  RigRecord record;
  record.plan.name = clip.name;
  record.plan.spec.system = system.name();
  record.has_mesh = metrics != nullptr;
  if (metrics != nullptr) record.surface = metrics->scope();
  Recording& recording = record.recording.emplace();
  recording.owner = owner_of_motion(clip);
  recording.watched = watched_joints(character, anatomy);
  recording.share_joints = joints_with_shares(character, anatomy);
  if (metrics != nullptr)
    recording.even_bend = [&stage, &body, &system, metrics](const PoseRecord& pose) {
      return measure_even_bend(stage, body, system, *metrics, frame_of(pose));
    };
  const JointMeasures joints(character, anatomy, clip, body, recording.watched);
  const bool has_slides = body.fit() != ClipFit::points;
  const bool has_arms = joints.any_arms() && has_slides;
  const bool clavicles_rest = has_arms && joints.clavicles_rest();
  const RigAtRest at_rest = rig_at_rest(system);
  progress.start("frames", clip.frame_count());
  for (const skin::ClipSweep& range : clip.sweeps) {
    poll_interrupt();
    SweepRecord sweep = plan_sweep(clip, range);
    oneapi::tbb::parallel_for(Index{0}, range.count, [&](Index i) {
      measure_frame(body, system, at_rest, metrics, sweep.poses[i]);
      progress.step();
    });
    const std::vector<double> time = times_of(clip, range);
    std::string no_drift_reason;
    // Turns of the clavicles are drift where nobody turns them, or where the clip says which
    // controls moved and none of them is an arm's.
    const bool arms_are_still = has_arms && joints.controls_leave_arms(range, no_drift_reason);
    const bool has_drift = clavicles_rest || arms_are_still;
    if (has_drift) joints.measure_drift(range, sweep.poses);
    if (has_slides) joints.measure_slides(range, time, arms_are_still, sweep.poses);
    set_applies(MetricId::arm_drift, has_drift, sweep.poses);
    set_applies(MetricId::arm_shift, has_slides && range.count >= kLeastFrames, sweep.poses);
    sweep.shares = shares_of(stage, body, range, recording, !sweep.sweep.channel.empty());
    sweep.response = control_response(clip, range, anatomy, character, body);
    const Index lead = rest_lead(anatomy, body, range);
    const std::vector<double> travel = control_travel(clip, range);
    ClipSettings settings;
    if (!travel.empty()) {
      sweep.sweep.step_deg = travel.back() / static_cast<double>(travel.size() - 1);
      settings.smallest_deg = kSmallestWithControlsDeg;
      // A rig answers alike from degree to degree, and its sweeps are not cut off.
      settings.two_frames_deg = 0.0;
      settings.at_end = 1.5;
      measure_gain(system, range, travel, sweep.poses);
    }
    set_applies(MetricId::gain, !travel.empty(), sweep.poses);
    sweep.flips =
        find_flips(body, recording.watched, range, travel.empty() ? time : travel, lead, settings);
    // Of a rig whose controls are recorded nobody animates the arms.
    if (clip.control.empty()) leave_to_leaps(character, anatomy, body, range, recording, sweep);
    if (lead > 0)
      recording.notes.push_back(
          range.name + ": begins with the rest pose; jumps are looked for after the first " +
          (lead == 1 ? "frame" : std::to_string(lead) + " frames"));
    if (has_arms && !has_drift)
      recording.notes.push_back(range.name +
                                ": arm drift (BB020) does not apply: " + no_drift_reason);
    record.sweeps.push_back(std::move(sweep));
  }
  // A held pose beside real motion is fine; a clip of held poses alone is a gap.
  const bool any = std::ranges::any_of(
      record.sweeps, [](const SweepRecord& each) { return each.poses.size() >= kLeastFrames; });
  for (SweepRecord& sweep : record.sweeps)
    sweep.searched = !any || !sweep.flips.finite || sweep.poses.size() >= kLeastFrames;
  record.system = std::move(made);
  progress.finish();
  return record;
}

}  // namespace backbend::validate
