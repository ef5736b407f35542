#pragma once
#include <glm/mat4x4.hpp>
#include <map>
#include <string>
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "skin/character/character.h"
#include "skin/gltf/glb_writer.h"
#include "validate/calibrate/draw.h"

namespace backbend::battery {

/// Weights of one vertex while they are worked on: by joint, any number of them.
using JointWeights = std::map<std::uint16_t, double>;

JointWeights weights_of(const skin::Influences& influences);
/// The largest `most` of them, at most skin::kMaxInfluences, largest first, summing to 1.
skin::Influences influences_of(const JointWeights& weights, std::size_t most);

/// The body with one bind matrix a node: the vertices of parts that are bound in another space than
/// the first part that goes by the node are moved to that one. Throws std::runtime_error where no
/// one motion does it.
skin::Character bound_in_one_space(skin::Character character);

/// The body as one part with one vertex a place and no pictures: what split normals and several
/// materials make of a mesh is the reader's business, and every variant is made of this.
skin::Character welded(const skin::Character& character);

/// A welded() body as a file, with a motion or without.
std::vector<std::uint8_t> encoded(const skin::Character& body,
                                  const skin::GlbAnimation* animation = nullptr);

/// A place for each vertex, and renew_normals(): after any change to the vertices.
void renew_surface(skin::Character& body);
/// Area-weighted normals of the bind mesh, one a place: after vertices were moved.
void renew_normals(skin::Character& body);
/// The vertices that share an edge with each vertex, ascending.
std::vector<std::vector<std::uint32_t>> neighbours(const skin::Character& body);

// Variants that leave a sound body sound. All take a welded() body.

/// Each vertex's weights drawn half the way to the mean of its neighbours', `steps` times.
void smooth_weights(skin::Character& body, int steps);
/// The largest `most` weights of each vertex, renormalised.
void limit_influences(skin::Character& body, std::size_t most);
/// Weights in whole parts of 255 that sum to 255: what exporters store.
void quantise_weights(skin::Character& body);
/// Shortest edges collapsed into their middles, as long as the surface stays a manifold and turns
/// no triangle over, until about `wanted` vertices are left.
void decimate(skin::Character& body, std::size_t wanted);
/// Every triangle cut into four, flat; weights are the means of their edges' ends.
void subdivide(skin::Character& body);
/// Mesh and skeleton in another unit.
void scale(skin::Character& body, double factor);
/// Mesh and skeleton reflected left to right; joints swap the names of their sides.
void mirror(skin::Character& body, const glm::dvec3& left);
/// Mesh and skeleton turned in the world.
void turn_in_world(skin::Character& body, const glm::dmat4& turn);
/// The mesh stored in another space, which the bind matrices take back: the world sees no change.
void change_bind_space(skin::Character& body, const glm::dmat4& bind_from_world);
/// The same vertices in another order.
void shuffle_vertices(skin::Character& body, validate::Draw& draw);
/// The mesh cut along a plane through the body, as an export splits vertices at a seam: triangles
/// on both sides have vertices of their own at the same places, with the same weights.
void split_vertices(skin::Character& body, const glm::dvec3& at, const glm::dvec3& normal);
/// `hero:Spine1`, `Spine1_jnt`, `SPINE1`: joints named after another house's custom, 0..4.
constexpr int kNamings = 5;
void rename_joints(skin::Character& body, int naming);

/// The chain from the hips to the joint that both arms hang from.
std::vector<int> hips_to_chest(const skin::Character& body, const skin::Anatomy& anatomy);
/// The chain hips..chest with `wanted` joints: joints are set into its longest bones, whose weights
/// they share smoothly along the bone, or the ones with the shortest bones are merged into their
/// parents, weights summed. Returns the number that it has.
std::size_t resample_spine(skin::Character& body, const skin::Anatomy& anatomy, std::size_t wanted);

/// The joint of the skin for a node, made where it has none.
std::uint16_t skin_joint(skin::Character& body, int node);
/// World matrices at rest from those of the parents.
void renew_world(skin::Character& body);

}  // namespace backbend::battery
