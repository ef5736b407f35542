#include "validate/evidence/render_job.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <future>
#include <glm/geometric.hpp>
#include <map>
#include <numeric>
#include <sstream>

#include "render/environment_map.h"
#include "render/exr.h"
#include "render/png.h"
#include "render/sheet.h"
#include "validate/evidence/extremes.h"
#include "validate/evidence/obj.h"
#include "validate/evidence/video.h"
#include "validate/evidence/worst_metric.h"
#include "validate/files/hash.h"
#include "validate/metrics/body_metrics.h"
#include "validate/report/report.h"
#include "validate/run/confirmed.h"
#include "validate/run/measure.h"
#include "validate/sweeps/external_spec.h"

namespace backbend::validate {
namespace {

constexpr int kSheetCells = 12;
constexpr int kSheetCellWidth = 320;

constexpr float kHeatTop = 20.0f;  // strain: the limit of BB032

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
    with_environment.heat_high = kHeatTop;
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

/// Encodes and writes one frame while the next is traced; at most one is under way.
class FrameWriter {
 public:
  FrameWriter(const OutputFolder& folder, render::ExrParts parts)
      : folder_(folder), parts_(parts) {}
  ~FrameWriter() {
    if (busy_.valid()) busy_.wait();
  }
  FrameWriter(const FrameWriter&) = delete;
  FrameWriter& operator=(const FrameWriter&) = delete;

  void write(const std::string& name, render::Frame frame) {
    wait();
    busy_ = std::async(std::launch::async, [this, name, frame = std::move(frame)] {
      folder_.write(name, render::encode_exr(frame, parts_));
    });
  }
  /// Throws what went wrong with the frame under way.
  void wait() {
    if (busy_.valid()) busy_.get();
  }

 private:
  const OutputFolder& folder_;
  render::ExrParts parts_;
  std::future<void> busy_;
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

render::Bounds framing_box(const Studio& studio, const PosedCharacter& posed) {
  render::Bounds box = render::bounds_of(studio.stage.rest().position);
  box.add(render::bounds_of(posed.mesh.position));
  return box;
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
    if (body_) render::draw_legend(picture, 0.0f, kHeatTop, kLabel);
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
  Photographer photographer(studio.stage, framing_box(studio, posed));
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

RenderedFiles render_pose(const RenderRequest& request, const OutputFolder& folder,
                          Progress& progress) {
  const Studio studio(request);
  const PosedCharacter posed = studio.posed(request.pose, request.mapping);
  Photographer photographer(studio.stage, framing_box(studio, posed));
  folder.prepare();
  export_obj(request, studio, posed);
  progress.start("frames", 1);
  const double aspect = static_cast<double>(request.settings.width) / request.settings.height;
  const render::Camera camera =
      render::view_camera(request.view, photographer.box(), photographer.facing(), aspect);
  const std::string stamp = stamp_of(studio, request.pose, camera);
  RenderedFiles files;
  files.frames = {studio.name + ".exr", studio.name + ".png"};
  const BurnIn burn_in = burn_in_of(studio, request, request.pose, posed);
  const Heat heat(studio, request);
  if (request.resume) {
    if (auto picture = picture_if_current(folder.path() / files.frames[0], stamp)) {
      heat.put_legend(*picture);
      burn_in.put(*picture);
      folder.write(files.frames[1], render::encode_png(*picture));
      files.kept = 1;
      return files;
    }
  }
  const std::vector<float> strain = heat.of(request.pose, posed);
  photographer.pose(posed, strain, nullptr, studio.controllers(request, request.pose));
  render::Frame frame = photographer.shoot(camera, studio.settings(request));
  poll_interrupt();
  add_provenance(frame, studio, request, request.pose, stamp);
  folder.write(files.frames[0], render::encode_exr(frame, request.parts));
  render::Picture picture = render::picture_from(frame);
  heat.put_legend(picture);
  burn_in.put(picture);
  folder.write(files.frames[1], render::encode_png(picture));
  progress.step();
  return files;
}

RenderedFiles render_turntable(const RenderRequest& request, int views, int light_views,
                               const OutputFolder& folder, Progress& progress) {
  const Studio studio(request);
  const PosedCharacter posed = studio.posed(request.pose, request.mapping);
  Photographer photographer(studio.stage, framing_box(studio, posed));
  folder.prepare();
  export_obj(request, studio, posed);
  const Heat heat(studio, request);
  const std::vector<float> strain = heat.of(request.pose, posed);
  photographer.pose(posed, strain, nullptr, studio.controllers(request, request.pose));

  const double aspect = static_cast<double>(request.settings.width) / request.settings.height;
  const std::vector<TurntableView> turn = turntable_views(views, light_views, photographer, aspect);
  const BurnIn burn_in = burn_in_of(studio, request, request.pose, posed);
  RenderedFiles files;
  std::vector<render::Picture> pictures;
  std::vector<std::string> labels;
  FrameWriter writer(folder, request.parts);
  const std::vector<std::size_t> wanted = frames_of(request, turn.size());
  progress.start("frames", wanted.size());
  for (const std::size_t i : wanted) {
    poll_interrupt();
    const std::string name =
        studio.name + "." + std::to_string(kFirstFrame + static_cast<int>(i)) + ".exr";
    const std::string stamp =
        stamp_of(studio, request.pose, turn[i].camera, turn[i].light_turn_deg);
    files.frames.emplace_back(name);
    labels.push_back(turn[i].label);
    if (request.resume) {
      if (auto picture = picture_if_current(folder.path() / name, stamp)) {
        pictures.push_back(std::move(*picture));
        ++files.kept;
        progress.step();
        continue;
      }
    }
    render::Settings settings = studio.settings(request);
    settings.light_turn_deg += turn[i].light_turn_deg;
    render::Frame frame = photographer.shoot(turn[i].camera, settings);
    add_provenance(frame, studio, request, request.pose, stamp);
    pictures.push_back(render::picture_from(frame));
    writer.write(name, std::move(frame));
    progress.step();
  }
  writer.wait();
  if (request.frames) return files;
  finish_sequence(studio, request, pictures, labels, title_of(studio, request), folder, files,
                  [&](std::size_t i) {
                    render::Picture picture = pictures[i];
                    heat.put_legend(picture);
                    burn_in.put(picture);
                    return picture;
                  });
  return files;
}

RenderedFiles render_sweep(const RenderRequest& request, const Sweep& sweep,
                           const OutputFolder& folder, Progress& progress) {
  const Studio studio(request);
  const std::size_t count = sweep.pose_count();
  const auto pose_at = [&](std::size_t i) { return sweep.pose_at(sweep.control_at(i)); };
  Photographer photographer(studio.stage, framing_box(studio, request, sweep));
  folder.prepare();
  const double aspect = static_cast<double>(request.settings.width) / request.settings.height;
  const render::Camera camera =
      render::view_camera(request.view, photographer.box(), photographer.facing(), aspect);
  const Heat heat(studio, request);
  RenderedFiles files;
  std::vector<render::Picture> pictures;
  std::vector<std::string> labels;
  std::vector<BurnIn> burn_in;
  FrameWriter writer(folder, request.parts);
  PosedCharacter now, before;
  const std::vector<std::size_t> wanted = frames_of(request, count);
  std::optional<std::size_t> posed;  // the frame that `now` is of
  progress.start("frames", wanted.size());
  for (const std::size_t i : wanted) {
    poll_interrupt();
    const PoseDegrees pose = pose_at(i);
    const std::string name =
        studio.name + "." + std::to_string(kFirstFrame + static_cast<int>(i)) + ".exr";
    // The motion layer is from the pose before.
    const std::string stamp = stamp_of(studio, pose, camera) + (i > 0 ? "" : "-first");
    files.frames.emplace_back(name);
    labels.push_back(pose.text());
    std::optional<render::Picture> kept;
    if (request.resume) kept = picture_if_current(folder.path() / name, stamp);
    if (i > 0)
      before = posed == i - 1 ? std::move(now) : studio.posed(pose_at(i - 1), request.mapping);
    now = studio.posed(pose, request.mapping);
    posed = i;
    burn_in.push_back(burn_in_of(studio, request, pose, now));
    if (kept) {
      pictures.push_back(std::move(*kept));
      ++files.kept;
    } else {
      const std::vector<float> strain = heat.of(pose, now);
      photographer.pose(now, strain, i > 0 ? &before : nullptr, studio.controllers(request, pose));
      render::Frame frame = photographer.shoot(camera, studio.settings(request));
      add_provenance(frame, studio, request, pose, stamp);
      pictures.push_back(render::picture_from(frame));
      writer.write(name, std::move(frame));
    }
    progress.step();
  }
  writer.wait();
  if (request.frames) return files;
  finish_sequence(studio, request, pictures, labels,
                  studio.stage.character().name + "  " + request.rig.name + "  " + sweep.name,
                  folder, files, [&](std::size_t i) {
                    render::Picture picture = pictures[i];
                    heat.put_legend(picture);
                    burn_in[i].put(picture);
                    return picture;
                  });
  return files;
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
  Photographer photographer(studio.stage, box);
  const double aspect = static_cast<double>(request.settings.width) / request.settings.height;
  const render::Camera camera =
      render::view_camera(request.view, box, photographer.facing(), aspect);

  RenderedFiles files;
  std::vector<render::Picture> pictures;
  std::vector<std::string> labels;
  FrameWriter writer(folder, request.parts);
  progress.start("frames", extremes.size());
  for (std::size_t i = 0; i < extremes.size(); ++i) {
    poll_interrupt();
    const std::string name = studio.name + "_" + extremes[i].label + ".exr";
    const std::string stamp = stamp_of(studio, extremes[i].pose, camera);
    files.frames.emplace_back(name);
    labels.push_back(extremes[i].caption);
    std::optional<render::Picture> kept;
    if (request.resume) kept = picture_if_current(folder.path() / name, stamp);
    if (kept) {
      pictures.push_back(std::move(*kept));
      ++files.kept;
    } else {
      photographer.pose(posed[i], {}, nullptr, studio.controllers(request, extremes[i].pose));
      render::Frame frame = photographer.shoot(camera, studio.settings(request));
      add_provenance(frame, studio, request, extremes[i].pose, stamp);
      pictures.push_back(render::picture_from(frame));
      writer.write(name, std::move(frame));
    }
    progress.step();
  }
  writer.wait();
  if (!pictures.empty()) {
    files.sheet = studio.name + "_extremes.png";
    std::vector<render::SheetCell> cells;
    for (std::size_t i = 0; i < pictures.size(); ++i)
      cells.push_back(
          {render::shrink(pictures[i], kSheetCellWidth, kSheetCellWidth), labels[i], false});
    folder.write(files.sheet,
                 render::encode_png(render::contact_sheet(
                     cells, 4, studio.stage.character().name + "  " + request.rig.name)));
  }
  return files;
}

}  // namespace backbend::validate
