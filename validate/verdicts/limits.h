#pragma once
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "validate/verdicts/checks.h"

namespace backbend::validate {

/// A limit or waiver that cannot be used. what() is the whole line the user sees.
struct LimitError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Later layers win. Waivers stand above all of them (waivers.h).
enum class LimitLayer { builtin, studio, show, character };
std::string_view name_of(LimitLayer layer);

/// One limit with its pedigree.
struct Limit {
  double value = 0.0;
  LimitLayer layer = LimitLayer::builtin;
  std::string origin;  // file and line, or `default`
  std::string owner;   // who answers for it
  std::string reason;
};

/// The limits in force for one character.
class LimitSet {
 public:
  /// The defaults of the table of checks.
  LimitSet();

  /// Sets a limit in a layer, replacing that layer's earlier one. Throws LimitError for an unknown
  /// code (naming the nearest), a value that is not finite, or an empty reason: a limit that nobody
  /// can explain is worth nothing.
  void set(std::string_view code, Limit limit);

  /// The limit in force. Throws LimitError for an unknown code.
  const Limit& of(std::string_view code) const;
  /// Every limit set for a code, the default first, the one in force last.
  const std::vector<Limit>& history(std::string_view code) const;

  /// judge() of the check with this code against the limit in force.
  Verdict judge(std::string_view code, double measured) const;

 private:
  std::map<std::string, std::vector<Limit>, std::less<>> limits_;
};

/// The known code that is nearest to a mistyped one.
std::string_view nearest_code(std::string_view code);

}  // namespace backbend::validate
