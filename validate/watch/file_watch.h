#pragma once
#include <chrono>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace backbend::validate {

/// Tells when what some files hold changes.
///
/// The system tells of changes in the files' folders (inotify); where it cannot, or not reliably (a
/// file system of another machine, or of another program), the files are looked at twice a second
/// instead. What counts is content: a file that is saved as it was has not changed, one that is
/// deleted or renamed has, and so has one that appears. Changes are told when the writer is done:
/// nothing has been written for a moment and no file is open half-written. One thread at a time.
class FileWatch {
 public:
  /// `poll`: looks at the files even where the system would tell.
  explicit FileWatch(bool poll = false);
  ~FileWatch();
  FileWatch(const FileWatch&) = delete;
  FileWatch& operator=(const FileWatch&) = delete;

  /// The files to watch from now on, there or not. Changes are told against what they hold now, or
  /// for files that were watched already against what was last told of them.
  void look_at(const std::vector<std::filesystem::path>& files);

  /// Waits at most so long; returns the files that changed since they were looked at or told of,
  /// none where the time was over first. Throws Interrupted.
  std::vector<std::filesystem::path> wait(std::chrono::milliseconds most);

  /// When the change that wait() returned last was first noticed.
  std::chrono::steady_clock::time_point noticed() const { return noticed_; }

  /// Why the files are looked at instead of told of; empty where they are told of.
  const std::string& why_polled() const { return why_polled_; }

 private:
  struct Seen {
    bool is_there = false;
    std::uint64_t inode = 0, bytes = 0;
    std::int64_t modified_ns = 0, changed_ns = 0;
    std::string hash;  // of what it holds
    bool same_entry(const Seen& other) const {
      return is_there == other.is_there && inode == other.inode && bytes == other.bytes &&
             modified_ns == other.modified_ns && changed_ns == other.changed_ns;
    }
  };
  static Seen entry_of(const std::filesystem::path& file);
  static Seen content_of(const std::filesystem::path& file);

  void watch_folders();
  bool drain();                  // the system's news; true if there was any
  bool entries_changed() const;  // by what the file system says, without reading
  std::vector<std::filesystem::path> take_changes();

  std::map<std::filesystem::path, Seen> files_;
  std::map<int, std::filesystem::path> folders_;  // by inotify's number
  std::map<std::string, bool> half_written_;      // names that were written to and not closed
  int descriptor_ = -1;
  bool poll_ = false;
  std::string why_polled_;
  std::chrono::steady_clock::time_point noticed_;
};

}  // namespace backbend::validate
