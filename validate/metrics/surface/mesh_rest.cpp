#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "validate/metrics/surface/mesh_blocks.h"

namespace backbend::validate {
namespace {

/// A triangle of the character on its way into a block.
struct Triangle {
  glm::uvec3 vertex;
  float inverse[3], area, s;
  glm::vec3 offset;
  glm::vec3 face;  // twice its area, along its normal
  glm::vec3 bound_normal;
  std::uint32_t slice;
  int part;  // that all its corners belong to; -1: none
  bool on_spine;
  bool bends;  // or stands beside what bends
};

/// Edges with the triangle they belong to, sorted so that the two sides of one stand together.
struct HalfEdge {
  std::uint32_t low, high;  // places
  bool forward;             // the triangle runs from low to high
  std::uint32_t triangle;   // into MeshRest::triangle
};

std::vector<HalfEdge> half_edges(const std::vector<Triangle>& triangle,
                                 std::span<const std::uint32_t> place) {
  std::vector<HalfEdge> out;
  out.reserve(triangle.size() * 3);
  for (std::uint32_t t = 0; t < triangle.size(); ++t)
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t a = place[triangle[t].vertex[i]];
      const std::uint32_t b = place[triangle[t].vertex[(i + 1) % 3]];
      if (a != b) out.push_back({std::min(a, b), std::max(a, b), a < b, t});
    }
  std::ranges::sort(out, [](const HalfEdge& x, const HalfEdge& y) {
    return std::tie(x.low, x.high, x.triangle, x.forward) <
           std::tie(y.low, y.high, y.triangle, y.forward);
  });
  return out;
}

/// An edge on its way into a block. Triangles by number.
struct Edge {
  std::uint32_t first, second;
  MeshRest::EdgeEnds end;
  Fold fold;
  bool bends;  // not between two triangles of one part
};

/// The edges between two triangles; sets why the mesh is open, if it is.
std::vector<Edge> edges_of(const std::vector<Triangle>& triangle, const RestMesh& mesh,
                           std::string& open_reason) {
  std::vector<std::uint32_t> vertex_of_place(mesh.place_count, 0);
  for (std::size_t v = mesh.position.size(); v-- > 0;)
    vertex_of_place[mesh.place[v]] = static_cast<std::uint32_t>(v);
  const std::vector<HalfEdge> half = half_edges(triangle, mesh.place);
  std::vector<Edge> out;
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
        Edge edge{half[i].triangle,
                  half[i + 1].triangle,
                  {vertex_of_place[half[i].forward ? half[i].low : half[i].high],
                   vertex_of_place[half[i].forward ? half[i].high : half[i].low],
                   static_cast<std::uint32_t>(out.size())},
                  {},
                  true};
        edge.fold = fold(triangle[edge.first].face, triangle[edge.second].face,
                         mesh.position[edge.end.b] - mesh.position[edge.end.a]);
        out.push_back(edge);
      }
    }
    i = end;
  }
  if (open > 0)
    open_reason = std::to_string(open) + " open edges: the mesh encloses no volume";
  else if (crowded > 0)
    open_reason = std::to_string(crowded) + " edges of three triangles or more";
  else if (turned > 0)
    open_reason = std::to_string(turned) + " edges whose triangles face opposite ways";
  return out;
}

/// Tells apart what bends. The triangles of an edge that bends are measured with it.
void find_bending(std::vector<Triangle>& triangle, std::vector<Edge>& edge) {
  for (Triangle& t : triangle) t.bends = t.on_spine || t.part < 0;
  for (Edge& e : edge) {
    Triangle &first = triangle[e.first], &second = triangle[e.second];
    e.bends = first.part < 0 || first.part != second.part;
    if (e.bends) first.bends = second.bends = true;
  }
}

/// The joints that move a block's triangles.
void fill_carriers(const std::vector<Triangle>& triangle, const MeshBinding& binding,
                   MeshRest::Block& block, MeshRest& rest) {
  std::map<std::uint32_t, MeshRest::Carrier> carriers;
  for (std::uint32_t lane = 0; lane < MeshRest::kLanes; ++lane) {
    const Triangle& t = triangle[block.number[lane]];
    for (int axis = 0; axis < 3; ++axis) block.normal[axis][lane] = t.bound_normal[axis];
    for (int k = 0; k < 3; ++k) {
      const skin::Influences& influences = binding.influences[t.vertex[k]];
      for (int i = 0; i < skin::kMaxInfluences; ++i) {
        if (!(influences.weight[i] > 0.0f)) continue;
        MeshRest::Carrier& carrier = carriers[influences.joint[i]];
        carrier.joint = influences.joint[i];
        carrier.weight[k][lane] += influences.weight[i];
      }
    }
  }
  block.first_carrier = static_cast<std::uint32_t>(rest.carrier.size());
  block.carriers = static_cast<std::uint32_t>(carriers.size());
  for (const auto& [joint, carrier] : carriers) rest.carrier.push_back(carrier);
}

/// Which of a block's triangles face as they should at rest.
std::uint32_t upright_of(const std::vector<Triangle>& triangle, const RestMesh& mesh,
                         const MeshRest& rest, const MeshRest::Block& block,
                         std::span<const glm::mat3> joint) {
  float facing[3][MeshRest::kLanes];
  if (!joint.empty()) {
    const VectorLanes turned = turned_faces(rest, block, joint);
    turned.x.store(facing[0]);
    turned.y.store(facing[1]);
    turned.z.store(facing[2]);
  }
  std::uint32_t out = 0;
  for (std::uint32_t lane = 0; lane < MeshRest::kLanes; ++lane) {
    const Triangle& t = triangle[block.number[lane]];
    const glm::vec3 should =
        joint.empty() ? mesh.normal[t.vertex.x] + mesh.normal[t.vertex.y] + mesh.normal[t.vertex.z]
                      : glm::vec3(facing[0][lane], facing[1][lane], facing[2][lane]);
    if (!(glm::dot(t.face, should) < 0.0f)) out |= 1u << lane;
  }
  return out & block.present;
}

/// Into blocks: those on the spine slice by slice, then others, those that do not bend last.
/// Returns the slot of each.
std::vector<std::uint32_t> fill_blocks(const std::vector<Triangle>& triangle, const RestMesh& mesh,
                                       const MeshBinding* binding, MeshRest& rest) {
  const std::vector<glm::mat3> joint =
      binding ? face_turns(binding->rest) : std::vector<glm::mat3>{};
  std::vector<std::uint32_t> order;
  for (std::uint32_t t = 0; t < triangle.size(); ++t) order.push_back(t);
  const auto group = [&](std::uint32_t t) {
    const auto beyond = static_cast<std::uint32_t>(rest.slice_count);
    return triangle[t].on_spine ? triangle[t].slice : triangle[t].bends ? beyond : beyond + 1;
  };
  std::ranges::stable_sort(order, {}, group);

  constexpr std::uint32_t kLanes = MeshRest::kLanes;
  std::vector<std::uint32_t> slot(triangle.size());
  for (std::size_t i = 0; i < order.size();) {
    const std::uint32_t here = group(order[i]);
    std::uint32_t count = 1;
    while (count < kLanes && i + count < order.size() && group(order[i + count]) == here) ++count;
    MeshRest::Block block{};
    MeshRest::Torso torso{};
    torso.slice = here;
    for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
      const std::uint32_t n = order[i + std::min(lane, count - 1)];
      const Triangle& t = triangle[n];
      for (int k = 0; k < 3; ++k) {
        block.corner[k][lane] = t.vertex[k];
        block.inverse[k][lane] = t.inverse[k];
        torso.offset[k][lane] = t.offset[k];
      }
      torso.s[lane] = t.s;
      block.number[lane] = n;
      if (lane < count) {
        slot[n] = static_cast<std::uint32_t>(rest.block.size()) * kLanes + lane;
        block.present |= 1u << lane;
      }
      rest.slot_area.push_back(lane < count ? t.area : 0.0f);
    }
    if (binding) fill_carriers(triangle, *binding, block, rest);
    block.upright = upright_of(triangle, mesh, rest, block, joint);
    rest.block.push_back(block);
    if (here < rest.slice_count) rest.torso.push_back(torso);
    if (here <= rest.slice_count) rest.bending_blocks = rest.block.size();
    i += count;
  }
  return slot;
}

void append_edges(std::span<const Edge> edge, MeshRest& rest) {
  constexpr std::size_t kLanes = MeshRest::kLanes;
  for (std::size_t i = 0; i < edge.size(); i += kLanes) {
    MeshRest::EdgeBlock block{};
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const Edge& e = edge[std::min(i + lane, edge.size() - 1)];
      block.first[lane] = e.first;
      block.second[lane] = e.second;
      block.cosine[lane] = e.fold.cosine;
      block.sine[lane] = e.fold.sine;
      rest.end.push_back(e.end);
    }
    rest.edge.push_back(block);
  }
}

void fill_edges(std::vector<Edge> edge, const std::vector<std::uint32_t>& slot, MeshRest& rest) {
  for (Edge& e : edge) {
    e.first = slot[e.first];
    e.second = slot[e.second];
  }
  // Beside each other where their triangles are; the figures do not depend on it.
  std::ranges::sort(edge, [](const Edge& a, const Edge& b) {
    return std::tie(a.first, a.second, a.end.number) < std::tie(b.first, b.second, b.end.number);
  });
  const auto bending = std::ranges::stable_partition(edge, &Edge::bends);
  const auto still = static_cast<std::size_t>(bending.size());
  const std::span all(edge);
  append_edges(all.first(all.size() - still), rest);
  rest.bending_edges = rest.edge.size();
  append_edges(all.last(still), rest);
}

/// What is left out where parts are rigid, part by part.
void find_pieces(const std::vector<Triangle>& triangle, const std::vector<Edge>& edge,
                 const RestMesh& mesh, MeshRest& rest) {
  std::vector<std::uint32_t> order;
  for (std::uint32_t t = 0; t < triangle.size(); ++t)
    if (!triangle[t].bends) order.push_back(t);
  std::ranges::stable_sort(order, {}, [&](std::uint32_t t) { return triangle[t].part; });
  std::vector<std::size_t> piece_of_part;
  for (const std::uint32_t t : order) {
    const glm::uvec3& corner = triangle[t].vertex;
    const auto part = static_cast<std::size_t>(triangle[t].part);
    if (part >= piece_of_part.size()) {
      piece_of_part.resize(part + 1);
      piece_of_part[part] = rest.piece.size();
      rest.piece.push_back({0.0, corner.x, 0, 0});
    }
    MeshRest::Piece& piece = rest.piece.back();
    const glm::dvec3 tip(mesh.position[piece.tip]);
    const auto from_tip = [&](int k) { return glm::dvec3(mesh.position[corner[k]]) - tip; };
    piece.volume += glm::dot(from_tip(0), glm::cross(from_tip(1), from_tip(2))) / 6.0;
  }
  std::vector<std::vector<MeshRest::RimEdge>> rim(rest.piece.size());
  for (const Edge& e : edge) {
    if (triangle[e.first].bends == triangle[e.second].bends) continue;
    const Triangle& own = triangle[triangle[e.first].bends ? e.second : e.first];
    for (int k = 0; k < 3; ++k) {  // its own vertices: others may stand at their places, too
      const std::uint32_t a = own.vertex[k], b = own.vertex[(k + 1) % 3];
      if (std::minmax(mesh.place[a], mesh.place[b]) ==
          std::minmax(mesh.place[e.end.a], mesh.place[e.end.b]))
        rim[piece_of_part[static_cast<std::size_t>(own.part)]].push_back({a, b});
    }
  }
  for (std::size_t i = 0; i < rim.size(); ++i) {
    rest.piece[i].first_rim = rest.rim.size();
    rest.piece[i].rim_count = rim[i].size();
    rest.rim.insert(rest.rim.end(), rim[i].begin(), rim[i].end());
  }
}

/// Numbers the corners of blocks and edges, which were vertices until now.
void number_corners(MeshRest& rest) {
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> corner(rest.vertex_count, kNone);
  const auto renumber = [&](std::uint32_t& vertex) {
    if (corner[vertex] == kNone) {
      corner[vertex] = static_cast<std::uint32_t>(rest.vertex.size());
      rest.vertex.push_back(vertex);
    }
    vertex = corner[vertex];
  };
  const auto renumber_blocks = [&](std::span<MeshRest::Block> blocks) {
    for (MeshRest::Block& block : blocks)
      for (std::uint32_t lane = 0; lane < MeshRest::kLanes; ++lane)
        for (auto& lanes : block.corner) renumber(lanes[lane]);
  };
  const auto renumber_ends = [&](auto edges) {
    for (auto& edge : edges) {
      renumber(edge.a);
      renumber(edge.b);
    }
  };
  const std::size_t ends = rest.bending_edges * MeshRest::kLanes;
  renumber_blocks(std::span(rest.block).first(rest.bending_blocks));
  renumber_ends(std::span(rest.end).first(ends));
  renumber_ends(std::span(rest.rim));
  for (MeshRest::Piece& piece : rest.piece) renumber(piece.tip);
  rest.bending_corners = rest.vertex.size();
  renumber_blocks(std::span(rest.block).subspan(rest.bending_blocks));
  renumber_ends(std::span(rest.end).subspan(ends));
}

double rest_volume(const MeshRest& rest, std::span<const glm::vec3> position) {
  VolumeSum sum(rest.middle);
  for (const MeshRest::Block& block : rest.block) {
    BlockCorners corners;
    for (int k = 0; k < 3; ++k) {
      float axis[3][MeshRest::kLanes];
      for (std::uint32_t lane = 0; lane < MeshRest::kLanes; ++lane)
        for (int i = 0; i < 3; ++i) axis[i][lane] = position[rest.vertex[block.corner[k][lane]]][i];
      corners.p[k] = {FloatLanes::load(axis[0]), FloatLanes::load(axis[1]),
                      FloatLanes::load(axis[2])};
    }
    sum.add(corners, block.present);
  }
  return sum.volume();
}

}  // namespace

std::vector<glm::mat3> face_turns(const skin::JointMatrices& joints) {
  std::vector<glm::mat3> out;
  out.reserve(joints.joint.size());
  for (const skin::JointMatrix& joint : joints.joint) {
    glm::mat3 point, normal;
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) {
        point[c][r] = joint.point[c][r];
        normal[c][r] = joint.normal[c][r];
      }
    out.push_back(glm::determinant(point) < 0.0f ? -normal : normal);
  }
  return out;
}

MeshRest prepare_mesh(const RestMesh& mesh, const SpineLine& line,
                      std::span<const float> coordinate, const SpineSlices& slices,
                      std::span<const int> part, const MeshBinding* binding) {
  assert(!slices.slice.empty());
  MeshRest rest;
  rest.vertex_count = mesh.position.size();
  rest.slice_count = slices.slice.size();
  rest.slice_spacing = slices.spacing;
  for (const glm::vec3& p : mesh.position) rest.middle += glm::dvec3(p);
  if (!mesh.position.empty()) rest.middle /= static_cast<double>(mesh.position.size());
  const auto nearest_slice = [&](float s) {
    const int last = static_cast<int>(rest.slice_count) - 1;
    const double first = slices.slice.front().s;
    return slices.spacing > 0.0
               ? std::clamp(static_cast<int>(std::lround((s - first) / slices.spacing)), 0, last)
               : 0;
  };

  // Where slices go on beyond the chest, so does what is judged with them.
  const float highest = std::max(1.0f, static_cast<float>(slices.slice.back().s));
  std::vector<Triangle> triangle;
  for (const glm::uvec3& corner : mesh.triangle) {
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
    Triangle t{};
    t.vertex = corner;
    t.inverse[0] = static_cast<float>(1.0 / a);
    t.inverse[1] = static_cast<float>(-b / (a * c));
    t.inverse[2] = static_cast<float>(1.0 / c);
    t.area = static_cast<float>(0.5 * double_area);
    t.part = part.empty() || part[corner.x] != part[corner.y] || part[corner.y] != part[corner.z]
                 ? -1
                 : part[corner.x];
    t.face = glm::cross(mesh.position[corner.y] - mesh.position[corner.x],
                        mesh.position[corner.z] - mesh.position[corner.x]);
    if (binding) {
      const auto at = [&](std::uint32_t v) { return binding->bind_position[v]; };
      const glm::vec3 bound = glm::cross(at(corner.y) - at(corner.x), at(corner.z) - at(corner.x));
      t.bound_normal = bound / std::max(glm::length(bound), std::numeric_limits<float>::min());
    }
    if (mesh.torso[corner.x] && mesh.torso[corner.y] && mesh.torso[corner.z]) {
      t.s = (coordinate[mesh.place[corner.x]] + coordinate[mesh.place[corner.y]] +
             coordinate[mesh.place[corner.z]]) /
            3.0f;
      t.offset = glm::vec3(p + (e1 + e2) / 3.0 - line.point(t.s));
      t.on_spine = t.s >= 0.0f && t.s <= highest;
      if (t.on_spine) t.slice = static_cast<std::uint32_t>(nearest_slice(t.s));
    }
    rest.area += t.area;
    if (t.on_spine) rest.torso_area += t.area;
    triangle.push_back(t);
  }
  rest.triangles = triangle.size();
  std::vector<Edge> edge = edges_of(triangle, mesh, rest.open_reason);
  find_bending(triangle, edge);
  if (rest.open_reason.empty()) find_pieces(triangle, edge, mesh, rest);
  const std::vector<std::uint32_t> slot = fill_blocks(triangle, mesh, binding, rest);
  fill_edges(std::move(edge), slot, rest);
  number_corners(rest);
  rest.volume = rest_volume(rest, mesh.position);
  // A sheet that is closed by its own back has no inside.
  if (rest.open_reason.empty() && !(std::abs(rest.volume) > 1e-6 * std::pow(rest.area, 1.5)))
    rest.open_reason = "the closed mesh encloses no volume";
  if (triangle.empty()) rest.open_reason = "no triangle with an area";
  return rest;
}

}  // namespace backbend::validate
