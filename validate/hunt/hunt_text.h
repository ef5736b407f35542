#pragma once
#include <string>
#include <vector>

#include "validate/hunt/hunt.h"

namespace backbend::validate {

/// A search for people: what was searched, each find with what to set, what may lie undiscovered.
std::string hunt_text(const HuntResult& result);
/// The same as `backbend.hunt/1`: one JSON object, keys sorted.
std::string hunt_json(const HuntResult& result);

/// A `[[pose]]` of a suite for each find that the suite does not have yet. Names are unlike those
/// that the suite has.
struct PoseRow {
  std::string name, at, from, comment;  // from: empty for rest
};
std::vector<PoseRow> pose_rows(const Hunt& hunt, const Suite& suite);
/// The text of a suite's file with the rows at its end; all else stays as it is.
std::string with_poses(std::string text, const std::vector<PoseRow>& rows);

}  // namespace backbend::validate
