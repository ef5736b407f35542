#include <algorithm>
#include <glm/geometric.hpp>
#include <queue>
#include <set>

#include "tests/battery/body_variants.h"

namespace backbend::battery {
namespace {

using Index = std::size_t;

/// A triangle mesh whose edges collapse one after another.
class CollapsingMesh {
 public:
  explicit CollapsingMesh(skin::Character& body) : body_(body), around_(body.vertex_count()) {
    for (Index t = 0; t < body.triangles.size(); ++t)
      for (int k = 0; k < 3; ++k)
        around_[body.triangles[t][k]].insert(static_cast<std::uint32_t>(t));
    age_.assign(body.vertex_count(), 0);
    weights_.reserve(body.vertex_count());
    for (const skin::Influences& each : body.influences) weights_.push_back(weights_of(each));
    left_ = body.vertex_count();
    for (std::uint32_t v = 0; v < body.vertex_count(); ++v)
      for (const std::uint32_t other : ring(v))
        if (v < other) push(v, other);
  }

  void collapse_to(Index wanted) {
    while (left_ > wanted && !queue_.empty()) {
      const Edge edge = queue_.top();
      queue_.pop();
      if (edge.age_a == age_[edge.a] && edge.age_b == age_[edge.b] && can_collapse(edge))
        collapse(edge);
    }
    write_back();
  }

 private:
  struct Edge {
    double length;
    std::uint32_t a, b;
    int age_a, age_b;
    bool operator<(const Edge& other) const {
      return std::tie(length, a, b) > std::tie(other.length, other.a, other.b);
    }
  };

  glm::dvec3 at(std::uint32_t v) const { return glm::dvec3(body_.bind_position[v]); }
  std::set<std::uint32_t> ring(std::uint32_t v) const {
    std::set<std::uint32_t> out;
    for (const std::uint32_t t : around_[v])
      for (int k = 0; k < 3; ++k)
        if (body_.triangles[t][k] != v) out.insert(body_.triangles[t][k]);
    return out;
  }
  void push(std::uint32_t a, std::uint32_t b) {
    queue_.push({glm::distance(at(a), at(b)), a, b, age_[a], age_[b]});
  }

  /// The link condition of a closed surface, and no face that turns over or dies.
  bool can_collapse(const Edge& edge) const {
    const auto first = ring(edge.a), second = ring(edge.b);
    std::vector<std::uint32_t> shared;
    std::set_intersection(first.begin(), first.end(), second.begin(), second.end(),
                          std::back_inserter(shared));
    if (shared.size() != 2) return false;
    for (const std::uint32_t apex : shared)
      if (around_[apex].size() <= 3) return false;
    const glm::dvec3 middle = 0.5 * (at(edge.a) + at(edge.b));
    for (const std::uint32_t v : {edge.a, edge.b})
      for (const std::uint32_t t : around_[v]) {
        const glm::uvec3& triangle = body_.triangles[t];
        glm::dvec3 corner[3], moved[3];
        int hits = 0;
        for (int k = 0; k < 3; ++k) {
          corner[k] = moved[k] = at(triangle[k]);
          if (triangle[k] == edge.a || triangle[k] == edge.b) {
            moved[k] = middle;
            ++hits;
          }
        }
        if (hits == 2) continue;
        const glm::dvec3 before = glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
        const glm::dvec3 after = glm::cross(moved[1] - moved[0], moved[2] - moved[0]);
        // A third of a right angle is a smooth surface's own turn at this size.
        if (glm::dot(before, after) < 0.85 * glm::length(before) * glm::length(after) ||
            glm::length(after) < 1e-3 * edge.length * edge.length)
          return false;
      }
    return true;
  }

  void collapse(const Edge& edge) {
    body_.bind_position[edge.a] = glm::vec3(0.5 * (at(edge.a) + at(edge.b)));
    for (auto& [joint, weight] : weights_[edge.a]) weight *= 0.5;
    for (const auto& [joint, weight] : weights_[edge.b]) weights_[edge.a][joint] += 0.5 * weight;
    const std::set<std::uint32_t> touched = around_[edge.b];
    for (const std::uint32_t t : touched) {
      glm::uvec3& triangle = body_.triangles[t];
      const bool dies = triangle.x == edge.a || triangle.y == edge.a || triangle.z == edge.a;
      if (dies) {
        for (int k = 0; k < 3; ++k) around_[triangle[k]].erase(t);
        triangle = glm::uvec3(0);
        continue;
      }
      for (int k = 0; k < 3; ++k)
        if (triangle[k] == edge.b) triangle[k] = edge.a;
      around_[edge.a].insert(t);
    }
    around_[edge.b].clear();
    ++age_[edge.a];
    ++age_[edge.b];
    --left_;
    for (const std::uint32_t other : ring(edge.a)) push(edge.a, other);
  }

  void write_back() {
    std::vector<std::uint32_t> number(body_.vertex_count(), 0);
    std::uint32_t count = 0;
    std::vector<glm::vec3> position;
    std::vector<skin::Influences> influences;
    for (Index v = 0; v < body_.vertex_count(); ++v) {
      if (around_[v].empty()) continue;
      number[v] = count++;
      position.push_back(body_.bind_position[v]);
      influences.push_back(influences_of(weights_[v], skin::kMaxInfluences));
    }
    std::vector<glm::uvec3> triangles;
    for (const glm::uvec3& t : body_.triangles)
      if (t.x != t.y) triangles.emplace_back(number[t.x], number[t.y], number[t.z]);
    body_.bind_position = std::move(position);
    body_.influences = std::move(influences);
    body_.triangles = std::move(triangles);
  }

  skin::Character& body_;
  std::vector<std::set<std::uint32_t>> around_;  // triangles of each vertex
  std::vector<int> age_;                         // an edge in the queue is stale once its ends aged
  std::vector<JointWeights> weights_;
  std::priority_queue<Edge> queue_;
  Index left_ = 0;
};

}  // namespace

void decimate(skin::Character& body, std::size_t wanted) {
  CollapsingMesh(body).collapse_to(wanted);
  renew_surface(body);
}

}  // namespace backbend::battery
