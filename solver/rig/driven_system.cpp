#include "solver/rig/driven_system.h"

#include <algorithm>
#include <cmath>

#include "solver/math/rotation.h"
#include "solver/rig/nearest_name.h"
#include "solver/rig/option_reader.h"
#include "solver/rig/solve_file.h"

namespace backbend::solver {
namespace {

std::vector<SystemElement> weighted(const std::vector<DrivingElement>& elements) {
  std::vector<SystemElement> out;
  for (const DrivingElement& element : elements)
    out.push_back(weighted_element(element.name, element.inputs, element.weights));
  return out;
}

std::vector<std::string> names_of(const std::vector<Channel>& channels) {
  std::vector<std::string> names;
  for (const Channel& channel : channels) names.push_back(channel.name);
  return names;
}

}  // namespace

DrivenSystem::DrivenSystem(std::unique_ptr<SpineSystem> rig, std::vector<SystemControl> controls,
                           const std::vector<DrivingElement>& elements)
    : rig_(std::move(rig)),
      controls_(controls),
      controller_(std::move(controls), weighted(elements)),
      channels_(rig_->channels()) {
  const std::vector<std::string> own = names_of(channels_);
  const auto find = [&](const std::string& name) {
    return std::find(own.begin(), own.end(), name);
  };
  for (const DrivingElement& element : elements) {
    if (!element.drives.empty() && element.drives.size() != element.weights.size())
      throw RigError("element '" + element.name + "': drives " +
                     std::to_string(element.drives.size()) + " channels with " +
                     std::to_string(element.weights.size()) + " rows of weights");
    for (std::size_t row = 0; row < element.drives.size(); ++row) {
      const auto found = find(element.drives[row]);
      if (found == own.end())
        throw RigError("element '" + element.name + "': the rig has no channel '" +
                       element.drives[row] + "'" + suggestion(element.drives[row], own));
      const auto channel = std::size_t(found - own.begin());
      const bool turns = channels_[channel].kind == Channel::Kind::rotation;
      drives_.push_back({element.name, row, channel, turns ? radians(1.0) : 1.0});
    }
  }
  for (const SystemControl& control : controls_) {
    const auto is_taken = [&](const std::string& name) {
      return name == control.name || name.starts_with(control.name + ".");
    };
    if (std::any_of(own.begin(), own.end(), is_taken))
      throw RigError("control '" + control.name + "': the rig has a control of this name");
    const std::size_t width = control.rest.size();
    for (std::size_t i = 0; i < width; ++i) {
      std::string name = width == 1 ? control.name : control.name + "." + std::to_string(i + 1);
      channels_.push_back({std::move(name), Channel::Kind::scalar, control.rest[i]});
    }
  }
  std::vector<double> rest;
  for (const Channel& channel : channels_) rest.push_back(channel.rest);
  rest_ = solve(rest);  // evaluates each element once: what cannot be evaluated is refused here
}

std::vector<double> DrivenSystem::rig_control(std::span<const double> control) const {
  const std::size_t own = rig_->channels().size();
  SystemController::State state = controller_.start();
  std::size_t first = own;
  for (const SystemControl& each : controls_) {
    controller_.set(state, each.name, control.subspan(first, each.rest.size()));
    first += each.rest.size();
  }
  controller_.update(state);
  std::vector<double> values(control.begin(), control.begin() + std::ptrdiff_t(own));
  for (const Drive& drive : drives_) {
    const Channel& channel = rig_->channels()[drive.channel];
    double& value = values[drive.channel];
    value += drive.scale * controller_.value(state, drive.element)[drive.row];
    if (!(std::abs(value) <= drive.scale * largest_written(channel)))
      throw RigError("element '" + drive.element + "' drives " + channel.name + " beyond +-" +
                     number_text(largest_written(channel)));
  }
  return values;
}

SpinePose DrivenSystem::solve(std::span<const double> control) const {
  return rig_->solve(rig_control(control));
}

void DrivenSystem::solve_into(std::span<const double> control, Detail detail,
                              SpinePose& pose) const {
  rig_->solve_into(rig_control(control), detail, pose);
}

std::vector<double> DrivenSystem::controls_for(const BodyPose& body, Mapping mapping) const {
  std::vector<double> control = rig_->controls_for(body, mapping);
  for (std::size_t i = control.size(); i < channels_.size(); ++i)
    control.push_back(channels_[i].rest);
  return control;
}

std::vector<glm::dvec3> DrivenSystem::intended_curve(std::span<const double> control,
                                                     std::size_t count) const {
  return rig_->intended_curve(rig_control(control), count);
}

bool DrivenSystem::read_pose_key(std::string_view key, const OptionValue& value,
                                 std::span<double> control) const {
  return rig_->read_pose_key(key, value, control.first(rig_->channels().size()));
}

std::vector<std::string> DrivenSystem::explain() const {
  std::vector<std::string> lines;
  for (const std::string& line : controller_.explain()) lines.push_back("element " + line);
  for (const Drive& drive : drives_)
    lines.push_back("add '" + drive.element + "' to " + rig_->channels()[drive.channel].name);
  for (const SystemControl& control : controls_) {
    SystemController::State state = controller_.start();
    controller_.update(state);
    std::vector<double> moved = control.rest;
    for (double& value : moved) value += 1.0;
    controller_.set(state, control.name, moved);
    lines.push_back("a change of " + control.name + " evaluates " +
                    std::to_string(controller_.update(state)) + " of " +
                    std::to_string(controller_.explain().size()) + " elements again");
  }
  return lines;
}

}  // namespace backbend::solver
