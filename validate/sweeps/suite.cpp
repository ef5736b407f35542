#include "validate/sweeps/suite.h"

#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "solver/rig/nearest_name.h"
#include "validate/files/output_folder.h"
#include "validate/sweeps/external_spec.h"
#include "validate/sweeps/named_pose.h"
#include "validate/text/number_text.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;

/// Reads one TOML table key by key; what was not asked for by the end is an unknown key.
class TableReader {
 public:
  TableReader(const toml::table& table, std::string file, std::string name)
      : table_(table), file_(std::move(file)), name_(std::move(name)) {}

  [[noreturn]] void fail(const toml::node& at, const std::string& why) const {
    throw SuiteError(file_ + ":" + std::to_string(at.source().begin.line) + ": " + why);
  }

  const toml::node* find(std::string_view key) {
    known_.emplace_back(key);
    return table_.get(key);
  }

  const toml::node& need(std::string_view key) {
    const toml::node* node = find(key);
    if (node == nullptr) fail(table_, "[" + name_ + "] needs '" + std::string(key) + "'");
    return *node;
  }

  std::string text(const toml::node& node, std::string_view key) const {
    if (const auto value = node.value_exact<std::string>()) return *value;
    fail(node, "'" + std::string(key) + "' must be text in quotes");
  }

  std::string text(std::string_view key, const std::string& otherwise) {
    const toml::node* node = find(key);
    return node == nullptr ? otherwise : text(*node, key);
  }

  double number(std::string_view key, double otherwise, double low, double high) {
    const toml::node* node = find(key);
    if (node == nullptr) return otherwise;
    const auto value = node->is_number() ? node->value<double>() : std::nullopt;
    if (!value || !std::isfinite(*value) || *value < low || *value > high) {
      fail(*node, "'" + std::string(key) + "' must be a number from " + number_text(low) + " to " +
                      number_text(high));
    }
    return *value;
  }

  int whole(std::string_view key, int otherwise, int low, int high) {
    const toml::node* node = find(key);
    const double value = number(key, otherwise, low, high);
    if (value != std::floor(value))
      fail(*node, "'" + std::string(key) + "' must be a whole number");
    return static_cast<int>(value);
  }

  bool flag(std::string_view key, bool otherwise) {
    const toml::node* node = find(key);
    if (node == nullptr) return otherwise;
    if (const auto value = node->value_exact<bool>()) return *value;
    fail(*node, "'" + std::string(key) + "' must be true or false");
  }

  std::string word(std::string_view key, const std::string& otherwise,
                   const std::vector<std::string>& allowed) {
    const std::string value = text(key, otherwise);
    if (std::find(allowed.begin(), allowed.end(), value) == allowed.end()) {
      std::string list;
      for (const std::string& each : allowed) list += (list.empty() ? "" : " | ") + each;
      fail(*table_.get(key), "'" + value + "' is no " + std::string(key) +
                                 solver::did_you_mean(value, allowed) + " (" + list + ")");
    }
    return value;
  }

  /// Every key must have been asked for by now.
  void finish() const {
    for (const auto& [key, node] : table_) {
      if (std::find(known_.begin(), known_.end(), key.str()) != known_.end()) continue;
      fail(node, "unknown key '" + std::string(key.str()) + "' in [" + name_ + "]" +
                     solver::did_you_mean(key.str(), known_));
    }
  }

  const std::string& file() const { return file_; }
  const toml::table& table() const { return table_; }

 private:
  const toml::table& table_;
  std::string file_, name_;
  std::vector<std::string> known_;
};

std::optional<double> finite_number(const toml::node& node) {
  const auto value = node.is_number() ? node.value<double>() : std::nullopt;
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<std::vector<double>> number_list(const toml::array& array) {
  std::vector<double> values;
  for (const toml::node& item : array) {
    const auto value = finite_number(item);
    if (!value) return std::nullopt;
    values.push_back(*value);
  }
  return values;
}

solver::OptionValue option_value(const TableReader& reader, const toml::node& node,
                                 std::string_view key) {
  if (const auto value = node.value_exact<bool>()) return *value;
  if (const auto value = node.value_exact<std::string>()) return *value;
  if (const auto value = finite_number(node)) return *value;
  if (const toml::array* array = node.as_array()) {
    if (const auto values = number_list(*array)) return *values;
    std::vector<std::vector<double>> rows;
    for (const toml::node& item : *array) {
      const auto row = item.is_array() ? number_list(*item.as_array()) : std::nullopt;
      if (!row)
        reader.fail(item, "'" + std::string(key) + "' must be a list of numbers, or of such lists");
      rows.push_back(*row);
    }
    return rows;
  }
  reader.fail(node,
              "'" + std::string(key) + "' must be a finite number, text, true, false or a list");
}

std::vector<std::string> system_names() {
  std::vector<std::string> names;
  for (const solver::SystemInfo& info : solver::list_systems()) names.emplace_back(info.name);
  return names;
}

/// A studio's own rig: its files are relative to the file that names them.
void read_external(const TableReader& reader, const toml::node& node, const fs::path& folder,
                   solver::SystemSpec& spec) {
  try {
    external_spec(spec);
  } catch (const solver::RigError& error) {
    reader.fail(node, error.what());
  }
  for (const char* key : {"file", "map"})
    if (const auto found = spec.options.find(key); found != spec.options.end())
      found->second = (folder / std::get<std::string>(found->second)).lexically_normal().string();
}

/// A table of `system` and its options, whose own names and values build_system() checks.
solver::SystemSpec read_spec(const TableReader& parent, const toml::node& node,
                             std::string_view key) {
  const toml::table* table = node.as_table();
  if (table == nullptr) parent.fail(node, "'" + std::string(key) + "' must be a table");
  TableReader reader(*table, parent.file(), std::string(key));
  solver::SystemSpec spec;
  spec.system = reader.text(reader.need("system"), "system");
  std::vector<std::string> names = system_names();
  names.emplace_back(kExternal);
  if (std::find(names.begin(), names.end(), spec.system) == names.end()) {
    reader.fail(*table->get("system"), "no system '" + spec.system + "'" +
                                           solver::did_you_mean(spec.system, names) +
                                           "; backbend list rigs shows all");
  }
  for (const auto& [name, value] : *table) {
    if (name.str() == "system") continue;
    spec.options[std::string(name.str())] = option_value(reader, value, name.str());
  }
  if (is_external(spec)) {
    read_external(reader, node, fs::path(parent.file()).parent_path(), spec);
    return spec;
  }
  try {
    // Options do not depend on the character: a wrong one is told with its line, before any work.
    solver::build_system(spec, {{{0, 0, 0}, {0, 1, 0}, {0, 2, 0}, {0, 3, 0}}, {1, 0, 0}});
  } catch (const solver::RigError& error) {
    reader.fail(node, error.what());
  }
  return spec;
}

CanaryDuty read_duty(const TableReader& parent, const toml::node& node) {
  const toml::table* table = node.as_table();
  if (table == nullptr) parent.fail(node, "'duty' must be a table");
  TableReader reader(*table, parent.file(), "duty");
  CanaryDuty duty;
  duty.code = reader.text(reader.need("code"), "code");
  duty.sweep = reader.text(reader.need("sweep"), "sweep");
  duty.joint = reader.text("joint", "");
  duty.mapping = *find_mapping(reader.word("mapping", "chest", {"chest", "spread"}));
  reader.need("at_deg");
  duty.control_deg = reader.number("at_deg", 0, -3600, 3600);
  duty.tolerance_deg = reader.number("tolerance_deg", 0.5, 0, 180);
  duty.twin = read_spec(reader, reader.need("twin"), "twin");
  reader.finish();
  return duty;
}

RigPlan read_rig_row(const std::string& file, const toml::table& table) {
  TableReader reader(table, file, "rig");
  RigPlan plan;
  plan.spec = read_spec(reader, reader.need("solver"), "solver");
  plan.name = reader.text("name", plan.spec.system);
  const std::string role = reader.word("role", "proposed", {"proposed", "reference", "canary"});
  plan.role = role == "proposed"    ? Role::proposed
              : role == "reference" ? Role::reference
                                    : Role::canary;
  if (plan.role == Role::canary) {
    plan.duty = read_duty(reader, reader.need("duty"));
  } else if (const toml::node* duty = reader.find("duty")) {
    reader.fail(*duty, "only a rig with role = \"canary\" has a duty");
  }
  reader.finish();
  return plan;
}

/// A sweep through named poses: `path = ["rest", "extension=60, side=20"]`.
Sweep read_path(TableReader& reader, const toml::node& node) {
  const std::string name = reader.text(reader.need("name"), "name");
  const double step = reader.number("step", 2, 0.01, 90);
  reader.finish();
  const toml::array* texts = node.as_array();
  if (texts == nullptr) reader.fail(node, "'path' must be a list of poses");
  std::vector<PoseDegrees> poses;
  for (const toml::node& each : *texts) {
    const std::string text = reader.text(each, "path");
    try {
      poses.push_back(parse_pose(text == "rest" ? "" : text));
    } catch (const solver::RigError& error) {
      reader.fail(each, error.what());
    }
  }
  try {
    return path_sweep(name, poses, step);
  } catch (const solver::RigError& error) {
    reader.fail(node, error.what());
  }
}

Sweep read_sweep(const std::string& file, const toml::table& table) {
  TableReader reader(table, file, "sweep");
  if (const toml::node* path = reader.find("path")) return read_path(reader, *path);
  const std::vector<std::string> channels{std::begin(kChannels), std::end(kChannels)};
  reader.need("channel");
  const std::string channel = reader.word("channel", "", channels);
  reader.need("to");
  Sweep sweep =
      channel_sweep(channel, reader.number("from", 0, -3600, 3600),
                    reader.number("to", 0, -3600, 3600), reader.number("step", 2, 0.01, 90));
  sweep.name = reader.text("name", channel);
  if (sweep.from_deg == sweep.to_deg) reader.fail(table, "the sweep ends where it begins");
  if (const toml::node* node = reader.find("with")) {
    const toml::table* with = node->as_table();
    if (with == nullptr)
      reader.fail(*node, "'with' must be a table of channel = degrees per degree");
    TableReader ratios(*with, file, "with");
    for (const std::string& each : channels) {
      if (each != channel) *sweep.per_degree.find(each) = ratios.number(each, 0, -100, 100);
    }
    ratios.finish();
  }
  for (const double control : {sweep.from_deg, sweep.to_deg})
    if (!(sweep.pose_at(control).stretch > kLeastStretch))
      reader.fail(table, "the sweep leaves no spine: stretch must stay above " +
                             number_text(kLeastStretch) + " per cent");
  reader.finish();
  return sweep;
}

/// `[[pose]]`: a pose that every night measures, and where its path begins.
Sweep read_named_pose(const std::string& file, const toml::table& table) {
  TableReader reader(table, file, "pose");
  const std::string name = reader.text(reader.need("name"), "name");
  const auto pose = [&](std::string_view key, const toml::node& node) {
    try {
      return parse_pose(reader.text(node, key));
    } catch (const solver::RigError& error) {
      reader.fail(node, error.what());
    }
  };
  const toml::node& node = reader.need("at");
  const PoseDegrees at = pose("at", node);
  const toml::node* from = reader.find("from");
  const PoseDegrees start = from == nullptr ? PoseDegrees{} : pose("from", *from);
  reader.finish();
  try {
    return named_pose(name, start, at);
  } catch (const solver::RigError& error) {
    reader.fail(node, error.what());
  }
}

PicturePlan read_pictures(const std::string& file, const toml::table& table) {
  TableReader reader(table, file, "pictures");
  PicturePlan plan;
  plan.width = reader.whole("width", plan.width, 16, 16384);
  plan.height = reader.whole("height", plan.height, 16, 16384);
  plan.samples = reader.whole("samples", plan.samples, 1, 65536);
  plan.turntable_views = reader.whole("turntable_views", plan.turntable_views, 0, 720);
  plan.sheet_columns = reader.whole("sheet_columns", plan.sheet_columns, 0, 16);
  reader.finish();
  return plan;
}

/// `[[limit]]`: who moved a limit, for whom, and why.
SuiteLimit read_limit(const std::string& file, const toml::table& table) {
  TableReader reader(table, file, "limit");
  SuiteLimit row;
  row.code = reader.text(reader.need("code"), "code");
  reader.need("value");
  row.limit.value = reader.number("value", 0, -1e9, 1e9);
  row.character = reader.text("character", "");
  const std::string layer = reader.word("layer", row.character.empty() ? "show" : "character",
                                        {"studio", "show", "character"});
  if ((layer == "character") == row.character.empty())
    reader.fail(table, "the layer 'character' and a character's name go together");
  row.limit.layer = layer == "studio" ? LimitLayer::studio
                    : layer == "show" ? LimitLayer::show
                                      : LimitLayer::character;
  row.limit.owner = reader.text(reader.need("owner"), "owner");
  row.limit.reason = reader.text(reader.need("reason"), "reason");
  reader.finish();
  try {
    LimitSet().set(row.code, row.limit);
  } catch (const LimitError& error) {
    reader.fail(table, error.what());
  }
  row.limit.origin = file + ":" + std::to_string(table.source().begin.line);
  return row;
}

/// `[[waiver]]`: a finding that somebody accepts until a day.
Waiver read_waiver(const std::string& file, const toml::table& table) {
  TableReader reader(table, file, "waiver");
  Waiver waiver;
  waiver.code = reader.text(reader.need("code"), "code");
  waiver.character = reader.text("character", "");
  waiver.rig = reader.text("rig", "");
  waiver.sweep = reader.text("sweep", "");
  waiver.joint = reader.text("joint", "");
  waiver.from_deg = reader.number("from_deg", waiver.from_deg, -3600, 3600);
  waiver.to_deg = reader.number("to_deg", waiver.to_deg, -3600, 3600);
  waiver.worst = reader.number("worst", waiver.worst, -1e9, 1e9);
  waiver.owner = reader.text(reader.need("owner"), "owner");
  waiver.reason = reader.text(reader.need("reason"), "reason");
  waiver.expires = reader.text(reader.need("expires"), "expires");
  reader.finish();
  try {
    check_waiver(waiver);
  } catch (const LimitError& error) {
    reader.fail(table, error.what());
  }
  waiver.origin = file + ":" + std::to_string(table.source().begin.line);
  return waiver;
}

toml::table parse(const fs::path& file) {
  const std::string text = read_text(file, std::uintmax_t{1} << 20);
  try {
    return toml::parse(text, file.string());
  } catch (const toml::parse_error& error) {
    throw SuiteError(file.string() + ":" + std::to_string(error.source().begin.line) + ": " +
                     std::string(error.description()));
  }
}

template <typename Read>
void each_row(TableReader& reader, std::string_view key, Read read) {
  const toml::node* node = reader.find(key);
  if (node == nullptr) return;
  const toml::array* rows = node->as_array();
  if (rows == nullptr || !rows->is_array_of_tables()) {
    reader.fail(*node,
                "'" + std::string(key) + "' must be written as [[" + std::string(key) + "]]");
  }
  for (const toml::node& row : *rows) read(*row.as_table());
}

/// `length=rest,depth=[0.3, 0.4]`: TOML values; a word needs no quotes.
void read_inline_options(const std::string& whole, std::string_view text,
                         solver::SystemSpec& spec) {
  while (!text.empty()) {
    std::size_t end = 0;
    for (int depth = 0; end < text.size() && (depth > 0 || text[end] != ','); ++end) {
      if (text[end] == '[') ++depth;
      if (text[end] == ']') --depth;
    }
    const std::string item(text.substr(0, end));
    text = text.substr(std::min(text.size(), end + 1));
    const std::size_t equals = item.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw SuiteError("rig '" + whole + "': '" + item + "' is not option=value");
    }
    const std::string key = item.substr(0, equals), value = item.substr(equals + 1);
    const bool is_word = !value.empty() && value != "true" && value != "false" &&
                         std::all_of(value.begin(), value.end(),
                                     [](char c) { return (c >= 'a' && c <= 'z') || c == '_'; });
    try {
      const toml::table table = toml::parse("value = " + (is_word ? "\"" + value + "\"" : value));
      spec.options[key] =
          option_value(TableReader(table, "rig '" + whole + "'", "rig"), *table.get("value"), key);
    } catch (const toml::parse_error&) {
      throw SuiteError("rig '" + whole + "': '" + value + "' is not a value of '" + key + "'");
    }
  }
}

/// Names tell apart in files, too: two that give one file name would write each other's pictures.
void check_names(const Suite& suite) {
  std::set<std::string> sweeps;
  std::vector<Sweep> named = suite.sweeps;
  named.insert(named.end(), suite.poses.begin(), suite.poses.end());
  for (const Sweep& sweep : named) sweeps.insert(sweep.name);
  const auto tell_apart = [&](const char* what, const auto& items, const auto& name_of) {
    std::map<std::string, std::string> by_file;
    for (const auto& item : items) {
      const std::string name = name_of(item);
      const auto [known, is_new] = by_file.emplace(file_word(name), name);
      if (is_new) continue;
      if (known->second == name)
        throw SuiteError(suite.file.string() + ": two " + what + " are named '" + name + "'");
      throw SuiteError(suite.file.string() + ": the " + what + " '" + known->second + "' and '" +
                       name + "' would write files of one name; rename one");
    }
  };
  tell_apart("rigs", suite.rigs, [](const RigPlan& rig) { return rig.name; });
  tell_apart("sweeps", named, [](const Sweep& sweep) { return sweep.name; });
  tell_apart("characters", suite.characters,
             [](const fs::path& file) { return file.stem().string(); });
  for (const RigPlan& rig : suite.rigs) {
    if (rig.duty && !sweeps.contains(rig.duty->sweep)) {
      throw SuiteError(suite.file.string() + ": canary '" + rig.name + "' names the sweep '" +
                       rig.duty->sweep + "', which the suite does not have");
    }
  }
}

std::string list_text(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + shortest(value);
  return "[" + text + "]";
}

std::string option_text(const solver::OptionValue& value) {
  if (const bool* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const double* number = std::get_if<double>(&value)) return shortest(*number);
  if (const std::string* word = std::get_if<std::string>(&value)) return *word;
  if (const auto* list = std::get_if<std::vector<double>>(&value)) return list_text(*list);
  std::string text;
  for (const std::vector<double>& row : std::get<std::vector<std::vector<double>>>(value)) {
    text += (text.empty() ? "" : ", ") + list_text(row);
  }
  return "[" + text + "]";
}

}  // namespace

/// Of a suite that says nothing else.
constexpr double kHuntPercent = 50.0;

Suite read_suite(const fs::path& file) {
  const toml::table table = parse(file);
  TableReader top(table, file.string(), "the file");
  Suite suite;
  suite.file = file;
  const toml::node& head = top.need("suite");
  if (!head.is_table()) top.fail(head, "'suite' must be a table");
  TableReader reader(*head.as_table(), file.string(), "suite");
  suite.name = reader.text("name", file.stem().string());
  suite.title = reader.text("title", suite.name);
  const bool names_envelope = reader.find("envelope") != nullptr;
  suite.envelope = *find_envelope(reader.word("envelope", "human", envelope_names()));
  suite.envelope_by_kind = !names_envelope;
  suite.corners = reader.flag("corners", !suite.envelope.whole_sweep);
  const auto list_of_text = [&](std::string_view key) {
    std::vector<std::string> values;
    if (const toml::node* node = reader.find(key)) {
      if (!node->is_array()) reader.fail(*node, "'" + std::string(key) + "' must be a list");
      for (const toml::node& item : *node->as_array()) values.push_back(reader.text(item, key));
    }
    return values;
  };
  for (const std::string& path : list_of_text("characters")) {
    suite.characters.push_back(fs::absolute(file).parent_path() / path);
  }
  for (const std::string& name : list_of_text("mappings")) {
    const auto mapping = find_mapping(name);
    if (!mapping) reader.fail(head, "no mapping '" + name + "' (chest | spread)");
    suite.mappings.push_back(*mapping);
  }
  if (suite.mappings.empty()) suite.mappings = {solver::Mapping::chest};
  reader.finish();

  each_row(top, "rig",
           [&](const toml::table& row) { suite.rigs.push_back(read_rig_row(file.string(), row)); });
  each_row(top, "sweep",
           [&](const toml::table& row) { suite.sweeps.push_back(read_sweep(file.string(), row)); });
  each_row(top, "pose", [&](const toml::table& row) {
    suite.poses.push_back(read_named_pose(file.string(), row));
  });
  each_row(top, "limit", [&](const toml::table& row) {
    suite.rules.limits.push_back(read_limit(file.string(), row));
  });
  each_row(top, "waiver", [&](const toml::table& row) {
    suite.rules.waivers.push_back(read_waiver(file.string(), row));
  });
  if (const toml::node* calibration = top.find("calibration")) {
    if (!calibration->is_table()) top.fail(*calibration, "'calibration' must be a table");
    TableReader slice(*calibration->as_table(), file.string(), "calibration");
    suite.calibration.poses = slice.whole("poses", 200, 0, 1000000);
    suite.calibration.faults = slice.whole("faults", 40, 1, 1000000);
    slice.finish();
  }
  suite.hunt.percent = kHuntPercent;
  if (const toml::node* hunt = top.find("hunt")) {
    if (!hunt->is_table()) top.fail(*hunt, "'hunt' must be a table");
    TableReader plan(*hunt->as_table(), file.string(), "hunt");
    suite.hunt.percent = plan.number("percent", kHuntPercent, 0, kMostHuntPercent);
    suite.hunt.seed = plan.whole("seed", suite.hunt.seed, 0, 1000000000);
    plan.finish();
  }
  if (const toml::node* pictures = top.find("pictures")) {
    if (!pictures->is_table()) top.fail(*pictures, "'pictures' must be a table");
    suite.pictures = read_pictures(file.string(), *pictures->as_table());
  }
  top.finish();
  if (suite.rigs.empty()) throw SuiteError(file.string() + ": a suite needs at least one [[rig]]");
  suite.standard = suite.sweeps.empty();
  if (suite.standard) suite.sweeps = standard_sweeps(suite.envelope);
  check_names(suite);
  return suite;
}

std::vector<Sweep> sweeps_for(const Suite& suite, const Envelope& envelope) {
  std::vector<Sweep> sweeps = suite.standard ? standard_sweeps(envelope) : suite.sweeps;
  if (suite.corners)
    for (Sweep& corner : corner_sweeps(reach_of(envelope, sweeps)))
      sweeps.push_back(std::move(corner));
  sweeps.insert(sweeps.end(), suite.poses.begin(), suite.poses.end());
  return sweeps;
}

LimitSet limits_for(const SuiteRules& rules, const std::string& character) {
  LimitSet limits;
  for (const SuiteLimit& row : rules.limits) {
    if (row.character.empty() || row.character == character) limits.set(row.code, row.limit);
  }
  return limits;
}

bool is_rig_file(const fs::path& file) { return parse(file).contains("rig"); }

RigPlan read_rig(const std::string& text) {
  try {
    if (const auto external = parse_external(text))
      return {external_name(*external), *external, Role::proposed, std::nullopt};
  } catch (const solver::RigError& error) {
    throw SuiteError(error.what());
  }
  const fs::path file(text);
  if (file.extension() == ".toml") {
    const toml::table table = parse(file);
    TableReader top(table, file.string(), "the file");
    RigPlan plan;
    plan.spec = read_spec(top, top.need("rig"), "rig");
    plan.name = file.stem().string();
    // A solver file (specification 5) is a rig file too: its chain and pose are its own business.
    for (const std::string_view key : {"chain", "path", "pose"}) top.find(key);
    top.finish();
    return plan;
  }
  const std::size_t colon = text.find(':');
  const std::string system = text.substr(0, colon);
  const std::vector<std::string> names = system_names();
  if (std::find(names.begin(), names.end(), system) == names.end()) {
    throw SuiteError("no rig '" + system + "'" + solver::did_you_mean(system, names) +
                     "; backbend list rigs shows all, a rig file ends in .toml");
  }
  RigPlan plan{text, {system, {}}, Role::proposed, std::nullopt};
  if (colon != std::string::npos) read_inline_options(text, text.substr(colon + 1), plan.spec);
  return plan;
}

std::string rig_text(const solver::SystemSpec& spec) {
  if (is_external(spec)) return external_text(spec);
  std::string text = spec.system;
  for (const auto& [key, value] : spec.options) {
    text += (text.size() == spec.system.size() ? ":" : ",") + key + "=" + option_text(value);
  }
  return text;
}

}  // namespace backbend::validate
