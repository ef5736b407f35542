#include "render/trace/path_tracer.h"

#include <bit>
#include <limits>

#include "render/trace/lighting.h"
#include "render/trace/shading.h"
#include "render/trace/wire.h"

namespace backbend::render {
namespace {

const Float8 kFar = splat(std::numeric_limits<float>::max());
constexpr glm::vec3 kInk(0.02f, 0.025f, 0.035f);
// Light that reached the eye by way of a narrow highlight is capped: one such path in a thousand
// would outshine its pixel for any number of samples worth waiting for.
constexpr float kIndirectCap = 8.0f;

Vec8 capped(const Vec8& light) {
  const Float8 most = splat(kIndirectCap);
  return {min(light.x, most), min(light.y, most), min(light.z, most)};
}

// The shading normal, turned towards the viewer where it faces away: along outlines interpolated
// normals do, and a coat has no colour from behind. The Lambert part does not ask.
Vec8 seen_normal(const Vec8& normal, const Vec8& out, const Bsdf8& bsdf) {
  if (!bsdf.has_coat) return normal;
  constexpr float kLeast = 0.02f;
  const Float8 lacking = max(kLeast - dot(normal, out), kZero);
  return normalize(normal + out * lacking);
}

// Distance along `direction` to the ground from above, in units of it; 0 where it is never met.
Float8 ground_distance(const Studio& studio, const Vec8& origin, const Vec8& direction) {
  if (!studio.has_ground) return kZero;
  const Int8 falling = direction.y < kZero;
  const Float8 t = (studio.ground_height - origin.y) / (falling ? direction.y : kOne);
  return falling ? max(t, kZero) : kZero;
}

// How much of a shadow at a point of the ground is shown: all near the character, none far away.
Float8 shadow_presence(const Studio& studio, const Vec8& point) {
  const Float8 x = point.x - studio.ground_center.x, z = point.z - studio.ground_center.z;
  return clamp(2.0f - 2.0f / studio.ground_reach * sqrt(x * x + z * z), 0.0f, 1.0f);
}

}  // namespace

/// Shading of one packet after another at one bounce; 0 is what the camera sees.
class PathShader {
 public:
  PathShader(const PathContext& context, PathBatch& batch, PathTracer& tracer, int bounce)
      : context_(context),
        batch_(batch),
        shadows_(*tracer.shadows_),
        next_(*tracer.next_),
        bounce_(bounce) {}

  void camera_packet(std::size_t first);
  void bounce_packet(const PathTracer::Bounces& arrived, std::size_t first);

 private:
  /// Which paths a packet belongs to, and what it takes from the sampler.
  struct Lanes {
    Int8 path;
    Int8 sample;
    Int8 pixel;      // of the tile
    bool is_packet;  // still one sample of eight neighbouring pixels
  };
  Point8 points(const Lanes& lanes, int pair) const {
    const int index = 1 + 3 * bounce_ + pair;
    const Sampler& sampler = *context_.sampler;
    if (!lanes.is_packet) return sampler.points(lanes.sample, index, context_.pixels, lanes.pixel);
    const std::size_t packet = static_cast<std::size_t>(lanes.pixel[0]) / 8;
    return sampler.points(lanes.sample[0], index,
                          context_.pixels + packet * sampler.words_per_packet());
  }
  Bsdf8 bsdf_of(Surface8& surface, Int8 mask, std::size_t camera_first) const;
  void scatter(const Lanes& lanes, Int8 mask, const Vec8& throughput, const LitPoints8& lit);
  void catch_shadow(const Lanes& lanes, Int8 mask, const Vec8& ground, const Vec8& behind);
  void wait_for(const Lanes& lanes, Int8 mask, const Vec8& from, const Vec8& direction, Float8 far,
                const Vec8& radiance, Float8 alpha);
  void add(Int8 path, Int8 mask, const Vec8& radiance) const;

  const PathContext& context_;
  PathBatch& batch_;
  PathTracer::Shadows& shadows_;
  PathTracer::Bounces& next_;
  int bounce_;
};

Bsdf8 PathShader::bsdf_of(Surface8& surface, Int8 mask, std::size_t camera_first) const {
  if (context_.surfacing == Surfacing::materials)
    return material_at(*context_.scene, surface, bits_of(mask));
  Vec8 clay = splat(kClayAlbedo);
  if (context_.surfacing == Surfacing::wireframe && bounce_ == 0) {
    for (unsigned left = bits_of(mask); left != 0; left &= left - 1) {
      const auto lane = static_cast<unsigned>(std::countr_zero(left));
      const float line = wire_coverage(
          *context_.scene, *context_.projection, static_cast<std::uint32_t>(surface.triangle[lane]),
          {batch_.film_x[camera_first + lane], batch_.film_y[camera_first + lane]});
      clay.set_lane(lane, kClayAlbedo + (kInk - kClayAlbedo) * line);
    }
  }
  return lambert(clay);
}

void PathShader::wait_for(const Lanes& lanes, Int8 mask, const Vec8& from, const Vec8& direction,
                          Float8 far, const Vec8& radiance, Float8 alpha) {
  const Compress kept(mask);
  const std::size_t at = shadows_.count;
  shadows_.rays.append(at, kept, from, direction, far);
  kept.write(&shadows_.path[at], lanes.path);
  kept.write(&shadows_.red[at], radiance.x);
  kept.write(&shadows_.green[at], radiance.y);
  kept.write(&shadows_.blue[at], radiance.z);
  kept.write(&shadows_.alpha[at], alpha);
  shadows_.count += kept.count();
}

void PathShader::add(Int8 path, Int8 mask, const Vec8& radiance) const {
  for (unsigned left = bits_of(mask); left != 0; left &= left - 1) {
    const auto lane = static_cast<unsigned>(std::countr_zero(left));
    const auto to = static_cast<std::size_t>(path[lane]);
    batch_.red[to] += radiance.x[lane];
    batch_.green[to] += radiance.y[lane];
    batch_.blue[to] += radiance.z[lane];
  }
}

// Sends shadow rays towards lights and one ray on, for the lanes of `mask`.
void PathShader::scatter(const Lanes& lanes, Int8 mask, const Vec8& throughput,
                         const LitPoints8& lit) {
  const Studio& studio = *context_.studio;
  const Point8 on_light = points(lanes, 0);
  // Where the path ends no ray of the surface's own will meet the lights.
  const Finders by = bounce_ < context_.bounces ? Finders::light_and_surface : Finders::light_alone;
  const auto ask = [&](const Direct8& direct) {
    Vec8 radiance = throughput * direct.radiance;
    if (bounce_ > 0) radiance = capped(radiance);
    wait_for(lanes, mask & (luminance(radiance) > kZero), lit.from, direct.to_light, direct.far,
             radiance, kZero);
  };
  if (bounce_ == 0 && !studio.environment) {
    // What the camera sees directly is lit by every light: two more shadow rays take away a third
    // of the noise for a tenth of the time.
    for (const AreaLight& light : studio.light) ask(sample_light(light, lit, on_light, by));
  } else {
    ask(sample_any_light(studio, lit, on_light, by));
  }
  if (bounce_ >= context_.bounces) return;
  const Float8 lobe = lit.bsdf->has_coat ? points(lanes, 2).x : kZero;
  const BsdfSample8 s = sample_bsdf(*lit.bsdf, lit.normal, lit.out, points(lanes, 1), lobe);
  const Compress kept(mask & (s.pdf > kZero) & (dot(s.in, lit.geometric) > kZero));
  const Vec8 weight = throughput * s.weight;
  const std::size_t at = next_.count;
  next_.rays.append(at, kept, lit.from, s.in, kFar);
  kept.write(&next_.path[at], lanes.path);
  kept.write(&next_.red[at], weight.x);
  kept.write(&next_.green[at], weight.y);
  kept.write(&next_.blue[at], weight.z);
  kept.write(&next_.pdf[at], s.pdf);
  next_.count += kept.count();
}

// The shadow catcher: the backdrop, darkened by the share of light the character keeps away.
void PathShader::catch_shadow(const Lanes& lanes, Int8 mask, const Vec8& ground,
                              const Vec8& behind) {
  const Studio& studio = *context_.studio;
  const Vec8 up = splat(glm::vec3(0.0f, 1.0f, 0.0f));
  const Vec8 from = ground + up * splat(1e-4f * context_.scene->rest_radius);
  const Bsdf8 white = lambert(splat(glm::vec3(1.0f)));
  const LitPoints8 lit{from, up, up, up, &white};
  const Point8 on_light = points(lanes, 0);
  std::array<Direct8, 3> direct;
  std::size_t count = 0;
  if (studio.environment) {
    direct[count++] = sample_any_light(studio, lit, on_light, Finders::light_alone);
  } else {
    for (const AreaLight& light : studio.light)
      direct[count++] = sample_light(light, lit, on_light, Finders::light_alone);
  }
  const Float8 sky =
      studio.environment ? kZero : splat(studio.sky_on_ground_luminance / 3.14159265f);
  Float8 sum = sky;
  for (std::size_t i = 0; i < count; ++i) sum += luminance(direct[i].radiance);
  const Float8 scale =
      sum > kZero ? shadow_presence(studio, ground) / (sum > kZero ? sum : kOne) : kZero;
  const Float8 shade = context_.transparent ? kOne : kZero;
  Float8 certain = kOne;
  const auto ask = [&](const Vec8& to_light, Float8 far, Float8 light) {
    // Light that nothing can keep away is there without being asked for.
    const Int8 asked = mask & context_.scene->bounds.may_meet(from, to_light, far);
    const Float8 share = asked ? light * scale : kZero;
    certain -= share;
    wait_for(lanes, share > kZero, from, to_light, far, behind * share, share * shade);
  };
  for (std::size_t i = 0; i < count; ++i)
    ask(direct[i].to_light, direct[i].far, luminance(direct[i].radiance));
  ask(sample_cosine(up, points(lanes, 1)), kFar, sky);
  add(lanes.path, mask, behind * max(certain, kZero));
}

void PathShader::camera_packet(std::size_t first) {
  const Studio& studio = *context_.studio;
  const Vec8 origin = batch_.origin(first), direction = batch_.direction(first);
  const Int8 triangle = batch_.hits.packet(first);
  const Int8 hit = triangle >= 0;
  const Int8 path = splat(static_cast<int>(first)) + Int8{0, 1, 2, 3, 4, 5, 6, 7};
  const Lanes lanes{path, load(&batch_.sample[first]), path & (context_.tile_pixels - 1), true};
  store(&batch_.red[first], kZero);
  store(&batch_.green[first], kZero);
  store(&batch_.blue[first], kZero);
  store(&batch_.alpha[first], context_.transparent ? (hit ? kOne : kZero) : kOne);
  const unsigned hit_bits = bits_of(hit);
  for (unsigned lane = 0; lane < 8; ++lane) batch_.region[first + lane] = -1;
  if (hit_bits != 0) {
    Surface8 surface = surface_at(*context_.scene, hit ? triangle : splat(0), origin, direction);
    for (unsigned left = hit_bits; left != 0; left &= left - 1) {
      const auto lane = static_cast<unsigned>(std::countr_zero(left));
      batch_.region[first + lane] = region_at(*context_.scene->mesh, surface, lane);
    }
    const Bsdf8 bsdf = bsdf_of(surface, hit, first);
    const Vec8 out = -normalize(direction);
    scatter(
        lanes, hit, splat(glm::vec3(1.0f)),
        {surface.launch, seen_normal(surface.shading, out, bsdf), surface.geometric, out, &bsdf});
  }
  if (hit_bits == 0xffu) return;
  const Projection& projection = *context_.projection;
  const Vec8 behind =
      context_.transparent
          ? splat(glm::vec3(0.0f))
          : backdrop(load(&batch_.film_x[first]) / static_cast<float>(projection.width),
                     load(&batch_.film_y[first]) / static_cast<float>(projection.height));
  const Float8 t = ground_distance(studio, origin, direction);
  const Vec8 ground = origin + direction * t;
  const Int8 shaded = ~hit & (t > kZero) & (shadow_presence(studio, ground) > kZero);
  add(lanes.path, ~hit & ~shaded, behind);
  if (bits_of(shaded) != 0) catch_shadow(lanes, shaded, ground, behind);
}

void PathShader::bounce_packet(const PathTracer::Bounces& arrived, std::size_t first) {
  const Studio& studio = *context_.studio;
  const Int8 alive = first_lanes(arrived.count - first);
  const Vec8 origin = arrived.rays.packet_origin(first);
  const Vec8 direction = arrived.rays.packet_direction(first);
  const Vec8 throughput{load(&arrived.red[first]), load(&arrived.green[first]),
                        load(&arrived.blue[first])};
  // Lanes past the last ray must not index anything.
  const Int8 path = alive ? load(&arrived.path[first]) : splat(0);
  const Int8 triangle = arrived.hits.packet(first);
  const Int8 hit = alive & (triangle >= 0);
  const Lanes lanes{path, gather(batch_.sample.data(), path), path & (context_.tile_pixels - 1),
                    false};
  if (bits_of(hit) != 0) {
    Surface8 surface = surface_at(*context_.scene, hit ? triangle : splat(0), origin, direction);
    const Bsdf8 bsdf = bsdf_of(surface, hit, 0);
    scatter(lanes, hit, throughput,
            {surface.launch, seen_normal(surface.shading, -direction, bsdf), surface.geometric,
             -direction, &bsdf});
  }
  const Float8 t = ground_distance(studio, origin, direction);
  const Int8 grounded = alive & ~hit & (t > kZero);
  if (bits_of(grounded) != 0) {
    const Vec8 up = splat(glm::vec3(0.0f, 1.0f, 0.0f));
    const Vec8 from = origin + direction * t + up * splat(1e-4f * context_.scene->rest_radius);
    const Bsdf8 ground = lambert(splat(studio.ground_albedo));
    scatter(lanes, grounded, throughput, {from, up, up, -direction, &ground});
  }
  const Int8 escaped = alive & ~hit & ~grounded;
  if (bits_of(escaped) != 0) {
    const Float8 pdf = load(&arrived.pdf[first]);
    add(path, escaped, capped(throughput * escaped_radiance(studio, origin, direction, pdf)));
  }
}

PathTracer::PathTracer()
    : shadows_(std::make_unique<Shadows>()),
      bounces_(std::make_unique<Bounces>()),
      next_(std::make_unique<Bounces>()) {}

void PathTracer::flush_shadows(const PathContext& context, PathBatch& batch) {
  Shadows& s = *shadows_;
  context.scene->rays->occluded(s.rays, s.count, s.blocked.data());
  for (std::size_t i = 0; i < s.count; ++i) {
    const auto path = static_cast<std::size_t>(s.path[i]);
    if (s.blocked[i]) {
      batch.alpha[path] += s.alpha[i];
    } else {
      batch.red[path] += s.red[i];
      batch.green[path] += s.green[i];
      batch.blue[path] += s.blue[i];
    }
  }
  s.count = 0;
}

void PathTracer::trace(const PathContext& context, PathBatch& batch) {
  shadows_->count = next_->count = 0;
  PathShader camera(context, batch, *this, 0);
  for (std::size_t first = 0; first < batch.count; first += 8) camera.camera_packet(first);
  flush_shadows(context, batch);
  for (int bounce = 1; bounce <= context.bounces && next_->count > 0; ++bounce) {
    std::swap(bounces_, next_);
    next_->count = 0;
    context.scene->rays->nearest(bounces_->rays, bounces_->count, Coherence::scattered,
                                 bounces_->hits);
    PathShader shader(context, batch, *this, bounce);
    for (std::size_t first = 0; first < bounces_->count; first += 8)
      shader.bounce_packet(*bounces_, first);
    flush_shadows(context, batch);
  }
}

}  // namespace backbend::render
