#include "skin/gltf/gltf_skins.h"

#include <tiny_gltf.h>

#include <glm/gtc/type_ptr.hpp>

#include "skin/character/printable.h"

namespace backbend::skin {
namespace {

constexpr std::size_t kMaxJoints = 65535;

/// `skeleton` has no effect on transforms, and exporters often get it wrong: what is wrong with it,
/// or nothing.
std::string skeleton_complaint(int hint, const std::vector<int>& index_of_file_node,
                               const std::vector<Node>& nodes, const BoundSkin& skin) {
  if (hint < 0) return "";
  const std::string name = "node " + std::to_string(hint);
  if (static_cast<std::size_t>(hint) >= index_of_file_node.size())
    return name + " does not exist; it is ignored";
  const int top = index_of_file_node[static_cast<std::size_t>(hint)];
  for (int node : skin.node) {
    while (node >= 0 && node != top) node = nodes[static_cast<std::size_t>(node)].parent;
    if (node != top) return name + " is not above every joint; it is ignored";
  }
  return "";
}

}  // namespace

JointNumbers::JointNumbers(Character& character)
    : character_(character), of_node_(character.nodes.size()) {}

std::uint32_t JointNumbers::number(int node, const glm::dmat4& joint_from_mesh) {
  auto& known = of_node_[static_cast<std::size_t>(node)];
  for (const std::uint32_t joint : known)
    if (character_.joints[joint].joint_from_mesh == joint_from_mesh) return joint;
  if (character_.joints.size() >= kMaxJoints)
    throw CharacterError(character_.file_name + ": /skins: more than 65535 joints");
  character_.joints.push_back({node, joint_from_mesh});
  known.push_back(static_cast<std::uint32_t>(character_.joints.size() - 1));
  return known.back();
}

GltfSkins read_skins(const tinygltf::Model& model, const std::string& file,
                     const GltfAccessors& accessors, const std::vector<int>& index_of_file_node,
                     const std::vector<Node>& nodes, JointNumbers& numbers) {
  const auto fail = [&](const std::string& place, const std::string& cause) {
    throw CharacterError(file + ": " + place + ": " + cause);
  };
  GltfSkins out;
  for (std::size_t s = 0; s < model.skins.size(); ++s) {
    const tinygltf::Skin& from = model.skins[s];
    BoundSkin skin;
    std::vector<std::uint32_t> number;
    const std::string place = "/skins/" + std::to_string(s);
    if (from.joints.empty()) fail(place + "/joints", "no joints");
    std::vector<float> binds;
    if (from.inverseBindMatrices >= 0) {
      const std::string bind_place = place + "/inverseBindMatrices";
      if (accessors.count(from.inverseBindMatrices, bind_place) < from.joints.size())
        fail(bind_place, "fewer matrices than joints");
      binds = accessors.numbers(from.inverseBindMatrices, 16, bind_place);
    }
    std::vector<int> first(index_of_file_node.size(), -1);  // place in the list, of each node
    for (std::size_t j = 0; j < from.joints.size(); ++j) {
      const int node = from.joints[j];
      if (node < 0 || static_cast<std::size_t>(node) >= index_of_file_node.size())
        fail(place + "/joints/" + std::to_string(j),
             "node " + std::to_string(node) + " does not exist");
      skin.node.push_back(index_of_file_node[static_cast<std::size_t>(node)]);
      int& twin = first[static_cast<std::size_t>(node)];
      if (twin >= 0)
        fail(place + "/joints/" + std::to_string(j),
             "joint " + in_quotes(nodes[static_cast<std::size_t>(skin.node.back())].name) +
                 " stands twice in this skin (also at " + std::to_string(twin) +
                 "); a skin lists each joint once");
      twin = static_cast<int>(j);
      skin.joint_from_mesh.push_back(
          binds.empty() ? glm::dmat4(1.0) : glm::dmat4(glm::make_mat4(binds.data() + 16 * j)));
      number.push_back(numbers.number(skin.node.back(), skin.joint_from_mesh.back()));
    }
    if (const auto complaint = skeleton_complaint(from.skeleton, index_of_file_node, nodes, skin);
        !complaint.empty())
      out.warnings.push_back({"skeleton_hint_wrong", place + "/skeleton: " + complaint});
    skin.world_from_mesh = place_at_bind(nodes, skin);
    out.skin.push_back(std::move(skin));
    out.number.push_back(std::move(number));
  }
  return out;
}

}  // namespace backbend::skin
