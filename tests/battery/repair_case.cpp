#include "tests/battery/repair_case.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <map>

#include "skin/anatomy/body_kind.h"
#include "skin/gltf/gltf_reader.h"
#include "skin/weights/weight_graph.h"
#include "tests/battery/cases.h"
#include "validate/judge/judge.h"
#include "validate/repair/weight_repair.h"
#include "validate/stage/stage.h"
#include "validate/verdicts/booking.h"
#include "validate/verdicts/checks.h"

namespace backbend::battery {
namespace {

namespace fs = std::filesystem;
using Index = std::size_t;
using namespace validate;

void write_bytes(const fs::path& file, const std::vector<std::uint8_t>& bytes) {
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
  if (!out.flush()) throw std::runtime_error(file.string() + ": cannot be written");
}

/// Findings by check and place.
std::map<std::string, Index> by_key(const std::vector<Finding>& findings) {
  std::map<std::string, Index> out;
  for (const Finding& each : findings)
    ++out[each.code + " " + (each.sweep.empty() ? each.joint : each.sweep)];
  return out;
}

PoseDegrees drawn_pose(const Envelope& envelope, Draw& draw) {
  PoseDegrees pose;
  const double bend = draw.uniform(-envelope.flexion, envelope.extension);
  pose.extension = std::max(bend, 0.0);
  pose.flexion = std::max(-bend, 0.0);
  pose.side = draw.uniform(-envelope.side, envelope.side);
  pose.twist = draw.uniform(-envelope.twist, envelope.twist);
  return pose;
}

/// A body made ready to be measured at single poses under the ideal bend.
class Measured {
 public:
  Measured(const skin::Character& character, const skin::Anatomy& anatomy)
      : stage_(character, anatomy),
        body_(stage_.character(), stage_.anatomy(), stage_.driver()),
        system_(stage_.build({"even", {}})) {}
  /// The factor of each deciding check's limit from which weights decide; above 1 it fails.
  std::map<std::string, double> at(const PoseDegrees& pose, const Envelope& envelope) const {
    PoseRecord record;
    record.body = pose;
    record.control = controls_at(*system_, pose, solver::Mapping::chest);
    measure_pose(body_, rig_at_rest(*system_), stage_.pose(*system_, record.control), record);
    std::map<std::string, double> out;
    if (record.at(MetricId::feasibility).value >= 1.0) return out;
    const LimitSet limits;
    for (const Metric& metric : metric_table()) {
      const Check& check = metric.check();
      if (check.subject != Subject::mesh || !check.decides) continue;
      const double value = record.at(metric.id).value;
      if (!std::isfinite(value)) continue;
      const double limit =
          limit_at(check.code, limits.of(check.code).value, compound_load(envelope, pose));
      out[std::string(check.code)] = excess(check, value, weights_limit(check, limit));
    }
    return out;
  }

 private:
  Stage stage_;
  BodyMetrics body_;
  std::unique_ptr<solver::SpineSystem> system_;
};

}  // namespace

RepairScore score_repair(const skin::Character& healthy, const skin::Character& faulted,
                         const WeightFault& fault, const fs::path& scratch, Index poses,
                         std::uint64_t seed) {
  RepairScore out;
  fs::create_directories(scratch);
  const fs::path file = scratch / "faulted.glb", twin = scratch / "healthy.glb";
  std::vector<std::uint8_t> bytes = encoded(faulted);
  if (!fault.file_scale.empty()) scale_written_weights(bytes, fault.file_scale);
  write_bytes(file, bytes);
  write_bytes(twin, encoded(healthy));
  Progress progress(Progress::Style::none);
  WeightRepair repair;
  const auto start = std::chrono::steady_clock::now();
  try {
    repair = repair_weights(file, {}, progress);
  } catch (const skin::CharacterError& error) {
    out.refused = error.what();
    return out;
  }
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  out.measurements = repair.measurements;
  for (const RepairStep& step : repair.steps)
    if (step.taken) out.done.push_back(step.what);
  const auto known = by_key(repair_weights(twin, {}, progress).before);
  const auto before = by_key(repair.before), after = by_key(repair.after);
  for (const auto& [key, count] : before)
    if (known.count(key) == 0) out.planted += count;
  for (const auto& [key, count] : after) {
    if (known.count(key) > 0) continue;
    const auto was = before.find(key);
    const Index old = was == before.end() ? 0 : was->second;
    out.left += std::min(count, old);
    out.added += count - std::min(count, old);
  }
  out.vertices = repair.touched.size();
  out.largest_change = repair.largest_change;
  Index counted = 0;
  for (Index v = 0; v < out.vertices; ++v) {
    const bool faulty = v < fault.touched.size() && fault.touched[v];
    out.faulty += faulty;
    out.touched += repair.touched[v];
    out.beyond += repair.touched[v] && !faulty;
    if ((!faulty && !repair.touched[v]) || v >= healthy.vertex_count()) continue;
    // Joints by node: the file may number them anew.
    const auto by_node = [](const skin::Character& body, const skin::Influences& from) {
      skin::JointShares shares;
      for (const auto& [joint, share] : skin::shares_of(from))
        shares[static_cast<std::uint16_t>(std::hash<std::string>()(
            body.nodes[static_cast<Index>(body.joints[joint].node)].name))] += share;
      return shares;
    };
    const skin::JointShares right = by_node(healthy, healthy.influences[v]);
    out.off_before +=
        skin::share_moved(right, by_node(repair.character, repair.character.influences[v]));
    out.off_after += skin::share_moved(right, by_node(repair.character, repair.influences[v]));
    ++counted;
  }
  if (counted > 0) {
    out.off_before /= static_cast<double>(counted);
    out.off_after /= static_cast<double>(counted);
  }
  if (poses == 0 || repair.touched_count == 0) return out;
  skin::Character mended = repair.character;
  mended.influences = repair.influences;
  const skin::Anatomy anatomy = skin::find_anatomy(mended);
  const Envelope envelope = envelope_for(skin::body_kind(mended, anatomy).kind, false);
  const Measured old_body(repair.character, anatomy), new_body(mended, anatomy);
  Draw draw(seed, 17'000'000);
  std::vector<PoseDegrees> drawn;
  for (Index i = 0; i < poses; ++i) drawn.push_back(drawn_pose(envelope, draw));
  std::vector<Index> made(poses, 0);
  oneapi::tbb::parallel_for(Index{0}, poses, [&](Index i) {
    const auto was = old_body.at(drawn[i], envelope);
    for (const auto& [code, factor] : new_body.at(drawn[i], envelope)) {
      const auto old = was.find(code);
      made[i] += factor > 1.0 && (old == was.end() || old->second <= 1.0);
    }
  });
  out.poses = poses;
  for (const Index each : made) out.new_at_poses += each;
  return out;
}

}  // namespace backbend::battery
