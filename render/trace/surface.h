#pragma once
#include "render/trace/bsdf.h"
#include "render/trace/scene_view.h"

namespace backbend::render {

/// Where eight rays meet the mesh.
struct Surface8 {
  Int8 triangle;
  Int8 vertex[3];
  Vec8 barycentric;  // weights of the three vertices, sum 1
  Vec8 position;     // world, exactly on the triangle
  Vec8 geometric;    // unit normal of the triangle, towards the viewer
  Vec8 shading;      // unit, interpolated, towards the viewer
  Vec8 launch;       // where rays leave from: lifted off the triangle, and off its flatness
};

/// The meeting points of rays with triangles, computed from the triangles alone (never from what
/// the ray device says), so that they do not depend on the tree or on the packet. Directions need
/// not be unit. Lanes without a hit may name any triangle; what they get means nothing.
/// The launch point follows the smooth surface that the normals describe, which keeps a coarse mesh
/// from shadowing itself along its edges.
/// Source: T. Moeller and B. Trumbore, 1997; J. Hanika, "Hacking the Shadow Terminator", Ray
/// Tracing Gems II, chapter 4, 2021.
Surface8 surface_at(const SceneView& scene, Int8 triangle, const Vec8& origin,
                    const Vec8& direction);

/// Value at a lane's point of something given per vertex.
template <class T>
T interpolate(std::span<const T> per_vertex, const Surface8& at, unsigned lane) {
  return per_vertex[at.vertex[0][lane]] * at.barycentric.x[lane] +
         per_vertex[at.vertex[1][lane]] * at.barycentric.y[lane] +
         per_vertex[at.vertex[2][lane]] * at.barycentric.z[lane];
}

/// The region that owns a lane's point: that with the largest weight among the three vertices.
std::uint8_t region_at(const MeshTopology& mesh, const Surface8& at, unsigned lane);

/// Reflectance of the material at the lanes in `mask` (bit i: lane i), textures applied; a normal
/// picture turns at.shading.
Bsdf8 material_at(const SceneView& scene, Surface8& at, unsigned mask);

/// Colour of the material alone at one lane: the albedo layer.
glm::vec3 base_color_at(const SceneView& scene, const Surface8& at, unsigned lane);

}  // namespace backbend::render
