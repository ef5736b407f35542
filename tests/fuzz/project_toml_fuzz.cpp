#include "tests/fuzz/target.h"
#include "validate/files/project.h"

namespace backbend::fuzz {
namespace {

using validate::ProjectKind;

/// Every value is asked for as its command would.
bool run(Input input) {
  static const validate::ProjectKeys keys = {{"",
                                              {{"threads", ProjectKind::number},
                                               {"quiet", ProjectKind::flag},
                                               {"rig", ProjectKind::text},
                                               {"history", ProjectKind::text},
                                               {"joint-map", ProjectKind::texts}}},
                                             {"check",
                                              {{"rig", ProjectKind::text},
                                               {"quick", ProjectKind::flag},
                                               {"joint-map", ProjectKind::texts}}},
                                             {"history", {{"nights", ProjectKind::number}}}};
  try {
    const validate::Project project =
        validate::parse_project(text_of(input), "backbend.toml", keys);
    for (const auto& [table, values] : project.values) {
      require(keys.contains(table), "tables are commands");
      for (const auto& [key, value] : values) {
        require(keys.at(table).contains(key), "keys are options");
        require(project.find(table, key) == &value, "a command's own value counts first");
        require(!value.words.empty() && value.line >= 1, "a value has words and a line");
        for (const std::string& word : value.words)
          require(!word.empty() && word.find('\0') == std::string::npos,
                  "a command line could say the word");
      }
    }
    return true;
  } catch (const validate::ProjectError& error) {
    require(std::string_view(error.what()).starts_with("backbend.toml:"), "a refusal has a place");
    return refused(error);
  }
}

std::vector<Bytes> seeds() {
  return {bytes_of("threads = 4\nquiet = true\nrig = \"even\"\nhistory = \"runs/history.jsonl\"\n"
                   "[check]\nquick = false\njoint-map = [\"spine_1=C_spine_1\", \"a=b\"]\n"),
          bytes_of("joint-map = \"a=b\"\n[history]\nnights = 3e1\n")};
}

const Registration registration{
    {"project_toml",
     run,
     seeds,
     {"threads", "quiet", "rig", "history", "joint-map", "[check]", "[history]", "quick", "nights",
      "true", "false", "inf", "nan", "1e308", "\"\"\"", "'''", "\\u0000", "1979-05-27"}}};

}  // namespace
}  // namespace backbend::fuzz
