#include "validate/serve/tool_table.h"

#include <algorithm>

#include "render/trace/cameras.h"
#include "solver/rig/nearest_name.h"
#include "validate/sweeps/external_spec.h"
#include "validate/sweeps/suite.h"
#include "validate/text/escape.h"
#include "validate/text/json_object.h"

namespace backbend::validate {
namespace {

using nlohmann::json;

constexpr std::size_t kMostWordBytes = 4096;

const ToolArgument kCharacter{"character", "", "character file: .glb, .gltf, .fbx or .dae",
                              ArgumentKind::file, true};
const ToolArgument kRig{
    "rig", "--rig",
    "rig: a system (list, what=rigs), the same with options (curve:length=rest), or a rig file "
    "[even]",
    ArgumentKind::rig};
const ToolArgument kMapping{"mapping",
                            "--mapping",
                            "how a body pose reaches the controls [chest]",
                            ArgumentKind::choice,
                            false,
                            {"chest", "spread"}};
const ToolArgument kSweeps{"sweeps",
                           "--sweeps",
                           "which motions are measured [standard; for compare stress]",
                           ArgumentKind::choice,
                           false,
                           {"standard", "stress"}};

std::vector<std::string_view> views() {
  const auto names = render::view_names();
  return {names.begin(), names.end()};
}

std::vector<Tool> made_tools() {
  return {
      {"check",
       "Check a character or a clip",
       "Judges a character's weights under a rig, or with `clip` the motion of its own rig. "
       "Returns the verdict, headroom for each channel in degrees, and findings with place, value, "
       "limit and owner (who must act). Nothing is written unless `output` is given.",
       {"check", "--json"},
       {{"character", "", "character file: .glb, .gltf, .fbx or .dae", ArgumentKind::file},
        {"clip", "--baked", "motion to judge instead of our rig: .glb, .fbx, .bvh, .clip, ...",
         ArgumentKind::file},
        kRig,
        kMapping,
        {"envelope",
         "--envelope",
         "required range of motion [auto: by the kind of body]",
         ArgumentKind::choice,
         false,
         {"auto", "human", "animal", "long_neck", "snake", "neck", "cartoon", "creature", "sweep"}},
        kSweeps,
        {"output", "-o", "run folder to write: report, page, pictures", ArgumentKind::output}}},
      {"explain",
       "Explain a check or a word",
       "What a check (BB011) or a word of the report (WEIGHTS, envelope) means, how it is "
       "measured, its limit with the reason, and what to try.",
       {"explain", "--json"},
       {{"code", "", "a code such as BB001, or a word of the report", ArgumentKind::word, true},
        {"suite", "--suite", "suite file whose limits apply", ArgumentKind::file},
        {"for", "--for", "with suite: the character's name"}}},
      {"compare",
       "Compare two of a kind",
       "Compares two rigs, characters, clips or run folders pose by pose: who is ahead, by which "
       "check, at which poses. Nothing is written unless `output` is given.",
       {"compare", "--json"},
       {{"a", "", "the proposed rig; or the earlier character, clip or run folder",
         ArgumentKind::subject, true},
        {"b", "", "the rig to compare with; or the later one", ArgumentKind::subject, true},
        {"character", "--character", "character file, for rigs and clips [the bundled human]",
         ArgumentKind::file},
        kRig,
        kMapping,
        kSweeps,
        {"output", "-o", "run folder to write: report, page, pictures", ArgumentKind::output}}},
      {"repair",
       "Repair weights",
       "Repairs weights that check finds at fault and measures again: what was found before and "
       "after, what was changed. Without `output` and `weights` it writes nothing (a dry run).",
       {"repair", "--json"},
       {kCharacter,
        {"output", "-o", "the .glb to write: the character with other weights",
         ArgumentKind::output},
        {"weights", "--weights",
         "write the weights alone: .xml (Maya), .json (mGear), .py (Blender)",
         ArgumentKind::output}}},
      {"picture",
       "Picture of a pose",
       "Renders the character in a pose under a rig and returns the picture as PNG.",
       {"render", "-o", "-"},
       {kCharacter,
        kRig,
        kMapping,
        {"pose", "--pose",
         "channel=degrees, separated by commas: extension=90,side=10; channels are extension, "
         "flexion, side, twist, hip, and stretch in per cent [rest]"},
        {"view", "--view", "camera [profile]", ArgumentKind::choice, false, views()},
        {"mode",
         "--mode",
         "what is shown; heat is strain [clay]",
         ArgumentKind::choice,
         false,
         {"beauty", "clay", "wireframe", "heat", "xray", "contour"}},
        {"width", "", "pixels, 64 to 1920 [640]", ArgumentKind::number, false, {}, 64, 1920},
        {"height", "", "pixels, 64 to 1080 [360]", ArgumentKind::number, false, {}, 64, 1080},
        {"samples",
         "--spp",
         "samples a pixel, 1 to 256 [16]",
         ArgumentKind::number,
         false,
         {},
         1,
         256}},
       true},
      {"inspect",
       "Inspect a character",
       "How a character file was understood: skeleton, spine and arms as found, meshes, weights.",
       {"inspect", "--json"},
       {kCharacter}},
      {"list",
       "List names",
       "The rigs, sweeps, checks (with limits and reasons) or camera views there are.",
       {"list", "--json"},
       {{"what",
         "",
         "what to list",
         ArgumentKind::choice,
         true,
         {"rigs", "sweeps", "checks", "views"}}}},
  };
}

json schema_of(const ToolArgument& argument) {
  json schema = JsonObject<json>()
                    .with("description", argument.description)
                    .with("type", argument.kind == ArgumentKind::number ? "integer" : "string");
  if (argument.kind == ArgumentKind::choice) schema["enum"] = argument.choices;
  if (argument.kind == ArgumentKind::number) {
    schema["minimum"] = argument.low;
    schema["maximum"] = argument.high;
  } else {
    schema["maxLength"] = kMostWordBytes;
  }
  return schema;
}

bool writes(const Tool& tool) {
  return std::ranges::any_of(
      tool.arguments, [](const ToolArgument& each) { return each.kind == ArgumentKind::output; });
}

[[noreturn]] void fail(const ToolArgument& argument, const std::string& what) {
  throw ArgumentError("'" + std::string(argument.name) + "': " + what);
}

std::string number_word(const ToolArgument& argument, const json& value) {
  if (!value.is_number_integer()) fail(argument, "expected a whole number");
  const auto number = value.is_number_unsigned() && value.get<std::uint64_t>() > INT32_MAX
                          ? INT64_MAX
                          : value.get<std::int64_t>();
  if (number < argument.low || number > argument.high)
    fail(argument,
         "expected " + std::to_string(argument.low) + " to " + std::to_string(argument.high));
  return std::to_string(number);
}

/// A rig of the studio's own is a program, which a client must not start.
void refuse_programs(const ToolArgument& argument, const solver::SystemSpec& spec) {
  if (is_external(spec))
    fail(argument, "rigs that start a program are not for clients; run backbend check --rig");
}

/// A rig by name, or by a file inside the server's folders.
void check_rig(const ToolArgument& argument, const std::string& word, const FileAccess& files) {
  const bool is_file = std::filesystem::path(word).extension() == ".toml";
  if (is_file) files.require_inside(word);
  refuse_programs(argument, read_rig(is_file ? (files.first() / word).string() : word).spec);
}

/// What compare takes: as it does, a word is a rig where nothing of that name is there.
void check_subject(const ToolArgument& argument, const std::string& word, const FileAccess& files) {
  const std::filesystem::path path = files.first() / word;
  std::error_code none;
  const bool looks_like_file = word.find('/') != std::string::npos ||
                               (path.has_extension() && word.find(':') == std::string::npos);
  if (!looks_like_file && !std::filesystem::exists(path, none))
    return check_rig(argument, word, files);
  files.require_inside(word);
  if (path.extension() == ".toml" && is_rig_file(path)) check_rig(argument, word, files);
}

std::string checked_word(const ToolArgument& argument, const json& value, const FileAccess& files) {
  if (argument.kind == ArgumentKind::number) return number_word(argument, value);
  if (!value.is_string()) fail(argument, "expected a string");
  const std::string word = value.get<std::string>();
  if (word.empty() || word.size() > kMostWordBytes)
    fail(argument, "expected 1 to " + std::to_string(kMostWordBytes) + " bytes");
  if (word.find('\0') != std::string::npos) fail(argument, "holds a NUL");
  // The line's reader would take it for an option, and `-` for standard output.
  if (word.front() == '-') fail(argument, "must not begin with '-'");
  switch (argument.kind) {
    case ArgumentKind::choice:
      if (std::ranges::find(argument.choices, word) == argument.choices.end()) {
        const std::vector<std::string> choices(argument.choices.begin(), argument.choices.end());
        fail(argument, "no '" + visible(word) + "'" + solver::did_you_mean(word, choices));
      }
      break;
    case ArgumentKind::file:
      files.require_inside(word);
      break;
    case ArgumentKind::rig:
      check_rig(argument, word, files);
      break;
    case ArgumentKind::subject:
      check_subject(argument, word, files);
      break;
    case ArgumentKind::output:
      files.require_new(word);
      break;
    default:
      break;
  }
  return word;
}

void refuse_unknown(const Tool& tool, const json& arguments, bool may_write) {
  for (const auto& [name, value] : arguments.items()) {
    const auto known = std::ranges::find(tool.arguments, name, &ToolArgument::name);
    if (known == tool.arguments.end()) {
      std::vector<std::string> names;
      for (const ToolArgument& each : tool.arguments) names.emplace_back(each.name);
      throw ArgumentError("no argument '" + visible(name) + "'" +
                          solver::did_you_mean(name, names));
    }
    if (known->kind == ArgumentKind::output && !may_write)
      fail(*known, "this server only reads; start it with backbend serve --stdio --allow-write");
  }
}

/// Words of options that no single argument stands for.
void add_joint_words(const Tool& tool, const json& arguments, std::vector<std::string>& words) {
  const auto has = [&](const char* name) { return arguments.contains(name); };
  if (tool.name == "picture" && (has("width") || has("height"))) {
    const auto side = [&](const char* name, int otherwise) {
      return std::to_string(arguments.value(name, otherwise));
    };
    words.insert(words.end(), {"--res", side("width", 640) + "x" + side("height", 360)});
  }
  if ((tool.name == "check" || tool.name == "compare") && !has("output"))
    words.insert(words.end(), {"-o", "-"});
  if (tool.name == "repair" && !has("output") && !has("weights")) words.emplace_back("--dry-run");
}

}  // namespace

std::span<const Tool> all_tools() {
  static const std::vector<Tool> tools = made_tools();
  return tools;
}

const Tool* find_tool(std::string_view name) {
  const auto tools = all_tools();
  const auto found = std::ranges::find(tools, name, &Tool::name);
  return found == tools.end() ? nullptr : &*found;
}

json tool_description(const Tool& tool, bool may_write) {
  json properties = json::object(), required = json::array();
  for (const ToolArgument& each : tool.arguments) {
    if (each.kind == ArgumentKind::output && !may_write) continue;
    properties[std::string(each.name)] = schema_of(each);
    if (each.required) required.push_back(each.name);
  }
  json schema = JsonObject<json>()
                    .with("type", "object")
                    .with("properties", properties)
                    .with("additionalProperties", false);
  if (!required.empty()) schema["required"] = required;
  return JsonObject<json>()
      .with("name", tool.name)
      .with("title", tool.title)
      .with("description", tool.description)
      .with("inputSchema", schema)
      .with("annotations", JsonObject<json>()
                               .with("title", tool.title)
                               .with("readOnlyHint", !(may_write && writes(tool)))
                               .with("destructiveHint", false)
                               .with("idempotentHint", !(may_write && writes(tool)))
                               .with("openWorldHint", false));
}

std::vector<std::string> words_of(const Tool& tool, const json& arguments, const FileAccess& files,
                                  bool may_write) {
  if (!arguments.is_object()) throw ArgumentError("'arguments' is not an object");
  refuse_unknown(tool, arguments, may_write);
  std::vector<std::string> words(tool.words.begin(), tool.words.end()), positional;
  for (const ToolArgument& each : tool.arguments) {
    const auto value = arguments.find(each.name);
    if (value == arguments.end()) {
      if (each.required) fail(each, "is missing");
      continue;
    }
    const std::string word = checked_word(each, *value, files);
    if (!each.option.empty()) {
      words.emplace_back(each.option);
      words.push_back(word);
    } else if (each.kind != ArgumentKind::number) {
      positional.push_back(word);
    }
  }
  add_joint_words(tool, arguments, words);
  // After it nothing is an option or a command, whatever it looks like.
  if (!positional.empty()) words.emplace_back("--");
  words.insert(words.end(), positional.begin(), positional.end());
  return words;
}

}  // namespace backbend::validate
