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

}  // namespace
}  // namespace backbend::render
