#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace backbend::validate {

/// Random numbers that are the same on every machine and for every order of asking: the state is a
/// counter, the value a hash of it. Source: G. Steele et al., "Fast splittable pseudorandom number
/// generators", OOPSLA 2014 (the SplitMix64 finaliser).
class Draw {
 public:
  /// Draws of different streams of one seed have nothing in common.
  Draw(std::uint64_t seed, std::uint64_t stream) : state_(mix(seed) ^ mix(~stream)) {}

  double uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(next() >> 11) * 0x1p-53);
  }
  /// 0 .. count - 1.
  std::size_t index(std::size_t count) {
    return static_cast<std::size_t>(uniform(0.0, static_cast<double>(count)));
  }
  bool coin() { return (next() >> 63) != 0; }
  glm::dvec3 direction() {
    for (;;) {
      const glm::dvec3 v(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
      const double length = glm::length(v);
      if (length > 0.1 && length <= 1.0) return v / length;
    }
  }

 private:
  static std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }
  std::uint64_t next() { return mix(state_ += 0x9e3779b97f4a7c15ull); }

  std::uint64_t state_;
};

}  // namespace backbend::validate
