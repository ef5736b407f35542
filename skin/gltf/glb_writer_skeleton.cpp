#include "skin/gltf/glb_writer_skeleton.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace backbend::skin {
namespace {

std::string node_label(const Character& character, std::size_t node) {
  return "node `" + character.nodes[node].name + "`";
}

bool finite(const glm::dmat4& m) {
  for (int c = 0; c < 4; ++c) {
    for (int r = 0; r < 4; ++r) {
      if (!std::isfinite(m[c][r])) return false;
    }
  }
  return true;
}

/// Whether the axes span nothing worth the name: less than a millionth of what they would square.
bool flattened(const glm::dmat3& m) {
  const double square = glm::length(m[0]) * glm::length(m[1]) * glm::length(m[2]);
  return !(std::abs(glm::determinant(m)) > 1e-6 * square);
}

/// The frame with the same origin and x axis whose y axis lies in the plane of `m`'s x and y, which
/// is not flattened().
glm::dmat4 rigid_frame(const glm::dmat4& m) {
  const glm::dvec3 x = glm::normalize(glm::dvec3(m[0])), across(m[1]);
  const glm::dvec3 y = glm::normalize(across - glm::dot(x, across) * x);
  return glm::dmat4(glm::dvec4(x, 0), glm::dvec4(y, 0), glm::dvec4(glm::cross(x, y), 0), m[3]);
}

/// Local transforms of every node for these world matrices; the first node that shears, or -1.
int split_all(const Character& character, const std::vector<glm::dmat4>& world,
              std::vector<NodeTransform>& out) {
  out.resize(world.size());
  for (std::size_t i = 0; i < world.size(); ++i) {
    const int parent = character.nodes[i].parent;
    const glm::dmat4 local =
        parent < 0 ? world[i] : glm::inverse(world[static_cast<std::size_t>(parent)]) * world[i];
    const std::optional<NodeTransform> split = split_transform(local);
    if (!split) return static_cast<int>(i);
    out[i] = *split;
  }
  return -1;
}

int split_skeleton(const Character& character, const GlbAnimation* animation,
                   const std::vector<glm::dmat4>* rigid_from_rest, WrittenSkeleton& out) {
  const std::size_t n = character.nodes.size();
  std::vector<glm::dmat4> world(n);
  const auto changed = [&](std::size_t i, const glm::dmat4& m) {
    return rigid_from_rest ? m * (*rigid_from_rest)[i] : m;
  };
  for (std::size_t i = 0; i < n; ++i) world[i] = changed(i, character.nodes[i].world_from_node);
  int bad = split_all(character, world, out.rest);
  const std::size_t frames = animation ? animation->time.size() : 0;
  out.frames.resize(frames);
  for (std::size_t f = 0; f < frames && bad < 0; ++f) {
    for (std::size_t i = 0; i < n; ++i) world[i] = changed(i, animation->world_from_node[f][i]);
    bad = split_all(character, world, out.frames[f]);
  }
  return bad;
}

void check(const Character& character, const GlbAnimation* animation) {
  for (std::size_t i = 0; i < character.nodes.size(); ++i) {
    if (!finite(character.nodes[i].world_from_node)) {
      throw CharacterError(node_label(character, i) + ": rest matrix is not finite");
    }
  }
  if (!animation) return;
  if (animation->time.empty() || animation->time.size() != animation->world_from_node.size()) {
    throw CharacterError("animation `" + animation->name +
                         "`: " + std::to_string(animation->time.size()) + " times for " +
                         std::to_string(animation->world_from_node.size()) + " frames");
  }
  for (std::size_t f = 0; f < animation->time.size(); ++f) {
    const std::string frame = "animation `" + animation->name + "`, frame " + std::to_string(f);
    const float time = animation->time[f];
    if (!(time >= 0.0f) || !std::isfinite(time) || (f > 0 && !(time > animation->time[f - 1]))) {
      throw CharacterError(frame + ": times do not rise from 0");
    }
    if (animation->world_from_node[f].size() != character.nodes.size()) {
      throw CharacterError(frame + ": " + std::to_string(animation->world_from_node[f].size()) +
                           " matrices for " + std::to_string(character.nodes.size()) + " nodes");
    }
    for (std::size_t i = 0; i < character.nodes.size(); ++i) {
      if (!finite(animation->world_from_node[f][i])) {
        throw CharacterError(frame + ": the matrix of " + node_label(character, i) +
                             " is not finite");
      }
    }
  }
}

Json numbers(const glm::dvec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}
Json numbers(const glm::dquat& q) {
  return {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z),
          static_cast<float>(q.w)};
}

void add_animation(GlbDocument& document, const Character& character, const GlbAnimation& animation,
                   const WrittenSkeleton& skeleton) {
  const std::size_t frames = animation.time.size();
  const int input = document.add_accessor<float>(animation.time, kGlFloat, "SCALAR");
  document.add_bounds<float>(input, animation.time, 1);
  Json channels = Json::array(), samplers = Json::array();
  const auto add = [&](std::size_t node, const char* path, int output) {
    samplers.push_back({{"input", input}, {"interpolation", "LINEAR"}, {"output", output}});
    channels.push_back(
        {{"sampler", samplers.size() - 1}, {"target", {{"node", node}, {"path", path}}}});
  };
  for (std::size_t i = 0; i < character.nodes.size(); ++i) {
    const NodeTransform& rest = skeleton.rest[i];
    std::vector<glm::vec3> translation(frames), scale(frames);
    std::vector<glm::vec4> rotation(frames);
    bool moves = false, turns = false, scales = false;
    glm::dquat before = rest.rotation;
    for (std::size_t f = 0; f < frames; ++f) {
      const NodeTransform& t = skeleton.frames[f][i];
      // q and -q are one turn; players blend the numbers, so neighbours must be close as numbers.
      const glm::dquat q = glm::dot(before, t.rotation) < 0.0 ? -t.rotation : t.rotation;
      before = q;
      translation[f] = t.translation;
      scale[f] = t.scale;
      rotation[f] = glm::vec4(q.x, q.y, q.z, q.w);
      moves |= translation[f] != glm::vec3(rest.translation);
      scales |= scale[f] != glm::vec3(rest.scale);
      turns |= rotation[f] !=
               glm::vec4(rest.rotation.x, rest.rotation.y, rest.rotation.z, rest.rotation.w);
    }
    if (moves)
      add(i, "translation", document.add_accessor<glm::vec3>(translation, kGlFloat, "VEC3"));
    if (turns) add(i, "rotation", document.add_accessor<glm::vec4>(rotation, kGlFloat, "VEC4"));
    if (scales) add(i, "scale", document.add_accessor<glm::vec3>(scale, kGlFloat, "VEC3"));
  }
  if (channels.empty()) return;  // nothing moves, and glTF knows no empty animation
  document.append("animations",
                  {{"name", animation.name}, {"channels", channels}, {"samplers", samplers}});
}

}  // namespace

std::optional<NodeTransform> split_transform(const glm::dmat4& matrix, double slack) {
  NodeTransform out;
  out.translation = glm::dvec3(matrix[3]);
  glm::dvec3 axis[3];
  for (int i = 0; i < 3; ++i) {
    axis[i] = glm::dvec3(matrix[i]);
    out.scale[i] = glm::length(axis[i]);
    if (!(out.scale[i] > 1e-12)) return std::nullopt;
    axis[i] /= out.scale[i];
  }
  for (int i = 0; i < 3; ++i) {
    if (std::abs(glm::dot(axis[i], axis[(i + 1) % 3])) > slack) return std::nullopt;
  }
  if (glm::dot(glm::cross(axis[0], axis[1]), axis[2]) < 0.0) {
    out.scale.x = -out.scale.x;
    axis[0] = -axis[0];
  }
  out.rotation = glm::normalize(glm::quat_cast(glm::dmat3(axis[0], axis[1], axis[2])));
  for (int i = 0; i < 3; ++i) {
    // A rigid matrix that went through a few products is still one.
    if (std::abs(std::abs(out.scale[i]) - 1.0) < 1e-9)
      out.scale[i] = std::copysign(1.0, out.scale[i]);
  }
  return out;
}

WrittenSkeleton prepare_skeleton(const Character& character, const GlbAnimation* animation,
                                 JointFrames frames) {
  check(character, animation);
  WrittenSkeleton out;
  for (const SkinJoint& joint : character.joints) {
    if (!finite(joint.joint_from_mesh)) {
      throw CharacterError(node_label(character, static_cast<std::size_t>(joint.node)) +
                           ": inverse bind matrix is not finite");
    }
    out.joint_from_mesh.push_back(joint.joint_from_mesh);
  }
  const bool rigid =
      frames == JointFrames::rigid && std::ranges::none_of(character.nodes, [](const Node& node) {
        return flattened(glm::dmat3(node.world_from_node));
      });
  if (!rigid && split_skeleton(character, animation, nullptr, out) < 0) return out;

  // world * rest^-1 * rigid is as rigid as the motion itself.
  std::vector<glm::dmat4> change(character.nodes.size());
  for (std::size_t i = 0; i < change.size(); ++i) {
    const glm::dmat4& rest = character.nodes[i].world_from_node;
    if (flattened(glm::dmat3(rest))) {
      throw CharacterError(node_label(character, i) + ": flattened to nothing, cannot be written");
    }
    change[i] = glm::inverse(rest) * rigid_frame(rest);
  }
  const int bad = split_skeleton(character, animation, &change, out);
  if (bad >= 0) {
    throw CharacterError(
        node_label(character, static_cast<std::size_t>(bad)) +
        ": sheared by the motion, which translation, rotation and scale cannot say");
  }
  for (std::size_t j = 0; j < character.joints.size(); ++j) {
    const auto node = static_cast<std::size_t>(character.joints[j].node);
    out.joint_from_mesh[j] = glm::inverse(change[node]) * character.joints[j].joint_from_mesh;
  }
  return out;
}

std::vector<int> add_skeleton(GlbDocument& document, const Character& character,
                              const GlbAnimation* animation, const SkinLayout& layout,
                              bool unskinned) {
  const WrittenSkeleton skeleton = prepare_skeleton(character, animation);
  const std::size_t n = character.nodes.size();
  Json nodes = Json::array(), roots = Json::array();
  for (std::size_t i = 0; i < n; ++i) {
    const NodeTransform& t = skeleton.rest[i];
    Json node;
    if (!character.nodes[i].name.empty()) node["name"] = character.nodes[i].name;
    if (t.translation != glm::dvec3(0.0)) node["translation"] = numbers(t.translation);
    if (t.rotation != glm::dquat(1, 0, 0, 0)) node["rotation"] = numbers(t.rotation);
    if (t.scale != glm::dvec3(1.0)) node["scale"] = numbers(t.scale);
    nodes.push_back(node.is_null() ? Json::object() : node);
  }
  const auto hang = [&nodes](std::size_t parent, std::size_t child) {
    nodes[parent]["children"].push_back(child);
  };
  for (std::size_t i = 0; i < n; ++i) {
    const int parent = character.nodes[i].parent;
    if (parent < 0) {
      roots.push_back(i);
    } else {
      hang(static_cast<std::size_t>(parent), i);
    }
  }

  std::vector<std::size_t> node_of_joint;
  for (std::size_t j = 0; j < character.joints.size(); ++j) {
    auto node = static_cast<std::size_t>(character.joints[j].node);
    if (layout.needs_node[j]) {
      const std::string name = character.nodes[node].name + "_bind_" + std::to_string(j);
      hang(node, nodes.size());
      node = nodes.size();
      nodes.push_back({{"name", name}});
    }
    node_of_joint.push_back(node);
  }
  const std::size_t still = nodes.size();
  if (unskinned) {
    roots.push_back(still);
    nodes.push_back({{"name", "unskinned"}});
  }
  if (roots.size() > 1) {  // joints need a common root
    const std::size_t top = nodes.size();
    nodes.push_back({{"name", "character"}, {"children", roots}});
    roots = Json::array({top});
  }
  document.json["scene"] = 0;
  document.json["scenes"] = Json::array({{{"nodes", roots}}});
  document.json["nodes"] = nodes;
  std::vector<int> skins;
  for (const std::vector<std::size_t>& listed : layout.joints) {
    Json joints = Json::array();
    std::vector<glm::mat4> inverse_bind;
    for (const std::size_t j : listed) {
      joints.push_back(node_of_joint[j]);
      inverse_bind.emplace_back(skeleton.joint_from_mesh[j]);
    }
    if (unskinned) {
      joints.push_back(still);
      inverse_bind.emplace_back(1.0f);
    }
    for (glm::mat4& m : inverse_bind) m[0][3] = m[1][3] = m[2][3] = 0.0f, m[3][3] = 1.0f;
    Json skin;
    if (!character.name.empty()) skin["name"] = character.name;
    skin["inverseBindMatrices"] = document.add_accessor<glm::mat4>(inverse_bind, kGlFloat, "MAT4");
    skin["joints"] = joints;
    skins.push_back(document.append("skins", std::move(skin)));
  }
  if (animation) add_animation(document, character, *animation, skeleton);
  return skins;
}

}  // namespace backbend::skin
