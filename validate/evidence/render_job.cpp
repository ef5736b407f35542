#include "validate/evidence/render_job.h"

#include <memory>

#include "validate/evidence/extremes.h"
#include "validate/evidence/worst_metric.h"
#include "validate/files/hash.h"
#include "validate/judge/confirmed.h"
#include "validate/measure/measure.h"
#include "validate/model/report.h"
#include "validate/sweeps/external_spec.h"
#include "validate/tasks/pictures_ahead.h"
#include "validate/tasks/seconds_of.h"

namespace backbend::validate {
namespace {

/// Poses of a character under a rig.
class RigPoses : public PoseSource {
 public:
  std::vector<PoseDegrees> poses;

  explicit RigPoses(const RenderRequest& request, std::vector<PoseDegrees> all = {})
      : poses(std::move(all)),
        request_(request),
        stage_(stage_of(request)),
        system_(stage_->build(request.rig.spec)) {
    const std::string why = why_not_taken(*system_, request.pose);
    if (!why.empty())
      throw solver::RigError("rig '" + request.rig.name + "' cannot take the pose: " + why);
  }

  const Stage& stage() const override { return *stage_; }
  std::string rig() const override { return request_.rig.name; }
  std::string rig_in_full() const override {
    return rig() + " (" + std::string(mapping_name(request_.mapping)) + ")";
  }
  std::string inputs() const override {
    const skin::Character& character = stage_->character();
    return hash_text(character.content_hash_high, character.content_hash_low) + "|" +
           rig_text(request_.rig.spec) + "|" +
           (is_external(request_.rig.spec) ? external_inputs(request_.rig.spec) : "") + "|" +
           std::string(mapping_name(request_.mapping));
  }
  std::vector<render::Attribute> attributes() const override {
    return {{"backbend/rig", rig()},
            {"backbend/rigOptions", rig_text(request_.rig.spec)},
            {"backbend/mapping", std::string(mapping_name(request_.mapping))}};
  }

  std::size_t count() const override { return poses.size(); }
  PosedCharacter posed(std::size_t pose) const override {
    return stage_->pose(*system_, controls(pose));
  }
  std::string text(std::size_t pose) const override { return poses[pose].text(); }
  /// A studio's own rig may remember what it was asked before.
  bool is_asked_in_order() const override { return is_external(request_.rig.spec); }
  std::vector<float> strain(const BodyMetrics& body, std::size_t pose,
                            const PosedCharacter& posed) const override {
    return body.strain_heat(rig_at_rest(*system_), controls(pose), posed.spine, posed.mesh,
                            glm::radians(poses[pose].twist));
  }
  std::vector<render::OverlayLine> controllers(std::size_t pose) const override {
    return controller_lines(
        solver::controller_shapes(*system_, stage_->rest_chain(), controls(pose)));
  }
  std::string worst_metric(std::size_t pose, const PosedCharacter& posed) const override {
    return validate::worst_metric(*stage_, *system_, poses[pose], request_.mapping, posed);
  }

 private:
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

  std::vector<double> controls(std::size_t pose) const {
    return controls_at(*system_, poses[pose], request_.mapping);
  }

  PicturesAhead pictures_ahead_;
  const RenderRequest& request_;
  std::unique_ptr<const Stage> stage_;
  std::unique_ptr<solver::SpineSystem> system_;
};

std::vector<PoseDegrees> poses_of(const Sweep& sweep) {
  std::vector<PoseDegrees> out;
  for (std::size_t i = 0; i < sweep.pose_count(); ++i)
    out.push_back(sweep.pose_at(sweep.control_at(i)));
  return out;
}

}  // namespace

RenderEstimate estimate_frames(const RenderRequest& request, std::size_t frames, bool moves) {
  RenderEstimate out;
  out.minutes_a_frame = minutes_a_picture(RigPoses(request, {request.pose}), 0, request, moves);
  out.minutes = static_cast<double>(frames) * out.minutes_a_frame;
  return out;
}

RenderEstimate estimate_extremes(const RenderRequest& request, const std::vector<Sweep>& sweeps,
                                 const Envelope& envelope) {
  const RigPoses source(request, {request.pose});
  RenderEstimate out;
  out.minutes_a_frame = minutes_a_picture(source, 0, request, true);
  Progress silent(Progress::Style::none);
  const double first_s = seconds_of([&] {
    find_extremes(source.stage(), request.rig, request.mapping, {sweeps.front()}, envelope, silent);
  });
  double poses = 0.0;
  for (const Sweep& sweep : sweeps) poses += static_cast<double>(sweep.pose_count());
  out.minutes = first_s / 60.0 * poses / static_cast<double>(sweeps.front().pose_count());
  return out;
}

RenderedFiles render_pose(const RenderRequest& request, const OutputFolder& folder,
                          Progress& progress) {
  return take_still(RigPoses(request, {request.pose}), 0, request, folder, progress);
}

std::vector<std::uint8_t> render_pose_png(const RenderRequest& request, Progress& progress) {
  return take_still_png(RigPoses(request, {request.pose}), 0, request, progress);
}

RenderedFiles render_turntable(const RenderRequest& request, int views, int light_views,
                               const OutputFolder& folder, Progress& progress) {
  return take_turntable(RigPoses(request, {request.pose}), 0, views, light_views, request, folder,
                        progress);
}

RenderedFiles render_sweep(const RenderRequest& request, const Sweep& sweep,
                           const OutputFolder& folder, Progress& progress) {
  const RigPoses source(request, poses_of(sweep));
  return take_sequence(source, title_of(source) + "  " + sweep.name, request, folder, progress);
}

RenderedFiles render_extremes(const RenderRequest& request, const std::vector<Sweep>& sweeps,
                              const Envelope& envelope, const OutputFolder& folder,
                              Progress& progress) {
  RigPoses source(request);
  std::vector<std::string> labels, captions;
  for (const ExtremePose& extreme :
       find_extremes(source.stage(), request.rig, request.mapping, sweeps, envelope, progress)) {
    source.poses.push_back(extreme.pose);
    labels.push_back(extreme.label);
    captions.push_back(extreme.caption);
  }
  return take_labelled(source, "extremes", labels, captions, request, folder, progress);
}

}  // namespace backbend::validate
