#pragma once
#include <cstdint>
#include <filesystem>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "skin/character/character.h"

namespace backbend::skin {

/// A joint of a described body. World space, +Y up, facing +Z, metres.
struct BodyJoint {
  std::string name;
  int parent = -1;  // stands before its children
  int twin = -1;    // the joint on the other side; itself for one in the middle
  glm::dvec3 at{0.0};
};

/// One cross-section of a loft: four half axes of a superellipse in the plane across the axis.
struct BodySection {
  double at = 0.0;                    // metres along the axis from its first point
  double outer = 0.05, inner = 0.05;  // towards and against BodySolid::side
  double front = 0.05, back = 0.05;   // towards and against BodySolid::front
  double square = 2.0;                // exponent: 2 an ellipse, larger squarer
};

/// One solid of the description; solids of a group are joined (or cut away) in order.
struct BodySolid {
  enum class Shape { loft, ellipsoid, cone };
  enum class Use { add, cut };
  Shape shape = Shape::loft;
  Use use = Use::add;
  bool mirrored = false;  // stands for itself (x > 0) and its mirror image
  double blend = 0.01;    // metres over which it melts into what stands before it

  std::vector<glm::dvec3> axis;  // loft: two or more points of its axis curve; cone: both ends
  std::vector<BodySection> sections;
  glm::dvec2 cap{0.0};  // lengths of the domes that close a loft beyond its first and last section
  glm::dvec2 radius{0.05};  // cone
  glm::dvec3 side{1, 0, 0}, front{0, 0, 1};
  glm::dvec3 center{0.0}, radii{0.05};   // ellipsoid
  glm::dmat3 world_from_ellipsoid{1.0};  // rotation

  std::vector<int> joints;  // what its surface follows, from the root outwards; empty: what is near
  std::vector<double>
      transition;        // half length in metres of the change at each joint but the first
  double soften = 0.02;  // metres over which its weights melt into its neighbours'
};

struct BodyGroup {
  std::string name;
  double blend = 0.02;  // metres over which the group melts into the groups before it
  std::vector<BodySolid> parts;
};

/// A body as its description file has it: a skeleton and the solids around it. Symmetric about x =
/// 0.
struct BodyDescription {
  std::string name, file_name;
  std::uint64_t content_hash_low = 0, content_hash_high = 0;  // of the file's bytes
  std::vector<BodyJoint> joints;
  std::vector<BodyGroup> groups;
  Material material;
  int vertices = 20000;                  // of the finished mesh, where nothing else is asked for
  double cell = 0.004;                   // metres: the grid that first finds the surface
  double fold = 0.004;                   // metres: how softly mirrored solids meet at x = 0
  double finest = 0.35, coarsest = 1.5;  // edge lengths against the typical one
  bool symmetric = true;  // about x = 0; if not, all of it lies at x > 0 and is not mirrored
  bool tunnels = false;   // whether the surface may have any
  int core = -1;          // a joint inside the solids to start from; -1: the root
  glm::dmat4 world_from_body{1.0};  // for a body around a skeleton of other axes and units
};

/// Reads a description (schema `backbend.body/1`, see scenes/characters/human.toml). Throws
/// CharacterError naming file, line and key for unknown keys, joints that are not there, sizes that
/// are not positive.
BodyDescription read_body_description(const std::filesystem::path& path);

}  // namespace backbend::skin
