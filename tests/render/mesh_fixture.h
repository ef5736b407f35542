#pragma once
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "render/trace/scene.h"

namespace backbend::render {

/// A mesh in one pose, with everything a Scene asks for.
struct TestMesh {
  std::shared_ptr<MeshTopology> topology;
  std::vector<glm::vec3> position, normal;

  PoseGeometry pose() const { return {position, normal, {}, {}, {}}; }
};

/// A sphere of triangles with exact normals; `rings` from pole to pole. One region, `torso`.
TestMesh sphere(const glm::vec3& center, float radius, int rings);

/// The unit square of two triangles in the plane z = 0, centred, facing +Z, `edge` long.
TestMesh square(float edge);

/// A torus standing on the plane y = 0 with two regions, `torso` and `arm_L`.
TestMesh torus(float ring_radius, float tube_radius, int segments);

/// A sphere on a vertical capsule on two capsules: something to see shadows and creases on.
TestMesh blob_figure();

/// `mesh` bent forward about the x axis, growing with height: a pose far from rest.
TestMesh bent(const TestMesh& mesh, float radians);

}  // namespace backbend::render
