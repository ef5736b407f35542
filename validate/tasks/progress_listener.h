#pragma once
#include <cstddef>
#include <functional>
#include <string>

namespace backbend::validate {

/// Told how far a job is: its stage as a person reads it, steps done, steps in all.
using ProgressListener =
    std::function<void(const std::string& stage, std::size_t done, std::size_t total)>;

/// Who is told from then on, of every Progress, whatever its style: at most ten times a second, by
/// one thread at a time. An empty one: nobody.
void listen_to_progress(ProgressListener listener);

}  // namespace backbend::validate
