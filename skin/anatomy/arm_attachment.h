#pragma once
#include <vector>

#include "skin/character/character.h"

namespace backbend::skin {

/// The spine joints that a pair of arms rides on, as indices into the spine.
struct ArmAttachment {
  int left = -1, right = -1;  // -1: the body lacks that arm
  bool by_place = false;      // no joint above the hips carries them: nearest to where they start

  /// The lower of the two, -1 without arms: carried by it, neither arm leaves the other.
  int lowest() const { return left < 0 ? right : right < 0 ? left : left < right ? left : right; }
};

/// Where arms (forelegs, front fins) hang: the first spine joint above each arm's root, whatever
/// helpers stand between. Arms that hang beside the spine or from the hips (mechanism joints, feet
/// on IK) are carried by the spine joint nearest, along the spine, to the middle between their
/// roots, but below the neck: `neck` where a known rig says which joint it is, else the first that
/// is called neck or head, from the third on. That may be the hips. `spine` is hips first; chains
/// are nodes from the root outwards, empty for none.
ArmAttachment find_arm_attachment(const Character& character, const std::vector<int>& spine,
                                  const std::vector<int>& left_arm,
                                  const std::vector<int>& right_arm, int neck = -1);

/// Whether a node is a mechanism's copy of a joint, as Rigify has them: it stands where that one
/// does and is called the same but for a prefix of three letters (`ORG-spine.003` of
/// `DEF-spine.003`).
bool is_copy(const Character& character, int node, int joint);

/// The first node of `spine`, or copy of one, at or above a node, as an index into it; -1 for none.
int spine_index_above(const Character& character, const std::vector<int>& spine, int node);

}  // namespace backbend::skin
