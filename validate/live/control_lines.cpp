#include "validate/live/control_lines.h"

#include <vector>

#include "validate/metrics/math/rotation.h"
#include "validate/sweeps/sweep.h"
#include "validate/text/escape.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

// How the bridges call an axis of a rotation or a move, and Maya.
const std::map<std::string, std::string, std::less<>> kMayaNames = {
    {"rx", "rotateX"},   {"ry", "rotateY"},   {"rz", "rotateZ"},
    {"x", "translateX"}, {"y", "translateY"}, {"z", "translateZ"}};

struct Target {
  std::string control, channel, value;
};

Target target_of(const ChannelValue& each) {
  const std::size_t dot = each.channel.rfind('.');
  const bool split = dot != std::string::npos;
  return {split ? each.channel.substr(0, dot) : std::string(),
          split ? each.channel.substr(dot + 1) : each.channel, number_text(each.value, 6)};
}

// A JSON string is a Python string.
std::string maya_line(const Target& target) {
  const auto known = kMayaNames.find(target.channel);
  const std::string attribute = known == kMayaNames.end() ? target.channel : known->second;
  return "; cmds.setAttr(" + json_text(target.control + "." + attribute) + ", " + target.value +
         ")";
}

std::string blender_line(const Target& target, solver::Channel::Kind kind) {
  const std::size_t colon = target.control.find(':');
  const std::string bone = colon == std::string::npos
                               ? "bpy.context.object.pose.bones[" + json_text(target.control) + "]"
                               : "bpy.data.objects[" + json_text(target.control.substr(0, colon)) +
                                     "].pose.bones[" + json_text(target.control.substr(colon + 1)) +
                                     "]";
  const std::string axis(1, static_cast<char>('0' + target.channel.back() - 'x'));
  std::string line = "; c = " + bone + "; ";
  if (kind == solver::Channel::Kind::rotation)
    line +=
        "c.rotation_mode = \"XYZ\" if c.rotation_mode in (\"QUATERNION\", \"AXIS_ANGLE\") else "
        "c.rotation_mode; c.rotation_euler[" +
        axis + "] = math.radians(" + target.value + ")";
  else if (kind == solver::Channel::Kind::translation)
    line += "c.location[" + axis + "] = " + target.value;
  else
    line += "c[" + json_text(target.channel) + "] = " + target.value;
  return line;
}

}  // namespace

std::map<std::string, std::string> control_lines(const std::string& program,
                                                 std::span<const ChannelValue> values) {
  if (values.empty()) return {};
  const bool maya = program.starts_with("Maya");
  if (!maya && !program.starts_with("Blender")) return {};
  std::string line = maya ? "from maya import cmds" : "import bpy, math";
  for (const ChannelValue& each : values) {
    const Target target = target_of(each);
    line += maya ? maya_line(target) : blender_line(target, each.kind);
  }
  return {{maya ? "maya" : "blender", line}};
}

std::map<std::string, std::string> control_lines(const ExternalRig& rig,
                                                 std::span<const double> control) {
  std::vector<ChannelValue> values;
  for (Index c = 0; c < control.size(); ++c) {
    const solver::Channel& channel = rig.channels()[c];
    if (control[c] == channel.rest) continue;
    values.push_back(
        {channel.name, channel.kind,
         channel.kind == solver::Channel::Kind::rotation ? degrees(control[c]) : control[c]});
  }
  return control_lines(rig.hello().program, values);
}

}  // namespace backbend::validate
