#pragma once
#include <string>

namespace backbend::solver::rigs {

/// Whether a channel changes sign in a mirror: turns about axes in the mirror's plane, and moves
/// across it. The neck's own axes are X along it, Y across and Z out of the back.
inline bool mirrors(const std::string& system, const std::string& name) {
  if (system == "neck") {
    for (const char* across : {"base_z", "roll", "parent.rx", "parent.rz", "parent_move.x"}) {
      if (name == across) return true;
    }
    return false;
  }
  if (system == "snake") {
    return name.starts_with("detail.x") || name.starts_with("ribbon.x") ||
           name.starts_with("twist.") || name == "amplitude";
  }
  return name.ends_with(".rx") || name.ends_with(".ry") || name.ends_with(".x");
}

}  // namespace backbend::solver::rigs
