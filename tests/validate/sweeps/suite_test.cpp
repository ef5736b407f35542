#include "validate/sweeps/suite.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/temporary_folder.h"
#include "validate/files/output_folder.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;

class SuiteFile : public testing::Test {
 protected:
  fs::path write(const std::string& text) const {
    const fs::path file = folder_ / "suite.toml";
    std::ofstream(file) << text;
    return file;
  }

  std::string error_of(const std::string& text) const {
    try {
      read_suite(write(text));
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }

  const TemporaryFolder folder_;
};

constexpr const char* kSmall = R"([suite]
characters = ["human.toml"]
mappings = ["spread"]
envelope = "cartoon"

[[rig]]
name = "proposed"
solver = { system = "curve", length = "rest", bones = 12 }

[[sweep]]
channel = "side"
from = -30
to = 30
step = 5
with = { twist = 0.5 }
)";

TEST_F(SuiteFile, IsReadWithEverythingItSays) {
  const Suite suite = read_suite(write(kSmall));
  EXPECT_EQ(suite.name, "suite");
  EXPECT_EQ(suite.characters.front(), folder_ / "human.toml");
  EXPECT_EQ(suite.mappings.front(), solver::Mapping::spread);
  EXPECT_EQ(suite.envelope.name, "cartoon");
  EXPECT_EQ(std::get<std::string>(suite.rigs.front().spec.options.at("length")), "rest");
  EXPECT_EQ(std::get<double>(suite.rigs.front().spec.options.at("bones")), 12.0);
  EXPECT_EQ(suite.sweeps.front().pose_count(), 13u);
  EXPECT_EQ(suite.sweeps.front().pose_at(20).twist, 10.0);
}

TEST_F(SuiteFile, SaysHowMuchIsSearchedBetweenItsSweeps) {
  EXPECT_GT(read_suite(write(kSmall)).hunt.percent, 0.0);
  const HuntPlan plan =
      read_suite(write(std::string(kSmall) + "[hunt]\npercent = 12.5\nseed = 7\n")).hunt;
  EXPECT_EQ(plan.percent, 12.5);
  EXPECT_EQ(plan.seed, 7);
  EXPECT_EQ(read_suite(write(std::string(kSmall) + "[hunt]\npercent = 0\n")).hunt.percent, 0.0);
  const std::string below = error_of(std::string(kSmall) + "[hunt]\npercent = -1\n");
  EXPECT_NE(below.find("suite.toml:17"), std::string::npos) << below;
  EXPECT_NE(error_of(std::string(kSmall) + "[hunt]\npercents = 5\n").find("percent"),
            std::string::npos);
}

TEST_F(SuiteFile, TakesASweepThroughNamedPoses) {
  const std::string path =
      "[[sweep]]\nname = \"dance\"\nstep = 5\n"
      "path = [\"rest\", \"extension=60, side=20\", \"twist=-45\"]\n";
  const Suite suite = read_suite(write(kSmall + path));
  ASSERT_EQ(suite.sweeps.size(), 2u);
  EXPECT_EQ(suite.sweeps.back().name, "dance");
  EXPECT_EQ(suite.sweeps.back().pose_at(30).text(), "extension 30, side 10");
  EXPECT_EQ(suite.sweeps.back().to_deg, 120.0);
  EXPECT_NE(error_of(kSmall + std::string("[[sweep]]\nname = \"x\"\npath = [\"bend=3\"]\n"))
                .find("no channel 'bend'"),
            std::string::npos);
  EXPECT_NE(error_of(kSmall + std::string("[[sweep]]\nname = \"x\"\npath = [\"rest\"]\n"))
                .find("two poses that differ"),
            std::string::npos);
}

TEST_F(SuiteFile, NamesLineAndNearestKeyOfAMistypedOne) {
  std::string text = kSmall;
  text.replace(text.find("envelope"), 8, "envelop ");
  const std::string error = error_of(text);
  EXPECT_NE(error.find("suite.toml:4:"), std::string::npos) << error;
  EXPECT_NE(error.find("did you mean 'envelope'"), std::string::npos) << error;
}

TEST_F(SuiteFile, RefusesWhatItCannotRun) {
  EXPECT_NE(error_of("[suite]\n").find("at least one [[rig]]"), std::string::npos);
  EXPECT_NE(
      error_of("[suite]\n[[rig]]\nsolver = { system = \"isnr\" }\n").find("did you mean 'isner'"),
      std::string::npos);
  EXPECT_NE(error_of("[suite]\n[[rig]]\nsolver = 3\n").find("must be a table"), std::string::npos);
  EXPECT_NE(error_of("[suite\n").find("suite.toml:1:"), std::string::npos);
  EXPECT_NE(error_of(std::string(kSmall) +
                     "[[rig]]\nname = \"proposed\"\nsolver = { system = \"isner\" }\n")
                .find("two rigs"),
            std::string::npos);
  // What differs in letters that file names cannot hold would write each other's pictures.
  EXPECT_NE(
      error_of(std::string(kSmall) + "[[rig]]\nname = \"a b\"\nsolver = { system = \"isner\" }\n"
                                     "[[rig]]\nname = \"a?b\"\nsolver = { system = \"isner\" }\n")
          .find("rigs 'a b' and 'a?b' would write files of one name"),
      std::string::npos);
  EXPECT_NE(error_of("[suite]\ncharacters = [\"a/hero.glb\", \"b/hero.glb\"]\n"
                     "[[rig]]\nsolver = { system = \"isner\" }\n")
                .find("two characters are named 'hero'"),
            std::string::npos);
  EXPECT_NE(error_of(std::string(kSmall) + "[[sweep]]\nchannel = \"twist\"\nto = inf\n")
                .find("'to' must be a number"),
            std::string::npos);
  EXPECT_NE(error_of(std::string(kSmall) + "[[sweep]]\nchannel = \"twist\"\nto = 0\n")
                .find("ends where it begins"),
            std::string::npos);
}

TEST_F(SuiteFile, ACanaryNeedsADutyOnASweepThatIsThere) {
  const std::string rig =
      "[[rig]]\nname = \"c\"\nrole = \"canary\"\nsolver = { system = \"isner\" }\n";
  EXPECT_NE(error_of(kSmall + rig).find("needs 'duty'"), std::string::npos);
  EXPECT_NE(error_of(kSmall + rig +
                     "duty = { code = \"BB001\", sweep = \"extension\", at_deg = 1, twin = { "
                     "system = \"even\" } }\n")
                .find("does not have"),
            std::string::npos);
}

TEST_F(SuiteFile, LimitsComeInLayersAndEachSaysWhereItIsFrom) {
  const Suite suite = read_suite(
      write(std::string(kSmall) + "[[limit]]\ncode = \"BB020\"\nvalue = 1.5\nlayer = \"studio\"\n"
                                  "owner = \"rigging\"\nreason = \"no props in this studio\"\n"
                                  "[[limit]]\ncode = \"BB020\"\nvalue = 3\ncharacter = \"blob\"\n"
                                  "owner = \"ann\"\nreason = \"it has no hands\"\n"));
  const double table = LimitSet().of("BB020").value;
  EXPECT_EQ(limits_for(suite.rules, "hero").of("BB020").value, 1.5);
  const std::vector<Limit> history = limits_for(suite.rules, "blob").history("BB020");
  ASSERT_EQ(history.size(), 3u);
  EXPECT_EQ(history[0].value, table);
  EXPECT_EQ(history[1].layer, LimitLayer::studio);
  EXPECT_EQ(history[2].value, 3.0);
  EXPECT_NE(history[2].origin.find(".toml:"), std::string::npos);
}

TEST_F(SuiteFile, ALimitOrWaiverThatNobodyAnswersForIsRefused) {
  EXPECT_NE(
      error_of(std::string(kSmall) + "[[limit]]\ncode = \"BB020\"\nvalue = 9\nowner = \"x\"\n")
          .find("needs 'reason'"),
      std::string::npos);
  EXPECT_NE(error_of(std::string(kSmall) +
                     "[[limit]]\ncode = \"BB02O\"\nvalue = 9\nowner = \"x\"\nreason = "
                     "\"y\"\n")
                .find("did you mean BB020"),
            std::string::npos);
  const std::string waiver = "[[waiver]]\ncode = \"BB020\"\nowner = \"x\"\nreason = \"y\"\n";
  EXPECT_NE(error_of(kSmall + waiver).find("needs 'expires'"), std::string::npos);
  EXPECT_NE(error_of(kSmall + waiver + "expires = \"2026-02-30\"\n").find("2026-02-30"),
            std::string::npos);
  EXPECT_EQ(
      read_suite(write(std::string(kSmall) + waiver + "expires = \"2026-02-28\"\nrig = \"r\"\n"))
          .rules.waivers.size(),
      1u);
}

TEST(ReadRig, TakesOptionsInline) {
  const RigPlan plan = read_rig("isner:vertebrae=7,depth=[0.3, 0.4],length=stretchy");
  EXPECT_EQ(plan.spec.system, "isner");
  EXPECT_EQ(std::get<double>(plan.spec.options.at("vertebrae")), 7.0);
  EXPECT_EQ(std::get<std::vector<double>>(plan.spec.options.at("depth")),
            (std::vector<double>{0.3, 0.4}));
  EXPECT_EQ(std::get<std::string>(plan.spec.options.at("length")), "stretchy");
}

TEST(RigText, IsReadBackAsTheSameRig) {
  const RigPlan plan = read_rig("isner:vertebrae=7,depth=[0.3, 0.4],length=stretchy");
  EXPECT_EQ(read_rig(rig_text(plan.spec)).spec.options, plan.spec.options);
  // To the last digit, so that what shows a finding again shows the same one.
  const RigPlan fine = read_rig("even:reach=0.12345678901234567,weights=[[0,0.7999999999999999]]");
  EXPECT_EQ(read_rig(rig_text(fine.spec)).spec.options, fine.spec.options);
}

TEST(ReadRig, SuggestsTheNearestSystem) {
  try {
    read_rig("curv");
    FAIL();
  } catch (const SuiteError& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean 'curve'"), std::string::npos)
        << error.what();
  }
  EXPECT_THROW(read_rig("curve:length"), SuiteError);
  EXPECT_THROW(read_rig("curve:length=]["), SuiteError);
}

}  // namespace
}  // namespace backbend::validate
