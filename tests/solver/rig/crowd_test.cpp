// Crowds: many poses at once are the poses one by one, to the last bit.
#include "solver/rig/crowd.h"

#include <algorithm>
#include <bit>
#include <random>

#include "tests/solver/rig_fixture.h"

namespace backbend::solver {
namespace {

using namespace rigs;

/// Bit for bit: zeros of either sign differ, and not-a-number would equal itself.
void expect_bits(double actual, double expected, const std::string& what) {
  EXPECT_EQ(std::bit_cast<std::uint64_t>(actual), std::bit_cast<std::uint64_t>(expected)) << what;
}

void expect_crowd_is_its_poses(const SpineSystem& system, const CrowdControls& control) {
  CrowdPose crowd;
  crowd.resize(1, 1);  // memory that held something else
  solve_crowd(system, control, crowd);
  ASSERT_EQ(crowd.pose_count(), control.count);
  ASSERT_EQ(crowd.joint_count(), system.joint_names().size());
  for (std::size_t i = 0; i < control.count && !testing::Test::HasFailure(); ++i) {
    std::vector<double> own;
    for (std::size_t c = 0; c < system.channels().size(); ++c) own.push_back(control.at(c, i));
    const SpinePose pose = system.solve(own);
    const std::string at = "pose " + std::to_string(i);
    const auto expect = [&](std::size_t joint, const dvec3& origin, const dquat& turn) {
      for (int a = 0; a < 3; ++a) {
        expect_bits(crowd.position(joint, std::size_t(a))[i], origin[a], at);
      }
      const double part[] = {turn.w, turn.x, turn.y, turn.z};
      for (std::size_t k = 0; k < 4; ++k) expect_bits(crowd.turn(joint, k)[i], part[k], at);
    };
    for (std::size_t j = 0; j < pose.joint_count(); ++j) expect(j, pose.position[j], pose.turn[j]);
    EXPECT_EQ(crowd.flagged()[i] != 0, !pose.flags.empty()) << at;
    EXPECT_EQ(crowd.arms_turn(0)[i], pose.arms.turn.w) << at;
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_EQ(crowd.arms_origin(a)[i], pose.arms.posed_origin[int(a)]) << at;
    }
  }
}

/// Ordinary poses, and among them rest, folds, whole turns, tiny and huge values.
std::vector<double> crowd_controls(const SpineSystem& system, std::size_t poses,
                                   std::mt19937& rng) {
  const double corner[] = {0.0, kPi, -kPi, kPi / 2, 2 * kPi, 1e-9, 1e6, 3e6, 4 * kPi, -0.0};
  std::vector<double> value(system.channels().size() * poses);
  for (std::size_t i = 0; i < poses; ++i) {
    const auto kind = rng() % 6;
    for (std::size_t c = 0; c < system.channels().size(); ++c) {
      const Channel& channel = system.channels()[c];
      const double unit = double(rng()) / 2147483648.0 - 1.0;
      double& v = value[c * poses + i];
      const bool turns = channel.kind == Channel::Kind::rotation;
      v = kind == 0   ? channel.rest
          : !turns    ? channel.rest + 0.2 * unit
          : kind == 1 ? corner[rng() % 10]
                      : unit;
    }
  }
  return value;
}

std::vector<std::pair<std::string, Options>> crowd_rigs() {
  std::vector<std::pair<std::string, Options>> rigs = {
      {"three_bone", {}},
      {"curve", {}},
      {"curve", {{"bones", 1.0}, {"length", "arc"}, {"arms", "top"}}},
      {"curve", {{"bones", 64.0}, {"length", "rest"}}},
      {"curve", {{"basis", "interpolate"}, {"bones", 7.0}}},
      {"curve", {{"basis", "linear"}, {"bones", 9.0}}},
      {"curve", {{"length", "null_sum"}}},
      {"curve", {{"length", "close"}, {"roll", "full"}}},
      {"curve", {{"follow", "on_curve"}, {"control_names", "hero_{name}"}}},
      {"isner", {}},
      {"even", {}},
      {"even", {{"bones", 1.0}}},
      {"even", {{"bones", 17.0}, {"stretchiness", 0.7}, {"lead", 0.5}, {"arms", "top"}}},
      {"even",
       {{"twist", "anatomical"},
        {"weights", OptionValue(std::vector<std::vector<double>>{{0.1, 0.7}, {0.35, 0.9}})}}},
      {"even", {{"reach", 1.0}, {"control_names", "{name}_ctrl"}}},
      {"even", {{"limits", "human"}}},
      {"stretchy", {{"bones", 5.0}}},
      {"neck", {}},
      {"snake", {{"joints", 12.0}, {"controls", 6.0}}},
      {"spline_ik", {}},
      {"matrix_blend", {}}};
  return rigs;
}

TEST(Crowd, OfAnySizeIsItsPosesOneByOneToTheLastBit) {
  std::mt19937 rng(7);
  RestChain spatial = curved();
  spatial.joint[1].x = 0.3;
  for (const auto& [name, options] : crowd_rigs()) {
    for (const RestChain& chain : {straight(), spatial}) {
      SCOPED_TRACE(name + ", " + std::to_string(options.size()) + " options");
      const auto system = build(name, options, chain);
      for (const std::size_t poses : {0u, 1u, 2u, 3u, 4u, 5u, 7u, 8u, 9u, 150u}) {
        const auto value = crowd_controls(*system, poses, rng);
        expect_crowd_is_its_poses(*system, {value, poses});
      }
    }
  }
}

TEST(Crowd, SolvedInPartsIsTheSameCrowd) {
  for (const char* name : {"curve", "even", "isner"}) {
    const auto system = build(name, {}, curved());
    std::mt19937 rng(9);
    constexpr std::size_t kPoses = 23;
    const auto value = crowd_controls(*system, kPoses, rng);
    CrowdPose whole, parts;
    solve_crowd(*system, {value, kPoses}, whole);
    parts.resize(system->joint_names().size(), kPoses);
    for (const PoseRange range : {PoseRange{9, 12}, {0, 9}, {12, 12}, {12, 22}, {22, 23}})
      solve_crowd(*system, {value, kPoses}, range, parts);
    for (std::size_t j = 0; j <= whole.joint_count(); ++j)
      for (std::size_t i = 0; i < kPoses; ++i) {
        for (std::size_t a = 0; a < 3; ++a)
          expect_bits(parts.position(j, a)[i], whole.position(j, a)[i], name);
        for (std::size_t a = 0; a < 4; ++a)
          expect_bits(parts.turn(j, a)[i], whole.turn(j, a)[i], name);
      }
    EXPECT_TRUE(std::ranges::equal(parts.flagged(), whole.flagged())) << name;
  }
}

TEST(Crowd, PosesDoNotDependOnTheirNeighboursInIt) {
  for (const char* name : {"curve", "even"}) {
    const auto system = build(name, {}, curved());
    std::mt19937 rng(8);
    constexpr std::size_t kPoses = 13;
    const auto value = crowd_controls(*system, kPoses, rng);
    std::vector<double> turned(value.size());
    for (std::size_t k = 0; k < value.size(); ++k) {
      const std::size_t c = k / kPoses, i = k % kPoses;
      turned[c * kPoses + (kPoses - 1 - i)] = value[k];
    }
    CrowdPose a, b;
    solve_crowd(*system, {value, kPoses}, a);
    solve_crowd(*system, {turned, kPoses}, b);
    for (std::size_t j = 0; j < a.joint_count(); ++j) {
      for (std::size_t i = 0; i < kPoses; ++i) {
        expect_bits(a.position(j, 2)[i], b.position(j, 2)[kPoses - 1 - i], name);
        expect_bits(a.turn(j, 3)[i], b.turn(j, 3)[kPoses - 1 - i], name);
      }
    }
  }
}

}  // namespace
}  // namespace backbend::solver
