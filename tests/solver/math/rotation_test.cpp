#include "solver/math/rotation.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>

namespace backbend::solver {
namespace {

using glm::dquat;
using glm::dvec3;

constexpr double kExact = 1e-14;  // a handful of double roundings

dquat random_rotation(std::mt19937& rng) {
  std::normal_distribution<double> n;
  return glm::normalize(dquat(n(rng), n(rng), n(rng), n(rng)));
}
dvec3 random_direction(std::mt19937& rng) { return random_rotation(rng) * kAxisX; }

void expect_same(const dvec3& a, const dvec3& b, double tolerance = kExact) {
  EXPECT_LT(glm::length(a - b), tolerance);
}

TEST(EulerXyz, TurnsAboutXFirstThenYThenZ) {  // R = Rz Ry Rx
  const dquat q = from_euler_xyz(radians(90), radians(90), 0);
  // X turns Y to Z; Y then turns Z to X.
  expect_same(q * kAxisY, kAxisX);
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> any(-10, 10);
  for (int i = 0; i < 200; ++i) {
    const double x = any(rng), y = any(rng), z = any(rng);
    const dquat product = turn_about(kAxisZ, z) * turn_about(kAxisY, y) * turn_about(kAxisX, x);
    EXPECT_LT(angle_between(from_euler_xyz(x, y, z), product), kExact);
  }
}

TEST(EulerXyz, NeverWraps) {  // 400 degrees is not 40: the quaternion's sign keeps the turn
  EXPECT_LT(from_euler_xyz(radians(400), 0, 0).w, 0.0);
  EXPECT_NEAR(from_euler_xyz(radians(720), 0, 0).w, 1.0, kExact);
}

TEST(ShortestArc, TakesOneDirectionToTheOtherByTheSmallestAngle) {
  std::mt19937 rng(2);
  for (int i = 0; i < 500; ++i) {
    const dvec3 a = random_direction(rng), b = random_direction(rng);
    const dquat q = shortest_arc(a, b, kAxisZ);
    expect_same(q * a, b);
    EXPECT_NEAR(angle_between(q, kNoTurn), angle_between(a, b), 1e-13);
  }
}

TEST(ShortestArc, IsAccurateNextToDoublingBack) {
  for (const double left : {1e-2, 1e-5, 1e-9, 1e-12}) {
    const dvec3 b(-std::cos(left), std::sin(left), 0);
    const dquat q = shortest_arc(kAxisX, b, kAxisY);
    expect_same(q * kAxisX, b, 1e-15 / left + kExact);
    EXPECT_NEAR(std::abs(q.z), 1.0, left);  // about Z, not about the fallback
  }
}

TEST(ShortestArc, DoublesBackAboutTheGivenAxis) {
  expect_same(shortest_arc(kAxisX, -kAxisX, kAxisZ) * kAxisY, -kAxisY);
  expect_same(shortest_arc(kAxisX, -kAxisX, kAxisY) * kAxisZ, -kAxisZ);
  // An axis that is not perpendicular is made so; a parallel one is replaced.
  expect_same(shortest_arc(kAxisX, -kAxisX, dvec3(5, 0, 1)) * kAxisY, -kAxisY);
  for (const dvec3& v : {kAxisX, kAxisY, kAxisZ, glm::normalize(dvec3(1, 2, 3))}) {
    expect_same(shortest_arc(v, -v, v) * v, -v);
    expect_same(shortest_arc(v, -v, dvec3(0)) * v, -v);
  }
}

TEST(SwingTwist, RecoversTwistAndRecomposes) {
  std::mt19937 rng(3);
  for (int i = 0; i < 300; ++i) {
    const dvec3 axis = random_direction(rng);
    const dquat q = random_rotation(rng);
    const SwingTwist parts = swing_twist(q, axis);
    EXPECT_LT(angle_between(parts.swing * parts.twist, q), 1e-14);
    EXPECT_NEAR(parts.swing.x * axis.x + parts.swing.y * axis.y + parts.swing.z * axis.z, 0.0,
                1e-14);
    EXPECT_LT(angle_between(turn_about(axis, parts.twist_angle), parts.twist), 1e-14);
  }
}

TEST(SwingTwist, AHalfTurnSwingHasNoTwistByDefinition) {
  const SwingTwist parts = swing_twist(turn_about(kAxisZ, kPi), kAxisX);
  EXPECT_EQ(parts.twist_angle, 0.0);
  EXPECT_EQ(parts.twist, kNoTurn);
}

TEST(SwingTwist, HiddenTwistOfAnEulerSwingIsTheClosedForm) {  // spine.md 2.5
  for (const auto& [y, z] : {std::pair{30., 30.}, {60., 60.}, {30., 90.}, {-45., 70.}}) {
    const double twist =
        wrap(swing_twist(from_euler_xyz(0, radians(y), radians(z)), kAxisX).twist_angle);
    EXPECT_NEAR(twist, -2 * std::atan(std::tan(radians(y / 2)) * std::tan(radians(z / 2))), 1e-13);
  }
}

TEST(Wrap, BringsAnglesIntoOneTurn) {
  EXPECT_NEAR(wrap(radians(540)), kPi, 1e-12);
  EXPECT_NEAR(wrap(radians(-190)), radians(170), 1e-12);
  EXPECT_EQ(wrap(0.0), 0.0);
  EXPECT_NEAR(unwrap(radians(-170), radians(900)), radians(910), 1e-12);
}

TEST(AngleBetween, IsAccurateForTinyTurns) {
  for (const double a : {1e-12, 1e-8, 1e-3, 3.0}) {
    EXPECT_NEAR(angle_between(kNoTurn, turn_about(kAxisY, a)) / a, 1.0, 1e-12);
    EXPECT_NEAR(angle_between(kNoTurn, -turn_about(kAxisY, a)) / a, 1.0, 1e-12);
  }
}

TEST(Slerp, ShortWayAndRawAgreeUntilAHalfTurnAndPartThere) {
  const auto at = [](double deg) { return turn_about(kAxisX, radians(deg)); };
  for (const double deg : {0.0, 1e-7, 30.0, 179.0}) {
    for (const double t : {0.0, 0.25, 0.5, 1.0}) {
      EXPECT_LT(angle_between(slerp_short(kNoTurn, at(deg), t), at(t * deg)), 1e-13);
      EXPECT_LT(angle_between(slerp_raw(kNoTurn, at(deg), t), at(t * deg)), 1e-13);
    }
  }
  EXPECT_LT(angle_between(slerp_short(kNoTurn, at(200), 0.25), at(-40)), 1e-13);
  EXPECT_LT(angle_between(slerp_raw(kNoTurn, at(200), 0.25), at(50)), 1e-13);
}

TEST(Slerp, RawReturnsItsFirstEndWhereTheOtherIsItsOpposite) {
  const dquat q = turn_about(kAxisY, 0.7);
  EXPECT_EQ(slerp_raw(q, -q, 0.3), q);
  EXPECT_LT(angle_between(slerp_short(q, -q, 0.3), q), 1e-15);
}

TEST(RestFrame, HasXAlongTheBoneAndZTowardTheLeft) {
  const dquat upright = rest_frame({0, 2, 0}, {1, 0, 0});
  expect_same(x_axis(upright), kAxisY);
  expect_same(y_axis(upright), kAxisZ);  // forward
  expect_same(z_axis(upright), kAxisX);  // the character's left
  std::mt19937 rng(4);
  for (int i = 0; i < 100; ++i) {
    const dvec3 bone = random_direction(rng), left = random_direction(rng);
    const dquat f = rest_frame(3.0 * bone, left);
    expect_same(x_axis(f), bone);
    EXPECT_NEAR(glm::dot(y_axis(f), left), 0.0, kExact);
    EXPECT_GT(glm::dot(z_axis(f), left), 0.0);
    expect_same(f * kAxisY, y_axis(f));
    expect_same(f * kAxisZ, z_axis(f));
  }
}

TEST(RestFrame, ABoneAlongTheLeftAxisStillHasOne) {
  for (const dvec3& v : {kAxisX, -kAxisX, kAxisY, kAxisZ}) {
    const dquat f = rest_frame(v, v);
    expect_same(x_axis(f), v);
    EXPECT_NEAR(glm::length(f), 1.0, kExact);
  }
}

TEST(Transport, KeepsTheTwistOfAPlanarChain) {
  std::array<dvec3, 5> direction;
  for (int i = 0; i < 5; ++i) direction[i] = {std::cos(0.9 * i), std::sin(0.9 * i), 0};
  std::array<dquat, 5> frame;
  transport_along(kNoTurn, direction, frame);
  for (int i = 0; i < 5; ++i) {
    expect_same(x_axis(frame[i]), direction[i]);
    expect_same(z_axis(frame[i]), kAxisZ);
  }
}

TEST(Transport, AZeroDirectionKeepsTheFrameBeforeIt) {
  const std::array<dvec3, 3> direction = {kAxisY, dvec3(0), kAxisX};
  std::array<dquat, 3> frame;
  transport_along(kNoTurn, direction, frame);
  EXPECT_EQ(frame[0], frame[1]);
  expect_same(x_axis(frame[2]), kAxisX);
}

TEST(Transport, MarginIsTheLeastAngleLeftToDoublingBack) {
  const auto in_plane = [](double deg) {
    return dvec3(std::cos(radians(deg)), std::sin(radians(deg)), 0.0);
  };
  const std::array<dvec3, 5> direction = {in_plane(20), in_plane(-80), dvec3(0.0), in_plane(90),
                                          in_plane(100)};
  std::array<dquat, 5> frame;
  std::array<double, 5> margin;
  transport_along(kNoTurn, direction, frame, margin);
  const double left[] = {160, 80, 80, 10, 10};
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(degrees(margin[i]), left[i], 1e-9) << i;
}

}  // namespace
}  // namespace backbend::solver
