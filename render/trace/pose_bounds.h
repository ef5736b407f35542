#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "render/image/lanes.h"
#include "render/trace/projection.h"

namespace backbend::render {

/// Where a pose is, told by a stack of boxes: what certainly meets none of them needs no ray. It is
/// never wrong in saying that a ray misses, so pictures do not depend on it.
class PoseBounds {
 public:
  /// An axis-aligned rectangle of the film, pixels.
  struct Rect {
    double x0, y0, x1, y1;
  };

  PoseBounds() = default;
  /// `margin` is added all around, for the rounding of rays. Needs finite positions.
  PoseBounds(std::span<const glm::uvec3> triangle, std::span<const glm::vec3> position,
             float margin);

  /// Lanes whose ray may meet the pose before `far`, in units of the direction.
  Int8 may_meet(const Vec8& origin, const Vec8& direction, Float8 far) const;

  /// Rectangles that hold all of the pose on the film; one without end where some of it may lie
  /// beside or behind the eye.
  std::vector<Rect> on_film(const Projection& camera) const;

 private:
  static constexpr int kSlabs = 16;
  struct Box {
    glm::vec3 low, high;
  };
  static Int8 may_meet(const Box& box, const Vec8& origin, const Vec8& inverse, Float8 far);

  Box whole_{};
  std::vector<Box> slab_;  // from the lowest up; those without triangles are left out
};

}  // namespace backbend::render
