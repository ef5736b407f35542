#pragma once
#include "validate/judge/judge.h"

namespace backbend::validate {

/// Says who must act on each mesh finding, by three more solves of that one pose: under `even` (the
/// ideal bend and twist with the same weights), with clean proxy weights, and with dual
/// quaternions. Findings on the chain are solved under `even` again, and keep their owner.
///
/// Infeasible poses belong to POSE. Where the ideal bend shows the fault as well, it belongs to
/// SKELETON (advisory) if clean weights show it too, else to WEIGHTS; where it does not, to SOLVER.
/// Unless the character itself is on trial (`judges_weights`), only what exceeds the ideal bend
/// decides; the rest is booked to skin or pose as stress, and stays listed.
void book_owners(const Stage& stage, const BodyMetrics& body, const RigRecord& rig,
                 bool judges_weights, std::vector<Finding>& findings);

}  // namespace backbend::validate
