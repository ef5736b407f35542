#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "skin/character/character.h"

namespace backbend::validate {

/// What is wrong with a character's weights without any pose.
struct WeightHygiene {
  double worst_sum = 0.0;  // largest |sum - 1|
  int worst_sum_vertex = -1;
  std::size_t unweighted = 0;  // vertices without any weight
  int unweighted_vertex = -1;
  std::size_t stray = 0;              // vertices bound to what none of their neighbours knows
  int stray_vertex = -1;              // the worst of them
  double stray_weight = 0.0;          // its weight on joints foreign to its neighbours
  std::vector<std::uint32_t> strays;  // all of them, ascending by place
};

/// Examines the weights. A vertex is a stray if more than half of its weight is on joints that none
/// of the vertices around it (across one edge, by place) is bound to, while either those agree
/// among themselves (each pair of them shares a joint) or the vertices around them share none of
/// its joints either. For a joint that moves little else, joints up to two bones away count as that
/// joint, too: the tip of a finger may be one vertex of a coarse mesh.
///
/// Weights of vertices at one place count together, so split normals change nothing. An isolated
/// vertex, or one with a single neighbour, is never a stray: there is nothing to compare it with.
/// `parent` is for each joint the joint that it hangs from, -1 for none; empty: none is known.
WeightHygiene examine_weights(std::span<const skin::Influences> influences,
                              std::span<const glm::uvec3> triangle,
                              std::span<const std::uint32_t> place, std::uint32_t place_count,
                              std::span<const int> parent = {});
/// The same of a character and its skeleton. A vertex nearer to the bones of its main joint than to
/// half of its neighbours is not counted: on a mesh that coarse the neighbours do not tell which
/// joint it belongs to. What hangs from the node `head` counts as one joint: no motion of the spine
/// parts tongue and jaw.
WeightHygiene examine_weights(const skin::Character& character,
                              std::span<const skin::Influences> influences, int head = -1);

}  // namespace backbend::validate
