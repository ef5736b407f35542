#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "validate/calibrate/calibration_body.h"
#include "validate/calibrate/sensitivity.h"

namespace backbend::validate {

struct CalibrationPlan {
  std::size_t clean_poses = 2000;  // per body, besides as many again that set the thresholds
  std::size_t fault_poses = 200;   // per size and body
  /// Seed of the poses that set the thresholds. Those that test them come from other seeds.
  std::uint64_t seed = 20261121;
  std::vector<int> chain_bones{6, 10, 24, 33};
};

struct CalibrationReport {
  CalibrationPlan plan;
  std::vector<Sensitivity> detectors;  // in the order they were tried
  bool ok() const;                     // every detector reached its target without a false alarm
};

/// Injects faults of rising size into clean poses and finds the smallest that each detector sees
/// with no false alarm. Clean poses are those of `even`, whose continuity is proven.
///
/// Chain detectors are tried on chains of `chain_bones` bones, mesh detectors on each body. The
/// result is the same for any number of threads. `progress` is told the name of each detector and
/// body as it begins.
CalibrationReport calibrate(const CalibrationPlan& plan,
                            std::span<const CalibrationBody* const> bodies,
                            const std::function<void(const std::string&)>& progress = {});

/// One line a detector: `chain kink  24 bones: from 0.5 deg, 0 of 2000 clean poses flagged`.
std::vector<std::string> detector_lines(const CalibrationReport& report);

/// The report as JSON text (`backbend.calibration/1`), keys sorted.
std::string calibration_json(const CalibrationReport& report);

// The trials, by what they are tried on.
std::vector<Sensitivity> try_chain_detectors(const CalibrationPlan& plan, int bones);
Sensitivity try_flip_detector(const CalibrationPlan& plan);
std::vector<Sensitivity> try_mesh_detectors(const CalibrationPlan& plan,
                                            const CalibrationBody& body);
std::vector<Sensitivity> try_weight_detectors(const CalibrationPlan& plan,
                                              const CalibrationBody& body);

}  // namespace backbend::validate
