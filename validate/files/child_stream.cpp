#include "validate/files/child_stream.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <thread>

#include "validate/files/child_spawn.h"

namespace backbend::validate {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kKeptComplaint = 4096;
constexpr std::size_t kBlock = 1 << 16;
constexpr double kSecondsToEnd = 1.0;

void answer_at_once(int descriptor) {
  ::fcntl(descriptor, F_SETFL, ::fcntl(descriptor, F_GETFL) | O_NONBLOCK);
}

int take(int& descriptor) {
  const int taken = descriptor;
  descriptor = -1;
  return taken;
}

}  // namespace

ChildStream::ChildStream(const std::vector<std::string>& argv) {
  Pipe in, out, complaints;
  child_ = spawn_child(argv, in.read_end, out.write_end, complaints.write_end);
  input_ = take(in.write_end);
  output_ = take(out.read_end);
  complaints_ = take(complaints.read_end);
  for (const int descriptor : {input_, output_, complaints_}) answer_at_once(descriptor);
}

ChildStream::~ChildStream() {
  if (input_ >= 0) ::close(input_);
  input_ = -1;
  if (!reap(kSecondsToEnd)) kill();
  ::close(output_);
  ::close(complaints_);
}

bool ChildStream::reap(double seconds) {
  const auto deadline = Clock::now() + std::chrono::duration<double>(seconds);
  while (!ended_) {
    siginfo_t found{};
    const int error =
        ::waitid(P_PID, static_cast<id_t>(child_), &found, WEXITED | WNOHANG | WNOWAIT);
    if ((error != 0 && errno != EINTR) || (error == 0 && found.si_pid == child_)) {
      kill();
    } else if (Clock::now() >= deadline) {
      return false;
    } else {
      listen();  // one that waits for somebody to read its complaints does not end
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }
  return true;
}

void ChildStream::kill() {
  if (ended_) return;
  // What it started itself and left behind goes, too: its group's number is taken while it is not
  // waited for.
  ::kill(-child_, SIGKILL);
  exit_code_ = wait_for_child(child_);
  ended_ = true;
}

int ChildStream::exit_code() {
  if (!reap(0.5)) kill();
  return exit_code_;
}

const std::string& ChildStream::complaint() {
  listen();
  return complaint_;
}

void ChildStream::listen() {
  std::array<char, 4096> block;
  while (true) {
    const ssize_t got = ::read(complaints_, block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return;
    complaint_.append(block.data(), static_cast<std::size_t>(got));
    if (complaint_.size() > kKeptComplaint) complaint_.erase(0, complaint_.size() - kKeptComplaint);
  }
}

ChildStream::Outcome ChildStream::wait(int descriptor, short events, const Patience& patience) {
  const auto deadline = Clock::now() + std::chrono::duration<double>(patience.seconds);
  while (true) {
    pollfd waits[] = {{descriptor, events, 0}, {complaints_, POLLIN, 0}};
    const int ready = ::poll(waits, 2, 100);
    if (patience.watch) patience.watch();
    if (ready > 0 && waits[0].revents != 0) return Outcome::all;
    // A child that closed its standard error would make poll() return at once, for ever.
    if (ready > 0 && (waits[1].revents & POLLIN) == 0)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    listen();
    if (Clock::now() >= deadline) return Outcome::silent;
  }
}

ChildStream::Outcome ChildStream::write(std::span<const std::uint8_t> bytes,
                                        const Patience& patience) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(input_, bytes.data(), bytes.size());
    if (written > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(written));
      continue;
    }
    if (written < 0 && errno == EINTR) continue;
    if (written == 0 || errno != EAGAIN) return Outcome::ended;
    if (const Outcome got = wait(input_, POLLOUT, patience); got != Outcome::all) return got;
  }
  return Outcome::all;
}

/// Reads what is there, waiting for at least one byte.
ChildStream::Outcome ChildStream::fill(const Patience& patience) {
  if (taken_ > 0) {
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(taken_));
    taken_ = 0;
  }
  while (true) {
    const std::size_t had = buffer_.size();
    buffer_.resize(had + kBlock);
    const ssize_t got = ::read(output_, buffer_.data() + had, kBlock);
    const int error = errno;
    buffer_.resize(had + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
    if (got > 0) return Outcome::all;
    if (got < 0 && error == EINTR) continue;
    if (got == 0 || error != EAGAIN) return Outcome::ended;
    if (const Outcome there = wait(output_, POLLIN, patience); there != Outcome::all) return there;
  }
}

ChildStream::Outcome ChildStream::read(std::span<std::uint8_t> bytes, const Patience& patience) {
  while (!bytes.empty()) {
    const std::size_t here = std::min(bytes.size(), buffer_.size() - taken_);
    std::memcpy(bytes.data(), buffer_.data() + taken_, here);
    taken_ += here;
    bytes = bytes.subspan(here);
    if (bytes.empty()) break;
    if (const Outcome got = fill(patience); got != Outcome::all) return got;
  }
  return Outcome::all;
}

ChildStream::Outcome ChildStream::read_line(std::string& line, std::size_t most,
                                            const Patience& patience) {
  line.clear();
  while (true) {
    const auto begin = buffer_.begin() + static_cast<std::ptrdiff_t>(taken_);
    const auto end = std::find(begin, buffer_.end(), std::uint8_t{'\n'});
    line.append(begin, end);
    if (line.size() > most) return Outcome::too_much;
    taken_ = static_cast<std::size_t>(end - buffer_.begin());
    if (end != buffer_.end()) {
      ++taken_;
      return Outcome::all;
    }
    if (const Outcome got = fill(patience); got != Outcome::all) return got;
  }
}

}  // namespace backbend::validate
