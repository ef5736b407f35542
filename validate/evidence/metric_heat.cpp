#include "validate/evidence/metric_heat.h"

#include <algorithm>
#include <cmath>

namespace backbend::validate {
namespace {

using Index = std::size_t;

/// Values along the spine on the vertices of the torso, between slices in proportion; 0 where no
/// slice was measured, and off the torso.
std::vector<float> along_spine(const BodyMetrics& body, const std::vector<double>& of_slice) {
  const std::vector<Slice>& slices = body.slices().slice;
  std::vector<float> out(body.coordinate().size(), 0.0f);
  if (slices.size() < 2 || of_slice.size() != slices.size()) return {};
  const auto value = [&](Index r) { return std::isfinite(of_slice[r]) ? of_slice[r] : 0.0; };
  for (Index v = 0; v < out.size(); ++v) {
    const double s = body.coordinate()[v];
    if (std::isnan(s)) continue;
    const double at = (s - slices.front().s) / body.slices().spacing;
    if (at < -0.5 || at > static_cast<double>(slices.size()) - 0.5) continue;
    const double inside = std::clamp(at, 0.0, static_cast<double>(slices.size() - 1));
    const Index r = std::min(static_cast<Index>(inside), slices.size() - 2);
    const double share = inside - static_cast<double>(r);
    out[v] = static_cast<float>(value(r) * (1.0 - share) + value(r + 1) * share);
  }
  return out;
}

/// How far the rig's arm parent takes each vertex of the arms from where the chest control takes
/// it, % of the height; 0 on the rest of the body. What BB022 is the largest of.
std::vector<float> arm_motion(const Stage& stage, const HeatPose& pose) {
  const std::vector<skin::Region> region = skin::vertex_regions(stage.character(), stage.anatomy());
  const solver::SpinePose& spine = pose.posed.spine;
  std::vector<float> out(region.size(), 0.0f);
  for (Index v = 0; v < out.size(); ++v) {
    if (region[v] != skin::Region::arm_left && region[v] != skin::Region::arm_right) continue;
    const glm::dvec3 rest(stage.rest().position[v]);
    out[v] =
        static_cast<float>(100.0 * glm::distance(spine.arms.apply(rest), spine.chest.apply(rest)) /
                           stage.anatomy().height);
  }
  return out;
}

VertexHeat scaled(std::string label, std::string unit, double end, std::vector<float> value) {
  VertexHeat heat{std::move(label), std::move(unit), 0.0f, static_cast<float>(end),
                  std::move(value)};
  for (const float each : heat.value)
    if (std::isfinite(each)) heat.high = std::max(heat.high, each);
  return heat;
}

}  // namespace

VertexHeat metric_heat(const Stage& stage, const BodyMetrics& body, const HeatPose& pose,
                       const Finding& finding) {
  const std::string& code = finding.code;
  const double limit = std::isfinite(finding.limit) ? finding.limit : 0.0;
  const bool arms = code == "BB020" || code == "BB021" || code == "BB022";
  if (arms && pose.baked) return {};
  if (arms) return scaled("arm drift, % of height", "% of height", 0.1, arm_motion(stage, pose));
  if (code == "BB033")
    return scaled("triangles that are turned inside out", "", 1.0,
                  body.inverted_heat(pose.posed.mesh, pose.posed.world_from_node));
  const RigAtRest rest = rig_at_rest(pose.system);
  if (code == "BB032")
    return scaled("strain over that of the ideal bend (limit x " + number_text(limit, 0) + ")",
                  "times", limit,
                  body.strain_heat(rest, pose.control, pose.posed.spine, pose.posed.mesh,
                                   pose.twist, pose.stretches));
  const bool kink = code == "BB010" || code == "BB011" || code == "BB013";
  const bool wring = code == "BB014" || code == "BB036" || code == "BB046";
  const bool narrow = code == "BB030" || code == "BB031";
  if (!kink && !wring && !narrow) return {};
  const BodyMeasures measured = body.measure(rest, pose.control, pose.posed.spine, pose.posed.mesh,
                                             pose.twist, pose.stretches, Crossing::left_out);
  std::vector<double> of_slice;
  if (narrow)
    for (const double ratio : measured.slices.area_ratio)
      of_slice.push_back(100.0 * std::max(0.0, 1.0 - ratio));
  else
    for (const double deg : kink ? measured.slices.kink_deg : measured.slices.twist_jump_deg)
      of_slice.push_back(std::abs(deg));
  if (narrow)
    return scaled("lost cross-section, % of rest", "% of rest",
                  code == "BB030" ? 100.0 * (1.0 - limit) : 25.0, along_spine(body, of_slice));
  const std::string own =
      code == "BB011" || code == "BB036" ? " (limit " + number_text(limit, 0) + ")" : "";
  return scaled((kink ? "mesh kink along the torso, deg" : "twist jump along the torso, deg") + own,
                "deg", own.empty() ? 5.0 : limit, along_spine(body, of_slice));
}

}  // namespace backbend::validate
