// What tests/bench/python_module.py is held against: the same work by the same calls. Seconds.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <glm/trigonometric.hpp>
#include <limits>
#include <random>

#include "skin/deform/skinning_plan.h"
#include "solver/rig/crowd.h"
#include "validate/judge/confirmed.h"
#include "validate/measure/measure.h"
#include "validate/stage/stage.h"

namespace {

using namespace backbend;

constexpr int kRounds = 7, kPoses = 10'000;

double best_seconds(int repeat, const std::function<void()>& work) {
  double best = std::numeric_limits<double>::infinity();
  work();
  for (int round = 0; round < kRounds; ++round) {
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 0; i < repeat; ++i) work();
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    best = std::min(best, took.count() / repeat);
  }
  return best;
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "usage: python_reference CHARACTER\n");
    return 2;
  }
  validate::ConfirmedCharacter confirmed = validate::load_confirmed(arguments[1], {});
  const validate::Stage stage(std::move(confirmed.character), confirmed.hints);
  const auto even = stage.build({"even", {}});
  validate::PoseDegrees pose;
  pose.extension = 60.0;
  const auto nodes =
      stage.pose(*even, validate::controls_at(*even, pose, solver::Mapping::chest)).world_from_node;
  const skin::SkinningPlan plan(stage.character());
  skin::PosedMesh mesh;
  std::printf("skin %.9f\n", best_seconds(200, [&] { plan.skin(nodes, mesh); }));

  std::mt19937 rng(1);
  std::uniform_real_distribution<double> angle(glm::radians(-60.0), glm::radians(60.0));
  std::vector<double> value(even->channels().size() * kPoses);
  for (double& v : value) v = angle(rng);
  solver::CrowdPose crowd;
  std::printf("solve %.9f\n", best_seconds(1, [&] {
                solver::solve_crowd(*even, {value, kPoses}, crowd);
              }));
  return 0;
}
