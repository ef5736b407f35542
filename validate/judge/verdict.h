#pragma once
#include "validate/model/report.h"

namespace backbend::validate {

/// Gives each rig and the whole report its verdict, headline, reasons and exit code: the proposed
/// rigs decide, references are shown, a failed canary makes it "not measured". So does a character
/// with doubts: what was found on it is shown and does not decide before a person has confirmed it.
void conclude(Report& report);

}  // namespace backbend::validate
