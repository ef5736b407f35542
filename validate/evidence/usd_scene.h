#pragma once
#include <string>
#include <vector>

#include "render/trace/cameras.h"
#include "skin/gltf/usd_writer.h"
#include "validate/model/report.h"

namespace backbend::validate {

/// The cameras of the pictures (`profile`, `front`, ...), each of which holds the whole box in a
/// 16:9 frame.
std::vector<skin::UsdCamera> usd_cameras(const render::Bounds& box, const render::Facing& facing);

/// Which of a report's findings a baked motion shows.
struct BakedMotion {
  std::string character, rig, mapping, sweep;
  std::vector<double> control_deg;  // of each frame
  int first_frame = kFirstFrame;
};

/// The findings of that rig on that character, on every sweep. Those of the motion's own sweep have
/// `time_code`: the frame whose angle is nearest. Throws ReportError, which begins with `name`,
/// where the report has no such result.
std::vector<skin::UsdNote> usd_findings(const Report& report, const std::string& name,
                                        const BakedMotion& motion);

}  // namespace backbend::validate
