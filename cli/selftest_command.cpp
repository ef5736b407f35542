#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/external_options.h"
#include "validate/files/data_folder.h"
#include "validate/selftest/selftest.h"
#include "validate/text/escape.h"
#include "validate/verdicts/exit_code.h"

namespace backbend::cli {

using namespace backbend::validate;

namespace {

/// Two digits, enough to compare with a bound.
std::string scientific(double value) {
  char text[32];
  std::snprintf(text, sizeof text, value == 0.0 ? "0" : "%.2g", value);
  return text;
}

/// How often the worst case would fit into what is allowed.
std::string margin_text(const Property& property) {
  const double margin = property.margin();
  return std::isinf(margin) ? "exact" : number_text(margin, margin < 10.0 ? 1 : 0) + "x";
}

void print(const std::vector<Property>& properties) {
  std::printf("%-7s %-60s %-12s %8s %8s %8s\n", "layer", "property", "on", "worst", "bound",
              "margin");
  for (const Property& each : properties) {
    std::printf("%-7s %-60s %-12s %8s %8s %8s  %s", each.layer.c_str(), each.name.c_str(),
                visible(each.subject).c_str(), scientific(each.worst).c_str(),
                scientific(each.bound).c_str(), margin_text(each).c_str(),
                each.holds() ? "holds" : "FAILS");
    if (!each.holds())
      std::printf(" at %s (%zu cases%s%s)", each.where.c_str(), each.cases,
                  each.unit.empty() ? "" : ", ", each.unit.c_str());
    std::printf("\n");
  }
}

/// Keys sorted; what is not finite as null.
void print_json(const std::vector<Property>& properties) {
  nlohmann::json rows = nlohmann::json::array();
  for (const Property& each : properties)
    rows.push_back({{"bound", each.bound},
                    {"cases", each.cases},
                    {"holds", each.holds()},
                    {"layer", each.layer},
                    {"property", each.name},
                    {"subject", visible(each.subject)},
                    {"unit", each.unit},
                    {"where", each.where},
                    {"worst", each.worst}});
  const nlohmann::json all = {{"schema", "backbend.selftest/1"}, {"properties", rows}};
  std::printf("%s\n", all.dump(1).c_str());
}

}  // namespace

void add_selftest(const Registry& registry) {
  struct Options {
    std::string character;
    std::vector<std::string> rigs;
    skin::AnatomyHints hints;
    bool full = false;
    ExternalOptions external;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = registry.add(
      "selftest", "test properties of solver, skinning and renderer on this machine",
      [options, &common = registry.common] {
        SelftestRequest request;
        request.character =
            options->character.empty()
                ? read_suite(data_folder() / "scenes" / "nightly.toml").characters.front()
                : std::filesystem::path(options->character);
        for (const std::string& rig : options->rigs) request.rigs.push_back(read_rig(rig));
        std::vector<RigPlan*> rigs;
        for (RigPlan& rig : request.rigs) rigs.push_back(&rig);
        options->external.apply_to(rigs);
        request.hints = options->hints;
        request.full = options->full;
        Progress progress(common.progress_style());
        const std::vector<Property> properties = selftest(request, progress);
        common.json ? print_json(properties) : print(properties);
        const bool holds = std::all_of(properties.begin(), properties.end(),
                                       [](const Property& each) { return each.holds(); });
        if (!common.json)
          std::printf(holds ? "all %zu properties hold\n" : "some of %zu properties do not hold\n",
                      properties.size());
        return holds ? kExitOk : kExitFindings;
      });
  options->rigs = {"three_bone", "curve", "isner", "even", "stretchy", "spline_ik", "matrix_blend"};
  command
      ->add_option("--rig", options->rigs,
                   "rig: a system, a rig file, or your own, live; repeatable")
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_option("--character", options->character, "character file [the bundled human]");
  command->add_flag("--full", options->full, "ten times the cases");
  options->external.add_to(command);
  add_anatomy_options(command, options->hints);
}

}  // namespace backbend::cli
