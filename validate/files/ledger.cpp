#include "validate/files/ledger.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "validate/files/hash.h"
#include "validate/files/output_folder.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::string_view kPartMagic = "backbend part 1\n";
constexpr std::uintmax_t kMostPartBytes = std::uintmax_t{1} << 28;

struct Part {
  std::string stamp, unit;
  std::vector<std::pair<std::string, std::string>> files;  // name, hash
  std::vector<std::uint8_t> result;
};

// A line of magic, the hash of all that follows, a line of JSON, and the result as it is.
std::string part_text(const Part& part) {
  json files = json::array();
  for (const auto& [name, hash] : part.files) files.push_back({name, hash});
  std::string body = json{{"stamp", part.stamp}, {"unit", part.unit}, {"files", files}}.dump(
                         -1, ' ', true, json::error_handler_t::replace) +
                     "\n";
  body.append(part.result.begin(), part.result.end());
  return std::string(kPartMagic) + content_hash(body) + "\n" + body;
}

std::optional<Part> parse_part(std::string_view text) {
  const std::size_t head = kPartMagic.size() + kHashLength + 1;
  if (text.size() < head || text.substr(0, kPartMagic.size()) != kPartMagic) return std::nullopt;
  const std::string_view body = text.substr(head);
  if (text[head - 1] != '\n' || content_hash(body) != text.substr(kPartMagic.size(), kHashLength))
    return std::nullopt;
  const std::size_t end = body.find('\n');
  if (end == std::string_view::npos) return std::nullopt;
  const json facts = json::parse(body.substr(0, end), nullptr, false);
  if (!facts.is_object() || !facts.contains("stamp") || !facts["stamp"].is_string() ||
      !facts.contains("unit") || !facts["unit"].is_string() || !facts.contains("files") ||
      !facts["files"].is_array())
    return std::nullopt;
  Part part;
  part.stamp = facts["stamp"];
  part.unit = facts["unit"];
  for (const json& file : facts["files"]) {
    if (!file.is_array() || file.size() != 2 || !file[0].is_string() || !file[1].is_string() ||
        !is_inside(file[0]))
      return std::nullopt;
    part.files.emplace_back(file[0], file[1]);
  }
  part.result.assign(body.begin() + static_cast<std::ptrdiff_t>(end) + 1, body.end());
  return part;
}

std::optional<Part> read_part(const fs::path& file) {
  try {
    const std::vector<std::uint8_t> bytes = read_bytes(file, kMostPartBytes);
    return parse_part({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  } catch (const ReadError&) {
    return std::nullopt;
  }
}

/// The bytes of a file of a part, if they are still those that were written.
std::optional<std::vector<std::uint8_t>> verified(const fs::path& file, const std::string& hash) {
  try {
    std::vector<std::uint8_t> bytes = read_bytes(file);
    if (content_hash(bytes) == hash) return bytes;
  } catch (const ReadError&) {
  }
  return std::nullopt;
}

fs::path part_name(const std::string& unit) {
  return fs::path(kPartsFolder) / (content_hash(unit) + ".part");
}

std::optional<int> number_in(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<int> number_of(const char* variable) {
  const char* value = std::getenv(variable);
  return value == nullptr ? std::nullopt : number_in(value);
}

}  // namespace

Shard parse_shard(std::string_view text) {
  if (text == "auto") {
    const auto task = number_of("SLURM_ARRAY_TASK_ID"), first = number_of("SLURM_ARRAY_TASK_MIN"),
               count = number_of("SLURM_ARRAY_TASK_COUNT");
    if (task && first && count && *task >= *first && *task - *first < *count)
      return {*task - *first + 1, *count};
    throw std::invalid_argument(
        "'auto' is for the tasks of a Slurm array, numbered without gaps; SLURM_ARRAY_TASK_ID, "
        "_MIN and _COUNT do not say so");
  }
  const std::size_t slash = text.find('/');
  const auto index =
      slash == std::string_view::npos ? std::nullopt : number_in(text.substr(0, slash));
  const auto count =
      slash == std::string_view::npos ? std::nullopt : number_in(text.substr(slash + 1));
  if (!index || !count || *index < 1 || *count < *index || *count > 100'000)
    throw std::invalid_argument(
        "'" + std::string(text) +
        "': invalid share; expected I/N with 1 <= I <= N <= 100000, or auto");
  return {*index, *count};
}

FolderLock::FolderLock(const fs::path& folder, Kind kind) {
  descriptor_ = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor_ < 0) return;  // whoever writes there says why it cannot
  const int wanted = (kind == Kind::shared ? LOCK_SH : LOCK_EX) | LOCK_NB;
  int result = -1;
  do {
    result = ::flock(descriptor_, wanted);
  } while (result != 0 && errno == EINTR);
  // File systems without locks give other errors: there the user keeps runs apart.
  if (result != 0 && errno == EWOULDBLOCK) {
    ::close(descriptor_);
    descriptor_ = -1;
    throw BusyError(folder.string() +
                    ": another run is writing there; try again when it has ended");
  }
}

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Ledger::Ledger(fs::path folder, std::string stamp, Mode mode, Shard shard, bool take_up)
    : folder_(std::move(folder)),
      stamp_(std::move(stamp)),
      mode_(mode),
      shard_(shard),
      take_up_(take_up) {}

std::optional<Ledger::Bytes> Ledger::find(const std::string& unit) const {
  if (!is_on() || !take_up_) return std::nullopt;
  std::optional<Part> part = read_part(folder_ / part_name(unit));
  if (!part || part->stamp != stamp_ || part->unit != unit) return std::nullopt;
  for (const auto& [name, hash] : part->files)
    if (!verified(folder_ / name, hash)) return std::nullopt;
  return std::move(part->result);
}

void Ledger::keep(const std::string& unit, std::span<const std::uint8_t> result,
                  const std::vector<std::string>& files) const {
  if (!is_on()) return;
  Part part{stamp_, unit, {}, {result.begin(), result.end()}};
  try {
    for (const std::string& name : files)
      part.files.emplace_back(name, content_hash(read_bytes(folder_ / name)));
  } catch (const ReadError& error) {  // a file that this run wrote is not the user's input
    throw WriteError(error.what(), EIO);
  }
  OutputFolder(folder_).write(part_name(unit), part_text(part));
}

void Ledger::miss(const std::string& unit) {
  const std::lock_guard lock(mutex_);
  missing_.push_back(unit);
}

std::vector<std::string> Ledger::missing() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> sorted = missing_;
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

namespace {

std::vector<fs::path> parts_in(const fs::path& run) {
  std::vector<fs::path> names;
  std::error_code error;
  for (fs::directory_iterator entry(run / kPartsFolder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry->path().extension() == ".part") names.push_back(entry->path());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

std::size_t gather_parts(const fs::path& from, const fs::path& to, const std::string& stamp) {
  std::error_code error;
  const bool same_place = fs::equivalent(from, to, error);
  const OutputFolder folder(to);
  std::size_t gathered = 0;
  for (const fs::path& name : parts_in(from)) {
    const std::optional<Part> part = read_part(name);
    if (!part) continue;
    if (part->stamp != stamp)
      throw MixedPartsError(name.string() + ": '" + part->unit +
                            "' was made from other inputs, options or by another program than the "
                            "rest; shards of one job only can be merged");
    if (same_place) {
      ++gathered;
      continue;
    }
    std::vector<std::vector<std::uint8_t>> contents;
    for (const auto& [file, hash] : part->files) {
      auto bytes = verified(from / file, hash);
      if (!bytes) break;
      contents.push_back(std::move(*bytes));
    }
    if (contents.size() != part->files.size()) continue;
    for (std::size_t i = 0; i < contents.size(); ++i)
      folder.write(part->files[i].first, contents[i]);
    folder.write(part_name(part->unit), part_text(*part));
    ++gathered;
  }
  return gathered;
}

void remove_parts(const fs::path& folder) {
  // File by file: a folder of this name may hold what is not ours, and a link leads to what never
  // is.
  std::error_code error;
  if (fs::is_symlink(folder / kPartsFolder, error)) return;
  const std::string ours = std::string(kPartsFolder) + "/";
  for (const fs::path& name : parts_in(folder)) {
    const std::optional<Part> part = read_part(name);
    if (!part) continue;
    for (const auto& [file, hash] : part->files)
      if (file.starts_with(ours)) fs::remove(folder / file, error);
    fs::remove(name, error);
  }
  fs::remove(folder / kPlanFile, error);
  std::vector<fs::path> folders = {folder / kPartsFolder};
  for (fs::recursive_directory_iterator entry(folders.front(), error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry->symlink_status(error).type() == fs::file_type::directory)
      folders.push_back(entry->path());
  }
  std::sort(folders.rbegin(), folders.rend());  // the deepest first
  for (const fs::path& each : folders) {
    if (fs::symlink_status(each, error).type() == fs::file_type::directory)
      fs::remove(each, error);  // where nothing is left in it
  }
}

}  // namespace backbend::validate
