#include "validate/live/control_mapping.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "solver/rig/nearest_name.h"
#include "validate/files/output_folder.h"
#include "validate/sweeps/sweep.h"

namespace backbend::validate {
namespace {

using nlohmann::json;

constexpr std::size_t kMostMappingBytes = 1 << 20, kMostTargets = 1000;

const std::vector<std::string>& body_channels() {
  static const std::vector<std::string> names(kBendChannels.begin(), kBendChannels.end());
  return names;
}

ControlTarget read_target(const json& object, const std::string& where) {
  const auto fail = [&](const std::string& what) { throw solver::RigError(where + what); };
  if (!object.is_object()) fail(": must be an object with control and channel");
  const auto text = [&](const char* key) -> std::string {
    const auto found = object.find(key);
    if (found == object.end()) return {};
    if (!found->is_string() || found->get_ref<const std::string&>().empty())
      fail(std::string("/") + key + ": must be text");
    return *found;
  };
  const std::string control = text("control"), channel = text("channel");
  if (channel.empty()) fail("/channel: missing");
  ControlTarget target;
  target.channel = control.empty() ? channel : control + "." + channel;
  if (const auto factor = object.find("per_degree"); factor != object.end()) {
    if (!factor->is_number() || !std::isfinite(factor->get<double>()) ||
        factor->get<double>() == 0.0)
      fail("/per_degree: must be a finite number other than 0");
    target.per_degree = *factor;
  }
  return target;
}

}  // namespace

std::vector<ControlTarget> ControlMapping::targets(std::string_view channel) const {
  if (const auto own = channels.find(channel); own != channels.end()) return own->second;
  const std::string_view other = channel == "extension" ? "flexion"
                                 : channel == "flexion" ? "extension"
                                                        : std::string_view();
  const auto opposite = channels.find(other);
  if (opposite == channels.end()) return {};
  std::vector<ControlTarget> targets = opposite->second;
  for (ControlTarget& target : targets) target.per_degree = -target.per_degree;
  return targets;
}

ControlMapping read_mapping(const std::filesystem::path& file) {
  return parse_mapping(read_text(file, kMostMappingBytes), file.string());
}

ControlMapping parse_mapping(const std::string& text, const std::string& file) {
  const auto fail = [&](const std::string& what) { throw solver::RigError(file + ": " + what); };
  const json object = json::parse(text, nullptr, false);
  if (!object.is_object()) fail("is not a mapping: JSON with \"channels\" expected");
  const auto channels = object.find("channels");
  if (channels == object.end() || !channels->is_object() || channels->empty())
    fail("channels: missing or empty");
  ControlMapping mapping;
  mapping.source = file;
  for (const auto& [name, targets] : channels->items()) {
    const std::vector<std::string>& known = body_channels();
    if (std::find(known.begin(), known.end(), name) == known.end())
      fail("channels: '" + name.substr(0, 100) + "' is none of extension, flexion, side, twist" +
           solver::did_you_mean(name, known));
    if (!targets.is_array() || targets.empty() || targets.size() > kMostTargets)
      fail("channels/" + name + ": must be a list of controls");
    for (std::size_t k = 0; k < targets.size(); ++k)
      mapping.channels[name].push_back(
          read_target(targets[k], file + ": channels/" + name + "/" + std::to_string(k)));
  }
  return mapping;
}

ControlMapping mapping_of(const std::vector<skin::SidecarControl>& controls) {
  ControlMapping mapping;
  mapping.source = "the sidecar";
  for (const skin::SidecarControl& each : controls) {
    const auto sharing = std::ranges::count(controls, each.channel, &skin::SidecarControl::channel);
    mapping.channels[each.channel].push_back(
        {each.control + "." + each.own_channel(),
         each.per_degree != 0.0 ? each.per_degree
                                : static_cast<double>(each.sign) / static_cast<double>(sharing)});
  }
  return mapping;
}

ControlMapping mapping_by_name(const RigHello& hello) {
  ControlMapping mapping;
  mapping.source = "the rig's own channel names";
  for (const RigChannel& channel : hello.channels) {
    const std::vector<std::string>& known = body_channels();
    if (channel.kind == solver::Channel::Kind::rotation &&
        std::find(known.begin(), known.end(), channel.name) != known.end())
      mapping.channels[channel.name] = {{channel.name, 1.0}};
  }
  return mapping;
}

}  // namespace backbend::validate
