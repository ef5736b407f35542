#pragma once
#include <string>

namespace backbend::validate {

/// Number texts that no locale changes. Each gives `not measured` style text for what is not
/// finite: `shortest` gives "null" (it writes JSON), the others give "-" (people read them).

/// The shortest text that reads back as the same double: 0.1, 60, 1e-09. Never "-0".
std::string shortest(double value);
/// With `digits` decimals: fixed(2.345, 1) is "2.3". Never "-0.0".
std::string fixed(double value, int digits);
/// With `digits` significant digits and no trailing zeros, for tables: 171.4, 0.713, 12300. Below
/// 1e-9 it is 0.
std::string significant(double value, int digits = 4);
/// As `fixed`, with its sign always shown: "+37", "-8", "0".
std::string with_sign(double value, int digits);

}  // namespace backbend::validate
