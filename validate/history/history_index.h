#pragma once
#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "validate/history/history.h"

struct sqlite3;

namespace backbend::validate {

/// An SQLite index of a history: what is asked of years of nights is answered without reading them
/// all. The history's own lines stay the truth, and this a cache of them that may be deleted at any
/// time: it is kept beside the history as `history.jsonl.index`, grows with it, and is rebuilt
/// where it is absent, damaged, of another version, or of other lines than the history has now.
/// Where it cannot be kept (a read-only folder, a busy one) it lives in memory.
class HistoryIndex {
 public:
  /// Brings the index up to date. Throws HistoryError for a damaged line, as parse_history() does;
  /// ReadError.
  explicit HistoryIndex(const std::filesystem::path& history);
  ~HistoryIndex();
  HistoryIndex(const HistoryIndex&) = delete;
  HistoryIndex& operator=(const HistoryIndex&) = delete;

  static std::filesystem::path path_for(const std::filesystem::path& history);

  std::size_t night_count() const;
  /// How many lines of the history had to be read as JSON to get here: 0 where nothing was new.
  std::size_t lines_read() const { return lines_read_; }
  /// The suite of the last night; empty where there is none.
  std::string last_suite() const;
  /// Of all nights whose results are known: the hash of the report -> that of its results.
  std::map<std::string, std::string> results() const;
  /// Names of all characters that any night looked at, sorted.
  std::vector<std::string> characters() const;

  /// Which values to give; empty: all of them.
  struct Wanted {
    std::string character, rig, metric;
  };
  /// The last nights of a suite, oldest first, whole but for the values that are not wanted.
  std::vector<Night> last_nights(const std::string& suite, std::size_t most,
                                 const Wanted& wanted) const;
  /// All nights that looked at the character, oldest first, with their versions, and of their
  /// failures those of that character and check; without values. What first_bad() needs.
  std::vector<Night> nights_of(const std::string& character, const std::string& code) const;

 private:
  void open(const std::string& file, const std::string& text, const std::string& name);
  void fill(const std::string& text, const std::string& name);

  sqlite3* database_ = nullptr;
  std::size_t lines_read_ = 0;
};

}  // namespace backbend::validate
