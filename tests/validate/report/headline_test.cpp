// headline.png: the card that a chat or a mail shows of a run.
#include <gtest/gtest.h>

#include "render/image/png.h"
#include "tests/validate/report_sample.h"
#include "validate/report/headline_picture.h"

namespace backbend::validate {
namespace {

using render::Color8;
using render::Picture;

/// How many pixels have a colour, in the columns from `x` on.
int count_of(const Picture& card, Color8 color, int x = 0) {
  int count = 0;
  for (int row = 0; row < card.height; ++row)
    for (int column = x; column < card.width; ++column)
      count += std::equal(color.begin(), color.end(), card.at(column, row));
  return count;
}

Picture card_of(const Report& report, const PictureBytes& bytes = {}) {
  return render::decode_png(headline_png(report, bytes));
}

constexpr Color8 kFrame{1, 200, 250, 255};

/// A finding's frame of one colour, whatever it is asked for.
std::optional<std::vector<std::uint8_t>> one_colour(const std::string&) {
  return render::encode_png(Picture(640, 360, kFrame));
}

TEST(HeadlinePicture, ItsEdgeHasTheVerdictsColour) {
  Report report = sample_report();
  std::vector<Color8> edge;
  for (const Verdict verdict : {Verdict::pass, Verdict::fail, Verdict::not_measured}) {
    report.verdict = verdict;
    const Picture card = card_of(report);
    ASSERT_EQ(card.width, 1200);
    ASSERT_EQ(card.height, 630);
    const std::uint8_t* p = card.at(4, 315);
    edge.push_back({p[0], p[1], p[2], p[3]});
    // Besides the edge the verdict's word has it.
    EXPECT_GT(count_of(card, edge.back(), 20), 500);
  }
  EXPECT_NE(edge[0], edge[1]);
  EXPECT_NE(edge[1], edge[2]);
  EXPECT_NE(edge[0], edge[2]);
}

TEST(HeadlinePicture, ShowsTheFrameOfTheWorstFindingThatHasOne) {
  const Report report = sample_report();
  const Picture with = card_of(report, one_colour), without = card_of(report);
  EXPECT_EQ(count_of(without, kFrame), 0);
  EXPECT_EQ(count_of(with, kFrame), 480 * 270) << "640 x 360 at the width of its place";
  // What is no picture is left out, as what is missing.
  const auto broken = [](const std::string&) {
    return std::optional<std::vector<std::uint8_t>>({1, 2, 3});
  };
  EXPECT_EQ(headline_png(report, broken), headline_png(report, {}));
}

TEST(HeadlinePicture, IsAFunctionOfTheReport) {
  EXPECT_EQ(headline_png(sample_report(), one_colour), headline_png(sample_report(), one_colour));
  Report other = sample_report();
  other.title = "another";
  EXPECT_NE(headline_png(other, one_colour), headline_png(sample_report(), one_colour));
}

TEST(HeadlinePicture, ABarMayBeEmptyOrFull) {
  Report report = sample_report();
  std::vector<int> green;
  for (const double clean : {0.0, 30.0, 200.0}) {
    for (RigResult& rig : report.rigs) {
      rig.headroom.resize(1);
      rig.headroom[0].measured = true;
      rig.headroom[0].clean_to_deg = clean;
      rig.headroom[0].needs_deg = 0.0;
    }
    report.verdict = Verdict::pass;  // whose colour an ample bar has
    green.push_back(count_of(card_of(report), {72, 178, 120, 255}, 20));
  }
  EXPECT_LT(green[0], green[1]);
  EXPECT_EQ(green[1], green[2]) << "30 of 0 and 200 of 0 are both all there is to show";
}

TEST(HeadlinePicture, HoldsAnyNameAndAnEmptyReport) {
  const Report long_names = sample_report_named(std::string(5000, 'W') + "\n\x1b[31m\xff");
  EXPECT_EQ(card_of(long_names, one_colour).width, 1200);
  EXPECT_EQ(count_of(card_of(long_names, one_colour), kFrame), 480 * 270)
      << "words stop where the picture begins";
  EXPECT_EQ(card_of(Report{}).height, 630);
}

}  // namespace
}  // namespace backbend::validate
