#pragma once
#include <string>
#include <vector>

#include "validate/verdicts/limits.h"
#include "validate/verdicts/waivers.h"

namespace backbend::validate {

/// A limit that a suite sets in place of the table's, for all characters or for one.
struct SuiteLimit {
  std::string code;
  std::string character;  // name; empty: every character
  Limit limit;
};

/// What people have decided about limits and findings: `[[limit]]` and `[[waiver]]` of a suite.
struct SuiteRules {
  std::vector<SuiteLimit> limits;
  std::vector<Waiver> waivers;
};

/// The limits in force for a character: those of the table, the rules' studio and show layers, and
/// what they set for this character. An empty name gives those that hold for every character.
LimitSet limits_for(const SuiteRules& rules, const std::string& character);

}  // namespace backbend::validate
