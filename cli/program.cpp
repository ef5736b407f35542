#include "cli/program.h"

#include <cstdio>

#include "cli/judging_commands.h"
#include "cli/prove_command.h"
#include "cli/search_commands.h"
#include "cli/serve_command.h"
#include "cli/settings.h"
#include "validate/text/escape.h"

namespace backbend::cli {

Program::Program()
    : app("backbend finds out whether a character's spine rig can be trusted, and shows it.",
          "backbend") {
  app.set_version_flag("--version", "backbend " BACKBEND_VERSION);
  app.require_subcommand(1);
  // The last of repeated options counts, so that a script's defaults can be overridden. Options
  // that a project or the environment may set are marked one by one.
  app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast)->configurable(false);
  app.fallthrough();
  app.add_flag("-q,--quiet", common.quiet, "no progress on standard error")->configurable();
  app.add_flag("--json", common.json, "one JSON object on standard output");
  app.add_option("--threads", common.threads, "threads to use, 0 for all cores [0]")
      ->check(CLI::Range(0, 1024))
      ->configurable();
  // Evaluated before a command runs, in settings.cpp.
  CLI::Option* project =
      app.add_option("--project",
                     "project file with defaults for options [BACKBEND_PROJECT, or the nearest "
                     "backbend.toml above what is judged]")
          ->type_name(kFileType)
          ->expected(1);
  app.add_flag_function(
         "--no-project", [](std::int64_t) {}, "ignore project files")
      ->excludes(project);

  const Registry registry{app, common, chosen};
  add_nightly(registry);
  add_check(registry);
  add_compare(registry);
  add_hunt(registry);
  add_why(registry);
  add_tune(registry);
  add_render(registry);
  add_turntable(registry);
  add_solve(registry);
  add_inspect(registry);
  add_repair(registry);
  add_export(registry);
  add_bake(registry);
  add_body(registry);
  add_calibrate(registry);
  add_diff(registry);
  add_report(registry);
  add_history(registry);
  add_approve(registry);
  add_prune(registry);
  add_list(registry);
  add_explain(registry);
  add_config(registry);
  add_bench(registry);
  add_selftest(registry);
  add_prove(registry);
  add_merge(registry);
  add_farm(registry);
  add_serve(registry);
  add_completions(registry);
}

std::filesystem::path take_surroundings(Program& program) {
  CLI::App& command = program.command();
  if (!takes_settings(command)) return {};
  const std::optional<validate::Project> project = project_for(program.app, command);
  const std::vector<Setting> settings =
      take_settings(program.app, command, project ? &*project : nullptr);
  for (const Setting& each : settings)
    if (each.origin == Origin::project) program.common.from_project.insert(each.option);
  const std::string note = note_of(settings);
  if (!note.empty() && !program.common.quiet)
    std::fprintf(stderr, "%s\n", validate::visible(note).c_str());
  return project ? project->file : std::filesystem::path();
}

}  // namespace backbend::cli
