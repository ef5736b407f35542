// The emulations beside poses that Blender computed (tests/cli/blender_poses.py wrote the file;
// tests/cli/emulations_test.py asks the living program).
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/solver/rig_fixture.h"
#include "tests/source_folder.h"

namespace backbend::solver {
namespace {

using namespace rigs;
using nlohmann::json;

constexpr double kMostDegrees = 0.1, kMostOfSpine = 0.001;  // of any joint

dvec3 vector_of(const json& v) { return {v.at(0), v.at(1), v.at(2)}; }

std::vector<double> controls_of(const SpineSystem& system, const json& pose) {
  std::vector<double> control = rest_controls(system);
  for (const auto& [name, value] : pose.at("controls").items()) {
    const bool moves = name.ends_with("_move");
    for (int i = 0; i < 3; ++i) {
      const std::string axis = std::string(moves ? "." : ".r") + "xyz"[i];
      const double number = value.at(std::size_t(i));
      control[channel(system, name + axis)] = moves ? number : radians(number);
    }
  }
  return control;
}

/// Exactly half a turn of a control that is shared out: either way round is as short, and which of
/// them each constraint of Blender takes is decided by its rounding.
bool either_way_round(const SpinePose& pose) {
  return std::any_of(pose.flags.begin(), pose.flags.end(), [](const std::string& flag) {
    return flag.find("half a turn") != std::string::npos;
  });
}

TEST(Emulations, MeetTheStoredPosesOfBlender) {
  std::ifstream in(source_folder() / "tests/solver/blender_poses.json");
  const json all = json::parse(in);
  std::map<std::string, int> compared;
  for (const json& c : all.at("cases")) {
    SystemSpec spec{c.at("system"), {}};
    for (const auto& [key, value] : c.at("options").items()) {
      if (value.is_string()) {
        spec.options[key] = value.get<std::string>();
      } else if (value.is_array()) {
        spec.options[key] = value.get<std::vector<double>>();
      } else {
        spec.options[key] = value.get<double>();
      }
    }
    RestChain chain;
    for (const json& p : c.at("chain")) chain.joint.push_back(vector_of(p));
    const auto rig = build_system(spec, chain);
    const double spine = glm::length(chain.joint.back() - chain.joint.front());
    int left_out = 0;
    for (const json& p : c.at("poses")) {
      SCOPED_TRACE(c.at("name").get<std::string>() + ": " + p.at("controls").dump());
      const SpinePose pose = rig->solve(controls_of(*rig, p));
      if (spec.system == "matrix_blend" && either_way_round(pose)) {
        ++left_out;
        continue;
      }
      ASSERT_EQ(pose.joint_count(), p.at("position").size());
      for (std::size_t k = 0; k < pose.joint_count(); ++k, ++compared[spec.system]) {
        const dvec3 place = vector_of(p.at("position").at(k));
        EXPECT_LE(glm::length(pose.position[k] - place), kMostOfSpine * spine) << k;
        const json& q = p.at("turn").at(k);
        const dquat turn = glm::normalize(dquat(q.at(0), q.at(1), q.at(2), q.at(3)));
        EXPECT_LE(degrees(angle_between(pose.turn[k], turn)), kMostDegrees) << k;
      }
    }
    EXPECT_EQ(left_out, spec.system == "matrix_blend" ? 2 : 0);  // extension 180 and twist 180
  }
  EXPECT_GT(compared["matrix_blend"], 500);
  EXPECT_GT(compared["spline_ik"], 300);
}

}  // namespace
}  // namespace backbend::solver
