#pragma once
#include <array>
#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace backbend::skin {

/// A character file that cannot be used. what() is the whole line the user sees: file, place
/// inside it (JSON path), what was found.
struct CharacterError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A legal or tolerated oddity of a file. Codes are stable words: `weights_renormalised`.
struct Warning {
  std::string code;
  std::string message;
};

/// A node of the skeleton. Parents stand before their children whatever the file's order.
struct Node {
  std::string name;                  // `#12` (file node number) where the file has none
  int parent = -1;                   // index into Character::nodes
  int file_node = -1;                // number in the file
  glm::dmat4 parent_from_node{1.0};  // at rest
  glm::dmat4 world_from_node{1.0};   // at rest; column vectors, file's own world space and unit
};

/// A joint that moves vertices: which node, and the mesh-to-joint matrix at bind.
struct SkinJoint {
  int node = 0;
  glm::dmat4 joint_from_mesh{1.0};
};

/// Up to eight joints of one vertex, largest weight first; unused places have weight 0. Weights
/// sum to 1 (renormalised on import; the original deviation is in Character::warnings).
constexpr int kMaxInfluences = 8;
struct Influences {
  std::array<std::uint16_t, kMaxInfluences> joint{};  // into Character::joints
  std::array<float, kMaxInfluences> weight{};
};

struct Material {
  std::string name;
  glm::vec4 base_color{0.8f, 0.8f, 0.8f, 1.0f};  // linear Rec.709
  float roughness = 0.6f;
  float metallic = 0.0f;
  glm::vec3 emissive{0.0f};
  int base_color_image = -1;  // into Character::images
  int metallic_roughness_image = -1;
  int normal_image = -1;
  bool double_sided = false;
};

/// An encoded picture as it stands in the file (PNG, JPEG); decoded only when rendered.
struct EncodedImage {
  std::string name;
  std::vector<std::uint8_t> bytes;
};

/// A run of triangles with one material: one glTF primitive.
struct Part {
  std::string name;
  int material = 0;
  std::uint32_t first_triangle = 0, triangle_count = 0;
  std::uint32_t first_vertex = 0, vertex_count = 0;
};

/// A rigged character: the file's meshes in one set of arrays, and its skeleton.
///
/// Positions are in the space that SkinJoint::joint_from_mesh expects (bind space). Vertex arrays
/// hold vertex_count() entries.
struct Character {
  std::string name;                                           // file name without folder and ending
  std::string file_name;                                      // without folder
  std::uint64_t content_hash_low = 0, content_hash_high = 0;  // of all bytes read
  std::vector<Node> nodes;
  std::vector<SkinJoint> joints;
  std::vector<Part> parts;
  std::vector<Material> materials;
  std::vector<EncodedImage> images;
  std::vector<glm::vec3> bind_position;
  std::vector<glm::vec3> bind_normal;
  std::vector<glm::vec2> uv;  // empty where no part has any
  std::vector<Influences> influences;
  std::vector<glm::uvec3> triangles;
  std::vector<std::uint32_t> place;  // vertices at one rest place share a number, 0..place_count-1
  std::uint32_t place_count = 0;
  std::vector<std::uint32_t> unweighted;  // vertices that came without any weight, ascending
  std::size_t renormalised_vertices = 0;  // whose weights did not sum to 1 in the file
  double worst_weight_sum = 1.0;          // of those
  int worst_weight_vertex = -1;           // that has it; -1: none, or in a part that was left out
  std::vector<Warning> warnings;

  std::size_t vertex_count() const { return bind_position.size(); }
};

/// A mesh at one pose: world space, one entry per vertex; normals unit length.
struct PosedMesh {
  std::vector<glm::vec3> position;
  std::vector<glm::vec3> normal;
};

}  // namespace backbend::skin
