#pragma once
#include <set>
#include <string>
#include <string_view>

namespace backbend::skin {

/// A name that every reader of USD takes: letters of ASCII, digits and underscores, no digit first.
/// Every other byte becomes an underscore; `otherwise` stands for an empty name.
std::string usd_identifier(std::string_view name, std::string_view otherwise);

/// Names of which no two are alike: the second `spine` becomes `spine_2`.
class UniqueNames {
 public:
  std::string take(std::string name);

 private:
  std::set<std::string> taken_;
};

/// `text` in double quotes as every reader of USD's text form takes it: readers differ in what they
/// make of escapes, so there are none. Double quotes become single ones, backslashes slashes,
/// control characters `?`.
std::string usd_string(std::string_view text);

}  // namespace backbend::skin
