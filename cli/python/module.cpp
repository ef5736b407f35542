#include <oneapi/tbb/global_control.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <new>

#include "cli/python/character.h"
#include "cli/python/judging.h"
#include "cli/python/python_rig.h"
#include "cli/python/rig.h"
#include "cli/python/working.h"
#include "cli/trouble.h"
#include "validate/tasks/progress.h"
#include "validate/text/escape.h"

namespace backbend::python {
namespace {

/// The exceptions of ours; never taken down, for the interpreter may be gone before.
struct Errors {
  py::object any, input, write;
};
Errors& errors() {
  static auto* all = new Errors;
  return *all;
}

py::object error_class(const char* name, const char* words, const py::object& base) {
  return py::reinterpret_steal<py::object>(
      PyErr_NewExceptionWithDoc(name, words, base.ptr(), nullptr));
}

void add_errors(py::module_& module) {
  Errors& all = errors();
  all.any = error_class("backbend.Error",
                        "What backbend cannot do, in the command line's words; exit_code is the "
                        "code that the command would end with.",
                        py::reinterpret_borrow<py::object>(PyExc_Exception));
  all.input =
      error_class("backbend.InputError", "A file, rig, pose or option that cannot be used.",
                  py::make_tuple(all.any, py::reinterpret_borrow<py::object>(PyExc_ValueError)));
  all.write =
      error_class("backbend.WriteError", "Results that cannot be written.",
                  py::make_tuple(all.any, py::reinterpret_borrow<py::object>(PyExc_OSError)));
  module.attr("Error") = all.any;
  module.attr("InputError") = all.input;
  module.attr("WriteError") = all.write;
}

/// With the interpreter's lock held, inside of a handler.
void raise(const cli::Trouble& trouble) {
  using namespace validate;
  const py::object& kind = trouble.code == kExitBadInput || trouble.code == kExitUsage
                               ? errors().input
                           : trouble.code == kExitCannotWrite ? errors().write
                                                              : errors().any;
  py::object error = kind(visible(trouble.line));
  error.attr("exit_code") = static_cast<int>(trouble.code);
  if (const py::object cause = take_cause(trouble.line)) error.attr("__cause__") = cause;
  PyErr_SetObject(kind.ptr(), error.ptr());
}

void translate(std::exception_ptr thrown) {
  try {
    std::rethrow_exception(thrown);
  } catch (const py::error_already_set&) {
    throw;  // Python's own: pybind11 passes them on
  } catch (const py::builtin_exception&) {
    throw;
  } catch (const NotNow& error) {
    PyErr_SetString(PyExc_RuntimeError, error.what());
  } catch (const validate::Interrupted&) {
    PyErr_SetNone(PyExc_KeyboardInterrupt);
  } catch (const std::bad_alloc&) {
    PyErr_NoMemory();
  } catch (...) {
    raise(cli::trouble_of_exception());
  }
}

/// How many threads our work may use from now on; 0: as many as there are cores.
void set_threads(int count) {
  if (count < 0 || count > 1024)
    throw py::value_error("threads: expected 0 to 1024, found " + std::to_string(count));
  static std::unique_ptr<oneapi::tbb::global_control> limit;
  limit.reset();
  if (count > 0)
    limit = std::make_unique<oneapi::tbb::global_control>(
        oneapi::tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(count));
}

}  // namespace
}  // namespace backbend::python

PYBIND11_MODULE(_core, module) {
  using namespace backbend::python;
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma"))
    throw py::import_error("this machine has no AVX2 and FMA, which backbend needs");
  module.attr("__version__") = BACKBEND_VERSION;
  add_errors(module);
  // Of this module's functions alone: another module's exceptions are not ours to name.
  py::register_local_exception_translator(&translate);
  watch_process();
  bind_python_rig(module);
  bind_character(module);
  bind_rig(module);
  bind_judging(module);
  module.def("set_threads", &set_threads, py::arg("count"),
             "How many threads backbend's work may use from now on; 0: as many as there are cores. "
             "Changes no result.");
}
