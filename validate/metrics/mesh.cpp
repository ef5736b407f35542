#include "validate/metrics/mesh.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <tuple>

namespace backbend::validate {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
// Strains below this are rounding of nearly straight poses, and no measure of anything.
constexpr float kLeastStrain = 0.05f;

struct Singular {
  float largest, smallest;
};

/// Singular values of a 3x2 matrix with columns u, v: the roots of its 2x2 Gram matrix.
Singular singular_values(const glm::vec3& u, const glm::vec3& v) {
  const float a = glm::dot(u, u), b = glm::dot(v, v), c = glm::dot(u, v);
  const float mean = 0.5f * (a + b), half = 0.5f * (a - b);
  const float root = std::sqrt(half * half + c * c);
  return {std::sqrt(mean + root), std::sqrt(std::max(mean - root, 0.0f))};
}

Singular triangle_stretch(const MeshRest::Triangle& t, std::span<const glm::vec3> position) {
  const glm::vec3& p = position[t.vertex[0]];
  const glm::vec3 e1 = position[t.vertex[1]] - p, e2 = position[t.vertex[2]] - p;
  return singular_values(e1 * t.inverse[0], e1 * t.inverse[1] + e2 * t.inverse[2]);
}

float strain_of(const Singular& s) { return std::max(s.largest - 1.0f, 1.0f - s.smallest); }

/// What an ideal beam bent and twisted as intended strains, slice by slice.
class IdealStrain {
 public:
  IdealStrain(const SpineSlices& slices, const BendIntent& intent, double bone)
      : first_(slices.slice.front().s),
        spacing_(slices.spacing),
        twist_(static_cast<float>(intent.twist)) {
    // The slice with the strongest bend within a bone of each: there the ideal is asked.
    const int n = static_cast<int>(slices.slice.size());
    const int reach = spacing_ > 0.0 ? static_cast<int>(std::ceil(bone / spacing_)) : 0;
    for (int r = 0; r < n; ++r) {
      int strongest = r;
      for (int k = std::max(0, r - reach); k <= std::min(n - 1, r + reach); ++k)
        if (glm::length(intent.bend[k]) > glm::length(intent.bend[strongest])) strongest = k;
      const glm::dvec3 tangent = rest_tangent(intent, r);
      tangent_.push_back(glm::vec3(tangent));
      // tangent . (bend x offset) = (tangent x bend) . offset
      lever_.push_back(glm::vec3(glm::cross(tangent, intent.bend[strongest])));
    }
  }

  float at(float s, const glm::vec3& offset) const {
    const int n = static_cast<int>(lever_.size());
    const int r = spacing_ > 0.0
                      ? std::clamp(static_cast<int>(std::lround((s - first_) / spacing_)), 0, n - 1)
                      : 0;
    const float along = 1.0f + glm::dot(lever_[r], offset);
    const glm::vec3 across = offset - glm::dot(offset, tangent_[r]) * tangent_[r];
    // [[1, twist * radius], [0, along]]; beyond its depth the inner side has no length left.
    const Singular ideal = singular_values(
        glm::vec3(1, 0, 0), glm::vec3(twist_ * glm::length(across), std::max(along, 0.0f), 0));
    return std::max(kLeastStrain, strain_of(ideal));
  }

 private:
  static glm::dvec3 rest_tangent(const BendIntent& intent, int r) {
    const glm::dvec3& t = intent.rest_tangent[static_cast<std::size_t>(r)];
    return glm::dot(t, t) > 0.0 ? t : glm::dvec3(0, 1, 0);
  }

  double first_, spacing_;
  float twist_;
  std::vector<glm::vec3> tangent_, lever_;
};

/// Area over value, in steps of 2^(1/16): a quantile within 4.4 % in one pass and no memory.
class AreaDistribution {
 public:
  void add(float value, float area) {
    area_[bin(value)] += area;
    whole_ += area;
  }
  /// The value that this share of the area stays below (upper end of its step); NaN without area.
  double below(double share) const {
    if (!(whole_ > 0.0)) return kNan;
    double sum = 0.0;
    for (std::size_t i = 0; i < area_.size(); ++i) {
      sum += area_[i];
      if (sum >= share * whole_) return std::exp2((static_cast<double>(i) + 1.0) / 16.0 - kOctaves);
    }
    return std::exp2(kOctaves);
  }

 private:
  static constexpr int kOctaves = 12;  // from 2^-12, which is nothing, to 2^12
  static std::size_t bin(float value) {
    if (!(value > 0.0f)) return 0;
    return static_cast<std::size_t>(
        std::clamp(static_cast<int>((std::log2(value) + kOctaves) * 16.0f), 0, 32 * kOctaves - 1));
  }
  std::array<double, 32 * kOctaves> area_{};
  double whole_ = 0.0;
};

bool on_spine(float s) { return s >= 0.0f && s <= 1.0f; }

/// Edges with the triangle they belong to, sorted so that the two sides of one stand together.
struct HalfEdge {
  std::uint32_t low, high;  // places
  bool forward;             // the triangle runs from low to high
  std::uint32_t triangle;   // into MeshRest::triangle
};

std::vector<HalfEdge> half_edges(const MeshRest& rest, std::span<const std::uint32_t> place) {
  std::vector<HalfEdge> out;
  out.reserve(rest.triangle.size() * 3);
  for (std::uint32_t t = 0; t < rest.triangle.size(); ++t)
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t a = place[rest.triangle[t].vertex[i]];
      const std::uint32_t b = place[rest.triangle[t].vertex[(i + 1) % 3]];
      if (a != b) out.push_back({std::min(a, b), std::max(a, b), a < b, t});
    }
  std::ranges::sort(out, [](const HalfEdge& x, const HalfEdge& y) {
    return std::tie(x.low, x.high, x.triangle, x.forward) <
           std::tie(y.low, y.high, y.triangle, y.forward);
  });
  return out;
}

glm::vec3 face(const MeshRest::Triangle& t, std::span<const glm::vec3> position) {
  const glm::vec3& p = position[t.vertex[0]];
  return glm::cross(position[t.vertex[1]] - p, position[t.vertex[2]] - p);
}

/// Cosine and sine of the angle that the second face is turned by about the edge.
struct Fold {
  float cosine, sine;
};
Fold fold(const glm::vec3& first, const glm::vec3& second, const glm::vec3& edge) {
  const float cosine = glm::dot(first, second);
  const float sine = glm::dot(glm::cross(first, second), edge) / glm::length(edge);
  const float length = std::sqrt(cosine * cosine + sine * sine);
  return length > 0.0f ? Fold{cosine / length, sine / length} : Fold{1.0f, 0.0f};
}

void add_edges(MeshRest& rest, const RestMesh& mesh) {
  const std::vector<HalfEdge> half = half_edges(rest, mesh.place);
  std::size_t open = 0, crowded = 0, turned = 0;
  for (std::size_t i = 0; i < half.size();) {
    std::size_t end = i;
    while (end < half.size() && half[end].low == half[i].low && half[end].high == half[i].high)
      ++end;
    if (end - i == 1) ++open;
    if (end - i > 2) ++crowded;
    if (end - i == 2) {
      if (half[i].forward == half[i + 1].forward) {
        ++turned;
      } else {
        MeshRest::Edge edge{half[i].forward ? half[i].low : half[i].high,
                            half[i].forward ? half[i].high : half[i].low,
                            half[i].triangle,
                            half[i + 1].triangle,
                            1.0f,
                            0.0f};
        const glm::vec3 along = mesh.position[rest.vertex_of_place[edge.b]] -
                                mesh.position[rest.vertex_of_place[edge.a]];
        const Fold at_rest = fold(face(rest.triangle[edge.first], mesh.position),
                                  face(rest.triangle[edge.second], mesh.position), along);
        edge.cosine = at_rest.cosine;
        edge.sine = at_rest.sine;
        rest.edge.push_back(edge);
      }
    }
    i = end;
  }
  if (open > 0)
    rest.open_reason = std::to_string(open) + " open edges: the mesh encloses no volume";
  else if (crowded > 0)
    rest.open_reason = std::to_string(crowded) + " edges of three triangles or more";
  else if (turned > 0)
    rest.open_reason = std::to_string(turned) + " edges whose triangles face opposite ways";
}

double signed_volume(const MeshRest& rest, std::span<const glm::vec3> position) {
  double six = 0.0;
  for (const MeshRest::Triangle& t : rest.triangle) {
    const glm::dvec3 a = glm::dvec3(position[t.vertex[0]]) - rest.middle,
                     b = glm::dvec3(position[t.vertex[1]]) - rest.middle,
                     c = glm::dvec3(position[t.vertex[2]]) - rest.middle;
    six += glm::dot(a, glm::cross(b, c));
  }
  return six / 6.0;
}

bool faces_inward(const MeshRest::Triangle& t, const glm::vec3& face,
                  std::span<const glm::vec3> normal) {
  return glm::dot(face, normal[t.vertex[0]] + normal[t.vertex[1]] + normal[t.vertex[2]]) < 0.0f;
}

}  // namespace

MeshRest prepare_mesh(const RestMesh& mesh, const SpineLine& line,
                      std::span<const float> coordinate) {
  MeshRest rest;
  rest.vertex_count = mesh.position.size();
  rest.vertex_of_place.assign(mesh.place_count, 0);
  for (std::size_t v = mesh.position.size(); v-- > 0;)
    rest.vertex_of_place[mesh.place[v]] = static_cast<std::uint32_t>(v);
  for (const glm::vec3& p : mesh.position) rest.middle += glm::dvec3(p);
  if (!mesh.position.empty()) rest.middle /= static_cast<double>(mesh.position.size());

  for (std::uint32_t n = 0; n < mesh.triangle.size(); ++n) {
    const glm::uvec3& corner = mesh.triangle[n];
    const glm::dvec3 p(mesh.position[corner.x]);
    const glm::dvec3 e1 = glm::dvec3(mesh.position[corner.y]) - p,
                     e2 = glm::dvec3(mesh.position[corner.z]) - p;
    // Rest basis [[a, b], [0, c]]: e1 along the first axis.
    const double a = glm::length(e1), double_area = glm::length(glm::cross(e1, e2));
    const double c = a > 0.0 ? double_area / a : 0.0, b = a > 0.0 ? glm::dot(e1, e2) / a : 0.0;
    // Needles thinner than float positions resolve have no measurable strain.
    if (!(c > 1e-5 * std::max(a, glm::length(e2)))) {
      ++rest.degenerate;
      continue;
    }
    MeshRest::Triangle t{{corner.x, corner.y, corner.z},
                         {static_cast<float>(1.0 / a), static_cast<float>(-b / (a * c)),
                          static_cast<float>(1.0 / c)},
                         static_cast<float>(0.5 * double_area),
                         std::numeric_limits<float>::quiet_NaN(),
                         glm::vec3(0.0f),
                         n,
                         false};
    t.inverted = faces_inward(t, glm::vec3(glm::cross(e1, e2)), mesh.normal);
    if (mesh.torso[corner.x] && mesh.torso[corner.y] && mesh.torso[corner.z]) {
      t.s = (coordinate[mesh.place[corner.x]] + coordinate[mesh.place[corner.y]] +
             coordinate[mesh.place[corner.z]]) /
            3.0f;
      t.offset = glm::vec3(p + (e1 + e2) / 3.0 - line.point(t.s));
    }
    rest.area += t.area;
    rest.triangle.push_back(t);
  }
  add_edges(rest, mesh);
  rest.volume = signed_volume(rest, mesh.position);
  // A sheet that is closed by its own back has no inside.
  if (rest.open_reason.empty() && !(std::abs(rest.volume) > 1e-6 * std::pow(rest.area, 1.5)))
    rest.open_reason = "the closed mesh encloses no volume";
  if (rest.triangle.empty()) rest.open_reason = "no triangle with an area";
  return rest;
}

MeshMeasures measure_mesh(const MeshRest& rest, std::span<const glm::vec3> position,
                          std::span<const glm::vec3> normal, const SpineSlices& slices,
                          const BendIntent& intent, double bone) {
  assert(position.size() == rest.vertex_count && normal.size() == rest.vertex_count);
  assert(!slices.slice.empty() && intent.bend.size() == slices.slice.size());
  MeshMeasures out;
  for (std::size_t v = 0; v < position.size(); ++v)
    out.not_finite += !(std::isfinite(position[v].x) && std::isfinite(position[v].y) &&
                        std::isfinite(position[v].z) && std::isfinite(normal[v].x) &&
                        std::isfinite(normal[v].y) && std::isfinite(normal[v].z));
  if (out.not_finite > 0) return out;

  const IdealStrain ideal(slices, intent, bone);
  std::vector<glm::vec3> faces;
  faces.reserve(rest.triangle.size());
  double inverted = 0.0;
  AreaDistribution distribution;
  for (const MeshRest::Triangle& t : rest.triangle) {
    faces.push_back(face(t, position));
    const Singular stretch = triangle_stretch(t, position);
    if (stretch.largest > out.stretch) {
      out.stretch = stretch.largest;
      out.stretch_vertex = static_cast<int>(t.vertex[0]);
    }
    if (on_spine(t.s)) {
      const float amplified = strain_of(stretch) / ideal.at(t.s, t.offset);
      distribution.add(amplified, t.area);
      if (amplified > out.strain) {
        out.strain = amplified;
        out.strain_vertex = static_cast<int>(t.vertex[0]);
        out.strain_s = t.s;
      }
    }
    if (!t.inverted && faces_inward(t, faces.back(), normal)) {
      ++out.inverted;
      inverted += t.area;
      if (out.inverted_vertex < 0) out.inverted_vertex = static_cast<int>(t.vertex[0]);
    }
  }
  out.strain_most = distribution.below(0.999);
  out.inverted_area = rest.area > 0.0 ? inverted / rest.area : kNan;

  float least_cosine = 1.0f;
  for (const MeshRest::Edge& edge : rest.edge) {
    const glm::vec3 along =
        position[rest.vertex_of_place[edge.b]] - position[rest.vertex_of_place[edge.a]];
    const Fold now = fold(faces[edge.first], faces[edge.second], along);
    const float cosine = now.cosine * edge.cosine + now.sine * edge.sine;
    if (cosine < least_cosine) {
      least_cosine = cosine;
      out.dihedral_vertex = static_cast<int>(rest.vertex_of_place[edge.a]);
    }
  }
  out.dihedral_deg = degrees(std::acos(std::clamp(static_cast<double>(least_cosine), -1.0, 1.0)));
  out.volume_change =
      rest.open_reason.empty() ? signed_volume(rest, position) / rest.volume - 1.0 : kNan;
  return out;
}

std::vector<float> strain_map(const MeshRest& rest, std::span<const glm::vec3> position,
                              const SpineSlices& slices, const BendIntent& intent, double bone) {
  const IdealStrain ideal(slices, intent, bone);
  std::vector<float> map(rest.vertex_count, 0.0f);
  for (const MeshRest::Triangle& t : rest.triangle) {
    if (!on_spine(t.s)) continue;
    const float amplified = strain_of(triangle_stretch(t, position)) / ideal.at(t.s, t.offset);
    for (std::uint32_t v : t.vertex) map[v] = std::max(map[v], amplified);
  }
  return map;
}

PartDrift part_drift(std::span<const glm::vec3> rest_position, std::span<const glm::vec3> position,
                     std::span<const std::uint8_t> part, const solver::RigidMotion& carrier) {
  assert(rest_position.size() == position.size() && part.size() == position.size());
  PartDrift out;
  for (std::size_t v = 0; v < position.size(); ++v) {
    if (!part[v]) continue;
    const double distance =
        glm::distance(glm::dvec3(position[v]), carrier.apply(glm::dvec3(rest_position[v])));
    if (!(distance <= out.distance)) {  // NaN is kept
      out = {distance, static_cast<int>(v)};
      if (std::isnan(distance)) return out;
    }
  }
  return out;
}

}  // namespace backbend::validate
