#pragma once
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace backbend::validate {

/// How far one joint of a frame turns away from its usual share of the spine's bend.
struct ShareExcess {
  double deg = 0.0;        // 0: nothing beyond
  double limit_deg = 0.0;  // of that joint
  int joint = -1;          // of the joints given
  glm::dvec3 turn{0.0};    // the excess as a rotation vector, radians
};

/// Kinks and rolls that are held: one joint turned against its neighbours while the spine bends.
///
/// `turn[frame * joints + joint]`: rotation vectors of the spine's joints against the joint below,
/// rest taken off, radians, all in axes that are alike at rest. A joint's usual share is the line
///
///     turn of the joint = slope (mean turn of the others) + offset,   each axis by itself
///
/// that most frames lie on within half a degree (of about equal ones that with the smallest
/// offset), so what happens in less than half of the frames does not bend it. `from_rest`: the
/// frames start from the rest pose (a sweep of controls), so an offset is excess, too; else it is
/// posture.
///
/// The excess is the turn that is left when the share (slope x mean, for captured motion the
/// offset, too) is taken off, from the side on which less is left over.
///
/// The limit is 7 degrees and six times the median distance of the joint's frames from its line:
/// rigs keep their shares, captured spines do not, and nobody can tell a kink there.
/// One value per frame, the joint that is furthest over its limit; fewer than three joints or five
/// frames give zeros.
std::vector<ShareExcess> share_excess(std::span<const glm::dvec3> turn, std::size_t joints,
                                      bool from_rest);

}  // namespace backbend::validate
