// How well `repair` cures faults that were planted in other people's characters.
//
//   repair_battery [options]
//
// --seed S      [1]
// --rounds N    times that every kind and size of fault is planted, each time in another body [1]
// --kind K      only faults of this kind
// --body FILE   only this character
// --poses N     drawn poses at which no new finding may appear, of each case [0]
// --shard I/N   only every Nth case, from I = 0 on
// --lines FILE  a line of JSON for each case, to be summed with others
// --keep DIR    each case's files, `N/faulted.glb` and `N/healthy.glb`
// --sum FILE... no cases: the table of such files
// --characters DIR   [BACKBEND_CHARACTERS, else beside the project]
//
// Exit code 0 where 95 of 100 planted findings are gone and none was added, 1 where not, 77 without
// characters.
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>

#include "skin/character/character.h"
#include "tests/battery/battery_options.h"
#include "tests/battery/repair_case.h"
#include "validate/metrics/math/median.h"
#include "validate/stage/stage.h"

namespace backbend::battery {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Index = std::size_t;

// Whole: 3200 to 24 000 vertices.
const std::vector<std::string> kBodies = {"mh_male_13k.glb",
                                          "mh_female_cmu_13k.glb",
                                          "quaternius_female_24k.glb",
                                          "bunny.glb",
                                          "alpaca.glb",
                                          "apatosaurus.glb",
                                          "snake.glb",
                                          "shark.glb",
                                          "cesium_man.glb"};
constexpr std::uint64_t kStream = 16'000'000;

struct Options : BatteryOptions {
  std::uint64_t rounds = 1;
  Index poses = 0;
  std::string kind, body;
};

Options read_options(int argc, char** argv) {
  Options out;
  static_cast<BatteryOptions&>(out) = read_battery_options(
      "repair_battery", argc, argv, [&](const std::string& word, const std::string& value) {
        if (word == "--rounds")
          out.rounds = number_of(value);
        else if (word == "--poses")
          out.poses = number_of(value);
        else if (word == "--kind")
          out.kind = value;
        else if (word == "--body")
          out.body = value;
        else
          return false;
        return true;
      });
  return out;
}

json line_of(const RepairScore& score) {
  if (!score.refused.empty()) return {{"refused", score.refused}};
  return {{"planted", score.planted},
          {"left", score.left},
          {"added", score.added},
          {"vertices", score.vertices},
          {"faulty", score.faulty},
          {"touched", score.touched},
          {"beyond", score.beyond},
          {"largest", score.largest_change},
          {"off_before", score.off_before},
          {"off_after", score.off_after},
          {"poses", score.poses},
          {"new_at_poses", score.new_at_poses},
          {"measurements", score.measurements},
          {"done", score.done},
          {"seconds", score.seconds}};
}

std::vector<json> run(const Options& options) {
  const fs::path scratch =
      fs::temp_directory_path() / ("repair_battery_" + std::to_string(::getpid()));
  std::ofstream lines;
  if (!options.lines.empty()) lines.open(options.lines, std::ios::app);
  std::map<std::string, skin::Character> bodies;
  std::vector<json> out;
  std::uint64_t number = 0;
  for (std::uint64_t round = 0; round < options.rounds; ++round)
    for (const WeightFaultKind& kind : weight_fault_kinds())
      for (const double size : kind.sizes) {
        const std::uint64_t n = number++;
        if (kind.name == "bind off") continue;  // no weights
        if (n % options.shards != options.shard) continue;
        if (!options.kind.empty() && kind.name != options.kind) continue;
        validate::Draw draw(options.seed, kStream + n);
        const std::string file = kBodies[draw.index(kBodies.size())];
        if (!options.body.empty() && file != options.body) continue;
        auto known = bodies.find(file);
        if (known == bodies.end())
          known = bodies.emplace(file, welded(validate::load_character(options.characters / file)))
                      .first;
        skin::Character body = known->second;
        const skin::Anatomy anatomy = skin::find_anatomy(body);
        const WeightFault fault = plant(body, anatomy, kind.name, size, draw);
        if (fault.joints.empty()) continue;
        json line = {
            {"n", n},       {"seed", options.seed}, {"character", file},   {"kind", kind.name},
            {"size", size}, {"unit", kind.unit},    {"plain", fault.plain}};
        line.update(line_of(score_repair(
            known->second, body, fault,
            options.keep.empty() ? scratch : fs::path(options.keep) / std::to_string(n),
            options.poses, options.seed + n)));
        if (lines.is_open()) lines << line.dump() << std::endl;
        std::fprintf(stderr, "%s\n", line.dump().c_str());
        out.push_back(std::move(line));
      }
  std::error_code ignored;
  fs::remove_all(scratch, ignored);
  return out;
}

struct Sum {
  Index cases = 0, planted = 0, left = 0, added = 0, poses = 0, new_at_poses = 0, silent = 0;
  std::vector<double> faulty, touched, beyond;
  double off_before = 0.0, off_after = 0.0, seconds = 0.0;
};

bool print_table(const std::vector<json>& lines) {
  std::map<std::string, Sum> sums;
  for (const json& line : lines) {
    if (line.contains("refused")) continue;
    for (const std::string& key : {line["kind"].get<std::string>(), std::string("~all")}) {
      Sum& sum = sums[key];
      const Index planted = line["planted"];
      sum.silent += planted == 0;
      if (planted == 0) continue;
      ++sum.cases;
      sum.planted += planted;
      sum.left += line["left"].get<Index>();
      sum.added += line["added"].get<Index>();
      sum.poses += line["poses"].get<Index>();
      sum.new_at_poses += line["new_at_poses"].get<Index>();
      const double all = line["vertices"];
      sum.faulty.push_back(100.0 * line["faulty"].get<double>() / all);
      sum.touched.push_back(100.0 * line["touched"].get<double>() / all);
      sum.beyond.push_back(100.0 * line["beyond"].get<double>() / all);
      sum.off_before += line["off_before"].get<double>();
      sum.off_after += line["off_after"].get<double>();
      sum.seconds = std::max(sum.seconds, line["seconds"].get<double>());
    }
  }
  std::printf(
      "| fault | cases with a finding | findings | gone | added | vertices faulty / touched / "
      "touched beyond the fault, median %% | weight off, before / after | new at other poses | "
      "longest |\n|---|---|---|---|---|---|---|---|---|\n");
  for (const auto& [kind, sum] : sums) {
    const auto cases = static_cast<double>(std::max<Index>(1, sum.cases));
    std::printf(
        "| %s | %zu of %zu | %zu | %.1f %% | %zu | %.1f / %.1f / %.1f | %.3f / %.3f | "
        "%zu of %zu | %.1f s |\n",
        kind == "~all" ? "all" : kind.c_str(), sum.cases, sum.cases + sum.silent, sum.planted,
        100.0 * static_cast<double>(sum.planted - sum.left) /
            static_cast<double>(std::max<Index>(1, sum.planted)),
        sum.added, validate::median(sum.faulty), validate::median(sum.touched),
        validate::median(sum.beyond), sum.off_before / cases, sum.off_after / cases,
        sum.new_at_poses, sum.poses, sum.seconds);
  }
  const Sum& all = sums["~all"];
  return all.planted > 0 && 100 * (all.planted - all.left) >= 95 * all.planted && all.added == 0;
}

int main_of(int argc, char** argv) {
  const Options options = read_options(argc, argv);
  std::vector<json> lines = options.lines_to_sum();
  if (options.sum.empty()) {
    if (!fs::exists(options.characters / kBodies.front())) return skipped_for_want_of_characters();
    lines = run(options);
  }
  return print_table(lines) ? 0 : 1;
}

}  // namespace
}  // namespace backbend::battery

int main(int argc, char** argv) {
  try {
    return backbend::battery::main_of(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "repair_battery: %s\n", error.what());
    return 2;
  }
}
