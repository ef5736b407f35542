#include "skin/character/printable.h"

#include <gtest/gtest.h>

#include <limits>

namespace backbend::skin {
namespace {

TEST(Printable, KeepsWellFormedTextAndMarksEverythingElse) {
  const struct {
    std::string in, out;
  } cases[] = {
      {"hips_01.L ~!", "hips_01.L ~!"},
      {"a\tb\x1f\x7f\n", "a?b???"},
      {"\xc2\x9b[2J", "?[2J"},                     // an escape sequence's other spelling
      {"\xc2\x80\xc2\x9f\xc2\xa0", "??\xc2\xa0"},  // U+00A0 is the first that is none
      {"\xc3\x85ngstr\xc3\xb6m", "\xc3\x85ngstr\xc3\xb6m"},
      {"\xe8\x83\x8c", "\xe8\x83\x8c"},            // three bytes
      {"\xf0\x9f\xa6\xb4!", "\xf0\x9f\xa6\xb4!"},  // four
      {"\xc1\xbf\xc0\x80", "????"},                // overlong
      {"\xf5\x80\x80\x80", "????"},                // beyond Unicode
      {"\x80\xbf", "??"},                          // continuations of nothing
      {"\xe8\x83", "??"},                          // cut short
      {"\xe8\x83x", "??x"},
      {"\xf0\x9f\xa6", "???"},
      {"\xdf\xbf\xe0\xa0\x80\xef\xbf\xbd\xf4\x8f\xbf\xbf",
       "\xdf\xbf\xe0\xa0\x80\xef\xbf\xbd\xf4\x8f\xbf\xbf"},  // the ends of each length's range
      {"", ""},
  };
  for (const auto& c : cases) {
    EXPECT_EQ(printable(c.in), c.out);
    EXPECT_EQ(in_quotes(c.in), "'" + c.out + "'");
  }
}

TEST(Printable, CutsAfterEightyBytesBetweenCharacters) {
  EXPECT_EQ(printable(std::string(80, 'x')), std::string(80, 'x'));
  EXPECT_EQ(printable(std::string(81, 'x')), std::string(80, 'x') + "...");
  EXPECT_EQ(printable(std::string(79, 'x') + "\xc3\xb6y"), std::string(79, 'x') + "\xc3\xb6...");
}

TEST(Printable, ListsEightAndCountsTheRest) {
  EXPECT_EQ(list_in_quotes({}), "none");
  EXPECT_EQ(list_in_quotes({"a"}), "'a'");
  EXPECT_EQ(list_in_quotes({"1", "2", "3", "4", "5", "6", "7", "8"}),
            "'1', '2', '3', '4', '5', '6', '7', '8'");
  EXPECT_EQ(list_in_quotes({"1", "2", "3", "4", "5", "6", "7", "8", "9", "10"}),
            "'1', '2', '3', '4', '5', '6', '7', '8' and 2 more");
}

TEST(Printable, WritesNumbersForPeople) {
  EXPECT_EQ(count_text(0), "0");
  EXPECT_EQ(count_text(999), "999");
  EXPECT_EQ(count_text(1000), "1 000");
  EXPECT_EQ(count_text(13380), "13 380");
  EXPECT_EQ(count_text(1234567), "1 234 567");
  EXPECT_EQ(plural(0, "place"), "0 places");
  EXPECT_EQ(plural(1, "vertex", "vertices"), "1 vertex");
  EXPECT_EQ(plural(13380, "vertex", "vertices"), "13 380 vertices");
  EXPECT_EQ(number_text(0.25), "0.25");
  EXPECT_EQ(number_text(1234.56), "1235");
  EXPECT_EQ(number_text(1234.56, 6), "1234.56");
  EXPECT_EQ(number_text(-1e-7, 2), "-1e-07");
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(number_text(kInfinity), "inf");
  EXPECT_EQ(number_text(-kInfinity), "-inf");
  EXPECT_EQ(number_text(std::numeric_limits<double>::quiet_NaN()), "NaN");
}

}  // namespace
}  // namespace backbend::skin
