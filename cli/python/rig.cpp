#include "cli/python/rig.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <glm/trigonometric.hpp>

#include "cli/python/character.h"
#include "cli/python/python_rig.h"
#include "cli/python/working.h"
#include "solver/rig/crowd.h"
#include "solver/rig/solve_file.h"
#include "validate/measure/measure.h"
#include "validate/sweeps/external_spec.h"

namespace backbend::python {
namespace {

using Index = std::size_t;
using namespace pybind11::literals;

constexpr Index kPosesBetweenLooks = 4096;  // for signals: some milliseconds of work

bool turns(const solver::Channel& channel) {
  return channel.kind == solver::Channel::Kind::rotation;
}

/// One value of a rig's option. Text, truth, a number, numbers or rows of numbers, of NumPy's, too.
solver::OptionValue option_of(const std::string& name, py::handle given) {
  py::object value = py::reinterpret_borrow<py::object>(given);
  if (py::hasattr(value, "dtype") && py::hasattr(value, "tolist")) value = value.attr("tolist")();
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>();
  if (py::isinstance<py::str>(value)) return text_from(value, "option '" + name + "'");
  if (py::isinstance<py::float_>(value) || py::isinstance<py::int_>(value)) {
    const double number = PyFloat_AsDouble(value.ptr());
    if (PyErr_Occurred() == nullptr) return number;
    PyErr_Clear();
    throw py::value_error("option '" + name + "': the number is too large");
  }
  if (py::isinstance<py::sequence>(value)) {
    const bool rows = py::len(value) > 0 && !PyNumber_Check(py::object(value[py::int_(0)]).ptr());
    try {
      if (rows) return value.cast<std::vector<std::vector<double>>>();
      return value.cast<std::vector<double>>();
    } catch (const py::cast_error&) {
      // told below
    }
  }
  throw py::type_error("option '" + name +
                       "': expected text, true or false, a number, numbers, or rows of numbers");
}

py::object option_for_python(const solver::OptionValue& value) {
  return std::visit([](const auto& v) -> py::object { return py::cast(v); }, value);
}

std::vector<glm::dvec3> read_points(py::handle from, const std::string& what) {
  const Numbers numbers = read_numbers(from, what, "N x 3 numbers", {-1, 3});
  std::vector<glm::dvec3> out;
  for (Index i = 0; i + 2 < numbers.value.size(); i += 3)
    out.emplace_back(numbers.value[i], numbers.value[i + 1], numbers.value[i + 2]);
  return out;
}

glm::dvec3 read_point(py::handle from, const std::string& what) {
  const Numbers n = read_numbers(from, what, "3 numbers", {3});
  return {n.value[0], n.value[1], n.value[2]};
}

/// `backbend.Chain`, or joints alone.
solver::RestChain chain_of(py::handle from) {
  solver::RestChain chain;
  if (!py::hasattr(from, "joints")) {
    chain.joint = read_points(from, "chain");
    return chain;
  }
  chain.joint = read_points(from.attr("joints"), "joints");
  chain.left = read_point(from.attr("left"), "left");
  if (const py::object curve = from.attr("curve"); !curve.is_none())
    chain.curve = read_points(curve, "curve");
  if (const py::object path = from.attr("path"); !path.is_none()) {
    chain.path.point = read_points(path, "path");
    chain.path.up = read_point(from.attr("up"), "up");
  }
  if (const py::object frames = from.attr("frames"); !frames.is_none()) {
    const Numbers numbers = read_numbers(frames, "frames", "N x 4 x 4 numbers", {-1, 4, 4});
    const std::vector<glm::dmat4> matrices = matrices_of(numbers);
    const auto names = from.attr("frame_names").cast<std::vector<std::string>>();
    if (names.size() != matrices.size())
      throw py::value_error("frame_names: expected a name for each of " +
                            std::to_string(matrices.size()) + " frames, found " +
                            std::to_string(names.size()));
    for (Index i = 0; i < matrices.size(); ++i) chain.frame.push_back({names[i], matrices[i]});
  }
  return chain;
}

validate::RigPlan plan_with_options(py::handle spec, const py::kwargs& options) {
  validate::RigPlan plan = plan_of(spec);
  for (const auto& [key, value] : options) {
    const std::string name = text_from(key, "the name of an option");
    plan.spec.options[name] = option_of(name, value);
  }
  return plan;
}

std::shared_ptr<Rig> make_rig(py::handle spec, py::handle on, const py::kwargs& options) {
  auto rig = std::make_shared<Rig>();
  rig->plan = plan_with_options(spec, options);
  if (py::isinstance<PythonRig>(spec)) rig->python = py::reinterpret_borrow<py::object>(spec);
  if (!py::isinstance<Character>(on)) {
    if (rig->python || validate::is_external(rig->plan.spec))
      throw py::type_error("a rig of your own needs a character, not a chain");
    rig->system = solver::build_system(rig->plan.spec, chain_of(on));
    return rig;
  }
  rig->character = on.cast<std::shared_ptr<const Character>>();
  // A rig of the user's own is asked when it is built.
  if (validate::is_external(rig->plan.spec))
    run_long([&] { rig->system = rig->character->stage().build(rig->plan.spec); });
  else
    rig->system = rig->character->stage().build(rig->plan.spec);
  return rig;
}

/// A pose file's rig, and its control values.
py::tuple read_pose_file(const std::filesystem::path& file) {
  solver::SolveFile read = solver::read_solve_file(file);
  auto rig = std::make_shared<Rig>();
  rig->plan.name = read.system->name();
  rig->plan.spec = {std::string(read.system->name()), read.system->options()};
  rig->system = std::move(read.system);
  std::vector<double> control = read.control;
  for (Index c = 0; c < control.size(); ++c)
    if (turns(rig->system->channels()[c])) control[c] = glm::degrees(control[c]);
  const auto width = length(control.size());
  return py::make_tuple(rig, array_of(std::move(control), {width}));
}

/// Channel after channel, each with its poses, as crowds have them.
std::vector<double> by_channel(const std::vector<double>& rows, Index channels, Index poses) {
  std::vector<double> out(rows.size());
  for (Index p = 0; p < poses; ++p)
    for (Index c = 0; c < channels; ++c) out[c * poses + p] = rows[p * channels + c];
  return out;
}

void solve_in_steps(const solver::SpineSystem& system, const std::vector<double>& rows, Index poses,
                    solver::CrowdPose& out, Unlocked& unlocked) {
  const std::vector<double> value = by_channel(rows, system.channels().size(), poses);
  out.resize(system.joint_names().size(), poses);
  for (Index first = 0; first < poses; first += kPosesBetweenLooks) {
    if (first > 0) unlocked.check_signals();
    const Index last = std::min(first + kPosesBetweenLooks, poses);
    solver::solve_crowd(system, {value, poses}, {first, last}, out);
  }
}

/// What a system says of each pose beside its joints.
py::dict measures_of(const solver::SpineSystem& system, const std::vector<double>& rows,
                     Index poses) {
  const Index channels = system.channels().size();
  std::map<std::string, std::vector<double>> measures;
  std::vector<std::vector<std::string>> flags(poses);
  std::vector<double> margins;
  Index joints_with_margin = 0;
  {
    Unlocked unlocked(Needs::threads);
    for (Index p = 0; p < poses; ++p) {
      solver::SpinePose pose = system.solve(std::span(rows).subspan(p * channels, channels));
      for (const solver::Measure& m : pose.measures) {
        std::vector<double>& values = measures[m.name];
        values.resize(poses, std::numeric_limits<double>::quiet_NaN());
        values[p] = m.value;
      }
      flags[p] = std::move(pose.flags);
      joints_with_margin = pose.flip_margin.size();
      for (const double margin : pose.flip_margin) margins.push_back(glm::degrees(margin));
      if (p % kPosesBetweenLooks == kPosesBetweenLooks - 1) unlocked.check_signals();
    }
  }
  py::dict named;
  for (auto& [name, values] : measures) named[py::str(name)] = array_of(values, {length(poses)});
  py::object margin = py::none();
  if (joints_with_margin > 0)
    margin = array_of(std::move(margins), {length(poses), length(joints_with_margin)});
  return py::dict("measures"_a = named, "flags"_a = flags, "flip_margin_deg"_a = margin);
}

/// Positions, turns and flags over the memory that they were solved into.
py::object solved(const Rig& rig, py::handle controls, bool measures) {
  Index poses = 0;
  const std::vector<double> rows = read_controls(controls, *rig.system, poses);
  auto crowd = std::make_shared<solver::CrowdPose>();
  if (validate::is_external(rig.plan.spec)) {
    run_long([&] {
      std::vector<std::vector<double>> asked;
      const Index channels = rig.system->channels().size();
      for (Index p = 0; p < poses; ++p)
        asked.emplace_back(rows.begin() + length(p * channels),
                           rows.begin() + length((p + 1) * channels));
      rig.system->prepare(asked, solver::Detail::joints);
      solver::solve_crowd(*rig.system, {by_channel(rows, channels, poses), poses}, *crowd);
    });
  } else {
    Unlocked unlocked(Needs::nothing);
    solve_in_steps(*rig.system, rows, poses, *crowd, unlocked);
  }
  const py::ssize_t n = length(poses), joints = length(crowd->joint_count());
  constexpr py::ssize_t kNumber = sizeof(double);
  const std::vector<py::ssize_t> strides = {kNumber, 7 * n * kNumber, n * kNumber};
  const solver::CrowdPose& read = *crowd;
  py::dict out(
      "positions"_a =
          view_of<double>(read.position(0, 0).data(), {n, joints, 3}, crowd, strides, true),
      "turns"_a = view_of<double>(read.turn(0, 0).data(), {n, joints, 4}, crowd, strides, true),
      "flagged"_a = view_of<bool>(reinterpret_cast<const bool*>(read.flagged().data()), {n}, crowd,
                                  {}, true));
  if (measures) out.attr("update")(measures_of(*rig.system, rows, poses));
  return record("Poses", out);
}

py::array controls_for(const Rig& rig, const std::string& mapping, const py::kwargs& channels) {
  const validate::PoseDegrees pose = pose_of(channels);
  std::vector<double> control = validate::controls_at(*rig.system, pose, mapping_of(mapping));
  if (const std::string why = validate::why_not_taken(*rig.system, pose); !why.empty())
    throw solver::RigError("rig '" + rig.plan.name + "' cannot take the pose: " + why);
  for (Index c = 0; c < control.size(); ++c)
    if (turns(rig.system->channels()[c])) control[c] = glm::degrees(control[c]);
  const auto width = length(control.size());
  return array_of(std::move(control), {width});
}

std::vector<std::string> channel_names(const Rig& rig) {
  std::vector<std::string> names;
  for (const solver::Channel& channel : rig.system->channels()) names.push_back(channel.name);
  return names;
}

py::dict channel_units(const Rig& rig) {
  py::dict units;
  for (const solver::Channel& channel : rig.system->channels())
    units[py::str(channel.name)] = channel.kind == solver::Channel::Kind::rotation      ? "degrees"
                                   : channel.kind == solver::Channel::Kind::translation ? "length"
                                                                                        : "number";
  return units;
}

py::array rest_controls(const Rig& rig) {
  std::vector<double> rest;
  for (const solver::Channel& channel : rig.system->channels())
    rest.push_back(turns(channel) ? glm::degrees(channel.rest) : channel.rest);
  const auto width = length(rest.size());
  return array_of(std::move(rest), {width});
}

py::dict options_of(const Rig& rig) {
  py::dict options;
  for (const auto& [key, value] : rig.system->options())
    options[py::str(key)] = option_for_python(value);
  return options;
}

py::array rest_positions(const std::shared_ptr<const Rig>& rig) {
  const std::vector<glm::dvec3>& joints = rig->system->rest().position;
  return view_of<double>(&joints.data()->x, {length(joints.size()), 3}, rig);
}

py::array intended_curve(const Rig& rig, py::handle controls, Index count) {
  if (count < 2 || count > 100'000)
    throw py::value_error("count: expected 2 to 100000 points, found " + std::to_string(count));
  Index poses = 0;
  const std::vector<double> rows = read_controls(controls, *rig.system, poses);
  if (poses != 1) throw py::value_error("controls: expected those of one pose");
  std::vector<glm::dvec3> curve;
  run_long([&] { curve = rig.system->intended_curve(rows, count); });
  const auto points = length(curve.size());
  auto owner = std::make_shared<const std::vector<glm::dvec3>>(std::move(curve));
  return view_of<double>(&owner->data()->x, {points, 3}, owner, {}, true);
}

}  // namespace

validate::RigPlan plan_of(py::handle rig) {
  if (py::isinstance<Rig>(rig)) return rig.cast<const Rig&>().plan;
  if (py::isinstance<PythonRig>(rig)) return rig.cast<const PythonRig&>().plan();
  if (py::isinstance<py::str>(rig)) return validate::read_rig(text_from(rig, "rig"));
  if (py::hasattr(rig, "__fspath__"))
    return validate::read_rig(text_from(py::str(rig.attr("__fspath__")()), "rig"));
  throw py::type_error("rig: expected a system's name, a rig file, a Rig or a PythonRig");
}

std::vector<double> read_controls(py::handle controls, const solver::SpineSystem& system,
                                  std::size_t& poses) {
  const std::vector<solver::Channel>& channels = system.channels();
  Numbers numbers =
      read_rows(controls, "controls", "N x " + std::to_string(channels.size()) + " channels",
                length(channels.size()));
  poses = static_cast<Index>(numbers.shape[0]);
  for (Index p = 0; p < poses; ++p)
    for (Index c = 0; c < channels.size(); ++c)
      if (double& value = numbers.value[p * channels.size() + c]; turns(channels[c]))
        value = glm::radians(value);
  return std::move(numbers.value);
}

solver::Mapping mapping_of(const std::string& name) {
  const auto mapping = validate::find_mapping(name);
  if (!mapping) throw py::value_error("mapping '" + name + "': expected chest or spread");
  return *mapping;
}

void bind_rig(py::module_& module) {
  py::class_<Rig, std::shared_ptr<Rig>>(
      module, "Rig",
      "A spine rig on a chain or on a character. Immutable: a pose is a function of its controls.")
      .def(py::init(&make_rig), "spec"_a, "on"_a,
           "spec: a system's name (backbend list rigs), the same with options "
           "('curve:length=rest'), a rig file, your own rig ('blender:FILE', "
           "'command:PROGRAM ARGS') or a PythonRig. on: a Character, a Chain, or joints from the "
           "hips up, N x 3 in rig space (+Y up, facing +Z). Options may be given by keyword, as in "
           "a rig file.")
      .def_static("from_file", &read_pose_file, "file"_a,
                  "The rig and the control values (channels, degrees and lengths) of a pose file, "
                  "the TOML that `backbend solve` takes.")
      .def_property_readonly(
          "name", [](const Rig& rig) { return rig.plan.name; }, "As reports have it.")
      .def_property_readonly(
          "system", [](const Rig& rig) { return std::string(rig.system->name()); },
          "Of `backbend list rigs`; external for a rig of your own.")
      .def_property_readonly("options", &options_of, "Every option with its value.")
      .def_property_readonly("channels", &channel_names,
                             "Names of the control channels, in the order of controls.")
      .def_property_readonly("units", &channel_units,
                             "By channel: degrees, length (the chain's unit) or number.")
      .def_property_readonly("rest_controls", &rest_controls,
                             "The channels of the untouched rig: degrees, lengths, numbers.")
      .def_property_readonly(
          "joints", [](const Rig& rig) { return rig.system->joint_names(); },
          "Names of the joints that it poses, hips first.")
      .def_property_readonly(
          "parents", [](const Rig& rig) { return rig.system->joint_parents(); },
          "Parent of each joint, -1 for none.")
      .def_property_readonly("rest_positions", &rest_positions,
                             "Joints at rest, joints x 3, rig space. A view; read-only.")
      .def_property_readonly(
          "arc_fractions", [](const Rig& rig) { return rig.system->arc_fraction(); },
          "Where each joint stands on the rest chain, 0 hips .. 1 chest.")
      .def("solve", &solved, "controls"_a, py::kw_only(), "measures"_a = false,
           "Solves N poses. controls: N x channels, or channels for one pose, in degrees, lengths "
           "and numbers (units). Returns Poses: positions (N x joints x 3, rig space), turns from "
           "rest (N x joints x 4: w, x, y, z), flagged (N: whether a documented fallback was "
           "needed); with measures also measures (name: N), flags (names for each pose) and "
           "flip_margin_deg (N x joints, to the nearest singular pose; None: there is none).")
      .def("controls", &controls_for, py::kw_only(), "mapping"_a = "chest",
           "The control values (channels) that stand for a body pose: extension=90, side=10, "
           "in degrees; stretch in per cent.")
      .def("intended_curve", &intended_curve, "controls"_a, "count"_a = 257,
           "The curve that the chain is meant to follow in one pose: count x 3, hips first.");
}

}  // namespace backbend::python
