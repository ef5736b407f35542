#include "validate/evidence/timeline.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/validate/report_sample.h"

namespace backbend::validate {
namespace {

using nlohmann::json;

/// Two rigs on one character, five poses of extension each, pictured; a flip of `isner` at 45
/// degrees, past the pose of 40, and a finding on a sweep without pictures.
Report two_rigs() {
  Report report;
  report.title = "night";
  for (const char* name : {"even", "isner"}) {
    RigResult rig;
    rig.character = "hero";
    rig.rig = name;
    rig.mapping = "chest";
    SweepSeries sweep{"extension", "extension", "chest", {0, 20, 40, 60, 80}, {}, {}, {}, {}, {}};
    for (int frame = 1001; frame <= 1005; ++frame)
      sweep.frame.push_back("review/hero_" + std::string(name) + "_chest/extension." +
                            std::to_string(frame) + ".png");
    rig.sweeps = {sweep, {"side", "side", "chest", {0, 1}, {}, {}, {}, {"", ""}, {}}};
    report.rigs.push_back(rig);
  }
  Finding flip;
  flip.code = "BB001";
  flip.at = {1, 0, -1};
  flip.character = "hero";
  flip.rig = "isner";
  flip.mapping = "chest";
  flip.pose = "extension 45";
  flip.control_deg = 45;
  flip.value = 171.4;
  flip.limit = 20;
  flip.unit = "deg";
  flip.verdict = Verdict::fail;
  flip.owner = Owner::solver;
  Finding other = flip;
  other.at.sweep = 1;
  report.findings = {flip, other};
  return report;
}

/// What RV and the library's readers take for an item: its time range as first frame and count.
std::pair<int, int> frames_of(const json& range) {
  EXPECT_EQ(range["OTIO_SCHEMA"], "TimeRange.1");
  EXPECT_EQ(range["start_time"]["rate"], 24.0);
  return {range["start_time"]["value"].get<int>(), range["duration"]["value"].get<int>()};
}

TEST(SweepsTimeline, StacksATrackForEachRigTheFirstOnTop) {
  const json timeline = json::parse(sweeps_otio(two_rigs()));
  EXPECT_EQ(timeline["OTIO_SCHEMA"], "Timeline.1");
  const json& tracks = timeline["tracks"]["children"];
  ASSERT_EQ(tracks.size(), 2u);
  EXPECT_EQ(tracks[0]["name"], "isner");
  EXPECT_EQ(tracks[1]["name"], "even");
  const json& clip = tracks[1]["children"][0];
  EXPECT_EQ(tracks[1]["children"].size(), 1u);  // no clip for the sweep without pictures
  EXPECT_EQ(frames_of(clip["source_range"]), std::pair(1001, 5));
  const json& media = clip["media_reference"];
  EXPECT_EQ(media["OTIO_SCHEMA"], "ImageSequenceReference.1");
  EXPECT_EQ(media["target_url_base"], "hero_even_chest/");  // relative to review/
  EXPECT_EQ(media["name_prefix"], "extension.");
  EXPECT_EQ(media["name_suffix"], ".png");
  EXPECT_EQ(media["start_frame"], 1001);
  EXPECT_EQ(frames_of(media["available_range"]), std::pair(1001, 5));
}

TEST(SweepsTimeline, MarksAFindingOnItsRigAtTheFrameOfTheNearestAngle) {
  const json tracks = json::parse(sweeps_otio(two_rigs()))["tracks"]["children"];
  EXPECT_TRUE(tracks[1]["children"][0]["markers"].empty());  // even has none
  const json& markers = tracks[0]["children"][0]["markers"];
  ASSERT_EQ(markers.size(), 1u);  // the other sweep has no pictures
  EXPECT_EQ(markers[0]["OTIO_SCHEMA"], "Marker.2");
  EXPECT_EQ(markers[0]["name"], "BB001 flip: 171.4 deg (limit 20)");
  EXPECT_EQ(markers[0]["color"], "RED");
  EXPECT_EQ(frames_of(markers[0]["marked_range"]), std::pair(1003, 1));  // 40 deg
  EXPECT_EQ(markers[0]["comment"], "extension 45, rig isner, SOLVER");
}

TEST(SweepsTimeline, LinesUpWhatOneRigLacks) {
  Report report = two_rigs();
  report.rigs[0].sweeps[0].frame.resize(3);
  report.rigs[0].sweeps[0].control_deg.resize(3);
  RigResult spread = report.rigs[1];
  spread.mapping = spread.sweeps[0].mapping = "spread";
  report.rigs.push_back(spread);
  const json tracks = json::parse(sweeps_otio(report))["tracks"]["children"];
  const json& even = tracks[1]["children"];
  ASSERT_EQ(even.size(), 3u);
  EXPECT_EQ(even[0]["OTIO_SCHEMA"], "Clip.1");
  EXPECT_EQ(frames_of(even[1]["source_range"]), std::pair(0, 2));  // up to isner's five frames
  EXPECT_EQ(even[2]["OTIO_SCHEMA"], "Gap.1");
  EXPECT_EQ(frames_of(even[2]["source_range"]), std::pair(0, 5));
  EXPECT_EQ(tracks[0]["children"].size(), 2u);
}

TEST(SweepsTimeline, IsLeftOutWhereNothingIsPicturedOrFramesAreMissing) {
  Report report = two_rigs();
  report.rigs.pop_back();
  report.rigs[0].sweeps[0].frame[2] = "review/hero_even_chest/extension.1009.png";
  EXPECT_EQ(sweeps_otio(report), "");
  EXPECT_EQ(sweeps_otio(Report{}), "");
  EXPECT_EQ(findings_otio(Report{}), "");
}

TEST(FindingsTimeline, ShowsThePoseOverWhatItIsComparedWithOverTheHeat) {
  Report report = two_rigs();
  report.findings[0].pictures = {"findings/a/before.png",
                                 "findings/a/after.png",
                                 "findings/a/heat.png",
                                 "",
                                 "",
                                 "profile",
                                 "kink, deg"};
  const json tracks = json::parse(findings_otio(report))["tracks"]["children"];
  ASSERT_EQ(tracks.size(), 3u);
  const char* const shown[] = {"heat.png", "after.png", "before.png"};
  for (std::size_t t = 0; t < 3; ++t) {
    ASSERT_EQ(tracks[t]["children"].size(), 1u);  // the other finding has no picture
    const json& clip = tracks[t]["children"][0];
    EXPECT_EQ(clip["media_reference"]["target_url"], "../findings/a/" + std::string(shown[t]));
    EXPECT_EQ(frames_of(clip["source_range"]).second, 48);
  }
  EXPECT_EQ(tracks[2]["children"][0]["markers"][0]["color"], "RED");
}

TEST(Timelines, OfHostileNamesAreStillJson) {
  for (const std::string& name : hostile_names()) {
    const Report report = sample_report_named(name);
    for (const std::string& text : {sweeps_otio(report), findings_otio(report)}) {
      if (!text.empty()) {
        EXPECT_EQ(json::parse(text)["OTIO_SCHEMA"], "Timeline.1");
      }
    }
  }
}

}  // namespace
}  // namespace backbend::validate
