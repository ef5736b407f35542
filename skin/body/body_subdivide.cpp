#include "skin/body/body_subdivide.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "skin/body/index.h"

namespace backbend::skin {
void subdivide(HalfMesh& mesh, const BodyShape& shape, std::vector<std::array<int, 2>>& edge_of) {
  const int old = static_cast<int>(mesh.position.size());
  std::vector<std::array<int, 3>> sorted;  // edge, and where it is: 3 triangle + side
  sorted.reserve(mesh.triangle.size() * 3);
  for (std::size_t t = 0; t < mesh.triangle.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.triangle[t][z(k)], b = mesh.triangle[t][z((k + 1) % 3)];
      sorted.push_back({std::min(a, b), std::max(a, b), static_cast<int>(3 * t) + k});
    }
  }
  std::sort(sorted.begin(), sorted.end());
  edge_of.clear();
  std::vector<int> middle(sorted.size());
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    if (i == 0 || sorted[i][0] != sorted[i - 1][0] || sorted[i][1] != sorted[i - 1][1]) {
      edge_of.push_back({sorted[i][0], sorted[i][1]});
    }
    middle[z(sorted[i][2])] = old + static_cast<int>(edge_of.size()) - 1;
  }
  mesh.position.resize(z(old) + edge_of.size());
  tbb::parallel_for(std::size_t{0}, edge_of.size(), [&](std::size_t i) {
    const glm::dvec3 &a = mesh.position[z(edge_of[i][0])], &b = mesh.position[z(edge_of[i][1])];
    glm::dvec3 p = shape.project(0.5 * (a + b), 0.5 * glm::distance(a, b));
    if (a.x != 0.0 || b.x != 0.0) p.x = std::max(p.x, 0.1 * std::max(a.x, b.x));
    mesh.position[z(old) + i] = p;
  });
  std::vector<std::array<int, 3>> finer;
  finer.reserve(mesh.triangle.size() * 4);
  for (std::size_t t = 0; t < mesh.triangle.size(); ++t) {
    const auto [a, b, c] = mesh.triangle[t];
    const int ab = middle[3 * t], bc = middle[3 * t + 1], ca = middle[3 * t + 2];
    finer.push_back({a, ab, ca});
    finer.push_back({ab, b, bc});
    finer.push_back({ca, bc, c});
    finer.push_back({ab, bc, ca});
  }
  mesh.triangle = std::move(finer);
}

void mend(HalfMesh& mesh, const BodyShape& shape) {
  constexpr int kPasses = 12;
  std::vector<glm::dvec3> normal(mesh.position.size());
  std::vector<std::vector<int>> ring;
  for (int pass = 0; pass < kPasses; ++pass) {
    std::fill(normal.begin(), normal.end(), glm::dvec3(0.0));
    for (const auto& t : mesh.triangle) {
      const glm::dvec3 &a = mesh.position[z(t[0])], &b = mesh.position[z(t[1])],
                       &c = mesh.position[z(t[2])];
      const glm::dvec3 cross = glm::cross(b - a, c - a);
      for (const int v : t) normal[z(v)] += cross;
    }
    std::vector<bool> bad(mesh.position.size(), false);
    bool any = false;
    for (const auto& t : mesh.triangle) {
      const glm::dvec3 &a = mesh.position[z(t[0])], &b = mesh.position[z(t[1])],
                       &c = mesh.position[z(t[2])];
      const glm::dvec3 cross = glm::cross(b - a, c - a), ab = b - a, bc = c - b, ca = a - c;
      const double area = glm::length(cross);
      const double longest = std::max({glm::dot(ab, ab), glm::dot(bc, bc), glm::dot(ca, ca)});
      const glm::dvec3 around = normal[z(t[0])] + normal[z(t[1])] + normal[z(t[2])];
      // Height over length below 0.2 (an even triangle has 0.87), or leaning by 70 degrees.
      if (area > 0.2 * longest && glm::dot(cross, around) > 0.34 * area * glm::length(around))
        continue;
      any = true;
      for (const int v : t) bad[z(v)] = true;
    }
    if (!any) return;
    ring.assign(mesh.position.size(), {});
    for (const auto& t : mesh.triangle) {
      for (std::size_t k = 0; k < 3; ++k) {
        if (!bad[z(t[k])]) continue;
        ring[z(t[k])].push_back(t[(k + 1) % 3]);
        ring[z(t[k])].push_back(t[(k + 2) % 3]);
      }
    }
    for (std::size_t v = 0; v < bad.size(); ++v) {
      if (!bad[v] || mesh.position[v].x == 0.0) continue;
      glm::dvec3 middle(0.0);
      for (const int n : ring[v]) middle += mesh.position[z(n)];
      middle /= static_cast<double>(ring[v].size());
      const double reach = glm::distance(middle, mesh.position[z(ring[v].front())]);
      const glm::dvec3 p = shape.project(middle, reach);
      if (p.x > 0.0) mesh.position[v] = p;
    }
  }
}

}  // namespace backbend::skin
