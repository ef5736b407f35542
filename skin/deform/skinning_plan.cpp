#include "skin/deform/skinning_plan.h"

#include <immintrin.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <cstring>
#include <optional>
#include <tuple>
#include <utility>

#include "skin/deform/eight_vertices.h"

namespace backbend::skin {
namespace {

constexpr std::size_t kLanes = 8;
constexpr std::size_t kBlockJoints = 4;
// Below this a block wastes more on empty lanes than single vertices cost.
constexpr std::size_t kLeastLanes = 5;
// From so many blocks on, a run gains more from spread-out matrices than spreading them costs.
constexpr std::size_t kLongRun = 4;
// How far ahead of the arithmetic the plan is fetched, in bytes: further than the processor looks
// by itself.
constexpr std::size_t kAhead = 5120;
// Vertices of a tile. The more there are, the more of them share their joints; but a small
// character must leave work for all threads, and vertices are counted in 16 bits.
constexpr std::size_t kLeastTile = 1024;
constexpr std::size_t kMostTile = 32768;
constexpr std::size_t kTiles = 16;  // wanted where a character is neither small nor large

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

[[gnu::always_inline]] inline void store_scattered(glm::vec3* out,
                                                   const std::array<std::uint16_t, kLanes>& vertex,
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

void store_block(glm::vec3* out, std::uint16_t first, const Triple& v) {
  store_in_a_row(&out[first].x, v);
}
[[gnu::always_inline]] inline void store_block(glm::vec3* out,
                                               const std::array<std::uint16_t, kLanes>& vertex,
                                               const Triple& v) {
  store_scattered(out, vertex, v);
}

/// The elements of a run's matrices, each eight times over: the products take them from memory as
/// they are, without an instruction of their own.
template <int kJoints, bool kUneven>
class SpreadMatrices {
 public:
  explicit SpreadMatrices(const JointMatrix* const* joint) {
    for (int r = 0; r < 3; ++r)
      for (int k = 0; k < kJoints; ++k) {
        for (int c = 0; c < 4; ++c) point_[r][c][k] = _mm256_set1_ps(joint[k]->point[c][r]);
        if constexpr (kUneven)
          for (int c = 0; c < 3; ++c) normal_[r][c][k] = _mm256_set1_ps(joint[k]->normal[c][r]);
      }
  }
  __m256 point(int r, int c, int k) const { return point_[r][c][k]; }
  __m256 normal(int r, int c, int k) const { return normal_[r][c][k]; }

 private:
  __m256 point_[3][4][kJoints];
  __m256 normal_[kUneven ? 3 : 1][3][kJoints];
};

/// The same for a single block: read where they lie.
struct JointElements {
  const JointMatrix* const* joint;
  __m256 point(int r, int c, int k) const { return _mm256_broadcast_ss(&joint[k]->point[c][r]); }
  __m256 normal(int r, int c, int k) const { return _mm256_broadcast_ss(&joint[k]->normal[c][r]); }
};

/// One block: the blend of its joints' matrices, eight vertices wide, then points and normals. The
/// normals are left as long as they come out.
template <int kJoints, bool kUneven, class Matrices>
[[gnu::always_inline]] inline void blend_block(const Matrices& matrices, const float* data,
                                               Triple& position, Triple& normal) {
  const auto lane = [&](int k) {
    return _mm256_loadu_ps(data + kLanes * static_cast<std::size_t>(k));
  };
  __m256 weight[kJoints];
  for (int k = 0; k < kJoints; ++k) weight[k] = lane(6 + k);
  const auto point_column = [&](int r, int c) {
    __m256 sum = _mm256_mul_ps(weight[0], matrices.point(r, c, 0));
    for (int k = 1; k < kJoints; ++k)
      sum = _mm256_fmadd_ps(weight[k], matrices.point(r, c, k), sum);
    return sum;
  };
  const auto normal_column = [&](int r, int c) {
    __m256 sum = _mm256_mul_ps(weight[0], matrices.normal(r, c, 0));
    for (int k = 1; k < kJoints; ++k)
      sum = _mm256_fmadd_ps(weight[k], matrices.normal(r, c, k), sum);
    return sum;
  };
  __m256 point[3], turned[3];
  for (int r = 0; r < 3; ++r) {
    point[r] = point_column(r, 3);
    for (int c = 2; c >= 0; --c) {
      const __m256 column = point_column(r, c);
      point[r] = _mm256_fmadd_ps(column, lane(c), point[r]);
      __m256 turn = column;
      if constexpr (kUneven) turn = normal_column(r, c);
      turned[r] =
          c == 2 ? _mm256_mul_ps(turn, lane(5)) : _mm256_fmadd_ps(turn, lane(3 + c), turned[r]);
    }
  }
  position = {point[0], point[1], point[2]};
  normal = {turned[0], turned[1], turned[2]};
}

/// `count` blocks behind each other, two at a time; returns where their data ends. `where` has what
/// store_block() needs of each.
template <int kJoints, bool kUneven, class Where>
[[gnu::always_inline]] inline const float* skin_blocks(
    const SpreadMatrices<kJoints, kUneven>& matrices, const Where* where, std::size_t count,
    const float* data, glm::vec3* position, glm::vec3* normal) {
  constexpr std::size_t kFloats = kLanes * (6 + kJoints);
  std::size_t b = 0;
  for (; b + 2 <= count; b += 2, data += 2 * kFloats) {
    const auto ahead = reinterpret_cast<std::uintptr_t>(data) + kAhead;  // may lie past the end
    for (std::size_t i = 0; i < 2 * kFloats * sizeof(float); i += 64)
      _mm_prefetch(reinterpret_cast<const char*>(ahead + i), _MM_HINT_T0);
    Triple p[2], n[2];
    blend_block<kJoints, kUneven>(matrices, data, p[0], n[0]);
    store_block(position, where[b], p[0]);
    blend_block<kJoints, kUneven>(matrices, data + kFloats, p[1], n[1]);
    store_block(position, where[b + 1], p[1]);
    make_unit_or_up(n);
    store_block(normal, where[b], n[0]);
    store_block(normal, where[b + 1], n[1]);
  }
  if (b < count) {
    Triple p, n[1];
    blend_block<kJoints, kUneven>(matrices, data, p, n[0]);
    make_unit_or_up(n);
    store_block(position, where[b], p);
    store_block(normal, where[b], n[0]);
    data += kFloats;
  }
  return data;
}

/// One block of a short run.
template <int kJoints, bool kUneven, class Where>
[[gnu::always_inline]] inline void skin_block(const JointMatrix* const* joint, const Where& where,
                                              const float* data, glm::vec3* position,
                                              glm::vec3* normal) {
  Triple p, n[1];
  blend_block<kJoints, kUneven>(JointElements{joint}, data, p, n[0]);
  make_unit_or_up(n);
  store_block(position, where, p);
  store_block(normal, where, n[0]);
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
      tile_(std::clamp(vertex_count_ / kTiles, kLeastTile, kMostTile)),
      joints_(character.joints) {
  for (std::size_t v = 0; v < vertex_count_; v += tile_)
    add_tile(character, static_cast<std::uint32_t>(v),
             static_cast<std::uint32_t>(std::min(v + tile_, vertex_count_)));
  begin_tile();
}

void SkinningPlan::begin_tile() {
  tiles_.push_back({runs_.size(), rows_.size(), scattered_.size(), data_.size(), singles_.size(),
                    others_.size()});
}

void SkinningPlan::add_tile(const Character& character, std::uint32_t first, std::uint32_t last) {
  begin_tile();
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
  // Runs of as many joints behind each other: no processor guesses well what changes from one to
  // the next.
  const auto kind = [&](const std::vector<std::uint32_t>& lanes) {
    std::array<std::uint16_t, kBlockJoints> joint{};
    const std::uint8_t count = joints_of(character.influences[lanes[0]], joint);
    return std::tuple(count, joint, !is_in_a_row(lanes));
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
  Run run;
  run.joint_count = joints_of(character.influences[vertices[0]], run.joint);
  if (runs_.size() == tiles_.back().run || runs_.back().joint != run.joint ||
      runs_.back().joint_count != run.joint_count)
    runs_.push_back(run);
  std::array<std::uint32_t, kLanes> vertex{};
  for (std::size_t k = 0; k < kLanes; ++k) vertex[k] = vertices[std::min(k, vertices.size() - 1)];
  if (is_in_a_row(vertices)) {
    ++runs_.back().rows;
    rows_.push_back(static_cast<std::uint16_t>(vertex[0] - first));
  } else {
    ++runs_.back().scattered;
    Lanes& lanes = scattered_.emplace_back();
    for (std::size_t k = 0; k < kLanes; ++k)
      lanes[k] = static_cast<std::uint16_t>(vertex[k] - first);
  }
  padded_ += kLanes - vertices.size();
  for (int axis = 0; axis < 3; ++axis)
    for (const std::uint32_t v : vertex) data_.push_back(character.bind_position[v][axis]);
  for (int axis = 0; axis < 3; ++axis)
    for (const std::uint32_t v : vertex) data_.push_back(character.bind_normal[v][axis]);
  for (std::size_t k = 0; k < run.joint_count; ++k)
    for (const std::uint32_t v : vertex)
      data_.push_back(weight_of(character.influences[v], run.joint[k]));
}

/// One run; returns where its data ends. A function for itself, so that the matrices stay where
/// they are spread out.
template <int kJoints, bool kUneven>
[[gnu::noinline]] const float* SkinningPlan::skin_run(const JointMatrices& joints, const Run& run,
                                                      const std::uint16_t* row,
                                                      const Lanes* scattered, const float* data,
                                                      glm::vec3* position,
                                                      glm::vec3* normal) const {
  const JointMatrix* joint[kJoints];
  for (std::size_t k = 0; k < kJoints; ++k) joint[k] = &joints.joint[run.joint[k]];
  if (std::size_t{run.rows} + run.scattered >= kLongRun) {
    const SpreadMatrices<kJoints, kUneven> matrices(joint);
    data = skin_blocks(matrices, row, run.rows, data, position, normal);
    return skin_blocks(matrices, scattered, run.scattered, data, position, normal);
  }
  for (std::size_t b = 0; b < run.rows; ++b, data += kLanes * (6 + kJoints))
    skin_block<kJoints, kUneven>(joint, row[b], data, position, normal);
  for (std::size_t b = 0; b < run.scattered; ++b, data += kLanes * (6 + kJoints))
    skin_block<kJoints, kUneven>(joint, scattered[b], data, position, normal);
  return data;
}

/// One tile into arrays of its own, counted from its first vertex.
template <bool kUneven>
void SkinningPlan::skin_tile(const JointMatrices& joints, std::size_t tile, glm::vec3* position,
                             glm::vec3* normal) const {
  const Tile &from = tiles_[tile], &to = tiles_[tile + 1];
  const float* data = data_.data() + from.data;
  const std::uint16_t* row = rows_.data() + from.row;
  const Lanes* scattered = scattered_.data() + from.scattered;
  for (std::size_t r = from.run; r != to.run; ++r) {
    const Run& run = runs_[r];
    const auto skinned = [&]<int kJoints>() {
      return skin_run<kJoints, kUneven>(joints, run, row, scattered, data, position, normal);
    };
    switch (run.joint_count) {
      case 1:
        data = skinned.template operator()<1>();
        break;
      case 2:
        data = skinned.template operator()<2>();
        break;
      case 3:
        data = skinned.template operator()<3>();
        break;
      default:
        data = skinned.template operator()<4>();
    }
    row += run.rows;
    scattered += run.scattered;
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

void SkinningPlan::skin(std::span<const glm::dmat4> world_from_node, PosedMesh& out) const {
  out.position.resize(vertex_count_);
  out.normal.resize(vertex_count_);
  skin(world_from_node, out.position, out.normal);
}

void SkinningPlan::skin(std::span<const glm::dmat4> world_from_node,
                        std::span<glm::vec3> out_position, std::span<glm::vec3> out_normal) const {
  assert(world_from_node.size() == node_count_);
  assert(out_position.size() == vertex_count_ && out_normal.size() == vertex_count_);
  const JointMatrices joints = joint_matrices(joints_, world_from_node);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, tiles_.size() - 1), [&](const auto& range) {
    for (std::size_t t = range.begin(); t != range.end(); ++t) {
      glm::vec3 *position = &out_position[t * tile_], *normal = &out_normal[t * tile_];
      if (joints.uneven)
        skin_tile<true>(joints, t, position, normal);
      else
        skin_tile<false>(joints, t, position, normal);
    }
  });
}

double SkinningPlan::padded_share() const {
  return vertex_count_ == 0 ? 0.0
                            : static_cast<double>(padded_) / static_cast<double>(vertex_count_);
}

double SkinningPlan::single_share() const {
  return vertex_count_ == 0 ? 0.0
                            : static_cast<double>(singles_.size() + others_.size()) /
                                  static_cast<double>(vertex_count_);
}

}  // namespace backbend::skin
