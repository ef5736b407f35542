#pragma once
#include <span>
#include <string_view>

namespace backbend::validate {

/// A word that reports use and that `backbend explain` explains.
struct Topic {
  std::string_view name;   // `SOLVER`, `envelope`
  std::string_view means;  // one sentence
  std::string_view more;   // how it is found or used
  std::string_view act;    // what to do about it
};

/// Owners first, in the order of their enumeration, then the rest by name.
std::span<const Topic> all_topics();

/// By name, whatever its case; `proxy_weights` and `proxy-weights` are `proxy weights`. nullptr for
/// another word.
const Topic* find_topic(std::string_view name);

}  // namespace backbend::validate
