#pragma once
#include <chrono>
#include <utility>

namespace backbend::validate {

/// How long `work` takes by the clock, in seconds: for estimates only, never for a result.
template <typename Work>
double seconds_of(Work&& work) {
  const auto start = std::chrono::steady_clock::now();
  std::forward<Work>(work)();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace backbend::validate
