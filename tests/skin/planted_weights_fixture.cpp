#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_inverse.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <numeric>
#include <tuple>

#include "skin/anatomy/mirror_image.h"
#include "skin/character/matrix_facts.h"
#include "skin/character/weld.h"
#include "skin/deform/skinning.h"
#include "tests/skin/planted_weights.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;
using Weights = std::map<std::uint16_t, double>;

Weights of(const Influences& influences) {
  Weights out;
  for (Index k = 0; k < kMaxInfluences; ++k)
    if (influences.weight[k] > 0.0f) out[influences.joint[k]] += influences.weight[k];
  return out;
}

/// The largest eight, of sum 1.
Influences packed(const Weights& weights) {
  std::vector<std::pair<double, std::uint16_t>> list;
  for (const auto& [joint, weight] : weights)
    if (weight > 0.0) list.emplace_back(-weight, joint);
  std::sort(list.begin(), list.end());
  if (list.size() > kMaxInfluences) list.resize(kMaxInfluences);
  double sum = 0.0;
  for (const auto& [weight, joint] : list) sum -= weight;
  Influences out;
  for (Index k = 0; k < list.size(); ++k) {
    out.joint[k] = list[k].second;
    out.weight[k] = static_cast<float>(-list[k].first / sum);
  }
  return out;
}

std::vector<std::uint16_t> joints_of(const Character& character, int node) {
  std::vector<std::uint16_t> out;
  for (Index j = 0; j < character.joints.size(); ++j)
    if (character.joints[j].node == node) out.push_back(static_cast<std::uint16_t>(j));
  return out;
}

void weld_again(Character& character) {
  Places places = weld(character.bind_position);
  character.place = std::move(places.place);
  character.place_count = places.count;
}

}  // namespace

int planted_node(const Character& character, const std::string& name) {
  for (Index n = 0; n < character.nodes.size(); ++n)
    if (character.nodes[n].name == name) return static_cast<int>(n);
  return -1;
}

std::size_t move_weight(Character& character, const Anatomy& anatomy, int from, int to,
                        double share, int on) {
  const Mirror mirror = mirror_of(character, anatomy);
  const PosedMesh rest = rest_mesh(character);
  const auto sources = joints_of(character, from), targets = joints_of(character, to);
  std::size_t count = 0;
  for (Index v = 0; v < character.vertex_count(); ++v) {
    const double aside = glm::dot(glm::dvec3(rest.position[v]) - mirror.middle, mirror.left);
    if (on * aside < 0.0) continue;
    Weights weights = of(character.influences[v]);
    double moved = 0.0;
    for (const std::uint16_t joint : sources)
      if (const auto found = weights.find(joint); found != weights.end()) {
        moved += share * found->second;
        found->second *= 1.0 - share;
      }
    if (moved <= 0.0) continue;
    weights[targets.front()] += moved;
    character.influences[v] = packed(weights);
    ++count;
  }
  return count;
}

void spill_weight(Character& character, int from, int to, double share) {
  constexpr double kReach = 0.1;
  const PosedMesh rest = rest_mesh(character);
  glm::vec3 low = rest.position.front(), high = low;
  for (const glm::vec3& p : rest.position) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const glm::vec3 sides = high - low;
  const double reach = kReach * std::max({sides.x, sides.y, sides.z});
  const auto sources = joints_of(character, from);
  const std::uint16_t target = joints_of(character, to).front();
  const auto weight = [&](Index v) {
    Weights weights = of(character.influences[v]);
    double sum = 0.0;
    for (const std::uint16_t joint : sources) sum += weights[joint];
    return sum;
  };
  Index middle = 0;
  for (Index v = 0; v < character.vertex_count(); ++v)
    if (weight(v) > weight(middle)) middle = v;
  for (Index v = 0; v < character.vertex_count(); ++v) {
    const double far = glm::distance(rest.position[v], rest.position[middle]) / reach;
    if (far >= 1.0) continue;
    const double spilt = share * (1.0 - far * far);
    Weights weights = of(character.influences[v]);
    for (auto& [joint, each] : weights) each *= 1.0 - spilt;
    weights[target] += spilt;
    character.influences[v] = packed(weights);
  }
}

void swap_weights(Character& character, int a, int b) {
  const auto first = joints_of(character, a).front(), second = joints_of(character, b).front();
  for (Influences& influences : character.influences)
    for (std::uint16_t& joint : influences.joint)
      joint = joint == first ? second : joint == second ? first : joint;
}

void turn_bind(Character& character, int node, double angle_deg) {
  for (const std::uint16_t j : joints_of(character, node))
    character.joints[j].joint_from_mesh =
        glm::rotate(glm::dmat4(1.0), glm::radians(angle_deg), glm::dvec3(0, 0, 1)) *
        character.joints[j].joint_from_mesh;
}

Character smoothed(const Character& character, int times) {
  Character out = character;
  for (int n = 0; n < times; ++n) {
    std::vector<Weights> at(out.place_count), sum(out.place_count);
    for (Index v = out.vertex_count(); v-- > 0;) at[out.place[v]] = of(out.influences[v]);
    sum = at;
    for (const glm::uvec3& t : out.triangles)
      for (int k = 0; k < 3; ++k)
        for (const auto& [joint, weight] : at[out.place[t[(k + 1) % 3]]])
          sum[out.place[t[k]]][joint] += 0.3 * weight;
    for (Index v = 0; v < out.vertex_count(); ++v) out.influences[v] = packed(sum[out.place[v]]);
  }
  return out;
}

Character decimated(const Character& character, std::size_t places) {
  glm::dvec3 low(character.bind_position.front()), high = low;
  for (const glm::vec3& p : character.bind_position) {
    low = glm::min(low, glm::dvec3(p));
    high = glm::max(high, glm::dvec3(p));
  }
  const glm::dvec3 sides = high - low;
  double cell = std::max({sides.x, sides.y, sides.z}) / 8.0;
  using Key = std::tuple<long, long, long>;
  std::map<Key, std::uint32_t> number;
  for (;; cell *= 0.9) {
    number.clear();
    for (const glm::vec3& p : character.bind_position) {
      const glm::dvec3 q = (glm::dvec3(p) - low) / cell;
      number.try_emplace({std::lround(q.x), std::lround(q.y), std::lround(q.z)}, 0);
    }
    if (number.size() >= places) break;
  }
  Character out = character;
  out.parts.resize(1);
  out.uv.clear();
  std::vector<glm::dvec3> point, normal;
  std::vector<Weights> weights;
  std::vector<double> count;
  std::vector<std::uint32_t> of_vertex;
  for (auto& [key, n] : number) n = static_cast<std::uint32_t>(-1);
  for (Index v = 0; v < character.vertex_count(); ++v) {
    const glm::dvec3 q = (glm::dvec3(character.bind_position[v]) - low) / cell;
    std::uint32_t& n = number[{std::lround(q.x), std::lround(q.y), std::lround(q.z)}];
    if (n == static_cast<std::uint32_t>(-1)) {
      n = static_cast<std::uint32_t>(point.size());
      point.emplace_back(0.0);
      normal.emplace_back(0.0);
      weights.emplace_back();
      count.push_back(0.0);
    }
    of_vertex.push_back(n);
    point[n] += glm::dvec3(character.bind_position[v]);
    normal[n] += glm::dvec3(character.bind_normal[v]);
    for (const auto& [joint, weight] : of(character.influences[v])) weights[n][joint] += weight;
    count[n] += 1.0;
  }
  out.bind_position.clear();
  out.bind_normal.clear();
  out.influences.clear();
  out.triangles.clear();
  for (Index n = 0; n < point.size(); ++n) {
    out.bind_position.emplace_back(point[n] / count[n]);
    out.bind_normal.emplace_back(glm::length(normal[n]) > 0.0 ? glm::normalize(normal[n])
                                                              : glm::dvec3(0, 1, 0));
    out.influences.push_back(packed(weights[n]));
  }
  for (const glm::uvec3& t : character.triangles) {
    const glm::uvec3 made(of_vertex[t.x], of_vertex[t.y], of_vertex[t.z]);
    if (made.x != made.y && made.y != made.z && made.z != made.x) out.triangles.push_back(made);
  }
  out.parts[0].first_vertex = out.parts[0].first_triangle = 0;
  out.parts[0].vertex_count = static_cast<std::uint32_t>(out.vertex_count());
  out.parts[0].triangle_count = static_cast<std::uint32_t>(out.triangles.size());
  weld_again(out);
  return out;
}

Character subdivided(const Character& character) {
  Character out = character;
  out.uv.clear();
  out.triangles.clear();
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middle;
  const auto between = [&](std::uint32_t a, std::uint32_t b) {
    const auto key = std::minmax(a, b);
    const auto [found, is_new] =
        middle.try_emplace(key, static_cast<std::uint32_t>(out.vertex_count()));
    if (is_new) {
      out.bind_position.push_back(0.5f * (out.bind_position[a] + out.bind_position[b]));
      out.bind_normal.push_back(out.bind_normal[a]);
      Weights weights = of(out.influences[a]);
      for (const auto& [joint, weight] : of(out.influences[b])) weights[joint] += weight;
      out.influences.push_back(packed(weights));
    }
    return found->second;
  };
  for (const glm::uvec3& t : character.triangles) {
    const std::uint32_t a = between(t.x, t.y), b = between(t.y, t.z), c = between(t.z, t.x);
    out.triangles.insert(out.triangles.end(), {{t.x, a, c}, {a, t.y, b}, {c, b, t.z}, {a, b, c}});
  }
  out.parts.resize(1);
  out.parts[0].first_vertex = out.parts[0].first_triangle = 0;
  out.parts[0].vertex_count = static_cast<std::uint32_t>(out.vertex_count());
  out.parts[0].triangle_count = static_cast<std::uint32_t>(out.triangles.size());
  weld_again(out);
  return out;
}

namespace {

/// A new joint of the spine after the one above it; numbers of the nodes behind it grow.
int insert_joint(Character& body, int above, const glm::dmat4& world) {
  const int place = above + 1;
  for (Node& each : body.nodes)
    if (each.parent >= place) ++each.parent;
  for (SkinJoint& joint : body.joints)
    if (joint.node >= place) ++joint.node;
  Node node;
  node.name = body.nodes[static_cast<std::size_t>(above)].name + "_cut";
  node.parent = above;
  node.world_from_node = world;
  node.parent_from_node =
      glm::inverse(body.nodes[static_cast<std::size_t>(above)].world_from_node) * world;
  body.nodes.insert(body.nodes.begin() + place, node);
  return place;
}

/// Cuts the bone from a joint to the next one of the chain. Returns the joints that it now has.
std::vector<int> cut_bone(Character& body, int low, int high, std::size_t pieces) {
  const glm::dmat4 low_world = body.nodes[static_cast<std::size_t>(low)].world_from_node;
  const glm::dvec3 start(low_world[3]);
  const glm::dvec3 bone =
      glm::dvec3(body.nodes[static_cast<std::size_t>(high)].world_from_node[3]) - start;
  std::vector<int> node = {low};
  for (std::size_t k = 1; k < pieces; ++k) {
    glm::dmat4 world = low_world;
    world[3] =
        glm::dvec4(start + bone * (static_cast<double>(k) / static_cast<double>(pieces)), 1.0);
    node.push_back(insert_joint(body, node.back(), world));
    ++high;
  }
  Node& end = body.nodes[static_cast<std::size_t>(high)];
  end.parent = node.back();
  end.parent_from_node =
      glm::inverse(body.nodes[static_cast<std::size_t>(node.back())].world_from_node) *
      end.world_from_node;
  const std::size_t known = body.joints.size();
  std::map<std::pair<std::size_t, std::size_t>, std::uint16_t> piece;  // of a skin's joint
  for (std::size_t j = 0; j < known; ++j) {
    if (body.joints[j].node != low) continue;
    piece[{j, 0}] = static_cast<std::uint16_t>(j);
    const glm::dmat4 world_from_mesh = low_world * body.joints[j].joint_from_mesh;
    for (std::size_t k = 1; k < pieces; ++k) {
      piece[{j, k}] = static_cast<std::uint16_t>(body.joints.size());
      body.joints.push_back(
          {node[k], glm::inverse(body.nodes[static_cast<std::size_t>(node[k])].world_from_node) *
                        world_from_mesh});
    }
  }
  for (std::size_t v = 0; v < body.vertex_count(); ++v) {
    std::vector<std::pair<double, std::uint16_t>> weights;
    for (std::size_t k = 0; k < kMaxInfluences && body.influences[v].weight[k] > 0.0f; ++k) {
      const std::size_t j = body.influences[v].joint[k];
      const double weight = body.influences[v].weight[k];
      if (body.joints[j].node != low || j >= known) {
        weights.emplace_back(weight, static_cast<std::uint16_t>(j));
        continue;
      }
      const glm::dvec3 p(low_world * body.joints[j].joint_from_mesh *
                         glm::dvec4(glm::dvec3(body.bind_position[v]), 1.0));
      const double count = static_cast<double>(pieces);
      const double at = std::clamp(glm::dot(p - start, bone) / glm::dot(bone, bone) * count - 0.5,
                                   0.0, count - 1.0);
      const auto below = std::min(static_cast<std::size_t>(at), pieces - 2);
      const double t = at - static_cast<double>(below), share = t * t * (3.0 - 2.0 * t);
      weights.emplace_back(weight * (1.0 - share), piece[{j, below}]);
      weights.emplace_back(weight * share, piece[{j, below + 1}]);
    }
    std::stable_sort(weights.begin(), weights.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    weights.resize(std::min<std::size_t>(weights.size(), kMaxInfluences));
    double sum = 0.0;
    for (const auto& [weight, joint] : weights) sum += weight;
    body.influences[v] = {};
    for (std::size_t k = 0; k < weights.size(); ++k) {
      body.influences[v].joint[k] = weights[k].second;
      body.influences[v].weight[k] = static_cast<float>(weights[k].first / sum);
    }
  }
  return node;
}

}  // namespace

Character with_dense_spine(const Character& character, const Anatomy& anatomy, std::size_t joints) {
  Character out = character;
  std::vector<int> chain(
      anatomy.spine.begin(),
      anatomy.spine.begin() + static_cast<std::ptrdiff_t>(anatomy.chest_index + 1));
  const auto place = [&](std::size_t k) {
    return glm::dvec3(out.nodes[static_cast<std::size_t>(chain[k])].world_from_node[3]);
  };
  std::vector<std::size_t> pieces(chain.size(), 1);  // of the bone that ends at each joint
  const auto length = [&](std::size_t k) {
    return glm::distance(place(k - 1), place(k)) / static_cast<double>(pieces[k]);
  };
  for (std::size_t count = chain.size(); count < joints; ++count) {
    std::size_t longest = 1;
    for (std::size_t k = 2; k < chain.size(); ++k)
      if (length(k) > length(longest)) longest = k;
    ++pieces[longest];
  }
  // From the top down: what is below keeps its number.
  for (std::size_t k = chain.size() - 1; k > 0; --k) {
    if (out.nodes[static_cast<std::size_t>(chain[k])].parent != chain[k - 1]) continue;
    if (pieces[k] > 1) cut_bone(out, chain[k - 1], chain[k], pieces[k]);
  }
  return out;
}

Character scaled(const Character& character, double factor) {
  Character out = character;
  const glm::dmat4 grow = glm::scale(glm::dmat4(1.0), glm::dvec3(factor));
  for (Node& node : out.nodes) {
    node.world_from_node[3] = glm::dvec4(factor * glm::dvec3(node.world_from_node[3]), 1.0);
    node.parent_from_node[3] = glm::dvec4(factor * glm::dvec3(node.parent_from_node[3]), 1.0);
  }
  for (SkinJoint& joint : out.joints)
    joint.joint_from_mesh =
        grow * joint.joint_from_mesh * glm::scale(glm::dmat4(1.0), glm::dvec3(1.0 / factor));
  for (glm::vec3& p : out.bind_position) p = glm::vec3(factor * glm::dvec3(p));
  weld_again(out);
  return out;
}

}  // namespace backbend::skin
