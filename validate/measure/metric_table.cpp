#include "validate/measure/metric_table.h"

#include <algorithm>
#include <cmath>

#include "validate/measure/measure.h"
#include "validate/metrics/chain/chain_corner.h"
#include "validate/metrics/surface/comb_jump.h"
#include "validate/sweeps/external_spec.h"

namespace backbend::validate {
namespace {

/// Twist by which the chain's end stays behind the chest control, degrees. The chain's own twist,
/// summed bone by bone, says how many whole turns that is: on a curved spine the sum itself differs
/// from the control's twist, whose axis is that of the chest.
double lost_twist(const ChainReading& at) {
  // Of a studio's own rig nothing says where its chest control points: what the pose asks for does.
  if (at.system.name() == kExternal) return at.chain.lost_twist_deg;
  const solver::SpinePose& rest = at.system.rest();
  const std::size_t tip = rest.position.size() - 1;
  const glm::dvec3 axis = glm::normalize(rest.position[tip] - rest.position[tip - 1]);
  solver::SpinePose end = at.pose;
  end.arms.turn = at.pose.turn.back();
  const double behind = -arm_drift(end, axis, 1.0).twist_deg;
  return behind + 360.0 * std::round((at.chain.lost_twist_deg - behind) / 360.0);
}

/// No curve is known that a studio's own rig should follow: its joints are held against each other.
Measured chain_kink(const ChainReading& at) {
  if (at.system.name() != kExternal || at.pose.joint_count() < kLeastForCorners)
    return {at.chain.kink_deg, at.chain.kink_joint};
  int joint = -1;
  const double corner = chain_corner(at.pose, at.system.rest(), joint);
  return {corner, joint};
}

bool kinks_can_be_told(const MetricScope& scope, const PoseRecord&) {
  return scope.surface.has_kinks;
}

constexpr std::array<Metric, kMetricCount> kTable = {{
    {.id = MetricId::gain, .name = "gain", .code = "BB002", .of_frames = false},
    {.id = MetricId::flip_margin,
     .name = "flip_margin",
     .code = "BB003",
     .place = PlaceKind::joint,
     .of_frames = false,
     .from_chain =
         [](const ChainReading& at) {
           return Measured{at.chain.least_margin_deg, at.chain.least_margin_joint};
         },
     .applies = [](const MetricScope& scope,
                   const PoseRecord&) { return !scope.rest.flip_margin.empty(); }},
    {.id = MetricId::chain_kink,
     .name = "chain_kink",
     .code = "BB010",
     .place = PlaceKind::joint,
     .of_frames = false,
     .from_chain = chain_kink},
    {.id = MetricId::uneven_bend,
     .name = "uneven_bend",
     .code = "BB013",
     .place = PlaceKind::joint,
     .from_chain =
         [](const ChainReading& at) {
           return Measured{at.chain.max_over_mean, at.chain.max_turn_joint};
         }},
    {.id = MetricId::arm_drift,
     .name = "arm_drift",
     .code = "BB020",
     .of_frames = false,
     .from_chain =
         [](const ChainReading& at) {
           return Measured{at.chain.arms.rotation_deg, -1};
         }},
    {.id = MetricId::arm_shift,
     .name = "arm_shift",
     .code = "BB021",
     .of_frames = false,
     .from_chain =
         [](const ChainReading& at) {
           return Measured{100.0 * at.chain.arms.shift, -1};
         }},
    {.id = MetricId::lost_twist,
     .name = "lost_twist",
     .code = "BB040",
     .of_frames = false,
     .from_chain =
         [](const ChainReading& at) {
           return Measured{std::abs(lost_twist(at)), -1};
         },
     // In a bend the chest's axis is not the spine's.
     .applies =
         [](const MetricScope&, const PoseRecord& pose) {
           return pose.body.extension == 0 && pose.body.flexion == 0 && pose.body.side == 0 &&
                  pose.body.hip == 0;
         }},
    {.id = MetricId::end_gap,
     .name = "end_gap",
     .code = "BB041",
     .of_frames = false,
     .from_chain =
         [](const ChainReading& at) {
           return Measured{100.0 * at.chain.end_gap, -1};
         }},
    {.id = MetricId::length_change,
     .name = "length_change",
     .code = "BB047",
     .from_chain =
         [](const ChainReading& at) {
           return Measured{100.0 * at.chain.length_change, -1};
         }},
    {.id = MetricId::mesh_kink,
     .name = "mesh_kink",
     .code = "BB011",
     .place = PlaceKind::slice,
     .growth = Growth::with_load,
     .from_body =
         [](const BodyReading& at) {
           return Measured{at.pose.slices.kink_worst_deg, at.pose.slices.kink_slice};
         },
     .applies = kinks_can_be_told},
    {.id = MetricId::surface_fold,
     .name = "surface_fold",
     .code = "BB012",
     .place = PlaceKind::slice,
     .growth = Growth::with_square,
     .from_body =
         [](const BodyReading& at) {
           return Measured{100.0 * at.pose.slices.folded, at.pose.slices.fold_slice};
         },
     .applies = [](const MetricScope& scope,
                   const PoseRecord&) { return scope.surface.has_folds; }},
    {.id = MetricId::arm_slide,
     .name = "arm_slide",
     .code = "BB022",
     .place = PlaceKind::vertex,
     .of_frames = false,  // arms move on purpose
     .from_body =
         [](const BodyReading& at) {
           return Measured{100.0 * at.pose.arm_drift, at.pose.arm_drift_vertex};
         },
     .applies = [](const MetricScope& scope, const PoseRecord&) { return scope.has_arms; }},
    {.id = MetricId::twist_jump,
     .name = "twist_jump",
     .code = "BB036",
     .place = PlaceKind::slice,
     .growth = Growth::with_load,
     .from_body =
         [](const BodyReading& at) {
           return Measured{at.pose.slices.twist_jump_worst_deg, at.pose.slices.twist_jump_slice};
         },
     .applies = kinks_can_be_told},
    {.id = MetricId::slice_area,
     .name = "slice_area",
     .code = "BB030",
     .place = PlaceKind::slice,
     .growth = Growth::with_load,
     .from_body =
         [](const BodyReading& at) {
           return Measured{at.pose.slices.least_area_ratio, at.pose.slices.area_slice};
         }},
    {.id = MetricId::volume,
     .name = "volume",
     .code = "BB031",
     .growth = Growth::with_load,
     .from_body =
         [](const BodyReading& at) {
           return Measured{100.0 * std::abs(at.pose.surface.volume_change), -1};
         },
     .applies = [](const MetricScope& scope,
                   const PoseRecord&) { return scope.surface.has_volume; }},
    {.id = MetricId::strain,
     .name = "strain",
     .code = "BB032",
     .place = PlaceKind::vertex,
     .growth = Growth::with_load,
     .from_body =
         [](const BodyReading& at) {
           return Measured{at.pose.surface.strain_most, at.pose.surface.strain_vertex};
         }},
    {.id = MetricId::inverted,
     .name = "inverted",
     .code = "BB033",
     .place = PlaceKind::vertex,
     .growth = Growth::with_square,
     .from_body =
         [](const BodyReading& at) {
           return Measured{100.0 * at.pose.surface.inverted_area, at.pose.surface.inverted_vertex};
         }},
    {.id = MetricId::dihedral,
     .name = "dihedral",
     .code = "BB035",
     .place = PlaceKind::vertex,
     .from_body =
         [](const BodyReading& at) {
           return Measured{at.pose.surface.dihedral_deg, at.pose.surface.dihedral_vertex};
         }},
    {.id = MetricId::feasibility,
     .name = "feasibility",
     .code = "BB048",
     .place = PlaceKind::slice,
     .from_body =
         [](const BodyReading& at) {
           return Measured{at.pose.slices.infeasible, at.pose.slices.infeasible_slice};
         }},
    {.id = MetricId::chain_twist_jump,
     .name = "chain_twist_jump",
     .code = "BB014",
     .place = PlaceKind::joint,
     .of_frames = false,  // no twist is known that the chain should carry
     .from_chain =
         [](const ChainReading& at) {
           return Measured{at.chain.twist_jump_deg, at.chain.twist_jump_joint};
         },
     .applies =
         [](const MetricScope& scope, const PoseRecord&) {
           return scope.rest.position.size() >= kLeastTwistJumpJoints;
         }},
    {.id = MetricId::predictability, .name = "predictability", .code = "BB042", .of_frames = false},
    {.id = MetricId::mirror,
     .name = "mirror_asymmetry",
     .code = "BB043",
     .place = PlaceKind::joint,
     .of_frames = false},  // a clip has no mirrored pose
    {.id = MetricId::return_to_rest,
     .name = "return_to_rest",
     .code = "BB044",
     .place = PlaceKind::joint,
     .of_frames = false,
     .applies = [](const MetricScope&, const PoseRecord& pose) { return pose.rest_noted; }},
    {.id = MetricId::range_of_motion,
     .name = "range_of_motion",
     .code = "BB045",
     .place = PlaceKind::joint,
     .of_frames = false,
     // A human range fits no snake.
     .applies = [](const MetricScope& scope, const PoseRecord&) { return scope.has_arms; }},
    {.id = MetricId::uneven_twist,
     .name = "uneven_twist",
     .code = "BB046",
     .from_chain =
         [](const ChainReading& at) {
           return Measured{at.chain.uneven_twist, -1};
         }},
    {.id = MetricId::non_finite, .name = "non_finite", .code = "BB050"},
    {.id = MetricId::self_intersection,
     .name = "self_intersection",
     .code = "BB034",
     .place = PlaceKind::vertex,
     .of_frames = false,  // limbs pass close by on purpose
     .growth = Growth::with_square,
     .from_body =
         [](const BodyReading& at) {
           return Measured{100.0 * at.pose.crossing, at.pose.crossing_vertex};
         }},
    {.id = MetricId::comb_jump,
     .name = "comb_jump",
     .code = "BB015",
     .place = PlaceKind::slice,
     .growth = Growth::with_load,
     .from_body =
         [](const BodyReading& at) {
           const CombJump jump = comb_jump(at.body.slices(), at.body.rest_slices(),
                                           at.pose.slice_pose, at.body.window());
           return Measured{jump.angle_deg, jump.slice};
         },
     .applies = kinks_can_be_told},
}};

const Metric* find(std::string_view Metric::*field, std::string_view text) {
  const auto found = std::ranges::find(kTable, text, field);
  return found == kTable.end() ? nullptr : &*found;
}

}  // namespace

const Check& Metric::check() const { return *find_check(code); }

const std::array<Metric, kMetricCount>& metric_table() { return kTable; }

const Metric* metric_of(std::string_view code) { return find(&Metric::code, code); }
const Metric* metric_named(std::string_view name) { return find(&Metric::name, name); }

bool is_applicable(const Metric& metric, const MetricScope& scope, const PoseRecord& pose) {
  return pose.taken && !pose.left_out[static_cast<std::size_t>(metric.id)] &&
         (metric.applies == nullptr || metric.applies(scope, pose));
}

}  // namespace backbend::validate
