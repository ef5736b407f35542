#include "validate/history/history_index.h"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <filesystem>
#include <fstream>
#include <limits>

#include "tests/temporary_folder.h"
#include "validate/files/output_folder.h"
#include "validate/history/trend.h"
#include "validate/text/escape.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;

/// Nights of two suites in turn, with a check that fails on hero from the 11th to the 14th.
Night night_number(int day) {
  const bool bad = day >= 11 && day <= 14;
  Night night;
  night.date = "2026-11-" + std::string(day < 10 ? "0" : "") + std::to_string(day);
  night.label = "v" + std::to_string(day);
  night.suite = day % 5 == 0 ? "weekly" : "nightly";
  night.report = "r" + std::to_string(day);
  if (day > 2) night.results = "s" + std::to_string(day);  // an older program kept none
  night.verdict = bad ? Verdict::fail : Verdict::pass;
  night.version = {{"hero", "h" + std::to_string(day)}};
  if (day % 2 == 0) night.version["villain"] = "w";
  night.values = {{"hero", "curve", "chest", "chain_kink", "deg", true, bad ? 6.0 : 2.0},
                  {"hero", "even", "chest", "headroom twist", "deg", false,
                   day == 3 ? std::numeric_limits<double>::quiet_NaN() : 30.0}};
  if (bad)
    night.failures = {{"hero", "curve", "chest", "BB010", "extension 58", 6.0},
                      {"hero", "curve", "chest", "BB020", "extension 60", 1.0},
                      {"villain", "curve", "chest", "BB010", "extension 62", 9.0}};
  return night;
}

class Index : public testing::Test {
 protected:
  void SetUp() override {
    for (int day = 1; day <= 20; ++day) text_ += night_json(night_number(day)) + "\n";
    write(text_);
  }
  void write(const std::string& text) const { std::ofstream(file_, std::ios::binary) << text; }
  fs::path index() const { return HistoryIndex::path_for(file_); }

  static std::string file_of(const Night* night) {
    return night == nullptr ? "none" : night->version.at("hero");
  }

  /// The index says what the lines say.
  void expect_true(const HistoryIndex& found) const {
    const std::vector<Night> all = parse_history(read_text(file_), "h");
    EXPECT_EQ(found.night_count(), all.size());
    EXPECT_EQ(found.last_suite(), all.empty() ? "" : all.back().suite);
    std::vector<Night> nightly;
    for (const Night& night : all)
      if (night.suite == "nightly") nightly.push_back(night);
    const std::vector<Night> shown = found.last_nights("nightly", 1000, {});
    ASSERT_EQ(shown.size(), nightly.size());
    for (std::size_t i = 0; i < shown.size(); ++i)
      EXPECT_EQ(night_json(shown[i]), night_json(nightly[i]));
    const auto want = first_bad(all, "hero", "BB010");
    const std::vector<Night> of_hero = found.nights_of("hero", "BB010");
    const auto got = first_bad(of_hero, "hero", "BB010");
    ASSERT_EQ(want.has_value(), got.has_value());
    if (!want) return;
    EXPECT_EQ(got->first_bad->date, want->first_bad->date);
    EXPECT_EQ(file_of(got->last_good), file_of(want->last_good));
    EXPECT_EQ(file_of(got->recovered), file_of(want->recovered));
    EXPECT_EQ(got->bad_nights, want->bad_nights);
    EXPECT_EQ(got->worst.pose, want->worst.pose);
  }

  const TemporaryFolder folder_;
  const fs::path file_ = folder_ / "history.jsonl";
  std::string text_;
};

TEST_F(Index, SaysWhatTheLinesSayAndReadsNoneOfThemTwice) {
  {
    const HistoryIndex first(file_);
    EXPECT_EQ(first.lines_read(), 20u);
    expect_true(first);
  }
  EXPECT_TRUE(fs::is_regular_file(index()));
  const HistoryIndex second(file_);
  EXPECT_EQ(second.lines_read(), 0u);
  expect_true(second);
}

TEST_F(Index, KnowsTheResultsOfEachNightsReport) {
  Night again =
      night_number(3);  // its report once more, added by hand: that says nothing of results
  again.results.clear();
  again.date = "2026-11-21";
  EXPECT_TRUE(append_night(file_, again));
  const std::map<std::string, std::string> results = HistoryIndex(file_).results();
  EXPECT_EQ(results.size(), 18u);
  for (int day = 3; day <= 20; ++day)
    EXPECT_EQ(results.at("r" + std::to_string(day)), "s" + std::to_string(day));
}

TEST_F(Index, GrowsByTheNightsThatAreNew) {
  { const HistoryIndex first(file_); }
  EXPECT_TRUE(append_night(file_, night_number(21)));
  const HistoryIndex grown(file_);
  EXPECT_EQ(grown.lines_read(), 1u);
  expect_true(grown);
}

TEST_F(Index, GivesOnlyWhatIsAskedFor) {
  const HistoryIndex history(file_);
  EXPECT_EQ(history.characters(), (std::vector<std::string>{"hero", "villain"}));
  const auto nights = history.last_nights("nightly", 3, {"hero", "", "chain_kink"});
  ASSERT_EQ(nights.size(), 3u);
  EXPECT_EQ(nights.front().label, "v17");
  EXPECT_EQ(nights.back().label, "v19");
  for (const Night& night : nights) {
    ASSERT_EQ(night.values.size(), 1u);
    EXPECT_EQ(night.values[0].metric, "chain_kink");
  }
  EXPECT_TRUE(history.last_nights("other", 3, {}).empty());
  EXPECT_EQ(history.nights_of("villain", "BB010").size(), 10u);
}

TEST_F(Index, IsMadeAnewWhereItIsDamagedStaleOrOfAnotherVersion) {
  { const HistoryIndex first(file_); }
  const std::string whole = read_text(index());
  const std::vector<std::string> damages{
      "", "no database", whole.substr(0, whole.size() / 2), std::string(whole.size(), 'x'),
      whole.substr(0, 4096) + std::string(whole.size() - 4096, '\xff')};
  for (const std::string& damage : damages) {
    std::ofstream(index(), std::ios::binary) << damage;
    const HistoryIndex found(file_);
    EXPECT_EQ(found.lines_read(), 20u) << damage.size();
    expect_true(found);
  }
  // Other lines than it was made from: as long, and shorter.
  std::string other = text_;
  other.replace(other.find("\"v3\""), 4, "\"w3\"");
  for (const std::string& text : {other, text_.substr(0, text_.find('\n') + 1)}) {
    write(text);
    const HistoryIndex found(file_);
    EXPECT_GT(found.lines_read(), 0u);
    expect_true(found);
  }
  write(text_);
  { const HistoryIndex again(file_); }
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(index().c_str(), &database), SQLITE_OK);
  sqlite3_exec(database, "PRAGMA user_version = 999", nullptr, nullptr, nullptr);
  sqlite3_close(database);
  const HistoryIndex found(file_);
  EXPECT_EQ(found.lines_read(), 20u);
  expect_true(found);
}

TEST_F(Index, NamesADamagedLineWithItsPlaceInTheWholeFile) {
  { const HistoryIndex first(file_); }
  write(text_ + "nonsense\n");
  for (int again = 0; again < 2; ++again) {
    try {
      const HistoryIndex found(file_);
      ADD_FAILURE();
    } catch (const HistoryError& error) {
      EXPECT_NE(std::string(error.what()).find("history.jsonl:21: "), std::string::npos)
          << error.what();
    }
  }
  write(text_);
  const HistoryIndex found(file_);
  expect_true(found);
}

TEST_F(Index, LivesInMemoryWhereItCannotBeKept) {
  fs::create_directories(index());
  {
    const HistoryIndex found(file_);
    expect_true(found);
  }
  EXPECT_TRUE(fs::is_directory(index()));
  fs::remove(index());
  { const HistoryIndex first(file_); }
  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open(index().c_str(), &other), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(other, "BEGIN EXCLUSIVE", nullptr, nullptr, nullptr), SQLITE_OK);
  {
    const HistoryIndex found(file_);  // waits its two seconds, and does without
    expect_true(found);
  }
  sqlite3_exec(other, "COMMIT", nullptr, nullptr, nullptr);
  sqlite3_close(other);
  EXPECT_EQ(HistoryIndex(file_).lines_read(), 0u);
}

TEST_F(Index, ReplacesALinkPlantedUnderItsNameAndMakesNothingForNoHistory) {
  std::ofstream(folder_ / "mine.txt") << "mine";
  fs::create_symlink(folder_ / "mine.txt", index());
  const HistoryIndex found(file_);
  expect_true(found);
  EXPECT_EQ(read_text(folder_ / "mine.txt"), "mine");
  EXPECT_FALSE(fs::is_symlink(index()));
  const HistoryIndex none(folder_ / "gone.jsonl");
  EXPECT_EQ(none.night_count(), 0u);
  EXPECT_FALSE(fs::exists(folder_ / "gone.jsonl.index"));
}

TEST_F(Index, LetsNoNameActAndKeepsEachAsItWas) {
  text_.clear();
  const std::string name = "x'); DROP TABLE night; --";
  for (const std::string& each : {name, std::string("nul\0byte", 8),
                                  std::string("\xf0\x9f\xa6\x92"), std::string("\"`[]%_")}) {
    Night night = night_number(12);
    night.suite = "nightly";
    night.label = night.values[0].character = night.failures[0].pose = each;
    night.version[each] = each;
    text_ += night_json(night) + "\n";
  }
  write(text_);
  const HistoryIndex found(file_);
  expect_true(found);
  EXPECT_EQ(found.nights_of(name, "BB010").size(), 1u);
}

}  // namespace
}  // namespace backbend::validate
