#include "cli/python/python_rig.h"

#include <cstring>

#include "cli/python/arrays.h"
#include "cli/python/working.h"

namespace backbend::python {
namespace {

using namespace pybind11::literals;

// Written with the interpreter's lock held.
struct LastRaised {
  std::string text;
  py::object exception;
};
LastRaised& last_raised() {
  static auto* raised = new LastRaised;  // never taken down: the interpreter may be gone before
  return *raised;
}

/// `ValueError: no such joint`, on one line.
std::string text_of(const py::error_already_set& error) {
  std::string text = py::str(error.type().attr("__name__")).cast<std::string>();
  try {
    text += ": " + py::str(error.value()).cast<std::string>();
  } catch (const py::error_already_set&) {
    // Its own text cannot be told either.
  }
  return text.substr(0, text.find('\n'));
}

std::vector<std::uint8_t> bytes_of(const py::handle& bytes) {
  const std::string_view text = bytes.cast<std::string_view>();
  return {text.begin(), text.end()};
}

class AskedInPython final : public validate::InProcessRig {
 public:
  AskedInPython(std::string hello, py::object answer)
      : hello_(std::move(hello)), answer_(std::move(answer)) {}
  ~AskedInPython() override {
    if (Py_IsInitialized() == 0) {
      answer_.release();
      return;
    }
    const py::gil_scoped_acquire locked;
    answer_ = py::object();
  }

  std::string hello() const override { return hello_; }

  Answer ask(std::span<const double> values, std::size_t poses, bool points) override {
    const py::gil_scoped_acquire locked;
    const PosingInPython posing;
    try {
      const auto rows = static_cast<py::ssize_t>(poses);
      const auto channels = static_cast<py::ssize_t>(poses == 0 ? 0 : values.size() / poses);
      const py::tuple said = answer_(
          array_of(std::vector<double>(values.begin(), values.end()), {rows, channels}), points);
      return {bytes_of(said[0]), bytes_of(said[1])};
    } catch (py::error_already_set& error) {
      last_raised() = {text_of(error), error.value()};
      throw std::runtime_error("pose() raised " + last_raised().text);
    } catch (const py::cast_error&) {
      throw std::runtime_error("pose() gave no answer that can be read");
    }
  }

 private:
  std::string hello_;
  py::object answer_;
};

}  // namespace

void PythonRig::start(const std::string& name, std::string hello, std::string map,
                      py::object answer) {
  name_ = name;
  map_ = std::move(map);
  known_.emplace(name, std::make_shared<AskedInPython>(std::move(hello), std::move(answer)));
}

validate::RigPlan PythonRig::plan() const {
  if (!known_)
    throw NotNow("this PythonRig was not set up: its class must call super().__init__(...)");
  validate::RigPlan plan;
  plan.name = name_;
  plan.spec = known_->spec();
  if (!map_.empty()) plan.spec.options["map"] = map_;
  return plan;
}

py::object take_cause(const std::string& line) {
  LastRaised& last = last_raised();
  py::object cause;
  if (last.exception && line.find(last.text) != std::string::npos) cause = last.exception;
  last = LastRaised();
  return cause;
}

void bind_python_rig(py::module_& module) {
  py::class_<PythonRig, std::shared_ptr<PythonRig>>(module, "_PythonRig")
      .def(py::init<>())
      .def("_start", &PythonRig::start, "name"_a, "hello"_a, "map"_a, "answer"_a);
}

}  // namespace backbend::python
