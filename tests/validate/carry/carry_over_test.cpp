#include "validate/carry/carry_over.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

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
    folder_ =
        fs::temp_directory_path() / ("backbend_carry_" + std::to_string(::getpid()) + "_" +
                                     testing::UnitTest::GetInstance()->current_test_info()->name());
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
  void TearDown() override { fs::remove_all(folder_); }

  CarryOver store(const std::string& today) const {
    CarryOver::Place place;
    place.history = folder_ / "history.jsonl";
    place.reports = {hash_};
    place.today = today;
    return CarryOver(place);
  }
  void keep(const Report& part) const {
    CarryOver carry = store("2026-11-22");
    carry.note("hero", "inputs", {part, carry.tonight(), {{"findings/a/before.png", ""}}});
    carry.keep(folder_ / "monday", hash_);
  }
  std::optional<CarryOver::Result> find(const std::string& stamp = "inputs", int most_days = 0,
                                        const std::string& today = "2026-11-23") {
    complaint_.clear();
    return store(today).find(
        "hero", stamp, folder_ / "tuesday", most_days, [](const Report&) { return true; },
        [&](const std::string& why) { complaint_ = why; });
  }

  fs::path folder_;
  Report report_, part_;
  std::string hash_, complaint_;
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

// Its hash is right, as whoever knows the format can make it: the night's own report decides.
TEST_F(Carrying, AForgedResultIsNotBelieved) {
  Report better = part_;
  better.findings.pop_back();
  keep(better);
  EXPECT_FALSE(find());
  EXPECT_NE(complaint_.find("does not say what the report of its night says"), std::string::npos);
  better = part_;
  better.findings.front().value *= 0.5;
  keep(better);
  EXPECT_FALSE(find());
  better = part_;
  better.rigs.front().headroom.front().clean_to_deg += 10;
  keep(better);
  EXPECT_FALSE(find());
  keep(part_);
  EXPECT_TRUE(find());
}

TEST_F(Carrying, AReportThatIsNotTheHistorysIsNotBelieved) {
  Report better = report_;
  better.findings.clear();
  OutputFolder(folder_ / "monday").write("report.json", report_json(better));
  EXPECT_FALSE(find());
  EXPECT_NE(complaint_, "");
  hash_ = content_hash(report_json(better));  // in a history that has it, the entry does not fit
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
  const fs::path folder =
      fs::temp_directory_path() / ("backbend_made_" + std::to_string(::getpid()));
  const OutputFolder run(folder);
  for (const char* name : {"findings/a.png", "findings/b.png", "report.json"})
    run.write(name, std::string_view("x"));
  const FolderListing before = list_results(folder);
  run.write("findings/b.png", std::string_view("x"));
  run.write("media/c.mp4", std::string_view("x"));
  run.write("report.json", std::string_view("y"));
  const std::map<std::string, std::string> expected = {{"findings/b.png", ""}, {"media/c.mp4", ""}};
  EXPECT_EQ(files_made(before, list_results(folder)), expected);
  fs::remove_all(folder);
}

TEST(NightInputs, AreTheSuiteWithoutCharactersTitleWaiversAndFaults) {
  const fs::path file =
      fs::temp_directory_path() / ("backbend_inputs_" + std::to_string(::getpid()) + ".toml");
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
