#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "validate/calibrate/calibration_body.h"
#include "validate/calibrate/sensitivity.h"

namespace backbend::validate {

struct CalibrationPlan {
  // Per body, besides as many again that set the thresholds; pictures take every fourth.
  std::size_t clean_poses = 2000;
  std::size_t fault_poses = 200;  // per size and body
  /// Seed of the poses that set the thresholds. Those that test them come from other seeds.
  std::uint64_t seed = 20261121;
  std::vector<int> chain_bones{6, 10, 24, 33};
};

/// What is told of a calibration while it runs; either may be empty.
struct CalibrationWatch {
  /// A stage begins, of so many steps: `mesh of mh_male_13k`. Never from two threads at once.
  std::function<void(const std::string& stage, std::size_t steps)> on_stage;
  /// A step is done. From any thread; what it throws ends the calibration.
  std::function<void()> on_step;

  void begin(const std::string& stage, std::size_t steps) const {
    if (on_stage) on_stage(stage, steps);
  }
  void step() const {
    if (on_step) on_step();
  }
};

struct CalibrationReport {
  CalibrationPlan plan;
  std::string date;                    // the day it was made, `2026-11-22`; empty where nobody asks
  std::vector<Sensitivity> detectors;  // in the order they were tried
  /// Of all cases that pictures were looked at in, clean and faulted.
  Agreement agreement() const;
  bool ok() const;  // every detector reached its target with no false alarm
};

/// Injects faults of rising size into clean poses and finds the smallest that each detector sees
/// with no false alarm. Clean poses are those of `even`, whose continuity is proven.
///
/// Chain detectors are tried on chains of `chain_bones` bones, detectors of meshes and of pictures
/// on each body. The result is the same for any number of threads.
CalibrationReport calibrate(const CalibrationPlan& plan,
                            std::span<const CalibrationBody* const> bodies,
                            const CalibrationWatch& watch = {});

/// How many minutes calibrate() would take here, judged by two small calibrations of the same
/// bodies: what does not grow with the poses is counted once. `poll` is asked between their steps
/// and may throw.
double estimate_minutes(const CalibrationPlan& plan, std::span<const CalibrationBody* const> bodies,
                        const std::function<void()>& poll);

/// One line a detector: `chain kink  24 bones: from 0.5 deg, 0 of 2000 clean poses flagged`.
std::vector<std::string> detector_lines(const CalibrationReport& report);

/// The figures as a table in Markdown, one row a detector: what docs/calibration.md holds.
std::string calibration_table(const CalibrationReport& report);

/// The report as JSON text (`backbend.calibration/1`), keys sorted.
std::string calibration_json(const CalibrationReport& report);

/// A stored calibration that cannot be read. what() is the whole line.
struct CalibrationError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What a stored calibration says, in one line with its day and how many days that is before
/// `today`; where there is no such file, how to make one. Throws CalibrationError.
std::string last_calibration(const std::filesystem::path& file, const std::string& today);

// The trials, by what they are tried on.
std::vector<Sensitivity> try_chain_detectors(const CalibrationPlan& plan, int bones,
                                             const CalibrationWatch& watch);
Sensitivity try_flip_detector(const CalibrationPlan& plan, const CalibrationWatch& watch);
std::vector<Sensitivity> try_mesh_detectors(const CalibrationPlan& plan,
                                            const CalibrationBody& body,
                                            const CalibrationWatch& watch);
/// `measured`: what try_mesh_detectors() gave for this body; its thresholds are geometry's.
std::vector<Sensitivity> try_pictures(const CalibrationPlan& plan, const CalibrationBody& body,
                                      const std::vector<Sensitivity>& measured,
                                      const CalibrationWatch& watch);
std::vector<Sensitivity> try_weight_detectors(const CalibrationPlan& plan,
                                              const CalibrationBody& body,
                                              const CalibrationWatch& watch);

}  // namespace backbend::validate
