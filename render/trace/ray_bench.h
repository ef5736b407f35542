#pragma once
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "render/trace/ray_device.h"
#include "render/trace/scene.h"

namespace backbend::render {

/// How fast the ray device alone traces one kind of a frame's rays.
struct RayRate {
  RayRecord::Kind kind;
  TreeQuality quality;
  RayWay way;
  bool coherent;   // as the device was told
  double seconds;  // one thread's, for all rays of the kind
};

/// What one frame costs, and what its rays alone would cost.
struct RayCost {
  std::array<std::size_t, 3> rays{};  // by kind
  double frame_s = 0.0;               // one thread's seconds for the frame, files not counted
  std::vector<RayRate> rates;         // every way, by kind
  std::array<RayRate, 3> best{};      // the fastest for each kind
  double as_asked_s = 0.0;  // all rays as the renderer asks for them, in a tree of medium quality

  std::size_t all_rays() const { return rays[0] + rays[1] + rays[2]; }
  double best_s() const { return best[0].seconds + best[1].seconds + best[2].seconds; }
  /// Share of the frame's time that its rays alone would take at the best that the device gives, in
  /// (0, 1].
  double ratio() const { return best_s() / frame_s; }
  double ratio_as_asked() const { return as_asked_s / frame_s; }
};

/// Renders a frame of `scene`, which must hold the pose `position`, on the calling thread, keeping
/// every ray; then measures the frame and its rays `repeats` times in turn and gives medians. The
/// rays go in the frame's own batches and order through trees that were built for this very pose,
/// with nothing asked of the device but its hits. Seconds are of processor time. Throws
/// RenderError, also where frame and rays do not agree about what was hit.
RayCost measure_rays(const Scene& scene, const MeshTopology& mesh,
                     std::span<const glm::vec3> position, const Camera& camera, Settings settings,
                     int repeats);

}  // namespace backbend::render
