#include "render/trace/refit_quality.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "render/image/exr.h"
#include "render/trace/cameras.h"
#include "render/trace/ray_device.h"
#include "tests/render/mesh_fixture.h"

namespace backbend::render {
namespace {

// The mesh with corners of its own for every triangle, so that each can go where it wants.
TestMesh unwelded(const TestMesh& mesh) {
  TestMesh apart;
  apart.topology = std::make_shared<MeshTopology>(*mesh.topology);
  apart.topology->triangle.clear();
  apart.topology->vertex_region.clear();
  for (const glm::uvec3& t : mesh.topology->triangle) {
    const auto first = static_cast<unsigned>(apart.position.size());
    apart.topology->triangle.emplace_back(first, first + 1, first + 2);
    for (int corner = 0; corner < 3; ++corner) {
      apart.position.push_back(mesh.position[t[corner]]);
      apart.normal.push_back(mesh.normal[t[corner]]);
      apart.topology->vertex_region.push_back(mesh.topology->vertex_region[t[corner]]);
    }
  }
  apart.topology->rest_position = apart.position;
  return apart;
}

// Every triangle moved to where another one was, far away as a rule, but left as it is.
TestMesh flung_apart(const TestMesh& mesh) {
  TestMesh flung = mesh;
  std::vector<std::size_t> to(mesh.position.size() / 3);
  std::iota(to.begin(), to.end(), std::size_t{0});
  std::mt19937 rng(1);
  for (std::size_t i = to.size() - 1; i > 0; --i) std::swap(to[i], to[rng() % (i + 1)]);
  for (std::size_t i = 0; i < flung.position.size(); ++i)
    flung.position[i] += mesh.position[to[i / 3] * 3] - mesh.position[i / 3 * 3];
  return flung;
}

TEST(RefitQuality, DoesNotChangeWhereAPoseIsMovedTurnedOrScaled) {
  const TestMesh mesh = blob_figure();
  const RefitQuality quality(mesh.topology->triangle, mesh.position);
  EXPECT_EQ(quality.growth(mesh.position), 1.0);
  std::vector<glm::vec3> other = mesh.position;
  for (glm::vec3& p : other) p = p * 4.0f;
  EXPECT_EQ(quality.growth(other), 1.0);
  // A quarter turn swaps the axes of every box.
  for (std::size_t i = 0; i < other.size(); ++i)
    other[i] = {-mesh.position[i].z, mesh.position[i].y, mesh.position[i].x};
  EXPECT_NEAR(quality.growth(other), 1.0, 1e-9);
}

TEST(RefitQuality, KeepsABentFigureAndNotOneThatIsTornApart) {
  const TestMesh mesh = unwelded(blob_figure());
  const RefitQuality quality(mesh.topology->triangle, mesh.position);
  for (const float angle : {0.5f, 1.5f, 3.1f})
    EXPECT_LT(quality.growth(bent(mesh, angle).position), 1.2) << angle;
  EXPECT_GT(quality.growth(flung_apart(mesh).position), 1.5);
}

TEST(RefitQuality, IsOneForAMeshWithoutExtent) {
  const std::vector<glm::uvec3> triangle{{0, 0, 0}};
  const std::vector<glm::vec3> position{{1, 2, 3}};
  EXPECT_EQ(RefitQuality(triangle, position).growth(position), 1.0);
}

// Whether a tree is refitted or built anew is decided by this pose alone, and not to be seen.
TEST(RayScene, BuildsATreeForAPoseTornApartAndGoesBackToRefitting) {
  const TestMesh mesh = unwelded(blob_figure()), torn = flung_apart(mesh), last = bent(mesh, 0.7f);
  RayScene rays(mesh.topology->triangle, mesh.position);
  EXPECT_TRUE(rays.is_refitted());
  rays.set_pose(torn.position);
  EXPECT_FALSE(rays.is_refitted());
  rays.set_pose(last.position);
  EXPECT_TRUE(rays.is_refitted());

  Settings settings;
  settings.width = 64;
  settings.height = 48;
  settings.samples = 4;
  const Camera camera = view_camera("front", bounds_of(mesh.position), {}, 64.0 / 48.0);
  Scene fresh(mesh.topology), used(mesh.topology);
  for (const TestMesh* pose : {&last, &torn}) {
    fresh.set_pose(pose->pose());
    used.set_pose((pose == &last ? torn : last).pose());
    used.set_pose(pose->pose());
    EXPECT_EQ(encode_exr(used.render(camera, settings)),
              encode_exr(fresh.render(camera, settings)));
  }
}

}  // namespace
}  // namespace backbend::render
