#pragma once
#include <vector>

namespace backbend::solver {

/// Nodes, ascending, and weights of the Gauss-Legendre rule with n >= 1 points on 0..1, by Newton's
/// method on the Legendre polynomial from Tricomi's first guess.
void gauss_legendre(int n, std::vector<double>& node, std::vector<double>& weight);

}  // namespace backbend::solver
