#include "solver/math/gauss_legendre.h"

#include <cmath>

#include "solver/math/rotation.h"

namespace backbend::solver {

void gauss_legendre(int n, std::vector<double>& node, std::vector<double>& weight) {
  node.resize(n);
  weight.resize(n);
  for (int i = 0; i < (n + 1) / 2; ++i) {
    double x = std::cos(kPi * (i + 0.75) / (n + 0.5));
    double slope = 1.0;
    for (int step = 0; step < 100; ++step) {
      double before = 1.0, p = x;
      for (int k = 2; k <= n; ++k) {
        const double next = ((2 * k - 1) * x * p - (k - 1) * before) / k;
        before = p;
        p = next;
      }
      slope = n * (x * p - before) / (x * x - 1.0);
      const double change = p / slope;
      x -= change;
      if (std::abs(change) < 1e-16) break;
    }
    const double w = 1.0 / ((1.0 - x * x) * slope * slope);
    node[i] = 0.5 * (1.0 - x);
    node[n - 1 - i] = 0.5 * (1.0 + x);
    weight[i] = weight[n - 1 - i] = w;
  }
}

}  // namespace backbend::solver
