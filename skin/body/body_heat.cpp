#include "skin/body/body_heat.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>

#include "skin/body/index.h"

namespace backbend::skin {
namespace {

Lanes dot(const std::vector<Lanes>& a, const std::vector<Lanes>& b) {
  Lanes sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

}  // namespace

WholeMesh whole_mesh(const HalfMesh& half) {
  WholeMesh whole;
  whole.position = half.position;
  const int n = static_cast<int>(half.position.size());
  whole.twin.resize(z(n));
  for (int v = 0; v < n; ++v) {
    if (half.on_plane(v)) {
      whole.twin[z(v)] = v;
      continue;
    }
    whole.twin[z(v)] = static_cast<int>(whole.position.size());
    const glm::dvec3 p = half.position[z(v)];
    whole.position.emplace_back(-p.x, p.y, p.z);
    whole.twin.push_back(v);
  }
  whole.area.assign(whole.position.size(), 0.0);
  whole.edges.resize(whole.position.size());
  const auto add = [&whole](int a, int b, double w) {
    for (Edge& e : whole.edges[z(a)]) {
      if (e.to == b) {
        e.cotangent += w;
        return;
      }
    }
    whole.edges[z(a)].push_back({b, w});
  };
  for (int side = 0; side < 2; ++side) {
    for (const auto& t : half.triangle) {
      for (int k = 0; k < 3; ++k) {
        int a = t[z(k)], b = t[z((k + 1) % 3)], c = t[z((k + 2) % 3)];
        if (side == 1) a = whole.twin[z(a)], b = whole.twin[z(b)], c = whole.twin[z(c)];
        const glm::dvec3 p = whole.position[z(a)] - whole.position[z(c)];
        const glm::dvec3 q = whole.position[z(b)] - whole.position[z(c)];
        const double doubled = glm::length(glm::cross(p, q));
        whole.area[z(c)] += doubled / 6.0;
        const double cotangent = 0.5 * glm::dot(p, q) / doubled;
        add(a, b, cotangent);
        add(b, a, cotangent);
      }
    }
  }
  for (auto& list : whole.edges) {
    std::sort(list.begin(), list.end(), [](const Edge& a, const Edge& b) { return a.to < b.to; });
    for (Edge& e : list) e.cotangent = std::max(e.cotangent, 0.02);
  }
  return whole;
}

BodyHeat::BodyHeat(const WholeMesh& whole, const std::vector<double>& reach)
    : first_(1, 0), diagonal_(whole.area), area_(whole.area) {
  for (std::size_t v = 0; v < whole.position.size(); ++v) {
    for (const Edge& e : whole.edges[v]) {
      // Two implicit steps, each over time reach^2 / 4: variances 2 t add up to reach^2.
      const double r = 0.5 * (reach[v] + reach[z(e.to)]);
      const double flow = e.cotangent * r * r / 4.0;
      column_.push_back(e.to);
      value_.push_back(-flow);
      diagonal_[v] += flow;
    }
    first_.push_back(column_.size());
  }
}

void BodyHeat::spread(std::span<std::vector<double>> values) const {
  const std::size_t n = area_.size(), count = values.size();
  assert(count <= kTogether);
  std::vector<Lanes> value(n), source(n);
  for (std::size_t v = 0; v < n; ++v) {
    double one[Lanes::kCount] = {};
    for (std::size_t k = 0; k < count; ++k) one[k] = values[k][v];
    value[v] = Lanes::load(one);
  }
  for (int step = 0; step < 2; ++step) {
    for (std::size_t v = 0; v < n; ++v) source[v] = area_[v] * value[v];
    solve(source, value);
  }
  for (std::size_t v = 0; v < n; ++v) {
    double one[Lanes::kCount];
    value[v].store(one);
    for (std::size_t k = 0; k < count; ++k) values[k][v] = one[k];
  }
}

void BodyHeat::multiply(const std::vector<Lanes>& x, std::vector<Lanes>& out) const {
  for (std::size_t i = 0; i < x.size(); ++i) {
    Lanes sum = diagonal_[i] * x[i];
    for (std::size_t k = first_[i]; k < first_[i + 1]; ++k) sum += value_[k] * x[z(column_[k])];
    out[i] = sum;
  }
}

/// Conjugate gradients with the diagonal as preconditioner; `x` starts as a guess. A lane stands
/// still once it is there.
void BodyHeat::solve(const std::vector<Lanes>& b, std::vector<Lanes>& x) const {
  const std::size_t n = b.size();
  std::vector<Lanes> r(n), p(n), ap(n);
  multiply(x, r);
  Lanes rq = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    r[i] = b[i] - r[i];
    p[i] = r[i] / diagonal_[i];
    rq += r[i] * p[i];
  }
  const Lanes goal = 1e-14 * dot(b, b) + 1e-300;
  Lanes::Mask going = dot(r, r) > goal;
  for (int step = 0; step < 300 && any(going); ++step) {
    multiply(p, ap);
    const Lanes alpha = select(going, rq / dot(p, ap), 0.0);
    Lanes next = 0.0, rr = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      x[i] += alpha * p[i];
      r[i] = r[i] - alpha * ap[i];
      next += r[i] * (r[i] / diagonal_[i]);
      rr += r[i] * r[i];
    }
    const Lanes beta = select(going, next / rq, 0.0);
    for (std::size_t i = 0; i < n; ++i) p[i] = r[i] / diagonal_[i] + beta * p[i];
    rq = next;
    going = going & (rr > goal);
  }
}

}  // namespace backbend::skin
