// The surface's figures beside a plain implementation of the same formulas, triangle by triangle
// and edge by edge in the character's order: blocks, order and short cuts must change nothing.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "tests/validate/tube_fixture.h"

namespace backbend::validate {
namespace {

using testing::even_bend;
using testing::SlicedTube;
using testing::Tube;

struct Plain {
  const RestMesh& mesh;
  const SpineLine& line;
  const std::vector<float>& coordinate;
  const SpineSlices& slices;
  std::span<const glm::vec3> position, normal;
  const testing::TubeBinding* bound;  // null: normals say how triangles face
  std::vector<glm::mat3> rest_turn, turn;
  const BendIntent& intent;
  double bone;

  std::vector<glm::uvec3> triangle{};  // those with an area
  MeshMeasures out{};

  struct Singular {
    float largest, smallest;
  };
  static Singular singular(const glm::vec3& u, const glm::vec3& v) {
    const float a = glm::dot(u, u), b = glm::dot(v, v), c = glm::dot(u, v);
    const float mean = 0.5f * (a + b), half = 0.5f * (a - b);
    const float root = std::sqrt(half * half + c * c);
    return {std::sqrt(mean + root), std::sqrt(std::max(mean - root, 0.0f))};
  }
  static float strain(const Singular& s) { return std::max(s.largest - 1.0f, 1.0f - s.smallest); }
  static glm::vec3 face(const glm::uvec3& t, std::span<const glm::vec3> p) {
    return glm::cross(p[t.y] - p[t.x], p[t.z] - p[t.x]);
  }
  bool inward(const glm::uvec3& t, const glm::vec3& f, std::span<const glm::vec3> n,
              const std::vector<glm::mat3>& joint) const {
    if (bound == nullptr) return glm::dot(f, n[t.x] + n[t.y] + n[t.z]) < 0.0f;
    const glm::vec3 own = glm::normalize(face(t, bound->tube.position));
    glm::vec3 sum(0.0f);
    for (int k = 0; k < 3; ++k) {
      const skin::Influences& each = bound->influences[t[k]];
      glm::vec3 corner(0.0f);
      for (int i = 0; i < skin::kMaxInfluences; ++i)
        if (each.weight[i] > 0.0f) corner += each.weight[i] * (joint[each.joint[i]] * own);
      sum += glm::normalize(corner);
    }
    return glm::dot(f, sum) < 0.0f;
  }

  float ideal(float s, const glm::vec3& offset) const {
    const int n = static_cast<int>(slices.slice.size());
    const int reach = static_cast<int>(std::ceil(bone / slices.spacing));
    const int r = std::clamp(
        static_cast<int>(std::lround((s - slices.slice.front().s) / slices.spacing)), 0, n - 1);
    int strongest = r;
    for (int k = std::max(0, r - reach); k <= std::min(n - 1, r + reach); ++k)
      if (glm::length(intent.bend[k]) > glm::length(intent.bend[strongest])) strongest = k;
    const glm::dvec3 t = intent.rest_tangent[r];
    const glm::vec3 tangent(t), lever(glm::cross(t, intent.bend[strongest]));
    const float along = 1.0f + glm::dot(lever, offset);
    const glm::vec3 across = offset - glm::dot(offset, tangent) * tangent;
    return std::max(
        0.05f, strain(singular({1, 0, 0}, {static_cast<float>(intent.twist) * glm::length(across),
                                           std::max(along, 0.0f), 0})));
  }

  void measure_triangles() {
    std::map<int, double> area_of_step;  // over the logarithm of the strain, in sixteenths
    double area = 0.0, torso_area = 0.0, inverted = 0.0;
    for (const glm::uvec3& t : mesh.triangle) {
      const glm::dvec3 p(mesh.position[t.x]);
      const glm::dvec3 e1 = glm::dvec3(mesh.position[t.y]) - p,
                       e2 = glm::dvec3(mesh.position[t.z]) - p;
      const double a = glm::length(e1), double_area = glm::length(glm::cross(e1, e2));
      const double c = double_area / a, b = glm::dot(e1, e2) / a;
      if (!(c > 1e-5 * std::max(a, glm::length(e2)))) continue;
      triangle.push_back(t);
      const float whole = static_cast<float>(0.5 * double_area);
      area += whole;
      const glm::vec3 f1 = position[t.y] - position[t.x], f2 = position[t.z] - position[t.x];
      const Singular s =
          singular(f1 * static_cast<float>(1.0 / a),
                   f1 * static_cast<float>(-b / (a * c)) + f2 * static_cast<float>(1.0 / c));
      if (s.largest > out.stretch) {
        out.stretch = s.largest;
        out.stretch_vertex = static_cast<int>(t.x);
      }
      if (!inward(t, face(t, mesh.position), mesh.normal, rest_turn) &&
          inward(t, face(t, position), normal, turn)) {
        if (out.inverted++ == 0) out.inverted_vertex = static_cast<int>(t.x);
        inverted += whole;
      }
      if (!(mesh.torso[t.x] && mesh.torso[t.y] && mesh.torso[t.z])) continue;
      const float at = (coordinate[mesh.place[t.x]] + coordinate[mesh.place[t.y]] +
                        coordinate[mesh.place[t.z]]) /
                       3.0f;
      if (!(at >= 0.0f && at <= 1.0f)) continue;
      const float amplified =
          strain(s) / ideal(at, glm::vec3(p + (e1 + e2) / 3.0 - line.point(at)));
      torso_area += whole;
      area_of_step[amplified > 0.0f ? static_cast<int>((std::log2(amplified) + 12) * 16) : 0] +=
          whole;
      if (amplified > out.strain) {
        out.strain = amplified;
        out.strain_vertex = static_cast<int>(t.x);
        out.strain_s = at;
      }
    }
    out.inverted_area = inverted / area;
    double below = 0.0;
    out.strain_most = std::nan("");
    for (const auto& [step, here] : area_of_step)
      if ((below += here) >= 0.999 * torso_area) {
        out.strain_most = std::exp2((std::max(step, 0) + 1.0) / 16.0 - 12.0);
        break;
      }
  }

  void measure_folds() {
    struct Side {
      std::size_t triangle;
      bool forward;
    };
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<Side>> edges;  // by places
    std::vector<std::uint32_t> vertex(mesh.place_count);
    for (std::size_t v = mesh.position.size(); v-- > 0;)
      vertex[mesh.place[v]] = static_cast<std::uint32_t>(v);
    for (std::size_t t = 0; t < triangle.size(); ++t)
      for (int i = 0; i < 3; ++i) {
        const std::uint32_t a = mesh.place[triangle[t][i]],
                            b = mesh.place[triangle[t][(i + 1) % 3]];
        if (a != b) edges[std::minmax(a, b)].push_back({t, a < b});
      }
    const auto fold = [&](const Side& first, const Side& second, std::uint32_t a, std::uint32_t b,
                          std::span<const glm::vec3> p) {
      const glm::vec3 n = face(triangle[first.triangle], p), m = face(triangle[second.triangle], p);
      const glm::vec3 along = p[vertex[b]] - p[vertex[a]];
      const float cosine = glm::dot(n, m),
                  sine = glm::dot(glm::cross(n, m), along) / glm::length(along);
      const float length = std::sqrt(cosine * cosine + sine * sine);
      return length > 0.0f ? std::pair(cosine / length, sine / length) : std::pair(1.0f, 0.0f);
    };
    float least = 1.0f;
    for (const auto& [ends, side] : edges) {
      if (side.size() != 2 || side[0].forward == side[1].forward) continue;
      auto [a, b] = ends;
      if (!side[0].forward) std::swap(a, b);
      const auto rest = fold(side[0], side[1], a, b, mesh.position);
      const auto now = fold(side[0], side[1], a, b, position);
      const float cosine = now.first * rest.first + now.second * rest.second;
      if (cosine < least) {
        least = cosine;
        out.dihedral_vertex = static_cast<int>(vertex[a]);
      }
    }
    out.dihedral_deg = degrees(std::acos(std::clamp(static_cast<double>(least), -1.0, 1.0)));
  }

  double volume(std::span<const glm::vec3> p) const {
    glm::dvec3 middle(0.0);
    for (const glm::vec3& v : mesh.position) middle += glm::dvec3(v) / double(mesh.position.size());
    double six = 0.0;
    for (const glm::uvec3& t : triangle)
      six += glm::dot(glm::dvec3(p[t.x]) - middle,
                      glm::cross(glm::dvec3(p[t.y]) - middle, glm::dvec3(p[t.z]) - middle));
    return six;
  }
};

/// The same body with its vertices and triangles in a random order, and a vertex of its own for
/// every fifth corner, at the place of another.
Tube shuffled(const Tube& from, std::mt19937& random) {
  Tube to = from;
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  std::vector<std::uint32_t> order(from.position.size());
  for (std::uint32_t v = 0; v < order.size(); ++v) order[v] = v;
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[below(i)]);
  std::vector<std::uint32_t> now(order.size());
  for (std::uint32_t v = 0; v < order.size(); ++v) now[order[v]] = v;
  for (std::size_t v = 0; v < order.size(); ++v) {
    to.position[v] = from.position[order[v]];
    to.normal[v] = from.normal[order[v]];
    to.weight[v] = from.weight[order[v]];
    to.torso[v] = from.position[order[v]].x > -0.05f;  // a side of it is an arm
  }
  for (std::size_t i = to.triangle.size(); i > 1; --i)
    std::swap(to.triangle[i - 1], to.triangle[below(i)]);
  for (glm::uvec3& t : to.triangle)
    for (int i = 0; i < 3; ++i) {
      t[i] = now[t[i]];
      if (below(5) > 0) continue;
      to.position.push_back(to.position[t[i]]);
      to.normal.push_back(to.normal[t[i]]);
      to.weight.push_back(to.weight[t[i]]);
      to.torso.push_back(to.torso[t[i]]);
      to.place.push_back(to.place[t[i]]);
      t[i] = static_cast<std::uint32_t>(to.position.size()) - 1;
    }
  return to;
}

void expect_same(const SlicedTube& t, const RestMesh& mesh, const std::vector<glm::vec3>& position,
                 const std::vector<glm::vec3>& normal, const testing::TubeBinding* bound,
                 const solver::SpinePose& pose, const BendIntent& intent, const std::string& what) {
  const double bone = 1.0 / t.tube.bones;
  const auto turns = [&](const solver::SpinePose& at) {
    return bound ? face_turns(bound->joints(at)) : std::vector<glm::mat3>{};
  };
  const std::vector<glm::mat3> turn = turns(pose);
  const MeshMeasures m = measure_mesh(t.mesh_rest, position, {normal, turn}, intent, bone);
  Plain plain{mesh, t.line, t.coordinate, t.slices, position, normal, bound, turns(t.tube.rest),
              turn, intent, bone};
  plain.measure_triangles();
  plain.measure_folds();
  const MeshMeasures& p = plain.out;
  EXPECT_EQ(m.stretch, p.stretch) << what;
  EXPECT_EQ(m.stretch_vertex, p.stretch_vertex) << what;
  EXPECT_EQ(m.strain, p.strain) << what;
  EXPECT_EQ(m.strain_vertex, p.strain_vertex) << what;
  EXPECT_EQ(m.strain_s, p.strain_s) << what;
  EXPECT_EQ(m.strain_most, p.strain_most) << what;
  EXPECT_EQ(m.inverted, p.inverted) << what;
  EXPECT_EQ(m.inverted_vertex, p.inverted_vertex) << what;
  EXPECT_NEAR(m.inverted_area, p.inverted_area, 1e-12) << what;
  EXPECT_EQ(m.dihedral_deg, p.dihedral_deg) << what;
  EXPECT_EQ(m.dihedral_vertex, p.dihedral_vertex) << what;
  if (t.mesh_rest.open_reason.empty())
    EXPECT_NEAR(m.volume_change, plain.volume(position) / plain.volume(mesh.position) - 1.0, 1e-12)
        << what;
  else
    EXPECT_TRUE(std::isnan(m.volume_change)) << what;
}

TEST(MeshAgainstPlainCode, EveryFigureIsTheSameOnCleanBrokenAndShuffledBodies) {
  std::mt19937 random(11);
  const auto spread = [&] {
    return static_cast<float>(static_cast<double>(random()) / 4294967295.0 - 0.5);
  };
  for (const bool shuffle : {false, true})
    for (const bool open : {false, true}) {
      Tube tube(8, 0.12);
      if (shuffle) tube = shuffled(tube, random);
      if (open) tube.triangle.resize(tube.triangle.size() - 3);
      SlicedTube t(tube);
      const RestMesh own{t.tube.position,
                         t.tube.normal,
                         t.tube.triangle,
                         t.tube.place,
                         // vertices at one place share its number
                         static_cast<std::uint32_t>(Tube(8, 0.12).position.size()),
                         t.tube.torso,
                         {},
                         t.tube.spine};
      const testing::TubeBinding bound(t.tube);
      const skin::JointMatrices at_rest = bound.joints(t.tube.rest);
      const MeshBinding binding{t.tube.position, bound.influences, at_rest};
      for (const bool joints : {false, true})
        for (const double bend : {0.0, 0.7, 2.6})
          for (const float noise : {0.0f, 1e-4f, 0.05f}) {
            t.mesh_rest =
                prepare_mesh(own, t.line, t.coordinate, t.slices, {}, joints ? &binding : nullptr);
            const double twist = 0.4 * bend;
            const solver::SpinePose pose = t.tube.pose_of(even_bend(bend), twist);
            std::vector<glm::vec3> position = t.tube.skin(pose);
            for (glm::vec3& p : position) p += noise * glm::vec3(spread(), spread(), spread());
            expect_same(t, own, position, t.tube.skin_normals(pose), joints ? &bound : nullptr,
                        pose, t.intent(pose, even_bend(bend), twist),
                        "bend " + std::to_string(bend) + ", noise " + std::to_string(noise) +
                            (shuffle ? ", shuffled" : "") + (open ? ", open" : ""));
          }
    }
}

TEST(MeshAgainstPlainCode, TriangleByTriangleOnBodiesOfFewTriangles) {
  // Blocks that are not full, and poses of which every triangle is as bad as the others.
  for (std::size_t count = 1; count <= 20; ++count) {
    Tube tube(4);
    tube.triangle.erase(tube.triangle.begin(), tube.triangle.begin() + 4000);
    tube.triangle.resize(count);
    const SlicedTube t(std::move(tube));
    const RestMesh mesh = t.tube.mesh();
    std::vector<glm::vec3> position = t.tube.position;
    for (glm::vec3& p : position) p *= 1.5f;
    expect_same(t, mesh, position, t.tube.normal, nullptr, t.tube.rest,
                no_intent(t.slices, t.rest_slices), std::to_string(count) + " triangles, grown");
    for (glm::vec3& p : position) p = glm::vec3(0.0f);
    expect_same(t, mesh, position, t.tube.normal, nullptr, t.tube.rest,
                no_intent(t.slices, t.rest_slices),
                std::to_string(count) + " triangles in one point");
  }
}

}  // namespace
}  // namespace backbend::validate
