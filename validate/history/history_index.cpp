#include "validate/history/history_index.h"

#include <sqlite3.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <span>
#include <string_view>
#include <system_error>
#include <tuple>

#include "validate/files/hash.h"
#include "validate/files/output_folder.h"
#include "validate/verdicts/names.h"

namespace backbend::validate {
namespace {

/// Counted up whenever the tables or what is in them change: another version's index is none.
constexpr int kVersion = 3;
/// How long another process may take to bring the same index up to date.
constexpr int kBusy_ms = 2000;

constexpr const char* kTables = R"(
CREATE TABLE source(bytes INTEGER NOT NULL, hash TEXT NOT NULL);
CREATE TABLE night(id INTEGER PRIMARY KEY, date TEXT NOT NULL, label TEXT NOT NULL,
  suite TEXT NOT NULL, report TEXT NOT NULL, verdict TEXT NOT NULL, results TEXT NOT NULL);
CREATE INDEX night_suite ON night(suite, id);
CREATE TABLE version(night INTEGER NOT NULL, character TEXT NOT NULL, hash TEXT NOT NULL);
CREATE INDEX version_night ON version(night);
CREATE INDEX version_character ON version(character, night);
CREATE TABLE metric(id INTEGER PRIMARY KEY, name TEXT NOT NULL, unit TEXT NOT NULL,
  more INTEGER NOT NULL);
CREATE TABLE measured(night INTEGER NOT NULL, place INTEGER NOT NULL, character TEXT NOT NULL,
  rig TEXT NOT NULL, mapping TEXT NOT NULL, value BLOB NOT NULL,
  PRIMARY KEY(night, place)) WITHOUT ROWID;
CREATE INDEX measured_character ON measured(character, night);
CREATE TABLE failure(night INTEGER NOT NULL, character TEXT NOT NULL, rig TEXT NOT NULL,
  mapping TEXT NOT NULL, code TEXT NOT NULL, pose TEXT NOT NULL, value REAL);
CREATE INDEX failure_night ON failure(night);
)";

/// SQLite failed: the index is then rebuilt.
struct IndexTrouble : HistoryError {
  explicit IndexTrouble(sqlite3* database)
      : HistoryError(std::string("the history's index: ") + sqlite3_errmsg(database)),
        busy(sqlite3_errcode(database) == SQLITE_BUSY) {}
  explicit IndexTrouble(const char* what) : HistoryError(what) {}
  bool busy = false;  // another process brings it up to date: it is not damaged
};

/// A number in the values of one row of `measured`: this machine's bytes, for the index is its own.
struct IndexedValue {
  std::int64_t metric;
  double value;  // NaN: not measured
};

/// One prepared statement.
class Statement {
 public:
  Statement(sqlite3* database, const char* sql) : database_(database) {
    check(sqlite3_prepare_v2(database, sql, -1, &statement_, nullptr));
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& with(std::string_view text) {
    check(sqlite3_bind_text64(statement_, ++bound_, text.data(), text.size(), SQLITE_TRANSIENT,
                              SQLITE_UTF8));
    return *this;
  }
  Statement& with(std::int64_t number) {
    check(sqlite3_bind_int64(statement_, ++bound_, number));
    return *this;
  }
  /// NaN is null.
  Statement& with(double number) {
    ++bound_;
    check(std::isfinite(number) ? sqlite3_bind_double(statement_, bound_, number)
                                : sqlite3_bind_null(statement_, bound_));
    return *this;
  }
  Statement& with(std::span<const IndexedValue> values) {
    check(sqlite3_bind_blob64(statement_, ++bound_, values.data(), values.size_bytes(),
                              SQLITE_TRANSIENT));
    return *this;
  }
  /// The next row; false after the last.
  bool step() {
    const int result = sqlite3_step(statement_);
    if (result != SQLITE_ROW && result != SQLITE_DONE) check(result);
    return result == SQLITE_ROW;
  }
  /// Does it for the values that are bound, and is ready for the next ones.
  void run() {
    step();
    check(sqlite3_reset(statement_));
    bound_ = 0;
  }
  std::string text(int column) {
    const void* const bytes = sqlite3_column_text(statement_, column);
    const int size = sqlite3_column_bytes(statement_, column);
    return bytes == nullptr
               ? ""
               : std::string(static_cast<const char*>(bytes), static_cast<std::size_t>(size));
  }
  std::vector<IndexedValue> values(int column) {
    const void* const bytes = sqlite3_column_blob(statement_, column);
    const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
    std::vector<IndexedValue> out(size / sizeof(IndexedValue));
    if (!out.empty()) std::memcpy(out.data(), bytes, out.size() * sizeof(IndexedValue));
    return out;
  }
  std::int64_t whole(int column) { return sqlite3_column_int64(statement_, column); }
  double number(int column) {
    return sqlite3_column_type(statement_, column) == SQLITE_NULL
               ? std::numeric_limits<double>::quiet_NaN()
               : sqlite3_column_double(statement_, column);
  }

 private:
  void check(int result) const {
    if (result != SQLITE_OK) throw IndexTrouble(database_);
  }

  sqlite3* database_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
};

void execute(sqlite3* database, const char* sql) {
  if (sqlite3_exec(database, sql, nullptr, nullptr, nullptr) != SQLITE_OK)
    throw IndexTrouble(database);
}

/// How many bytes of the history the index holds, where they are still what it was made from.
std::size_t bytes_indexed(sqlite3* database, std::string_view text) {
  Statement version(database, "PRAGMA user_version");
  if (!version.step() || version.whole(0) != kVersion) return 0;
  Statement source(database, "SELECT bytes, hash FROM source");
  if (!source.step()) return 0;
  const auto bytes = static_cast<std::size_t>(source.whole(0));
  if (bytes > text.size() || content_hash(text.substr(0, bytes)) != source.text(1)) return 0;
  return bytes;
}

/// Everything that was there goes; the tables are as new.
void start_anew(sqlite3* database) {
  for (const char* table : {"source", "night", "version", "metric", "measured", "failure"})
    execute(database, ("DROP TABLE IF EXISTS " + std::string(table)).c_str());
  execute(database, kTables);
  execute(database, ("PRAGMA user_version = " + std::to_string(kVersion)).c_str());
}

void add_nights(sqlite3* database, const std::vector<Night>& nights) {
  Statement last(database, "SELECT coalesce(max(id), 0) FROM night");
  last.step();
  std::int64_t id = last.whole(0);
  Statement night(database, "INSERT INTO night VALUES (?, ?, ?, ?, ?, ?, ?)");
  Statement version(database, "INSERT INTO version VALUES (?, ?, ?)");
  std::map<std::tuple<std::string, std::string, bool>, std::int64_t> metrics;
  Statement known(database, "SELECT name, unit, more, id FROM metric");
  while (known.step())
    metrics[{known.text(0), known.text(1), known.whole(2) != 0}] = known.whole(3);
  Statement metric(database, "INSERT INTO metric VALUES (?, ?, ?, ?)");
  Statement measured(database, "INSERT INTO measured VALUES (?, ?, ?, ?, ?, ?)");
  Statement failure(database, "INSERT INTO failure VALUES (?, ?, ?, ?, ?, ?, ?)");
  for (const Night& each : nights) {
    night.with(++id).with(each.date).with(each.label).with(each.suite).with(each.report);
    night.with(verdict_word(each.verdict)).with(each.results).run();
    for (const auto& [character, hash] : each.version)
      version.with(id).with(character).with(hash).run();
    std::int64_t place = 0;
    for (auto first = each.values.begin(); first != each.values.end();) {
      const NightValue& row = *first;
      std::vector<IndexedValue> values;
      for (; first != each.values.end() && std::tie(first->character, first->rig, first->mapping) ==
                                               std::tie(row.character, row.rig, row.mapping);
           ++first) {
        const auto [found, is_new] = metrics.try_emplace(
            {first->metric, first->unit, first->more_is_worse}, metrics.size() + 1);
        if (is_new)
          metric.with(found->second)
              .with(first->metric)
              .with(first->unit)
              .with(std::int64_t{first->more_is_worse})
              .run();
        values.push_back({found->second, first->value});
      }
      measured.with(id).with(++place).with(row.character).with(row.rig).with(row.mapping);
      measured.with(values).run();
    }
    for (const NightFailure& f : each.failures) {
      failure.with(id).with(f.character).with(f.rig).with(f.mapping).with(f.code).with(f.pose);
      failure.with(f.value).run();
    }
  }
}

/// The head of a night and its versions, from a row as kHead selects it.
Night night_at(sqlite3* database, Statement& row) {
  Night night;
  night.date = row.text(1);
  night.label = row.text(2);
  night.suite = row.text(3);
  night.report = row.text(4);
  night.verdict = verdict_from_word(row.text(5)).value_or(Verdict::not_measured);
  night.results = row.text(6);
  Statement version(database, "SELECT character, hash FROM version WHERE night = ?");
  version.with(row.whole(0));
  while (version.step()) night.version[version.text(0)] = version.text(1);
  return night;
}

constexpr const char* kHead = "SELECT id, date, label, suite, report, verdict, results FROM night ";

}  // namespace

std::filesystem::path HistoryIndex::path_for(const std::filesystem::path& history) {
  return history.string() + ".index";
}

HistoryIndex::HistoryIndex(const std::filesystem::path& history) {
  namespace fs = std::filesystem;
  std::error_code none;
  const std::string text = fs::exists(history, none) ? read_text(history) : "";
  const std::string name = history.string();
  const fs::path file = path_for(history);
  const fs::file_type there = fs::symlink_status(file, none).type();
  // A link planted under the index's name is replaced, never followed; what is no file stays.
  if (there == fs::file_type::symlink) fs::remove(file, none);
  const bool keeps =
      !text.empty() && (there == fs::file_type::not_found || there == fs::file_type::regular ||
                        there == fs::file_type::symlink);
  for (int attempt = 0; keeps && attempt < 2; ++attempt) {
    try {
      open(file.string(), text, name);
      return;
    } catch (const IndexTrouble& trouble) {
      if (trouble.busy) break;
      fs::remove(file, none);
      fs::remove(file.string() + "-journal", none);
    }
  }
  open(":memory:", text, name);
}

HistoryIndex::~HistoryIndex() { sqlite3_close(database_); }

void HistoryIndex::open(const std::string& file, const std::string& text, const std::string& name) {
  sqlite3_close(database_);
  database_ = nullptr;
  lines_read_ = 0;
  try {
    const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
    if (sqlite3_open_v2(file.c_str(), &database_, flags, nullptr) != SQLITE_OK)
      throw IndexTrouble(database_);
    sqlite3_busy_timeout(database_, kBusy_ms);
    execute(database_, "BEGIN IMMEDIATE");
    fill(text, name);
    execute(database_, "COMMIT");
  } catch (...) {
    // What was begun is not kept.
    sqlite3_close(database_);
    database_ = nullptr;
    throw;
  }
}

void HistoryIndex::fill(const std::string& text, const std::string& name) {
  Statement sound(database_, "PRAGMA quick_check(1)");
  if (!sound.step() || sound.text(0) != "ok") throw IndexTrouble("the index is damaged");
  std::size_t from = bytes_indexed(database_, text);
  if (from == text.size() && from > 0) return;
  if (from == 0) start_anew(database_);
  std::vector<Night> added;
  try {
    added = parse_history(std::string_view(text).substr(from), name);
  } catch (const HistoryError&) {
    if (from == 0) throw;
    parse_history(text, name);  // says the line as it is counted in the whole file
    throw;
  }
  lines_read_ = added.size();
  add_nights(database_, added);
  execute(database_, "DELETE FROM source");
  Statement(database_, "INSERT INTO source VALUES (?, ?)")
      .with(static_cast<std::int64_t>(text.size()))
      .with(content_hash(text))
      .run();
}

std::size_t HistoryIndex::night_count() const {
  Statement row(database_, "SELECT count(*) FROM night");
  row.step();
  return static_cast<std::size_t>(row.whole(0));
}

std::string HistoryIndex::last_suite() const {
  Statement row(database_, "SELECT suite FROM night ORDER BY id DESC LIMIT 1");
  return row.step() ? row.text(0) : "";
}

std::map<std::string, std::string> HistoryIndex::results() const {
  std::map<std::string, std::string> hashes;
  Statement row(database_, "SELECT report, results FROM night WHERE results != ''");
  while (row.step()) hashes[row.text(0)] = row.text(1);
  return hashes;
}

std::vector<std::string> HistoryIndex::characters() const {
  std::vector<std::string> names;
  Statement row(database_, "SELECT DISTINCT character FROM version ORDER BY character");
  while (row.step()) names.push_back(row.text(0));
  return names;
}

std::vector<Night> HistoryIndex::last_nights(const std::string& suite, std::size_t most,
                                             const Wanted& wanted) const {
  struct Named {
    std::string name, unit;
    bool more_is_worse;
  };
  std::map<std::int64_t, Named> metrics;
  Statement metric(database_, "SELECT id, name, unit, more FROM metric WHERE ? IN ('', name)");
  metric.with(wanted.metric);
  while (metric.step())
    metrics[metric.whole(0)] = {metric.text(1), metric.text(2), metric.whole(3) != 0};
  const std::string measured =
      "SELECT character, rig, mapping, value FROM measured WHERE night = ?1 AND " +
      std::string(wanted.character.empty() ? "?2 = ''" : "character = ?2") +
      " AND ?3 IN ('', rig) ORDER BY place";
  Statement row(database_, ("SELECT * FROM (" + std::string(kHead) +
                            "WHERE suite = ? ORDER BY id DESC LIMIT ?) ORDER BY id")
                               .c_str());
  row.with(suite).with(static_cast<std::int64_t>(most));
  std::vector<Night> nights;
  while (row.step()) {
    nights.push_back(night_at(database_, row));
    Night& night = nights.back();
    Statement values(database_, measured.c_str());
    values.with(row.whole(0)).with(wanted.character).with(wanted.rig);
    while (values.step()) {
      for (const IndexedValue& each : values.values(3)) {
        const auto found = metrics.find(each.metric);
        if (found == metrics.end()) continue;
        const auto& [name, unit, more_is_worse] = found->second;
        night.values.push_back({values.text(0), values.text(1), values.text(2), name, unit,
                                more_is_worse, each.value});
      }
    }
    Statement failure(database_,
                      "SELECT character, rig, mapping, code, pose, value FROM failure WHERE night "
                      "= ? ORDER BY rowid");
    failure.with(row.whole(0));
    while (failure.step()) {
      night.failures.push_back({failure.text(0), failure.text(1), failure.text(2), failure.text(3),
                                failure.text(4), failure.number(5)});
    }
  }
  return nights;
}

std::vector<Night> HistoryIndex::nights_of(const std::string& character,
                                           const std::string& code) const {
  Statement row(database_,
                (std::string(kHead) +
                 "WHERE id IN (SELECT night FROM version WHERE character = ?) ORDER BY id")
                    .c_str());
  row.with(character);
  std::vector<Night> nights;
  while (row.step()) {
    nights.push_back(night_at(database_, row));
    Statement failure(database_,
                      "SELECT rig, mapping, pose, value FROM failure WHERE night = ? AND character "
                      "= ? AND code = ? ORDER BY rowid");
    failure.with(row.whole(0)).with(character).with(code);
    while (failure.step()) {
      nights.back().failures.push_back(
          {character, failure.text(0), failure.text(1), code, failure.text(2), failure.number(3)});
    }
  }
  return nights;
}

}  // namespace backbend::validate
