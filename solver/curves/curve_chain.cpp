#include "solver/curves/curve_chain.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace backbend::solver {
namespace {

using glm::dvec3;

double null_arc(const Curve& curve, int i) {
  return curve.length() * (double(i) / double(kNullCount - 1));
}

/// Each bone turns to its goal; a goal fixes a direction, not a length.
void chase(const Curve& curve, std::span<const dvec3> goal, CurveChain& chain) {
  chain.joint[0] = goal[0];
  chain.aimless = false;
  dvec3 aim(0.0);
  for (std::size_t i = 0; i < chain.direction.size(); ++i) {
    const dvec3 to_goal = goal[i + 1] - chain.joint[i];
    const double distance = glm::length(to_goal);
    if (distance > 1e-12 * curve.length()) {
      aim = to_goal * (1.0 / distance);
    } else {
      chain.aimless = true;  // keeps the direction of the bone before it
      if (i == 0) aim = curve.tangent(0.0);
    }
    chain.direction[i] = aim;
    chain.joint[i + 1] = chain.joint[i] + chain.bone_length * aim;
  }
  chain.overrun = 0.0;
}

void walk(const Curve& curve, CurveChain& chain) {
  chain.joint[0] = curve.point(0.0);
  chain.aimless = false;
  double arc = 0.0;
  for (std::size_t i = 0; i < chain.direction.size(); ++i) {
    const Curve::Step step = curve.step_to_distance(chain.joint[i], arc, chain.bone_length);
    arc = step.arc;
    chain.joint[i + 1] = step.place.position;
    chain.direction[i] = glm::normalize(chain.joint[i + 1] - chain.joint[i]);
  }
  chain.overrun = arc - curve.length();  // below zero: the chain ends short of the curve
}

/// The bone length nearest to `guess` at which `miss`, rising with it there, is zero: brackets it
/// by growing steps, then secants within the bracket (Illinois rule).
template <class Miss>
bool close(double guess, double tolerance, CurveChain& chain, Miss miss) {
  const auto at = [&](double length) {
    chain.bone_length = length;
    return miss();
  };
  double end = guess, error = at(guess);
  if (std::abs(error) <= tolerance) return true;
  // A far bracket could hold another zero, with bones that double back. So from small steps up.
  double start = end, start_error = error;
  for (double step = 1e-4; (start_error > 0.0) == (error > 0.0); step *= 2.0) {
    if (step > 1.0) return false;
    start = end, start_error = error;
    end = guess * (error > 0.0 ? 1.0 - 0.999 * step : 1.0 + step);
    error = at(end);
  }
  for (int i = 0; i < 100; ++i) {
    if (std::abs(error) <= tolerance) return true;
    const double next = (start * error - end * start_error) / (error - start_error);
    if (next == start || next == end) break;
    const double next_error = at(next);
    if ((next_error > 0.0) != (error > 0.0)) {
      start = end, start_error = error;
    } else {
      start_error *= 0.5;
    }
    end = next, error = next_error;
  }
  return false;
}

}  // namespace

double length_by_first_null(const Curve& curve) {
  const dvec3 second = curve.at_arc(null_arc(curve, 1)).position;
  return glm::length(second - curve.pieces().front().cv[0]) * (kNullCount - 1);
}

double length_by_null_sum(const Curve& curve) {
  std::array<double, kNullCount> arc;
  std::array<dvec3, kNullCount> null;
  for (int i = 0; i < kNullCount; ++i) arc[std::size_t(i)] = null_arc(curve, i);
  curve.points_at_arcs(arc, null);
  double sum = 0.0;
  for (std::size_t i = 1; i < null.size(); ++i) sum += glm::length(null[i] - null[i - 1]);
  return sum;
}

void lay_chain(const Curve& curve, std::size_t bones, Follow follow, BoneLength rule,
               double rest_length, CurveChain& chain) {
  chain.joint.resize(bones + 1);
  chain.direction.resize(bones);
  chain.unclosed = false;

  // The goals of a chasing chain and the first length null, found together.
  std::array<double, kMostBones + 2> arc;
  std::array<dvec3, kMostBones + 2> goal;
  std::size_t places = 0;
  if (follow == Follow::chase) {
    for (; places <= bones; ++places)
      arc[places] = curve.length() * (double(places) / double(bones));
  }
  if (rule == BoneLength::nulls) arc[places++] = null_arc(curve, 1);
  curve.points_at_arcs(std::span(arc).first(places), std::span(goal).first(places));

  const auto lay = [&] {
    follow == Follow::chase ? chase(curve, std::span(goal).first(bones + 1), chain)
                            : walk(curve, chain);
  };
  const double even = curve.length() / double(bones);
  switch (rule) {
    case BoneLength::nulls:
      chain.bone_length = glm::length(goal[places - 1] - curve.pieces().front().cv[0]) *
                          (kNullCount - 1) / double(bones);
      break;
    case BoneLength::rest:
      chain.bone_length = rest_length / double(bones);
      break;
    case BoneLength::null_sum:
      chain.bone_length = length_by_null_sum(curve) / double(bones);
      break;
    case BoneLength::arc:
      chain.bone_length = even;
      break;
    case BoneLength::close: {
      const dvec3 tip = curve.point(1.0);
      chain.unclosed = !close(even, 1e-11 * curve.length(), chain, [&] {
        lay();
        // A chasing chain meets the tip when its last goal is one bone away; a walking one when its
        // last joint has gone the curve's whole length.
        return follow == Follow::chase
                   ? chain.bone_length - glm::length(tip - chain.joint[bones - 1])
                   : chain.overrun;
      });
      break;
    }
  }
  lay();
}

}  // namespace backbend::solver
