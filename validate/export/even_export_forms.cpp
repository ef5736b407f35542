#include <nlohmann/json.hpp>

#include "skin/character/printable.h"
#include "validate/export/even_export.h"
#include "validate/export/script_files.h"
#include "validate/sweeps/suite.h"
#include "validate/text/json_object.h"

namespace backbend::validate {
namespace {

using nlohmann::ordered_json;

constexpr double kLimitDeg = 180.0;  // where the distance from the solver was measured

ordered_json numbers(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

template <class Matrix>
ordered_json columns(const Matrix& m) {
  ordered_json out = ordered_json::array();
  for (int column = 0; column < Matrix::length(); ++column)
    for (int row = 0; row < Matrix::length(); ++row) out.push_back(m[column][row]);
  return out;
}

void add_weights(ordered_json& to, const solver::EvenGraph::Weights& weight) {
  to["middle"] = {weight[0], weight[1], weight[2]};
  to["top"] = {weight[3], weight[4], weight[5]};
}

ordered_json graph_of(const EvenExport& from) {
  const solver::EvenGraph& graph = from.graph;
  ordered_json root = JsonObject<ordered_json>()
                          .with("schema", "backbend.even_graph/1")
                          .with("character", from.character)
                          .with("rig", rig_text(from.rig))
                          .with("length", graph.length)
                          .with("origin", numbers(graph.origin))
                          .with("left", numbers(from.left))
                          .with("limit_deg", kLimitDeg)
                          .with("hips", from.hips.name)
                          .with("hips_rest", columns(from.hips.rest))
                          .with("controls", ordered_json::array())
                          .with("samples", ordered_json::array())
                          .with("joints", ordered_json::array())
                          .with("followers", ordered_json::array());
  for (std::size_t k = 0; k < 3; ++k) {
    const solver::EvenGraph::Control& control = graph.control[k];
    root["controls"].push_back(JsonObject<ordered_json>()
                                   .with("name", control.name)
                                   .with("at", control.at)
                                   .with("place", numbers(control.place))
                                   .with("axes", columns(control.axes))
                                   .with("samples", control.samples)
                                   .with("half_size", from.half_size[k]));
  }
  for (const solver::EvenGraph::Sample& sample : graph.sample) {
    ordered_json entry =
        JsonObject<ordered_json>().with("at", sample.at).with("step", numbers(sample.step));
    add_weights(entry, sample.weight);
    root["samples"].push_back(std::move(entry));
  }
  for (const EvenExport::Joint& joint : from.joints) {
    const solver::EvenGraph::Joint& in_graph = graph.joint[joint.in_graph];
    ordered_json entry = JsonObject<ordered_json>()
                             .with("name", joint.name)
                             .with("at", in_graph.at)
                             .with("frame_at", in_graph.frame_at)
                             .with("place", numbers(in_graph.place))
                             .with("samples", in_graph.samples)
                             .with("rest", columns(joint.rest));
    add_weights(entry, in_graph.weight);
    root["joints"].push_back(std::move(entry));
  }
  for (const EvenExport::Follower& follower : from.followers)
    root["followers"].push_back(
        JsonObject<ordered_json>().with("name", follower.name).with("leader", follower.leader));
  root["distance"] = JsonObject<ordered_json>()
                         .with("poses", from.distance.poses)
                         .with("place_percent", 100.0 * from.distance.place)
                         .with("turn_deg", from.distance.turn_deg);
  return root;
}

/// The script with the graph in the place of `@GRAPH@`, inside a Python string: two levels of
/// escapes, and only ASCII.
std::string with_graph(std::string_view script, const EvenExport& from) {
  const std::string data =
      graph_of(from).dump(-1, ' ', true, ordered_json::error_handler_t::replace);
  std::string quoted;
  for (const char c : data) {
    if (c == '\\' || c == '"') quoted += '\\';
    quoted += c;
  }
  constexpr std::string_view kPlace = "@GRAPH@";
  std::string out(script);
  return out.replace(out.find(kPlace), kPlace.size(), quoted);
}

}  // namespace

std::string even_graph_json(const EvenExport& from) {
  return graph_of(from).dump(1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

std::string even_blender_script(const EvenExport& from) {
  return with_graph(scripts::blender_even(), from);
}

std::string even_maya_script(const EvenExport& from) {
  return with_graph(scripts::maya_even(), from);
}

std::string even_export_text(const EvenExport& from) {
  std::vector<std::string> joints;
  for (const EvenExport::Joint& joint : from.joints) joints.push_back(joint.name);
  std::vector<std::string> arms;
  for (const EvenExport::Follower& follower : from.followers)
    arms.push_back(skin::in_quotes(follower.name) + " with " + skin::in_quotes(follower.leader));
  std::string out = "even on " + skin::plural(joints.size(), "joint") + " of " +
                    skin::printable(from.character) + " above " + skin::in_quotes(from.hips.name) +
                    ": " + skin::list_in_quotes(joints) +
                    "\n  controls   lower, middle, top; limits +-" + skin::number_text(kLimitDeg) +
                    " deg\n  distance   " + skin::number_text(100.0 * from.distance.place, 2) +
                    " % of the spine's length at most, and no turn, from the exact spine (" +
                    skin::plural(from.graph.sample.size(), "step") + ", " +
                    skin::count_text(static_cast<std::size_t>(from.distance.poses)) +
                    " poses to +-" + skin::number_text(kLimitDeg) + " deg)\n";
  for (const std::string& arm : arms) out += "  goes along " + arm + "\n";
  if (!from.apart.empty())
    out += "  left as is " + skin::list_in_quotes(from.apart) +
           ": the file hangs it from another joint than our pictures move it with\n";
  return out;
}

}  // namespace backbend::validate
