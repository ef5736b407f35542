#include "render/trace/tile_renderer.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "render/image/cryptomatte.h"
#include "render/trace/shading.h"

namespace backbend::render {
namespace {

constexpr std::size_t kMaxRegions = 256;

/// Sums over the samples of one tile, in the order of the samples. Pixels are in packet order.
struct TileSums {
  using Column = std::array<float, kMostTilePixels>;
  alignas(32) Column red, green, blue, alpha;
  alignas(32) Column red_squared, green_squared, blue_squared;
  alignas(32) Column red_odd, green_odd, blue_odd;  // of every second sample
  int count = 0;                                    // samples so far
  // [pixel][region]: how many of its samples saw it; 16 bits hold any sample count we accept.
  std::vector<std::uint16_t> region;
  std::size_t region_count = 0;

  void clear(std::size_t pixels, std::size_t regions) {
    region_count = regions;
    region.assign(pixels * regions, 0);
    count = 0;
    for (Column* c : {&red, &green, &blue, &alpha, &red_squared, &green_squared, &blue_squared,
                      &red_odd, &green_odd, &blue_odd})
      c->fill(0.0f);
  }
};

// Mean error of a picture over the square root of its light, in the worst 8 x 8 pixels of a tile of
// the largest size, told by the difference of its odd and its even samples. Both halves must be
// equally many.
float worst_error(const TileSums& sums) {
  constexpr std::size_t kPackets = kMostTilePixels / 8;
  constexpr float kLeastLight = 0.01f;
  std::array<float, 4> block{};
  for (std::size_t packet = 0; packet < kPackets; ++packet) {
    const std::size_t first = packet * 8;
    const auto difference = [&](const TileSums::Column& all, const TileSums::Column& odd) {
      return abs(load(&all[first]) - 2.0f * load(&odd[first]));
    };
    const Float8 scale = splat(1.0f / static_cast<float>(sums.count));
    const Float8 error =
        (difference(sums.red, sums.red_odd) + difference(sums.green, sums.green_odd) +
         difference(sums.blue, sums.blue_odd)) *
        scale;
    const Float8 light =
        (load(&sums.red[first]) + load(&sums.green[first]) + load(&sums.blue[first])) * scale;
    const Float8 relative = error / sqrt(max(light, splat(kLeastLight)));
    const std::size_t at = (tile_y(kLargestTile, packet, 0) >= kLargestTile / 2 ? 2 : 0) +
                           (tile_x(kLargestTile, packet, 0) >= kLargestTile / 2 ? 1 : 0);
    for (unsigned lane = 0; lane < 8; ++lane) block[at] += relative[lane];
  }
  return *std::max_element(block.begin(), block.end()) / (kMostTilePixels / 4);
}

// Whether a tile's samples may end here: at a power of two, where they are well spread.
bool is_clean(const TileSums& sums, const Settings& settings) {
  const auto count = static_cast<unsigned>(sums.count);
  return sums.count >= settings.least_samples && std::has_single_bit(count) &&
         worst_error(sums) <= settings.noise;
}

/// What the modes without lights show where nothing is. The pass that image metrics read stays
/// empty there, so that nothing but the figure is compared.
struct Background {
  glm::vec3 color{0.0f};
  float alpha = 0.0f;
};
Background background_of(const Settings& settings) {
  if (settings.transparent || settings.mode == Mode::primary) return {};
  if (settings.mode == Mode::contour) return {glm::vec3(0.90f), 1.0f};
  if (settings.mode == Mode::xray) return {glm::vec3(0.012f, 0.016f, 0.024f), 1.0f};
  return {glm::vec3(0.055f, 0.058f, 0.065f), 1.0f};
}

bool traces_paths(Mode mode) {
  return mode == Mode::beauty || mode == Mode::clay || mode == Mode::wireframe;
}

// Colour of one surface point in the modes that need no further rays.
glm::vec3 surface_color(const FrameJob& job, const Surface8& surface, unsigned lane,
                        const glm::vec3& out) {
  const Settings& settings = *job.settings;
  const glm::vec3 normal = surface.shading.lane(lane);
  switch (settings.mode) {
    case Mode::matcap:
      return matcap_shade(*job.projection, normal, out);
    case Mode::contour:
      return paper_shade(*job.projection, normal);
    case Mode::heat: {
      const std::span<const float> heat = job.scene->pose.heat;
      const float value =
          heat.empty() ? std::numeric_limits<float>::quiet_NaN() : interpolate(heat, surface, lane);
      return heat_shade(*job.projection, normal, value, settings.heat_low, settings.heat_high);
    }
    default:
      return fixed_light_shade(*job.projection, normal);
  }
}

}  // namespace

struct TileRenderer::Impl {
  PathBatch batch;
  PathTracer tracer;
  TileSums sums;
  RayBatch rays;  // of the modes without lights
  HitBatch hits;
  std::array<std::int32_t, RayBatch::kCapacity> path;
  std::array<std::uint8_t, RayBatch::kCapacity> blocked;
  std::array<float, PathBatch::kCapacity> transmitted;

  std::vector<std::uint32_t> pixels;  // of the sampler, by packet
  int size = kLargestTile;            // pixels along the tile's edge
  std::size_t pixel_count = kMostTilePixels;
  std::vector<std::uint8_t> may_hit;  // by packet: whether the pose may be there

  const std::uint32_t* pixels_of(const FrameJob& job, std::size_t packet) const {
    return pixels.data() + packet * job.sampler->words_per_packet();
  }
  void place_pixels(const FrameJob& job, int x0, int y0);
  void find_pose(const FrameJob& job, int x0, int y0);
  void add_camera_rays(const FrameJob& job, int x0, int y0, int sample);
  void shade_ambient(const FrameJob& job);
  void shade_surface(const FrameJob& job);
  void shade_translucent(const FrameJob& job);
  void accumulate();
  void write(const FrameJob& job, int x0, int y0);

  Surface8 meet(const FrameJob& job, std::size_t first);
};

TileRenderer::TileRenderer() : impl_(std::make_unique<Impl>()) {}
TileRenderer::~TileRenderer() = default;

namespace {

// One sample a pixel goes through its centre, unless paths need their film samples spread.
bool through_centers(const Settings& settings) {
  return settings.samples == 1 && !traces_paths(settings.mode);
}

}  // namespace

void TileRenderer::Impl::place_pixels(const FrameJob& job, int x0, int y0) {
  pixels.resize(pixel_count / 8 * job.sampler->words_per_packet());
  for (std::size_t packet = 0; packet < pixel_count / 8; ++packet) {
    Int8 x{}, y{};
    for (unsigned lane = 0; lane < 8; ++lane) {
      x[lane] = x0 + tile_x(size, packet, lane);
      y[lane] = y0 + tile_y(size, packet, lane);
    }
    job.sampler->place(x, y, pixels.data() + packet * job.sampler->words_per_packet());
  }
}

// Which packets see a place where the pose may be.
void TileRenderer::Impl::find_pose(const FrameJob& job, int x0, int y0) {
  constexpr double kReach = 2.0;  // pixels: the filter's one, and room for rounding
  may_hit.resize(pixel_count / 8);
  for (std::size_t packet = 0; packet < may_hit.size(); ++packet) {
    const double left = x0 + tile_x(size, packet, 0) - kReach, right = left + 4.0 + 2.0 * kReach;
    const double top = y0 + tile_y(size, packet, 0) - kReach, bottom = top + 2.0 + 2.0 * kReach;
    may_hit[packet] = std::any_of(job.seen.begin(), job.seen.end(), [&](const auto& rect) {
      return rect.x0 <= right && rect.x1 >= left && rect.y0 <= bottom && rect.y1 >= top;
    });
  }
}

// The packets of one sample. Lanes past the frame's edge are traced like all others and not read.
void TileRenderer::Impl::add_camera_rays(const FrameJob& job, int x0, int y0, int sample) {
  const Projection& camera = *job.projection;
  const Vec8 eye = splat(glm::vec3(camera.eye));
  for (std::size_t packet = 0; packet < pixel_count / 8; ++packet) {
    const std::size_t first = batch.count;
    Float8 x, y;
    for (unsigned lane = 0; lane < 8; ++lane) {
      const int at_x = x0 + tile_x(size, packet, lane), at_y = y0 + tile_y(size, packet, lane);
      x[lane] = static_cast<float>(at_x) + 0.5f;
      y[lane] = static_cast<float>(at_y) + 0.5f;
    }
    if (!through_centers(*job.settings)) {
      const Point8 random = job.sampler->points(sample, 0, pixels_of(job, packet));
      x += job.filter->offset(random.x);
      y += job.filter->offset(random.y);
    }
    store(&batch.sample[first], splat(sample));
    store(&batch.film_x[first], x);
    store(&batch.film_y[first], y);
    batch.rays.set_packet(first, eye, camera.directions(x, y),
                          splat(std::numeric_limits<float>::max()));
    batch.count += 8;
  }
}

// Surfaces of a packet of camera rays; notes their regions.
Surface8 TileRenderer::Impl::meet(const FrameJob& job, std::size_t first) {
  const Int8 triangle = batch.hits.packet(first);
  const Int8 hit = triangle >= 0;
  for (unsigned lane = 0; lane < 8; ++lane) batch.region[first + lane] = -1;
  const Surface8 surface = surface_at(*job.scene, hit ? triangle : splat(0), batch.origin(first),
                                      batch.direction(first));
  for (unsigned left = bits_of(hit); left != 0; left &= left - 1) {
    const auto lane = static_cast<unsigned>(std::countr_zero(left));
    batch.region[first + lane] = region_at(*job.scene->mesh, surface, lane);
  }
  return surface;
}

// Open sky within a third of the character's size: creases and contacts go dark.
void TileRenderer::Impl::shade_ambient(const FrameJob& job) {
  const Background behind = background_of(*job.settings);
  const Float8 reach = splat(0.7f * job.scene->rest_radius);
  std::size_t count = 0;
  for (std::size_t first = 0; first < batch.count; first += 8) {
    const Int8 hit = batch.hits.packet(first) >= 0;
    const Surface8 surface = meet(job, first);
    for (auto* channel : {&batch.red, &batch.green, &batch.blue})
      store(&(*channel)[first], hit ? splat(0.0f)
                                    : splat(behind.color[channel == &batch.red     ? 0
                                                         : channel == &batch.green ? 1
                                                                                   : 2]));
    store(&batch.alpha[first], hit ? splat(1.0f) : splat(behind.alpha));
    const Point8 random =
        job.sampler->points(batch.sample[first], 1, pixels_of(job, first % pixel_count / 8));
    const Compress kept(hit);
    rays.append(count, kept, surface.launch, sample_cosine(surface.shading, random), reach);
    kept.write(&path[count], splat(static_cast<int>(first)) + Int8{0, 1, 2, 3, 4, 5, 6, 7});
    count += kept.count();
  }
  job.scene->rays->occluded(rays, count, blocked.data());
  for (std::size_t i = 0; i < count; ++i) {
    if (blocked[i]) continue;
    const auto to = static_cast<std::size_t>(path[i]);
    batch.red[to] = batch.green[to] = batch.blue[to] = 0.9f;
  }
}

void TileRenderer::Impl::shade_surface(const FrameJob& job) {
  const Background behind = background_of(*job.settings);
  for (std::size_t first = 0; first < batch.count; first += 8) {
    if (bits_of(batch.hits.packet(first) >= 0) == 0) {
      for (std::size_t to = first; to < first + 8; ++to) {
        batch.region[to] = -1;
        batch.red[to] = behind.color.x, batch.green[to] = behind.color.y;
        batch.blue[to] = behind.color.z;
        batch.alpha[to] = behind.alpha;
      }
      continue;
    }
    const Surface8 surface = meet(job, first);
    const Vec8 out = -normalize(batch.direction(first));
    for (unsigned lane = 0; lane < 8; ++lane) {
      const std::size_t to = first + lane;
      const bool hit = batch.region[to] >= 0;
      const glm::vec3 color =
          hit ? surface_color(job, surface, lane, out.lane(lane)) : behind.color;
      batch.red[to] = color.x, batch.green[to] = color.y, batch.blue[to] = color.z;
      batch.alpha[to] = hit ? 1.0f : behind.alpha;
    }
  }
}

// Every layer of skin along the ray, more opaque towards its edges, composited front to back.
void TileRenderer::Impl::shade_translucent(const FrameJob& job) {
  constexpr int kLayers = 8;
  constexpr glm::vec3 kSkin(0.30f, 0.42f, 0.55f);
  const Background behind = background_of(*job.settings);
  // The camera's own hits come first; then every ray goes on behind the skin it has met.
  std::size_t count = batch.count;
  rays = batch.rays;
  hits = batch.hits;
  for (std::size_t i = 0; i < count; ++i) {
    path[i] = static_cast<std::int32_t>(i);
    transmitted[i] = 1.0f;
    batch.red[i] = batch.green[i] = batch.blue[i] = 0.0f;
  }
  for (std::size_t first = 0; first < count; first += 8) meet(job, first);
  for (int layer = 0; layer < kLayers && count > 0; ++layer) {
    if (layer > 0) job.scene->rays->nearest(rays, count, Coherence::camera, hits);
    std::size_t kept_count = 0;
    for (std::size_t first = 0; first < count; first += 8) {
      const Int8 triangle = hits.packet(first);
      const Int8 hit = (triangle >= 0) & first_lanes(count - first);
      const Vec8 direction = rays.packet_direction(first);
      const Int8 to = load(&path[first]);
      const Surface8 surface =
          surface_at(*job.scene, hit ? triangle : splat(0), rays.packet_origin(first), direction);
      const Float8 size = length(direction);
      const Float8 turned = 1.0f - max(splat(0.0f), -dot(surface.shading, direction) / size);
      const Float8 opacity = 0.10f + 0.55f * turned * turned;
      for (unsigned left = bits_of(hit); left != 0; left &= left - 1) {
        const auto lane = static_cast<unsigned>(std::countr_zero(left));
        const auto p = static_cast<std::size_t>(to[lane]);
        const float share = opacity[lane] * transmitted[p];
        batch.red[p] += kSkin.x * share;
        batch.green[p] += kSkin.y * share;
        batch.blue[p] += kSkin.z * share;
        transmitted[p] *= 1.0f - opacity[lane];
      }
      const Compress kept(hit);
      rays.append(kept_count, kept,
                  surface.position + direction * (1e-4f * job.scene->rest_radius / size), direction,
                  splat(std::numeric_limits<float>::max()));
      kept.write(&path[kept_count], to);
      kept_count += kept.count();
    }
    count = kept_count;
  }
  for (std::size_t i = 0; i < batch.count; ++i) {
    batch.red[i] += behind.color.x * transmitted[i];
    batch.green[i] += behind.color.y * transmitted[i];
    batch.blue[i] += behind.color.z * transmitted[i];
    batch.alpha[i] = 1.0f - transmitted[i] * (1.0f - behind.alpha);
  }
}

void TileRenderer::Impl::accumulate() {
  for (std::size_t i = 0; i < batch.count; i += 8) {
    const std::size_t p = i % pixel_count;
    const auto add = [&](auto& sum, auto& squared, const PathBatch::Column& value) {
      const Float8 v = load(&value[i]);
      store(&sum[p], load(&sum[p]) + v);
      store(&squared[p], load(&squared[p]) + v * v);
    };
    add(sums.red, sums.red_squared, batch.red);
    add(sums.green, sums.green_squared, batch.green);
    add(sums.blue, sums.blue_squared, batch.blue);
    store(&sums.alpha[p], load(&sums.alpha[p]) + load(&batch.alpha[i]));
    if (batch.sample[i] % 2 != 0) {
      store(&sums.red_odd[p], load(&sums.red_odd[p]) + load(&batch.red[i]));
      store(&sums.green_odd[p], load(&sums.green_odd[p]) + load(&batch.green[i]));
      store(&sums.blue_odd[p], load(&sums.blue_odd[p]) + load(&batch.blue[i]));
    }
    for (unsigned lane = 0; lane < 8; ++lane)
      if (batch.region[i + lane] >= 0)
        ++sums.region[(p + lane) * sums.region_count + batch.region[i + lane]];
  }
  sums.count += static_cast<int>(batch.count / pixel_count);
  batch.count = 0;
}

void TileRenderer::Impl::write(const FrameJob& job, int x0, int y0) {
  Frame& frame = *job.frame;
  const float per_sample = 1.0f / static_cast<float>(sums.count);
  const std::size_t regions = job.region_id.size();
  const auto layers = std::span(frame.layers);
  std::array<Matte, kMaxRegions> matte;
  for (std::size_t p = 0; p < pixel_count; ++p) {
    const int x = x0 + tile_x(size, p / 8, p % 8), y = y0 + tile_y(size, p / 8, p % 8);
    if (x >= frame.width || y >= frame.height) continue;
    const std::size_t pixel = static_cast<std::size_t>(y) * frame.width + x;
    const glm::vec3 color = glm::vec3(sums.red[p], sums.green[p], sums.blue[p]) * per_sample;
    float* beauty = frame.layers[job.at.beauty].data.data() + pixel * 4;
    beauty[0] = color.x, beauty[1] = color.y, beauty[2] = color.z;
    beauty[3] = sums.alpha[p] * per_sample;
    if (job.at.variance >= 0) {
      // Of the pixel's mean, as if its samples were independent: an upper bound for Sobol points.
      const glm::vec3 squared(sums.red_squared[p], sums.green_squared[p], sums.blue_squared[p]);
      const glm::vec3 spread =
          glm::max(squared * per_sample - color * color, glm::vec3(0.0f)) * per_sample;
      float* out = frame.layers[job.at.variance].data.data() + pixel * 3;
      out[0] = spread.x, out[1] = spread.y, out[2] = spread.z;
    }
    if (job.at.sample_count >= 0)
      frame.layers[job.at.sample_count].data[pixel] = static_cast<float>(sums.count);
    if (!job.odd_half.empty()) {
      const int odds = sums.count / 2, evens = sums.count - odds;
      const glm::vec3 all(sums.red[p], sums.green[p], sums.blue[p]);
      const glm::vec3 odd(sums.red_odd[p], sums.green_odd[p], sums.blue_odd[p]);
      for (int c = 0; c < 3; ++c) {
        job.odd_half[pixel * 3 + c] = odd[c] / static_cast<float>(odds);
        job.even_half[pixel * 3 + c] = (all[c] - odd[c]) / static_cast<float>(evens);
      }
    }
    if (job.at.region_matte < 0) continue;
    std::size_t seen = 0;
    std::uint32_t hit_count = 0;
    const std::uint16_t* count = sums.region.data() + p * regions;
    for (std::size_t region = 0; region < regions; ++region) {
      if (count[region] == 0) continue;
      hit_count += count[region];
      matte[seen++] = {job.region_id[region], static_cast<float>(count[region]) * per_sample};
    }
    if (seen == 0) continue;
    write_cryptomatte(layers.subspan(job.at.region_matte, 3), pixel, {matte.data(), seen});
    matte[0] = {job.object_id, static_cast<float>(hit_count) * per_sample};
    write_cryptomatte(layers.subspan(job.at.object_matte, 3), pixel, {matte.data(), 1});
  }
}

void TileRenderer::render(const FrameJob& job, int x0, int y0) {
  Impl& tile = *impl_;
  const Settings& settings = *job.settings;
  tile.size = job.tile_size;
  tile.pixel_count = static_cast<std::size_t>(tile.size) * static_cast<std::size_t>(tile.size);
  tile.find_pose(job, x0, y0);
  // The pass that image metrics read leaves what is empty as the layers were made.
  if (settings.mode == Mode::primary && through_centers(settings) && job.at.sample_count < 0 &&
      std::ranges::find(tile.may_hit, 1) == tile.may_hit.end())
    return;
  tile.sums.clear(tile.pixel_count, job.region_id.size());
  tile.batch.count = 0;
  if (!through_centers(settings) || settings.mode == Mode::ao) tile.place_pixels(job, x0, y0);
  PathContext context{job.scene, job.projection, job.studio, job.sampler, tile.pixels.data()};
  context.surfacing = settings.mode == Mode::beauty      ? Surfacing::materials
                      : settings.mode == Mode::wireframe ? Surfacing::wireframe
                                                         : Surfacing::clay;
  context.tile_pixels = static_cast<int>(tile.pixel_count);
  context.bounces = settings.bounces;
  context.transparent = settings.transparent;
  for (int sample = 0; sample < settings.samples; ++sample) {
    tile.add_camera_rays(job, x0, y0, sample);
    const bool last = sample + 1 == settings.samples;
    if (!last && tile.batch.count + tile.pixel_count <= PathBatch::kCapacity) continue;
    job.scene->rays->nearest(tile.batch.rays, tile.batch.count, Coherence::camera, tile.batch.hits,
                             tile.may_hit);
    if (traces_paths(settings.mode)) {
      tile.tracer.trace(context, tile.batch);
    } else if (settings.mode == Mode::ao) {
      tile.shade_ambient(job);
    } else if (settings.mode == Mode::xray) {
      tile.shade_translucent(job);
    } else {
      tile.shade_surface(job);
    }
    tile.accumulate();
    if (settings.noise > 0.0 && is_clean(tile.sums, settings)) break;
  }
  tile.write(job, x0, y0);
  Frame& frame = *job.frame;
  const PixelRect rect{x0, y0, std::min(x0 + tile.size, frame.width),
                       std::min(y0 + tile.size, frame.height), tile.size};
  if (through_centers(settings)) {
    write_geometry_layers(*job.scene, *job.projection, settings.mode, rect, tile.batch.rays,
                          tile.batch.hits, job.at, frame);
  } else {
    write_geometry_layers(*job.scene, *job.projection, settings.mode, rect, job.at, frame,
                          tile.batch.rays, tile.batch.hits, tile.may_hit);
  }
}

}  // namespace backbend::render
