#include "cli/serve_command.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <condition_variable>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <mutex>
#include <optional>
#include <thread>

#include "cli/program.h"
#include "cli/trouble.h"
#include "validate/files/output_folder.h"
#include "validate/serve/json_rpc.h"
#include "validate/serve/mcp_session.h"
#include "validate/serve/message_lines.h"
#include "validate/serve/tool_result.h"
#include "validate/serve/tool_table.h"
#include "validate/tasks/progress.h"
#include "validate/tasks/progress_listener.h"
#include "validate/tasks/superseded.h"
#include "validate/text/escape.h"
#include "validate/verdicts/exit_code.h"

namespace backbend::cli {
namespace {

namespace fs = std::filesystem;
using namespace backbend::validate;

/// How long the reader waits before it looks for a signal.
constexpr int kWait_ms = 250;

struct ServeOptions {
  bool stdio = false, allow_write = false;
  std::vector<std::string> roots;
};

/// Standard output as the protocol's own. What commands print goes into memory instead, from where
/// it is taken; so nothing else reaches the client, whoever prints it.
class CapturedOutput {
 public:
  CapturedOutput()
      : client_(::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1)),
        memory_(::memfd_create("backbend-output", MFD_CLOEXEC)) {
    if (client_ < 0 || memory_ < 0 || ::dup2(memory_, STDOUT_FILENO) < 0)
      throw WriteError("standard output: cannot be kept for the protocol", errno);
  }
  ~CapturedOutput() {
    ::close(client_);
    ::close(memory_);
  }
  CapturedOutput(const CapturedOutput&) = delete;
  CapturedOutput& operator=(const CapturedOutput&) = delete;

  /// Lines to the client. False once it is gone.
  bool send(std::string_view lines) const {
    while (!lines.empty()) {
      const ssize_t sent = ::write(client_, lines.data(), lines.size());
      if (sent < 0 && errno == EINTR) continue;
      if (sent < 0) return false;
      lines.remove_prefix(static_cast<std::size_t>(sent));
    }
    return true;
  }

  /// Waits a while; whether the client has closed its end meanwhile.
  bool is_closed_after(int milliseconds) const {
    pollfd end{client_, 0, 0};
    return ::poll(&end, 1, milliseconds) > 0 && (end.revents & (POLLERR | POLLNVAL)) != 0;
  }

  /// What was printed since the last time.
  std::string take() const {
    std::fflush(stdout);
    const off_t size = ::lseek(memory_, 0, SEEK_END);
    std::string text(static_cast<std::size_t>(std::max<off_t>(size, 0)), '\0');
    std::size_t filled = 0;
    while (filled < text.size()) {
      const ssize_t got =
          ::pread(memory_, text.data() + filled, text.size() - filled, static_cast<off_t>(filled));
      if (got <= 0) throw ReadError("a command's output cannot be read back");
      filled += static_cast<std::size_t>(got);
    }
    if (::ftruncate(memory_, 0) != 0 || ::lseek(memory_, 0, SEEK_SET) != 0)
      throw WriteError("a command's output cannot be cleared", errno);
    return text;
  }

 private:
  int client_, memory_;
};

/// Runs one command line in this process. Throws what the command throws.
int run_words(std::vector<std::string> words) {
  Program program;
  std::reverse(words.begin(), words.end());  // the library takes them from the end
  program.app.parse(std::move(words));
  program.common.quiet = true;
  take_surroundings(program);
  return program.chosen();
}

ToolResult run_call(const ToolCall& call, const FileAccess& files, bool may_write,
                    const CapturedOutput& output) {
  const Tool& tool = *find_tool(call.tool);
  try {
    const int code = run_words(words_of(tool, call.arguments, files, may_write));
    const std::string printed = output.take();
    if (!tool.gives_picture) return json_result(printed, code);
    ToolResult result;
    result.png = printed;
    return result;
  } catch (const Interrupted&) {
    throw;
  } catch (const ArgumentError& error) {
    output.take();
    return trouble_result(error.what(), kExitUsage);
  } catch (const AccessError& error) {
    output.take();
    return trouble_result(error.what(), kExitUsage);
  } catch (...) {
    const Trouble trouble = trouble_of_exception();
    output.take();
    return trouble_result(trouble.line, trouble.code);
  }
}

/// One session: the calling thread reads, another one works, one call after the other.
class Server {
 public:
  Server(const FileAccess& files, bool may_write)
      : files_(files), may_write_(may_write), session_(descriptions(may_write), BACKBEND_VERSION) {
    worker_ = std::thread([this] { work(); });
  }
  ~Server() {
    {
      const std::lock_guard lock(mutex_);
      ends_ = true;
      waiting_.clear();
      set_superseded(true);  // nobody is left who wants the answer
    }
    changed_.notify_all();
    worker_.join();
    set_superseded(false);
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// Reads until the client closes its side, and ends when all that it asked for is answered, or
  /// when nobody is left to read the answers. Throws Interrupted where a signal came.
  void serve() {
    MessageLines lines(kMostMessageBytes);
    std::array<char, 65536> bytes{};
    for (;;) {
      pollfd input{STDIN_FILENO, POLLIN, 0};
      const int ready = ::poll(&input, 1, kWait_ms);
      if (interrupt_pending()) throw_interrupt();
      if (client_is_gone()) return;
      if (ready <= 0) continue;
      const ssize_t got = ::read(STDIN_FILENO, bytes.data(), bytes.size());
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return finish_calls();
      lines.add({bytes.data(), static_cast<std::size_t>(got)});
      while (const auto line = lines.next()) take(*line);
    }
  }

 private:
  static nlohmann::json descriptions(bool may_write) {
    nlohmann::json list = nlohmann::json::array();
    for (const Tool& tool : all_tools()) list.push_back(tool_description(tool, may_write));
    return list;
  }

  void finish_calls() {
    while (is_busy() && !client_is_gone() && !output_.is_closed_after(kWait_ms / 5))
      if (interrupt_pending()) throw_interrupt();
  }

  bool is_busy() {
    const std::lock_guard lock(mutex_);
    return running_ || !waiting_.empty();
  }

  /// The worker may have been told to stop for another reason first.
  static void throw_interrupt() {
    set_superseded(false);
    poll_interrupt();
  }

  bool client_is_gone() {
    const std::lock_guard lock(mutex_);
    return gone_;
  }

  void send(const std::string& lines) { gone_ |= !lines.empty() && !output_.send(lines); }

  void take(const MessageLines::Line& line) {
    const std::lock_guard lock(mutex_);
    McpSession::Step step = line.too_long ? session_.too_long() : session_.take(line.text);
    for (const std::string& each : step.send) send(each);
    if (step.start) waiting_.push_back(std::move(*step.start));
    if (step.cancel) give_up(*step.cancel);
    changed_.notify_all();
  }

  void give_up(const nlohmann::json& id) {
    if (running_ && running_->id == id) set_superseded(true);
    for (auto call = waiting_.begin(); call != waiting_.end(); ++call) {
      if (call->id != id) continue;
      session_.finish(*call, {});
      waiting_.erase(call);
      return;
    }
  }

  void work() {
    for (;;) {
      {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [this] { return ends_ || !waiting_.empty(); });
        if (ends_) return;
        running_ = std::move(waiting_.front());
        waiting_.pop_front();
        set_superseded(false);
      }
      report_progress();
      try {
        const ToolResult result = run_call(*running_, files_, may_write_, output_);
        listen_to_progress({});
        const std::lock_guard lock(mutex_);
        send(session_.finish(*running_, result));
        running_.reset();
      } catch (const Interrupted&) {
        return;  // the reader sees the signal, too
      }
    }
  }

  /// Stages follow one another, so each counts as one and its share.
  void report_progress() {
    listen_to_progress([this, stages = 0.0, last = std::string(), most = -1.0](
                           const std::string& stage, std::size_t done, std::size_t total) mutable {
      if (stage != last && !last.empty()) stages += 1.0;
      last = stage;
      const double share =
          total == 0 ? 0.0 : static_cast<double>(done) / static_cast<double>(total);
      const double progress = stages + std::min(share, 1.0);
      if (!(progress > most)) return;
      most = progress;
      const std::lock_guard lock(mutex_);
      send(session_.progress(
          *running_, progress,
          visible(stage) + " " + std::to_string(done) + " of " + std::to_string(total)));
    });
  }

  const FileAccess& files_;
  const bool may_write_;
  CapturedOutput output_;
  std::mutex mutex_;  // of all below
  std::condition_variable changed_;
  McpSession session_;
  std::deque<ToolCall> waiting_;
  std::optional<ToolCall> running_;  // set and cleared by the worker alone
  bool ends_ = false, gone_ = false;
  std::thread worker_;
};

int run_serve(const ServeOptions& options) {
  if (!options.stdio)
    throw CLI::RequiredError("--stdio, the only way that clients are served (no port is opened)");
  try {
    const FileAccess files(options.roots.empty()
                               ? std::vector<fs::path>{fs::current_path()}
                               : std::vector<fs::path>(options.roots.begin(), options.roots.end()));
    // Relative names of clients start there, and so do those in what they are told.
    fs::current_path(files.first());
    Server(files, options.allow_write).serve();
  } catch (const AccessError& error) {
    throw CLI::ValidationError(std::string("--root: ") + error.what());
  }
  return kExitOk;
}

}  // namespace

void add_serve(const Registry& registry) {
  auto options = std::make_shared<ServeOptions>();
  CLI::App* command = registry.add(
      "serve", "serve an agent or another program: commands as tools, Model Context Protocol",
      [options] { return run_serve(*options); });
  command->add_flag("--stdio", options->stdio,
                    "speak over standard input and output, a JSON-RPC message a line; opens no "
                    "port");
  command
      ->add_option("--root", options->roots,
                   "folder that clients may name files in; repeat for several [the working folder]")
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_flag("--allow-write", options->allow_write,
                    "let clients name outputs, which replace nothing; without it nothing is "
                    "written");
}

}  // namespace backbend::cli
