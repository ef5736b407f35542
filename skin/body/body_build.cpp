#include "skin/body/body_build.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>

#include "skin/body/body_grid.h"
#include "skin/body/body_remesh.h"
#include "skin/body/body_shape.h"
#include "skin/body/body_subdivide.h"
#include "skin/body/body_weights.h"

namespace backbend::skin {
namespace {

// Above this many vertices a coarser mesh is remeshed and cut in four: as even, and much faster.
constexpr int kRemeshLimit = 60000;

std::string place_text(const glm::dvec3& p) {
  const auto thousandths = [](double v) {
    const long n = std::lround(v * 1000.0), rest = std::abs(n % 1000);
    return std::string(n < 0 ? "-" : "") + std::to_string(std::abs(n / 1000)) + "." +
           (rest < 100 ? "0" : "") + (rest < 10 ? "0" : "") + std::to_string(rest);
  };
  return thousandths(p.x) + ", " + thousandths(p.y) + ", " + thousandths(p.z);
}

/// Throws where the half body, mirrored, is not one closed surface without tunnels.
void check_closed(const BodyDescription& body, const HalfMesh& half) {
  std::vector<std::array<int, 2>> sides;
  for (const auto& t : half.triangle) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
      sides.push_back({low, high});
    }
  }
  std::sort(sides.begin(), sides.end());
  long edges = 0, vertices = 0;
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i;
    while (end < sides.size() && sides[end] == sides[i]) ++end;
    const bool border = half.on_plane(sides[i][0]) && half.on_plane(sides[i][1]);
    if (end - i != (border ? 1u : 2u)) {
      throw CharacterError(body.file_name + ": the surface is open or meets itself near (" +
                           place_text(half.position[static_cast<std::size_t>(sides[i][0])]) +
                           "); a smaller `cell` or parts further apart help");
    }
    edges += border ? 1 : 2;
    i = end;
  }
  for (const glm::dvec3& p : half.position) vertices += p.x == 0.0 ? 1 : 2;
  long euler = vertices - edges + 2 * static_cast<long>(half.triangle.size());
  if (!body.symmetric) euler /= 2;  // nothing was mirrored
  if (euler != 2 && !body.tunnels) {
    throw CharacterError(body.file_name + ": the surface has tunnels (Euler characteristic " +
                         std::to_string(euler) + ", 2 expected): parts touch that should melt " +
                         "together or stand further apart than two cells");
  }
}

glm::dvec3 seed_of(const BodyDescription& body) {
  if (body.core >= 0) return body.joints[static_cast<std::size_t>(body.core)].at;
  for (const BodyJoint& joint : body.joints) {
    if (joint.parent < 0) return joint.at;
  }
  return glm::dvec3(0.0);
}

}  // namespace

SkinnedHalf build_half(const BodyDescription& body, const BodyOptions& options) {
  const int wanted = options.vertices > 0 ? options.vertices : body.vertices;
  int cuts = 0, base = wanted;
  while (base > kRemeshLimit) base /= 4, ++cuts;

  const BodyShape shape(body);
  SkinnedHalf out;
  options.poll();
  out.mesh = grid_surface(shape, seed_of(body), body.cell);
  options.poll();
  const EdgeSizes sizes(out.mesh, shape, body.cell, body.finest, body.coarsest,
                        body.symmetric ? 0.5 * base : base);
  remesh(out.mesh, shape, sizes, 7, options.poll);
  check_closed(body, out.mesh);
  out.weights = body_weights(out.mesh, shape, body, options.poll);
  for (int i = 0; i < cuts; ++i) {
    options.poll();
    const HalfMesh coarse = out.mesh;
    std::vector<std::array<int, 2>> edge_of;
    subdivide(out.mesh, shape, edge_of);
    mend(out.mesh, shape);
    out.weights = subdivide_weights(coarse, out.weights, edge_of, body);
  }
  for (Influences& w : out.weights) w = four_largest(w);
  out.normal.resize(out.mesh.position.size());
  tbb::parallel_for(std::size_t{0}, out.normal.size(), [&](std::size_t v) {
    glm::dvec3 n = shape.gradient(out.mesh.position[v]);
    if (out.mesh.position[v].x == 0.0) n.x = 0.0;
    out.normal[v] = glm::normalize(n);
  });
  return out;
}

}  // namespace backbend::skin
