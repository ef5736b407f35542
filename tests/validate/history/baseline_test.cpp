#include "validate/history/baseline.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/validate/report_sample.h"
#include "validate/files/hash.h"
#include "validate/model/digest.h"
#include "validate/model/report_json.h"

namespace backbend::validate {
namespace {

constexpr const char* kToday = "2026-11-22";

std::string some_hash(const std::string& path) { return content_hash(path); }

Approvals everything(const Report& report) {
  Approvals approvals = approvals_of_all(report);
  approvals.author = "lead";
  approvals.reason = "show start";
  approvals.until = "2026-12-15";
  return approvals;
}

std::vector<Finding> after(Report report, const Baseline& baseline,
                           const std::string& day = kToday) {
  const Digest digest(report);
  apply_baseline(
      report.findings, [&](const Finding& f) { return digest.role_of(f); }, baseline, day);
  return report.findings;
}

std::string refusal(const Approvals& approvals, const Report& report = sample_report(),
                    const Baseline& before = {}) {
  try {
    approve(before, report, approvals, kToday, some_hash);
  } catch (const BaselineError& error) {
    return error.what();
  }
  return "";
}

TEST(Baseline, WaivesWhatWasApprovedAndSaysByWhomAndUntilWhen) {
  const Report report = sample_report();
  const auto findings = after(report, approve({}, report, everything(report), kToday, some_hash));
  EXPECT_EQ(findings[0].verdict, Verdict::waived);
  EXPECT_NE(findings[0].detail.find("approved at 9.1 until 2026-12-15 by lead: show start"),
            std::string::npos)
      << findings[0].detail;
  // A reference rig's failure does not decide, hence is not approved.
  EXPECT_EQ(findings[6].rig, "isner");
  EXPECT_EQ(findings[6].verdict, Verdict::fail);
}

TEST(Baseline, FailsOnWorseThanApprovedInTheSenseOfTheCheck) {
  Report report = sample_report();
  const Baseline baseline = approve({}, report, everything(report), kToday, some_hash);
  report.findings[0].value = 9.2;   // kink: more is worse
  report.findings[2].value = 0.70;  // slice area: less is worse
  auto findings = after(report, baseline);
  EXPECT_EQ(findings[0].verdict, Verdict::fail);
  EXPECT_NE(findings[0].detail.find("worse than the approved 9.1"), std::string::npos);
  EXPECT_EQ(findings[2].verdict, Verdict::fail);
  report.findings[0].value = 9.0;
  report.findings[2].value = 0.72;
  findings = after(report, baseline);
  EXPECT_EQ(findings[0].verdict, Verdict::waived);
  EXPECT_EQ(findings[2].verdict, Verdict::waived);
}

TEST(Baseline, FailsOnWhatIsNewAndOnWhatHasExpired) {
  const Report report = sample_report();
  const Baseline baseline = approve({}, report, everything(report), kToday, some_hash);
  Report other = report;
  other.findings[0].joint = "bone_03";
  EXPECT_EQ(after(other, baseline)[0].verdict, Verdict::fail);
  EXPECT_EQ(after(report, baseline, "2026-12-15")[0].verdict, Verdict::waived);
  const Finding expired = after(report, baseline, "2026-12-16")[0];
  EXPECT_EQ(expired.verdict, Verdict::fail);
  EXPECT_NE(expired.detail.find("expired on 2026-12-15"), std::string::npos);
}

TEST(Baseline, NeverCoversAFlipInsideTheEnvelope) {
  Report report = sample_report();
  report.findings[0].code = "BB001";
  report.findings[0].inside_envelope = true;
  Approvals approvals = everything(report);
  for (const auto& one : approvals.cases) EXPECT_NE(one.finding, 0u);
  approvals.cases.push_back({0, finding_hash(report.findings[0])});
  EXPECT_NE(refusal(approvals, report).find("a flip inside the envelope"), std::string::npos);
  Baseline forged = approve({}, report, everything(report), kToday, some_hash);
  forged.approvals.push_back(forged.approvals[0]);
  forged.approvals.back().code = "BB001";
  forged.approvals.back().joint = report.findings[0].joint;
  forged.approvals.back().sweep = report.findings[0].sweep;
  forged.approvals.back().mapping = report.findings[0].mapping;
  forged.approvals.back().value = 1000;
  EXPECT_EQ(after(report, forged)[0].verdict, Verdict::fail);
}

TEST(Baseline, KeepsSeveralApprovalsOfOneCaseAndAnyOfThemSuffices) {
  Report report = sample_report();
  Baseline baseline = approve({}, report, everything(report), kToday, some_hash);
  const std::size_t count = baseline.approvals.size();
  baseline = approve(baseline, report, everything(report), kToday, some_hash);
  EXPECT_EQ(baseline.approvals.size(), count) << "the same approval twice is one";
  report.findings[0].value = 9.9;
  baseline = approve(baseline, report, everything(report), kToday, some_hash);
  EXPECT_EQ(baseline.approvals.size(), count + 1);
  EXPECT_EQ(after(report, baseline)[0].verdict, Verdict::waived);
}

TEST(Baseline, ReadsBackAsTheSameBytes) {
  const Report report = sample_report();
  const std::string text =
      baseline_json(approve({}, report, everything(report), kToday, some_hash));
  EXPECT_EQ(baseline_json(parse_baseline(text, "b")), text);
  for (const std::string& name : hostile_names()) {
    if (name.empty()) continue;  // refused: an approval needs an author
    Approvals approvals = everything(report);
    approvals.author = approvals.reason = name;
    const std::string hostile = baseline_json(approve({}, report, approvals, kToday, some_hash));
    EXPECT_EQ(baseline_json(parse_baseline(hostile, "b")), hostile);
  }
}

TEST(Baseline, RefusesDamage) {
  const Report report = sample_report();
  const std::string text =
      baseline_json(approve({}, report, everything(report), kToday, some_hash));
  for (const std::string& damaged :
       {std::string(), text.substr(0, text.size() / 2), std::string("{}"), std::string("[]"),
        std::string(R"({"schema": "backbend.baseline/2"})"),
        std::string(R"({"schema": "backbend.baseline/1", "suite": 3, "approvals": []})"),
        std::string(R"({"schema": "backbend.baseline/1", "suite": "", "approvals": [3]})")}) {
    EXPECT_THROW(parse_baseline(damaged, "b"), BaselineError) << damaged;
    EXPECT_THROW(parse_approvals(damaged, "a"), BaselineError) << damaged;
  }
}

TEST(Approvals, OfAnotherReportOrSuiteAreRefused) {
  const Report report = sample_report();
  Report later = report;
  later.findings[0].value += 0.001;
  EXPECT_NE(refusal(everything(report), later).find("stale"), std::string::npos);
  Approvals elsewhere = everything(report);
  elsewhere.suite = "weekly";
  EXPECT_NE(refusal(elsewhere).find("weekly"), std::string::npos);
  Baseline of_weekly = approve({}, report, everything(report), kToday, some_hash);
  of_weekly.suite = "weekly";
  EXPECT_NE(refusal(everything(report), report, of_weekly).find("weekly"), std::string::npos);
}

TEST(Approvals, WithAWrongHashOrOfNoFailureAreRefused) {
  Approvals wrong = everything(sample_report());
  wrong.cases[1].hash = wrong.cases[0].hash;
  EXPECT_NE(refusal(wrong).find("wrong hash"), std::string::npos);
  wrong.cases[1] = {99, "x"};
  EXPECT_NE(refusal(wrong).find("no such finding"), std::string::npos);
  const Report report = sample_report();
  for (const std::size_t i : {std::size_t{3}, std::size_t{5}, std::size_t{6}}) {
    wrong.cases[1] = {i, finding_hash(report.findings[i])};
    EXPECT_NE(refusal(wrong).find("only failures of a proposed rig"), std::string::npos) << i;
  }
}

TEST(Approvals, NeedAnAuthorAReasonAndADayToCome) {
  Approvals approvals = everything(sample_report());
  EXPECT_EQ(refusal(approvals), "");
  for (const char* until : {"2026-11-21", "tomorrow", "2026-02-30"}) {
    Approvals wrong = approvals;
    wrong.until = until;
    EXPECT_NE(refusal(wrong), "") << until;
  }
  Approvals nameless = approvals, pointless = approvals;
  nameless.author = "";
  pointless.reason = "";
  EXPECT_NE(refusal(nameless).find("author"), std::string::npos);
  EXPECT_NE(refusal(pointless).find("reason"), std::string::npos);
}

TEST(Approvals, OfPicturesThatAreNotThereAreRefused) {
  const Report report = sample_report();
  EXPECT_THROW(approve({}, report, everything(report), kToday,
                       [](const std::string&) { return std::string(); }),
               BaselineError);
}

}  // namespace
}  // namespace backbend::validate
