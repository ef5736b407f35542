#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace backbend::validate {

/// Which connected piece of a surface each place belongs to: two places of one triangle are of one
/// piece. Pieces are named by one of their places. `triangle` holds vertices, `place` each vertex's
/// place, below `place_count`; where `place` is empty, `triangle` holds places.
std::vector<std::uint32_t> connected_pieces(std::span<const glm::uvec3> triangle,
                                            std::span<const std::uint32_t> place,
                                            std::uint32_t place_count);

/// Pieces of costume that are rigid on purpose: 1 for each vertex of a connected piece that goes as
/// a whole with one joint of the spine, near which it lies, and that reaches along no more than
/// 0.6 of the spine. A breastplate, a belt, a skirt's stiff waist; no shirt that hangs from one
/// joint, nor a belt of the hips on the chest.
///
/// `joint_of_vertex`: the joint of the chain that moves a vertex alone, -1 where several do or
/// none. `fraction`: where the chain's joints stand along it, `coordinate` where the places do; NaN
/// off the torso.
std::vector<std::uint8_t> rigid_pieces(std::span<const glm::uvec3> triangle,
                                       std::span<const std::uint32_t> place,
                                       std::span<const int> joint_of_vertex,
                                       std::span<const double> fraction,
                                       std::span<const float> coordinate);

/// Props that are rigid on purpose and stand off the body: a pack, a quiver, a sword on the back. 1
/// for each vertex of a connected piece of six places or more, beside the largest, that goes with
/// one joint of the spine near which it lies, as in rigid_pieces(), and of which half stands
/// further than `off` from every other piece. What lies close all over, a plate or a jacket, is
/// none.
///
/// `position`: of each vertex at rest, in the unit of `off`, which is above 0.
std::vector<std::uint8_t> standing_props(std::span<const glm::uvec3> triangle,
                                         std::span<const std::uint32_t> place,
                                         std::span<const int> joint_of_vertex,
                                         std::span<const double> fraction,
                                         std::span<const float> coordinate,
                                         std::span<const glm::vec3> position, double off);

}  // namespace backbend::validate
