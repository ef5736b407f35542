#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "skin/anatomy/body_kind.h"
#include "validate/sweeps/sweep.h"

namespace backbend::validate {

/// How far a kind of character is expected to be clean in each channel, degrees. Side and twist
/// count both ways; the corners are the poses that take a bend, the side and the twist to their
/// ends at once.
struct Envelope {
  std::string name;
  double extension = 0, flexion = 0, side = 0, twist = 0;
  bool whole_sweep = false;  // a comparison: everything that is swept counts
  std::string reason;        // why these figures, one clause

  double needs(std::string_view channel) const;
  /// Whether a pose of the sweep lies inside. A tipped hip and a stretch always are stress.
  bool contains(const PoseDegrees& pose) const;
  /// `extension 60, flexion 90, side 45, twist 60, and their corners`
  std::string text() const;
};

/// One of envelope_names(); nullopt for another name.
std::optional<Envelope> find_envelope(std::string_view name);
std::vector<std::string> envelope_names();

/// What a body of this kind is expected to do with its back, or with its neck where that is the
/// chain that is driven.
Envelope envelope_for(skin::BodyKind kind, bool neck_is_driven);

/// Specification 8, Sweeps: what `check` runs by itself. Each channel to the end of the envelope
/// and at least as far as people look: extension 0..120 by 2, flexion 0..90 by 2, side +-45 and
/// twist +-90 by 3.
std::vector<Sweep> standard_sweeps(const Envelope& envelope);

/// The same envelope where it names figures; where everything that is swept counts, as far as these
/// sweeps take each channel alone.
Envelope reach_of(const Envelope& envelope, const std::vector<Sweep>& sweeps);

/// From rest straight to each corner of an envelope: extension or flexion x side x twist, both ways
/// each (8), and to the corners of its faces, two channels at a time (12). Eleven poses each.
/// Channels that the envelope does not ask for are left out.
std::vector<Sweep> corner_sweeps(const Envelope& envelope);

/// Whether a sweep moves this channel alone, from rest or through it.
bool moves_alone(const Sweep& sweep, std::string_view channel);

}  // namespace backbend::validate
