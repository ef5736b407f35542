#pragma once
#include <string>

#include "validate/night/run.h"

namespace backbend::validate {

// What `check` and `compare` run, in one place for the command line and for Python. Joint names
// that a user gives, pictures, folder, baseline and history are the caller's to add.

/// The default canary of a run (specification 8).
RigPlan isner_canary();

/// Has the suite sweep as a name says: `standard`, or `stress` with the grid of poses; either with
/// the corners of the envelope.
void sweep_as_named(const std::string& name, Suite& suite);

/// Which chain a rig drives: `spine`, `neck`, or where nothing was said the neck for the rig `neck`
/// unless joints were named.
DrivenChain driven_chain(const std::string& chain, const RigPlan& rig,
                         const skin::AnatomyHints& hints);

/// The name that stands for the envelope of each character's kind.
inline constexpr const char* kEnvelopeByKind = "auto";

/// One character under one rig.
struct CheckWishes {
  std::string character;  // file as the user named it
  RigPlan rig;
  solver::Mapping mapping = solver::Mapping::chest;
  std::string envelope = kEnvelopeByKind;  // or one of envelope_names()
  std::string sweeps = "standard";         // or `stress`
  std::string chain;                       // driven_chain()
  skin::AnatomyHints hints;
};
RunRequest check_request(const CheckWishes& wishes);

/// Two rigs on one character, over everything that is swept; the second is the reference.
struct RigComparisonWishes {
  RigPlan proposed, reference;
  std::string character;  // file; empty: the bundled human
  solver::Mapping mapping = solver::Mapping::chest;
  std::string sweeps = "stress";  // or `standard`
};
RunRequest compare_rigs_request(const RigComparisonWishes& wishes);

/// Two versions of a character under one rig; the second decides. Throws skin::CharacterError where
/// one of the files is missing, before the first is measured.
struct CharacterComparisonWishes {
  std::string first, second;  // files
  RigPlan rig;
  solver::Mapping mapping = solver::Mapping::chest;
  std::string sweeps = "stress";
};
RunRequest compare_characters_request(const CharacterComparisonWishes& wishes);

/// Runs a request for a program of its own: nothing is written where its folder is empty, else the
/// report in all its forms with its pictures. Throws what run_suite() and OutputFolder throw.
Report run_request(const RunRequest& request, Progress& progress);

}  // namespace backbend::validate
