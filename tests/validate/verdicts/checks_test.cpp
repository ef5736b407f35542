#include "validate/verdicts/checks.h"
#include "validate/metrics/math/nan.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "validate/verdicts/limits.h"

namespace backbend::validate {
namespace {

TEST(Checks, EveryRowAnswersWhatAPersonAsks) {
  std::set<std::string_view> codes, names;
  for (const Check& check : all_checks()) {
    EXPECT_TRUE(codes.insert(check.code).second) << check.code;
    EXPECT_TRUE(names.insert(check.name).second) << check.name;
    EXPECT_EQ(check.code.size(), 5u) << check.code;
    for (std::string_view text :
         {check.measures, check.unit, check.reason, check.cause, check.remedy})
      EXPECT_FALSE(text.empty()) << check.code;
    EXPECT_TRUE(std::isfinite(check.limit)) << check.code;
    EXPECT_NE(check.owner, Owner::none) << check.code;
    EXPECT_EQ(find_check(check.code), &check);
  }
}

TEST(Checks, AnUnknownCodeIsNotFound) {
  EXPECT_EQ(find_check("BB999"), nullptr);
  EXPECT_EQ(find_check(""), nullptr);
  EXPECT_EQ(nearest_code("BB0O1"), "BB001");
}

TEST(Checks, ALimitBoundsFromTheSideThatTheRowSays) {
  const Check& flip = *find_check("BB001");
  EXPECT_EQ(judge(flip, 1.0, 1.0), Verdict::pass);
  EXPECT_EQ(judge(flip, 1.1, 1.0), Verdict::fail);
  const Check& area = *find_check("BB030");
  EXPECT_EQ(judge(area, 0.75, 0.75), Verdict::pass);
  EXPECT_EQ(judge(area, 0.71, 0.75), Verdict::fail);
}

TEST(Checks, WhatIsNotANumberIsNeverAPass) {
  for (const Check& check : all_checks()) {
    EXPECT_EQ(judge(check, kNan, check.limit), Verdict::not_measured) << check.code;
    EXPECT_EQ(judge(check, check.limit, kNan), Verdict::not_measured) << check.code;
    EXPECT_EQ(judge(check, -std::numeric_limits<double>::infinity(), check.limit),
              Verdict::not_measured);
  }
}

TEST(LimitSet, StartsFromTheTable) {
  const LimitSet limits;
  for (const Check& check : all_checks()) {
    EXPECT_EQ(limits.of(check.code).value, check.limit);
    EXPECT_EQ(limits.of(check.code).reason, check.reason);
  }
}

TEST(LimitSet, LaterLayersWinWhateverTheOrderTheyAreRead) {
  LimitSet limits;
  limits.set("BB020", {0.2, LimitLayer::character, "hero.toml:4", "ann", "close-ups of the hands"});
  limits.set("BB020", {1.0, LimitLayer::studio, "studio.toml:2", "lee", "old rigs"});
  EXPECT_EQ(limits.of("BB020").value, 0.2);
  ASSERT_EQ(limits.history("BB020").size(), 3u);
  EXPECT_EQ(limits.history("BB020")[1].owner, "lee");
  EXPECT_EQ(limits.judge("BB020", 0.3), Verdict::fail);
  limits.set("BB020", {2.0, LimitLayer::character, "hero.toml:4", "ann", "far away now"});
  EXPECT_EQ(limits.history("BB020").size(), 3u);
  EXPECT_EQ(limits.judge("BB020", 0.3), Verdict::pass);
}

TEST(LimitSet, RefusesWhatNobodyCouldExplain) {
  LimitSet limits;
  EXPECT_THROW(limits.set("BB020", {1.0, LimitLayer::show, "a.toml:1", "x", ""}), LimitError);
  EXPECT_THROW(limits.set("BB020", {kNan, LimitLayer::show, "a.toml:1", "x", "y"}), LimitError);
  try {
    limits.set("BB02O", {1.0, LimitLayer::show, "a.toml:1", "x", "y"});
    FAIL();
  } catch (const LimitError& error) {
    EXPECT_NE(std::string(error.what()).find("BB020"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace backbend::validate
