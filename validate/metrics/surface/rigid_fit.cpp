#include "validate/metrics/surface/rigid_fit.h"

#include <array>
#include <cassert>
#include <cmath>
#include <glm/matrix.hpp>

#include "validate/metrics/math/nan.h"

namespace backbend::validate {
namespace {

using Matrix4 = std::array<std::array<double, 4>, 4>;

/// The eigenvector of a symmetric matrix with the largest eigenvalue, by Jacobi's rotations.
std::array<double, 4> largest_eigenvector(Matrix4 a) {
  Matrix4 v{};
  for (std::size_t i = 0; i < 4; ++i) v[i][i] = 1.0;
  constexpr int kSweeps = 50;  // it converges in fewer than ten
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double off = 0.0, size = 0.0;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < 4; ++j) (i == j ? size : off) += a[i][j] * a[i][j];
    if (!(off > 1e-30 * size)) break;
    for (std::size_t p = 0; p < 4; ++p)
      for (std::size_t q = p + 1; q < 4; ++q) {
        if (a[p][q] == 0.0) continue;
        const double theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
        const double t =
            (theta >= 0.0 ? 1.0 : -1.0) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
        const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
        for (std::size_t k = 0; k < 4; ++k) {
          const double x = a[k][p], y = a[k][q];
          a[k][p] = c * x - s * y;
          a[k][q] = s * x + c * y;
        }
        for (std::size_t k = 0; k < 4; ++k) {
          const double x = a[p][k], y = a[q][k];
          a[p][k] = c * x - s * y;
          a[q][k] = s * x + c * y;
          const double vx = v[k][p], vy = v[k][q];
          v[k][p] = c * vx - s * vy;
          v[k][q] = s * vx + c * vy;
        }
      }
  }
  std::size_t best = 0;
  for (std::size_t i = 1; i < 4; ++i)
    if (a[i][i] > a[best][best]) best = i;
  return {v[0][best], v[1][best], v[2][best], v[3][best]};
}

}  // namespace

glm::dquat nearest_rotation(const glm::dmat3& map) {
  glm::dmat3 r = map;
  if (!(glm::determinant(r) > 0.0)) return glm::dquat(kNan, kNan, kNan, kNan);
  constexpr int kSteps = 100;  // quadratic; what needs more has collapsed
  for (int step = 0; step < kSteps; ++step) {
    const glm::dmat3 next = 0.5 * (r + glm::transpose(glm::inverse(r)));
    double change = 0.0;
    for (int c = 0; c < 3; ++c) change += glm::dot(next[c] - r[c], next[c] - r[c]);
    r = next;
    if (!(change > 1e-30)) break;
  }
  return glm::normalize(glm::quat_cast(r));
}

solver::RigidMotion fit_rigid(std::span<const glm::dvec3> rest, std::span<const glm::dvec3> posed,
                              std::span<const double> weight) {
  assert(rest.size() == posed.size() && rest.size() == weight.size());
  solver::RigidMotion out;
  double sum = 0.0;
  glm::dvec3 from(0.0), to(0.0);
  for (std::size_t i = 0; i < rest.size(); ++i) {
    sum += weight[i];
    from += weight[i] * rest[i];
    to += weight[i] * posed[i];
  }
  out.rest_origin = from / sum;
  out.posed_origin = to / sum;
  glm::dmat3 h(0.0);  // h[r][c] = sum of weight rest_c posed_r
  for (std::size_t i = 0; i < rest.size(); ++i)
    h += weight[i] * glm::outerProduct(rest[i] - out.rest_origin, posed[i] - out.posed_origin);
  const auto s = [&](int a, int b) { return h[b][a]; };  // rest a against posed b
  const Matrix4 k = {
      {{s(0, 0) + s(1, 1) + s(2, 2), s(1, 2) - s(2, 1), s(2, 0) - s(0, 2), s(0, 1) - s(1, 0)},
       {s(1, 2) - s(2, 1), s(0, 0) - s(1, 1) - s(2, 2), s(0, 1) + s(1, 0), s(2, 0) + s(0, 2)},
       {s(2, 0) - s(0, 2), s(0, 1) + s(1, 0), -s(0, 0) + s(1, 1) - s(2, 2), s(1, 2) + s(2, 1)},
       {s(0, 1) - s(1, 0), s(2, 0) + s(0, 2), s(1, 2) + s(2, 1), -s(0, 0) - s(1, 1) + s(2, 2)}}};
  const auto q = largest_eigenvector(k);
  out.turn = glm::normalize(glm::dquat(q[0], q[1], q[2], q[3]));
  return out;
}

}  // namespace backbend::validate
