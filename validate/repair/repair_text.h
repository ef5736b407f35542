#pragma once
#include <string>

#include "validate/repair/weight_repair.h"

namespace backbend::validate {

/// For a person: what was found before and after by check, what was changed, how much of the body
/// was touched, and with figures what weights did not cure.
std::string repair_text(const WeightRepair& repair);

/// The same as one JSON object, schema `backbend.repair/1`.
std::string repair_json(const WeightRepair& repair);

}  // namespace backbend::validate
