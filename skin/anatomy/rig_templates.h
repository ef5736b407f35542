#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "skin/character/character.h"

namespace backbend::skin {

/// The joints of a character that a common rig's names point out. Indices into Character::nodes.
struct TemplateMatch {
  std::string_view name;               // what `--template` and a sidecar call it: `mixamo`
  std::string_view title;              // what its makers call it: `Mixamo`
  int hip = -1, neck = -1, head = -1;  // neck: its lowest joint
};

/// The names that `--template` and a sidecar's `template` take.
std::vector<std::string_view> template_names();

/// The common rig whose names a character's joints bear: hips, base of the neck, head and both arms
/// have to be there, and to hang from each other in that order. nullopt where none does. Namespaces
/// and letter case do not count.
std::optional<TemplateMatch> find_template(const Character& character);

/// The same for one rig that somebody named. Throws CharacterError for a rig that is not known, and
/// naming the first joint that the character lacks.
TemplateMatch require_template(const Character& character, const std::string& name);

}  // namespace backbend::skin
