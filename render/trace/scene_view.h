#pragma once
#include <glm/vec3.hpp>

#include "render/trace/pose_bounds.h"
#include "render/trace/ray_device.h"
#include "render/trace/scene.h"

namespace backbend::render {

/// What every pass reads of a scene in one pose.
struct SceneView {
  const MeshTopology* mesh;
  const RayScene* rays;
  PoseGeometry pose;
  glm::vec3
      rest_center;    // of the rest pose's bounding box: lights and ground stay put over all poses
  float rest_radius;  // half its diagonal, > 0
  float rest_floor;   // its lowest y
  PoseBounds bounds = {};  // of the pose
};

}  // namespace backbend::render
