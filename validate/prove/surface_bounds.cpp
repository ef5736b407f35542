#include "validate/prove/surface_bounds.h"

#include <algorithm>
#include <limits>

#include "skin/deform/linear_blend.h"
#include "skin/deform/rest_matrices.h"

namespace backbend::validate {

using solver::BoxReal;
using solver::BoxVector;
using solver::Interval;
using solver::IntervalVector;

namespace {

/// The motion with the largest sum of weights over some vertices.
template <class Vertices>
std::uint16_t most_carrying(const Vertices& vertices) {
  std::vector<double> sum;
  for (const auto& vertex : vertices) {
    for (const auto& c : vertex) {
      if (c.motion >= sum.size()) sum.resize(c.motion + std::size_t{1}, 0.0);
      sum[c.motion] += c.weight;
    }
  }
  return static_cast<std::uint16_t>(std::max_element(sum.begin(), sum.end()) - sum.begin());
}

/// All motions that carry some of the vertices.
template <class Vertices>
std::vector<std::uint16_t> motions_of(const Vertices& vertices) {
  std::vector<std::uint16_t> all;
  for (const auto& vertex : vertices)
    for (const auto& c : vertex) all.push_back(c.motion);
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

}  // namespace

SurfaceBounds::SurfaceBounds(const Stage& stage, const BodyMetrics& body)
    : character_(stage.character()), motion_of_node_(stage.driver().node_motions()) {
  for (const skin::SkinJoint& joint : character_.joints) {
    rest_.push_back(character_.nodes[static_cast<std::size_t>(joint.node)].world_from_node *
                    joint.joint_from_mesh);
  }
  face_ = face_turns(skin::joint_matrices(character_.joints, skin::rest_matrices(character_)));
  const MeshRest& mesh = body.mesh();
  area_ = mesh.area;
  for (std::size_t b = 0; b < mesh.block.size(); ++b) {
    const MeshRest::Block& block = mesh.block[b];
    for (std::uint32_t lane = 0; lane < MeshRest::kLanes; ++lane) {
      if ((block.present & block.upright) >> lane & 1) {
        add_triangle({mesh.vertex[block.corner[0][lane]], mesh.vertex[block.corner[1][lane]],
                      mesh.vertex[block.corner[2][lane]]},
                     mesh.slot_area[b * MeshRest::kLanes + lane]);
      }
    }
  }
  const SpineSlices& slices = body.slices();
  for (std::size_t s = 0; s < slices.slice.size(); ++s)
    add_ring(slices.slice[s], glm::length(body.rest_slices().area[s]));
}

SurfaceBounds::Vertex SurfaceBounds::vertex_of(std::size_t v) const {
  const skin::Influences& influences = character_.influences[v];
  const glm::dvec4 place(glm::dvec3(character_.bind_position[v]), 1.0);
  double sum = 0.0;
  for (const float w : influences.weight) sum += w;
  if (!(sum > 0.0)) return {{0, 1.0, glm::dvec3(place)}};  // no joint: stays as it is
  Vertex vertex;
  for (std::size_t k = 0; k < skin::kMaxInfluences; ++k) {
    if (!(influences.weight[k] > 0.0f)) continue;
    const double weight = influences.weight[k] / sum;
    const std::size_t joint = influences.joint[k];
    const auto motion = static_cast<std::uint16_t>(
        motion_of_node_[static_cast<std::size_t>(character_.joints[joint].node)]);
    auto at = std::find_if(vertex.begin(), vertex.end(),
                           [&](const Carried& c) { return c.motion == motion; });
    if (at == vertex.end()) at = vertex.insert(at, {motion, 0.0, {}});
    at->weight += weight;
    at->place += weight * glm::dvec3(rest_[joint] * place);
    at->face += weight * glm::dmat3(face_[joint]);
  }
  return vertex;
}

std::uint16_t SurfaceBounds::pair_of(std::uint16_t base, std::uint16_t motion) {
  const MotionPair pair{base, motion};
  const auto number =
      static_cast<std::uint16_t>(std::find(pairs_.begin(), pairs_.end(), pair) - pairs_.begin());
  if (number == pairs_.size()) pairs_.push_back(pair);
  return number;
}

void SurfaceBounds::add_triangle(const std::array<std::size_t, 3>& corner, double area) {
  const std::array<Vertex, 3> vertex{vertex_of(corner[0]), vertex_of(corner[1]),
                                     vertex_of(corner[2])};
  const std::vector<std::uint16_t> motions = motions_of(vertex);
  if (motions.size() == 1) return;
  const std::uint16_t base = most_carrying(vertex);
  Triangle t{{}, static_cast<std::uint32_t>(triangle_term_.size()), 0, area};
  for (const Vertex& v : vertex)
    for (const Carried& c : v) t.middle += c.place / 3.0;
  const auto bound = [&](std::size_t k) { return glm::dvec3(character_.bind_position[corner[k]]); };
  const glm::dvec3 face = glm::normalize(glm::cross(bound(1) - bound(0), bound(2) - bound(0)));
  for (const std::uint16_t motion : motions) {
    TriangleTerm term{pair_of(base, motion), {}, {}, {}};
    Carried part[3];
    for (std::size_t k = 0; k < 3; ++k) {
      part[k] = {motion, 0.0, {}};
      for (const Carried& c : vertex[k])
        if (c.motion == motion) part[k] = c;
      term.facing[k] = part[k].face * face;
    }
    for (std::size_t e = 0; e < 2; ++e) {
      term.weight[e] = part[e + 1].weight - part[0].weight;
      term.edge[e] = part[e + 1].place - part[0].place - term.weight[e] * t.middle;
    }
    triangle_term_.push_back(term);
  }
  t.terms = static_cast<std::uint32_t>(triangle_term_.size()) - t.first_term;
  triangle_.push_back(t);
}

void SurfaceBounds::add_ring(const Slice& slice, double area) {
  Ring ring{{}, {}, {}, area};
  std::vector<Vertex> point;
  for (const SlicePoint& p : slice.ring) {
    const double share = p.share;
    Vertex& own = point.emplace_back();
    for (const auto& [v, part] : {std::pair{p.a, 1.0 - share}, std::pair{p.b, share}}) {
      for (Carried c : vertex_of(v)) {
        c.weight *= part;
        c.place *= part;
        own.push_back(c);
      }
    }
  }
  if (point.empty()) {
    ring_.push_back(std::move(ring));
    return;
  }
  const std::uint16_t base = most_carrying(point);
  std::vector<std::uint16_t> other = motions_of(point);
  std::erase(other, base);
  for (const std::uint16_t motion : other) ring.pair.push_back(pair_of(base, motion));
  for (const Vertex& v : point)
    for (const Carried& c : v) ring.middle += c.place / double(point.size());

  const std::size_t vectors = 3 + 4 * other.size();
  std::vector<std::vector<double>> part(point.size(), std::vector<double>(vectors, 0.0));
  for (std::size_t p = 0; p < point.size(); ++p) {
    for (const Carried& c : point[p]) {
      const glm::dvec3 place = c.place - c.weight * ring.middle;
      for (int i = 0; i < 3; ++i) part[p][std::size_t(i)] += place[i];
      if (c.motion == base) continue;
      double* own = &part[p][3 + 4 * std::size_t(std::find(other.begin(), other.end(), c.motion) -
                                                 other.begin())];
      for (int i = 0; i < 3; ++i) own[i] += place[i];
      own[3] += c.weight;
    }
  }
  for (std::size_t a = 0; a < vectors; ++a) {
    for (std::size_t b = a + 1; b < vectors; ++b) {
      double sum = 0.0;
      for (std::size_t p = 0; p < part.size(); ++p) {
        const std::size_t next = (p + 1) % part.size();
        sum += part[p][a] * part[next][b] - part[p][b] * part[next][a];
      }
      ring.product.push_back(0.5 * sum);
    }
  }
  ring_.push_back(std::move(ring));
}

std::vector<std::uint32_t> SurfaceBounds::triangles() const {
  std::vector<std::uint32_t> all(triangle_.size());
  for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
  return all;
}

std::vector<std::uint32_t> SurfaceBounds::slices() const {
  std::vector<std::uint32_t> all;
  for (std::uint32_t i = 0; i < ring_.size(); ++i)
    if (!ring_[i].product.empty()) all.push_back(i);
  return all;
}

bool SurfaceBounds::faces_as_it_should(const Triangle& t, const RelativeMotions& motions) const {
  IntervalVector edge[2], corner[3];
  for (std::uint32_t i = t.first_term; i < t.first_term + t.terms; ++i) {
    const TriangleTerm& term = triangle_term_[i];
    const IntervalVector middle = motions.shift(term.pair, t.middle);
    for (std::size_t e = 0; e < 2; ++e) {
      edge[e] = edge[e] + motions.turn(term.pair, term.edge[e]) + Interval(term.weight[e]) * middle;
    }
    for (std::size_t k = 0; k < 3; ++k)
      corner[k] = corner[k] + motions.turn(term.pair, term.facing[k]);
  }
  // Weights of a vertex sum to 1: what is left of the middle itself cancels.
  const IntervalVector face = cross(edge[0], edge[1]);
  Interval facing(0.0);
  for (const IntervalVector& c : corner) facing = facing + dot(face, c) / length(c);
  return facing.lo > 0.0;  // not finite: lower bound -infinity
}

double SurfaceBounds::keep_unproved(const RelativeMotions& motions,
                                    std::vector<std::uint32_t>& triangle) const {
  double left = 0.0;
  std::erase_if(triangle, [&](std::uint32_t i) {
    const bool proved = faces_as_it_should(triangle_[i], motions);
    if (!proved) left += triangle_[i].area;
    return proved;
  });
  return area_ > 0.0 ? left / area_ : 0.0;
}

double SurfaceBounds::least_area(const Ring& ring, const RelativeMotions& motions) const {
  std::vector<BoxVector> vector{glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)};
  for (const std::uint16_t pair : ring.pair) {
    for (std::size_t axis = 0; axis < 3; ++axis) vector.push_back(motions.excess(pair, axis));
    vector.push_back(motions.box_shift(pair, ring.middle));
  }
  BoxVector area;
  const double* product = ring.product.data();
  for (std::size_t a = 0; a < vector.size(); ++a) {
    // The sum over b first: one cross product for each a.
    BoxVector with;
    for (std::size_t b = a + 1; b < vector.size(); ++b)
      with = with + BoxReal(*product++) * vector[b];
    area = area + cross(vector[a], with);
  }
  return length(area).value.lo / ring.area;
}

SurfaceBounds::LeastArea SurfaceBounds::keep_small(const RelativeMotions& motions, double limit,
                                                   std::vector<std::uint32_t>& slice) const {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  LeastArea least{kNone, kNone};
  std::erase_if(slice, [&](std::uint32_t i) {
    const double bound = least_area(ring_[i], motions);
    double& own = bound >= limit ? least.taken_out : least.left_in;
    own = std::min(own, bound);
    return bound >= limit;
  });
  return least;
}

}  // namespace backbend::validate
