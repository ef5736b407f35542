#include "cli/python/judging.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "cli/python/character.h"
#include "cli/python/rig.h"
#include "cli/python/working.h"
#include "solver/rig/nearest_name.h"
#include "validate/model/report_json.h"
#include "validate/night/standard_runs.h"
#include "validate/sweeps/envelope.h"

namespace backbend::python {
namespace {

namespace py = pybind11;
using namespace pybind11::literals;
using namespace backbend::validate;

std::string file_of(py::handle character) {
  if (py::isinstance<Character>(character))
    return character.cast<const Character&>().file().string();
  PyObject* bytes = nullptr;
  if (PyUnicode_FSConverter(character.ptr(), &bytes) == 0) throw py::error_already_set();
  return py::reinterpret_steal<py::object>(bytes).cast<std::string>();
}

skin::AnatomyHints hints_of(py::handle character) {
  if (!py::isinstance<Character>(character)) return {};
  return character.cast<const Character&>().hints();
}

void require_one_of(const char* what, const std::string& word, std::vector<std::string> known) {
  if (std::ranges::find(known, word) != known.end()) return;
  std::string all;
  for (const std::string& each : known) all += (all.empty() ? "" : ", ") + each;
  throw py::value_error(std::string(what) + " '" + word + "'" + solver::did_you_mean(word, known) +
                        ": expected one of " + all);
}

/// Pictures are made where there is a folder for them.
std::string run(RunRequest request, const std::filesystem::path& folder, bool pictures) {
  request.folder = folder;
  request.image_pass = pictures;
  request.suite.pictures.enabled = pictures && !folder.empty();
  std::string text;
  run_long([&] {
    Progress silent(Progress::Style::none);
    text = report_json(run_request(request, silent));
  });
  return text;
}

std::string judge(py::handle character, py::handle rig, const std::string& mapping,
                  const std::string& envelope, const std::string& sweeps,
                  const std::filesystem::path& folder, bool pictures) {
  std::vector<std::string> envelopes = envelope_names();
  envelopes.insert(envelopes.begin(), kEnvelopeByKind);
  require_one_of("envelope", envelope, std::move(envelopes));
  require_one_of("sweeps", sweeps, {"standard", "stress"});
  CheckWishes wishes;
  wishes.character = file_of(character);
  wishes.rig = plan_of(rig);
  wishes.mapping = mapping_of(mapping);
  wishes.envelope = envelope;
  wishes.sweeps = sweeps;
  wishes.hints = hints_of(character);
  if (py::isinstance<Character>(character))
    wishes.chain = character.cast<const Character&>().chain();
  return run(check_request(wishes), folder, pictures);
}

std::string compare_rigs(py::handle a, py::handle b, py::handle character,
                         const std::string& mapping, const std::string& sweeps,
                         const std::filesystem::path& folder, bool pictures) {
  require_one_of("sweeps", sweeps, {"standard", "stress"});
  RunRequest request =
      compare_rigs_request({plan_of(a), plan_of(b), character.is_none() ? "" : file_of(character),
                            mapping_of(mapping), sweeps});
  if (!character.is_none()) request.hints = hints_of(character);
  return run(std::move(request), folder, pictures);
}

std::string compare_characters(const Character& a, const Character& b, py::handle rig,
                               const std::string& mapping, const std::string& sweeps,
                               const std::filesystem::path& folder, bool pictures) {
  require_one_of("sweeps", sweeps, {"standard", "stress"});
  return run(compare_characters_request(
                 {a.file().string(), b.file().string(), plan_of(rig), mapping_of(mapping), sweeps}),
             folder, pictures);
}

}  // namespace

void bind_judging(py::module_& module) {
  module.def("_judge", &judge, "character"_a, "rig"_a, "mapping"_a, "envelope"_a, "sweeps"_a,
             "folder"_a, "pictures"_a);
  module.def("_compare_rigs", &compare_rigs, "a"_a, "b"_a, "character"_a, "mapping"_a, "sweeps"_a,
             "folder"_a, "pictures"_a);
  module.def("_compare_characters", &compare_characters, "a"_a, "b"_a, "rig"_a, "mapping"_a,
             "sweeps"_a, "folder"_a, "pictures"_a);
  module.def("_report_schema", [] { return std::string(report_schema()); });
}

}  // namespace backbend::python
