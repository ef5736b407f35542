#pragma once
#include <map>
#include <mutex>
#include <string>

#include "validate/measure/compound_search.h"
#include "validate/measure/measure.h"

namespace backbend::validate {

/// What searches for jumps found, kept while a program judges the same character again and again.
/// They depend on the joints at rest, the rig and the path alone: while those stay, bit for bit,
/// no change of the mesh or its weights asks for another search. Safe for several threads.
///
/// Rigs of the studio's own are always searched: what they answer is not known by what we see.
class KnownJumps {
 public:
  /// search_flips(), or what it found before.
  FlipReport flips(const Stage& stage, const RigRecord& rig, const Sweep& sweep);
  /// search_compound(), or what it found before. `system`: the plan's, on this stage.
  FoundJumps compound(const Stage& stage, const RigPlan& plan, const solver::SpineSystem& system,
                      solver::Mapping mapping, const Envelope& box, Progress& progress);

  /// Forgets what nobody has asked for since it was called last.
  void forget_unused();

 private:
  template <class Found>
  struct Kept {
    Found found;
    int asked = 0;  // in which run it was asked for last
  };
  template <class Found>
  using Store = std::map<std::string, Kept<Found>>;

  template <class Found, class Search>
  Found known(Store<Found>& store, std::string key, const Search& search);

  std::mutex mutex_;
  int run_ = 0;
  Store<FlipReport> flips_;
  Store<FoundJumps> compound_;
};

}  // namespace backbend::validate
