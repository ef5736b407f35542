#pragma once
#include <algorithm>
#include <vector>

namespace backbend::validate {

/// The middle value of `values`, of an even number the larger of the two: always one of them. 0 for
/// none. Reorders `values`.
inline double upper_median(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The middle value, of an even number the mean of the two. 0 for none.
inline double median(std::vector<double> values) {
  const double upper = upper_median(values);
  if (values.size() % 2 == 1 || values.empty()) return upper;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  return 0.5 * (upper + *std::max_element(values.begin(), middle));
}

}  // namespace backbend::validate
