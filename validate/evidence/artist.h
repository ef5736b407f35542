#pragma once
#include <map>
#include <string>

#include "skin/anatomy/sidecar.h"
#include "validate/sweeps/sweep.h"

namespace backbend::validate {

/// The line to paste into the artist's program so that the character's own rig takes up a body pose
/// from its rest: `maya` and `blender` -> Python.
///
/// Follows the sidecar's controls: a channel's degrees are shared equally by the controls that
/// stand for it, times their sign; extension and flexion are each other's opposite where only one
/// of them has a control. None where the pose is rest, or moves a channel that has no control: half
/// a pose would show another fault.
std::map<std::string, std::string> artist_lines(const skin::Sidecar& sidecar,
                                                const PoseDegrees& pose);

/// The line as a file that the program can run: `note` stands above it as a comment.
std::string artist_script(const std::string& line, const std::string& note);

}  // namespace backbend::validate
