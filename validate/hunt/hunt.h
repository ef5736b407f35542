#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "validate/files/ledger.h"
#include "validate/hunt/control_box.h"
#include "validate/hunt/flip_hunt.h"
#include "validate/measure/measure.h"
#include "validate/metrics/surface/body_metrics.h"
#include "validate/model/report.h"
#include "validate/stage/stage.h"
#include "validate/sweeps/suite.h"
#include "validate/verdicts/limits.h"

namespace backbend::validate {

/// Which poses are searched, and for what.
struct HuntSettings {
  ControlBox box;
  std::string check;               // only this one; empty: every check that can be hunted
  std::size_t evaluations = 5000;  // poses solved, most of them skinned and measured
  std::uint64_t seed = 1;
  // Of the evaluations: poses drawn evenly from the box, before all others. The search goes on from
  // them.
  std::size_t samples = 0;
  const Ledger* ledger = nullptr;  // keeps what was looked at, for a hunt that was stopped
};

/// A rig on a character, as it is judged.
struct HuntScene {
  const Stage& stage;
  const BodyMetrics& body;
  const Envelope& envelope;
  const LimitSet& limits;
  RigPlan plan;
  solver::Mapping mapping = solver::Mapping::chest;
  std::string character;  // its file and joints, as commands name them
  // The system, built again for every confirmation.
  std::function<std::unique_ptr<solver::SpineSystem>()> build;
};

/// A pose that fails a check, confirmed by a measurement of its own.
struct HuntFind {
  Finding finding;  // as `check` would say it
  // What to set. A flip lies on the straight line from `from` to `pose`; else `from` is rest.
  PoseDegrees from, pose;
  std::vector<std::pair<std::string, double>> controls;  // of the rig, in `pose`: degrees, lengths
  // How far the fault goes on through the pose along each axis of the box, degrees. A flip is met
  // on paths that are shifted so far to either side.
  std::map<std::string, double> width_deg;
  std::vector<std::string> ends_at_box;  // axes on which it reaches the box's border
  std::string picture;                   // file name; empty: none
};

/// The worst value of a check in the box, whether it fails or not.
struct HuntWorst {
  std::string code;
  double value = 0.0, limit = 0.0;
  PoseDegrees pose;
};

/// What a search found, and what it cannot know.
struct Hunt {
  ControlBox box;
  std::size_t evaluations = 0;    // spent on the search
  std::size_t confirmations = 0;  // further poses, for confirming finds and measuring their width
  std::vector<HuntFind> finds;    // worst first
  std::vector<HuntWorst> worst;   // by code
  // A fault without any slope that fits between the poses that were looked at: its half width, a
  // share of each axis, and its share of the box's volume.
  double gap = 0.0, gap_volume = 0.0;
  std::vector<std::string> notes;  // what could not be searched, and why
};

/// What a search saw, nothing of it confirmed: a night measures what it takes up of it.
struct BoxSearch {
  ControlBox box;
  std::size_t evaluations = 0;
  std::vector<HuntWorst> worst;     // by code, of the checks that decide; without rest
  std::vector<FlipPath> jumps;      // as FlipHunt::paths() gives them
  std::vector<PoseRecord> samples;  // measured
  double gap_volume = 0.0;          // as of a Hunt
  std::vector<std::string> notes;
};

/// The codes that hunt_poses() can be asked for: flips (BB001), near-flips (BB002) and what is
/// measured pose by pose.
std::vector<std::string> huntable_checks();

/// Searches the box for the worst pose of each check (pose_search.h). A find is reported only where
/// the pose, measured again by itself, fails the check. A pose that the body is too thick for
/// counts against no check of the mesh. Flips are found where the motion jumps between two near
/// poses, or where it turns ever faster: the stretch is bisected by find_flips().
///
/// The same for any number of threads. Throws solver::RigError where the rig remembers earlier
/// poses; Interrupted.
Hunt hunt_poses(const HuntScene& scene, const HuntSettings& settings, Progress& progress);

/// The same search of all checks that decide, without what comes after it: no find is confirmed, no
/// width measured. All evaluations are spent, but for some that are kept for flips; where all are
/// samples nothing else is looked at. `on_step` is told how many poses were measured, from any
/// thread. Throws what hunt_poses() throws.
BoxSearch search_poses(const HuntScene& scene, const HuntSettings& settings,
                       const std::function<void(std::size_t)>& on_step);

/// What is hunted, as a user names it.
struct HuntRequest {
  std::filesystem::path character;
  skin::AnatomyHints hints;
  DrivenChain chain = DrivenChain::spine;
  RigPlan rig;
  solver::Mapping mapping = solver::Mapping::chest;
  std::string box = "envelope";  // find_box()
  std::string envelope;          // its name; empty: the sidecar's, else that of the kind of body
  std::string check;             // empty: all
  std::size_t evaluations = 5000;
  std::uint64_t seed = 1;
  std::optional<Suite> suite;     // its limits count
  std::filesystem::path folder;   // for a picture of each find; empty: none
  int width = 640, height = 480;  // of pictures
  bool resume = false;            // takes up what a stopped hunt has left in the folder
  /// Called as soon as the character is read.
  std::function<void(const CharacterFacts&, const ControlBox&)> on_character;
};

struct HuntResult {
  CharacterFacts facts;
  std::string rig, mapping, check;
  std::uint64_t seed = 1;
  Hunt hunt;
  /// 1 where a find fails inside the envelope, 5 where nothing could be measured, else 0.
  int exit_code() const;
};

/// Loads the character and hunts. Throws what loading, find_box() and hunt_poses() throw;
/// WriteError where a picture cannot be written.
HuntResult run_hunt(const HuntRequest& request, Progress& progress);

}  // namespace backbend::validate
