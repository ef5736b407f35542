#include "skin/body/body_connectivity.h"

#include <algorithm>

#include "skin/body/index.h"

namespace backbend::skin {
namespace {

bool has(const std::array<int, 3>& t, int v) { return t[0] == v || t[1] == v || t[2] == v; }

/// Whether `t` runs from a to b in its own sense.
bool runs(const std::array<int, 3>& t, int a, int b) {
  return (t[0] == a && t[1] == b) || (t[1] == a && t[2] == b) || (t[2] == a && t[0] == b);
}

}  // namespace

Connectivity::Connectivity(HalfMesh& mesh) : mesh_(mesh), faces_(mesh.position.size()) {
  for (auto& list : faces_) list.reserve(8);
  for (std::size_t f = 0; f < mesh.triangle.size(); ++f) {
    for (const int v : mesh.triangle[f]) faces_[z(v)].push_back(static_cast<int>(f));
  }
}

void Connectivity::neighbours(int v, std::vector<int>& out) const {
  out.clear();
  for (const int f : faces(v)) {
    for (const int n : mesh_.triangle[z(f)]) {
      if (n == v) continue;
      auto at = out.end();
      while (at != out.begin() && *(at - 1) > n) --at;
      if (at == out.begin() || *(at - 1) != n) out.insert(at, n);
    }
  }
}

int Connectivity::valence(int v) const {
  // A fan of faces has one neighbour more than faces, a closed one as many.
  return static_cast<int>(faces(v).size()) + (mesh_.on_plane(v) ? 1 : 0);
}

int Connectivity::third(int face, int a, int b) const {
  const auto& t = mesh_.triangle[z(face)];
  return *std::find_if(t.begin(), t.end(), [&](int v) { return v != a && v != b; });
}

void Connectivity::unlink(int v, int face) {
  auto& list = faces_[z(v)];
  list.erase(std::find(list.begin(), list.end(), face));
}

Connectivity::Shared Connectivity::shared(int a, int b) const {
  Shared out;
  for (const int f : faces(a)) {
    if (out.count < 3 && has(mesh_.triangle[z(f)], b)) out.face[z(out.count++)] = f;
  }
  return out;
}

int Connectivity::split(int a, int b, const glm::dvec3& p) {
  const int fresh = static_cast<int>(mesh_.position.size());
  mesh_.position.push_back(p);
  faces_.emplace_back();
  const Shared both = shared(a, b);
  for (int i = 0; i < both.count; ++i) {
    const int f = both.face[z(i)];
    std::array<int, 3> other = mesh_.triangle[z(f)];
    const int c = third(f, a, b);
    for (int& v : mesh_.triangle[z(f)]) v = v == b ? fresh : v;
    for (int& v : other) v = v == a ? fresh : v;
    const int added = static_cast<int>(mesh_.triangle.size());
    mesh_.triangle.push_back(other);
    unlink(b, f);
    faces_[z(b)].push_back(added);
    faces_[z(c)].push_back(added);
    faces_[z(fresh)].push_back(f);
    faces_[z(fresh)].push_back(added);
  }
  return fresh;
}

bool Connectivity::may_collapse(int a, int b) const {
  neighbours(a, of_a_);
  return may_collapse(a, b, of_a_);
}

bool Connectivity::may_collapse(int a, int b, const std::vector<int>& of_a) const {
  const bool a_border = mesh_.on_plane(a), b_border = mesh_.on_plane(b);
  if (a_border && !b_border) return false;
  const Shared lost = shared(a, b);
  if (lost.count != (a_border ? 1 : 2)) return false;
  int opposite[2] = {-1, -1};
  for (int i = 0; i < lost.count; ++i) {
    const int n = opposite[i] = third(lost.face[z(i)], a, b);
    // Every vertex keeps four neighbours or more, those beyond the plane counted.
    if (valence(n) <= (mesh_.on_plane(n) ? 3 : 4)) return false;
    if (a_border && mesh_.on_plane(n)) return false;
  }
  const auto vanishes = [&](int n) { return n == opposite[0] || n == opposite[1]; };
  // The link condition: a and b may only share the vertices of the faces that vanish.
  if (lost.count == 2 && opposite[0] == opposite[1]) return false;
  for (const int f : faces(b)) {
    for (const int n : mesh_.triangle[z(f)]) {
      if (n == a || n == b || vanishes(n)) continue;
      if (std::find(of_a.begin(), of_a.end(), n) != of_a.end()) return false;
    }
  }
  // Neighbours are no fewer than faces.
  const std::size_t least = b_border ? 8u : 9u;
  if (of_a.size() + faces(b).size() < least) {
    neighbours(b, of_b_);
    if (of_a.size() + of_b_.size() < least) return false;
  }
  if (!a_border && b_border) {
    for (const int n : of_a) {
      if (n == b || !mesh_.on_plane(n)) continue;
      if (!vanishes(n) || shared(b, n).count != 1) return false;
    }
  }
  return true;
}

void Connectivity::collapse(int a, int b) {
  const std::vector<int> around = faces(a);
  for (const int f : around) {
    auto& t = mesh_.triangle[z(f)];
    if (has(t, b)) {
      for (const int v : t) {
        if (v != a) unlink(v, f);
      }
      t = {-1, -1, -1};
    } else {
      for (int& v : t) v = v == a ? b : v;
      faces_[z(b)].push_back(f);
    }
  }
  faces_[z(a)].clear();
}

bool Connectivity::may_flip(int a, int b, int* c, int* d) const {
  const Shared both = shared(a, b);
  if (both.count != 2) return false;
  const bool first = runs(mesh_.triangle[z(both.face[0])], a, b);
  *c = third(both.face[first ? 0 : 1], a, b);
  *d = third(both.face[first ? 1 : 0], a, b);
  if (mesh_.on_plane(*c) && mesh_.on_plane(*d)) return false;
  if (shared(*c, *d).count > 0) return false;
  return valence(a) > (mesh_.on_plane(a) ? 3 : 4) && valence(b) > (mesh_.on_plane(b) ? 3 : 4);
}

void Connectivity::flip(int a, int b, int c, int d) {
  const Shared both = shared(a, b);
  const bool first = runs(mesh_.triangle[z(both.face[0])], a, b);
  const int f = both.face[first ? 0 : 1], g = both.face[first ? 1 : 0];
  mesh_.triangle[z(f)] = {c, d, b};
  mesh_.triangle[z(g)] = {d, c, a};
  unlink(a, f);
  unlink(b, g);
  faces_[z(d)].push_back(f);
  faces_[z(c)].push_back(g);
}

std::vector<int> Connectivity::compact() {
  std::vector<int> number(mesh_.position.size(), -1), old;
  HalfMesh kept;
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (faces_[v].empty()) continue;
    number[v] = static_cast<int>(kept.position.size());
    kept.position.push_back(mesh_.position[v]);
    old.push_back(static_cast<int>(v));
  }
  for (const auto& t : mesh_.triangle) {
    if (t[0] >= 0) kept.triangle.push_back({number[z(t[0])], number[z(t[1])], number[z(t[2])]});
  }
  mesh_ = std::move(kept);
  faces_ = Connectivity(mesh_).faces_;
  return old;
}

}  // namespace backbend::skin
