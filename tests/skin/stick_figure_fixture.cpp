#include <glm/gtc/matrix_inverse.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <stdexcept>

#include "tests/skin/stick_figure.h"

namespace backbend::skin {

int stick_node(const Character& character, const std::string& name) {
  for (std::size_t n = 0; n < character.nodes.size(); ++n)
    if (character.nodes[n].name == name) return static_cast<int>(n);
  throw std::runtime_error("no node " + name);
}

int add_node(Character& character, const std::string& name, int parent, const glm::dvec3& at) {
  Node node;
  node.name = name;
  node.parent = parent;
  node.file_node = static_cast<int>(character.nodes.size());
  node.world_from_node = glm::translate(glm::dmat4(1.0), at);
  node.parent_from_node =
      parent < 0
          ? node.world_from_node
          : glm::affineInverse(character.nodes[static_cast<std::size_t>(parent)].world_from_node) *
                node.world_from_node;
  character.nodes.push_back(node);
  return node.file_node;
}

void stick_vertex(Character& character, int node) {
  const glm::dmat4 world = character.nodes[static_cast<std::size_t>(node)].world_from_node;
  character.joints.push_back({node, glm::affineInverse(world)});
  Influences influences;
  influences.joint[0] = static_cast<std::uint16_t>(character.joints.size() - 1);
  influences.weight[0] = 1.0f;
  const auto first = static_cast<std::uint32_t>(character.vertex_count());
  for (int k = 0; k < 3; ++k) {
    const glm::vec3 beside(k == 0 ? 0.02f : 0.0f, k == 1 ? 0.02f : 0.0f, k == 2 ? 0.02f : 0.0f);
    character.bind_position.push_back(glm::vec3(world[3]) + beside);
    character.bind_normal.emplace_back(0.0f, 0.0f, 1.0f);
    character.influences.push_back(influences);
    character.place.push_back(character.place_count++);
  }
  character.triangles.emplace_back(first, first + 1, first + 2);
}

Character stick_figure(int spine_joints) {
  Character character;
  character.name = "stick";
  character.file_name = "stick.glb";
  const auto add = [&](const std::string& name, int parent, const glm::dvec3& at) {
    const int index = add_node(character, name, parent, at);
    if (parent >= 0) stick_vertex(character, index);
    return index;
  };
  const int scene = add("scene", -1, glm::dvec3(0.0));
  const int hips = add("hips", scene, {0.0, 0.9, 0.0});
  int top = hips;
  for (int k = 1; k <= spine_joints; ++k)
    top = add("spine_" + std::to_string(k), top, {0.0, 0.9 + 0.5 * k / (spine_joints + 1), 0.0});
  const int neck = add("neck", top, {0.0, 1.4, 0.0});
  add("head", neck, {0.0, 1.5, 0.0});
  for (const double side : {1.0, -1.0}) {
    const std::string end = side > 0.0 ? ".L" : ".R";
    const int clavicle = add("clavicle" + end, top, {0.03 * side, 1.35, 0.0});
    const int arm = add("arm" + end, clavicle, {0.2 * side, 1.35, 0.0});
    add("hand" + end, arm, {0.7 * side, 1.35, 0.0});
    const int thigh = add("thigh" + end, hips, {0.1 * side, 0.88, 0.0});
    const int shin = add("shin" + end, thigh, {0.1 * side, 0.45, 0.0});
    add("foot" + end, shin, {0.1 * side, 0.05, 0.0});
  }
  return character;
}

}  // namespace backbend::skin
