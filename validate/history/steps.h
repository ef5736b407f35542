#pragma once
#include <cstddef>
#include <span>
#include <vector>

namespace backbend::validate {

/// A lasting change of level in a series with one value a night.
struct Step {
  std::size_t at = 0;            // the first night of the new level
  std::size_t known = 0;         // the night on which enough was seen to be sure
  double before = 0, after = 0;  // mean levels, up to the neighbouring steps
};

/// Where the level of `values` changed, in order. NaN is a night without a measurement.
///
/// A self-starting two-sided CUSUM: each value is compared with the mean of its level so far, in
/// units of the noise of all levels so far, and turned into a normal score, so that the rate of
/// false alarms is the same from the fourth night on: less than one in a year of normal noise. A
/// step of two standard deviations after a settled level is known within five nights in five cases
/// of six. One outlier alone is no step.
///
/// `least` is the smallest change that matters, in the values' unit, > 0. Where the noise is below
/// it (the same bits every night), a change of more than `least` is a step on its first night.
///
/// Sources: D. M. Hawkins, "Self-starting CUSUM charts for location and scale", The Statistician
/// 36, 1987; the normal score of a t value: D. L. Wallace, "Bounds on normal approximations to
/// Student's and the chi-square distributions", Annals of Mathematical Statistics 30, 1959.
std::vector<Step> find_steps(std::span<const double> values, double least);

}  // namespace backbend::validate
