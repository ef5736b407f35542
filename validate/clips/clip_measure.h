#pragma once
#include "validate/clips/clip_system.h"
#include "validate/clips/control_response.h"
#include "validate/measure/measure.h"
#include "validate/metrics/chain/clip_flip.h"

namespace backbend::validate {

/// The frame of the clip that a pose of its record is.
inline std::size_t frame_of(const PoseRecord& pose) {
  return static_cast<std::size_t>(pose.control.front());
}

/// The system of a record that measure_clip() made.
inline const ClipSystem& clip_system(const RigRecord& clip) {
  return static_cast<const ClipSystem&>(*clip.system);
}

/// The nearest joint of the spine that a node hangs from; -1 for none.
int spine_above(const skin::Character& character, const skin::Anatomy& anatomy, int node);

/// The hips in the world, the chain joints above them, neck and head, and the arm roots, as far as
/// they hang from the spine, each against its base; then all from the second joint on against the
/// hips. Entry k is joint k of the anatomy's spine.
std::vector<WatchedJoint> watched_joints(const skin::Character& character,
                                         const skin::Anatomy& anatomy);

/// How many of a sweep's first frames stand before the motion begins: many captures begin with the
/// rest pose, and jump into the motion with the second frame (or, resampled, over a few steps of
/// one width; a cut may begin on that way). 0 where not all of the spine stands at rest or by one
/// share of the way from there, or where not most of its joints, the hips among them, leave it in
/// steps that are far wider than the next one (three times, of all joints above hips that are
/// held).
std::size_t rest_lead(const skin::Anatomy& anatomy, const ClipBody& body,
                      const skin::ClipSweep& range);

/// Turns of the watched joints over a run of frames, as find_clip_flips() takes them.
std::vector<glm::dquat> watched_turns(const ClipBody& body,
                                      const std::vector<WatchedJoint>& watched,
                                      const skin::ClipSweep& range);

/// By how much the steps of a point's path jump, beyond what the steps around explain: one value
/// per frame (of the step that ends there), in the path's unit. The same rule as for turns, with no
/// smallest size, and half of what the steps beside it differ from the usual pace taken off. Fewer
/// than five frames tell nothing: NaN.
std::vector<double> path_pops(const std::vector<glm::dvec3>& path, const std::vector<double>& time,
                              const ClipSettings& settings = {});

/// A sweep's frames, none of them measured.
SweepRecord plan_sweep(const skin::Clip& clip, const skin::ClipSweep& range);

/// Measures one planned frame by itself: all but what is measured over its whole sweep (arms,
/// slides, gain), which is left out. `metrics` is null for a skeleton without a body.
void measure_frame(const ClipBody& body, const ClipSystem& system, const RigAtRest& at_rest,
                   const BodyMetrics* metrics, PoseRecord& record);

/// Measures every frame. `metrics` is null for a skeleton without a body. The record keeps
/// references to all but the progress, as long as its even_bend is called.
RigRecord measure_clip(const Stage& stage, const skin::Clip& clip, const ClipBody& body,
                       const BodyMetrics* metrics, Progress& progress);

}  // namespace backbend::validate
