#pragma once
#include <string>
#include <vector>

#include "validate/tune/tune.h"

namespace backbend::validate {

/// For a person: what was varied, the trade choice by choice, and which one is written. `planned`:
/// what would be searched, and about how long.
std::string tune_text(const TuneResult& result, bool planned);
/// `backbend.tune/1`: one JSON object, keys sorted.
std::string tune_json(const TuneResult& result, bool planned);
/// The lines at the head of the rig file: where it comes from, what it gives. Needs a chosen one.
std::vector<std::string> rig_file_comment(const TuneResult& result);

}  // namespace backbend::validate
