#include "validate/history/history.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "tests/temporary_folder.h"
#include "tests/validate/report_sample.h"
#include "validate/files/output_folder.h"
#include "validate/history/history_text.h"
#include "validate/history/steps.h"
#include "validate/history/trend.h"
#include "validate/text/escape.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;

/// Normal noise, the same on every machine (std::normal_distribution is not).
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : engine_(seed) {}
  double next() {
    const double radius = std::sqrt(-2 * std::log(uniform()));
    return radius * std::cos(6.283185307179586 * uniform());
  }

 private:
  double uniform() { return (static_cast<double>(engine_() >> 11) + 0.5) / 9007199254740992.0; }
  std::mt19937_64 engine_;
};

constexpr double kLeast = 1e-6;
constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

TEST(Steps, RaiseAtMostOneFalseAlarmPerMetricAndYearOfNoise) {
  Noise noise(1);
  constexpr int kYears = 400;
  std::size_t alarms = 0;
  for (int year = 0; year < kYears; ++year) {
    std::vector<double> nights(365);
    for (double& value : nights) value = 3.0 + 0.2 * noise.next();
    alarms += find_steps(nights, kLeast).size();
  }
  EXPECT_LE(alarms, static_cast<std::size_t>(kYears));
  // Noise must be looked at at all: a detector that is deaf would pass the line above.
  EXPECT_GT(alarms, static_cast<std::size_t>(kYears) / 4);
}

TEST(Steps, FindATwoSigmaStepWithinFiveNightsInFiveCasesOfSix) {
  Noise noise(2);
  constexpr int kCases = 2000, kSettled = 120;
  int found = 0;
  for (int i = 0; i < kCases; ++i) {
    const double sign = i % 2 == 0 ? 1 : -1;
    std::vector<double> nights;
    for (int n = 0; n < kSettled + 5; ++n)
      nights.push_back(0.2 * (noise.next() + (n < kSettled ? 0 : sign * 2)));
    for (const Step& step : find_steps(nights, kLeast))
      if (step.known >= kSettled && (step.after > step.before) == (sign > 0)) {
        ++found;
        break;
      }
  }
  EXPECT_GE(found, kCases * 5 / 6);
}

TEST(Steps, FindWhatMovesOnANightWithoutNoiseAtOnceAndSayByHowMuch) {
  std::vector<double> nights(20, 4.0);
  nights.insert(nights.end(), 3, 4.5);
  const auto steps = find_steps(nights, 0.01);
  ASSERT_EQ(steps.size(), 1u);
  EXPECT_EQ(steps[0].at, 20u);
  EXPECT_EQ(steps[0].known, 20u);
  EXPECT_EQ(steps[0].before, 4.0);
  EXPECT_EQ(steps[0].after, 4.5);
  nights.back() = 4.505;  // less than what matters
  EXPECT_EQ(find_steps(nights, 0.01).size(), 1u);
}

TEST(Steps, TakeOneOutlierForNoStep) {
  Noise noise(3);
  std::vector<double> nights(60);
  for (double& value : nights) value = std::clamp(noise.next(), -1.0, 1.0);
  nights[40] = 30;
  EXPECT_TRUE(find_steps(nights, kLeast).empty());
}

TEST(Steps, DoNotMindNightsWithoutAMeasurement) {
  std::vector<double> nights(30, 1.0);
  for (std::size_t i = 15; i < 30; ++i) nights[i] = 2.0;
  nights[3] = nights[15] = kNotMeasured;
  const auto steps = find_steps(nights, 0.1);
  ASSERT_EQ(steps.size(), 1u);
  EXPECT_EQ(steps[0].at, 16u);
  EXPECT_TRUE(find_steps(std::vector<double>(10, kNotMeasured), 0.1).empty());
  EXPECT_TRUE(find_steps({}, 0.1).empty());
}

Night night_with(const std::string& date, double kink, bool fails) {
  Night night;
  night.date = date;
  night.label = "v" + date.substr(8);
  night.suite = "nightly";
  night.report = "r" + date;
  night.version = {{"hero", "h" + date}};
  night.values = {{"hero", "curve", "chest", "chain_kink", "deg", true, kink}};
  if (fails) night.failures = {{"hero", "curve", "chest", "BB010", "extension 58", kink}};
  return night;
}

/// Kink of 2, then 6 from the 11th to the 14th, then 2 again; it fails while it is 6.
std::vector<Night> month() {
  std::vector<Night> nights;
  for (int day = 1; day <= 20; ++day) {
    const bool bad = day >= 11 && day <= 14;
    nights.push_back(night_with("2026-11-" + std::string(day < 10 ? "0" : "") + std::to_string(day),
                                bad ? 6.0 : 2.0, bad));
  }
  return nights;
}

TEST(Trend, KeepsARecoveredRegressionListedWithTheNightsThatMadeAndEndedIt) {
  const TrendTable table = trends_of(month(), "nightly");
  ASSERT_EQ(table.trends.size(), 1u);
  const auto& steps = table.trends[0].steps;
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_TRUE(steps[0].worse);
  EXPECT_EQ(steps[0].version, "2026-11-11 v11");
  EXPECT_EQ(steps[0].last_before, "2026-11-10 v10");
  EXPECT_EQ(steps[0].recovered, "2026-11-15 v15");
  EXPECT_FALSE(steps[1].worse);
  EXPECT_TRUE(trends_of(month(), "other").trends.empty());
}

TEST(Trend, PutsRegressionsThatStandBeforeEverythingElse) {
  auto nights = month();
  for (std::size_t n = 0; n < nights.size(); ++n)
    nights[n].values.push_back(
        {"hero", "curve", "chest", "headroom twist", "deg", false, n < 18 ? 30.0 : 12.0});
  const TrendTable table = trends_of(nights, "nightly");
  EXPECT_EQ(table.trends[0].metric, "headroom twist");
  EXPECT_TRUE(table.trends[0].steps[0].worse);
  EXPECT_EQ(table.trends[0].steps[0].recovered, "");
}

TEST(Trend, NamesTheVersionWhereACheckBeganToFail) {
  const auto nights = month();
  const auto onset = first_bad(nights, "hero", "BB010");
  ASSERT_TRUE(onset);
  EXPECT_EQ(onset->first_bad->date, "2026-11-11");
  EXPECT_EQ(onset->last_good->date, "2026-11-10");
  EXPECT_EQ(onset->recovered->date, "2026-11-15");
  EXPECT_EQ(onset->bad_nights, 4u);
  EXPECT_FALSE(first_bad(nights, "hero", "BB001"));
  EXPECT_FALSE(first_bad(nights, "villain", "BB010"));
  const std::string text = onset_text("hero", "BB010", *onset, {});
  for (const char* word : {"2026-11-11 v11", "h2026-11-11", "2026-11-10 v10", "2026-11-15 v15"})
    EXPECT_NE(text.find(word), std::string::npos) << word << "\n" << text;
}

TEST(Trend, SaysNothingOfNightsThatDidNotLookAtTheCharacter) {
  auto nights = month();
  nights[12].version = {{"villain", "x"}};
  nights[12].failures.clear();
  EXPECT_EQ(first_bad(nights, "hero", "BB010")->first_bad->date, "2026-11-11");
}

TEST(History, SaysWhatIsNewSinceTheNightBefore) {
  const Night clean = night_with("2026-11-01", 2, false), bad = night_with("2026-11-02", 6, true);
  Night worse = bad;
  worse.date = "2026-11-03";
  worse.failures.push_back({"hero", "curve", "chest", "BB030", "twist 60", 0.6});
  worse.failures.push_back({"hero", "curve", "chest", "BB030", "twist 62", 0.6});
  EXPECT_EQ(news_of({clean}), "");
  EXPECT_EQ(news_of({clean, clean}), "");
  EXPECT_EQ(news_of({clean, bad}), "1 of 1 failing check is new since 2026-11-01 (v01)");
  EXPECT_EQ(news_of({bad, worse}), "1 of 2 failing checks are new since 2026-11-02 (v02)");
  EXPECT_EQ(news_of({worse, bad}),
            "0 of 1 failing check is new since 2026-11-03 (v02), 1 has gone");
  EXPECT_EQ(news_of({worse, clean}), "nothing fails any more, 2 have gone since 2026-11-03 (v02)");
  // Nights of another suite are none of its own.
  Night other = worse;
  other.suite = "weekly";
  EXPECT_EQ(news_of({bad, other, worse}), news_of({bad, worse}));
}

TEST(History, ReadsBackWhatItWrote) {
  const Night night = night_of(sample_report(), "2026-11-22", "v013");
  EXPECT_FALSE(night.values.empty());
  EXPECT_FALSE(night.failures.empty());
  const auto back = parse_history(night_json(night) + "\n", "h");
  ASSERT_EQ(back.size(), 1u);
  EXPECT_EQ(night_json(back[0]), night_json(night));
}

TEST(History, ReadsTheLinesOfItsFirstVersion) {
  const std::string line =
      R"({"date":"2026-11-22","failures":[],"label":"","report":"r","schema":"backbend.night/1",)"
      R"("suite":"s","values":[{"character":"hero","mapping":"chest","metric":"gain",)"
      R"("more_is_worse":true,"rig":"even","unit":"deg/deg","value":1.5},{"character":"hero",)"
      R"("mapping":"chest","metric":"headroom side","more_is_worse":false,"rig":"even",)"
      R"("unit":"deg","value":null}],"verdict":"pass","version":{"hero":"h"}})";
  const auto old = parse_history(line + "\n", "h");
  ASSERT_EQ(old.size(), 1u);
  ASSERT_EQ(old[0].values.size(), 2u);
  EXPECT_EQ(old[0].values[0].value, 1.5);
  EXPECT_EQ(old[0].values[1].metric, "headroom side");
  EXPECT_TRUE(std::isnan(old[0].values[1].value));
  const auto same = parse_history(night_json(old[0]) + "\n", "h");
  EXPECT_EQ(night_json(same[0]), night_json(old[0]));
}

TEST(History, SaysTheNameOfAMetricOnce) {
  Night night = night_of(sample_report(), "2026-11-22", "");
  const std::size_t alone = night_json(night).size();
  const std::vector<NightValue> values = night.values;
  for (NightValue value : values) {
    value.character = "another";
    night.values.push_back(value);
  }
  EXPECT_LT(night_json(night).size() - alone, 40 * values.size());
}

TEST(History, RefusesAMetricThatIsNotThereOrHasNoValue) {
  const std::string good = night_json(night_of(sample_report(), "2026-11-22", ""));
  const std::size_t at = good.find(",[0,") + 2;
  ASSERT_GT(at, 2U);
  for (const std::string& bad : {good.substr(0, at) + "99999" + good.substr(at + 1),
                                 good.substr(0, at) + good.substr(at + 2)})
    EXPECT_THROW(parse_history(bad + "\n", "h"), HistoryError) << bad;
}

TEST(History, HoldsNothingOfCanariesAndNoFailureOfAReference) {
  Report report = sample_report();
  report.rigs[0].role = Role::canary;
  const Night night = night_of(report, "2026-11-22", "");
  for (const NightFailure& f : night.failures) EXPECT_NE(f.rig, "isner");
  for (const NightValue& v : night.values)
    EXPECT_FALSE(v.rig == "curve" && v.mapping == "chest") << v.metric;
}

TEST(History, GrowsOnlyAtItsEndAndTakesTheSameRunOnce) {
  const TemporaryFolder folder;
  const fs::path file = folder / "runs" / "history.jsonl";
  const auto nights = month();
  EXPECT_TRUE(append_night(file, nights[0]));
  const std::string first = read_text(file);
  EXPECT_FALSE(append_night(file, nights[0]));
  EXPECT_TRUE(append_night(file, nights[1]));
  EXPECT_EQ(read_text(file).substr(0, first.size()), first);
  EXPECT_EQ(parse_history(read_text(file), "h").size(), 2u);
}

TEST(History, NamesTheDamagedLineAndTouchesNothing) {
  const TemporaryFolder folder;
  const fs::path file = folder / "history.jsonl";
  for (const std::string& damage :
       {std::string("{\n"), std::string("{}\n"), std::string("nonsense\n"),
        std::string("{\"schema\""), night_json(month()[0]).substr(0, 200),
        std::string(60, '[') + "\n"}) {
    const std::string text = night_json(month()[0]) + "\n" + damage;
    std::ofstream(file, std::ios::binary) << text;
    for (const bool append : {false, true}) {
      try {
        append ? static_cast<void>(append_night(file, month()[1]))
               : static_cast<void>(parse_history(read_text(file), file.string()));
        ADD_FAILURE() << damage;
      } catch (const HistoryError& error) {
        EXPECT_NE(std::string(error.what()).find("history.jsonl:2: "), std::string::npos)
            << error.what();
      }
    }
    EXPECT_EQ(read_text(file), text);
  }
}

TEST(History, TextFitsTheWidthAndLetsNoNameAct) {
  for (const std::string& name : hostile_names()) {
    auto nights = month();
    for (Night& night : nights) {
      night.label = night.values[0].character = night.values[0].rig = night.values[0].metric = name;
      night.values[0].mapping = night.values[0].unit = name;
      const Night back = parse_history(night_json(night) + "\n", "h").front();
      EXPECT_EQ(back.label, valid_utf8(name));
    }
    auto several = nights;
    for (Night& night : several)
      night.values.push_back({name + "2", name, name, name, name, true, 1.0});
    for (const auto& history : {nights, several}) {
      TerminalStyle style;
      style.width = 60;
      const std::string text = history_text(trends_of(history, "nightly"), style);
      std::string line;
      for (const char c : text) {
        if (c != '\n') {
          line += c;
          continue;
        }
        EXPECT_EQ(visible(line), line);
        EXPECT_LE(display_width(line), 60u) << line;
        line.clear();
      }
    }
  }
}

TEST(History, DrawsASparklineThatRisesWithItsValues) {
  EXPECT_EQ(sparkline({0, 1, 2, 3, 4}, 10, false), "_.-'^");
  EXPECT_EQ(sparkline({0, kNotMeasured, 4}, 10, false), "_ ^");
  EXPECT_EQ(sparkline({9, 9, 0, 4}, 2, false), "_^");
  EXPECT_EQ(sparkline({0, 7}, 2, true), "\xe2\x96\x81\xe2\x96\x88");
}

}  // namespace
}  // namespace backbend::validate
