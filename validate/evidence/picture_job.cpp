#include "validate/evidence/picture_job.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <memory>
#include <numeric>

#include "render/image/png.h"
#include "render/review/sheet.h"
#include "render/trace/environment_map.h"
#include "validate/camera/photographer_pool.h"
#include "validate/evidence/obj.h"
#include "validate/evidence/pose_frame.h"
#include "validate/evidence/video.h"
#include "validate/files/hash.h"
#include "validate/model/report.h"
#include "validate/tasks/seconds_of.h"
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

std::string camera_text(const render::Camera& camera) {
  std::string text;
  for (const glm::dvec3& v : {camera.eye, camera.target, camera.up}) {
    for (int axis = 0; axis < 3; ++axis) text += number_text(v[axis], 9) + ",";
  }
  return text + number_text(camera.focal_mm, 6);
}

/// A source of poses in front of the cameras of a request.
struct Studio {
  const PoseSource& source;
  const PictureRequest& request;
  const Stage& stage;
  Environment environment;
  std::string name, inputs;

  Studio(const PoseSource& poses, const PictureRequest& asked)
      : source(poses),
        request(asked),
        stage(source.stage()),
        environment(read_environment(request.settings.environment_file)) {
    if (request.settings.mode == render::Mode::beauty) {
      // Clay needs no textures; a beauty picture without them would be wrong.
      for (const skin::Warning& warning : stage.character().warnings)
        if (warning.code == "image_missing") throw render::RenderError(warning.message);
    }
    name = request.name.empty() ? title_of(source, "_") : request.name;
    const render::Settings& s = request.settings;
    inputs = std::string(BACKBEND_VERSION) + "|" + source.inputs() + "|" + std::to_string(s.width) +
             "x" + std::to_string(s.height) + "|" + std::to_string(s.samples) + "|" +
             std::to_string(s.seed) + "|" + std::to_string(static_cast<int>(s.mode)) + "|" +
             std::to_string(s.all_layers) + "|" + environment.hash + "|" + number_text(s.noise, 9) +
             "|" + std::to_string(s.denoise * (1 + s.open_image_denoise)) + "|" +
             std::to_string(static_cast<int>(request.parts)) + "|" + std::to_string(s.transparent);
  }

  double aspect() const {
    return static_cast<double>(request.settings.width) / request.settings.height;
  }

  /// What the request asks for, with the environment at hand.
  render::Settings settings() const {
    render::Settings with_environment = request.settings;
    with_environment.environment = environment.picture;
    with_environment.heat_high = kStrainHeatTop;
    return with_environment;
  }

  /// X-ray pictures show the rig's controllers; all others are without them to the last bit.
  std::vector<render::OverlayLine> controllers(std::size_t pose) const {
    if (request.settings.mode != render::Mode::xray) return {};
    return source.controllers(pose);
  }

  std::string title(std::size_t pose) const { return title_of(source) + "  " + source.text(pose); }

  std::string stamp(std::size_t pose, const render::Camera& camera,
                    double light_turn_deg = 0.0) const {
    return content_hash(inputs + "|" + source.text(pose) + "|" + camera_text(camera) + "|" +
                        number_text(light_turn_deg, 6));
  }

  void add_provenance(render::Frame& frame, std::size_t pose, const std::string& stamp) const {
    const skin::Character& character = stage.character();
    frame.attributes.insert(frame.attributes.end(),
                            {{"backbend/version", BACKBEND_VERSION},
                             {"backbend/character", character.name},
                             {"backbend/characterHash",
                              hash_text(character.content_hash_high, character.content_hash_low)}});
    for (render::Attribute& each : source.attributes()) frame.attributes.push_back(std::move(each));
    frame.attributes.insert(frame.attributes.end(), {{"backbend/poseParameter", source.text(pose)},
                                                     {"backbend/stamp", stamp}});
  }
};

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
std::size_t frames_at_once(const PictureRequest& request, Progress& progress) {
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
  const Studio& studio;
  RenderedFiles files;
  std::vector<render::Picture> pictures;
  std::vector<std::string> labels;
  std::atomic<std::size_t> kept = 0;

  explicit Sequence(const Studio& of) : studio(of) {}

  void plan(std::string name, std::string label) {
    files.frames.emplace_back(std::move(name));
    labels.push_back(std::move(label));
  }
  /// Of a numbered frame.
  void plan(int number, std::string label) {
    std::string digits = std::to_string(number);
    digits.insert(0, digits.size() < 4 ? 4 - digits.size() : 0, '0');
    plan(studio.name + "." + digits + ".exr", std::move(label));
  }
  /// `make(n)` for each planned frame, as many at once as fit; each fills its picture.
  void make(Progress& progress, const std::function<void(std::size_t)>& make) {
    pictures.resize(labels.size());
    progress.start("frames", labels.size());
    for_each_side_by_side(
        labels.size(),
        [&](std::size_t n) {
          poll_interrupt();
          make(n);
          progress.step();
        },
        studio.source.is_asked_in_order() ? 1 : frames_at_once(studio.request, progress));
    files.kept = kept;
  }
  /// Takes frame n from an earlier run, where that is good.
  bool keep(const OutputFolder& folder, std::size_t n, const std::string& stamp) {
    if (!studio.request.resume) return false;
    auto picture = picture_if_current(folder.path() / files.frames[n], stamp);
    if (!picture) return false;
    pictures[n] = std::move(*picture);
    ++kept;
    return true;
  }
  void write(const OutputFolder& folder, std::size_t n, const render::Frame& frame) {
    pictures[n] = render::picture_from(frame);
    folder.write(files.frames[n], render::encode_exr(frame, studio.request.parts));
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

void export_obj(const Studio& studio, const PosedCharacter& posed) {
  const std::filesystem::path& file = studio.request.export_obj;
  if (file.empty()) return;
  OutputFolder(file.parent_path())
      .write(file.filename(), obj_text(studio.stage.character(), posed.mesh));
}

/// The box of a sequence: of sixteen of its poses, enlarged by 1 % for the poses between.
render::Bounds sequence_box(const Studio& studio) {
  constexpr std::size_t kLooks = 16;
  render::Bounds box = studio.stage.bounds(studio.stage.rest());
  const std::size_t last = studio.source.count() - 1, looks = std::min(kLooks, last);
  for (std::size_t i = 0; i <= looks; ++i) {
    const std::size_t pose = looks > 0 ? i * last / looks : 0;
    box.add(studio.stage.bounds(studio.source.posed(pose).mesh));
  }
  const double more = 0.01 * glm::length(box.high - box.low);
  box.low -= more;
  box.high += more;
  return box;
}

/// The text drawn into the pictures of one pose.
struct BurnIn {
  std::string rig, pose, worst;

  /// Returns the height of the strip that it takes.
  int put(render::Picture& picture) const {
    return rig.empty() ? 0 : render::burn_in(picture, rig, pose, worst);
  }
};

BurnIn burn_in_of(const Studio& studio, std::size_t pose, const PosedCharacter& posed) {
  if (!studio.request.burn_in) return {};
  return {studio.source.rig_in_full(), studio.source.text(pose),
          studio.source.worst_metric(pose, posed)};
}

/// Heat of a pose for the heat mode, one value per vertex; empty in other modes.
class Heat {
 public:
  static constexpr const char* kLabel = "strain / ideal";

  explicit Heat(const Studio& studio) : source_(studio.source) {
    if (studio.request.settings.mode != render::Mode::heat) return;
    const Stage& stage = studio.stage;
    body_ = std::make_unique<BodyMetrics>(stage.character(), stage.anatomy(), stage.driver());
  }
  std::vector<float> of(std::size_t pose, const PosedCharacter& posed) const {
    return body_ ? source_.strain(*body_, pose, posed) : std::vector<float>();
  }
  void put_legend(render::Picture& picture, int above_bottom) const {
    if (body_) render::draw_legend(picture, 0.0f, kStrainHeatTop, kLabel, above_bottom);
  }

 private:
  const PoseSource& source_;
  std::unique_ptr<BodyMetrics> body_;
};

/// The contact sheet and the video of a sequence of frames.
void finish_sequence(const Studio& studio, Sequence& sequence, const std::string& title,
                     const OutputFolder& folder,
                     const std::function<render::Picture(std::size_t)>& shown) {
  RenderedFiles& files = sequence.files;
  files.sheet = studio.name + "_sheet.png";
  folder.write(files.sheet,
               render::encode_png(sheet_of(sequence.pictures, sequence.labels, title)));
  files.video = studio.name + ".mp4";
  write_video(folder, files.video, sequence.pictures.size(),
              studio.request.settings.frames_per_second, shown);
}

std::vector<std::size_t> frames_of(const PictureRequest& request, std::size_t count) {
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

/// Seconds for one frame, tracing and encoding, judged by a smaller one of at most about so many.
double frame_seconds(const Studio& studio, const Photographer& photographer) {
  constexpr double kFirstSamples = 2e5, kLookSeconds = 1.0;
  const render::Settings whole = studio.settings();
  const double pixels = static_cast<double>(whole.width) * whole.height;
  const auto looked = [&](double share) {
    render::Settings part = whole;
    const double side = std::sqrt(std::min(1.0, share));
    part.width = std::max(16, static_cast<int>(whole.width * side));
    part.height = std::max(16, static_cast<int>(whole.height * side));
    const double seconds = seconds_of([&] {
      render::encode_exr(photographer.shoot(studio.request.view, part), studio.request.parts);
      poll_interrupt();
    });
    return seconds * pixels / (static_cast<double>(part.width) * part.height);
  };
  const double first = looked(kFirstSamples / (pixels * whole.samples));
  return looked(kLookSeconds / std::max(first, 1e-9));
}

/// One pose in front of its camera.
struct PoseView {
  const Studio studio;
  const std::size_t pose;
  const PosedCharacter posed;
  Photographer photographer;
  const render::Camera camera;
  const Heat heat;
  const BurnIn burn_in;

  PoseView(const PoseSource& source, std::size_t of, const PictureRequest& request)
      : studio(source, request),
        pose(of),
        posed(source.posed(pose)),
        photographer(studio.stage, framing_box(studio.stage, posed)),
        camera(render::view_camera(request.view, photographer.box(), photographer.facing(),
                                   studio.aspect())),
        heat(studio),
        burn_in(burn_in_of(studio, pose, posed)) {}

  render::Frame shoot() {
    const std::vector<float> strain = heat.of(pose, posed);
    photographer.pose(posed, strain, nullptr, studio.controllers(pose));
    render::Frame frame = photographer.shoot(camera, studio.settings());
    poll_interrupt();
    return frame;
  }

  /// The picture of a frame as people see it.
  std::vector<std::uint8_t> png(render::Picture picture) const {
    heat.put_legend(picture, burn_in.put(picture));
    return render::encode_png(picture);
  }
};

}  // namespace

int PoseSource::frame_number(std::size_t pose) const {
  return kFirstFrame + static_cast<int>(pose);
}

double minutes_a_picture(const PoseSource& source, std::size_t pose, const PictureRequest& request,
                         bool moves) {
  const Studio studio(source, request);
  PosedCharacter posed = source.posed(pose);
  Photographer photographer(studio.stage, framing_box(studio.stage, posed));
  const Heat heat(studio);
  std::vector<float> strain;
  const double pose_s = seconds_of([&] {
    posed = source.posed(pose);
    strain = heat.of(pose, posed);
    photographer.pose(posed, strain, nullptr, studio.controllers(pose));
  });
  return (frame_seconds(studio, photographer) + (moves ? pose_s : 0.0)) / 60.0;
}

std::string title_of(const PoseSource& source, const char* between) {
  const std::string body = source.stage().character().name, rig = source.rig();
  return body == rig ? body : body + between + rig;
}

RenderedFiles take_still(const PoseSource& source, std::size_t pose, const PictureRequest& request,
                         const OutputFolder& folder, Progress& progress) {
  PoseView view(source, pose, request);
  folder.prepare();
  export_obj(view.studio, view.posed);
  progress.start("frames", 1);
  const std::string stamp = view.studio.stamp(pose, view.camera);
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
  view.studio.add_provenance(frame, pose, stamp);
  folder.write(files.frames[0], render::encode_exr(frame, request.parts));
  folder.write(files.frames[1], view.png(render::picture_from(frame)));
  progress.step();
  return files;
}

std::vector<std::uint8_t> take_still_png(const PoseSource& source, std::size_t pose,
                                         const PictureRequest& request, Progress& progress) {
  PoseView view(source, pose, request);
  progress.start("frames", 1);
  std::vector<std::uint8_t> png = view.png(render::picture_from(view.shoot()));
  progress.step();
  return png;
}

RenderedFiles take_turntable(const PoseSource& source, std::size_t pose, int views, int light_views,
                             const PictureRequest& request, const OutputFolder& folder,
                             Progress& progress) {
  const Studio studio(source, request);
  const PosedCharacter posed = source.posed(pose);
  Photographer photographer(studio.stage, framing_box(studio.stage, posed));
  folder.prepare();
  export_obj(studio, posed);
  const Heat heat(studio);
  const std::vector<float> strain = heat.of(pose, posed);
  photographer.pose(posed, strain, nullptr, studio.controllers(pose));

  const std::vector<TurntableView> turn =
      turntable_views(views, light_views, photographer, studio.aspect());
  const BurnIn burn_in = burn_in_of(studio, pose, posed);
  const std::vector<std::size_t> wanted = frames_of(request, turn.size());
  Sequence sequence(studio);
  for (const std::size_t i : wanted)
    sequence.plan(kFirstFrame + static_cast<int>(i), turn[i].label);
  sequence.make(progress, [&](std::size_t n) {
    const TurntableView& view = turn[wanted[n]];
    const std::string stamp = studio.stamp(pose, view.camera, view.light_turn_deg);
    if (sequence.keep(folder, n, stamp)) return;
    render::Settings settings = studio.settings();
    settings.light_turn_deg += view.light_turn_deg;
    render::Frame frame = photographer.shoot(view.camera, settings);
    studio.add_provenance(frame, pose, stamp);
    sequence.write(folder, n, frame);
  });
  if (request.frames) return sequence.files;
  finish_sequence(studio, sequence, studio.title(pose), folder, [&](std::size_t i) {
    render::Picture picture = sequence.pictures[i];
    heat.put_legend(picture, burn_in.put(picture));
    return picture;
  });
  return sequence.files;
}

RenderedFiles take_sequence(const PoseSource& source, const std::string& title,
                            const PictureRequest& request, const OutputFolder& folder,
                            Progress& progress) {
  const Studio studio(source, request);
  PhotographerPool cameras(studio.stage, sequence_box(studio));
  folder.prepare();
  const render::Camera camera =
      render::view_camera(request.view, cameras.box(), cameras.facing(), studio.aspect());
  const Heat heat(studio);
  const std::vector<std::size_t> wanted = frames_of(request, source.count());
  std::vector<BurnIn> burn_in(wanted.size());
  PosedCharacter last_posed;  // of a rig that may remember
  std::optional<std::size_t> last;
  Sequence sequence(studio);
  for (const std::size_t i : wanted) sequence.plan(source.frame_number(i), source.text(i));
  sequence.make(progress, [&](std::size_t n) {
    const std::size_t i = wanted[n];
    // The motion layer is from the pose before.
    const std::string stamp = studio.stamp(i, camera) + (i > 0 ? "" : "-first");
    const bool kept = sequence.keep(folder, n, stamp);
    PosedCharacter before;
    if (last == i - 1 && i > 0) {
      before = std::move(last_posed);
    } else if (i > 0 && !kept) {
      before = source.posed(i - 1);
    }
    PosedCharacter now = source.posed(i);
    burn_in[n] = burn_in_of(studio, i, now);
    // Handed on where frames follow each other on one thread.
    const auto hand_on = [&] {
      if (!source.is_asked_in_order()) return;
      last = i;
      last_posed = std::move(now);
    };
    if (kept) return hand_on();
    const std::vector<float> strain = heat.of(i, now);
    const PhotographerPool::Loan photographer(cameras);
    photographer->pose(now, strain, i > 0 ? &before : nullptr, studio.controllers(i));
    render::Frame frame = photographer->shoot(camera, studio.settings());
    studio.add_provenance(frame, i, stamp);
    sequence.write(folder, n, frame);
    hand_on();
  });
  if (request.frames) return sequence.files;
  finish_sequence(studio, sequence, title, folder, [&](std::size_t i) {
    render::Picture picture = sequence.pictures[i];
    heat.put_legend(picture, burn_in[i].put(picture));
    return picture;
  });
  return sequence.files;
}

RenderedFiles take_labelled(const PoseSource& source, const std::string& kind,
                            const std::vector<std::string>& labels,
                            const std::vector<std::string>& captions, const PictureRequest& request,
                            const OutputFolder& folder, Progress& progress) {
  const Studio studio(source, request);
  folder.prepare();
  std::vector<PosedCharacter> posed;
  render::Bounds box = studio.stage.bounds(studio.stage.rest());
  for (std::size_t i = 0; i < source.count(); ++i) {
    posed.push_back(source.posed(i));
    box.add(studio.stage.bounds(posed.back().mesh));
  }
  PhotographerPool cameras(studio.stage, box);
  const render::Camera camera =
      render::view_camera(request.view, box, cameras.facing(), studio.aspect());
  Sequence sequence(studio);
  for (std::size_t i = 0; i < source.count(); ++i)
    sequence.plan(studio.name + "_" + labels[i] + ".exr", captions[i]);
  sequence.make(progress, [&](std::size_t n) {
    const std::string stamp = studio.stamp(n, camera);
    if (sequence.keep(folder, n, stamp)) return;
    const PhotographerPool::Loan photographer(cameras);
    photographer->pose(posed[n], {}, nullptr, studio.controllers(n));
    render::Frame frame = photographer->shoot(camera, studio.settings());
    studio.add_provenance(frame, n, stamp);
    sequence.write(folder, n, frame);
  });
  if (sequence.pictures.empty()) return sequence.files;
  sequence.files.sheet = studio.name + "_" + kind + ".png";
  std::vector<render::SheetCell> cells;
  for (std::size_t i = 0; i < sequence.pictures.size(); ++i)
    cells.push_back({render::shrink(sequence.pictures[i], kSheetCellWidth, kSheetCellWidth),
                     sequence.labels[i], false});
  folder.write(sequence.files.sheet,
               render::encode_png(render::contact_sheet(cells, 4, title_of(source))));
  return sequence.files;
}

}  // namespace backbend::validate
