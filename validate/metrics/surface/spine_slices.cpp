#include "validate/metrics/surface/spine_slices.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <optional>

#include "validate/metrics/math/nan.h"
#include "validate/metrics/math/rotation.h"

namespace backbend::validate {
namespace {

using EdgeKey = std::pair<std::uint32_t, std::uint32_t>;  // places, lower first

/// A step of a ring: to another crossing, over a triangle.
struct Step {
  EdgeKey to;
  glm::uvec3 triangle{0};
};

/// An edge of the mesh that crosses a level: the slice point, and the steps from it.
struct Crossing {
  SlicePoint point;
  glm::dvec3 at{0.0};
  std::vector<Step> step;
};
using Crossings = std::map<EdgeKey, Crossing>;  // ordered: the same rings on every machine

struct Piece {
  std::vector<SlicePoint> point;
  std::vector<glm::dvec3> at;
  std::vector<char> gap_after;  // empty, or 1 where no surface leads to the next point
  bool closed = false;
};

glm::dvec3 vector_area(std::span<const glm::dvec3> ring, const glm::dvec3& about) {
  glm::dvec3 area(0.0);
  for (std::size_t i = 0; i < ring.size(); ++i)
    area += 0.5 * glm::cross(ring[i] - about, ring[(i + 1) % ring.size()] - about);
  return area;
}

/// Axes across the spine: `left` as near as can be, and the one that makes them right-handed.
struct Across {
  glm::dvec3 tangent, left, other;

  Across(const glm::dvec3& t, const glm::dvec3& wish) : tangent(t) {
    left = wish - glm::dot(wish, t) * t;
    if (glm::length(left) < 1e-6 * glm::length(wish)) {
      const glm::dvec3 any = std::abs(t.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
      left = any - glm::dot(any, t) * t;
    }
    left = glm::normalize(left);
    other = glm::cross(t, left);
  }
  double angle(const glm::dvec3& offset) const {
    return std::atan2(glm::dot(offset, other), glm::dot(offset, left));
  }
};

/// Whether a ring goes round the middle, seen along the spine. The last point joins the first.
bool goes_round(std::span<const glm::dvec3> ring, const Across& across, const glm::dvec3& middle) {
  double turned = 0.0;
  for (std::size_t i = 0; i < ring.size(); ++i)
    turned += wrapped(across.angle(ring[(i + 1) % ring.size()] - middle) -
                      across.angle(ring[i] - middle));
  return std::abs(turned) > kPi;
}

class LevelCutter {
 public:
  LevelCutter(const RestMesh& mesh, std::span<const float> coordinate)
      : mesh_(mesh), coordinate_(coordinate) {}

  void add(const glm::uvec3& t, float level, Crossings& crossings) const {
    EdgeKey found[2];
    int count = 0;
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t a = t[i], b = t[(i + 1) % 3];
      const float sa = coordinate_[mesh_.place[a]], sb = coordinate_[mesh_.place[b]];
      // A vertex exactly on the level counts as above it: every triangle then has 0 or 2 crossings.
      if ((sa >= level) == (sb >= level)) continue;
      const bool forward = mesh_.place[a] < mesh_.place[b];
      const EdgeKey key = forward ? EdgeKey(mesh_.place[a], mesh_.place[b])
                                  : EdgeKey(mesh_.place[b], mesh_.place[a]);
      Crossing& crossing = crossings[key];
      if (crossing.step.empty()) {
        crossing.point = forward ? SlicePoint{a, b, (level - sa) / (sb - sa)}
                                 : SlicePoint{b, a, (level - sb) / (sa - sb)};
        crossing.at = glm::mix(glm::dvec3(mesh_.position[crossing.point.a]),
                               glm::dvec3(mesh_.position[crossing.point.b]),
                               static_cast<double>(crossing.point.share));
      }
      found[count++] = key;
    }
    if (count != 2) return;
    std::vector<Step>& step = crossings[found[0]].step;
    // A triangle doubled for its back face, or by another level of detail, is one step.
    if (std::ranges::find(step, found[1], &Step::to) != step.end()) return;
    step.push_back({found[1], t});
    crossings[found[1]].step.push_back({found[0], t});
  }

  /// Which step to take after `last`: where several surfaces meet in one edge (levels of detail
  /// share some), the one that shares two vertices, and so stays on its surface.
  static std::vector<Step>::iterator onward(std::vector<Step>& step,
                                            const std::optional<Step>& last) {
    const auto shared = [&](const Step& s) {
      int count = 0;
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) count += s.triangle[i] == last->triangle[k];
      return count >= 2;
    };
    if (step.size() > 1 && last)
      if (const auto same = std::ranges::find_if(step, shared); same != step.end()) return same;
    return std::prev(step.end());
  }

  /// Takes the crossings apart into rings and open pieces.
  static std::vector<Piece> pieces(Crossings crossings, const Across& across,
                                   const glm::dvec3& middle) {
    drop_inner_walls(crossings, across, middle);
    std::vector<Piece> out;
    const auto walk = [&](EdgeKey at) {
      Piece piece;
      const EdgeKey start = at;
      std::optional<Step> last;  // the one that led here
      for (;;) {
        Crossing& here = crossings.at(at);
        piece.point.push_back(here.point);
        piece.at.push_back(here.at);
        if (here.step.empty()) break;
        const auto next = onward(here.step, last);
        last = *next;
        here.step.erase(next);
        std::vector<Step>& back = crossings.at(last->to).step;
        back.erase(std::ranges::find(back, at, &Step::to));
        if (last->to == start) {
          piece.closed = true;
          break;
        }
        at = last->to;
      }
      if (piece.point.size() > 2) out.push_back(std::move(piece));
    };
    for (auto& [key, crossing] : crossings)  // ends of open pieces first
      if (crossing.step.size() == 1) walk(key);
    for (auto& [key, crossing] : crossings)
      if (!crossing.step.empty()) walk(key);
    return out;
  }

 private:
  /// From a crossing where surfaces meet, over the step to `to` and on, to the next such crossing
  /// or an end.
  static std::vector<EdgeKey> chain_from(const Crossings& crossings, const EdgeKey& from,
                                         EdgeKey to) {
    std::vector<EdgeKey> chain{from, to};
    for (const Crossing* here = &crossings.at(to); here->step.size() == 2 && to != from;
         here = &crossings.at(to)) {
      const EdgeKey back = chain[chain.size() - 2];
      to = here->step[here->step[0].to == back ? 1 : 0].to;
      chain.push_back(to);
    }
    return chain;
  }

  /// Where three surfaces lead from one edge to one other, and two of them go round the middle, the
  /// third stands inside: the wall that is left where halves were mirrored.
  static void drop_inner_walls(Crossings& crossings, const Across& across,
                               const glm::dvec3& middle) {
    for (auto& [key, crossing] : crossings) {
      if (crossing.step.size() != 3) continue;
      std::vector<EdgeKey> chain[3];
      for (std::size_t i = 0; i < 3; ++i)
        chain[i] = chain_from(crossings, key, crossing.step[i].to);
      const EdgeKey end = chain[0].back();
      if (end == key || chain[1].back() != end || chain[2].back() != end ||
          crossings.at(end).step.size() != 3)
        continue;
      std::optional<std::size_t> inner;
      double largest = 0.0;
      for (std::size_t i = 0; i < 3; ++i) {
        std::vector<glm::dvec3> ring;
        for (const EdgeKey& k : chain[(i + 1) % 3]) ring.push_back(crossings.at(k).at);
        const std::vector<EdgeKey>& back = chain[(i + 2) % 3];
        for (std::size_t k = back.size(); k-- > 0;) ring.push_back(crossings.at(back[k]).at);
        const double area = glm::length(vector_area(ring, ring.front()));
        if (area <= largest) continue;
        largest = area;
        inner = goes_round(ring, across, middle) ? std::optional(i) : std::nullopt;
      }
      if (!inner) continue;
      for (std::size_t k = 1; k < chain[*inner].size(); ++k) {
        const EdgeKey a = chain[*inner][k - 1], b = chain[*inner][k];
        std::erase_if(crossings.at(a).step, [&](const Step& step) { return step.to == b; });
        std::erase_if(crossings.at(b).step, [&](const Step& step) { return step.to == a; });
      }
    }
  }

  const RestMesh& mesh_;
  std::span<const float> coordinate_;
};

void reverse(Piece& piece) {
  std::ranges::reverse(piece.point);
  std::ranges::reverse(piece.at);
}

/// Strings open pieces together into one ring: by their angle around the middle, each run so that
/// it goes round the same way.
Piece join_open(std::vector<Piece>& open, const Across& across, const glm::dvec3& middle) {
  struct Placed {
    double angle;
    Piece* piece;
  };
  std::vector<Placed> order;
  for (Piece& piece : open) {
    double turned = 0.0;  // about the middle, from its first point to its last
    for (std::size_t i = 1; i < piece.at.size(); ++i)
      turned +=
          wrapped(across.angle(piece.at[i] - middle) - across.angle(piece.at[i - 1] - middle));
    if (turned < 0.0) reverse(piece);
    order.push_back({across.angle(piece.at[piece.at.size() / 2] - middle), &piece});
  }
  std::ranges::stable_sort(order, {}, &Placed::angle);
  Piece ring;
  for (const Placed& placed : order) {
    ring.point.insert(ring.point.end(), placed.piece->point.begin(), placed.piece->point.end());
    ring.at.insert(ring.at.end(), placed.piece->at.begin(), placed.piece->at.end());
    ring.gap_after.resize(ring.at.size(), 0);
    ring.gap_after.back() = 1;
  }
  return ring;
}

constexpr double kLeastShare = 0.02;

double spine_share(const RestMesh& mesh, const SlicePoint& p) {
  if (mesh.spine_share.empty()) return 1.0;
  return glm::mix(mesh.spine_share[p.a], mesh.spine_share[p.b], p.share);
}

/// Where a ring crosses the half-plane at an angle around its centre: the outermost of its
/// crossings.
LinePoint line_point(const Piece& ring, const Across& across, const glm::dvec3& centre,
                     double angle) {
  LinePoint out;
  double farthest = -1.0;
  const std::size_t n = ring.at.size();
  for (std::size_t i = 0; i < n; ++i) {
    const glm::dvec3 a = ring.at[i] - centre, b = ring.at[(i + 1) % n] - centre;
    const double before = wrapped(across.angle(a) - angle),
                 after = wrapped(across.angle(b) - angle);
    // A step past the angle and not past its opposite.
    if ((before < 0.0) == (after < 0.0) || std::abs(after - before) > kPi) continue;
    const double share = before / (before - after);
    const glm::dvec3 offset = glm::mix(a, b, share);
    if (glm::dot(offset, offset) <= farthest) continue;
    farthest = glm::dot(offset, offset);
    out = {static_cast<std::uint32_t>(i), static_cast<float>(share),
           ring.gap_after.empty() || !ring.gap_after[i], offset};
  }
  return out;
}

/// Weights, cosines and lines of a chosen ring.
Slice finish(const RestMesh& mesh, Piece ring, double s, const Across& across) {
  Slice slice;
  slice.s = s;
  slice.ring = std::move(ring.point);
  const std::size_t n = ring.at.size();
  slice.weight.assign(n, 0.0);
  double length = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    if (!ring.gap_after.empty() && ring.gap_after[i])
      continue;  // a straight line across a gap is not part of the surface
    const std::size_t next = (i + 1) % n;
    const double half = 0.5 * glm::distance(ring.at[i], ring.at[next]);
    slice.weight[i] += half * spine_share(mesh, slice.ring[i]);
    slice.weight[next] += half * spine_share(mesh, slice.ring[next]);
    length += 2.0 * half;
  }
  double sum = 0.0;
  for (double w : slice.weight) sum += w;
  slice.spine_share = sum / length;
  // Without the spine's share the centre would be no one's: it is then that of the whole ring.
  if (sum < kLeastShare * length) {
    slice.weight.assign(n, 1.0);
    sum = static_cast<double>(n);
  }
  glm::dvec3 centre(0.0);
  for (std::size_t i = 0; i < n; ++i) {
    slice.weight[i] /= sum;
    centre += slice.weight[i] * ring.at[i];
  }
  for (std::size_t i = 0; i < n; ++i)
    slice.cosine.push_back(slice.weight[i] * std::cos(across.angle(ring.at[i] - centre)));
  for (int k = 0; k < kLineCount; ++k)
    slice.line.push_back(line_point(ring, across, centre, wrapped(2.0 * kPi * k / kLineCount)));
  return slice;
}

/// The largest ring around the middle that some pieces make: closed ones by themselves, all open
/// ones together. No points where none goes round.
Piece largest_ring(std::vector<Piece> pieces, const glm::dvec3& middle, const Across& across) {
  std::vector<Piece> open;
  std::vector<Piece> candidates;
  for (Piece& piece : pieces) (piece.closed ? candidates : open).push_back(std::move(piece));
  if (!open.empty()) candidates.push_back(join_open(open, across, middle));
  Piece best;
  double largest = 0.0;
  for (Piece& candidate : candidates) {
    const double area = glm::length(vector_area(candidate.at, middle));
    if (area > largest && goes_round(candidate.at, across, middle)) {
      largest = area;
      best = std::move(candidate);
    }
  }
  return best;
}

constexpr double kLike = 0.5;             // of the larger one's area
constexpr double kFarthestBeside = 3.0;   // radii: a ring further off is of something else
constexpr double kMeasuredBeside = 0.25;  // ... and one so far bends about a place in the air

glm::dvec3 middle_of(const std::vector<glm::dvec3>& points) {
  glm::dvec3 sum(0.0);
  for (const glm::dvec3& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

/// The ring beside the middle that the spine moves: the largest closed one, for a spine that
/// stands outside the body. No points where there is none, and where the middle is between two
/// rings of like size: hips that stand below the crotch are between the legs.
Piece ring_beside(const RestMesh& mesh, const std::vector<Piece>& pieces,
                  const glm::dvec3& middle) {
  std::vector<std::pair<double, const Piece*>> closed;
  for (const Piece& piece : pieces)
    if (piece.closed)
      closed.emplace_back(glm::length(vector_area(piece.at, piece.at.front())), &piece);
  std::ranges::stable_sort(closed, std::greater<>(), &std::pair<double, const Piece*>::first);
  if (closed.size() > 1 && closed[1].first > kLike * closed[0].first &&
      glm::dot(middle_of(closed[0].second->at) - middle, middle_of(closed[1].second->at) - middle) <
          0.0)
    return {};
  for (const auto& [area, piece] : closed) {
    double share = 0.0;
    for (const SlicePoint& p : piece->point) share += spine_share(mesh, p);
    if (area > 0.0 && share >= kSpineSlice * static_cast<double>(piece->point.size()))  // no leg
      return *piece;
  }
  return {};
}

/// Whether one of the pieces is a ring of like size that lies beside this one.
bool has_twin(const Piece& ring, const std::vector<Piece>& pieces, const Across& across) {
  const double area = glm::length(vector_area(ring.at, ring.at.front()));
  return std::ranges::any_of(pieces, [&](const Piece& piece) {
    return piece.closed && piece.at != ring.at &&
           glm::length(vector_area(piece.at, piece.at.front())) > kLike * area &&
           !goes_round(ring.at, across, middle_of(piece.at)) &&
           !goes_round(piece.at, across, middle_of(ring.at));
  });
}

double radius_of(const Piece& ring, const glm::dvec3& point) {
  return std::sqrt(glm::length(vector_area(ring.at, point)) / kPi);
}

/// How far a point outside a ring stands from it.
double distance_to(const Piece& ring, const glm::dvec3& point) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < ring.at.size(); ++i) {
    const glm::dvec3 from = ring.at[i], step = ring.at[(i + 1) % ring.at.size()] - from;
    const double squared = glm::dot(step, step);
    const double share =
        squared > 0.0 ? std::clamp(glm::dot(point - from, step) / squared, 0.0, 1.0) : 0.0;
    nearest = std::min(nearest, glm::distance(point, from + share * step));
  }
  return nearest;
}

Slice choose_ring(const RestMesh& mesh, const std::vector<Piece>& pieces, double s,
                  const glm::dvec3& middle, const Across& across) {
  // The body below a breastplate is what bends.
  std::vector<Piece> soft;
  for (const Piece& piece : pieces)
    if (mesh.rigid.empty() || mesh.rigid[piece.point.front().a] == 0) soft.push_back(piece);
  Piece ring = largest_ring(soft, middle, across);
  if (ring.at.empty()) ring = largest_ring(pieces, middle, across);
  double outside = 0.0, beside_radius = 0.0;
  if (ring.at.empty()) {
    Slice none;
    none.s = s;
    ring = ring_beside(mesh, soft, middle);
    if (ring.at.empty()) return none;
    beside_radius = radius_of(ring, middle);
    outside = distance_to(ring, middle) / beside_radius;
    if (outside > kFarthestBeside) return none;
    none.outside = outside;
    none.beside_radius = beside_radius;
    if (outside > kMeasuredBeside) return none;
  }
  const bool is_half = ring.closed && has_twin(ring, soft, across);
  if (ring.closed && glm::dot(vector_area(ring.at, middle), across.tangent) < 0.0) reverse(ring);
  Slice slice = finish(mesh, std::move(ring), s, across);
  slice.is_half = is_half;
  slice.outside = outside;
  slice.beside_radius = beside_radius;
  return slice;
}

}  // namespace

std::size_t SpineSlices::measured() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(slice, [](const Slice& s) { return !s.ring.empty(); }));
}

SpineSlices cut_slices(const RestMesh& mesh, const SpineLine& line,
                       std::span<const float> coordinate, const glm::dvec3& left, int count,
                       double from, double to) {
  SpineSlices out;
  out.spine_length = line.length();
  out.spacing = count > 1 ? (to - from) / (count - 1) : 0.0;
  std::vector<float> level;
  for (int i = 0; i < count; ++i) level.push_back(static_cast<float>(from + out.spacing * i));

  const LevelCutter cutter(mesh, coordinate);
  std::vector<Crossings> crossings(level.size());
  for (const glm::uvec3& t : mesh.triangle) {
    if (!mesh.torso[t.x] || !mesh.torso[t.y] || !mesh.torso[t.z]) continue;
    const float s[3] = {coordinate[mesh.place[t.x]], coordinate[mesh.place[t.y]],
                        coordinate[mesh.place[t.z]]};
    const auto [low, high] = std::minmax({s[0], s[1], s[2]});
    const auto first = std::lower_bound(level.begin(), level.end(), low);
    for (auto at = first; at != level.end() && *at <= high; ++at)
      cutter.add(t, *at, crossings[static_cast<std::size_t>(at - level.begin())]);
  }
  for (std::size_t i = 0; i < level.size(); ++i) {
    const double s = level[i];
    const glm::dvec3 middle = line.point(s);
    const Across across(line.tangent(s), left);
    const std::vector<Piece> pieces = LevelCutter::pieces(std::move(crossings[i]), across, middle);
    out.slice.push_back(choose_ring(mesh, pieces, s, middle, across));
  }
  return out;
}

SlicePose pose_slices(const SpineSlices& slices, std::span<const glm::vec3> position) {
  SlicePose out;
  std::vector<glm::dvec3> ring;
  for (const Slice& slice : slices.slice) {
    if (slice.ring.empty()) {
      out.centre.push_back(kNowhere);
      out.area.push_back(kNowhere);
      out.direction.push_back(kNowhere);
      out.line.insert(out.line.end(), kLineCount, kNowhere);
      continue;
    }
    ring.clear();
    glm::dvec3 centre(0.0);
    for (std::size_t i = 0; i < slice.ring.size(); ++i) {
      const SlicePoint& p = slice.ring[i];
      const double share = p.share;
      ring.push_back(glm::dvec3(position[p.a]) * (1.0 - share) + glm::dvec3(position[p.b]) * share);
      centre += slice.weight[i] * ring.back();
    }
    const glm::dvec3 area = vector_area(ring, centre);
    glm::dvec3 direction(0.0);
    for (std::size_t i = 0; i < ring.size(); ++i) direction += slice.cosine[i] * (ring[i] - centre);
    const double squared = glm::dot(area, area);
    if (squared > 0.0) direction -= area * (glm::dot(direction, area) / squared);
    const double length = glm::length(direction);
    out.centre.push_back(centre);
    out.area.push_back(area);
    out.direction.push_back(length > 0.0 ? direction / length : kNowhere);
    for (const LinePoint& point : slice.line)
      out.line.push_back(glm::mix(ring[point.from], ring[(point.from + 1) % ring.size()],
                                  static_cast<double>(point.share)));
  }
  return out;
}

}  // namespace backbend::validate
