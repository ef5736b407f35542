#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "solver/rig/box_solver.h"
#include "validate/prove/proof_box.h"
#include "validate/stage/stage.h"
#include "validate/tasks/progress.h"
#include "validate/verdicts/checks.h"

namespace backbend::validate {

/// A limit of a check that is to hold at every pose of a box.
struct MetricClaim {
  const Check* check = nullptr;
  double limit = 0.0;
};

/// `BB030`, or with a limit of its own `BB030=0.8`: of the chain BB010, BB020, BB021, BB041 and
/// BB047, of the mesh BB030 and BB033. Throws ProofError.
MetricClaim read_claim(const std::string& text);

struct MetricQuestion {
  const solver::SpineSystem* system = nullptr;
  solver::Mapping mapping = solver::Mapping::chest;
  const Stage* stage = nullptr;  // null: only claims about the chain
  ProofBox box;                  // of body channels
  std::vector<MetricClaim> claim;
  double smallest = 2.0;  // degrees: boxes no wider are not split
};

enum class ClaimState : std::uint8_t { certified, refuted, open };

/// A box that was not split, and in which some claim was not certified: one of the smallest, or one
/// at whose every pose all that was left to prove is broken.
struct UndecidedBox {
  SubBox box;
  std::vector<ClaimState> state;  // of each claim
};

/// What became of one claim. Shares of the box's volume.
struct ClaimResult {
  double certified = 0.0, refuted = 0.0, open = 0.0;
  double bound = 0.0;  // where certified, no pose has a worse value than this
  // The worst value that the plain solver and skinning gave at the middle of a box that was not
  // split; none were looked at where all is certified.
  bool measured = false;
  double worst = 0.0;
  std::array<double, kProofAxes> pose{};
};

struct MetricProof {
  std::vector<ClaimResult> claim;
  std::vector<UndecidedBox> undecided;
  std::uint64_t looked_at = 0;
};

/// The box's parts, which are looked at side by side: of each what became of it; none: not yet
/// looked at to its end.
using MetricParts = std::vector<std::optional<MetricProof>>;

/// All of them, not yet looked at.
MetricParts parts_not_looked_at(const MetricQuestion& question);

/// A proof of no box.
MetricProof nothing_yet(const MetricQuestion& question);

/// Bounds the metrics over boxes by interval arithmetic. A box where a claim is not certified is
/// halved across its widest channel until `smallest`; then the plain solver and skinning measure
/// the pose at its centre. The result is the same for any number of threads. `parts` are those of
/// the same question; what is decided of them is kept, and what a signal leaves decided is in it.
/// Throws ProofError where the rig's joints cannot be enclosed or a claim needs a character,
/// Interrupted after a signal.
MetricProof prove_metrics(const MetricQuestion& question, MetricParts& parts, Progress& progress);

}  // namespace backbend::validate
