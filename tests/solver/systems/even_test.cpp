// The theorems of docs/even.md, each against the built system.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "solver/math/even_weight.h"
#include "solver/math/fast_trigonometry.h"
#include "solver/rig/limits.h"
#include "solver/systems/even_limits.h"
#include "solver/systems/even_reach.h"
#include "tests/solver/rig_fixture.h"

namespace backbend::solver {
namespace {

using namespace rigs;

// What rounding can add to an angle between two frames: a few units of 2^-53 through a dozen
// products, and an arc tangent at the end.
constexpr double kRounding = 1e-13;

std::vector<double> even_controls(const std::vector<double>& nine) {
  std::vector<double> control = nine;
  control.push_back(1.0);  // stretch
  control.push_back(0.0);  // compression
  return control;
}

std::vector<double> random_controls(std::mt19937& rng, double most_deg) {
  std::uniform_real_distribution<double> angle(-most_deg, most_deg);
  std::vector<double> nine(9);
  for (double& c : nine) c = radians(angle(rng));
  return even_controls(nine);
}

/// The weight of a channel in a default rig at bone k of ten, written out again from docs/even.md.
double default_weight(std::size_t channel, double s) {
  if (channel < 3) return 1.0;
  if (channel % 3 == 0) return s;  // RX: linear
  const double from = channel < 6 ? 0.0 : 0.2, width = 0.8, ramp = 0.1, peak = 10.0 / 7.0;
  const auto rise = [&](double x) { return peak * ramp * (x * x * x - 0.5 * x * x * x * x); };
  const double d = std::clamp(s - from, 0.0, width);
  if (d < ramp) return rise(d / ramp);
  if (d > width - ramp) return 1.0 - rise((width - d) / ramp);
  return 0.5 * peak * ramp + peak * (d - ramp);
}

double frame_place(std::size_t k) { return k < 10 ? (double(k) + 0.5) / 10.0 : 1.0; }

TEST(EvenWeight, RisesFromExactlyZeroToExactlyOneWithoutACorner) {
  for (const auto& [from, to] : {std::pair{0.0, 0.8}, {0.2, 1.0}, {0.0, 1.0}, {0.4, 0.45}}) {
    const EvenWeight w = EvenWeight::trapezoid(from, to);
    EXPECT_EQ(w(0.0), 0.0);
    EXPECT_EQ(w(1.0), 1.0);
    EXPECT_DOUBLE_EQ(w.peak_slope(), 8.0 / (7.0 * (to - from)));
    const double h = 1e-6 * (to - from);
    for (const double knot : w.knots()) {
      if (knot <= h || knot >= 1.0 - h) continue;
      // Slope and its derivative meet: W is twice continuously differentiable.
      EXPECT_NEAR(w(knot - 1e-15), w(knot + 1e-15), 1e-13);
      EXPECT_NEAR(w.slope(knot - 1e-15), w.slope(knot + 1e-15), 1e-12 * w.peak_slope());
      const double before = (w.slope(knot) - w.slope(knot - h)) / h;
      const double after = (w.slope(knot + h) - w.slope(knot)) / h;
      EXPECT_NEAR(before, after, 1e-3 * w.peak_slope() / (to - from));
    }
    for (double s = 0.0; s < 1.0; s += 1e-3) {
      EXPECT_LE(w(s), w(s + 1e-3) + 1e-15);
      EXPECT_GE(w.slope(s), -1e-12);
      EXPECT_LE(w.slope(s), w.peak_slope() * (1.0 + 1e-12));
    }
  }
}

TEST(EvenWeight, DensityIsSharedByArea) {
  const double even[] = {3.0};
  EXPECT_DOUBLE_EQ(EvenWeight::from_density(even)(0.37), 0.37);
  const double upper[] = {0.0, 1.0};  // density 2 s: W = s^2
  EXPECT_DOUBLE_EQ(EvenWeight::from_density(upper)(0.37), 0.37 * 0.37);
  EXPECT_DOUBLE_EQ(EvenWeight::from_density(upper).peak_slope(), 2.0);
}

TEST(EvenWeight, SlopeIsTheWeightsDerivative) {
  const double bumpy[] = {1.0, 3.0, 0.5, 2.0};
  for (const EvenWeight& w : {EvenWeight::trapezoid(0.2, 1.0), EvenWeight::trapezoid(0.1, 0.5),
                              EvenWeight::from_density(bumpy)}) {
    const double h = 1e-5;
    for (double s = 0.003; s < 0.997; s += 0.0117)
      EXPECT_NEAR(w.slope(s), (w(s + h) - w(s - h)) / (2.0 * h), 1e-4 * w.peak_slope()) << s;
  }
}

TEST(EvenWeight, ThePeakOfAStretchIsTheLargestSlopeOnIt) {
  const double bumpy[] = {1.0, 3.0, 0.5, 2.0};
  for (const EvenWeight& w : {EvenWeight::trapezoid(0.2, 1.0), EvenWeight::from_density(bumpy)}) {
    for (double from = 0.0; from < 1.0; from += 0.083) {
      const double to = std::min(1.0, from + 0.21);
      double most = 0.0;
      for (int i = 0; i <= 1000; ++i)
        most = std::max(most, w.slope(from + (to - from) * i / 1000.0));
      EXPECT_GE(w.peak_slope(from, to), most * (1.0 - 1e-12)) << from;
      EXPECT_NEAR(w.peak_slope(from, to), most, 0.01 * w.peak_slope()) << from;
    }
    EXPECT_DOUBLE_EQ(w.peak_slope(0.0, 1.0), w.peak_slope());
  }
}

TEST(Even, AFrameTurnsByExactlyItsWeightTimesTheChannel) {  // theorem 1, as an equality
  const auto even = build("even");
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> step(-0.4, 0.4);
  for (int i = 0; i < 2000; ++i) {
    std::vector<double> control = random_controls(rng, 720.0);
    const SpinePose before = even->solve(control);
    const std::size_t channel = i % 9;
    const double by = step(rng);
    control[channel] += by;
    const SpinePose after = even->solve(control);
    for (std::size_t k = 0; k <= 10; ++k) {
      const double expected = default_weight(channel, frame_place(k)) * std::abs(by);
      EXPECT_NEAR(angle_between(before.turn[k], after.turn[k]), expected, 1e-12)
          << "channel " << channel << " frame " << k;
    }
  }
}

TEST(Even, AFrameTurnsByItsWeightTimesAnyAngle) {  // beyond what the fast sines take, too
  const auto even = build("even");
  constexpr double kAngle = 1e7;
  for (std::size_t channel = 3; channel < 9; ++channel) {
    std::vector<double> nine(9);
    nine[channel] = kAngle;
    const SpinePose pose = even->solve(even_controls(nine));
    for (std::size_t k = 0; k <= 10; ++k) {
      const double turned = default_weight(channel, frame_place(k)) * kAngle;
      // A weight is good to a few units of 2^-53, of which 1e7 makes 1e-8.
      EXPECT_NEAR(angle_between(kNoTurn, pose.turn[k]), std::abs(std::remainder(turned, 2.0 * kPi)),
                  1e-7)
          << "channel " << channel << " frame " << k;
    }
  }
}

/// Theorem 1 over random poses to +-720 degrees and steps of any size.
void expect_gain_at_most_one(int count, unsigned seed) {
  const auto even = build("even");
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> exponent(-6.0, 0.3);
  SpinePose before, after;
  double worst = 0.0;
  for (int i = 0; i < count; ++i) {
    std::vector<double> control = random_controls(rng, 720.0);
    even->solve_into(control, Detail::joints, before);
    const double by = std::pow(10.0, exponent(rng));
    control[rng() % 9] += i % 2 ? by : -by;
    even->solve_into(control, Detail::joints, after);
    for (std::size_t k = 0; k < before.joint_count(); ++k) {
      const double turned = angle_between(before.turn[k], after.turn[k]);
      worst = std::max(worst, turned - by);
    }
  }
  EXPECT_LE(worst, kRounding);
}

TEST(Even, NoFrameOutrunsAChannelInAHundredThousandRandomPoses) {
  expect_gain_at_most_one(100000, 2);
}

TEST(Even, NoFrameOutrunsAChannelInAMillionRandomPoses) {
  if (!std::getenv("BACKBEND_LONG_TESTS")) GTEST_SKIP() << "set BACKBEND_LONG_TESTS to run it";
  expect_gain_at_most_one(1000000, 3);
}

TEST(Even, NoFrameOutrunsAChannelOnADenseGrid) {
  // Bend of Middle, bend and side of Top, every 45 degrees through two turns each way, and every
  // pose against its neighbours in each direction.
  const auto even = build("even");
  constexpr int kSteps = 33;
  const auto at = [](int i) { return radians(-720.0 + 45.0 * i); };
  std::vector<SpinePose> pose(kSteps * kSteps * kSteps);
  std::vector<double> control = rest_controls(*even);
  for (int a = 0; a < kSteps; ++a) {
    for (int b = 0; b < kSteps; ++b) {
      for (int c = 0; c < kSteps; ++c) {
        control[5] = at(a), control[8] = at(b), control[7] = at(c);
        even->solve_into(control, Detail::joints, pose[(a * kSteps + b) * kSteps + c]);
      }
    }
  }
  double worst = 0.0;
  for (int i = 0; i < int(pose.size()); ++i) {
    for (const int stride : {kSteps * kSteps, kSteps, 1}) {
      if ((i / stride) % kSteps == kSteps - 1) continue;
      for (std::size_t k = 0; k <= 10; ++k) {
        worst = std::max(worst, angle_between(pose[i].turn[k], pose[i + stride].turn[k]));
      }
    }
  }
  EXPECT_LE(worst, radians(45.0) + kRounding);
  EXPECT_GT(worst, radians(44.9));  // the chest does turn by all of it
}

TEST(Even, EveryJointStaysUnderItsBound) {  // theorem 2
  for (const double bones : {3.0, 10.0, 17.0}) {
    const auto even = build("even", {{"bones", bones}});
    std::mt19937 rng(4);
    for (int i = 0; i < 5000; ++i) {
      const std::vector<double> control = random_controls(rng, 720.0 * (i % 10 + 1) / 10.0);
      const SpinePose pose = even->solve(control);
      double sum = 0.0;
      for (std::size_t ch = 3; ch < 9; ++ch) sum += std::abs(control[ch]);
      const double trapezoid = std::min(180.0, degrees(10.0 / 7.0 / bones * sum));
      EXPECT_LE(measure(pose, "max_joint_deg"), measure(pose, "joint_bound_deg") + 1e-9);
      EXPECT_LE(measure(pose, "joint_bound_deg"), trapezoid + 1e-9);
    }
  }
}

TEST(Even, TheChestCarriesExactlyTopsTurn) {  // theorem 3: any angle, curved or straight
  for (const RestChain& chain : {straight(), curved()}) {
    const auto even = build("even", {}, chain), bones = build("three_bone", {}, chain);
    std::mt19937 rng(5);
    for (int i = 0; i < 2000; ++i) {
      const std::vector<double> control = random_controls(rng, 720.0);
      const SpinePose pose = even->solve(control);
      const SpinePose fk = bones->solve(std::span(control).first(9));
      EXPECT_LE(angle_between(pose.turn.back(), fk.turn.back()), radians(1e-9));
    }
  }
}

TEST(Even, ArmsNeverDriftOnEitherParent) {  // W1, W2: exactly nothing
  for (const char* parent : {"effector", "top"}) {
    const auto even = build("even", {{"arms", parent}}, curved());
    std::mt19937 rng(6);
    for (int i = 0; i < 500; ++i) {
      const SpinePose pose = even->solve(random_controls(rng, 720.0));
      EXPECT_EQ(pose.arms.turn, pose.chest.turn);
      EXPECT_EQ(pose.arms.rest_origin, pose.chest.rest_origin);
      EXPECT_EQ(pose.arms.posed_origin, pose.chest.posed_origin);
      EXPECT_EQ(measure(pose, "arm_drift_twist_deg"), 0.0);
    }
  }
}

TEST(Even, TwistIsExactForAnyAngleAndMovesNoJoint) {  // R49, R50, R52, R54
  const auto even = build("even");
  for (const std::size_t channel : {std::size_t{3}, std::size_t{6}}) {
    for (double deg = -720.0; deg <= 720.0; deg += 36.0) {
      std::vector<double> control = rest_controls(*even);
      control[channel] = radians(deg);
      const SpinePose pose = even->solve(control);
      for (std::size_t k = 0; k <= 10; ++k) {
        const dquat expected = turn_about(kAxisY, radians(deg) * frame_place(k));
        EXPECT_LE(angle_between(pose.turn[k], expected), 1e-13);
        EXPECT_EQ(pose.position[k], even->rest().position[k]);
      }
    }
  }
}

TEST(Even, TwistFollowsAListOrTheBody) {
  const auto twisted = [](OptionValue twist) {
    const auto even = build("even", {{"twist", twist}});
    std::vector<double> control = rest_controls(*even);
    control[6] = radians(100.0);
    std::vector<double> deg;
    for (const dquat& q : even->solve(control).turn)
      deg.push_back(degrees(angle_between(q, kNoTurn)));
    return deg;
  };
  const auto upper = twisted(std::vector<double>{0, 0, 1, 1});
  EXPECT_NEAR(upper[2], 0.0, 1e-9);  // the lower third takes nothing
  EXPECT_NEAR(upper[10], 100.0, 1e-9);
  const auto body = twisted("anatomical");
  const RangeOfMotion whole = human_range(0.0, 1.0);
  EXPECT_NEAR(body[10], 100.0, 1e-9);
  // The lumbar third of the body twists little: 11 of 71 degrees.
  EXPECT_NEAR(body[3], 100.0 * human_range(0.0, 0.35).axial / whole.axial, 1.5);
  EXPECT_NEAR(body[7], 100.0 * human_range(0.0, 0.75).axial / whole.axial, 1.5);
}

TEST(Even, SingleBendsAreSpread) {  // R4, R156: 6.4 on the thesis's rig at Top RZ -150
  for (const double bones : {8.0, 9.0, 10.0, 12.0, 20.0}) {
    const auto even = build("even", {{"bones", bones}});
    for (const std::size_t channel :
         {std::size_t{4}, std::size_t{5}, std::size_t{7}, std::size_t{8}}) {
      for (double deg = -150.0; deg <= 150.0; deg += 10.0) {
        std::vector<double> control = rest_controls(*even);
        control[channel] = radians(deg);
        EXPECT_LE(measure(even->solve(control), "max_over_mean_turn"), 1.5)
            << bones << " bones, channel " << channel << " at " << deg;
      }
    }
  }
  const auto even = build("even");
  EXPECT_NEAR(measure(even->solve(even_controls(pose_f())), "max_over_mean_turn"), 1.314, 0.001);
  EXPECT_GT(measure(build("curve")->solve(pose_f()), "max_over_mean_turn"), 3.0);
}

TEST(Even, NothingJumpsInTwoTurnsOfAnyChannel) {
  const auto even = build("even", {}, curved());
  for (std::size_t channel = 0; channel < 9; ++channel) {
    const auto at = [&](double deg) {
      std::vector<double> control = even_controls(pose_e());
      control[channel] = radians(deg);
      return control;
    };
    EXPECT_LE(largest_step_deg(*even, at, -720.0, 720.0, 3.0), 3.0 + 1e-9);
  }
}

TEST(Even, LowerTurnsEverythingRigidly) {  // R2
  const auto even = build("even", {}, curved());
  std::mt19937 rng(7);
  for (int i = 0; i < 200; ++i) {
    std::vector<double> control = random_controls(rng, 360.0);
    const SpinePose turned = even->solve(control);
    std::fill_n(control.begin(), 3, 0.0);
    const SpinePose still = even->solve(control);
    const dquat by = turned.turn[0] * glm::conjugate(still.turn[0]);
    for (std::size_t k = 0; k <= 10; ++k) {
      expect_near(turned.position[k], by * still.position[k], 1e-12);
      EXPECT_LE(angle_between(turned.turn[k], by * still.turn[k]), 1e-13);
    }
  }
}

TEST(Even, JointsAreTheIntegralOfTheTurnedTangent) {
  // An oracle of its own: rotation matrices, and a midpoint sum of 20000 steps (error of order
  // 1e-9 times the square of the turning, which stays below 40 radians here).
  std::mt19937 rng(8);
  for (const RestChain& chain : {straight(), curved()}) {
    const auto even = build("even", {}, chain);
    std::vector<double> corner{0.0};
    for (std::size_t i = 1; i < 4; ++i) {
      corner.push_back(corner.back() + glm::length(chain.joint[i] - chain.joint[i - 1]));
    }
    const double length = corner.back();
    const auto axes = [&](int bone) {
      const dvec3 x = glm::normalize(chain.joint[bone + 1] - chain.joint[bone]);
      return glm::dmat3(x, glm::cross(dvec3(1, 0, 0), x), dvec3(1, 0, 0));
    };
    const auto euler = [](const glm::dmat3& frame, double rx, double ry, double rz) {
      const auto about = [](double angle, const dvec3& axis) {
        return glm::dmat3(glm::rotate(glm::dmat4(1.0), angle, axis));
      };
      return frame * about(rz, {0, 0, 1}) * about(ry, {0, 1, 0}) * about(rx, {1, 0, 0}) *
             glm::transpose(frame);
    };
    for (int i = 0; i < 4; ++i) {
      const std::vector<double> c = random_controls(rng, i < 2 ? 90.0 : 360.0);
      const SpinePose pose = even->solve(c);
      constexpr int kSteps = 20000;
      dvec3 at = chain.joint[0];
      for (int step = 0; step < kSteps; ++step) {
        if (step % (kSteps / 10) == 0) expect_near(pose.position[step / (kSteps / 10)], at, 3e-5);
        const double s = (step + 0.5) / kSteps;
        const auto w = [&](std::size_t ch) { return default_weight(ch, s) * c[ch]; };
        int bone = 0;
        while (s * length > corner[bone + 1]) ++bone;
        const dvec3 rest = glm::normalize(chain.joint[bone + 1] - chain.joint[bone]);
        at += (length / kSteps) *
              (euler(axes(0), c[0], c[1], c[2]) * euler(axes(1), w(3), w(4), w(5)) *
               euler(axes(2), w(6), w(7), w(8)) * rest);
      }
      expect_near(pose.position[10], at, 3e-5);
    }
  }
}

TEST(Even, QuadratureIsGoodToRoundingHoweverTheBonesCutIt) {
  const auto coarse = build("even", {{"bones", 5.0}}, curved());
  const auto fine = build("even", {{"bones", 60.0}}, curved());
  std::mt19937 rng(9);
  for (const double most : {5.0, 30.0, 90.0, 180.0, 360.0, 720.0}) {
    for (int i = 0; i < 100; ++i) {
      const std::vector<double> control = random_controls(rng, most);
      const SpinePose a = coarse->solve(control), b = fine->solve(control);
      for (std::size_t k = 0; k <= 5; ++k) expect_near(a.position[k], b.position[12 * k], 1e-12);
    }
  }
}

TEST(Even, TheCurveKeepsItsLengthInEveryPose) {
  const auto even = build("even", {}, curved());
  const double length = measure(even->rest(), "rest_curve_length");
  std::mt19937 rng(10);
  for (int i = 0; i < 20; ++i) {
    const std::vector<double> control = random_controls(rng, 360.0);
    EXPECT_DOUBLE_EQ(measure(even->solve(control), "curve_length"), length);
    const auto point = even->intended_curve(control, 4001);
    double sum = 0.0;
    for (std::size_t k = 1; k < point.size(); ++k) {
      const double chord = glm::length(point[k] - point[k - 1]);
      EXPECT_LE(chord, length / 4000.0 * (1.0 + 1e-9));  // a chord is never longer than its arc
      sum += chord;
    }
    // Chords of equal arcs fall short by (turning per step)^2 / 24, here under 1e-6; rest corners
    // cost one step each at most.
    EXPECT_NEAR(sum, length, 2e-4 * length);
  }
}

TEST(Even, CurvedChainsRestExactlyOnTheirDrawing) {
  const auto even = build("even", {{"bones", 12.0}}, curved());
  const auto& rest = even->rest().position;
  EXPECT_EQ(rest.front(), curved().joint.front());
  EXPECT_EQ(rest.back(), curved().joint.back());
  for (const dvec3& p : rest) {  // each on one of the three drawn bones
    double nearest = 1.0;
    for (int b = 0; b < 3; ++b) {
      const dvec3 a = curved().joint[b], along = curved().joint[b + 1] - a;
      const double t = std::clamp(glm::dot(p - a, along) / glm::dot(along, along), 0.0, 1.0);
      nearest = std::min(nearest, glm::length(p - a - t * along));
    }
    EXPECT_LE(nearest, 1e-15);
  }
}

TEST(Even, PlanarPosesStayExactlyInThePlane) {  // R20
  for (const RestChain& chain : {straight(), curved()}) {
    const auto even = build("even", {{"reach", 1.0}}, chain);
    for (const auto& pose : {pose_b(), pose_c(), pose_f()}) {
      for (const dvec3& p : even->solve(even_controls(pose)).position) EXPECT_EQ(p.x, 0.0);
    }
  }
}

TEST(Even, SignsAreTheSpecifications) {  // fails if any axis is swapped
  const auto even = build("even");
  const auto tip = [&](BodyPose body) {
    return even->solve(even->controls_for(body, Mapping::chest));
  };
  EXPECT_LT(tip({.extension = 1.0}).position.back().z, -1.0);
  EXPECT_GT(tip({.flexion = 1.0}).position.back().z, 1.0);
  EXPECT_GT(tip({.side = 1.0}).position.back().x, 1.0);
  EXPECT_GT((tip({.twist = 1.0}).turn.back() * kAxisZ).x, 0.8);  // the front turns to the left
}

TEST(Even, ReachBringsTheChestBackAndKeepsItsTurn) {
  for (const double deg : {-60.0, -90.0, -120.0, -150.0, 120.0}) {
    std::vector<double> nine(9, 0.0);
    nine[8] = radians(deg);
    const std::vector<double> control = even_controls(nine);
    const dvec3 asked = build("three_bone")->solve(nine).position.back();
    double before = 1e9;
    const dquat turn = build("even")->solve(control).turn.back();
    for (const double reach : {0.0, 0.25, 0.5, 0.75, 1.0}) {
      const SpinePose pose = build("even", {{"reach", reach}})->solve(control);
      const double gap = measure(pose, "reach_gap");
      EXPECT_NEAR(gap, glm::length(pose.position.back() - asked), 1e-12);
      EXPECT_LT(gap, before);
      before = gap;
      EXPECT_LE(angle_between(pose.turn.back(), turn), 1e-14);
      // What leans goes along in the frames: each shows its bone, as far as a bent bone has one.
      for (std::size_t k = 0; k + 1 < pose.joint_count(); ++k)
        EXPECT_LT(
            degrees(angle_between(pose.turn[k] * kAxisY, pose.position[k + 1] - pose.position[k])),
            2.0)
            << reach << ' ' << k;
    }
    EXPECT_LT(before, 0.45 * measure(build("even")->solve(control), "reach_gap")) << deg;
  }
}

TEST(EvenReach, BumpsAreALeanAndAnSThatVanishAtBothEndsWithTheirSlopes) {
  for (const int which : {0, 1}) {
    for (const double end : {0.0, 1.0}) {
      EXPECT_EQ(reach_bump(which, end), 0.0);
      EXPECT_NEAR(reach_bump(which, std::abs(end - 1e-6)), 0.0, 1e-10);
    }
  }
  EXPECT_EQ(reach_bump(0, 0.5), 1.0);
  for (double s = 0.0; s <= 0.5; s += 0.01) {
    EXPECT_NEAR(reach_bump(0, s), reach_bump(0, 1.0 - s), 1e-14);
    EXPECT_NEAR(reach_bump(1, s), -reach_bump(1, 1.0 - s), 1e-14);
    EXPECT_LE(std::hypot(reach_bump(0, s), reach_bump(1, s)), 1.0 + 1e-14);  // used in the proof
  }
}

TEST(EvenReach, LastOfTheRoomIsGivenOutWithoutACorner) {
  // The field's size over what is left goes to 0 with what is left: the slope is continuous.
  const std::array<double, 6> step{0, 0, 0, 0, 0, 0.1};
  const EvenReach reach(1.0, radians(20.0), step, 10);
  const std::array<dvec3, 2> moment{dvec3(0, 0.5, 0), dvec3(0.1, 0.2, 0)};
  const auto size = [&](double left_deg) {
    const ReachField f =
        reach.field({0.2, 0, 0.1}, moment, {0, 0, 0, 0, 0, radians(200.0 - 10.0 * left_deg)});
    return reach.joint_share(f) / radians(left_deg);
  };
  EXPECT_LT(size(0.1), 0.05);
  EXPECT_LT(size(0.01), 0.01);
  EXPECT_TRUE(reach.field({0.2, 0, 0}, moment, {0, 0, 0, 0, 0, radians(201.0)}).none());
}

TEST(Even, ReachKeepsItsGainAndJointBounds) {
  // The derived gain bounds of docs/even.md.
  EXPECT_NEAR(measure(build("even", {{"reach", 0.5}})->rest(), "gain_bound"), 7.12, 0.01);
  EXPECT_NEAR(measure(build("even", {{"reach", 1.0}})->rest(), "gain_bound"), 12.87, 0.01);
  int held = 0;
  for (const double reach : {0.5, 1.0}) {
    for (const double most : {20.0, 45.0, 180.0}) {
      const auto even = build("even", {{"reach", reach}, {"max_joint_angle", most}});
      const double bound = measure(even->rest(), "gain_bound");
      std::mt19937 rng(11);
      double worst = 0.0;
      for (int i = 0; i < 3000; ++i) {
        std::vector<double> control = random_controls(rng, 72.0 * (i % 10 + 1));
        const SpinePose before = even->solve(control);
        EXPECT_LE(measure(before, "max_joint_deg"), measure(before, "joint_bound_deg") + 1e-9);
        double plain = 0.0;  // theorem 5: what the channels take of a joint, each at its steepest
        for (std::size_t ch = 3; ch < 9; ++ch) {
          plain += (ch % 3 == 0 ? 0.1 : 1.0 / 7.0) * std::abs(degrees(control[ch]));
        }
        EXPECT_LE(measure(before, "joint_bound_deg"), std::max(plain, most) + 1e-9);
        held += plain < most;
        const double by = 1e-6;
        control[rng() % 9] += by;
        const SpinePose after = even->solve(control);
        for (std::size_t k = 0; k <= 10; ++k) {
          worst = std::max(worst, angle_between(before.turn[k], after.turn[k]) / by);
        }
      }
      EXPECT_LE(worst, bound);
      EXPECT_LE(worst, 4.0) << "the derived bound is generous; this is what was measured";
    }
  }
  EXPECT_GT(held, 1000);
}

TEST(Even, ReachGivesUpItsRoomWithoutAJump) {
  // As Top bends on, the joints use up max_joint_angle and the field has to go.
  const auto even = build("even", {{"reach", 1.0}, {"max_joint_angle", 20.0}});
  const auto at = [&](double deg) {
    std::vector<double> nine(9, 0.0);
    nine[8] = radians(deg);
    return even_controls(nine);
  };
  EXPECT_LE(largest_step_deg(*even, at, -300.0, 300.0, 0.25), 0.25 * 4.0);
  EXPECT_DOUBLE_EQ(measure(even->solve(at(-300.0)), "reach_gap"),
                   measure(build("even")->solve(at(-300.0)), "reach_gap"));
}

TEST(Even, JointsStandWhereTheirBonesPointWhateverReachAdds) {
  // Bones are the turned bones of rest: the midpoint rule of what the joints integrate, whose error
  // falls with the square of the bones' length.
  std::mt19937 rng(17);
  std::uniform_real_distribution<double> angle(-1.0, 1.0);
  const auto with = [](double reach) {
    return build("even", {{"bones", 64.0}, {"reach", reach}, {"max_joint_angle", 180.0}}, curved());
  };
  const auto plain = with(0.0), reaching = with(1.0);
  double most_reach = 0.0;
  for (int i = 0; i < 40; ++i) {
    std::vector<double> nine(9);
    for (double& a : nine) a = angle(rng);
    dvec3 tip(0.0);  // without reach
    for (const auto* even : {plain.get(), reaching.get()}) {
      const SpinePose& rest = even->rest();
      const SpinePose pose = even->solve(even_controls(nine));
      dvec3 at = pose.position[0];
      for (std::size_t k = 0; k < 64; ++k) {
        at += pose.turn[k] * (rest.position[k + 1] - rest.position[k]);
        expect_near(at, pose.position[k + 1], 2e-3);
      }
      if (even == plain.get()) tip = pose.position.back();
      most_reach = std::max(most_reach, glm::length(pose.position.back() - tip));
    }
  }
  EXPECT_GT(most_reach, 0.2) << "reach did nothing";
}

TEST(Even, SpreadsAnAnatomicalTwistAsEachLevelOfTheSpineCan) {
  const std::vector<double> density = human_twist_density(1001);
  ASSERT_EQ(density.size(), 1001u);
  const std::span<const SpineLevel> levels = human_levels();
  for (std::size_t i = 0; i < density.size(); ++i) {
    const double s = static_cast<double>(i) / 1000.0;
    const SpineLevel* here = &levels.back();
    for (const SpineLevel& level : levels)
      if (s >= level.from && s < level.to) here = &level;
    EXPECT_DOUBLE_EQ(density[i], here->range.axial / (here->to - here->from)) << s;
  }
}

TEST(Even, LimitsKeepEveryJointInsideItsRange) {
  const auto even = build("even", {{"limits", "human"}});
  for (const auto& [channel, pick] : {std::pair{std::size_t{8}, &RangeOfMotion::flexion},
                                      {std::size_t{7}, &RangeOfMotion::side},
                                      {std::size_t{6}, &RangeOfMotion::axial}}) {
    for (double deg = 0.0; deg <= 300.0; deg += 10.0) {
      std::vector<double> control = rest_controls(*even);
      control[channel] = radians(deg);
      const SpinePose pose = even->solve(control);
      double from = 0.0;
      for (std::size_t k = 0; k <= 10; ++k) {
        const double cap = human_range(from, frame_place(k)).*pick;
        const dquat below = k == 0 ? kNoTurn : pose.turn[k - 1];
        EXPECT_LE(degrees(angle_between(below, pose.turn[k])), cap + 1e-9) << k << " at " << deg;
        from = frame_place(k);
      }
    }
  }
}

TEST(Even, MiddleAndTopShareAJointsRange) {
  const auto even = build("even", {{"limits", "human"}});
  for (const double top : {-200.0, -40.0, 40.0, 200.0}) {
    for (const double middle : {-200.0, -40.0, 40.0, 200.0}) {
      std::vector<double> control = rest_controls(*even);
      control[5] = radians(middle), control[8] = radians(top);
      const SpinePose pose = even->solve(control);
      double from = 0.0;
      for (std::size_t k = 0; k <= 10; ++k) {
        const RangeOfMotion range = human_range(from, frame_place(k));
        const dquat below = k == 0 ? kNoTurn : pose.turn[k - 1];
        // About world X, the lateral axis: forward is positive.
        const double bend =
            degrees(swing_twist(glm::conjugate(below) * pose.turn[k], kAxisX).twist_angle);
        EXPECT_LE(bend, range.flexion + 1e-9) << middle << " " << top << " joint " << k;
        EXPECT_GE(bend, -range.extension - 1e-9) << middle << " " << top << " joint " << k;
        from = frame_place(k);
      }
    }
  }
}

TEST(Even, LimitsLoseNothingWhileTheSpineHasRoomAndSayWhatTheyLose) {
  const auto even = build("even", {{"limits", "human"}}), free = build("even");
  const auto bent = [&](double deg) {
    std::vector<double> control = rest_controls(*even);
    control[8] = -radians(deg);
    return even->solve(control);
  };
  // Far inside nothing differs; past the first joint's limit the chest still gets it all.
  std::vector<double> control = rest_controls(*free);
  control[8] = -radians(20.0);
  for (std::size_t k = 0; k <= 10; ++k) {
    expect_near(bent(20.0).position[k], free->solve(control).position[k], 1e-13);
  }
  const SpinePose full = bent(50.0);
  EXPECT_FALSE(full.flags.empty());
  EXPECT_EQ(measure(full, "limit_loss_deg"), 0.0);
  EXPECT_NEAR(degrees(angle_between(full.turn.back(), kNoTurn)), 50.0, 1e-9);
  const SpinePose over = bent(100.0);
  EXPECT_NEAR(degrees(angle_between(over.turn.back(), kNoTurn)),
              100.0 - measure(over, "limit_loss_deg"), 1e-9);
  // All of Top's joints: from a tenth of the way on, where its weight begins.
  EXPECT_NEAR(measure(over, "limit_loss_deg"), 100.0 - human_range(0.15, 1.0).extension, 1e-9);
  EXPECT_NE(over.flags.front().find("extension is at its limit at joint"), std::string::npos);
  // Arms on the effector show the loss, arms on the top control do not: that is the choice.
  EXPECT_NEAR(measure(over, "chest_gap_deg"), measure(over, "limit_loss_deg"), 1e-9);
}

TEST(Even, LimitedFramesStayWithinTwiceTheChannel) {
  const auto even = build("even", {{"limits", "human"}});
  std::mt19937 rng(12);
  double worst = 0.0;
  for (int i = 0; i < 20000; ++i) {
    std::vector<double> control = random_controls(rng, 18.0 * (i % 10 + 1));
    const SpinePose before = even->solve(control);
    control[rng() % 9] += 1e-6;
    const SpinePose after = even->solve(control);
    for (std::size_t k = 0; k <= 10; ++k) {
      worst = std::max(worst, angle_between(before.turn[k], after.turn[k]) / 1e-6);
    }
  }
  EXPECT_LE(worst, measure(even->rest(), "gain_bound") + 1e-6);
  EXPECT_EQ(measure(even->rest(), "gain_bound"), 2.0);
}

TEST(Even, StretchesAsAskedAndHoldsItsLengthOtherwise) {  // as in 4.4; W7, W13, W15
  const auto solved = [](Options options, double stretch, double compression) {
    const auto even = build("even", std::move(options));
    std::vector<double> control = rest_controls(*even);
    control[channel(*even, "stretch")] = stretch;
    control[channel(*even, "compression")] = compression;
    return even->solve(control);
  };
  EXPECT_DOUBLE_EQ(solved({}, 1.5, 0.0).position.back().y, 6.0);  // stretchiness 0: held
  EXPECT_DOUBLE_EQ(solved({{"stretchiness", 1.0}}, 1.5, 0.0).position.back().y, 9.0);
  EXPECT_DOUBLE_EQ(solved({{"stretchiness", 0.5}}, 1.5, 0.0).position.back().y, 7.5);
  EXPECT_DOUBLE_EQ(
      measure(solved({{"stretchiness", 1.0}, {"max_ratio", 1.2}}, 1.5, 0.0), "curve_length"), 7.2);
  EXPECT_DOUBLE_EQ(measure(solved({{"stretchiness", 1.0}}, 1.44, 0.0), "volume"), 1.0 / 1.2);
  EXPECT_DOUBLE_EQ(solved({{"stretchiness", 1.0}, {"no_squash", true}}, 0.5, 0.0).position.back().y,
                   6.0);
  // The hip leads, the chest leads: the other end gives.
  EXPECT_DOUBLE_EQ(solved({}, 1.0, 0.25).position.back().y, 4.5);
  const SpinePose chest_led = solved({{"lead", 1.0}}, 1.0, 0.25);
  EXPECT_DOUBLE_EQ(chest_led.position.front().y, 1.5);
  EXPECT_DOUBLE_EQ(chest_led.position.back().y, 6.0);
  EXPECT_FALSE(solved({}, -1.0, 0.0).flags.empty());
}

TEST(Even, RefusesSettingsThatItCannotKeep) {
  const auto message = [](Options options) -> std::string {
    try {
      build("even", std::move(options));
    } catch (const RigError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(
      message({{"weights", std::vector<std::vector<double>>{{0.5, 0.4}, {0, 1}}}}).find("weights"),
      std::string::npos);
  EXPECT_NE(message({{"twist", std::vector<double>{0, 0}}}).find("no density"), std::string::npos);
  EXPECT_NE(message({{"twist", std::vector<double>{1, -1}}}).find("-1"), std::string::npos);
  EXPECT_NE(message({{"reach", 0.5}, {"limits", "human"}}).find("limits"), std::string::npos);
  EXPECT_NE(message({{"reach", 2.0}}).find("0 to 1"), std::string::npos);
  EXPECT_NE(message({{"rech", 1.0}}).find("reach"), std::string::npos);
}

TEST(FastTrigonometry, IsTheLibrarysToTheLastDigits) {
  std::mt19937 rng(13);
  for (const double most : {1e-8, kSmallAngle, 30.0, 1e4, 1e6}) {
    std::uniform_real_distribution<double> angle(-most, most);
    for (int i = 0; i < 20000; ++i) {
      // The last lane stands where octants meet.
      const double x[4] = {angle(rng), angle(rng), angle(rng),
                           most > 1.0 ? kPi / 4 * std::floor(angle(rng)) : 0.0};
      Lanes s, c, opposite_s, opposite_c;
      sin_cos(Lanes::load(x), s, c);
      sin_cos(Lanes(-x[0], -x[1], -x[2], -x[3]), opposite_s, opposite_c);
      for (int k = 0; k < 4; ++k) {
        EXPECT_NEAR(s[k], std::sin(x[k]), 3e-16) << x[k];
        EXPECT_NEAR(c[k], std::cos(x[k]), 3e-16) << x[k];
        EXPECT_EQ(opposite_s[k], -s[k]);
        EXPECT_EQ(opposite_c[k], c[k]);
      }
      if (most > kSmallAngle) continue;
      Lanes small_s, small_c;
      sin_cos_small(Lanes::load(x), small_s, small_c);
      for (int k = 0; k < 4; ++k) {
        EXPECT_EQ(small_s[k], s[k]);
        EXPECT_EQ(small_c[k], c[k]);
      }
    }
  }
  Lanes s, c;
  sin_cos(Lanes(0.0), s, c);
  EXPECT_EQ(s[0], 0.0);
  EXPECT_EQ(c[0], 1.0);
}

TEST(FastTrigonometry, OfTinyAnglesNeedsFewerTerms) {
  for (int i = -10000; i <= 10000; ++i) {
    const double x = kTinyAngle * i / 10000.0;
    Lanes s, c, opposite_s, opposite_c;
    sin_cos_tiny(Lanes(x), s, c);
    sin_cos_tiny(Lanes(-x), opposite_s, opposite_c);
    EXPECT_NEAR(s[0], std::sin(x), 3e-17) << x;  // an angle of 0.11 has digits down to 1.4e-17
    EXPECT_NEAR(c[0], std::cos(x), 2e-16) << x;
    EXPECT_EQ(opposite_s[3], -s[3]);
    EXPECT_EQ(opposite_c[3], c[3]);
  }
}

TEST(HumanLevels, FillTheSpineAndAddUp) {
  const auto levels = human_levels();
  ASSERT_EQ(levels.size(), 17u);  // R5: five lumbar, twelve thoracic
  EXPECT_EQ(levels.front().from, 0.0);
  EXPECT_DOUBLE_EQ(levels[5].from, 0.38);  // the lumbar part of the way
  EXPECT_DOUBLE_EQ(levels.back().to, 1.0);
  for (std::size_t i = 1; i < levels.size(); ++i)
    EXPECT_DOUBLE_EQ(levels[i].from, levels[i - 1].to);
  RangeOfMotion sum;
  for (const SpineLevel& l : levels) sum.extension += l.range.extension, sum.axial += l.range.axial;
  EXPECT_NEAR(human_range(0, 1).extension, sum.extension, 1e-12);
  EXPECT_NEAR(human_range(0, 0.3).axial + human_range(0.3, 1).axial, sum.axial, 1e-12);
}

}  // namespace
}  // namespace backbend::solver
