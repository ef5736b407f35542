#pragma once
#include <optional>
#include <string>
#include <vector>

#include "validate/why/why.h"

namespace backbend::validate {

/// What `why` was asked and what it found.
struct WhyResult {
  std::vector<std::string> versions;  // as the user named them
  std::string rig;
  std::optional<FirstBad> first_bad;  // of more than two versions
  std::optional<WhyPair> pair;        // none: no version is worse than the first
  std::vector<std::string> notes;     // findings of the versions that were left out
  /// 1 where a finding is new or worse, else 0.
  int exit_code() const;
};

std::string why_text(const WhyResult& result);
/// `backbend.why/1`: one JSON object, keys sorted.
std::string why_json(const WhyResult& result);

}  // namespace backbend::validate
