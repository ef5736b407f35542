#pragma once
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "solver/rig/spine_system.h"
#include "validate/sweeps/envelope.h"
#include "validate/sweeps/suite_rules.h"
#include "validate/sweeps/sweep.h"
#include "validate/verdicts/finding.h"

namespace backbend::validate {

/// A suite or rig file that cannot be used. what() is the whole line: file:line, cause, hint.
struct SuiteError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What a canary must be caught at, and the rig with only that fault removed.
struct CanaryDuty {
  std::string code, sweep, joint;  // joint: empty for any
  solver::Mapping mapping = solver::Mapping::chest;
  double control_deg = 0, tolerance_deg = 0;
  solver::SystemSpec twin;
};

/// One rig of a suite.
struct RigPlan {
  std::string name;
  solver::SystemSpec spec;
  Role role = Role::proposed;
  std::optional<CanaryDuty> duty;  // canaries only
};

/// Which pictures a run makes beside the measurements.
struct PicturePlan {
  bool enabled = true;
  int width = 640, height = 360;
  int samples = 16;         // of a pixel at most: clean tiles end at half
  int turntable_views = 0;  // per rig, at its worst pose; 0: none
  int sheet_columns = 6;    // poses of the leading sweep on a contact sheet; 0: none
};

/// What a run searches beside its sweeps: for the worst poses of each rig inside the envelope.
struct HuntPlan {
  double percent = 0.0;  // poses, of those that the rig's sweeps measure; 0: nothing is searched
  int samples = 0;       // random poses at least, also where nothing is searched
  int seed = 1;
};
inline constexpr double kMostHuntPercent = 10000.0;

/// Planted faults that a run tries its own detectors on: as many clean poses of each body, and so
/// many faulted ones of each size. 0: the run plants none.
struct CalibrationSlice {
  int poses = 0, faults = 0;
};

/// A nightly job: characters x rigs x mappings x sweeps.
struct Suite {
  std::string name, title;
  std::filesystem::path file;
  std::vector<std::filesystem::path> characters;  // absolute
  std::vector<RigPlan> rigs;
  std::vector<solver::Mapping> mappings;
  std::vector<Sweep> sweeps;  // with `standard`: those of a human's envelope, for estimates
  bool standard = false;      // the standard sweeps of each character's envelope instead
  bool corners = false;       // and straight to each corner of it
  std::vector<Sweep> poses;   // and to each named pose: [[pose]]
  Envelope envelope;
  bool envelope_by_kind = false;  // each character's own, by the kind of its body
  PicturePlan pictures;
  HuntPlan hunt;
  CalibrationSlice calibration;
  SuiteRules rules;             // limits that were moved, findings that were accepted
  bool judges_weights = false;  // mesh findings count against the character, not only the rig
};

/// Reads a suite from TOML. Throws SuiteError naming file, line and the nearest key for every
/// unknown key, wrong type or value out of range.
Suite read_suite(const std::filesystem::path& file);

/// What a suite sweeps on a character with this envelope: its sweeps, or the standard ones, then
/// the corners, then the paths to its named poses.
std::vector<Sweep> sweeps_for(const Suite& suite, const Envelope& envelope);

/// `--rig`: the name of a system, the same with options (`curve:length=rest,bones=12`), or a TOML
/// file with a [rig] table. Throws SuiteError.
RigPlan read_rig(const std::string& text);

/// Whether a TOML file holds a [rig] (and is no body description). Throws SuiteError where it
/// cannot be read.
bool is_rig_file(const std::filesystem::path& file);

/// The text that read_rig() makes the same system of: `curve:length="rest"`.
std::string rig_text(const solver::SystemSpec& spec);

}  // namespace backbend::validate
