#pragma once
#include <string>

#include "skin/character/character.h"

namespace backbend::skin {

/// A human skeleton of sticks, 1.7 high, facing +Z, with a few vertices on every joint: `scene` (no
/// joint), `hips` at 0.9, `spine_1` .. `spine_N` at equal steps, `neck` at 1.4, `head` at 1.5,
/// thigh/shin/foot and clavicle/arm/hand with .L and .R. Arms hang from the last spine joint.
Character stick_figure(int spine_joints = 2);

/// The node with that name.
int stick_node(const Character& character, const std::string& name);

/// Adds a node that stands at a place of the world, not turned. Gives its number.
int add_node(Character& character, const std::string& name, int parent, const glm::dvec3& at);

/// Adds a triangle of vertices that follow one node alone.
void stick_vertex(Character& character, int node);

}  // namespace backbend::skin
