// Options searched for headroom: the cube of options, the search, the gauge, and the rig file.
#include "validate/tune/tune.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "tests/temporary_folder.h"
#include "tests/validate/figure_stage.h"
#include "validate/tune/rig_file.h"
#include "validate/tune/trade_search.h"

namespace backbend::validate {
namespace {

const solver::RestChain kChain{{{0, 0, 0}, {0, 1, 0}, {0, 2, 0}, {0, 3, 0}}, {1, 0, 0}};

OptionSpace space(const solver::SystemSpec& spec, const std::vector<std::string>& vary) {
  return {spec, solver::build_system(spec, kChain)->options(), solver::option_ranges(spec, kChain),
          vary};
}

std::string refusal(const solver::SystemSpec& spec, const std::vector<std::string>& vary) {
  try {
    space(spec, vary);
  } catch (const solver::RigError& error) {
    return error.what();
  }
  return "taken";
}

TEST(OptionSpace, StartsAtTheGivenRigWithoutChangingIt) {
  for (const char* text : {"even:bones=7,reach=0.25", "curve:basis=interpolate", "isner",
                           "stretchy:depth=[0.3, 0.5]"}) {
    const solver::SystemSpec given = read_rig(text).spec;
    const OptionSpace cube = space(given, {});
    EXPECT_EQ(cube.at(cube.origin()).options, given.options) << text;
  }
}

TEST(OptionSpace, TheGivenValueStandsInTheMiddleOfALongRange) {
  const OptionSpace cube = space({"even", {}}, {"bones"});
  ASSERT_EQ(cube.axes().size(), 1u);
  const OptionAxis& bones = cube.axes().front();
  EXPECT_NEAR(cube.origin().front(), 0.5, 1e-12);
  EXPECT_EQ(bones.at(0.0), 1.0);
  EXPECT_EQ(bones.at(0.5), 10.0);
  EXPECT_EQ(bones.at(1.0), 64.0);
  for (const double value : {1.0, 2.0, 33.0, 64.0})
    EXPECT_EQ(bones.at(bones.unit_of(value)), value);
}

TEST(OptionSpace, WholeNumbersStayWholeAndWordsAreThoseAllowed) {
  const OptionSpace cube = space({"curve", {}}, {"bones=4:20", "arms"});
  std::vector<double> at{0.77, 0.9};
  const auto spec = cube.at(at);
  const double bones = std::get<double>(spec.options.at("bones"));
  EXPECT_EQ(bones, std::round(bones));
  EXPECT_GE(bones, 4.0);
  EXPECT_LE(bones, 20.0);
  EXPECT_EQ(std::get<std::string>(spec.options.at("arms")), "top");
}

TEST(OptionSpace, SpansRunUpwardsWhereverTheirEndsAre) {
  const OptionSpace cube = space({"even", {}}, {"weights"});
  ASSERT_EQ(cube.axes().size(), 4u);
  std::vector<double> at = cube.origin();
  at[0] = 1.0;  // Middle's from: above its to
  const auto rows = std::get<std::vector<std::vector<double>>>(cube.at(at).options.at("weights"));
  EXPECT_LE(rows[0][0], rows[0][1]);
  EXPECT_EQ(rows[0][1], 1.0);
}

TEST(OptionSpace, WhatCannotBeVariedIsNamed) {
  const solver::SystemSpec even{"even", {}};
  EXPECT_NE(refusal(even, {"boness"}).find("'bones'"), std::string::npos);
  EXPECT_NE(refusal(even, {"bones=4"}).find("NAME=FROM:TO"), std::string::npos);
  EXPECT_NE(refusal(even, {"bones=9:4"}).find("9 is not below"), std::string::npos);
  EXPECT_NE(refusal(even, {"bones=2:99"}).find("1 to 64"), std::string::npos);
  EXPECT_NE(refusal(even, {"bones=2.5:9"}).find("whole"), std::string::npos);
  EXPECT_NE(refusal(even, {"arms=0:1"}).find("words"), std::string::npos);
  EXPECT_NE(refusal(even, {"bones", "bones"}).find("twice"), std::string::npos);
  EXPECT_NE(refusal({"three_bone", {}}, {}).find("nothing to tune"), std::string::npos);
}

/// Gain is highest at (0.8, a whole number of thirds: 1), and change is the distance from the
/// origin in per cent.
TradeSettings hill(std::size_t evaluations, std::size_t* looked) {
  TradeSettings settings;
  settings.origin = {0.5, 0.1};
  settings.values = {0, 4};
  settings.evaluations = evaluations;
  settings.levels = {10.0, 20.0};
  settings.key = [](std::span<const double> at) {
    return std::to_string(std::lround(1000.0 * at[0])) + " " +
           std::to_string(static_cast<int>(std::min(3.0, 4.0 * at[1])));
  };
  settings.look = [looked](std::span<const double> at) -> std::optional<TradeValue> {
    ++*looked;
    const double step = std::floor(std::min(3.0, 4.0 * at[1]));
    if (step == 2.0) return std::nullopt;  // cannot be had: has to be stepped over
    return TradeValue{1.0 - std::pow(at[0] - 0.8, 2) - 0.01 * std::pow(3.0 - step, 2),
                      100.0 * std::abs(at[0] - 0.5)};
  };
  return settings;
}

TEST(TradeSearch, FindsTheBestGainBelowEachLevelOfChange) {
  std::size_t looked = 0;
  const auto front = front_of(search_trade(hill(200, &looked)), {10.0, 20.0}, 0.0);
  EXPECT_LE(looked, 200u);
  ASSERT_EQ(front.size(), 3u);
  // As far towards 0.8 as each level allows, and with the best of the four.
  EXPECT_NEAR(front[0].value.gain, 1.0 - 0.2 * 0.2, 0.005);
  EXPECT_NEAR(front[1].value.gain, 1.0 - 0.1 * 0.1, 0.005);
  EXPECT_NEAR(front[2].value.gain, 1.0, 0.001);
  for (std::size_t i = 1; i < front.size(); ++i)
    EXPECT_GT(front[i].value.change, front[i - 1].value.change);
}

TEST(TradeSearch, IsTheSameEachTimeAndLooksAtNoPlaceTwice) {
  std::size_t first = 0, second = 0;
  const auto a = search_trade(hill(90, &first)), b = search_trade(hill(90, &second));
  EXPECT_EQ(first, second);
  ASSERT_EQ(a.size(), b.size());
  std::size_t unknown = 0;
  const TradeSettings settings = hill(90, &unknown);
  std::set<std::string> keys;
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].at, b[i].at);
    EXPECT_TRUE(keys.insert(settings.key(a[i].at)).second) << i;
  }
}

TEST(TradeSearch, WhatLookingThrowsEndsIt) {
  std::size_t looked = 0;
  TradeSettings settings = hill(90, &looked);
  const auto look = settings.look;
  settings.look = [&](std::span<const double> at) {
    if (looked > 10) throw Interrupted(2);
    return look(at);
  };
  EXPECT_THROW(search_trade(settings), Interrupted);
}

TEST(TradeFront, LeavesOutWhatGainsTooLittleForItsChange) {
  const std::vector<TradePoint> points{
      {{0.0}, {1.0, 0.0}}, {{0.1}, {1.2, 4.0}}, {{0.2}, {1.203, 9.0}}, {{0.3}, {1.5, 50.0}}};
  const auto front = front_of(points, {0.0, 5.0, 10.0}, 0.01);
  ASSERT_EQ(front.size(), 3u);
  EXPECT_EQ(front[0].at, points[0].at);
  EXPECT_EQ(front[1].at, points[1].at);
  EXPECT_EQ(front[2].at, points[3].at);
}

TEST(RigFile, ReadsBackAsTheSameRig) {
  const TemporaryFolder folder;
  const auto file = folder / "rig.toml";
  for (const char* text : {"even:bones=7,weights=[[0, 0.7], [0.25, 1]],arms=top",
                           "isner:depth=[0.3, 0.512]", "stretchy:no_squash=true", "three_bone"}) {
    const solver::SystemSpec spec = read_rig(text).spec;
    std::ofstream(file) << rig_toml(spec, {"one line", "a line\nwith a break"});
    EXPECT_EQ(rig_text(read_rig(file.string()).spec), rig_text(spec));
  }
}

struct Scene : testing::FigureStage {
  RigGauge of(const char* rig, const char* given) const {
    return HeadroomGauge(stage, body, envelope, limits, solver::Mapping::chest,
                         read_rig(given).spec)
        .of(read_rig(rig).spec);
  }
  Envelope envelope = *find_envelope("human");
  LimitSet limits;
};

TEST(HeadroomGauge, TheGivenRigHasNoChangeAndTheKinkingOneLessHeadroom) {
  const Scene scene;
  // With arms on the top control, so that no drift of theirs ends the headroom first.
  const RigGauge given = scene.of("curve:arms=top", "curve:arms=top");
  EXPECT_EQ(given.change, 0.0);
  EXPECT_EQ(given.change_most, 0.0);
  // The rig of the thesis's figure 3.7 kinks (BB010).
  const RigGauge kinking = scene.of("curve:arms=top,length=rest", "curve:arms=top");
  EXPECT_LT(kinking.headroom, given.headroom);
  EXPECT_GT(kinking.change, 0.1);
  EXPECT_GE(kinking.change_most, kinking.change);
}

TEST(HeadroomGauge, ArmsOnTheTopControlDriftLessAtNoChangeOfTheCurve) {
  const Scene scene;
  const RigGauge effector = scene.of("curve", "curve"), top = scene.of("curve:arms=top", "curve");
  EXPECT_EQ(top.change, 0.0);
  EXPECT_GT(top.headroom, effector.headroom);
}

TEST(HeadroomGauge, SeesTheFlipOfTheIsnerSpineWhereItIs) {
  const Scene scene;
  // Its first flip in extension is at 100.9 degrees (specification 4.3): 1.68 of 60.
  const RigGauge gauge = scene.of("isner", "isner");
  EXPECT_LE(gauge.clean.front(), 100.91 / 60.0);
}

TEST(HeadroomGauge, DoesNotDependOnThreads) {
  const Scene scene;
  const RigGauge many = scene.of("curve:bones=6", "curve");
  const oneapi::tbb::global_control one(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  const RigGauge single = scene.of("curve:bones=6", "curve");
  EXPECT_EQ(many.clean, single.clean);
  EXPECT_EQ(many.change, single.change);
}

TEST(Directions, AreTheEndsOfTheEnvelopeAndItsCorners) {
  const auto directions = directions_of(*find_envelope("human"));
  EXPECT_EQ(directions.size(), 26u);  // extension, flexion, side and twist both ways, 20 corners
  EXPECT_EQ(directions.front().name, "extension 60");
}

}  // namespace
}  // namespace backbend::validate
