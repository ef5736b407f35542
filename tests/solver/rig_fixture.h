#pragma once
// The chains, poses and small helpers that the solver's tests share (research/seeds.md, section 1).
#include <gtest/gtest.h>

#include <functional>
#include <glm/geometric.hpp>
#include <memory>
#include <string>
#include <vector>

#include "solver/math/rotation.h"
#include "solver/rig/spine_system.h"

namespace backbend::solver::rigs {

using glm::dquat;
using glm::dvec3;
using Options = std::map<std::string, OptionValue>;

/// CH-S, the straight chain, and CH-C, the curved one; both lie in the Y-Z plane.
inline RestChain straight() { return {.joint = {{0, 0, 0}, {0, 2, 0}, {0, 4, 0}, {0, 6, 0}}}; }
inline RestChain curved() {
  return {.joint = {{0, 0, 0}, {0, 2, 0.5}, {0, 4.1, 0.2}, {0, 6, -0.6}}};
}

inline std::unique_ptr<SpineSystem> build(const std::string& system, Options options = {},
                                          const RestChain& chain = straight()) {
  return build_system({system, std::move(options)}, chain);
}

/// Control values from degrees: lower, middle, top (RX, RY, RZ).
inline std::vector<double> degrees_to_controls(std::vector<double> deg) {
  for (double& d : deg) d = radians(d);
  return deg;
}
inline std::vector<double> pose_deg(dvec3 lower, dvec3 middle, dvec3 top) {
  return degrees_to_controls(
      {lower.x, lower.y, lower.z, middle.x, middle.y, middle.z, top.x, top.y, top.z});
}
inline std::vector<double> pose_a() { return pose_deg({0, 0, 0}, {0, 0, 0}, {0, 0, 0}); }
inline std::vector<double> pose_b() { return pose_deg({0, 0, 30}, {0, 0, 30}, {0, 0, 30}); }
inline std::vector<double> pose_c() { return pose_deg({0, 0, -60}, {0, 0, -60}, {0, 0, -60}); }
inline std::vector<double> pose_d() { return pose_deg({0, 0, 0}, {0, 0, 0}, {60, 0, 0}); }
inline std::vector<double> pose_e() { return pose_deg({0, 0, 20}, {0, 25, -10}, {45, -30, 35}); }
inline std::vector<double> pose_f() { return pose_deg({0, 0, 0}, {0, 0, 0}, {0, 0, -150}); }
inline std::vector<double> pose_g() { return pose_deg({60, 0, 0}, {0, 0, 0}, {0, 0, 0}); }
inline std::vector<double> pose_h() { return pose_deg({0, 0, 0}, {60, 0, 0}, {0, 0, 0}); }

inline double measure(const SpinePose& pose, const std::string& name) {
  for (const Measure& m : pose.measures) {
    if (m.name == name) return m.value;
  }
  ADD_FAILURE() << "no measure '" << name << "'";
  return std::numeric_limits<double>::quiet_NaN();
}

inline std::size_t channel(const SpineSystem& system, const std::string& name) {
  for (std::size_t i = 0; i < system.channels().size(); ++i) {
    if (system.channels()[i].name == name) return i;
  }
  ADD_FAILURE() << "no channel '" << name << "'";
  return 0;
}

inline std::vector<double> rest_controls(const SpineSystem& system) {
  std::vector<double> control;
  for (const Channel& c : system.channels()) control.push_back(c.rest);
  return control;
}

inline void expect_near(const dvec3& actual, const dvec3& expected, double tolerance) {
  EXPECT_NEAR(actual.x, expected.x, tolerance);
  EXPECT_NEAR(actual.y, expected.y, tolerance);
  EXPECT_NEAR(actual.z, expected.z, tolerance);
}

inline double turn_between_deg(const SpinePose& a, const SpinePose& b, std::size_t joint) {
  return degrees(angle_between(a.turn[joint], b.turn[joint]));
}

/// Angle between consecutive bones at each inner joint, degrees.
inline std::vector<double> joint_angles_deg(const SpinePose& pose) {
  std::vector<double> angle;
  for (std::size_t i = 1; i + 1 < pose.joint_count(); ++i) {
    angle.push_back(degrees(angle_between(pose.position[i] - pose.position[i - 1],
                                          pose.position[i + 1] - pose.position[i])));
  }
  return angle;
}

/// A jump of one joint's turn while one channel moves on.
struct Jump {
  std::size_t joint;
  double at_deg;    // channel value
  double size_deg;  // rotation across it
};

/// Jumps of more than `least_deg` that stay when the interval around them shrinks to 1e-7 degrees,
/// while `name` goes from `from` to `to` in steps of `step` degrees.
inline std::vector<Jump> find_jumps(const SpineSystem& system, std::vector<double> control,
                                    const std::string& name, double from, double to, double step,
                                    double least_deg = 20.0) {
  const std::size_t c = channel(system, name);
  const auto at = [&](double deg) {
    control[c] = radians(deg);
    return system.solve(control);
  };
  std::vector<Jump> jumps;
  double low = from;
  SpinePose before = at(low);
  const int steps = int(std::lround((to - from) / step));
  for (int i = 1; i <= steps; ++i) {
    const double high = from + i * step;
    const SpinePose after = at(high);
    for (std::size_t j = 0; j < before.joint_count(); ++j) {
      if (turn_between_deg(before, after, j) < least_deg) continue;
      double a = low, b = high;
      SpinePose pa = before, pb = after;
      while (std::abs(b - a) > 1e-7) {
        const double m = 0.5 * (a + b);
        SpinePose pm = at(m);
        if (turn_between_deg(pa, pm, j) >= turn_between_deg(pm, pb, j)) {
          b = m, pb = std::move(pm);
        } else {
          a = m, pa = std::move(pm);
        }
      }
      const double size = turn_between_deg(pa, pb, j);
      if (size >= least_deg) jumps.push_back({j, 0.5 * (a + b), size});
    }
    before = after;
    low = high;
  }
  return jumps;
}

/// The largest turn of any joint from one step of a sweep to the next, degrees.
inline double largest_step_deg(const SpineSystem& system,
                               const std::function<std::vector<double>(double)>& control,
                               double from, double to, double step) {
  SpinePose before = system.solve(control(from));
  double largest = 0.0;
  const int steps = int(std::lround((to - from) / step));
  for (int i = 1; i <= steps; ++i) {
    const SpinePose after = system.solve(control(from + i * step));
    for (std::size_t j = 0; j < after.joint_count(); ++j) {
      largest = std::max(largest, turn_between_deg(before, after, j));
    }
    before = after;
  }
  return largest;
}

}  // namespace backbend::solver::rigs
