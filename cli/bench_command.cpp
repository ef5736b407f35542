#include <cstdio>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "validate/evidence/bench.h"
#include "validate/night/standard_runs.h"

namespace backbend::cli {

using namespace backbend::validate;

namespace {

constexpr const char* kKinds[] = {"camera", "scattered", "shadow"};

const char* name_of(render::TreeQuality quality) {
  return quality == render::TreeQuality::high ? "high" : "medium";
}

double rate_of(const render::RayCost& cost, const render::RayRate& rate) {
  return static_cast<double>(cost.rays[static_cast<std::size_t>(rate.kind)]) / rate.seconds;
}

nlohmann::ordered_json json_of(const render::RayCost& cost, const render::RayRate& rate) {
  return {{"kind", kKinds[static_cast<std::size_t>(rate.kind)]},
          {"tree", name_of(rate.quality)},
          {"way", render::name_of(rate.way)},
          {"coherent", rate.coherent},
          {"rays_per_s", rate_of(cost, rate)}};
}

void print_json(const render::RayCost& cost) {
  nlohmann::ordered_json rates = nlohmann::ordered_json::array(), best = rates;
  for (const render::RayRate& rate : cost.rates) rates.push_back(json_of(cost, rate));
  for (const render::RayRate& rate : cost.best) best.push_back(json_of(cost, rate));
  const nlohmann::ordered_json told = {{"camera_rays", cost.rays[0]},
                                       {"scattered_rays", cost.rays[1]},
                                       {"shadow_rays", cost.rays[2]},
                                       {"frame_s", cost.frame_s},
                                       {"rays_s", cost.best_s()},
                                       {"ratio", cost.ratio()},
                                       {"rays_as_asked_s", cost.as_asked_s},
                                       {"ratio_as_asked", cost.ratio_as_asked()},
                                       {"best", best},
                                       {"rates", rates}};
  std::printf("%s\n", told.dump().c_str());
}

void print_table(const render::RayCost& cost) {
  std::printf("M rays/s of Embree alone, one thread; `*` is the best for the kind\n");
  std::printf("%-10s %-8s %-12s %10s %10s %10s\n", "told", "tree", "asked", kKinds[0], kKinds[1],
              kKinds[2]);
  const std::size_t ways = cost.rates.size() / 3;
  for (std::size_t i = 0; i < ways; ++i) {
    const render::RayRate& way = cost.rates[i];
    std::printf("%-10s %-8s %-12s", way.coherent ? "coherent" : "incoherent", name_of(way.quality),
                std::string(render::name_of(way.way)).c_str());
    for (std::size_t kind = 0; kind < 3; ++kind) {
      const render::RayRate& rate = cost.rates[kind * ways + i];
      std::printf(" %9.2f%c", 1e-6 * rate_of(cost, rate),
                  rate.seconds == cost.best[kind].seconds ? '*' : ' ');
    }
    std::printf("\n");
  }
  const double rays = 1e-6 * static_cast<double>(cost.all_rays());
  const auto line = [&](const char* what, double seconds) {
    std::printf("%-32s %8.3f s  %6.2f M rays/s  ratio %.3f\n", what, seconds, rays / seconds,
                seconds / cost.frame_s);
  };
  std::printf("%.2f M rays: %.2f camera, %.2f scattered, %.2f shadow\n", rays,
              1e-6 * static_cast<double>(cost.rays[0]), 1e-6 * static_cast<double>(cost.rays[1]),
              1e-6 * static_cast<double>(cost.rays[2]));
  line("frame", cost.frame_s);
  line("rays alone, the best ways", cost.best_s());
  line("rays alone, as the renderer asks", cost.as_asked_s);
}

}  // namespace

void add_bench(const Registry& registry) {
  struct Options {
    RenderRequest request;
    std::string what, rig = "even", pose, resolution;
    int repeats = 5;
  };
  auto options = std::make_shared<Options>();
  const auto run = [options, &common = registry.common] {
    RenderRequest request = options->request;
    request.rig = read_rig(options->rig);
    request.chain = driven_chain("", request.rig, request.hints);
    try {
      request.pose = parse_pose(options->pose);
    } catch (const solver::RigError& error) {
      throw CLI::ValidationError(std::string("--") + error.what());
    }
    request.settings.width = request.settings.height = 256;
    if (!options->resolution.empty()) {
      std::tie(request.settings.width, request.settings.height) =
          parse_resolution(options->resolution);
    }
    const render::RayCost cost = bench_rays(request, options->repeats);
    common.json ? print_json(cost) : print_table(cost);
    return 0;
  };
  CLI::App* command =
      registry.add("bench", "compare the renderer's ray rate with Embree alone", run);
  command->add_option("what", options->what, "rays: trace one frame's rays with Embree alone")
      ->required()
      ->check(CLI::IsMember({"rays"}));
  command->add_option("character", options->request.character, "character file")->required();
  command->add_option("--rig", options->rig, "rig: a system (backbend list rigs) or a file [even]");
  command->add_option("--pose", options->pose, "channel=degrees, separated by commas [rest]");
  command->add_option("--res", options->resolution, "picture size, WIDTHxHEIGHT [256x256]");
  command->add_option("--spp", options->request.settings.samples, "samples a pixel, 1 to 256 [16]")
      ->check(CLI::Range(1, 256));
  command
      ->add_option("--repeat", options->repeats,
                   "measurements, of which the median counts, 1 to 100 [5]")
      ->check(CLI::Range(1, 100));
  add_anatomy_options(command, options->request.hints);
}

}  // namespace backbend::cli
