#include "validate/sweeps/sweep_named.h"

#include "solver/rig/nearest_name.h"

namespace backbend::validate {

std::vector<Sweep> bundled_sweeps(const Envelope& envelope) {
  std::vector<Sweep> sweeps = standard_sweeps(envelope);
  for (Sweep& corner : corner_sweeps(envelope)) sweeps.push_back(std::move(corner));
  return sweeps;
}

Sweep sweep_named(const std::string& name) {
  const std::string stress = "stress ", grid = stress + "grid";
  std::vector<std::string> names;
  for (const Sweep& sweep : bundled_sweeps()) {
    if (sweep.name == name) return sweep;
    names.push_back(sweep.name);
  }
  for (const Sweep& sweep : stress_sweeps()) {
    if (stress + sweep.name == name) return sweep;
    names.push_back(stress + sweep.name);
  }
  if (name == grid) {
    // One line after the other, each from its start to its end.
    std::vector<PoseDegrees> poses;
    double step = 0.0;
    for (const Sweep& sweep : grid_sweeps()) {
      poses.push_back(sweep.pose_at(sweep.from_deg));
      poses.push_back(sweep.pose_at(sweep.to_deg));
      step = sweep.step_deg;
    }
    return path_sweep("grid", poses, step);
  }
  names.push_back(grid);
  throw solver::RigError("no sweep '" + name + "'" + solver::did_you_mean(name, names) +
                         "; backbend list sweeps shows all");
}

}  // namespace backbend::validate
