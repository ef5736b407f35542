#pragma once
#include <optional>
#include <vector>

#include "render/trace/projection.h"
#include "render/trace/scene_view.h"

namespace backbend::render {

/// Depth written where a ray meets nothing; infinity upsets viewers, and Blender writes the same.
inline constexpr float kBackgroundDepth = 1e10f;

/// Where the layers of one frame lie in Frame::layers; -1: not asked for.
struct FrameLayers {
  int beauty = -1, depth = -1, normal = -1, object_matte = -1, region_matte = -1;
  int position = -1, albedo = -1, rest_position = -1, motion = -1, object_id = -1, triangle_id = -1;
  int variance = -1, heat = -1, sample_count = -1;
};

/// Adds every layer that `settings` asks for to `frame`, filled with what background pixels hold.
FrameLayers add_layers(Frame& frame, const SceneView& scene, const Settings& settings);

/// Bytes of all layers that `settings` asks for.
double layer_bytes(const SceneView& scene, const Settings& settings);

/// Adds only what lines are drawn from: depth, normal and region.
FrameLayers add_geometry_layers(Frame& frame);

/// The pixels of a tile that lie within the frame.
struct PixelRect {
  int x0, y0, x1, y1;
  int tile_size;  // pixels along an edge of the whole tile
};

/// Writes the geometry layers of a rectangle from one ray through each pixel's centre: unfiltered,
/// so that no pixel mixes two surfaces. `may_hit`: as RayScene::nearest() has it. `rays` and
/// `hits` are memory to work in.
void write_geometry_layers(const SceneView& scene, const Projection& projection, Mode mode,
                           const PixelRect& rect, const FrameLayers& at, Frame& frame,
                           RayBatch& rays, HitBatch& hits,
                           std::span<const std::uint8_t> may_hit = {});

/// The same for rays that were already traced through the centres of all pixels of the tile, in
/// blocks of 4 x 2.
void write_geometry_layers(const SceneView& scene, const Projection& projection, Mode mode,
                           const PixelRect& rect, const RayBatch& rays, const HitBatch& hits,
                           const FrameLayers& at, Frame& frame);

inline constexpr int kLargestTile = 16;  // pixels along an edge; 256 camera rays a sample
inline constexpr std::size_t kMostTilePixels = kLargestTile * kLargestTile;

/// Where lane `lane` of packet `packet` lies in a tile of `size` x `size` pixels: packets are
/// blocks of 4 x 2 pixels.
constexpr int tile_x(int size, std::size_t packet, unsigned lane) {
  return static_cast<int>(packet % (static_cast<std::size_t>(size) / 4) * 4 + lane % 4);
}
constexpr int tile_y(int size, std::size_t packet, unsigned lane) {
  return static_cast<int>(packet / (static_cast<std::size_t>(size) / 4) * 2 + lane / 4);
}

}  // namespace backbend::render
