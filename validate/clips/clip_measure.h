#pragma once
#include "validate/clips/clip_system.h"
#include "validate/metrics/clip_flip.h"
#include "validate/run/measure.h"

namespace backbend::validate {

/// One sweep of a clip as it was measured; frames are those of the clip from `range.first` on.
struct ClipSweepRecord {
  skin::ClipSweep range;
  std::vector<PoseRecord> poses;
  ClipReport flips;     // joints are those of ClipRecord::watched
  std::string control;  // the leading control, empty where the clip names none that moves
};

/// A joint whose turns are searched for jumps: against the joint below it on the chain, or the
/// spine joint that it hangs from.
struct WatchedJoint {
  int node = -1, base = -1;
  std::string name;
};

/// Everything measured on one clip.
struct ClipRecord {
  std::vector<WatchedJoint> watched;
  std::vector<ClipSweepRecord> sweeps;
  bool has_mesh = false, open_mesh = false;
  bool has_corners = false;     // enough joints to hold one against its neighbours
  bool has_arms = false;        // arm roots that hang from the spine, and are not fitted
  bool clavicles_rest = false;  // nobody animates them: they show the rig's own drift
};

/// The chain joints above the hips, neck and head, and the arm roots, as far as they hang from the
/// spine.
std::vector<WatchedJoint> watched_joints(const skin::Character& character,
                                         const skin::Anatomy& anatomy);

/// Turns of the watched joints over a run of frames, as find_clip_flips() takes them.
std::vector<glm::dquat> watched_turns(const ClipBody& body,
                                      const std::vector<WatchedJoint>& watched,
                                      const skin::ClipSweep& range);

/// By how much the steps of a point's path jump, beyond what the steps around explain: one value
/// per frame (of the step that ends there), in the path's unit. The same rule as for turns, with no
/// smallest size. Fewer than five frames tell nothing: NaN.
std::vector<double> path_pops(const std::vector<glm::dvec3>& path, const std::vector<double>& time,
                              const ClipSettings& settings = {});

/// Measures every frame. `metrics` is null for a skeleton without a body.
ClipRecord measure_clip(const skin::Character& character, const skin::Anatomy& anatomy,
                        const skin::Clip& clip, const ClipBody& body, const ClipSystem& system,
                        const BodyMetrics* metrics, Progress& progress);

}  // namespace backbend::validate
