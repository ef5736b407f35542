// Whether `why` names what made each new finding: one ingredient or two of real characters spoiled,
// hidden among changes that do no harm.
//
//   why_battery [--cases N] [--seed S] [--characters DIR] [--verbose]
//
// Exit code 0 where the right ingredients are named each time, else 1; 77 without characters.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "tests/battery/body_variants.h"
#include "tests/battery/why_cases.h"
#include "tests/source_folder.h"
#include "validate/judge/confirmed.h"

namespace backbend::battery {
namespace {

namespace fs = std::filesystem;
using namespace validate;

std::string words(IngredientSet set) {
  std::string out;
  for (const Ingredient each : members(set))
    out += (out.empty() ? "" : "+") + std::string(name_of(each));
  return out.empty() ? "nothing" : out;
}

int run(std::size_t cases, std::uint64_t seed, const fs::path& folder, bool verbose) {
  struct Body {
    std::string name;
    skin::Character character;
    skin::AnatomyHints hints;
  };
  std::vector<Body> bodies;
  for (const char* name : {"mh_male_13k.glb", "mh_female_cmu_13k.glb", "quaternius_female_24k.glb",
                           "cesium_man.glb"}) {
    if (!fs::exists(folder / name)) continue;
    ConfirmedCharacter confirmed = load_confirmed(folder / name, {});
    skin::Character body = welded(confirmed.character);
    if (body.vertex_count() > 3000) decimate(body, 3000);
    bodies.push_back({name, std::move(body), confirmed.hints});
  }
  if (bodies.empty()) return 77;
  std::size_t right = 0, told = 0, silent = 0, refused = 0;
  for (std::size_t n = 0; told < cases && n < 4 * cases; ++n) {
    Draw draw(seed, n);
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
      ++told;
      IngredientSet named = 0;
      bool each_told = true;
      for (const WhyFinding& each : found.findings) {
        named |= each.ingredients;
        each_told &= each.ingredients != 0;
      }
      const bool good = each_told && (named & ~drawn->spoiled) == 0;
      right += good;
      if (!good || verbose)
        std::printf("%s case %zu %s: %s; %zu findings, named %s, %zu measured\n",
                    good ? "right" : "WRONG", n, body.name.c_str(), drawn->what.c_str(),
                    found.findings.size(), words(named).c_str(), found.measured);
      std::fflush(stdout);
    } catch (const std::runtime_error& error) {
      ++refused;
      if (verbose) std::printf("refused %zu: %s (%s)\n", n, error.what(), drawn->what.c_str());
    }
  }
  std::printf("right in %zu of %zu, %zu more made no finding, %zu could not be measured\n", right,
              told, silent, refused);
  return right == told ? 0 : 1;
}

}  // namespace
}  // namespace backbend::battery

int main(int argc, char** argv) {
  std::filesystem::path folder = backbend::characters_folder();
  std::size_t cases = 60;
  std::uint64_t seed = 1;
  bool verbose = false;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--verbose")
      verbose = true;
    else if (i + 1 == argc)
      return 2;
    else if (word == "--cases")
      cases = std::strtoull(argv[++i], nullptr, 10);
    else if (word == "--seed")
      seed = std::strtoull(argv[++i], nullptr, 10);
    else if (word == "--characters")
      folder = argv[++i];
    else
      return 2;
  }
  return backbend::battery::run(cases, seed, folder, verbose);
}
