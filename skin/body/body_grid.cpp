#include "skin/body/body_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/vector_relational.hpp>
#include <memory>
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

/// Nodes of 4 x 4 x 4, with what is known of each and of the cube that starts there.
struct Block {
  static constexpr int kNodes = 64, kSteps = 8;
  std::array<double, kNodes> value;
  std::array<bool, kNodes> visited{};
  std::array<int, kNodes * kSteps> vertex;  // on the edge to the node one step on; -1: none yet

  Block() {
    value.fill(NAN);  // not asked for yet
    vertex.fill(-1);
  }
};

struct Site {
  Block* block = nullptr;
  std::size_t node = 0;

  double& value() const { return block->value[node]; }
  bool& visited() const { return block->visited[node]; }
  int& vertex(int step) const {
    return block->vertex[node * Block::kSteps + static_cast<std::size_t>(step)];
  }
};

class Marcher {
 public:
  Marcher(const BodyShape& shape, double cell) : shape_(shape), cell_(cell) {}

  HalfMesh run(const glm::dvec3& seed) {
    visit(first_cube(seed));
    while (next_ < queue_.size()) {
      const Node cube = queue_[next_++];
      load(cube);
      cut(cube);
      spread(cube);
    }
    return std::move(mesh_);
  }

 private:
  Site site(const Node& n) {
    const Node block = n >> 2;
    if (last_ == nullptr || block != last_block_) {
      std::unique_ptr<Block>& entry = block_[key(block)];
      if (!entry) entry = std::make_unique<Block>();
      last_ = entry.get();
      last_block_ = block;
    }
    const Node in = n & 3;
    return {last_, static_cast<std::size_t>(in.x | in.y << 2 | in.z << 4)};
  }

  double off_surface(double d) const {
    // A node on the surface would make triangles without area.
    if (std::abs(d) >= 1e-4 * cell_) return d;
    return d < 0.0 ? -1e-4 * cell_ : 1e-4 * cell_;
  }

  double value(const Node& n) { return off_surface(shape_.value(glm::dvec3(n) * cell_)); }

  /// The corners of a cube, with their values.
  void load(const Node& cube) {
    int fresh[8], count = 0;
    for (int i = 0; i < 8; ++i) {
      site_[i] = site(corner(cube, i));
      if (std::isnan(site_[i].value())) fresh[count++] = i;
    }
    for (int first = 0; first < count; first += Lanes::kCount) {
      glm::dvec3 p[Lanes::kCount];
      for (int k = 0; k < Lanes::kCount; ++k) {
        p[k] = glm::dvec3(corner(cube, fresh[std::min(first + k, count - 1)])) * cell_;
      }
      const Lanes d = shape_.values(LaneVector({p[0].x, p[1].x, p[2].x, p[3].x},
                                               {p[0].y, p[1].y, p[2].y, p[3].y},
                                               {p[0].z, p[1].z, p[2].z, p[3].z}));
      for (int k = 0; k < Lanes::kCount && first + k < count; ++k) {
        site_[fresh[first + k]].value() = off_surface(d[k]);
      }
    }
    for (int i = 0; i < 8; ++i) value_[i] = site_[i].value();
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
    const Site at = site(cube);
    if (at.visited()) return;
    at.visited() = true;
    queue_.push_back(cube);
  }

  // On to every neighbour whose shared face the surface crosses.
  void spread(const Node& cube) {
    for (int axis = 0; axis < 3; ++axis) {
      for (int end = 0; end < 2; ++end) {
        int inside = 0;
        for (int i = 0; i < 8; ++i) {
          if (((i >> axis) & 1) == end && value_[i] < 0.0) ++inside;
        }
        if (inside == 0 || inside == 4) continue;
        Node neighbour = cube;
        neighbour[axis] += end == 1 ? 1 : -1;
        visit(neighbour);
      }
    }
  }

  /// The vertex on the edge between two corners of the cube at hand.
  int edge_vertex(const Node& cube, int a, int b) {
    // Corners of a tetrahedron differ by 0 or 1 in each coordinate, all the same way.
    const int from = std::min(a, b), to = std::max(a, b), step = to - from;
    int& vertex = site_[from].vertex(step);
    if (vertex < 0) {
      vertex = static_cast<int>(mesh_.position.size());
      const double va = value_[from], vb = value_[to];
      const double t = std::clamp(va / (va - vb), 0.02, 0.98);  // keeps triangles apart from nodes
      mesh_.position.push_back(
          (glm::dvec3(corner(cube, from)) + t * glm::dvec3(corner(Node(0), step))) * cell_);
    }
    return vertex;
  }

  void cut(const Node& cube) {
    int inside = 0;
    for (const double v : value_) inside += v < 0.0;
    if (inside == 0 || inside == 8) return;
    for (const auto& tetra : kTetra) {
      int in[4], out[4];
      int in_count = 0, out_count = 0, place[4] = {};
      for (int i = 0; i < 4; ++i) {
        if (value_[tetra[i]] < 0.0) {
          place[i] = 1;
          in[in_count++] = tetra[i];
        } else {
          out[out_count++] = tetra[i];
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
        const int pr = edge_vertex(cube, in[0], out[0]), ps = edge_vertex(cube, in[0], out[1]);
        const int qr = edge_vertex(cube, in[1], out[0]), qs = edge_vertex(cube, in[1], out[1]);
        if (swaps % 2 == 0)
          quad(pr, ps, qs, qr);
        else
          quad(pr, qr, qs, ps);
      } else {
        const int lone = in_count == 1 ? 1 : 0;
        int at = 0;
        while (place[at] != lone) ++at;
        int v[3], k = 0;
        for (int i = 0; i < 4; ++i)
          if (i != at) v[k++] = edge_vertex(cube, tetra[at], tetra[i]);
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
  std::unordered_map<std::uint64_t, std::unique_ptr<Block>> block_;
  Block* last_ = nullptr;  // the block asked for last, and which it is
  Node last_block_{0};
  Site site_[8];  // corners of the cube at hand
  double value_[8] = {};
  std::vector<Node> queue_;
  std::size_t next_ = 0;
  HalfMesh mesh_;
};

}  // namespace

HalfMesh grid_surface(const BodyShape& shape, const glm::dvec3& seed, double cell) {
  return Marcher(shape, cell).run(seed);
}

}  // namespace backbend::skin
