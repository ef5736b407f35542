#include "skin/weights/weight_inpaint.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <map>
#include <set>

namespace backbend::skin {
namespace {

using Index = std::size_t;
using Sparse = Eigen::SparseMatrix<double>;
using Triplet = Eigen::Triplet<double>;

constexpr double kNearlySure = 0.999;  // confidence 1 would need a weight without end
constexpr double kNothing = 1e-9;      // of the diagonal: keeps lonely islands solvable

/// The nodes that a solve looks at: the free ones first, then their neighbours and the neighbours'.
struct Patch {
  std::vector<std::uint32_t> node;
  std::map<std::uint32_t, int> number;
  Index free = 0, ring = 0;  // count of free nodes, and with the first ring

  int at(std::uint32_t n) {
    const auto [entry, is_new] = number.try_emplace(n, static_cast<int>(node.size()));
    if (is_new) node.push_back(n);
    return entry->second;
  }
};

Patch patch_around(const WeightGraph& graph, const std::vector<InpaintNode>& nodes) {
  Patch patch;
  for (const InpaintNode& each : nodes) patch.at(each.node);
  patch.free = patch.node.size();
  for (Index i = 0; i < patch.free; ++i)
    for (const std::uint32_t n : graph.neighbours(patch.node[i])) patch.at(n);
  patch.ring = patch.node.size();
  for (Index i = 0; i < patch.ring; ++i)
    for (const std::uint32_t n : graph.neighbours(patch.node[i])) patch.at(n);
  return patch;
}

/// Rows of the Laplacian of the free nodes and the first ring, over the whole patch.
Sparse laplacian(const WeightGraph& graph, Patch& patch) {
  std::vector<Triplet> entries;
  for (Index i = 0; i < patch.ring; ++i) {
    const std::uint32_t n = patch.node[i];
    double sum = 0.0;
    for (Index e = graph.first_edge[n]; e < graph.first_edge[n + 1]; ++e) {
      entries.emplace_back(static_cast<int>(i), patch.at(graph.to[e]), -graph.cotangent[e]);
      sum += graph.cotangent[e];
    }
    entries.emplace_back(static_cast<int>(i), static_cast<int>(i), sum);
  }
  Sparse out(static_cast<int>(patch.ring), static_cast<int>(patch.node.size()));
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

JointShares cleaned(const JointShares& shares) {
  double sum = 0.0;
  for (const auto& [joint, share] : shares) sum += std::max(share, 0.0);
  JointShares out;
  if (sum < 1e-6) return out;
  for (const auto& [joint, share] : shares)
    if (share > 0.0) out[joint] = share / sum;
  return out;
}

}  // namespace

std::vector<JointShares> inpaint_weights(const WeightGraph& graph,
                                         const std::vector<JointShares>& weights,
                                         const std::vector<InpaintNode>& nodes) {
  if (nodes.empty()) return {};
  Patch patch = patch_around(graph, nodes);
  const Sparse rows = laplacian(graph, patch);
  const auto free = static_cast<int>(patch.free);
  const auto all = static_cast<int>(patch.node.size());
  double area = 0.0;
  Eigen::VectorXd inverse_area(static_cast<int>(patch.ring));
  for (Index i = 0; i < patch.ring; ++i) {
    inverse_area[static_cast<int>(i)] = 1.0 / graph.area[patch.node[i]];
    if (i < patch.free) area += graph.area[patch.node[i]];
  }
  const Sparse transposed = rows.transpose();
  Sparse q = (transposed * inverse_area.asDiagonal() * rows).pruned();
  q *= area;
  Sparse first(all, all);
  {
    // The free nodes' rows alone: the others' unknowns are held.
    std::vector<Triplet> entries;
    for (int outer = 0; outer < rows.outerSize(); ++outer)
      for (Sparse::InnerIterator it(rows, outer); it; ++it)
        if (it.row() < free || it.col() < free)
          entries.emplace_back(it.row(), it.col(), it.value());
    first.setFromTriplets(entries.begin(), entries.end());
  }
  q += first;

  std::set<std::uint16_t> joints;
  for (Index i = patch.free; i < patch.node.size(); ++i)
    for (const auto& [joint, share] : weights[patch.node[i]]) joints.insert(joint);
  for (const InpaintNode& each : nodes)
    for (const auto& [joint, share] : each.kept) joints.insert(joint);
  if (joints.empty()) return std::vector<JointShares>(nodes.size());
  const std::vector<std::uint16_t> column(joints.begin(), joints.end());
  const auto columns = static_cast<int>(column.size());
  const auto column_of = [&](std::uint16_t joint) {
    return static_cast<int>(std::lower_bound(column.begin(), column.end(), joint) - column.begin());
  };
  Eigen::MatrixXd held = Eigen::MatrixXd::Zero(all - free, columns);
  for (Index i = patch.free; i < patch.node.size(); ++i)
    for (const auto& [joint, share] : weights[patch.node[i]])
      held(static_cast<int>(i - patch.free), column_of(joint)) = share;
  Eigen::MatrixXd right = -(q.topRightCorner(free, all - free) * held);
  Sparse left = q.topLeftCorner(free, free);
  for (int i = 0; i < free; ++i) {
    const InpaintNode& each = nodes[static_cast<Index>(i)];
    const double diagonal = left.coeff(i, i);
    const double sure = std::min(each.confidence, kNearlySure);
    const double pull = each.kept.empty() ? 0.0 : diagonal * sure / (1.0 - sure);
    left.coeffRef(i, i) += pull + kNothing * diagonal;
    for (const auto& [joint, share] : each.kept) right(i, column_of(joint)) += pull * share;
  }
  Eigen::SimplicialLDLT<Sparse> solver(left);
  std::vector<JointShares> out(nodes.size());
  if (solver.info() != Eigen::Success) return out;
  const Eigen::MatrixXd solved = solver.solve(right);
  for (int i = 0; i < free; ++i) {
    JointShares shares;
    for (int c = 0; c < columns; ++c)
      if (solved(i, c) > 0.0) shares[column[static_cast<Index>(c)]] = solved(i, c);
    out[static_cast<Index>(i)] = cleaned(shares);
  }
  return out;
}

double unevenness(const WeightGraph& graph, const std::vector<JointShares>& weights,
                  const std::vector<std::uint32_t>& nodes) {
  double sum = 0.0;
  for (const std::uint32_t n : nodes)
    for (Index e = graph.first_edge[n]; e < graph.first_edge[n + 1]; ++e) {
      double squares = 0.0;
      JointShares apart = weights[n];
      for (const auto& [joint, share] : weights[graph.to[e]]) apart[joint] -= share;
      for (const auto& [joint, share] : apart) squares += share * share;
      sum += graph.cotangent[e] * squares;
    }
  return sum;
}

}  // namespace backbend::skin
