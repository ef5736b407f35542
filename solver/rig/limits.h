#pragma once
#include <span>
#include <vector>

namespace backbend::solver {

/// How far a stretch of spine can move, degrees from upright: flexion and extension each way, side
/// and axial to one side.
struct RangeOfMotion {
  double flexion = 0.0;
  double extension = 0.0;
  double side = 0.0;
  double axial = 0.0;
};

/// One level of the human spine and what part of the way from sacrum to first thoracic vertebra it
/// takes.
struct SpineLevel {
  const char* name;
  double from, to;  // arc fraction, 0 sacrum .. 1 first thoracic vertebra
  RangeOfMotion range;
};

/// The seventeen mobile levels L5-S1 .. T1-T2, from below.
///
/// Lumbar ranges are in-vitro means of Yamamoto et al., Spine 14:1256, 1989; thoracic ones of Wilke
/// et al., PLoS ONE 0177823, 2017 (its full ranges halved), both without the stiffening of a whole
/// rib cage, so they overstate a living chest. T12-L1 was in neither and is the mean of its
/// neighbours. Heights: lumbar 0.38 of the way, levels of one region alike. Advisory by nature:
/// sources differ by more than a third.
std::span<const SpineLevel> human_levels();

/// Range of the levels between two arc fractions, a level that is cut counting by its part.
RangeOfMotion human_range(double from, double to);

/// Axial range per arc at `count` equal steps from sacrum to first thoracic vertebra: how a body
/// spreads a twist.
std::vector<double> human_twist_density(int count);

}  // namespace backbend::solver
