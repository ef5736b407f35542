#pragma once
#include <cmath>

namespace backbend::validate {

/// How much of a whole is good at least, with this confidence, where `good` of `count` places drawn
/// evenly from it are: a share, 0 where none is good or none was drawn. With all of them good that
/// is (1 - confidence)^(1/count), nearly 1 - 3/count for 95 %.
///
/// Source: C. J. Clopper, E. S. Pearson, "The use of confidence or fiducial limits illustrated in
/// the case of the binomial", Biometrika 26, 1934; one-sided.
inline double least_share(int good, int count, double confidence) {
  if (good <= 0 || count <= 0) return 0.0;
  // How likely so many or more are good where this share is.
  const auto chance = [&](double share) {
    double log_term = count * std::log(share), sum = std::exp(log_term);  // all are good
    for (int i = count; i > good; --i) {
      log_term += std::log(static_cast<double>(i) / (count - i + 1) * (1.0 - share) / share);
      sum += std::exp(log_term);
    }
    return sum;
  };
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (chance(middle) < 1.0 - confidence ? low : high) = middle;
  }
  return low;
}

}  // namespace backbend::validate
