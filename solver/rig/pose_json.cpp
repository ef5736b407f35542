#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "solver/rig/option_reader.h"
#include "solver/rig/solve_file.h"

namespace backbend::solver {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const OptionValue& value) {
  return std::visit([](const auto& v) { return Json(v); }, value);
}

Json pose_json(const SpineSystem& system, const SpinePose& pose, const Json* control) {
  Json json;
  json["schema"] = "backbend.pose/1";
  json["system"] = system.name();
  Json& options = json["options"] = Json::object();
  for (const auto& [key, value] : system.options()) options[key] = to_json(value);
  if (control) json["control"] = *control;
  Json& joints = json["joints"] = Json::array();
  for (std::size_t i = 0; i < pose.joint_count(); ++i) {
    const glm::dvec3& p = pose.position[i];
    const glm::dquat& q = pose.turn[i];
    const int parent = system.joint_parents()[i];
    joints.push_back({{"name", system.joint_names()[i]},
                      {"parent", parent < 0 ? Json(nullptr) : Json(parent)},
                      {"position", {p.x, p.y, p.z}},
                      {"turn", {q.w, q.x, q.y, q.z}}});
  }
  Json& measures = json["measures"] = Json::object();
  for (const Measure& m : pose.measures) measures[m.name] = m.value;
  json["flags"] = pose.flags;
  return json;
}

std::string padded(std::string text, std::size_t width) {
  if (text.size() < width) text.insert(0, width - text.size(), ' ');
  return text;
}

std::string fixed(double value) {
  char buffer[400];  // the largest double has 309 digits before its point
  const auto end =
      std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, 6);
  return {buffer, end.ptr};
}

}  // namespace

std::string pose_to_json(const SpineSystem& system, const SpinePose& pose) {
  return pose_json(system, pose, nullptr).dump();
}

std::string pose_to_json(const SpineSystem& system, const SpinePose& pose, std::string_view channel,
                         double written) {
  const Json control = {{std::string(channel), written}};
  return pose_json(system, pose, &control).dump();
}

std::string solve_to_json(const SolveFile& file) {
  return pose_to_json(*file.system, file.system->solve(file.control));
}

std::string sweep_to_json_lines(const SpineSystem& system, std::string_view channel,
                                std::span<const double> written,
                                const std::function<std::vector<double>(std::size_t)>& control_at) {
  constexpr std::size_t kAskedAtOnce = 256;
  std::string lines;
  for (std::size_t first = 0; first < written.size(); first += kAskedAtOnce) {
    std::vector<std::vector<double>> controls(std::min(kAskedAtOnce, written.size() - first));
    for (std::size_t i = 0; i < controls.size(); ++i) controls[i] = control_at(first + i);
    system.prepare(controls, Detail::joints);
    for (std::size_t i = 0; i < controls.size(); ++i)
      lines += pose_to_json(system, system.solve(controls[i]), channel, written[first + i]) + "\n";
  }
  return lines;
}

std::string sweep_to_json_lines(const SolveFile& file, std::string_view text) {
  if (constexpr std::string_view kTime = "time="; text.starts_with(kTime)) {
    const std::string start = "sweep '" + std::string(text.substr(0, 200)) + "': ";
    if (file.key.empty()) throw RigError(start + file.name + " has no [[key]]");
    const std::vector<double> time = parse_range(text.substr(kTime.size()), start);
    return sweep_to_json_lines(*file.system, "time", time,
                               [&](std::size_t i) { return file.control_at(time[i]); });
  }
  const ControlSweep sweep = parse_sweep(*file.system, text);
  return sweep_to_json_lines(*file.system, file.system->channels()[sweep.channel].name,
                             sweep.written, [&](std::size_t i) {
                               std::vector<double> control = file.control;
                               control[sweep.channel] = sweep.value[i];
                               return control;
                             });
}

std::string solve_to_text(const SolveFile& file) {
  const SpinePose pose = file.system->solve(file.control);
  std::size_t width = 5;
  for (const std::string& name : file.system->joint_names()) width = std::max(width, name.size());
  std::string text = padded("joint", width);
  for (const char* column : {"x", "y", "z", "turn w", "x", "y", "z"}) text += padded(column, 13);
  text += "\n";
  for (std::size_t i = 0; i < pose.joint_count(); ++i) {
    const glm::dvec3& p = pose.position[i];
    const glm::dquat& q = pose.turn[i];
    text += padded(file.system->joint_names()[i], width);
    for (const double v : {p.x, p.y, p.z, q.w, q.x, q.y, q.z}) text += padded(fixed(v), 13);
    text += "\n";
  }
  for (const Measure& m : pose.measures) text += m.name + " " + number_text(m.value) + "\n";
  for (const std::string& flag : pose.flags) text += "note: " + flag + "\n";
  return text;
}

}  // namespace backbend::solver
