#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace backbend::fuzz {

using Bytes = std::vector<std::uint8_t>;
using Input = std::span<const std::uint8_t>;

/// One parser, driven from its bytes through to the first use of what was read.
struct Target {
  std::string_view name;
  /// True where the input was read and used, false where it was refused as a user sees it.
  /// Whatever else happens to an input is a finding: a crash, another exception, a broken promise.
  bool (*run)(Input);
  /// Inputs to start from. Every one is read, not refused.
  std::vector<Bytes> (*seeds)();
  /// Words of the format, for a mutator.
  std::vector<std::string> words;
  std::size_t most_bytes = 4096;  // of an input that a mutator makes
};

/// The targets of this program: one in a fuzzer, all of them in the replay.
std::vector<Target>& targets();

/// Each *_fuzz.cpp has one of these.
struct Registration {
  explicit Registration(Target target) { targets().push_back(std::move(target)); }
};

/// Ends the process, which is how a fuzzer learns of a finding.
void require(bool holds, const char* promise);

/// False, for `return refused(error)`; requires that something is said. Names that a refusal
/// repeats are made one visible line where it is printed (cli/main.cpp).
bool refused(const std::exception& error);

/// What the last refusal said.
const std::string& last_refusal();

inline std::string_view text_of(Input input) {
  return {reinterpret_cast<const char*>(input.data()), input.size()};
}
inline Bytes bytes_of(std::string_view text) { return {text.begin(), text.end()}; }

/// True for one input in so many, told by its bytes: for what costs a mutator its time and takes
/// few other ways.
bool one_in(unsigned many, Input input);

/// The input as a file of that name in this process's own folder, which nothing else is in.
std::filesystem::path as_file(Input input, const std::string& name);

/// A file of the source tree.
std::string source_text(const std::string& relative);

}  // namespace backbend::fuzz
