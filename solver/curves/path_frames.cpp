#include "solver/curves/path_frames.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "solver/math/rotation.h"

namespace backbend::solver {
namespace {

using glm::dvec3;

/// `v` carried from one place of a curve to another by two reflections: in the plane halfway
/// between the places, then in the one that makes the tangents meet.
dvec3 reflected_twice(const dvec3& v, const dvec3& from, const dvec3& tangent, const dvec3& to,
                      const dvec3& to_tangent) {
  const dvec3 step = to - from;
  const double size = glm::dot(step, step);
  if (!(size > 0.0)) return v;
  const dvec3 once = v - (2.0 / size) * glm::dot(step, v) * step;
  const dvec3 tangent_once = tangent - (2.0 / size) * glm::dot(step, tangent) * step;
  const dvec3 between = to_tangent - tangent_once;
  const double gap = glm::dot(between, between);
  if (!(gap > 0.0)) return once;
  return once - (2.0 / gap) * glm::dot(between, once) * between;
}

dvec3 made_perpendicular(const dvec3& v, const dvec3& tangent) {
  return glm::normalize(v - glm::dot(v, tangent) * tangent);
}

}  // namespace

PathFrames::PathFrames(const Curve& path, const dvec3& up) : path_(path) {
  constexpr int kPerPiece = 64;
  const std::size_t count = path_.pieces().size() * kPerPiece;
  Sample sample{0.0, path_.at_arc(0.0).position, path_.at_arc(0.0).tangent, dvec3(0.0)};
  const dvec3 along = glm::cross(sample.tangent, up);
  up_is_lost_ = !(glm::length(along) > 1e-6 * glm::length(up));
  sample.up =
      up_is_lost_ ? any_perpendicular(sample.tangent) : made_perpendicular(up, sample.tangent);
  sample_.push_back(sample);
  for (std::size_t i = 1; i <= count; ++i) {
    const Sample& before = sample_.back();
    const double arc = path_.length() * (double(i) / double(count));
    const CurvePoint place = path_.at_arc(arc);
    const dvec3 carried =
        reflected_twice(before.up, before.position, before.tangent, place.position, place.tangent);
    sample_.push_back(
        {arc, place.position, place.tangent, made_perpendicular(carried, place.tangent)});
  }
}

PathFrames::Place PathFrames::at(double fraction) const {
  const double arc = std::clamp(fraction, 0.0, 1.0) * path_.length();
  const auto after = std::upper_bound(sample_.begin(), sample_.end(), arc,
                                      [](double a, const Sample& s) { return a < s.arc; });
  const Sample& before = after == sample_.begin() ? *after : *(after - 1);
  const CurvePoint place = path_.at_arc(arc);
  const dvec3 carried =
      reflected_twice(before.up, before.position, before.tangent, place.position, place.tangent);
  const dvec3 up = made_perpendicular(carried, place.tangent);
  return {place.position, {glm::cross(up, place.tangent), up, place.tangent}};
}

}  // namespace backbend::solver
