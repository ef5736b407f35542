#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "validate/sweeps/suite.h"
#include "validate/tasks/progress.h"

namespace backbend::validate {

/// One property that must hold on this machine: what was tried, the worst that was seen, and what
/// is allowed. Not measured is not held.
struct Property {
  std::string layer, name;  // solver, "moved and turned"
  std::string subject;      // rig or character
  double worst = 0.0;       // NaN: could not be measured
  double bound = 0.0;
  std::string unit;
  std::size_t cases = 0;
  std::string where;  // the worst case, for a person

  bool holds() const { return cases > 0 && worst <= bound; }
  /// How much room is left, as a factor; infinite where nothing at all was off.
  double margin() const;
};

struct SelftestRequest {
  std::filesystem::path character;
  std::vector<RigPlan> rigs;
  skin::AnatomyHints hints;
  bool full = false;  // ten times the cases
};

/// Tries the metamorphic properties of solver, skinner and renderer: the same rig elsewhere in the
/// world, scaled and mirrored, in another order; skinning carried along by a rigid motion, between
/// the bones that carry it, for any number of threads; pictures with another number of threads,
/// under twice the light, and twice as large. A studio's own rig is tried at rest, at any angle,
/// and against its program started again. Random numbers have fixed seeds. Throws
/// skin::CharacterError, solver::RigError, Interrupted.
std::vector<Property> selftest(const SelftestRequest& request, Progress& progress);

}  // namespace backbend::validate
