#pragma once
#include <pybind11/pybind11.h>

#include <filesystem>
#include <memory>
#include <mutex>

#include "skin/anatomy/anatomy.h"
#include "skin/deform/skinning_plan.h"
#include "validate/metrics/surface/body_metrics.h"
#include "validate/stage/stage.h"

namespace backbend::python {

namespace py = pybind11;

/// A character as Python holds it: read, its spine found, ready to be posed. Immutable.
class Character {
 public:
  /// Without the interpreter's lock. Throws skin::CharacterError; Interrupted.
  Character(std::filesystem::path file, skin::AnatomyHints hints, const std::string& chain);

  const std::filesystem::path& file() const { return file_; }
  const skin::AnatomyHints& hints() const { return hints_; }
  const std::string& chain() const { return chain_; }
  const validate::Stage& stage() const { return *stage_; }
  /// Made when the first pose is skinned, without the interpreter's lock.
  const skin::SkinningPlan& plan() const;
  /// Made when the first pose is measured, without the interpreter's lock.
  const validate::BodyMetrics& body() const;
  /// Memory to skin one pose into; that of an earlier pose where nothing shows it any more.
  std::shared_ptr<skin::PosedMesh> mesh_to_skin_into() const;

 private:
  std::filesystem::path file_;
  skin::AnatomyHints hints_;  // as the caller gave them
  std::string chain_;
  std::unique_ptr<const validate::Stage> stage_;
  mutable std::once_flag plan_made_, body_made_;
  mutable std::unique_ptr<const skin::SkinningPlan> plan_;
  mutable std::unique_ptr<const validate::BodyMetrics> body_;
  struct Spare {
    std::mutex mutex;
    std::unique_ptr<skin::PosedMesh> mesh;  // null: in use
  };
  std::shared_ptr<Spare> spare_ = std::make_shared<Spare>();  // arrays may outlive the character
};

/// A body pose from its channels: extension=90, side=10. Throws TypeError, ValueError; RigError
/// with the nearest name for an unknown channel.
validate::PoseDegrees pose_of(const py::kwargs& channels);

void bind_character(py::module_& module);

}  // namespace backbend::python
