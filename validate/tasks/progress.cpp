#include "validate/tasks/progress.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "validate/tasks/interrupt_note.h"
#include "validate/tasks/progress_listener.h"
#include "validate/tasks/superseded.h"

namespace backbend::validate {
namespace {

// Written by signal handlers, and by other threads than those that ask.
std::atomic<int> pending_signal = 0;
static_assert(std::atomic<int>::is_always_lock_free);
std::atomic<bool> is_superseded = false;

/// The one listener, and when it was last told.
struct Listening {
  std::mutex mutex;
  ProgressListener listener;
  std::chrono::steady_clock::time_point told;
};
Listening& listening() {
  static Listening place;
  return place;
}

void tell(const std::string& stage, std::size_t done, std::size_t total) {
  constexpr std::chrono::milliseconds kPause(100);
  Listening& place = listening();
  const std::lock_guard lock(place.mutex);
  const auto now = std::chrono::steady_clock::now();
  if (!place.listener || now - place.told < kPause) return;
  place.told = now;
  place.listener(stage, done, total);
}

std::string remaining(double seconds) {
  const auto whole = static_cast<long>(seconds + 0.5);
  if (whole >= 60)
    return std::to_string(whole / 60) + " min " + std::to_string(whole % 60) + " s left";
  return std::to_string(whole) + " s left";
}

}  // namespace

void watch_signals() {
  struct sigaction action = {};
  action.sa_handler = note_interrupt;
  sigemptyset(&action.sa_mask);
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
  ::signal(SIGPIPE, SIG_IGN);
}

void note_interrupt(int signal_number) { pending_signal = signal_number; }

bool interrupt_pending() { return pending_signal != 0; }

void poll_interrupt() {
  if (interrupt_pending()) throw Interrupted(pending_signal);
  if (is_superseded.load(std::memory_order_relaxed)) throw Superseded();
}

bool stop_pending() { return interrupt_pending() || is_superseded.load(); }

void set_superseded(bool superseded) { is_superseded.store(superseded); }

void listen_to_progress(ProgressListener listener) {
  Listening& place = listening();
  const std::lock_guard lock(place.mutex);
  place.listener = std::move(listener);
  place.told = {};
}

Progress::Progress(Style style) : style_(style) {
  if (style_ == Style::automatic) {
    const char* terminal = std::getenv("TERM");
    const bool dumb = terminal == nullptr || std::strcmp(terminal, "dumb") == 0;
    style_ = ::isatty(STDERR_FILENO) == 1 && !dumb ? Style::live : Style::plain;
  }
}

Progress::~Progress() { finish(); }

void Progress::start(const std::string& stage, std::size_t total) {
  const std::lock_guard lock(mutex_);
  stage_ = stage;
  total_ = total;
  done_ = 0;
  started_ = shown_ = std::chrono::steady_clock::now();
}

void Progress::step(std::size_t count) {
  const std::lock_guard lock(mutex_);
  done_ += count;
  tell(stage_, done_, total_);
  const auto now = std::chrono::steady_clock::now();
  const auto pause =
      style_ == Style::live ? std::chrono::milliseconds(100) : std::chrono::milliseconds(1000);
  if (now - shown_ < pause) return;
  shown_ = now;
  show();
}

void Progress::finish() {
  const std::lock_guard lock(mutex_);
  if (line_is_live_) std::fputs("\r\x1b[K", stderr);
  line_is_live_ = false;
  total_ = 0;
}

void Progress::say(const std::string& line) {
  const std::lock_guard lock(mutex_);
  if (style_ == Style::none) return;
  if (line_is_live_) std::fputs("\r\x1b[K", stderr);
  line_is_live_ = false;
  std::fprintf(stderr, "%s\n", line.c_str());
}

void Progress::show() {
  if (style_ == Style::none || total_ == 0) return;
  const double fraction = std::min(1.0, static_cast<double>(done_) / static_cast<double>(total_));
  const double seconds = std::chrono::duration<double>(shown_ - started_).count();
  const std::string left = fraction > 0.0 ? remaining(seconds / fraction - seconds) : "";
  const int percent = static_cast<int>(fraction * 100.0);
  if (style_ == Style::live) {
    std::string bar(20, '.');
    std::fill_n(bar.begin(), percent / 5, '#');
    std::fprintf(stderr, "\r\x1b[K%s %s %zu/%zu  %s", stage_.c_str(), bar.c_str(), done_, total_,
                 left.c_str());
    std::fflush(stderr);
    line_is_live_ = true;
  } else {
    std::fprintf(stderr, "%s %zu/%zu (%d %%)  %s\n", stage_.c_str(), done_, total_, percent,
                 left.c_str());
  }
}

}  // namespace backbend::validate
