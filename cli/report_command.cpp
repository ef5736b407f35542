#include <cstdio>

#include "cli/commands.h"
#include "validate/files/output_folder.h"
#include "validate/model/report_json.h"
#include "validate/night/run.h"

namespace backbend::cli {

using namespace backbend::validate;

void add_report(const Registry& registry) {
  struct Options {
    std::string file, output;
    bool single_file = false;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command =
      registry.add("report", "rewrite page, JUnit, Markdown and CSV from a report.json", [options] {
        const std::filesystem::path file(options->file);
        const Report report = parse_report(read_text(file), options->file);
        const std::filesystem::path folder =
            options->output.empty() ? file.parent_path() : std::filesystem::path(options->output);
        write_report(report, folder, {file.parent_path(), options->single_file});
        std::printf("%s\n", (folder / "index.html").c_str());
        return 0;
      });
  command->add_option("file", options->file, "report.json of a run")->required();
  command->add_option("-o,--output", options->output, "folder for the files [that of report.json]");
  command->add_flag("--single-file", options->single_file, "embed every picture in the page")
      ->configurable();
}

}  // namespace backbend::cli
