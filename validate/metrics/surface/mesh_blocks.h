#pragma once
// How the blocks of MeshRest are read: between the mesh's preparation and its measuring.
#include <glm/geometric.hpp>

#include "validate/metrics/math/float_lanes.h"
#include "validate/metrics/surface/mesh.h"

namespace backbend::validate {

/// The corners of a block's triangles.
struct BlockCorners {
  VectorLanes p[3];
};

/// The sum of triple products, lane by lane, in double precision.
class VolumeSum {
 public:
  explicit VolumeSum(const glm::dvec3& middle) : middle_(middle) {}

  void add(const BlockCorners& corners, std::uint32_t present) {
    for (int half = 0; half < 2; ++half) {
      const Wide a = wide(corners.p[0], half), b = wide(corners.p[1], half),
                 c = wide(corners.p[2], half);
      const __m256d x = _mm256_sub_pd(_mm256_mul_pd(b.y, c.z), _mm256_mul_pd(c.y, b.z)),
                    y = _mm256_sub_pd(_mm256_mul_pd(b.z, c.x), _mm256_mul_pd(c.z, b.x)),
                    z = _mm256_sub_pd(_mm256_mul_pd(b.x, c.y), _mm256_mul_pd(c.x, b.y));
      __m256d six = _mm256_add_pd(_mm256_add_pd(_mm256_mul_pd(a.x, x), _mm256_mul_pd(a.y, y)),
                                  _mm256_mul_pd(a.z, z));
      if (present != 0xff) {
        alignas(32) double lane[4];
        _mm256_store_pd(lane, six);
        for (int i = 0; i < 4; ++i)
          if (!(present >> (4 * half + i) & 1)) lane[i] = 0.0;
        six = _mm256_load_pd(lane);
      }
      sum_[half] = _mm256_add_pd(sum_[half], six);
    }
  }
  double volume() const {
    alignas(32) double lane[4];
    _mm256_store_pd(lane, _mm256_add_pd(sum_[0], sum_[1]));
    return ((lane[0] + lane[1]) + (lane[2] + lane[3])) / 6.0;
  }

 private:
  struct Wide {
    __m256d x, y, z;
  };
  static __m256d widened(FloatLanes v, int half) {
    return _mm256_cvtps_pd(half == 0 ? _mm256_castps256_ps128(v.v) : _mm256_extractf128_ps(v.v, 1));
  }
  Wide wide(const VectorLanes& v, int half) const {
    return {_mm256_sub_pd(widened(v.x, half), _mm256_set1_pd(middle_.x)),
            _mm256_sub_pd(widened(v.y, half), _mm256_set1_pd(middle_.y)),
            _mm256_sub_pd(widened(v.z, half), _mm256_set1_pd(middle_.z))};
  }

  glm::dvec3 middle_;
  __m256d sum_[2] = {_mm256_setzero_pd(), _mm256_setzero_pd()};
};

/// Where a block's triangles should face (see Facing), of any length. `joint` from face_turns(), of
/// a mesh whose joints are known.
inline VectorLanes turned_faces(const MeshRest& rest, const MeshRest::Block& block,
                                std::span<const glm::mat3> joint) {
  const FloatLanes x = FloatLanes::load(block.normal[0]), y = FloatLanes::load(block.normal[1]),
                   z = FloatLanes::load(block.normal[2]);
  VectorLanes corner[3]{glm::vec3(0.0f), glm::vec3(0.0f), glm::vec3(0.0f)};
  for (std::uint32_t i = block.first_carrier; i < block.first_carrier + block.carriers; ++i) {
    const MeshRest::Carrier& carrier = rest.carrier[i];
    const glm::mat3& m = joint[carrier.joint];
    const VectorLanes turned =
        x * VectorLanes(m[0]) + y * VectorLanes(m[1]) + z * VectorLanes(m[2]);
    for (int k = 0; k < 3; ++k)
      corner[k] = corner[k] + FloatLanes::load(carrier.weight[k]) * turned;
  }
  // A corner that no joint moves says nothing.
  constexpr float kLeast = 1e-30f;
  VectorLanes sum(glm::vec3(0.0f));
  for (const VectorLanes& each : corner)
    sum = sum + FloatLanes(1.0f) / square_root(larger(dot(each, each), kLeast)) * each;
  return sum;
}

/// Cosine and sine of the angle that the second face is turned by about the edge.
struct Fold {
  float cosine, sine;
};
inline Fold fold(const glm::vec3& first, const glm::vec3& second, const glm::vec3& edge) {
  const float cosine = glm::dot(first, second);
  const float sine = glm::dot(glm::cross(first, second), edge) / glm::length(edge);
  const float length = std::sqrt(cosine * cosine + sine * sine);
  return length > 0.0f ? Fold{cosine / length, sine / length} : Fold{1.0f, 0.0f};
}

}  // namespace backbend::validate
