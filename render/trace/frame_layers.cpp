#include "render/trace/frame_layers.h"

#include <bit>
#include <limits>

#include "render/image/cryptomatte.h"
#include "render/trace/shading.h"
#include "render/trace/surface.h"

namespace backbend::render {
namespace {

int add(Frame& frame, std::vector<std::string> names, bool half, float fill = 0.0f) {
  Layer layer;
  layer.half = half;
  layer.data.assign(static_cast<std::size_t>(frame.width) * frame.height * names.size(), fill);
  layer.names = std::move(names);
  frame.layers.push_back(std::move(layer));
  return static_cast<int>(frame.layers.size()) - 1;
}

int add_matte(Frame& frame, const char* name) {
  const int first = static_cast<int>(frame.layers.size());
  for (Layer& layer :
       cryptomatte_layers(name, static_cast<std::size_t>(frame.width) * frame.height))
    frame.layers.push_back(std::move(layer));
  return first;
}

std::size_t tile_pixels(const PixelRect& rect) {
  return static_cast<std::size_t>(rect.tile_size) * static_cast<std::size_t>(rect.tile_size);
}

void put(Frame& frame, int layer, std::size_t pixel, const glm::vec3& value) {
  float* out = frame.layers[layer].data.data() + pixel * 3;
  out[0] = value.x, out[1] = value.y, out[2] = value.z;
}

void write_pixel(const SceneView& scene, const Projection& projection, Mode mode,
                 const Surface8& surface, unsigned lane, std::size_t pixel, const FrameLayers& at,
                 Frame& frame) {
  const MeshTopology& mesh = *scene.mesh;
  const glm::vec3 position = surface.position.lane(lane);
  const glm::dvec3 on_film = projection.project(position);
  frame.layers[at.depth].data[pixel] = static_cast<float>(on_film.z);
  put(frame, at.normal, pixel, surface.shading.lane(lane));
  if (at.position >= 0) put(frame, at.position, pixel, position);
  if (at.albedo >= 0) put(frame, at.albedo, pixel, albedo_at(scene, mode, surface, lane));
  if (at.rest_position >= 0)
    put(frame, at.rest_position, pixel,
        interpolate(std::span<const glm::vec3>(mesh.rest_position), surface, lane));
  if (at.motion >= 0) {
    const glm::dvec3 was =
        projection.project(interpolate(scene.pose.previous_position, surface, lane));
    float* out = frame.layers[at.motion].data.data() + pixel * 2;
    // A point that was behind the camera has no place on the film: no motion is claimed.
    out[0] = was.z > 0.0 ? static_cast<float>(was.x - on_film.x) : 0.0f;
    out[1] = was.z > 0.0 ? static_cast<float>(was.y - on_film.y) : 0.0f;
  }
  if (at.object_id >= 0)
    frame.layers[at.object_id].data[pixel] =
        1.0f + static_cast<float>(region_at(mesh, surface, lane));
  if (at.triangle_id >= 0)
    frame.layers[at.triangle_id].data[pixel] = 1.0f + static_cast<float>(surface.triangle[lane]);
  if (at.heat >= 0) frame.layers[at.heat].data[pixel] = interpolate(scene.pose.heat, surface, lane);
}

}  // namespace

FrameLayers add_layers(Frame& frame, const SceneView& scene, const Settings& settings) {
  const bool all = settings.all_layers;
  // The layers of the largest frames take gigabytes and seconds.
  const auto stopped = [&] { return settings.stop != nullptr && settings.stop(); };
  FrameLayers at;
  at.beauty = add(frame, {"R", "G", "B", "A"}, true);
  if (stopped()) return at;
  at.depth = add(frame, {"Z"}, false, kBackgroundDepth);
  at.normal = add(frame, {"N.X", "N.Y", "N.Z"}, true);
  if (stopped()) return at;
  if (settings.mattes) {
    at.object_matte = add_matte(frame, "CryptoAsset");
    if (stopped()) return at;
    at.region_matte = add_matte(frame, "CryptoObject");
  }
  if (stopped()) return at;
  const bool position = all || settings.position_and_albedo;
  if (position) at.position = add(frame, {"P.X", "P.Y", "P.Z"}, false);
  if (position || settings.denoise)
    at.albedo = add(frame, {"albedo.R", "albedo.G", "albedo.B"}, true);
  if (all || settings.rest_and_motion) {
    at.rest_position = add(frame, {"Pref.X", "Pref.Y", "Pref.Z"}, false);
    if (!scene.pose.previous_position.empty())
      at.motion = add(frame, {"motion.X", "motion.Y"}, false);
  }
  if (all || settings.object_id) at.object_id = add(frame, {"objectId"}, false);
  if (all) {
    at.triangle_id = add(frame, {"triangleId"}, false);
    at.variance = add(frame, {"variance.R", "variance.G", "variance.B"}, false);
    if (settings.noise > 0.0) at.sample_count = add(frame, {"sampleCount"}, false);
  }
  if (!scene.pose.heat.empty() && (all || settings.mode == Mode::heat))
    at.heat = add(frame, {"heat"}, false);
  return at;
}

double layer_bytes(const SceneView& scene, const Settings& settings) {
  Frame pixel;
  pixel.width = pixel.height = 1;
  add_layers(pixel, scene, settings);
  std::size_t channels = 0;
  for (const Layer& layer : pixel.layers) channels += layer.names.size();
  return static_cast<double>(settings.width) * settings.height *
         static_cast<double>(channels * sizeof(float));
}

FrameLayers add_geometry_layers(Frame& frame) {
  FrameLayers at;
  at.depth = add(frame, {"Z"}, false, kBackgroundDepth);
  at.normal = add(frame, {"N.X", "N.Y", "N.Z"}, false);
  at.object_id = add(frame, {"objectId"}, false);
  return at;
}

void write_geometry_layers(const SceneView& scene, const Projection& projection, Mode mode,
                           const PixelRect& rect, const FrameLayers& at, Frame& frame,
                           RayBatch& rays, HitBatch& hits, std::span<const std::uint8_t> may_hit) {
  const Vec8 eye = splat(glm::vec3(projection.eye));
  const std::size_t pixels = tile_pixels(rect);
  for (std::size_t first = 0; first < pixels; first += 8) {
    Float8 x, y;
    for (unsigned lane = 0; lane < 8; ++lane) {
      x[lane] = static_cast<float>(rect.x0 + tile_x(rect.tile_size, first / 8, lane)) + 0.5f;
      y[lane] = static_cast<float>(rect.y0 + tile_y(rect.tile_size, first / 8, lane)) + 0.5f;
    }
    rays.set_packet(first, eye, projection.directions(x, y),
                    splat(std::numeric_limits<float>::max()));
  }
  scene.rays->nearest(rays, pixels, Coherence::camera, hits, may_hit);
  write_geometry_layers(scene, projection, mode, rect, rays, hits, at, frame);
}

void write_geometry_layers(const SceneView& scene, const Projection& projection, Mode mode,
                           const PixelRect& rect, const RayBatch& rays, const HitBatch& hits,
                           const FrameLayers& at, Frame& frame) {
  const std::size_t pixels = tile_pixels(rect);
  for (std::size_t first = 0; first < pixels; first += 8) {
    const Int8 triangle = hits.packet(first);
    const Int8 hit = triangle >= 0;
    unsigned left = bits_of(hit);
    if (left == 0) continue;
    const Surface8 surface = surface_at(scene, hit ? triangle : splat(0), rays.packet_origin(first),
                                        rays.packet_direction(first));
    for (; left != 0; left &= left - 1) {
      const auto lane = static_cast<unsigned>(std::countr_zero(left));
      const int x = rect.x0 + tile_x(rect.tile_size, first / 8, lane),
                y = rect.y0 + tile_y(rect.tile_size, first / 8, lane);
      if (x >= rect.x1 || y >= rect.y1) continue;
      write_pixel(scene, projection, mode, surface, lane,
                  static_cast<std::size_t>(y) * frame.width + x, at, frame);
    }
  }
}

}  // namespace backbend::render
