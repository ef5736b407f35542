#pragma once
#include <string>
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "skin/anatomy/driver_coverage.h"

namespace backbend::skin {

/// What `backbend inspect --json` prints: schema `backbend.inspect/1`, keys sorted, two spaces of
/// indent, no line break at the end. Lengths in the file's unit, shares 0..1, angles none. Joints
/// without a name are `#` and their node number; bytes that are not UTF-8 become U+FFFD.
std::string inspect_json(const Character& character, const Anatomy& anatomy);

/// The same for a person: one fact a line, the skeleton as a tree at the end.
std::string inspect_text(const Character& character, const Anatomy& anatomy);

/// What our rigs leave unmoved, in words: a line for the helpers and one for what is unreached,
/// each where there are some.
std::vector<std::string> coverage_lines(const Character& character, const DriverCoverage& coverage);

}  // namespace backbend::skin
