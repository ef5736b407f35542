#pragma once
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "skin/anatomy/anatomy.h"

namespace backbend::skin {

/// The reflection that swaps a character's left and right, world space at rest.
struct Mirror {
  glm::dvec3 left;    // unit
  glm::dvec3 middle;  // a point of the middle plane
  glm::dvec3 operator()(const glm::dvec3& p) const {
    return p - 2.0 * glm::dot(p - middle, left) * left;
  }
};

/// The middle plane runs through the middle of the arms' roots, else of the legs', else the hips;
/// across it lies the way from the right limbs' roots to the left ones', where that is more than 2
/// degrees off the anatomy's left.
Mirror mirror_of(const Character& character, const Anatomy& anatomy);

/// The reflection that takes a body's surface, `points` at rest, onto itself, starting from
/// mirror_of() and from the middle between pairs of joints, of limbs or, where none are, by names,
/// which a body that leans to a side has in another place: fitted to the points that lie near each
/// other's images. mirror_of() itself where that is as good, or nothing is.
Mirror surface_mirror(const Character& character, const Anatomy& anatomy,
                      const std::vector<glm::dvec3>& points);

/// The body's left, up and forward as columns, unit length, left as the mirror has it.
glm::dmat3 body_axes(const Anatomy& anatomy, const Mirror& mirror);
/// Whether every joint of the spine is within 2 % of the spine's length of the middle plane.
bool spine_is_in_the_middle(const Character& character, const Anatomy& anatomy,
                            const Mirror& mirror);

/// The node on the other side of each node; itself in the middle, and where there is none. Names
/// decide, and where they tell no pair, places: of a joint in the middle whose limb lies on one
/// side (a clavicle that starts at the spine) the limb's.
std::vector<int> mirrored_nodes(const Character& character, const Mirror& mirror);

}  // namespace backbend::skin
