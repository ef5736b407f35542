// Whether `why` names what made each new finding: one ingredient or two of real characters spoiled,
// hidden among changes that do no harm.
//
//   why_battery [options]
//
// --cases N     with something to explain [60]
// --seed S      [1]
// --vertices N  bodies are decimated to so many: a case measures a body ten times and more [3000]
// --characters DIR   [BACKBEND_CHARACTERS, else beside the project]
// --verbose     each case, not only the wrong ones
// --only N      only case N
//
// A case is right where no finding is booked to an ingredient that was not spoiled or to none, and,
// where two were spoiled, each that one of them alone makes and the other does not is booked to
// that one. Exit code 0 where all cases are right, 1 where not, 77 without characters.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>

#include "tests/battery/body_variants.h"
#include "tests/battery/why_cases.h"
#include "tests/source_folder.h"
#include "validate/judge/confirmed.h"
#include "validate/verdicts/checks.h"

namespace backbend::battery {
namespace {

namespace fs = std::filesystem;
using namespace validate;
using Index = std::size_t;

struct Options {
  Index cases = 60, vertices = 3000;
  std::uint64_t seed = 1;
  fs::path characters = characters_folder();
  bool verbose = false;
  std::optional<Index> only;
};

std::string words(IngredientSet set) {
  std::string out;
  for (const Ingredient each : members(set))
    out += (out.empty() ? "" : "+") + std::string(name_of(each));
  return out.empty() ? "nothing" : out;
}

/// How far a value is from what the finding was to what it is: 0..1, and beyond.
double share_of(const WhyFinding& why, const Failures& failures) {
  const Finding& is = why.finding;
  const Check& check = *find_check(is.code);
  const double from = std::max(1.0, why.was ? excess(check, *why.was, is.limit) : 1.0);
  const double to = excess(check, is.value, is.limit);
  const auto found = failures.find(why.key);
  if (found == failures.end()) return 0.0;
  const double at = excess(check, found->second.value, found->second.limit);
  return (at - from) / std::max(1e-9, to - from);
}

/// What is wrong with the answer; empty: nothing.
std::string mistake(const WhyCase& drawn, const WhyPair& found) {
  for (const WhyFinding& each : found.findings)
    if (each.ingredients == 0 || (each.ingredients & ~drawn.spoiled) != 0)
      return each.key + " booked to " + words(each.ingredients);
  if (drawn.alone.size() < 2) return {};
  std::vector<Failures> alone;
  for (const auto& [ingredient, version] : drawn.alone) {
    try {
      alone.push_back(failures_of(version, {}));
    } catch (const std::runtime_error&) {
      return {};  // one alone cannot be measured: nothing to hold the answer against
    }
  }
  for (const WhyFinding& each : found.findings)
    for (Index i = 0; i < 2; ++i)
      if (share_of(each, alone[i]) > 0.75 && share_of(each, alone[1 - i]) < 0.25 &&
          each.ingredients != bit(drawn.alone[i].first))
        return each.key + " booked to " + words(each.ingredients) + ", made by " +
               words(bit(drawn.alone[i].first));
  return {};
}

struct Row {
  Index cases = 0, right = 0, findings = 0, measured = 0;
};

int run(const Options& options) {
  struct Body {
    std::string name;
    skin::Character character;
    skin::AnatomyHints hints;
  };
  std::vector<Body> bodies;
  for (const char* name : {"mh_male_13k.glb", "mh_female_cmu_13k.glb", "quaternius_female_24k.glb",
                           "cesium_man.glb"}) {
    if (!fs::exists(options.characters / name)) continue;
    ConfirmedCharacter confirmed = load_confirmed(options.characters / name, {});
    skin::Character body = welded(confirmed.character);
    if (body.vertex_count() > options.vertices) decimate(body, options.vertices);
    bodies.push_back({name, std::move(body), confirmed.hints});
  }
  if (bodies.empty()) return 77;
  std::map<std::string, Row> rows;  // by what was spoiled
  Row all;
  Index silent = 0, refused = 0;
  for (Index n = 0; all.cases < options.cases && n < 4 * options.cases; ++n) {
    if (options.only && n != *options.only) continue;
    Draw draw(options.seed, n);
    const Body& body = bodies[n % bodies.size()];
    const auto drawn = draw_why_case(body.character, body.hints, n % 3 == 2, draw);
    if (!drawn) continue;
    Progress none(Progress::Style::none);
    try {
      const WhyPair found = why(VersionPair(drawn->before, drawn->after), {}, none);
      if (found.findings.empty()) {
        ++silent;  // what was spoiled fails no check: nothing to explain
        continue;
      }
      const std::string wrong = mistake(*drawn, found);
      for (Row* row : {&all, &rows[words(drawn->spoiled)]}) {
        ++row->cases;
        row->right += wrong.empty();
        row->findings += found.findings.size();
        row->measured += found.measured;
      }
      if (!wrong.empty() || options.verbose)
        std::printf("%s case %zu %s: %s; %zu findings, %zu measured%s%s\n",
                    wrong.empty() ? "right" : "WRONG", n, body.name.c_str(), drawn->what.c_str(),
                    found.findings.size(), found.measured, wrong.empty() ? "" : ": ",
                    wrong.c_str());
      if (options.only)
        for (const WhyFinding& each : found.findings)
          std::printf("  %s %s of %s at vertex %d, was %s: %s; %s\n", each.key.c_str(),
                      number_text(each.finding.value).c_str(),
                      number_text(each.finding.limit).c_str(), each.finding.vertex,
                      each.was ? number_text(*each.was).c_str() : "none",
                      words(each.ingredients).c_str(), each.finding.detail.c_str());
    } catch (const std::runtime_error& error) {
      ++refused;
      if (options.verbose)
        std::printf("refused %zu: %s (%s)\n", n, error.what(), drawn->what.c_str());
    }
    std::fflush(stdout);
  }
  rows["all"] = all;
  std::printf("| spoiled | cases | right | findings | measured, mean |\n|---|---|---|---|---|\n");
  for (const auto& [spoiled, row] : rows)
    std::printf(
        "| %s | %zu | %zu | %zu | %.1f |\n", spoiled.c_str(), row.cases, row.right, row.findings,
        static_cast<double>(row.measured) / static_cast<double>(std::max<Index>(1, row.cases)));
  std::printf("%zu more made no finding, %zu could not be measured\n", silent, refused);
  return all.cases > 0 && all.right == all.cases ? 0 : 1;
}

}  // namespace
}  // namespace backbend::battery

int main(int argc, char** argv) {
  backbend::battery::Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--verbose") {
      options.verbose = true;
      continue;
    }
    const char* value = i + 1 < argc ? argv[++i] : nullptr;
    if (value && word == "--cases")
      options.cases = std::strtoull(value, nullptr, 10);
    else if (value && word == "--vertices")
      options.vertices = std::strtoull(value, nullptr, 10);
    else if (value && word == "--seed")
      options.seed = std::strtoull(value, nullptr, 10);
    else if (value && word == "--only")
      options.only = std::strtoull(value, nullptr, 10);
    else if (value && word == "--characters")
      options.characters = value;
    else
      return std::fprintf(stderr, "why_battery: what is '%s'? See the top of why_battery.cpp\n",
                          word.c_str()),
             2;
  }
  return backbend::battery::run(options);
}
