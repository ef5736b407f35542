#include "validate/carry/carry_over.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <toml++/toml.h>
#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "validate/carry/input_files.h"
#include "validate/files/hash.h"
#include "validate/files/output_folder.h"
#include "validate/files/program_hash.h"
#include "validate/files/project.h"
#include "validate/model/report_json.h"
#include "validate/report/libraries.h"
#include "validate/sweeps/external_spec.h"
#include "validate/tasks/side_by_side.h"
#include "validate/text/escape.h"
#include "validate/text/json_object.h"
#include "validate/verdicts/waivers.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::string_view kCarriedMagic = "backbend carried 1\n";
constexpr std::uintmax_t kMostEntryBytes = std::uintmax_t{1} << 28;
constexpr const char* kEntryFolder = "carried";
/// Folders below a run's that hold what is made for one character.
constexpr const char* kResultFolders[] = {"findings", "frames", "media", "meshes", "review"};

struct Damaged : std::runtime_error {
  using std::runtime_error::runtime_error;
};

std::string dumped(const json& value) {
  return value.dump(-1, ' ', true, json::error_handler_t::replace);
}

std::string complaint(const std::string& unit, const std::string& what) {
  return unit + ": what an earlier night left " + what + ": measured again";
}

/// The value of an entry whose own hash is right.
json read_entry(const fs::path& file) {
  std::string text;
  try {
    text = read_text(file, kMostEntryBytes);
  } catch (const ReadError& error) {
    throw Damaged(error.what());
  }
  const std::size_t head = kCarriedMagic.size() + kHashLength + 1;
  if (text.size() < head || !text.starts_with(kCarriedMagic) || text[head - 1] != '\n' ||
      content_hash(std::string_view(text).substr(head)) !=
          text.substr(kCarriedMagic.size(), kHashLength))
    throw Damaged("is not as it was written");
  return json::parse(text.substr(head));
}

/// Makes the folders that a name leads through; false where one of them is a link, or no folder.
bool make_folders(const fs::path& folder, const fs::path& name) {
  fs::path at = folder;
  std::error_code error;
  fs::create_directories(at, error);
  for (const fs::path& step : name.parent_path()) {
    at /= step;
    fs::create_directory(at, error);
    if (fs::symlink_status(at, error).type() != fs::file_type::directory) return false;
  }
  return true;
}

/// Puts a file of an earlier run into this one's folder.
void place_file(const fs::path& from, const fs::path& folder, const std::string& name,
                const std::vector<std::uint8_t>& bytes) {
  const fs::path target = folder / name;
  struct stat facts = {};
  if (make_folders(folder, name) && ::lstat(from.c_str(), &facts) == 0 && S_ISREG(facts.st_mode)) {
    if (::link(from.c_str(), target.c_str()) == 0) return;
    // A name that is taken here is an older run's.
    struct stat there = {};
    if (errno == EEXIST && ::lstat(target.c_str(), &there) == 0) {
      if (there.st_dev == facts.st_dev && there.st_ino == facts.st_ino) return;
      if (!S_ISDIR(there.st_mode) && ::unlink(target.c_str()) == 0 &&
          ::link(from.c_str(), target.c_str()) == 0)
        return;
    }
  }
  OutputFolder(folder).write(name, bytes);  // another file system, or one without links
}

/// Names that were made in a folder reach the medium.
void flush_folder(const fs::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

}  // namespace

std::string program_inputs() {
  return content_hash(dumped(
      JsonObject<json>().with("program", program_hash()).with("versions", program_versions())));
}

std::string night_inputs(const Suite& suite, const std::vector<std::string>& options) {
  json facts = JsonObject<json>()
                   .with("program", program_inputs())
                   .with("options", options)
                   .with("suite", suite.name);
  for (const RigPlan& rig : suite.rigs) {
    facts["rigs"].push_back({rig.name, rig_text(rig.spec)});
    if (rig.duty) facts["rigs"].back().push_back(rig_text(rig.duty->twin));
    if (is_external(rig.spec)) facts["rigs"].back().push_back(external_inputs(rig.spec));
  }
  if (!suite.file.empty()) {
    try {
      toml::table text = toml::parse(read_text(suite.file), suite.file.string());
      if (toml::table* own = text["suite"].as_table()) {
        own->erase("characters");
        own->erase("title");
      }
      text.erase("waiver");
      text.erase("calibration");
      std::ostringstream shown;
      shown << toml::json_formatter(text);
      facts["text"] = shown.str();
    } catch (const toml::parse_error& error) {
      throw SuiteError(suite.file.string() + ": " + std::string(error.description()));
    }
  }
  return content_hash(dumped(facts));
}

std::string character_content(const fs::path& character) {
  json facts = json::array();
  for (const fs::path& file : input_files(character)) {
    if (file.filename() == kProjectFile) continue;  // options are told by their values
    std::error_code error;
    const bool is_there = fs::exists(file, error);
    facts.push_back({file.filename().string(),
                     is_there || file == character ? content_hash(read_bytes(file)) : "none"});
  }
  return content_hash(dumped(facts));
}

CarryOver::CarryOver(Place place) : place_(std::move(place)) {}

std::string CarryOver::tonight() const {
  return place_.label.empty() ? place_.today : place_.today + " " + place_.label;
}

fs::path CarryOver::entry_file(const std::string& unit) const {
  return place_.history.parent_path() / kEntryFolder /
         (content_hash(place_.options + "\n" + unit) + ".json");
}

bool CarryOver::is_unchanged(const fs::path& report, const std::string& hash) const {
  const std::lock_guard lock(looking_at_reports_);
  const auto [found, is_new] = unchanged_.try_emplace({report, hash}, false);
  if (!is_new) return found->second;
  try {
    found->second = content_hash(read_bytes(report)) == hash;
  } catch (const ReadError&) {
    // It is gone.
  }
  return found->second;
}

CarryOver::Entry CarryOver::read(const std::string& unit, const std::string& stamp) const {
  const fs::path file = entry_file(unit);
  std::error_code error;
  if (place_.fresh || !fs::exists(file, error)) return {};
  const auto damaged = [&](const std::string& what) {
    return Entry{{}, {}, complaint(unit, what)};
  };
  try {
    json entry = read_entry(file);
    if (entry.at("unit") != unit || entry.at("stamp") != stamp) return {};
    const std::string hash = entry.at("report_hash"), results = entry.at("results");
    const auto night = place_.results.find(hash);
    if (night == place_.results.end() || night->second != content_hash(results))
      throw Damaged("is of no night of " + place_.history.string());
    const fs::path run =
        fs::absolute(place_.history).parent_path() / entry.at("run").get<std::string>();
    if (!is_unchanged(run / "report.json", hash))
      throw Damaged("is of a night whose report is gone or another by now");
    Result result;
    entry.at("night").get_to(result.night);
    entry.at("files").get_to(result.files);
    result.text = std::move(entry.at("report").get_ref<std::string&>());
    if (json::parse(results).at(valid_utf8(unit)) != content_hash(result.text))
      throw Damaged("is not what its night found");
    result.report = parse_report(result.text, file.string());
    return {std::move(result), run, {}};
  } catch (const json::exception&) {
    return damaged("is damaged");
  } catch (const Damaged& why) {
    return damaged(why.what());
  } catch (const ReadError& why) {
    return damaged("is gone (" + std::string(why.what()) + ")");
  } catch (const ReportError& why) {
    return damaged("is damaged (" + std::string(why.what()) + ")");
  }
}

void CarryOver::read_ahead(const std::vector<std::pair<std::string, std::string>>& units) {
  std::vector<Entry> entries(units.size());
  for_each_side_by_side(units.size(),
                        [&](std::size_t i) { entries[i] = read(units[i].first, units[i].second); });
  for (std::size_t i = 0; i < units.size(); ++i) ahead_[units[i]] = std::move(entries[i]);
}

std::optional<CarryOver::Result> CarryOver::find(
    const std::string& unit, const std::string& stamp, const fs::path& folder, int most_days,
    const std::function<bool(const Report&)>& fits,
    const std::function<void(const std::string&)>& complain) {
  auto known = ahead_.extract({unit, stamp});
  Entry entry = known ? std::move(known.mapped()) : read(unit, stamp);
  if (!entry.complaint.empty()) complain(entry.complaint);
  if (!entry.result) return std::nullopt;
  Result& result = *entry.result;
  if (most_days > 0) {
    const int days = days_between(result.night.substr(0, 10), place_.today);
    if (days < 0 || days > most_days) return std::nullopt;
  }
  if (!fits(result.report)) return std::nullopt;
  // All files are looked at before any is placed.
  std::vector<std::pair<std::string, std::string>> files(result.files.begin(), result.files.end());
  std::vector<std::vector<std::uint8_t>> contents(files.size());
  std::vector<std::string> wrong(files.size());
  for_each_side_by_side(files.size(), [&](std::size_t i) {
    const auto& [name, hash] = files[i];
    try {
      if (!is_inside(name)) throw Damaged("names a file outside of its run");
      contents[i] = read_bytes(entry.run / name);
      if (content_hash(contents[i]) != hash) throw Damaged(name + " has changed since");
    } catch (const Damaged& why) {
      wrong[i] = why.what();
    } catch (const ReadError& why) {
      wrong[i] = "is gone (" + std::string(why.what()) + ")";
    }
  });
  const auto first = std::ranges::find_if(wrong, [](const auto& why) { return !why.empty(); });
  if (first != wrong.end()) {
    complain(complaint(unit, *first));
    return std::nullopt;
  }
  std::set<fs::path> folders;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const std::string& name = files[i].first;
    place_file(entry.run / name, folder, name, contents[i]);
    for (fs::path above = fs::path(name).parent_path(); !above.empty(); above = above.parent_path())
      folders.insert(folder / above);
  }
  for (const fs::path& each : folders) flush_folder(each);
  return std::move(result);
}

void CarryOver::note(const std::string& unit, const std::string& stamp, Result result) {
  if (result.text.empty()) result.text = report_json_compact(result.report);
  result.report = {};
  noted_[unit] = {stamp, std::move(result)};
}

std::string CarryOver::results_text() const {
  json hashes = json::object();
  for (const auto& [unit, noted] : noted_)
    hashes[valid_utf8(unit)] = content_hash(noted.result.text);
  return dumped(hashes);
}

std::string CarryOver::results_hash() const { return content_hash(results_text()); }

void CarryOver::keep(const fs::path& folder, const std::string& report_hash) const {
  if (!place_.keeps) return;
  const std::string results = results_text();
  const fs::path home = fs::absolute(place_.history).parent_path();
  const std::string run =
      fs::absolute(folder).lexically_normal().lexically_proximate(home).string();
  std::vector<decltype(noted_)::const_pointer> units;
  for (const auto& each : noted_) units.push_back(&each);
  for_each_side_by_side(units.size(), [&](std::size_t i) {
    const auto& [unit, noted] = *units[i];
    json files = json::object();
    try {
      for (const auto& [name, hash] : noted.result.files)
        files[name] = hash.empty() ? content_hash(read_bytes(folder / name)) : hash;
    } catch (const ReadError& error) {  // what this run has written is no input of the user's
      throw WriteError(error.what(), EIO);
    }
    const std::string body = dumped(JsonObject<json>()
                                        .with("unit", unit)
                                        .with("stamp", noted.stamp)
                                        .with("night", noted.result.night)
                                        .with("report_hash", report_hash)
                                        .with("results", results)
                                        .with("run", run)
                                        .with("files", files)
                                        .with("report", noted.result.text)) +
                             "\n";
    const fs::path file = entry_file(unit);
    OutputFolder(file.parent_path())
        .write(file.filename(), std::string(kCarriedMagic) + content_hash(body) + "\n" + body);
  });
}

FolderListing list_results(const fs::path& folder) {
  FolderListing files;
  std::error_code none;
  for (const char* name : kResultFolders) {
    for (fs::recursive_directory_iterator each(folder / name, none), end; !none && each != end;
         each.increment(none)) {
      struct stat facts = {};
      if (::lstat(each->path().c_str(), &facts) == 0 && S_ISREG(facts.st_mode))
        files[each->path().lexically_relative(folder).string()] = {
            static_cast<std::int64_t>(facts.st_ino), facts.st_mtim.tv_sec, facts.st_mtim.tv_nsec};
    }
    none.clear();
  }
  return files;
}

std::map<std::string, std::string> files_made(const FolderListing& before,
                                              const FolderListing& after) {
  std::map<std::string, std::string> made;
  for (const auto& [name, entry] : after) {
    const auto old = before.find(name);
    if (old == before.end() || old->second != entry) made[name] = "";
  }
  return made;
}

}  // namespace backbend::validate
