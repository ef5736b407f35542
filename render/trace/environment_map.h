#pragma once
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "render/image/frame.h"

namespace backbend::render {

/// A latitude-longitude picture as a light, sampled in proportion to its brightness.
/// The upper edge is +Y; the middle column is +Z and the right-hand quarter is -X, so that the
/// picture is seen as it hangs when looking along +Z.
class EnvironmentMap {
 public:
  struct Sample {
    glm::vec3 direction;  // unit
    glm::vec3 radiance;
    float pdf;  // per steradian, > 0
  };

  /// The picture is turned about +Y by `turn_rad`, from +Z towards +X.
  /// Throws RenderError for an empty picture, a negative or non-finite texel, or one that is black.
  explicit EnvironmentMap(Texture picture, double turn_rad = 0.0);

  glm::vec3 radiance(const glm::vec3& direction) const;
  float pdf(const glm::vec3& direction) const;
  Sample sample(glm::vec2 random) const;

 private:
  std::size_t texel_of(const glm::vec3& direction) const;

  Texture picture_;
  float turn_ = 0.0f;              // radians
  std::vector<float> row_cdf_;     // [height + 1], ends with 1
  std::vector<float> column_cdf_;  // [height][width + 1], each row ends with 1
};

}  // namespace backbend::render
