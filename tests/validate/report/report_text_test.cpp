#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/validate/report_sample.h"
#include "validate/model/digest.h"
#include "validate/report/terminal.h"
#include "validate/text/escape.h"
#include "validate/text/number_text.h"
#include "validate/text/shell_word.h"
#include "validate/verdicts/names.h"

namespace backbend::validate {
namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

TEST(ShellWord, QuotesOnlyWhatAShellWouldTouch) {
  EXPECT_EQ(shell_word("runs/a-b_1.glb"), "runs/a-b_1.glb");
  EXPECT_EQ(shell_word("--pose=extension=90,side=10"), "--pose=extension=90,side=10");
  EXPECT_EQ(shell_word(""), "''");
  EXPECT_EQ(shell_word("my hero.glb"), "'my hero.glb'");
  EXPECT_EQ(shell_word("$(rm x);`y`\n"), "'$(rm x);`y`\n'");
  EXPECT_EQ(shell_word("it's"), "'it'\\''s'");
  EXPECT_EQ(shell_quoted("plain"), "'plain'");
}

TEST(NumberText, IsTheShortestThatReadsBack) {
  EXPECT_EQ(shortest(0.1), "0.1");
  EXPECT_EQ(shortest(60), "60");
  EXPECT_EQ(shortest(-0.0), "0");
  EXPECT_EQ(shortest(114.30000000000001), "114.30000000000001");
  EXPECT_EQ(shortest(1e-9), "1e-09");
  EXPECT_EQ(shortest(kNotANumber), "null");
  EXPECT_EQ(shortest(-std::numeric_limits<double>::infinity()), "null");
}

TEST(NumberText, NeverShowsAMinusZero) {
  EXPECT_EQ(fixed(-0.04, 1), "0.0");
  EXPECT_EQ(with_sign(-0.4, 0), "0");
  EXPECT_EQ(with_sign(37, 0), "+37");
  EXPECT_EQ(with_sign(-8, 0), "-8");
  EXPECT_EQ(with_sign(kNotANumber, 0), "-");
}

TEST(NumberText, KeepsFourSignificantDigitsAndNoTrailingZeros) {
  EXPECT_EQ(significant(171.42), "171.4");
  EXPECT_EQ(significant(0.713), "0.713");
  EXPECT_EQ(significant(0.5), "0.5");
  EXPECT_EQ(significant(12345.6), "12346");
  EXPECT_EQ(significant(-24), "-24");
  EXPECT_EQ(significant(0), "0");
  EXPECT_EQ(significant(1e12), "1.000e+12");
  EXPECT_EQ(significant(kNotANumber), "-");
}

TEST(Escape, SpellsOutWhatActsAndKeepsTheRest) {
  EXPECT_EQ(visible("spine_04.L"), "spine_04.L");
  EXPECT_EQ(visible("\x1b[31m"), "\\x1b[31m");
  EXPECT_EQ(visible("a\nb\tc"), "a\\nb\\tc");
  EXPECT_EQ(visible("\u202Eevil"), "\\u202eevil");  // right-to-left override
  EXPECT_EQ(visible("\u009b31m"), "\\u009b31m");    // the 8-bit form of escape [
  EXPECT_EQ(visible("Rücken \u6f22"), "Rücken \u6f22");
  EXPECT_EQ(visible("\xff"), "\\xff");
  EXPECT_EQ(visible("\xc0\xbc"), "\\xc0\\xbc");           // an overlong <
  EXPECT_EQ(visible("\xed\xa0\x80"), "\\xed\\xa0\\x80");  // a surrogate
  EXPECT_EQ(visible(std::string_view("a\0b", 3)), "a\\x00b");
}

TEST(Escape, IsDoneOnce) {
  for (const std::string& name : hostile_names()) EXPECT_EQ(visible(visible(name)), visible(name));
}

TEST(Escape, FitsEachPlace) {
  EXPECT_EQ(markup_text("<a href='\"&\">"), "&lt;a href=&#39;&quot;&amp;&quot;&gt;");
  EXPECT_EQ(markdown_code("x`y"), "`` x`y ``");
  EXPECT_EQ(markdown_code("a|b"), "`a\u00a6b`");
  EXPECT_EQ(markdown_code(""), "-");
  EXPECT_EQ(csv_text("plain"), "plain");
  EXPECT_EQ(csv_text("a,\"b\""), "\"a,\"\"b\"\"\"");
  EXPECT_EQ(csv_text("=1+1"), "\"'=1+1\"");
  EXPECT_EQ(csv_text("\uff1d1"), "\"'\uff1d1\"");  // full-width =
  EXPECT_EQ(json_text("\"\\\n\x01"), "\"\\\"\\\\\\n\\u0001\"");
  EXPECT_EQ(json_for_script("\"</script>&\""), "\"\\u003c/script\\u003e\\u0026\"");
}

TEST(Escape, CountsColumnsAsATerminalDoes) {
  EXPECT_EQ(display_width("spine"), 5u);
  EXPECT_EQ(display_width("\u6f22\u5b57"), 4u);  // two wide characters
  EXPECT_EQ(display_width("e\u0301"), 1u);       // a combining accent takes no room
  EXPECT_EQ(fitted("\u6f22\u5b57", 3), "\u6f22\u2026");
  EXPECT_EQ(padded("ab", 4), "ab  ");
  for (std::size_t width = 0; width < 12; ++width)
    for (const std::string& name : hostile_names())
      EXPECT_EQ(display_width(padded(visible(name), width)), width) << visible(name);
}

TEST(Names, AreReadAsTheyAreWritten) {
  for (const Verdict v : {Verdict::pass, Verdict::fail, Verdict::waived, Verdict::stress,
                          Verdict::not_measured, Verdict::not_applicable})
    EXPECT_EQ(verdict_from_word(verdict_word(v)), v);
  for (const Owner o : {Owner::none, Owner::solver, Owner::rig, Owner::motion, Owner::weights,
                        Owner::skeleton, Owner::pose, Owner::input, Owner::tool})
    EXPECT_EQ(owner_from_word(owner_word(o)), o);
  for (const Role r : {Role::proposed, Role::reference, Role::canary})
    EXPECT_EQ(role_from_word(role_word(r)), r);
  EXPECT_FALSE(verdict_from_word("PASS"));
}

TEST(Digest, ShowsFailuresOfTheProposedRigFirstAndOneOfEachKind) {
  Report report = sample_report();
  // The same failure again, and the reference's flip moved to the very front.
  report.findings.insert(report.findings.begin(), report.findings[0]);
  std::swap(report.findings[0], report.findings[7]);
  ASSERT_EQ(report.findings[0].code, "BB001");
  const Digest digest(report);
  const auto worst = digest.worst(3);
  ASSERT_EQ(worst.size(), 3u);
  EXPECT_EQ(worst[0]->code, "BB020");  // 1.32 times its limit
  EXPECT_EQ(worst[1]->code, "BB010");  // 1.14 times
  EXPECT_EQ(worst[2]->code, "BB030");
  EXPECT_EQ(digest.worst(100).size(), report.findings.size());
}

TEST(Digest, CountsOnlyWhatDecides) {
  const Report report = sample_report();
  const Digest digest(report);
  EXPECT_EQ(digest.counts().fail, 3);
  EXPECT_EQ(digest.counts().stress, 1);
  EXPECT_EQ(digest.counts().waived, 1);
  EXPECT_EQ(digest.counts().reference, 2);
  EXPECT_EQ(digest.counts().not_measured, 10);  // two mappings of the proposed rig, 2 + 3 each
}

TEST(Digest, TakesAnUnknownRigForOneThatDecides) {
  Report report = sample_report();
  report.findings[6].at.rig = -1;
  EXPECT_EQ(Digest(report).role_of(report.findings[6]), Role::proposed);
  EXPECT_EQ(Digest(report).counts().fail, 4);
}

TEST(Digest, PutsTheWorstOfAllRigsFirstByHowFarItIsOverItsLimit) {
  Report report = sample_report();
  // The second rig's finding stands last in the report and is four times over its limit.
  Finding late = report.findings[0];
  late.code = "BB011";
  late.at.rig = -1;
  late.rig = "another";
  late.value = 32.0;
  late.limit = 8.0;
  report.findings.push_back(late);
  const Digest digest(report);
  EXPECT_EQ(digest.worst(1).front()->rig, "another");
  // Under a lower limit the smaller value is the worse one: 0.75 / 0.15 is five times.
  Finding narrow = report.findings[2];
  narrow.at.rig = -1;
  narrow.rig = "another";
  narrow.value = 0.15;
  report.findings.push_back(narrow);
  EXPECT_EQ(Digest(report).worst(1).front()->code, "BB030");
}

TEST(Digest, SaysAValueWithItsLimitInTheWordsOfItsUnit) {
  Finding f;
  f.value = 63.0412;
  f.limit = 25;
  f.unit = "deg";
  EXPECT_EQ(value_text(f), "63 deg (limit 25)");
  f.value = 179.84;
  EXPECT_EQ(value_text(f), "179.8 deg (limit 25)");
  f.limit = kNotANumber;
  EXPECT_EQ(value_text(f), "179.8 deg");
  f.value = kNotANumber;
  EXPECT_EQ(value_text(f), "not measured");
  f.value = 20.4;
  f.limit = 20;
  f.unit = "ratio";
  EXPECT_EQ(value_text(f), "x 20.4 (limit 20)");
  f.code = "BB030";
  f.value = 0.71;
  f.limit = 0.75;
  EXPECT_EQ(value_text(f), "0.71 of rest (limit 0.75)");
}

TEST(Digest, NeverShowsAValueBeyondItsLimitAsEqualToIt) {
  Finding f;
  f.unit = "deg";
  f.limit = 15.0;
  f.value = 15.0004;
  EXPECT_EQ(value_text(f), "15.0004 deg (limit 15)");
  f.value = 15.0;
  EXPECT_EQ(value_text(f), "15 deg (limit 15)");
  f.limit = 0.0;
  f.value = 6.42e-15;  // what rounding leaves of nothing
  EXPECT_EQ(value_text(f), "0 deg (limit 0)");
}

TEST(Digest, NamesAPlaceByJointsSideAndMeshAndKeepsNumbersForWantOfBetter) {
  Finding f;
  EXPECT_EQ(place_text(f), "");
  f.slice = 18;
  EXPECT_EQ(place_text(f), "slice 18");
  f.joint = "spine_03";
  f.between = {"spine_02", "spine_03"};
  f.side = "left";
  f.part = "body";
  EXPECT_EQ(place_text(f), "between spine_02 and spine_03, left, mesh \"body\"");
  Finding joint;
  joint.joint = "clavicle.L";
  joint.side = "left";
  EXPECT_EQ(place_text(joint), "clavicle.L, left");
}

TEST(Digest, SpeaksOfACandyWrapperOnlyWhereTheBodyIsTwisted) {
  const Report report = sample_report();
  const Digest digest(report);
  Finding f = report.findings[2];
  ASSERT_EQ(f.code, "BB030");
  f.pose = "twist 60";
  EXPECT_EQ(finding_name(f, digest), "candy wrapper");
  f.pose = "extension 60, twist 60";
  EXPECT_EQ(finding_name(f, digest), "cross-section collapse");
}

TEST(Terminal, ShowsOneRigWithBarsAndSeveralInColumns) {
  Report report = sample_report();
  EXPECT_NE(terminal_summary(report).find("three_bone"), std::string::npos);
  report.rigs.resize(1);
  TerminalStyle ascii;
  ascii.unicode = false;
  const std::string text = terminal_summary(report, ascii);
  // 56 of 180 tested is 5 of 16 cells.
  EXPECT_NE(text.find("extension         56 deg       60        -4 X  #####..........."),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("flexion          90+ deg       90         0    met; not tested further"),
            std::string::npos)
      << text;
}

TEST(Terminal, SetsTheProposedRigAgainstEachReferenceInARow) {
  Report report = sample_report();
  std::string text = terminal_summary(report);
  EXPECT_NE(text.find("  curve, pose by pose against  human, chest\n"
                      "  isner          better 18   worse 9    mixed 9    over a limit 18 : 27   "
                      "ahead\n"),
            std::string::npos)
      << text;
  // One alone is told in full, with its worst poses and its map.
  report.comparisons.resize(1);
  text = terminal_summary(report);
  EXPECT_NE(text.find("curve against isner"), std::string::npos);
  EXPECT_NE(text.find("against isner BB010"), std::string::npos) << text;
  EXPECT_NE(text.find("side   twist -45"), std::string::npos) << text;
}

TEST(Terminal, SaysWhenACanaryDidNotDoItsDuty) {
  Report report = sample_report();
  report.canaries[0].found = false;
  report.canaries[1].twin_clean = false;
  TerminalStyle wide;
  wide.width = 120;
  const std::string text = terminal_summary(report, wide);
  EXPECT_NE(text.find("isner_chest: BB001 NOT detected, expected at 114.3 deg"), std::string::npos);
  EXPECT_NE(text.find("its repaired twin is not clean"), std::string::npos);
}

}  // namespace
}  // namespace backbend::validate
