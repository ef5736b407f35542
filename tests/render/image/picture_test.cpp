#include "render/image/picture.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include "render/image/png.h"
#include "render/image/text.h"
#include "render/review/sheet.h"
#include "tests/temporary_folder.h"

namespace backbend::render {
namespace {

Picture gradient(int width, int height, bool opaque) {
  Picture picture(width, height, {0, 0, 0, 255});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      std::uint8_t* p = picture.at(x, y);
      p[0] = static_cast<std::uint8_t>(x * 7), p[1] = static_cast<std::uint8_t>(y * 11);
      p[2] = static_cast<std::uint8_t>(x + y),
      p[3] = opaque ? 255 : static_cast<std::uint8_t>(x * 3);
    }
  return picture;
}

TEST(Png, ReadsBackWhatItWrote) {
  for (const bool opaque : {true, false}) {
    const Picture picture = gradient(33, 17, opaque);
    const Picture read = decode_png(encode_png(picture));
    ASSERT_EQ(read.width, 33);
    ASSERT_EQ(read.height, 17);
    EXPECT_EQ(read.rgba, picture.rgba) << (opaque ? "RGB" : "RGBA");
  }
}

TEST(Png, HoldsNoClockAndNoText) {
  const auto bytes = encode_png(gradient(8, 8, true));
  const std::string text(bytes.begin(), bytes.end());
  for (const char* chunk : {"tIME", "tEXt", "iTXt", "zTXt", "pHYs"})
    EXPECT_EQ(text.find(chunk), std::string::npos) << chunk;
  EXPECT_NE(text.find("IEND"), std::string::npos);
}

TEST(Png, RefusesBytesThatAreNoPicture) {
  EXPECT_THROW(decode_png({}), RenderError);
  auto bytes = encode_png(gradient(64, 64, true));
  bytes.resize(bytes.size() / 3);
  EXPECT_THROW(decode_png(bytes), RenderError);
  EXPECT_THROW(encode_png(Picture{}), RenderError);
}

TEST(Png, ReadsTheOtherFormatsThatCharactersAndEnvironmentsComeIn) {
  const Picture picture(16, 8, {200, 100, 50, 255});
  const TemporaryFolder folder;
  for (const char* ending : {"png", "jpg", "tif", "bmp", "tga", "webp", "hdr", "exr"}) {
    const std::string name = folder / (std::string("picture.") + ending);
    const auto out = OIIO::ImageOutput::create(name);
    ASSERT_TRUE(out) << ending;
    ASSERT_TRUE(out->open(name, OIIO::ImageSpec(16, 8, 3, OIIO::TypeDesc::UINT8))) << ending;
    ASSERT_TRUE(out->write_image(OIIO::TypeDesc::UINT8, picture.rgba.data(), 4)) << ending;
    ASSERT_TRUE(out->close());
    std::ifstream in(name, std::ios::binary);
    const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(in), {}};
    const Texture texture = decode_texture(bytes, Encoding::data);
    ASSERT_EQ(texture.texel.size(), 16u * 8) << ending;
    EXPECT_NEAR(texture.texel[20].x, 200 / 255.0, 0.02) << ending;
    EXPECT_NEAR(texture.texel[20].z, 50 / 255.0, 0.03) << ending;
  }
}

TEST(Png, LooksForNoFileInTheWorkingFolder) {
  namespace fs = std::filesystem;
  const fs::path before = fs::current_path();
  const TemporaryFolder folder;
  const auto png = encode_png(gradient(4, 4, true));
  for (const char* ending : {"png", "jpg", "hdr", "exr", "webp", "dds", "bmp", "tif", "tga"})
    std::ofstream(folder / (std::string("memory.") + ending)) << "a file of the user's";
  fs::current_path(folder.path());
  const int opened = ::inotify_init1(IN_NONBLOCK);
  ASSERT_GE(::inotify_add_watch(opened, folder.path().c_str(), IN_OPEN), 0);
  for (const std::string magic :
       {"", "\x89PNG", "\xff\xd8", "#?", "RIFF", "DDS ", "BM", "II", "\x76\x2f\x31\x01"}) {
    std::vector<std::uint8_t> bytes(magic.begin(), magic.end());
    bytes.resize(200, 7);
    EXPECT_THROW(decode_png(bytes), RenderError) << magic;
  }
  EXPECT_NO_THROW(decode_png(png));
  std::array<char, 4096> events;
  EXPECT_EQ(::read(opened, events.data(), events.size()), -1) << "a file there was opened";
  ::close(opened);
  fs::current_path(before);
}

TEST(Png, RefusesAPictureOfMorePixelsThanItsBytesCanHold) {
  // 16000 x 16000 RGBA in 45 bytes: a gigabyte of pixels, four of them as numbers.
  const std::vector<std::uint8_t> bomb{
      0x89, 'P',  'N', 'G', '\r', '\n', 0x1A, '\n',                                // signature
      0,    0,    0,   13,  'I',  'H',  'D',  'R',  0,    0,    0x3E, 0x80, 0, 0,  // header
      0x3E, 0x80, 8,   6,   0,    0,    0,    0x41, 0x7E, 0xDF, 0xDE,         // and its checksum
      0,    0,    0,   0,   'I',  'D',  'A',  'T',  0x35, 0xAF, 0x06, 0x1E};  // no pixels
  for (const bool as_texture : {true, false}) {
    try {
      as_texture ? (void)decode_texture(bomb, Encoding::srgb) : (void)decode_png(bomb);
      FAIL() << "not refused";
    } catch (const RenderError& error) {
      EXPECT_NE(std::string(error.what()).find("few bytes"), std::string::npos) << error.what();
    }
  }
}

TEST(Png, BecomesALinearTextureUnlessItHoldsData) {
  const auto bytes = encode_png(Picture(1, 1, {188, 255, 0, 255}));
  const Texture color = decode_texture(bytes, Encoding::srgb);
  EXPECT_NEAR(color.texel[0].x, 0.5029f, 1e-4f);  // sRGB 188 is 50.29 % light
  EXPECT_EQ(color.texel[0].y, 1.0f);
  EXPECT_NEAR(decode_texture(bytes, Encoding::data).texel[0].x, 188.0f / 255.0f, 1e-6f);
}

TEST(Picture, TakesLinearLightThroughTheSrgbCurveAndBack) {
  for (int code = 0; code < 256; ++code) {
    const float linear = linear_from_srgb(static_cast<float>(code) / 255.0f);
    EXPECT_NEAR(srgb_from_linear(linear) * 255.0f, static_cast<float>(code), 1e-3f);
  }
  EXPECT_NEAR(srgb_from_linear(0.18f), 0.4614f, 1e-4f);
  EXPECT_EQ(srgb_from_linear(std::nanf("")), 0.0f);
  EXPECT_EQ(srgb_from_linear(7.0f), 1.0f);
}

TEST(Picture, DividesAssociatedAlphaOut) {
  Frame frame;
  frame.width = frame.height = 1;
  frame.layers = {{{"R", "G", "B", "A"}, true, {0.09f, 0.09f, 0.09f, 0.5f}}};
  const Picture picture = picture_from(frame);
  EXPECT_EQ(picture.rgba,
            (std::vector<std::uint8_t>{118, 118, 118, 128}));  // 18 % grey, half there
  frame.layers.clear();
  EXPECT_THROW(picture_from(frame), RenderError);
}

TEST(Picture, ShowsNothingWhereAFileHoldsNoNumbers) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinite = std::numeric_limits<float>::infinity();
  Frame frame;
  frame.width = 2;
  frame.height = 1;
  frame.layers = {{{"R", "G", "B", "A"}, false, {0, 1, 1, nan, nan, infinite, -infinite, 1e-40f}}};
  EXPECT_EQ(picture_from(frame).rgba, (std::vector<std::uint8_t>{0, 255, 255, 0, 0, 255, 0, 0}));
}

TEST(Picture, BlendsAndClipsWhatIsPutOnIt) {
  Picture picture(4, 4, {100, 100, 100, 255});
  blit(picture, Picture(3, 3, {200, 0, 0, 255}), 2, -1);
  EXPECT_EQ(picture.at(3, 1)[0], 200);
  EXPECT_EQ(picture.at(3, 2)[0], 100);
  EXPECT_EQ(picture.at(1, 0)[0], 100);
  blit(picture, Picture(1, 1, {200, 200, 200, 128}), 0, 0);
  EXPECT_NEAR(picture.at(0, 0)[0], 150, 1);
}

TEST(Picture, ShrinksToTheMeanOfTheLight) {
  Picture checker(2, 2, {0, 0, 0, 255});
  for (int c = 0; c < 3; ++c) checker.at(0, 0)[c] = checker.at(1, 1)[c] = 255;
  const Picture one = shrink(checker, 1, 1);
  EXPECT_EQ(one.at(0, 0)[0], 188);  // half the light, not half the code
  EXPECT_EQ(shrink(checker, 10, 10).width, 2) << "never enlarged";
  EXPECT_EQ(shrink(Picture(100, 50, {1, 2, 3, 255}), 20, 20).height, 10);
}

TEST(Text, LeavesInkOnItsLineOnly) {
  Picture picture(120, 60, {255, 255, 255, 255});
  draw_text(picture, 10, 20, "Wjgl", 18, {0, 0, 0, 255});
  int inside = 0, outside = 0;
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 120; ++x)
      if (picture.at(x, y)[0] < 128)
        (y >= 20 && y < 20 + line_height(18) && x >= 8 ? inside : outside) += 1;
  EXPECT_GT(inside, 60);
  EXPECT_EQ(outside, 0);
}

TEST(Text, CutsWhatIsTooLongAndSurvivesHostileNames) {
  EXPECT_EQ(fit_text("spine", 12, 200), "spine");
  const std::string cut = fit_text("a very long name of a joint in a rig", 12, 100);
  EXPECT_LE(text_width(cut, 12), 100);
  EXPECT_EQ(cut.substr(cut.size() - 3), "...");
  EXPECT_EQ(fit_text("a\x1b[31mb\n\xff\xc3", 12, 500), "a[31mb??");
  EXPECT_EQ(fit_text("M\xc3\xa4"
                     "dchen 5\xc2\xb0",
                     12, 500),
            "Madchen 5 deg");
  Picture picture(20, 20, {255, 255, 255, 255});
  draw_text(picture, -500, 5, "off the picture", 12, {0, 0, 0, 255});
  draw_text(picture, 5, 900, "off the picture", 12, {0, 0, 0, 255});
}

TEST(Sheet, KeepsEveryPictureWhole) {
  const Picture red(40, 30, {200, 0, 0, 255}), green(20, 30, {0, 200, 0, 255});
  const std::vector<SheetCell> cells{{red, "one", false}, {green, "two", true}, {red, "", false}};
  const Picture sheet = contact_sheet(cells, 2, "title");
  int reds = 0, greens = 0;
  for (int y = 0; y < sheet.height; ++y)
    for (int x = 0; x < sheet.width; ++x) {
      reds += std::memcmp(sheet.at(x, y), red.at(0, 0), 4) == 0;
      greens += std::memcmp(sheet.at(x, y), green.at(0, 0), 4) == 0;
    }
  EXPECT_EQ(reds, 2 * 40 * 30);
  EXPECT_EQ(greens, 20 * 30);
  EXPECT_THROW(contact_sheet({}, 2, ""), RenderError);
  EXPECT_THROW(contact_sheet(cells, 0, ""), RenderError);
}

TEST(Sheet, PutsBothSidesOfAComparisonAtOneScale) {
  const Picture both = side_by_side(Picture(50, 40, {9, 9, 9, 255}), "curve",
                                    Picture(50, 40, {99, 99, 99, 255}), "isner");
  EXPECT_EQ(both.height, 40);
  EXPECT_EQ(both.at(0, 39)[0], 9);
  EXPECT_EQ(both.at(both.width - 1, 39)[0], 99);
}

TEST(Sheet, BurnsInAlongTheLowerEdgeOnly) {
  Picture picture(200, 100, {255, 255, 255, 255});
  burn_in(picture, "even", "extension 97",
          "kink 2.1 deg of a very long name that does not fit at all");
  EXPECT_EQ(picture.at(100, 50)[0], 255);
  EXPECT_LT(picture.at(1, 98)[0], 128);
  Picture tiny(8, 8, {255, 255, 255, 255});
  burn_in(tiny, "even", "extension 97", "kink");
  draw_legend(tiny, 0, 1, "mm");
}

TEST(Sheet, ALegendLeavesTheBurntInStripFree) {
  Picture picture(300, 200, {255, 255, 255, 255});
  const int strip = burn_in(picture, "even", "extension 97", "kink");
  const Picture before = picture;
  draw_legend(picture, 0, 1, "mm", strip);
  for (int y = picture.height - strip; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) ASSERT_EQ(picture.at(x, y)[0], before.at(x, y)[0]);
  EXPECT_LT(picture.at(1, picture.height - strip - 1)[0], 128);
  EXPECT_EQ(picture.at(1, 20)[0], 255);
}

}  // namespace
}  // namespace backbend::render
