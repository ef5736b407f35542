#pragma once
#include <string>
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "skin/anatomy/sidecar.h"
#include "skin/character/character.h"
#include "solver/rig/spine_system.h"

namespace backbend::validate {

/// The controls of a rig that stand for a body channel, as they were found by moving them.
struct ProposedChannel {
  std::string channel;  // extension, flexion, side or twist
  std::vector<skin::SidecarControl> controls;
  double share = 0.0;     // of a degree that is asked, what arrives at the chest
  double over = 0.0;      // share of the spine's joints that take part, 1: all alike
  bool opposite = false;  // flexion: that of extension, which the mapping need not name
};

struct ProposedMapping {
  std::string rig;
  std::size_t tried = 0;             // controls
  std::size_t properties_tried = 0;  // of them
  std::vector<ProposedChannel> channels;
  double held_above = 0.0;  // what the chest gets of the turn of a control above it; 0: none
  std::vector<std::string> missing;  // channels that no control stands for
  std::vector<std::string> others;   // controls that would do as well, best first
  /// For a sidecar: without opposites.
  std::vector<skin::SidecarControl> controls() const;
};

/// Turns every control of a rig by itself, by 20 degrees about each of its axes, and takes those
/// that turn the chest against the hips about the axis of a body channel, leave the hips where they
/// are, and turn little about the others. One control that bends several joints is taken before a
/// chain of controls that bend one each, of which all are taken together. One
/// control for all channels of which the chest gets the same share about every axis is held above
/// the chest, and scaled. A channel that no
/// rotation stands for may have a property (a scalar channel), tried at half of the way to an end
/// of its range, else one unit on. Throws as ExternalRig
/// does, and solver::RigError where no control bends the spine.
ProposedMapping propose_mapping(const solver::SystemSpec& spec, const skin::Character& character,
                                const skin::Anatomy& anatomy);

/// For a person.
std::string proposal_text(const ProposedMapping& proposal);
/// As `--map FILE` takes it.
std::string proposal_json(const ProposedMapping& proposal);

}  // namespace backbend::validate
