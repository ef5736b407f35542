#include "validate/carry/carry_over.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "tests/temporary_folder.h"
#include "tests/validate/report_sample.h"
#include "validate/files/hash.h"
#include "validate/files/output_folder.h"
#include "validate/model/report_json.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;

/// A night in runs/monday with one finding's picture, and what it left.
class Carrying : public testing::Test {
 protected:
  void SetUp() override {
    report_ = sample_report();
    const std::string text = report_json(report_);
    hash_ = content_hash(text);
    OutputFolder(folder_ / "monday").write("report.json", text);
    OutputFolder(folder_ / "monday").write("findings/a/before.png", std::string_view("picture"));
    part_.characters = report_.characters;
    part_.rigs = report_.rigs;
    part_.findings = report_.findings;
    part_.calibration = report_.calibration;
    keep(part_);
  }

  CarryOver store(const std::string& today) const {
    CarryOver::Place place;
    place.history = folder_ / "history.jsonl";
    place.results = {{hash_, results_}};
    place.today = today;
    return CarryOver(place);
  }
  /// As Monday did, whose results the history then has.
  void keep(const Report& part) {
    CarryOver carry = store("2026-11-22");
    carry.note("hero", "inputs", {part, carry.tonight(), {{"findings/a/before.png", ""}}});
    results_ = carry.results_hash();
    carry.keep(folder_ / "monday", hash_);
  }
  /// Changes what is kept, and gives it the hash that it should have, as whoever knows the format
  /// can.
  void forge(const std::function<void(nlohmann::json&)>& change) const {
    for (const auto& file : fs::directory_iterator(folder_ / "carried")) {
      const std::string text = read_text(file.path());
      const std::size_t head = text.find('\n') + 1, body = text.find('\n', head) + 1;
      nlohmann::json entry = nlohmann::json::parse(text.substr(body));
      change(entry);
      const std::string forged = entry.dump() + "\n";
      std::ofstream(file.path()) << text.substr(0, head) << content_hash(forged) << "\n" << forged;
    }
  }
  std::optional<CarryOver::Result> find(const std::string& stamp = "inputs", int most_days = 0,
                                        const std::string& today = "2026-11-23") {
    complaint_.clear();
    return store(today).find(
        "hero", stamp, folder_ / "tuesday", most_days, [](const Report&) { return true; },
        [&](const std::string& why) { complaint_ = why; });
  }

  const TemporaryFolder folder_;
  Report report_, part_;
  std::string hash_, results_, complaint_;
};

TEST_F(Carrying, GivesTheResultWithItsNightAndItsFiles) {
  const auto found = find();
  ASSERT_TRUE(found) << complaint_;
  EXPECT_EQ(report_json(found->report), report_json(part_));
  EXPECT_EQ(found->night, "2026-11-22");
  EXPECT_EQ(read_text(folder_ / "tuesday/findings/a/before.png"), "picture");
}

TEST_F(Carrying, OtherInputsAreNoComplaint) {
  EXPECT_FALSE(find("others"));
  EXPECT_EQ(complaint_, "");
}

TEST_F(Carrying, WhatIsTooOldDoesNotCount) {
  EXPECT_TRUE(find("inputs", 5, "2026-11-27"));
  EXPECT_FALSE(find("inputs", 5, "2026-11-28"));
  EXPECT_FALSE(find("inputs", 5, "2026-11-21"));  // a clock that was put back
  EXPECT_EQ(complaint_, "");
}

TEST_F(Carrying, AForgedResultIsNotBelieved) {
  Report better = part_;
  better.findings.pop_back();
  const std::string text = report_json_compact(better);
  forge([&](auto& entry) { entry["report"] = text; });
  EXPECT_FALSE(find());
  EXPECT_NE(complaint_.find("is not what its night found"), std::string::npos) << complaint_;
  // With the night's list of results forged to fit: the history has another.
  forge([&](auto& entry) {
    auto results = nlohmann::json::parse(entry["results"].template get<std::string>());
    results["hero"] = content_hash(text);
    entry["results"] = results.dump();
  });
  EXPECT_FALSE(find());
  EXPECT_NE(complaint_.find("is of no night of"), std::string::npos) << complaint_;
  keep(part_);
  forge([](auto&) {});
  EXPECT_TRUE(find()) << complaint_;
}

TEST_F(Carrying, AResultOfANightThatKeptNoneIsNotBelieved) {
  results_.clear();  // as an older program's line
  EXPECT_FALSE(find());
  EXPECT_NE(complaint_.find("is of no night of"), std::string::npos) << complaint_;
}

TEST_F(Carrying, IsTheSameWhetherItWasReadAheadOrNot) {
  CarryOver ahead = store("2026-11-23");
  ahead.read_ahead({{"hero", "inputs"}, {"hero", "others"}, {"nobody", "inputs"}});
  const auto take = [&](const std::string& unit, const std::string& stamp) {
    return ahead.find(
        unit, stamp, folder_ / "tuesday", 0, [](const Report&) { return true; },
        [&](const std::string& why) { complaint_ = why; });
  };
  EXPECT_FALSE(take("nobody", "inputs"));
  EXPECT_FALSE(take("hero", "others"));
  const auto found = take("hero", "inputs");
  ASSERT_TRUE(found) << complaint_;
  EXPECT_EQ(report_json(found->report), report_json(part_));
  // Noted again it is the same result.
  const std::string before = results_;
  ahead.note("hero", "inputs", *found);
  EXPECT_EQ(ahead.results_hash(), before);
}

TEST_F(Carrying, AReportThatIsNotTheHistorysIsNotBelieved) {
  Report better = report_;
  better.findings.clear();
  OutputFolder(folder_ / "monday").write("report.json", report_json(better));
  EXPECT_FALSE(find());
  EXPECT_NE(complaint_, "");
  hash_ = content_hash(report_json(better));  // the entry is of another report
  EXPECT_FALSE(find());
  EXPECT_NE(complaint_, "");
}

TEST_F(Carrying, AFileThatChangedOrLeadsElsewhereIsNotTaken) {
  std::ofstream(folder_ / "monday/findings/a/before.png") << "another";
  EXPECT_FALSE(find());
  EXPECT_FALSE(fs::exists(folder_ / "tuesday"));  // nothing is placed of what does not hold
  CarryOver carry = store("2026-11-22");
  std::ofstream(folder_ / "outside.png") << "picture";
  carry.note("hero", "inputs", {part_, "2026-11-22", {{"../outside.png", ""}}});
  carry.keep(folder_ / "monday", hash_);
  EXPECT_FALSE(find());
  EXPECT_NE(complaint_.find("outside of its run"), std::string::npos);
}

TEST_F(Carrying, AFileInThePlaceOfOneThatIsCarriedIsReplaced) {
  OutputFolder(folder_ / "tuesday").write("findings/a/before.png", std::string_view("old"));
  EXPECT_TRUE(find());
  EXPECT_EQ(read_text(folder_ / "tuesday/findings/a/before.png"), "picture");
  EXPECT_TRUE(find());  // and again
  EXPECT_EQ(read_text(folder_ / "monday/findings/a/before.png"), "picture");
}

TEST_F(Carrying, ALinkInTheFolderIsNotFollowed) {
  fs::create_directories(folder_ / "tuesday");
  fs::create_directories(folder_ / "elsewhere");
  fs::create_directory_symlink(folder_ / "elsewhere", folder_ / "tuesday/findings");
  EXPECT_ANY_THROW(find());
  EXPECT_TRUE(fs::is_empty(folder_ / "elsewhere"));
}

TEST(FilesMade, AreThoseThatAreNewOrTookAnothersPlace) {
  const TemporaryFolder temporary;
  const fs::path folder = temporary / "run";
  const OutputFolder run(folder);
  for (const char* name : {"findings/a.png", "findings/b.png", "report.json"})
    run.write(name, std::string_view("x"));
  const FolderListing before = list_results(folder);
  run.write("findings/b.png", std::string_view("x"));
  run.write("media/c.mp4", std::string_view("x"));
  run.write("report.json", std::string_view("y"));
  const std::map<std::string, std::string> expected = {{"findings/b.png", ""}, {"media/c.mp4", ""}};
  EXPECT_EQ(files_made(before, list_results(folder)), expected);
}

TEST(NightInputs, AreTheSuiteWithoutCharactersTitleWaiversAndFaults) {
  const TemporaryFolder folder;
  const fs::path file = folder / "suite.toml";
  const auto inputs = [&](const std::string& top, const std::string& rest,
                          const std::vector<std::string>& options = {}) {
    std::ofstream(file) << "[suite]\nname = \"a\"\n"
                        << top << "[[rig]]\nname = \"even\"\nsolver = { system = \"even\" }\n"
                        << rest;
    return night_inputs(read_suite(file), options);
  };
  const std::string one = "characters = [\"one.glb\"]\n";
  const std::string base = inputs(one, "");
  EXPECT_EQ(inputs(one, ""), base);
  EXPECT_EQ(inputs("characters = [\"two.glb\", \"one.glb\"]\ntitle = \"T\"\n", ""), base);
  EXPECT_EQ(inputs(one, "[calibration]\nposes = 3\n# a comment\n"), base);
  EXPECT_NE(inputs(one + "corners = true\n", ""), base);
  EXPECT_NE(inputs(one, "[[sweep]]\nchannel = \"extension\"\nto = 60\n"), base);
  EXPECT_NE(inputs(one, "[pictures]\nsamples = 3\n"), base);
  EXPECT_NE(inputs(one, "", {"--spp=3"}), base);
  fs::remove(file);
}

}  // namespace
}  // namespace backbend::validate
