#include "tests/battery/pose_faults.h"

#include <algorithm>
#include <cmath>
#include <glm/trigonometric.hpp>

#include "tests/validate/spoiled_rig.h"
#include "validate/calibrate/faults.h"
#include "validate/metrics/math/rotation.h"

namespace backbend::battery {
namespace {

using Index = std::size_t;
using validate::Draw;
using Point = std::vector<double>;

constexpr Index kAxes = 3;

/// What is bent, rolled or turned, where, and which check says so.
void draw_what(PoseFault& fault, Index joints, Draw& draw) {
  const char* codes[] = {"BB010", "BB014", "BB020"};
  fault.code = codes[draw.index(3)];
  fault.joint = 2 + draw.index(joints - 4);
  fault.axis = draw.direction();
}

double bell(double distance, double half_width) {
  return std::exp2(-(distance * distance) / (half_width * half_width));
}

/// The distance of a point from the stretch of `half` to both sides of `middle`.
double distance_from(std::span<const double> at, const Point& middle, const glm::dvec3& along,
                     double half) {
  const glm::dvec3 d(at[0] - middle[0], at[1] - middle[1], at[2] - middle[2]);
  const double t = std::clamp(glm::dot(d, along), -half, half);
  return glm::length(d - t * along);
}

/// A fault around a stretch, or around a point where `half` is 0, whose region has radius `r`.
void shape(PoseFault& fault, const Point& middle, const glm::dvec3& along, double half, double r,
           double half_width, Draw& draw) {
  fault.half_width = half_width;
  fault.level = bell(r, half_width);
  fault.top = middle;
  fault.strength = [=](std::span<const double> at) {
    return bell(distance_from(at, middle, along, half), half_width);
  };
  const glm::dvec3 other = draw.direction();
  const glm::dvec3 across = glm::normalize(glm::cross(along, other));
  for (Index a = 0; a < kAxes; ++a) {
    const auto i = static_cast<glm::length_t>(a);
    fault.edge.push_back(middle[a] + r * across[i]);
    const double reach = half * std::abs(along[i]) + 1.6 * r;
    fault.low.push_back(std::max(0.0, middle[a] - reach));
    fault.high.push_back(std::min(1.0, middle[a] + reach));
  }
}

}  // namespace

PoseFault draw_corner_flip(Index axes, double share, Index joints, Draw& draw) {
  PoseFault fault;
  fault.kind = "corner flip";
  fault.code = "BB001";
  fault.share = share;
  fault.joint = 1 + draw.index(joints - 2);
  fault.axis = draw.direction();
  fault.amount = glm::radians(draw.uniform(25.0, 180.0));
  Point corner, slant;
  double product = 1.0, factorial = 1.0;
  for (Index a = 0; a < axes; ++a) {
    corner.push_back(draw.coin() ? 1.0 : 0.0);
    slant.push_back(draw.uniform(0.4, 1.0));
    product *= slant.back();
    factorial *= static_cast<double>(a + 1);
  }
  // Volume of the simplex that the plane cuts off: depth^n / (n! product of slants).
  const double depth = std::pow(share * factorial * product, 1.0 / static_cast<double>(axes));
  fault.top = fault.edge = corner;
  for (Index a = 0; a < axes; ++a) {
    const double reach = depth / slant[a];
    fault.low.push_back(corner[a] == 0.0 ? 0.0 : 1.0 - reach);
    fault.high.push_back(corner[a] == 0.0 ? reach : 1.0);
  }
  fault.strength = [=](std::span<const double> at) {
    double sum = 0.0;
    for (Index a = 0; a < at.size(); ++a) sum += slant[a] * std::abs(at[a] - corner[a]);
    return sum < depth ? 1.0 : 0.0;
  };
  return fault;
}

PoseFault draw_bump(double share, double half_width, Index joints, Draw& draw) {
  PoseFault fault;
  fault.kind = "bump";
  fault.share = share;
  draw_what(fault, joints, draw);
  const double r = std::cbrt(share / (4.0 / 3.0 * validate::kPi));
  Point middle;
  for (Index a = 0; a < kAxes; ++a) middle.push_back(draw.uniform(r, 1.0 - r));
  shape(fault, middle, draw.direction(), 0.0, r, half_width, draw);
  return fault;
}

PoseFault draw_ridge(double share, double half_width, Index joints, Draw& draw) {
  PoseFault fault;
  fault.kind = "ridge";
  fault.share = share;
  draw_what(fault, joints, draw);
  const double half = draw.uniform(0.1, 0.3);
  // A cylinder with two half balls at its ends.
  const auto volume = [&](double r) {
    return validate::kPi * r * r * (2.0 * half + 4.0 / 3.0 * r);
  };
  double low = 0.0, high = 0.2;
  for (int i = 0; i < 60; ++i) {
    const double r = 0.5 * (low + high);
    (volume(r) < share ? low : high) = r;
  }
  const glm::dvec3 along = draw.direction();
  Point middle;
  for (Index a = 0; a < kAxes; ++a) {
    const double reach = half * std::abs(along[static_cast<glm::length_t>(a)]) + high;
    middle.push_back(draw.uniform(reach, 1.0 - reach));
  }
  shape(fault, middle, along, half, high, half_width, draw);
  return fault;
}

std::unique_ptr<solver::SpineSystem> with_fault(std::unique_ptr<solver::SpineSystem> sound,
                                                const validate::ControlBox& box,
                                                const PoseFault& fault) {
  const auto channel = [&](const char* name) {
    Index i = 0;
    while (sound->channels().at(i).name != name) ++i;
    return i;
  };
  const Index rx = channel("top.rx"), ry = channel("top.ry"), rz = channel("top.rz");
  const solver::SpinePose rest = sound->rest();
  const std::vector<double> fraction = sound->arc_fraction();
  return std::make_unique<validate::Spoiled>(std::move(sound), [=](std::span<const double> control,
                                                                   solver::SpinePose& pose) {
    validate::PoseDegrees body;
    const double bend = -glm::degrees(control[rz]);
    body.extension = std::max(bend, 0.0);
    body.flexion = std::max(-bend, 0.0);
    body.side = -glm::degrees(control[ry]);
    body.twist = glm::degrees(control[rx]);
    const double amount = fault.amount * fault.strength(box.point_of(body));
    if (amount == 0.0) return;
    if (fault.code == "BB001") {
      pose.turn[fault.joint] = validate::rotation(amount * fault.axis) * pose.turn[fault.joint];
    } else if (fault.code == "BB010") {
      // The axis lies in the plane in which the chain bends least: any will do.
      validate::inject_kink(pose, fraction, fraction[fault.joint],
                            amount * glm::normalize(glm::dvec3(fault.axis.x, 0.0, fault.axis.z)));
    } else if (fault.code == "BB014") {
      const double to = fraction[fault.joint + 1];
      validate::inject_roll(pose, rest, fraction, fraction[fault.joint], to, amount);
    } else {
      validate::inject_arm_drift(pose, amount * fault.axis, glm::dvec3(0.0));
    }
  });
}

}  // namespace backbend::battery
