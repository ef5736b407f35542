#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "render/image/video.h"
#include "render/trace/cameras.h"
#include "render/trace/contour.h"
#include "render/trace/scene.h"
#include "tests/render/mesh_fixture.h"

namespace backbend::render {
namespace {

Camera along_z(double distance) {
  Camera camera;
  camera.eye = {0, 0, distance};
  camera.target = {0, 0, 0};
  return camera;
}

float red(const Frame& frame, int x, int y) {
  return frame.find("R")->data[(static_cast<std::size_t>(y) * frame.width + x) * 4];
}

Frame shoot(const TestMesh& mesh, const PoseGeometry& pose, Mode mode, int samples = 4) {
  Scene scene(mesh.topology);
  scene.set_pose(pose);
  Settings settings;
  settings.width = settings.height = 100;
  settings.mode = mode;
  settings.samples = samples;
  return scene.render(along_z(2.0), settings);
}

TEST(Contour, OutlinesASquareAndLeavesItsDiagonalAlone) {
  const TestMesh mesh = square(0.72f);
  const Frame frame = shoot(mesh, mesh.pose(), Mode::contour);
  for (const int along : {30, 50, 70}) {
    EXPECT_LT(std::min(red(frame, along, 24), red(frame, along, 25)), 0.5f) << "upper edge";
    EXPECT_LT(std::min(red(frame, 74, along), red(frame, 75, along)), 0.5f) << "right edge";
    EXPECT_GT(red(frame, along, along), 0.7f) << "both triangles are one face";
  }
  EXPECT_GT(red(frame, 10, 10), 0.7f);
}

TEST(Contour, TakesASlantedPlaneForOneSurface) {
  // Depth of a plane seen at a slant: its inverse is linear along x.
  ContourInput in{64, 4, {}, {}, {}};
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 64; ++x) {
      in.depth.push_back(1.0f / (0.1f + 0.01f * static_cast<float>(x)));
      in.normal.emplace_back(0.7f, 0.0f, 0.714f);
      in.region.push_back(1.0f);
    }
  }
  for (const float ink : find_contours(in)) EXPECT_EQ(ink, 0.0f);
  for (int y = 0; y < 4; ++y)
    for (int x = 32; x < 64; ++x) in.depth[y * 64 + x] *= 1.2f;
  EXPECT_EQ(find_contours(in)[64 + 31], 1.0f);
}

TEST(Wireframe, DrawsEdgesAndNotTheInsideOfTriangles) {
  const TestMesh mesh = square(0.72f);
  const Frame frame = shoot(mesh, mesh.pose(), Mode::wireframe, 16);
  // The square's diagonal runs from the lower left to the upper right corner.
  EXPECT_LT(red(frame, 50, 49), 0.5f * std::min(red(frame, 35, 35), red(frame, 65, 65)));
}

TEST(Xray, ShowsBonesInsideTheBodyAndThinnerWhereLessSkinIsCrossed) {
  const TestMesh mesh = square(0.72f);
  const std::vector<OverlayLine> bone{{{-0.2f, 0, -1}, {0.2f, 0, -1}, {1, 0, 0}, 3.0f}};
  PoseGeometry pose = mesh.pose();
  const Frame clean = shoot(mesh, pose, Mode::xray);
  pose.overlay = bone;
  const Frame with_bone = shoot(mesh, pose, Mode::xray);
  EXPECT_LT(red(clean, 50, 50), 0.2f);
  EXPECT_GT(red(with_bone, 50, 50), 0.9f) << "behind the skin, and seen";
  EXPECT_EQ(red(with_bone, 50, 60), red(clean, 50, 60));
  EXPECT_GT(red(clean, 50, 50), red(clean, 5, 5)) << "skin over background";
}

TEST(Xray, CutsLinesOffAtTheCamera) {
  const TestMesh mesh = square(0.72f);
  const std::vector<OverlayLine> through{{{0, -0.1f, -1}, {0, -0.1f, 30}, {1, 0, 0}, 3.0f},
                                         {{0.1f, 0, 9}, {0.1f, 0, 30}, {1, 0, 0}, 3.0f}};
  PoseGeometry pose = mesh.pose();
  pose.overlay = through;
  const Frame frame = shoot(mesh, pose, Mode::xray);
  for (const float value : frame.find("R")->data) ASSERT_TRUE(std::isfinite(value));
  EXPECT_GT(red(frame, 50, 99), 0.9f) << "runs out of the frame below the camera";
  EXPECT_LT(red(frame, 57, 10), 0.2f) << "a line behind the camera is not seen";
}

TEST(Ambient, DarkensACreaseAndNotTheOpen) {
  TestMesh mesh = torus(1.0f, 0.4f, 32);
  Scene scene(mesh.topology);
  scene.set_pose(mesh.pose());
  Settings settings;
  settings.width = settings.height = 64;
  settings.samples = 64;
  settings.mode = Mode::ao;
  Camera above = along_z(1.0);
  above.eye = {0, 6, 0.01};
  const Frame frame = scene.render(above, settings);
  // Seen from above: the ring's middle line is open, the flank towards the hole is not.
  const double scale = 64.0 / (2.0 * (6.0 - 0.4) * 18.0 / 50.0);
  EXPECT_GT(red(frame, 32 + static_cast<int>(1.0 * scale), 32),
            red(frame, 32 + static_cast<int>(0.68 * scale), 32) + 0.1f);
}

TEST(Ground, CatchesAShadowNextToTheFigureAndNoneFarAway) {
  const TestMesh mesh = sphere({0, 1, 0}, 1.0f, 24);
  Scene scene(mesh.topology);
  scene.set_pose(mesh.pose());
  Settings settings;
  settings.width = settings.height = 64;
  settings.samples = 32;
  Camera above;
  above.eye = {0, 12, 0.01};
  above.target = {0, 0, 0};
  const Frame with = scene.render(above, settings);
  settings.ground = false;
  const Frame without = scene.render(above, settings);
  double darkest = 1.0;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      const double matte =
          with.find("CryptoAsset00.r")->data[(static_cast<std::size_t>(y) * 64 + x) * 4 + 1];
      if (matte == 0.0) darkest = std::min(darkest, double(red(with, x, y) / red(without, x, y)));
    }
  EXPECT_LT(darkest, 0.75);
  EXPECT_NEAR(red(with, 0, 0) / red(without, 0, 0), 1.0, 0.15);
}

TEST(Ground, LeavesOnlyTheShadowInATransparentFrame) {
  const TestMesh mesh = sphere({0, 1, 0}, 1.0f, 24);
  Scene scene(mesh.topology);
  scene.set_pose(mesh.pose());
  Settings settings;
  settings.width = settings.height = 64;
  settings.samples = 16;
  settings.transparent = true;
  Camera above;
  above.eye = {0, 12, 0.01};
  above.target = {0, 0, 0};
  const Frame frame = scene.render(above, settings);
  float most = 0.0f;
  for (std::size_t p = 0; p < 64 * 64; ++p) {
    const float* beauty = frame.find("R")->data.data() + p * 4;
    const float matte = frame.find("CryptoAsset00.r")->data[p * 4 + 1];
    ASSERT_GE(beauty[3], matte - 1e-6f);
    ASSERT_LE(beauty[3], 1.0f + 1e-6f);
    if (matte > 0.0f) continue;
    EXPECT_EQ(beauty[0], 0.0f) << "a shadow has no light of its own";
    most = std::max(most, beauty[3]);
  }
  EXPECT_GT(most, 0.2f);
}

TEST(Video, IsTaggedSoThatItLooksLikeThePng) {
  const auto command = video_command(640, 361, 24.0, "-odd name.mp4");
  const auto has = [&](std::string_view option, std::string_view value) {
    const auto at = std::find(command.begin(), command.end(), option);
    return at != command.end() && at + 1 != command.end() && *(at + 1) == value;
  };
  EXPECT_EQ(command.front(), "ffmpeg");
  EXPECT_EQ(command.back(), "file:-odd name.mp4") << "a name that starts with a dash is no option";
  EXPECT_TRUE(has("-video_size", "640x361"));
  EXPECT_TRUE(has("-framerate", "24/1"));
  EXPECT_TRUE(has("-pix_fmt", "yuv420p"));
  EXPECT_TRUE(has("-colorspace", "bt709"));
  EXPECT_TRUE(has("-color_trc", "iec61966-2-1"));
  EXPECT_TRUE(has("-movflags", "+faststart"));
  EXPECT_THROW(video_command(0, 4, 24.0, "x.mp4"), RenderError);
  EXPECT_THROW(video_command(4, 4, 0.0, "x.mp4"), RenderError);
}

TEST(Video, KnowsTheTelevisionRates) {
  EXPECT_EQ(frame_rate_fraction(25.0), "25/1");
  EXPECT_EQ(frame_rate_fraction(23.976), "24000/1001");
  EXPECT_EQ(frame_rate_fraction(29.97), "30000/1001");
  EXPECT_EQ(frame_rate_fraction(12.5), "12500/1000");
  EXPECT_THROW(frame_rate_fraction(std::nan("")), RenderError);
}

}  // namespace
}  // namespace backbend::render
