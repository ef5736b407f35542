#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <tuple>
#include <utility>
#include <vector>

namespace backbend::skin {

/// Points in cells of one edge length (above 0), to find the nearest to a point.
class PointCells {
 public:
  PointCells(std::vector<glm::dvec3> points, double edge)
      : points_(std::move(points)), edge_(edge) {
    for (std::size_t p = 0; p < points_.size(); ++p)
      if (has_cell(points_[p])) cells_.push_back({key(points_[p]), p});
    std::sort(cells_.begin(), cells_.end());
  }
  std::size_t size() const { return points_.size(); }
  const glm::dvec3& point(std::size_t index) const { return points_[index]; }
  /// Calls `take` with the index of each point within `radius`, of at most one edge length.
  template <class Take>
  void each_within(const glm::dvec3& at, double radius, const Take& take) const {
    if (!has_cell(at)) return;
    each_around(at, [&](std::size_t p) {
      if (glm::distance(points_[p], at) <= radius) take(p);
    });
  }
  /// The nearest point within one edge length, or size(). The first of several as near.
  std::size_t nearest(const glm::dvec3& at) const {
    return nearest(at, [](std::size_t) { return true; });
  }
  /// The same of those points whose index `counts`.
  template <class Counts>
  std::size_t nearest(const glm::dvec3& at, const Counts& counts) const {
    std::size_t best = points_.size();
    if (!has_cell(at)) return best;
    double least = edge_;
    each_around(at, [&](std::size_t p) {
      const double distance = glm::distance(points_[p], at);
      if (distance >= least || !counts(p)) return;
      least = distance;
      best = p;
    });
    return best;
  }

 private:
  using Key = std::tuple<long, long, long>;
  using Cell = std::pair<Key, std::size_t>;
  template <class Take>
  void each_around(const glm::dvec3& at, const Take& take) const {
    const auto [x, y, z] = key(at);
    for (long dx = -1; dx <= 1; ++dx)
      for (long dy = -1; dy <= 1; ++dy) {
        // Cells are sorted by z last: three in a row are one run.
        auto cell = std::lower_bound(cells_.begin(), cells_.end(),
                                     Cell{Key{x + dx, y + dy, z - 1}, std::size_t{0}});
        for (; cell != cells_.end() && cell->first <= Key{x + dx, y + dy, z + 1}; ++cell)
          take(cell->second);
      }
  }
  /// Cells are counted in whole numbers; single precision has none of an edge out there anyway.
  bool has_cell(const glm::dvec3& p) const {
    constexpr double kMost = 1e15;
    return std::abs(p.x) < kMost * edge_ && std::abs(p.y) < kMost * edge_ &&
           std::abs(p.z) < kMost * edge_;
  }
  Key key(const glm::dvec3& p) const {
    const auto cell = [&](double x) { return static_cast<long>(std::floor(x / edge_)); };
    return {cell(p.x), cell(p.y), cell(p.z)};
  }
  std::vector<glm::dvec3> points_;
  double edge_;
  std::vector<Cell> cells_;
};

}  // namespace backbend::skin
