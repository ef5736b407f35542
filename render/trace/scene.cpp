#include "render/trace/scene.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <numbers>

#include "render/image/cryptomatte.h"
#include "render/image/png.h"
#include "render/image/threads.h"
#include "render/image/video.h"
#include "render/trace/contour.h"
#include "render/trace/denoiser.h"
#include "render/trace/open_image_denoise.h"
#include "render/trace/overlay.h"
#include "render/trace/tile_renderer.h"

namespace backbend::render {
namespace {

bool is_finite(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

[[noreturn]] void refuse(const std::string& what) { throw RenderError("render: " + what); }

void expect_finite(std::span<const glm::vec3> values, const char* what) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!is_finite(values[i]))
      refuse(std::string(what) + " of vertex " + std::to_string(i) + " is not finite");
}

void check_textures(const MeshTopology& mesh) {
  const auto known = [&](int texture) {
    return texture >= -1 && texture < static_cast<int>(mesh.textures.size());
  };
  for (const Material& m : mesh.materials)
    if (!known(m.base_color_texture) || !known(m.roughness_metallic_texture) ||
        !known(m.normal_texture))
      refuse("a material names a texture that is not there");
  for (const Texture& t : mesh.textures)
    if (t.width < 1 || t.height < 1 ||
        t.texel.size() != static_cast<std::size_t>(t.width) * t.height)
      refuse("a texture's size and its texels disagree");
}

void check_topology(const MeshTopology& mesh) {
  const std::size_t vertices = mesh.rest_position.size();
  if (mesh.triangle.empty() || vertices == 0) refuse("the mesh has no triangles");
  if (mesh.vertex_region.size() != vertices || mesh.region_name.empty() ||
      mesh.region_name.size() > 256)
    refuse("the mesh needs one region per vertex and 1 to 256 region names");
  if (!mesh.uv.empty() && mesh.uv.size() != vertices)
    refuse("texture coordinates are not one per vertex");
  if (!mesh.triangle_material.empty() && mesh.triangle_material.size() != mesh.triangle.size())
    refuse("materials are not one per triangle");
  for (const glm::uvec3& t : mesh.triangle)
    if (t.x >= vertices || t.y >= vertices || t.z >= vertices)
      refuse("a triangle names a vertex past the last of " + std::to_string(vertices));
  for (const std::uint16_t material : mesh.triangle_material)
    if (material >= mesh.materials.size()) refuse("a triangle names a material that is not there");
  for (const std::uint8_t region : mesh.vertex_region)
    if (region >= mesh.region_name.size()) refuse("a vertex names a region that is not there");
  check_textures(mesh);
  expect_finite(mesh.rest_position, "the rest position");
}

template <class Body>
void for_each_tile(int width, int height, int size, const Settings& settings, const Body& body) {
  const int columns = (width + size - 1) / size;
  const int rows = (height + size - 1) / size;
  on_threads(settings.threads, [&] {
    tbb::parallel_for(tbb::blocked_range<int>(0, columns * rows, 1),
                      [&](const tbb::blocked_range<int>& tiles) {
                        const FlushDenormals flush;
                        for (int tile = tiles.begin(); tile != tiles.end(); ++tile) {
                          if (settings.stop != nullptr && settings.stop()) return;
                          body(tile % columns * size, tile / columns * size);
                        }
                      });
  });
}

// Line drawing from a geometry pass at twice the size: edges are found there and averaged down.
void draw_contours(const SceneView& scene, const Camera& camera, const Settings& settings,
                   const FrameLayers& at, Frame& frame) {
  constexpr int kScale = 2;
  Settings fine = settings;
  fine.width *= kScale;
  fine.height *= kScale;
  fine.all_layers = true;
  const Projection projection = project_camera(camera, fine.width, fine.height);
  Frame lines;
  lines.width = fine.width;
  lines.height = fine.height;
  const FrameLayers fine_at = add_geometry_layers(lines);
  const int size = settings.tile_size;
  for_each_tile(fine.width, fine.height, size, settings, [&](int x, int y) {
    const PixelRect rect{x, y, std::min(x + size, fine.width), std::min(y + size, fine.height),
                         size};
    const auto rays = std::make_unique_for_overwrite<RayBatch>();
    const auto hits = std::make_unique_for_overwrite<HitBatch>();
    write_geometry_layers(scene, projection, Mode::contour, rect, fine_at, lines, *rays, *hits);
  });
  ContourInput in{fine.width,
                  fine.height,
                  std::move(lines.layers[fine_at.depth].data),
                  {},
                  std::move(lines.layers[fine_at.object_id].data)};
  const std::vector<float>& normal = lines.layers[fine_at.normal].data;
  for (std::size_t i = 0; i < normal.size(); i += 3)
    in.normal.emplace_back(normal[i], normal[i + 1], normal[i + 2]);
  const std::vector<float> ink = find_contours(in);
  std::vector<float>& beauty = frame.layers[at.beauty].data;
  for (int y = 0; y < frame.height; ++y) {
    for (int x = 0; x < frame.width; ++x) {
      float sum = 0.0f;
      for (int i = 0; i < kScale * kScale; ++i)
        sum += ink[static_cast<std::size_t>(y * kScale + i / kScale) * fine.width + x * kScale +
                   i % kScale];
      const float cover = sum / (kScale * kScale);
      float* pixel = beauty.data() + (static_cast<std::size_t>(y) * frame.width + x) * 4;
      for (int c = 0; c < 3; ++c) pixel[c] += (0.012f - pixel[c]) * cover;
      pixel[3] += (1.0f - pixel[3]) * cover;
    }
  }
}

// Where light is sampled, and nothing is drawn over it afterwards.
bool can_denoise(const Settings& settings) {
  return settings.samples > 1 && !settings.overlay &&
         (settings.mode == Mode::beauty || settings.mode == Mode::clay ||
          settings.mode == Mode::ao);
}

// Layers for people to look at; whatever is measured stays as it was sampled.
void add_denoised(const FrameJob& job, Frame& frame) {
  const DenoiseInput noisy{frame.width,
                           frame.height,
                           job.even_half,
                           job.odd_half,
                           frame.layers[job.at.albedo].data,
                           frame.layers[job.at.normal].data,
                           frame.layers[job.at.depth].data,
                           job.settings->threads};
  Denoised clean = job.settings->open_image_denoise ? open_image_denoise(noisy) : denoise(noisy);
  frame.layers.push_back(
      {{"denoised.R", "denoised.G", "denoised.B"}, true, std::move(clean.color)});
  frame.layers.push_back({{"denoisedError"}, true, std::move(clean.error)});
}

std::string shortest_text(double value) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  return {digits.data(), end};
}

constexpr std::size_t kMaxEnvironmentBytes = std::size_t{1} << 30;

Texture read_environment(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw RenderError(file + ": the environment picture cannot be opened");
  std::vector<std::uint8_t> bytes;
  std::array<char, 65536> block;
  while (stream.read(block.data(), block.size()) || stream.gcount() > 0) {
    bytes.insert(bytes.end(), block.data(), block.data() + stream.gcount());
    if (bytes.size() > kMaxEnvironmentBytes)
      throw RenderError(file + ": the environment picture is larger than 1 GiB");
  }
  try {
    return decode_texture(bytes, Encoding::srgb);
  } catch (const RenderError& error) {
    throw RenderError(file + ": " + error.what());
  }
}

void add_matte_attributes(const MeshTopology& mesh, Frame& frame) {
  const auto add = [&](const char* layer, std::span<const std::string> names) {
    for (Attribute& attribute : cryptomatte_attributes(layer, names))
      frame.attributes.push_back(std::move(attribute));
  };
  add("CryptoAsset", {&mesh.object_name, 1});
  add("CryptoObject", mesh.region_name);
}

// A frame that can never fit is refused before the machine is brought to its knees.
void expect_room(const SceneView& scene, const Settings& settings) {
  const double needed = layer_bytes(scene, settings);
  const double has =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  if (needed > has) {
    const auto gigabytes = [](double bytes) {
      return std::to_string(static_cast<long>(std::ceil(bytes * 1e-9)));
    };
    refuse("a frame of " + std::to_string(settings.width) + "x" + std::to_string(settings.height) +
           " pixels needs " + gigabytes(needed) + " GB, this machine has " + gigabytes(has));
  }
}

const char* mode_name(Mode mode) {
  switch (mode) {
    case Mode::beauty:
      return "beauty";
    case Mode::clay:
      return "clay";
    case Mode::ao:
      return "ao";
    case Mode::matcap:
      return "matcap";
    case Mode::wireframe:
      return "wireframe";
    case Mode::heat:
      return "heat";
    case Mode::xray:
      return "xray";
    case Mode::contour:
      return "contour";
    case Mode::primary:
      return "primary";
  }
  return "unknown";
}

}  // namespace

struct Scene::Impl {
  std::shared_ptr<const MeshTopology> mesh;
  RayScene rays;
  SceneView view;
  mutable tbb::enumerable_thread_specific<TileRenderer>
      renderer;  // scratch memory, kept over frames

  explicit Impl(std::shared_ptr<const MeshTopology> topology)
      : mesh(std::move(topology)), rays(mesh->triangle, mesh->rest_position) {
    glm::vec3 low = mesh->rest_position[0], high = low;
    for (const glm::vec3& p : mesh->rest_position) low = glm::min(low, p), high = glm::max(high, p);
    view = {mesh.get(), &rays, {}, 0.5f * (low + high), 0.5f * glm::length(high - low), low.y, {}};
    if (!(view.rest_radius > 0.0f) || !std::isfinite(view.rest_radius))
      refuse("the mesh has no extent");
  }
};

Scene::Scene(std::shared_ptr<const MeshTopology> topology) {
  if (!topology) refuse("no mesh");
  check_topology(*topology);
  impl_ = std::make_unique<Impl>(std::move(topology));
}
Scene::~Scene() = default;
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;

void Scene::set_pose(const PoseGeometry& pose) {
  const std::size_t vertices = impl_->mesh->rest_position.size();
  const auto expect_size = [&](std::size_t size, const char* what) {
    if (size != vertices)
      refuse(std::string("a pose has ") + std::to_string(size) + " " + what + " for " +
             std::to_string(vertices) + " vertices");
  };
  expect_size(pose.position.size(), "positions");
  expect_size(pose.normal.size(), "normals");
  if (!pose.previous_position.empty())
    expect_size(pose.previous_position.size(), "earlier positions");
  if (!pose.heat.empty()) expect_size(pose.heat.size(), "heat values");
  expect_finite(pose.position, "the position");
  expect_finite(pose.normal, "the normal");
  expect_finite(pose.previous_position, "the earlier position");
  for (const OverlayLine& line : pose.overlay)
    if (!is_finite(line.from) || !is_finite(line.to)) refuse("an overlay line is not finite");
  impl_->rays.set_pose(pose.position);
  impl_->view.pose = pose;
  // Rays are rounded by a few millionths of what they cross.
  impl_->view.bounds =
      PoseBounds(impl_->mesh->triangle, pose.position, 1e-3f * impl_->view.rest_radius);
}

Frame Scene::render(const Camera& camera, const Settings& settings) const {
  const SceneView& scene = impl_->view;
  if (scene.pose.position.empty()) refuse("no pose was set");
  if (settings.samples < 1 || settings.samples > 65535) refuse("samples must be 1 to 65535");
  if (settings.bounces < 0 || settings.bounces > 16) refuse("bounces must be 0 to 16");
  if (settings.tile_size != 16 && settings.tile_size != 8 && settings.tile_size != 4)
    refuse("tiles must be 16, 8 or 4 pixels wide");
  const Projection projection = project_camera(camera, settings.width, settings.height);
  if (!(settings.noise >= 0.0) || !std::isfinite(settings.noise) ||
      !std::isfinite(settings.light_turn_deg))
    refuse("the noise must be 0 or more, and the turn of the light finite");
  expect_room(scene, settings);
  Studio studio = make_studio(projection, scene.rest_center, scene.rest_radius, scene.rest_floor,
                              settings.light_turn_deg);
  studio.has_ground = settings.ground;
  // Seen from above lights turn clockwise, as from +Z to -X.
  const double light_turn = -settings.light_turn_deg * std::numbers::pi / 180.0;
  if (settings.environment) {
    studio.environment.emplace(*settings.environment, light_turn);
  } else if (!settings.environment_file.empty()) {
    studio.environment.emplace(read_environment(settings.environment_file), light_turn);
  }
  const Sampler sampler(settings.samples, sampler_pairs(settings.bounces), settings.seed);
  static const PixelFilter filter;

  Frame frame;
  frame.width = settings.width;
  frame.height = settings.height;
  frame.camera_from_world = projection.camera_from_world();
  frame.ndc_from_world = projection.ndc_from_world();
  FrameJob job{&scene, &projection, &studio, &sampler, &settings, &filter, {},
               &frame, {},          0.0f,    {},       {},        {},      kLargestTile};
  job.at = add_layers(frame, scene, settings);
  if (!(settings.noise > 0.0)) job.tile_size = settings.tile_size;
  job.seen = scene.bounds.on_film(projection);
  for (const std::string& name : impl_->mesh->region_name)
    job.region_id.push_back(cryptomatte_id(name));
  job.object_id = cryptomatte_id(impl_->mesh->object_name);
  std::vector<float> even_half, odd_half;
  if (settings.denoise && can_denoise(settings)) {
    even_half.resize(static_cast<std::size_t>(frame.width) * frame.height * 3);
    odd_half.resize(even_half.size());
    job.even_half = even_half;
    job.odd_half = odd_half;
  }

  for_each_tile(frame.width, frame.height, job.tile_size, settings,
                [&](int x, int y) { impl_->renderer.local().render(job, x, y); });
  if (settings.stop != nullptr && settings.stop()) return frame;
  if (!odd_half.empty()) add_denoised(job, frame);
  if (settings.mode == Mode::contour) draw_contours(scene, camera, settings, job.at, frame);
  if (settings.mode == Mode::xray || settings.overlay)
    draw_overlay(scene.pose.overlay, projection, frame);

  if (settings.mattes) add_matte_attributes(*impl_->mesh, frame);
  frame.attributes.push_back({"framesPerSecond", frame_rate_fraction(settings.frames_per_second)});
  frame.attributes.push_back({"backbend/mode", mode_name(settings.mode)});
  frame.attributes.push_back({"backbend/seed", std::to_string(settings.seed)});
  frame.attributes.push_back({"backbend/spp", std::to_string(settings.samples)});
  if (settings.noise > 0.0)
    frame.attributes.push_back({"backbend/noise", shortest_text(settings.noise)});
  return frame;
}

}  // namespace backbend::render
