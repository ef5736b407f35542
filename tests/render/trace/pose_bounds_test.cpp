#include "render/trace/pose_bounds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>

#include "render/trace/cameras.h"
#include "render/trace/ray_device.h"
#include "tests/render/mesh_fixture.h"

namespace backbend::render {
namespace {

// Every ray that hits must be one that may meet; of those that miss, most are known to.
TEST(PoseBounds, NeverCallAHitAMiss) {
  const TestMesh mesh = bent(blob_figure(), 1.2f);
  const RayScene rays(mesh.topology->triangle, mesh.position);
  const PoseBounds bounds(mesh.topology->triangle, mesh.position, 1e-4f);
  const Bounds box = bounds_of(mesh.position);
  std::mt19937 rng(6);
  const auto around = [&](double reach) {
    glm::vec3 p;
    for (int axis = 0; axis < 3; ++axis) {
      const double unit = (rng() >> 8) * 0x1p-24 * (1.0 + 2.0 * reach) - reach;
      p[axis] = static_cast<float>(box.low[axis] + (box.high[axis] - box.low[axis]) * unit);
    }
    return p;
  };
  const auto batch = std::make_unique<RayBatch>();
  const auto hits = std::make_unique<HitBatch>();
  int hit = 0, missed = 0, known = 0;
  for (int round = 0; round < 30; ++round) {
    for (std::size_t i = 0; i < RayBatch::kCapacity; i += 8) {
      Vec8 from, to;
      for (unsigned lane = 0; lane < 8; ++lane)
        from.set_lane(lane, around(2.0)), to.set_lane(lane, around(0.5));
      // Some run along an axis, some end before they have gone far.
      if (i % 32 == 0) to.y = from.y;
      batch->set_packet(i, from, to - from, splat(i % 24 == 0 ? 0.5f : 1e30f));
    }
    rays.nearest(*batch, RayBatch::kCapacity, Coherence::scattered, *hits);
    for (std::size_t i = 0; i < RayBatch::kCapacity; i += 8) {
      const Int8 may = bounds.may_meet(batch->packet_origin(i), batch->packet_direction(i),
                                       load(&batch->far[i]));
      for (unsigned lane = 0; lane < 8; ++lane) {
        if (hits->triangle[i + lane] >= 0) {
          ++hit;
          ASSERT_NE(may[lane], 0) << i + lane;
        } else {
          ++missed;
          known += may[lane] == 0;
        }
      }
    }
  }
  EXPECT_GT(hit, 1000);
  EXPECT_GT(known, missed / 2);
}

TEST(PoseBounds, HoldThePoseOnTheFilm) {
  const TestMesh mesh = bent(blob_figure(), 1.2f);
  const PoseBounds bounds(mesh.topology->triangle, mesh.position, 0.0f);
  for (const char* view : {"profile", "front", "three_quarter"}) {
    const Projection camera =
        project_camera(view_camera(view, bounds_of(mesh.position), {}, 1.5), 96, 64);
    const auto rects = bounds.on_film(camera);
    EXPECT_LT(rects.size(), 17u);
    double least = 1e300, most = 0.0;
    for (const PoseBounds::Rect& r : rects)
      least = std::min(least, r.x1 - r.x0), most = std::max(most, r.x1 - r.x0);
    EXPECT_LT(least, 0.5 * most) << view;  // narrow where the figure is
    for (const glm::vec3& p : mesh.position) {
      const glm::dvec3 at = camera.project(p);
      EXPECT_TRUE(std::any_of(rects.begin(), rects.end(), [&](const PoseBounds::Rect& r) {
        return at.x >= r.x0 - 1e-3 && at.x <= r.x1 + 1e-3 && at.y >= r.y0 - 1e-3 &&
               at.y <= r.y1 + 1e-3;
      }));
    }
  }
}

TEST(PoseBounds, ClaimNothingForACameraInsideOfThePose) {
  const TestMesh mesh = sphere({0, 0, 0}, 1.0f, 16);
  const PoseBounds bounds(mesh.topology->triangle, mesh.position, 0.0f);
  Camera camera;
  camera.eye = {0, 0, 0.2};
  camera.target = {0, 0, -1};
  const auto rects = bounds.on_film(project_camera(camera, 64, 64));
  ASSERT_EQ(rects.size(), 1u);
  EXPECT_LT(rects[0].x0, -1e6);
  EXPECT_GT(rects[0].y1, 1e6);
}

}  // namespace
}  // namespace backbend::render
