#include "tests/battery/body_variants.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_inverse.hpp>
#include <numeric>
#include <optional>
#include <set>
#include <stdexcept>

#include "skin/character/joint_names.h"
#include "skin/character/matrix_facts.h"

namespace backbend::battery {
namespace {

using Index = std::size_t;
using skin::Character;

}  // namespace

JointWeights weights_of(const skin::Influences& influences) {
  JointWeights out;
  for (Index k = 0; k < skin::kMaxInfluences; ++k)
    if (influences.weight[k] > 0.0f) out[influences.joint[k]] += influences.weight[k];
  return out;
}

skin::Influences influences_of(const JointWeights& weights, Index most) {
  std::vector<std::pair<double, std::uint16_t>> sorted;
  for (const auto& [joint, weight] : weights)
    if (weight > 1e-6) sorted.emplace_back(weight, joint);
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  sorted.resize(std::min({sorted.size(), most, Index{skin::kMaxInfluences}}));
  double sum = 0.0;
  for (const auto& each : sorted) sum += each.first;
  skin::Influences out;
  for (Index k = 0; k < sorted.size(); ++k) {
    out.joint[k] = sorted[k].second;
    out.weight[k] = static_cast<float>(sorted[k].first / sum);
  }
  return out;
}

void renew_surface(Character& body) {
  body.place.resize(body.vertex_count());
  std::iota(body.place.begin(), body.place.end(), 0u);
  body.place_count = static_cast<std::uint32_t>(body.vertex_count());
  renew_normals(body);
}

void renew_normals(Character& body) {
  std::vector<glm::dvec3> sum(body.place_count, glm::dvec3(0.0));
  for (const glm::uvec3& t : body.triangles) {
    const glm::dvec3 a(body.bind_position[t.x]), b(body.bind_position[t.y]),
        c(body.bind_position[t.z]);
    for (int k = 0; k < 3; ++k) sum[body.place[t[k]]] += glm::cross(b - a, c - a);
  }
  body.bind_normal.clear();
  for (const std::uint32_t place : body.place) {
    const double length = glm::length(sum[place]);
    body.bind_normal.emplace_back(length > 0.0 ? sum[place] / length : glm::dvec3(0, 1, 0));
  }
}

Character bound_in_one_space(Character character) {
  constexpr double kSame = 1e-5;
  constexpr Index kNone = static_cast<Index>(-1);
  const Character& in = character;
  std::vector<Index> first(in.nodes.size(), kNone);  // joint of each node
  std::vector<bool> moved(in.vertex_count(), false);
  for (const skin::Part& part : in.parts) {
    const Index begin = part.first_vertex, end = begin + part.vertex_count;
    if (begin == end || moved[begin]) continue;
    std::fill(moved.begin() + begin, moved.begin() + end, true);
    std::set<std::uint16_t> joints;
    for (Index v = begin; v < end; ++v)
      for (Index k = 0; k < skin::kMaxInfluences && in.influences[v].weight[k] > 0.0f; ++k)
        joints.insert(in.influences[v].joint[k]);
    std::optional<glm::dmat4> motion;
    for (const std::uint16_t joint : joints) {
      const Index known = first[static_cast<Index>(in.joints[joint].node)];
      if (known == kNone) continue;
      const glm::dmat4 own =
          glm::inverse(in.joints[known].joint_from_mesh) * in.joints[joint].joint_from_mesh;
      if (!motion) motion = own;
      if (!skin::same_motion(own, *motion, kSame, 1.0))
        throw std::runtime_error("bound in several spaces");
    }
    for (const std::uint16_t joint : joints) {
      Index& known = first[static_cast<Index>(in.joints[joint].node)];
      if (known != kNone) continue;
      known = joint;
      if (motion)
        character.joints[joint].joint_from_mesh =
            in.joints[joint].joint_from_mesh * glm::inverse(*motion);
    }
    for (Index v = begin; v < end; ++v) {
      if (motion)
        character.bind_position[v] =
            glm::vec3(*motion * glm::dvec4(glm::dvec3(in.bind_position[v]), 1.0));
      for (Index k = 0; k < skin::kMaxInfluences && in.influences[v].weight[k] > 0.0f; ++k) {
        std::uint16_t& joint = character.influences[v].joint[k];
        joint = static_cast<std::uint16_t>(first[static_cast<Index>(in.joints[joint].node)]);
      }
    }
  }
  return character;
}

Character welded(const Character& in) {
  Character out = in;
  out.materials.clear();
  out.images.clear();
  out.uv.clear();
  out.warnings.clear();
  out.bind_position.assign(in.place_count, glm::vec3(0.0f));
  out.influences.assign(in.place_count, {});
  for (Index v = in.vertex_count(); v-- > 0;) {
    out.bind_position[in.place[v]] = in.bind_position[v];
    out.influences[in.place[v]] = in.influences[v];
  }
  out.triangles.clear();
  for (const glm::uvec3& t : in.triangles) {
    const glm::uvec3 w(in.place[t.x], in.place[t.y], in.place[t.z]);
    if (w.x != w.y && w.y != w.z && w.z != w.x) out.triangles.push_back(w);
  }
  skin::Part part;
  part.name = "body";
  part.material = -1;
  out.parts = {part};
  // Places that no triangle uses would be left alone by every variant.
  std::vector<std::uint32_t> number(in.place_count, in.place_count);
  std::uint32_t count = 0;
  for (glm::uvec3& t : out.triangles)
    for (int k = 0; k < 3; ++k) {
      if (number[t[k]] == in.place_count) number[t[k]] = count++;
      t[k] = number[t[k]];
    }
  std::vector<glm::vec3> position(count);
  std::vector<skin::Influences> influences(count);
  for (Index p = 0; p < in.place_count; ++p) {
    if (number[p] == in.place_count) continue;
    position[number[p]] = out.bind_position[p];
    influences[number[p]] = out.influences[p];
  }
  out.bind_position = std::move(position);
  out.influences = std::move(influences);
  renew_surface(out);
  return out;
}

std::vector<std::uint8_t> encoded(const Character& body, const skin::GlbAnimation* animation) {
  Character out = body;
  out.parts.front().vertex_count = static_cast<std::uint32_t>(out.vertex_count());
  out.parts.front().triangle_count = static_cast<std::uint32_t>(out.triangles.size());
  return skin::encode_glb(out, animation);
}

std::vector<std::vector<std::uint32_t>> neighbours(const Character& body) {
  std::vector<std::vector<std::uint32_t>> out(body.vertex_count());
  for (const glm::uvec3& t : body.triangles)
    for (int k = 0; k < 3; ++k) {
      out[t[k]].push_back(t[(k + 1) % 3]);
      out[t[k]].push_back(t[(k + 2) % 3]);
    }
  for (auto& each : out) {
    std::sort(each.begin(), each.end());
    each.erase(std::unique(each.begin(), each.end()), each.end());
  }
  return out;
}

void smooth_weights(Character& body, int steps) {
  const auto around = neighbours(body);
  std::vector<JointWeights> now(body.vertex_count()), next(body.vertex_count());
  for (Index v = 0; v < now.size(); ++v) now[v] = weights_of(body.influences[v]);
  for (int step = 0; step < steps; ++step) {
    for (Index v = 0; v < now.size(); ++v) {
      next[v].clear();
      for (const auto& [joint, weight] : now[v]) next[v][joint] += 0.5 * weight;
      for (const std::uint32_t other : around[v])
        for (const auto& [joint, weight] : now[other])
          next[v][joint] += 0.5 * weight / static_cast<double>(around[v].size());
    }
    std::swap(now, next);
  }
  for (Index v = 0; v < now.size(); ++v)
    body.influences[v] = influences_of(now[v], skin::kMaxInfluences);
}

void limit_influences(Character& body, Index most) {
  for (skin::Influences& each : body.influences) each = influences_of(weights_of(each), most);
}

void quantise_weights(Character& body) {
  for (skin::Influences& each : body.influences) {
    int left = 255;
    for (Index k = 1; k < skin::kMaxInfluences; ++k) {
      const int parts = static_cast<int>(std::lround(255.0f * each.weight[k]));
      each.weight[k] = static_cast<float>(parts) / 255.0f;
      left -= parts;
    }
    each.weight[0] = static_cast<float>(left) / 255.0f;
  }
}

void subdivide(Character& body) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middle;
  const auto middle_of = [&](std::uint32_t a, std::uint32_t b) {
    const auto [entry, is_new] = middle.try_emplace(
        {std::min(a, b), std::max(a, b)}, static_cast<std::uint32_t>(body.vertex_count()));
    if (is_new) {
      body.bind_position.push_back(0.5f * (body.bind_position[a] + body.bind_position[b]));
      JointWeights mean;
      for (const std::uint32_t end : {a, b})
        for (const auto& [joint, weight] : weights_of(body.influences[end]))
          mean[joint] += 0.5 * weight;
      body.influences.push_back(influences_of(mean, skin::kMaxInfluences));
    }
    return entry->second;
  };
  std::vector<glm::uvec3> fine;
  for (const glm::uvec3& t : body.triangles) {
    const std::uint32_t a = middle_of(t.x, t.y), b = middle_of(t.y, t.z), c = middle_of(t.z, t.x);
    fine.insert(fine.end(), {{t.x, a, c}, {a, t.y, b}, {c, b, t.z}, {a, b, c}});
  }
  body.triangles = std::move(fine);
  renew_surface(body);
}

void renew_world(Character& body) {
  for (skin::Node& node : body.nodes)
    node.world_from_node =
        node.parent < 0
            ? node.parent_from_node
            : body.nodes[static_cast<Index>(node.parent)].world_from_node * node.parent_from_node;
}

void scale(Character& body, double factor) {
  const auto scaled = [&](glm::dmat4 m) {
    m[3] = glm::dvec4(factor * glm::dvec3(m[3]), 1.0);
    return m;
  };
  for (skin::Node& node : body.nodes) node.parent_from_node = scaled(node.parent_from_node);
  for (skin::SkinJoint& joint : body.joints) joint.joint_from_mesh = scaled(joint.joint_from_mesh);
  for (glm::vec3& p : body.bind_position) p = glm::vec3(factor * glm::dvec3(p));
  renew_world(body);
}

namespace {

/// `Left` for `Right` and the other way round, whatever its case; marks like `_l` and `.R` too.
std::string other_side(const std::string& name) {
  std::string lower = name;
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  // In the case of what it replaces, as far as that has letters.
  const auto put = [&](Index at, Index length, std::string word) {
    for (Index k = 0; k < word.size(); ++k)
      if (std::isupper(static_cast<unsigned char>(name[at + std::min(k, length - 1)])))
        word[k] = static_cast<char>(std::toupper(static_cast<unsigned char>(word[k])));
    return std::string(name).replace(at, length, word);
  };
  if (const Index at = lower.find("left"); at != std::string::npos) return put(at, 4, "right");
  if (const Index at = lower.find("right"); at != std::string::npos) return put(at, 5, "left");
  const auto is_mark = [&](Index at) {
    const auto is_gap = [&](Index i) { return i >= name.size() || !std::isalnum(name[i]); };
    return (lower[at] == 'l' || lower[at] == 'r') && at > 0 && is_gap(at - 1) && is_gap(at + 1);
  };
  for (Index at = lower.size(); at-- > 0;)
    if (is_mark(at)) return put(at, 1, lower[at] == 'l' ? "r" : "l");
  // `LHipJoint`
  if (name.size() > 1 && (name[0] == 'L' || name[0] == 'R') && std::isupper(name[1]))
    return (name[0] == 'L' ? "R" : "L") + name.substr(1);
  return name;
}

}  // namespace

void mirror(Character& body, const glm::dvec3& left) {
  glm::dmat4 flip(1.0);
  int axis = 0;
  for (int c = 1; c < 3; ++c)
    if (std::abs(left[c]) > std::abs(left[axis])) axis = c;
  flip[axis][axis] = -1.0;
  std::set<std::string> names;
  for (const skin::Node& node : body.nodes) names.insert(node.name);
  for (skin::Node& node : body.nodes) {
    node.parent_from_node = flip * node.parent_from_node * flip;
    if (const std::string other = other_side(node.name); names.contains(other)) node.name = other;
  }
  for (skin::SkinJoint& joint : body.joints)
    joint.joint_from_mesh = flip * joint.joint_from_mesh * flip;
  for (glm::vec3& p : body.bind_position) p[axis] = -p[axis];
  for (glm::vec3& n : body.bind_normal) n[axis] = -n[axis];
  for (glm::uvec3& t : body.triangles) std::swap(t.y, t.z);
  renew_world(body);
}

void turn_in_world(Character& body, const glm::dmat4& turn) {
  for (skin::Node& node : body.nodes)
    if (node.parent < 0) node.parent_from_node = turn * node.parent_from_node;
  renew_world(body);
}

void change_bind_space(Character& body, const glm::dmat4& bind_from_world) {
  const glm::dmat4 back = glm::inverse(bind_from_world);
  for (skin::SkinJoint& joint : body.joints) joint.joint_from_mesh = joint.joint_from_mesh * back;
  for (glm::vec3& p : body.bind_position)
    p = glm::vec3(bind_from_world * glm::dvec4(glm::dvec3(p), 1.0));
  renew_normals(body);
}

void shuffle_vertices(Character& body, validate::Draw& draw) {
  std::vector<std::uint32_t> to(body.vertex_count());
  std::iota(to.begin(), to.end(), 0u);
  for (Index i = to.size(); i > 1; --i) std::swap(to[i - 1], to[draw.index(i)]);
  const auto moved = [&](auto values) {
    auto out = values;
    for (Index v = 0; v < to.size(); ++v) out[to[v]] = values[v];
    return out;
  };
  body.bind_position = moved(body.bind_position);
  body.bind_normal = moved(body.bind_normal);
  body.influences = moved(body.influences);
  body.place = moved(body.place);
  for (glm::uvec3& t : body.triangles)
    for (int k = 0; k < 3; ++k) t[k] = to[t[k]];
}

void split_vertices(Character& body, const glm::dvec3& at, const glm::dvec3& normal) {
  enum : std::uint8_t { kFront = 1, kBack = 2 };
  std::vector<std::uint8_t> sides(body.vertex_count(), 0);
  std::vector<std::uint8_t> side_of;  // of each triangle
  for (const glm::uvec3& t : body.triangles) {
    glm::dvec3 middle(0.0);
    for (int k = 0; k < 3; ++k) middle += glm::dvec3(body.bind_position[t[k]]) / 3.0;
    side_of.push_back(glm::dot(middle - at, normal) > 0.0 ? kFront : kBack);
    for (int k = 0; k < 3; ++k) sides[t[k]] |= side_of.back();
  }
  std::vector<std::uint32_t> copy(sides.size());
  std::iota(copy.begin(), copy.end(), 0u);
  for (Index v = 0; v < sides.size(); ++v) {
    if (sides[v] != (kFront | kBack)) continue;
    copy[v] = static_cast<std::uint32_t>(body.vertex_count());
    body.bind_position.push_back(body.bind_position[v]);
    body.bind_normal.push_back(body.bind_normal[v]);
    body.influences.push_back(body.influences[v]);
    body.place.push_back(body.place[v]);
  }
  for (Index t = 0; t < body.triangles.size(); ++t)
    for (int k = 0; side_of[t] == kBack && k < 3; ++k)
      body.triangles[t][k] = copy[body.triangles[t][k]];
}

void rename_joints(Character& body, int naming) {
  for (skin::Node& node : body.nodes) {
    if (node.name.empty() || node.name[0] == '#') continue;
    std::string& name = node.name;
    if (naming == 0) name = "hero:" + name;
    if (naming == 1) name += "_jnt";
    if (naming == 2)
      for (char& c : name) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    if (naming == 3) name = "DEF-" + name;
    if (naming == 4)
      for (char& c : name) c = c == '.' || c == ' ' ? '_' : c;
  }
}

std::vector<int> hips_to_chest(const Character& body, const skin::Anatomy& anatomy) {
  Index chest = anatomy.chest_index;
  const auto attached = [&](const std::vector<int>& arm) -> std::ptrdiff_t {
    for (int node = arm.empty() ? -1 : arm.front(); node >= 0;
         node = body.nodes[static_cast<Index>(node)].parent) {
      const auto found = std::find(anatomy.spine.begin(), anatomy.spine.end(), node);
      if (found != anatomy.spine.end()) return found - anatomy.spine.begin();
    }
    return -1;
  };
  const std::ptrdiff_t left = attached(anatomy.left_arm), right = attached(anatomy.right_arm);
  if (left > 0 && left == right) chest = static_cast<Index>(left);
  return {anatomy.spine.begin(), anatomy.spine.begin() + static_cast<std::ptrdiff_t>(chest) + 1};
}

std::uint16_t skin_joint(Character& body, int node) {
  for (Index j = 0; j < body.joints.size(); ++j)
    if (body.joints[j].node == node) return static_cast<std::uint16_t>(j);
  // The bind space of the others, at rest: a neighbour's way from the mesh to the world.
  int near = node;
  const skin::SkinJoint* known = nullptr;
  while (near >= 0 && known == nullptr) {
    near = body.nodes[static_cast<Index>(near)].parent;
    for (const skin::SkinJoint& each : body.joints)
      if (each.node == near) known = &each;
  }
  if (known == nullptr) known = &body.joints.front();
  const glm::dmat4 world_from_mesh =
      body.nodes[static_cast<Index>(known->node)].world_from_node * known->joint_from_mesh;
  body.joints.push_back(
      {node, glm::inverse(body.nodes[static_cast<Index>(node)].world_from_node) * world_from_mesh});
  return static_cast<std::uint16_t>(body.joints.size() - 1);
}

}  // namespace backbend::battery
