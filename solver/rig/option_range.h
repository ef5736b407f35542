#pragma once
#include <map>
#include <string>
#include <vector>

#include "solver/rig/spine_system.h"

namespace backbend::solver {

/// What an option may be, as the system that reads it says.
struct OptionRange {
  enum class Kind { number, integer, flag, word, numbers, spans };
  Kind kind = Kind::number;
  double least = 0.0, most = 0.0;    // number, integer, and each of numbers and spans
  std::vector<std::string> words{};  // of a word: those allowed
};

/// A system that can say what its options may be.
class RangedOptions {
 public:
  virtual ~RangedOptions() = default;
  /// By key; options with forms of their own (a list or a word) may be left out.
  virtual const std::map<std::string, OptionRange>& option_ranges() const = 0;
};

/// The ranges of a system's options on a chain: those that its own reading of options checks. Empty
/// for a system without any. Throws as build_system().
std::map<std::string, OptionRange> option_ranges(const SystemSpec& spec, const RestChain& chain);

}  // namespace backbend::solver
