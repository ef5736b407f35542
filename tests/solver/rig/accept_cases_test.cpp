// Every case of tests/accept/solver_cases.json, through the reader and the writer that the command
// uses. The numbers were derived by independent models; see the file's own "about".
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "solver/math/rotation.h"
#include "solver/rig/solve_file.h"
#include "tests/source_folder.h"

namespace backbend::solver {
namespace {

using nlohmann::json;

const std::filesystem::path kAccept = source_folder() / "tests/accept";

const json& cases() {
  static const json all = [] {
    std::ifstream in(kAccept / "solver_cases.json");
    return json::parse(in).at("cases");
  }();
  return all;
}

class AcceptCase : public testing::TestWithParam<std::size_t> {};

TEST_P(AcceptCase, GivesTheExpectedNumbers) {
  const json& c = cases().at(GetParam());
  const json pose = json::parse(
      solve_to_json(parse_solve_file(c.at("toml").get<std::string>(), "case.toml", kAccept)));
  const json& expect = c.at("expect");
  const json& joints = pose.at("joints");
  int compared = 0;

  if (expect.contains("positions")) {
    const double tolerance = c.at("tol_position");
    for (std::size_t i = 0; i < expect["positions"].size(); ++i, ++compared) {
      const std::size_t joint =
          expect.contains("joint_indices") ? expect["joint_indices"][i].get<std::size_t>() : i;
      ASSERT_LT(joint, joints.size());
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(joints[joint]["position"][axis].get<double>(),
                    expect["positions"][i][axis].get<double>(), tolerance)
            << "joint " << joint << " axis " << axis;
      }
    }
    if (!expect.contains("joint_indices")) {
      EXPECT_EQ(joints.size(), expect["positions"].size());
    }
  }
  if (expect.contains("turns_wxyz")) {
    const auto turn = [](const json& q) { return glm::dquat(q[0], q[1], q[2], q[3]); };
    for (std::size_t i = 0; i < expect["turns_wxyz"].size(); ++i, ++compared) {
      const double apart =
          angle_between(turn(joints[i]["turn"]), glm::normalize(turn(expect["turns_wxyz"][i])));
      EXPECT_LE(degrees(apart), c.at("tol_turn_deg").get<double>()) << "joint " << i;
    }
  }
  if (expect.contains("measures")) {
    for (const auto& [key, value] : expect["measures"].items()) {
      ASSERT_TRUE(pose["measures"].contains(key)) << key;
      EXPECT_NEAR(pose["measures"][key].get<double>(), value.get<double>(),
                  c.at("tol_measure").get<double>())
          << key;
      ++compared;
    }
  }
  EXPECT_GT(compared, 0) << "the case expects nothing";
}

std::string test_name(const testing::TestParamInfo<std::size_t>& info) {
  std::string name = cases().at(info.param).at("name");
  for (char& ch : name) {
    if (!std::isalnum(static_cast<unsigned char>(ch))) ch = '_';
  }
  return name;
}

INSTANTIATE_TEST_SUITE_P(Solver, AcceptCase, testing::Range<std::size_t>(0, 27), test_name);

TEST(AcceptCases, AreAllRun) { EXPECT_EQ(cases().size(), 27u); }

}  // namespace
}  // namespace backbend::solver
