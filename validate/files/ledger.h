#pragma once
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace backbend::validate {

/// Parts of a job that are missing where all are needed, or that belong to another job. what() is
/// the whole line.
struct IncompleteError : std::runtime_error {
  using std::runtime_error::runtime_error;
};
struct MixedPartsError : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// Another process works on the folder: try again later.
struct BusyError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// One of `count` equal shares of a job; `index` counts from 1.
struct Shard {
  int index = 1, count = 1;
  bool owns(std::size_t item) const {
    return item % static_cast<std::size_t>(count) == static_cast<std::size_t>(index - 1);
  }
};

/// Reads `3/8`, or `auto`: the share of a Slurm array task, from its environment. Throws
/// std::invalid_argument saying what was expected.
Shard parse_shard(std::string_view text);

/// A lock on a run folder: shared by the shards of one job, exclusive for everything else. Released
/// when destroyed or when the process dies. Throws BusyError.
class FolderLock {
 public:
  enum class Kind { shared, exclusive };
  FolderLock(const std::filesystem::path& folder, Kind kind);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_ = -1;
};

/// The finished parts of a job, in the run folder under `parts/`, so that a job can be divided into
/// shards, merged, and resumed.
///
/// A part holds the result of one unit of work, which depends on nothing but the job's inputs: the
/// stamp of those inputs, the unit's name, its result and the hashes of files that it made. A part
/// counts only if its own hash, its stamp and every file that it lists are right; anything else
/// counts as missing. Parts are written atomically; writing one twice is harmless.
class Ledger {
 public:
  enum class Mode {
    off,    // stores nothing, computes everything
    alone,  // computes everything that is missing
    shard,  // computes its share, and what it needs of the others'
    merge   // computes nothing: reports what is missing
  };
  using Bytes = std::vector<std::uint8_t>;

  Ledger() = default;
  /// `take_up`: parts that are there already count.
  Ledger(std::filesystem::path folder, std::string stamp, Mode mode, Shard shard, bool take_up);

  Mode mode() const { return mode_; }
  bool is_on() const { return mode_ != Mode::off; }
  /// True if this process computes the item.
  bool makes(std::size_t item) const {
    return mode_ == Mode::off || mode_ == Mode::alone ||
           (mode_ == Mode::shard && shard_.owns(item));
  }
  /// Whether the report is put together here.
  bool assembles() const { return mode_ != Mode::shard; }

  /// The result of a unit that is finished, all its files verified.
  std::optional<Bytes> find(const std::string& unit) const;
  /// Keeps a result and the names, relative to the run folder, of files that were written for it.
  /// Throws WriteError.
  void keep(const std::string& unit, std::span<const std::uint8_t> result,
            const std::vector<std::string>& files = {}) const;
  /// Records a missing unit.
  void miss(const std::string& unit);
  std::vector<std::string> missing() const;

  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
  std::string stamp_;
  Mode mode_ = Mode::off;
  Shard shard_;
  bool take_up_ = false;
  mutable std::mutex mutex_;
  std::vector<std::string> missing_;
};

/// Where parts are, below a run folder, and what they are parts of.
inline constexpr std::string_view kPartsFolder = "parts";
inline constexpr std::string_view kPlanFile = "parts/plan.json";

/// Copies every part of `from` that is whole, with its files, into `to`; returns how many parts
/// came. Throws MixedPartsError naming the first part of another job, WriteError.
std::size_t gather_parts(const std::filesystem::path& from, const std::filesystem::path& to,
                         const std::string& stamp);

/// Removes the parts of a job that is done, and nothing else.
void remove_parts(const std::filesystem::path& folder);

}  // namespace backbend::validate
