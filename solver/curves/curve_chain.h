#pragma once
#include <cstddef>
#include <glm/vec3.hpp>
#include <vector>

#include "solver/curves/curve.h"

namespace backbend::solver {

/// How a chain keeps to its curve. `chase`: each bone aims at the next of the equal-arc goals, with
/// its own length, wherever it starts. `on_curve`: each joint is walked on to the curve at the
/// straight bone length, and along the end tangent past the end.
enum class Follow { chase, on_curve };

/// Which length the bones get, NB of them on a curve of length L. `nulls`: nine times the first gap
/// between ten equal-arc nulls, over NB (the thesis's expression). `rest`: L at rest, frozen.
/// `null_sum`: all nine gaps. `arc`: L / NB. `close`: solved so that the last joint meets the end.
enum class BoneLength { nulls, rest, null_sum, arc, close };

/// A chain laid along a curve.
struct CurveChain {
  std::vector<glm::dvec3> joint;      // bones + 1
  std::vector<glm::dvec3> direction;  // unit, one per bone; zero where a bone had no goal to aim at
  double bone_length = 0.0;
  double overrun = 0.0;   // on_curve: how far the last joint is past the curve's end
  bool aimless = false;   // a bone stood on its goal and had no direction
  bool unclosed = false;  // close: no bone length meets the end
};

inline constexpr std::size_t kMostBones = 64;

/// Number of length nulls on the curve, both ends included.
inline constexpr int kNullCount = 10;

/// Length of a curve estimated by its first null gap, times nine: |N1 N2| (NN - 1).
double length_by_first_null(const Curve& curve);
/// The sum of all nine gaps.
double length_by_null_sum(const Curve& curve);

/// Lays `bones` bones, 1 to kMostBones, along the curve. `rest_length` is the curve's length at
/// rest, for BoneLength::rest. Writes into `chain`, whose memory is used again.
void lay_chain(const Curve& curve, std::size_t bones, Follow follow, BoneLength rule,
               double rest_length, CurveChain& chain);

}  // namespace backbend::solver
