#include "tests/battery/battery_options.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "tests/source_folder.h"

namespace backbend::battery {

void BatteryOptions::usage(const std::string& why) const {
  std::fprintf(stderr, "%s: %s; see the head of its source\n", program.c_str(), why.c_str());
  std::exit(2);
}

std::vector<nlohmann::json> BatteryOptions::lines_to_sum() const {
  std::vector<nlohmann::json> out;
  for (const std::string& file : sum) {
    std::ifstream in(file);
    if (!in) usage(file + ": cannot be read");
    for (std::string line; std::getline(in, line);)
      if (!line.empty()) out.push_back(nlohmann::json::parse(line));
  }
  return out;
}

std::uint64_t number_of(const std::string& value) {
  return std::strtoull(value.c_str(), nullptr, 10);
}

BatteryOptions read_battery_options(const std::string& program, int argc, char** argv,
                                    const TakeOption& own) {
  BatteryOptions out;
  out.program = program;
  out.characters = characters_folder();
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--sum") {
      while (++i < argc) out.sum.emplace_back(argv[i]);
      break;
    }
    if (++i == argc) out.usage(word + " needs a value");
    const std::string value = argv[i];
    if (word == "--seed") {
      out.seed = number_of(value);
    } else if (word == "--lines") {
      out.lines = value;
    } else if (word == "--keep") {
      out.keep = value;
    } else if (word == "--characters") {
      out.characters = value;
    } else if (word == "--shard") {
      const std::size_t slash = value.find('/');
      if (slash == std::string::npos) out.usage("--shard is I/N");
      out.shard = number_of(value);
      out.shards = std::max<std::uint64_t>(1, number_of(value.substr(slash + 1)));
    } else if (!own(word, value)) {
      out.usage("unknown option " + word);
    }
  }
  return out;
}

int skipped_for_want_of_characters() {
  constexpr int kSkipped = 77;
  std::fprintf(stderr, "skipped: no characters here; set BACKBEND_CHARACTERS to their folder\n");
  return kSkipped;
}

}  // namespace backbend::battery
