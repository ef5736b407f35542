#include "validate/files/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <system_error>
#include <thread>

#include "validate/files/output_folder.h"

extern char** environ;

namespace backbend::validate {
namespace {

struct Pipe {
  int read_end = -1, write_end = -1;
  Pipe() {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) {
      throw ReadError("cannot make a pipe: " + std::generic_category().message(errno));
    }
    read_end = ends[0];
    write_end = ends[1];
  }
  ~Pipe() {
    close_read();
    close_write();
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  void close_read() {
    if (read_end >= 0) ::close(read_end);
    read_end = -1;
  }
  void close_write() {
    if (write_end >= 0) ::close(write_end);
    write_end = -1;
  }
};

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

pid_t spawn(const std::vector<std::string>& argv, int input, int output, int complaints) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  const auto give = [&](int descriptor, int as) {
    if (descriptor >= 0) {
      posix_spawn_file_actions_adddup2(&actions, descriptor, as);
    } else {
      posix_spawn_file_actions_addopen(&actions, as, "/dev/null", as == 0 ? O_RDONLY : O_WRONLY, 0);
    }
  };
  give(input, 0);
  give(output, 1);
  give(complaints, 2);

  // A group of its own: Ctrl-C on our terminal is ours to handle, then the child sees its input
  // end.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t defaults;
  sigemptyset(&defaults);
  sigaddset(&defaults, SIGPIPE);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);

  std::vector<char*> words;
  for (const std::string& word : argv) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  pid_t child = -1;
  const int error = ::posix_spawnp(&child, words[0], &actions, &attributes, words.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  if (error != 0) {
    throw ReadError(argv[0] + ": cannot be started: " + std::generic_category().message(error));
  }
  return child;
}

int wait_for(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return -1;
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
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
  const pid_t child = spawn(argv, input.read_end, -1, complaints.write_end);
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
    const int exit_code = wait_for(child);
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
  const pid_t child = spawn(argv, -1, output.write_end, -1);
  output.close_write();
  CapturedChild result;
  result.output = drain(output.read_end, 0);
  result.exit_code = wait_for(child);
  return result;
}

FilteredChild filter_child(const std::vector<std::string>& argv,
                           std::span<const std::uint8_t> input, std::size_t most_bytes,
                           double seconds) {
  using Clock = std::chrono::steady_clock;
  const auto deadline = Clock::now() + std::chrono::duration<double>(seconds);
  Pipe in, out, complaints;
  const pid_t child = spawn(argv, in.read_end, out.write_end, complaints.write_end);
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
  result.exit_code = wait_for(child);
  feeder.join();
  listener.join();
  return result;
}

}  // namespace backbend::validate
