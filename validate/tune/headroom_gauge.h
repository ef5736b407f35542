#pragma once
#include <string>
#include <vector>

#include "validate/measure/measure.h"
#include "validate/metrics/surface/body_metrics.h"
#include "validate/stage/stage.h"
#include "validate/sweeps/envelope.h"
#include "validate/verdicts/limits.h"

namespace backbend::validate {

/// A straight way out of rest, to an end of a channel that the envelope asks for, or to one of its
/// corners.
struct Direction {
  std::string name;  // `extension 60`, `extension 60, side 45`
  PoseDegrees end;
};
std::vector<Direction> directions_of(const Envelope& envelope);

/// How much headroom a rig has in each direction, and how far its curve is from the given rig's.
struct RigGauge {
  std::vector<double> clean;  // of each direction: how much of its way is clean, 1 is the
                              // envelope's end, at most HeadroomGauge::kFurthest
  double headroom = 0.0;      // their mean
  double least = 0.0;         // the least of them, and which
  std::size_t worst = 0;
  std::string code;  // of the check that ends the worst; empty: none does
  // Distance of the curve from the given rig's, poses inside the envelope, % of the spine's length:
  // root of the mean square over poses and points, and the largest.
  double change = 0.0, change_most = 0.0;
};

/// Measures rigs of one system against a given one.
///
/// A direction is clean up to where the first deciding check of chain or mesh meets its limit,
/// linearly between two poses, or where the chain jumps. A mesh value that the ideal bend with the
/// same weights shows as well does not count: no option of the rig cures it. Triangles that run
/// through others are left out, for they cost a third of the time.
class HeadroomGauge {
 public:
  static constexpr int kSteps = 6;          // poses from rest to the envelope's end
  static constexpr double kFurthest = 2.0;  // of the envelope's end: what is measured

  /// Keeps references. Throws solver::RigError where the given rig cannot be built.
  HeadroomGauge(const Stage& stage, const BodyMetrics& body, const Envelope& envelope,
                const LimitSet& limits, solver::Mapping mapping, const solver::SystemSpec& given);

  const std::vector<Direction>& directions() const { return directions_; }
  /// Poses that one rig takes at most.
  std::size_t poses() const;
  /// The same for any number of threads. Throws solver::RigError for options that do not go
  /// together.
  RigGauge of(const solver::SystemSpec& spec) const;

 private:
  using Points = std::vector<glm::dvec3>;

  /// How far one direction is clean, and the check that ends it.
  struct Reach {
    double clean = 0.0;
    std::string code;
  };
  Reach reach_of(RigRecord& rig, const RigAtRest& at_rest, std::size_t direction) const;
  /// The deciding check that a pose is nearest to, or furthest beyond.
  struct Nearest {
    double excess = 0.0;
    std::string_view code;
  };
  Nearest nearest_limit(const RigRecord& rig, const PoseRecord& pose, std::size_t direction,
                        std::size_t step) const;
  std::vector<Points> curves_of(const RigRecord& rig) const;
  RigRecord planned(const solver::SystemSpec& spec) const;

  const Stage& stage_;
  const BodyMetrics& body_;
  const Envelope& envelope_;
  const LimitSet& limits_;
  solver::Mapping mapping_;
  std::vector<Direction> directions_;
  std::vector<Sweep> sweeps_;
  bool against_ideal_ = false;
  std::vector<std::vector<PoseRecord>> ideal_;  // [direction][pose]
  std::vector<Points> given_;                   // curves inside the envelope
};

}  // namespace backbend::validate
