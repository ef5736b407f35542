#pragma once
#include "validate/clips/clip_system.h"
#include "validate/clips/control_response.h"
#include "validate/measure/measure.h"
#include "validate/metrics/chain/bend_shares.h"
#include "validate/metrics/chain/clip_flip.h"

namespace backbend::validate {

/// One sweep of a clip as it was measured; frames are those of the clip from `range.first` on.
struct ClipSweepRecord {
  skin::ClipSweep range;
  std::vector<PoseRecord> poses;
  ClipReport flips;            // joints are those of ClipRecord::watched
  std::size_t rest_lead = 0;   // first frames that are the rest pose and the way from it: no motion
  std::string control;         // the leading control, empty where the clip names none that moves
  std::vector<double> travel;  // control_travel(): then there is a gain
  // Whether turns of the clavicles are drift here: nobody turns them, or the clip says which
  // controls moved and none of them is an arm's.
  bool drift_applies = false;
  std::string no_drift_reason;              // why not
  std::vector<ShareExcess> shares;          // one per frame; share_excess() where controls are kept
  std::optional<ControlResponse> response;  // of the one channel that the sweep moves
};

/// A joint whose turns are searched for jumps.
struct WatchedJoint {
  enum class Against {
    below,  // the joint below it on the chain, or the spine joint that it hangs from
    hips,   // what all joints up to it add up to: small jumps of many joints in one direction
    world   // the hips themselves
  };
  int node = -1, base = -1;  // base: -1 for the world
  Against against = Against::below;
  std::string name;
};

/// Everything measured on one clip.
struct ClipRecord {
  std::vector<WatchedJoint> watched;
  std::vector<ClipSweepRecord> sweeps;
  bool has_mesh = false;
  SurfaceScope surface;          // what may be asked of it
  bool has_corners = false;      // enough joints to hold one against its neighbours
  bool has_arms = false;         // arm roots that hang from the spine, and are not fitted
  bool has_slides = false;       // where joints stand is the clip's own, not fitted
  std::vector<int> share_joint;  // watched joints that ClipSweepRecord::shares counts
};

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

/// Measures one frame by itself: all but what is measured over its whole sweep (arms, slides).
/// `metrics` is null for a skeleton without a body.
void measure_frame(const ClipBody& body, const ClipSystem& system, const RigAtRest& at_rest,
                   const BodyMetrics* metrics, std::size_t frame, PoseRecord& record);

/// Measures every frame. `metrics` is null for a skeleton without a body.
ClipRecord measure_clip(const skin::Character& character, const skin::Anatomy& anatomy,
                        const skin::Clip& clip, const ClipBody& body, const ClipSystem& system,
                        const BodyMetrics* metrics, Progress& progress);

}  // namespace backbend::validate
