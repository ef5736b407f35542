#include "validate/metrics/chain/flip.h"
#include "tests/validate/metrics/axes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace backbend::validate {
namespace {

double uniform(std::mt19937_64& rng, double low, double high) {
  return low + (high - low) * (static_cast<double>(rng() >> 11) * 0x1p-53);
}

glm::dvec3 random_axis(std::mt19937_64& rng) {
  for (;;) {
    const glm::dvec3 v(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -1, 1));
    const double length = glm::length(v);
    if (length > 0.1 && length < 1.0) return v / length;
  }
}

/// A smooth rig: each joint turns about three axes by a few slow waves, and may whip once.
struct SmoothRig {
  struct Wave {
    glm::dvec3 axis;
    double angle, frequency, phase;
  };
  struct Whip {
    glm::dvec3 axis{1, 0, 0};
    double angle = 0.0, place = 0.5, width = 1.0;
  };
  std::vector<std::array<Wave, 3>> joint;
  std::vector<Whip> whip;

  static SmoothRig random(std::mt19937_64& rng, std::size_t joints) {
    SmoothRig rig;
    for (std::size_t j = 0; j < joints; ++j) {
      rig.joint.emplace_back();
      for (Wave& wave : rig.joint.back())
        wave = {random_axis(rng), radians_from(uniform(rng, 5, 60)), uniform(rng, 0.5, 2.5),
                uniform(rng, 0, 6)};
      rig.whip.emplace_back();
    }
    return rig;
  }

  void operator()(double t, FlipSample& sample) const {
    sample.turn.resize(joint.size());
    for (std::size_t j = 0; j < joint.size(); ++j) {
      glm::dquat q(1, 0, 0, 0);
      for (const Wave& wave : joint[j])
        q = rotation(wave.axis * (wave.angle * std::sin(wave.frequency * t * 3.0 + wave.phase))) *
            q;
      const Whip& w = whip[j];
      // A turn by `angle` within a few widths: its speed is angle / (4 width) at the middle.
      q = rotation(w.axis * (w.angle / (1.0 + std::exp((w.place - t) / w.width)))) * q;
      sample.turn[j] = q;
    }
  }
};

glm::dquat turn_about(const glm::dvec3& axis, double deg) {
  return rotation(axis * radians_from(deg));
}

/// Control degrees that make a typical wave rig's median gain about one.
constexpr double kControl = 180.0;

TEST(FindFlips, FindsEveryJumpAtIrrationalPlacesAndSizesItToOneInAThousand) {
  std::mt19937_64 rng(1);
  int planted = 0;
  for (int rig_number = 0; rig_number < 60; ++rig_number) {
    const SmoothRig smooth = SmoothRig::random(rng, 6);
    struct Planted {
      double t, size;
      std::size_t joint;
      glm::dvec3 axis;
    };
    std::vector<Planted> jumps;
    for (int k = 0; k < 3; ++k)  // fractional parts of multiples of the golden ratio: never dyadic
      jumps.push_back({std::fmod((rig_number * 3 + k + 1) * 0.6180339887498949, 1.0),
                       uniform(rng, 1.5, 180.0), static_cast<std::size_t>(rng() % 6),
                       random_axis(rng)});
    std::ranges::sort(jumps, {}, &Planted::t);
    const FlipRig rig = [&](double t, FlipSample& sample) {
      smooth(t, sample);
      for (const Planted& jump : jumps)
        if (t > jump.t)
          sample.turn[jump.joint] =
              sample.turn[jump.joint] * rotation(jump.axis * radians_from(jump.size));
    };
    const FlipReport report = find_flips(rig, {.intervals = 90, .control_deg = kControl});
    ASSERT_EQ(report.jumps.size(), jumps.size()) << "rig " << rig_number;
    for (std::size_t k = 0; k < jumps.size(); ++k) {
      const Jump& found = report.jumps[k];
      EXPECT_NEAR(found.t, jumps[k].t, 1e-5) << "rig " << rig_number;
      EXPECT_LT(found.before, jumps[k].t);
      EXPECT_GE(found.after, jumps[k].t);
      ASSERT_EQ(found.joints.size(), 1u);
      EXPECT_EQ(found.joints[0].joint, jumps[k].joint);
      EXPECT_NEAR(found.size_deg(), jumps[k].size, 1e-3 * jumps[k].size);
      ++planted;
    }
    EXPECT_TRUE(report.certified);
  }
  EXPECT_EQ(planted, 180);
}

TEST(FindFlips, CallsNoSmoothRigAFlipHoweverFastItWhips) {
  std::mt19937_64 rng(2);
  int whips = 0;
  for (int rig_number = 0; rig_number < 1000; ++rig_number) {
    SmoothRig rig = SmoothRig::random(rng, 4);
    if (rig_number % 2 == 0) {
      // The waves turn at about 1 deg per deg; angle / (4 width) is 50 times that or more.
      const double angle = uniform(rng, 40, 170);
      rig.whip[rng() % 4] = {random_axis(rng), radians_from(angle), uniform(rng, 0.1, 0.9),
                             angle / (4.0 * 50.0 * kControl * uniform(rng, 1.0, 3.0))};
      ++whips;
    }
    const FlipReport report = find_flips(rig, {.intervals = 90, .control_deg = kControl});
    EXPECT_TRUE(report.jumps.empty()) << "rig " << rig_number;
    EXPECT_TRUE(report.certified);
    EXPECT_EQ(report.steep.empty(), rig_number % 2 != 0) << "rig " << rig_number;
    if (!report.steep.empty()) {
      EXPECT_GT(report.steep[0].gain, 45.0);
    }
  }
  EXPECT_EQ(whips, 500);
}

TEST(FindFlips, MeasuresTheGainOfAJointThatTurnsTwiceAsFastAsItsControl) {
  const FlipRig rig = [](double t, FlipSample& sample) {
    sample.turn = {rotation(kX * radians_from(120.0 * t)), rotation(kX * radians_from(240.0 * t))};
  };
  const FlipReport report = find_flips(rig, {.intervals = 60, .control_deg = 120.0});
  ASSERT_EQ(report.gain.size(), 2u);
  EXPECT_NEAR(report.gain[0], 1.0, 1e-9);
  EXPECT_NEAR(report.gain[1], 2.0, 1e-9);
  EXPECT_TRUE(report.steep.empty());
}

TEST(FindFlips, GainIsTheFastestWhicheverEndOfTheSweepItIsAt) {
  const FlipRig rig = [](double t,
                         FlipSample& sample) {  // one slows down to rest, one is its mirror
    sample.turn = {rotation(kX * radians_from(120.0 * (2.0 * t - t * t))),
                   rotation(kX * radians_from(120.0 * t * t))};
  };
  const FlipReport report = find_flips(rig, {.intervals = 60, .control_deg = 120.0});
  EXPECT_NEAR(report.gain[0], report.gain[1], 1e-9);
  EXPECT_LT(report.gain[0], 2.0);
  EXPECT_GT(report.gain[0], 2.0 - 0.5 / 60.0);
}

TEST(FindFlips, WithoutControlTheGainIsNotMeasuredButJumpsAreFound) {
  const FlipRig rig = [](double t, FlipSample& sample) {
    sample.turn = {t > 0.3 ? rotation(kX * 0.5) : glm::dquat(1, 0, 0, 0)};
  };
  const FlipReport report = find_flips(rig, {.intervals = 10, .control_deg = 0.0});
  EXPECT_TRUE(std::isnan(report.gain[0]));
  EXPECT_EQ(report.jumps.size(), 1u);
}

/// Joint 0 turns over and back within one interval: an up vector that touches the tangent twice.
void two_that_cancel(double t, FlipSample& sample, double middle, double apart) {
  const bool over = std::abs(t - middle) < 0.5 * apart;
  sample.turn = {rotation(kX * (over ? kPi : 0.0) + kX * 0.1 * t)};
  sample.bone = {kX};
  sample.margin = {std::abs(std::abs(t - middle) - 0.5 * apart) * radians_from(kControl)};
}

TEST(FindFlips, TwoJumpsThatCancelInsideOneIntervalAreBetrayedByTheirMargin) {
  const double middle = 1.0 / std::sqrt(3.0), apart = 0.0003;  // a 37th of an interval
  const FlipRig rig = [=](double t, FlipSample& s) { two_that_cancel(t, s, middle, apart); };
  const FlipReport report = find_flips(rig, {.intervals = 90, .control_deg = kControl});
  ASSERT_EQ(report.jumps.size(), 2u);
  EXPECT_NEAR(report.jumps[0].t, middle - 0.5 * apart, 1e-6);
  EXPECT_NEAR(report.jumps[1].t, middle + 0.5 * apart, 1e-6);
  EXPECT_EQ(report.jumps[0].kind, FlipClass::up_vector);
  EXPECT_LT(report.least_margin_deg[0], 1e-3);
}

TEST(FindFlips, WithoutAMarginTwoThatCancelAreFoundDownToTheStatedGap) {
  for (int place = 0; place < 50; ++place) {
    const double apart = 1.01 * 0.25 / 90, middle = 0.1 + place * 0.0137;
    const FlipRig rig = [=](double t, FlipSample& s) {
      two_that_cancel(t, s, middle, apart);
      s.margin.clear();
    };
    const FlipReport report = find_flips(rig, {.intervals = 90, .control_deg = kControl});
    EXPECT_EQ(report.jumps.size(), 2u) << "place " << middle;
    EXPECT_LT(report.smallest_gap, apart);
  }
}

TEST(FindFlips, AJumpExactlyOnASampledPoseIsOneJumpWhateverThatPoseShows) {
  for (double share : {0.0, 0.3, 0.5, 1.0}) {  // of the jump that the pose itself already has
    const FlipRig rig = [=](double t, FlipSample& sample) {
      const double angle = t < 0.5 ? 0.0 : t > 0.5 ? 1.0 : share;
      sample.turn = {rotation(kZ * radians_from(120.0 * angle) + kZ * 0.2 * t)};
    };
    const FlipReport report = find_flips(rig, {.intervals = 90, .control_deg = kControl});
    ASSERT_EQ(report.jumps.size(), 1u) << share;
    EXPECT_NEAR(report.jumps[0].size_deg(), 120.0, 1e-3);
    EXPECT_NEAR(report.jumps[0].t, 0.5, 1e-5);
  }
}

TEST(FindFlips, APoseThatAloneIsWrongIsASpike) {
  const FlipRig rig = [](double t, FlipSample& sample) {
    sample.turn = {rotation(kZ * (t == 0.5 ? 1.0 : 0.0))};
  };
  const FlipReport report = find_flips(rig, {.intervals = 90, .control_deg = kControl});
  ASSERT_EQ(report.jumps.size(), 1u);
  EXPECT_EQ(report.jumps[0].kind, FlipClass::spike);
}

TEST(FindFlips, TheSignOfAQuaternionIsNoMotion) {
  const FlipRig rig = [](double t, FlipSample& sample) {
    const glm::dquat q = rotation(kX * t);
    sample.turn = {t > 1.0 / 3.0 && t < 0.7 ? -q : q};
  };
  EXPECT_TRUE(find_flips(rig, {.intervals = 20, .control_deg = 60.0}).jumps.empty());
}

TEST(FindFlips, AJumpBelowTheStatedSizeIsNotClaimedEitherWay) {
  const FlipRig rig = [](double t, FlipSample& sample) {
    sample.turn = {rotation(kX * radians_from(t > 0.437 ? 0.4 : 0.0))};
  };
  const FlipReport coarse = find_flips(rig, {.intervals = 20, .smallest_deg = 1.0});
  EXPECT_TRUE(coarse.jumps.empty());
  EXPECT_EQ(coarse.smallest_deg, 1.0);
  EXPECT_EQ(find_flips(rig, {.intervals = 20, .smallest_deg = 0.1}).jumps.size(), 1u);
}

TEST(FindFlips, PositionsThatJumpAloneAreAPop) {
  const FlipRig rig = [](double t, FlipSample& sample) {
    sample.turn = {glm::dquat(1, 0, 0, 0)};
    sample.position = {kY * (t + (t > 0.61803398875 ? 0.3 : 0.0))};
  };
  const FlipReport report = find_flips(rig, {.intervals = 30, .length = 6.0});
  ASSERT_EQ(report.jumps.size(), 1u);
  EXPECT_EQ(report.jumps[0].kind, FlipClass::pop);
  EXPECT_NEAR(report.jumps[0].joints[0].shift, 0.05, 1e-6);
}

/// Joints that spread the turn of the end by fraction through a quaternion's shortest way.
void spread(double t, FlipSample& sample, double control_deg, bool shortest,
            const glm::dvec3& axis) {
  const double angle = radians_from(control_deg * t);
  const double seen = shortest ? wrapped(angle) : angle > 2 * kPi ? angle - 4 * kPi : angle;
  sample.turn.clear();
  sample.bone.clear();
  for (double fraction : {1.0 / 6, 2.0 / 6, 3.0 / 6, 4.0 / 6, 5.0 / 6}) {
    sample.turn.push_back(rotation(axis * (fraction * seen)));
    sample.bone.push_back(kX);
  }
  sample.end = rotation(axis * angle);
}

TEST(FindFlips, WhatHangsFromTheChainIsSearchedForJumpsAndHasNoGain) {
  const FlipRig rig = [](double t, FlipSample& sample) {
    sample.turn = {turn_about(kX, 10.0 * t), turn_about(kX, 2000.0 * t),
                   turn_about(kY, t < 0.7071 ? 0.0 : 40.0)};
    sample.hanging = 2;
  };
  FlipSettings settings;
  settings.control_deg = 100.0;
  const FlipReport report = find_flips(rig, settings);
  ASSERT_EQ(report.jumps.size(), 1u);
  EXPECT_EQ(report.jumps[0].joints[0].joint, 2u);
  EXPECT_NEAR(report.jumps[0].size_deg(), 40.0, 1e-6);
  EXPECT_NEAR(report.jumps[0].t, 0.7071, 1e-5);
  ASSERT_EQ(report.gain.size(), 1u);
  EXPECT_NEAR(report.gain[0], 0.1, 1e-9);
  EXPECT_TRUE(report.steep.empty());
  for (const double gain : report.interval_gain) EXPECT_NEAR(gain, 0.1, 1e-9);
}

TEST(FindFlips, AFlipOfTheChainKeepsItsClassWhereMoreHangsFromIt) {
  // From half a turn one way to half a turn the other way, shared by fraction.
  const FlipRig rig = [](double t, FlipSample& sample) {
    const double whole = 160.0 + 40.0 * t, read = whole < 180.0 ? whole : whole - 360.0;
    sample.turn.clear();
    for (const double share : {0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0, 0.0})
      sample.turn.push_back(turn_about(kY, share * read));
    sample.end = sample.turn[3];
    sample.hanging = 1;
  };
  FlipSettings settings;
  settings.fraction = {0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0};
  const FlipReport report = find_flips(rig, settings);
  ASSERT_EQ(report.jumps.size(), 1u);
  EXPECT_EQ(report.jumps[0].kind, FlipClass::hemisphere);
}

TEST(FindFlips, TellsAHemisphereFromADoubleCoverAndARollWrap) {
  FlipSettings settings{.intervals = 100, .control_deg = 400.0};
  settings.fraction = {1.0 / 6, 2.0 / 6, 3.0 / 6, 4.0 / 6, 5.0 / 6};
  const FlipReport hemisphere =
      find_flips([](double t, FlipSample& s) { spread(t, s, 400, true, kX); }, settings);
  ASSERT_EQ(hemisphere.jumps.size(), 1u);
  EXPECT_EQ(hemisphere.jumps[0].kind, FlipClass::hemisphere);
  EXPECT_NEAR(400.0 * hemisphere.jumps[0].t, 180.0, 1e-3);
  EXPECT_NEAR(hemisphere.jumps[0].size_deg(), 180.0, 1e-2);
  EXPECT_EQ(hemisphere.jumps[0].joints.size(), 5u);

  const FlipReport cover =
      find_flips([](double t, FlipSample& s) { spread(t, s, 400, false, kX); }, settings);
  ASSERT_EQ(cover.jumps.size(), 1u);
  EXPECT_NEAR(400.0 * cover.jumps[0].t, 360.0, 1e-3);

  EXPECT_EQ(cover.jumps[0].kind, FlipClass::double_cover);

  // A chain bent by a quarter turn whose twist is read back: each joint jumps about its own bone.
  const FlipReport wrap = find_flips(
      [&](double t, FlipSample& s) {
        spread(t, s, 200, true, kX);
        for (std::size_t j = 0; j < s.turn.size(); ++j) {
          const glm::dquat bend = rotation(kZ * (0.5 * kPi * settings.fraction[j]));
          s.turn[j] = bend * s.turn[j];
          s.bone[j] = bend * kX;
        }
        s.end = rotation(kZ * (0.5 * kPi)) * s.end;
      },
      settings);
  ASSERT_EQ(wrap.jumps.size(), 1u);
  EXPECT_EQ(wrap.jumps[0].kind, FlipClass::roll_wrap);
}

TEST(FindFlips, ASampleThatIsNotANumberEndsTheCertificate) {
  const FlipRig rig = [](double t, FlipSample& sample) {
    sample.turn = {rotation(kX * t)};
    if (t > 0.4) sample.turn[0].x = std::nan("");
  };
  const FlipReport report = find_flips(rig, {.intervals = 10});
  EXPECT_FALSE(report.finite);
  EXPECT_FALSE(report.certified);
  EXPECT_NEAR(report.not_finite_t, 0.5, 0.11);
}

TEST(FindFlips, AnExhaustedBudgetIsNotACertificate) {
  const FlipRig rig = [](double t, FlipSample& sample) {
    sample.turn = {rotation(kX * std::sin(4000.0 * t))};
  };
  EXPECT_FALSE(find_flips(rig, {.intervals = 10, .budget = 500}).certified);
}

TEST(FindFlips, ARigThatJumpsEverywhereIsNotCertifiedAndOneJumpIsTold) {
  const FlipRig rig = [](double t, FlipSample& sample) {  // on a half of all numbers, as it seems
    const double place = 1e9 * std::sqrt(2.0) * t;
    sample.turn = {rotation(kX * (place - std::floor(place) < 0.5 ? 1.0 : 0.0))};
  };
  const FlipReport report = find_flips(rig, {.intervals = 10, .budget = 500});
  EXPECT_FALSE(report.certified);
  ASSERT_EQ(report.jumps.size(), 1u);
  EXPECT_NEAR(report.jumps[0].size_deg(), degrees(1.0), 1e-6);
  EXPECT_LT(report.samples, 520u);
}

}  // namespace
}  // namespace backbend::validate
