#include "validate/files/child_process.h"

#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <thread>

#include "validate/files/child_spawn.h"

namespace backbend::validate {
namespace {

std::string drain(int descriptor, std::size_t keep) {
  std::string text;
  std::array<char, 4096> block;
  while (true) {
    const ssize_t got = ::read(descriptor, block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    text.append(block.data(), static_cast<std::size_t>(got));
    if (keep != 0 && text.size() > keep) text.erase(0, text.size() - keep);
  }
  return text;
}

/// Writes all of it, or until the reader goes away: SIGPIPE is ignored by the program.
void write_all(int descriptor, std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

}  // namespace

ChildResult run_child(
    const std::vector<std::string>& argv,
    const std::function<void(const std::function<void(std::span<const std::uint8_t>)>&)>& feed) {
  Pipe input, complaints;
  const pid_t child = spawn_child(argv, input.read_end, -1, complaints.write_end);
  input.close_read();
  complaints.close_write();

  std::string complaint;
  std::thread listener([&] { complaint = drain(complaints.read_end, 4096); });
  bool broken = false;
  const auto give = [&](std::span<const std::uint8_t> bytes) {
    while (!broken && !bytes.empty()) {
      const ssize_t written = ::write(input.write_end, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) {
        broken = true;  // SIGPIPE is ignored by the program: the child's exit code tells the rest
        return;
      }
      bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
  };
  const auto finish = [&] {
    input.close_write();
    const int exit_code = wait_for_child(child);
    listener.join();
    return exit_code;
  };
  try {
    feed(give);
  } catch (...) {
    ::kill(child, SIGKILL);
    finish();
    throw;
  }
  ChildResult result;
  result.exit_code = finish();
  result.complaint = complaint;
  return result;
}

CapturedChild capture_child(const std::vector<std::string>& argv) {
  Pipe output;
  const pid_t child = spawn_child(argv, -1, output.write_end, -1);
  output.close_write();
  CapturedChild result;
  result.output = drain(output.read_end, 0);
  result.exit_code = wait_for_child(child);
  return result;
}

FilteredChild filter_child(const std::vector<std::string>& argv,
                           std::span<const std::uint8_t> input, std::size_t most_bytes,
                           double seconds) {
  using Clock = std::chrono::steady_clock;
  const auto deadline = Clock::now() + std::chrono::duration<double>(seconds);
  Pipe in, out, complaints;
  const pid_t child = spawn_child(argv, in.read_end, out.write_end, complaints.write_end);
  in.close_read();
  out.close_write();
  complaints.close_write();
  FilteredChild result;
  std::thread feeder([&] {
    write_all(in.write_end, input);
    in.close_write();
  });
  std::thread listener([&] { result.complaint = drain(complaints.read_end, 4096); });
  std::vector<std::uint8_t> block(1 << 16);
  const auto stop = [&](bool& why) {
    why = true;
    ::kill(-child, SIGKILL);
  };
  while (true) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    pollfd wait{out.read_end, POLLIN, 0};
    const int ready =
        left <= 0 ? 0 : ::poll(&wait, 1, static_cast<int>(std::min<long>(left, 1000)));
    if (ready < 0 && errno == EINTR) continue;
    if (left <= 0) {
      stop(result.too_long);
      break;
    }
    if (ready == 0) continue;
    const ssize_t got = ::read(out.read_end, block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    result.output.insert(result.output.end(), block.begin(), block.begin() + got);
    if (result.output.size() > most_bytes) {
      stop(result.too_much);
      break;
    }
  }
  // A child that closed its output may still run: its time goes on.
  while (!result.too_long && !result.too_much) {
    siginfo_t ended{};
    if (::waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOHANG | WNOWAIT) != 0 ||
        ended.si_pid == child)
      break;
    if (Clock::now() >= deadline) stop(result.too_long);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  result.exit_code = wait_for_child(child);
  feeder.join();
  listener.join();
  return result;
}

}  // namespace backbend::validate
