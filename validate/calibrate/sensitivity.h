#pragma once
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

namespace backbend::validate {

/// What one detector said about clean poses and about poses with a fault of one size.
struct FaultTrial {
  double size = 0.0;
  std::vector<double> value;  // the detector's, one per faulted pose
  std::size_t placed = 0;     // of those over the threshold, how many named the right place
};

/// How often the verdicts of geometry and of pictures on the same cases were alike.
struct Agreement {
  std::size_t both = 0, geometry_only = 0, picture_only = 0, neither = 0;

  void count(bool geometry, bool picture) {
    ++(geometry ? (picture ? both : geometry_only) : (picture ? picture_only : neither));
  }
  std::size_t cases() const { return both + geometry_only + picture_only + neither; }
  std::size_t alike() const { return both + neither; }
  Agreement& operator+=(const Agreement& other);
};

/// How often a fault of one size was found.
struct HitRate {
  double size = 0.0;
  std::size_t tried = 0, found = 0, placed = 0;
  double roc_area = 0.5;  // chance that a faulted pose reads higher than a clean one
  Agreement agreement{};  // with geometry, where pictures were looked at
  double rate() const {
    return tried ? static_cast<double>(found) / static_cast<double>(tried) : 0;
  }
};

/// What a detector can see: the figures that a report shows.
struct Sensitivity {
  std::string detector;  // `chain kink`
  std::string code;      // the check that it serves
  std::string body;      // what it was tried on: `24 bones`, `mh_male_13k`
  std::string unit;
  std::string threshold_unit;  // that of the fault's size, unless pictures are read
  double threshold = std::numeric_limits<double>::quiet_NaN();
  std::size_t clean = 0, false_alarms = 0;
  std::vector<HitRate> hits;                                   // by rising size
  double target = 0.0;                                         // the size that has to be found
  double smallest = std::numeric_limits<double>::quiet_NaN();  // found in 99 of 100; NaN: none
  Agreement clean_agreement{};  // with geometry, where pictures were looked at
  Agreement agreement() const;  // of clean and faulted cases
  /// No false alarm, and the target's size found in 99 of 100.
  bool ok() const { return false_alarms == 0 && smallest <= target; }
};

/// A threshold from clean values: a quarter above the largest, at least `floor`. NaN among them, or
/// none of them, gives NaN: nothing can be said.
double threshold_from(const std::vector<double>& clean, double floor);

/// Chance that a value of `faulted` exceeds one of `clean`, ties counted half; NaN where either is
/// empty. A value that is not a number counts as the lowest: it was not found.
double roc_area(const std::vector<double>& clean, const std::vector<double>& faulted);

/// Puts the figures together. `clean` are other poses than those that gave the threshold.
Sensitivity judge_detector(std::string detector, std::string code, std::string body,
                           std::string unit, double target, double threshold,
                           const std::vector<double>& clean, const std::vector<FaultTrial>& trials);

}  // namespace backbend::validate
