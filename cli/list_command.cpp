#include <cstdio>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/settings.h"
#include "render/trace/cameras.h"
#include "solver/rig/nearest_name.h"
#include "solver/rig/spine_system.h"
#include "validate/judge/judge_recorded.h"
#include "validate/sweeps/suite.h"
#include "validate/sweeps/sweep.h"
#include "validate/sweeps/sweep_named.h"
#include "validate/text/escape.h"
#include "validate/verdicts/checks.h"
#include "validate/verdicts/topics.h"

namespace backbend::cli {
namespace {

using namespace backbend::validate;

/// Rows of name and text: two columns on a terminal, an array of objects as JSON.
class Rows {
 public:
  void add(std::string name, std::string text) {
    rows_.emplace_back(std::move(name), std::move(text));
  }

  int print(bool as_json) const {
    if (as_json) {
      nlohmann::json list = nlohmann::json::array();
      for (const auto& [name, text] : rows_) list.push_back({{"name", name}, {"summary", text}});
      std::printf("%s\n", list.dump(2).c_str());
      return 0;
    }
    std::size_t width = 0;
    for (const auto& row : rows_) width = std::max(width, row.first.size());
    for (const auto& [name, text] : rows_)
      std::printf("%-*s  %s\n", static_cast<int>(width), name.c_str(), text.c_str());
    return 0;
  }

 private:
  std::vector<std::pair<std::string, std::string>> rows_;
};

Rows rig_rows() {
  Rows rows;
  for (const solver::SystemInfo& info : solver::list_systems())
    rows.add(std::string(info.name), std::string(info.summary));
  return rows;
}

std::string sweep_text(const Sweep& sweep) {
  if (!sweep.through.empty())
    return std::to_string(sweep.through.size()) + " poses and the way between them, " +
           number_text(sweep.to_deg) + " degrees by " + number_text(sweep.step_deg);
  std::string text = number_text(sweep.from_deg) + " to " + number_text(sweep.to_deg) + " by " +
                     number_text(sweep.step_deg) +
                     (sweep.channel == "stretch" ? " per cent of " : " degrees of ") +
                     sweep.channel;
  for (const std::string_view channel : kChannels) {
    const double ratio = *sweep.per_degree.find(channel);
    if (channel != sweep.channel && ratio != 0.0)
      text += ", " + std::string(channel) + " " + number_text(ratio) + " of it";
  }
  return text;
}

Rows sweep_rows() {
  Rows rows;
  for (const Sweep& sweep : bundled_sweeps()) rows.add(sweep.name, sweep_text(sweep));
  for (const Sweep& sweep : stress_sweeps()) rows.add("stress " + sweep.name, sweep_text(sweep));
  rows.add("stress grid", sweep_text(grid_sweeps().front()) +
                              "; each at side -60 to 60 by 30 and twist -90 to 90 by 45");
  return rows;
}

/// The limit of a clip, of which only the motion is known.
Limit clip_limit(const Check& check) { return clip_limits().of(check.code); }
bool on_clips(const Check& check) { return clip_limit(check).value != check.limit; }

/// `at most 2 deg`
std::string limit_text(const Check& check) {
  return std::string(name_of(check.sense)) + " " + number_text(check.limit) + " " +
         std::string(check.unit);
}

Rows check_rows() {
  Rows rows;
  for (const Check& check : all_checks()) {
    rows.add(std::string(check.code),
             std::string(check.name) + ": " + std::string(check.measures) + "; " +
                 limit_text(check) +
                 (on_clips(check) ? ", on clips " + number_text(clip_limit(check).value) : ""));
  }
  return rows;
}

Rows view_rows() {
  Rows rows;
  for (const std::string_view view : render::view_names()) rows.add(std::string(view), "");
  return rows;
}

int print_topic(const Topic& topic, bool json) {
  if (json) {
    const nlohmann::json object = {
        {"topic", topic.name}, {"means", topic.means}, {"more", topic.more}, {"try", topic.act}};
    std::printf("%s\n", object.dump(2).c_str());
    return 0;
  }
  const auto line = [](const char* head, std::string_view text) {
    std::printf("  %-9s %.*s\n", head, static_cast<int>(text.size()), text.data());
  };
  std::printf("%.*s\n", static_cast<int>(topic.name.size()), topic.name.data());
  line("means", topic.means);
  line("how", topic.more);
  line("try", topic.act);
  return 0;
}

int print_checks_json() {
  nlohmann::json list = nlohmann::json::array();
  for (const Check& check : all_checks()) {
    list.push_back({{"code", check.code},
                    {"name", check.name},
                    {"measures", check.measures},
                    {"unit", check.unit},
                    {"limit", check.limit},
                    {"clip_limit", clip_limit(check).value},
                    {"sense", name_of(check.sense)},
                    {"decides", check.decides},
                    {"owner", name_of(check.owner)},
                    {"reason", check.reason}});
  }
  std::printf("%s\n", list.dump(2).c_str());
  return 0;
}

}  // namespace

void add_list(const Registry& registry) {
  auto what = std::make_shared<std::string>();
  CLI::App* command =
      registry.add("list", "list rigs, sweeps, checks or views", [what, &common = registry.common] {
        if (*what == "rigs") return rig_rows().print(common.json);
        if (*what == "sweeps") return sweep_rows().print(common.json);
        if (*what == "checks") return common.json ? print_checks_json() : check_rows().print(false);
        return view_rows().print(common.json);
      });
  command->add_option("what", *what, "rigs, sweeps, checks or views")
      ->required()
      ->check(CLI::IsMember({"rigs", "sweeps", "checks", "views"}));
}

void add_explain(const Registry& registry) {
  struct Options {
    std::string code, suite, character;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = registry.add(
      "explain", "explain a code or a word of the report: meaning, measure, what to try",
      [options, &common = registry.common] {
        const std::string* code = &options->code;
        if (const Topic* topic = find_topic(*code)) return print_topic(*topic, common.json);
        const Check* check = find_check(*code);
        if (check == nullptr) {
          std::vector<std::string> known;
          for (const Check& each : all_checks()) known.emplace_back(each.code);
          for (const Topic& each : all_topics()) known.emplace_back(each.name);
          throw CLI::ValidationError("no check or word '" + *code + "'" +
                                     solver::did_you_mean(*code, known) +
                                     "; backbend list checks shows all checks");
        }
        std::vector<Limit> history;
        if (!options->suite.empty()) {
          history = limits_for(read_suite(options->suite).rules, options->character).history(*code);
        }
        const std::pair<const char*, std::string> lines[] = {
            {"measures", std::string(check->measures)},
            {"limit",
             limit_text(*check) + (check->decides ? "" : " (advisory: never fails a rig)")},
            {"why", std::string(check->reason)},
            {"on clips", on_clips(*check)
                             ? std::string(name_of(check->sense)) + " " +
                                   number_text(clip_limit(*check).value) + " " +
                                   std::string(check->unit) + ": " + clip_limit(*check).reason
                             : ""},
            {"owner", std::string(name_of(check->owner))},
            {"cause", std::string(check->cause)},
            {"try", std::string(check->remedy)},
            {"repair", check->owner == Owner::weights || check->code == "BB060" ||
                               check->code == "BB061" || check->code == "BB062"
                           ? "backbend repair CHARACTER -o OUT.glb, where the weights are at fault"
                           : ""},
            {"export", check->owner == Owner::solver || check->owner == Owner::rig
                           ? "backbend export even --to blender|maya|json --for CHARACTER -o FILE: "
                             "our spine on your joints; check CHARACTER --rig even measures it"
                           : ""},
            {"tune", check->owner == Owner::solver
                         ? "backbend tune RIG --for CHARACTER -o RIG.toml, where a rig of ours is "
                           "at fault"
                         : ""},
            {"picture", std::string(check->witness)},
            {"source", std::string(check->source)}};
        if (common.json) {
          nlohmann::json object = {{"code", check->code},
                                   {"name", check->name},
                                   {"default_limit", check->limit},
                                   {"unit", check->unit}};
          for (const auto& [key, text] : lines) object[key] = text;
          for (const Limit& limit : history)
            object["limits"].push_back({{"value", limit.value},
                                        {"layer", name_of(limit.layer)},
                                        {"origin", valid_utf8(limit.origin)},
                                        {"owner", valid_utf8(limit.owner)},
                                        {"reason", valid_utf8(limit.reason)}});
          std::printf("%s\n", object.dump(2).c_str());
          return 0;
        }
        std::printf("%s %s\n", std::string(check->code).c_str(), std::string(check->name).c_str());
        for (const auto& [key, text] : lines) {
          if (!text.empty()) std::printf("  %-9s %s\n", key, text.c_str());
        }
        for (std::size_t i = 0; i < history.size(); ++i) {
          const Limit& limit = history[i];
          const bool in_force = i + 1 == history.size();
          std::printf("  %-9s %s: %s %s, %s (%s; %s)\n", in_force ? "in force" : "before",
                      std::string(name_of(limit.layer)).c_str(),
                      number_text(limit.value, 6).c_str(), std::string(check->unit).c_str(),
                      visible(limit.reason).c_str(), visible(limit.owner).c_str(),
                      visible(limit.origin).c_str());
        }
        return 0;
      });
  command
      ->add_option("code", options->code,
                   "a code such as BB001, or a word of the report such as SOLVER or envelope")
      ->required();
  CLI::Option* suite =
      command
          ->add_option("--suite", options->suite,
                       "suite file whose limits apply: shows where the limit comes from")
          ->type_name(kFileType)
          ->configurable();
  command->add_option("--for", options->character, "with --suite: the character's name")
      ->needs(suite);
}

}  // namespace backbend::cli
