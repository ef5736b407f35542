#include "skin/body/body_remesh.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "skin/body/body_connectivity.h"
#include "skin/body/index.h"

namespace backbend::skin {
namespace {

class Remesher {
 public:
  Remesher(HalfMesh& mesh, const BodyShape& shape, const EdgeSizes& sizes)
      : mesh_(mesh), shape_(shape), sizes_(sizes), net_(mesh) {}

  void thin() {
    if (want_.size() != mesh_.position.size()) measure();
    collapse_short();
    // What is left is where it was.
    const std::vector<int> old = net_.compact();
    for (std::size_t v = 0; v < old.size(); ++v) want_[v] = want_[z(old[v])];
    want_.resize(old.size());
  }

  void round(bool last) {
    measure();
    if (!last) {
      split_long();
      collapse_short();
    }
    for (int i = 0; i < (last ? 4 : 1); ++i) {
      flip();
      relax();
    }
    net_.compact();
  }

 private:
  void measure() {
    want_.resize(mesh_.position.size());
    tbb::parallel_for(std::size_t{0}, want_.size(),
                      [&](std::size_t i) { want_[i] = sizes_.at(mesh_.position[i]); });
  }

  const glm::dvec3& at(int v) const { return mesh_.position[z(v)]; }
  double length(int a, int b) const { return glm::distance(at(a), at(b)); }
  double wanted(int a, int b) const { return 0.5 * (want_[z(a)] + want_[z(b)]); }

  glm::dvec3 area_normal(int a, int b, int c) const {
    return glm::cross(at(b) - at(a), at(c) - at(a));
  }

  void split_long() {
    const int count = static_cast<int>(mesh_.position.size());
    for (int a = 0; a < count; ++a) {
      net_.neighbours(a, ring_);
      for (const int b : ring_) {
        if (b < a || b >= count || length(a, b) <= 4.0 / 3.0 * wanted(a, b)) continue;
        const double size = wanted(a, b);
        const glm::dvec3 middle = 0.5 * (at(a) + at(b));
        const int fresh = net_.split(a, b, shape_.project(middle, 0.5 * size));
        keep_off_plane(fresh, a, b);
        want_.push_back(size);
      }
    }
  }

  // A vertex inside the half must not come to lie on its border.
  void keep_off_plane(int v, int a, int b) {
    glm::dvec3& p = mesh_.position[z(v)];
    if (mesh_.on_plane(a) && mesh_.on_plane(b)) return;
    p.x = std::max(p.x, 0.1 * std::max(at(a).x, at(b).x));
  }

  void collapse_short() {
    const int count = static_cast<int>(mesh_.position.size());
    for (int a = 0; a < count; ++a) {
      bool gone = false;
      net_.neighbours(a, ring_);
      for (const int b : ring_) {
        if (gone) break;
        if (length(a, b) >= 0.8 * wanted(a, b)) continue;
        gone = try_collapse(a, b);
      }
    }
  }

  /// Removes `a`, whose neighbours are in ring_, by moving it to `b`, where that is sound.
  bool try_collapse(int a, int b) {
    for (const int n : ring_) {
      if (n != b && length(b, n) > 4.0 / 3.0 * wanted(b, n)) return false;
    }
    if (!net_.may_collapse(a, b, ring_)) return false;
    for (const int f : net_.faces(a)) {
      std::array<int, 3> t = mesh_.triangle[z(f)];
      if (t[0] == b || t[1] == b || t[2] == b) continue;
      const glm::dvec3 before = area_normal(t[0], t[1], t[2]);
      for (int& v : t) v = v == a ? b : v;
      const glm::dvec3 after = area_normal(t[0], t[1], t[2]);
      const double longest = std::max({length(t[0], t[1]), length(t[1], t[2]), length(t[2], t[0])});
      const double area = glm::length(after);
      // Neither turned over nor a sliver; a triangle that is one already may turn.
      if (area < 0.1 * longest * longest) return false;
      if (glm::dot(before, after) < 0.3 * glm::length(before) * area) return false;
    }
    net_.collapse(a, b);
    return true;
  }

  void flip() {
    const int count = static_cast<int>(mesh_.position.size());
    for (int a = 0; a < count; ++a) {
      net_.neighbours(a, ring_);
      for (const int b : ring_) {
        if (b < a) continue;
        int c = -1, d = -1;
        if (!net_.may_flip(a, b, &c, &d)) continue;
        const auto excess = [&](int v, int change) {
          const int ideal = mesh_.on_plane(v) ? 4 : 6;
          const int e = net_.valence(v) + change - ideal;
          return e * e;
        };
        const int before = excess(a, 0) + excess(b, 0) + excess(c, 0) + excess(d, 0);
        const int after = excess(a, -1) + excess(b, -1) + excess(c, 1) + excess(d, 1);
        if (after >= before) continue;
        // The two faces become (c, d, b) and (d, c, a) when (a, b, c) and (b, a, d) were them.
        const glm::dvec3 old_normal = area_normal(a, b, c) + area_normal(b, a, d);
        const glm::dvec3 n1 = area_normal(c, d, b), n2 = area_normal(d, c, a);
        const double floor = 0.1 * length(c, d) * length(c, d);
        if (glm::length(n1) < floor || glm::length(n2) < floor) continue;
        if (glm::dot(n1, old_normal) < 0.5 * glm::length(n1) * glm::length(old_normal)) continue;
        if (glm::dot(n2, old_normal) < 0.5 * glm::length(n2) * glm::length(old_normal)) continue;
        net_.flip(a, b, c, d);
      }
    }
  }

  void relax() {
    measure();
    const std::vector<glm::dvec3> old = mesh_.position;
    tbb::parallel_for(std::size_t{0}, old.size(), [&](std::size_t i) {
      const int v = static_cast<int>(i);
      if (net_.faces(v).empty()) return;
      glm::dvec3 sum(0.0), normal(0.0);
      double total = 0.0;
      const bool border = old[i].x == 0.0;
      for (const int f : net_.faces(v)) {
        const auto& t = mesh_.triangle[z(f)];
        const glm::dvec3 &p = old[z(t[0])], &q = old[z(t[1])], &r = old[z(t[2])];
        const glm::dvec3 cross = glm::cross(q - p, r - p);
        const double size = want_[z(t[0])] + want_[z(t[1])] + want_[z(t[2])];
        const double weight = glm::length(cross) / (size * size);
        normal += cross;
        glm::dvec3 middle = (p + q + r) / 3.0;
        if (border) middle.x = 0.0;  // what its mirror image adds cancels the rest
        sum += weight * middle;
        total += weight;
      }
      if (border) normal.x = 0.0;
      if (total <= 0.0 || glm::length(normal) <= 0.0) return;
      normal = glm::normalize(normal);
      glm::dvec3 move = sum / total - old[i];
      move -= normal * glm::dot(move, normal);
      glm::dvec3 p = shape_.project(old[i] + 0.7 * move, want_[i]);
      if (border) {
        p.x = 0.0;
      } else if (p.x < 0.2 * want_[i] && p.x < old[i].x) {
        p.x = old[i].x;  // too near the border to slide towards it
      }
      mesh_.position[i] = p;
    });
  }

  HalfMesh& mesh_;
  const BodyShape& shape_;
  const EdgeSizes& sizes_;
  Connectivity net_;
  std::vector<double> want_;
  std::vector<int> ring_;  // neighbours of the vertex at hand
};

}  // namespace

void remesh(HalfMesh& mesh, const BodyShape& shape, const EdgeSizes& sizes, int rounds,
            const std::function<void()>& poll) {
  Remesher remesher(mesh, shape, sizes);
  // A grid's mesh is much too fine: thinned out first, or the rounds would polish what goes anyway.
  std::size_t before = 0;
  do {
    poll();
    before = mesh.position.size();
    remesher.thin();
  } while (mesh.position.size() < before * 4 / 5);
  for (int i = 0; i < rounds; ++i) {
    poll();
    remesher.round(i + 1 == rounds);
  }
}

}  // namespace backbend::skin
