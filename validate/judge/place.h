#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "validate/metrics/surface/body_metrics.h"
#include "validate/stage/stage.h"
#include "validate/verdicts/finding.h"

namespace backbend::validate {

/// Says where on a character a finding is, in the words of those who rig it.
class PlaceNames {
 public:
  /// Keeps references; `metrics` may be null: then only joints have names.
  PlaceNames(const skin::Character& character, const skin::Anatomy& anatomy,
             const BodyMetrics* metrics);

  /// Fills joint, between, side and part of a finding with a slice or a vertex; one with a joint
  /// keeps it, and its side is that of the joint's arm or leg; drift of the arms is at their root.
  /// `posed`: the vertices in the finding's pose, or empty; without them a slice has no side.
  ///
  /// The side of a slice: where its material lines along the torso turn most beyond rest (for
  /// BB030: where they come nearest to the centre), if it is a quarter more than on the others.
  /// The side of a vertex: that of its limb; on the torso, where it stands from the spine.
  void name(std::span<const glm::vec3> posed, Finding& finding) const;

  /// Where the finding is in a pose, world space: its vertex, the middle of its slice (on its side,
  /// where it has one), or its joint. Nullopt where it has no place. `world_from_node`: of the
  /// character's nodes in the pose.
  std::optional<glm::dvec3> point(std::span<const glm::vec3> posed,
                                  std::span<const glm::dmat4> world_from_node,
                                  const Finding& finding) const;

 private:
  void name_slice(std::span<const glm::vec3> posed, Finding& finding) const;
  void name_vertex(Finding& finding) const;
  void name_between(double s, Finding& finding) const;
  std::string side_of_slice(std::span<const glm::vec3> posed, const Finding& finding) const;
  std::string side_of(const glm::dvec3& offset) const;
  std::string part_of(std::size_t vertex) const;

  const skin::Character& character_;
  const skin::Anatomy& anatomy_;
  const BodyMetrics* metrics_;
  std::vector<skin::Region> node_region_;
};

}  // namespace backbend::validate
