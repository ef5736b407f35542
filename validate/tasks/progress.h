#pragma once
#include <chrono>
#include <csignal>
#include <mutex>
#include <stdexcept>
#include <string>

namespace backbend::validate {

/// A signal asked the program to stop; thrown from poll_interrupt() between whole steps of work.
struct Interrupted : std::runtime_error {
  explicit Interrupted(int signal_number)
      : std::runtime_error(signal_number == SIGTERM ? "terminated" : "interrupted"),
        signal_number(signal_number) {}
  int signal_number;
};

/// From then on SIGINT and SIGTERM only leave a note that poll_interrupt() turns into Interrupted.
void watch_signals();
/// Whether a watched signal has come.
bool interrupt_pending();
/// Throws Interrupted where a watched signal has come.
void poll_interrupt();

/// Progress of one long job, on standard error: a live line on a terminal, plain lines (at most one
/// a second) elsewhere, nothing when quiet. Thread safe.
class Progress {
 public:
  enum class Style { automatic, live, plain, none };

  explicit Progress(Style style = Style::automatic);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Starts a stage of `total` steps, named for a person: `poses`, `frames`.
  void start(const std::string& stage, std::size_t total);
  void step(std::size_t count = 1);
  /// Ends the stage and takes the live line away.
  void finish();
  /// One line to standard error, above the live line.
  void say(const std::string& line);

 private:
  void show();

  std::mutex mutex_;
  Style style_;
  std::string stage_;
  std::size_t total_ = 0, done_ = 0;
  bool line_is_live_ = false;
  std::chrono::steady_clock::time_point started_, shown_;
};

}  // namespace backbend::validate
