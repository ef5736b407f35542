#include "validate/farm/job.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>

#include "validate/evidence/evidence.h"
#include "validate/files/hash.h"
#include "validate/files/output_folder.h"
#include "validate/files/program_hash.h"
#include "validate/judge/confirmed.h"
#include "validate/metrics/chain/rig_probe.h"
#include "validate/sweeps/external_spec.h"
#include "validate/tasks/seconds_of.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::uintmax_t kMostPlanBytes = 1 << 20;

/// What a file holds. One that cannot be read is an entry of the report, and may have no sidecar.
std::string hash_of(const fs::path& file) {
  try {
    return content_hash(read_bytes(file));
  } catch (const ReadError&) {
    return "none";
  }
}

}  // namespace

std::string job_stamp(const RunRequest& request, const std::vector<std::string>& options) {
  const Suite& suite = request.suite;
  json facts = {{"version", BACKBEND_VERSION}, {"program", program_hash()}, {"options", options}};
  if (!suite.file.empty()) facts["suite"] = content_hash(read_bytes(suite.file));
  for (const RigPlan& rig : suite.rigs)
    facts["rigs"].push_back(
        {rig.name, rig_text(rig.spec), is_external(rig.spec) ? external_inputs(rig.spec) : ""});
  for (const fs::path& file : suite.characters) {
    facts["characters"].push_back(
        {file.filename().string(), hash_of(file), hash_of(skin::sidecar_path(file))});
  }
  return content_hash(facts.dump(-1, ' ', true, json::error_handler_t::replace));
}

void keep_plan(const JobPlan& plan, const fs::path& run) {
  if (fs::exists(run / kPlanFile)) {
    if (read_plan(run).stamp == plan.stamp) return;
    throw MixedPartsError(run.string() +
                          ": holds parts of another job (other inputs, options or program); use "
                          "another folder, or remove its 'parts'");
  }
  const json text = {
      {"arguments", plan.arguments}, {"folder", plan.folder.string()}, {"stamp", plan.stamp}};
  OutputFolder(run).write(kPlanFile,
                          text.dump(2, ' ', true, json::error_handler_t::replace) + "\n");
}

JobPlan read_plan(const fs::path& run) {
  const fs::path file = run / kPlanFile;
  const json text = json::parse(read_text(file, kMostPlanBytes), nullptr, false);
  try {
    JobPlan plan;
    text.at("arguments").get_to(plan.arguments);
    plan.folder = text.at("folder").get<std::string>();
    text.at("stamp").get_to(plan.stamp);
    return plan;
  } catch (const json::exception&) {
    throw ReadError(file.string() + ": not a job plan");
  }
}

JobEstimate estimate(const RunRequest& request) {
  const Suite& suite = request.suite;
  JobEstimate job;
  job.characters = suite.characters.size();
  job.mappings = suite.mappings.size();
  const std::vector<Sweep> sweeps = sweeps_for(suite, suite.envelope);
  job.sweeps = sweeps.size();
  for (const RigPlan& rig : suite.rigs) ++(rig.role == Role::canary ? job.canaries : job.rigs);
  std::size_t poses = 0, looked_at = 0;
  for (const Sweep& sweep : sweeps) {
    poses += sweep.pose_count();
    looked_at += sweep.watched ? sweep.pose_count() : 0;
  }
  job.poses = job.characters * job.rigs * job.mappings * poses;
  // As hunt_rigs() counts them.
  const auto share =
      static_cast<std::size_t>(std::ceil(suite.hunt.percent / 100.0 * static_cast<double>(poses)));
  job.searched = job.characters * job.rigs * job.mappings *
                 std::max(share, static_cast<std::size_t>(suite.hunt.samples));
  if (request.image_pass)
    job.small_pictures = 3 * job.characters * job.rigs * job.mappings * looked_at;
  const PicturePlan& plan = suite.pictures;
  std::size_t frames = 0;
  if (plan.enabled && !suite.sweeps.empty()) {
    if (plan.sheet_columns > 0)
      frames = job.characters * job.rigs * job.mappings * suite.sweeps.front().pose_count();
    job.pictures = frames + job.characters * static_cast<std::size_t>(plan.turntable_views);
  }
  if (suite.characters.empty() || suite.rigs.empty() || suite.sweeps.empty()) return job;

  ConfirmedCharacter confirmed = load_confirmed(suite.characters.front(), request.hints);
  const Stage stage(std::move(confirmed.character), confirmed.hints, request.chain);
  const BodyMetrics body(stage.character(), stage.anatomy(), stage.driver());
  RigRecord rig = plan_rig(stage, body, suite.rigs.front(), suite.mappings.front(),
                           {suite.sweeps.front()}, suite.envelope);
  Progress silent(Progress::Style::none);
  SweepRecord& sweep = rig.sweeps.front();
  const std::size_t middle = sweep.poses.size() / 2;
  const double pose_s = seconds_of([&] {
    measure_poses(stage, body, rig, rig_at_rest(*rig.system),
                  std::span(sweep.poses).subspan(middle, 1), silent);
  });
  const double jumps_s = seconds_of([&] { search_flips(rig, sweep.sweep); });
  const double cores = std::max(1u, std::thread::hardware_concurrency());
  const double searches =
      static_cast<double>(job.characters * job.rigs * job.mappings * job.sweeps);
  double seconds =
      (static_cast<double>(job.poses + job.searched) * pose_s + searches * jumps_s) / cores;

  const PosedCharacter posed = stage.pose(*rig.system, sweep.poses[middle].control);
  render::Bounds box = stage.bounds(stage.rest());
  box.add(stage.bounds(posed.mesh));
  Photographer photographer(stage, box);
  render::Settings settings;
  settings.width = 320;
  settings.height = 240;
  if (job.small_pictures > 0) {
    settings.samples = 1;
    settings.mode = render::Mode::primary;
    settings.position_and_albedo = true;
    seconds += static_cast<double>(job.small_pictures) * seconds_of([&] {
                 photographer.pose(posed);
                 photographer.shoot("profile", settings);
               });
  }
  if (job.pictures > 0) {
    settings = render::Settings{};
    settings.width = plan.width;
    settings.height = plan.height;
    settings.samples = plan.samples;
    // Frames of sweeps are small ones.
    const double frame_share = std::min(1.0, 320.0 * 240.0 * std::min(8, plan.samples) /
                                                 (1.0 * plan.width * plan.height * plan.samples));
    const double full = seconds_of([&] { photographer.shoot("profile", settings); });
    seconds += full * (frame_share * static_cast<double>(frames) +
                       static_cast<double>(job.pictures - frames));
  }
  job.minutes = seconds / 60.0;
  return job;
}

}  // namespace backbend::validate
