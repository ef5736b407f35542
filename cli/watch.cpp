#include "cli/watch.h"

#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <set>
#include <thread>

#include "cli/program.h"
#include "cli/trouble.h"
#include "validate/files/folder_trace.h"
#include "validate/files/ledger.h"
#include "validate/files/output_folder.h"
#include "validate/model/report_json.h"
#include "validate/night/run.h"
#include "validate/tasks/superseded.h"
#include "validate/text/escape.h"
#include "validate/text/number_text.h"
#include "validate/watch/file_watch.h"
#include "validate/watch/save_changes.h"

namespace backbend::cli {
namespace {

namespace fs = std::filesystem;
using namespace backbend::validate;
using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

/// What a writer leaves unreadable for longer than this is a fault of the file, not a step of a
/// save.
constexpr milliseconds kSecondStep{400};
/// One long wait; the loop goes on with the next.
constexpr milliseconds kLong{3'600'000};
/// The folders below a run's that hold its pictures.
constexpr const char* kPictureFolders[] = {"findings", "frames", "media", "meshes", "review"};

struct CommandLine {
  int count = 0;
  char** arguments = nullptr;
};
CommandLine& command_line() {
  static CommandLine line;
  return line;
}

/// Where a command that is parsed while another one watches leaves what it would do.
std::optional<WatchedRun>*& offer() {
  static std::optional<WatchedRun>* place = nullptr;
  return place;
}

/// The run that the same command line means now, with the options of the project as it is now.
class NextRun {
 public:
  NextRun() { offer() = &offered_; }
  ~NextRun() { offer() = nullptr; }
  NextRun(const NextRun&) = delete;
  NextRun& operator=(const NextRun&) = delete;

  WatchedRun make() {
    auto program = std::make_unique<Program>();
    program->app.parse(command_line().count, command_line().arguments);
    program->common.quiet = true;  // what options depend on has been said once
    const fs::path project = take_surroundings(*program);
    offered_.reset();
    program->chosen();
    program_ = std::move(program);
    WatchedRun run = std::move(offered_.value());
    if (!project.empty()) run.inputs.push_back(project);
    return run;
  }

 private:
  std::unique_ptr<Program> program_;
  std::optional<WatchedRun> offered_;
};

std::set<fs::path> picture_files(const fs::path& folder) {
  std::set<fs::path> files;
  std::error_code none;
  for (const char* name : kPictureFolders)
    for (fs::recursive_directory_iterator each(folder / name, none), end; !none && each != end;
         each.increment(none))
      if (each->is_regular_file(none)) files.insert(each->path());
  return files;
}

/// Where results of the watch go.
class Screen {
 public:
  Screen(const Common& common, const fs::path& folder)
      : json_(common.json), style_(style_of_stdout()), folder_(folder) {
    const char* terminal = std::getenv("TERM");
    redraws_ = !json_ && ::isatty(STDOUT_FILENO) == 1 && terminal != nullptr &&
               std::strcmp(terminal, "dumb") != 0;
    if (::isatty(STDOUT_FILENO) != 1) style_.width = 160;  // a line of a log may be long
  }

  bool redraws() const { return redraws_; }

  void show(const SaveView& view) {
    if (json_) {
      print(report_json_compact(view.complete != nullptr ? *view.complete : *view.now) + "\n");
    } else if (view.complete != nullptr && !redraws_) {
      print("pictures of save " + std::to_string(view.save) + ": " +
            visible((folder_ / "index.html").string()) + "\n");
    } else {
      print((redraws_ ? "\x1b[H\x1b[2J" : view.save > 1 ? "\n" : "") + save_text(view, style_));
    }
  }

  void show_trouble(const Trouble& trouble, const std::string& watching) {
    if (redraws_)
      print("\x1b[H\x1b[2Jcannot be judged: " + visible(trouble.line) + "\n" + visible(watching) +
            "\n");
    else
      std::fprintf(stderr, "backbend: %s\n", visible(trouble.line).c_str());
  }

 private:
  static void print(const std::string& text) {
    // Whoever read it may be gone, and then nobody is served.
    if (std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0)
      throw WriteError(std::string("standard output: ") + std::strerror(errno), errno);
  }

  bool json_ = false, redraws_ = false;
  TerminalStyle style_;
  fs::path folder_;
};

std::string names_of(const std::vector<fs::path>& files) {
  std::string names;
  std::error_code none;
  for (const fs::path& file : files) {
    names += (names.empty() ? "" : ", ") + file.filename().string();
    if (!fs::exists(file, none)) names += " (gone)";
  }
  return names;
}

std::string watching_text(const FileWatch& files, std::size_t count) {
  const std::string how = std::to_string(count) + (count == 1 ? " file" : " files");
  return files.why_polled().empty()
             ? "watching " + how + "; Ctrl-C ends"
             : "looking at " + how + " twice a second (" + files.why_polled() + "); Ctrl-C ends";
}

/// Tells poll_interrupt() when an input changes while pictures are made.
class Superseding {
 public:
  explicit Superseding(FileWatch& files)
      : thread_([this, &files] {
          try {
            while (!done_ && changed_.empty()) changed_ = files.wait(milliseconds(100));
          } catch (const Interrupted&) {
            return;  // the other thread is told, too
          } catch (const Superseded&) {
            return;
          }
          if (!changed_.empty()) set_superseded(true);
        }) {}
  ~Superseding() { end(); }
  Superseding(const Superseding&) = delete;
  Superseding& operator=(const Superseding&) = delete;

  /// What has changed until now; nothing is watched from then on.
  std::vector<fs::path> end() {
    done_ = true;
    if (thread_.joinable()) thread_.join();
    set_superseded(false);
    return changed_;
  }

 private:
  std::atomic<bool> done_ = false;
  std::vector<fs::path> changed_;
  std::thread thread_;
};

/// One `check --watch` from its first run to the signal that ends it.
class Watching {
 public:
  Watching(WatchedRun run, const Common& common)
      : run_(std::move(run)),
        common_(common),
        names_folder_(!run_.output.empty()),
        folder_(new_run_folder(run_.output)),
        files_(run_.poll),
        screen_(common, folder_) {}

  [[noreturn]] void go() {
    const FolderTrace trace(folder_);
    OutputFolder(folder_).prepare();
    const FolderLock lock(folder_, FolderLock::Kind::exclusive);
    others_ = picture_files(folder_);
    run_ = next_.make();  // knows the project
    files_.look_at(run_.inputs);
    std::vector<fs::path> changed;
    for (;;) {
      changed = once(names_of(changed));
      while (changed.empty()) changed = files_.wait(kLong);
      since_ = files_.noticed();
    }
  }

 private:
  /// One run; returns what has changed meanwhile.
  std::vector<fs::path> once(const std::string& changed) {
    try {
      if (saves_ > 0) run_ = next_.make();
      files_.look_at(run_.inputs);
      Progress silent(Progress::Style::none);
      Report now = run_.judge(folder_, false, known_jumps_, silent);
      ++saves_;
      known_jumps_->forget_unused();
      before_ = std::move(now_);
      now_ = std::move(now);
    } catch (const WriteError&) {
      throw;
    } catch (...) {
      const Trouble trouble = trouble_of_exception();
      if (saves_ == 0 || (trouble.code != kExitBadInput && trouble.code != kExitUsage &&
                          trouble.code != kExitNoBaseline))
        throw;
      // It may be half of a save.
      std::vector<fs::path> more = files_.wait(kSecondStep);
      if (more.empty()) screen_.show_trouble(trouble, watching_text(files_, run_.inputs.size()));
      return more;
    }
    return finish(changed);
  }

  std::vector<fs::path> finish(const std::string& changed) {
    SaveView view;
    view.now = &*now_;
    view.before = before_ ? &*before_ : nullptr;
    view.save = saves_;
    view.changed = changed;
    view.seconds = fixed(std::chrono::duration<double>(Clock::now() - since_).count(), 2);
    view.pictures = run_.pictures ? "pictures follow" : "";
    view.watching = watching_text(files_, run_.inputs.size());
    screen_.show(view);
    if (!run_.pictures) {
      write(*now_);
      return {};
    }
    Superseding superseding(files_);
    std::optional<Report> complete;
    try {
      clear_pictures();
      Progress progress(common_.progress_style());
      complete = run_.judge(folder_, true, known_jumps_, progress);
      progress.finish();
      write(*complete);
    } catch (const Superseded&) {
      return superseding.end();
    }
    std::vector<fs::path> more = superseding.end();
    view.complete = &*complete;
    view.pictures = "page  " + (folder_ / "index.html").string();
    if (more.empty()) screen_.show(view);
    return more;
  }

  void write(const Report& report) const {
    write_report(report, folder_, {{}, run_.single_file});
    if (!names_folder_) point_link(folder_.parent_path() / "latest", folder_.filename());
  }

  /// Those of the saves before, which the next report knows nothing of.
  void clear_pictures() const {
    std::error_code none;
    for (const fs::path& file : picture_files(folder_))
      if (!others_.contains(file)) fs::remove(file, none);
  }

  WatchedRun run_;
  const Common& common_;
  bool names_folder_;
  fs::path folder_;
  FileWatch files_;
  Screen screen_;
  NextRun next_;
  std::shared_ptr<KnownJumps> known_jumps_ = std::make_shared<KnownJumps>();
  std::set<fs::path> others_;  // pictures that stood in the folder before
  std::optional<Report> before_, now_;
  int saves_ = 0;
  Clock::time_point since_ = Clock::now();
};

}  // namespace

void remember_command_line(int count, char** arguments) { command_line() = {count, arguments}; }

int watch(WatchedRun run, const Common& common) {
  if (offer() != nullptr) {
    *offer() = std::move(run);
    return kExitOk;
  }
  Watching(std::move(run), common).go();
}

}  // namespace backbend::cli
