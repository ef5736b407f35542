#include <cstdio>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "validate/evidence/bench.h"
#include "validate/night/standard_runs.h"

namespace backbend::cli {

using namespace backbend::validate;

void add_bench(const Registry& registry) {
  struct Options {
    RenderRequest request;
    std::string what, rig = "even", pose, resolution;
    int repeats = 5;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = registry.add(
      "bench", "compare the renderer's ray rate with Embree alone",
      [options, &common = registry.common] {
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
        const auto rays = static_cast<double>(cost.rays());
        if (common.json) {
          const nlohmann::ordered_json told = {
              {"camera_rays", cost.camera_rays}, {"scattered_rays", cost.scattered_rays},
              {"shadow_rays", cost.shadow_rays}, {"frame_s", cost.frame_s},
              {"rays_s", cost.rays_s},           {"ratio", cost.ratio()}};
          std::printf("%s\n", told.dump().c_str());
        } else {
          std::printf(
              "%.2f M rays: %.2f camera, %.2f scattered, %.2f shadow\n"
              "frame         %8.3f s  %6.2f M rays/s\n"
              "rays alone    %8.3f s  %6.2f M rays/s\n"
              "ratio         %8.3f\n",
              rays * 1e-6, static_cast<double>(cost.camera_rays) * 1e-6,
              static_cast<double>(cost.scattered_rays) * 1e-6,
              static_cast<double>(cost.shadow_rays) * 1e-6, cost.frame_s,
              rays * 1e-6 / cost.frame_s, cost.rays_s, rays * 1e-6 / cost.rays_s, cost.ratio());
        }
        return 0;
      });
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
