#pragma once
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

namespace backbend::validate {

/// How far one joint of a frame turns away from its usual share of the spine's bend.
struct ShareExcess {
  /// What the joint is beyond: its share (share_excess), what all joints together turn
  /// (counter_turns: others turn it back), or the joints beside it (peak_turns).
  enum class Beyond { share, whole, neighbours };
  double deg = 0.0;        // 0: nothing beyond
  double limit_deg = 0.0;  // of that joint
  int joint = -1;          // of the joints given
  glm::dvec3 turn{0.0};    // the excess as a rotation vector, radians
  Beyond beyond = Beyond::share;
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
/// In a wide pose of several channels a healthy joint leaves that line (`from_rest` only), for the
/// joints below it turn its axes. But it does so smoothly: its turn leaves the chord, from a tenth
/// of the frames before to a tenth after, by little of the excess. Of 60 rigs with random shares
/// and orders of turning, 13 joints were over their limit in sweeps to a corner, with at most 0.026
/// of the excess; 600 kinks and rolls of 10 to 25 degrees had 0.08 and more, but for some of those
/// that grow over half of the sweep, of which 4 of 152 are below the 0.06 at which a joint is taken
/// for healthy. An offset of half the excess or more is never taken so.
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

/// What is known of a motion.
struct MotionFacts {
  bool of_controls = false;   // a sweep of controls from rest
  bool mirrored_rig = false;  // of a spine in the body's middle plane, by controls, or nothing but
                              // the spine moves
  // At rest, of the joint below the first and of all joints; empty: bones of one length.
  std::vector<glm::dvec3> rest_place = {};
};

/// Kinks and rolls that grow with the motion, so that share_excess() takes them for the joint's
/// share: one joint turns about an axis about which the spine as a whole does not turn, or against
/// it, or by more than all of it, and its neighbours turn back.
///
/// `turn` as for share_excess(). Columns of `axes`: the body's left, up and forward, unit length,
/// in the axes of the turns. About each of them, what lies outside of 0 and the sum over all joints
/// is excess.
///
/// The limit is 7 degrees or, where it is more, 0.45 of what all joints turn in the widest frame,
/// for along a curved rest pose one axis brings another with it (splines reach 0.44); and six times
/// the median distance of the joint's frames from motion in which all joints keep one proportion.
/// Frames in which the joints together turn by less than 10 degrees are zeros, as are fewer than
/// three joints or five frames, and all frames of a motion that stays near one posture.
///
/// Without controls only motion in which all joints keep one proportion to a degree is asked: who
/// poses a spine or captures one may turn any joint against the others.
///
/// Where a mirrored rig's motion starts at rest and keeps its proportions, one control drives it;
/// by symmetry a bend in the middle plane then gives no joint roll or side bend, and side bend and
/// twist no bend in the plane but one that grows with their square. What a joint has of these is
/// held to 7 degrees and six times the median alone.
std::vector<ShareExcess> counter_turns(std::span<const glm::dvec3> turn, std::size_t joints,
                                       const glm::dmat3& axes, const MotionFacts& facts);

/// Kinks and rolls that grow with a sweep of controls, about its own axis: one joint turns further
/// than each of the two beside it. Rigs share a bend as they like, evenly, by a slope, by halves or
/// by a spline, but none of these gives one joint much more than both neighbours.
///
/// `turn` and `axes` as for counter_turns(); the excess is taken about each of the three axes,
/// beyond what the larger neighbour turns in the direction of the whole, each times the ratio of
/// the two joints' bones where this one's are longer (up to 3). The first joint, which has one
/// neighbour, is held against the line through the two above it; the last is not asked. A joint
/// that turns against the whole while both neighbours turn with it is beyond them by what lies
/// between it and the nearer (for the first joint: while the two above it do).
///
/// The limit is 4 degrees, 0.12 of what all joints turn in that frame (0.2 of a spine of three
/// joints, where one in the middle has both ends to itself), and six times the median distance from
/// motion in one proportion. Our own systems on nine characters reach 0.07, within and beyond the
/// envelope, but for poses in which a spline or a flip puts half of the bend into one joint. Fewer
/// than three joints, five frames, 10 degrees, and motion that stays near one posture give zeros;
/// so does motion without controls.
std::vector<ShareExcess> peak_turns(std::span<const glm::dvec3> turn, std::size_t joints,
                                    const glm::dmat3& axes, const MotionFacts& facts);

/// counter_turns() and, where the motion is a sweep of controls, share_excess() and peak_turns(),
/// too: each frame's joint that is further over its limit.
std::vector<ShareExcess> joint_excess(std::span<const glm::dvec3> turn, std::size_t joints,
                                      const glm::dmat3& axes, const MotionFacts& facts);

/// In words, after the joint's name: ` rolls by 12.1 deg beyond the joints beside it`. `bone`:
/// the joint's own at rest, in the axes of the turns; within 45 degrees of it a turn is a roll.
std::string words_of(const ShareExcess& excess, const glm::dvec3& bone);

}  // namespace backbend::validate
