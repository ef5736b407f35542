#include "validate/watch/file_watch.h"

#include <poll.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <set>
#include <thread>

#include "validate/files/hash.h"
#include "validate/files/output_folder.h"
#include "validate/tasks/progress.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

/// A writer pauses for less than this between its steps.
constexpr milliseconds kQuiet{20};
/// A file that stays open, or is gone between two steps of a save, is waited for so long.
constexpr milliseconds kOpenAtMost{1000}, kGoneAtMost{300};
/// How often files are looked at where nobody tells of them, and where somebody does: a folder that
/// was replaced is told of by nobody.
constexpr milliseconds kPollEvery{500}, kLookEvery{2000};
/// A signal may have been taken by another thread.
constexpr milliseconds kStep{100};

/// What inotify knows of these is what this machine does to them. Numbers: linux/magic.h and the
/// file systems' own sources.
struct Remote {
  std::uint32_t type;
  const char* name;
};
constexpr std::array<Remote, 13> kRemote = {{{0x6969, "NFS"},
                                             {0x517b, "SMB"},
                                             {0xff534d42, "CIFS"},
                                             {0xfe534d42, "SMB"},
                                             {0x65735546, "FUSE"},
                                             {0x01021997, "9P"},
                                             {0x5346414f, "AFS"},
                                             {0x6b414653, "AFS"},
                                             {0x00c36400, "Ceph"},
                                             {0x73757245, "Coda"},
                                             {0x0bd00bd0, "Lustre"},
                                             {0x47504653, "GPFS"},
                                             {0x786f4256, "VirtualBox's shared folders"}}};

fs::path folder_of(const fs::path& file) {
  const fs::path folder = fs::absolute(file).parent_path();
  return folder.empty() ? fs::path("/") : folder;
}

std::int64_t nanoseconds(const timespec& time) {
  return static_cast<std::int64_t>(time.tv_sec) * 1'000'000'000 + time.tv_nsec;
}

}  // namespace

FileWatch::FileWatch(bool poll) : poll_(poll) {
  if (poll_) why_polled_ = "requested";
  if (poll_) return;
  descriptor_ = ::inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
  if (descriptor_ < 0)
    why_polled_ = std::string("the system does not tell of changes: ") + std::strerror(errno);
}

FileWatch::~FileWatch() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

FileWatch::Seen FileWatch::entry_of(const fs::path& file) {
  struct stat facts = {};
  Seen seen;
  if (::stat(file.c_str(), &facts) != 0) return seen;
  seen.is_there = true;
  seen.inode = facts.st_ino;
  seen.bytes = static_cast<std::uint64_t>(facts.st_size);
  seen.modified_ns = nanoseconds(facts.st_mtim);
  seen.changed_ns = nanoseconds(facts.st_ctim);
  return seen;
}

FileWatch::Seen FileWatch::content_of(const fs::path& file) {
  // Taken before the content: what is written meanwhile differs from it.
  Seen seen = entry_of(file);
  try {
    if (seen.is_there) seen.hash = content_hash(read_bytes(file));
  } catch (const ReadError&) {
    seen.hash = "unreadable";
  }
  return seen;
}

void FileWatch::watch_folders() {
  if (poll_) return;
  why_polled_.clear();
  std::set<fs::path> wanted;
  for (const auto& [file, seen] : files_) {
    wanted.insert(folder_of(file));
    std::error_code error;
    // What is saved through a link is written where that leads.
    if (fs::is_symlink(file, error)) {
      const fs::path target = fs::weakly_canonical(file, error);
      if (!error) wanted.insert(folder_of(target));
    }
  }
  for (auto it = folders_.begin(); it != folders_.end();) {
    if (wanted.contains(it->second)) {
      ++it;
      continue;
    }
    ::inotify_rm_watch(descriptor_, it->first);
    it = folders_.erase(it);
  }
  for (const fs::path& folder : wanted) {
    struct statfs facts = {};
    if (::statfs(folder.c_str(), &facts) != 0) continue;  // not there: looked at now and then
    const auto type = static_cast<std::uint32_t>(facts.f_type);
    const auto remote = std::ranges::find(kRemote, type, &Remote::type);
    if (remote != kRemote.end()) {
      why_polled_ = folder.string() + " is on " + remote->name;
      continue;
    }
    const int number =
        descriptor_ < 0 ? -1
                        : ::inotify_add_watch(descriptor_, folder.c_str(),
                                              IN_CREATE | IN_MODIFY | IN_CLOSE_WRITE | IN_ATTRIB |
                                                  IN_MOVED_TO | IN_MOVED_FROM | IN_DELETE |
                                                  IN_DELETE_SELF | IN_MOVE_SELF | IN_ONLYDIR);
    if (number < 0) {
      why_polled_ =
          "the system does not tell of changes in " + folder.string() + ": " + std::strerror(errno);
    } else {
      folders_[number] = folder;
    }
  }
}

void FileWatch::look_at(const std::vector<fs::path>& files) {
  std::map<fs::path, Seen> now;
  for (const fs::path& file : files) {
    const auto known = files_.find(file);
    now[file] = known == files_.end() ? content_of(file) : known->second;
  }
  files_ = std::move(now);
  watch_folders();
}

bool FileWatch::drain() {
  if (descriptor_ < 0) return false;
  alignas(inotify_event) char buffer[16384];
  bool any = false, folder_lost = false;
  for (;;) {
    const ssize_t bytes = ::read(descriptor_, buffer, sizeof buffer);
    if (bytes <= 0) break;
    for (ssize_t at = 0; at < bytes;) {
      const auto& event = *reinterpret_cast<const inotify_event*>(buffer + at);
      at += static_cast<ssize_t>(sizeof event + event.len);
      any = true;
      if (event.mask & (IN_IGNORED | IN_DELETE_SELF | IN_MOVE_SELF)) {
        folders_.erase(event.wd);
        folder_lost = true;
      }
      if (event.len == 0) continue;
      const std::string name(event.name);
      const bool watched = std::ranges::any_of(
          files_, [&](const auto& each) { return each.first.filename() == name; });
      if (!watched) continue;
      if (event.mask & IN_MODIFY) half_written_[name] = true;
      if (event.mask & (IN_CLOSE_WRITE | IN_MOVED_TO | IN_MOVED_FROM | IN_DELETE))
        half_written_.erase(name);
    }
  }
  if (folder_lost) watch_folders();
  return any;
}

bool FileWatch::entries_changed() const {
  return std::ranges::any_of(
      files_, [](const auto& each) { return !each.second.same_entry(entry_of(each.first)); });
}

std::vector<fs::path> FileWatch::take_changes() {
  std::vector<fs::path> changed;
  for (auto& [file, seen] : files_) {
    if (seen.same_entry(entry_of(file))) continue;
    Seen now = content_of(file);
    if (now.is_there != seen.is_there || now.hash != seen.hash) changed.push_back(file);
    seen = std::move(now);
  }
  return changed;
}

std::vector<fs::path> FileWatch::wait(milliseconds most) {
  const auto end = Clock::now() + most;
  auto looked = Clock::now() - kLookEvery;
  for (;;) {
    poll_interrupt();
    bool touched = drain();
    const milliseconds every = why_polled_.empty() ? kLookEvery : kPollEvery;
    if (Clock::now() - looked >= every) {
      looked = Clock::now();
      if (folders_.empty()) watch_folders();
      touched = true;
    }
    if (touched && entries_changed()) {
      // Until the writer is done.
      const auto began = Clock::now();
      auto last = began;
      for (;;) {
        poll_interrupt();
        const bool gone = std::ranges::any_of(files_, [](const auto& each) {
          return each.second.is_there && !entry_of(each.first).is_there;
        });
        std::map<fs::path, Seen> before;
        for (const auto& [file, seen] : files_) before[file] = entry_of(file);
        std::this_thread::sleep_for(kQuiet);
        const bool moved = std::ranges::any_of(
            before, [](const auto& each) { return !each.second.same_entry(entry_of(each.first)); });
        if (drain() || moved) last = Clock::now();
        const auto quiet = Clock::now() - last;
        const milliseconds needed = !half_written_.empty() ? kOpenAtMost
                                    : gone                 ? kGoneAtMost
                                                           : kQuiet / 2;
        if (quiet >= needed) break;
      }
      half_written_.clear();
      watch_folders();
      noticed_ = began;
      if (std::vector<fs::path> changed = take_changes(); !changed.empty()) return changed;
    }
    const auto now = Clock::now();
    if (now >= end) return {};
    const auto left = std::chrono::duration_cast<milliseconds>(end - now) + milliseconds(1);
    const auto step = std::min(left, why_polled_.empty() ? kStep : std::min(kStep, kPollEvery));
    pollfd news = {descriptor_, POLLIN, 0};
    // Ends early for a signal, too.
    ::poll(&news, descriptor_ < 0 ? 0 : 1, static_cast<int>(step.count()));
  }
}

}  // namespace backbend::validate
