#include "skin/skinning_plan.h"

#include <immintrin.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cstring>
#include <optional>
#include <utility>

namespace backbend::skin {
namespace {

constexpr std::size_t kLanes = 8;
constexpr std::size_t kBlockJoints = 4;
// Below this a block wastes more on empty lanes than single vertices cost.
constexpr std::size_t kLeastLanes = 5;
constexpr std::size_t kTileGrain = 2;  // tiles a task: some ten microseconds
constexpr std::size_t kTile = 1024;    // vertices: 24 kB of positions and normals

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

/// The joints of a vertex that joint_key() takes, ascending; how many they are.
std::uint8_t joints_of(const Influences& influences,
                       std::array<std::uint16_t, kBlockJoints>& joint) {
  std::size_t count = 0;
  for (; count < kBlockJoints && influences.weight[count] > 0.0f; ++count)
    joint[count] = influences.joint[count];
  std::sort(joint.begin(), joint.begin() + static_cast<std::ptrdiff_t>(count));
  return static_cast<std::uint8_t>(count);
}

bool is_in_a_row(std::span<const std::uint32_t> vertices) {
  return vertices.size() == kLanes && vertices.back() == vertices.front() + kLanes - 1;
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

void store_scattered(glm::vec3* out, const std::array<std::uint16_t, kLanes>& vertex,
                     const Triple& v) {
  const __m256 low = _mm256_unpacklo_ps(v.x, v.y);   // x0 y0 x1 y1 | x4 y4 x5 y5
  const __m256 high = _mm256_unpackhi_ps(v.x, v.y);  // x2 y2 x3 y3 | x6 y6 x7 y7
  const __m128 pair[4] = {_mm256_castps256_ps128(low), _mm256_castps256_ps128(high),
                          _mm256_extractf128_ps(low, 1), _mm256_extractf128_ps(high, 1)};
  const __m128 z[2] = {_mm256_castps256_ps128(v.z), _mm256_extractf128_ps(v.z, 1)};
  const auto store = [&]<int kLane>() {
    float* to = &out[vertex[kLane]].x;
    if constexpr (kLane % 2 == 0)
      _mm_storel_pi(reinterpret_cast<__m64*>(to), pair[kLane / 2]);
    else
      _mm_storeh_pi(reinterpret_cast<__m64*>(to), pair[kLane / 2]);
    const int bits = _mm_extract_ps(z[kLane / 4], kLane % 4);
    std::memcpy(to + 2, &bits, sizeof bits);
  };
  store.template operator()<0>();
  store.template operator()<1>();
  store.template operator()<2>();
  store.template operator()<3>();
  store.template operator()<4>();
  store.template operator()<5>();
  store.template operator()<6>();
  store.template operator()<7>();
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

void store_vec3(glm::vec3& to, __m128 v) {
  _mm_storel_pi(reinterpret_cast<__m64*>(&to.x), v);
  const int z = _mm_extract_ps(v, 2);
  std::memcpy(&to.z, &z, sizeof z);
}

/// Unit length; +Y where there is none. The same steps as unit_or_up().
void store_unit_or_up(glm::vec3& to, __m128 v) {
  const __m128 y = _mm_movehdup_ps(v), z = _mm_movehl_ps(v, v);
  const __m128 square = _mm_fmadd_ss(v, v, _mm_fmadd_ss(y, y, _mm_mul_ss(z, z)));
  const __m128 length = _mm_sqrt_ss(square);
  if (!(_mm_cvtss_f32(length) > 0.0f)) {
    to = glm::vec3(0.0f, 1.0f, 0.0f);
    return;
  }
  const __m128 inverse = _mm_div_ss(_mm_set_ss(1.0f), length);
  store_vec3(to, _mm_mul_ps(v, _mm_shuffle_ps(inverse, inverse, 0)));
}

/// One vertex: the blend of its joints' matrices, two columns at once. The same steps as
/// blend_vertex(), whose joints it takes in their order.
template <bool kUneven>
void skin_single(const JointMatrices& joints, const std::uint16_t* joint, const float* weights,
                 int count, const glm::vec3& bind_position, const glm::vec3& bind_normal,
                 glm::vec3& position, glm::vec3& normal) {
  // Columns 0 and 1, columns 2 and 3.
  const JointMatrix& first = joints.joint[joint[0]];
  __m256 low = _mm256_mul_ps(_mm256_set1_ps(weights[0]), _mm256_loadu_ps(first.point[0]));
  __m256 high = _mm256_mul_ps(_mm256_set1_ps(weights[0]), _mm256_loadu_ps(first.point[2]));
  __m128 turn[3];
  if constexpr (kUneven)
    for (int c = 0; c < 3; ++c)
      turn[c] = _mm_mul_ps(_mm_set1_ps(weights[0]), _mm_load_ps(first.normal[c]));
  for (int k = 1; k < count; ++k) {
    const JointMatrix& matrix = joints.joint[joint[k]];
    const __m256 weight = _mm256_set1_ps(weights[k]);
    low = _mm256_fmadd_ps(weight, _mm256_loadu_ps(matrix.point[0]), low);
    high = _mm256_fmadd_ps(weight, _mm256_loadu_ps(matrix.point[2]), high);
    if constexpr (kUneven)
      for (int c = 0; c < 3; ++c)
        turn[c] =
            _mm_fmadd_ps(_mm256_castps256_ps128(weight), _mm_load_ps(matrix.normal[c]), turn[c]);
  }
  const __m128 c0 = _mm256_castps256_ps128(low), c1 = _mm256_extractf128_ps(low, 1);
  const __m128 c2 = _mm256_castps256_ps128(high), c3 = _mm256_extractf128_ps(high, 1);
  if constexpr (!kUneven) {
    turn[0] = c0;
    turn[1] = c1;
    turn[2] = c2;
  }
  const glm::vec3 &p = bind_position, &n = bind_normal;
  store_vec3(position, _mm_fmadd_ps(c0, _mm_set1_ps(p.x),
                                    _mm_fmadd_ps(c1, _mm_set1_ps(p.y),
                                                 _mm_fmadd_ps(c2, _mm_set1_ps(p.z), c3))));
  store_unit_or_up(normal, _mm_fmadd_ps(turn[0], _mm_set1_ps(n.x),
                                        _mm_fmadd_ps(turn[1], _mm_set1_ps(n.y),
                                                     _mm_mul_ps(turn[2], _mm_set1_ps(n.z)))));
}

}  // namespace

SkinningPlan::SkinningPlan(const Character& character)
    : vertex_count_(character.vertex_count()),
      node_count_(character.nodes.size()),
      joints_(character.joints) {
  for (std::size_t v = 0; v < vertex_count_; v += kTile)
    add_tile(character, static_cast<std::uint32_t>(v),
             static_cast<std::uint32_t>(std::min(v + kTile, vertex_count_)));
  tiles_.push_back({blocks_.size(), data_.size(), singles_.size(), others_.size()});
}

void SkinningPlan::add_tile(const Character& character, std::uint32_t first, std::uint32_t last) {
  tiles_.push_back({blocks_.size(), data_.size(), singles_.size(), others_.size()});
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keyed;
  for (std::uint32_t v = first; v < last; ++v) {
    if (const auto key = joint_key(character.influences[v]))
      keyed.emplace_back(*key, v);
    else
      others_.push_back({character.influences[v], character.bind_position[v],
                         character.bind_normal[v], static_cast<std::uint16_t>(v - first)});
  }
  std::sort(keyed.begin(), keyed.end());
  std::vector<std::vector<std::uint32_t>> blocks;
  const std::size_t first_single = singles_.size();
  for (std::size_t i = 0; i < keyed.size();) {
    std::vector<std::uint32_t> lanes;
    for (const std::uint64_t key = keyed[i].first;
         i < keyed.size() && keyed[i].first == key && lanes.size() < kLanes; ++i)
      lanes.push_back(keyed[i].second);
    if (lanes.size() >= kLeastLanes)
      blocks.push_back(std::move(lanes));
    else
      for (const std::uint32_t v : lanes) add_single(character, first, v);
  }
  // Alike ones behind each other: no processor guesses well what changes from block to block.
  const auto kind = [&](const std::vector<std::uint32_t>& lanes) {
    std::array<std::uint16_t, kBlockJoints> joint{};
    return std::pair(joints_of(character.influences[lanes[0]], joint), is_in_a_row(lanes));
  };
  std::stable_sort(blocks.begin(), blocks.end(),
                   [&](const auto& a, const auto& b) { return kind(a) < kind(b); });
  for (const auto& lanes : blocks) add_block(character, first, lanes);
  std::stable_sort(singles_.begin() + static_cast<std::ptrdiff_t>(first_single), singles_.end(),
                   [](const Single& a, const Single& b) { return a.joint_count < b.joint_count; });
}

void SkinningPlan::add_single(const Character& character, std::uint32_t first,
                              std::uint32_t vertex) {
  Single single;
  single.position = character.bind_position[vertex];
  single.normal = character.bind_normal[vertex];
  single.vertex = static_cast<std::uint16_t>(vertex - first);
  single.joint_count = joints_of(character.influences[vertex], single.joint);
  for (std::size_t k = 0; k < single.joint_count; ++k)
    single.weight[k] = weight_of(character.influences[vertex], single.joint[k]);
  singles_.push_back(single);
}

void SkinningPlan::add_block(const Character& character, std::uint32_t first,
                             std::span<const std::uint32_t> vertices) {
  Block block;
  block.lane_count = static_cast<std::uint8_t>(vertices.size());
  std::array<std::uint32_t, kLanes> vertex{};
  for (std::size_t k = 0; k < kLanes; ++k) {
    vertex[k] = vertices[std::min(k, vertices.size() - 1)];
    block.lane[k] = static_cast<std::uint16_t>(vertex[k] - first);
  }
  block.in_a_row = is_in_a_row(vertices);
  block.joint_count = joints_of(character.influences[vertices[0]], block.joint);
  for (int axis = 0; axis < 3; ++axis)
    for (const std::uint32_t v : vertex) data_.push_back(character.bind_position[v][axis]);
  for (int axis = 0; axis < 3; ++axis)
    for (const std::uint32_t v : vertex) data_.push_back(character.bind_normal[v][axis]);
  for (std::size_t k = 0; k < block.joint_count; ++k)
    for (const std::uint32_t v : vertex)
      data_.push_back(weight_of(character.influences[v], block.joint[k]));
  blocks_.push_back(block);
}

/// One tile into arrays of its own, counted from its first vertex.
template <bool kUneven>
void SkinningPlan::skin_tile(const JointMatrices& joints, std::size_t tile, glm::vec3* position,
                             glm::vec3* normal) const {
  const Tile &from = tiles_[tile], &to = tiles_[tile + 1];
  const float* data = data_.data() + from.data;
  for (std::size_t b = from.block; b != to.block; ++b) {
    const Block& block = blocks_[b];
    const JointMatrix* joint[kBlockJoints];
    for (std::size_t k = 0; k < kBlockJoints; ++k) joint[k] = &joints.joint[block.joint[k]];
    Triple p, n;
    skin_block<kUneven>(block.joint_count, joint, data, p, n);
    data += kLanes * (6 + std::size_t{block.joint_count});
    if (block.in_a_row) {
      store_in_a_row(&position[block.lane[0]].x, p);
      store_in_a_row(&normal[block.lane[0]].x, n);
    } else {
      store_scattered(position, block.lane, p);
      store_scattered(normal, block.lane, n);
    }
  }
  for (std::size_t k = from.single; k != to.single; ++k) {
    const Single& single = singles_[k];
    skin_single<kUneven>(joints, single.joint.data(), single.weight.data(), single.joint_count,
                         single.position, single.normal, position[single.vertex],
                         normal[single.vertex]);
  }
  for (std::size_t k = from.other; k != to.other; ++k) {
    const Other& other = others_[k];
    blend_vertex(joints, other.influences, other.position, other.normal, position[other.vertex],
                 normal[other.vertex]);
  }
}

void SkinningPlan::skin(const std::vector<glm::dmat4>& world_from_node, PosedMesh& out) const {
  assert(world_from_node.size() == node_count_);
  const JointMatrices joints = joint_matrices(joints_, world_from_node);
  out.position.resize(vertex_count_);
  out.normal.resize(vertex_count_);
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, tiles_.size() - 1, kTileGrain), [&](const auto& range) {
        for (std::size_t t = range.begin(); t != range.end(); ++t) {
          glm::vec3 *position = &out.position[t * kTile], *normal = &out.normal[t * kTile];
          if (joints.uneven)
            skin_tile<true>(joints, t, position, normal);
          else
            skin_tile<false>(joints, t, position, normal);
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
  return vertex_count_ == 0 ? 0.0
                            : static_cast<double>(singles_.size() + others_.size()) /
                                  static_cast<double>(vertex_count_);
}

}  // namespace backbend::skin
