#include "cli/python/character.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <functional>

#include "cli/python/arrays.h"
#include "cli/python/picture.h"
#include "cli/python/rig.h"
#include "cli/python/working.h"
#include "skin/anatomy/anatomy_hints.h"
#include "skin/weights/inspect.h"
#include "validate/judge/confirmed.h"
#include "validate/judge/measured_series.h"
#include "validate/night/standard_runs.h"
#include "validate/stage/pose_many.h"
#include "validate/sweeps/external_spec.h"
#include "validate/sweeps/sweep_named.h"

namespace backbend::python {
namespace {

using Index = std::size_t;
using namespace pybind11::literals;
using Shared = std::shared_ptr<const Character>;

const skin::Character& mesh(const Shared& character) { return character->stage().character(); }

Shared load(const std::filesystem::path& file, const std::string& chain, const std::string& hip,
            const std::string& chest, std::vector<std::string> spine,
            std::vector<std::string> left_arm, std::vector<std::string> right_arm,
            const std::string& rig_template, const std::string& up, const std::string& forward) {
  if (chain != "" && chain != "spine" && chain != "neck")
    throw py::value_error("chain '" + chain + "': expected spine or neck");
  skin::AnatomyHints hints{
      hip,          chest, std::move(spine), std::move(left_arm), std::move(right_arm),
      rig_template, up,    forward};
  Shared character;
  run_long([&] { character = std::make_shared<const Character>(file, hints, chain); });
  return character;
}

/// A view of one array of vectors that the character owns.
template <typename Vector>
py::array vectors(const Shared& character, const std::vector<Vector>& of) {
  constexpr int kWidth = Vector::length();
  using Number = typename Vector::value_type;
  const auto* data = reinterpret_cast<const Number*>(of.data());
  return view_of<Number>(data, {length(of.size()), kWidth}, character);
}

py::array weights(const Shared& character) {
  const std::vector<skin::Influences>& of = mesh(character).influences;
  const float* data = of.empty() ? nullptr : of.front().weight.data();
  return view_of<float>(data, {length(of.size()), skin::kMaxInfluences}, character,
                        {sizeof(skin::Influences), sizeof(float)});
}

/// Into the skeleton's joints; where the weight is 0 the joint of the first.
py::array weight_joints(const Shared& character) {
  std::vector<std::int32_t> joints;
  for (const skin::Influences& vertex : mesh(character).influences)
    for (const std::uint16_t joint : vertex.joint)
      joints.push_back(mesh(character).joints.empty() ? 0 : mesh(character).joints[joint].node);
  const py::ssize_t vertices = length(joints.size()) / skin::kMaxInfluences;
  return array_of(std::move(joints), {vertices, skin::kMaxInfluences});
}

std::vector<std::string> joint_names(const Shared& character) {
  return skin::reference_names(mesh(character));
}

std::vector<int> parents(const Shared& character) {
  std::vector<int> out;
  for (const skin::Node& node : mesh(character).nodes) out.push_back(node.parent);
  return out;
}

py::array rest_matrices(const Shared& character) {
  const std::vector<skin::Node>& nodes = mesh(character).nodes;
  constexpr py::ssize_t kNumber = sizeof(double);
  return view_of<double>(nodes.empty() ? nullptr : &nodes.front().world_from_node[0][0],
                         {length(nodes.size()), 4, 4}, character,
                         {sizeof(skin::Node), kNumber, 4 * kNumber});
}

py::object anatomy(const Shared& character) {
  const skin::Anatomy& found = character->stage().anatomy();
  const std::vector<std::string> name_of = joint_names(character);
  const auto names = [&](const std::vector<int>& nodes) {
    std::vector<std::string> out;
    for (const int n : nodes) out.push_back(name_of[static_cast<Index>(n)]);
    return out;
  };
  const auto vector = [](const glm::dvec3& v) { return py::make_tuple(v.x, v.y, v.z); };
  const auto driven = length(found.chest_index) + 1;
  return record(
      "Record",
      py::dict("spine"_a = names({found.spine.begin(), found.spine.begin() + driven}),
               "spine_to_head"_a = names(found.spine), "left_arm"_a = names(found.left_arm),
               "right_arm"_a = names(found.right_arm), "left_leg"_a = names(found.left_leg),
               "right_leg"_a = names(found.right_leg), "tail"_a = names(found.tail),
               "up"_a = vector(found.up), "forward"_a = vector(found.forward),
               "left"_a = vector(found.left), "height"_a = found.height,
               "spine_length"_a = found.spine_length, "sure"_a = found.sure(),
               "doubts"_a = found.doubts, "reasons"_a = found.reasons));
}

py::array chain(const Shared& character) {
  return vectors(character, character->stage().rest_chain().joint);
}

/// Memory for points of all vertices in all poses: new, or `given` by the caller.
py::array_t<float> points_for(py::handle given, const char* what, py::ssize_t poses,
                              py::ssize_t vertices) {
  if (given.is_none()) return py::array_t<float>({poses, vertices, py::ssize_t{3}});
  const std::string words = std::to_string(poses) + " x " + std::to_string(vertices) + " x 3";
  if (!py::isinstance<py::array_t<float, py::array::c_style>>(given))
    throw py::type_error(std::string(what) + ": expected a float32 array in C order, " + words);
  auto array = py::reinterpret_borrow<py::array_t<float>>(given);
  if (array.ndim() != 3 || array.shape(0) != poses || array.shape(1) != vertices ||
      array.shape(2) != 3)
    throw py::value_error(std::string(what) + ": expected " + words);
  if (!array.writeable()) throw py::value_error(std::string(what) + ": the array is read-only");
  if (reinterpret_cast<std::uintptr_t>(array.data()) % alignof(float) != 0)
    throw py::value_error(std::string(what) + ": the array's memory is not aligned to its numbers");
  return array;
}

struct Points {
  py::array_t<float> positions, normals;

  std::span<glm::vec3> position() { return span(positions); }
  std::span<glm::vec3> normal() { return span(normals); }

 private:
  static std::span<glm::vec3> span(py::array_t<float>& array) {
    return {reinterpret_cast<glm::vec3*>(array.mutable_data()),
            static_cast<Index>(array.size()) / 3};
  }
};

Points points_of(const Shared& character, Index poses, py::handle out) {
  py::object positions = py::none(), normals = py::none();
  if (!out.is_none()) {
    if (!py::isinstance<py::tuple>(out) || py::len(out) != 2)
      throw py::type_error("out: expected (positions, normals)");
    positions = out[py::int_(0)];
    normals = out[py::int_(1)];
  }
  const py::ssize_t vertices = length(mesh(character).vertex_count());
  Points points = {points_for(positions, "out positions", length(poses), vertices),
                   points_for(normals, "out normals", length(poses), vertices)};
  const std::span<glm::vec3> position = points.position(), normal = points.normal();
  if (std::less<>()(position.data(), normal.data() + normal.size()) &&
      std::less<>()(normal.data(), position.data() + position.size()))
    throw py::value_error("out: positions and normals share memory");
  return points;
}

/// One pose: the arrays are the memory that it was skinned into.
py::object skinned_once(const Shared& character, const std::vector<glm::dmat4>& world_from_node) {
  const std::shared_ptr<skin::PosedMesh> out = character->mesh_to_skin_into();
  {
    const Unlocked unlocked(Needs::threads);
    character->plan().skin(world_from_node, *out);
  }
  const py::ssize_t vertices = length(out->position.size());
  const auto view = [&](const std::vector<glm::vec3>& of) {
    return view_of<float>(reinterpret_cast<const float*>(of.data()), {1, vertices, 3}, out, {},
                          true);
  };
  return record("SkinnedPoses",
                py::dict("positions"_a = view(out->position), "normals"_a = view(out->normal)));
}

py::object skinned(const Shared& character, py::handle matrices, py::handle out) {
  const Index nodes = mesh(character).nodes.size();
  const std::vector<glm::dmat4> world_from_node =
      read_matrices(matrices, "matrices", length(nodes));
  const Index poses = world_from_node.size() / std::max<Index>(1, nodes);
  if (poses == 1 && out.is_none()) return skinned_once(character, world_from_node);
  Points points = points_of(character, poses, out);
  const std::span<glm::vec3> position = points.position(), normal = points.normal();
  {
    const Unlocked unlocked(Needs::threads);
    validate::skin_many(character->plan(), nodes, world_from_node, position, normal);
  }
  return record("SkinnedPoses",
                py::dict("positions"_a = points.positions, "normals"_a = points.normals));
}

void require_same(const Shared& character, const Rig& rig) {
  if (rig.character != character)
    throw py::value_error("rig '" + rig.plan.name +
                          "' is not built on this character: Rig(spec, character)");
}

py::object posed(const Shared& character, const Rig& rig, py::handle controls, py::handle out) {
  require_same(character, rig);
  Index poses = 0;
  const std::vector<double> rows = read_controls(controls, *rig.system, poses);
  Points points = points_of(character, poses, out);
  const Index nodes = mesh(character).nodes.size();
  const auto matrices = std::make_shared<std::vector<glm::dmat4>>(poses * nodes);
  const validate::ManyPoses to{points.position(), points.normal(), *matrices};
  const auto work = [&] { validate::pose_many(character->stage(), *rig.system, rows, to); };
  // A rig of the user's own may take its time, and work for many poses does.
  constexpr Index kFewVertices = 4'000'000;
  if (!validate::is_external(rig.plan.spec) &&
      poses * mesh(character).vertex_count() < kFewVertices) {
    const Unlocked unlocked(Needs::threads);
    work();
  } else {
    run_long(work);
  }
  return record("SkinnedPoses",
                py::dict("positions"_a = points.positions, "normals"_a = points.normals,
                         "matrices"_a = matrices_view(matrices, length(poses), length(nodes))));
}

py::object series(validate::SweepSeries of) {
  py::dict metrics, units, limits;
  const py::ssize_t poses = length(of.control_deg.size());
  for (auto& [name, values] : of.metric)
    metrics[py::str(name)] = array_of(std::move(values), {poses});
  for (const auto& [name, unit] : of.metric_unit) units[py::str(name)] = unit;
  for (const auto& [name, limit] : of.metric_limit)
    limits[py::str(name)] = std::isfinite(limit) ? py::object(py::float_(limit)) : py::none();
  return record("Series",
                py::dict("sweep"_a = of.sweep, "channel"_a = of.channel, "mapping"_a = of.mapping,
                         "control_deg"_a = array_of(std::move(of.control_deg), {poses}),
                         "metric"_a = metrics, "unit"_a = units, "limit"_a = limits));
}

py::object measured(const Shared& character, const Rig& rig, const std::string& mapping,
                    const py::kwargs& channels) {
  require_same(character, rig);
  const validate::PoseDegrees pose = pose_of(channels);
  const solver::Mapping way = mapping_of(mapping);
  validate::SweepSeries found;
  run_long([&] {
    found = validate::measure_one_pose(character->stage(), character->body(), rig.plan, way, pose);
  });
  return series(std::move(found));
}

py::object measured_sweep(const Shared& character, const Rig& rig, const std::string& name,
                          const std::string& mapping) {
  require_same(character, rig);
  const validate::Sweep sweep = validate::sweep_named(name);
  const solver::Mapping way = mapping_of(mapping);
  validate::SweepSeries found;
  run_long([&] {
    found = validate::measure_sweep(character->stage(), character->body(), rig.plan, way, sweep);
  });
  return series(std::move(found));
}

py::object inspected(const Shared& character) {
  std::string text;
  {
    const Unlocked unlocked(Needs::threads);
    text = skin::inspect_json(mesh(character), character->stage().anatomy());
  }
  return py::module_::import("backbend").attr("_record_of")(text);
}

}  // namespace

Character::Character(std::filesystem::path file, skin::AnatomyHints hints, const std::string& chain)
    : file_(std::move(file)), hints_(std::move(hints)), chain_(chain) {
  validate::ConfirmedCharacter confirmed = validate::load_confirmed(file_, hints_);
  auto controls =
      confirmed.sidecar ? confirmed.sidecar->controls : std::vector<skin::SidecarControl>();
  stage_ = std::make_unique<const validate::Stage>(
      std::move(confirmed.character), confirmed.hints,
      chain == "neck" ? validate::DrivenChain::neck : validate::DrivenChain::spine,
      std::move(controls));
}

const skin::SkinningPlan& Character::plan() const {
  std::call_once(plan_made_,
                 [&] { plan_ = std::make_unique<const skin::SkinningPlan>(stage_->character()); });
  return *plan_;
}

const validate::BodyMetrics& Character::body() const {
  std::call_once(body_made_, [&] {
    body_ = std::make_unique<const validate::BodyMetrics>(stage_->character(), stage_->anatomy(),
                                                          stage_->driver());
  });
  return *body_;
}

std::shared_ptr<skin::PosedMesh> Character::mesh_to_skin_into() const {
  // New memory costs page faults at every call.
  std::unique_ptr<skin::PosedMesh> mesh;
  {
    const std::lock_guard lock(spare_->mutex);
    mesh = std::move(spare_->mesh);
  }
  if (!mesh) mesh = std::make_unique<skin::PosedMesh>();
  return {mesh.release(), [spare = spare_](skin::PosedMesh* done) {
            std::unique_ptr<skin::PosedMesh> back(done);
            const std::lock_guard lock(spare->mutex);
            std::swap(spare->mesh, back);
          }};
}

validate::PoseDegrees pose_of(const py::kwargs& channels) {
  std::string text;
  for (const auto& [key, value] : channels) {
    const std::string name = text_from(key, "the name of a channel");
    const double degrees = PyFloat_AsDouble(value.ptr());
    if (PyErr_Occurred() != nullptr) {
      PyErr_Clear();
      throw py::type_error(name + ": expected a number of degrees");
    }
    text +=
        (text.empty() ? "" : ",") + name + "=" + py::repr(py::float_(degrees)).cast<std::string>();
  }
  return validate::parse_pose(text);
}

void bind_character(py::module_& module) {
  py::class_<Character, std::shared_ptr<Character>>(
      module, "Character",
      "A character from a file: mesh, skeleton, weights, the spine as found. Made by load(). "
      "Immutable; its arrays are read-only views that keep it alive. World space: right-handed, "
      "+Y up, the file's unit.")
      .def_property_readonly(
          "name", [](const Shared& c) { return mesh(c).name; }, "As reports have it.")
      .def_property_readonly(
          "path", [](const Shared& c) { return c->file().string(); }, "The file it was read from.")
      .def_property_readonly(
          "positions", [](const Shared& c) { return vectors(c, c->stage().rest().position); },
          "Vertices at rest, vertices x 3, float32, world space.")
      .def_property_readonly(
          "normals", [](const Shared& c) { return vectors(c, c->stage().rest().normal); },
          "Unit normals at rest, vertices x 3, float32.")
      .def_property_readonly(
          "triangles", [](const Shared& c) { return vectors(c, mesh(c).triangles); },
          "Vertices of each triangle, triangles x 3, uint32.")
      .def_property_readonly(
          "uv", [](const Shared& c) { return vectors(c, mesh(c).uv); },
          "Texture coordinates, vertices x 2, float32; 0 x 2 where there are none.")
      .def_property_readonly("weights", &weights,
                             "Weights, vertices x 8, float32, largest first; they sum to 1.")
      .def_property_readonly("weight_joints", &weight_joints,
                             "The joint of each weight, vertices x 8, int32, into joints.")
      .def_property_readonly("joints", &joint_names,
                             "Names of the skeleton's nodes; `#12`, the file's node 12, where "
                             "others share its name.")
      .def_property_readonly("parents", &parents, "Parent of each joint, -1 for none.")
      .def_property_readonly("rest_matrices", &rest_matrices,
                             "World from joint at rest, joints x 4 x 4, column vectors.")
      .def_property_readonly("chain", &chain,
                             "The driven spine at rest, hips to chest, N x 3, world space.")
      .def_property_readonly("anatomy", &anatomy,
                             "Spine, arms, legs and tail as found (names of joints), axes, height "
                             "and spine length, and why.")
      .def("inspect", &inspected, "What `backbend inspect --json` prints, backbend.inspect/1.")
      .def("skin", &skinned, "matrices"_a, py::kw_only(), "out"_a = py::none(),
           "Skins by world-from-joint matrices, N x joints x 4 x 4 or joints x 4 x 4. Returns "
           "positions and normals, N x vertices x 3, float32. out: (positions, normals) of that "
           "shape, to be written instead of new arrays.")
      .def("pose", &posed, "rig"_a, "controls"_a, py::kw_only(), "out"_a = py::none(),
           "The body in N poses of a rig that is built on it. controls: N x channels, degrees. "
           "Returns positions and normals as skin() does, and matrices, N x joints x 4 x 4.")
      .def("measure", &measured, "rig"_a, py::kw_only(), "mapping"_a = "chest",
           "Every metric of one pose, given by its channels: extension=90, side=10 (degrees). "
           "Returns a Series of one pose.")
      .def("measure_sweep", &measured_sweep, "rig"_a, "sweep"_a, py::kw_only(),
           "mapping"_a = "chest",
           "Every metric of every pose of a sweep (backbend list sweeps). Returns a Series.")
      .def(
          "render", &rendered, "rig"_a, py::kw_only(), "mapping"_a = "chest", "view"_a = "profile",
          "width"_a = 640, "height"_a = 360, "samples"_a = 16, "mode"_a = "clay", "seed"_a = 0,
          "all_layers"_a = false, "transparent"_a = false, "denoise"_a = false,
          "heat"_a = py::none(),
          "A picture of one pose, given by its channels, as arrays. Returns a Picture: layers "
          "(name: height x width x channels, float32, top row first; RGBA is scene-linear "
          "Rec.709), attributes (of an EXR's header, Cryptomatte's names among them), "
          "camera_from_world and ndc_from_world (4 x 4). view: profile, front, back, "
          "three_quarter. mode: beauty, clay, ao, matcap, wireframe, heat, xray, contour, primary. "
          "heat: a value for each vertex; without, the strain.");
  module.def(
      "load", &load, "file"_a, py::kw_only(), "chain"_a = "", "hip"_a = "", "chest"_a = "",
      "spine"_a = std::vector<std::string>(), "left_arm"_a = std::vector<std::string>(),
      "right_arm"_a = std::vector<std::string>(), "template"_a = "", "up"_a = "", "forward"_a = "",
      "Reads a character: .glb, .gltf, .fbx, .dae, or a body description .toml, with the "
      "sidecar beside it. Joint names, and axes as +Y, replace what is found; chain: spine or "
      "neck.");
}

}  // namespace backbend::python
