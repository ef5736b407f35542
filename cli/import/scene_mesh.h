#pragma once
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <utility>
#include <vector>

struct aiMesh;

namespace backbend::import {

/// Joint (number of the bone in its mesh) and weight, as the file has them.
using Weights = std::vector<std::pair<std::uint16_t, float>>;

/// The triangles of one mesh, equal corners welded.
struct ImportedMesh {
  std::vector<glm::vec3> position;
  std::vector<glm::vec3> normal;  // empty where the file has none
  std::vector<glm::vec2> uv;      // empty where the file has none; top row first
  std::vector<Weights> weights;   // empty for a mesh without bones
  std::vector<std::uint32_t> index;
};

/// `scale` multiplies positions. Throws skin::CharacterError headed `mesh 'NAME'`.
ImportedMesh import_mesh(const aiMesh& mesh, double scale);

}  // namespace backbend::import
