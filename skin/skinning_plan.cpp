#include "skin/skinning_plan.h"

#include <immintrin.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <optional>
#include <utility>

namespace backbend::skin {
namespace {

constexpr std::size_t kLanes = 8;
constexpr std::size_t kBlockJoints = 4;
// Below this a block wastes more on empty lanes than single vertices cost.
constexpr std::size_t kLeastLanes = 3;
constexpr std::size_t kBlockGrain = 256;  // blocks a task: some ten microseconds
constexpr std::size_t kSingleGrain = 1024;

/// Up to four joints of a vertex, ascending, as one number; nothing for any other count.
std::optional<std::uint64_t> joint_key(const Influences& influences) {
  // Missing joints are 65535, which no joint is: lists of different length never look alike.
  std::array<std::uint16_t, kBlockJoints> joint;
  joint.fill(0xFFFF);
  std::size_t count = 0;
  for (; count < kMaxInfluences && influences.weight[count] > 0.0f; ++count) {
    if (count == kBlockJoints) return std::nullopt;
    joint[count] = influences.joint[count];
  }
  if (count == 0) return std::nullopt;
  std::sort(joint.begin(), joint.end());
  std::uint64_t key = 0;
  for (const std::uint16_t each : joint) key = key << 16 | each;
  return key;
}

float weight_of(const Influences& influences, std::uint16_t joint) {
  for (std::size_t k = 0; k < kMaxInfluences && influences.weight[k] > 0.0f; ++k)
    if (influences.joint[k] == joint) return influences.weight[k];
  return 0.0f;
}

/// Three coordinates of eight vertices.
struct Triple {
  __m256 x, y, z;
};

/// Eight packed x, y, z, one vertex after the other.
void store_in_a_row(float* out, const Triple& v) {
  const __m256 xy = _mm256_shuffle_ps(v.x, v.y, _MM_SHUFFLE(2, 0, 2, 0));    // x0 x2 y0 y2
  const __m256 yz = _mm256_shuffle_ps(v.y, v.z, _MM_SHUFFLE(3, 1, 3, 1));    // y1 y3 z1 z3
  const __m256 zx = _mm256_shuffle_ps(v.z, v.x, _MM_SHUFFLE(3, 1, 2, 0));    // z0 z2 x1 x3
  const __m256 first = _mm256_shuffle_ps(xy, zx, _MM_SHUFFLE(2, 0, 2, 0));   // x0 y0 z0 x1
  const __m256 second = _mm256_shuffle_ps(yz, xy, _MM_SHUFFLE(3, 1, 2, 0));  // y1 z1 x2 y2
  const __m256 third = _mm256_shuffle_ps(zx, yz, _MM_SHUFFLE(3, 1, 3, 1));   // z2 x3 y3 z3
  _mm_storeu_ps(out, _mm256_castps256_ps128(first));
  _mm_storeu_ps(out + 4, _mm256_castps256_ps128(second));
  _mm_storeu_ps(out + 8, _mm256_castps256_ps128(third));
  _mm_storeu_ps(out + 12, _mm256_extractf128_ps(first, 1));
  _mm_storeu_ps(out + 16, _mm256_extractf128_ps(second, 1));
  _mm_storeu_ps(out + 20, _mm256_extractf128_ps(third, 1));
}

void store_scattered(glm::vec3* out, const std::array<std::uint32_t, kLanes>& vertex,
                     const Triple& v) {
  const __m256 low = _mm256_unpacklo_ps(v.x, v.y);   // x0 y0 x1 y1 | x4 y4 x5 y5
  const __m256 high = _mm256_unpackhi_ps(v.x, v.y);  // x2 y2 x3 y3 | x6 y6 x7 y7
  alignas(32) float z[kLanes];
  _mm256_store_ps(z, v.z);
  const __m128 pair[4] = {_mm256_castps256_ps128(low), _mm256_castps256_ps128(high),
                          _mm256_extractf128_ps(low, 1), _mm256_extractf128_ps(high, 1)};
  for (std::size_t k = 0; k < kLanes; ++k) {
    glm::vec3& to = out[vertex[k]];
    if (k % 2 == 0)
      _mm_storel_pi(reinterpret_cast<__m64*>(&to.x), pair[k / 2]);
    else
      _mm_storeh_pi(reinterpret_cast<__m64*>(&to.x), pair[k / 2]);
    to.z = z[k];
  }
}

/// Unit length; +Y where there is none. The same steps as unit_or_up().
Triple unit_or_up(const Triple& v) {
  const __m256 square =
      _mm256_fmadd_ps(v.x, v.x, _mm256_fmadd_ps(v.y, v.y, _mm256_mul_ps(v.z, v.z)));
  const __m256 length = _mm256_sqrt_ps(square);
  const __m256 some = _mm256_cmp_ps(length, _mm256_setzero_ps(), _CMP_GT_OQ);
  const __m256 inverse = _mm256_div_ps(_mm256_set1_ps(1.0f), length);
  const auto kept = [&](__m256 axis, float otherwise) {
    return _mm256_blendv_ps(_mm256_set1_ps(otherwise), _mm256_mul_ps(axis, inverse), some);
  };
  return {kept(v.x, 0.0f), kept(v.y, 1.0f), kept(v.z, 0.0f)};
}

/// One block: the blend of its joints' matrices, eight vertices wide, then points and normals.
template <int kJoints, bool kUneven>
void skin_block_of(const JointMatrix* const* joint, const float* data, Triple& position,
                   Triple& normal) {
  const auto lane = [&](int k) {
    return _mm256_loadu_ps(data + kLanes * static_cast<std::size_t>(k));
  };
  __m256 weight[kJoints];
  for (int k = 0; k < kJoints; ++k) weight[k] = lane(6 + k);
  const auto blended = [&](auto element) {
    __m256 sum = _mm256_mul_ps(weight[0], _mm256_broadcast_ss(element(*joint[0])));
    for (int k = 1; k < kJoints; ++k)
      sum = _mm256_fmadd_ps(weight[k], _mm256_broadcast_ss(element(*joint[k])), sum);
    return sum;
  };
  const __m256 x = lane(0), y = lane(1), z = lane(2);
  const __m256 nx = lane(3), ny = lane(4), nz = lane(5);
  __m256 point[3], turned[3];
  for (int r = 0; r < 3; ++r) {
    __m256 column[4];
    for (int c = 0; c < 4; ++c)
      column[c] = blended([&](const JointMatrix& j) { return &j.point[c][r]; });
    point[r] = _mm256_fmadd_ps(
        column[0], x, _mm256_fmadd_ps(column[1], y, _mm256_fmadd_ps(column[2], z, column[3])));
    if constexpr (kUneven)
      for (int c = 0; c < 3; ++c)
        column[c] = blended([&](const JointMatrix& j) { return &j.normal[c][r]; });
    turned[r] = _mm256_fmadd_ps(column[0], nx,
                                _mm256_fmadd_ps(column[1], ny, _mm256_mul_ps(column[2], nz)));
  }
  position = {point[0], point[1], point[2]};
  normal = unit_or_up({turned[0], turned[1], turned[2]});
}

template <bool kUneven>
void skin_block(int joints, const JointMatrix* const* joint, const float* data, Triple& position,
                Triple& normal) {
  switch (joints) {
    case 1:
      return skin_block_of<1, kUneven>(joint, data, position, normal);
    case 2:
      return skin_block_of<2, kUneven>(joint, data, position, normal);
    case 3:
      return skin_block_of<3, kUneven>(joint, data, position, normal);
    default:
      return skin_block_of<4, kUneven>(joint, data, position, normal);
  }
}

}  // namespace

SkinningPlan::SkinningPlan(const Character& character)
    : vertex_count_(character.vertex_count()),
      node_count_(character.nodes.size()),
      joints_(character.joints) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keyed;
  const auto add_single = [&](std::uint32_t v) {
    singles_.push_back(
        {v, character.influences[v], character.bind_position[v], character.bind_normal[v]});
  };
  for (std::uint32_t v = 0; v < vertex_count_; ++v) {
    if (const auto key = joint_key(character.influences[v]))
      keyed.emplace_back(*key, v);
    else
      add_single(v);
  }
  std::sort(keyed.begin(), keyed.end());
  std::vector<std::uint32_t> lanes;
  for (std::size_t i = 0; i < keyed.size(); ++i) {
    lanes.push_back(keyed[i].second);
    const bool last = i + 1 == keyed.size() || keyed[i + 1].first != keyed[i].first;
    if (lanes.size() < kLanes && !last) continue;
    if (lanes.size() >= kLeastLanes)
      add_block(character, lanes);
    else
      for (const std::uint32_t v : lanes) add_single(v);
    lanes.clear();
  }
  // In the order of the mesh: neighbours in memory are written together.
  std::sort(blocks_.begin(), blocks_.end(),
            [](const Block& a, const Block& b) { return a.vertex[0] < b.vertex[0]; });
  std::vector<float> sorted;
  sorted.reserve(data_.size());
  for (Block& block : blocks_) {
    const auto from = data_.begin() + static_cast<std::ptrdiff_t>(block.first);
    block.first = sorted.size();
    sorted.insert(sorted.end(), from,
                  from + static_cast<std::ptrdiff_t>(kLanes) * (6 + block.joint_count));
  }
  data_ = std::move(sorted);
}

void SkinningPlan::add_block(const Character& character, std::span<const std::uint32_t> vertices) {
  Block block;
  block.first = data_.size();
  block.lane_count = static_cast<std::uint8_t>(vertices.size());
  for (std::size_t k = 0; k < kLanes; ++k)
    block.vertex[k] = vertices[std::min(k, vertices.size() - 1)];
  block.in_a_row = true;
  for (std::size_t k = 0; k < kLanes; ++k)
    block.in_a_row = block.in_a_row && block.vertex[k] == block.vertex[0] + k;

  const Influences& first = character.influences[vertices[0]];
  while (block.joint_count < kBlockJoints && first.weight[block.joint_count] > 0.0f) {
    block.joint[block.joint_count] = first.joint[block.joint_count];
    ++block.joint_count;
  }
  std::sort(block.joint.begin(), block.joint.begin() + block.joint_count);
  for (int axis = 0; axis < 3; ++axis)
    for (const std::uint32_t v : block.vertex) data_.push_back(character.bind_position[v][axis]);
  for (int axis = 0; axis < 3; ++axis)
    for (const std::uint32_t v : block.vertex) data_.push_back(character.bind_normal[v][axis]);
  for (std::size_t k = 0; k < block.joint_count; ++k)
    for (const std::uint32_t v : block.vertex)
      data_.push_back(weight_of(character.influences[v], block.joint[k]));
  blocks_.push_back(block);
}

void SkinningPlan::skin(const std::vector<glm::dmat4>& world_from_node, PosedMesh& out) const {
  assert(world_from_node.size() == node_count_);
  const JointMatrices joints = joint_matrices(joints_, world_from_node);
  out.position.resize(vertex_count_);
  out.normal.resize(vertex_count_);
  const auto skin_range = [&]<bool kUneven>(std::size_t first, std::size_t last) {
    for (std::size_t b = first; b != last; ++b) {
      const Block& block = blocks_[b];
      const JointMatrix* joint[kBlockJoints];
      for (std::size_t k = 0; k < kBlockJoints; ++k) joint[k] = &joints.joint[block.joint[k]];
      Triple position, normal;
      skin_block<kUneven>(block.joint_count, joint, data_.data() + block.first, position, normal);
      if (block.in_a_row) {
        store_in_a_row(&out.position[block.vertex[0]].x, position);
        store_in_a_row(&out.normal[block.vertex[0]].x, normal);
      } else {
        store_scattered(out.position.data(), block.vertex, position);
        store_scattered(out.normal.data(), block.vertex, normal);
      }
    }
  };
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks_.size(), kBlockGrain),
                    [&](const auto& range) {
                      if (joints.uneven)
                        skin_range.template operator()<true>(range.begin(), range.end());
                      else
                        skin_range.template operator()<false>(range.begin(), range.end());
                    });
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, singles_.size(), kSingleGrain),
                    [&](const auto& range) {
                      for (std::size_t k = range.begin(); k != range.end(); ++k) {
                        const Single& single = singles_[k];
                        blend_vertex(joints, single.influences, single.position, single.normal,
                                     out.position[single.vertex], out.normal[single.vertex]);
                      }
                    });
}

double SkinningPlan::padded_share() const {
  std::size_t padded = 0;
  for (const Block& block : blocks_) padded += kLanes - block.lane_count;
  return vertex_count_ == 0 ? 0.0
                            : static_cast<double>(padded) / static_cast<double>(vertex_count_);
}

double SkinningPlan::single_share() const {
  return vertex_count_ == 0
             ? 0.0
             : static_cast<double>(singles_.size()) / static_cast<double>(vertex_count_);
}

}  // namespace backbend::skin
