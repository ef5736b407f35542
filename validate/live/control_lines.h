#pragma once
#include <map>
#include <span>
#include <string>

#include "validate/live/external_rig.h"

namespace backbend::validate {

/// The line to paste into the program that a live rig runs in, so that the rig takes up a pose from
/// its rest: `blender` or `maya` -> Python. `control` as ExternalRig::controls_for() gives it. None
/// where no control leaves its rest, and for other programs, whose language is not known.
std::map<std::string, std::string> control_lines(const ExternalRig& rig,
                                                 std::span<const double> control);

/// The same of what a program says of itself (`Blender 3.4.1`), of channels and their values as on
/// the wire, degrees for rotations.
struct ChannelValue {
  std::string channel;  // `chest.rx`
  solver::Channel::Kind kind = solver::Channel::Kind::rotation;
  double value = 0.0;
};
std::map<std::string, std::string> control_lines(const std::string& program,
                                                 std::span<const ChannelValue> values);

}  // namespace backbend::validate
