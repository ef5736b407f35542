#include "validate/metrics/chain/clip_flip.h"
#include "tests/validate/metrics/axes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace backbend::validate {
namespace {

/// A lively clip: each joint swings about two axes, a few times a second at its busiest.
struct Clip {
  std::size_t joints = 3, frames = 144;
  std::vector<glm::dquat> turn;
  std::vector<double> time;

  explicit Clip(double speed = 1.0, double rate = 30.0) {
    for (std::size_t f = 0; f < frames; ++f) {
      time.push_back(static_cast<double>(f) / rate);
      for (std::size_t j = 0; j < joints; ++j) {
        const double t = time.back() * speed, k = 1.0 + 0.3 * static_cast<double>(j);
        turn.push_back(rotation(kX * (0.6 * std::sin(5.0 * k * t))) *
                       rotation(kZ * (0.4 * std::sin(3.1 * k * t + 1.0))));
      }
    }
  }
  glm::dquat& at(std::size_t frame, std::size_t joint) { return turn[frame * joints + joint]; }
  FlipReport find() const { return find_clip_flips({joints, turn, time}); }
};

/// One joint of one jump; each counts by itself.
struct Found {
  std::size_t joint, frame, frames_out;
  double size_deg;
};

std::vector<Found> each_joint(const FlipReport& report) {
  std::vector<Found> out;
  for (const Jump& jump : report.jumps)
    for (const JointJump& each : jump.joints)
      out.push_back({each.joint, jump.pose, each.frames_out, each.size_deg});
  return out;
}

TEST(FindClipFlips, AcrobaticsAreNoFlips) {
  for (double speed : {0.0, 1.0, 2.0, 3.0}) EXPECT_TRUE(Clip(speed).find().jumps.empty()) << speed;
}

TEST(FindClipFlips, AStepIsFoundBetweenItsFramesAndSized) {
  for (double size_deg : {60.0, 90.0, 120.0, 180.0})
    for (std::size_t at : {0u, 1u, 50u, 141u, 142u}) {
      Clip clip;
      for (std::size_t f = at + 1; f < clip.frames; ++f)
        clip.at(f, 1) = clip.at(f, 1) * rotation(kX * radians_from(size_deg));
      const FlipReport report = clip.find();
      ASSERT_EQ(each_joint(report).size(), 1u) << size_deg << " at " << at;
      EXPECT_EQ(each_joint(report)[0].joint, 1u);
      EXPECT_EQ(each_joint(report)[0].frame, at);
      EXPECT_EQ(each_joint(report)[0].frames_out, 0u);
      EXPECT_NEAR(each_joint(report)[0].size_deg, size_deg, 0.05 * size_deg);
    }
}

TEST(FindClipFlips, InCalmMotionEightDegreesAreEnoughWhicheverSideTheyAreMultipliedFrom) {
  for (double size_deg : {8.0, 10.0, 25.0, 40.0, 90.0, 180.0})
    for (const bool own : {false, true})
      for (std::size_t out : {0u, 1u, 2u, 4u, 20u}) {
        Clip clip(0.1);
        const glm::dquat turn =
            rotation(glm::normalize(glm::dvec3(1, 2, -1)) * radians_from(size_deg));
        for (std::size_t f = 60; f < (out == 0 ? clip.frames : 60 + out); ++f)
          clip.at(f, 2) = own ? clip.at(f, 2) * turn : turn * clip.at(f, 2);
        const FlipReport report = clip.find();
        // What stays away for more than four frames is two events.
        ASSERT_EQ(each_joint(report).size(), out > 4 ? 2u : 1u) << size_deg << " for " << out;
        EXPECT_EQ(each_joint(report)[0].joint, 2u);
        EXPECT_EQ(each_joint(report)[0].frame, 59u);
        EXPECT_EQ(each_joint(report)[0].frames_out, out > 4 ? 0u : out);
        for (const Found& jump : each_joint(report))
          EXPECT_NEAR(jump.size_deg, size_deg, 0.05 * size_deg) << out;
      }
}

TEST(FindClipFlips, SeveralJointsBetweenTheSameFramesAreOneJump) {
  Clip clip(0.1);
  for (std::size_t f = 60; f < clip.frames; ++f)
    for (const std::size_t joint : {2u, 0u})
      clip.at(f, joint) = clip.at(f, joint) * rotation(kX * radians_from(30.0));
  const FlipReport report = clip.find();
  ASSERT_EQ(report.jumps.size(), 1u);
  ASSERT_EQ(report.jumps[0].joints.size(), 2u);
  EXPECT_EQ(report.jumps[0].joints[0].joint, 0u);
  EXPECT_EQ(report.jumps[0].joints[1].joint, 2u);
}

TEST(FindClipFlips, OutAndBackForLongAreTwo) {
  Clip clip;
  for (std::size_t f = 40; f < 60; ++f) clip.at(f, 2) = clip.at(f, 2) * rotation(kX * kPi);
  const FlipReport report = clip.find();
  ASSERT_EQ(each_joint(report).size(), 2u);
  EXPECT_EQ(each_joint(report)[0].frame, 39u);
  EXPECT_EQ(each_joint(report)[1].frame, 59u);
}

TEST(FindClipFlips, AJumpDoesNotHideASmallerOneBesideIt) {
  Clip clip(0.2);
  for (std::size_t f = 60; f < clip.frames; ++f) clip.at(f, 1) = clip.at(f, 1) * rotation(kX * kPi);
  for (std::size_t f = 66; f < clip.frames; ++f)
    clip.at(f, 1) = clip.at(f, 1) * rotation(kZ * radians_from(12.0));
  const FlipReport report = clip.find();
  ASSERT_EQ(each_joint(report).size(), 2u);
  EXPECT_EQ(each_joint(report)[0].frame, 59u);
  EXPECT_EQ(each_joint(report)[1].frame, 65u);
  EXPECT_NEAR(each_joint(report)[1].size_deg, 12.0, 0.6);
}

TEST(FindClipFlips, PopsNearEachOtherDoNotHideEachOther) {
  for (const double size_deg : {20.0, 40.0, 90.0, 170.0})
    for (const std::size_t apart : {2u, 3u, 4u, 5u, 7u})
      for (const std::size_t pops : {2u, 3u}) {
        Clip clip(0.2);
        for (std::size_t i = 0; i < pops; ++i) {
          glm::dquat& turn = clip.at(60 + i * apart, 1);
          turn = turn * rotation(kX * radians_from(size_deg));
        }
        const std::vector<Found> found = each_joint(clip.find());
        ASSERT_FALSE(found.empty()) << size_deg << ", " << apart;
        // So wide and near that their pauses could as well be the pops.
        if (size_deg >= 90.0 && apart <= 3) continue;
        ASSERT_EQ(found.size(), pops) << size_deg << ", " << apart;
        for (std::size_t i = 0; i < pops; ++i) {
          EXPECT_EQ(found[i].frame, 59 + i * apart) << size_deg;
          EXPECT_EQ(found[i].frames_out, 1u) << size_deg;
          EXPECT_NEAR(found[i].size_deg, size_deg, 0.05 * size_deg) << apart;
        }
      }
}

TEST(FindClipFlips, APopOfOneFrameNextToAnEndIsFound) {
  for (const double size_deg : {25.0, 60.0, 170.0})
    for (const std::size_t frame : {1u, 142u}) {
      Clip clip(0.1);
      clip.at(frame, 1) = clip.at(frame, 1) * rotation(kX * radians_from(size_deg));
      const std::vector<Found> found = each_joint(clip.find());
      ASSERT_EQ(found.size(), 1u) << size_deg << " at " << frame;
      EXPECT_EQ(found[0].frame, frame - 1);
      EXPECT_NEAR(found[0].size_deg, size_deg, 0.05 * size_deg);
    }
}

TEST(FindClipFlips, ALeapOfTwoFramesIsMotionUnlessControlsSayOtherwise) {
  // `turn` in each of two frames in a row; the second by `second` of it.
  const auto leap = [](double turn_deg, double second, const glm::dvec3& axis, bool controls) {
    Clip clip(0.1);
    for (std::size_t f = 60; f < clip.frames; ++f)
      clip.at(f, 0) = clip.at(f, 0) * rotation(kX * radians_from(turn_deg));
    for (std::size_t f = 61; f < clip.frames; ++f)
      clip.at(f, 0) = clip.at(f, 0) * rotation(axis * radians_from(second * turn_deg));
    ClipSettings settings;
    if (controls) settings.two_frames_deg = 0.0;
    return each_joint(find_clip_flips({3, clip.turn, clip.time}, settings)).size();
  };
  EXPECT_EQ(leap(19.0, 1.0, kX, false), 0u);
  EXPECT_EQ(leap(19.0, 1.0, kX, true), 2u);
  EXPECT_EQ(leap(41.0, 1.0, kX, false), 0u) << "an attack";
  EXPECT_EQ(leap(60.0, 1.0, kX, false), 2u) << "a flip of 120 degrees that a player shows half way";
  EXPECT_EQ(leap(19.0, 1.0, kZ, false), 2u) << "another way";
  EXPECT_GE(leap(19.0, 0.3, kX, false), 1u) << "another pace";
}

TEST(FindClipFlips, AJointsOwnPopRaisesNoFloor) {
  // The clavicle of the report that hid its own 25 degrees: still but for one frame.
  Clip clip;
  for (std::size_t f = 0; f < clip.frames; ++f)
    clip.at(f, 0) = rotation(kX * (f == 70 ? radians_from(25.0) : 0.0));
  const FlipReport report = clip.find();
  ASSERT_EQ(each_joint(report).size(), 1u);
  EXPECT_NEAR(each_joint(report)[0].size_deg, 25.0, 0.01);
  EXPECT_LT(report.detectable_deg[0], 8.0);
}

TEST(FindClipFlips, TheSignOfAQuaternionIsNoMotion) {
  Clip clip;
  for (std::size_t f = 30; f < 90; ++f) clip.at(f, 0) = -clip.at(f, 0);
  EXPECT_TRUE(clip.find().jumps.empty());
}

TEST(FindClipFlips, UnevenKeysAreNoJumps) {
  // Every third frame dropped, and a gap of five: the same motion at other times.
  const Clip even;
  Clip uneven;
  uneven.turn.clear();
  uneven.time.clear();
  for (std::size_t f = 0; f < even.frames; ++f) {
    if (f % 3 == 2 || (f > 70 && f < 75)) continue;
    uneven.time.push_back(even.time[f]);
    for (std::size_t j = 0; j < 3; ++j) uneven.turn.push_back(even.turn[f * 3 + j]);
  }
  EXPECT_TRUE(uneven.find().jumps.empty());
}

TEST(FindClipFlips, ASteadySpinIsNoFlip) {
  Clip clip;
  for (std::size_t f = 0; f < clip.frames; ++f)
    clip.at(f, 0) = rotation(kX * wrapped(radians_from(45.0 * static_cast<double>(f))));
  EXPECT_TRUE(clip.find().jumps.empty());
}

TEST(FindClipFlips, SaysWhatItCouldNotHaveSeen) {
  const FlipReport calm = Clip(0.1).find(), lively = Clip(6.0).find();
  EXPECT_LT(calm.detectable_deg[0], 8.0);
  EXPECT_GT(lively.detectable_deg[2], 45.0);
}

TEST(FindClipFlips, AJumpOfTheSizeThatIsStatedIsFoundAnywhere) {
  for (double speed : {0.1, 0.5, 1.0, 2.0}) {
    const FlipReport clean = Clip(speed).find();
    for (std::size_t joint = 0; joint < 3; ++joint)
      for (std::size_t at = 0; at + 1 < 144; at += 11) {
        // A degree more: the planted turn moves the paces behind it a little.
        const double size_deg = std::min(180.0, clean.detectable_deg[joint] + 1.0);
        if (size_deg > 170.0) continue;
        Clip clip(speed);
        for (std::size_t f = at + 1; f < clip.frames; ++f)
          clip.at(f, joint) = clip.at(f, joint) * rotation(kZ * radians_from(size_deg));
        const std::vector<Found> jumps = each_joint(clip.find());
        EXPECT_TRUE(
            std::any_of(jumps.begin(), jumps.end(),
                        [&](const Found& jump) { return jump.joint == joint && jump.frame == at; }))
            << speed << " joint " << joint << " at " << at << " by " << size_deg;
      }
  }
}

TEST(FindClipFlips, TooFewFramesDetectNothing) {
  Clip clip;
  clip.time.resize(4);
  clip.turn.resize(12);
  clip.at(2, 0) = rotation(kX * 3.0);
  const FlipReport report = clip.find();
  EXPECT_TRUE(each_joint(report).empty());
  EXPECT_TRUE(std::isinf(report.detectable_deg[0]));
}

TEST(FindClipFlips, AFrameThatIsNotANumberIsNamed) {
  Clip clip;
  clip.at(17, 2).y = std::nan("");
  EXPECT_FALSE(clip.find().finite);
  EXPECT_EQ(clip.find().not_finite_pose, 17u);
}

}  // namespace
}  // namespace backbend::validate
