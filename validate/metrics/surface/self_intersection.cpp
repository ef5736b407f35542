#include "validate/metrics/surface/self_intersection.h"

#include <immintrin.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <memory>
#include <numeric>

#include "validate/metrics/surface/connected_pieces.h"

namespace backbend::validate {
namespace {

// Coordinates as whole numbers of 39 bits with sign: differences take 40, their products in a
// determinant of three 120, which 128 hold.
constexpr int kBits = 38;
using Whole = std::int64_t;
__extension__ typedef __int128 Wide;

struct Point {
  Whole x, y, z;
};
Point operator-(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }

/// Powers of two only, so that every float of the body's size keeps all its digits.
class Lattice {
 public:
  explicit Lattice(float largest) {
    int exponent = 0;
    std::frexp(largest, &exponent);  // largest < 2^exponent
    scale_ = std::ldexp(1.0, kBits - exponent);
  }
  Point operator()(const glm::vec3& p) const { return {on(p.x), on(p.y), on(p.z)}; }

 private:
  // What is below a whole number is cut off: only digits that no float of the body's size has.
  Whole on(float x) const { return static_cast<Whole>(scale_ * static_cast<double>(x)); }
  double scale_ = 1.0;
};

int sign(Wide value) { return (value > 0) - (value < 0); }

/// Side of p against the plane through a, b, c: the sign of (b - a) x (c - a) . (p - a).
int side(const Point& a, const Point& b, const Point& c, const Point& p) {
  const Point u = b - a, v = c - a, w = p - a;
  // Nearly always decided by doubles: the differences are exact in them, and what the products and
  // sums lose is below 7 units of 2^-53 of the terms' sizes (Shewchuk 1997, section 4.3, whose
  // bound holds the differences' errors too).
  const double ux = static_cast<double>(u.x), uy = static_cast<double>(u.y),
               uz = static_cast<double>(u.z), vx = static_cast<double>(v.x),
               vy = static_cast<double>(v.y), vz = static_cast<double>(v.z),
               wx = static_cast<double>(w.x), wy = static_cast<double>(w.y),
               wz = static_cast<double>(w.z);
  const double value =
      wx * (uy * vz - uz * vy) + wy * (uz * vx - ux * vz) + wz * (ux * vy - uy * vx);
  const double size = std::abs(wx) * (std::abs(uy * vz) + std::abs(uz * vy)) +
                      std::abs(wy) * (std::abs(uz * vx) + std::abs(ux * vz)) +
                      std::abs(wz) * (std::abs(ux * vy) + std::abs(uy * vx));
  if (std::abs(value) > 1e-15 * size) return value > 0.0 ? 1 : -1;
  const auto minor = [](Whole a1, Whole b2, Whole b1, Whole a2) {
    return static_cast<Wide>(a1) * b2 - static_cast<Wide>(b1) * a2;
  };
  return sign(static_cast<Wide>(w.x) * minor(u.y, v.z, u.z, v.y) +
              static_cast<Wide>(w.y) * minor(u.z, v.x, u.x, v.z) +
              static_cast<Wide>(w.z) * minor(u.x, v.y, u.y, v.x));
}

struct Flat {
  Whole x, y;
};

int turn(const Flat& a, const Flat& b, const Flat& c) {
  return sign(static_cast<Wide>(b.x - a.x) * (c.y - a.y) -
              static_cast<Wide>(b.y - a.y) * (c.x - a.x));
}

/// Whether a point on the line through a and b lies between them, ends included.
bool between(const Flat& a, const Flat& b, const Flat& p) {
  return std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) && std::min(a.y, b.y) <= p.y &&
         p.y <= std::max(a.y, b.y);
}

bool segments_meet(const Flat& a, const Flat& b, const Flat& c, const Flat& d) {
  const int abc = turn(a, b, c), abd = turn(a, b, d), cda = turn(c, d, a), cdb = turn(c, d, b);
  if (abc * abd < 0 && cda * cdb < 0) return true;
  return (abc == 0 && between(a, b, c)) || (abd == 0 && between(a, b, d)) ||
         (cda == 0 && between(c, d, a)) || (cdb == 0 && between(c, d, b));
}

/// A segment and a triangle of one plane, seen along the axis that the plane is most square to.
bool meet_in_plane(const Point& p, const Point& q, const Point (&t)[3]) {
  const Point u = t[1] - t[0], v = t[2] - t[0];
  const Wide normal[3] = {static_cast<Wide>(u.y) * v.z - static_cast<Wide>(u.z) * v.y,
                          static_cast<Wide>(u.z) * v.x - static_cast<Wide>(u.x) * v.z,
                          static_cast<Wide>(u.x) * v.y - static_cast<Wide>(u.y) * v.x};
  const auto size = [&](int i) { return normal[i] < 0 ? -normal[i] : normal[i]; };
  const int axis = size(0) >= size(1) && size(0) >= size(2) ? 0 : size(1) >= size(2) ? 1 : 2;
  if (normal[axis] == 0) return false;
  const auto flat = [&](const Point& r) {
    return axis == 0 ? Flat{r.y, r.z} : axis == 1 ? Flat{r.z, r.x} : Flat{r.x, r.y};
  };
  const Flat a = flat(p), b = flat(q), f[3] = {flat(t[0]), flat(t[1]), flat(t[2])};
  for (int i = 0; i < 3; ++i)
    if (segments_meet(a, b, f[i], f[(i + 1) % 3])) return true;
  const int s[3] = {turn(f[0], f[1], a), turn(f[1], f[2], a), turn(f[2], f[0], a)};
  return s[0] == s[1] && s[1] == s[2];
}

/// A segment whose ends stand on the sides sp and sq of the triangle's plane.
bool segment_meets(const Point& p, int sp, const Point& q, int sq, const Point (&t)[3]) {
  if (sp * sq > 0) return false;
  if (sp == 0 && sq == 0) return meet_in_plane(p, q, t);
  // The line crosses the plane in one point: inside where it passes all edges on one side.
  const int s[3] = {side(p, q, t[0], t[1]), side(p, q, t[1], t[2]), side(p, q, t[2], t[0])};
  const bool left = s[0] > 0 || s[1] > 0 || s[2] > 0, right = s[0] < 0 || s[1] < 0 || s[2] < 0;
  return !(left && right);
}

bool meet(const Point (&a)[3], const Point (&b)[3]) {
  int of_b[3], of_a[3];
  for (int i = 0; i < 3; ++i) of_b[i] = side(a[0], a[1], a[2], b[i]);
  if (of_b[0] * of_b[1] > 0 && of_b[1] * of_b[2] > 0) return false;
  for (int i = 0; i < 3; ++i) of_a[i] = side(b[0], b[1], b[2], a[i]);
  if (of_a[0] * of_a[1] > 0 && of_a[1] * of_a[2] > 0) return false;
  // Closed triangles meet only where an edge of one meets the other.
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    if (segment_meets(b[i], of_b[i], b[j], of_b[j], a) ||
        segment_meets(a[i], of_a[i], a[j], of_a[j], b))
      return true;
  }
  return false;
}

/// Corners of a box; the fourth lane is 0 in both.
struct Box {
  __m128 low, high;

  void add(const Box& other) {
    low = _mm_min_ps(low, other.low);
    high = _mm_max_ps(high, other.high);
  }
};

bool overlap(const Box& a, const Box& b) {
  return _mm_movemask_ps(_mm_or_ps(_mm_cmpgt_ps(a.low, b.high), _mm_cmpgt_ps(b.low, a.high))) == 0;
}

float largest_of(std::span<const glm::vec3> position) {
  float largest = 0.0f;
  for (const glm::vec3& p : position)
    largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  return largest;
}

bool share_a_place(const glm::uvec3& a, const glm::uvec3& b) {
  for (int i = 0; i < 3; ++i)
    if (a[i] == b.x || a[i] == b.y || a[i] == b.z) return true;
  return false;
}

/// How many numbers there are, of which the last stands in a triangle.
std::uint32_t count_of(const std::vector<glm::uvec3>& triangles) {
  std::uint32_t count = 0;
  for (const glm::uvec3& t : triangles) count = std::max({count, t.x + 1, t.y + 1, t.z + 1});
  return count;
}

constexpr std::uint32_t kLeaf = 8;  // triangles: as many as a register has lanes

/// The boxes of a leaf's triangles, a coordinate of all of them at a time. Where there are fewer
/// than kLeaf, the rest are boxes that overlap none.
struct alignas(32) LeafBoxes {
  float low[3][kLeaf], high[3][kLeaf];

  void clear() {
    constexpr float kBeyond = std::numeric_limits<float>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      std::ranges::fill(low[axis], kBeyond);
      std::ranges::fill(high[axis], -kBeyond);
    }
  }
  void set(std::uint32_t i, const Box& box) {
    alignas(16) float lower[4], upper[4];
    _mm_store_ps(lower, box.low);
    _mm_store_ps(upper, box.high);
    for (int axis = 0; axis < 3; ++axis) {
      low[axis][i] = lower[axis];
      high[axis][i] = upper[axis];
    }
  }
  /// Which of them overlap a box: a bit each.
  unsigned overlapping(const Box& box) const {
    alignas(16) float lower[4], upper[4];
    _mm_store_ps(lower, box.low);
    _mm_store_ps(upper, box.high);
    __m256 all = _mm256_castsi256_ps(_mm256_set1_epi32(-1));
    for (int axis = 0; axis < 3; ++axis) {
      const __m256 starts =
          _mm256_cmp_ps(_mm256_load_ps(low[axis]), _mm256_set1_ps(upper[axis]), _CMP_LE_OQ);
      const __m256 ends =
          _mm256_cmp_ps(_mm256_load_ps(high[axis]), _mm256_set1_ps(lower[axis]), _CMP_GE_OQ);
      all = _mm256_and_ps(all, _mm256_and_ps(starts, ends));
    }
    return static_cast<unsigned>(_mm256_movemask_ps(all));
  }
};

/// Calls `act` with the place of every bit that is set.
template <class Act>
void each_bit(unsigned bits, const Act& act) {
  for (; bits != 0; bits &= bits - 1) act(static_cast<std::uint32_t>(std::countr_zero(bits)));
}

}  // namespace

bool triangles_meet(const glm::vec3 (&a)[3], const glm::vec3 (&b)[3]) {
  const Lattice lattice(std::max(largest_of(a), largest_of(b)));
  return meet({lattice(a[0]), lattice(a[1]), lattice(a[2])},
              {lattice(b[0]), lattice(b[1]), lattice(b[2])});
}

/// One pose: boxes of every node, and the walk over pairs of nodes.
struct SelfIntersection::Search {
  const SelfIntersection& mesh;
  std::span<const glm::vec3> position;
  Lattice lattice;
  std::vector<Box> point;
  std::vector<Box> box;  // per node
  // Of triangles, and all of a leaf's together: filled in where the walk comes to the leaf.
  std::vector<bool> is_filled;
  std::unique_ptr<Box[]> triangle_box;  // per entry of order_
  std::unique_ptr<LeafBoxes[]> leaf;
  std::vector<Pair> found;

  Search(const SelfIntersection& of, std::span<const glm::vec3> at)
      : mesh(of),
        position(at),
        lattice(largest_of(at)),
        point(at.size()),
        box(of.node_.size()),
        is_filled(of.leaves_, false),
        triangle_box(std::make_unique_for_overwrite<Box[]>(of.order_.size())),
        leaf(std::make_unique_for_overwrite<LeafBoxes[]>(of.leaves_)) {
    for (std::size_t v = 0; v < point.size(); ++v)
      point[v].low = point[v].high = _mm_setr_ps(position[v].x, position[v].y, position[v].z, 0.0f);
    for (std::size_t n = box.size(); n-- > 0;) {  // children stand after their parents
      const Node& node = mesh.node_[n];
      box[n] = node.right != 0 ? box[n + 1] : around(node.leaf);
      if (node.right != 0) box[n].add(box[node.right]);
    }
  }

  Box around(std::uint32_t number) const {
    const std::span vertices =
        std::span(mesh.vertex_of_leaf_)
            .subspan(mesh.first_vertex_[number],
                     mesh.first_vertex_[number + 1] - mesh.first_vertex_[number]);
    Box out = point[vertices.front()];
    for (const std::uint32_t v : vertices) out.add(point[v]);
    return out;
  }

  /// The boxes of a leaf's triangles.
  const LeafBoxes& filled(const Node& node) {
    if (is_filled[node.leaf]) return leaf[node.leaf];
    is_filled[node.leaf] = true;
    leaf[node.leaf].clear();
    for (std::uint32_t i = 0; i < node.count; ++i) {
      const glm::uvec3& corner = mesh.triangle_[mesh.order_[node.first + i]];
      Box& one = triangle_box[node.first + i] = point[corner.x];
      one.add(point[corner.y]);
      one.add(point[corner.z]);
      leaf[node.leaf].set(i, one);
    }
    return leaf[node.leaf];
  }

  /// Triangles of two leaves that are neighbours, as Neighbour has them.
  std::uint64_t neighbours(std::uint32_t a, std::uint32_t b) const {
    for (std::uint32_t k = mesh.first_neighbour_[a]; k < mesh.first_neighbour_[a + 1]; ++k)
      if (mesh.neighbour_[k].leaf == b) return mesh.neighbour_[k].triangles;
    return 0;
  }

  /// Two triangles whose boxes overlap.
  void test(std::uint32_t i, std::uint32_t j) {
    std::uint32_t a = mesh.order_[i], b = mesh.order_[j];
    if (a > b) std::swap(a, b);
    if (mesh.group_[a] >= 0 && mesh.group_[a] == mesh.group_[b]) return;
    if (share_a_place(mesh.places_[a], mesh.places_[b])) return;
    const auto corners = [&](std::uint32_t t, Point(&out)[3]) {
      for (int c = 0; c < 3; ++c) out[c] = lattice(position[mesh.triangle_[t][c]]);
    };
    Point s[3], t[3];
    corners(a, s);
    corners(b, t);
    if (meet(s, t)) found.push_back({a, b});
  }

  void inside(std::uint32_t n) {
    const Node& node = mesh.node_[n];
    if (node.group >= 0) return;
    if (node.right != 0) {
      inside(n + 1);
      inside(node.right);
      across(n + 1, node.right);
      return;
    }
    const LeafBoxes& own = filled(node);
    std::uint64_t joined = neighbours(node.leaf, node.leaf);
    for (std::uint32_t i = 0; i < node.count; ++i, joined >>= kLeaf) {
      const unsigned before = (2u << i) - 1;  // and itself
      each_bit(
          own.overlapping(triangle_box[node.first + i]) & ~before & ~static_cast<unsigned>(joined),
          [&](std::uint32_t j) { test(node.first + i, node.first + j); });
    }
  }

  void across(std::uint32_t a, std::uint32_t b) {
    const Node &p = mesh.node_[a], &q = mesh.node_[b];
    if ((p.group >= 0 && p.group == q.group) || !overlap(box[a], box[b])) return;
    if (p.right == 0 && q.right == 0) {
      const unsigned near = filled(p).overlapping(box[b]);
      if (near == 0) return;
      const std::uint64_t joined = neighbours(p.leaf, q.leaf);
      const LeafBoxes& other = filled(q);
      each_bit(near, [&](std::uint32_t i) {
        each_bit(other.overlapping(triangle_box[p.first + i]) &
                     ~static_cast<unsigned>(joined >> (kLeaf * i)),
                 [&](std::uint32_t j) { test(p.first + i, q.first + j); });
      });
    } else if (q.right == 0 || (p.right != 0 && p.count >= q.count)) {
      across(a + 1, b);
      across(p.right, b);
    } else {
      across(a, b + 1);
      across(a, q.right);
    }
  }
};

SelfIntersection::SelfIntersection(std::span<const glm::vec3> rest_position,
                                   std::span<const glm::uvec3> triangle,
                                   std::span<const std::uint32_t> place, std::span<const int> group)
    : triangle_(triangle.begin(), triangle.end()) {
  for (const glm::uvec3& corner : triangle_) {
    places_.emplace_back(place[corner.x], place[corner.y], place[corner.z]);
    const bool rigid =
        !group.empty() && group[corner.x] == group[corner.y] && group[corner.y] == group[corner.z];
    group_.push_back(rigid ? group[corner.x] : -1);
  }
  prepare(rest_position);
}

SelfIntersection SelfIntersection::without_groups(std::span<const glm::vec3> rest_position) const {
  SelfIntersection out;
  out.triangle_ = triangle_;
  out.places_ = places_;
  out.group_.assign(group_.size(), -1);
  out.prepare(rest_position);
  return out;
}

void SelfIntersection::prepare(std::span<const glm::vec3> rest_position) {
  std::vector<glm::vec3> middle;
  for (std::uint32_t t = 0; t < triangle_.size(); ++t) {
    const glm::uvec3& corner = triangle_[t];
    const glm::vec3 &a = rest_position[corner.x], &b = rest_position[corner.y],
                    &c = rest_position[corner.z];
    area_.push_back(0.5f * glm::length(glm::cross(b - a, c - a)));
    whole_area_ += area_.back();
    middle.push_back((a + b + c) / 3.0f);
    order_.push_back(t);
  }
  if (order_.empty()) return;
  // Groups apart from each other: pairs of whole branches fall away.
  std::ranges::stable_sort(order_, {}, [&](std::uint32_t t) { return group_[t]; });
  build(0, static_cast<std::uint32_t>(order_.size()), middle);
  list_vertices();
  find_neighbours();
  rest_pairs_ = pairs(rest_position);
  find_shells();
}

void SelfIntersection::list_vertices() {
  first_vertex_.push_back(0);
  for (const Node& node : node_) {  // leaves come in the order of their numbers
    if (node.right != 0) continue;
    const std::ptrdiff_t begin = first_vertex_.back();
    for (std::uint32_t i = 0; i < node.count; ++i)
      for (int k = 0; k < 3; ++k) vertex_of_leaf_.push_back(triangle_[order_[node.first + i]][k]);
    std::sort(vertex_of_leaf_.begin() + begin, vertex_of_leaf_.end());
    vertex_of_leaf_.erase(std::unique(vertex_of_leaf_.begin() + begin, vertex_of_leaf_.end()),
                          vertex_of_leaf_.end());
    first_vertex_.push_back(static_cast<std::uint32_t>(vertex_of_leaf_.size()));
  }
}

void SelfIntersection::find_neighbours() {
  // Neighbours around a place with more triangles than this are told apart one by one.
  constexpr std::uint32_t kMostOfPlace = 32;
  std::vector<std::uint32_t> first(count_of(places_) + 1, 0), leaf_of(order_.size()),
      lane_of(order_.size());
  for (const glm::uvec3& t : places_)
    for (int k = 0; k < 3; ++k) ++first[t[k] + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<std::uint32_t> around(first.back()), next(first.begin(), first.end() - 1);
  for (std::uint32_t t = 0; t < places_.size(); ++t)
    for (int k = 0; k < 3; ++k) around[next[places_[t][k]]++] = t;
  for (const Node& node : node_) {
    for (std::uint32_t i = 0; node.right == 0 && i < node.count; ++i) {
      leaf_of[order_[node.first + i]] = node.leaf;
      lane_of[order_[node.first + i]] = i;
    }
  }
  for (const Node& node : node_) {  // leaves come in the order of their numbers
    if (node.right != 0) continue;
    const auto begin = static_cast<std::ptrdiff_t>(neighbour_.size());
    first_neighbour_.push_back(static_cast<std::uint32_t>(begin));
    for (std::uint32_t i = 0; i < node.count; ++i) {
      const glm::uvec3& corner = places_[order_[node.first + i]];
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t from = first[corner[k]], to = first[corner[k] + 1];
        if (to - from > kMostOfPlace) continue;
        for (const std::uint32_t t : std::span(around).subspan(from, to - from)) {
          auto near = std::find_if(neighbour_.begin() + begin, neighbour_.end(),
                                   [&](const Neighbour& each) { return each.leaf == leaf_of[t]; });
          if (near == neighbour_.end()) near = neighbour_.insert(near, {leaf_of[t], 0});
          near->triangles |= std::uint64_t{1} << (kLeaf * i + lane_of[t]);
        }
      }
    }
  }
  first_neighbour_.push_back(static_cast<std::uint32_t>(neighbour_.size()));
}

void SelfIntersection::find_shells() {
  const std::vector<std::uint32_t> piece = connected_pieces(places_, {}, count_of(places_));
  for (const glm::uvec3& t : places_) shell_.push_back(piece[t[0]]);
  for (const Pair& pair : rest_pairs_)
    if (shell_[pair.first] != shell_[pair.second]) joined_shells_.push_back(shells_of(pair));
  std::ranges::sort(joined_shells_);
  joined_shells_.erase(std::unique(joined_shells_.begin(), joined_shells_.end()),
                       joined_shells_.end());
}

SelfIntersection::Pair SelfIntersection::shells_of(const Pair& pair) const {
  const auto [low, high] = std::minmax(shell_[pair.first], shell_[pair.second]);
  return {low, high};
}

void SelfIntersection::build(std::uint32_t first, std::uint32_t count,
                             const std::vector<glm::vec3>& middle) {
  const std::size_t number = node_.size();
  const auto group_at = [&](std::uint32_t i) { return group_[order_[i]]; };
  const bool one_group = group_at(first) == group_at(first + count - 1);  // they are sorted
  node_.push_back({first, count, 0, one_group ? group_at(first) : -1});
  if (count <= kLeaf) {
    node_[number].leaf = leaves_++;
    return;
  }
  std::uint32_t left = count / 2;
  if (one_group) {
    glm::vec3 low = middle[order_[first]], high = low;
    for (std::uint32_t i = first; i < first + count; ++i) {
      low = glm::min(low, middle[order_[i]]);
      high = glm::max(high, middle[order_[i]]);
    }
    const glm::vec3 size = high - low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const auto begin = order_.begin() + first;
    std::nth_element(begin, begin + left, begin + count, [&](std::uint32_t a, std::uint32_t b) {
      return middle[a][axis] != middle[b][axis] ? middle[a][axis] < middle[b][axis] : a < b;
    });
  } else {  // at the border of groups that is nearest to the middle
    std::uint32_t best = 0;
    for (std::uint32_t i = 1; i < count; ++i) {
      const auto off = [&](std::uint32_t at) { return at > left ? at - left : left - at; };
      if (group_at(first + i) != group_at(first + i - 1) && (best == 0 || off(i) < off(best)))
        best = i;
    }
    left = best;
  }
  build(first, left, middle);
  node_[number].right = static_cast<std::uint32_t>(node_.size());
  build(first + left, count - left, middle);
}

std::vector<SelfIntersection::Pair> SelfIntersection::pairs(
    std::span<const glm::vec3> position) const {
  if (node_.empty()) return {};
  Search search(*this, position);
  search.inside(0);
  std::ranges::sort(search.found);
  return std::move(search.found);
}

std::vector<SelfIntersection::Pair> SelfIntersection::new_pairs(
    std::span<const glm::vec3> position) const {
  const std::vector<Pair> now = pairs(position);
  std::vector<Pair> out;
  std::ranges::set_difference(now, rest_pairs_, std::back_inserter(out));
  std::erase_if(out, [&](const Pair& pair) {
    return std::ranges::binary_search(joined_shells_, shells_of(pair));
  });
  return out;
}

SelfIntersection::Measures SelfIntersection::measure(std::span<const glm::vec3> position) const {
  const std::vector<Pair> now = new_pairs(position);
  std::vector<std::uint32_t> involved;
  for (const Pair& pair : now) {
    involved.push_back(pair.first);
    involved.push_back(pair.second);
  }
  std::ranges::sort(involved);
  involved.erase(std::unique(involved.begin(), involved.end()), involved.end());
  Measures out;
  out.pairs = now.size();
  float largest = -1.0f;
  double area = 0.0;
  for (const std::uint32_t t : involved) {
    area += area_[t];
    if (area_[t] > largest) {
      largest = area_[t];
      out.vertex = static_cast<int>(triangle_[t].x);
    }
  }
  if (whole_area_ > 0.0) out.area = area / whole_area_;
  return out;
}

}  // namespace backbend::validate
