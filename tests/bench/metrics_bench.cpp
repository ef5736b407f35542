// Milliseconds that the geometry metrics of one pose take on one core: all of them but the exact
// self-intersection, and that alone. Both are timed in turns on the same poses, by processor time.
// The characters are those of BACKBEND_CHARACTERS; the round body is always there.
#include <benchmark/benchmark.h>
#include <tbb/global_control.h>
#include <time.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "validate/calibrate/calibration_body.h"

namespace backbend::validate {
namespace {

double thread_seconds() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

std::unique_ptr<CalibrationBody> human(const char* name) {
  const char* folder = std::getenv("BACKBEND_CHARACTERS");
  const std::filesystem::path file = std::filesystem::path(folder ? folder : ".") / name;
  if (!std::filesystem::exists(file)) return nullptr;
  skin::Character character = load_character(file);
  skin::Anatomy anatomy = skin::find_anatomy(character, {});
  return std::make_unique<CalibrationBody>(std::move(character), std::move(anatomy));
}

double median(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return values[values.size() / 2];
}

/// A bend with some twist: nothing of the body stays where it was.
void measure(benchmark::State& state, const std::unique_ptr<CalibrationBody>& body) {
  if (!body) {
    state.SkipWithError("BACKBEND_CHARACTERS has no such character");
    return;
  }
  const oneapi::tbb::global_control one(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  const auto rig = body->stage().build({"even", {}});
  const RigAtRest rest = rig_at_rest(*rig);
  const solver::BodyPose pose{radians_from(60.0), 0.0, radians_from(10.0), radians_from(20.0)};
  const std::vector<double> control = rig->controls_for(pose, solver::Mapping::chest);
  const PosedCharacter posed = body->stage().pose(*rig, control);
  std::vector<double> whole, crossing;
  for (auto _ : state) {
    const double start = thread_seconds();
    benchmark::DoNotOptimize(body->metrics().measure(rest, control, posed.spine, posed.mesh,
                                                     pose.twist, false, Crossing::measured,
                                                     posed.world_from_node));
    const double middle = thread_seconds();
    benchmark::DoNotOptimize(body->metrics().self_intersection(posed.mesh.position));
    whole.push_back(middle - start);
    crossing.push_back(thread_seconds() - middle);
  }
  const double vertices = static_cast<double>(body->character().vertex_count());
  const double triangles = static_cast<double>(body->character().triangles.size());
  const double rest_ms = 1e3 * (median(whole) - median(crossing));
  state.counters["vertices"] = vertices;
  state.counters["triangles"] = triangles;
  state.counters["metrics_ms"] = rest_ms;
  state.counters["metrics_ms_per_100k_vertices"] = rest_ms * 1e5 / vertices;
  state.counters["crossing_ms"] = 1e3 * median(crossing);
  state.counters["crossing_ms_per_200k_triangles"] = 1e3 * median(crossing) * 2e5 / triangles;
}

void round_body(benchmark::State& state) { measure(state, tube_body(24)); }
void human_13k(benchmark::State& state) { measure(state, human("mh_female_cmu_13k.glb")); }
void human_214k(benchmark::State& state) { measure(state, human("mh_male_214k.glb")); }

BENCHMARK(round_body)->Unit(benchmark::kMillisecond);
BENCHMARK(human_13k)->Unit(benchmark::kMillisecond);
BENCHMARK(human_214k)->Unit(benchmark::kMillisecond)->Iterations(15);

}  // namespace
}  // namespace backbend::validate

BENCHMARK_MAIN();
