#include "tests/battery/weight_faults.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>

#include "skin/character/matrix_facts.h"
#include "validate/metrics/math/rotation.h"

namespace backbend::battery {
namespace {

using Index = std::size_t;
using skin::Character;

/// A body under change, with what every kind of fault asks of it.
class Patient {
 public:
  Patient(Character& body, const skin::Anatomy& anatomy, WeightFault& fault)
      : body(body), anatomy(anatomy), chain(hips_to_chest(body, anatomy)), fault(fault) {
    fault.touched.assign(body.vertex_count(), false);
    for (const skin::Influences& each : body.influences) weights.push_back(weights_of(each));
    const auto& joint = body.joints.front();
    world_from_mesh =
        body.nodes[static_cast<Index>(joint.node)].world_from_node * joint.joint_from_mesh;
  }

  glm::dvec3 place(Index vertex) const {
    return glm::dvec3(world_from_mesh * glm::dvec4(glm::dvec3(body.bind_position[vertex]), 1.0));
  }
  glm::dvec3 place_of_node(int node) const {
    return skin::origin(body.nodes[static_cast<Index>(node)].world_from_node);
  }
  std::uint16_t joint(int node) { return skin_joint(body, node); }
  /// -1 where the skin has none for this node.
  int known_joint(int node) const {
    for (Index j = 0; j < body.joints.size(); ++j)
      if (body.joints[j].node == node) return static_cast<int>(j);
    return -1;
  }
  void blame(int node) { fault.joints.insert(body.nodes[static_cast<Index>(node)].name); }
  void blame_chain_around(Index k) {
    for (Index i = k == 0 ? 0 : k - 1; i <= std::min(k + 1, chain.size() - 1); ++i) blame(chain[i]);
  }
  double weight(Index v, int joint) const {
    const auto found = weights[v].find(static_cast<std::uint16_t>(joint));
    return joint < 0 || found == weights[v].end() ? 0.0 : found->second;
  }
  /// Gives a share of one joint's weight to another.
  void move(Index v, std::uint16_t from, std::uint16_t to, double share) {
    const auto found = weights[v].find(from);
    if (found == weights[v].end()) return;
    const double amount = share * found->second;
    if (amount < 1e-4) return;
    found->second -= amount;
    weights[v][to] += amount;
    fault.touched[v] = true;
  }
  void finish() {
    for (Index v = 0; v < weights.size(); ++v)
      if (fault.touched[v]) body.influences[v] = influences_of(weights[v], skin::kMaxInfluences);
    if (std::none_of(fault.touched.begin(), fault.touched.end(), [](bool each) { return each; }))
      fault.joints.clear();
  }
  /// Vertebrae between hips and chest that carry weight, by place in the chain.
  std::vector<Index> vertebrae() const {
    std::vector<Index> out;
    for (Index k = 1; k < chain.size(); ++k)
      if (known_joint(chain[k]) >= 0 && mass(known_joint(chain[k])) > 1.0) out.push_back(k);
    return out;
  }
  double mass(int joint) const {
    double sum = 0.0;
    for (Index v = 0; v < weights.size(); ++v) sum += weight(v, joint);
    return sum;
  }
  /// The arm's joint that moves most vertices.
  int arm_joint(const std::vector<int>& arm) const {
    int best = -1;
    double most = 0.0;
    for (Index k = 1; k < std::min(arm.size(), Index{4}); ++k)
      if (const int j = known_joint(arm[k]); j >= 0 && mass(j) > most) {
        most = mass(j);
        best = arm[k];
      }
    return best;
  }
  double side(Index v) const { return glm::dot(place(v) - place_of_node(chain[0]), anatomy.left); }

  Character& body;
  const skin::Anatomy& anatomy;
  std::vector<int> chain;
  WeightFault& fault;
  std::vector<JointWeights> weights;
  glm::dmat4 world_from_mesh{1.0};
};

using Draw = validate::Draw;

constexpr std::ptrdiff_t kSeenPlaces = 12;  // fewer vertices at fault are single slips

void wrong_side(Patient& on, double percent, Draw& draw) {
  const bool from_left = draw.coin();
  const auto& own = from_left ? on.anatomy.left_arm : on.anatomy.right_arm;
  const auto& other = from_left ? on.anatomy.right_arm : on.anatomy.left_arm;
  const int from = on.arm_joint(own), to = on.arm_joint(other);
  if (from < 0 || to < 0) return;
  const std::uint16_t a = on.joint(from), b = on.joint(to);
  for (Index v = 0; v < on.weights.size(); ++v) on.move(v, a, b, 0.01 * percent);
  on.blame(from);
  on.blame(to);
}

void smear(Patient& on, double percent, Draw& draw, bool left_only) {
  const std::vector<Index> all = on.vertebrae();
  if (all.empty()) return;
  const Index k = all[draw.index(all.size())];
  const bool up = k == 1 || (k + 1 < on.chain.size() && draw.coin());
  const Index to = up ? std::min(k + 1, on.chain.size() - 1) : k - 1;
  if (to == k) return;
  const std::uint16_t a = on.joint(on.chain[k]), b = on.joint(on.chain[to]);
  for (Index v = 0; v < on.weights.size(); ++v)
    if (!left_only || on.side(v) > 0.0) on.move(v, a, b, 0.01 * percent);
  on.blame_chain_around(k);
  on.blame_chain_around(to);
}

void half_torso(Patient& on, double percent, Draw&) {
  // All vertebrae's weight on the left goes one up.
  for (Index k = on.chain.size() - 1; k-- > 1;) {
    const std::uint16_t a = on.joint(on.chain[k]), b = on.joint(on.chain[k + 1]);
    for (Index v = 0; v < on.weights.size(); ++v)
      if (on.side(v) > 0.0) on.move(v, a, b, 0.01 * percent);
  }
  for (const int node : on.chain) on.blame(node);
}

void swapped(Patient& on, double, Draw& draw) {
  const std::vector<Index> all = on.vertebrae();
  if (all.size() < 2) return;
  const Index i = draw.index(all.size() - 1);
  const std::uint16_t a = on.joint(on.chain[all[i]]), b = on.joint(on.chain[all[i + 1]]);
  for (Index v = 0; v < on.weights.size(); ++v) {
    const double wa = on.weight(v, a), wb = on.weight(v, b);
    if (std::abs(wa - wb) < 1e-4) continue;
    on.weights[v][a] = wb;
    on.weights[v][b] = wa;
    on.fault.touched[v] = true;
  }
  on.blame_chain_around(all[i]);
  on.blame_chain_around(all[i + 1]);
}

void rigid_ring(Patient& on, double, Draw& draw) {
  const std::vector<Index> all = on.vertebrae();
  if (all.size() < 2) return;
  const Index i = draw.index(all.size() - 1);
  const std::uint16_t a = on.joint(on.chain[all[i]]), b = on.joint(on.chain[all[i + 1]]);
  for (Index v = 0; v < on.weights.size(); ++v) {
    const double wa = on.weight(v, a), wb = on.weight(v, b);
    if (wa + wb < 0.3 || std::min(wa, wb) < 1e-3) continue;
    on.weights[v][a] = wa >= wb ? wa + wb : 0.0;
    on.weights[v][b] = wa >= wb ? 0.0 : wa + wb;
    on.fault.touched[v] = true;
  }
  on.blame_chain_around(all[i]);
  on.blame_chain_around(all[i + 1]);
}

/// A share of the weight of a patch of the torso goes to a joint that has no business there.
void bleed(Patient& on, double percent, Draw& draw, int to_node) {
  if (to_node < 0) return;
  const std::vector<Index> all = on.vertebrae();
  if (all.empty()) return;
  const std::uint16_t to = on.joint(to_node);
  std::vector<Index> torso;
  const std::uint16_t own = on.joint(on.chain[all[draw.index(all.size())]]);
  for (Index v = 0; v < on.weights.size(); ++v)
    if (on.weight(v, own) > 0.4) torso.push_back(v);
  if (torso.empty()) return;
  // Away from the joint's own area: beside it more weight is a wide brush, not a spill.
  std::vector<Index> apart;
  for (const Index v : torso) {
    bool is_apart = true;
    for (Index other = 0; other < on.weights.size() && is_apart; ++other)
      is_apart = on.weight(other, to) < 0.3 ||
                 glm::distance(on.place(v), on.place(other)) > 0.15 * on.anatomy.height;
    if (is_apart) apart.push_back(v);
  }
  if (apart.empty()) return;
  const glm::dvec3 middle = on.place(apart[draw.index(apart.size())]);
  // A patch that can be seen: of long, low or coarse bodies a larger share of the height.
  double reach = 0.12 * on.anatomy.height;
  const auto places_within = [&](double radius) {
    return std::count_if(torso.begin(), torso.end(), [&](Index v) {
      return glm::distance(on.place(v), middle) < 0.7 * radius;
    });
  };
  for (int grown = 0; grown < 8 && places_within(reach) < kSeenPlaces; ++grown) reach *= 1.25;
  if (places_within(reach) < kSeenPlaces) return;
  for (const Index v : torso) {
    const double far = glm::distance(on.place(v), middle) / reach;
    if (far >= 1.0) continue;
    const double share = 0.01 * percent * (1.0 - far * far);
    for (auto& [joint, weight] : on.weights[v]) weight *= 1.0 - share;
    on.weights[v][to] += share;
    on.fault.touched[v] = true;
  }
  on.blame(to_node);
  for (Index k = 0; k < on.chain.size(); ++k)
    if (on.joint(on.chain[k]) == own) on.blame_chain_around(k);
}

void bind_off(Patient& on, double degrees, Draw& draw) {
  const std::vector<Index> all = on.vertebrae();
  if (all.empty()) return;
  const Index k = all[draw.index(all.size())];
  const int node = on.chain[k];
  const std::uint16_t j = on.joint(node);
  const glm::dvec3 centre = on.place_of_node(node);
  const glm::dquat turn = validate::rotation(draw.direction() * validate::radians_from(degrees));
  // The joint was bound while it stood turned: it carries its vertices along by that turn.
  const glm::dmat4 off = glm::inverse(on.world_from_mesh) *
                         skin::rigid_matrix(turn, centre, centre) * on.world_from_mesh;
  on.body.joints[j].joint_from_mesh = on.body.joints[j].joint_from_mesh * off;
  for (Index v = 0; v < on.weights.size(); ++v) on.fault.touched[v] = on.weight(v, j) > 0.01;
  on.blame_chain_around(k);
}

void unweighted(Patient& on, double count, Draw& draw) {
  on.fault.file_scale.assign(on.weights.size(), 1.0);
  for (int i = 0; i < static_cast<int>(count); ++i) {
    const Index v = draw.index(on.weights.size());
    on.fault.file_scale[v] = 0.0;
    on.fault.touched[v] = true;
  }
  on.blame(on.chain[0]);
}

void sums(Patient& on, double percent, Draw& draw) {
  on.fault.file_scale.assign(on.weights.size(), 1.0);
  for (int i = 0; i < 20; ++i) {
    const Index v = draw.index(on.weights.size());
    on.fault.file_scale[v] = 1.0 + (draw.coin() ? 0.01 : -0.01) * percent;
    on.fault.touched[v] = true;
  }
  on.blame(on.chain[0]);
}

/// A seam around the torso: vertices there become two, whose weights differ.
void seam(Patient& on, double percent, Draw& draw) {
  const std::vector<Index> all = on.vertebrae();
  if (all.size() < 2) return;
  const Index i = draw.index(all.size() - 1);
  const std::uint16_t a = on.joint(on.chain[all[i]]), b = on.joint(on.chain[all[i + 1]]);
  const glm::dvec3 at = on.place_of_node(on.chain[all[i + 1]]);
  std::map<std::uint32_t, std::uint32_t> twin;
  const Index before = on.weights.size();
  std::vector<bool> above(before, false), below(before, false);
  std::vector<int> side_of(on.body.triangles.size(), 0);
  for (Index t = 0; t < on.body.triangles.size(); ++t) {
    const glm::uvec3& triangle = on.body.triangles[t];
    glm::dvec3 middle(0.0);
    bool torso = true;
    for (int k = 0; k < 3; ++k) {
      middle += on.place(triangle[k]) / 3.0;
      torso = torso && on.weight(triangle[k], a) + on.weight(triangle[k], b) > 0.5;
    }
    if (!torso) continue;
    side_of[t] = glm::dot(middle - at, on.anatomy.up) > 0.0 ? 1 : -1;
    for (int k = 0; k < 3; ++k) (side_of[t] > 0 ? above : below)[triangle[k]] = true;
  }
  for (Index v = 0; v < before; ++v) {
    if (!above[v] || !below[v]) continue;
    twin[static_cast<std::uint32_t>(v)] = static_cast<std::uint32_t>(on.body.vertex_count());
    on.body.bind_position.push_back(on.body.bind_position[v]);
    on.body.bind_normal.push_back(on.body.bind_normal[v]);
    on.body.influences.push_back(on.body.influences[v]);
    on.weights.push_back(on.weights[v]);
    on.fault.touched.push_back(true);
    on.fault.touched[v] = true;
    JointWeights& other = on.weights.back();
    const double take = std::min(0.01 * percent, 1.0);
    for (auto& [joint, weight] : other) weight *= 1.0 - take;
    other[on.weight(v, a) > on.weight(v, b) ? b : a] += take;
  }
  for (Index t = 0; t < on.body.triangles.size(); ++t)
    if (side_of[t] > 0)
      for (int k = 0; k < 3; ++k)
        if (const auto found = twin.find(on.body.triangles[t][k]); found != twin.end())
          on.body.triangles[t][k] = found->second;
  on.blame_chain_around(all[i]);
  on.blame_chain_around(all[i + 1]);
}

/// The left's weights copied to the right without swapping the sides' joints.
void mirrored_half(Patient& on, double percent, Draw& draw) {
  if (on.anatomy.left_arm.empty()) return;
  const bool to_right = draw.coin();
  const glm::dvec3 left = on.anatomy.left, centre = on.place_of_node(on.chain[0]);
  std::vector<std::pair<Index, double>> source;
  for (Index v = 0; v < on.weights.size(); ++v)
    if ((on.side(v) > 0.0) == to_right) source.emplace_back(v, 0.0);
  // Arms only, and the clavicles' surroundings: as much of the height as is asked for.
  const std::vector<JointWeights> before = on.weights;
  std::set<std::uint16_t> arm;
  const auto& from = to_right ? on.anatomy.left_arm : on.anatomy.right_arm;
  for (const int node : from)
    if (on.known_joint(node) >= 0) arm.insert(static_cast<std::uint16_t>(on.known_joint(node)));
  for (Index v = 0; v < on.weights.size(); ++v) {
    if ((on.side(v) > 0.0) == to_right) continue;
    const glm::dvec3 p = on.place(v);
    const glm::dvec3 reflected = p - 2.0 * glm::dot(p - centre, left) * left;
    Index best = source.front().first;
    double least = 1e300;
    for (const auto& [each, unused] : source)
      if (const double far = glm::distance(on.place(each), reflected); far < least) {
        least = far;
        best = each;
      }
    double on_arm = 0.0;
    for (const std::uint16_t j : arm)
      if (const auto found = before[best].find(j); found != before[best].end())
        on_arm += found->second;
    if (on_arm < 0.01) continue;
    for (auto& [joint, weight] : on.weights[v]) weight *= 1.0 - 0.01 * percent;
    for (const auto& [joint, weight] : before[best])
      on.weights[v][joint] += 0.01 * percent * weight;
    on.fault.touched[v] = true;
  }
  for (const auto* each : {&on.anatomy.left_arm, &on.anatomy.right_arm})
    for (const int node : *each) on.blame(node);
}

void clavicle(Patient& on, double percent, Draw& draw) {
  const auto& arm = draw.coin() ? on.anatomy.left_arm : on.anatomy.right_arm;
  const std::vector<Index> all = on.vertebrae();
  if (arm.empty() || all.size() < 2 || on.known_joint(arm.front()) < 0) return;
  const Index k = all[draw.index(all.size() - 1)];
  const std::uint16_t a = on.joint(arm.front()), b = on.joint(on.chain[k]);
  for (Index v = 0; v < on.weights.size(); ++v) on.move(v, a, b, 0.01 * percent);
  on.blame(arm.front());
  on.blame_chain_around(k);
  on.blame(on.chain.back());
}

int root_of(const Character& body, int node) {
  while (body.nodes[static_cast<Index>(node)].parent >= 0)
    node = body.nodes[static_cast<Index>(node)].parent;
  return node;
}

}  // namespace

const std::vector<WeightFaultKind>& weight_fault_kinds() {
  static const std::vector<WeightFaultKind> kinds = {
      {"wrong side", "% of an arm", {2, 5, 10, 20, 50}, 10},
      {"vertebra smeared", "% of its weight", {20, 50, 100}, 100},
      {"vertebra smeared on one side", "% of its weight", {20, 50, 100}, 50},
      {"half torso one up", "% of its weight", {20, 50, 100}, 50},
      {"vertebrae swapped", "joints", {2}, 2},
      {"rigid ring", "joints", {2}, 2},
      {"bleed to head", "%", {5, 10, 20, 30}, 10},
      {"bleed to root", "%", {5, 10, 20, 30}, 10},
      {"bleed to hand", "%", {5, 10, 20, 30}, 10},
      {"bleed to thigh", "%", {5, 10, 20, 30}, 10},
      {"bind off", "deg", {2, 5, 10}, 5},
      {"unweighted", "vertices", {1, 20}, 1},
      {"weight sums", "%", {0.5, 2, 10}, 2},
      {"seam", "% moved", {10, 30, 100}, 30},
      {"mirrored half", "%", {10, 50, 100}, 10},
      {"clavicle on a vertebra", "% of its weight", {10, 25, 50}, 50},
  };
  return kinds;
}

WeightFault plant(Character& body, const skin::Anatomy& anatomy, std::string_view kind, double size,
                  validate::Draw& draw) {
  WeightFault fault;
  fault.kind = kind;
  fault.size = size;
  for (const WeightFaultKind& each : weight_fault_kinds())
    if (each.name == kind) {
      fault.unit = each.unit;
      fault.plain = size >= each.plain_from;
    }
  Patient on(body, anatomy, fault);
  if (kind == "wrong side") wrong_side(on, size, draw);
  if (kind == "vertebra smeared") smear(on, size, draw, false);
  if (kind == "vertebra smeared on one side") smear(on, size, draw, true);
  if (kind == "half torso one up") half_torso(on, size, draw);
  if (kind == "vertebrae swapped") swapped(on, size, draw);
  if (kind == "rigid ring") rigid_ring(on, size, draw);
  if (kind == "bleed to head") bleed(on, size, draw, anatomy.head);
  if (kind == "bleed to root") bleed(on, size, draw, root_of(body, on.chain[0]));
  if (kind == "bleed to hand")
    bleed(on, size, draw, anatomy.left_arm.empty() ? -1 : anatomy.left_arm.back());
  if (kind == "bleed to thigh")
    bleed(on, size, draw, anatomy.right_leg.empty() ? -1 : anatomy.right_leg.front());
  if (kind == "bind off") bind_off(on, size, draw);
  if (kind == "unweighted") unweighted(on, size, draw);
  if (kind == "weight sums") sums(on, size, draw);
  if (kind == "seam") seam(on, size, draw);
  if (kind == "mirrored half") mirrored_half(on, size, draw);
  if (kind == "clavicle on a vertebra") clavicle(on, size, draw);
  on.finish();
  return fault;
}

}  // namespace backbend::battery
