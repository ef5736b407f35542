#pragma once
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace backbend::validate {

enum class Verdict { pass, fail, waived, stress, not_measured, not_applicable };
/// Who must act: a solver of ours, a living rig or its clip, captured or keyed motion, the mesh's
/// weights, a skeleton with too few joints for the range (advisory), a pose that the body cannot
/// take, the file, or this tool.
enum class Owner { none, solver, rig, motion, weights, skeleton, pose, input, tool };
/// In a suite: who decides the exit code, who is only shown, who must fail.
enum class Role { proposed, reference, canary };

/// NaN compares false with everything, so `measured > limit` would call it a pass.
inline Verdict judge(double measured, double limit) {
  if (!std::isfinite(measured)) return Verdict::not_measured;
  return measured <= limit ? Verdict::pass : Verdict::fail;
}

/// What a picture says about a defect that geometry decided, found without looking at geometry.
struct ImageWitness {
  bool measured = false;
  bool visible = false;
  std::string camera;  // the view that shows it best
  std::string metric;  // `flip_mean`, `silhouette_hausdorff_px`, ...
  double value = 0.0;
  double threshold = 0.0;
  double pixels = 0.0;  // how many pixels changed visibly
  std::string note;
};

/// Names of pictures of one finding, relative to the report's folder; empty where none was made.
struct FindingPictures {
  std::string before, after, heat, other;  // `other`: the same pose under the other rig
  std::string other_rig{};                 // what that rig is called
  std::string view{};                      // the side that they are seen from: `profile`
  std::string heat_of{};                   // what the heat shows: `mesh kink, deg`
};

/// A command line that may cure a finding. It measures again by itself.
struct Cure {
  std::string command;
  std::string gives;  // what was measured that speaks for it, one line; empty: nothing was
};

/// A pose among what was measured, by numbers: names are for readers of a report.
struct PoseRef {
  int rig = -1;    // into Report::rigs; -1: of none, or not in a report yet
  int sweep = -1;  // into the rig's sweeps; -1: at none
  int pose = -1;   // into the sweep's poses; -1: between them
  bool operator==(const PoseRef&) const = default;
};

/// One thing that was measured and judged, with its place and how to see it again.
struct Finding {
  std::string code;  // BB001 ...: a row of the table of checks
  PoseRef at;
  // What a report calls that, and the same from night to night. Nothing of one run is looked up by
  // them.
  std::string character, rig, mapping;
  std::string sweep;                   // `extension`, `side`, ...
  std::string pose;                    // in channel names: `extension 114.3`
  std::optional<int> frame;            // of a clip: the file's own number
  std::optional<double> time_s;        // of a clip: its own second
  double control_deg = 0;              // where on the sweep, degrees of its leading channel
  std::string joint;                   // where, or the nearest joint; empty if none
  std::array<std::string, 2> between;  // the spine joints on both sides, lower first; empty: at
                                       // `joint`
  std::string side;  // `left`, `right`, `front` or `back` of the body; empty: no one side
  std::string part;  // name of the mesh part
  int slice = -1;    // place on the mesh along the spine
  int vertex = -1;
  double value = 0.0, limit = 0.0;
  std::string unit;
  Verdict verdict = Verdict::pass;
  Owner owner = Owner::none;
  bool inside_envelope = true;
  std::string detail;                      // one line: what was seen, in numbers
  std::map<std::string, double> geometry;  // further numbers by name
  ImageWitness image;
  FindingPictures pictures;
  std::string reproduce;  // command line that shows it again
  std::vector<Cure> cures;
  /// Program (`maya`, `blender`) -> the line of Python that puts the artist's own rig into the
  /// pose; empty where no sidecar says which control does what.
  std::map<std::string, std::string> artist;
};

}  // namespace backbend::validate
