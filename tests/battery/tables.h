#pragma once
#include <nlohmann/json.hpp>
#include <vector>

namespace backbend::battery {

/// Prints what the cases say, as the tables of docs/calibration.md. Returns whether no clean case
/// failed and 95 of 100 faults of a plain size were found.
bool print_tables(const std::vector<nlohmann::json>& cases);

}  // namespace backbend::battery
