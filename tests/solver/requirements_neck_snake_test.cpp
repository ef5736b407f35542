// Requirements on the neck and the snake that have no home in another test: research/seeds.md 2h,
// 2i.
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "solver/rig/controllers.h"
#include "solver/rig/solve_file.h"
#include "tests/solver/rig_fixture.h"
#include "tests/source_folder.h"

namespace backbend::solver {
namespace {

using namespace rigs;

const std::filesystem::path kAccept = source_folder() / "tests/accept";

/// The stored rows of each vertebra, head first: X, Y, Z and place.
std::vector<std::array<dvec3, 4>> stored_neck() {
  const auto json = nlohmann::json::parse(std::ifstream(kAccept / "mSaurus_neck.json"));
  std::vector<std::array<dvec3, 4>> vertebra;
  for (const auto& v : json.at("vertebrae")) {
    std::array<dvec3, 4> rows{};
    std::size_t r = 0;
    for (const char* row : {"row1_x_axis", "row2_y_axis", "row3_z_axis", "row4_position"}) {
      for (int c = 0; c < 3; ++c) rows[r][c] = v.at(row).at(std::size_t(c));
      ++r;
    }
    vertebra.push_back(rows);
  }
  return vertebra;
}

std::unique_ptr<SpineSystem> seed_neck() {
  return parse_solve_file("[rig]\nsystem = \"neck\"\n[chain]\nrest = \"mSaurus_neck.json\"\n",
                          "neck.toml", kAccept)
      .system;
}

TEST(Requirements, StoredNeckIsOrthonormalAndRunsAlongItsBones) {  // R89, R90, R91
  const auto v = stored_neck();
  ASSERT_EQ(v.size(), 14u);
  const double length[] = {6.63433, 7.41680, 8.36456, 8.88193, 8.60845, 8.47879, 9.33833,
                           9.06445, 8.51917, 9.02962, 9.81708, 9.95799, 10.87388};
  double least = 180.0, most = 0.0;
  std::size_t at = 0;
  for (std::size_t i = 0; i < 14; ++i) {
    for (int r = 0; r < 3; ++r) {
      EXPECT_NEAR(glm::length(v[i][std::size_t(r)]), 1.0, 2.5e-6);  // 2e-6 as printed
      EXPECT_NEAR(glm::dot(v[i][std::size_t(r)], v[i][std::size_t((r + 1) % 3)]), 0.0, 1e-6);
    }
    EXPECT_NEAR(glm::dot(glm::cross(v[i][0], v[i][1]), v[i][2]), 1.0, 4.5e-6);  // 4e-6 as printed
    EXPECT_GT(glm::dot(v[i][1], dvec3(-1, 0, 0)), 0.99);  // local Y is world -X
    if (i == 13) continue;
    const dvec3 bone = v[i][3] - v[i + 1][3];
    EXPECT_NEAR(glm::length(bone), length[i], 1e-4);
    const double off = degrees(angle_between(bone, -v[i + 1][0]));
    least = std::min(least, off);
    if (off > most) most = off, at = i + 1;
  }
  EXPECT_NEAR(most, 13.0524, 1e-3);
  EXPECT_EQ(at, 10u);
  EXPECT_NEAR(least, 1.25, 0.01);
}

TEST(Requirements, NeckControlsStandAtTheNeckAndMoveWithItsParent) {  // R119, R121, W10
  const auto neck = seed_neck();
  const RestChain none;
  const std::vector<double> still = rest_controls(*neck);
  std::vector<double> moved = still;
  const dvec3 step(7, -3, 11);
  for (int i = 0; i < 3; ++i) {
    moved[channel(*neck, std::string("parent_move.") + "xyz"[i])] = step[i];
  }
  const auto before = controller_shapes(*neck, none, still);
  const auto after = controller_shapes(*neck, none, moved);
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t s = 0; s < before.size(); ++s) {
    for (std::size_t l = 0; l < before[s].line.size(); ++l) {
      for (std::size_t end = 0; end < 2; ++end) {
        const dvec3 at = before[s].line[l][end];
        expect_near(after[s].line[l][end], at + step, 1e-9);
        EXPECT_LT(glm::distance(at, neck->rest().position[13]), 1.25 * 114.98536);
      }
    }
  }
}

// ---- snake ----

RestChain path_along_z() {
  RestChain chain;
  for (int i = 0; i <= 24; ++i) chain.path.point.push_back({0.0, 0.0, 5.0 * i});
  return chain;
}

TEST(Requirements, AttachingTheSnakeMovesNothing) {  // R137: rest is the path's own start
  const auto snake = build("snake", {}, path_along_z());
  const SpinePose& rest = snake->rest();
  for (std::size_t i = 0; i < rest.joint_count(); ++i) {
    expect_near(rest.position[i], {0, 0, 30.0 * double(i) / 99.0}, 1e-6);
    EXPECT_EQ(rest.turn[i], kNoTurn);
  }
}

TEST(Requirements, ASlideIsOneAnimatedChannel) {  // R123, R154
  const auto snake = build("snake", {}, path_along_z());
  std::vector<double> control = rest_controls(*snake);
  const SpinePose before = snake->solve(control);
  control[channel(*snake, "slide")] = 0.25;
  const SpinePose after = snake->solve(control);
  for (std::size_t i = 0; i < after.joint_count(); ++i) {
    expect_near(after.position[i] - before.position[i], {0, 0, 22.5}, 1e-9);
  }
}

}  // namespace
}  // namespace backbend::solver
