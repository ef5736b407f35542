#pragma once
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "skin/anatomy/mirror_image.h"
#include "skin/weights/weight_graph.h"

namespace backbend::skin {

/// What the surface at each node's mirror image has, with each joint swapped for the one on the
/// other side: the weights that a symmetric body would have at the node. Of the node at the image
/// (within 0.2 % of the body's largest side), else of the nearest point of the triangles around the
/// nearest node, within 1 %; empty where the body has no other side there. A joint without a
/// partner among the character's joints stays itself.
///
/// `weights` has one entry a node of the graph, and so has the result.
std::vector<JointShares> mirrored_weights(const Character& character, const Mirror& mirror,
                                          const WeightGraph& graph,
                                          const std::vector<JointShares>& weights);

/// For each node the one at its mirror image, itself in the middle; node_count() where none is
/// within 0.2 % of the body's largest side.
std::vector<std::uint32_t> mirrored_graph_nodes(const Mirror& mirror, const WeightGraph& graph);

}  // namespace backbend::skin
