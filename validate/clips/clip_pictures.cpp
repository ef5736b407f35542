#include "validate/clips/clip_pictures.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "render/image/png.h"
#include "validate/camera/photographer.h"
#include "validate/clips/clip_images.h"
#include "validate/evidence/finding_view.h"
#include "validate/evidence/heat_picture.h"
#include "validate/judge/judge.h"
#include "validate/model/digest.h"
#include "validate/text/escape.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

/// How many findings get pictures, one of each check; of these so many as meshes in the page.
constexpr Index kPictured = 6, kMeshes = 3;
/// So many frames for the scrubber at most, over all sweeps.
constexpr Index kMostFrames = 96;

/// The clip's frames as the photographer takes them.
class ClipCamera {
 public:
  ClipCamera(const ClipScene& scene, const PicturePlan& plan)
      : scene_(scene), photographer_(scene.stage, scene.stage.bounds(scene.stage.rest())) {
    settings_.width = plan.width;
    settings_.height = plan.height;
    settings_.samples = plan.samples;
  }

  PosedCharacter posed(Index frame) const {
    return {scene_.system().pose(frame), scene_.body.world_from_node(frame),
            scene_.body.mesh(frame), nullptr};
  }

  /// The body's facing in a frame: its hips' heading, on the ground.
  render::Facing facing(Index frame) const {
    const skin::Anatomy& anatomy = scene_.stage.anatomy();
    const auto hips = static_cast<Index>(anatomy.spine.front());
    const glm::dmat4 moved = scene_.body.world_from_node(frame)[hips] *
                             glm::inverse(scene_.stage.character().nodes[hips].world_from_node);
    const glm::dvec3 forward = glm::dmat3(moved) * anatomy.forward;
    const glm::dvec3 flat = forward - anatomy.up * glm::dot(forward, anatomy.up);
    // Hips that look straight up or down have no heading.
    constexpr double kLeastHeading = 0.2;
    const double length = glm::length(flat);
    if (!(length > kLeastHeading * glm::length(forward)) || !std::isfinite(length))
      return {anatomy.up, anatomy.forward};
    return {anatomy.up, flat / length};
  }

  /// What the chest is turned against the hips from rest, as a pose says it, degrees: enough to
  /// tell from which side the bend shows.
  PoseDegrees bend(Index frame) const {
    const skin::Anatomy& anatomy = scene_.stage.anatomy();
    const glm::dquat turn = scene_.body.turn(frame, anatomy.spine[anatomy.chest_index]);
    PoseDegrees pose;
    if (!std::isfinite(glm::dot(turn, turn))) return pose;
    const glm::dquat shorter = turn.w < 0.0 ? -turn : turn;
    const glm::dvec3 axis(shorter.x, shorter.y, shorter.z);
    const double sine = glm::length(axis);
    if (!(sine > 0.0)) return pose;
    const glm::dvec3 degrees = axis / sine * glm::degrees(2.0 * std::atan2(sine, shorter.w));
    const double bend = glm::dot(degrees, anatomy.left);
    (bend < 0.0 ? pose.extension : pose.flexion) = std::abs(bend);
    pose.side = glm::dot(degrees, anatomy.forward);
    pose.twist = glm::dot(degrees, anatomy.up);
    return pose;
  }

  /// Near the place, or of the whole body.
  render::Camera camera(const FindingView& view, Index frame, const PosedCharacter& body,
                        const std::optional<glm::dvec3>& place) const {
    const double aspect = static_cast<double>(settings_.width) / settings_.height;
    const render::Facing from = view.facing(facing(frame));
    if (place)
      return render::close_up(view.camera, *place, kCloseUp * scene_.stage.anatomy().spine_length,
                              from, aspect);
    return render::view_camera(view.camera, scene_.stage.bounds(body.mesh), from, aspect);
  }

  render::Picture still(const PosedCharacter& body, const render::Camera& camera) {
    photographer_.pose(body);
    render::Settings settings = settings_;
    settings.mattes = false;
    return render::picture_from(photographer_.shoot(camera, settings));
  }

  render::Picture heat(const PosedCharacter& body, const VertexHeat& values,
                       const render::Camera& camera, const std::optional<glm::dvec3>& mark) {
    return heat_picture(photographer_, settings_, body, values, camera, mark);
  }

  /// One small frame for the scrubber, the body in the middle and always of one size.
  render::Picture small(Index frame, double radius) {
    const render::Settings settings = scrubber_frame(settings_);
    const PosedCharacter body = posed(frame);
    const render::Bounds box = scene_.stage.bounds(body.mesh);
    photographer_.pose(body);
    const render::Camera camera =
        render::close_up("profile", 0.5 * (box.low + box.high), radius, facing(frame),
                         static_cast<double>(settings.width) / settings.height);
    return render::picture_from(photographer_.shoot(camera, settings));
  }

 private:
  const ClipScene& scene_;
  Photographer photographer_;
  render::Settings settings_;
};

/// The worst findings, one of each check.
std::vector<Index> pictured(const Report& report) {
  const Digest digest(report);
  std::vector<Index> out;
  std::vector<std::string> codes;
  for (const Finding* finding : digest.worst(report.findings.size())) {
    if (out.size() == kPictured) break;
    if (finding->at.pose < 0 || std::ranges::find(codes, finding->code) != codes.end()) continue;
    codes.push_back(finding->code);
    out.push_back(static_cast<Index>(finding - report.findings.data()));
  }
  return out;
}

void picture_finding(const ClipScene& scene, ClipCamera& camera, const OutputFolder& folder,
                     const std::string& place, bool in_page, Index index, Report& report) {
  Finding& finding = report.findings[index];
  const SweepRecord& sweep = *sweep_of(scene.record, finding);
  const auto in_sweep = static_cast<Index>(finding.at.pose);
  const Index frame = frame_of(sweep.poses[in_sweep]);
  const PosedCharacter here = camera.posed(frame);
  const FindingView view = view_of(camera.bend(frame), finding);
  const auto mark = scene.places.point(here.mesh.position, here.world_from_node, finding);
  const bool jump = finding.code == "BB001" && in_sweep > 0;
  const render::Camera from =
      camera.camera(view, frame, here, jump ? std::optional<glm::dvec3>{} : mark);
  const auto write = [&](const std::string& name, const render::Picture& picture) {
    folder.write(name, render::encode_png(picture));
    return name;
  };
  const double height = scene.stage.anatomy().height;
  VertexHeat heat;
  finding.pictures.view = view.name;
  if (jump) {
    const PosedCharacter before = camera.posed(frame - 1);
    finding.pictures.before = write(place + "/before.png", camera.still(before, from));
    finding.pictures.after = write(place + "/after.png", camera.still(here, from));
    heat = distance_heat(here, before, height, "moved in the jump");
  } else {
    finding.pictures.before = write(place + "/frame.png", camera.still(here, from));
    const std::vector<double> control = {static_cast<double>(frame)};
    heat = metric_heat(
        scene.stage, scene.metrics,
        {scene.system(), control, here, glm::radians(scene.system().twist_deg(frame)), false, true},
        finding);
    if (heat.value.empty() && in_sweep > 0)
      heat = distance_heat(here, camera.posed(frame - 1), height, "moved since the frame before");
  }
  if (heat.value.empty()) return;
  finding.pictures.heat_of = heat.label;
  finding.pictures.heat = write(place + "/heat.png", camera.heat(here, heat, from, mark));
  const skin::Character& character = scene.stage.character();
  write_posed_glb(folder, place, character, here, heat);
  if (in_page)
    add_page_mesh(folder, place, finding.rig + ", " + finding.pose, character, here, heat,
                  view.name, mark, static_cast<int>(index), report);
}

/// Half the largest extent that the body has in any frame.
double largest_radius(const ClipScene& scene, const SweepRecord& sweep, Index step) {
  double radius = 0.0;
  for (Index i = 0; i < sweep.poses.size(); i += step) {
    const render::Bounds box = scene.stage.bounds(scene.body.mesh(frame_of(sweep.poses[i])));
    if (!box.is_empty()) radius = std::max(radius, 0.5 * glm::distance(box.low, box.high));
  }
  return radius;
}

void shoot_sweep(const ClipScene& scene, ClipCamera& camera, const SweepRecord& sweep, Index step,
                 const OutputFolder& folder, Progress& progress, SweepSeries& series) {
  const double radius = largest_radius(scene, sweep, step);
  if (!(radius > 0.0) || !std::isfinite(radius)) return;
  series.frame.assign(sweep.poses.size(), "");
  for (Index i = 0; i < sweep.poses.size(); i += step) {
    poll_interrupt();
    const std::string name = "review/" + file_word(series.sweep) + "." +
                             std::to_string(kFirstFrame + static_cast<int>(i)) + ".png";
    folder.write(name, render::encode_png(camera.small(frame_of(sweep.poses[i]), radius)));
    // The frames around one that was taken show it.
    const Index first = i - std::min(i, (step - 1) / 2);
    const Index last = std::min(sweep.poses.size(), i + step);
    std::fill(series.frame.begin() + static_cast<std::ptrdiff_t>(first),
              series.frame.begin() + static_cast<std::ptrdiff_t>(last), name);
    progress.step();
  }
}

}  // namespace

void make_clip_pictures(const ClipScene& scene, const PicturePlan& plan, const OutputFolder& folder,
                        Progress& progress, Report& report) {
  folder.prepare();
  ClipCamera camera(scene, plan);
  const std::vector<Index> chosen = pictured(report);
  Index frames = 0;
  for (const SweepRecord& sweep : scene.record.sweeps) frames += sweep.poses.size();
  const Index step = std::max<Index>(1, (frames + kMostFrames - 1) / kMostFrames);
  progress.start("pictures", chosen.size() + frames / step);
  for (Finding& finding : report.findings) finding.image.note = "not looked at: worse ones were";
  for (Index n = 0; n < chosen.size(); ++n) {
    poll_interrupt();
    Finding& finding = report.findings[chosen[n]];
    finding.image = clip_witness(scene, *sweep_of(scene.record, finding), finding);
    picture_finding(scene, camera, folder,
                    "findings/" + file_word(finding.sweep) + "_" + finding.code, n < kMeshes,
                    chosen[n], report);
    progress.step();
  }
  for (Index s = 0; s < scene.record.sweeps.size(); ++s)
    shoot_sweep(scene, camera, scene.record.sweeps[s], step, folder, progress,
                report.rigs.front().sweeps[s]);
  progress.finish();
}

}  // namespace backbend::validate
