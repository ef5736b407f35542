#pragma once
#include <cstddef>
#include <span>

#include "render/trace/scene.h"

namespace backbend::render {

/// What one frame costs, and what its rays alone would cost.
struct RayCost {
  std::size_t camera_rays = 0, scattered_rays = 0, shadow_rays = 0;
  double frame_s = 0.0;  // one thread's seconds for the whole frame, files not counted
  double rays_s = 0.0;   // one thread's seconds for the same rays by the ray device alone

  std::size_t rays() const { return camera_rays + scattered_rays + shadow_rays; }
  /// Share of the time in which rays are traced at the ray device's full speed, in (0, 1].
  double ratio() const { return rays_s / frame_s; }
};

/// Renders a frame of `scene`, which must hold the pose `position`, on the calling thread, keeping
/// every ray; then measures frame and rays `repeats` times in turn and gives the medians. The rays
/// go in the frame's own batches and order through a tree that was built for this very pose, with
/// nothing asked of the device but its hits. Seconds are of processor time. Throws RenderError,
/// also where frame and rays do not agree about what was hit.
RayCost measure_rays(const Scene& scene, const MeshTopology& mesh,
                     std::span<const glm::vec3> position, const Camera& camera, Settings settings,
                     int repeats);

}  // namespace backbend::render
