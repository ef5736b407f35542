#pragma once
#include <string>
#include <string_view>

#include "render/trace/cameras.h"
#include "validate/sweeps/sweep.h"
#include "validate/verdicts/finding.h"

namespace backbend::validate {

/// The side from which a finding shows.
struct FindingView {
  std::string_view camera = "profile";  // of render::view_names()
  bool opposite = false;  // the same camera from the other side of the body: left and right, and
                          // front and back, change places
  std::string name = "profile";  // `profile`, `right profile`, `back`, ... as the page says it

  /// What the camera takes as the body's facing.
  render::Facing facing(const render::Facing& body) const;
};

/// Extension and flexion show in profile, a side bend from behind (from the front where the place
/// is there), a twist in three-quarter view; a place on the right from the right. Of several
/// channels the one counts that turns most of what its sweep holds.
FindingView view_of(const PoseDegrees& pose, const Finding& finding);

}  // namespace backbend::validate
