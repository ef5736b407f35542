#include "render/trace/contour.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "render/trace/frame_layers.h"

namespace backbend::render {
namespace {

constexpr float kOutline = 1.0f, kCrease = 0.75f, kRegion = 0.35f;
constexpr float kStep = 0.012f;         // of the depth: a jump between parts, not a slope
constexpr float kCreaseCosine = 0.80f;  // 37 degrees from one pixel to the next

bool empty(float depth) { return depth >= kBackgroundDepth; }

// Four pixels in a row; ink is wanted between the second and the third.
struct Row {
  std::size_t before, at, next, after;
};

float ink_between(const ContourInput& in, const Row& row) {
  const float here = in.depth[row.at], there = in.depth[row.next];
  if (empty(here) != empty(there)) return kOutline;
  if (empty(here)) return 0.0f;
  // A plane's inverse depth is linear across the image: a step is what neither side's slope
  // explains.
  const float change = 1.0f / there - 1.0f / here;
  float step = std::abs(change);
  const auto explain = [&](std::size_t from, std::size_t to) {
    if (from == to || empty(in.depth[from]) || empty(in.depth[to])) return;
    step = std::min(step, std::abs(change - (1.0f / in.depth[to] - 1.0f / in.depth[from])));
  };
  explain(row.before, row.at);
  explain(row.next, row.after);
  if (step * here > kStep) return kOutline;
  if (glm::dot(in.normal[row.at], in.normal[row.next]) < kCreaseCosine) return kCrease;
  return in.region[row.at] != in.region[row.next] ? kRegion : 0.0f;
}

}  // namespace

std::vector<float> find_contours(const ContourInput& in) {
  std::vector<float> ink(in.depth.size(), 0.0f);
  const auto index = [&](int x, int y) {
    return static_cast<std::size_t>(std::clamp(y, 0, in.height - 1)) * in.width +
           std::clamp(x, 0, in.width - 1);
  };
  for (int y = 0; y < in.height; ++y) {
    for (int x = 0; x < in.width; ++x) {
      const std::size_t at = index(x, y);
      const float right = ink_between(in, {index(x - 1, y), at, index(x + 1, y), index(x + 2, y)});
      const float down = ink_between(in, {index(x, y - 1), at, index(x, y + 1), index(x, y + 2)});
      // Both pixels of a pair are inked: lines are two wide at this resolution.
      const float most = std::max(right, down);
      ink[at] = std::max(ink[at], most);
      if (right > 0.0f) ink[index(x + 1, y)] = std::max(ink[index(x + 1, y)], right);
      if (down > 0.0f) ink[index(x, y + 1)] = std::max(ink[index(x, y + 1)], down);
    }
  }
  return ink;
}

}  // namespace backbend::render
