#pragma once
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "validate/sweeps/envelope.h"
#include "validate/sweeps/sweep.h"

namespace backbend::validate {

/// One side of a box of body poses, degrees (per cent for `stretch`). `bend` is extension above 0
/// and flexion below: no pose bends both ways.
struct BoxAxis {
  std::string name;
  double low = 0.0, high = 0.0;
  double width() const { return high - low; }
};

/// All body poses between two ends of each channel. Points of the box are given by one number per
/// axis, 0 at its low end and 1 at its high end.
struct ControlBox {
  std::string name;           // `envelope`, `stress`, `sweep`, or the file
  std::vector<BoxAxis> axes;  // one or more, each wider than 0
  PoseDegrees held;           // what the channels without an axis stay at

  PoseDegrees pose_at(std::span<const double> unit) const;
  /// The point of a pose; of one outside the box, the nearest.
  std::vector<double> point_of(const PoseDegrees& pose) const;
  /// The least and the most of every channel that the box moves, as a file names them: `extension`
  /// and `flexion` apart.
  std::map<std::string, std::pair<double, double>> channels() const;
  /// `extension 0..60, flexion 0..90, side -45..45, twist -60..60`
  std::string text() const;
};

/// The words that name a box: `envelope`, `stress`, `sweep`.
std::vector<std::string> box_words();

/// `envelope`: as far as the character is expected to go in each channel. `stress`: as far as the
/// stress sweeps take the channels that every rig has. `sweep`: as far as the standard sweeps do.
/// Anything else is a file: read_box(). Throws ReadError.
ControlBox find_box(const std::string& word, const Envelope& envelope);

/// The envelope's box; where everything that is swept counts, as far as these sweeps take each
/// channel alone. Throws ReadError where that moves no channel.
ControlBox box_within(const Envelope& envelope, const std::vector<Sweep>& sweeps);

/// A box from a file of `channel = [least, most]`, in TOML, or in JSON where its name ends so.
/// Channels are extension, flexion, side, twist, hip (degrees) and stretch (per cent); one that is
/// not named stays at rest, and one whose ends are equal is held there. Extension and flexion are
/// 0 or more; where both are moved, both begin at 0. Throws ReadError naming file, line (TOML) and
/// channel: no channel moved, inverted ends, numbers that are not finite, unknown names (with the
/// nearest one), a stretch that leaves no spine.
ControlBox read_box(const std::filesystem::path& file);

}  // namespace backbend::validate
