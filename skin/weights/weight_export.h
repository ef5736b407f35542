#pragma once
#include <span>
#include <string>
#include <vector>

#include "skin/character/character.h"

namespace backbend::skin {

/// A character's weights for other programs. `influences` has one entry a vertex, `changed` says
/// which vertices differ from the file's.
///
/// Vertices are numbered as importers do that keep a file's order (Blender's does): mesh by mesh,
/// the primitives of a mesh one after another, without vertices that no triangle uses. A program
/// that joins vertices of equal place numbers them otherwise; each form holds places to match by.
struct WeightExport {
  const Character& character;
  std::span<const Influences> influences;
  const std::vector<bool>& changed;
};

/// Maya's `deformerWeights` XML: every vertex of every mesh, one deformer a mesh. Places are in the
/// file's own unit and axes.
std::string maya_weights_xml(const WeightExport& from);

/// JSON in the layout of mGear's `.jSkin`, with `schema` backbend.weights/1 and, of each mesh, the
/// places of its vertices and which were changed.
std::string weights_json(const WeightExport& from);

/// A Python script for Blender that sets the vertex groups of the changed vertices: by number where
/// the mesh has as many vertices as the file's, else by place (refused below 90 %).
std::string blender_weights_script(const WeightExport& from);

}  // namespace backbend::skin
