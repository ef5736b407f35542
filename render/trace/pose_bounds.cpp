#include "render/trace/pose_bounds.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

namespace backbend::render {
namespace {

constexpr float kHuge = std::numeric_limits<float>::max();

}  // namespace

PoseBounds::PoseBounds(std::span<const glm::uvec3> triangle, std::span<const glm::vec3> position,
                       float margin) {
  constexpr Box kEmpty{glm::vec3(kHuge), glm::vec3(-kHuge)};
  const auto join = [](Box& box, const Box& other) {
    box.low = glm::min(box.low, other.low);
    box.high = glm::max(box.high, other.high);
  };
  whole_ = kEmpty;
  for (const glm::vec3& p : position) join(whole_, {p, p});
  const float bottom = whole_.low.y, height = whole_.high.y - whole_.low.y;
  const float per_height = height > 0.0f ? kSlabs / height : 0.0f;
  const auto slab_at = [&](float y) {
    return std::clamp(static_cast<int>((y - bottom) * per_height), 0, kSlabs - 1);
  };
  using Slabs = std::array<Box, kSlabs>;
  Slabs empty;
  empty.fill(kEmpty);
  // The lowest and the highest of numbers do not depend on the order in which they are asked.
  const Slabs slabs = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, triangle.size(), 8192), empty,
      [&](const tbb::blocked_range<std::size_t>& range, Slabs found) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) {
          const glm::uvec3& t = triangle[i];
          Box box{position[t.x], position[t.x]};
          join(box, {position[t.y], position[t.y]});
          join(box, {position[t.z], position[t.z]});
          for (int s = slab_at(box.low.y); s <= slab_at(box.high.y); ++s) join(found[s], box);
        }
        return found;
      },
      [&](Slabs a, const Slabs& b) {
        for (int s = 0; s < kSlabs; ++s) join(a[s], b[s]);
        return a;
      });
  const auto widened = [margin](const Box& box) {
    return Box{box.low - margin, box.high + margin};
  };
  for (const Box& slab : slabs)
    if (slab.low.x <= slab.high.x) slab_.push_back(widened(slab));
  whole_ = widened(whole_);
}

// The slabs of T. Kay and J. Kajiya, "Ray Tracing Complex Scenes", SIGGRAPH 1986. A direction
// without extent along an axis has an inverse so large that only being inside decides.
Int8 PoseBounds::may_meet(const Box& box, const Vec8& origin, const Vec8& inverse, Float8 far) {
  Float8 enter = splat(0.0f), leave = far;
  const auto cut = [&](Float8 o, Float8 i, float low, float high) {
    const Float8 a = (low - o) * i, b = (high - o) * i;
    enter = max(enter, min(a, b));
    leave = min(leave, max(a, b));
  };
  cut(origin.x, inverse.x, box.low.x, box.high.x);
  cut(origin.y, inverse.y, box.low.y, box.high.y);
  cut(origin.z, inverse.z, box.low.z, box.high.z);
  return enter <= leave;
}

Int8 PoseBounds::may_meet(const Vec8& origin, const Vec8& direction, Float8 far) const {
  const auto inverse = [](Float8 d) {
    const Float8 least = splat(1e-30f);
    return 1.0f / (abs(d) < least ? least : d);
  };
  const Vec8 inverses{inverse(direction.x), inverse(direction.y), inverse(direction.z)};
  const Int8 near = may_meet(whole_, origin, inverses, far);
  Int8 met{};
  if (bits_of(near) == 0) return met;
  for (const Box& slab : slab_) {
    met |= near & may_meet(slab, origin, inverses, far);
    if (bits_of(met) == bits_of(near)) break;
  }
  return met;
}

std::vector<PoseBounds::Rect> PoseBounds::on_film(const Projection& camera) const {
  std::vector<Rect> rects;
  for (const Box& slab : slab_) {
    Rect rect{kHuge, kHuge, -kHuge, -kHuge};
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 at = camera.project({corner & 1 ? slab.high.x : slab.low.x,
                                            corner & 2 ? slab.high.y : slab.low.y,
                                            corner & 4 ? slab.high.z : slab.low.z});
      // Before the eye by a hundredth of its distance to the middle, or places mean little.
      const double size = glm::length(glm::dvec3(whole_.high) - glm::dvec3(whole_.low));
      if (!(at.z > 0.01 * size)) return {{-kHuge, -kHuge, kHuge, kHuge}};
      rect.x0 = std::min(rect.x0, at.x), rect.x1 = std::max(rect.x1, at.x);
      rect.y0 = std::min(rect.y0, at.y), rect.y1 = std::max(rect.y1, at.y);
    }
    rects.push_back(rect);
  }
  return rects;
}

}  // namespace backbend::render
