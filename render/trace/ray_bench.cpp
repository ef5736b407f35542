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
  const BareRayScene medium(mesh.triangle, position, TreeQuality::medium),
      high(mesh.triangle, position, TreeQuality::high);
  using Kind = RayRecord::Kind;
  for (const Kind kind : {Kind::camera, Kind::scattered, Kind::shadow}) {
    cost.rays[static_cast<std::size_t>(kind)] = record.ray_count(kind);
    for (const TreeQuality quality : {TreeQuality::medium, TreeQuality::high})
      for (const RayWay way : ray_ways())
        for (const bool coherent : {true, false})
          cost.rates.push_back({kind, quality, way, coherent, 0.0});
  }
  std::vector<double> frame_s;
  std::vector<std::vector<double>> seconds(cost.rates.size());
  const FlushDenormals flush;
  for (int i = 0; i < std::max(repeats, 1); ++i) {
    double start = thread_seconds();
    scene.render(camera, settings);
    frame_s.push_back(thread_seconds() - start);
    for (std::size_t r = 0; r < cost.rates.size(); ++r) {
      const RayRate& rate = cost.rates[r];
      start = thread_seconds();
      const std::size_t hits = (rate.quality == TreeQuality::high ? high : medium)
                                   .trace(record, rate.kind, rate.way, rate.coherent);
      seconds[r].push_back(thread_seconds() - start);
      // Rounding at edges may differ between two trees, by a ray in many thousands; a kind may have
      // few.
      const auto kind = static_cast<std::size_t>(rate.kind);
      const std::size_t most = std::max(hits, record.hits[kind]),
                        least = std::min(hits, record.hits[kind]);
      if (most - least > cost.all_rays() / 1000)
        throw RenderError("bench: the bare device hits " + std::to_string(hits) +
                          " times, the frame's rays " + std::to_string(record.hits[kind]));
    }
  }
  cost.frame_s = median(frame_s);
  for (std::size_t r = 0; r < cost.rates.size(); ++r) {
    RayRate& rate = cost.rates[r];
    rate.seconds = median(seconds[r]);
    RayRate& best = cost.best[static_cast<std::size_t>(rate.kind)];
    if (best.seconds == 0.0 || rate.seconds < best.seconds) best = rate;
    const bool as_asked = rate.quality == TreeQuality::medium && rate.way == RayWay::packet &&
                          rate.coherent == (rate.kind == Kind::camera);
    if (as_asked) cost.as_asked_s += rate.seconds;
  }
  return cost;
}

}  // namespace backbend::render
