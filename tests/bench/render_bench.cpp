// render_bench CHARACTER: what a pose costs beside its picture, and what a tree costs that does not
// fit its pose.
//
// All in seconds of processor time, median of repeats, 512x512, one camera over everything.
//   animated  a pose (solved, skinned, given to the ray device) and its frame, over the frame alone
//   torn      the body's triangles flung apart step by step: RefitQuality's growth, whether the
//   tree was refitted or
//             built, what giving the pose took, and the frame
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <glm/geometric.hpp>
#include <random>
#include <vector>

#include "render/image/exr.h"
#include "render/trace/ray_device.h"
#include "render/trace/refit_quality.h"
#include "validate/camera/photographer.h"
#include "validate/measure/measure.h"

namespace backbend::validate {
namespace {

double processor_seconds() {
  timespec now{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

template <class Work>
double seconds_of(const Work& work) {
  const double start = processor_seconds();
  work();
  return processor_seconds() - start;
}

render::Settings frame_of(int samples) {
  render::Settings settings;
  settings.width = settings.height = 512;
  settings.samples = samples;
  return settings;
}

void animated(const Stage& stage) {
  constexpr int kPoses = 37;  // an extension from 0 to 180 degrees
  const auto system = stage.build({"even", {}});
  const auto posed_at = [&](int i) {
    return stage.pose(
        *system, controls_at(*system, PoseDegrees{.extension = 5.0 * i}, solver::Mapping::chest));
  };
  render::Bounds box = render::bounds_of(stage.rest().position);
  box.add(render::bounds_of(posed_at(kPoses - 1).mesh.position));
  Photographer photographer(stage, box);
  const auto topology = stage.topology();
  const render::RefitQuality quality(topology->triangle, topology->rest_position);
  double growth = 1.0;
  for (int i = 0; i < kPoses; ++i)
    growth = std::max(growth, quality.growth(posed_at(i).mesh.position));
  std::printf("animated  growth at most %.3f\n", growth);
  for (const int samples : {8, 1}) {
    std::vector<double> pose, frame, file;
    for (int i = 0; i < kPoses; ++i) {
      PosedCharacter posed;
      render::Frame picture;
      pose.push_back(seconds_of([&] {
        posed = posed_at(i);
        photographer.pose(posed);
      }));
      frame.push_back(
          seconds_of([&] { picture = photographer.shoot("profile", frame_of(samples)); }));
      file.push_back(seconds_of([&] { render::encode_exr(picture); }));
    }
    const double p = median(pose), f = median(frame), e = median(file);
    std::printf(
        "animated  %d samples: pose %.4f s, frame %.4f s, file %.4f s; animated over static %.3f, "
        "with the file %.3f\n",
        samples, p, f, e, (p + f) / f, (p + f + e) / (f + e));
  }
}

void torn(const Stage& stage) {
  const auto topology = stage.topology();
  const render::MeshTopology& whole = *topology;
  auto apart = std::make_shared<render::MeshTopology>();
  apart->region_name = whole.region_name;
  std::vector<glm::vec3> normal;
  for (const glm::uvec3& t : whole.triangle) {
    const auto first = static_cast<unsigned>(apart->rest_position.size());
    apart->triangle.emplace_back(first, first + 1, first + 2);
    const glm::vec3 n = glm::cross(whole.rest_position[t.y] - whole.rest_position[t.x],
                                   whole.rest_position[t.z] - whole.rest_position[t.x]);
    const float length = glm::length(n);
    for (int corner = 0; corner < 3; ++corner) {
      apart->rest_position.push_back(whole.rest_position[t[corner]]);
      apart->vertex_region.push_back(whole.vertex_region[t[corner]]);
      normal.push_back(length > 0.0f ? n / length : glm::vec3(0.0f, 1.0f, 0.0f));
    }
  }
  const render::Bounds box = render::bounds_of(apart->rest_position);
  const float height = static_cast<float>(box.high.y - box.low.y);
  const render::RefitQuality quality(apart->triangle, apart->rest_position);
  render::Scene scene(apart);
  render::RayScene rays(apart->triangle, apart->rest_position);
  const render::Camera camera = render::view_camera("front", box, facing_of(stage.anatomy()), 1.0);
  for (const float reach : {0.0f, 0.0005f, 0.001f, 0.002f, 0.003f, 0.005f, 0.01f, 0.03f}) {
    std::mt19937 rng(1);
    const auto random = [&] { return static_cast<float>(rng() >> 8) * 0x1p-23f - 1.0f; };
    std::vector<glm::vec3> position = apart->rest_position;
    for (std::size_t i = 0; i < position.size(); i += 3) {
      const glm::vec3 away(random(), random(), random());
      for (std::size_t corner = 0; corner < 3; ++corner)
        position[i + corner] += away * (reach * height);
    }
    rays.set_pose(position);
    std::vector<double> pose, frame;
    for (int i = 0; i < 3; ++i) {
      pose.push_back(seconds_of([&] {
        render::PoseGeometry geometry;
        geometry.position = position;
        geometry.normal = normal;
        scene.set_pose(geometry);
      }));
      frame.push_back(seconds_of([&] { scene.render(camera, frame_of(8)); }));
    }
    std::printf("torn      by %.2f %% of the height: growth %.2f, %s, pose %.4f s, frame %.4f s\n",
                100.0 * reach, quality.growth(position), rays.is_refitted() ? "refitted" : "built",
                median(pose), median(frame));
  }
}

}  // namespace
}  // namespace backbend::validate

int main(int count, char** words) {
  if (count != 2) {
    std::fprintf(stderr, "usage: render_bench CHARACTER\n");
    return 2;
  }
  try {
    const backbend::validate::Stage stage(backbend::validate::load_character(words[1]),
                                          backbend::skin::AnatomyHints{});
    backbend::validate::animated(stage);
    backbend::validate::torn(stage);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "render_bench: %s\n", error.what());
    return 1;
  }
}
