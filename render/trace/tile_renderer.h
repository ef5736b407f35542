#pragma once
#include <span>

#include "render/trace/frame_layers.h"
#include "render/trace/path_tracer.h"
#include "render/trace/pixel_filter.h"

namespace backbend::render {

/// One frame being rendered.
struct FrameJob {
  const SceneView* scene;
  const Projection* projection;
  const Studio* studio;
  const Sampler* sampler;
  const Settings* settings;
  const PixelFilter* filter;
  FrameLayers at;
  Frame* frame;
  std::vector<float> region_id;  // Cryptomatte ids by region
  float object_id;
  std::span<float> even_half, odd_half;  // means of every second sample, in triples, or empty
  std::vector<PoseBounds::Rect> seen;    // where on the film the pose may be
  int tile_size = kLargestTile;          // 16, 8 or 4
};

/// Renders one tile's samples into the frame. Tiles touch no common pixel, and what a tile holds
/// depends on nothing but its place: any order and any thread gives the same frame.
class TileRenderer {
 public:
  TileRenderer();
  ~TileRenderer();
  void render(const FrameJob& job, int x0, int y0);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace backbend::render
