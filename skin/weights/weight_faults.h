#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "skin/anatomy/anatomy.h"

namespace backbend::skin {

/// One joint's weights that are wrong in one way.
struct WeightFault {
  int node = -1;             // the joint that has the weight
  int other = -1;            // the joint whose area or image it is in; -1: none
  double value = 0.0;        // share of a vertex's weight, 0..1; of weight_order: of the spine
  double distance = 0.0;     // how far it stands from where it should, in the file's unit
  std::uint32_t vertex = 0;  // that shows it most
  std::size_t places = 0;    // that show it
  /// The first vertex of each of those places; none of `order`.
  std::vector<std::uint32_t> vertices = {};
};

/// The answer to one question: all joints at fault, the worst first; or why it was not asked.
struct WeightAnswer {
  std::string not_applicable;  // empty: it was asked
  std::vector<WeightFault> faults;

  double worst() const { return faults.empty() ? 0.0 : faults.front().value; }
};

/// Faults of the weights that show without any pose. Values are what is found, not yet judged: what
/// is too much is for the checks to say. Lengths below are shares of the body's largest side. Of
/// one joint at least six places, and 0.5 % of all, must show a fault: single slips are others'
/// business (stray vertices).
struct WeightFaults {
  /// The largest weight of a joint on a place of the other side (0.12 from the middle plane, or 0.6
  /// of the joint's own distance where that is less): more than 0.12 from the places
  /// where it weighs most (from elbows and knees on 0.9 of the joint's distance from the middle, if
  /// that is less), and from all where it weighs twice as much as here. Of a symmetric body
  /// also, where that finds nothing, the share of its weight that a joint has and its mirror image
  /// lacks.
  WeightAnswer wrong_side;
  /// The largest weight of a joint on a place three joints or more along the skeleton from the one
  /// that weighs most there (of a spine of many joints: 0.4 of its length, and the torso's half
  /// width), and 0.15 from its own area, where it does not fade (the next place
  /// with twice the weight is 0.2 away). Of joints that are no vertebra, or on another vertebra's
  /// area, also 0.08 away where no edges lead from there to its area, or the weight rises again by
  /// 0.04 of a vertex's weight on its way there over the mesh (two joints along the skeleton do).
  /// And any weight of a joint above the hips that leads with less than a quarter of it, on what
  /// vertebrae move, neck and head among them: it stays behind. On 24 places and 2 % of all, on 12
  /// and 0.9 % that have 0.05 of it and one 0.08, or on 12 and 0.2 % where the mirror images of a
  /// quarter of them have less than 0.8 of it. On a body that mirrors itself also humps of eight
  /// places to 0.15 of the torso with 0.08 of the weight of a joint two or more away that the other
  /// side has nowhere within 0.03. And whole pieces of costume: skin/weights/costume_pieces.h, as
  /// in `wrong_side`.
  WeightAnswer far;
  /// Left against right: the share of a joint's weight that its mirror image has and it lacks
  /// (a middle joint: one side of the other's), over places with a mirror image: a place there, or
  /// the surface within 0.01. Asked of spine, clavicles and upper arms, where 95 % of the places
  /// have an image or the torso mirrors itself (skin/weights/body_sides.h), and the spine's joints
  /// do; where fewer places have a place there, of 0.42 and more. A difference on fewer than 16
  /// places, there on any number, on none of which it is 0.25 of a vertex's weight, does not count.
  WeightAnswer asymmetry;
  /// Joints of the spine up to the chest whose middles of weight do not stand in the chain's order:
  /// by how much of the spine's length the lower one stands beyond the upper. Asked of joints that
  /// stand a fifth of the torso's width apart or more. And (`other` is `node`) joints whose
  /// weights, with those of the joints above, begin about a bone away from them because the joint
  /// between was smeared wholly into its neighbour: by how much of the spine's length.
  WeightAnswer order;
  /// Vertebrae between hips and chest whose weights stand beyond their own bones along the chain
  /// (the middle of each one's weight against its bone's ends): the median, as a share of the
  /// spine's length. `node` is the vertebra that has it, `other` the one on whose side its weights
  /// are.
  WeightAnswer levels;
  /// Vertices at one place with different weights, half the sum of the differences: they come apart
  /// in motion. Asked of one part of the mesh, and of two parts whose surfaces both end there
  /// and of which none is a prop on a joint of its own.
  WeightAnswer seams;
  /// Vertebrae whose weights meet in a hard border: skin/weights/weight_borders.h.
  WeightAnswer borders;
};

/// Asks all of them. The character's rest is what its nodes say.
WeightFaults find_weight_faults(const Character& character, const Anatomy& anatomy);

/// Where a fault is, in words: `arm_L of part "Body"`; empty for one without a place.
std::string place_of_fault(const Character& character, const Anatomy& anatomy,
                           const WeightFault& fault);

/// What was found, for a person, one line a question; and the joints whose bind pose is off.
std::vector<std::string> weight_fault_lines(const Character& character, const Anatomy& anatomy);

}  // namespace backbend::skin
