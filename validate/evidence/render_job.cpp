#include "validate/evidence/render_job.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <map>
#include <sstream>

#include "render/exr.h"
#include "render/png.h"
#include "render/sheet.h"
#include "validate/evidence/extremes.h"
#include "validate/evidence/obj.h"
#include "validate/evidence/video.h"
#include "validate/files/hash.h"
#include "validate/report/report.h"
#include "validate/run/confirmed.h"

namespace backbend::validate {
namespace {

constexpr int kSheetCells = 12;
constexpr int kSheetCellWidth = 320;

/// A character under a rig, ready to be photographed.
struct Studio {
  Stage stage;
  std::unique_ptr<solver::SpineSystem> system;
  std::string name, inputs;

  explicit Studio(const RenderRequest& request)
      : Studio(request, load_confirmed(request.character, request.hints)) {}

  Studio(const RenderRequest& request, ConfirmedCharacter confirmed)
      : stage(std::move(confirmed.character), confirmed.hints, request.chain),
        system(stage.build(request.rig.spec)) {
    const skin::Character& character = stage.character();
    name = request.name.empty() ? character.name + "_" + request.rig.name : request.name;
    // What a frame depends on beside its pose and camera.
    const render::Settings& s = request.settings;
    inputs = std::string(BACKBEND_VERSION) + "|" +
             hash_text(character.content_hash_high, character.content_hash_low) + "|" +
             rig_text(request.rig.spec) + "|" + std::string(mapping_name(request.mapping)) + "|" +
             std::to_string(s.width) + "x" + std::to_string(s.height) + "|" +
             std::to_string(s.samples) + "|" + std::to_string(s.seed) + "|" +
             std::to_string(static_cast<int>(s.mode)) + "|" + std::to_string(s.all_layers) + "|" +
             s.environment_file;
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

std::string stamp_of(const Studio& studio, const PoseDegrees& pose, const render::Camera& camera) {
  return content_hash(studio.inputs + "|" + pose.text() + "|" + camera_text(camera));
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
    // A damaged frame is made again, like one that is not there.
  }
  return std::nullopt;
}

/// Encodes and writes one frame while the next is traced; at most one is under way.
class FrameWriter {
 public:
  explicit FrameWriter(const OutputFolder& folder) : folder_(folder) {}
  ~FrameWriter() {
    if (busy_.valid()) busy_.wait();
  }
  FrameWriter(const FrameWriter&) = delete;
  FrameWriter& operator=(const FrameWriter&) = delete;

  void write(const std::string& name, render::Frame frame) {
    wait();
    busy_ = std::async(std::launch::async, [this, name, frame = std::move(frame)] {
      folder_.write(name, render::encode_exr(frame));
    });
  }
  /// Throws what went wrong with the frame under way.
  void wait() {
    if (busy_.valid()) busy_.get();
  }

 private:
  const OutputFolder& folder_;
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

std::string title_of(const Studio& studio, const RenderRequest& request) {
  return studio.stage.character().name + "  " + request.rig.name + "  " + request.pose.text();
}

}  // namespace

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
  if (request.resume) {
    if (const auto picture = picture_if_current(folder.path() / files.frames[0], stamp)) {
      folder.write(files.frames[1], render::encode_png(*picture));
      files.kept = 1;
      return files;
    }
  }
  photographer.pose(posed, {}, nullptr, studio.controllers(request, request.pose));
  render::Frame frame = photographer.shoot(camera, request.settings);
  poll_interrupt();
  add_provenance(frame, studio, request, request.pose, stamp);
  folder.write(files.frames[0], render::encode_exr(frame));
  folder.write(files.frames[1], render::encode_png(render::picture_from(frame)));
  progress.step();
  return files;
}

RenderedFiles render_turntable(const RenderRequest& request, int views, const OutputFolder& folder,
                               Progress& progress) {
  const Studio studio(request);
  const PosedCharacter posed = studio.posed(request.pose, request.mapping);
  Photographer photographer(studio.stage, framing_box(studio, posed));
  folder.prepare();
  export_obj(request, studio, posed);
  photographer.pose(posed, {}, nullptr, studio.controllers(request, request.pose));

  const double aspect = static_cast<double>(request.settings.width) / request.settings.height;
  const std::vector<render::Camera> cameras =
      render::turntable(views, photographer.box(), photographer.facing(), aspect);
  RenderedFiles files;
  std::vector<render::Picture> pictures;
  std::vector<std::string> labels;
  FrameWriter writer(folder);
  progress.start("frames", cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    poll_interrupt();
    const std::string name =
        studio.name + "." + std::to_string(kFirstFrame + static_cast<int>(i)) + ".exr";
    const std::string stamp = stamp_of(studio, request.pose, cameras[i]);
    files.frames.emplace_back(name);
    labels.push_back(number_text(360.0 * static_cast<double>(i) / views, 1) + " deg");
    if (request.resume) {
      if (auto picture = picture_if_current(folder.path() / name, stamp)) {
        pictures.push_back(std::move(*picture));
        ++files.kept;
        progress.step();
        continue;
      }
    }
    render::Frame frame = photographer.shoot(cameras[i], request.settings);
    add_provenance(frame, studio, request, request.pose, stamp);
    pictures.push_back(render::picture_from(frame));
    writer.write(name, std::move(frame));
    progress.step();
  }
  writer.wait();
  files.sheet = studio.name + "_sheet.png";
  folder.write(files.sheet,
               render::encode_png(sheet_of(pictures, labels, title_of(studio, request))));
  files.video = studio.name + ".mp4";
  write_video(folder, files.video, pictures.size(), request.settings.frames_per_second,
              [&](std::size_t i) { return pictures[i]; });
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
  FrameWriter writer(folder);
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
      render::Frame frame = photographer.shoot(camera, request.settings);
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
