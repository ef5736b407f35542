#include <oneapi/tbb/parallel_for.h>

#include <algorithm>

#include "validate/calibrate/calibrate.h"
#include "validate/calibrate/faults.h"
#include "validate/metrics/surface/weight_hygiene.h"

namespace backbend::validate {
namespace {

constexpr std::uint64_t kWeights = 3000;  // stream of the draws

/// A joint that nothing near a vertex knows: of another vertex far from it, or -1 after many tries.
int far_joint(const skin::Character& character, std::size_t vertex, Draw& draw, double height) {
  for (int tries = 0; tries < 100; ++tries) {
    const std::size_t other = draw.index(character.vertex_count());
    if (glm::distance(character.bind_position[vertex], character.bind_position[other]) >
        0.3 * height)
      return character.influences[other].joint[0];
  }
  return -1;
}

}  // namespace

std::vector<Sensitivity> try_weight_detectors(const CalibrationPlan& plan,
                                              const CalibrationBody& body,
                                              const CalibrationWatch& watch) {
  const skin::Character& character = body.character();
  const WeightHygiene clean = examine_weights(character, character.influences);
  // Weights do not change with the pose: one reading is all the clean ones there are.
  const std::vector<double> clean_stray{static_cast<double>(clean.stray)};
  const std::vector<double> clean_sum{100.0 * clean.worst_sum};
  // An examination of a heavy mesh takes a while, and each vertex is one as good as another.
  const std::size_t tries = std::min<std::size_t>(plan.fault_poses, 50);

  const std::vector<double> sizes{0.02, 0.05, 0.1, 1.0};
  watch.begin("weights of " + body.name(), tries * (1 + sizes.size()));
  FaultTrial stray{1.0, std::vector<double>(tries, 0.0), 0};
  std::vector<char> named(tries, 0);
  oneapi::tbb::parallel_for(std::size_t{0}, tries, [&](std::size_t i) {
    Draw draw(plan.seed + kWeights, i);
    std::vector<skin::Influences> influences = character.influences;
    std::size_t vertex = 0;
    int joint = -1;
    while (joint < 0) {
      vertex = draw.index(influences.size());
      joint = far_joint(character, vertex, draw, body.metrics().height());
    }
    for (std::size_t v = 0; v < influences.size(); ++v)  // every vertex at that place
      if (character.place[v] == character.place[vertex])
        bind_vertex(influences[v], static_cast<std::uint16_t>(joint));
    const WeightHygiene found = examine_weights(character, influences);
    stray.value[i] = static_cast<double>(found.stray);
    named[i] =
        found.stray_vertex >= 0 &&
        character.place[static_cast<std::size_t>(found.stray_vertex)] == character.place[vertex];
    watch.step();
  });
  stray.placed = static_cast<std::size_t>(std::ranges::count(named, 1));

  std::vector<FaultTrial> sums;
  for (double size : sizes) {
    FaultTrial trial{size, std::vector<double>(tries, 0.0), 0};
    std::vector<char> right(tries, 0);
    oneapi::tbb::parallel_for(std::size_t{0}, tries, [&](std::size_t i) {
      Draw draw(plan.seed + kWeights + 1, i);
      std::vector<skin::Influences> influences = character.influences;
      const std::size_t vertex = draw.index(influences.size());
      scale_weights(influences[vertex], 1.0 + 0.01 * (draw.coin() ? size : -size));
      const WeightHygiene found = examine_weights(character, influences);
      trial.value[i] = 100.0 * found.worst_sum;
      right[i] = found.worst_sum_vertex == static_cast<int>(vertex);
      watch.step();
    });
    trial.placed = static_cast<std::size_t>(std::ranges::count(right, 1));
    sums.push_back(std::move(trial));
  }
  return {
      judge_detector("wrong vertex", "BB062", body.name(), "joint", 1.0, 0.0, clean_stray, {stray}),
      judge_detector("weight sum", "BB060", body.name(), "%", 0.1, threshold_from(clean_sum, 0.01),
                     clean_sum, sums)};
}

}  // namespace backbend::validate
