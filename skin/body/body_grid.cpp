#include "skin/body/body_grid.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vector_relational.hpp>
#include <unordered_map>

namespace backbend::skin {
namespace {

using Node = glm::ivec3;

constexpr int kBias = 1 << 19;  // nodes within +-524288 of the origin

std::uint64_t key(const Node& n) {
  return (static_cast<std::uint64_t>(n.x + kBias) << 40) |
         (static_cast<std::uint64_t>(n.y + kBias) << 20) | static_cast<std::uint64_t>(n.z + kBias);
}

Node corner(const Node& cube, int index) {
  return cube + Node(index & 1, (index >> 1) & 1, (index >> 2) & 1);
}

// The tetrahedra around the diagonal from corner 0 to corner 7, all of one handedness.
constexpr int kTetra[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7},
                              {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};

class Marcher {
 public:
  Marcher(const BodyShape& shape, double cell) : shape_(shape), cell_(cell) {}

  HalfMesh run(const glm::dvec3& seed) {
    visit(first_cube(seed));
    while (next_ < queue_.size()) {
      const Node cube = queue_[next_++];
      cut(cube);
      spread(cube);
    }
    return std::move(mesh_);
  }

 private:
  double value(const Node& n) {
    const auto [entry, fresh] = value_.try_emplace(key(n), 0.0);
    if (fresh) {
      double d = shape_.value(glm::dvec3(n) * cell_);
      // A node on the surface would make triangles without area.
      if (std::abs(d) < 1e-4 * cell_) d = d < 0.0 ? -1e-4 * cell_ : 1e-4 * cell_;
      entry->second = d;
    }
    return entry->second;
  }

  Node first_cube(const glm::dvec3& seed) {
    Node n = glm::ivec3(glm::floor(glm::abs(seed) / cell_ + 0.5));
    n.y = static_cast<int>(std::floor(seed.y / cell_ + 0.5));
    n.z = static_cast<int>(std::floor(seed.z / cell_ + 0.5));
    if (value(n) > 0.0) throw CharacterError("the root joint is not inside the body's solids");
    // Outwards along +z.
    const int end = static_cast<int>(std::ceil(shape_.high().z / cell_)) + 2;
    while (n.z < end && value(n + Node(0, 0, 1)) < 0.0) ++n.z;
    return n;
  }

  void visit(const Node& cube) {
    if (cube.x < 0) return;
    if (visited_.try_emplace(key(cube), true).second) queue_.push_back(cube);
  }

  // On to every neighbour whose shared face the surface crosses.
  void spread(const Node& cube) {
    for (int axis = 0; axis < 3; ++axis) {
      for (int end = 0; end < 2; ++end) {
        int inside = 0;
        for (int i = 0; i < 8; ++i) {
          if (((i >> axis) & 1) == end && value(corner(cube, i)) < 0.0) ++inside;
        }
        if (inside == 0 || inside == 4) continue;
        Node neighbour = cube;
        neighbour[axis] += end == 1 ? 1 : -1;
        visit(neighbour);
      }
    }
  }

  int edge_vertex(const Node& a, const Node& b) {
    // Corners of a tetrahedron differ by 0 or 1 in each coordinate, all the same way.
    const bool forward = a.x <= b.x && a.y <= b.y && a.z <= b.z;
    const Node &from = forward ? a : b, &to = forward ? b : a;
    const Node step = to - from;
    const std::uint64_t id =
        (key(from) << 3) | static_cast<std::uint64_t>(step.x | step.y << 1 | step.z << 2);
    const auto [entry, fresh] = vertex_.try_emplace(id, static_cast<int>(mesh_.position.size()));
    if (fresh) {
      const double va = value(from), vb = value(to);
      const double t = std::clamp(va / (va - vb), 0.02, 0.98);  // keeps triangles apart from nodes
      mesh_.position.push_back((glm::dvec3(from) + t * glm::dvec3(step)) * cell_);
    }
    return entry->second;
  }

  void cut(const Node& cube) {
    for (const auto& tetra : kTetra) {
      Node in[4], out[4];
      int in_count = 0, out_count = 0, place[4] = {};
      for (int i = 0; i < 4; ++i) {
        const Node n = corner(cube, tetra[i]);
        if (value(n) < 0.0) {
          place[i] = 1;
          in[in_count++] = n;
        } else {
          out[out_count++] = n;
        }
      }
      if (in_count == 0 || out_count == 0) continue;
      // An even permutation (lone corners first) keeps the tetrahedron's handedness.
      if (in_count == 2) {
        // in = {p, q}, out = {r, s} in tetra order; parity of the order p q r s.
        int order[4], k = 0;
        for (int i = 0; i < 4; ++i)
          if (place[i]) order[k++] = i;
        for (int i = 0; i < 4; ++i)
          if (!place[i]) order[k++] = i;
        int swaps = 0;
        for (int i = 0; i < 4; ++i)
          for (int j = i + 1; j < 4; ++j) swaps += order[i] > order[j];
        const int pr = edge_vertex(in[0], out[0]), ps = edge_vertex(in[0], out[1]);
        const int qr = edge_vertex(in[1], out[0]), qs = edge_vertex(in[1], out[1]);
        if (swaps % 2 == 0)
          quad(pr, ps, qs, qr);
        else
          quad(pr, qr, qs, ps);
      } else {
        const int lone = in_count == 1 ? 1 : 0;
        int at = 0;
        while (place[at] != lone) ++at;
        Node others[3];
        int k = 0;
        for (int i = 0; i < 4; ++i)
          if (i != at) others[k++] = corner(cube, tetra[i]);
        const Node apex = corner(cube, tetra[at]);
        int v[3];
        for (int i = 0; i < 3; ++i) v[i] = edge_vertex(apex, others[i]);
        // Taking corner `at` out of the order is an even change for even `at`.
        if ((at % 2 == 0) == (in_count == 1))
          mesh_.triangle.push_back({v[0], v[1], v[2]});
        else
          mesh_.triangle.push_back({v[0], v[2], v[1]});
      }
    }
  }

  void quad(int a, int b, int c, int d) {
    mesh_.triangle.push_back({a, b, c});
    mesh_.triangle.push_back({a, c, d});
  }

  const BodyShape& shape_;
  double cell_;
  std::unordered_map<std::uint64_t, double> value_;
  std::unordered_map<std::uint64_t, bool> visited_;
  std::unordered_map<std::uint64_t, int> vertex_;
  std::vector<Node> queue_;
  std::size_t next_ = 0;
  HalfMesh mesh_;
};

}  // namespace

HalfMesh grid_surface(const BodyShape& shape, const glm::dvec3& seed, double cell) {
  return Marcher(shape, cell).run(seed);
}

}  // namespace backbend::skin
