#include <nlohmann/json.hpp>

#include "validate/farm/job.h"
#include "validate/text/json_object.h"
#include "validate/text/shell_word.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;

std::string shard_script(const FarmJob& job) {
  std::string text =
      "#!/usr/bin/env bash\n"
      "# One share of the job: I/N, or by itself that of a Slurm array task; several: "
      "FIRST-LAST/N.\n"
      "# Exit 75 means that it is worth trying again (RequeueExit=75 in slurm.conf).\n"
      "set -euo pipefail\n"
      "cd -- " +
      shell_quoted(job.folder.string()) + "\nshare() {\n  exec " + shell_quoted(job.program) +
      " --quiet --no-project --threads " + "\"${SLURM_CPUS_PER_TASK:-0}\" nightly";
  for (const std::string& word : job.arguments) text += " " + shell_quoted(word);
  return text + " -o " + shell_quoted(job.run.string()) +
         " --shard \"$1\"\n}\n"
         "if [[ ${1:-auto} =~ ^([0-9]+)-([0-9]+)/([0-9]+)$ ]]; then\n"
         "  trap 'kill \"$child\"; wait \"$child\"' TERM INT\n"
         "  for ((i = BASH_REMATCH[1]; i <= BASH_REMATCH[2]; ++i)); do\n"
         "    share \"$i/${BASH_REMATCH[3]}\" &\n"
         "    child=$!\n"
         "    wait \"$child\"\n"
         "  done\n"
         "else\n"
         "  share \"${1:-auto}\"\n"
         "fi\n";
}

std::string merge_script(const FarmJob& job) {
  return "#!/usr/bin/env bash\n"
         "# Puts the shares together and writes the report; exit 4 names what is missing.\n"
         "set -euo pipefail\n"
         "cd -- " +
         shell_quoted(job.folder.string()) + "\nexec " + shell_quoted(job.program) +
         " --quiet merge " + shell_quoted(job.run.string()) + "\n";
}

std::string farm_file(const FarmJob& job, const std::string& name) {
  return (job.run / "farm" / name).string();
}

/// Slurm gives % a meaning in names of files.
std::string log_pattern(const FarmJob& job, const std::string& name) {
  std::string text;
  for (const char c : (job.run / "farm").string())
    text += c == '%' ? std::string("%%") : std::string(1, c);
  return shell_quoted(text + "/" + name);
}

}  // namespace

FarmScripts slurm_scripts(const FarmJob& job) {
  const std::string submit =
      "#!/usr/bin/env bash\n"
      "# Submits the shares as an array, and the merge to run when all of them have ended. "
      "Further\n"
      "# arguments go to sbatch: --partition=..., --cpus-per-task=...\n"
      "set -euo pipefail\n"
      "job=$(sbatch --parsable --job-name=backbend --array=1-" +
      std::to_string(job.shards) +
      " --requeue --open-mode=append --output=" + log_pattern(job, "shard_%a.log") + " \"$@\" " +
      shell_quoted(farm_file(job, "shard.sh")) +
      ")\n"
      // Not afterok: what is missing is for the merge to say.
      "sbatch --parsable --job-name=backbend_merge --dependency=\"afterany:${job%%;*}\" "
      "--kill-on-invalid-dep=yes --requeue --open-mode=append --output=" +
      log_pattern(job, "merge.log") + " \"$@\" " + shell_quoted(farm_file(job, "merge.sh")) + "\n";
  return {{{"shard.sh", shard_script(job)}, {"merge.sh", merge_script(job)}, {"submit.sh", submit}},
          "submit.sh"};
}

FarmScripts parallel_scripts(const FarmJob& job) {
  const std::string start =
      "#!/usr/bin/env bash\n"
      "# All shares by GNU parallel, then the merge. Further arguments go to parallel: --jobs 4,\n"
      "# --sshloginfile ... (the folders must be the same on every machine).\n"
      "set -uo pipefail\n"
      "seq 1 " +
      std::to_string(job.shards) + " | parallel --will-cite --joblog " +
      shell_quoted(farm_file(job, "joblog.tsv")) + " --retries 3 \"$@\" bash " +
      // What parallel starts goes through a shell once more.
      shell_quoted(shell_quoted(farm_file(job, "shard.sh"))) + " '{}/" +
      std::to_string(job.shards) + "'\n" + "exec bash " + shell_quoted(farm_file(job, "merge.sh")) +
      "\n";
  return {{{"shard.sh", shard_script(job)}, {"merge.sh", merge_script(job)}, {"run.sh", start}},
          "run.sh"};
}

/// A farm that sees shares end sooner than this may give a worker several of them at once.
constexpr int kChunkSeconds = 300;

/// Source: Open Job Description, template schemas 2023-09, 3.4.1.5 `CHUNK[INT]`: a worker is given
/// its shares as FIRST-LAST.
FarmScripts openjd_scripts(const FarmJob& job) {
  using nlohmann::ordered_json;
  const auto script = [&](const std::string& file, const std::vector<std::string>& more) {
    std::vector<std::string> words = {farm_file(job, file)};
    words.insert(words.end(), more.begin(), more.end());
    return ordered_json(JsonObject<ordered_json>().with(
        "actions",
        JsonObject<ordered_json>().with(
            "onRun", JsonObject<ordered_json>().with("command", "bash").with("args", words))));
  };
  ordered_json shards =
      JsonObject<ordered_json>()
          .with("name", "Shards")
          .with("parameterSpace",
                JsonObject<ordered_json>().with(
                    "taskParameterDefinitions",
                    ordered_json::array(
                        {JsonObject<ordered_json>()
                             .with("name", "Shard")
                             .with("type", "CHUNK[INT]")
                             .with("range", "1-" + std::to_string(job.shards))
                             .with("chunks", JsonObject<ordered_json>()
                                                 .with("defaultTaskCount", 1)
                                                 .with("targetRuntimeSeconds", kChunkSeconds)
                                                 .with("rangeConstraint", "CONTIGUOUS"))})))
          .with("script",
                script("shard.sh", {"{{Task.Param.Shard}}/" + std::to_string(job.shards)}));
  ordered_json merge =
      JsonObject<ordered_json>()
          .with("name", "Merge")
          .with("dependencies",
                ordered_json::array({JsonObject<ordered_json>().with("dependsOn", "Shards")}))
          .with("script", script("merge.sh", {}));
  const ordered_json job_template = JsonObject<ordered_json>()
                                        .with("specificationVersion", "jobtemplate-2023-09")
                                        .with("extensions", ordered_json::array({"TASK_CHUNKING"}))
                                        .with("name", "backbend nightly")
                                        .with("steps", ordered_json::array({shards, merge}));
  return {{{"shard.sh", shard_script(job)},
           {"merge.sh", merge_script(job)},
           {"template.json",
            job_template.dump(2, ' ', true, ordered_json::error_handler_t::replace) + "\n"}},
          "template.json"};
}

}  // namespace backbend::validate
