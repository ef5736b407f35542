#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "validate/metrics/surface/bend_intent.h"
#include "validate/metrics/surface/spine_slices.h"

namespace backbend::validate {

/// What the slices of one pose say. Profiles have one entry per slice, NaN where the slice or the
/// window around it has no ring; the worst values are NaN where no slice could be measured.
struct SliceMeasures {
  std::size_t planned = 0, measured = 0;  // slices; and those with a ring

  std::vector<glm::dvec3> turning;  // over one window, beyond the intended, radians
  std::vector<double> kink_deg;     // second difference of the turning
  double kink_worst_deg = 0.0;
  int kink_slice = -1;

  std::vector<double> twist_deg;       // over one window beyond rest's, signed
  std::vector<double> twist_jump_deg;  // its second difference
  double twist_jump_worst_deg = 0.0;
  int twist_jump_slice = -1;

  std::vector<double> area_ratio;  // posed / rest
  double least_area_ratio = 0.0;
  int area_slice = -1;

  double folded = 0.0;  // share of the surface lines' rest length that runs backwards
  int fold_slice = -1;  // the first slice of the longest folded run, -1: none

  double infeasible =
      0.0;  // largest curvature times depth on the inner side; 1: the surface must fold
  int infeasible_slice = -1;
};

/// Measures one pose of the slices. `window`: slices that one turning spans (one bone, at least 2).
///
/// The turning over a window is the arc between the directions of the slice centres below and above
/// it, less that of the centres as the intent would move them. What is left is what the mesh does
/// by itself, and its second difference is large only where that changes suddenly: at a kink.
SliceMeasures measure_slices(const SpineSlices& slices, const SlicePose& rest,
                             const SlicePose& pose, const BendIntent& intent, int window);

/// The window for a body on `bones` spine bones: one bone, but no more than a sixth of the slices,
/// and as much less as the longest run of slices that the spine moves asks for, so that a second
/// difference has room there; at least 2.
int slice_window(const SpineSlices& slices, int bones);

/// Why no second difference fits onto the body, even with the smallest window: kinks and twist
/// jumps of the mesh cannot be told on it. Empty where one fits.
std::string why_no_kinks(const SpineSlices& slices);

/// Why the surface cannot be asked for folds: no line along the body crosses two slices in a row.
/// Empty where it can.
std::string why_no_folds(const SpineSlices& slices, const SlicePose& rest);

/// Kinks of one rig beyond those of another in the same pose of the same character: the second
/// difference of the difference of their turnings, degrees.
std::vector<double> paired_kink(const SliceMeasures& a, const SliceMeasures& b, int window);

/// The same for twist jumps: the second difference of the difference of their twists, degrees.
std::vector<double> paired_twist_jump(const SliceMeasures& a, const SliceMeasures& b, int window);

}  // namespace backbend::validate
