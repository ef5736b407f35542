#pragma once
#include <memory>

#include "solver/rig/spine_system.h"

namespace backbend::solver {

/// Whether a rig goes on following the chain that it was drawn on: the thesis freezes it, its
/// author wished for `live` (research/seeds.md R28, W5).
enum class Drawing { frozen, live };

/// A rig together with the chain it was drawn on. A rig is a pure function of its spec and chain
/// (build_system()), so a live one is simply built anew when the chain is another: nothing is
/// carried over, and the same chain gives the same rig whatever was drawn before.
class LiveRig {
 public:
  /// Throws RigError as build_system() does.
  LiveRig(SystemSpec spec, RestChain chain, Drawing drawing = Drawing::frozen);

  const SpineSystem& system() const { return *system_; }
  const RestChain& chain() const { return chain_; }

  /// Tells the rig what the chain looks like now. Returns true if it was built anew: it is live and
  /// the chain differs in any number. References to the earlier system() are then dangling.
  ///
  /// Throws RigError where no rig can be built on the chain, or where the new rig's channels or
  /// joints have other names, so that keys and weights would lose their owner; the rig stays as it
  /// was.
  bool redraw(const RestChain& chain);

  /// The rig as it is now, which follows no chain any more.
  std::unique_ptr<SpineSystem> take() && { return std::move(system_); }

 private:
  SystemSpec spec_;
  RestChain chain_;
  Drawing drawing_;
  std::unique_ptr<SpineSystem> system_;
};

}  // namespace backbend::solver
