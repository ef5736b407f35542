#include "solver/rig/option_range.h"

namespace backbend::solver {

std::map<std::string, OptionRange> option_ranges(const SystemSpec& spec, const RestChain& chain) {
  SystemSpec bare = spec;  // with names of its own it would be another object
  bare.options.erase("control_names");
  bare.options.erase("joint_names");
  const auto system = build_system(bare, chain);
  const auto* ranged = dynamic_cast<const RangedOptions*>(system.get());
  return ranged == nullptr ? std::map<std::string, OptionRange>() : ranged->option_ranges();
}

}  // namespace backbend::solver
