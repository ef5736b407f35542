#include "render/image/half_layers.h"

#include <gtest/gtest.h>

#include "render/image/exr.h"

namespace backbend::render {
namespace {

TEST(RoundHalfLayers, GivesWhatTheFileHolds) {
  Frame frame;
  frame.width = 4;
  frame.height = 2;
  Layer color{{"R", "G", "B", "A"}, true, {}}, depth{{"Z"}, false, {}};
  for (int i = 0; i < 32; ++i) color.data.push_back(0.1f + 0.0137f * static_cast<float>(i * i));
  for (int i = 0; i < 8; ++i) depth.data.push_back(1.0f / 3.0f + static_cast<float>(i));
  frame.layers = {color, depth};
  round_half_layers(frame);
  const Frame back = decode_exr(encode_exr(frame));
  EXPECT_EQ(back.find("R")->data, frame.find("R")->data);
  EXPECT_NE(frame.find("R")->data, color.data) << "nothing was rounded";
  EXPECT_EQ(frame.find("Z")->data, depth.data) << "a float layer was rounded";
}

TEST(RoundHalfLayers, AsTheFileIsWrittenForTiesAndForTheSmallestAndLargest) {
  Frame frame;
  frame.width = 5;
  frame.height = 1;
  Layer color{{"R", "G", "B", "A"}, true, {}};
  for (const float value :
       {0.0f,       1.0f,         1.0f + 0x1p-11f, 1.0f + 0x3p-11f, 1.0f + 0x1.000002p-11f,
        65504.0f,   65519.0f,     0x1p-14f,        0x1p-24f,        0x1p-25f,
        0x1.8p-25f, 0x1p-130f,    1e-3f,           12345.678f,      0.3f,
        2047.5f,    0x1.ffcp-15f, 0x1.ffdp-15f,    0x1.ffep-15f,    3.0f})
    color.data.push_back(value);
  frame.layers = {color};
  const Frame back = decode_exr(encode_exr(frame));
  round_half_layers(frame);
  EXPECT_EQ(back.find("R")->data, frame.find("R")->data);
}

}  // namespace
}  // namespace backbend::render
