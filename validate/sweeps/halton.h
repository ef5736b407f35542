#pragma once
#include <cstddef>

namespace backbend::validate {

/// The number's digits in a base, mirrored at the point: of consecutive numbers values that fill
/// 0..1 evenly, in bases without a common factor evenly together. 0 is 0.
///
/// Source: J. H. Halton, "On the efficiency of certain quasi-random sequences", Numerische
/// Mathematik 2, 1960.
inline double halton(std::size_t number, unsigned base) {
  double result = 0.0, share = 1.0;
  for (; number > 0; number /= base) {
    share /= base;
    result += share * static_cast<double>(number % base);
  }
  return result;
}

}  // namespace backbend::validate
