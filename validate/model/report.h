#pragma once
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "validate/verdicts/finding.h"

namespace backbend::validate {

/// Rendered sequences start at frame 1001 (room for pre-roll) and play at 24 frames a second.
inline constexpr int kFirstFrame = 1001;
inline constexpr double kFramesPerSecond = 24.0;

/// How far one channel is clean, and how much that leaves over what the envelope needs. Degrees.
struct Headroom {
  std::string channel;      // extension, flexion, side, twist
  double clean_to_deg = 0;  // the largest tested angle with everything below it clean
  double tested_to_deg = 0;
  double needs_deg = 0;
  bool measured = false;
  double headroom_deg() const { return clean_to_deg - needs_deg; }
  /// Whether it was measured as far as the envelope needs.
  bool covered() const { return measured && tested_to_deg >= needs_deg - 1e-9; }
};

/// How far one of our systems is clean on a character.
struct RigHeadroom {
  std::string system;
  std::vector<Headroom> headroom;
};

/// The poses on the way from rest to the corners of the envelope: extension or flexion, side and
/// twist together.
struct Corners {
  int poses = 0, clean = 0;
  bool needed = false;      // the envelope has corners
  std::string worst, code;  // the pose that is furthest over a limit, and by which check
  double clean_percent() const { return poses == 0 ? 0.0 : 100.0 * clean / poses; }
  bool covered() const { return poses > 0 || !needed; }
};

/// The search for jumps between the sweeps: paths from the end of flexion through rest to the end
/// of extension, at each pair of a lattice of side and twist.
struct CompoundSearch {
  int paths = 0, poses = 0;  // poses: at which it started to look; it looks between them as needed
  int with_jumps = 0;        // paths
  int unsure = 0;            // paths that could not be certified
  std::string box;           // `extension 0..120, flexion 0..90, side +-45, twist +-90`
};

/// The worst pose of one check that a search of the envelope saw.
struct HuntedPose {
  std::string code, unit, pose;  // pose: `extension 40, side 30`
  double value = 0, limit = 0;
  bool over = false;  // it fails
  // The path on which the run measured it afterwards, among the rig's sweeps. -1: nothing is over,
  // or the sweeps show the check as bad.
  int sweep = -1;
};

/// What was searched beside the sweeps for the worst poses of a rig.
struct PoseHunt {
  int evaluations = 0;  // poses; 0: nothing was searched
  int seed = 1;
  std::string box;  // `extension 0..60, flexion 0..90, side -45..45, twist -60..60`
  double gap = 0;   // share of the box that fits between the poses, none of them in it
  std::vector<HuntedPose> worst;   // by code
  std::vector<std::string> notes;  // what could not be searched, and why
};

/// How much of the envelope is clean, by volume: what is proved, and what random poses say. Two
/// figures of two questions, never added up.
struct CleanVolume {
  std::string box;  // as of a PoseHunt
  // Of the joints alone: that none jumps, and none turns more than `gain` times as fast as a
  // channel. Shares of the volume.
  bool proved = false;  // a proof was tried
  double certified = 0, no_jump = 0, refuted = 0, gain = 0;
  std::string not_proved;  // why none was
  // Every deciding check that a pose shows by itself, at seeded random poses.
  int poses = 0, clean = 0;
  double at_least = 0;  // share of the volume that is clean, with the confidence kVolumeConfidence
};
inline constexpr double kVolumeConfidence = 0.95;

/// One sweep of one rig: a value per pose for every plotted metric.
struct SweepSeries {
  std::string sweep, channel, mapping;
  std::vector<double> control_deg;                    // one per pose
  std::map<std::string, std::vector<double>> metric;  // by name; NaN: not measured
  std::map<std::string, std::string> metric_unit;
  std::map<std::string, double> metric_limit;  // absent or NaN: no limit is drawn
  std::vector<std::string> frame;              // picture per pose, relative path, empty where none
  std::map<std::string, std::vector<double>> pose_deg;  // by channel; empty: not in channels
};

/// Planned, measured and not measured for one check on one rig: the sums must match.
struct Coverage {
  std::string code;
  int planned = 0, measured = 0, not_measured = 0, not_applicable = 0;
};

/// One rig on one character.
struct RigResult {
  std::string character, rig, system, mapping;
  Role role = Role::proposed;
  std::map<std::string, std::string> options;
  Verdict verdict = Verdict::not_measured;
  std::vector<Headroom> headroom;
  std::vector<RigHeadroom> beside;  // of systems of ours on this character
  Corners corners;
  CompoundSearch search;
  PoseHunt hunt;
  CleanVolume volume;
  std::vector<SweepSeries> sweeps;
  std::vector<Coverage> coverage;
  std::map<std::string, double> summary;  // worst value per metric, by name
};

struct CharacterFacts {
  std::string name, file, hash;
  int meshes = 0, vertices = 0, triangles = 0, joints = 0;
  double height = 0, spine_length = 0;
  std::vector<std::string> spine, left_arm, right_arm;
  std::vector<std::string> doubts;        // what a person has to confirm first; empty: sure
  std::string kind, kind_reason;          // `human`, `arms on an upright spine`
  std::string envelope, envelope_reason;  // its name; where it comes from, and its figures
  std::vector<std::string> notes;
};

/// A canary's duty: exactly this finding, and none on its repaired twin.
struct CanaryResult {
  std::string rig, code, joint;
  double expected_deg = 0, tolerance_deg = 0, found_deg = 0;
  bool found = false, twin_clean = false;
  std::string detail;
  bool ok() const { return found && twin_clean; }
};

struct MediaItem {
  std::string kind;  // `contact_sheet`, `video`, `turntable`
  std::string title, path;
};

/// Side by side frames of one event, for the page's comparison view.
struct PicturePair {
  std::string title, caption;
  std::string a_path, a_label, b_path, b_label, heat_path;
  int finding = -1;  // into Report::findings: the event these frames show, -1 if none
};

/// A posed mesh that the page turns in 3D, from the files of page_mesh.h. Poses of one mesh share
/// their triangles.
struct MeshView {
  std::string title;                      // `isner (chest), extension 114.3`
  std::string pose_path, triangles_path;  // relative to the report
  std::string heat, unit;                 // what the colours show, `moved since the frame before`
  double heat_low = 0, heat_high = 0;     // the scale, the same for all views that are compared
  int finding = -1;                       // into Report::findings, -1 if none
  std::string view{};                     // the side that shows it: `profile`; empty: not known
  std::vector<double> mark{};             // x y z of the place, in the mesh's space; or empty
};

/// One row of the table of checks, so that a reader of the report needs no other page.
struct CheckLegend {
  std::string code, name;    // BB011, mesh kink
  std::string measures;      // what is measured, one line
  std::string unit, reason;  // reason: why the limit is where it is
  double limit = 0;          // the default; NaN: none
  std::string sense;         // `at most`, `at least`
};

/// A lasting change of a metric's level from one night on.
struct TrendStep {
  int night = 0;                 // index into Report::nights: the first night of the new level
  double before = 0, after = 0;  // mean levels
  bool worse = false;
  std::string version;      // the night and version where the new level began
  std::string last_before;  // the last one of the old level; empty: not in sight
  std::string recovered;    // where a later step undid it; empty: it stands
};

/// What one detector was shown to see tonight: planted faults of rising size among clean poses.
struct CalibrationRow {
  std::string detector, code, body, unit;  // body: what it was tried on, `24 bones`
  double threshold = 0;
  std::string threshold_unit;       // pictures are read in other units than faults are made in
  int clean = 0, false_alarms = 0;  // clean poses, and how many of them it flagged
  double target = 0;                // the size that has to be found
  double smallest = 0;              // found in 99 of 100, as is all that is larger; NaN: none
  bool ok = false;                  // no false alarm, and the target found
  int compared = 0, alike = 0;      // cases that pictures and geometry judged, and how many alike
};

/// One metric of one rig over the nights of the suite's history.
struct Trend {
  std::string character, rig, mapping, metric, unit;
  bool more_is_worse = true;
  std::vector<double> value;  // one per night; NaN: not measured
  std::vector<TrendStep> steps;
};

/// A pose at which one side of a comparison is worse than the other by one check.
struct ComparedPose {
  std::string sweep, pose;  // `grid side 30 twist 45`; `extension 90, side 30, twist 45`
  PoseRef at;               // among the sweeps of a, of whichever rig; a file has no sweep's number
  double control_deg = 0;
  std::string code, unit;
  double a = 0, b = 0, limit = 0;
  std::string a_path, b_path;        // frames of both sides, relative to the report; empty: none
  std::string a_command, b_command;  // that show them again; empty: none
};

/// One metric over all paired poses.
struct MetricComparison {
  std::string metric, code, unit;
  double tolerance = 0;  // a smaller difference counts as none
  int a_better = 0, b_better = 0, same = 0;
  double median_gain = 0;  // over the poses, by how much a is better than b; unit
};

/// How the poses of one sweep compare.
struct SweepComparison {
  std::string sweep;
  std::map<std::string, std::vector<double>> pose_deg;  // as in SweepSeries
  std::vector<double> control_deg;
  std::string marks;  // one a pose: + a is better, - b is, x each in something, = same, ? unpaired
};

/// Two rigs, characters, clips or runs, paired on every pose.
struct Comparison {
  std::string a, b;  // what the sides are called
  std::string character, mapping;
  double matched = std::numeric_limits<double>::quiet_NaN();  // share of b's surface found on a's,
                                                              // where the bodies are two
  int paired = 0, unpaired = 0;
  int a_better = 0, b_better = 0, mixed = 0, same = 0;  // of the paired poses
  int a_over = 0, b_over = 0;  // paired poses with something over its limit
  std::string ahead;           // `a`, `b`; empty: a draw
  std::string sampled;         // what random poses say of all, and how surely; empty: none were
  std::vector<MetricComparison> metrics;
  std::vector<ComparedPose> worst_of_a, worst_of_b;  // what speaks most against each
  std::vector<SweepComparison> sweeps;
};

/// Everything a report shows. report.json is this, and every other form is a function of it.
struct Report {
  std::string title, suite, headline;
  std::vector<std::string> reasons;  // why the verdict is what it is, one line each
  Verdict verdict = Verdict::not_measured;
  int exit_code = 0;
  std::map<std::string, std::string> provenance;  // versions, hashes; no clock, host or path
  std::vector<CharacterFacts> characters;
  std::vector<RigResult> rigs;
  std::vector<Finding> findings;  // worst first
  std::vector<CanaryResult> canaries;
  std::vector<std::string> detectors;       // one line each: sensitivity at zero false alarms
  std::vector<CalibrationRow> calibration;  // empty where the run planted no faults
  std::vector<Comparison> comparisons;
  bool is_comparison = false;  // made to compare: its last word is which side is ahead
  std::vector<PicturePair> pairs;
  std::vector<MediaItem> media;
  std::vector<MeshView> meshes;
  std::vector<std::string> nights;  // of the history, oldest first; tonight is the last
  std::vector<Trend> trends;        // regressions that stand first; empty without a history
  std::vector<std::string> next;    // commands to type next
  std::vector<CheckLegend> checks;  // by code; every code that was planned
};

}  // namespace backbend::validate
