#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace backbend::validate {

struct ChildResult {
  int exit_code = -1;     // 128 + signal where a signal ended it
  std::string complaint;  // the end of what it wrote to standard error
};

/// Runs a program found on PATH without a shell. `feed` is called with a writer for the child's
/// standard input until it returns; the child's output is dropped, its complaints are kept.
/// Throws ReadError where the program cannot be started. Writing to a child that went away is no
/// error: its exit code tells.
ChildResult run_child(
    const std::vector<std::string>& argv,
    const std::function<void(const std::function<void(std::span<const std::uint8_t>)>&)>& feed);

/// Runs a program and returns its standard output. Throws ReadError where it cannot be started.
struct CapturedChild {
  int exit_code = -1;
  std::string output;
};
CapturedChild capture_child(const std::vector<std::string>& argv);

/// Runs a program that turns its standard input into its standard output, and stops it (with
/// SIGKILL) once it has run for `seconds` or written more than `most_bytes`. Throws ReadError where
/// it cannot be started.
struct FilteredChild {
  int exit_code = -1;     // 128 + signal where a signal ended it
  bool too_long = false;  // stopped for its time
  bool too_much = false;  // stopped for its output
  std::vector<std::uint8_t> output;
  std::string complaint;  // the end of what it wrote to standard error
};
FilteredChild filter_child(const std::vector<std::string>& argv,
                           std::span<const std::uint8_t> input, std::size_t most_bytes,
                           double seconds);

}  // namespace backbend::validate
