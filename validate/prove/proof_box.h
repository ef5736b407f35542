#pragma once
#include <array>
#include <stdexcept>
#include <string>
#include <vector>

#include "solver/rig/box_solver.h"
#include "validate/sweeps/envelope.h"

namespace backbend::validate {

/// A box, rig or certificate that cannot be used for a proof. what() is the whole line.
struct ProofError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

inline constexpr int kProofAxes = solver::kBoxVariables;

/// From where to where one channel goes: degrees (rotations), lengths or plain numbers.
struct ProofAxis {
  std::string channel;
  double low = 0.0, high = 0.0;

  double width() const { return high - low; }
  bool varies() const { return high > low; }
};

/// The box of poses that a proof is about: body channels under a mapping, or controls of the rig.
/// Of the former, `extension` counts flexion as below 0.
struct ProofBox {
  std::string name;  // `envelope`, or what the user named
  bool of_controls = false;
  std::vector<ProofAxis> axis;  // body: extension, side, twist; controls: 1 to kProofAxes

  /// `extension -90..60, side -45..45, twist -60..60`
  std::string text() const;
};

/// `envelope` (as given), `stress`, `sweep`, text like `extension=0:180,side=0`, or a TOML file
/// with a [box] table of channels, each a number or [from, to]. A body channel that is not named
/// stays at 0. Throws ProofError for a box that is empty, inverted, not finite or past 100 turns,
/// for channels that the system does not have, and for more than kProofAxes that vary.
ProofBox read_box(const std::string& text, const Envelope& envelope,
                  const solver::SpineSystem& system);

/// Throws ProofError as read_box() does, after `where`.
void check_box(const ProofBox& box, const std::string& where);

/// A part of a ProofBox, in its units.
struct SubBox {
  std::array<double, kProofAxes> low{}, high{};
};
SubBox whole_of(const ProofBox& box);

/// Splits a part in two at the middle of an axis.
std::array<SubBox, 2> halves(const SubBox& box, int axis);
/// The axis that is the widest, the first of equals; -1: none is wider than `least`. Those that are
/// `idle` do not count.
int widest_axis(const SubBox& box, double least, const std::array<bool, kProofAxes>& idle = {});
/// The share of the whole that a part has: over the axes that vary.
double share_of(const SubBox& part, const ProofBox& whole);

/// The rig's control values at a pose of a box.
class PoseOfBox {
 public:
  PoseOfBox(const ProofBox& box, const solver::SpineSystem& system, solver::Mapping mapping);
  std::vector<double> at(const std::array<double, kProofAxes>& pose) const;

 private:
  const ProofBox& box_;
  const solver::SpineSystem& system_;
  solver::Mapping mapping_;
  std::vector<std::size_t> channel_;  // of controls
};

/// A body's bend in channel names, as a person reads it: `flexion 20, side 10`.
std::string pose_text(const ProofBox& box, const std::array<double, kProofAxes>& pose);

}  // namespace backbend::validate
