// What tests/bench/python_module.py is held against: the same work by the same calls. Reads `skin`
// or `solve` and a number of repeats, line by line, and answers each with the seconds of one.
#include <chrono>
#include <functional>
#include <glm/trigonometric.hpp>
#include <iostream>
#include <map>
#include <random>
#include <string>

#include "skin/deform/skinning_plan.h"
#include "solver/rig/crowd.h"
#include "validate/judge/confirmed.h"
#include "validate/measure/measure.h"
#include "validate/stage/stage.h"

namespace {

using namespace backbend;

constexpr int kPoses = 10'000;

double seconds(int repeat, const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < repeat; ++i) work();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  return took.count() / repeat;
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::cerr << "usage: python_reference CHARACTER\n";
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

  std::mt19937 rng(1);
  std::uniform_real_distribution<double> angle(glm::radians(-60.0), glm::radians(60.0));
  std::vector<double> value(even->channels().size() * kPoses);
  for (double& v : value) v = angle(rng);
  solver::CrowdPose crowd;
  const std::map<std::string, std::function<void()>> work = {
      {"skin", [&] { plan.skin(nodes, mesh); }},
      {"solve", [&] {
         solver::solve_crowd(*even, {value, kPoses}, crowd);
       }}};
  std::string what;
  for (int repeat = 0; std::cin >> what >> repeat;)
    std::cout << seconds(repeat, work.at(what)) << std::endl;
  return 0;
}
