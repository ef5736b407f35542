#include "validate/evidence/render_job.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <map>
#include <numeric>
#include <sstream>

#include "render/image/exr.h"
#include "render/image/png.h"
#include "render/review/sheet.h"
#include "render/trace/environment_map.h"
#include "validate/camera/photographer_pool.h"
#include "validate/evidence/extremes.h"
#include "validate/evidence/obj.h"
#include "validate/evidence/pose_frame.h"
#include "validate/evidence/video.h"
#include "validate/evidence/worst_metric.h"
#include "validate/files/hash.h"
#include "validate/judge/confirmed.h"
#include "validate/measure/measure.h"
#include "validate/metrics/surface/body_metrics.h"
#include "validate/model/report.h"
#include "validate/sweeps/external_spec.h"
#include "validate/tasks/pictures_ahead.h"
#include "validate/tasks/side_by_side.h"

namespace backbend::validate {
namespace {

constexpr int kSheetCells = 12;
constexpr int kSheetCellWidth = 320;

constexpr std::uintmax_t kMaxEnvironmentBytes = std::uintmax_t{1} << 30;

/// An environment picture, read and judged once for all frames.
struct Environment {
  std::shared_ptr<const render::Texture> picture;  // null: the built-in studio
  std::string hash;
};

Environment read_environment(const std::string& file) {
  if (file.empty()) return {};
  const std::vector<std::uint8_t> bytes = read_bytes(file, kMaxEnvironmentBytes);
  try {
    auto picture = std::make_shared<const render::Texture>(
        render::decode_texture(bytes, render::Encoding::srgb));
    const render::EnvironmentMap fit(*picture);  // throws where it has no light to give
    return {picture, content_hash(std::span<const std::uint8_t>(bytes))};
  } catch (const render::RenderError& error) {
    throw render::RenderError(file + ": " + error.what());
  }
}

/// A character under a rig, ready to be rendered.
struct Studio {
  PicturesAhead pictures_ahead;
  Environment environment;
  std::unique_ptr<const Stage> stage_held;
  const Stage& stage;
  std::unique_ptr<solver::SpineSystem> system;
  std::string name, inputs;

  explicit Studio(const RenderRequest& request)
      : environment(read_environment(request.settings.environment_file)),
        stage_held(stage_of(request)),
        stage(*stage_held),
        system(stage.build(request.rig.spec)) {
    const std::string why = why_not_taken(*system, request.pose);
    if (!why.empty())
      throw solver::RigError("rig '" + request.rig.name + "' cannot take the pose: " + why);
    const skin::Character& character = stage.character();
    if (request.settings.mode == render::Mode::beauty) {
      // Clay needs no textures; a beauty picture without them would be wrong.
      for (const skin::Warning& warning : character.warnings)
        if (warning.code == "image_missing") throw render::RenderError(warning.message);
    }
    name = request.name.empty() ? character.name + "_" + request.rig.name : request.name;
    // What a frame depends on beside its pose and camera.
    const render::Settings& s = request.settings;
    inputs = std::string(BACKBEND_VERSION) + "|" +
             hash_text(character.content_hash_high, character.content_hash_low) + "|" +
             rig_text(request.rig.spec) + "|" +
             (is_external(request.rig.spec) ? external_inputs(request.rig.spec) : "") + "|" +
             std::string(mapping_name(request.mapping)) + "|" + std::to_string(s.width) + "x" +
             std::to_string(s.height) + "|" + std::to_string(s.samples) + "|" +
             std::to_string(s.seed) + "|" + std::to_string(static_cast<int>(s.mode)) + "|" +
             std::to_string(s.all_layers) + "|" + environment.hash + "|" + number_text(s.noise, 9) +
             "|" + std::to_string(s.denoise * (1 + s.open_image_denoise)) + "|" +
             std::to_string(static_cast<int>(request.parts)) + "|" + std::to_string(s.transparent);
  }

  /// Of a studio's own rig that has another mesh than the character, with that mesh.
  static std::unique_ptr<const Stage> stage_of(const RenderRequest& request) {
    ConfirmedCharacter confirmed = load_confirmed(request.character, request.hints);
    const std::vector<skin::SidecarControl> controls =
        confirmed.sidecar ? confirmed.sidecar->controls : std::vector<skin::SidecarControl>();
    auto stage = std::make_unique<const Stage>(std::move(confirmed.character), confirmed.hints,
                                               request.chain, controls);
    auto with_its_mesh = stage->with_mesh_of(request.rig.spec);
    if (!with_its_mesh) return stage;
    return std::make_unique<const Stage>(std::move(*with_its_mesh), confirmed.hints, request.chain,
                                         controls);
  }

  /// What the request asks for, with the environment at hand.
  render::Settings settings(const RenderRequest& request) const {
    render::Settings with_environment = request.settings;
    with_environment.environment = environment.picture;
    with_environment.heat_high = kStrainHeatTop;
    return with_environment;
  }

  PosedCharacter posed(const PoseDegrees& pose, solver::Mapping mapping) const {
    return stage.pose(*system, controls_at(*system, pose, mapping));
  }

  /// X-ray pictures show the rig's controllers; all others are without them to the last bit.
  std::vector<render::OverlayLine> controllers(const RenderRequest& request,
                                               const PoseDegrees& pose) const {
    if (request.settings.mode != render::Mode::xray) return {};
    return controller_lines(solver::controller_shapes(*system, stage.rest_chain(),
                                                      controls_at(*system, pose, request.mapping)));
  }
};

std::string camera_text(const render::Camera& camera) {
  std::string text;
  for (const glm::dvec3& v : {camera.eye, camera.target, camera.up}) {
    for (int axis = 0; axis < 3; ++axis) text += number_text(v[axis], 9) + ",";
  }
  return text + number_text(camera.focal_mm, 6);
}

std::string stamp_of(const Studio& studio, const PoseDegrees& pose, const render::Camera& camera,
                     double light_turn_deg = 0.0) {
  return content_hash(studio.inputs + "|" + pose.text() + "|" + camera_text(camera) + "|" +
                      number_text(light_turn_deg, 6));
}

void add_provenance(render::Frame& frame, const Studio& studio, const RenderRequest& request,
                    const PoseDegrees& pose, const std::string& stamp) {
  const skin::Character& character = studio.stage.character();
  frame.attributes.insert(frame.attributes.end(),
                          {{"backbend/version", BACKBEND_VERSION},
                           {"backbend/character", character.name},
                           {"backbend/characterHash",
                            hash_text(character.content_hash_high, character.content_hash_low)},
                           {"backbend/rig", request.rig.name},
                           {"backbend/rigOptions", rig_text(request.rig.spec)},
                           {"backbend/mapping", std::string(mapping_name(request.mapping))},
                           {"backbend/poseParameter", pose.text()},
                           {"backbend/stamp", stamp}});
}

/// The picture in a frame that an earlier run left, where it is whole and of the same inputs.
std::optional<render::Picture> picture_if_current(const std::filesystem::path& file,
                                                  const std::string& stamp) {
  if (!std::filesystem::is_regular_file(file)) return std::nullopt;
  try {
    const render::Frame frame = render::decode_exr(read_bytes(file));
    for (const render::Attribute& attribute : frame.attributes) {
      if (attribute.name == "backbend/stamp" && attribute.value == stamp)
        return render::picture_from(frame);
    }
  } catch (const std::exception&) {
    // A damaged frame is rendered again, like a missing one.
  }
  return std::nullopt;
}

/// How many frames to have under way at once: as many as there are threads, fewer where their
/// layers, in memory and as a file, would fill it. Says so then.
std::size_t frames_at_once(const RenderRequest& request, Progress& progress) {
  constexpr double kBytesOfPixel = 2.0 * 64 * sizeof(float);  // all layers have fewer channels
  const render::Settings& s = request.settings;
  const std::size_t most = pieces_in_memory(kBytesOfPixel * static_cast<double>(s.width) *
                                            static_cast<double>(s.height));
  const auto threads = static_cast<std::size_t>(oneapi::tbb::this_task_arena::max_concurrency());
  if (most < threads)
    progress.say("backbend: memory is free for " + std::to_string(most) +
                 (most == 1 ? " frame" : " frames") + " at a time, so no more are under way");
  return most;
}

/// Frames of a sequence while they are made, in any order.
struct Sequence {
  RenderedFiles files;
  std::vector<render::Picture> pictures;
  std::vector<std::string> labels;
  std::atomic<std::size_t> kept = 0;

  void plan(std::string name, std::string label) {
    files.frames.emplace_back(std::move(name));
    labels.push_back(std::move(label));
  }
  /// `make(n)` for each planned frame, as many at once as fit; each fills its picture.
  /// A studio's own rig may remember what it was asked before: its frames go one after another.
  void make(const RenderRequest& request, Progress& progress,
            const std::function<void(std::size_t)>& make) {
    pictures.resize(labels.size());
    progress.start("frames", labels.size());
    for_each_side_by_side(
        labels.size(),
        [&](std::size_t n) {
          poll_interrupt();
          make(n);
          progress.step();
        },
        is_external(request.rig.spec) ? 1 : frames_at_once(request, progress));
    files.kept = kept;
  }
  /// Takes frame n from an earlier run, where that is good.
  bool keep(const RenderRequest& request, const OutputFolder& folder, std::size_t n,
            const std::string& stamp) {
    if (!request.resume) return false;
    auto picture = picture_if_current(folder.path() / files.frames[n], stamp);
    if (!picture) return false;
    pictures[n] = std::move(*picture);
    ++kept;
    return true;
  }
  void write(const RenderRequest& request, const OutputFolder& folder, std::size_t n,
             const render::Frame& frame) {
    pictures[n] = render::picture_from(frame);
    folder.write(files.frames[n], render::encode_exr(frame, request.parts));
  }
};

render::Picture sheet_of(const std::vector<render::Picture>& pictures,
                         const std::vector<std::string>& labels, const std::string& title) {
  std::vector<render::SheetCell> cells;
  const std::size_t count = std::min<std::size_t>(pictures.size(), kSheetCells);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t from = i * pictures.size() / count;
    const render::Picture& picture = pictures[from];
    const int height = std::max(1, picture.height * kSheetCellWidth / picture.width);
    cells.push_back({render::shrink(picture, kSheetCellWidth, height), labels[from], false});
  }
  return render::contact_sheet(cells, std::min<int>(4, static_cast<int>(count)), title);
}

void export_obj(const RenderRequest& request, const Studio& studio, const PosedCharacter& posed) {
  if (request.export_obj.empty()) return;
  OutputFolder(request.export_obj.parent_path())
      .write(request.export_obj.filename(), obj_text(studio.stage.character(), posed.mesh));
}

/// The box of a sweep: of sixteen of its poses, enlarged by 1 % for the poses between.
render::Bounds framing_box(const Studio& studio, const RenderRequest& request, const Sweep& sweep) {
  constexpr std::size_t kLooks = 16;
  render::Bounds box = render::bounds_of(studio.stage.rest().position);
  const std::size_t last = sweep.pose_count() - 1, looks = std::min(kLooks, last);
  for (std::size_t i = 0; i <= looks; ++i) {
    const std::size_t pose = looks > 0 ? i * last / looks : 0;
    box.add(render::bounds_of(
        studio.posed(sweep.pose_at(sweep.control_at(pose)), request.mapping).mesh.position));
  }
  const double more = 0.01 * glm::length(box.high - box.low);
  box.low -= more;
  box.high += more;
  return box;
}

std::string title_of(const Studio& studio, const RenderRequest& request) {
  return studio.stage.character().name + "  " + request.rig.name + "  " + request.pose.text();
}

/// The text drawn into the pictures of one pose.
struct BurnIn {
  std::string rig, pose, worst;

  void put(render::Picture& picture) const {
    if (!rig.empty()) render::burn_in(picture, rig, pose, worst);
  }
};

BurnIn burn_in_of(const Studio& studio, const RenderRequest& request, const PoseDegrees& pose,
                  const PosedCharacter& posed) {
  if (!request.burn_in) return {};
  return {request.rig.name + " (" + std::string(mapping_name(request.mapping)) + ")", pose.text(),
          worst_metric(studio.stage, *studio.system, pose, request.mapping, posed)};
}

/// Heat of a pose for the heat mode, one value per vertex; empty in other modes.
class Heat {
 public:
  static constexpr const char* kLabel = "strain / ideal";

  Heat(const Studio& studio, const RenderRequest& request) : studio_(studio), request_(request) {
    if (request.settings.mode != render::Mode::heat) return;
    const Stage& stage = studio.stage;
    body_ = std::make_unique<BodyMetrics>(stage.character(), stage.anatomy(), stage.driver());
  }
  std::vector<float> of(const PoseDegrees& pose, const PosedCharacter& posed) const {
    if (!body_) return {};
    return body_->strain_heat(rig_at_rest(*studio_.system),
                              controls_at(*studio_.system, pose, request_.mapping), posed.spine,
                              posed.mesh, glm::radians(pose.twist));
  }
  void put_legend(render::Picture& picture) const {
    if (body_) render::draw_legend(picture, 0.0f, kStrainHeatTop, kLabel);
  }

 private:
  const Studio& studio_;
  const RenderRequest& request_;
  std::unique_ptr<BodyMetrics> body_;
};

/// The contact sheet and the video of a sequence of frames.
void finish_sequence(const Studio& studio, const RenderRequest& request,
                     const std::vector<render::Picture>& pictures,
                     const std::vector<std::string>& labels, const std::string& title,
                     const OutputFolder& folder, RenderedFiles& files,
                     const std::function<render::Picture(std::size_t)>& shown) {
  files.sheet = studio.name + "_sheet.png";
  folder.write(files.sheet, render::encode_png(sheet_of(pictures, labels, title)));
  files.video = studio.name + ".mp4";
  write_video(folder, files.video, pictures.size(), request.settings.frames_per_second, shown);
}

std::vector<std::size_t> frames_of(const RenderRequest& request, std::size_t count) {
  if (request.frames) return *request.frames;
  std::vector<std::size_t> all(count);
  std::iota(all.begin(), all.end(), std::size_t{0});
  return all;
}

/// One picture of a turntable.
struct TurntableView {
  render::Camera camera;
  double light_turn_deg = 0.0;
  std::string label;
};

std::vector<TurntableView> turntable_views(int views, int light_views,
                                           const Photographer& photographer, double aspect) {
  std::vector<TurntableView> all;
  const std::vector<render::Camera> cameras =
      render::turntable(views, photographer.box(), photographer.facing(), aspect);
  for (std::size_t i = 0; i < cameras.size(); ++i)
    all.push_back(
        {cameras[i], 0.0, number_text(360.0 * static_cast<double>(i) / views, 1) + " deg"});
  for (int i = 0; i < light_views; ++i) {
    const double turn_deg = 360.0 * i / light_views;
    all.push_back({cameras.front(), turn_deg, "light " + number_text(turn_deg, 1) + " deg"});
  }
  return all;
}

double seconds_of(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Seconds for one frame, tracing and encoding, judged by a smaller one of at most about so many.
double frame_seconds(const Studio& studio, const RenderRequest& request,
                     const Photographer& photographer) {
  constexpr double kFirstSamples = 2e5, kLookSeconds = 1.0;
  const render::Settings whole = studio.settings(request);
  const double pixels = static_cast<double>(whole.width) * whole.height;
  const auto looked = [&](double share) {
    render::Settings part = whole;
    const double side = std::sqrt(std::min(1.0, share));
    part.width = std::max(16, static_cast<int>(whole.width * side));
    part.height = std::max(16, static_cast<int>(whole.height * side));
    const double seconds = seconds_of([&] {
      render::encode_exr(photographer.shoot(request.view, part), request.parts);
      poll_interrupt();
    });
    return seconds * pixels / (static_cast<double>(part.width) * part.height);
  };
  const double first = looked(kFirstSamples / (pixels * whole.samples));
  return looked(kLookSeconds / std::max(first, 1e-9));
}

/// Seconds for one picture of the request; `moves`: with what a pose of its own costs.
double picture_seconds(const Studio& studio, const RenderRequest& request, bool moves) {
  PosedCharacter posed;
  const auto pose = [&] { posed = studio.posed(request.pose, request.mapping); };
  pose();
  Photographer photographer(studio.stage, framing_box(studio.stage, posed));
  const Heat heat(studio, request);
  std::vector<float> strain;
  const double pose_s = seconds_of([&] {
    pose();
    strain = heat.of(request.pose, posed);
    photographer.pose(posed, strain, nullptr, studio.controllers(request, request.pose));
  });
  return frame_seconds(studio, request, photographer) + (moves ? pose_s : 0.0);
}

}  // namespace

RenderEstimate estimate_frames(const RenderRequest& request, std::size_t frames, bool moves) {
  RenderEstimate out;
  out.minutes_a_frame = picture_seconds(Studio(request), request, moves) / 60.0;
  out.minutes = static_cast<double>(frames) * out.minutes_a_frame;
  return out;
}

RenderEstimate estimate_extremes(const RenderRequest& request, const std::vector<Sweep>& sweeps,
                                 const Envelope& envelope) {
  const Studio studio(request);
  RenderEstimate out;
  out.minutes_a_frame = picture_seconds(studio, request, true) / 60.0;
  Progress silent(Progress::Style::none);
  const double first_s = seconds_of([&] {
    find_extremes(studio.stage, request.rig, request.mapping, {sweeps.front()}, envelope, silent);
  });
  double poses = 0.0;
  for (const Sweep& sweep : sweeps) poses += static_cast<double>(sweep.pose_count());
  out.minutes = first_s / 60.0 * poses / static_cast<double>(sweeps.front().pose_count());
  return out;
}

namespace {

/// One pose in front of its camera.
struct PoseView {
  const RenderRequest& request;
  const Studio studio;
  const PosedCharacter posed;
  Photographer photographer;
  const render::Camera camera;
  const Heat heat;
  const BurnIn burn_in;

  explicit PoseView(const RenderRequest& asked)
      : request(asked),
        studio(request),
        posed(studio.posed(request.pose, request.mapping)),
        photographer(studio.stage, framing_box(studio.stage, posed)),
        camera(render::view_camera(
            request.view, photographer.box(), photographer.facing(),
            static_cast<double>(request.settings.width) / request.settings.height)),
        heat(studio, request),
        burn_in(burn_in_of(studio, request, request.pose, posed)) {}

  render::Frame shoot() {
    const std::vector<float> strain = heat.of(request.pose, posed);
    photographer.pose(posed, strain, nullptr, studio.controllers(request, request.pose));
    render::Frame frame = photographer.shoot(camera, studio.settings(request));
    poll_interrupt();
    return frame;
  }

  /// The picture of a frame as people see it.
  std::vector<std::uint8_t> png(render::Picture picture) const {
    heat.put_legend(picture);
    burn_in.put(picture);
    return render::encode_png(picture);
  }
};

}  // namespace

RenderedFiles render_pose(const RenderRequest& request, const OutputFolder& folder,
                          Progress& progress) {
  PoseView view(request);
  folder.prepare();
  export_obj(request, view.studio, view.posed);
  progress.start("frames", 1);
  const std::string stamp = stamp_of(view.studio, request.pose, view.camera);
  RenderedFiles files;
  files.frames = {view.studio.name + ".exr", view.studio.name + ".png"};
  if (request.resume) {
    if (auto picture = picture_if_current(folder.path() / files.frames[0], stamp)) {
      folder.write(files.frames[1], view.png(std::move(*picture)));
      files.kept = 1;
      return files;
    }
  }
  render::Frame frame = view.shoot();
  add_provenance(frame, view.studio, request, request.pose, stamp);
  folder.write(files.frames[0], render::encode_exr(frame, request.parts));
  folder.write(files.frames[1], view.png(render::picture_from(frame)));
  progress.step();
  return files;
}

std::vector<std::uint8_t> render_pose_png(const RenderRequest& request, Progress& progress) {
  PoseView view(request);
  progress.start("frames", 1);
  std::vector<std::uint8_t> png = view.png(render::picture_from(view.shoot()));
  progress.step();
  return png;
}

RenderedFiles render_turntable(const RenderRequest& request, int views, int light_views,
                               const OutputFolder& folder, Progress& progress) {
  const Studio studio(request);
  const PosedCharacter posed = studio.posed(request.pose, request.mapping);
  Photographer photographer(studio.stage, framing_box(studio.stage, posed));
  folder.prepare();
  export_obj(request, studio, posed);
  const Heat heat(studio, request);
  const std::vector<float> strain = heat.of(request.pose, posed);
  photographer.pose(posed, strain, nullptr, studio.controllers(request, request.pose));

  const double aspect = static_cast<double>(request.settings.width) / request.settings.height;
  const std::vector<TurntableView> turn = turntable_views(views, light_views, photographer, aspect);
  const BurnIn burn_in = burn_in_of(studio, request, request.pose, posed);
  const std::vector<std::size_t> wanted = frames_of(request, turn.size());
  Sequence sequence;
  for (const std::size_t i : wanted)
    sequence.plan(studio.name + "." + std::to_string(kFirstFrame + static_cast<int>(i)) + ".exr",
                  turn[i].label);
  sequence.make(request, progress, [&](std::size_t n) {
    const TurntableView& view = turn[wanted[n]];
    const std::string stamp = stamp_of(studio, request.pose, view.camera, view.light_turn_deg);
    if (sequence.keep(request, folder, n, stamp)) return;
    render::Settings settings = studio.settings(request);
    settings.light_turn_deg += view.light_turn_deg;
    render::Frame frame = photographer.shoot(view.camera, settings);
    add_provenance(frame, studio, request, request.pose, stamp);
    sequence.write(request, folder, n, frame);
  });
  if (request.frames) return sequence.files;
  finish_sequence(studio, request, sequence.pictures, sequence.labels, title_of(studio, request),
                  folder, sequence.files, [&](std::size_t i) {
                    render::Picture picture = sequence.pictures[i];
                    heat.put_legend(picture);
                    burn_in.put(picture);
                    return picture;
                  });
  return sequence.files;
}

RenderedFiles render_sweep(const RenderRequest& request, const Sweep& sweep,
                           const OutputFolder& folder, Progress& progress) {
  const Studio studio(request);
  const std::size_t count = sweep.pose_count();
  const auto pose_at = [&](std::size_t i) { return sweep.pose_at(sweep.control_at(i)); };
  PhotographerPool cameras(studio.stage, framing_box(studio, request, sweep));
  folder.prepare();
  const double aspect = static_cast<double>(request.settings.width) / request.settings.height;
  const render::Camera camera =
      render::view_camera(request.view, cameras.box(), cameras.facing(), aspect);
  const Heat heat(studio, request);
  const std::vector<std::size_t> wanted = frames_of(request, count);
  std::vector<BurnIn> burn_in(wanted.size());
  PosedCharacter last_posed;  // of a rig that may remember
  std::optional<std::size_t> last;
  Sequence sequence;
  for (const std::size_t i : wanted)
    sequence.plan(studio.name + "." + std::to_string(kFirstFrame + static_cast<int>(i)) + ".exr",
                  pose_at(i).text());
  sequence.make(request, progress, [&](std::size_t n) {
    const std::size_t i = wanted[n];
    const PoseDegrees pose = pose_at(i);
    // The motion layer is from the pose before.
    const std::string stamp = stamp_of(studio, pose, camera) + (i > 0 ? "" : "-first");
    const bool kept = sequence.keep(request, folder, n, stamp);
    PosedCharacter before;
    if (last == i - 1 && i > 0) {
      before = std::move(last_posed);
    } else if (i > 0 && !kept) {
      before = studio.posed(pose_at(i - 1), request.mapping);
    }
    PosedCharacter now = studio.posed(pose, request.mapping);
    burn_in[n] = burn_in_of(studio, request, pose, now);
    // Handed on where frames follow each other on one thread.
    const auto hand_on = [&] {
      if (!is_external(request.rig.spec)) return;
      last = i;
      last_posed = std::move(now);
    };
    if (kept) return hand_on();
    const std::vector<float> strain = heat.of(pose, now);
    const PhotographerPool::Loan photographer(cameras);
    photographer->pose(now, strain, i > 0 ? &before : nullptr, studio.controllers(request, pose));
    render::Frame frame = photographer->shoot(camera, studio.settings(request));
    add_provenance(frame, studio, request, pose, stamp);
    sequence.write(request, folder, n, frame);
    hand_on();
  });
  if (request.frames) return sequence.files;
  finish_sequence(studio, request, sequence.pictures, sequence.labels,
                  studio.stage.character().name + "  " + request.rig.name + "  " + sweep.name,
                  folder, sequence.files, [&](std::size_t i) {
                    render::Picture picture = sequence.pictures[i];
                    heat.put_legend(picture);
                    burn_in[i].put(picture);
                    return picture;
                  });
  return sequence.files;
}

RenderedFiles render_extremes(const RenderRequest& request, const std::vector<Sweep>& sweeps,
                              const Envelope& envelope, const OutputFolder& folder,
                              Progress& progress) {
  const Studio studio(request);
  const std::vector<ExtremePose> extremes =
      find_extremes(studio.stage, request.rig, request.mapping, sweeps, envelope, progress);
  folder.prepare();
  std::vector<PosedCharacter> posed;
  render::Bounds box = render::bounds_of(studio.stage.rest().position);
  for (const ExtremePose& extreme : extremes) {
    posed.push_back(studio.posed(extreme.pose, request.mapping));
    box.add(render::bounds_of(posed.back().mesh.position));
  }
  PhotographerPool cameras(studio.stage, box);
  const double aspect = static_cast<double>(request.settings.width) / request.settings.height;
  const render::Camera camera = render::view_camera(request.view, box, cameras.facing(), aspect);
  Sequence sequence;
  for (const ExtremePose& extreme : extremes)
    sequence.plan(studio.name + "_" + extreme.label + ".exr", extreme.caption);
  sequence.make(request, progress, [&](std::size_t n) {
    const PoseDegrees& pose = extremes[n].pose;
    const std::string stamp = stamp_of(studio, pose, camera);
    if (sequence.keep(request, folder, n, stamp)) return;
    const PhotographerPool::Loan photographer(cameras);
    photographer->pose(posed[n], {}, nullptr, studio.controllers(request, pose));
    render::Frame frame = photographer->shoot(camera, studio.settings(request));
    add_provenance(frame, studio, request, pose, stamp);
    sequence.write(request, folder, n, frame);
  });
  if (!sequence.pictures.empty()) {
    sequence.files.sheet = studio.name + "_extremes.png";
    std::vector<render::SheetCell> cells;
    for (std::size_t i = 0; i < sequence.pictures.size(); ++i)
      cells.push_back({render::shrink(sequence.pictures[i], kSheetCellWidth, kSheetCellWidth),
                       sequence.labels[i], false});
    folder.write(sequence.files.sheet,
                 render::encode_png(render::contact_sheet(
                     cells, 4, studio.stage.character().name + "  " + request.rig.name)));
  }
  return sequence.files;
}

}  // namespace backbend::validate
