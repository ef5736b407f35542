#include "validate/evidence/usd_scene.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "validate/evidence/review.h"
#include "validate/model/report_json.h"
#include "validate/text/escape.h"
#include "validate/verdicts/checks.h"

namespace backbend::validate {
namespace {

constexpr double kAspect = 16.0 / 9.0;

skin::UsdCamera usd_camera(std::string_view view, const render::Bounds& box,
                           const render::Facing& facing) {
  const render::Camera camera = render::view_camera(view, box, facing, kAspect);
  const glm::dvec3 back = camera.eye - camera.target;
  const glm::dvec3 z = glm::normalize(back), x = glm::normalize(glm::cross(camera.up, z));
  const double distance = glm::length(back), size = glm::length(box.high - box.low);
  skin::UsdCamera out;
  out.name = view;
  out.world_from_camera = glm::dmat4(glm::dvec4(x, 0), glm::dvec4(glm::cross(z, x), 0),
                                     glm::dvec4(z, 0), glm::dvec4(camera.eye, 1));
  out.focal_mm = camera.focal_mm;
  out.film_width_mm = camera.film_width_mm;
  out.film_height_mm = camera.film_width_mm / kAspect;
  // The target is inside the box, so all of it is nearer to the target than its diagonal.
  out.near = std::max(distance - size, 0.001 * distance);
  out.far = distance + size;
  return out;
}

skin::UsdNote usd_note(const Finding& finding, const BakedMotion& motion) {
  skin::UsdNote note;
  note.name = finding.code + "_" + finding.sweep;
  const auto text = [&note](const char* key, std::string_view value) {
    if (!value.empty()) note.text.emplace_back(key, visible(value));
  };
  text("code", finding.code);
  if (const Check* check = find_check(finding.code)) text("check", check->name);
  text("sweep", finding.sweep);
  text("pose", finding.pose);
  text("verdict", name_of(finding.verdict));
  text("owner", name_of(finding.owner));
  text("joint", finding.joint);
  text("part", finding.part);
  text("side", finding.side);
  text("unit", finding.unit);
  text("detail", finding.detail);
  note.number = {
      {"value", finding.value}, {"limit", finding.limit}, {"control_deg", finding.control_deg}};
  if (finding.slice >= 0) note.number.emplace_back("slice", finding.slice);
  if (finding.vertex >= 0) note.number.emplace_back("vertex", finding.vertex);
  if (finding.sweep == motion.sweep)
    note.number.emplace_back(
        "time_code", motion.first_frame +
                         static_cast<int>(nearest_pose(motion.control_deg, finding.control_deg)));
  return note;
}

}  // namespace

std::vector<skin::UsdCamera> usd_cameras(const render::Bounds& box, const render::Facing& facing) {
  std::vector<skin::UsdCamera> cameras;
  for (const std::string_view view : render::view_names())
    cameras.push_back(usd_camera(view, box, facing));
  return cameras;
}

std::vector<skin::UsdNote> usd_findings(const Report& report, const std::string& name,
                                        const BakedMotion& motion) {
  const auto rig = std::ranges::find_if(report.rigs, [&](const RigResult& each) {
    return each.character == motion.character && each.rig == motion.rig &&
           each.mapping == motion.mapping;
  });
  if (rig == report.rigs.end()) {
    std::string there;
    for (const RigResult& each : report.rigs)
      there +=
          (there.empty() ? "" : "; ") + each.rig + " on " + each.character + ", " + each.mapping;
    throw ReportError(name + ": has no result of rig '" + motion.rig + "' on '" + motion.character +
                      "', mapping " + motion.mapping + "; it has " +
                      (there.empty() ? "none" : there));
  }
  std::vector<skin::UsdNote> notes;
  for (const Finding& each : report.findings)
    if (each.at.rig == rig - report.rigs.begin()) notes.push_back(usd_note(each, motion));
  return notes;
}

}  // namespace backbend::validate
