#pragma once
#include <string>

#include "validate/model/report.h"

namespace backbend::validate {

/// A few lines of plain text for whatever posts them (mail, chat): verdict and title, headroom that
/// falls short, counts, the worst finding. No line is longer than 200 columns.
std::string headline_text(const Report& report);

/// Which control angle each picture of a sweep shows, as CSV: rig, mapping, sweep, frame number,
/// degrees, picture. Empty where no sweep has pictures.
std::string angles_csv(const Report& report);

}  // namespace backbend::validate
