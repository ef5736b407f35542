#include "skin/gltf/gltf_skeleton.h"

#include <tiny_gltf.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "skin/character/matrix_facts.h"

namespace backbend::skin {
namespace {

[[noreturn]] void fail(const std::string& file, std::size_t node, const std::string& member,
                       const std::string& cause) {
  throw CharacterError(file + ": /nodes/" + std::to_string(node) + member + ": " + cause);
}

/// Parent of every node, -1 for roots.
std::vector<int> find_parents(const tinygltf::Model& model, const std::string& file) {
  std::vector<int> parent(model.nodes.size(), -1);
  for (std::size_t n = 0; n < model.nodes.size(); ++n) {
    const auto& children = model.nodes[n].children;
    for (std::size_t c = 0; c < children.size(); ++c) {
      const std::string member = "/children/" + std::to_string(c);
      const int child = children[c];
      if (child < 0 || static_cast<std::size_t>(child) >= model.nodes.size())
        fail(file, n, member, "node " + std::to_string(child) + " does not exist");
      auto& slot = parent[static_cast<std::size_t>(child)];
      if (slot >= 0)
        fail(file, n, member,
             "node " + std::to_string(child) + " is already a child of node " +
                 std::to_string(slot));
      slot = static_cast<int>(n);
    }
  }
  return parent;
}

glm::dmat4 local_matrix(const tinygltf::Node& node, std::size_t index, const std::string& file) {
  glm::dmat4 matrix(1.0);
  if (!node.matrix.empty()) {
    if (node.matrix.size() != 16) fail(file, index, "/matrix", "not 16 numbers");
    for (int k = 0; k < 16; ++k) matrix[k / 4][k % 4] = node.matrix[static_cast<std::size_t>(k)];
    if (!is_finite(matrix)) fail(file, index, "/matrix", "not finite");
    return matrix;
  }
  const auto part = [&](const std::vector<double>& values, std::size_t size, const char* member) {
    if (!values.empty() && values.size() != size)
      fail(file, index, member, "not " + std::to_string(size) + " numbers");
    return !values.empty();
  };
  if (part(node.translation, 3, "/translation"))
    matrix[3] = {node.translation[0], node.translation[1], node.translation[2], 1.0};
  if (part(node.rotation, 4, "/rotation")) {
    // glTF stores x, y, z, w; glm takes w first.
    const glm::dquat turn(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]);
    const double length = std::sqrt(glm::dot(turn, turn));
    if (!(length > 1e-6) || !std::isfinite(length))
      fail(file, index, "/rotation", "not a quaternion of length 1");
    const glm::dmat3 axes = glm::mat3_cast(turn / length);
    for (int c = 0; c < 3; ++c) matrix[c] = glm::dvec4(axes[c], 0.0);
  }
  if (part(node.scale, 3, "/scale"))
    for (int c = 0; c < 3; ++c) matrix[c] *= node.scale[static_cast<std::size_t>(c)];
  if (!is_finite(matrix)) fail(file, index, "", "transform is not finite");
  return matrix;
}

// Film rigs reach about a hundred; a deeper file only means to cost time.
constexpr int kMaxDepth = 2048;

}  // namespace

GltfNodes read_nodes(const tinygltf::Model& model, const std::string& file) {
  const std::vector<int> parent = find_parents(model, file);
  GltfNodes out;
  out.nodes.reserve(model.nodes.size());
  out.index_of_file_node.assign(model.nodes.size(), -1);

  std::vector<int> pending, depth(model.nodes.size(), 0);
  for (std::size_t n = model.nodes.size(); n-- > 0;)
    if (parent[n] < 0) pending.push_back(static_cast<int>(n));
  while (!pending.empty()) {
    const auto n = static_cast<std::size_t>(pending.back());
    pending.pop_back();
    const tinygltf::Node& from = model.nodes[n];
    if (parent[n] >= 0) depth[n] = depth[static_cast<std::size_t>(parent[n])] + 1;
    if (depth[n] > kMaxDepth)
      fail(file, n, "", "more than " + std::to_string(kMaxDepth) + " nodes above it");
    Node node;
    node.name = from.name.empty() ? std::string("#").append(std::to_string(n)) : from.name;
    node.file_node = static_cast<int>(n);
    node.parent = parent[n] < 0 ? -1 : out.index_of_file_node[static_cast<std::size_t>(parent[n])];
    node.parent_from_node = local_matrix(from, n, file);
    node.world_from_node = node.parent < 0
                               ? node.parent_from_node
                               : out.nodes[static_cast<std::size_t>(node.parent)].world_from_node *
                                     node.parent_from_node;
    if (!is_finite(node.world_from_node)) fail(file, n, "", "world transform is not finite");
    out.index_of_file_node[n] = static_cast<int>(out.nodes.size());
    out.nodes.push_back(std::move(node));
    pending.insert(pending.end(), from.children.rbegin(), from.children.rend());
  }
  // A cycle has no root, so nothing in it was reached.
  for (std::size_t n = 0; n < model.nodes.size(); ++n)
    if (out.index_of_file_node[n] < 0) fail(file, n, "", "is its own ancestor");
  return out;
}

}  // namespace backbend::skin
