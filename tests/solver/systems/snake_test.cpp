// The snake, requirement by requirement (research/seeds.md 2i). Fixture: 16 controls, 100 joints,
// length 30 on a straight path of 120 along +Z; up +Y, side +X.
#include <cmath>

#include "solver/curves/curve.h"
#include "solver/curves/path_frames.h"
#include "solver/rig/option_reader.h"
#include "solver/rig/solve_file.h"
#include "tests/solver/rig_fixture.h"

namespace backbend::solver {
namespace {

using namespace rigs;

RestChain straight_path() {
  RestChain chain;
  for (int i = 0; i <= 24; ++i) chain.path.point.push_back({0.0, 0.0, 5.0 * i});
  return chain;
}

/// A path that turns through half a circle and climbs.
RestChain winding_path() {
  RestChain chain;
  for (int i = 0; i <= 24; ++i) {
    const double a = kPi * i / 24.0;
    chain.path.point.push_back({40.0 * std::cos(a), 0.5 * i, 40.0 * std::sin(a)});
  }
  return chain;
}

using Pose = std::vector<std::pair<std::string, double>>;

std::vector<double> controls(const SpineSystem& snake, const Pose& values) {
  std::vector<double> control = rest_controls(snake);
  for (const auto& [name, value] : values) control[channel(snake, name)] = value;
  return control;
}

SpinePose solved(const SpineSystem& snake, const Pose& values) {
  return snake.solve(controls(snake, values));
}

double spacing_sum(const SpinePose& pose) {
  double sum = 0.0;
  for (std::size_t i = 1; i < pose.joint_count(); ++i) {
    sum += glm::length(pose.position[i] - pose.position[i - 1]);
  }
  return sum;
}

const Pose kSlither{{"slide", 0.5}, {"amplitude", 1.5}, {"frequency", 75.0}};

Pose with(Pose pose, const std::string& name, double value) {
  pose.push_back({name, value});
  return pose;
}

TEST(Snake, StandsUprightWhereItsChainRunsAlongItsLeft) {
  RestChain chain;  // up by the cross of both would be nowhere
  for (int i = 0; i <= 10; ++i) chain.joint.push_back({0.1 * i, 0.0, 0.0});
  chain.left = {1.0, 0.0, 0.0};
  const auto snake = build("snake", {{"joints", 10.0}}, chain);
  const SpinePose pose = solved(*snake, {{"slide", 0.25}});
  for (std::size_t i = 0; i < pose.joint_count(); ++i) {
    EXPECT_NEAR(glm::length(pose.position[i] - dvec3(pose.position[i].x, 0, 0)), 0.0, 1e-9) << i;
    EXPECT_LT(angle_between(pose.turn[i], glm::dquat(1, 0, 0, 0)), 1e-9) << i;
  }
}

TEST(Snake, OneChannelMovesTheWholeBodyAlongThePath) {  // R123, R140, R154
  const auto snake = build("snake", {}, straight_path());
  for (const auto& [slide, tail] : {std::pair{0.0, 0.0}, {0.5, 45.0}, {1.0, 90.0}}) {
    const SpinePose pose = solved(*snake, {{"slide", slide}});
    expect_near(pose.position.front(), {0, 0, tail}, 1e-9);
    expect_near(pose.position.back(), {0, 0, tail + 30.0}, 1e-9);
    for (const dquat& q : pose.turn) EXPECT_LE(angle_between(q, kNoTurn), 1e-12);
  }
}

TEST(Snake, SlideStopsAtTheEndsSoThatControlsNeverBunch) {  // R138, R139
  const auto snake = build("snake", {}, straight_path());
  for (const auto& [slide, same] : {std::pair{-0.5, 0.0}, {1.5, 1.0}}) {
    const SpinePose pose = solved(*snake, {{"slide", slide}});
    for (std::size_t i = 0; i < pose.joint_count(); ++i) {
      expect_near(pose.position[i], solved(*snake, {{"slide", same}}).position[i], 1e-12);
    }
    EXPECT_FALSE(pose.flags.empty());
  }
}

TEST(Snake, WithoutStretchTheJointsKeepTheirSpacing) {  // R126
  const auto snake = build("snake", {}, straight_path());
  const SpinePose pose = solved(*snake, kSlither);
  EXPECT_NEAR(measure(pose, "body_length"), 33.403749, 1e-3);
  EXPECT_NEAR(measure(pose, "min_spacing"), 30.0 / 99.0, 1e-9);
  EXPECT_NEAR(measure(pose, "max_spacing"), 30.0 / 99.0, 1e-9);
  EXPECT_NEAR(spacing_sum(pose), 30.0, 1e-8);
}

TEST(Snake, StretchyFollowsTheRibbonAndEndsOnTheCurve) {  // R125, R129 (oracle)
  const auto snake = build("snake", {}, straight_path());
  const SpinePose pose = solved(*snake, with(kSlither, "stretchy", 1.0));
  EXPECT_NEAR(spacing_sum(pose), 33.394211, 1e-3);
  EXPECT_LT(measure(pose, "end_gap"), 1e-6);
  EXPECT_LT(measure(pose, "start_gap"), 1e-6);
  // Between both: the mean of the parameters lies between the places on the curve.
  const SpinePose half = solved(*snake, with(kSlither, "stretchy", 0.5));
  const SpinePose none = solved(*snake, kSlither);
  EXPECT_GT(half.position[99].z, none.position[99].z);
  EXPECT_LT(half.position[99].z, pose.position[99].z);
}

TEST(Snake, ClosestPointAndWalkAgreeWhileTheBodyDoesNotCrossItself) {  // R128, A36
  const auto walk = build("snake", {{"joints", 30.0}}, straight_path());
  const auto nearest = build("snake", {{"joints", 30.0}, {"closest", "nearest"}}, straight_path());
  const SpinePose a = solved(*walk, kSlither), b = solved(*nearest, kSlither);
  for (std::size_t i = 0; i < a.joint_count(); ++i) {
    expect_near(a.position[i], b.position[i], 1e-6);
  }
}

TEST(Snake, SlitherIsTheSeedsSineInRadians) {  // R143, R144, R145, R146, A32
  // Every control's place shows in the body curve; the first control is its start.
  const auto snake = build("snake", {}, straight_path());
  const auto start_x = [&](const Pose& pose) {
    return snake->intended_curve(controls(*snake, pose), 2).front().x;
  };
  // u of the first control at slide s is s (1 - maxU) = 0.75 s.
  const double u = 0.75 * 0.4;
  EXPECT_NEAR(start_x({{"slide", 0.4},
                       {"amplitude", 2.0},
                       {"frequency", 30.0},
                       {"offset", 10.0},
                       {"blend.0", 0.5}}),
              2.0 * 0.5 * std::sin((u + 0.1) * 30.0), 1e-9);
  EXPECT_NEAR(start_x({{"slide", 0.4}, {"amplitude", 2.0}, {"frequency", 30.0}, {"offset", 100.0}}),
              2.0 * std::sin((u + 1.0) * 30.0), 1e-9);
  EXPECT_EQ(start_x({{"slide", 0.4}, {"frequency", 30.0}}), 0.0);
}

TEST(Snake, AWaveTravelsByTheOffsetAsItDoesAlongThePath) {  // R168: 1 of offset is 0.01 of U
  const auto snake = build("snake", {}, straight_path());
  // 0.01 of U in slide is 0.01 / 0.75.
  const SpinePose a =
      solved(*snake, {{"slide", 0.2}, {"amplitude", 1.0}, {"frequency", 40.0}, {"offset", 3.0}});
  const SpinePose b =
      solved(*snake, {{"slide", 0.2 + 0.03 / 0.75}, {"amplitude", 1.0}, {"frequency", 40.0}});
  for (std::size_t i = 0; i < a.joint_count(); ++i) {
    EXPECT_NEAR(a.position[i].x, b.position[i].x, 1e-9);
    EXPECT_NEAR(a.position[i].z + 0.03 * 120.0, b.position[i].z, 1e-9);
  }
}

TEST(Snake, SlitherIsFixedToThePath) {  // R149, R152: the head comes where the tail will be
  const auto snake = build("snake", {{"controls", 31.0}}, straight_path());
  // One control step is 1 of 120; sliding by it puts control i where i + 1 was.
  const double step = (1.0 / 120.0) / 0.75;
  const SpinePose a =
      solved(*snake, {{"slide", 0.3}, {"amplitude", 1.0}, {"frequency", 60.0}, {"stretchy", 1.0}});
  const SpinePose b = solved(
      *snake, {{"slide", 0.3 + step}, {"amplitude", 1.0}, {"frequency", 60.0}, {"stretchy", 1.0}});
  // Compared by place along the path, away from the clamped ends of the body curve.
  for (std::size_t i = 20; i < 80; ++i) {
    const double z = b.position[i].z;
    std::size_t k = 1;
    while (a.position[k].z < z) ++k;
    const double f = (z - a.position[k - 1].z) / (a.position[k].z - a.position[k - 1].z);
    EXPECT_NEAR(b.position[i].x, glm::mix(a.position[k - 1].x, a.position[k].x, f), 5e-3);
  }
}

TEST(Snake, SlitherTurnsWithThePathAndStaysWithinItsAmplitude) {  // R142, R151
  const auto snake = build("snake", {}, winding_path());
  const Curve path = Curve::bspline(winding_path().path.point);
  const SpinePose pose =
      solved(*snake, {{"slide", 0.5}, {"amplitude", 1.5}, {"frequency", 75.0}, {"stretchy", 1.0}});
  double farthest = 0.0;
  for (const dvec3& p : pose.position) {
    farthest = std::max(farthest, glm::length(p - path.point(path.closest_parameter(p))));
  }
  // The body curve lies in the hull of its controls, whose chords cut the path's bends by a little.
  EXPECT_LE(farthest, 1.5 + 0.05);
  EXPECT_GE(farthest, 1.0);
}

TEST(Snake, PathFramesHaveTheSideAcrossThePath) {  // R141, A34
  const PathFrames frames(Curve::bspline(winding_path().path.point), {0, 1, 0});
  for (double u = 0.0; u <= 1.0; u += 0.01) {
    const PathFrames::Place place = frames.at(u);
    const auto& f = place.frame;
    EXPECT_NEAR(glm::dot(f[0], f[2]), 0.0, 1e-12);
    EXPECT_NEAR(glm::dot(f[1], f[2]), 0.0, 1e-12);
    expect_near(glm::cross(f[0], f[1]), f[2], 1e-12);
    EXPECT_NEAR(glm::length(f[1]), 1.0, 1e-12);
  }
  const PathFrames straight(Curve::bspline(straight_path().path.point), {0, 1, 0});
  expect_near(straight.at(0.3).frame[0], kAxisX, 1e-12);
}

TEST(Snake, AVerticalLoopDoesNotFlipTheSide) {  // A34: up is transported, never fixed
  RestChain chain;
  for (int i = 0; i <= 32; ++i) {
    const double a = 2.0 * kPi * i / 32.0;
    chain.path.point.push_back({0.0, 10.0 - 10.0 * std::cos(a), 10.0 * std::sin(a)});
  }
  const PathFrames frames(Curve::bspline(chain.path.point), {0, 1, 0});
  for (double u = 0.0; u <= 1.0; u += 0.005) expect_near(frames.at(u).frame[0], kAxisX, 1e-9);
}

TEST(Snake, ATwistedPathKeepsItsFramesSmooth) {
  RestChain chain;  // a helix: torsion everywhere
  for (int i = 0; i <= 60; ++i) {
    const double a = 0.4 * i;
    chain.path.point.push_back({5.0 * std::cos(a), 1.0 * i, 5.0 * std::sin(a)});
  }
  const Curve path = Curve::bspline(chain.path.point);
  const PathFrames frames(path, {1, 0, 0});
  // An oracle: shortest arcs between 60000 tangents, whose error falls with the square of the step.
  constexpr int kSteps = 60000;
  CurvePoint before = path.at_fraction(0.0);
  dvec3 up = frames.at(0.0).frame[1];
  for (int i = 1; i <= kSteps; ++i) {
    const CurvePoint after = path.at_fraction(double(i) / kSteps);
    up = shortest_arc(before.tangent, after.tangent, up) * up;
    before = after;
    if (i % 1000 == 0) expect_near(frames.at(double(i) / kSteps).frame[1], up, 3e-7);
  }
}

TEST(Snake, ABodyLongerThanItsCurveRunsStraightOnAndSaysSo) {
  const auto snake = build("snake", {}, straight_path());
  Pose pulled_back;  // every control half as far along: the body curve is 15 long
  for (int i = 0; i < 16; ++i) pulled_back.push_back({"detail.z" + std::to_string(i), -1.0 * i});
  const SpinePose pose = solved(*snake, pulled_back);
  EXPECT_NEAR(measure(pose, "body_length"), 15.0, 1e-9);
  EXPECT_NEAR(measure(pose, "min_spacing"), 30.0 / 99.0, 1e-9);
  expect_near(pose.position.back(), {0, 0, 30}, 1e-9);
  EXPECT_FALSE(pose.flags.empty());
  const SpinePose ribbon = solved(*snake, with(pulled_back, "stretchy", 1.0));
  expect_near(ribbon.position.back(), {0, 0, 15}, 1e-9);
}

TEST(Snake, DetailKeysMoveOneControlInItsOwnFrame) {  // R134, R136, R147
  const auto snake = build("snake", {}, winding_path());
  const SpinePose still = solved(*snake, {{"slide", 0.4}, {"stretchy", 1.0}});
  const SpinePose keyed = solved(*snake, {{"slide", 0.4}, {"stretchy", 1.0}, {"detail.y7", 1.0}});
  double moved = 0.0;
  for (std::size_t i = 0; i < still.joint_count(); ++i) {
    const dvec3 by = keyed.position[i] - still.position[i];
    moved = std::max(moved, by.y);
    // A cubic B-spline's control reaches two spans either way: joints far off do not move.
    if (i < 20 || i > 75) {
      EXPECT_NEAR(glm::length(by), 0.0, 1e-12) << i;
    }
  }
  EXPECT_NEAR(moved, 2.0 / 3.0, 0.01);  // the peak of a uniform cubic's basis
  // The first control is the curve's start: a key of 1 moves it by exactly 1 along its frame.
  const SpinePose first = solved(*snake, {{"slide", 0.4}, {"stretchy", 1.0}, {"detail.x0", 1.0}});
  EXPECT_NEAR(glm::length(first.position[0] - still.position[0]), 1.0, 1e-9);
}

TEST(Snake, RibbonOffsetsDeformTheBodyAndLeaveItsParametersAlone) {  // R133
  for (const double stretchy : {0.0, 0.4, 1.0}) {
    const auto snake = build("snake", {}, winding_path());
    const Pose base = with(with(kSlither, "stretchy", stretchy), "twist.9", 1.0);
    const SpinePose still = solved(*snake, base);
    const SpinePose once = solved(*snake, with(base, "ribbon.y7", 1.0));
    const SpinePose twice = solved(*snake, with(base, "ribbon.y7", 2.0));
    double most = 0.0;
    for (std::size_t i = 0; i < still.joint_count(); ++i) {
      const dvec3 by = once.position[i] - still.position[i];
      most = std::max(most, glm::length(by));
      // Parameters that moved along would make the way of a joint anything but proportional.
      expect_near(twice.position[i] - still.position[i], 2.0 * by, 1e-9);
      if (i < 20 || i > 75) {
        EXPECT_NEAR(glm::length(by), 0.0, 1e-12) << "a cubic reaches two spans: " << i;
      }
    }
    EXPECT_NEAR(most, 2.0 / 3.0, 0.01) << stretchy;
  }
}

TEST(Snake, SelectableSlitherAxis) {  // R148
  const auto snake = build("snake", {{"axis", "y"}}, straight_path());
  const SpinePose pose = solved(*snake, kSlither);
  double up = 0.0;
  for (const dvec3& p : pose.position) {
    EXPECT_NEAR(p.x, 0.0, 1e-12);
    up = std::max(up, p.y);
  }
  EXPECT_GT(up, 0.8);
}

TEST(Snake, TwistComesFromAnyPointOfTheBody) {  // R124
  const auto snake = build("snake", {}, straight_path());
  std::vector<double> control = rest_controls(*snake);
  const OptionValue key = std::vector<std::vector<double>>{{5.0, 90.0}};
  set_pose_key(*snake, "twist", key, control);
  const SpinePose pose = snake->solve(control);
  // Control 5 of 16 stands at U = 4/13 of the body curve.
  const auto joint = std::size_t(std::lround(99.0 * 10.0 / 30.0));
  EXPECT_NEAR(turn_between_deg(pose, snake->rest(), joint), 90.0, 1.5);
  EXPECT_NEAR(turn_between_deg(pose, snake->rest(), 0), 0.0, 1e-9);
  EXPECT_NEAR(turn_between_deg(pose, snake->rest(), 99), 0.0, 1e-9);
  double peak = 0.0;
  for (std::size_t i = 0; i < 100; ++i)
    peak = std::max(peak, turn_between_deg(pose, snake->rest(), i));
  EXPECT_NEAR(peak, 90.0, 1.5);
  for (const double bad : {-1.0, 16.0, 2.5}) {
    const OptionValue wrong = std::vector<std::vector<double>>{{bad, 90.0}};
    EXPECT_THROW(set_pose_key(*snake, "twist", wrong, control), OptionError);
  }
}

TEST(Snake, TwistKeysAtChosenPlacesAreHitExactly) {  // W14
  const auto snake = build(
      "snake", {{"twist_u", std::vector<double>{0.3, 0.7}}, {"joints", 1000.0}}, straight_path());
  std::vector<double> control = rest_controls(*snake);
  control[channel(*snake, "twist.0")] = radians(90.0);
  control[channel(*snake, "twist.1")] = radians(-45.0);
  const SpinePose pose = snake->solve(control);
  double most = -1e9, least = 1e9;
  for (std::size_t i = 0; i < pose.joint_count(); ++i) {
    const double twist = degrees(wrap(swing_twist(pose.turn[i], kAxisZ).twist_angle));
    most = std::max(most, twist);
    least = std::min(least, twist);
  }
  EXPECT_NEAR(most, 90.0, 0.5);
  EXPECT_NEAR(least, -45.0, 0.5);
  // And none at the ends, which have no key.
  const auto twist_at = [&](std::size_t joint) {
    return degrees(wrap(swing_twist(pose.turn[joint], kAxisZ).twist_angle));
  };
  EXPECT_NEAR(twist_at(0), 0.0, 0.5);
  EXPECT_NEAR(twist_at(999), 0.0, 0.5);
}

TEST(Snake, MarginVanishesWhereTheBodyDoublesBack) {
  const auto snake = build("snake", {{"joints", 12.0}, {"controls", 6.0}}, straight_path());
  for (const double margin : snake->rest().flip_margin) EXPECT_NEAR(margin, kPi, 1e-6);
  // The first control goes past the second: the body starts straight back along the path.
  const SpinePose folded = solved(*snake, {{"detail.z0", 12.0}, {"detail.x0", 1e-6}});
  EXPECT_LT(folded.flip_margin.back(), 1e-3);
  const SpinePose beside = solved(*snake, {{"detail.x0", 6.0}});
  EXPECT_GT(beside.flip_margin.back(), 1.0);
}

TEST(Snake, TwistPastAnyTurnNeverJumps) {
  const auto snake = build("snake", {}, straight_path());
  const auto at = [&](double deg) {
    return controls(*snake, {{"amplitude", 1.0}, {"frequency", 50.0}, {"twist.8", radians(deg)}});
  };
  EXPECT_LE(largest_step_deg(*snake, at, -720.0, 720.0, 5.0), 5.0 + 1e-9);
}

TEST(Snake, LeadChoosesTheEndThatKeepsItsControl) {  // A35
  const auto snake = build("snake", {}, straight_path());
  const SpinePose tail = solved(*snake, kSlither);
  EXPECT_LT(measure(tail, "start_gap"), 1e-9);
  EXPECT_NEAR(tail.position[99].z, 71.768, 2e-3);
  const SpinePose head = solved(*snake, with(kSlither, "lead", 1.0));
  EXPECT_LT(measure(head, "end_gap"), 1e-6);
  EXPECT_GT(measure(head, "start_gap"), 3.0);
}

TEST(Snake, SlidingIsContinuousOnAWindingPath) {
  const auto snake = build("snake", {{"joints", 40.0}}, winding_path());
  SpinePose before = solved(*snake, {{"slide", 0.0}, {"amplitude", 1.0}, {"frequency", 60.0}});
  for (int i = 1; i <= 200; ++i) {
    const SpinePose after =
        solved(*snake, {{"slide", i / 200.0}, {"amplitude", 1.0}, {"frequency", 60.0}});
    for (std::size_t j = 0; j < after.joint_count(); ++j) {
      // The head goes 97 along the path in 200 steps and swings by up to the slope of the sine.
      EXPECT_LT(glm::length(after.position[j] - before.position[j]), 1.0);
      EXPECT_LT(turn_between_deg(before, after, j), 15.0);
    }
    before = after;
  }
}

TEST(Snake, WavesBeyondAllMeasureEnd) {  // bones are below the last digit of the curve's length
  const auto snake = build("snake", {{"joints", 20.0}}, straight_path());
  for (const double amplitude : {1e9, 1e20, 1e29}) {
    for (const double lead : {0.0, 1.0}) {
      const SpinePose pose =
          solved(*snake, {{"amplitude", amplitude}, {"frequency", 75.0}, {"lead", lead}});
      for (const dvec3& p : pose.position) EXPECT_TRUE(std::isfinite(glm::length(p)));
    }
  }
}

TEST(Snake, AliasedSlitherAndLostUpAreSaid) {  // A32
  const auto snake = build("snake", {}, straight_path());
  // Controls are 1/60 of the path apart: waves of frequency pi * 60 are the shortest they can show.
  EXPECT_TRUE(solved(*snake, {{"amplitude", 1.0}, {"frequency", 188.0}}).flags.empty());
  EXPECT_FALSE(solved(*snake, {{"amplitude", 1.0}, {"frequency", 188.6}}).flags.empty());
  RestChain vertical = straight_path();
  vertical.path.up = {0, 0, 1};
  const SpinePose pose = solved(*build("snake", {}, vertical), kSlither);
  ASSERT_FALSE(pose.flags.empty());
  for (const dvec3& p : pose.position) EXPECT_TRUE(std::isfinite(glm::length(p)));
}

TEST(Snake, TakesTwoToAThousandJoints) {  // R131, R132: lists always match
  for (const double joints : {2.0, 3.0, 1000.0}) {
    const auto snake = build("snake", {{"joints", joints}}, straight_path());
    const SpinePose pose = solved(*snake, kSlither);
    EXPECT_EQ(pose.joint_count(), std::size_t(joints));
    EXPECT_EQ(pose.turn.size(), pose.joint_count());
    EXPECT_EQ(snake->joint_names().size(), pose.joint_count());
    EXPECT_LE(spacing_sum(pose), 30.0 + 1e-9);
  }
  EXPECT_THROW(build("snake", {{"joints", 1.0}}, straight_path()), RigError);
}

TEST(Snake,
     AnEditOfThePathMovesOnlyWhatIsNear) {  // R135, R153: places along it are not sought anew
  RestChain edited = straight_path();
  edited.path.point[20].y += 0.01;  // far ahead of the body at rest
  const auto snake = build("snake", {}, straight_path()), other = build("snake", {}, edited);
  const SpinePose a = solved(*snake, kSlither), b = solved(*other, kSlither);
  for (std::size_t i = 0; i < a.joint_count(); ++i) {
    EXPECT_LT(glm::length(a.position[i] - b.position[i]), 1e-3);  // only the path's length changed
  }
}

TEST(Snake, PathsThatCannotCarryTheBodyAreRefused) {  // R166
  RestChain chain = straight_path();
  EXPECT_THROW(build("snake", {{"length", 121.0}}, chain), RigError);
  chain.path.point.resize(1);
  EXPECT_THROW(build("snake", {}, chain), RigError);
  chain.path.point = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
  EXPECT_THROW(build("snake", {}, chain), RigError);
}

TEST(Snake, OnACharacterTheSignsAreTheSpecifications) {
  const auto snake = build("snake", {{"joints", 20.0}, {"controls", 8.0}});
  for (const Mapping mapping : {Mapping::chest, Mapping::spread}) {
    const auto solve = [&](BodyPose body) {
      return snake->solve(snake->controls_for(body, mapping));
    };
    EXPECT_LT(solve({.extension = 0.8}).position.back().z, -0.3);
    EXPECT_GT(solve({.flexion = 0.8}).position.back().z, 0.3);
    EXPECT_GT(solve({.side = 0.8}).position.back().x, 0.3);
    EXPECT_GT((solve({.twist = 0.8}).turn.back() * kAxisZ).x, 0.6);
    EXPECT_NEAR(angle_between(solve({.extension = 0.8}).turn.back(), kNoTurn), 0.8, 1e-9);
  }
}

TEST(Snake, ManySnakesOnOnePathAreIndependent) {  // R169, R170
  std::vector<SpinePose> alone;
  for (int i = 0; i < 24; ++i) {
    const auto snake = build("snake", {}, straight_path());
    alone.push_back(solved(
        *snake, {{"slide", 0.3}, {"amplitude", 1.0}, {"frequency", 50.0}, {"twist.6", 0.1 * i}}));
  }
  const auto shared = build("snake", {}, straight_path());
  for (int i = 23; i >= 0; --i) {
    const SpinePose pose = solved(
        *shared, {{"slide", 0.3}, {"amplitude", 1.0}, {"frequency", 50.0}, {"twist.6", 0.1 * i}});
    EXPECT_EQ(pose.position, alone[i].position);
    EXPECT_EQ(pose.turn, alone[i].turn);
    if (i > 0) {
      EXPECT_NE(pose.turn, alone[0].turn);
    }
  }
}

}  // namespace
}  // namespace backbend::solver
