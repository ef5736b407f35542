#pragma once
// Faults of weights and binds as they happen, planted on any character, and healthy variants of it.
#include <string>

#include "skin/anatomy/anatomy.h"

namespace backbend::skin {

/// Moves `share` of the weight that a joint has on each place to another joint, where `on` (a side
/// of the middle plane: 1 left, -1 right, 0 both) says so. Returns the number of places changed.
std::size_t move_weight(Character& character, const Anatomy& anatomy, int from, int to,
                        double share, int on = 0);

/// Gives a share of all weight on a round patch, in the middle of where `from` weighs most, to
/// another joint: all of `share` in the patch's middle, nothing at its rim, a tenth of the body's
/// largest side away.
void spill_weight(Character& character, int from, int to, double share);

/// Swaps the weights of two joints.
void swap_weights(Character& character, int a, int b);

/// Binds a joint turned by an angle about its own origin, or shifted, against the others.
void turn_bind(Character& character, int node, double angle_deg);

/// Healthy variants. Weights averaged over neighbours, so many times.
Character smoothed(const Character& character, int times);
/// Vertices joined within cells of a size (share of the height), about `places` of them left.
Character decimated(const Character& character, std::size_t places);
/// Each triangle in four, weights averaged.
Character subdivided(const Character& character);
/// The spine up to the chest with so many joints at least: its longest bones are cut, and each
/// cut bone's weights go over smoothly along it.
Character with_dense_spine(const Character& character, const Anatomy& anatomy, std::size_t joints);
/// Body and skeleton in another unit.
Character scaled(const Character& character, double factor);

/// The node of that name; -1 for none.
int planted_node(const Character& character, const std::string& name);

}  // namespace backbend::skin
