#pragma once
#include "skin/weights/weight_faults.h"

namespace backbend::skin {

/// Vertebrae up to the chest whose weights meet in a hard border on a body whose other vertebrae
/// blend: there the surface breaks like a hinge while it bends softly everywhere else.
///
/// Of the edges of the mesh that lead from one joint's share of the two weights to the other's, the
/// share (0..1) on which both ends belong to one of the two alone. `node` is the lower joint,
/// `other` the next one with weight. Asked where eight edges or more cross, each on the mean
/// shorter than 0.6 of the bone between the joints (longer ones cannot hold a blend), and where of
/// the other borders of the spine, up to the head, two or more are soft, and most of them: a body
/// that is bound rigidly throughout, or built of plates (plates.h), is meant to be so.
WeightAnswer find_hard_borders(const Character& character, const Anatomy& anatomy);

}  // namespace backbend::skin
