// Requirements on the traditional three controls and on the lengths of the seeds that have no home
// in another test: research/seeds.md 2a to 2g.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "solver/curves/curve.h"
#include "solver/rig/controllers.h"
#include "solver/rig/solve_file.h"
#include "solver/rig/system_controller.h"
#include "solver/systems/fk_bones.h"
#include "tests/solver/rig_fixture.h"

namespace backbend::solver {
namespace {

using namespace rigs;

dvec3 arrow(const ControllerShape& shape) {
  return glm::normalize(shape.line[4][1] - shape.line[4][0]);
}

dvec3 middle_of_square(const ControllerShape& shape) {
  dvec3 sum(0.0);
  for (std::size_t edge = 0; edge < 4; ++edge) sum += shape.line[edge][0];
  return sum / 4.0;
}

TEST(Requirements, ThreeControlsHaveNineRotationsAndNothingElse) {  // R16
  for (const char* system : {"three_bone", "curve"}) {
    const auto rig = build(system);
    ASSERT_EQ(rig->channels().size(), 9u);
    for (const Channel& c : rig->channels()) {
      EXPECT_EQ(c.kind, Channel::Kind::rotation) << c.name;
      EXPECT_EQ(c.rest, 0.0) << c.name;
    }
  }
}

TEST(Requirements, IsnerHasHipChestAndTwoDepths) {  // R11
  const auto isner = build("isner");
  std::vector<std::string> controls;
  for (const Channel& c : isner->channels()) {
    const std::string control = c.name.substr(0, c.name.find('.'));
    if (std::find(controls.begin(), controls.end(), control) == controls.end()) {
      controls.push_back(control);
    }
  }
  EXPECT_EQ(controls, (std::vector<std::string>{"hip", "chest", "hip_move", "chest_move",
                                                "hip_depth", "chest_depth"}));
}

TEST(Requirements, ControlsRideOnTheirBonesInPlaceAndTurn) {  // R40, R45, R47, R158
  for (const RestChain& chain : {straight(), curved()}) {
    const auto fk = build("three_bone", {}, chain);
    const auto at_rest = controller_shapes(*fk, chain, pose_a());
    for (const auto& pose : {pose_a(), pose_b(), pose_c(), pose_e(), pose_f()}) {
      const SpinePose posed = fk->solve(pose);
      const auto shapes = controller_shapes(*fk, chain, pose);
      for (std::size_t bone = 0; bone < 3; ++bone) {
        expect_near(middle_of_square(shapes[bone]), posed.position[bone], 1e-12);
        expect_near(arrow(shapes[bone]), posed.turn[bone] * arrow(at_rest[bone]), 1e-12);
      }
    }
  }
}

TEST(Requirements, ControlArrowsPointForwardAndTellQuarterTurnsApart) {  // R41, R42
  const auto curve = build("curve");
  const auto shapes = controller_shapes(*curve, straight(), pose_a());
  for (const ControllerShape& shape : shapes) {
    EXPECT_LT(degrees(angle_between(arrow(shape), dvec3(0, 0, 1))), 1e-6);
  }
  // A square alone looks the same after a quarter of a turn about its bone; its arrow does not.
  const auto turned =
      controller_shapes(*curve, straight(), pose_deg({90, 0, 0}, {0, 0, 0}, {0, 0, 0}));
  EXPECT_NEAR(degrees(angle_between(arrow(turned[0]), arrow(shapes[0]))), 90.0, 1e-9);
  for (std::size_t corner = 0; corner < 4; ++corner) {
    double nearest = 1e9;
    for (std::size_t other = 0; other < 4; ++other) {
      nearest =
          std::min(nearest, glm::distance(turned[0].line[corner][0], shapes[0].line[other][0]));
    }
    EXPECT_LT(nearest, 1e-12);
  }
}

TEST(Requirements, ControlsHaveThreeColours) {  // R55
  const auto shapes = controller_shapes(*build("curve"), straight(), pose_a());
  ASSERT_EQ(shapes.size(), 3u);
  EXPECT_NE(shapes[0].color, shapes[1].color);
  EXPECT_NE(shapes[1].color, shapes[2].color);
  EXPECT_NE(shapes[0].color, shapes[2].color);
}

TEST(Requirements, ZerosRestoreTheBindPoseAfterAnyPose) {  // R44
  for (const char* system : {"three_bone", "curve", "even"}) {
    const auto rig = build(system, {}, curved());
    SpinePose pose;
    for (const auto& nine : {pose_f(), pose_e(), pose_a()}) {
      std::vector<double> control = rest_controls(*rig);
      std::copy(nine.begin(), nine.end(), control.begin());
      rig->solve_into(control, Detail::all, pose);
    }
    EXPECT_EQ(pose.position, rig->rest().position);
    EXPECT_EQ(pose.turn, rig->rest().turn);
  }
}

TEST(Requirements, LowerTurnsAllThreeControlsAndNoChannel) {  // R46
  const auto pose = pose_deg({0, 0, 30}, {0, 0, 0}, {0, 0, 0});
  const SpinePose posed = build("three_bone")->solve(pose);
  const dquat expected = turn_about({1, 0, 0}, radians(30));  // bone Z is world X
  for (std::size_t bone = 0; bone < 3; ++bone) {
    EXPECT_LT(angle_between(posed.turn[bone], expected), 1e-12);
  }
}

TEST(Requirements, FourDrawnJointsAreAllThatIsNeeded) {  // R57
  const SolveFile file = parse_solve_file(
      "[rig]\nsystem = \"curve\"\n[chain]\njoints = [[0,0,0],[0,2,0],[0,4,0],[0,6,0]]\n", "a.toml",
      ".");
  EXPECT_EQ(file.system->rest().joint_count(), 11u);
  EXPECT_EQ(file.control.size(), 9u);
}

TEST(Requirements, KeysOfAFileMayComeInAnyOrder) {  // R116
  const std::string tables[] = {"[rig]\nsystem = \"curve\"\nbones = 8\nroll = \"full\"\n",
                                "[chain]\njoints = [[0,0,0],[0,2,0],[0,4,0],[0,6,0]]\n",
                                "[pose]\ntop = [10, 20, 30]\nlower.rz = 4\n"};
  const std::string swapped[] = {"[rig]\nroll = \"full\"\nbones = 8\nsystem = \"curve\"\n",
                                 tables[1], "[pose]\nlower.rz = 4\ntop = [10, 20, 30]\n"};
  const std::string expected =
      solve_to_json(parse_solve_file(tables[0] + tables[1] + tables[2], "a.toml", "."));
  int order[] = {0, 1, 2};
  do {
    const auto text = swapped[order[0]] + swapped[order[1]] + swapped[order[2]];
    EXPECT_EQ(solve_to_json(parse_solve_file(text, "a.toml", ".")), expected);
  } while (std::next_permutation(order, order + 3));
}

TEST(Requirements, RatioOfTheStretchIsOneNumberByNodesOrDirectly) {  // R73, R163
  // The Maya form: one node for each operation, as the author drew it.
  const auto op = [](auto f) {
    return [f](SystemElement::Input in, std::span<double> out) { out[0] = f(in[0][0], in[1][0]); };
  };
  const SystemController nodes(
      {{"length", {6}}, {"rest_length", {6}}, {"stretchiness", {0}}},
      {{"delta", {"length", "rest_length"}, 1, op([](double a, double b) { return a - b; })},
       {"scaled", {"delta", "stretchiness"}, 1, op([](double a, double b) { return a * b; })},
       {"wanted", {"scaled", "rest_length"}, 1, op([](double a, double b) { return a + b; })},
       {"ratio", {"wanted", "rest_length"}, 1, op([](double a, double b) { return a / b; })}});
  const std::array<dvec3, 4> rest{dvec3(0, 0, 0), {0, 2, 0}, {0, 4, 0}, {0, 6, 0}};
  const std::array<dvec3, 4> shapes[] = {
      {dvec3(0, 0, 0), {0, 3, 0}, {0, 6, 0}, {0, 9, 0}},
      {dvec3(0, 0, 0), {0, 1.5, 0}, {0, 3, 0}, {0, 4.5, 0}},
      {dvec3(0, 0, 0), {0, 3, 0}, {0, 5, 3}, {0, 4, 7}},
      {dvec3(0, 0, 0), {0, 9, 0}, {3, -3, 5}, {0, 6, 0}},
  };
  RestChain chain;
  chain.curve.assign(rest.begin(), rest.end());
  const auto stretchy = build("stretchy", {}, chain);
  SystemController::State state = nodes.start();
  for (const auto& cv : shapes) {
    for (const double s : {0.0, 0.25, 0.5, 1.0}) {
      std::vector<double> control = rest_controls(*stretchy);
      for (std::size_t i = 0; i < 12; ++i) control[i] = cv[i / 3][int(i % 3)];
      control[channel(*stretchy, "stretchiness")] = s;
      const double length = Curve::bezier(cv).length(), start = Curve::bezier(rest).length();
      nodes.set(state, "length", std::span(&length, 1));
      nodes.set(state, "rest_length", std::span(&start, 1));
      nodes.set(state, "stretchiness", std::span(&s, 1));
      nodes.update(state);
      EXPECT_EQ(nodes.value(state, "ratio")[0], measure(stretchy->solve(control), "ratio"));
    }
  }
}

TEST(Requirements, EveryFrameIsTheStaticSolveOfItsControls) {  // R113: no lag, any frame order
  for (const SystemInfo& info : list_systems()) {
    const auto rig = build(std::string(info.name));
    const auto at = [&](int frame) {
      return rig->controls_for({.extension = radians(frame), .twist = radians(2 * frame)},
                               Mapping::spread);
    };
    std::vector<SpinePose> forward;
    SpinePose running;
    for (int frame = 0; frame < 48; ++frame) {
      rig->solve_into(at(frame), Detail::all, running);
      forward.push_back(running);
    }
    for (int i = 0; i < 48; ++i) {
      const int frame = (i * 29) % 48;  // every frame once, out of order
      const SpinePose alone = rig->solve(at(frame));
      EXPECT_EQ(alone.position, forward[std::size_t(frame)].position) << info.name;
      EXPECT_EQ(alone.turn, forward[std::size_t(frame)].turn) << info.name;
    }
  }
}

}  // namespace
}  // namespace backbend::solver
