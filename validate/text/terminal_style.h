#pragma once
#include <string>

namespace backbend::validate {

/// How text for a terminal is laid out.
struct TerminalStyle {
  int width = 80;       // columns; at least 40 is used
  bool color = false;   // ANSI colours; the caller knows about NO_COLOR and terminals
  bool unicode = true;  // false: bars and marks in ASCII
  int worst = 3;        // how many findings are shown with detail
  std::string page;     // path of the report's page as the user may open it; empty: no line
};

}  // namespace backbend::validate
