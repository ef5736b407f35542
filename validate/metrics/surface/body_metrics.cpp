#include "validate/metrics/surface/body_metrics.h"

#include <algorithm>
#include <cmath>

#include "skin/character/part_owners.h"
#include "skin/deform/rest_matrices.h"
#include "validate/metrics/math/nan.h"
#include "validate/metrics/surface/connected_pieces.h"
#include "validate/metrics/surface/torso.h"

namespace backbend::validate {
namespace {

/// Vertices that nothing but the arms moves.
std::vector<std::uint8_t> arm_vertices(const skin::Character& character,
                                       const skin::Anatomy& anatomy) {
  std::vector<char> arm(character.nodes.size(), 0);
  for (const std::vector<int>* chain : {&anatomy.left_arm, &anatomy.right_arm})
    if (!chain->empty()) arm[static_cast<std::size_t>(chain->front())] = 1;
  for (std::size_t n = 0; n < arm.size(); ++n) {
    const int parent = character.nodes[n].parent;
    if (parent >= 0 && arm[static_cast<std::size_t>(parent)]) arm[n] = 1;
  }
  std::vector<std::uint8_t> out;
  for (const skin::Influences& influences : character.influences) {
    double sum = 0.0;
    for (int k = 0; k < skin::kMaxInfluences; ++k)
      if (arm[static_cast<std::size_t>(character.joints[influences.joint[k]].node)])
        sum += influences.weight[k];
    out.push_back(sum > 0.999);
  }
  return out;
}

/// Arc of each spine joint along the rest pose, hips first, against that of the chest.
std::vector<double> arc_of_joints(const skin::Character& character, const skin::Anatomy& anatomy) {
  std::vector<double> arc;
  const auto at = [&](std::size_t k) {
    return glm::dvec3(
        character.nodes[static_cast<std::size_t>(anatomy.spine[k])].world_from_node[3]);
  };
  for (std::size_t k = 0; k < anatomy.spine.size(); ++k)
    arc.push_back(k == 0 ? 0.0 : arc.back() + glm::distance(at(k - 1), at(k)));
  const double length = arc[anatomy.chest_index];
  for (double& a : arc) a /= length;
  return arc;
}

// Of the chain from hips to where the neck starts.
constexpr double kFirstSlice = 0.05, kLastSlice = 0.95;

/// Where the last slice is cut. The chain's last joint bends the body, too: half of that bend
/// stands beyond the joint, and beyond one bone nothing but rigid ribs follows.
double last_slice(const std::vector<double>& fraction, const skin::Anatomy& anatomy) {
  if (anatomy.neck_index <= anatomy.chest_index) return kLastSlice;
  const double bone = 1.0 - fraction[anatomy.chest_index - 1];
  return std::max(kLastSlice, std::min(kLastSlice * fraction[anatomy.neck_index], 1.0 + bone));
}

}  // namespace

RigAtRest rig_at_rest(const solver::SpineSystem& system) {
  std::vector<double> control;
  for (const solver::Channel& channel : system.channels()) control.push_back(channel.rest);
  return {&system, system.intended_curve(control, kCurvePoints),
          std::max(1, static_cast<int>(system.rest().position.size()) - 1)};
}

double asked_length(const RigAtRest& rig, std::span<const glm::dvec3> intended, bool stretches) {
  return stretches ? chain_length(intended) / chain_length(rig.curve) : 1.0;
}

BodyMetrics::BodyMetrics(const skin::Character& character, const skin::Anatomy& anatomy,
                         const skin::SpineDriver& driver)
    : height_(anatomy.height), joints_(character.joints), parts_(character, driver) {
  const skin::PosedMesh rest = skin::rest_mesh(character);
  rest_position_.assign(rest.position.begin(), rest.position.end());
  const std::vector<std::uint8_t> torso = torso_mask(character, anatomy, rest_position_);
  const std::vector<float> share = spine_shares(character, anatomy);
  const std::vector<glm::dvec3>& joints = driver.rest_chain().joint;
  RestMesh mesh{rest_position_,
                rest.normal,
                character.triangles,
                character.place,
                character.place_count,
                torso,
                share,
                joints};
  const SpineLine line(joints);
  const std::vector<float> coordinate = spine_coordinate(mesh, line);
  std::vector<int> joint_of_vertex;
  for (const int part : parts_.of_vertex())
    joint_of_vertex.push_back(part < 0 ? -1 : skin::SpineDriver::joint_of_motion(part));
  std::vector<std::uint8_t> rigid = rigid_pieces(
      character.triangles, character.place, joint_of_vertex, driver.joint_fractions(), coordinate);
  // Props do not bend with the torso: its slices leave them out.
  std::vector<bool> is_prop = skin::nodes_of_props(character);
  for (const int node : anatomy.spine) is_prop[static_cast<std::size_t>(node)] = false;
  for (std::size_t v = 0; v < rigid.size(); ++v)
    if (is_prop[static_cast<std::size_t>(character.joints[character.influences[v].joint[0]].node)])
      rigid[v] = 1;
  mesh.rigid = rigid;
  spine_fraction_ = arc_of_joints(character, anatomy);
  for (const int node : anatomy.spine)
    spine_name_.push_back(character.nodes[static_cast<std::size_t>(node)].name);
  for (const std::uint32_t place : character.place) coordinate_.push_back(coordinate[place]);
  slices_ = cut_slices(mesh, line, coordinate, driver.rest_chain().left, kSliceCount, kFirstSlice,
                       last_slice(spine_fraction_, anatomy));
  rest_slices_ = pose_slices(slices_, rest_position_);
  window_ = slice_window(slices_, static_cast<int>(joints.size()) - 1);
  const skin::JointMatrices at_rest = skin::joint_matrices(joints_, skin::rest_matrices(character));
  const MeshBinding binding{character.bind_position, character.influences, at_rest};
  mesh_ = prepare_mesh(mesh, line, coordinate, slices_, parts_.of_vertex(), &binding);
  crossing_.emplace(rest_position_, character.triangles, character.place, parts_.of_vertex());
  has_arms_ = driver.arms_follow_chest();
  if (has_arms_) arm_ = arm_vertices(character, anatomy);
}

SurfaceScope BodyMetrics::scope() const {
  return {.has_volume = mesh_.open_reason.empty(),
          .has_kinks = why_no_kinks(slices_).empty(),
          .has_folds = why_no_folds(slices_, rest_slices_).empty()};
}

std::vector<std::string> BodyMetrics::why_not() const {
  std::vector<std::string> out;
  const auto add = [&](std::string why) {
    if (!why.empty()) out.push_back(std::move(why));
  };
  if (slices_.measured() == 0)
    add("cross-sections (BB030) cannot be measured: nowhere does the surface go round the driven "
        "spine; is another meant (--hip and --chest, or --spine)?");
  if (!mesh_.open_reason.empty()) add("volume has no meaning here: " + mesh_.open_reason);
  add(why_no_kinks(slices_));
  add(why_no_folds(slices_, rest_slices_));
  return out;
}

BendIntent BodyMetrics::intent(const RigAtRest& rig, const std::vector<glm::dvec3>& curve,
                               const solver::SpinePose& pose, double twist, bool stretches) const {
  return bend_intent(
      slices_, rest_slices_,
      {pose, curve, rig.curve, twist, 1.0 / rig.bones, asked_length(rig, curve, stretches)});
}

BodyMeasures BodyMetrics::measure(const RigAtRest& rig, std::span<const double> control,
                                  const solver::SpinePose& pose, const skin::PosedMesh& mesh,
                                  double twist, bool stretches, Crossing crossing,
                                  std::span<const glm::dmat4> world_from_node,
                                  Deformers deformers) const {
  BodyMeasures out;
  const std::vector<glm::dvec3> curve = rig.system->intended_curve(control, kCurvePoints);
  out.chain = measure_chain({pose, rig.system->rest(), curve, rig.curve, degrees(twist),
                             asked_length(rig, curve, stretches)});
  out.arm_drift = out.crossing = kNan;
  out.slices.planned = slices_.slice.size();
  if (!out.chain.finite) {
    out.surface.not_finite = mesh.position.size();
    return out;
  }
  const BendIntent asked = intent(rig, curve, pose, twist, stretches);
  const bool hold =
      !world_from_node.empty() && deformers == Deformers::none && parts_.hold(world_from_node);
  const std::vector<glm::mat3> turns = face_turns_of(world_from_node);
  out.surface = measure_mesh(mesh_, mesh.position, {mesh.normal, turns}, asked, 1.0 / rig.bones,
                             hold ? Parts::rigid : Parts::unknown);
  if (out.surface.not_finite > 0) return out;
  out.slice_pose = pose_slices(slices_, mesh.position);
  out.slices = measure_slices(slices_, rest_slices_, out.slice_pose, asked, window_);
  if (crossing == Crossing::measured) {
    // Under rigs of ours parts move as one, whatever the weights and the blending.
    const SelfIntersection::Measures found = self_intersection(
        mesh.position, hold || pose.body == nullptr ? Parts::rigid : Parts::unknown);
    out.crossing = found.area;
    out.crossing_vertex = found.vertex;
  }
  if (has_arms_) {
    const PartDrift drift = part_drift(rest_position_, arm_, pose.arms, pose.chest);
    out.arm_drift = drift.distance / height_;
    out.arm_drift_vertex = drift.vertex;
  }
  return out;
}

SelfIntersection::Measures BodyMetrics::self_intersection(std::span<const glm::vec3> position,
                                                          Parts parts) const {
  if (parts == Parts::rigid) return crossing_->measure(position);
  std::call_once(loose_->made,
                 [&] { loose_->crossing.emplace(crossing_->without_groups(rest_position_)); });
  return loose_->crossing->measure(position);
}

std::vector<float> BodyMetrics::strain_heat(const RigAtRest& rig, std::span<const double> control,
                                            const solver::SpinePose& pose,
                                            const skin::PosedMesh& mesh, double twist,
                                            bool stretches) const {
  const std::vector<glm::dvec3> curve = rig.system->intended_curve(control, kCurvePoints);
  return strain_map(mesh_, mesh.position, intent(rig, curve, pose, twist, stretches),
                    1.0 / rig.bones);
}

std::vector<float> BodyMetrics::inverted_heat(const skin::PosedMesh& mesh,
                                              std::span<const glm::dmat4> world_from_node) const {
  const std::vector<glm::mat3> turns = face_turns_of(world_from_node);
  return inverted_map(mesh_, mesh.position, {mesh.normal, turns});
}

std::vector<glm::mat3> BodyMetrics::face_turns_of(
    std::span<const glm::dmat4> world_from_node) const {
  if (world_from_node.empty()) return {};
  return face_turns(skin::joint_matrices(joints_, world_from_node));
}

MeshExcess mesh_excess(const BodyMeasures& rig, const BodyMeasures& ideal, int window) {
  MeshExcess out;
  out.kink_deg = out.area_loss = kNan;
  const std::vector<double> kink = paired_kink(rig.slices, ideal.slices, window);
  for (std::size_t r = 0; r < kink.size(); ++r) {
    // A pair also differs where the ideal has the kink and the rig has not.
    const double worse = std::min(kink[r], rig.slices.kink_deg[r]) -
                         std::max(0.0, ideal.slices.kink_deg[r] - rig.slices.kink_deg[r]);
    if (!std::isnan(worse) && !(worse <= out.kink_deg)) {
      out.kink_deg = worse;
      out.kink_slice = static_cast<int>(r);
    }
  }
  for (std::size_t r = 0; r < rig.slices.area_ratio.size(); ++r) {
    const double loss = ideal.slices.area_ratio[r] - rig.slices.area_ratio[r];
    if (!std::isnan(loss) && !(loss <= out.area_loss)) {
      out.area_loss = loss;
      out.area_slice = static_cast<int>(r);
    }
  }
  out.twist_jump_deg = rig.slices.twist_jump_worst_deg - ideal.slices.twist_jump_worst_deg;
  out.strain = rig.surface.strain_most - ideal.surface.strain_most;
  out.inverted_area = rig.surface.inverted_area - ideal.surface.inverted_area;
  out.folded = rig.slices.folded - ideal.slices.folded;
  out.dihedral_deg = rig.surface.dihedral_deg - ideal.surface.dihedral_deg;
  return out;
}

}  // namespace backbend::validate
