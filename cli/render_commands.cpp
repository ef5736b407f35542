#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <optional>

#include "cli/clip_options.h"
#include "cli/external_options.h"
#include "cli/no_folder.h"
#include "cli/settings.h"
#include "cli/sweep_option.h"
#include "render/trace/cameras.h"
#include "render/trace/modes.h"
#include "render/trace/open_image_denoise.h"
#include "validate/camera/frame_choice.h"
#include "validate/clips/clip_render.h"
#include "validate/evidence/render_job.h"
#include "validate/files/folder_trace.h"
#include "validate/night/standard_runs.h"
#include "validate/sweeps/suite.h"
#include "validate/sweeps/sweep_named.h"

namespace backbend::cli {
namespace {

using namespace backbend::validate;

/// Presets of quality; options on the command line override them.
struct Preset {
  const char* name;
  int width, height, samples;
  double noise;
  bool all_layers, denoise;
  int views, light_views;
};
constexpr Preset kPresets[] = {
    {"review", 640, 360, 16, 0.0, false, false, 72, 0},
    {"quick", 320, 180, 8, 0.0, false, true, 36, 0},
    {"final", 1920, 1080, 512, 0.01, true, false, 72, 36},
};

/// Options of both picture commands.
struct PictureOptions {
  RenderRequest request;
  std::string rig = "even", pose, mapping = "chest", chain, resolution, layers, output = ".";
  std::string preset_name = kPresets[0].name, mode = "clay";
  std::optional<int> samples;
  std::optional<double> noise;
  std::optional<bool> denoise;
  std::optional<int> frame;
  bool dry_run = false;
  ExternalOptions external;
  BakedOptions baked;

  const Preset& preset() const {
    return *std::find_if(std::begin(kPresets), std::end(kPresets),
                         [&](const Preset& each) { return each.name == preset_name; });
  }

  void add_to(CLI::App* command) {
    command
        ->add_option("character", request.character,
                     "character file: .glb, .gltf, or a body description .toml")
        ->type_name(kFileType);
    command->add_option("--rig", rig, kRigHelp)->type_name(kRigType)->configurable();
    external.add_to(command);
    CLI::Option* of_pose = command->add_option(
        "--pose", pose, "channel=degrees, separated by commas: extension=90,side=10 [rest]");
    CLI::Option* of_clip =
        add_clip_options(command, baked, "show a clip's frames instead of a rig's pose")
            ->excludes(of_pose);
    command->add_option("--frame", frame, "with --baked: one frame, by the number that reports say")
        ->needs(of_clip);
    add_mapping_option(command, mapping)->configurable();
    command
        ->add_option("--preset", preset_name,
                     "review: 640x360, 16 samples; quick: 320x180, 8 samples, denoised; final: "
                     "1920x1080, up to 512 samples by noise, all layers [review]")
        ->check(CLI::IsMember({"review", "quick", "final"}))
        ->configurable();
    command->add_option("--res", resolution, "picture size, WIDTHxHEIGHT pixels [the preset's]")
        ->check(picture_size())
        ->configurable();
    command
        ->add_option("--spp", samples,
                     "samples per pixel, 1 to 65535; with --noise the maximum [the preset's]")
        ->check(CLI::Range(1, 65535))
        ->configurable();
    command
        ->add_option("--noise", noise,
                     "stop sampling where the error over the square root of the light is below "
                     "this; 0: never [the preset's]")
        ->check(CLI::Range(0.0, 1.0))
        ->configurable();
    command
        ->add_flag_function(
            "--denoise,!--no-denoise", [this](std::int64_t count) { denoise = count > 0; },
            "add a denoised layer, which PNG and video show [the preset's]")
        ->configurable();
    if (render::has_open_image_denoise())
      command->add_flag("--open-image-denoise", request.settings.open_image_denoise,
                        "use Open Image Denoise for that layer instead of our own denoiser");
    command->add_option("--seed", request.settings.seed, "sampling seed [0]");
    command
        ->add_option(
            "--mode", mode,
            "beauty, clay, ao, matcap, wireframe, heat (strain), xray, contour, primary [clay]")
        ->transform(CLI::IsMember(render::modes(), CLI::ignore_case))
        ->configurable();
    command
        ->add_option("--aovs", layers,
                     "default (RGBA, Z, N, P, albedo, mattes) or all [the preset's]")
        ->check(CLI::IsMember({"default", "all"}))
        ->configurable();
    command
        ->add_option("--environment", request.settings.environment_file,
                     "HDR picture to light with [the built-in studio]")
        ->type_name(kFileType)
        ->configurable();
    command
        ->add_flag("--transparent", request.settings.transparent,
                   "no backdrop: alpha holds the character and its shadow")
        ->configurable();
    command->add_option("--name", request.name, "name of the files [CHARACTER_RIG]");
    command->add_option("--export-obj", request.export_obj, "write the posed mesh as OBJ too");
    command
        ->add_flag_callback(
            "--multipart", [this] { request.parts = render::ExrParts::by_layer; },
            "write each layer as its own EXR part")
        ->configurable();
    command
        ->add_flag("--burn-in", request.burn_in,
                   "draw rig, pose and worst metric into PNG and video, not into EXR")
        ->configurable();
    command->add_flag("--resume", request.resume,
                      "keep existing frames that are whole and have the same inputs");
    command->add_flag("--dry-run", dry_run, "print the plan and the estimated time, then exit");
    command->add_option("-o,--output", output,
                        "folder for the files [.]; of one pose also -: the PNG on standard output");
    add_anatomy_options(command, request.hints);
    add_chain_option(command, chain);
  }

  bool is_of_clip() const { return !baked.clip.empty(); }
  ClipFiles clip_files() const { return cli::clip_files(baked, request.character, request.hints); }

  /// The place of --frame among a clip's frames; the first where none is asked for.
  std::size_t pose_of_frame(const ClipPoses& clip) const {
    try {
      return frame ? clip.pose_of_frame(*frame) : 0;
    } catch (const std::invalid_argument& error) {
      throw CLI::ValidationError(std::string("--frame: ") + error.what());
    }
  }

  RenderRequest finished() const {
    if (request.character.empty() && !is_of_clip())
      throw CLI::RequiredError("a character file, or --baked with a clip");
    RenderRequest result = request;
    result.rig = external.read_rig(rig);
    result.chain = driven_chain(chain, result.rig, result.hints);
    result.mapping = *find_mapping(mapping);
    try {
      result.pose = parse_pose(pose);
    } catch (const solver::RigError& error) {
      throw CLI::ValidationError(std::string("--") + error.what());
    }
    result.settings.mode = render::modes().at(mode);
    const Preset& base = preset();
    result.settings.width = base.width;
    result.settings.height = base.height;
    if (!resolution.empty())
      std::tie(result.settings.width, result.settings.height) = parse_resolution(resolution);
    result.settings.samples = samples.value_or(base.samples);
    // A given sample count is exact, unless --noise is given as well.
    result.settings.noise = noise.value_or(samples ? 0.0 : base.noise);
    result.settings.denoise = denoise.value_or(base.denoise || request.settings.open_image_denoise);
    result.settings.position_and_albedo = true;
    result.settings.all_layers = layers.empty() ? base.all_layers : layers == "all";
    return result;
  }
};

/// Which frames of a sequence a command makes, so that many machines may share one.
struct FrameOptions {
  std::string frames, shard;

  std::array<CLI::Option*, 2> add_to(CLI::App* command) {
    CLI::Option* of_frames =
        command->add_option("--frames", frames,
                            "render only these frames: 1001-1010x2,1020; when all exist, --resume "
                            "without it makes contact sheet and video");
    CLI::Option* of_shard = command->add_option(
        "--shard", shard, "render only one share of the frames: I/N, or 'auto' in a Slurm array");
    return {of_frames, of_shard};
  }

  bool any() const { return !frames.empty() || !shard.empty(); }

  /// `frames_there`: how many there are, or their numbers.
  template <typename Frames>
  std::optional<std::vector<std::size_t>> chosen_of(const Frames& frames_there) const {
    if (frames.empty() && shard.empty()) return std::nullopt;
    const char* option = "--shard: ";
    try {
      const Shard share = shard.empty() ? Shard{} : parse_shard(shard);
      option = "--frames: ";
      return chosen_frames(frames, share, frames_there);
    } catch (const std::invalid_argument& error) {
      throw CLI::ValidationError(option + std::string(error.what()));
    }
  }
};

/// A picture's description in a plan.
std::string picture_text(const PictureRequest& request) {
  const render::Settings& s = request.settings;
  return std::to_string(s.width) + "x" + std::to_string(s.height) + ", " +
         (s.noise > 0.0 ? "up to " : "") + std::to_string(s.samples) + " samples a pixel";
}

/// `frames` of a sequence of `all`, which take so long.
int print_plan(const PictureRequest& request, std::size_t frames, std::size_t all, double minutes,
               const Common& common) {
  const render::Settings& s = request.settings;
  const double samples = static_cast<double>(frames) * s.width * s.height * s.samples;
  if (common.json) {
    std::printf(
        "{\"frames\": %zu, \"height\": %d, \"minutes\": %s, \"samples\": %.0f, "
        "\"samples_a_pixel\": %d, \"sequence\": %zu, \"width\": %d}\n",
        frames, s.height, number_text(minutes, 4).c_str(), samples, s.samples, all, s.width);
    return 0;
  }
  std::printf("frames   %zu of %zu, %s\n", frames, all, picture_text(request).c_str());
  std::printf("samples  %s%s million\n", s.noise > 0.0 ? "up to " : "",
              number_text(samples * 1e-6, 3).c_str());
  std::printf("time     about %s minutes on this machine\n", minutes_text(minutes).c_str());
  return 0;
}

int print_extreme_plan(const RenderRequest& request, const std::vector<Sweep>& sweeps,
                       const Common& common) {
  const RenderEstimate told = estimate_extremes(request, sweeps, *find_envelope("sweep"));
  std::size_t poses = 0;
  for (const Sweep& sweep : sweeps) poses += sweep.pose_count();
  const render::Settings& s = request.settings;
  if (common.json) {
    std::printf(
        "{\"height\": %d, \"minutes\": %s, \"minutes_a_frame\": %s, \"poses\": %zu, "
        "\"samples_a_pixel\": %d, \"sweeps\": %zu, \"width\": %d}\n",
        s.height, number_text(told.minutes, 4).c_str(),
        number_text(told.minutes_a_frame, 4).c_str(), poses, s.samples, sweeps.size(), s.width);
    return 0;
  }
  std::printf("poses    %zu to measure, in %zu sweeps\n", poses, sweeps.size());
  std::printf("frames   the worst ones, found by measuring; %s\n", picture_text(request).c_str());
  std::printf("time     about %s minutes to measure, and %s for each frame, on this machine\n",
              minutes_text(told.minutes).c_str(), minutes_text(told.minutes_a_frame).c_str());
  return 0;
}

int print_png(const std::vector<std::uint8_t>& png) {
  std::fwrite(png.data(), 1, png.size(), stdout);
  if (std::fflush(stdout) != 0) throw WriteError("standard output: cannot be written", EIO);
  return 0;
}

int print_files(const RenderedFiles& files, const std::filesystem::path& folder) {
  for (const auto& frame : files.frames) std::printf("%s\n", (folder / frame).c_str());
  for (const auto& extra : {files.sheet, files.video}) {
    if (!extra.empty()) std::printf("%s\n", (folder / extra).c_str());
  }
  return 0;
}

std::vector<std::string> known_views() {
  const auto names = render::view_names();
  return {names.begin(), names.end()};
}

struct RenderOptions : PictureOptions {
  bool extreme = false;
  std::string sweeps = "stress", sweep;
  FrameOptions frames;
};

/// `render --baked`: one frame of a clip, or a sequence of them.
int render_clip(const RenderOptions& options, PictureRequest request, const Common& common) {
  Progress progress(common.progress_style());
  const bool to_stdout = options.output == kNoFolder;
  if (to_stdout && (!options.frame || options.dry_run || request.resume))
    throw CLI::ValidationError(
        "-o -: one --frame goes to standard output; not with --dry-run or --resume");
  const ClipPoses clip(options.clip_files());
  const std::size_t pose = options.pose_of_frame(clip);
  if (to_stdout) return print_png(take_still_png(clip, pose, request, progress));
  const FolderTrace trace(options.output);
  const OutputFolder folder(options.output);
  if (!options.frame) {
    request.frames = options.frames.chosen_of(clip.frame_numbers());
    if (!request.export_obj.empty())
      throw CLI::ValidationError("--export-obj: needs one --frame of the clip");
  }
  if (options.dry_run) {
    const std::size_t all = options.frame ? 1 : clip.count();
    const std::size_t frames = request.frames ? request.frames->size() : all;
    return print_plan(
        request, frames, all,
        static_cast<double>(frames) * minutes_a_picture(clip, pose, request, !options.frame),
        common);
  }
  if (options.frame)
    return print_files(take_still(clip, pose, request, folder, progress), folder.path());
  return print_files(take_sequence(clip, title_of(clip), request, folder, progress), folder.path());
}

}  // namespace

void add_render(const Registry& registry) {
  using Options = RenderOptions;
  auto options = std::make_shared<Options>();
  CLI::App* command = registry.add(
      "render", "render one pose, a sweep as a sequence, or a rig's worst poses, to EXR and PNG",
      [options, &common = registry.common] {
        RenderRequest request = options->finished();
        if (options->is_of_clip()) return render_clip(*options, request, common);
        if (options->frames.any() && options->sweep.empty())
          throw CLI::ValidationError("--frames and --shard need --sweep or --baked");
        Progress progress(common.progress_style());
        if (options->output == kNoFolder) {
          if (options->extreme || !options->sweep.empty() || options->dry_run || request.resume ||
              !request.export_obj.empty())
            throw CLI::ValidationError(
                "-o -: one pose goes to standard output; not with --sweep, --extreme, --dry-run, "
                "--resume or --export-obj");
          return print_png(render_pose_png(request, progress));
        }
        const FolderTrace trace(options->output);
        const OutputFolder folder(options->output);
        if (!options->sweep.empty()) {
          const Sweep sweep = sweep_option(options->sweep);
          const std::size_t count = sweep.pose_count();
          request.frames = options->frames.chosen_of(count);
          if (options->dry_run) {
            request.pose = sweep.pose_at(sweep.control_at(count / 2));
            const std::size_t frames = request.frames ? request.frames->size() : count;
            return print_plan(request, frames, count,
                              estimate_frames(request, frames, true).minutes, common);
          }
          return print_files(render_sweep(request, sweep, folder, progress), folder.path());
        }
        if (!options->extreme && options->dry_run)
          return print_plan(request, 1, 1, estimate_frames(request, 1, false).minutes, common);
        if (!options->extreme)
          return print_files(render_pose(request, folder, progress), folder.path());
        const std::vector<Sweep> sweeps =
            options->sweeps == "stress" ? stress_sweeps() : bundled_sweeps();
        if (options->dry_run) return print_extreme_plan(request, sweeps, common);
        return print_files(
            render_extremes(request, sweeps, *find_envelope("sweep"), folder, progress),
            folder.path());
      });
  options->add_to(command);
  command
      ->add_option("--view", options->request.view,
                   "camera: profile, front, back or three_quarter [profile]")
      ->check(CLI::IsMember(known_views()))
      ->configurable();
  CLI::Option* extreme = command->add_flag("--extreme", options->extreme,
                                           "the worst frames of every sweep instead of one pose");
  CLI::Option* sweep =
      command
          ->add_option("--sweep", options->sweep,
                       "every pose of a sweep (backbend list sweeps): EXRs, contact sheet and MP4")
          ->excludes(extreme);
  CLI::Option* clip = command->get_option("--baked");
  for (CLI::Option* other : {extreme, sweep}) other->excludes(clip);
  CLI::Option* of_frame = command->get_option("--frame");
  for (CLI::Option* each : options->frames.add_to(command)) each->excludes(of_frame);
  command->add_option("--sweeps", options->sweeps, "with --extreme: standard or stress [stress]")
      ->check(CLI::IsMember({"standard", "stress"}))
      ->configurable();
}

void add_turntable(const Registry& registry) {
  struct Options : PictureOptions {
    std::optional<int> views, light_views;
    FrameOptions frames;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = registry.add(
      "turntable", "render a pose from all around: EXRs, contact sheet and MP4",
      [options, &common = registry.common] {
        RenderRequest request = options->finished();
        Progress progress(common.progress_style());
        if (options->output == kNoFolder)
          throw CLI::ValidationError("-o -: a turntable needs a folder");
        const FolderTrace trace(options->output);
        const OutputFolder folder(options->output);
        const Preset& base = options->preset();
        const int views = options->views.value_or(base.views);
        const int light_views = options->light_views.value_or(base.light_views);
        const std::size_t count = static_cast<std::size_t>(views) + light_views;
        request.frames = options->frames.chosen_of(count);
        const std::size_t frames = request.frames ? request.frames->size() : count;
        if (options->is_of_clip()) {
          const ClipPoses clip(options->clip_files());
          const std::size_t pose = options->pose_of_frame(clip);
          if (options->dry_run)
            return print_plan(
                request, frames, count,
                static_cast<double>(frames) * minutes_a_picture(clip, pose, request, false),
                common);
          return print_files(
              take_turntable(clip, pose, views, light_views, request, folder, progress),
              folder.path());
        }
        if (options->dry_run)
          return print_plan(request, frames, count, estimate_frames(request, frames, false).minutes,
                            common);
        return print_files(render_turntable(request, views, light_views, folder, progress),
                           folder.path());
      });
  options->add_to(command);
  command
      ->add_option("--views", options->views,
                   "views around the character, 1 to 1440 [72, quick 36]")
      ->check(CLI::Range(1, 1440))
      ->configurable();
  command
      ->add_option("--light-views", options->light_views,
                   "further views while the light turns, 0 to 1440 [0, final 36]")
      ->check(CLI::Range(0, 1440))
      ->configurable();
  options->frames.add_to(command);
}

}  // namespace backbend::cli
