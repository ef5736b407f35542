#include "skin/anatomy/import_checks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vector_relational.hpp>
#include <limits>
#include <numeric>
#include <optional>

#include "skin/character/joint_names.h"
#include "skin/character/matrix_facts.h"
#include "skin/character/part_owners.h"
#include "skin/character/printable.h"
#include "skin/deform/skinning.h"
#include "skin/gltf/bind_agreement.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;

// Healthy bodies give 0.8 to 1.3 (the middles of a hand or a foot lie beyond their last joint); an
// inch taken for a centimetre gives 2.5, a foot for a metre 3.3.
constexpr double kDoubtfulScale = 1.6, kImpossibleScale = 2.0;
// Healthy bodies' vertices stand within 0.1 of the size around their joints.
constexpr double kDoubtfulShift = 0.2, kImpossibleShift = 0.5;
constexpr double kFits = 0.6;         // share of the spread that a fit explains: joints tell places
constexpr double kFitsNot = 0.3;      // ... and do not
constexpr double kLeastShare = 1e-4;  // of all weight: less says nothing of a joint's place
constexpr double kOutside = 0.25;     // of the size, from the body's box
constexpr double kAmid = 0.02;        // of the size, around what a joint moves
constexpr double kStandIn = 0.8;      // of the weight: joints amid what they move tell the size

std::string name_of(const Character& character, int node) {
  return in_quotes(character.nodes[static_cast<Index>(node)].name);
}

/// A bone, the middle of what it moves, and whether its joint stands amid that.
struct BoneShare {
  int node = -1;
  double weight = 0.0;
  glm::dvec3 bone{0.0}, middle{0.0};
  bool stands_in = false;
};

struct BodyFacts {
  std::vector<BoneShare> shares;
  BodyBox box;
  double weight = 0.0;
};

BodyFacts measure_body(const Character& character) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  BodyFacts out{{}, {glm::dvec3(kFar), glm::dvec3(-kFar)}, 0.0};
  const PosedMesh rest = rest_mesh(character);
  std::vector<double> weight(character.nodes.size(), 0.0);
  std::vector<glm::dvec3> sum(character.nodes.size(), glm::dvec3(0.0));
  std::vector<BodyBox> moved(character.nodes.size(), {glm::dvec3(kFar), glm::dvec3(-kFar)});
  std::vector<bool> unweighted(character.vertex_count(), false);
  for (const std::uint32_t v : character.unweighted) unweighted[v] = true;
  // The pivot of a prop may be anywhere, and a floor larger than the body.
  const std::vector<bool> is_prop = nodes_of_props(character);
  for (Index v = 0; v < character.vertex_count(); ++v) {
    const std::uint16_t main = character.influences[v].joint[0];
    if (is_prop[static_cast<Index>(character.joints[main].node)]) continue;
    const glm::dvec3 p(rest.position[v]);
    out.box.low = glm::min(out.box.low, p);
    out.box.high = glm::max(out.box.high, p);
    if (unweighted[v]) continue;
    for (Index k = 0; k < kMaxInfluences; ++k) {
      const double w = character.influences[v].weight[k];
      if (!(w > 0.0)) continue;
      const auto node = static_cast<Index>(character.joints[character.influences[v].joint[k]].node);
      weight[node] += w;
      sum[node] += w * p;
      out.weight += w;
      moved[node].low = glm::min(moved[node].low, p);
      moved[node].high = glm::max(moved[node].high, p);
    }
  }
  // A bone runs from its joint to the joints that hang from it and move something, too.
  std::vector<glm::dvec3> ends(character.nodes.size(), glm::dvec3(0.0));
  std::vector<double> count(character.nodes.size(), 0.0);
  for (Index n = 0; n < character.nodes.size(); ++n) {
    const int parent = character.nodes[n].parent;
    if (parent < 0 || !(weight[n] > kLeastShare * out.weight)) continue;
    ends[static_cast<Index>(parent)] += origin(character.nodes[n].world_from_node);
    count[static_cast<Index>(parent)] += 1.0;
  }
  for (Index n = 0; n < character.nodes.size(); ++n) {
    if (!(weight[n] > kLeastShare * out.weight)) continue;
    const glm::dvec3 start = origin(character.nodes[n].world_from_node);
    const glm::dvec3 bone = count[n] > 0.0 ? 0.5 * (start + ends[n] / count[n]) : start;
    const double slack = kAmid * out.box.size();
    out.shares.push_back({static_cast<int>(n), weight[n], bone, sum[n] / weight[n],
                          glm::all(glm::greaterThanEqual(start, moved[n].low - slack)) &&
                              glm::all(glm::lessThanEqual(start, moved[n].high + slack))});
  }
  return out;
}

/// middles = scale * turn * bones + shift, by least squares over the shares' weights.
struct Fit {
  double scale = 1.0;
  double explained = 0.0;  // share of the spread, 0..1; below 0 where the body is turned over
  glm::dvec3 bone_middle{0.0}, body_middle{0.0};
};

Fit fit(const std::vector<BoneShare>& shares, const glm::dmat3& turn) {
  Fit out;
  double total = 0.0;
  for (const BoneShare& one : shares) {
    out.bone_middle += one.weight * one.bone;
    out.body_middle += one.weight * one.middle;
    total += one.weight;
  }
  out.bone_middle /= total;
  out.body_middle /= total;
  double bones = 0.0, body = 0.0, both = 0.0;
  for (const BoneShare& one : shares) {
    const glm::dvec3 p = turn * (one.bone - out.bone_middle), q = one.middle - out.body_middle;
    bones += one.weight * glm::dot(p, p);
    body += one.weight * glm::dot(q, q);
    both += one.weight * glm::dot(p, q);
  }
  if (!(bones > 0.0) || !(body > 0.0)) return out;
  out.scale = both / bones;
  out.explained = both * std::abs(both) / (bones * body);
  return out;
}

/// The 24 turns that map axes to axes; the first changes nothing.
std::vector<glm::dmat3> axis_turns() {
  std::vector<glm::dmat3> out;
  constexpr std::array<std::array<int, 3>, 6> kOrders = {
      {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  for (const auto& order : kOrders)
    for (int signs = 0; signs < 8; ++signs) {
      glm::dmat3 turn(0.0);
      for (int c = 0; c < 3; ++c)
        turn[c][order[static_cast<Index>(c)]] = (signs >> c) & 1 ? -1.0 : 1.0;
      if (glm::determinant(turn) > 0.0) out.push_back(turn);
    }
  return out;
}

std::string times_text(double scale) {
  return scale >= 1.0 ? "about " + number_text(scale, 2) + " times its skeleton's size"
                      : "about 1/" + number_text(1.0 / scale, 2) + " of its skeleton's size";
}

/// The unit that explains a scale, if one does.
std::string unit_text(double scale) {
  const double ratio = scale >= 1.0 ? scale : 1.0 / scale;
  const struct {
    double ratio;
    const char* text;
  } units[] = {{2.54, "inches and centimetres"},      {3.28, "feet and metres"},
               {10.0, "millimetres and centimetres"}, {39.4, "inches and metres"},
               {100.0, "centimetres and metres"},     {1000.0, "millimetres and metres"}};
  for (const auto& unit : units)
    if (std::abs(std::log(ratio / unit.ratio)) < 0.2) return std::string(" (") + unit.text + "?)";
  return "";
}

void check_size(const BodyFacts& body, std::vector<ImportFact>& out) {
  const Fit straight = fit(body.shares, glm::dmat3(1.0));
  if (straight.explained >= kFits && straight.scale > 0.0) {
    // Limbs of one joint have no bone that could tell its length.
    double stands_in = 0.0, all = 0.0;
    for (const BoneShare& one : body.shares) {
      all += one.weight;
      if (one.stands_in) stands_in += one.weight;
    }
    const double ratio =
        stands_in >= kStandIn * all ? 1.0 : std::max(straight.scale, 1.0 / straight.scale);
    if (ratio > kDoubtfulScale)
      out.push_back({"body_size", ratio > kImpossibleScale,
                     "the body is " + times_text(straight.scale) + unit_text(straight.scale) +
                         "; export both in one unit, with scale applied (\"apply transforms\") to "
                         "mesh and armature"});
    if (ratio > kImpossibleScale) return;  // its place says nothing more
  } else if (straight.explained < kFits) {
    double best = straight.explained;
    for (const glm::dmat3& turn : axis_turns()) {
      const Fit turned = fit(body.shares, turn);
      if (turned.scale > 0.0) best = std::max(best, turned.explained);
    }
    if (best >= kFits) {
      out.push_back({"body_axis", straight.explained < kFitsNot,
                     "the body fits its skeleton only after a quarter or half turn; export both "
                     "with the same up axis, with rotation applied (\"apply transforms\") to mesh "
                     "and armature"});
      return;
    }
    out.push_back({"body_apart", straight.explained < 0.1,
                   "the parts of the body do not lie where the bones that move them are; was the "
                   "mesh bound to another skeleton, or its vertex groups lost their order?"});
    return;
  }
  const double size = std::max(body.box.size(), 1e-300);
  const double shift = glm::distance(straight.body_middle, straight.bone_middle) / size;
  if (shift > kDoubtfulShift)
    out.push_back({"body_place", shift > kImpossibleShift,
                   "the body stands " + number_text(shift * size, 3) + " (" +
                       number_text(100.0 * shift, 3) +
                       " % of its size) beside its skeleton; apply the transforms of mesh and "
                       "armature before export, and bind again"});
}

void check_joints(const Character& character, const BodyFacts& body, std::vector<ImportFact>& out) {
  const double size = body.box.size();
  int first = -1;
  double farthest = 0.0;
  Index count = 0;
  for (const BoneShare& one : body.shares) {
    const glm::dvec3 p = origin(character.nodes[static_cast<Index>(one.node)].world_from_node);
    const glm::dvec3 beyond = glm::max(glm::max(body.box.low - p, p - body.box.high), 0.0);
    const double distance = glm::length(beyond);
    if (distance <= kOutside * size) continue;
    ++count;
    if (distance <= farthest) continue;
    farthest = distance;
    first = one.node;
  }
  if (first < 0) return;
  out.push_back({"joint_outside", 2 * count > body.shares.size(),
                 plural(count, "joint") + " of " + std::to_string(body.shares.size()) +
                     " that move vertices stand outside the body, " + name_of(character, first) +
                     " by " + number_text(farthest, 3) + " (" +
                     number_text(100.0 * farthest / size, 3) +
                     " % of its size); check the unit and the rest pose of the skeleton, and apply "
                     "transforms before export"});
}

}  // namespace

std::vector<ImportFact> check_import(const Character& character) {
  std::vector<ImportFact> out;
  if (character.vertex_count() == 0) return out;
  const BodyFacts body = measure_body(character);
  if (body.shares.size() < 3 || !(body.box.size() > 0.0)) return out;
  check_size(body, out);
  const bool impossible =
      std::any_of(out.begin(), out.end(), [](const ImportFact& fact) { return fact.impossible; });
  if (!impossible) check_joints(character, body, out);
  return out;
}

void require_possible_import(const Character& character) {
  for (const ImportFact& fact : check_import(character))
    if (fact.impossible)
      throw CharacterError(character.file_name + ": " + fact.code + ": " + fact.message);
}

std::vector<JointBindOff> joints_bound_off(const Character& character) {
  // Joints that share a vertex, or a part in rigid pieces, are of one skin; numbers of joints are
  // not told by skin any more.
  std::vector<Index> group(character.joints.size());
  std::iota(group.begin(), group.end(), Index{0});
  const auto find = [&](Index a) {
    while (group[a] != a) a = group[a] = group[group[a]];
    return a;
  };
  const auto join = [&](Index a, Index b) {
    a = find(a);
    b = find(b);
    group[std::max(a, b)] = std::min(a, b);
  };
  std::vector<bool> unweighted(character.vertex_count(), false);
  for (const std::uint32_t v : character.unweighted) unweighted[v] = true;
  constexpr double kFar = std::numeric_limits<double>::infinity();
  std::vector<BodyBox> box(character.joints.size(), {glm::dvec3(kFar), glm::dvec3(-kFar)});
  std::vector<bool> moves(character.joints.size(), false);
  for (Index v = 0; v < character.vertex_count(); ++v) {
    if (unweighted[v]) continue;
    const Influences& influences = character.influences[v];
    const glm::dvec3 p(character.bind_position[v]);
    for (Index k = 0; k < kMaxInfluences && influences.weight[k] > 0.0f; ++k) {
      const Index j = influences.joint[k];
      moves[j] = true;
      box[j].low = glm::min(box[j].low, p);
      box[j].high = glm::max(box[j].high, p);
      join(influences.joint[0], j);
    }
  }
  for (const Part& part : character.parts) {
    std::optional<Index> known;
    for (Index v = part.first_vertex; v < part.first_vertex + Index{part.vertex_count}; ++v) {
      if (unweighted[v]) continue;
      const Index j = character.influences[v].joint[0];
      join(known.value_or(j), j);
      known = j;
    }
  }
  std::vector<JointBindOff> out;
  for (Index first = 0; first < character.joints.size(); ++first) {
    if (find(first) != first || !moves[first]) continue;
    std::vector<BoundJoint> joints;
    std::vector<Index> number;
    BodyBox whole{glm::dvec3(kFar), glm::dvec3(-kFar)};
    for (Index j = first; j < character.joints.size(); ++j) {
      if (!moves[j] || find(j) != first) continue;
      const glm::dmat4 world = rest_motion(character, j);
      if (!is_finite(world)) continue;
      joints.push_back({character.joints[j].node, world});
      number.push_back(j);
      whole.low = glm::min(whole.low, box[j].low);
      whole.high = glm::max(whole.high, box[j].high);
    }
    for (const BindOff& one : find_bind_off(character.nodes, joints, whole)) {
      Index j = 0;
      while (joints[j].node != one.node) ++j;
      const glm::dmat4 own = joints[j].world_from_mesh;
      JointBindOff off{one.node, one.angle_deg, 0.0, 0};
      for (Index v = 0; v < character.vertex_count(); ++v)
        for (Index k = 0; k < kMaxInfluences; ++k) {
          if (character.influences[v].joint[k] != number[j]) continue;
          const glm::dvec4 p(glm::dvec3(character.bind_position[v]), 1.0);
          const double shift = character.influences[v].weight[k] *
                               glm::distance(glm::dvec3(own * p), glm::dvec3(one.agreed * p));
          if (shift <= off.shift) continue;
          off.shift = shift;
          off.vertex = static_cast<std::uint32_t>(v);
        }
      if (off.shift > 0.0) out.push_back(off);
    }
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const JointBindOff& a, const JointBindOff& b) { return a.shift > b.shift; });
  return out;
}

}  // namespace backbend::skin
