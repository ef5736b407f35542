#include <cmath>
#include <glm/gtc/quaternion.hpp>

#include "solver/curves/curve.h"
#include "solver/systems/system_base.h"
#include "validate/live/external_rig.h"
#include "validate/metrics/chain/chain.h"
#include "validate/sweeps/sweep.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

class ExternalSystem final : public solver::SystemBase {
 public:
  ExternalSystem(const solver::SystemSpec& spec, std::shared_ptr<const ExternalRig> rig)
      : rig_(std::move(rig)) {
    name_ = spec.system;
    options_ = spec.options;
    for (const char* of_no_result : {"servers", "timeout"}) options_.erase(of_no_result);
    channels_ = rig_->channels();
    rest_ = rig_->rest();
    name_chain(rig_->joint_names());
    measure_arc_fraction();
  }

  solver::SpinePose solve(std::span<const double> control) const override {
    return rig_->pose(control, solver::Detail::all);
  }
  void solve_into(std::span<const double> control, solver::Detail detail,
                  solver::SpinePose& pose) const override {
    rig_->pose_into(control, detail, pose);
  }
  void prepare(std::span<const std::vector<double>> controls,
               solver::Detail detail) const override {
    rig_->prepare(controls, detail);
  }
  std::vector<double> controls_for(const solver::BodyPose& body, solver::Mapping) const override {
    return rig_->controls_for(body);
  }
  std::string_view why_without(solver::BodyChannel) const override {
    return "a mapping has no such channel";
  }
  std::string why_not_mapped(const solver::BodyPose& body) const override {
    const std::pair<std::string_view, double> asked[] = {{"extension", body.extension},
                                                         {"flexion", body.flexion},
                                                         {"side", body.side},
                                                         {"twist", body.twist}};
    for (const auto& [name, angle] : asked)
      if (angle != 0.0 && !rig_->maps(name))
        return std::string(name) + ": " + rig_->mapping().source + " names no control for it";
    return {};
  }

  /// The rest spine bent evenly as far as the pose takes its chest against its hips: what is
  /// sharper than that at one joint was not asked for.
  std::vector<glm::dvec3> intended_curve(std::span<const double> control,
                                         std::size_t count) const override {
    const solver::SpinePose pose = rig_->pose(control, solver::Detail::joints);
    const std::vector<glm::dvec3> rest = solver::equal_arc_points(
        solver::Curve::interpolating(
            rest_.position, solver::make_knots(rest_.position, solver::KnotRule::centripetal)),
        count);
    // The whole turn, with the full turns that the joints add up to.
    glm::dvec3 whole(0.0);
    for (Index k = 1; k < pose.turn.size(); ++k)
      whole += turn_between(pose.turn[k - 1], pose.turn[k]);
    glm::dvec3 shared = rotation_vector(pose.chest.turn * glm::conjugate(pose.hip.turn));
    if (const double angle = glm::length(shared); angle > 0.0) {
      const glm::dvec3 axis = shared / angle;
      shared += axis * (2.0 * kPi * std::round((glm::dot(whole, axis) - angle) / (2.0 * kPi)));
    }
    std::vector<glm::dvec3> out{pose.hip.posed_origin};
    for (Index i = 1; i < rest.size(); ++i) {
      const double arc = (static_cast<double>(i) - 0.5) / static_cast<double>(rest.size() - 1);
      out.push_back(out.back() + rotation(shared * arc) * pose.hip.turn * (rest[i] - rest[i - 1]));
    }
    return out;
  }

  const ExternalRig& rig() const { return *rig_; }

 private:
  std::shared_ptr<const ExternalRig> rig_;
};

}  // namespace

std::unique_ptr<solver::SpineSystem> external_system(const solver::SystemSpec& spec,
                                                     std::shared_ptr<const ExternalRig> rig) {
  return std::make_unique<ExternalSystem>(spec, std::move(rig));
}

const ExternalRig* external_rig(const solver::SpineSystem& system) {
  const auto* external = dynamic_cast<const ExternalSystem*>(&system);
  return external ? &external->rig() : nullptr;
}

}  // namespace backbend::validate
