#include "skin/deform/linear_blend.h"

#include <immintrin.h>

#include <cmath>
#include <glm/gtc/matrix_inverse.hpp>

#include "skin/character/matrix_facts.h"

namespace backbend::skin {
namespace {

/// Whether the 3x3 part turns and scales evenly, to float accuracy, without mirroring.
bool is_even(const glm::dmat3& m) {
  const glm::dmat3 square = glm::transpose(m) * m;
  const double scale = (square[0][0] + square[1][1] + square[2][2]) / 3.0;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r)
      if (!(std::abs(square[c][r] - (c == r ? scale : 0.0)) <= 2e-5 * scale)) return false;
  return glm::determinant(m) > 0.0;
}

glm::vec3 xyz(__m128 v) {
  alignas(16) float lane[4];
  _mm_store_ps(lane, v);
  return {lane[0], lane[1], lane[2]};
}

}  // namespace

glm::mat3 normal_matrix(const glm::dmat4& m) {
  const glm::dmat3 axes(m);
  if (is_even(axes) || !is_invertible(m)) return glm::mat3(axes);
  const double scale = std::cbrt(std::abs(glm::determinant(axes)));
  return glm::mat3(scale * scale * glm::inverseTranspose(axes));
}

glm::vec3 unit_or_up(const glm::vec3& v) {
  const float length = std::sqrt(std::fma(v.x, v.x, std::fma(v.y, v.y, v.z * v.z)));
  // One division and three products: the same in SkinningPlan, where divisions are what costs.
  return length > 0.0f ? v * (1.0f / length) : glm::vec3(0.0f, 1.0f, 0.0f);
}

JointMatrices joint_matrices(const std::vector<SkinJoint>& joints,
                             std::span<const glm::dmat4> world_from_node) {
  JointMatrices out;
  out.joint.resize(joints.size());
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const glm::dmat4 matrix =
        world_from_node[static_cast<std::size_t>(joints[j].node)] * joints[j].joint_from_mesh;
    const glm::mat3 normal = normal_matrix(matrix);
    out.uneven |= normal != glm::mat3(matrix);
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 4; ++r) {
        out.joint[j].point[c][r] = r < 3 ? static_cast<float>(matrix[c][r]) : 0.0f;
        if (c < 3) out.joint[j].normal[c][r] = r < 3 ? normal[c][r] : 0.0f;
      }
  }
  return out;
}

void blend_vertex(const JointMatrices& joints, const Influences& influences,
                  const glm::vec3& bind_position, const glm::vec3& bind_normal, glm::vec3& position,
                  glm::vec3& normal) {
  // In the order of joint numbers; at most eight, so that insertion is the quickest sort.
  std::uint8_t order[kMaxInfluences];
  std::size_t count = 0;
  for (; count < kMaxInfluences && influences.weight[count] > 0.0f; ++count) {
    std::size_t at = count;
    for (; at > 0 && influences.joint[order[at - 1]] > influences.joint[count]; --at)
      order[at] = order[at - 1];
    order[at] = static_cast<std::uint8_t>(count);
  }
  __m128 point[4], turn[3];
  for (std::size_t k = 0; k < count; ++k) {
    const JointMatrix& joint = joints.joint[influences.joint[order[k]]];
    const __m128 weight = _mm_set1_ps(influences.weight[order[k]]);
    for (int c = 0; c < 4; ++c) {
      const __m128 column = _mm_load_ps(joint.point[c]);
      point[c] = k == 0 ? _mm_mul_ps(weight, column) : _mm_fmadd_ps(weight, column, point[c]);
    }
    if (joints.uneven)
      for (int c = 0; c < 3; ++c) {
        const __m128 column = _mm_load_ps(joint.normal[c]);
        turn[c] = k == 0 ? _mm_mul_ps(weight, column) : _mm_fmadd_ps(weight, column, turn[c]);
      }
  }
  if (count == 0) {  // no joint: as it was bound
    position = bind_position;
    normal = unit_or_up(bind_normal);
    return;
  }
  const __m128* columns = joints.uneven ? turn : point;
  position = xyz(
      _mm_fmadd_ps(point[0], _mm_set1_ps(bind_position.x),
                   _mm_fmadd_ps(point[1], _mm_set1_ps(bind_position.y),
                                _mm_fmadd_ps(point[2], _mm_set1_ps(bind_position.z), point[3]))));
  normal = unit_or_up(
      xyz(_mm_fmadd_ps(columns[0], _mm_set1_ps(bind_normal.x),
                       _mm_fmadd_ps(columns[1], _mm_set1_ps(bind_normal.y),
                                    _mm_mul_ps(columns[2], _mm_set1_ps(bind_normal.z))))));
}

}  // namespace backbend::skin
