#include "validate/why/ingredients.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <set>
#include <tuple>
#include <unordered_map>

#include "skin/anatomy/import_checks.h"
#include "skin/deform/skinning.h"
#include "validate/judge/confirmed.h"
#include "validate/sweeps/sweep.h"
#include "validate/why/vertex_match.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;
using skin::Character;

constexpr double kNear = 1.0 / 200.0;       // of the height: the same vertex, as surface_match()
constexpr double kJointNear = 1.0 / 500.0;  // of the height: the same joint under another name
constexpr double kLeastCoverage = 0.9;
constexpr double kSameWeight = 1e-5;  // shares; what storage in 16 bits rounds
constexpr double kSamePlace = 1e-5;   // of the height
constexpr Index kMostNames = 4;

struct Bounds {
  glm::dvec3 low{std::numeric_limits<double>::infinity()};
  glm::dvec3 high{-std::numeric_limits<double>::infinity()};
};

double size_of(const std::vector<glm::vec3>& points) {
  Bounds b;
  for (const glm::vec3& p : points) {
    b.low = glm::min(b.low, glm::dvec3(p));
    b.high = glm::max(b.high, glm::dvec3(p));
  }
  return points.empty() ? 0.0
                        : std::max({b.high.x - b.low.x, b.high.y - b.low.y, b.high.z - b.low.z});
}

double largest_change(const glm::dmat4& a, const glm::dmat4& b) {
  double most = 0.0;
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r) most = std::max(most, std::abs(a[c][r] - b[c][r]));
  return most;
}

/// What the bind of a joint adds to the skeleton at rest: where it takes the stored mesh.
glm::dmat4 world_from_mesh(const Character& body, const skin::SkinJoint& joint) {
  return body.nodes[static_cast<Index>(joint.node)].world_from_node * joint.joint_from_mesh;
}

std::string list_text(const std::vector<std::string>& names) {
  std::string text;
  for (Index i = 0; i < std::min(names.size(), kMostNames); ++i)
    text += (text.empty() ? "" : ", ") + names[i];
  if (names.size() > kMostNames)
    text += " and " + std::to_string(names.size() - kMostNames) + " more";
  return text;
}

std::string counted(Index count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

/// For each node of `a` the node of `b` of the same name, or else at the same place; -1: none.
std::vector<int> match_nodes(const Character& a, const Character& b, double near) {
  std::unordered_map<std::string, int> by_name;
  for (Index n = 0; n < b.nodes.size(); ++n) by_name.emplace(b.nodes[n].name, static_cast<int>(n));
  std::vector<int> out(a.nodes.size(), -1);
  std::vector<bool> taken(b.nodes.size(), false);
  for (Index n = 0; n < a.nodes.size(); ++n)
    if (const auto found = by_name.find(a.nodes[n].name); found != by_name.end()) {
      out[n] = found->second;
      taken[static_cast<Index>(found->second)] = true;
    }
  for (Index n = 0; n < a.nodes.size(); ++n) {
    if (out[n] >= 0) continue;
    double best = near;
    for (Index m = 0; m < b.nodes.size(); ++m) {
      if (taken[m]) continue;
      const double far = glm::distance(glm::dvec3(a.nodes[n].world_from_node[3]),
                                       glm::dvec3(b.nodes[m].world_from_node[3]));
      if (far < best) {
        best = far;
        out[n] = static_cast<int>(m);
      }
    }
    if (out[n] >= 0) taken[static_cast<Index>(out[n])] = true;
  }
  return out;
}

/// What a sidecar or the user says of the character, without what it did to the mesh on loading.
bool same_mapping(const Version& a, const Version& b) {
  const auto words = [](const skin::AnatomyHints& h) {
    return std::tie(h.hip, h.chest, h.spine, h.left_arm, h.right_arm, h.rig_template, h.up,
                    h.forward);
  };
  const auto of = [](const Version& v) { return v.sidecar.value_or(skin::Sidecar{}); };
  return words(a.hints) == words(b.hints) && of(a).envelope == of(b).envelope &&
         of(a).controls == of(b).controls;
}

}  // namespace

std::string_view name_of(Ingredient ingredient) {
  constexpr std::string_view kNames[kIngredients] = {"skeleton", "bind",    "mesh",   "weights",
                                                     "options",  "mapping", "program"};
  return kNames[static_cast<Index>(ingredient)];
}

std::vector<Ingredient> members(IngredientSet set) {
  std::vector<Ingredient> out;
  for (int i = 0; i < kIngredients; ++i)
    if (set >> i & 1u) out.push_back(static_cast<Ingredient>(i));
  return out;
}

Version load_version(const std::string& file, const skin::AnatomyHints& hints, const RigPlan& rig) {
  ConfirmedCharacter confirmed = load_confirmed(file, hints);
  skin::require_possible_import(confirmed.character);
  return {file, std::move(confirmed.character), std::move(confirmed.hints),
          std::move(confirmed.sidecar), rig};
}

VersionPair::VersionPair(Version before, Version after)
    : before_(std::move(before)),
      after_(std::move(after)),
      rest_before_(skin::rest_mesh(before_.character).position),
      rest_after_(skin::rest_mesh(after_.character).position) {
  match_vertices();
  match_joints();
  compare();
}

void VersionPair::match_vertices() {
  const Character &a = before_.character, &b = after_.character;
  if (a.vertex_count() == b.vertex_count() && a.triangles == b.triangles) return;
  // A body without size, which nothing can be measured of, is refused later.
  const double size = std::max({size_of(rest_before_), size_of(rest_after_), 1e-9});
  VertexMatch match =
      validate::match_vertices({rest_before_, a.triangles}, {rest_after_, b.triangles},
                               {kNear * size, kSamePlace * size, kLeastCoverage});
  coverage_ = match.coverage;
  if (!(coverage_ >= kLeastCoverage))
    throw skin::CharacterError(
        after_.label + ": only " + number_text(100.0 * coverage_, 1) +
        " % of its vertices and those of " + before_.label +
        " are within a two-hundredth of the height of each other; versions of one body have " +
        number_text(100.0 * kLeastCoverage) + " % and more");
  same_mesh_ = match.same_mesh;
  before_of_after_ = std::move(match.before_of_after);
  after_of_before_ = std::move(match.after_of_before);
}

void VersionPair::match_joints() {
  const Character &a = before_.character, &b = after_.character;
  const double near = kJointNear * std::max(size_of(rest_before_), size_of(rest_after_));
  node_of_before_ = match_nodes(a, b, near);
  node_of_after_.assign(b.nodes.size(), -1);
  for (Index n = 0; n < node_of_before_.size(); ++n)
    if (const int m = node_of_before_[n]; m >= 0 && node_of_after_[static_cast<Index>(m)] < 0)
      node_of_after_[static_cast<Index>(m)] = static_cast<int>(n);
  std::map<int, int> joint_of_node;  // of the later version: into joints_
  joint_of_before_.assign(a.joints.size(), -1);
  joint_of_after_.assign(b.joints.size(), -1);
  for (Index j = 0; j < b.joints.size(); ++j) {
    joint_of_after_[j] = static_cast<int>(joints_.size());
    joint_of_node.emplace(b.joints[j].node, static_cast<int>(joints_.size()));
    joints_.push_back({-1, static_cast<int>(j)});
  }
  for (Index j = 0; j < a.joints.size(); ++j) {
    const auto found = joint_of_node.find(node_of_before_[static_cast<Index>(a.joints[j].node)]);
    if (found != joint_of_node.end() && joints_[static_cast<Index>(found->second)].before < 0) {
      joints_[static_cast<Index>(found->second)].before = static_cast<int>(j);
      joint_of_before_[j] = found->second;
    } else {
      joint_of_before_[j] = static_cast<int>(joints_.size());
      joints_.push_back({static_cast<int>(j), -1});
    }
  }
}

void VersionPair::compare() {
  const Character &a = before_.character, &b = after_.character;
  const double size = std::max(size_of(rest_before_), size_of(rest_after_));
  const auto add = [&](Ingredient ingredient) { changed_ |= bit(ingredient); };

  // The skeleton: which joints there are, what they hang from, where they are at rest.
  for (Index n = 0; n < b.nodes.size(); ++n) {
    const int m = node_of_after_[n];
    bool same = m >= 0;
    if (same) {
      const skin::Node &x = a.nodes[static_cast<Index>(m)], &y = b.nodes[n];
      const int parent = y.parent < 0 ? -1 : node_of_after_[static_cast<Index>(y.parent)];
      same = parent == x.parent;
      for (int c = 0; c < 4 && same; ++c)
        for (int r = 0; r < 3; ++r)
          same = same && std::abs(x.world_from_node[c][r] - y.world_from_node[c][r]) <=
                             (c == 3 ? kSamePlace * size
                                     : 1e-5 * (1.0 + std::abs(x.world_from_node[c][r])));
    }
    if (!same) moved_joints_.push_back(b.nodes[n].name);
  }
  for (Index n = 0; n < a.nodes.size(); ++n)
    if (node_of_before_[n] < 0) moved_joints_.push_back(a.nodes[n].name);
  if (!moved_joints_.empty()) add(Ingredient::skeleton);

  // The bind: what it adds to the skeleton, less what all joints have in common, which is the space
  // that the mesh is stored in.
  std::optional<glm::dmat4> space_a, space_b;
  for (const Joint& joint : joints_) {
    if (joint.before < 0 || joint.after < 0) continue;
    const glm::dmat4 x = world_from_mesh(a, a.joints[static_cast<Index>(joint.before)]);
    const glm::dmat4 y = world_from_mesh(b, b.joints[static_cast<Index>(joint.after)]);
    if (!space_a) {
      space_a = x;
      space_b = y;
    }
    const glm::dmat4 from_a = x * glm::inverse(*space_a), from_b = y * glm::inverse(*space_b);
    if (largest_change(from_a, from_b) > 1e-4 * std::max(1.0, size))
      rebound_joints_.push_back(
          b.nodes[static_cast<Index>(b.joints[static_cast<Index>(joint.after)].node)].name);
  }
  if (!rebound_joints_.empty()) add(Ingredient::bind);

  // The mesh, where it stands at rest.
  if (!before_of_after_.empty()) {
    const double reach = kSamePlace * size;
    for (Index v = 0; v < rest_after_.size(); ++v)
      moved_vertices_ += glm::distance(glm::dvec3(rest_after_[v]),
                                       glm::dvec3(rest_before_[before_of_after_[v]])) > reach;
    add(Ingredient::mesh);  // its order or its triangles at least
  } else {
    for (Index v = 0; v < rest_after_.size(); ++v)
      moved_vertices_ += glm::distance(glm::dvec3(rest_after_[v]), glm::dvec3(rest_before_[v])) >
                         kSamePlace * size;
    if (moved_vertices_ > 0) add(Ingredient::mesh);
  }

  // Weights, by the joint whose share changes most.
  std::vector<double> share(joints_.size(), 0.0);
  for (Index v = 0; v < b.vertex_count(); ++v) {
    const Index u = before_of_after_.empty() ? v : before_of_after_[v];
    const skin::Influences &x = a.influences[u], &y = b.influences[v];
    std::vector<Index> touched;
    for (int k = 0; k < skin::kMaxInfluences; ++k) {
      if (y.weight[k] != 0.0f) {
        touched.push_back(static_cast<Index>(joint_of_after_[y.joint[k]]));
        share[touched.back()] += y.weight[k];
      }
      if (x.weight[k] != 0.0f) {
        touched.push_back(static_cast<Index>(joint_of_before_[x.joint[k]]));
        share[touched.back()] -= x.weight[k];
      }
    }
    std::ranges::sort(touched);
    Index most = 0;
    double change = 0.0;
    for (const Index j : touched) {
      if (std::abs(share[j]) > change) {
        change = std::abs(share[j]);
        most = j;
      }
    }
    // What a joint gains says more than what others lose for it.
    for (const Index j : touched)
      if (share[j] > 0.0 && share[j] >= change - kSameWeight) most = j;
    for (const Index j : touched) share[j] = 0.0;
    if (change <= kSameWeight) continue;
    const Joint& joint = joints_[most];
    const int node = joint.after >= 0 ? b.joints[static_cast<Index>(joint.after)].node
                                      : a.joints[static_cast<Index>(joint.before)].node;
    changed_weights_[(joint.after >= 0 ? b : a).nodes[static_cast<Index>(node)].name].push_back(
        static_cast<std::uint32_t>(v));
  }
  if (!changed_weights_.empty()) add(Ingredient::weights);

  const solver::SystemSpec &old_rig = before_.rig.spec, &new_rig = after_.rig.spec;
  if (old_rig.system != new_rig.system) changed_options_.emplace_back("system");
  std::set<std::string> keys;
  for (const auto* spec : {&old_rig, &new_rig})
    for (const auto& [key, value] : spec->options) keys.insert(key);
  for (const std::string& key : keys) {
    const auto x = old_rig.options.find(key), y = new_rig.options.find(key);
    if (x == old_rig.options.end() || y == new_rig.options.end() || x->second != y->second)
      changed_options_.push_back(key);
  }
  if (!changed_options_.empty()) add(Ingredient::options);
  if (!same_mapping(before_, after_)) add(Ingredient::mapping);
}

std::string VersionPair::difference(Ingredient ingredient) const {
  switch (ingredient) {
    case Ingredient::skeleton:
      return list_text(moved_joints_);
    case Ingredient::bind:
      return list_text(rebound_joints_);
    case Ingredient::mesh:
      if (before_of_after_.empty())
        return counted(moved_vertices_, "vertex moved", "vertices moved");
      if (same_mesh_)
        return "another order, " + counted(moved_vertices_, "vertex moved", "vertices moved");
      return "other vertices or order, " + counted(moved_vertices_,
                                                   "vertex without one at its place",
                                                   "vertices without one at their place");
    case Ingredient::weights: {
      Index count = 0;
      std::vector<std::string> names;
      for (const auto& [name, vertices] : changed_weights_) {
        count += vertices.size();
        names.push_back(name);
      }
      std::ranges::stable_sort(names, std::greater<>(), [&](const std::string& name) {
        return changed_weights_.at(name).size();
      });
      return list_text(names) + ": " + counted(count, "vertex", "vertices");
    }
    case Ingredient::options:
      return list_text(changed_options_);
    case Ingredient::mapping:
      return "the sidecar, or what was said of the joints";
    case Ingredient::program:
      break;  // not of the versions
  }
  return {};
}

Version VersionPair::mixed(IngredientSet of_after, const Parts& parts) const {
  const bool whole = !parts.weights && !parts.options;
  if (whole && (of_after & changed_) == 0) return before_;
  if (whole && (of_after & changed_) == changed_) return after_;
  const auto takes_after = [&](Ingredient ingredient) { return (of_after & bit(ingredient)) != 0; };
  const bool new_skeleton = takes_after(Ingredient::skeleton),
             new_bind = takes_after(Ingredient::bind), new_mesh = takes_after(Ingredient::mesh),
             new_weights = takes_after(Ingredient::weights);
  const Character &a = before_.character, &b = after_.character;
  const Character& bones = new_skeleton ? b : a;
  const Character& surface = new_mesh ? b : a;

  Version out = takes_after(Ingredient::mapping) ? after_ : before_;
  out.label = "a mixture of " + before_.label + " and " + after_.label;
  if (takes_after(Ingredient::options)) {
    out.rig = after_.rig;
    if (parts.options) {
      out.rig = before_.rig;
      for (const std::string& key : *parts.options) {
        if (key == "system") {
          out.rig.spec.system = after_.rig.spec.system;
        } else if (const auto found = after_.rig.spec.options.find(key);
                   found != after_.rig.spec.options.end()) {
          out.rig.spec.options[key] = found->second;
        } else {
          out.rig.spec.options.erase(key);
        }
      }
    }
  } else {
    out.rig = before_.rig;
  }

  Character body = surface;
  body.name = a.name;
  body.nodes = bones.nodes;
  // The space that the mesh is stored in is the mesh's, as is what takes it to the world.
  const auto space_of = [&](const Character& of, bool after) -> glm::dmat4 {
    for (const Joint& joint : joints_)
      if (joint.before >= 0 && joint.after >= 0)
        return world_from_mesh(of,
                               of.joints[static_cast<Index>(after ? joint.after : joint.before)]);
    return glm::dmat4(1.0);
  };
  const glm::dmat4 mesh_space = space_of(surface, new_mesh);
  body.joints.clear();
  for (const Joint& joint : joints_) {
    // Where the joint is in the skeleton that is taken; of one that it does not have, its nearest
    // ancestor that it has.
    const auto node_in_bones = [&]() -> int {
      const int own = new_skeleton ? joint.after : joint.before;
      const Character& owner = new_skeleton ? b : a;
      if (own >= 0) return owner.joints[static_cast<Index>(own)].node;
      const Character& other = new_skeleton ? a : b;
      const std::vector<int>& match = new_skeleton ? node_of_before_ : node_of_after_;
      int node = other.joints[static_cast<Index>(new_skeleton ? joint.before : joint.after)].node;
      while (node >= 0 && match[static_cast<Index>(node)] < 0)
        node = other.nodes[static_cast<Index>(node)].parent;
      return node < 0 ? 0 : match[static_cast<Index>(node)];
    };
    const int node = node_in_bones();
    const bool bind_after = joint.before < 0 || (new_bind && joint.after >= 0);
    const Character& binder = bind_after ? b : a;
    const skin::SkinJoint& bound =
        binder.joints[static_cast<Index>(bind_after ? joint.after : joint.before)];
    glm::dmat4 joint_from_mesh;
    if (&binder == &bones && &binder == &surface && bound.node == node) {
      joint_from_mesh = bound.joint_from_mesh;  // to the last bit
    } else {
      const glm::dmat4 added =
          world_from_mesh(binder, bound) * glm::inverse(space_of(binder, bind_after));
      joint_from_mesh =
          glm::inverse(bones.nodes[static_cast<Index>(node)].world_from_node) * added * mesh_space;
    }
    body.joints.push_back({node, joint_from_mesh});
  }

  // Weights, vertex by vertex, where only some joints' are mixed.
  std::vector<bool> taken;  // vertices of the later mesh whose weights are the later ones
  if (new_weights && parts.weights) {
    taken.assign(b.vertex_count(), false);
    for (const std::string& name : *parts.weights)
      if (const auto found = changed_weights_.find(name); found != changed_weights_.end())
        for (const std::uint32_t v : found->second) taken[v] = true;
  }
  for (Index v = 0; v < body.vertex_count(); ++v) {
    const Index in_after = new_mesh || after_of_before_.empty() ? v : after_of_before_[v];
    const Index in_before = !new_mesh || before_of_after_.empty() ? v : before_of_after_[v];
    const bool later = new_weights && (taken.empty() || taken[in_after]);
    skin::Influences influences = later ? b.influences[in_after] : a.influences[in_before];
    for (int k = 0; k < skin::kMaxInfluences; ++k) {
      if (influences.weight[k] == 0.0f) continue;
      influences.joint[k] = static_cast<std::uint16_t>(
          (later ? joint_of_after_ : joint_of_before_)[influences.joint[k]]);
    }
    for (int k = 0; k < skin::kMaxInfluences; ++k)
      if (influences.weight[k] == 0.0f) influences.joint[k] = 0;
    body.influences[v] = influences;
  }
  // What reading the file noticed of weights is theirs.
  const Character& weighted = new_weights ? b : a;
  const std::vector<std::uint32_t>& from_weighted =
      new_weights ? before_of_after_ : after_of_before_;
  body.unweighted.clear();
  for (const std::uint32_t v : weighted.unweighted) {
    const bool same_mesh = new_weights == new_mesh || from_weighted.empty();
    body.unweighted.push_back(same_mesh ? v : from_weighted[v]);
  }
  std::ranges::sort(body.unweighted);
  body.renormalised_vertices = weighted.renormalised_vertices;
  body.worst_weight_sum = weighted.worst_weight_sum;
  body.worst_weight_vertex = weighted.worst_weight_vertex;
  if (body.worst_weight_vertex >= static_cast<int>(body.vertex_count()))
    body.worst_weight_vertex = -1;
  out.character = std::move(body);
  return out;
}

}  // namespace backbend::validate
