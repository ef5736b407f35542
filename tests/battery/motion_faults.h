#pragma once
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "tests/battery/motion.h"
#include "validate/calibrate/draw.h"

namespace backbend::battery {

/// Where in a motion a fault was put, and what a check should say of it.
struct MotionFault {
  std::string kind;
  double size = 0;
  std::string unit;
  std::set<std::string> joints;  // names that a finding of it may bear; empty: no place for it
  int frame = -1;                // that the jump leads to, or where a lasting fault is widest
  bool jump = false;             // a frame to find, and a size that the check reports in degrees
  bool lasting = false;          // any frame of the clip shows it
  bool plain = true;             // of a size that a rigger sees at once
};

struct MotionFaultKind {
  std::string_view name, unit;
  std::vector<double> sizes;
  double plain_from;
  bool needs_calm;  // on captured motion it may be the performer's own
};
const std::vector<MotionFaultKind>& motion_fault_kinds();

MotionFault plant(Motion& motion, const skin::Character& body, const skin::Anatomy& anatomy,
                  const std::vector<int>& chain, std::string_view kind, double size,
                  validate::Draw& draw);

}  // namespace backbend::battery
