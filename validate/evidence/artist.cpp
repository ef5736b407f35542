#include "validate/evidence/artist.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "validate/text/escape.h"

namespace backbend::validate {
namespace {

/// One turn of one control, degrees.
struct Turn {
  std::string control, axis;
  double degrees = 0;
};

/// Which channel of the sidecar serves a channel of ours, and with which sign.
std::pair<std::string, double> served_by(const skin::Sidecar& sidecar, std::string_view channel) {
  const auto has = [&](std::string_view name) {
    return std::any_of(sidecar.controls.begin(), sidecar.controls.end(),
                       [&](const skin::SidecarControl& each) { return each.channel == name; });
  };
  if (has(channel)) return {std::string(channel), 1.0};
  if (channel == "extension" && has("flexion")) return {"flexion", -1.0};
  if (channel == "flexion" && has("extension")) return {"extension", -1.0};
  return {"", 0.0};
}

std::vector<Turn> turns_of(const skin::Sidecar& sidecar, const PoseDegrees& pose) {
  std::vector<Turn> turns;
  for (const std::string_view channel : kChannels) {
    const double degrees = *pose.find(channel);
    if (degrees == 0) continue;
    const auto [name, direction] = served_by(sidecar, channel);
    const auto count =
        std::count_if(sidecar.controls.begin(), sidecar.controls.end(),
                      [&, &name = name](const auto& each) { return each.channel == name; });
    if (count == 0) return {};
    for (const skin::SidecarControl& each : sidecar.controls) {
      if (each.channel != name) continue;
      // What a property holds at rest is not known here.
      if (!each.property.empty()) return {};
      const double share =
          each.per_degree != 0.0 ? each.per_degree : each.sign / static_cast<double>(count);
      const double turn = direction * share * degrees;
      const auto known = std::find_if(turns.begin(), turns.end(), [&](const Turn& other) {
        return other.control == each.control && other.axis == each.axis;
      });
      if (known == turns.end())
        turns.push_back({each.control, each.axis, turn});
      else
        known->degrees += turn;
    }
  }
  return turns;
}

}  // namespace

std::map<std::string, std::string> artist_lines(const skin::Sidecar& sidecar,
                                                const PoseDegrees& pose) {
  const std::vector<Turn> turns = turns_of(sidecar, pose);
  if (turns.empty()) return {};
  std::string maya = "from maya import cmds", blender = "import bpy, math";
  for (const Turn& turn : turns) {
    // A JSON string is a Python string.
    const std::string degrees = number_text(turn.degrees, 6);
    maya +=
        "; cmds.setAttr(" + json_text(turn.control + ".rotate" + turn.axis) + ", " + degrees + ")";
    blender += "; c = bpy.context.object.pose.bones[" + json_text(turn.control) +
               "]; c.rotation_mode = \"XYZ\" if c.rotation_mode in (\"QUATERNION\", "
               "\"AXIS_ANGLE\") else c.rotation_mode; c.rotation_euler[" +
               std::to_string(turn.axis.front() - 'X') + "] = math.radians(" + degrees + ")";
  }
  return {{"maya", maya}, {"blender", blender}};
}

std::string artist_script(const std::string& line, const std::string& note) {
  return "# " + visible(note) + "\n" + line + "\n";
}

}  // namespace backbend::validate
