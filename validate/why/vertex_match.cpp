#include "validate/why/vertex_match.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <set>
#include <unordered_map>

namespace backbend::validate {
namespace {

using Index = std::size_t;
constexpr std::int64_t kNone = -1;

/// Points by cells as large as a distance within which they are looked for.
class PointGrid {
 public:
  explicit PointGrid(double reach) : reach_(reach) {}
  PointGrid(const std::vector<glm::vec3>& points, double reach) : reach_(reach) {
    for (const glm::vec3& p : points) add(p);
  }
  void add(const glm::vec3& p) {
    cells_[key(cell(p))].push_back(static_cast<std::uint32_t>(points_.size()));
    points_.push_back(p);
  }
  Index size() const { return points_.size(); }

  /// The nearest within the distance, of equal ones the first.
  std::int64_t nearest(const glm::vec3& p) const {
    double best = std::numeric_limits<double>::infinity();
    std::int64_t found = kNone;
    each_within(p, [&](std::uint32_t i, double square) {
      if (square < best || (square == best && i < found)) {
        best = square;
        found = i;
      }
    });
    return found;
  }
  /// The one within the distance; none where there are several.
  std::int64_t only(const glm::vec3& p) const {
    std::int64_t found = kNone;
    Index count = 0;
    each_within(p, [&](std::uint32_t i, double) {
      found = i;
      ++count;
    });
    return count == 1 ? found : kNone;
  }

 private:
  using Cell = std::array<std::int64_t, 3>;

  template <class Visit>
  void each_within(const glm::vec3& p, const Visit& visit) const {
    const Cell c = cell(p);
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z) {
          const Cell around{c[0] + x, c[1] + y, c[2] + z};
          const auto near = cells_.find(key(around));
          if (near == cells_.end()) continue;
          for (const std::uint32_t i : near->second) {
            // Cells that share a key are listed together: a point counts in its own cell only.
            if (cell(points_[i]) != around) continue;
            const glm::dvec3 d = glm::dvec3(points_[i]) - glm::dvec3(p);
            if (const double square = glm::dot(d, d); square <= reach_ * reach_) visit(i, square);
          }
        }
  }
  Cell cell(const glm::vec3& p) const {
    return {static_cast<std::int64_t>(std::floor(p.x / reach_)),
            static_cast<std::int64_t>(std::floor(p.y / reach_)),
            static_cast<std::int64_t>(std::floor(p.z / reach_))};
  }
  static std::uint64_t key(const Cell& c) {
    std::uint64_t h = 0;
    for (const std::int64_t v : c) h = (h ^ static_cast<std::uint64_t>(v)) * 0x9e3779b97f4a7c15ull;
    return h;
  }

  double reach_;
  std::vector<glm::vec3> points_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
};

/// Pairs of vertices, each in one pair at most.
class Pairs {
 public:
  Pairs(Index before, Index after) : before_of_(after, kNone), after_of_(before, kNone) {}

  bool add(std::int64_t before, std::int64_t after) {
    std::int64_t& b = before_of_[static_cast<Index>(after)];
    std::int64_t& a = after_of_[static_cast<Index>(before)];
    if (a != kNone || b != kNone) return false;
    b = before;
    a = after;
    return true;
  }
  void drop(std::int64_t after) {
    std::int64_t& b = before_of_[static_cast<Index>(after)];
    after_of_[static_cast<Index>(b)] = kNone;
    b = kNone;
  }
  std::int64_t before_of(Index after) const { return before_of_[after]; }
  std::int64_t after_of(Index before) const { return after_of_[before]; }
  bool is_complete() const {
    return std::ranges::find(before_of_, kNone) == before_of_.end() &&
           std::ranges::find(after_of_, kNone) == after_of_.end();
  }

 private:
  std::vector<std::int64_t> before_of_, after_of_;
};

void pair_by_place(const RestSurface& before, const RestSurface& after, double exact,
                   Pairs& pairs) {
  const PointGrid old_points(before.position, exact), new_points(after.position, exact);
  for (Index v = 0; v < after.position.size(); ++v) {
    const std::int64_t u = old_points.only(after.position[v]);
    if (u != kNone &&
        new_points.only(before.position[static_cast<Index>(u)]) == static_cast<std::int64_t>(v))
      pairs.add(u, static_cast<std::int64_t>(v));
  }
}

/// The third corner of the triangle at each directed edge; kNone where several have it.
class Edges {
 public:
  explicit Edges(const std::vector<glm::uvec3>& triangles) {
    for (const glm::uvec3& t : triangles)
      for (int i = 0; i < 3; ++i) {
        const auto [place, is_new] =
            third_.emplace(key(t[i], t[(i + 1) % 3]), std::int64_t{t[(i + 2) % 3]});
        if (!is_new) place->second = kNone;
      }
  }
  std::int64_t third(std::int64_t from, std::int64_t to) const {
    const auto found = third_.find(key(from, to));
    return found == third_.end() ? kNone : found->second;
  }

 private:
  static std::uint64_t key(std::int64_t from, std::int64_t to) {
    return static_cast<std::uint64_t>(from) << 32 | static_cast<std::uint64_t>(to);
  }
  std::unordered_map<std::uint64_t, std::int64_t> third_;
};

/// Returns the vertices of `after` that were given a partner.
std::vector<std::uint32_t> pair_by_triangles(const RestSurface& before, const RestSurface& after,
                                             Pairs& pairs) {
  const Edges old_edges(before.triangles);
  std::vector<std::vector<std::uint32_t>> triangles_at(after.position.size());
  std::vector<std::uint32_t> todo, paired;
  for (Index t = 0; t < after.triangles.size(); ++t) {
    for (int i = 0; i < 3; ++i)
      triangles_at[after.triangles[t][i]].push_back(static_cast<std::uint32_t>(t));
    todo.push_back(static_cast<std::uint32_t>(t));
  }
  while (!todo.empty()) {
    const glm::uvec3 t = after.triangles[todo.back()];
    todo.pop_back();
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t corner = t[(i + 2) % 3];
      const std::int64_t a = pairs.before_of(t[i]), b = pairs.before_of(t[(i + 1) % 3]);
      if (a == kNone || b == kNone || pairs.before_of(corner) != kNone) continue;
      const std::int64_t c = old_edges.third(a, b);
      if (c == kNone || !pairs.add(c, corner)) continue;
      paired.push_back(corner);
      todo.insert(todo.end(), triangles_at[corner].begin(), triangles_at[corner].end());
    }
  }
  return paired;
}

using Corners = std::array<std::uint32_t, 3>;

/// Which corner a triangle is begun at so that the same one always begins at the same.
int first_corner(const Corners& t) {
  return t[0] <= t[1] && t[0] <= t[2] ? 0 : t[1] <= t[2] ? 1 : 2;
}
Corners begun_at(const Corners& t, int first) {
  const auto f = static_cast<Index>(first);
  return {t[f], t[(f + 1) % 3], t[(f + 2) % 3]};
}
Corners ordered(const Corners& t) { return begun_at(t, first_corner(t)); }

/// A triangle of `after` in the numbers of `before`; nothing where a corner has no partner.
bool in_before(const glm::uvec3& t, const Pairs& pairs, Corners& out) {
  for (int i = 0; i < 3; ++i) {
    const std::int64_t u = pairs.before_of(t[i]);
    if (u == kNone) return false;
    out[static_cast<Index>(i)] = static_cast<std::uint32_t>(u);
  }
  return true;
}

bool is_same_mesh(const RestSurface& before, const RestSurface& after, const Pairs& pairs) {
  if (before.triangles.size() != after.triangles.size() || !pairs.is_complete()) return false;
  std::multiset<Corners> old_ones, new_ones;
  for (const glm::uvec3& t : before.triangles) old_ones.insert(ordered({t[0], t[1], t[2]}));
  for (const glm::uvec3& t : after.triangles) {
    Corners old{};
    in_before(t, pairs, old);
    new_ones.insert(ordered(old));
  }
  return old_ones == new_ones;
}

/// A surface with one vertex a place.
struct Welded {
  Welded(const RestSurface& surface, double exact) {
    PointGrid places(exact);
    for (const glm::vec3& p : surface.position) {
      std::int64_t place = places.nearest(p);
      if (place == kNone) {
        place = static_cast<std::int64_t>(places.size());
        places.add(p);
        position.push_back(p);
      }
      place_of.push_back(static_cast<std::uint32_t>(place));
    }
    for (const glm::uvec3& t : surface.triangles)
      triangles.emplace_back(place_of[t[0]], place_of[t[1]], place_of[t[2]]);
    for (Index v = place_of.size(); v-- > 0;) first_at[place_of[v]] = static_cast<std::uint32_t>(v);
  }
  RestSurface surface() const { return {position, triangles}; }

  std::vector<glm::vec3> position;
  std::vector<glm::uvec3> triangles;                          // in the order of the surface's
  std::vector<std::uint32_t> place_of;                        // of each vertex
  std::unordered_map<std::uint32_t, std::uint32_t> first_at;  // the first vertex at each place
};

/// Where an edge's third corner is another in the two (a diagonal that runs the other way), what
/// the triangles told is wrong: pairs of which a triangle is none of the earlier ones.
void drop_contradicted(const Welded& before, const Welded& after,
                       const std::vector<std::uint32_t>& by_triangles, Pairs& pairs) {
  std::set<Corners> known;
  for (const glm::uvec3& t : before.triangles) known.insert(ordered({t[0], t[1], t[2]}));
  std::vector<bool> wrong(after.position.size(), false);
  for (const glm::uvec3& t : after.triangles) {
    Corners old{};
    if (!in_before(t, pairs, old) || !known.contains(ordered(old)))
      for (int i = 0; i < 3; ++i) wrong[t[i]] = true;
  }
  for (const std::uint32_t v : by_triangles)
    if (wrong[v]) pairs.drop(v);
}

/// Partners of `from`'s vertices in `to` where their places are paired: at the same corner of the
/// same triangle, else the first at the place.
std::vector<std::int64_t> partners_by_place(const RestSurface& from, const Welded& from_places,
                                            const RestSurface& to, const Welded& to_places,
                                            const auto& place_in_to) {
  std::vector<std::int64_t> out(from.position.size(), kNone);
  for (Index v = 0; v < out.size(); ++v)
    if (const std::int64_t place = place_in_to(from_places.place_of[v]); place != kNone)
      out[v] = to_places.first_at.at(static_cast<std::uint32_t>(place));
  std::map<Corners, Corners> vertices_of;  // of a triangle of places in `to`
  for (Index t = 0; t < to.triangles.size(); ++t) {
    const glm::uvec3& p = to_places.triangles[t];
    const Corners places{p[0], p[1], p[2]};
    const int first = first_corner(places);
    const glm::uvec3& v = to.triangles[t];
    vertices_of.emplace(begun_at(places, first), begun_at({v[0], v[1], v[2]}, first));
  }
  std::vector<bool> told(out.size(), false);
  for (Index t = 0; t < from.triangles.size(); ++t) {
    Corners places{};
    bool paired = true;
    for (int i = 0; i < 3; ++i) {
      const std::int64_t place = place_in_to(from_places.triangles[t][i]);
      paired = paired && place != kNone;
      places[static_cast<Index>(i)] = static_cast<std::uint32_t>(std::max(place, std::int64_t{0}));
    }
    if (!paired) continue;
    const int first = first_corner(places);
    const auto found = vertices_of.find(begun_at(places, first));
    if (found == vertices_of.end()) continue;
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t v = from.triangles[t][(first + i) % 3];
      if (told[v]) continue;
      told[v] = true;
      out[v] = found->second[static_cast<Index>(i)];
    }
  }
  return out;
}

/// Those without a partner get the closest rest point within reach.
void add_nearest(const RestSurface& from, const RestSurface& to, double reach,
                 std::vector<std::int64_t>& partner) {
  const PointGrid grid(to.position, reach);
  for (Index v = 0; v < partner.size(); ++v)
    if (partner[v] == kNone) partner[v] = grid.nearest(from.position[v]);
}

double share_with(const std::vector<std::int64_t>& partner) {
  if (partner.empty()) return 0.0;
  const auto without = static_cast<Index>(std::ranges::count(partner, kNone));
  return static_cast<double>(partner.size() - without) / static_cast<double>(partner.size());
}

/// Every vertex needs weights in a mixture: those without a partner take the nearest's, however
/// far.
std::vector<std::uint32_t> completed(const RestSurface& from, const RestSurface& to, double reach,
                                     std::vector<std::int64_t> partner) {
  while (std::ranges::find(partner, kNone) != partner.end())
    add_nearest(from, to, reach *= 2.0, partner);
  std::vector<std::uint32_t> out;
  for (const std::int64_t each : partner) out.push_back(static_cast<std::uint32_t>(each));
  return out;
}

}  // namespace

VertexMatch match_vertices(const RestSurface& before, const RestSurface& after,
                           const MatchReach& reach) {
  VertexMatch out;
  Pairs pairs(before.position.size(), after.position.size());
  pair_by_place(before, after, reach.exact, pairs);
  pair_by_triangles(before, after, pairs);
  std::vector<std::int64_t> of_after(after.position.size()), of_before(before.position.size());
  out.same_mesh = is_same_mesh(before, after, pairs);
  if (out.same_mesh) {
    for (Index v = 0; v < of_after.size(); ++v) of_after[v] = pairs.before_of(v);
    for (Index u = 0; u < of_before.size(); ++u) of_before[u] = pairs.after_of(u);
  } else {
    const Welded old_places(before, reach.exact), new_places(after, reach.exact);
    Pairs places(old_places.position.size(), new_places.position.size());
    pair_by_place(old_places.surface(), new_places.surface(), reach.exact, places);
    const std::vector<std::uint32_t> by_triangles =
        pair_by_triangles(old_places.surface(), new_places.surface(), places);
    drop_contradicted(old_places, new_places, by_triangles, places);
    of_after = partners_by_place(after, new_places, before, old_places,
                                 [&](Index place) { return places.before_of(place); });
    of_before = partners_by_place(before, old_places, after, new_places,
                                  [&](Index place) { return places.after_of(place); });
    add_nearest(after, before, reach.near, of_after);
    add_nearest(before, after, reach.near, of_before);
  }
  out.coverage = std::min(share_with(of_after), share_with(of_before));
  // The search for partners of a body that has none would take long.
  if (!(out.coverage >= reach.least_coverage)) return out;
  out.before_of_after = completed(after, before, reach.near, std::move(of_after));
  out.after_of_before = completed(before, after, reach.near, std::move(of_before));
  return out;
}

}  // namespace backbend::validate
