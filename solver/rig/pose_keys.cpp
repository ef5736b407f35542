#include <algorithm>
#include <cmath>

#include "solver/math/rotation.h"
#include "solver/rig/nearest_name.h"
#include "solver/rig/option_reader.h"
#include "solver/rig/solve_file.h"

namespace backbend::solver {
namespace {

std::vector<std::string> control_names(const SpineSystem& system) {
  std::vector<std::string> names;
  for (const Channel& c : system.channels()) {
    const std::string control = control_of(c.name);
    if (std::find(names.begin(), names.end(), control) == names.end()) names.push_back(control);
  }
  return names;
}

bool only_rotates(const SpineSystem& system, const std::string& control) {
  bool any = false;
  for (const Channel& c : system.channels()) {
    if (control_of(c.name) != control) continue;
    if (c.kind != Channel::Kind::rotation) return false;
    any = true;
  }
  return any;
}

/// "translation" or "scale" if a name asks for one: tx, y, translate_z, pos, sx, scale ...
std::string_view locked_kind(std::string_view name) {
  for (const std::string_view s : {"sx", "sy", "sz", "scale", "scl"}) {
    if (name.starts_with(s)) return "scale";
  }
  for (const std::string_view t :
       {"tx", "ty", "tz", "move", "translat", "trans", "pos", "offset"}) {
    if (name.starts_with(t)) return "translation";
  }
  return name == "x" || name == "y" || name == "z" || name == "t" ? "translation"
                                                                  : std::string_view{};
}

/// Refuses what animators try on a control that only rotates, by name: `top.ty`, `top_move`.
void refuse_locked(const SpineSystem& system, const std::string& key) {
  for (const std::string& control : control_names(system)) {
    if (!only_rotates(system, control) || key.size() < control.size() + 2) continue;
    if (!key.starts_with(control) || (key[control.size()] != '.' && key[control.size()] != '_'))
      continue;
    const std::string channel = key.substr(control.size() + 1);
    const std::string_view kind = locked_kind(channel);
    if (kind.empty()) continue;
    throw OptionError(key, "control '" + control + "' only rotates: channel '" + channel +
                               "' is a " + std::string(kind) +
                               ", which is locked; it has rx, ry, rz");
  }
}

[[noreturn]] void refuse_unknown(const SpineSystem& system, const std::string& key) {
  const std::string start = std::string(system.name()) + ": ";
  std::vector<std::string> channels;
  for (const Channel& c : system.channels()) {
    if (c.name.starts_with(control_of(key) + ".")) channels.push_back(c.name);
  }
  if (!channels.empty()) {
    throw OptionError(key, start + "unknown channel '" + key + "'" + suggestion(key, channels));
  }
  throw OptionError(
      key, start + "unknown control '" + key + "'" + suggestion(key, control_names(system)));
}

std::vector<double> flatten(const std::string& key, const OptionValue& value) {
  std::vector<double> flat;
  if (const auto* number = std::get_if<double>(&value)) {
    flat = {*number};
  } else if (const auto* list = std::get_if<std::vector<double>>(&value)) {
    flat = *list;
  } else if (const auto* rows = std::get_if<std::vector<std::vector<double>>>(&value)) {
    for (const auto& row : *rows) flat.insert(flat.end(), row.begin(), row.end());
  } else {
    throw OptionError(key, "'" + key + "' is not a number or a list of numbers");
  }
  return flat;
}

}  // namespace

double largest_written(const Channel& channel) {
  return channel.kind == Channel::Kind::rotation ? 1e6 : 1e9;
}

void set_pose_key(const SpineSystem& system, const std::string& key, const OptionValue& value,
                  std::span<double> control) {
  if (system.read_pose_key(key, value, control)) return;
  const auto& channels = system.channels();
  std::vector<std::size_t> mine;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (channels[i].name == key || channels[i].name.starts_with(key + ".")) mine.push_back(i);
  }
  if (mine.empty()) {
    refuse_locked(system, key);
    refuse_unknown(system, key);
  }
  const std::vector<double> given = flatten(key, value);
  if (given.size() != mine.size()) {
    std::string names;
    for (const std::size_t i : mine) names += (names.empty() ? "" : ", ") + channels[i].name;
    const bool locked = only_rotates(system, key) && given.size() > mine.size();
    throw OptionError(
        key, "control '" + key + "' has " + std::to_string(given.size()) + " values, expected " +
                 std::to_string(mine.size()) + " (" + names + ")" +
                 (locked ? "; it only rotates: translation and scale are locked" : ""));
  }
  for (std::size_t i = 0; i < mine.size(); ++i) {
    const Channel& channel = channels[mine[i]];
    const bool angle = channel.kind == Channel::Kind::rotation;
    const double most = largest_written(channel);
    if (!std::isfinite(given[i]) || std::abs(given[i]) > most) {
      throw OptionError(key, "'" + channel.name + "' is " + number_text(given[i]) +
                                 ", expected a number within +-" + number_text(most));
    }
    control[mine[i]] = angle ? radians(given[i]) : given[i];
  }
}

}  // namespace backbend::solver
