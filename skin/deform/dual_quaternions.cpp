#include "skin/deform/dual_quaternions.h"

#include <immintrin.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <glm/gtc/matrix_inverse.hpp>

#include "skin/character/matrix_facts.h"
#include "skin/deform/eight_vertices.h"
#include "skin/deform/linear_blend.h"
#include "skin/deform/rest_matrices.h"
#include "skin/deform/skinning.h"

namespace backbend::skin {
namespace {

// A joint that stretches by less does not stretch: float matrices of rigid motions round so far.
constexpr float kNoStretch = 1e-6f;
constexpr std::size_t kWidth = 8;
constexpr std::size_t kGrain = 256;  // blocks a task: far more work than a task costs

/// The rotation nearest to `m`, by Newton's iteration on its inverse transpose.
/// Source: N. Higham, "Computing the Polar Decomposition with Applications", 1986.
glm::dmat3 nearest_rotation(glm::dmat3 m) {
  for (int step = 0; step < 32; ++step) {
    const glm::dmat3 next = 0.5 * (m + glm::inverseTranspose(m));
    double change = 0.0;
    for (int c = 0; c < 3; ++c) change += glm::length(next[c] - m[c]);
    m = next;
    if (change < 1e-15) break;
  }
  return m;
}

DualQuaternion motion(const glm::dmat4& from_rest) {
  DualQuaternion out;
  // A mirrored or collapsed joint has no rotation to blend: all of it is stretch then.
  const bool turns = is_invertible(from_rest) && glm::determinant(glm::dmat3(from_rest)) > 0.0;
  const glm::dmat3 rotation = turns ? nearest_rotation(glm::dmat3(from_rest)) : glm::dmat3(1.0);
  const glm::dquat turn = glm::normalize(glm::quat_cast(rotation));
  const glm::dvec3 shift = origin(from_rest);
  out.turn = glm::quat(turn);
  out.shift = glm::quat(0.5 * (glm::dquat(0.0, shift.x, shift.y, shift.z) * turn));
  out.added_stretch = glm::mat3(glm::transpose(rotation) * glm::dmat3(from_rest) - glm::dmat3(1.0));
  float most = 0.0f;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) most = std::max(most, std::abs(out.added_stretch[c][r]));
  out.stretches = !(most <= kNoStretch);
  if (!out.stretches) out.added_stretch = glm::mat3(0.0f);
  return out;
}

/// Without `kStretch` no joint stretches.
template <bool kStretch>
void blend(const std::vector<DualQuaternion>& motions, const Influences& influences,
           glm::vec3& position, glm::vec3& normal) {
  const glm::quat& lead = motions[influences.joint[0]].turn;
  glm::quat turn(0.0f, 0.0f, 0.0f, 0.0f), shift(0.0f, 0.0f, 0.0f, 0.0f);
  // Summed as what it adds to the identity, so that rest comes out exactly.
  glm::mat3 stretch(1.0f);
  for (std::size_t k = 0; k < kMaxInfluences && influences.weight[k] > 0.0f; ++k) {
    const DualQuaternion& joint = motions[influences.joint[k]];
    // q and -q are one rotation: take the one on the side of the largest weight.
    const float weight =
        glm::dot(lead, joint.turn) < 0.0f ? -influences.weight[k] : influences.weight[k];
    turn = turn + weight * joint.turn;
    shift = shift + weight * joint.shift;
    if constexpr (kStretch) stretch += influences.weight[k] * joint.added_stretch;
  }
  const float size = std::sqrt(glm::dot(turn, turn));
  if (!(size > 0.0f)) return;
  turn = turn / size;
  shift = shift / size;
  const glm::quat moved = 2.0f * (shift * glm::conjugate(turn));
  if constexpr (kStretch) {
    position = stretch * position;
    normal = normal_matrix(glm::dmat4(stretch)) * normal;
  }
  position = turn * position + glm::vec3(moved.x, moved.y, moved.z);
  normal = unit_or_up(turn * normal);
}

}  // namespace

JointMotions joint_motions(const std::vector<SkinJoint>& joints,
                           const std::vector<glm::dmat4>& rest,
                           const std::vector<glm::dmat4>& world_from_node) {
  JointMotions out;
  for (const SkinJoint& joint : joints) {
    const auto node = static_cast<std::size_t>(joint.node);
    out.joint.push_back(motion(world_from_node[node] == rest[node] || !is_invertible(rest[node])
                                   ? glm::dmat4(1.0)
                                   : world_from_node[node] * glm::affineInverse(rest[node])));
    out.stretch = out.stretch || out.joint.back().stretches;
  }
  return out;
}

void blend_dual_quaternions(const JointMotions& motions, const Influences& influences,
                            glm::vec3& position, glm::vec3& normal) {
  if (motions.stretch)
    blend<true>(motions.joint, influences, position, normal);
  else
    blend<false>(motions.joint, influences, position, normal);
}

/// The rigid part of one joint's motion, so that one load fetches it.
struct alignas(32) DualQuaternionPlan::Motion {
  float turn[4];  // x, y, z, w
  float shift[4];
};

DualQuaternionPlan::DualQuaternionPlan(const Character& character)
    : joint_(character.joints),
      rest_node_(rest_matrices(character)),
      influences_(character.influences),
      rest_(rest_mesh(character)) {
  const std::size_t vertices = character.vertex_count();
  for (std::size_t first = 0; first < vertices; first += kWidth) {
    std::array<std::size_t, kWidth> vertex{};
    for (std::size_t l = 0; l < kWidth; ++l) vertex[l] = std::min(first + l, vertices - 1);
    Block block;
    block.joints = static_cast<std::uint32_t>(joints_.size());
    const auto has = [&](std::size_t v, std::size_t k) {
      // The list ends at the first weight that is not above 0.
      const auto& weight = influences_[v].weight;
      return std::all_of(weight.begin(), weight.begin() + static_cast<std::ptrdiff_t>(k) + 1,
                         [](float w) { return w > 0.0f; });
    };
    for (std::size_t k = 0; k < kMaxInfluences; ++k) {
      if (std::none_of(vertex.begin(), vertex.end(), [&](std::size_t v) { return has(v, k); }))
        break;
      Joints& joints = joints_.emplace_back();
      for (std::size_t l = 0; l < kWidth; ++l) {
        // What adds nothing is the vertex's first joint, whatever that does.
        const Influences& influences = influences_[vertex[l]];
        const bool counts = has(vertex[l], k);
        joints[l] = influences.joint[counts ? k : 0];
        weights_.push_back(counts ? influences.weight[k] : 0.0f);
      }
      if (std::ranges::all_of(joints, [&](std::uint16_t j) { return j == joints[0]; }))
        block.alike = static_cast<std::uint8_t>(block.alike | 1u << k);
      ++block.count;
    }
    blocks_.push_back(block);
    for (const std::vector<glm::vec3>* from : {&rest_.position, &rest_.normal})
      for (int axis = 0; axis < 3; ++axis)
        for (const std::size_t v : vertex) data_.push_back((*from)[v][axis]);
  }
}

namespace {

/// A quaternion of each of eight vertices.
struct Quaternions {
  __m256 x, y, z, w;
};

__m256 mul(__m256 a, __m256 b) { return _mm256_mul_ps(a, b); }
__m256 add(__m256 a, __m256 b) { return _mm256_add_ps(a, b); }
__m256 sub(__m256 a, __m256 b) { return _mm256_sub_ps(a, b); }

// Every step as glm does it for one vertex, so that the bits agree.

__m256 dot(const Quaternions& a, const Quaternions& b) {
  return add(add(mul(a.w, b.w), mul(a.x, b.x)), add(mul(a.y, b.y), mul(a.z, b.z)));
}

Triple cross(const Triple& a, const Triple& b) {
  return {sub(mul(a.y, b.z), mul(b.y, a.z)), sub(mul(a.z, b.x), mul(b.z, a.x)),
          sub(mul(a.x, b.y), mul(b.x, a.y))};
}

Triple turned(const Quaternions& by, const Triple& v) {
  const Triple axis{by.x, by.y, by.z};
  const Triple once = cross(axis, v), twice = cross(axis, once);
  const auto moved = [&](__m256 at, __m256 first, __m256 second) {
    return add(at, mul(add(mul(first, by.w), second), _mm256_set1_ps(2.0f)));
  };
  return {moved(v.x, once.x, twice.x), moved(v.y, once.y, twice.y), moved(v.z, once.z, twice.z)};
}

/// Both parts of eight motions, one load each, turned so that each part's x, y, z, w stand apart.
[[gnu::always_inline]] inline void gather(const float* motion, const std::uint16_t* joint,
                                          Quaternions& turn, Quaternions& shift) {
  __m256 row[8];
  for (int l = 0; l < 8; ++l) row[l] = _mm256_load_ps(motion + 8 * std::size_t{joint[l]});
  // Of each row the low half is the turn, the high half the shift: 4x4 transposes in both halves,
  // then halves of vertices 0 to 3 and 4 to 7 together.
  const auto transposed = [](const __m256* r, __m256(&out)[4]) {
    const __m256 a = _mm256_unpacklo_ps(r[0], r[1]), b = _mm256_unpackhi_ps(r[0], r[1]);
    const __m256 c = _mm256_unpacklo_ps(r[2], r[3]), d = _mm256_unpackhi_ps(r[2], r[3]);
    out[0] = _mm256_shuffle_ps(a, c, _MM_SHUFFLE(1, 0, 1, 0));
    out[1] = _mm256_shuffle_ps(a, c, _MM_SHUFFLE(3, 2, 3, 2));
    out[2] = _mm256_shuffle_ps(b, d, _MM_SHUFFLE(1, 0, 1, 0));
    out[3] = _mm256_shuffle_ps(b, d, _MM_SHUFFLE(3, 2, 3, 2));
  };
  __m256 low[4], high[4];
  transposed(row, low);
  transposed(row + 4, high);
  const auto turns = [&](int i) { return _mm256_permute2f128_ps(low[i], high[i], 0x20); };
  const auto shifts = [&](int i) { return _mm256_permute2f128_ps(low[i], high[i], 0x31); };
  turn = {turns(0), turns(1), turns(2), turns(3)};
  shift = {shifts(0), shifts(1), shifts(2), shifts(3)};
}

[[gnu::always_inline]] inline void broadcast(const float* motion, Quaternions& turn,
                                             Quaternions& shift) {
  const auto all = [&](int i) { return _mm256_broadcast_ss(motion + i); };
  turn = {all(0), all(1), all(2), all(3)};
  shift = {all(4), all(5), all(6), all(7)};
}

}  // namespace

/// Eight vertices, or in the last block of a mesh as many as are left (not `kWhole`).
template <bool kWhole>
void DualQuaternionPlan::skin_block(const Motion* motions, std::size_t number, glm::vec3* position,
                                    glm::vec3* normal) const {
  const Block& block = blocks_[number];
  const float* motion = motions->turn;
  const __m256 zero = _mm256_setzero_ps(), minus = _mm256_set1_ps(-0.0f);
  Quaternions lead{}, turn{zero, zero, zero, zero}, shift = turn;
  for (std::size_t k = 0; k < block.count; ++k) {
    const Joints& joint = joints_[block.joints + k];
    Quaternions of_turn, of_shift;
    if ((block.alike >> k & 1u) != 0)
      broadcast(motion + 8 * std::size_t{joint[0]}, of_turn, of_shift);
    else
      gather(motion, joint.data(), of_turn, of_shift);
    __m256 weight = _mm256_loadu_ps(&weights_[kWidth * (block.joints + k)]);
    if (k == 0) lead = of_turn;
    const __m256 other_side = _mm256_cmp_ps(dot(lead, of_turn), zero, _CMP_LT_OQ);
    weight = _mm256_xor_ps(weight, _mm256_and_ps(other_side, minus));
    const auto sum = [&](Quaternions& to, const Quaternions& from) {
      to.x = add(to.x, mul(from.x, weight));
      to.y = add(to.y, mul(from.y, weight));
      to.z = add(to.z, mul(from.z, weight));
      to.w = add(to.w, mul(from.w, weight));
    };
    sum(turn, of_turn);
    sum(shift, of_shift);
  }
  const float* data = &data_[6 * kWidth * number];
  const auto lane = [&](std::size_t i) { return _mm256_loadu_ps(data + kWidth * i); };
  const Triple rest{lane(0), lane(1), lane(2)}, rest_normal{lane(3), lane(4), lane(5)};
  const __m256 size = _mm256_sqrt_ps(dot(turn, turn));
  const auto over_size = [&](const Quaternions& q) {
    return Quaternions{_mm256_div_ps(q.x, size), _mm256_div_ps(q.y, size), _mm256_div_ps(q.z, size),
                       _mm256_div_ps(q.w, size)};
  };
  const Quaternions q = over_size(turn), p = over_size(shift);
  // 2 p conjugate(q)
  const __m256 qx = _mm256_xor_ps(q.x, minus), qy = _mm256_xor_ps(q.y, minus),
               qz = _mm256_xor_ps(q.z, minus);
  const __m256 two = _mm256_set1_ps(2.0f);
  const Triple moved{
      mul(sub(add(add(mul(p.w, qx), mul(p.x, q.w)), mul(p.y, qz)), mul(p.z, qy)), two),
      mul(sub(add(add(mul(p.w, qy), mul(p.y, q.w)), mul(p.z, qx)), mul(p.x, qz)), two),
      mul(sub(add(add(mul(p.w, qz), mul(p.z, q.w)), mul(p.x, qy)), mul(p.y, qx)), two)};
  Triple at = turned(q, rest);
  at = {add(at.x, moved.x), add(at.y, moved.y), add(at.z, moved.z)};
  Triple out_normal[1] = {turned(q, rest_normal)};
  make_unit_or_up(out_normal);
  // Motions that cancel each other leave a vertex at rest.
  const __m256 some = _mm256_cmp_ps(size, zero, _CMP_GT_OQ);
  const auto kept = [&](const Triple& from, const Triple& to) {
    return Triple{_mm256_blendv_ps(from.x, to.x, some), _mm256_blendv_ps(from.y, to.y, some),
                  _mm256_blendv_ps(from.z, to.z, some)};
  };
  at = kept(rest, at);
  const Triple facing = kept(rest_normal, out_normal[0]);
  const std::size_t first = number * kWidth;
  if constexpr (kWhole) {
    store_in_a_row(&position[first].x, at);
    store_in_a_row(&normal[first].x, facing);
  } else {
    std::array<glm::vec3, kWidth> points, normals;
    store_in_a_row(&points[0].x, at);
    store_in_a_row(&normals[0].x, facing);
    const std::size_t left = influences_.size() - first;
    std::copy_n(points.begin(), left, position + first);
    std::copy_n(normals.begin(), left, normal + first);
  }
}

void DualQuaternionPlan::skin(const std::vector<glm::dmat4>& world_from_node,
                              PosedMesh& out) const {
  assert(world_from_node.size() == rest_node_.size());
  const JointMotions motions = joint_motions(joint_, rest_node_, world_from_node);
  const std::size_t vertices = influences_.size();
  out.position.resize(vertices);
  out.normal.resize(vertices);
  std::vector<Motion> rigid(motions.joint.size());
  for (std::size_t j = 0; j < rigid.size(); ++j) {
    const DualQuaternion& from = motions.joint[j];
    rigid[j] = {{from.turn.x, from.turn.y, from.turn.z, from.turn.w},
                {from.shift.x, from.shift.y, from.shift.z, from.shift.w}};
  }
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, blocks_.size(), kGrain), [&](const auto& range) {
        for (std::size_t b = range.begin(); b != range.end(); ++b) {
          if (!motions.stretch) {
            if ((b + 1) * kWidth <= vertices)
              skin_block<true>(rigid.data(), b, out.position.data(), out.normal.data());
            else
              skin_block<false>(rigid.data(), b, out.position.data(), out.normal.data());
            continue;
          }
          for (std::size_t v = b * kWidth; v < std::min(vertices, (b + 1) * kWidth); ++v) {
            out.position[v] = rest_.position[v];
            out.normal[v] = rest_.normal[v];
            blend_dual_quaternions(motions, influences_[v], out.position[v], out.normal[v]);
          }
        }
      });
}

}  // namespace backbend::skin
