#include "skin/anatomy/skeleton_shape.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "skin/character/ancestor.h"
#include "skin/character/matrix_facts.h"
#include "skin/character/part_owners.h"
#include "skin/deform/skinning.h"

namespace backbend::skin {
namespace {

constexpr double kMirrorReach = 0.1;     // two mirrored branches reach equally far, relative
constexpr double kChainReach = 0.15;     // ... of two chains of as many joints, placed by hand
constexpr std::size_t kChainJoints = 4;  // ... and this many
constexpr double kMirrorAngle = 0.94;    // cosine: their ends lie across one world axis
constexpr double kApart = 0.02;          // ... and this much of the size apart
constexpr double kWorn = 0.1;            // of the size, around the body: what it wears lies within
constexpr std::size_t kMostSiblings = 256;

/// What hangs from each node. Nodes that only stand between a joint and the one it hangs from,
/// where it stands (exporters undo a bone's scale there), are passed over.
void find_children(const Character& character, SkeletonShape& shape) {
  const std::size_t count = character.nodes.size();
  std::vector<int> children(count, 0), only(count, -1);
  for (std::size_t n = 0; n < count; ++n)
    if (const int parent = character.nodes[n].parent; parent >= 0) {
      ++children[static_cast<std::size_t>(parent)];
      only[static_cast<std::size_t>(parent)] = static_cast<int>(n);
    }
  const auto is_passed = [&](std::size_t n) {
    return !shape.is_joint[n] && character.nodes[n].parent >= 0 && children[n] == 1 &&
           shape.is_joint[static_cast<std::size_t>(only[n])] &&
           glm::distance(shape.position[n], shape.position[static_cast<std::size_t>(only[n])]) <=
               1e-6 * shape.size;
  };
  for (std::size_t n = 0; n < count; ++n) {
    if (is_passed(n)) continue;
    int parent = character.nodes[n].parent;
    if (parent >= 0 && is_passed(static_cast<std::size_t>(parent))) {
      shape.children[static_cast<std::size_t>(parent)].push_back(static_cast<int>(n));
      parent = character.nodes[static_cast<std::size_t>(parent)].parent;
    }
    if (parent >= 0)
      shape.children[static_cast<std::size_t>(parent)].push_back(static_cast<int>(n));
  }
}

void measure_weights(const Character& character, SkeletonShape& shape) {
  // Vertices without weights were left to a joint that does not mean them.
  std::vector<bool> left_over(character.influences.size(), false);
  for (const std::uint32_t v : character.unweighted) left_over[v] = true;
  for (std::size_t v = 0; v < character.influences.size(); ++v) {
    const Influences& influences = character.influences[v];
    for (std::size_t k = 0; !left_over[v] && k < kMaxInfluences && influences.weight[k] > 0.0f; ++k)
      shape.weight[static_cast<std::size_t>(character.joints[influences.joint[k]].node)] +=
          influences.weight[k];
  }
  shape.weight_below = shape.weight;
  for (std::size_t n = character.nodes.size(); n-- > 0;)
    if (const int parent = character.nodes[n].parent; parent >= 0)
      shape.weight_below[static_cast<std::size_t>(parent)] += shape.weight_below[n];
}

/// Finds props, and tells scenery from what the body wears: scenery reaches out of the body's box.
void find_props(const Character& character, SkeletonShape& shape) {
  shape.is_prop = nodes_of_props(character);
  std::vector<bool> is_loose = shape.is_prop;
  for (std::size_t n = 0; n < character.nodes.size(); ++n)
    for (int above = character.nodes[n].parent; above >= 0 && is_loose[n];
         above = character.nodes[static_cast<std::size_t>(above)].parent)
      is_loose[n] = !shape.is_joint[static_cast<std::size_t>(above)];
  const auto vertices_of = [&](const std::vector<bool>& nodes) {
    std::vector<bool> out;
    for (const Influences& influences : character.influences)
      out.push_back(nodes[static_cast<std::size_t>(character.joints[influences.joint[0]].node)]);
    return out;
  };
  const std::vector<bool> loose_vertices = vertices_of(is_loose);
  measure_box(shape, loose_vertices);
  const glm::dvec3 slack(kWorn * shape.size);
  shape.is_scenery.assign(character.nodes.size(), false);
  for (std::size_t v = 0; v < loose_vertices.size(); ++v) {
    const glm::dvec3 p(shape.rest[v]);
    const auto node =
        static_cast<std::size_t>(character.joints[character.influences[v].joint[0]].node);
    if (loose_vertices[v] && (glm::any(glm::lessThan(p, shape.low - slack)) ||
                              glm::any(glm::greaterThan(p, shape.high + slack))))
      shape.is_scenery[node] = true;
  }
  shape.is_scene = vertices_of(shape.is_scenery);
  measure_box(shape, shape.is_scene);
}

void measure_reach(const Character& character, SkeletonShape& shape) {
  for (std::size_t n = 0; n < character.nodes.size(); ++n) {
    shape.farthest[n] = static_cast<int>(n);
    if (!shape.is_joint[n] || shape.is_prop[n]) continue;
    for (int above = character.nodes[n].parent; above >= 0;
         above = character.nodes[static_cast<std::size_t>(above)].parent) {
      const auto a = static_cast<std::size_t>(above);
      const double distance = glm::distance(shape.position[a], shape.position[n]);
      if (distance > shape.reach[a]) {
        shape.reach[a] = distance;
        shape.farthest[a] = static_cast<int>(n);
      }
    }
  }
}

bool named_pair(const NameFacts& a, const NameFacts& b) {
  return a.side != Side::none && b.side != Side::none && a.side != b.side &&
         a.without_side == b.without_side;
}

/// Names of two sides that differ in more than the side: numbers that an exporter counted all
/// nodes with (`LeftLeg_015`, `RightLeg_019`).
bool numbered_apart(const NameFacts& a, const NameFacts& b) {
  const auto letters = [](std::string text) {
    std::erase_if(text, [](char c) { return c >= '0' && c <= '9'; });
    return text;
  };
  return a.side != Side::none && b.side != Side::none && a.side != b.side && a.part == b.part &&
         letters(a.without_side) == letters(b.without_side);
}

/// The joints of a chain without a fork, from its root on; 0 where it forks.
std::size_t chain_length(const SkeletonShape& shape, std::size_t root) {
  std::size_t length = 1;
  for (std::size_t n = root; !shape.children[n].empty(); ++length) {
    if (shape.children[n].size() > 1) return 0;
    n = static_cast<std::size_t>(shape.children[n].front());
  }
  return length;
}

/// From the end of one branch to the end of another that reaches as far, of length 1; 0 where they
/// do not, or end in one place.
glm::dvec3 across_between(const SkeletonShape& shape, std::size_t a, std::size_t b) {
  const double reach = std::max(shape.reach[a], shape.reach[b]);
  const std::size_t joints = chain_length(shape, a);
  const bool is_limb = joints >= kChainJoints && joints == chain_length(shape, b);
  if (std::abs(shape.reach[a] - shape.reach[b]) > (is_limb ? kChainReach : kMirrorReach) * reach)
    return glm::dvec3(0.0);
  const glm::dvec3 across = shape.position[static_cast<std::size_t>(shape.farthest[a])] -
                            shape.position[static_cast<std::size_t>(shape.farthest[b])];
  const double length = glm::length(across);
  return length > kApart * shape.size ? across / length : glm::dvec3(0.0);
}

/// Whether the ends of two branches lie across one of the directions.
bool mirrors(const SkeletonShape& shape, std::span<const glm::dvec3> directions, std::size_t a,
             std::size_t b) {
  const glm::dvec3 across = across_between(shape, a, b);
  return std::any_of(directions.begin(), directions.end(), [&](const glm::dvec3& direction) {
    return std::abs(glm::dot(across, direction)) > kMirrorAngle;
  });
}

/// Whether no other child of these could be the one or the other.
bool only_two(const SkeletonShape& shape, const std::vector<int>& children, std::size_t a,
              std::size_t b) {
  return std::none_of(children.begin(), children.end(), [&](int child) {
    const auto c = static_cast<std::size_t>(child);
    return c != a && c != b &&
           (numbered_apart(shape.name[a], shape.name[c]) ||
            numbered_apart(shape.name[b], shape.name[c]));
  });
}

int root_of(const Character& character, int node) {
  while (character.nodes[static_cast<std::size_t>(node)].parent >= 0)
    node = character.nodes[static_cast<std::size_t>(node)].parent;
  return node;
}

bool is_limb(const NameFacts& name) {
  return name.part == BodyPart::clavicle || name.part == BodyPart::arm ||
         name.part == BodyPart::leg || name.part == BodyPart::fin;
}

/// Limbs whose two sides hang from different nodes, as mechanisms and separate armatures have
/// them: the topmost joints of one name, left and right, with no pair above them.
void find_parted_pairs(const Character& character, SkeletonShape& shape) {
  std::map<std::string, std::pair<int, int>> sides;  // first left and right joint of each name
  std::vector<int> other(character.nodes.size(), -1);
  const auto unusable = [&](std::size_t n) {
    return !shape.is_joint[n] || shape.name[n].control || shape.name[n].end;
  };
  for (std::size_t n = 0; n < character.nodes.size(); ++n) {
    if (unusable(n) || shape.name[n].side == Side::none) continue;
    auto& [left, right] = sides.try_emplace(shape.name[n].without_side, -1, -1).first->second;
    int& slot = shape.name[n].side == Side::left ? left : right;
    if (slot < 0) slot = static_cast<int>(n);
  }
  for (const auto& [name, pair] : sides) {
    if (pair.first < 0 || pair.second < 0) continue;
    other[static_cast<std::size_t>(pair.first)] = pair.second;
    other[static_cast<std::size_t>(pair.second)] = pair.first;
  }
  for (const MirrorPair& pair : shape.pairs) {
    other[static_cast<std::size_t>(pair.left)] = pair.right;
    other[static_cast<std::size_t>(pair.right)] = pair.left;
  }
  for (std::size_t n = 0; n < character.nodes.size(); ++n) {
    const int right = other[n];
    if (right < 0 || shape.name[n].side != Side::left || !is_limb(shape.name[n])) continue;
    if (std::ranges::any_of(
            shape.pairs, [&](const MirrorPair& pair) { return pair.left == static_cast<int>(n); }))
      continue;
    const int parent = character.nodes[n].parent;
    if (parent == character.nodes[static_cast<std::size_t>(right)].parent) continue;
    int above = parent;
    while (above >= 0 && (other[static_cast<std::size_t>(above)] < 0 ||
                          !is_ancestor(character, other[static_cast<std::size_t>(above)], right)))
      above = character.nodes[static_cast<std::size_t>(above)].parent;
    if (above >= 0) continue;  // further down a limb that is known
    int common = parent;
    while (common >= 0 && !is_ancestor(character, common, right))
      common = character.nodes[static_cast<std::size_t>(common)].parent;
    if (common < 0) common = root_of(character, static_cast<int>(n));
    shape.pairs.push_back({common, static_cast<int>(n), right, true});
  }
}

/// Calls `visit(parent, a, b)` for every two joints that hang from one node.
template <typename Visit>
void each_two_siblings(const Character& character, const SkeletonShape& shape, Visit visit) {
  for (std::size_t parent = 0; parent < character.nodes.size(); ++parent) {
    const auto& children = shape.children[parent];
    if (children.size() > kMostSiblings) continue;  // a crowd, not a body
    for (std::size_t i = 0; i < children.size(); ++i)
      for (std::size_t k = i + 1; k < children.size(); ++k) {
        const auto a = static_cast<std::size_t>(children[i]);
        const auto b = static_cast<std::size_t>(children[k]);
        if (shape.is_joint[a] && shape.is_joint[b]) visit(parent, a, b);
      }
  }
}

/// Whether two siblings could be a left and a right one by all but their places.
bool alike(const SkeletonShape& shape, std::size_t a, std::size_t b) {
  return shape.name[a].side == Side::none && shape.name[b].side == Side::none &&
         shape.name[a].part == shape.name[b].part;
}

void find_pairs(const Character& character, SkeletonShape& shape,
                std::span<const glm::dvec3> directions) {
  each_two_siblings(character, shape, [&](std::size_t parent, std::size_t a, std::size_t b) {
    const bool named =
        named_pair(shape.name[a], shape.name[b]) || (numbered_apart(shape.name[a], shape.name[b]) &&
                                                     only_two(shape, shape.children[parent], a, b));
    if (!named && (!alike(shape, a, b) || !mirrors(shape, directions, a, b))) return;
    const bool swap = named && shape.name[a].side == Side::right;
    shape.pairs.push_back({static_cast<int>(parent), static_cast<int>(swap ? b : a),
                           static_cast<int>(swap ? a : b), named});
  });
}

/// The direction in which most siblings lie across from each other, for a body without names that
/// stands turned between two axes; nothing where fewer than two pairs share one.
std::optional<glm::dvec3> shared_direction(const Character& character, const SkeletonShape& shape) {
  std::vector<std::pair<glm::dvec3, double>> across;  // and how far the smaller branch reaches
  each_two_siblings(character, shape, [&](std::size_t, std::size_t a, std::size_t b) {
    const glm::dvec3 direction = across_between(shape, a, b);
    if (alike(shape, a, b) && glm::dot(direction, direction) > 0.0)
      across.emplace_back(direction, std::min(shape.reach[a], shape.reach[b]));
  });
  std::optional<glm::dvec3> best;
  double most = 0.0;
  for (const auto& [direction, own] : across) {
    double others = 0.0;
    for (const auto& [other, reach] : across)
      if (&other != &direction && std::abs(glm::dot(direction, other)) > kMirrorAngle)
        others += reach;
    if (others > 0.0 && others + own > most) {
      most = others + own;
      best = direction;
    }
  }
  return best;
}

/// Whether a name begins with Blender's mark of bones that deform, `DEF-`, behind any namespace.
bool is_marked_deforming(std::string_view name) {
  constexpr std::string_view kMark = "DEF-";
  const std::size_t space = name.find_last_of(":|");
  return name.substr(space == std::string_view::npos ? 0 : space + 1).starts_with(kMark);
}

/// A rig that marks the bones that deform says of all others that they do not: its torso, hips and
/// chest are what an animator holds, and the bones of the mechanism lie in the same places.
void find_mechanism(const Character& character, SkeletonShape& shape) {
  constexpr double kMost = 0.5;  // hair or a hat may have bones of their own
  double all = 0.0, marked = 0.0;
  for (std::size_t n = 0; n < shape.weight.size(); ++n) {
    all += shape.weight[n];
    if (is_marked_deforming(character.nodes[n].name)) marked += shape.weight[n];
  }
  if (all <= 0.0 || marked < kMost * all) return;
  for (std::size_t n = 0; n < shape.weight.size(); ++n)
    shape.is_mechanism[n] = !is_marked_deforming(character.nodes[n].name) && shape.weight[n] <= 0.0;
}

}  // namespace

void measure_box(SkeletonShape& shape, const std::vector<bool>& left_out) {
  glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
  for (std::size_t v = 0; v < shape.rest.size(); ++v) {
    if (left_out[v]) continue;
    low = glm::min(low, glm::dvec3(shape.rest[v]));
    high = glm::max(high, glm::dvec3(shape.rest[v]));
  }
  if (!(low.x <= high.x)) low = high = glm::dvec3(0.0);
  shape.low = low;
  shape.high = high;
  shape.size = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
}

SkeletonShape measure_skeleton(const Character& character) {
  if (character.joints.empty()) throw CharacterError(character.file_name + ": no joints");
  const std::size_t count = character.nodes.size();
  SkeletonShape shape;
  shape.children.resize(count);
  shape.is_joint.assign(count, false);
  shape.is_mechanism.assign(count, false);
  shape.weight.assign(count, 0.0);
  shape.farthest.assign(count, -1);
  shape.reach.assign(count, 0.0);
  for (const SkinJoint& joint : character.joints)
    shape.is_joint[static_cast<std::size_t>(joint.node)] = true;
  for (std::size_t n = 0; n < count; ++n) {
    shape.name.push_back(read_joint_name(character.nodes[n].name));
    shape.position.push_back(origin(character.nodes[n].world_from_node));
  }
  shape.rest = rest_mesh(character).position;
  find_props(character, shape);
  find_children(character, shape);
  measure_weights(character, shape);
  // A joint that moves vertices is not an end marker: some rigs' wrists are `arm_end`.
  for (std::size_t n = 0; n < count; ++n)
    if (shape.weight[n] >= 1.0 && !shape.name[n].tip) shape.name[n].end = false;
  find_mechanism(character, shape);
  measure_reach(character, shape);
  constexpr glm::dvec3 kAxes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  find_pairs(character, shape, kAxes);
  if (shape.pairs.size() < 2) {
    shape.pairs.clear();
    const std::optional<glm::dvec3> direction = shared_direction(character, shape);
    find_pairs(character, shape, direction ? std::span(&*direction, 1) : std::span(kAxes));
  }
  find_parted_pairs(character, shape);
  return shape;
}

std::vector<int> path_down(const Character& character, int top, int bottom) {
  std::vector<int> path;
  for (int n = bottom; n >= 0; n = character.nodes[static_cast<std::size_t>(n)].parent) {
    path.push_back(n);
    if (n == top) {
      std::reverse(path.begin(), path.end());
      return path;
    }
  }
  return {};
}

}  // namespace backbend::skin
