#pragma once
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "skin/character/character.h"

namespace backbend::skin {

/// A motion of a character's nodes to go into a file.
struct GlbAnimation {
  std::string name = "backbend";
  std::vector<float> time;                               // seconds, rising, one per frame
  std::vector<std::vector<glm::dmat4>> world_from_node;  // [frame][node of the character]
};

/// A character as binary glTF 2.0: meshes with joints and weights, skeleton, materials, images and,
/// if given, a motion. The same character and motion give the same bytes.
///
/// The motion is written as translation, rotation and scale of each node that moves, linearly
/// interpolated; neighbouring quaternions are in one hemisphere, so players turn the short way.
/// Where a node's transform relative to its parent is sheared, which glTF cannot say, the whole
/// skeleton is written with rigid joint frames and inverse bind matrices that make up for it: the
/// skinned vertices are the same.
///
/// Parts that are bound in several spaces have a skin and a mesh each (lay_out_skins()).
/// Rigid parts are written bound at rest (with_rigid_parts_at_rest()). Vertices without any weight
/// follow an extra joint that never moves. Throws CharacterError for a motion with the wrong number
/// of nodes, times that do not rise, non-finite numbers, a node that still shears, and sizes beyond
/// 4 GB. Source: glTF 2.0 specification.
std::vector<std::uint8_t> encode_glb(const Character& character,
                                     const GlbAnimation* animation = nullptr);

/// A character's mesh at one pose, without skeleton, as binary glTF 2.0. `color` is empty or has
/// one linear Rec.709 colour per vertex, which replaces the materials' base colours.
std::vector<std::uint8_t> encode_posed_glb(const Character& character, const PosedMesh& posed,
                                           std::span<const glm::vec3> color = {});

}  // namespace backbend::skin
