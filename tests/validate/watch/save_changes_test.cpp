#include "validate/watch/save_changes.h"

#include <gtest/gtest.h>

namespace backbend::validate {
namespace {

Finding kink(const std::string& sweep, double value, Verdict verdict = Verdict::fail) {
  Finding f;
  f.code = "BB011";
  f.at.rig = 0;
  f.character = "hero";
  f.rig = "even";
  f.mapping = "chest";
  f.sweep = sweep;
  f.pose = sweep + " 60";
  f.value = value;
  f.limit = 25;
  f.unit = "deg";
  f.verdict = verdict;
  return f;
}

Report report_of(std::vector<Finding> findings) {
  Report report;
  report.title = "Judging the WEIGHTS of hero.glb";
  report.verdict = findings.empty() ? Verdict::pass : Verdict::fail;
  RigResult rig;
  rig.character = "hero";
  rig.rig = "even";
  rig.mapping = "chest";
  Headroom headroom;
  headroom.channel = "extension";
  headroom.clean_to_deg = findings.empty() ? 97 : 54;
  headroom.tested_to_deg = 120;
  headroom.needs_deg = 60;
  headroom.measured = true;
  rig.headroom = {headroom};
  report.rigs = {rig};
  report.checks.push_back({"BB011", "mesh kink", "", "deg", "", 25, "at most"});
  report.findings = std::move(findings);
  return report;
}

using Kind = SaveChange::Kind;

TEST(SaveChanges, AreWorseNewBetterAndGoneInThisOrder) {
  const Report before = report_of({kink("extension", 30), kink("flexion", 40), kink("side", 50)});
  const Report now = report_of({kink("extension", 29), kink("flexion", 41), kink("twist", 26)});
  const std::vector<SaveChange> changes = changes_between(before, now);
  ASSERT_EQ(changes.size(), 4u);
  EXPECT_EQ(changes[0].kind, Kind::worse);
  EXPECT_EQ(changes[0].before->value, 40);
  EXPECT_EQ(changes[0].now->value, 41);
  EXPECT_EQ(changes[1].kind, Kind::fresh);
  EXPECT_EQ(changes[1].now->sweep, "twist");
  EXPECT_EQ(changes[2].kind, Kind::better);
  EXPECT_EQ(changes[2].now->sweep, "extension");
  EXPECT_EQ(changes[3].kind, Kind::gone);
  EXPECT_EQ(changes[3].before->sweep, "side");
}

TEST(SaveChanges, WhatReadsTheSameIsTheSame) {
  const Report before = report_of({kink("extension", 30.0)});
  EXPECT_TRUE(changes_between(before, report_of({kink("extension", 30.0 + 1e-9)})).empty());
  EXPECT_EQ(changes_between(before, report_of({kink("extension", 30.1)})).size(), 1u);
}

TEST(SaveChanges, AVerdictThatTurnsCountsBeforeTheFigure) {
  const Report before = report_of({kink("extension", 40, Verdict::stress)});
  const Report now = report_of({kink("extension", 30, Verdict::fail)});
  ASSERT_EQ(changes_between(before, now).size(), 1u);
  EXPECT_EQ(changes_between(before, now)[0].kind, Kind::worse);
  EXPECT_EQ(changes_between(now, before)[0].kind, Kind::better);
}

TEST(SaveChanges, WhatCannotBeMeasuredAnyMoreIsWorse) {
  const Report before = report_of({kink("extension", 30)});
  const Report now = report_of({kink("extension", std::nan(""), Verdict::fail)});
  ASSERT_EQ(changes_between(before, now).size(), 1u);
  EXPECT_EQ(changes_between(before, now)[0].kind, Kind::worse);
}

TEST(SaveChanges, ALimitFromBelowTurnsTheDirection) {
  Finding area = kink("twist", 0.5);
  area.code = "BB030";  // slice area: at least
  Finding more = area;
  more.value = 0.6;
  const auto changes = changes_between(report_of({area}), report_of({more}));
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].kind, Kind::better);
}

TEST(SaveChanges, ReferenceRigsAreNotCounted) {
  Report before = report_of({kink("extension", 30)}), now = report_of({kink("extension", 60)});
  for (Report* each : {&before, &now}) each->rigs[0].role = Role::reference;
  EXPECT_TRUE(changes_between(before, now).empty());
}

TEST(SaveText, ShowsVerdictHeadroomChangesAndTheWorst) {
  const Report before = report_of({kink("extension", 30)}), now = report_of({});
  SaveView view;
  view.now = &now;
  view.before = &before;
  view.save = 2;
  view.changed = "hero\x1b.glb";
  TerminalStyle style;
  std::string text = save_text(view, style);
  EXPECT_NE(text.find("PASS  Judging"), std::string::npos) << text;
  EXPECT_NE(text.find("clean to 97   needs 60   headroom +37  (clean to 54 before)"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("0 worse, 0 new, 0 better, 1 gone"), std::string::npos) << text;
  EXPECT_NE(text.find("gone    BB011 mesh kink, extension 60: 30 deg (limit 25)"),
            std::string::npos)
      << text;
  EXPECT_EQ(text.find('\x1b'), std::string::npos) << text;  // names do not act
  std::swap(view.now, view.before);
  text = save_text(view, style);
  EXPECT_NE(text.find("new     BB011"), std::string::npos) << text;
  EXPECT_NE(text.find("worst BB011 mesh kink, extension 60: 30 deg (limit 25)"), std::string::npos)
      << text;
  style.width = 40;
  text = save_text(view, style);
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\n', at);
    EXPECT_LE(end - at, 40u + 2) << text.substr(at, end - at);  // an ellipsis is three bytes
    at = end + 1;
  }
}

}  // namespace
}  // namespace backbend::validate
