#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "validate/why/why.h"

namespace backbend::validate {

/// What an earlier run says of one rig on one character.
struct RecordedRun {
  std::string character, hash;     // the file's name without its folder, and its content
  std::vector<std::string> spine;  // names of the driven joints
  RigPlan rig;
  solver::Mapping mapping = solver::Mapping::chest;
  std::string envelope;
  std::map<std::string, double> limits;        // by code, those that are not this program's own
  std::map<std::string, std::string> program;  // version, compiler and libraries that measured it
  Failures failures;  // of the sweeps that `check` makes, and of the file; waived ones too
  std::size_t other_sweeps = 0;  // failures of other sweeps, which cannot be measured again
};

/// Whether a version's name is a run: a folder, or its report.json.
bool is_recorded_run(const std::string& text);

/// Which of a run's characters and rigs; empty: its only character, its first proposed rig.
struct RecordedChoice {
  std::string character;  // the file's name, or the character's
  std::string rig;
};

/// Reads report.json of a run. Throws ReportError, ReadError; skin::CharacterError where the run
/// does not hold what is asked for, or the rig is none of ours.
RecordedRun read_recorded_run(const std::string& text, const RecordedChoice& choice);

/// The version that a run measured, from the file of its name in `folder`, else from any character
/// there with the same content. Throws skin::CharacterError where there is none, or where its spine
/// is now understood otherwise than the run did: the sidecar has changed since, or the run was told
/// joints that are not in `hints`.
Version version_of(const RecordedRun& run, const std::filesystem::path& folder,
                   const skin::AnatomyHints& hints, DrivenChain chain);

/// What keeps two runs from being compared: they were judged under another mapping, envelope or
/// limits. Empty: nothing.
std::string unlike(const RecordedRun& a, const RecordedRun& b);

/// `backbend 0.0.9 -> 0.1.0`: where two programs differ, one's version, compiler and libraries
/// against the other's; empty: nowhere.
std::string program_difference(const std::map<std::string, std::string>& before,
                               const std::map<std::string, std::string>& after);

}  // namespace backbend::validate
