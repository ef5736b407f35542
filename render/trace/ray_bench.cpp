#include "render/trace/ray_bench.h"

#include <time.h>

#include <algorithm>
#include <vector>

#include "render/trace/ray_device.h"

namespace backbend::render {
namespace {

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

RayCost measure_rays(const Scene& scene, const MeshTopology& mesh,
                     std::span<const glm::vec3> position, const Camera& camera, Settings settings,
                     int repeats) {
  settings.threads = 1;
  RayRecord record;
  {
    const RecordRays recording(record);
    scene.render(camera, settings);
  }
  RayCost cost;
  for (const RayRecord::Batch& batch : record.batches) {
    (batch.kind == RayRecord::Kind::camera      ? cost.camera_rays
     : batch.kind == RayRecord::Kind::scattered ? cost.scattered_rays
                                                : cost.shadow_rays) += batch.count;
  }
  const BareRayScene bare(mesh.triangle, position);
  std::vector<double> frame_s, rays_s;
  const FlushDenormals flush;
  for (int i = 0; i < std::max(repeats, 1); ++i) {
    const double start = thread_seconds();
    scene.render(camera, settings);
    const double rendered = thread_seconds();
    const std::size_t hits = bare.trace(record);
    rays_s.push_back(thread_seconds() - rendered);
    frame_s.push_back(rendered - start);
    // Rounding at edges may differ between the two trees, by a ray in many thousands.
    const std::size_t more = std::max(hits, record.hits), fewer = std::min(hits, record.hits);
    if (more - fewer > record.ray_count() / 1000)
      throw RenderError("bench: the bare device hits " + std::to_string(hits) +
                        " times, the frame's rays " + std::to_string(record.hits));
  }
  cost.frame_s = median(frame_s);
  cost.rays_s = median(rays_s);
  return cost;
}

}  // namespace backbend::render
