#pragma once
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "solver/rig/spine_system.h"

namespace backbend::solver {

/// What an artist wants controls and joints to be called: text with `{name}` for what the system
/// calls them and `{index}` for their number from 1, padded so that names sort. Empty: as they are.
struct Naming {
  std::string control_names;  // option `control_names`: "hero_{name}_ctl"
  std::string joint_names;    // option `joint_names`: "hero_spine_{index}"
};

/// `names` written by a template. Throws OptionError with `key` for a placeholder that does not
/// exist, a brace without its partner, or a name that comes out empty or with a '.', a blank or a
/// control character in it.
std::vector<std::string> names_from(const std::string& key, std::string_view text,
                                    const std::vector<std::string>& names);

/// The same system under other names: channels, pose keys, joints and every message. Numbers,
/// order and parents are untouched, bit for bit. `options()` records the
/// templates that were given.
///
/// Throws OptionError where two names of the rig, controls and joints together, come out the same
/// (naming both), or as names_from() does. Source: wish W4 of research/seeds.md.
std::unique_ptr<SpineSystem> name_system(std::unique_ptr<SpineSystem> system, const Naming& naming);

}  // namespace backbend::solver
