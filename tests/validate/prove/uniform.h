#pragma once
#include <random>

namespace backbend::validate::testing {

/// From -1 to below 1; the same on every platform.
inline double uniform(std::mt19937& random) { return 2.0 * double(random()) / 4294967296.0 - 1.0; }

}  // namespace backbend::validate::testing
