#pragma once
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "solver/systems/even_graph.h"

namespace backbend::validate {

/// The spine `even` on a character's own joints, for other programs: what `export even` writes.
struct EvenExport {
  struct Joint {
    std::string name;
    std::size_t in_graph = 0;  // into EvenGraph::joint
    glm::dmat4 rest{1.0};      // world space of the character
  };
  /// A joint, arms first, and the spine joint (or hips) that it goes with.
  struct Follower {
    std::string name, leader;
  };

  std::string character;           // the file's name
  solver::SystemSpec rig;          // with `joints` where those of the character stand
  solver::EvenGraph graph;         // world space of the character
  glm::dvec3 left{1.0, 0.0, 0.0};  // its left: what the controls' axes are drawn with
  solver::GraphDistance distance;
  Joint hips;
  std::vector<Joint> joints;        // above the hips, up to the chest
  std::vector<Follower> followers;  // arms, and what hangs from nothing in the file
  std::vector<std::string> apart;   // what hangs from another joint than our pictures move it with
  std::array<double, 3> half_size{};  // of the controls' outlines: around the torso there
};

/// Reads the character as `check` does, and finds the fewest steps whose joints stay within 0.03 %
/// of the spine's length of `rig` on them at +-180 degrees of every channel. Throws
/// skin::CharacterError, solver::RigError for options that cannot be exported.
EvenExport export_even(const std::filesystem::path& character, const skin::AnatomyHints& hints,
                       const solver::SystemSpec& rig);

/// `backbend.even_graph/1`: docs/export.md.
std::string even_graph_json(const EvenExport& from);
/// A Python script for Blender, or for Maya, that builds the graph and takes it away again.
std::string even_blender_script(const EvenExport& from);
std::string even_maya_script(const EvenExport& from);

/// What was made, for a person.
std::string even_export_text(const EvenExport& from);

}  // namespace backbend::validate
