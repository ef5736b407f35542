#pragma once
#include <pybind11/pybind11.h>

#include <memory>
#include <string>

#include "cli/python/arrays.h"
#include "validate/stage/stage.h"
#include "validate/sweeps/suite.h"

namespace backbend::python {

class Character;

/// A rig as Python holds it: a system on a chain or on a character, and what keeps it alive.
struct Rig {
  validate::RigPlan plan;
  std::shared_ptr<const Character> character;  // null: on a bare chain
  py::object python;                           // the PythonRig that it asks; null: another rig
  std::shared_ptr<const solver::SpineSystem> system;
};

/// What a caller names a rig by, as a plan: a text (`even`, `curve:length=rest`, a file,
/// `command:...`), a Rig or a PythonRig. Throws SuiteError; TypeError for anything else.
validate::RigPlan plan_of(py::handle rig);

/// Rows of control values in degrees and lengths, one per channel, as a system takes them: radians.
/// Throws TypeError and ValueError naming `controls`.
std::vector<double> read_controls(py::handle controls, const solver::SpineSystem& system,
                                  std::size_t& poses);

/// `mapping`: chest or spread. Throws ValueError.
solver::Mapping mapping_of(const std::string& name);

void bind_rig(py::module_& module);

}  // namespace backbend::python
