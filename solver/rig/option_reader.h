#pragma once
#include <cstddef>
#include <initializer_list>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "solver/rig/option_range.h"
#include "solver/rig/spine_system.h"

namespace backbend::solver {

/// An option or pose key with a value that cannot be used. `key` names it, so that whoever knows
/// the file can add the line; what() is complete without it.
struct OptionError : RigError {
  OptionError(std::string key, const std::string& message)
      : RigError(message), key(std::move(key)) {}
  std::string key;
};

/// Reads a SystemSpec's options one by one, each with its default and what is allowed, and keeps
/// the full record. Every reader throws OptionError for a wrong type, a number that is not finite
/// or out of range, or a word that is not allowed, and says what is.
///
///   OptionReader read(spec);
///   const int bones = read.integer("bones", 10, 1, 64);
///   const auto basis = read.choice<Basis>("basis", {"bspline", "interpolate", "linear"});
///   options_ = read.finish();  // throws for a key that nobody read, with the nearest name
class OptionReader {
 public:
  explicit OptionReader(const SystemSpec& spec) : spec_(spec) {}

  bool flag(const std::string& key, bool fallback);
  double number(const std::string& key, double fallback, double least, double most);
  int integer(const std::string& key, int fallback, int least, int most);
  /// Index of the word among `allowed`; the first is the default.
  std::size_t word(const std::string& key, std::initializer_list<std::string_view> allowed);
  template <class Enum>
  Enum choice(const std::string& key, std::initializer_list<std::string_view> allowed) {
    return static_cast<Enum>(word(key, allowed));
  }
  /// A list of numbers; `count` 0 takes any length.
  std::vector<double> numbers(const std::string& key, std::vector<double> fallback,
                              std::size_t count = 0,
                              double least = -std::numeric_limits<double>::max(),
                              double most = std::numeric_limits<double>::max());
  /// A list of lists; the caller judges their lengths.
  std::vector<std::vector<double>> rows(const std::string& key,
                                        std::vector<std::vector<double>> fallback);
  /// rows() of as many spans as the fallback has, each from and to inside a range and `width` apart
  /// or more.
  std::vector<std::vector<double>> spans(const std::string& key,
                                         std::vector<std::vector<double>> fallback, double least,
                                         double most, double width);
  /// The value as given, for options with several forms; nullptr where none was. Record it with
  /// keep().
  const OptionValue* find(const std::string& key);
  void keep(const std::string& key, OptionValue value) { record_[key] = std::move(value); }

  /// Every option read so far with its value. Throws OptionError for a given one that was not read.
  std::map<std::string, OptionValue> finish() const;
  /// What the options read so far may be, of those that are held against a range or a list.
  const std::map<std::string, OptionRange>& ranges() const { return ranges_; }

  /// An OptionError that names the system: "curve: option 'bones' is 70, expected 1 to 64".
  [[noreturn]] void refuse(const std::string& key, const std::string& what) const;

 private:
  const SystemSpec& spec_;
  std::map<std::string, OptionValue> record_;
  std::map<std::string, OptionRange> ranges_;
};

/// A number as short as it reads back: for messages and records.
std::string number_text(double value);

}  // namespace backbend::solver
