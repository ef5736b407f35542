#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "skin/anatomy/anatomy.h"

namespace backbend::skin {

struct Clip;

/// A control of the artist's own rig that stands for one of our channels.
struct SidecarControl {
  std::string channel;        // extension, flexion, side or twist
  std::string control;        // as the artist's program calls it
  std::string axis;           // X, Y or Z: the axis it turns about; empty: `property` is set
  int sign = 1;               // -1 where its positive turn is our negative one
  std::string property = "";  // another channel of the control, by the artist's program's name
  // What a degree of our channel adds to it; 0: the channel's controls share the degree equally,
  // each by its sign.
  double per_degree = 0.0;

  /// As rigs call it beside the control: `rx`, or the property.
  std::string own_channel() const;
  bool operator==(const SidecarControl&) const = default;
};

/// What a person confirmed of a character: `NAME.backbend.toml` beside it, schema
/// `backbend.sidecar/1`. Lists are empty and texts are "" where nothing was said.
struct Sidecar {
  std::vector<std::string> spine;  // hips to head
  std::string chest;               // the last driven joint: one of the spine
  std::vector<std::string> left_arm, right_arm;
  std::string rig_template;  // whose names the joints bear, for a spine that is not listed
  std::string up, forward;   // of the file: `+Y`
  std::string found_up, found_forward;  // what those replace; "" where they are what was found
  double metres_per_unit = 1.0;         // what one unit of the file is
  std::vector<std::string> leave_out;   // parts that are not judged: hair, props, proxies
  std::vector<std::string> namespaces;  // prefixes to remove from joint names: `hero:`
  std::string envelope;                 // human, cartoon, creature, sweep
  std::vector<SidecarControl> controls;
  bool operator==(const Sidecar&) const = default;
};

/// Where the sidecar of a character stands: hero.fbx has hero.backbend.toml.
std::filesystem::path sidecar_path(const std::filesystem::path& character);

/// The sidecar beside a character, or nullopt where there is none. Throws CharacterError naming
/// file, line and key for anything that is not as above.
std::optional<Sidecar> read_sidecar(const std::filesystem::path& character);

/// The sidecar that is written in `text`; `path` heads what is said against it.
Sidecar parse_sidecar(const std::string& text, const std::filesystem::path& path);

/// What was found, ready to be confirmed: the rest is taken from `known`, what stood there before.
/// A namespace that every joint bears is one to take away.
Sidecar sidecar_of(const Character& character, const Anatomy& anatomy, const Sidecar& known = {});

/// The file's text; reading it gives the same sidecar again.
std::string sidecar_text(const Sidecar& sidecar);

/// Makes a character as the sidecar says: names without namespaces, parts left out, in metres. The
/// sidecar becomes part of what its content hash is of.
/// Throws CharacterError headed by the sidecar's name for a part that is not there, and where
/// nothing would be left.
void apply_sidecar(const Sidecar& sidecar, Character& character);

/// The same for motion that was made for the character: joint names without namespaces, and in
/// metres where the clip's form names no unit of its own. A clip out of the character's own file
/// keeps the hash that they share.
void apply_sidecar(const Sidecar& sidecar, Clip& clip);

/// What the sidecar says of the skeleton, where `hints` say nothing.
AnatomyHints hints_with(const Sidecar& sidecar, AnatomyHints hints);

/// The first difference from the confirmed anatomy, one line; nothing where all agrees. A character
/// that was exported anew with other axes is noticed here.
std::optional<std::string> contradiction(const Sidecar& sidecar, const Anatomy& anatomy);

}  // namespace backbend::skin
