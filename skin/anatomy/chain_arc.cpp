#include "skin/anatomy/chain_arc.h"

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

namespace backbend::skin {

double arc_length(std::span<const glm::dvec3> chain) {
  double length = 0.0;
  for (std::size_t k = 1; k < chain.size(); ++k) length += glm::distance(chain[k - 1], chain[k]);
  return length;
}

double nearest_arc(std::span<const glm::dvec3> chain, const glm::dvec3& point) {
  double best = std::numeric_limits<double>::infinity(), best_arc = 0.0, arc = 0.0;
  for (std::size_t k = 1; k < chain.size(); ++k) {
    const glm::dvec3 bone = chain[k] - chain[k - 1];
    const double square = glm::dot(bone, bone);
    const double t =
        square > 0.0 ? glm::clamp(glm::dot(point - chain[k - 1], bone) / square, 0.0, 1.0) : 0.0;
    const double distance = glm::distance(point, chain[k - 1] + t * bone);
    if (distance < best) {
      best = distance;
      best_arc = arc + t * std::sqrt(square);
    }
    arc += std::sqrt(square);
  }
  return best_arc;
}

glm::dvec3 point_at(std::span<const glm::dvec3> chain, double fraction) {
  double left = fraction * arc_length(chain);
  for (std::size_t k = 1; k < chain.size(); ++k) {
    const double bone = glm::distance(chain[k - 1], chain[k]);
    if (left <= bone && bone > 0.0) return glm::mix(chain[k - 1], chain[k], left / bone);
    left -= bone;
  }
  return chain.back();
}

}  // namespace backbend::skin
