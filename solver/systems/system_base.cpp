#include "solver/systems/system_base.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>

#include "solver/curves/curve.h"
#include "solver/rig/option_reader.h"

namespace backbend::solver {

void SystemBase::take_options(const OptionReader& read) {
  options_ = read.finish();
  ranges_ = read.ranges();
}

void SystemBase::add_rotation(const std::string& control) {
  for (const char* axis : {".rx", ".ry", ".rz"}) {
    channels_.push_back({control + axis, Channel::Kind::rotation, 0.0});
  }
}

void SystemBase::add_translation(const std::string& control) {
  for (const char* axis : {".x", ".y", ".z"}) {
    channels_.push_back({control + axis, Channel::Kind::translation, 0.0});
  }
}

void SystemBase::add_scalar(const std::string& name, double rest) {
  channels_.push_back({name, Channel::Kind::scalar, rest});
}

void SystemBase::name_chain(std::vector<std::string> names) {
  joint_names_ = std::move(names);
  joint_parents_.resize(joint_names_.size());
  for (std::size_t i = 0; i < joint_parents_.size(); ++i) joint_parents_[i] = int(i) - 1;
}

void SystemBase::measure_arc_fraction() {
  arc_fraction_ = polyline_arcs(rest_.position);
  const double whole = arc_fraction_.back();
  for (double& f : arc_fraction_) f = whole > 0.0 ? f / whole : 0.0;
}

bool SystemBase::is_at_rest(std::span<const double> control) const {
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (control[i] != channels_[i].rest) return false;
  }
  return true;
}

SpinePose FormulaSystem::solve(std::span<const double> control) const {
  SpinePose pose;
  solve_into(control, Detail::all, pose);
  return pose;
}

void FormulaSystem::solve_into(std::span<const double> control, Detail detail,
                               SpinePose& pose) const {
  assert(control.size() == channels_.size());
  if (is_at_rest(control)) {
    pose = rest_;
    return;
  }
  fill(control, detail, pose);
}

std::vector<double> polyline_arcs(const std::vector<glm::dvec3>& point) {
  std::vector<double> arc(point.size(), 0.0);
  for (std::size_t i = 1; i < point.size(); ++i) {
    arc[i] = arc[i - 1] + glm::length(point[i] - point[i - 1]);
  }
  return arc;
}

void check_chain(const RestChain& chain, const std::string& system, std::size_t least) {
  if (chain.joint.size() < least) {
    throw RigError(system + ": the chain has " + std::to_string(chain.joint.size()) +
                   " joints, expected " + std::to_string(least) + " or more");
  }
  for (std::size_t i = 0; i < chain.joint.size(); ++i) {
    const glm::dvec3& p = chain.joint[i];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
      throw RigError(system + ": joint " + std::to_string(i) + " of the chain is not finite");
    }
  }
  if (!(glm::length(chain.left) > 0.0) || !std::isfinite(glm::length(chain.left))) {
    throw RigError(system + ": the chain's left direction is zero or not finite");
  }
  const std::vector<double> arc = polyline_arcs(chain.joint);
  for (std::size_t i = 1; i < arc.size(); ++i) {
    if (!(arc[i] - arc[i - 1] > 1e-9 * arc.back())) {
      throw RigError(system + ": joints " + std::to_string(i - 1) + " and " + std::to_string(i) +
                     " of the chain coincide; remove one of them");
    }
  }
}

std::vector<glm::dvec3> three_bones_of(const RestChain& chain) {
  if (chain.joint.size() == 4) return chain.joint;
  const Curve line = Curve::polyline(chain.joint);
  return {chain.joint.front(), line.at_fraction(1.0 / 3.0).position,
          line.at_fraction(2.0 / 3.0).position, chain.joint.back()};
}

}  // namespace backbend::solver
