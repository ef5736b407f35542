#include "cli/python/picture.h"

#include <pybind11/stl.h>

#include <glm/trigonometric.hpp>

#include "cli/python/arrays.h"
#include "cli/python/working.h"
#include "render/trace/modes.h"
#include "solver/rig/nearest_name.h"
#include "validate/evidence/pose_frame.h"
#include "validate/measure/measure.h"

namespace backbend::python {
namespace {

using namespace pybind11::literals;

int whole(const char* name, int value, int least, int most) {
  if (value < least || value > most)
    throw py::value_error(std::string(name) + ": expected " + std::to_string(least) + " to " +
                          std::to_string(most) + ", found " + std::to_string(value));
  return value;
}

render::Mode mode_of(const std::string& name) {
  const auto found = render::modes().find(name);
  if (found != render::modes().end()) return found->second;
  std::vector<std::string> names;
  for (const auto& [known, mode] : render::modes()) names.push_back(known);
  throw py::value_error("mode '" + name + "'" + solver::did_you_mean(name, names) +
                        ": expected beauty, clay, ao, matcap, wireframe, heat, xray, contour or "
                        "primary");
}

/// `N` of `N.X`, `N.Y`, `N.Z`; `RGBA` of R, G, B, A.
std::string name_of(const render::Layer& layer) {
  const std::string& first = layer.names.front();
  if (const std::size_t dot = first.rfind('.'); dot != std::string::npos)
    return first.substr(0, dot);
  std::string name;
  for (const std::string& channel : layer.names) name += channel;
  return name;
}

py::dict layers_of(render::Frame& frame) {
  py::dict layers;
  for (render::Layer& layer : frame.layers)
    layers[py::str(name_of(layer))] =
        array_of(std::move(layer.data), {frame.height, frame.width, length(layer.names.size())});
  return layers;
}

py::dict attributes_of(const render::Frame& frame) {
  py::dict attributes;
  for (const render::Attribute& attribute : frame.attributes)
    attributes[py::str(attribute.name)] = attribute.value;
  return attributes;
}

py::array matrix(const glm::dmat4& of) {
  return matrices_view(std::make_shared<std::vector<glm::dmat4>>(1, of), 1, 1)
      .attr("reshape")(4, 4)
      .cast<py::array>();
}

}  // namespace

py::object rendered(const std::shared_ptr<const Character>& character, const Rig& rig,
                    const std::string& mapping, const std::string& view, int width, int height,
                    int samples, const std::string& mode, std::uint32_t seed, bool all_layers,
                    bool transparent, bool denoise, py::handle given_heat,
                    const py::kwargs& channels) {
  if (rig.character != character)
    throw py::value_error("rig '" + rig.plan.name +
                          "' is not built on this character: Rig(spec, character)");
  const validate::Stage& stage = character->stage();
  render::Settings settings;
  settings.width = whole("width", width, 16, 16384);
  settings.height = whole("height", height, 16, 16384);
  settings.samples = whole("samples", samples, 1, 65535);
  settings.seed = seed;
  settings.mode = mode_of(mode);
  settings.all_layers = all_layers;
  settings.position_and_albedo = true;
  settings.transparent = transparent;
  settings.denoise = denoise;
  settings.heat_high = validate::kStrainHeatTop;
  const validate::PoseDegrees pose = pose_of(channels);
  if (const std::string why = validate::why_not_taken(*rig.system, pose); !why.empty())
    throw solver::RigError("rig '" + rig.plan.name + "' cannot take the pose: " + why);
  const std::vector<double> control = validate::controls_at(*rig.system, pose, mapping_of(mapping));
  std::vector<float> heat;
  if (!given_heat.is_none()) {
    const auto vertices = length(stage.character().vertex_count());
    const Numbers n =
        read_numbers(given_heat, "heat", std::to_string(vertices) + " values", {vertices});
    heat.assign(n.value.begin(), n.value.end());
  }
  render::Frame frame;
  run_long([&] {
    const validate::PosedCharacter posed = stage.pose(*rig.system, control);
    if (settings.mode == render::Mode::heat && heat.empty())
      heat = character->body().strain_heat(validate::rig_at_rest(*rig.system), control, posed.spine,
                                           posed.mesh, glm::radians(pose.twist));
    std::vector<render::OverlayLine> controllers;
    if (settings.mode == render::Mode::xray)
      controllers = validate::controller_lines(
          solver::controller_shapes(*rig.system, stage.rest_chain(), control));
    frame = validate::pose_frame(stage, posed, view, settings, heat, controllers);
  });
  return record("Picture",
                py::dict("layers"_a = layers_of(frame), "attributes"_a = attributes_of(frame),
                         "camera_from_world"_a = matrix(frame.camera_from_world),
                         "ndc_from_world"_a = matrix(frame.ndc_from_world)));
}

}  // namespace backbend::python
