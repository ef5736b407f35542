#pragma once
#include <string>

#include "validate/sweeps/sweep.h"

namespace backbend::validate {

/// The path that a named pose of a suite is measured on: straight from `from` to `at`, which is its
/// last pose to rounding; no pose on it is bent both ways. Steps of about 5 degrees, 2 to 24 of
/// them; flips are found on the whole way. Throws solver::RigError where the two are the same pose.
Sweep named_pose(const std::string& name, const PoseDegrees& from, const PoseDegrees& at);

/// A pose as a suite's file and --pose take it: `extension=57.25,side=44.1`; `rest` for none. At
/// most six decimals: in_file_digits() rounds a pose so that its text is exact.
std::string pose_words(const PoseDegrees& pose);
PoseDegrees in_file_digits(const PoseDegrees& pose);

}  // namespace backbend::validate
