#pragma once
#include <array>
#include <cstdint>
#include <memory>

#include "render/trace/ray_device.h"
#include "render/trace/sampler.h"
#include "render/trace/scene_view.h"
#include "render/trace/studio.h"
#include "render/trace/surface.h"

namespace backbend::render {

/// What surfaces are made of while paths are traced.
enum class Surfacing { materials, clay, wireframe };

/// All that is fixed over one frame.
struct PathContext {
  const SceneView* scene;
  const Projection* projection;
  const Studio* studio;
  const Sampler* sampler;
  const std::uint32_t* pixels;  // the tile's part of the sampler's points, by packet
  Surfacing surfacing = Surfacing::clay;
  int bounces = 2;           // segments after the first hit
  bool transparent = false;  // no backdrop: alpha holds the character and its shadow
  int tile_pixels = 256;     // a power of two
};

/// Points taken per path: one for the film, three for every vertex.
constexpr int sampler_pairs(int bounces) { return 1 + 3 * (bounces + 1); }

/// Camera rays of one tile on their way to becoming colours, in packets of eight pixels with one
/// sample each, a tile's pixels after one another. Paths never move, so sums over them are always
/// taken in the same order.
struct PathBatch {
  static constexpr std::size_t kCapacity = 512;  // four shadow rays each fit one RayBatch
  using Column = std::array<float, kCapacity>;
  std::size_t count = 0;                       // a multiple of 8
  std::array<std::int32_t, kCapacity> sample;  // the same throughout a packet
  alignas(32) Column film_x, film_y;           // pixels
  RayBatch rays;                               // direction scaled to unit depth
  HitBatch hits;
  alignas(32) Column red, green, blue, alpha;  // results
  std::array<std::int16_t, kCapacity> region;  // what was seen; -1: nothing

  Vec8 origin(std::size_t first) const { return rays.packet_origin(first); }
  Vec8 direction(std::size_t first) const { return rays.packet_direction(first); }
};

/// Traces paths; holds the scratch memory of one thread.
class PathTracer {
 public:
  PathTracer();
  /// Fills the results of a batch whose camera rays have been traced.
  void trace(const PathContext& context, PathBatch& batch);

 private:
  friend class PathShader;

  /// Rays that wait for an answer, with what is added to which path if nothing is in the way.
  struct Shadows {
    RayBatch rays;
    std::array<std::int32_t, RayBatch::kCapacity + 8> path;
    RayBatch::Column red, green, blue;
    RayBatch::Column alpha;  // added if something is in the way
    std::array<std::uint8_t, RayBatch::kCapacity> blocked;
    std::size_t count = 0;
  };
  /// Rays that left a surface, with the share of their radiance that reaches the eye.
  struct Bounces {
    RayBatch rays;
    HitBatch hits;
    std::array<std::int32_t, RayBatch::kCapacity + 8> path;
    RayBatch::Column red, green, blue;
    RayBatch::Column pdf;  // with which the ray was chosen, per steradian
    std::size_t count = 0;
  };
  void flush_shadows(const PathContext& context, PathBatch& batch);

  std::unique_ptr<Shadows> shadows_;
  std::unique_ptr<Bounces> bounces_, next_;
};

}  // namespace backbend::render
