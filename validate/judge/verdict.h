#pragma once
#include "validate/model/report.h"

namespace backbend::validate {

/// Gives each rig and the whole report its verdict, headline, reasons and exit code: the proposed
/// rigs decide, references are shown, a failed canary makes it "not measured".
void conclude(Report& report);

}  // namespace backbend::validate
