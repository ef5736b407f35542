#include "validate/metrics/surface/mesh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <limits>

#include "validate/metrics/math/nan.h"
#include "validate/metrics/surface/mesh_blocks.h"

namespace backbend::validate {
namespace {

// Strains below this are rounding of nearly straight poses, and no measure of anything.
constexpr float kLeastStrain = 0.05f;
constexpr std::uint32_t kLanes = MeshRest::kLanes;
static_assert(kLanes == FloatLanes::kCount);

struct alignas(16) Corner {
  float position[4];  // the fourth is not used
};
struct alignas(16) Normal {
  float axis[4];  // the fourth is not used
};
/// What one pose is unfolded into. Kept by each thread: fresh pages cost more than the figures.
struct Scratch {
  std::vector<Corner> corner;       // of MeshRest
  std::vector<Normal> normal;       // of each corner, where no joints tell how triangles face
  std::vector<Normal> unit_normal;  // per slot, of its face
};
thread_local Scratch scratch;

bool all_finite(std::span<const glm::vec3> values) {
  const float* p = values.empty() ? nullptr : &values.front().x;
  const std::size_t count = values.size() * 3;
  const FloatLanes infinity(std::numeric_limits<float>::infinity());
  int finite = 0xff;
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes)
    finite &= less(magnitude(FloatLanes::load(p + i)), infinity);
  for (; i < count; ++i) finite &= std::isfinite(p[i]) ? 0xff : 0;
  return finite == 0xff;
}

bool is_finite(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Four floats of an array of threes, the last of which belongs to the next; none may follow.
void copy_three(std::span<const glm::vec3> from, std::size_t i, float* to) {
  if (i + 1 < from.size()) {
    _mm_store_ps(to, _mm_loadu_ps(&from[i].x));
  } else {
    for (int k = 0; k < 3; ++k) to[k] = from[i][k];
  }
}

/// Of each corner what its vertex has.
template <class Four>
void unfold(const MeshRest& rest, std::size_t corners, std::span<const glm::vec3> of_vertex,
            std::vector<Four>& out) {
  out.resize(corners);
  constexpr std::size_t kAhead = 24;  // vertices lie apart: asked for before they are needed
  for (std::size_t c = 0; c < out.size(); ++c) {
    const std::uint32_t soon = rest.vertex[std::min(c + kAhead, out.size() - 1)];
    _mm_prefetch(reinterpret_cast<const char*>(&of_vertex[soon]), _MM_HINT_T0);
    copy_three(of_vertex, rest.vertex[c], reinterpret_cast<float*>(&out[c]));
  }
}

BlockCorners corners_of(const MeshRest::Block& block, const std::vector<Corner>& corner) {
  BlockCorners out;
  for (int k = 0; k < 3; ++k)
    out.p[k] = gather([&](int lane) { return corner[block.corner[k][lane]].position; });
  return out;
}

/// Of each triangle, the sum of its corners' normals.
VectorLanes normals_of(const MeshRest::Block& block, const std::vector<Normal>& normal) {
  alignas(16) float sum[kLanes][4];
  for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
    const auto at = [&](int k) { return _mm_load_ps(normal[block.corner[k][lane]].axis); };
    _mm_store_ps(sum[lane], _mm_add_ps(_mm_add_ps(at(0), at(1)), at(2)));
  }
  return gather([&](int lane) { return sum[lane]; });
}

/// Bit i: triangle i faces another way than it should.
std::uint32_t turned_over(const MeshRest& rest, const MeshRest::Block& block,
                          const VectorLanes& face, std::span<const glm::mat3> joint,
                          const std::vector<Normal>& normal) {
  const VectorLanes facing =
      joint.empty() ? normals_of(block, normal) : turned_faces(rest, block, joint);
  return static_cast<std::uint32_t>(less(dot(face, facing), 0.0f)) & block.upright;
}

/// Singular values of a 3x2 matrix with columns u, v: the roots of its 2x2 Gram matrix, before the
/// last root is drawn. The larger one's square is mean + sqrt(apart).
struct Gram {
  FloatLanes mean, apart;
};
Gram gram(FloatLanes uu, FloatLanes vv, FloatLanes uv) {
  const FloatLanes half = FloatLanes(0.5f) * (uu - vv);
  return {FloatLanes(0.5f) * (uu + vv), half * half + uv * uv};
}

struct Singular {
  FloatLanes largest, smallest;
};
Singular singular_values(const Gram& g) {
  const FloatLanes root = square_root(g.apart);
  return {square_root(g.mean + root), square_root(larger(g.mean - root, 0.0f))};
}

FloatLanes strain_of(const Singular& s) { return larger(s.largest - 1.0f, 1.0f - s.smallest); }

Gram triangle_gram(const MeshRest::Block& block, const VectorLanes& e1, const VectorLanes& e2) {
  const VectorLanes u = FloatLanes::load(block.inverse[0]) * e1;
  const VectorLanes v =
      FloatLanes::load(block.inverse[1]) * e1 + FloatLanes::load(block.inverse[2]) * e2;
  return gram(dot(u, u), dot(v, v), dot(u, v));
}

/// What an ideal beam bent and twisted as intended strains, slice by slice.
class IdealStrain {
 public:
  IdealStrain(const MeshRest& rest, const BendIntent& intent, double bone)
      : twist_(static_cast<float>(intent.twist)), stretch_(static_cast<float>(intent.stretch)) {
    // The slice with the strongest bend within a bone of each: there the ideal is asked.
    const int n = static_cast<int>(rest.slice_count);
    const int reach =
        rest.slice_spacing > 0.0 ? static_cast<int>(std::ceil(bone / rest.slice_spacing)) : 0;
    for (int r = 0; r < n; ++r) {
      int strongest = r;
      for (int k = std::max(0, r - reach); k <= std::min(n - 1, r + reach); ++k)
        if (glm::length(intent.bend[k]) > glm::length(intent.bend[strongest])) strongest = k;
      const glm::dvec3 tangent = rest_tangent(intent, r);
      tangent_.push_back(glm::vec3(tangent));
      // tangent . (bend x offset) = (tangent x bend) . offset
      lever_.push_back(glm::vec3(glm::cross(tangent, intent.bend[strongest])));
    }
  }

  FloatLanes at(const MeshRest::Torso& torso) const {
    const VectorLanes offset(FloatLanes::load(torso.offset[0]), FloatLanes::load(torso.offset[1]),
                             FloatLanes::load(torso.offset[2]));
    const VectorLanes tangent(tangent_[torso.slice]), lever(lever_[torso.slice]);
    // [[1, twist * radius], [0, along]]; beyond its depth the inner side has no length left.
    const FloatLanes along = larger(FloatLanes(stretch_) + dot(lever, offset), 0.0f);
    const VectorLanes across = offset - dot(offset, tangent) * tangent;
    const FloatLanes shear = FloatLanes(twist_) * square_root(dot(across, across));
    return larger(kLeastStrain,
                  strain_of(singular_values(gram(1.0f, shear * shear + along * along, shear))));
  }

 private:
  static glm::dvec3 rest_tangent(const BendIntent& intent, int r) {
    const glm::dvec3& t = intent.rest_tangent[static_cast<std::size_t>(r)];
    return glm::dot(t, t) > 0.0 ? t : glm::dvec3(0, 1, 0);
  }

  float twist_, stretch_;
  std::vector<glm::vec3> tangent_, lever_;
};

/// Area over value, in steps of 2^(1/16): a quantile within 4.4 % in one pass and no memory.
class AreaDistribution {
 public:
  void add(FloatLanes value, const float* area) {
    alignas(32) std::int32_t bin[kLanes];
    _mm256_store_si256(reinterpret_cast<__m256i*>(bin), bins(value));
    // Every other lane its own sums: one that waits for the last would be slow.
    for (std::uint32_t i = 0; i < kLanes; ++i)
      area_[i % 2][static_cast<std::size_t>(bin[i])] += area[i];
  }
  /// The value that this share of `whole` area stays below (upper end of its step); NaN without.
  double below(double share, double whole) const {
    if (!(whole > 0.0)) return kNan;
    double sum = 0.0;
    for (std::size_t i = 0; i < kBins; ++i) {
      sum += area_[0][i] + area_[1][i];
      if (sum >= share * whole) return std::exp2((static_cast<double>(i) + 1.0) / 16.0 - kOctaves);
    }
    return std::exp2(kOctaves);
  }

 private:
  static constexpr int kOctaves = 12;  // from 2^-12, which is nothing, to 2^12
  static constexpr std::size_t kBins = 32 * kOctaves;
  static constexpr int kMantissa = 23,
                       kKey = 7;  // bits of a float's mantissa; those that are looked up

  /// For the first bits of a mantissa: the step that they begin in (upper bits), and the mantissa
  /// from which the next one counts. Steps are wider than what the bits tell apart.
  static std::array<std::int32_t, 1 << kKey> make_steps() {
    std::array<std::int32_t, 1 << kKey> out{};
    for (int key = 0; key < 1 << kKey; ++key) {
      const double from = 1.0 + std::ldexp(key, -kKey);
      int step = 15;
      while (step > 0 && std::exp2(step / 16.0) > from) --step;
      const double next = std::ceil(std::ldexp(std::exp2((step + 1) / 16.0) - 1.0, kMantissa));
      const int last = (1 << kMantissa) - 1;
      out[static_cast<std::size_t>(key)] =
          step << kMantissa | std::min(static_cast<int>(next), last);
      // Only the last step ends with the octave: no mantissa reaches it.
    }
    return out;
  }
  static __m256i bins(FloatLanes value) {
    static const std::array<std::int32_t, 1 << kKey> steps = make_steps();
    const __m256i bits = _mm256_castps_si256(value.v);
    const __m256i low = _mm256_set1_epi32((1 << kMantissa) - 1);
    const __m256i mantissa = _mm256_and_si256(bits, low);
    const __m256i entry =
        _mm256_i32gather_epi32(steps.data(), _mm256_srli_epi32(mantissa, kMantissa - kKey), 4);
    // -1 where the mantissa is at or past the next step.
    const __m256i before = _mm256_cmpgt_epi32(_mm256_and_si256(entry, low), mantissa);
    const __m256i past = _mm256_andnot_si256(before, _mm256_set1_epi32(1));
    const __m256i octave =
        _mm256_sub_epi32(_mm256_srai_epi32(bits, kMantissa), _mm256_set1_epi32(127 - kOctaves));
    const __m256i bin = _mm256_add_epi32(
        _mm256_add_epi32(_mm256_slli_epi32(octave, 4), _mm256_srli_epi32(entry, kMantissa)), past);
    return _mm256_min_epi32(_mm256_max_epi32(bin, _mm256_setzero_si256()),
                            _mm256_set1_epi32(static_cast<int>(kBins) - 1));
  }

  double area_[2][kBins]{};
};

/// The largest value, and of equal ones the first in the character's order.
struct Largest {
  float value;
  std::int64_t number = -1;  // of the triangle; -1: nothing was larger than at the start
  std::uint32_t slot = 0;

  void offer(FloatLanes values, const MeshRest::Block& block, std::uint32_t first_slot) {
    int lanes = at_least(values, value);
    if (lanes == 0) return;
    float all[kLanes];
    values.store(all);
    for (; lanes != 0; lanes &= lanes - 1) {
      const auto lane = static_cast<std::uint32_t>(std::countr_zero(static_cast<unsigned>(lanes)));
      if (all[lane] > value || (all[lane] == value && block.number[lane] < number)) {
        value = all[lane];
        number = block.number[lane];
        slot = first_slot + lane;
      }
    }
  }
};

/// Triangles that have turned over.
struct Inverted {
  std::size_t count = 0;
  double area = 0.0;
  std::uint32_t first = std::numeric_limits<std::uint32_t>::max();  // number
  std::uint32_t slot = 0;

  void add(std::uint32_t lanes, const MeshRest& rest, std::uint32_t first_slot) {
    for (; lanes != 0; lanes &= lanes - 1) {
      const auto lane = static_cast<std::uint32_t>(std::countr_zero(lanes));
      ++count;
      area += rest.slot_area[first_slot + lane];
      const std::uint32_t number = rest.block[first_slot / kLanes].number[lane];
      if (number < first) {
        first = number;
        slot = first_slot + lane;
      }
    }
  }
};

int first_vertex(const MeshRest& rest, std::uint32_t slot) {
  return static_cast<int>(rest.vertex[rest.block[slot / kLanes].corner[0][slot % kLanes]]);
}

/// What a piece that moved as one adds to the volume about `middle`: its own about its tip, and
/// tip against the vector area that its rim spans.
double volume_of(const MeshRest::Piece& piece, const MeshRest& rest,
                 const std::vector<Corner>& corner) {
  const auto at = [&](std::uint32_t c) {
    const float* p = corner[c].position;
    return glm::dvec3(p[0], p[1], p[2]);
  };
  const glm::dvec3 tip = at(piece.tip);
  glm::dvec3 twice_area(0.0);
  for (std::size_t i = piece.first_rim; i < piece.first_rim + piece.rim_count; ++i)
    twice_area += glm::cross(at(rest.rim[i].a) - tip, at(rest.rim[i].b) - tip);
  return piece.volume + glm::dot(tip - rest.middle, twice_area) / 6.0;
}

/// One pass over the first triangles: all but the folds of their edges, for which it leaves the
/// faces' unit normals behind.
void measure_triangles(const MeshRest& rest, std::size_t blocks, const IdealStrain& ideal,
                       std::span<const glm::mat3> joint, Scratch& s, MeshMeasures& out) {
  const bool closed = rest.open_reason.empty();
  s.unit_normal.resize(blocks * kLanes);
  VolumeSum volume(rest.middle);
  AreaDistribution distribution;
  Largest stretch{1.0f}, strain{0.0f};
  Inverted inverted;
  for (std::uint32_t b = 0; b < blocks; ++b) {
    const MeshRest::Block& block = rest.block[b];
    const std::uint32_t slot = b * kLanes;
    const BlockCorners corners = corners_of(block, s.corner);
    const VectorLanes e1 = corners.p[1] - corners.p[0], e2 = corners.p[2] - corners.p[0];
    const VectorLanes face = cross(e1, e2);
    scatter((FloatLanes(1.0f) / square_root(dot(face, face))) * face, s.unit_normal[slot].axis);
    if (closed) volume.add(corners, block.present);
    inverted.add(turned_over(rest, block, face, joint, s.normal), rest, slot);

    const Gram g = triangle_gram(block, e1, e2);
    if (b < rest.torso.size()) {
      const Singular singular = singular_values(g);
      stretch.offer(singular.largest, block, slot);
      const FloatLanes amplified = strain_of(singular) / ideal.at(rest.torso[b]);
      distribution.add(amplified, &rest.slot_area[slot]);
      strain.offer(amplified, block, slot);
    } else {
      // mean + sqrt(apart) >= value^2, without the roots: few triangles come near the largest.
      const FloatLanes left = FloatLanes(stretch.value * stretch.value * 0.999f) - g.mean;
      if ((less(left, 0.0f) | at_least(g.apart, left * left)) != 0)
        stretch.offer(singular_values(g).largest, block, slot);
    }
  }
  out.stretch = stretch.value;
  if (stretch.number >= 0) out.stretch_vertex = first_vertex(rest, stretch.slot);
  if (strain.number >= 0) {
    out.strain = strain.value;
    out.strain_vertex = first_vertex(rest, strain.slot);
    out.strain_s = rest.torso[strain.slot / kLanes].s[strain.slot % kLanes];
  }
  out.strain_most = distribution.below(0.999, rest.torso_area);
  out.inverted = inverted.count;
  out.inverted_area = rest.area > 0.0 ? inverted.area / rest.area : kNan;
  if (inverted.count > 0) out.inverted_vertex = first_vertex(rest, inverted.slot);
  if (!closed) {
    out.volume_change = kNan;
    return;
  }
  double whole = volume.volume();
  if (blocks < rest.block.size())
    for (const MeshRest::Piece& piece : rest.piece) whole += volume_of(piece, rest, s.corner);
  out.volume_change = whole / rest.volume - 1.0;
}

/// The largest change of the angle between two triangles.
class LargestFold {
 public:
  /// Among the first blocks of edges.
  LargestFold(const MeshRest& rest, std::size_t edges, const Scratch& s)
      : rest_(rest), edges_(edges), s_(s) {}

  void measure() {
    // A few first: what cannot be as large as the largest of them need not be measured.
    constexpr std::size_t kEvery = 61;
    for (std::size_t b = 0; b < edges_; b += kEvery) offer(b, 0);
    for (std::size_t b = 0; b < edges_; ++b) {
      int lanes = may_be_largest(rest_.edge[b]);
      if (lanes != 0) lanes &= nearly_largest(b);
      for (; lanes != 0; lanes &= lanes - 1)
        offer(b, static_cast<std::size_t>(std::countr_zero(static_cast<unsigned>(lanes))));
    }
  }

  double angle() const { return std::acos(std::clamp(static_cast<double>(cosine_), -1.0, 1.0)); }
  int vertex() const { return vertex_; }

 private:
  /// An angle p folded from r changes by at most |p| + |r|. That stays below the largest change L,
  /// and the edge is out, where cos p > cos(L - |r|) = cos L cos r + sin L |sin r| and |r| < L.
  int may_be_largest(const MeshRest::EdgeBlock& edge) const {
    constexpr float kRounding =
        4e-6f;  // of the normals' products: some dozen units in the last place
    const FloatLanes rest_cosine = FloatLanes::load(edge.cosine);
    const FloatLanes least = FloatLanes(cosine_) * rest_cosine +
                             FloatLanes(sine_) * magnitude(FloatLanes::load(edge.sine));
    const auto product = [&](int i) {
      return _mm_mul_ps(_mm_load_ps(s_.unit_normal[edge.first[i]].axis),
                        _mm_load_ps(s_.unit_normal[edge.second[i]].axis));
    };
    const auto pair = [&](int i) {
      return _mm256_insertf128_ps(_mm256_castps128_ps256(product(i)), product(i + 4), 1);
    };
    const FloatLanes cosine(
        _mm256_hadd_ps(_mm256_hadd_ps(pair(0), pair(1)), _mm256_hadd_ps(pair(2), pair(3))));
    // A crack at a seam makes the edge's own angle smaller than the normals', or, past a right
    // angle, larger.
    const int out = less(least + kRounding, cosine) &
                    less(FloatLanes(cosine_) + kRounding, rest_cosine) & less(0.0f, cosine);
    return ~out & 0xff;
  }

  /// What offer() measures, from the unit normals: those that may come out as the largest.
  int nearly_largest(std::size_t block) const {
    constexpr float kRounding = 1e-5f;  // a hundred units in the last place of what is summed
    const MeshRest::EdgeBlock& edge = rest_.edge[block];
    const MeshRest::EdgeEnds* end = &rest_.end[block * kLanes];
    const VectorLanes n = gather([&](int i) { return s_.unit_normal[edge.first[i]].axis; });
    const VectorLanes m = gather([&](int i) { return s_.unit_normal[edge.second[i]].axis; });
    const VectorLanes along = gather([&](int i) { return s_.corner[end[i].b].position; }) -
                              gather([&](int i) { return s_.corner[end[i].a].position; });
    const FloatLanes cosine = dot(n, m);
    const FloatLanes sine = dot(cross(n, m), along) / square_root(dot(along, along));
    const FloatLanes size = square_root(cosine * cosine + sine * sine);
    const FloatLanes change =
        cosine * FloatLanes::load(edge.cosine) + sine * FloatLanes::load(edge.sine);
    return ~less(FloatLanes(cosine_) * size + kRounding, change) & 0xff;
  }

  void offer(std::size_t block, std::size_t lane) {
    const MeshRest::EdgeBlock& edge = rest_.edge[block];
    const MeshRest::EdgeEnds& end = rest_.end[block * kLanes + lane];
    const Fold now = fold(face(edge.first[lane]), face(edge.second[lane]), at(end.b) - at(end.a));
    const float cosine = now.cosine * edge.cosine[lane] + now.sine * edge.sine[lane];
    if (cosine < cosine_ || (cosine == cosine_ && end.number < number_)) {
      cosine_ = cosine;
      sine_ = std::abs(now.sine * edge.cosine[lane] - now.cosine * edge.sine[lane]);
      number_ = end.number;
      vertex_ = static_cast<int>(rest_.vertex[end.a]);
    }
  }
  glm::vec3 at(std::uint32_t corner) const {
    const float* p = s_.corner[corner].position;
    return {p[0], p[1], p[2]};
  }
  glm::vec3 face(std::uint32_t slot) const {
    const MeshRest::Block& block = rest_.block[slot / kLanes];
    const auto corner = [&](int k) { return at(block.corner[k][slot % kLanes]); };
    const glm::vec3 p = corner(0);
    return glm::cross(corner(1) - p, corner(2) - p);
  }

  const MeshRest& rest_;
  std::size_t edges_;
  const Scratch& s_;
  float cosine_ = 1.0f, sine_ = 0.0f;  // of the largest change
  std::int64_t number_ = -1;
  int vertex_ = -1;
};

}  // namespace

MeshMeasures measure_mesh(const MeshRest& rest, std::span<const glm::vec3> position,
                          const Facing& facing, const BendIntent& intent, double bone,
                          Parts parts) {
  const std::span<const glm::vec3> normal = facing.normal;
  assert(position.size() == rest.vertex_count && normal.size() == rest.vertex_count);
  assert(intent.bend.size() == rest.slice_count);
  MeshMeasures out;
  if (!all_finite(position) || !all_finite(normal)) {
    for (std::size_t v = 0; v < position.size(); ++v)
      out.not_finite += !(is_finite(position[v]) && is_finite(normal[v]));
    return out;
  }
  Scratch& s = scratch;
  const bool rigid = parts == Parts::rigid;
  const std::size_t corners = rigid ? rest.bending_corners : rest.vertex.size();
  unfold(rest, corners, position, s.corner);
  if (facing.joint.empty()) unfold(rest, corners, normal, s.normal);
  measure_triangles(rest, rigid ? rest.bending_blocks : rest.block.size(),
                    IdealStrain(rest, intent, bone), facing.joint, s, out);
  LargestFold folds(rest, rigid ? rest.bending_edges : rest.edge.size(), s);
  folds.measure();
  out.dihedral_deg = degrees(folds.angle());
  out.dihedral_vertex = folds.vertex();
  return out;
}

std::vector<float> strain_map(const MeshRest& rest, std::span<const glm::vec3> position,
                              const BendIntent& intent, double bone) {
  const IdealStrain ideal(rest, intent, bone);
  Scratch& s = scratch;
  unfold(rest, rest.bending_corners, position, s.corner);
  std::vector<float> map(rest.vertex_count, 0.0f);
  for (std::size_t b = 0; b < rest.torso.size(); ++b) {
    const MeshRest::Block& block = rest.block[b];
    const BlockCorners corners = corners_of(block, s.corner);
    float amplified[kLanes];
    (strain_of(singular_values(
         triangle_gram(block, corners.p[1] - corners.p[0], corners.p[2] - corners.p[0]))) /
     ideal.at(rest.torso[b]))
        .store(amplified);
    for (std::uint32_t lane = 0; lane < kLanes; ++lane)
      for (const auto& corner : block.corner) {
        float& here = map[rest.vertex[corner[lane]]];
        here = std::max(here, amplified[lane]);
      }
  }
  return map;
}

std::vector<float> inverted_map(const MeshRest& rest, std::span<const glm::vec3> position,
                                const Facing& facing) {
  Scratch& s = scratch;
  unfold(rest, rest.vertex.size(), position, s.corner);
  if (facing.joint.empty()) unfold(rest, rest.vertex.size(), facing.normal, s.normal);
  std::vector<float> map(rest.vertex_count, 0.0f);
  for (const MeshRest::Block& block : rest.block) {
    const BlockCorners corners = corners_of(block, s.corner);
    const VectorLanes face = cross(corners.p[1] - corners.p[0], corners.p[2] - corners.p[0]);
    const std::uint32_t over = turned_over(rest, block, face, facing.joint, s.normal);
    for (std::uint32_t lane = 0; lane < kLanes; ++lane)
      for (const auto& corner : block.corner)
        if ((over >> lane & 1) != 0) map[rest.vertex[corner[lane]]] = 1.0f;
  }
  return map;
}

PartDrift part_drift(std::span<const glm::vec3> rest_position, std::span<const std::uint8_t> part,
                     const solver::RigidMotion& moved, const solver::RigidMotion& carrier) {
  assert(part.size() == rest_position.size());
  PartDrift out;
  const glm::dmat3 turn = glm::mat3_cast(carrier.turn) - glm::mat3_cast(moved.turn);
  const glm::dvec3 shift = carrier.apply(glm::dvec3(0.0)) - moved.apply(glm::dvec3(0.0));
  double largest = 0.0;  // squared
  for (std::size_t v = 0; v < part.size(); ++v) {
    if (!part[v]) continue;
    const glm::dvec3 off = turn * glm::dvec3(rest_position[v]) + shift;
    const double square = glm::dot(off, off);
    if (!(square <= largest)) {  // NaN is kept
      largest = square;
      out = {std::sqrt(square), static_cast<int>(v)};
      if (std::isnan(square)) return out;
    }
  }
  return out;
}

}  // namespace backbend::validate
