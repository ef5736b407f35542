#pragma once
#include <pybind11/pybind11.h>

namespace backbend::python {

/// `_judge` and `_compare`, which give the text of report.json.
void bind_judging(pybind11::module_& module);

}  // namespace backbend::python
