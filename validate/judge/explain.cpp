#include "validate/judge/explain.h"

#include <cmath>

#include "solver/rig/driven_system.h"
#include "solver/rig/evaluation_order.h"
#include "validate/metrics/chain/chain.h"
#include "validate/metrics/math/rotation.h"
#include "validate/sweeps/suite.h"
#include "validate/sweeps/sweep.h"

namespace backbend::validate {
namespace {

std::string inputs_text(const solver::SolveFile& file) {
  std::string text = "inputs\n", control;
  const auto& channels = file.system->channels();
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const std::size_t dot = channels[i].name.find('.');
    const std::string owner = channels[i].name.substr(0, dot);
    const bool is_angle = channels[i].kind == solver::Channel::Kind::rotation;
    const double value = is_angle ? degrees(file.control[i]) : file.control[i];
    text += owner == control ? "  " : (control.empty() ? "  " : "\n  ") + owner + "  ";
    if (dot != std::string::npos) text += channels[i].name.substr(dot + 1) + " ";
    text += number_text(value, 4) + (is_angle ? " deg" : "");
    control = owner;
  }
  return text + "\n";
}

bool has_three_controls(const solver::SpineSystem& system) {
  return system.name() == "three_bone" || system.name() == "curve" || system.name() == "even";
}

/// Middle and Top as Euler controls of which only the last one's twist may feed the chain.
std::string story_text(const solver::SolveFile& file, const ArmDrift& drift) {
  if (!has_three_controls(*file.system)) return "";
  const auto* driven = dynamic_cast<const solver::DrivenSystem*>(file.system.get());
  const std::vector<double> control = driven ? driven->rig_control(file.control) : file.control;
  std::vector<EulerChannels> controls;
  for (std::size_t first = 0; first < 9; first += 3)
    controls.push_back({control[first], control[first + 1], control[first + 2]});
  const auto roll = file.system->options().find("roll");
  const bool from_last =
      roll != file.system->options().end() && std::get<std::string>(roll->second) == "top";
  const ArmDriftStory story = explain_arm_drift(drift, controls, from_last);
  return "  twist explained: hidden Euler twist " + number_text(story.hidden_euler_deg, 2) +
         " + lost twist " + number_text(story.lost_twist_deg, 2) + " + holonomy " +
         number_text(story.holonomy_deg, 2) + " deg\n";
}

}  // namespace

std::string explain_solve(const solver::SolveFile& file) {
  const solver::SpineSystem& system = *file.system;
  const solver::SpinePose pose = system.solve(file.control);
  const solver::SpinePose& rest = system.rest();
  std::string text = std::string(system.name()) + "\n" + inputs_text(file) + "options\n";
  for (const auto& [key, value] : system.options()) {
    text += "  " + key + " = " + rig_text({"", {{key, value}}}).substr(key.size() + 2) + "\n";
  }
  if (!file.drawing.empty()) text += "drawing\n  " + file.drawing + "\n";
  text += "order of evaluation\n";
  int step = 0;
  for (const std::string& line : solver::evaluation_order(system))
    text += "  " + std::to_string(++step) + "  " + line + "\n";
  text += "measures\n";
  for (const solver::Measure& measure : pose.measures)
    text += "  " + measure.name + " = " + number_text(measure.value, 6) + "\n";

  const std::size_t tip = rest.position.size() - 1;
  const double length = chain_length(rest.position);
  const ArmDrift drift =
      arm_drift(pose, glm::normalize(rest.position[tip] - rest.position[tip - 1]), length);
  text += "drift of the arms against the chest control\n  " + number_text(drift.rotation_deg, 3) +
          " deg: twist " + number_text(drift.twist_deg, 3) + ", aim " +
          number_text(drift.aim_deg, 3) + "; shift " + number_text(100.0 * drift.shift, 3) +
          " % of the spine\n" + story_text(file, drift);
  for (const std::string& flag : pose.flags) text += "flag  " + flag + "\n";
  return text;
}

}  // namespace backbend::validate
