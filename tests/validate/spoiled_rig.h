#pragma once
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "solver/rig/spine_system.h"

namespace backbend::validate {

/// `even` with something of a bad rig added to what it solves.
class Spoiled : public solver::SpineSystem {
 public:
  using Fault = std::function<void(std::span<const double>, solver::SpinePose&)>;
  Spoiled(std::unique_ptr<solver::SpineSystem> good, Fault fault)
      : good_(std::move(good)), fault_(std::move(fault)) {}
  std::string_view name() const override { return good_->name(); }
  const std::map<std::string, solver::OptionValue>& options() const override {
    return good_->options();
  }
  const std::vector<solver::Channel>& channels() const override { return good_->channels(); }
  const std::vector<std::string>& joint_names() const override { return good_->joint_names(); }
  const std::vector<int>& joint_parents() const override { return good_->joint_parents(); }
  const solver::SpinePose& rest() const override { return good_->rest(); }
  const std::vector<double>& arc_fraction() const override { return good_->arc_fraction(); }
  solver::SpinePose solve(std::span<const double> control) const override {
    solver::SpinePose pose = good_->solve(control);
    fault_(control, pose);
    return pose;
  }
  std::vector<double> controls_for(const solver::BodyPose& body,
                                   solver::Mapping mapping) const override {
    return good_->controls_for(body, mapping);
  }
  std::vector<glm::dvec3> intended_curve(std::span<const double> control,
                                         std::size_t count) const override {
    return good_->intended_curve(control, count);
  }

 private:
  std::unique_ptr<solver::SpineSystem> good_;
  Fault fault_;
};

}  // namespace backbend::validate
