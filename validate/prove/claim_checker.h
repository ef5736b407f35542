#pragma once
#include <array>
#include <memory>
#include <string>

#include "validate/prove/proof_box.h"

namespace backbend::validate {

/// Bounds the gain of a rig over boxes by other means than the search: it shares the interval
/// arithmetic (solver/math/interval.h) and nothing else, neither the solver's code nor its
/// templates.
class ClaimChecker {
 public:
  virtual ~ClaimChecker() = default;
  /// The most that any joint turns per unit of any one channel, over a part of the box; infinite
  /// where that cannot be said.
  virtual double gain_over(const SubBox& part) const = 0;
  /// Axes that no bound depends on: to cut a part there says no more.
  virtual std::array<bool, kProofAxes> idle() const { return {}; }
};

struct ProofQuestion;

/// Throws ProofError: the rig's checker knows `what` only.
[[noreturn]] void checker_knows(const ProofQuestion& question, const std::string& what);
/// Throws ProofError for a box of the rig's own controls.
void check_body_channels(const ProofQuestion& question);

/// Throws ProofError where no checker knows the system with its options.
std::unique_ptr<ClaimChecker> claim_checker(const ProofQuestion& question,
                                            const solver::SpineSystem& system);

/// For rigs whose joints are products of turns about fixed axes by shares of the channels
/// (three_bone, even, neck): a joint turns by at most the sum of the shares times what a channel
/// moves. docs/prove.md, "What the check shares".
std::unique_ptr<ClaimChecker> sum_checker(const ProofQuestion& question,
                                          const solver::SpineSystem& system);

/// For matrix_blend in Rigify's style: bounds of the parts of a turn in closed form.
std::unique_ptr<ClaimChecker> blend_checker(const ProofQuestion& question,
                                            const solver::SpineSystem& system);

/// For spline_ik and stretchy on any spine: one Bezier curve from hips to chest.
std::unique_ptr<ClaimChecker> hip_chest_checker(const ProofQuestion& question,
                                                const solver::SpineSystem& system);

/// For curve on any spine, under both mappings: its curve, places and bones are enclosed with their
/// derivatives.
std::unique_ptr<ClaimChecker> curve_checker(const ProofQuestion& question,
                                            const solver::SpineSystem& system);

/// For snake under both mappings: its joints are walked by interval Newton steps.
std::unique_ptr<ClaimChecker> snake_checker(const ProofQuestion& question,
                                            const solver::SpineSystem& system);

/// For isner under the mapping chest: in the chest's frame the arc length depends on the pose by
/// one number, and every derivative is written out by hand.
std::unique_ptr<ClaimChecker> isner_checker(const ProofQuestion& question,
                                            const solver::SpineSystem& system);

}  // namespace backbend::validate
