#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "solver/rig/spine_system.h"

namespace backbend::solver {

/// What `backbend solve` runs: a rig built on its chain, and the control values of one pose.
struct SolveFile {
  std::string name;     // as errors print it
  std::string drawing;  // what became of [redrawn]; empty where the file has none
  std::unique_ptr<SpineSystem> system;
  std::vector<double> control;  // one per channel, radians and lengths; with keys: the first one's

  /// What `control` is at a time.
  struct Key {
    double time = 0.0;
    std::vector<double> control;
  };
  std::vector<Key> key;  // by rising time; empty for a still pose

  /// Channel by channel straight between the keys around `time`, the end keys before and after
  /// them; `control` if there are none. Angles are not wrapped: two turns are two turns.
  std::vector<double> control_at(double time) const;
};

/// Reads `[rig]` (`system` and its options), `[chain]` (`joints`, `left`, `curve`, `rest`),
/// `[path]` (`points`, `up`), `[pose]` (control values in degrees) and any `[[key]]` (`time`, and
/// `pose`, which changes `[pose]` at that time), and builds the system.
///
/// `[redrawn]` is the chain as it was edited after the rig had been built on `[chain]`: a rig with
/// `drawing = "frozen"` (the default) keeps its own, one with `drawing = "live"` is built anew on
/// it (LiveRig). `[[control]]` (`name`, `rest`) and `[[element]]` (`name`, `inputs`, `weights`,
/// `drives`) are controls of the file's own that drive the rig's channels (DrivenSystem).
///
/// Throws RigError, "FILE:LINE: what was found, what was expected", for a file that cannot be read
/// or parsed, an unknown key (with the nearest name), a wrong type, a number that is not finite, a
/// translation or scale of a control that only rotates, and whatever the system refuses.
SolveFile read_solve_file(const std::filesystem::path& file);
/// The same for text already in memory. `folder` is where a `rest` file is looked for.
SolveFile parse_solve_file(std::string_view text, const std::string& name,
                           const std::filesystem::path& folder);

/// How far a channel may be set to either side: 1e6 degrees, 1e9 of anything else. Far inside what
/// doubles can square: an overflow would become a NaN further down.
double largest_written(const Channel& channel);

/// Sets channels from one pose key as a file would: `top` = [rx, ry, rz], `top.rz` or `slide` = a
/// number. Angles in degrees. Throws OptionError for an unknown control or channel (with the
/// nearest name), a count that does not fit, or a translation of a control that only rotates.
void set_pose_key(const SpineSystem& system, const std::string& key, const OptionValue& value,
                  std::span<double> control);

/// Values of a range `from:to:step`, each from the start by a product. Both ends are included when
/// the steps meet the end to 1e-9 of a step. Throws RigError, after `start`, for text that is none,
/// a step of zero or away from the end, or more than a million values.
std::vector<double> parse_range(std::string_view text, const std::string& start);

/// One control channel moved over a range: `top.rz=0:-150:-5`.
struct ControlSweep {
  std::size_t channel = 0;      // index into SpineSystem::channels()
  std::vector<double> written;  // values as in the text (degrees, lengths)
  std::vector<double> value;    // radians, lengths
};
/// Throws RigError for text that is not `control.channel=from:to:step`, an unknown channel, or a
/// range that is none.
ControlSweep parse_sweep(const SpineSystem& system, std::string_view text);

/// `{"schema": "backbend.pose/1", "system", "options", "joints": [{"name", "parent", "position",
/// "turn"}], "measures", "flags"}` of one pose on one line, no newline at the end. `parent` is the
/// index of a joint or null; `turn` is w, x, y, z. Numbers read back to the same doubles.
std::string pose_to_json(const SpineSystem& system, const SpinePose& pose);
/// The same with `"control": {channel: value}` in front of the joints: a line of a sweep.
std::string pose_to_json(const SpineSystem& system, const SpinePose& pose, std::string_view channel,
                         double written);

/// The pose of a solve file, as JSON.
std::string solve_to_json(const SolveFile& file);
/// One such line for each value of a sweep, each ended by a newline; `control_at` has the channel
/// values of each.
std::string sweep_to_json_lines(const SpineSystem& system, std::string_view channel,
                                std::span<const double> written,
                                const std::function<std::vector<double>(std::size_t)>& control_at);
/// The same for a sweep of a solve file. `time=from:to:step` plays the
/// file's keys. Throws RigError as parse_sweep() does, and for a time in a file without keys.
std::string sweep_to_json_lines(const SolveFile& file, std::string_view sweep);
/// The pose for a person: a table of joints and the measures.
std::string solve_to_text(const SolveFile& file);

}  // namespace backbend::solver
