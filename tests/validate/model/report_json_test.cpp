#include "validate/model/report_json.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/validate/report_sample.h"

namespace backbend::validate {
namespace {

/// What parse_report says about `text`; empty if it is content.
std::string complaint(const std::string& text) {
  try {
    parse_report(text);
  } catch (const ReportError& e) {
    return e.what();
  }
  return {};
}

std::string with(const std::string& pointer, const nlohmann::json& value) {
  auto document = nlohmann::json::parse(report_json(sample_report()));
  document[nlohmann::json::json_pointer(pointer)] = value;
  return document.dump();
}

TEST(ReportJson, ReadsBackAsTheSameBytes) {
  const std::string text = report_json(sample_report());
  EXPECT_EQ(report_json(parse_report(text)), text);
}

TEST(ReportJson, SaysTheSameOnOneLineAndOnMany) {
  const Report report = sample_report();
  EXPECT_EQ(nlohmann::json::parse(report_json_compact(report)),
            nlohmann::json::parse(report_json(report)));
  EXPECT_EQ(report_json_compact(report).find('\n'), std::string::npos);
}

TEST(ReportJson, WritesWhatIsNotFiniteAsNullAndReadsItAsNotANumber) {
  Report report = sample_report();
  report.findings[0].value = std::numeric_limits<double>::quiet_NaN();
  report.findings[1].value = std::numeric_limits<double>::infinity();
  const std::string text = report_json(report);
  const auto document = nlohmann::json::parse(text);
  EXPECT_TRUE(document["findings"][0]["value"].is_null());
  EXPECT_TRUE(document["findings"][1]["value"].is_null());
  const Report back = parse_report(text);
  EXPECT_TRUE(std::isnan(back.findings[0].value));
  EXPECT_EQ(judge(back.findings[0].value, 1.0), Verdict::not_measured);
}

TEST(ReportJson, KeepsWhatWasSearchedAndHowMuchIsCleanApart) {
  Report report = sample_report();
  RigResult& rig = report.rigs.front();
  EXPECT_FALSE(nlohmann::json::parse(report_json(report))["rigs"][0].contains("hunt"));
  rig.hunt = {177, 3, "side -45..45", 0.04, {}, {"not searched: it has no twist"}};
  rig.hunt.worst = {{"BB011", "deg", "side 40", 31.5, 25, true, 1},
                    {"BB030", "ratio", "side 45", 0.9, 0.75, false, -1}};
  rig.volume = {"side -45..45", true, 0.875, 1.0, 0.125, 8.0, "", 59, 58, 0.92};
  const std::string text = report_json(report);
  EXPECT_EQ(report_json(parse_report(text)), text);
  EXPECT_EQ(nlohmann::json::parse(text)["rigs"][0]["hunt"]["worst"][0]["sweep"], "side");
  EXPECT_EQ(parse_report(text).rigs[0].hunt.worst[0].sweep, 1);
  EXPECT_EQ(parse_report(text).rigs[0].hunt.worst[1].sweep, -1);
  const auto volume = nlohmann::json::parse(text)["rigs"][0]["volume"];
  EXPECT_EQ(volume["certified"]["share"], 0.875);
  EXPECT_EQ(volume["searched"]["clean"], 58);
  EXPECT_EQ(volume["searched"]["confidence"], 0.95);
  // Where nothing was proved no share is written.
  rig.volume.proved = false;
  rig.volume.not_proved = "not on boxes";
  const auto without = nlohmann::json::parse(report_json(report))["rigs"][0]["volume"];
  EXPECT_TRUE(without["certified"].is_null());
  EXPECT_EQ(without["not_certified"], "not on boxes");
  // More clean poses than were looked at, shares that are none, and paths that are no sweep of the
  // rig are refused.
  auto damaged = nlohmann::json::parse(text);
  damaged["rigs"][0]["hunt"]["worst"][0]["sweep"] = "hunt even BB011";
  EXPECT_NE(complaint(damaged.dump()).find("worst[0].sweep: names no sweep of the rig"),
            std::string::npos)
      << complaint(damaged.dump());
  damaged = nlohmann::json::parse(text);
  damaged["rigs"][0]["volume"]["searched"]["clean"] = 60;
  EXPECT_NE(complaint(damaged.dump()).find("more clean poses than poses"), std::string::npos);
  damaged = nlohmann::json::parse(text);
  damaged["rigs"][0]["volume"]["certified"]["share"] = 1.5;
  EXPECT_NE(complaint(damaged.dump()).find("from 0 to 1"), std::string::npos);
}

TEST(ReportJson, HoldsEveryKeyOfTheSpecificationInAFinding) {
  const auto document = nlohmann::json::parse(report_json(sample_report()));
  for (const char* key :
       {"code", "character", "rig", "sweep", "pose", "frame", "time", "control_deg", "place",
        "value", "limit", "unit", "verdict", "owner", "geometry", "image", "reproduce"})
    EXPECT_TRUE(document["findings"][0].contains(key)) << key;
  EXPECT_EQ(document["findings"][0]["pose_index"], 29);     // extension 58 of 0..180 by 2
  EXPECT_TRUE(document["findings"][0]["frame"].is_null());  // a sweep has no time
  EXPECT_TRUE(document["findings"][0]["time"].is_null());
  EXPECT_EQ(document["findings"][0]["place"], (nlohmann::json{{"joint", "bone_07"}}));
  EXPECT_EQ(document["findings"][3]["image"], "not_measured");
}

TEST(ReportJson, AClipsFindingHasTheClipsOwnFrameAndSecond) {
  Report report = sample_report();
  report.findings[0].frame = 43;
  report.findings[0].time_s = 43.0 / 30.0;
  const std::string text = report_json(report);
  const auto document = nlohmann::json::parse(text);
  EXPECT_EQ(document["findings"][0]["frame"], 43);
  EXPECT_EQ(document["findings"][0]["time"], 43.0 / 30.0);
  const Report back = parse_report(text);
  EXPECT_EQ(back.findings[0].frame, 43);
  EXPECT_EQ(back.findings[0].time_s, 43.0 / 30.0);
  EXPECT_EQ(back.findings[0].at.pose, 29);
}

TEST(ReportJson, FindsThePosesOfFindingsByTheirNames) {
  Report report = sample_report();
  report.findings[0].at = {};
  number_findings(report);
  // The first rig's extension; the pose's number is its file's.
  EXPECT_EQ(report.findings[0].at, (PoseRef{0, 0, -1}));
  const Report back = parse_report(report_json(sample_report()));
  EXPECT_EQ(back.findings[0].at, (PoseRef{0, 0, 29}));
  EXPECT_EQ(parse_report(with("/findings/0/sweep", "elsewhere")).findings[0].at,
            (PoseRef{0, -1, 29}));
  EXPECT_EQ(parse_report(with("/findings/0/rig", "nobody")).findings[0].at, (PoseRef{-1, -1, 29}));
}

TEST(ReportJson, KeepsEveryDoubleExactly) {
  Report report = sample_report();
  for (const double value :
       {0.1, 1.0 / 3, 114.30000000000001, 5e-324, 1.7976931348623157e308, -60.0}) {
    report.findings[0].value = value;
    EXPECT_EQ(parse_report(report_json(report)).findings[0].value, value);
  }
}

TEST(ReportJson, NamesThePathOfWhatItCannotRead) {
  EXPECT_NE(complaint(with("/rigs/1/headroom/0/needs_deg", "sixty"))
                .find("$.rigs[1].headroom[0].needs_deg: expected a number or null"),
            std::string::npos)
      << complaint(with("/rigs/1/headroom/0/needs_deg", "sixty"));
  EXPECT_NE(complaint(with("/findings/2/verdict", "fine"))
                .find("$.findings[2].verdict: unknown word 'fine'"),
            std::string::npos);
  EXPECT_NE(
      complaint(with("/findings/0/surprise", 1)).find("$.findings[0]: unknown key 'surprise'"),
      std::string::npos);
  EXPECT_NE(complaint(with("/schema", "backbend.report/2")).find("$.schema"), std::string::npos);
  EXPECT_NE(complaint(with("/exit_code", 1e10)).find("$.exit_code"), std::string::npos);
  EXPECT_NE(
      complaint(with("/exit_code", 10000000000)).find("$.exit_code: the number is out of range"),
      std::string::npos);
}

TEST(ReportJson, RefusesWhatContradictsItself) {
  EXPECT_NE(complaint(with("/rigs/0/headroom/0/headroom_deg", 99)), "");
  EXPECT_NE(complaint(with("/rigs/0/coverage/0/measured", 1)), "");
  EXPECT_NE(complaint(with("/rigs/0/sweeps/0/control_deg", nlohmann::json::array())), "");
  EXPECT_NE(complaint(with("/rigs/0/sweeps/0/metric/kink", nlohmann::json::array({1, 2})))
                .find("$.rigs[0].sweeps[0]: metric 'kink' has 2 values for 91 poses"),
            std::string::npos);
  EXPECT_NE(complaint(with("/rigs/0/sweeps/0/frame", nlohmann::json::array({"a.png"}))), "");
  EXPECT_NE(complaint(with("/canaries/0/ok", false)), "");
  EXPECT_NE(complaint(with("/findings/0/frame", 1031)).find("'frame' and 'time' stand together"),
            std::string::npos);
  EXPECT_NE(complaint(with("/findings/0/time", 1.25)), "");
  EXPECT_NE(complaint(with("/pairs/0/finding", 8)), "");
  EXPECT_EQ(complaint(with("/pairs/0/finding", 7)), "");
}

TEST(ReportJson, KeepsAClipsOwnFrameAndSecond) {
  Report report = sample_report();
  report.findings[0].frame = 7;
  report.findings[0].time_s = 0.25;
  const Finding back = parse_report(report_json(report)).findings[0];
  EXPECT_EQ(back.at.pose, report.findings[0].at.pose);
  EXPECT_EQ(back.frame, 7);
  EXPECT_EQ(back.time_s, 0.25);
}

TEST(ReportJson, ReadsOlderReportsThatCountThePosesFrom1001) {
  auto document = nlohmann::json::parse(report_json(sample_report()));
  auto& old = document["findings"][0];
  old.erase("pose_index");
  EXPECT_EQ(parse_report(document.dump()).findings[0].at.pose, -1) << "on no sweep";
  old["frame"] = 1030;
  old["time"] = 29 / 24.0;
  const Finding back = parse_report(document.dump()).findings[0];
  EXPECT_EQ(back.at.pose, 29);
  EXPECT_FALSE(back.frame || back.time_s) << "a clip's own time is not in them";
  old["time"] = 1.0;
  EXPECT_NE(complaint(document.dump()), "") << "time must follow from frame";
  old["frame"] = 1000;
  EXPECT_NE(complaint(document.dump()).find("sequences start at frame 1001"), std::string::npos);
}

TEST(ReportJson, RefusesDamagedText) {
  const std::string text = report_json(sample_report());
  EXPECT_NE(complaint("").find("not JSON"), std::string::npos);
  EXPECT_NE(complaint("[]").find("expected an object"), std::string::npos);
  EXPECT_NE(complaint("{\"schema\": 1, \"schema\": 2}").find("stands twice"), std::string::npos);
  EXPECT_NE(complaint(std::string(100000, '[')), "");
  for (std::size_t cut = 1; cut < text.size(); cut += text.size() / 50)
    EXPECT_NE(complaint(text.substr(0, cut)), "") << cut;
}

}  // namespace
}  // namespace backbend::validate
