#include "render/review/mark.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace backbend::render {
namespace {

constexpr Color8 kGrey = {120, 120, 120, 255};

TEST(Mark, IsARingThatLeavesTheMiddleFree) {
  Picture picture(64, 64, kGrey);
  draw_mark(picture, 32.0, 32.0, 16.0);
  EXPECT_EQ(picture.at(32, 32)[0], 120);
  EXPECT_GT(picture.at(48, 32)[0], 240) << "the ring is white";
  EXPECT_LT(picture.at(45, 32)[0], 60) << "with a dark line inside";
  EXPECT_LT(picture.at(50, 32)[0], 60) << "and outside";
  EXPECT_EQ(picture.at(60, 32)[0], 120);
}

TEST(Mark, IsCutAtThePicturesEdges) {
  Picture picture(40, 30, kGrey);
  draw_mark(picture, 0.0, 0.0, 12.0);
  draw_mark(picture, 39.5, 29.5, 12.0);
  EXPECT_GT(picture.at(12, 0)[0], 180);  // half a pixel off the ring's middle
  EXPECT_GT(picture.at(27, 29)[0], 180);
}

TEST(Mark, OfAPlaceThatIsNowhereDrawsNothing) {
  Picture picture(20, 20, kGrey);
  const Picture before = picture;
  draw_mark(picture, std::nan(""), 5.0, 4.0);
  draw_mark(picture, 5.0, 5.0, std::numeric_limits<double>::infinity());
  draw_mark(picture, 5.0, 5.0, 0.0);
  draw_mark(picture, -1e12, 5.0, 4.0);
  draw_mark(picture, 5.0, 1e300, 4.0);
  EXPECT_EQ(picture.rgba, before.rgba);
}

}  // namespace
}  // namespace backbend::render
