#include "render/image/exr.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "render/trace/cameras.h"
#include "tests/render/mesh_fixture.h"

namespace backbend::render {
namespace {

Frame rendered() {
  const TestMesh mesh = torus(1.0f, 0.4f, 16);
  Scene scene(mesh.topology);
  scene.set_pose(mesh.pose());
  Settings settings;
  settings.width = 37;  // neither a multiple of a tile nor of a ZIP block
  settings.height = 21;
  settings.samples = 2;
  settings.all_layers = true;
  return scene.render(view_camera("front", bounds_of(mesh.position), {}, 37.0 / 21.0), settings);
}

// The nearest half to a float: 11 significant bits.
float as_half(float value) {
  if (value == 0.0f) return 0.0f;
  const int exponent = std::max(std::ilogb(value), -14);
  const float unit = std::ldexp(1.0f, exponent - 10);
  return std::nearbyint(value / unit) * unit;
}

TEST(Exr, ReadsBackWhatItWrote) {
  const Frame frame = rendered();
  const Frame read = decode_exr(encode_exr(frame));
  ASSERT_EQ(read.width, 37);
  ASSERT_EQ(read.height, 21);
  ASSERT_EQ(read.layers.size(), frame.layers.size());
  for (const Layer& layer : frame.layers) {
    const Layer* same = read.find(layer.names[0]);
    ASSERT_NE(same, nullptr) << layer.names[0];
    EXPECT_EQ(same->names, layer.names);
    EXPECT_EQ(same->half, layer.half);
    ASSERT_EQ(same->data.size(), layer.data.size());
    for (std::size_t i = 0; i < layer.data.size(); ++i)
      ASSERT_EQ(same->data[i], layer.half ? as_half(layer.data[i]) : layer.data[i])
          << layer.names[0] << " value " << i;
  }
  EXPECT_EQ(read.attributes.size(), frame.attributes.size());
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      EXPECT_FLOAT_EQ(read.camera_from_world[i][j], frame.camera_from_world[i][j]);
      EXPECT_FLOAT_EQ(read.ndc_from_world[i][j], frame.ndc_from_world[i][j]);
    }
  }
}

TEST(Exr, HoldsTheSameInOnePartAndInMany) {
  const Frame frame = rendered();
  const auto many = encode_exr(frame, ExrParts::by_layer);
  EXPECT_NE(many, encode_exr(frame));
  const Frame from_one = decode_exr(encode_exr(frame)), from_many = decode_exr(many);
  ASSERT_EQ(from_many.layers.size(), from_one.layers.size());
  for (const Layer& layer : from_one.layers) {
    const Layer* same = from_many.find(layer.names.front());
    ASSERT_NE(same, nullptr) << layer.names.front();
    EXPECT_EQ(same->names, layer.names);
    EXPECT_EQ(same->data, layer.data) << layer.names.front();
  }
  ASSERT_EQ(from_many.attributes.size(), from_one.attributes.size());
  for (std::size_t i = 0; i < from_one.attributes.size(); ++i) {
    EXPECT_EQ(from_many.attributes[i].name, from_one.attributes[i].name);
    EXPECT_EQ(from_many.attributes[i].value, from_one.attributes[i].value);
  }
}

TEST(Exr, GivesTheSameBytesForTheSameFrame) {
  EXPECT_EQ(encode_exr(rendered()), encode_exr(rendered()));
}

TEST(Exr, KeepsTheFrameRateAsAFraction) {
  Frame frame = rendered();
  for (Attribute& a : frame.attributes)
    if (a.name == "framesPerSecond") a.value = "24000/1001";
  const Frame read = decode_exr(encode_exr(frame));
  bool found = false;
  for (const Attribute& a : read.attributes)
    found = found || (a.name == "framesPerSecond" && a.value == "24000/1001");
  EXPECT_TRUE(found);
  frame.attributes = {{"framesPerSecond", "24"}};
  EXPECT_THROW(encode_exr(frame), RenderError);
}

TEST(Exr, KeepsNanAndBrightValues) {
  Frame frame;
  frame.width = 2;
  frame.height = 1;
  frame.layers = {{{"R", "G", "B", "A"}, true, {1e9f, -1e9f, 0.5f, 1.0f, 0, 0, 0, 0}},
                  {{"heat"}, false, {std::numeric_limits<float>::quiet_NaN(), 1e20f}}};
  const Frame read = decode_exr(encode_exr(frame));
  EXPECT_EQ(read.find("R")->data[0], 65504.0f) << "the largest half, not an infinity";
  EXPECT_EQ(read.find("R")->data[1], -65504.0f);
  EXPECT_TRUE(std::isnan(read.find("heat")->data[0]));
  EXPECT_EQ(read.find("heat")->data[1], 1e20f);
}

TEST(Exr, RefusesFramesThatAreNone) {
  Frame frame;
  EXPECT_THROW(encode_exr(frame), RenderError);
  frame.width = frame.height = 2;
  EXPECT_THROW(encode_exr(frame), RenderError) << "no channels";
  frame.layers = {{{"Z"}, false, {1, 2, 3}}};
  EXPECT_THROW(encode_exr(frame), RenderError) << "three values for four pixels";
  frame.layers = {{{"Z"}, false, {1, 2, 3, 4}}, {{"Z"}, false, {1, 2, 3, 4}}};
  EXPECT_THROW(encode_exr(frame), RenderError) << "named twice";
}

TEST(Exr, RefusesBytesThatAreNoPicture) {
  EXPECT_THROW(decode_exr({}), RenderError);
  const std::vector<std::uint8_t> text(100, 'x');
  EXPECT_THROW(decode_exr(text), RenderError);
  std::vector<std::uint8_t> cut = encode_exr(rendered());
  cut.resize(cut.size() / 2);
  EXPECT_THROW(decode_exr(cut), RenderError);
}

/// What decode_exr() says of a written picture in which the bytes `offset` behind the first
/// occurrence of `text` are other ones.
std::string refusal_of(const std::string& text, std::size_t offset,
                       const std::vector<std::uint8_t>& other) {
  Frame frame;
  frame.width = frame.height = 4;
  frame.layers.push_back({{"R", "G", "B", "A"}, true, std::vector<float>(64, 0.5f)});
  std::vector<std::uint8_t> bytes = encode_exr(frame);
  bytes.resize(bytes.size() + 20000);  // room for a table of many lines
  const auto at = std::search(bytes.begin(), bytes.end(), text.begin(), text.end());
  if (at == bytes.end()) return "no such attribute";
  std::copy(other.begin(), other.end(), at + static_cast<std::ptrdiff_t>(text.size() + offset));
  try {
    decode_exr(bytes);
  } catch (const RenderError& error) {
    return error.what();
  }
  return "read";
}

TEST(Exr, MakesNoRoomForMoreThanTheFileCanHold) {
  // Behind an attribute's name and type stands its size: here 1.6 GB of a file of 20 kB.
  const std::string attribute("lineOrder\0lineOrder\0", 20);
  EXPECT_EQ(refusal_of(attribute, 0, {0x61, 0x62, 0x63, 0x61}),
            "exr: an attribute of 1633903201 bytes does not fit the file");
  // A data window from 0, 0 to 29999, 29999: behind the size, and the least corner.
  const std::string window("dataWindow\0box2i\0", 17);
  EXPECT_EQ(refusal_of(window, 4 + 8, {0x2F, 0x75, 0, 0, 0x2F, 0x75, 0, 0}),
            "exr: a picture of 30000 x 30000 does not fit a file of this size");
  EXPECT_EQ(refusal_of(window, 0, {}), "read");
}

TEST(Exr, RefusesAnAttributeThatEndsElsewhereThanItsSizeSays) {
  // The library reads these to their own end, and would take what follows for names and sizes.
  using namespace std::string_literals;
  EXPECT_EQ(refusal_of("channels\0chlist\0"s, 0, {0x48}),
            "exr: an attribute of the type 'chlist' does not have 72 bytes");
  EXPECT_EQ(refusal_of("dataWindow\0box2i\0"s, 0, {0x0C}),
            "exr: an attribute of the type 'box2i' does not have 12 bytes");
  // `lineOrder` made a list of texts, of floats and a picture.
  const auto made = [&](const std::string& type, std::vector<std::uint8_t> rest) {
    std::vector<std::uint8_t> bytes(type.begin(), type.end());
    bytes.push_back(0);
    bytes.insert(bytes.end(), rest.begin(), rest.end());
    return refusal_of("lineOrder\0"s, 0, bytes);
  };
  EXPECT_EQ(made("stringvector", {8, 0, 0, 0, 3, 0, 0, 0}),
            "exr: an attribute of the type 'stringvector' does not have 8 bytes");
  EXPECT_EQ(made("floatvector", {6, 0, 0, 0}),
            "exr: an attribute of the type 'floatvector' does not have 6 bytes");
  EXPECT_EQ(made("preview", {12, 0, 0, 0, 255, 255, 255, 255, 255, 255, 255, 255}),
            "exr: an attribute of the type 'preview' does not have 12 bytes");
}

}  // namespace
}  // namespace backbend::render
