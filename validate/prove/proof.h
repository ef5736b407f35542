#pragma once
#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "solver/rig/box_solver.h"
#include "validate/prove/proof_box.h"
#include "validate/tasks/progress.h"

namespace backbend::validate {

/// What is asked to be proved of every pose of a box: that no joint's frame jumps, and that none
/// turns by more than `gain` per unit of any one channel alone.
struct ProofQuestion {
  solver::SystemSpec rig;
  solver::RestChain chain;
  solver::Mapping mapping = solver::Mapping::chest;
  ProofBox box;
  double gain = 8.0;              // BB002's limit
  double smallest = 1.0;          // boxes no wider than this are not split any more
  std::uint64_t boxes = 1000000;  // the most that are looked at
};

/// A pose that breaks a claim, found and measured with the plain solver.
struct Refutation {
  std::array<double, kProofAxes> pose{};  // in the box's units
  std::string check;                      // BB001: a jump, degrees; BB002: a gain
  double value = 0.0;
  std::size_t joint = 0;
  int axis = 0;  // of the box: along which it shows
};

/// What became of a box. The proof is a tree of boxes: the first is the whole, and each that is
/// `split` has its two halves in the tree.
enum class BoxState : char {
  certified = 'C',  // no jump, and the gain is at most what was asked
  refuted = 'R',    // holds a pose that breaks a claim, and no proof that it does not jump
  steep = 'S',      // the same, but proved not to jump
  smooth = 'G',     // open: proved not to jump, the gain not bounded as asked
  open = 'O',       // open: neither
  pending = 'P',    // not looked at yet
  split = '/'
};

struct ProofNode {
  BoxState state = BoxState::pending;
  std::int8_t axis = 0;          // split: at the middle of this axis
  bool looked_at = false;        // split: after a look; else its halves were split at once
  std::uint32_t first = 0;       // split: its halves are nodes first and first + 1
  std::uint32_t refutation = 0;  // refuted, steep: index into the list
};

struct ProofTree {
  std::vector<ProofNode> node{ProofNode{}};
  std::vector<Refutation> refutation;
  double gain_bound = 0.0;  // the largest that was proved for a certified box
  std::uint64_t looked_at = 0;

  bool is_complete() const;
};

/// Calls `visit(box, node)` for every leaf in order: a split box's lower half first.
void each_leaf(const ProofTree& tree, const ProofBox& whole,
               const std::function<void(const SubBox&, const ProofNode&)>& visit);

/// Shares of the box's volume.
struct ProofShares {
  double certified = 0.0, refuted = 0.0, open = 0.0;
  double no_jump = 0.0;  // proved continuous, whatever its gain
  std::uint64_t certified_boxes = 0, refuted_boxes = 0, open_boxes = 0;
};
ProofShares shares_of(const ProofTree& tree, const ProofBox& whole);

/// Proves and refutes by bisection: a box that cannot be certified is split at the middle of its
/// widest axis until it is no wider than `smallest`; then the plain solver searches it for a pose
/// that breaks a claim. Boxes go by falling size, so that what the number of boxes leaves open is
/// small; where a box is far from certified its halves are split again without a look.
///
/// The tree is the same for any number of threads. `tree` may hold the beginning of a search of the
/// same question, which goes on: when a signal comes, what is decided stays in it, the rest is
/// pending, and Interrupted is thrown.
void prove(const ProofQuestion& question, const solver::SpineSystem& system, ProofTree& tree,
           Progress& progress);

/// The rig's BoxSolver. Throws ProofError naming the system and the reason where it has none.
const solver::BoxSolver& box_solver_of(const solver::SpineSystem& system);
/// Throws ProofError for a box of controls along one that its solver cannot vary over boxes.
void check_controls(const ProofBox& box, const solver::SpineSystem& system,
                    const solver::BoxSolver& solver);

/// The body poses of a part of a box of body channels.
solver::BodyBox body_over(const ProofBox& whole, const SubBox& part);
/// The rig's controls over a part of a box: exact, or one variable for each axis that varies.
std::vector<solver::BoxReal> controls_over(const ProofBox& whole, const solver::SpineSystem& system,
                                           const solver::BoxSolver& solver, solver::Mapping mapping,
                                           const SubBox& part);

/// What the box solver says of a part of the box: the most that any joint turns per unit of each
/// channel alone; infinite where a joint may jump.
struct PartGain {
  std::array<double, kProofAxes> along{};
  std::array<bool, kProofAxes> only_rolls{};  // as BoxPose's

  double most() const { return *std::max_element(along.begin(), along.end()); }
  /// Axes along which nothing turns, or all does by fixed shares: what is unknown of a part is the
  /// same over all of them, and no split there says more.
  std::array<bool, kProofAxes> idle() const;
};
PartGain gain_over(const ProofQuestion& question, const solver::SpineSystem& system,
                   const solver::BoxSolver& solver, const SubBox& part);

}  // namespace backbend::validate
