#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "skin/anatomy/sidecar.h"
#include "solver/rig/spine_system.h"
#include "validate/live/rig_protocol.h"

namespace backbend::validate {

/// A channel of the rig that a body channel moves.
struct ControlTarget {
  std::string channel;      // of RigHello: `chest.ry`
  double per_degree = 1.0;  // what a degree of the body channel adds to its rest, as on the wire
};

/// Which of a rig's own channels stand for which body channel: extension, flexion, side, twist.
/// Several body channels may move one: what they ask of it adds up.
struct ControlMapping {
  std::map<std::string, std::vector<ControlTarget>, std::less<>> channels;
  std::string source;  // for a person: where it was read

  /// Of a body channel; extension and flexion are each other's opposite where only one of them is
  /// named. Empty: nothing stands for it.
  std::vector<ControlTarget> targets(std::string_view channel) const;
};

/// The bridges' JSON: docs/bridges/blender.md. Throws RigError naming file and place.
ControlMapping read_mapping(const std::filesystem::path& file);
ControlMapping parse_mapping(const std::string& text, const std::string& file);
/// What a sidecar says: each channel's degrees are shared equally by its controls but where it
/// scales them.
ControlMapping mapping_of(const std::vector<skin::SidecarControl>& controls);
/// Of a rig whose channels are called as ours are.
ControlMapping mapping_by_name(const RigHello& hello);

}  // namespace backbend::validate
