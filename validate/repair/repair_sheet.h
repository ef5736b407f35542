#pragma once
#include <cstdint>
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "validate/sweeps/envelope.h"
#include "validate/tasks/progress.h"
#include "validate/verdicts/finding.h"

namespace backbend::validate {

/// A body before and after its weights were repaired.
struct RepairedBody {
  const skin::Character& before;
  const skin::Character& after;  // the same vertices
  const skin::Anatomy& anatomy;
  const Envelope& envelope;
  const std::vector<Finding>& findings;  // of the weights, before, worst first
};

/// One PNG: the body before and after in the pose of the worst finding that has one (else at the
/// end of extension) and how much weight each vertex changed; beneath, where that finding is of the
/// mesh, its heat before and after on one scale. Throws Interrupted, render::RenderError.
std::vector<std::uint8_t> repair_sheet(const RepairedBody& body, Progress& progress);

}  // namespace backbend::validate
