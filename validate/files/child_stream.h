#pragma once
#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace backbend::validate {

/// A program that is talked to over its standard input and output for as long as this lives.
///
/// It is found on PATH and started without a shell, in a process group of its own, so that Ctrl-C
/// on our terminal is ours to handle. The end of this closes its input, leaves it a second to end
/// by itself and then kills the group. Not for several threads at once.
class ChildStream {
 public:
  /// Throws ReadError where the program cannot be started.
  explicit ChildStream(const std::vector<std::string>& argv);
  ~ChildStream();
  ChildStream(const ChildStream&) = delete;
  ChildStream& operator=(const ChildStream&) = delete;

  /// `all`: done. `ended`: the child closed its end. `silent`: no byte went for `seconds`.
  /// `too_much`: a line longer than is allowed.
  enum class Outcome { all, ended, silent, too_much };

  /// How long a child may be silent, and what is called about ten times a second while it is waited
  /// for; it may throw.
  struct Patience {
    double seconds = 60.0;
    std::function<void()> watch;
  };

  Outcome write(std::span<const std::uint8_t> bytes, const Patience& patience);
  /// Fills all of `bytes`.
  Outcome read(std::span<std::uint8_t> bytes, const Patience& patience);
  /// Up to and without the line feed; at most `most` bytes.
  Outcome read_line(std::string& line, std::size_t most, const Patience& patience);

  /// Kills the child and waits for its end.
  void kill();
  /// The exit code once the child has ended, 128 + signal where a signal ended it: waits half a
  /// second for it, then kills it.
  int exit_code();
  /// The end of what it has written to standard error.
  const std::string& complaint();

 private:
  Outcome fill(const Patience& patience);
  Outcome wait(int descriptor, short events, const Patience& patience);
  void listen();
  bool reap(double seconds);

  pid_t child_ = -1;
  int input_ = -1, output_ = -1, complaints_ = -1;
  bool ended_ = false;
  int exit_code_ = -1;
  std::vector<std::uint8_t> buffer_;  // read and not yet taken
  std::size_t taken_ = 0;             // of it
  std::string complaint_;
};

}  // namespace backbend::validate
