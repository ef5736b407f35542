#pragma once
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "tests/battery/body_variants.h"

namespace backbend::battery {

/// A body with a fault of its weights or its bind pose, and where it was put.
struct WeightFault {
  std::string kind;
  double size = 0;
  std::string unit;
  std::vector<double> file_scale;  // of each vertex's weights in the file; empty: 1
  std::set<std::string> joints;    // names that a finding of it may bear
  std::vector<bool> touched;       // vertices whose weights or place it changed
  bool plain = true;               // of a size that a rigger sees at once
};

/// Every kind, and the sizes it is tried at, least first.
struct WeightFaultKind {
  std::string_view name, unit;
  std::vector<double> sizes;
  double plain_from;  // a rigger sees this and what is larger at once
};
const std::vector<WeightFaultKind>& weight_fault_kinds();

/// Puts the fault into a welded() body. Empty `joints` where the body has no place for it.
WeightFault plant(skin::Character& body, const skin::Anatomy& anatomy, std::string_view kind,
                  double size, validate::Draw& draw);

}  // namespace backbend::battery
