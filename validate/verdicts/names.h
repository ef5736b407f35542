#pragma once
#include <optional>
#include <string_view>

#include "validate/verdicts/finding.h"

namespace backbend::validate {

/// The words of spec 9 for the three enumerations, as they stand in report.json.
std::string_view verdict_word(Verdict verdict);  // `pass`, `not_measured`, ...
std::string_view owner_word(Owner owner);        // `SOLVER`, ...; `none` where nobody must act
std::string_view role_word(Role role);           // `proposed`, ...

/// The inverse; nullopt for any other word.
std::optional<Verdict> verdict_from_word(std::string_view word);
std::optional<Owner> owner_from_word(std::string_view word);
std::optional<Role> role_from_word(std::string_view word);

}  // namespace backbend::validate
