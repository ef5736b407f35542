#pragma once
#include <cstddef>
#include <glm/vec3.hpp>
#include <vector>

#include "solver/curves/box_course.h"
#include "solver/math/box_number.h"

namespace backbend::solver {

/// A chain that one turn bends over a box of poses, beside the same chain with its bones cut ever
/// finer: each step of both is carried by a share of the turn, as slerp_short() takes it from none.
/// So both are known in the frame of any share, where what is near it hardly moves.
struct BentChain {
  struct Step {
    glm::dvec3 rest{0.0};
    double share = 0.0;   // below 0 and above 1, too
    double spread = 0.0;  // how far from that the shares are by which its parts are carried, in the
                          // mean over its length
  };
  BoxTurn turn;
  std::vector<Step> bone, fine;  // from joint to joint, first step first
  // Where the two are known to lie: from a joint to a joint of the finer chain.
  std::size_t joint = 0, fine_joint = 0;
  Step gap;
};

/// The chain, held against chords of the finer one from where that is nearest to the chain's start
/// to where it is nearest to its end.
///
/// A finer chain that comes back to the place where the chain begins or ends is left out: there the
/// nearest place could be another.
BoxCourse held_course(const BentChain& chain);

}  // namespace backbend::solver
