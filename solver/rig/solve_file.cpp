#include "solver/rig/solve_file.h"

#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "solver/rig/driven_system.h"
#include "solver/rig/live_rig.h"
#include "solver/rig/nearest_name.h"
#include "solver/rig/option_reader.h"

namespace backbend::solver {
namespace {

constexpr std::size_t kLargestFile = 16u
                                     << 20;  // a hundred thousand joints; no pose file is larger
constexpr double kFarthest = 1e9;            // of a coordinate: its square is far from overflow

/// Where errors of one file come from.
struct Source {
  std::string name;
  [[noreturn]] void refuse(const toml::node& at, const std::string& what) const {
    refuse(int(at.source().begin.line), what);
  }
  [[noreturn]] void refuse(int line, const std::string& what) const {
    throw RigError(name + (line > 0 ? ":" + std::to_string(line) : "") + ": " + what);
  }
};

std::string read_text(const std::filesystem::path& file) {
  std::error_code trouble;
  if (!std::filesystem::is_regular_file(file, trouble)) {
    throw RigError(file.string() + ": no such file");
  }
  const auto size = std::filesystem::file_size(file, trouble);
  if (trouble) throw RigError(file.string() + ": " + trouble.message());
  if (size > kLargestFile) throw RigError(file.string() + ": larger than 16 MiB, not a pose file");
  std::ifstream in(file, std::ios::binary);
  std::string text(size, '\0');
  in.read(text.data(), std::streamsize(size));
  if (!in || std::size_t(in.gcount()) != size) throw RigError(file.string() + ": cannot be read");
  return text;
}

std::optional<double> number_of(const toml::node& node) {
  if (const auto* real = node.as_floating_point()) return real->get();
  if (const auto* whole = node.as_integer()) return double(whole->get());
  return std::nullopt;
}

std::vector<double> numbers_of(const Source& source, const std::string& key,
                               const toml::array& array) {
  std::vector<double> list;
  list.reserve(array.size());
  for (const toml::node& item : array) {
    const auto number = number_of(item);
    if (!number) source.refuse(item, "'" + key + "' holds something that is not a number");
    if (!std::isfinite(*number)) source.refuse(item, "'" + key + "' holds " + number_text(*number));
    list.push_back(*number);
  }
  return list;
}

OptionValue value_of(const Source& source, const std::string& key, const toml::node& node) {
  if (const auto* flag = node.as_boolean()) return flag->get();
  if (const auto* text = node.as_string()) return text->get();
  if (const auto number = number_of(node)) {
    if (!std::isfinite(*number)) {
      source.refuse(node,
                    "'" + key + "' is " + number_text(*number) + ", expected a finite number");
    }
    return *number;
  }
  if (const auto* array = node.as_array()) {
    if (array->empty() || !array->front().is_array()) return numbers_of(source, key, *array);
    std::vector<std::vector<double>> rows;
    for (const toml::node& item : *array) {
      if (!item.is_array()) source.refuse(item, "'" + key + "' mixes lists and single values");
      rows.push_back(numbers_of(source, key, *item.as_array()));
    }
    return rows;
  }
  source.refuse(node, "'" + key + "' is neither a number, a word, true or false, nor a list");
}

glm::dvec3 vector_of(const Source& source, const std::string& key, const toml::node& node) {
  const auto* array = node.as_array();
  if (!array || array->size() != 3) source.refuse(node, "'" + key + "' expects [x, y, z]");
  const std::vector<double> v = numbers_of(source, key, *array);
  for (const double x : v) {
    if (std::abs(x) > kFarthest) {
      source.refuse(node, "'" + key + "' holds " + number_text(x) + ", expected within +-1e9");
    }
  }
  return {v[0], v[1], v[2]};
}

std::vector<glm::dvec3> vectors_of(const Source& source, const std::string& key,
                                   const toml::node& node) {
  const auto* array = node.as_array();
  if (!array) source.refuse(node, "'" + key + "' expects a list of [x, y, z]");
  std::vector<glm::dvec3> list;
  list.reserve(array->size());
  for (const toml::node& item : *array) list.push_back(vector_of(source, key, item));
  return list;
}

/// Refuses keys of a table other than the known ones.
void check_keys(const Source& source, const toml::table& table, const std::string& where,
                const std::vector<std::string>& known) {
  for (const auto& [key, node] : table) {
    const std::string name(key.str());
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      source.refuse(int(key.source().begin.line),
                    "unknown key '" + name + "' " + where + suggestion(name, known));
    }
  }
}

const toml::table* section(const Source& source, const toml::table& file, const std::string& name) {
  const toml::node* node = file.get(name);
  if (!node) return nullptr;
  if (!node->is_table()) source.refuse(*node, "'" + name + "' must be a table: [" + name + "]");
  return node->as_table();
}

// A rest file: {"vertebrae": [{"name", "row1_x_axis", .., "row4_position"}]}, rows as in the seed.
std::vector<RestFrame> read_rest_file(const std::filesystem::path& file) {
  const std::string name = file.string();
  const auto json = nlohmann::json::parse(read_text(file), nullptr, false);
  const auto refuse = [&](const std::string& what) { throw RigError(name + ": " + what); };
  if (json.is_discarded()) refuse("not JSON");
  if (!json.is_object() || !json.contains("vertebrae") || !json["vertebrae"].is_array()) {
    refuse("expected an object with a list \"vertebrae\"");
  }
  std::vector<RestFrame> frames;
  for (const auto& item : json["vertebrae"]) {
    const std::string where = "vertebra " + std::to_string(frames.size() + 1);
    RestFrame frame;
    if (!item.is_object() || !item.contains("name") || !item["name"].is_string()) {
      refuse(where + " has no \"name\"");
    }
    frame.name = item["name"].get<std::string>();
    constexpr const char* kRows[] = {"row1_x_axis", "row2_y_axis", "row3_z_axis", "row4_position"};
    for (int row = 0; row < 4; ++row) {
      const auto found = item.find(kRows[row]);
      bool good = found != item.end() && found->is_array() && found->size() == 3;
      for (int i = 0; good && i < 3; ++i) {
        good = (*found)[i].is_number();
        if (good) {
          const double value = (*found)[i].get<double>();
          good = std::isfinite(value) && std::abs(value) <= kFarthest;
          frame.rig_from_joint[row][i] = value;  // a row of the row-vector matrix is our column
        }
      }
      if (!good)
        refuse(where + " ('" + frame.name + "'): \"" + kRows[row] + "\" must be three numbers");
    }
    frames.push_back(std::move(frame));
  }
  return frames;
}

/// `[chain]` or `[redrawn]`, and the file's `[path]`.
RestChain read_chain(const Source& source, const toml::table& file, const std::string& name,
                     const std::filesystem::path& folder) {
  RestChain chain;
  if (const toml::table* table = section(source, file, name)) {
    check_keys(source, *table, "in [" + name + "]", {"joints", "left", "curve", "rest"});
    if (const auto* node = table->get("joints")) chain.joint = vectors_of(source, "joints", *node);
    if (const auto* node = table->get("curve")) chain.curve = vectors_of(source, "curve", *node);
    if (const auto* node = table->get("left")) {
      chain.left = vector_of(source, "left", *node);
      if (chain.left == glm::dvec3(0.0))
        source.refuse(*node, "'left' is zero, expected a direction");
    }
    if (const auto* node = table->get("rest")) {
      const auto* text = node->as_string();
      if (!text) source.refuse(*node, "'rest' expects the name of a file");
      // Only files beside the rig: a path from a stranger's file must not roam the disk.
      const std::filesystem::path rest(text->get());
      if (rest.is_absolute() || rest.lexically_normal().string().starts_with("..")) {
        source.refuse(*node,
                      "'rest' must name a file beside this one, found '" + text->get() + "'");
      }
      try {
        chain.frame = read_rest_file(folder / rest);
      } catch (const RigError& trouble) {
        source.refuse(*node, trouble.what());
      }
    }
  }
  if (const toml::table* table = section(source, file, "path")) {
    check_keys(source, *table, "in [path]", {"points", "up"});
    if (const auto* node = table->get("points"))
      chain.path.point = vectors_of(source, "points", *node);
    if (const auto* node = table->get("up")) {
      chain.path.up = vector_of(source, "up", *node);
      if (chain.path.up == glm::dvec3(0.0))
        source.refuse(*node, "'up' is zero, expected a direction");
    }
  }
  return chain;
}

Drawing drawing_of(const Source& source, const toml::node& node) {
  const auto* word = node.as_string();
  if (word && word->get() == "live") return Drawing::live;
  if (!word || word->get() != "frozen")
    source.refuse(node, "'drawing' expects \"frozen\" or \"live\"");
  return Drawing::frozen;
}

/// The rig of `file` after its chain was edited to `chain`.
void redraw(const Source& source, const toml::table& redrawn, LiveRig rig, const RestChain& chain,
            SolveFile& file) {
  try {
    file.drawing =
        rig.redraw(chain) ? "live: built again on [redrawn]" : "[redrawn] changes nothing";
  } catch (const RigError& trouble) {
    source.refuse(redrawn, "[redrawn]: " + std::string(trouble.what()));
  }
  file.system = std::move(rig).take();
}

/// The tables of `[[name]]`; none where the file has no such key.
std::vector<const toml::table*> tables_of(const Source& source, const toml::table& toml,
                                          const std::string& name, const std::string& keys) {
  std::vector<const toml::table*> tables;
  const toml::node* node = toml.get(name);
  if (!node) return tables;
  const toml::array* list = node->as_array();
  if (!list || list->empty() || !list->is_homogeneous(toml::node_type::table))
    source.refuse(*node, "'" + name + "' expects tables: [[" + name + "]] with " + keys);
  for (const toml::node& item : *list) tables.push_back(item.as_table());
  return tables;
}

std::vector<std::string> words_of(const Source& source, const toml::table& table,
                                  const std::string& key) {
  std::vector<std::string> words;
  const toml::node* node = table.get(key);
  if (!node) return words;
  const toml::array* list = node->as_array();
  if (!list || !list->is_homogeneous(toml::node_type::string))
    source.refuse(*node, "'" + key + "' expects a list of names");
  for (const toml::node& item : *list) words.push_back(item.as_string()->get());
  return words;
}

/// A name that a pose key can have: a letter, then letters, digits and _.
std::string name_of(const Source& source, const toml::table& table, const std::string& what) {
  const toml::node* node = table.get("name");
  if (!node) source.refuse(table, what + " has no name");
  const auto* word = node->as_string();
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto is_good = [&](char c) { return is_letter(c) || (c >= '0' && c <= '9') || c == '_'; };
  if (!word || word->get().empty() || !is_letter(word->get().front()) ||
      !std::all_of(word->get().begin(), word->get().end(), is_good))
    source.refuse(*node, "'name' of " + what + " expects a letter, then letters, digits and _");
  return word->get();
}

/// `[[control]]`s and `[[element]]`s in front of the rig's channels.
void add_controller(const Source& source, const toml::table& toml, SolveFile& file) {
  std::vector<SystemControl> controls;
  for (const toml::table* table : tables_of(source, toml, "control", "name and rest")) {
    check_keys(source, *table, "in [[control]]", {"name", "rest"});
    SystemControl control{name_of(source, *table, "[[control]]"), {0.0}};
    if (const toml::node* rest = table->get("rest")) {
      const OptionValue value = value_of(source, "rest", *rest);
      if (const double* number = std::get_if<double>(&value))
        control.rest = {*number};
      else if (const auto* numbers = std::get_if<std::vector<double>>(&value))
        control.rest = *numbers;
      else
        source.refuse(*rest, "'rest' expects a number or a list of numbers");
    }
    controls.push_back(std::move(control));
  }
  std::vector<DrivingElement> elements;
  const auto tables = tables_of(source, toml, "element", "name, inputs, weights and drives");
  for (const toml::table* table : tables) {
    check_keys(source, *table, "in [[element]]", {"name", "inputs", "weights", "drives"});
    DrivingElement element;
    element.name = name_of(source, *table, "[[element]]");
    element.inputs = words_of(source, *table, "inputs");
    element.drives = words_of(source, *table, "drives");
    const toml::node* weights = table->get("weights");
    if (!weights) source.refuse(*table, "element '" + element.name + "' has no weights");
    const OptionValue value = value_of(source, "weights", *weights);
    const auto* rows = std::get_if<std::vector<std::vector<double>>>(&value);
    if (!rows) source.refuse(*weights, "'weights' expects a list of rows: [[1, 0.5], [0, 1]]");
    element.weights = *rows;
    elements.push_back(std::move(element));
  }
  if (controls.empty() && elements.empty()) return;
  const toml::node& place = *toml.get(elements.empty() ? "control" : "element");
  if (elements.empty()) source.refuse(place, "[[control]] without [[element]] drives nothing");
  try {
    file.system =
        std::make_unique<DrivenSystem>(std::move(file.system), std::move(controls), elements);
  } catch (const RigError& trouble) {
    source.refuse(place, trouble.what());
  }
}

int line_of(const toml::table* table, const std::string& key) {
  const toml::node* node = table ? table->get(control_of(key)) : nullptr;
  return node ? int(node->source().begin.line) : 0;
}

void read_pose(const Source& source, const toml::table& pose, const SpineSystem& system,
               std::span<double> control) {
  for (const auto& [name, node] : pose) {
    const std::string key(name.str());
    try {
      if (const auto* inner = node.as_table()) {
        for (const auto& [channel, value] : *inner) {
          const std::string full = key + "." + std::string(channel.str());
          set_pose_key(system, full, value_of(source, full, value), control);
        }
      } else {
        set_pose_key(system, key, value_of(source, key, node), control);
      }
    } catch (const OptionError& trouble) {
      source.refuse(int(name.source().begin.line), trouble.what());
    }
  }
}

void read_keys(const Source& source, const toml::table& toml, SolveFile& file) {
  const toml::node* node = toml.get("key");
  if (!node) return;
  const toml::array* keys = node->as_array();
  if (!keys || keys->empty() || !keys->is_homogeneous(toml::node_type::table)) {
    source.refuse(*node, "'key' expects tables: [[key]] with time and pose");
  }
  for (const toml::node& item : *keys) {
    const toml::table& table = *item.as_table();
    check_keys(source, table, "in [[key]]", {"time", "pose"});
    const toml::node* time = table.get("time");
    if (!time) source.refuse(item, "[[key]] has no time");
    const OptionValue value = value_of(source, "time", *time);
    const double* number = std::get_if<double>(&value);
    if (!number) source.refuse(*time, "'time' expects a number");
    if (!file.key.empty() && !(*number > file.key.back().time)) {
      source.refuse(*time, "'time' is " + number_text(*number) + ", not after the key before (" +
                               number_text(file.key.back().time) + ")");
    }
    file.key.push_back({*number, file.control});
    if (const toml::table* pose = section(source, table, "pose")) {
      read_pose(source, *pose, *file.system, file.key.back().control);
    }
  }
  file.control = file.key.front().control;
}

}  // namespace

std::vector<double> SolveFile::control_at(double time) const {
  if (key.empty()) return control;
  const auto next = std::ranges::upper_bound(key, time, {}, &Key::time);
  if (next == key.begin()) return key.front().control;
  if (next == key.end()) return key.back().control;
  const Key &a = *(next - 1), &b = *next;
  const double share = (time - a.time) / (b.time - a.time);
  std::vector<double> between(a.control.size());
  for (std::size_t i = 0; i < between.size(); ++i) {
    between[i] = std::lerp(a.control[i], b.control[i], share);
  }
  return between;
}

SolveFile parse_solve_file(std::string_view text, const std::string& name,
                           const std::filesystem::path& folder) {
  const Source source{name};
  toml::table toml;
  try {
    toml = toml::parse(text);
  } catch (const toml::parse_error& trouble) {
    source.refuse(int(trouble.source().begin.line), std::string(trouble.description()));
  }
  check_keys(source, toml, "at the top",
             {"rig", "chain", "redrawn", "path", "control", "element", "pose", "key"});
  const toml::table* rig = section(source, toml, "rig");
  if (!rig) source.refuse(1, "no [rig] table: expected [rig] with system = \"...\"");
  SystemSpec spec;
  Drawing drawing = Drawing::frozen;
  for (const auto& [key, node] : *rig) {
    const std::string option(key.str());
    if (option == "drawing") {
      drawing = drawing_of(source, node);
    } else if (option != "system") {
      spec.options[option] = value_of(source, option, node);
    } else if (node.is_string()) {
      spec.system = node.as_string()->get();
    } else {
      source.refuse(node, "'system' must be a word");
    }
  }
  if (spec.system.empty()) source.refuse(*rig, "[rig] has no system");
  const RestChain chain = read_chain(source, toml, "chain", folder);

  SolveFile file;
  file.name = name;
  try {
    file.system = build_system(spec, chain);
  } catch (const OptionError& trouble) {
    source.refuse(line_of(rig, trouble.key), trouble.what());
  } catch (const RigError& trouble) {
    const toml::table* drawn = section(source, toml, "chain");
    const bool known = [&] {
      for (const SystemInfo& info : list_systems()) {
        if (info.name == spec.system) return true;
      }
      return false;
    }();
    const toml::node& place = known && drawn ? *static_cast<const toml::node*>(drawn)
                              : known        ? *static_cast<const toml::node*>(rig)
                                             : *rig->get("system");
    source.refuse(place, trouble.what());
  }
  if (const toml::table* redrawn = section(source, toml, "redrawn"))
    redraw(source, *redrawn, LiveRig(spec, chain, drawing),
           read_chain(source, toml, "redrawn", folder), file);
  add_controller(source, toml, file);
  for (const Channel& channel : file.system->channels()) file.control.push_back(channel.rest);
  if (const toml::table* pose = section(source, toml, "pose")) {
    read_pose(source, *pose, *file.system, file.control);
  }
  read_keys(source, toml, file);
  return file;
}

SolveFile read_solve_file(const std::filesystem::path& file) {
  return parse_solve_file(read_text(file), file.string(), file.parent_path());
}

}  // namespace backbend::solver
