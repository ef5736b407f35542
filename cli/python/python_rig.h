#pragma once
#include <pybind11/pybind11.h>

#include <memory>
#include <optional>
#include <string>

#include "validate/live/in_process_rig.h"
#include "validate/sweeps/suite.h"

namespace backbend::python {

namespace py = pybind11;

/// A rig written in Python, known to this process as long as this lives.
class PythonRig {
 public:
  /// `answer`: a callable of (values: poses x channels, points: bool) that gives the joints'
  /// matrices and the points as bytes; it must not keep the Python object alive. `hello`: JSON as
  /// docs/rig_protocol.md has it. `map`: a mapping file; empty: the sidecar's, or by name.
  void start(const std::string& name, std::string hello, std::string map, py::object answer);
  /// Throws NotNow where start() was not called: a class that does not call super().__init__().
  validate::RigPlan plan() const;

 private:
  std::string name_, map_;
  std::optional<validate::KnownRig> known_;
};

/// What a rig's pose() raised last, if `line` tells of it, to be named as its cause; forgets it.
py::object take_cause(const std::string& line);

void bind_python_rig(py::module_& module);

}  // namespace backbend::python
