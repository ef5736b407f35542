#include <cstdio>

#include "cli/commands.h"
#include "cli/judging_commands.h"
#include "validate/export/even_export.h"
#include "validate/files/output_folder.h"
#include "validate/files/replaceable.h"
#include "validate/sweeps/suite.h"
#include "validate/text/escape.h"
#include "validate/text/shell_word.h"
#include "validate/verdicts/exit_code.h"

namespace backbend::cli {

namespace fs = std::filesystem;
using namespace backbend::validate;

namespace {

struct ExportOptions {
  std::string rig, program, character, output;
  skin::AnatomyHints hints;
};

std::string text_for(const std::string& program, const EvenExport& from) {
  if (program == "blender") return even_blender_script(from);
  if (program == "maya") return even_maya_script(from);
  return even_graph_json(from);
}

/// What to type next in the program that the file is for; empty for JSON.
std::string next_step(const std::string& program, const std::string& script,
                      const std::string& character) {
  const std::string stem = fs::path(character).stem().string();
  if (program == "blender")
    return "next: blender " + shell_word(stem + ".blend") + " --background --python " +
           shell_word(script) + " -- -o " + shell_word(stem + "_even.blend");
  if (program == "maya")
    return "next, in Maya's script editor: exec(open(\"" + fs::path(script).filename().string() +
           "\").read())";
  return {};
}

int run_export(const ExportOptions& options, const Common& common) {
  const fs::path file(options.output);
  const std::string ending = options.program == "json" ? ".json" : ".py";
  if (file.extension() != ending)
    throw CLI::ValidationError("-o: '" + options.output + "': expected a name that ends in " +
                               ending);
  const solver::SystemSpec rig = read_rig(options.rig).spec;
  const OutputFolder folder(file.parent_path());
  require_replaceable(file);
  folder.prepare();
  const EvenExport made = export_even(options.character, options.hints, rig);
  folder.write(file.filename(), text_for(options.program, made));
  std::fputs(common.json ? even_graph_json(made).c_str() : even_export_text(made).c_str(), stdout);
  std::fflush(stdout);
  if (!common.quiet) {
    std::fprintf(stderr, "wrote %s\n", visible(options.output).c_str());
    const std::string next = next_step(options.program, options.output, options.character);
    if (!next.empty()) std::fprintf(stderr, "%s\n", visible(next).c_str());
  }
  return kExitOk;
}

}  // namespace

void add_export(const Registry& registry) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* command =
      registry.add("export", "write our spine 'even' as a native rig for Blender, Maya or as JSON",
                   [options, &common = registry.common] { return run_export(*options, common); });
  command->add_option("rig", options->rig, "even, even:OPTIONS, or a TOML file with such a [rig]")
      ->required();
  command->add_option("--to", options->program, "the program that the file is for")
      ->required()
      ->check(CLI::IsMember({"blender", "maya", "json"}));
  command->add_option("--for", options->character, "character on whose joints the rig is built")
      ->required();
  command->add_option("-o,--output", options->output, "the file to write: .py, or .json")
      ->required();
  add_anatomy_options(command, options->hints);
}

}  // namespace backbend::cli
