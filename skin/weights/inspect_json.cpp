#include <cmath>
#include <nlohmann/json.hpp>

#include "skin/anatomy/anatomy_hints.h"
#include "skin/anatomy/driver_coverage.h"
#include "skin/anatomy/import_checks.h"
#include "skin/anatomy/rig_templates.h"
#include "skin/anatomy/skeleton_shape.h"
#include "skin/weights/inspect.h"
#include "skin/weights/weight_faults.h"
#include "skin/weights/weight_hygiene.h"

namespace backbend::skin {
namespace {

using nlohmann::json;

json names(const Character& character, const std::vector<int>& nodes) {
  json out = json::array();
  for (const int node : nodes) out.push_back(reference_name(character, node));
  return out;
}

/// The known rig whose names were what decided, null where none was.
json template_json(const Character& character, const Anatomy& anatomy) {
  const auto match = find_template(character);
  const bool decided = match && match->hip == anatomy.spine.front() &&
                       match->neck == anatomy.spine[anatomy.neck_index];
  return decided ? json(match->name) : json(nullptr);
}

json vector_json(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

json meshes_json(const Character& character) {
  json out = json::array();
  for (const Part& part : character.parts)
    out.push_back({{"name", part.name},
                   {"material", character.materials[static_cast<std::size_t>(part.material)].name},
                   {"vertices", part.vertex_count},
                   {"triangles", part.triangle_count}});
  return out;
}

json answer_json(const Character& character, const Anatomy& anatomy, const WeightAnswer& answer) {
  if (!answer.not_applicable.empty()) return {{"not_applicable", answer.not_applicable}};
  const auto name = [&](int node) {
    return node < 0 ? json(nullptr) : json(character.nodes[static_cast<std::size_t>(node)].name);
  };
  json list = json::array();
  constexpr std::size_t kMost = 16;
  for (std::size_t k = 0; k < answer.faults.size() && k < kMost; ++k) {
    const WeightFault& fault = answer.faults[k];
    list.push_back({{"joint", name(fault.node)},
                    {"other", name(fault.other)},
                    {"share", fault.value},
                    {"distance", fault.distance},
                    {"places", fault.places},
                    {"vertex", fault.places > 0 ? json(fault.vertex) : json(nullptr)},
                    {"where", place_of_fault(character, anatomy, fault)}});
  }
  return {{"joints", answer.faults.size()}, {"worst", list}};
}

json faults_json(const Character& character, const Anatomy& anatomy) {
  const WeightFaults faults = find_weight_faults(character, anatomy);
  json bind = json::array();
  for (const JointBindOff& off : joints_bound_off(character))
    bind.push_back({{"joint", character.nodes[static_cast<std::size_t>(off.node)].name},
                    {"angle_deg", off.angle_deg},
                    {"shift", off.shift},
                    {"vertex", off.vertex}});
  return {{"wrong_side", answer_json(character, anatomy, faults.wrong_side)},
          {"far", answer_json(character, anatomy, faults.far)},
          {"asymmetry", answer_json(character, anatomy, faults.asymmetry)},
          {"order", answer_json(character, anatomy, faults.order)},
          {"levels", answer_json(character, anatomy, faults.levels)},
          {"borders", answer_json(character, anatomy, faults.borders)},
          {"seams", answer_json(character, anatomy, faults.seams)},
          {"bind_off", bind}};
}

json import_json(const Character& character) {
  json out = json::array();
  for (const ImportFact& fact : check_import(character))
    out.push_back(
        {{"code", fact.code}, {"impossible", fact.impossible}, {"message", fact.message}});
  return out;
}

json weights_json(const Character& character, const Anatomy& anatomy) {
  const WeightHygiene weights = judge_weights(character, anatomy);
  json bleed = json::array();
  for (const Bleed& entry : weights.bleed)
    bleed.push_back({{"joint", character.nodes[static_cast<std::size_t>(entry.node)].name},
                     {"places", entry.places},
                     {"vertex", entry.vertex},
                     {"largest", entry.largest}});
  return {{"most_influences", weights.most_influences()},
          {"vertices_by_influences", weights.with_influences},
          {"more_than_four", weights.more_than_four},
          {"unweighted", weights.unweighted},
          {"off_sum", weights.off_sum},
          {"worst_sum", weights.worst_sum},
          {"tiny", weights.tiny},
          {"tiny_below", kTinyWeight},
          {"symmetry",
           {{"mirrored_share", weights.mirrored_share},
            {"asymmetric_places", weights.asymmetric},
            {"worst", weights.worst_asymmetry},
            {"worst_vertex", weights.worst_asymmetric_vertex}}},
          {"bleed", bleed},
          {"faults", faults_json(character, anatomy)}};
}

/// The joint that the arms hang from, null where there is none.
json chest_json(const Character& character, const Anatomy& anatomy) {
  return anatomy.chest < 0 ? json(nullptr) : json(reference_name(character, anatomy.chest));
}

/// Why the driven chain ends where it does: the last of the reasons that speak of it.
std::string driven_reason(const Anatomy& anatomy) {
  std::string out;
  for (const std::string& reason : anatomy.reasons)
    if (reason.starts_with("chest: ") || reason.starts_with("driven: ")) out = reason;
  return out;
}

json driven_json(const Character& character, const Anatomy& anatomy) {
  const SpineDriver driver(character, anatomy);
  const DriverCoverage coverage = driver_coverage(character, anatomy);
  json joints = json::array();
  for (std::size_t k = 0; k <= anatomy.chest_index; ++k)
    joints.push_back({{"name", character.nodes[static_cast<std::size_t>(anatomy.spine[k])].name},
                      {"fraction", driver.joint_fractions()[k]}});
  json followers = json::array();
  for (const Follower& follower : anatomy.followers)
    followers.push_back(
        {{"joint", character.nodes[static_cast<std::size_t>(follower.node)].name},
         {"goes_with", character.nodes[static_cast<std::size_t>(follower.leader)].name}});
  return {{"joints", joints},
          {"end", reference_name(character, anatomy.spine[anatomy.chest_index])},
          {"why", driven_reason(anatomy)},
          {"arms_follow", anatomy.left_arm.empty() && anatomy.right_arm.empty() ? "none"
                          : driver.arms_follow_chest()                          ? "chest"
                                                                                : "spine"},
          {"followers", followers},
          {"helpers", names(character, coverage.helpers)},
          {"helper_torso_share", coverage.helper_share},
          {"unreached", names(character, coverage.unreached)},
          {"unreached_share", coverage.unreached_share}};
}

json skeleton_json(const Character& character) {
  const SkeletonShape shape = measure_skeleton(character);
  json out = json::array();
  for (std::size_t n = 0; n < character.nodes.size(); ++n) {
    const Node& node = character.nodes[n];
    out.push_back(
        {{"name", node.name},
         {"node", node.file_node},
         {"parent", node.parent < 0
                        ? json(nullptr)
                        : json(character.nodes[static_cast<std::size_t>(node.parent)].name)},
         {"joint", static_cast<bool>(shape.is_joint[n])},
         {"weight", shape.weight[n]},
         {"position", vector_json(shape.position[n])}});
  }
  return out;
}

}  // namespace

std::string inspect_json(const Character& character, const Anatomy& anatomy) {
  json warnings = json::array();
  for (const Warning& warning : character.warnings)
    warnings.push_back({{"code", warning.code}, {"message", warning.message}});
  const json root = {{"schema", "backbend.inspect/1"},
                     {"file", character.file_name},
                     {"spine", names(character, anatomy.spine)},
                     {"chest", chest_json(character, anatomy)},
                     {"template", template_json(character, anatomy)},
                     {"arms",
                      {{"left", names(character, anatomy.left_arm)},
                       {"right", names(character, anatomy.right_arm)}}},
                     {"legs",
                      {{"left", names(character, anatomy.left_leg)},
                       {"right", names(character, anatomy.right_leg)}}},
                     {"tail", names(character, anatomy.tail)},
                     {"up", vector_json(anatomy.up)},
                     {"forward", vector_json(anatomy.forward)},
                     {"left", vector_json(anatomy.left)},
                     {"height", anatomy.height},
                     {"spine_length", anatomy.spine_length},
                     {"sure", anatomy.sure()},
                     {"doubts", anatomy.doubts},
                     {"reasons", anatomy.reasons},
                     {"vertices", character.vertex_count()},
                     {"places", character.place_count},
                     {"triangles", character.triangles.size()},
                     {"joints", character.joints.size()},
                     {"import", import_json(character)},
                     {"meshes", meshes_json(character)},
                     {"weights", weights_json(character, anatomy)},
                     {"driven", driven_json(character, anatomy)},
                     {"skeleton", skeleton_json(character)},
                     {"warnings", warnings}};
  return root.dump(2, ' ', false, json::error_handler_t::replace);
}

}  // namespace backbend::skin
