#pragma once
#include <cstdint>
#include <vector>

#include "skin/weights/weight_graph.h"

namespace backbend::skin {

/// A node whose weights are to be found again.
struct InpaintNode {
  std::uint32_t node = 0;   // of the graph
  JointShares kept;         // what is known of its weights, summing to 1; empty: nothing
  double confidence = 0.0;  // in `kept`, 0..1; 1 keeps it
};

/// The weights of the nodes that continue those around them most smoothly and keep what is known.
///
/// For each joint the field w minimises w'Qw + sum of c/(1-c) d_n (w_n - kept_n)^2 with the weights
/// of all other nodes held, where Q = L + A L M^-1 L: cotangent Laplacian L, node areas M, area A
/// of the nodes that are free (which makes Q independent of the unit), d the diagonal of Q.
/// Negative weights become 0 and sums 1. Solved by a sparse Cholesky factorisation on one thread:
/// the same bits every time. Nodes that nothing held and nothing known reaches keep no weight
/// (empty).
///
/// `weights` has one entry a node of the graph. `nodes` are different nodes, in any order; the
/// result has one entry each.
///
/// Source: R. Abdrashitov et al., "Robust Skin Weights Transfer via Weight Inpainting", SIGGRAPH
/// Asia 2023, section 4.2: the energy; the terms for what is known are ours.
std::vector<JointShares> inpaint_weights(const WeightGraph& graph,
                                         const std::vector<JointShares>& weights,
                                         const std::vector<InpaintNode>& nodes);

/// How uneven weights are over the nodes and the edges around them: the sum of squared differences,
/// times the cotangents.
double unevenness(const WeightGraph& graph, const std::vector<JointShares>& weights,
                  const std::vector<std::uint32_t>& nodes);

}  // namespace backbend::skin
