#include <cstdio>

#include "cli/clip_options.h"
#include "cli/no_folder.h"
#include "validate/clips/clip_run.h"
#include "validate/files/output_folder.h"
#include "validate/text/shell_word.h"

namespace backbend::cli {
namespace {

namespace fs = std::filesystem;
using namespace backbend::validate;

JointMap joint_map(const std::vector<std::string>& pairs) {
  JointMap names;
  for (const std::string& pair : pairs) {
    const std::size_t equals = pair.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == pair.size())
      throw CLI::ValidationError("--joint-map: '" + pair + "' is not CHARACTER_JOINT=CLIP_JOINT");
    names[pair.substr(0, equals)] = pair.substr(equals + 1);
  }
  return names;
}

}  // namespace

CLI::Option* add_clip_options(CLI::App* command, BakedOptions& options, const std::string& what) {
  CLI::Option* baked = command->add_option(
      "--baked", options.clip, what + ": .glb, .fbx, .dae, .bvh, backbend.clip/1, .mdd or .pc2");
  command->add_option("--clip", options.animation,
                      "use only this animation or sweep of the --baked file [all]");
  command
      ->add_option("--joint-map", options.joint_map,
                   "joint names that differ in --baked: CHARACTER_JOINT=CLIP_JOINT,...")
      ->delimiter(',')
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->configurable();
  command
      ->add_option("--clip-fps", options.frames_per_second,
                   "frames per second of a --baked .pc2, 1 to 1000 [24]")
      ->check(CLI::Range(1.0, 1000.0))
      ->configurable();
  return baked;
}

void add_baked_options(CLI::App* command, BakedOptions& options) {
  add_clip_options(command, options, "judge YOUR RIG by its motion");
}

ClipFiles clip_files(const BakedOptions& options, const std::string& character,
                     const skin::AnatomyHints& hints) {
  return {character,
          options.clip,
          {options.animation, options.frames_per_second},
          hints,
          joint_map(options.joint_map)};
}

Report baked_report(const BakedOptions& options, const std::string& character,
                    const skin::AnatomyHints& hints, const Common& common, const fs::path& folder,
                    const PicturePlan& pictures) {
  ClipRequest request;
  static_cast<ClipFiles&>(request) = clip_files(options, character, hints);
  request.folder = folder;
  request.pictures = pictures;
  request.command = "backbend check " + (character.empty() ? "" : shell_word(character) + " ") +
                    "--baked " + shell_word(options.clip);
  if (!common.json)
    request.on_character = [](const std::string& title, const CharacterFacts& facts) {
      print_character(title, facts);
    };
  Progress progress(common.progress_style());
  return run_clip(request, progress);
}

int check_baked(const BakedOptions& options, const std::string& character,
                const skin::AnatomyHints& hints, const std::string& output,
                const PicturePlan& pictures, const Common& common) {
  const fs::path folder = new_run_folder(output);
  const Report report =
      baked_report(options, character, hints, common, folder == kNoFolder ? "" : folder, pictures);
  return publish(report, folder, output.empty(), common);
}

}  // namespace backbend::cli
