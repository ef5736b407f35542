#include <cstdio>

#include "cli/judging_commands.h"
#include "validate/evidence/picture_diff.h"

namespace backbend::cli {

void add_diff(const Registry& registry) {
  struct Options {
    std::string a, b;
    validate::PictureLimits limits;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = registry.add(
      "diff", "compare two EXR pictures, or two folders of them, as a person would see them",
      [options, &common = registry.common] {
        validate::Progress progress(common.progress_style());
        const validate::PictureDiff diff =
            validate::diff_pictures(options->a, options->b, options->limits, progress);
        progress.finish();
        std::fputs(
            (common.json ? validate::picture_diff_json(diff) : validate::picture_diff_text(diff))
                .c_str(),
            stdout);
        return diff.exit_code();
      });
  command->add_option("A", options->a, "EXR file or folder: expected")->required();
  command->add_option("B", options->b, "EXR file or folder: actual")->required();
  command
      ->add_option("--flip", options->limits.perceptual,
                   "largest mean perceptual difference (FLIP, HDR), 0 to 1 [0.01]")
      ->check(CLI::Range(0.0, 1.0))
      ->configurable();
  command
      ->add_option("--normal-deg", options->limits.normal_deg,
                   "largest mean angle between normals, degrees [0.05]")
      ->check(CLI::Range(0.0, 180.0))
      ->configurable();
  command
      ->add_option("--outline-px", options->limits.outline_px,
                   "largest 95 % distance between the outlines, pixels [0.5]")
      ->check(CLI::Range(0.0, 100000.0))
      ->configurable();
  command
      ->add_option("--overlap", options->limits.overlap,
                   "least overlap of the silhouettes, 0 to 1 [0.995]")
      ->check(CLI::Range(0.0, 1.0))
      ->configurable();
}

}  // namespace backbend::cli
