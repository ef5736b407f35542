#include "validate/why/vertex_match.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <unordered_map>

#include "skin/character/point_cells.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;
constexpr std::int64_t kNone = -1;

skin::PointCells cells_of(const std::vector<glm::vec3>& points, double edge) {
  return {std::vector<glm::dvec3>(points.begin(), points.end()), edge};
}

/// The point within a distance; none where there are several.
std::int64_t only_within(const skin::PointCells& points, const glm::vec3& at, double distance) {
  std::int64_t found = kNone;
  Index count = 0;
  points.each_within(glm::dvec3(at), distance, [&](Index i) {
    found = static_cast<std::int64_t>(i);
    ++count;
  });
  return count == 1 ? found : kNone;
}

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
  const skin::PointCells old_points = cells_of(before.position, exact),
                         new_points = cells_of(after.position, exact);
  for (Index v = 0; v < after.position.size(); ++v) {
    const std::int64_t u = only_within(old_points, after.position[v], exact);
    if (u != kNone && only_within(new_points, before.position[static_cast<Index>(u)], exact) ==
                          static_cast<std::int64_t>(v))
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
  std::vector<std::uint32_t> waiting, paired;
  for (Index t = 0; t < after.triangles.size(); ++t) {
    for (int i = 0; i < 3; ++i)
      triangles_at[after.triangles[t][i]].push_back(static_cast<std::uint32_t>(t));
    waiting.push_back(static_cast<std::uint32_t>(t));
  }
  while (!waiting.empty()) {
    const glm::uvec3 t = after.triangles[waiting.back()];
    waiting.pop_back();
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t corner = t[(i + 2) % 3];
      const std::int64_t a = pairs.before_of(t[i]), b = pairs.before_of(t[(i + 1) % 3]);
      if (a == kNone || b == kNone || pairs.before_of(corner) != kNone) continue;
      const std::int64_t c = old_edges.third(a, b);
      if (c == kNone || !pairs.add(c, corner)) continue;
      paired.push_back(corner);
      waiting.insert(waiting.end(), triangles_at[corner].begin(), triangles_at[corner].end());
    }
  }
  return paired;
}

using Triangle = std::array<std::uint32_t, 3>;

/// Which corner a triangle is begun at so that the same one always begins at the same.
int first_corner(const Triangle& t) {
  return t[0] <= t[1] && t[0] <= t[2] ? 0 : t[1] <= t[2] ? 1 : 2;
}
Triangle begun_at(const Triangle& t, int first) {
  const auto f = static_cast<Index>(first);
  return {t[f], t[(f + 1) % 3], t[(f + 2) % 3]};
}
Triangle ordered(const Triangle& t) { return begun_at(t, first_corner(t)); }

/// A triangle of `after` in the numbers of `before`; nothing where a corner has no partner.
bool in_before(const glm::uvec3& t, const Pairs& pairs, Triangle& out) {
  for (int i = 0; i < 3; ++i) {
    const std::int64_t u = pairs.before_of(t[i]);
    if (u == kNone) return false;
    out[static_cast<Index>(i)] = static_cast<std::uint32_t>(u);
  }
  return true;
}

bool is_same_mesh(const RestSurface& before, const RestSurface& after, const Pairs& pairs) {
  if (before.triangles.size() != after.triangles.size() || !pairs.is_complete()) return false;
  std::multiset<Triangle> old_ones, new_ones;
  for (const glm::uvec3& t : before.triangles) old_ones.insert(ordered({t[0], t[1], t[2]}));
  for (const glm::uvec3& t : after.triangles) {
    Triangle old{};
    in_before(t, pairs, old);
    new_ones.insert(ordered(old));
  }
  return old_ones == new_ones;
}

/// A surface with one vertex a place.
struct Welded {
  Welded(const RestSurface& surface, double exact) {
    const skin::PointCells points = cells_of(surface.position, exact);
    std::vector<bool> is_first(points.size(), false);
    for (Index v = 0; v < points.size(); ++v) {
      const Index first =
          points.nearest(points.point(v), [&](Index earlier) { return is_first[earlier]; });
      is_first[v] = first == points.size();
      if (is_first[v]) position.push_back(surface.position[v]);
      place_of.push_back(is_first[v] ? static_cast<std::uint32_t>(position.size() - 1)
                                     : place_of[first]);
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
  std::set<Triangle> known;
  for (const glm::uvec3& t : before.triangles) known.insert(ordered({t[0], t[1], t[2]}));
  std::vector<bool> wrong(after.position.size(), false);
  for (const glm::uvec3& t : after.triangles) {
    Triangle old{};
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
  std::map<Triangle, Triangle> vertices_of;  // of a triangle of places in `to`
  for (Index t = 0; t < to.triangles.size(); ++t) {
    const glm::uvec3& p = to_places.triangles[t];
    const Triangle places{p[0], p[1], p[2]};
    const int first = first_corner(places);
    const glm::uvec3& v = to.triangles[t];
    vertices_of.emplace(begun_at(places, first), begun_at({v[0], v[1], v[2]}, first));
  }
  std::vector<bool> told(out.size(), false);
  for (Index t = 0; t < from.triangles.size(); ++t) {
    Triangle places{};
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
  const skin::PointCells points = cells_of(to.position, reach);
  for (Index v = 0; v < partner.size(); ++v) {
    if (partner[v] != kNone) continue;
    const Index nearest = points.nearest(glm::dvec3(from.position[v]));
    if (nearest != points.size()) partner[v] = static_cast<std::int64_t>(nearest);
  }
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
