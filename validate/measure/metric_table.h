#pragma once
#include <array>
#include <cstddef>
#include <limits>
#include <string_view>

#include "solver/rig/spine_system.h"
#include "validate/metrics/surface/body_metrics.h"
#include "validate/verdicts/checks.h"

namespace backbend::validate {

struct PoseRecord;

/// What is measured at every pose, in the order of metric_table().
enum class MetricId : std::size_t {
  gain,
  flip_margin,
  chain_kink,
  uneven_bend,
  arm_drift,
  arm_shift,
  lost_twist,
  end_gap,
  length_change,
  mesh_kink,
  surface_fold,
  arm_slide,
  twist_jump,
  slice_area,
  volume,
  strain,
  inverted,
  dihedral,
  feasibility,
  chain_twist_jump,
  predictability,
  mirror,
  return_to_rest,
  range_of_motion,
  uneven_twist,
  non_finite,
  self_intersection,
  comb_jump,
  count  // stays last
};
inline constexpr std::size_t kMetricCount = static_cast<std::size_t>(MetricId::count);

/// A value and where on the character it was found, counted as the metric's PlaceKind says; -1 for
/// none.
struct Measured {
  double value = std::numeric_limits<double>::quiet_NaN();
  int place = -1;
};

enum class PlaceKind { none, joint, slice, vertex };

/// What the metrics of the chain are read from: one finite pose.
struct ChainReading {
  const solver::SpineSystem& system;
  const solver::SpinePose& pose;
  const ChainMeasures& chain;
};

/// What the metrics of the mesh are read from: one finite pose of a body.
struct BodyReading {
  const BodyMetrics& body;
  const BodyMeasures& pose;
};

/// What decides which metrics apply to a rig on a character.
struct MetricScope {
  const solver::SpinePose& rest;
  SurfaceScope surface;
  bool has_arms = true;
};

/// How the limit grows with the load of a pose that uses several channels at once
/// (compound_load()): not at all, as an angle or a length, or as an area.
enum class Growth { none, with_load, with_square };

/// A row of the one table of metrics. Limit, unit, sense, words and picture witness are those of
/// its check.
struct Metric {
  MetricId id;
  std::string_view name;  // in plots and report.json
  std::string_view code;  // of the check that judges it
  PlaceKind place = PlaceKind::none;
  bool of_frames = true;  // a recorded frame has it by itself, as a pose does
  Growth growth = Growth::none;
  /// How one pose's value is read. A metric with neither is filled over a sweep or a rig.
  Measured (*from_chain)(const ChainReading&) = nullptr;
  Measured (*from_body)(const BodyReading&) = nullptr;
  /// Null: to every pose that the rig takes.
  bool (*applies)(const MetricScope&, const PoseRecord&) = nullptr;

  const Check& check() const;
};

const std::array<Metric, kMetricCount>& metric_table();

/// The metric that a check judges, or of this name; nullptr for none.
const Metric* metric_of(std::string_view code);
const Metric* metric_named(std::string_view name);

/// Whether a value of this metric means anything at this pose.
bool is_applicable(const Metric& metric, const MetricScope& scope, const PoseRecord& pose);

}  // namespace backbend::validate
