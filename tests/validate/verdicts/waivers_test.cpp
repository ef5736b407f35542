#include "validate/verdicts/waivers.h"

#include <gtest/gtest.h>

namespace backbend::validate {
namespace {

Waiver arm_drift() {
  Waiver w;
  w.code = "BB020";
  w.character = "hero";
  w.joint = "clavicle.L";
  w.from_deg = 40;
  w.to_deg = 90;
  w.owner = "lee";
  w.reason = "show start; drift ticket RIG-212";
  w.expires = "2026-12-15";
  w.origin = "show.toml:12";
  return w;
}
Finding drift(double control_deg = 60) {
  Finding f;
  f.code = "BB020";
  f.character = "hero";
  f.joint = "clavicle.L";
  f.control_deg = control_deg;
  f.value = 1.8;
  f.verdict = Verdict::fail;
  return f;
}
Verdict after(const Waiver& waiver, Finding finding, std::string_view today = "2026-12-01") {
  apply_waivers({&finding, 1}, {&waiver, 1}, today);
  return finding.verdict;
}

TEST(Waivers, SayHowManyDaysAreLeft) {
  EXPECT_EQ(days_between("2026-12-01", "2026-12-15"), 14);
  EXPECT_EQ(days_between("2026-12-15", "2026-12-15"), 0);
  EXPECT_EQ(days_between("2028-02-28", "2028-03-01"), 2);  // a leap year
  EXPECT_EQ(days_between("2027-01-01", "2026-12-31"), -1);
  Finding finding = drift();
  const Waiver waiver = arm_drift();
  EXPECT_EQ(apply_waivers({&finding, 1}, {&waiver, 1}, "2026-12-15").holding.size(), 1u);
  finding = drift();
  EXPECT_TRUE(apply_waivers({&finding, 1}, {&waiver, 1}, "2026-12-16").holding.empty());
}

TEST(Waivers, CoverWhatTheyNameUntilTheirLastDay) {
  EXPECT_EQ(after(arm_drift(), drift()), Verdict::waived);
  EXPECT_EQ(after(arm_drift(), drift(), "2026-12-15"), Verdict::waived);
  EXPECT_EQ(after(arm_drift(), drift(), "2026-12-16"), Verdict::fail);
}

TEST(Waivers, CoverNothingElse) {
  EXPECT_EQ(after(arm_drift(), drift(91)), Verdict::fail);
  Finding other = drift();
  other.joint = "clavicle.R";
  EXPECT_EQ(after(arm_drift(), other), Verdict::fail);
  other = drift();
  other.code = "BB021";
  EXPECT_EQ(after(arm_drift(), other), Verdict::fail);
  Waiver up_to = arm_drift();
  up_to.worst = 1.5;
  EXPECT_EQ(after(up_to, drift()), Verdict::fail);
  up_to.worst = 2.0;
  EXPECT_EQ(after(up_to, drift()), Verdict::waived);
}

TEST(Waivers, TurnOnlyFailures) {
  Finding f = drift();
  f.verdict = Verdict::not_measured;
  EXPECT_EQ(after(arm_drift(), f), Verdict::not_measured);
  f.verdict = Verdict::stress;
  EXPECT_EQ(after(arm_drift(), f), Verdict::stress);
}

TEST(Waivers, SayWhichHaveExpiredAndWhichAreUnused) {
  std::vector<Finding> findings{drift()};
  std::vector<Waiver> waivers{arm_drift(), arm_drift()};
  waivers[0].expires = "2026-11-01";
  waivers[1].code = "BB001";
  const WaiverUse use = apply_waivers(findings, waivers, "2026-12-01");
  EXPECT_EQ(use.waived, 0u);
  EXPECT_EQ(use.expired, std::vector<std::size_t>{0});
  EXPECT_EQ(use.unused, std::vector<std::size_t>{1});
  EXPECT_EQ(findings[0].verdict, Verdict::fail);
}

TEST(Waivers, WithoutOwnerReasonOrARealDayAreRefusedWithTheirPlace) {
  for (void (*spoil)(Waiver&) :
       {+[](Waiver& w) { w.owner.clear(); }, +[](Waiver& w) { w.reason.clear(); },
        +[](Waiver& w) { w.expires = "2026-02-30"; }, +[](Waiver& w) { w.expires = "soon"; },
        +[](Waiver& w) { w.code = "BB02"; }, +[](Waiver& w) { w.from_deg = 100; }}) {
    Waiver w = arm_drift();
    spoil(w);
    try {
      check_waiver(w);
      FAIL();
    } catch (const LimitError& error) {
      EXPECT_EQ(std::string(error.what()).rfind("show.toml:12: ", 0), 0u) << error.what();
    }
  }
  EXPECT_NO_THROW(check_waiver(arm_drift()));
}

TEST(IsDay, KnowsTheCalendar) {
  EXPECT_TRUE(is_day("2028-02-29"));
  EXPECT_TRUE(is_day("2000-02-29"));
  EXPECT_FALSE(is_day("2026-02-29"));
  EXPECT_FALSE(is_day("2100-02-29"));
  EXPECT_FALSE(is_day("2026-13-01"));
  EXPECT_FALSE(is_day("2026-1-01"));
  EXPECT_FALSE(is_day("2026-01-00"));
  EXPECT_FALSE(is_day("20260-1-01"));
}

}  // namespace
}  // namespace backbend::validate
