#include "skin/anatomy/spine_finder.h"

#include <algorithm>
#include <functional>
#include <glm/geometric.hpp>
#include <optional>

#include "skin/anatomy/anatomy_hints.h"
#include "skin/character/ancestor.h"
#include "skin/character/printable.h"

namespace backbend::skin {
namespace {

// Of the character's size: arms reach a third and more, breasts, ears and pouches less than this.
constexpr double kLimbReach = 0.12;
constexpr double kNamedLimbReach = 0.02;  // a dinosaur's leg against its length
constexpr double kOneJointReach = 0.04;   // of the surface, as thick as it is

// Hair, trunks and antlers hang from heads too, but none makes a third of its owner.
constexpr double kBodyReach = 0.35;

// Hips that hang so far (of the size) from the way to the head end a spine; nearer ones are a
// pelvis beside its centre of mass.
constexpr double kBuiltFromChest = 0.05;

using Index = std::size_t;

bool is_limb_name(BodyPart part) {
  return part == BodyPart::leg || part == BodyPart::arm || part == BodyPart::clavicle ||
         part == BodyPart::fin;
}

LimbPair::Kind kind_of(const NameFacts& name) {
  switch (name.part) {
    case BodyPart::leg:
      return name.front ? LimbPair::Kind::arm : LimbPair::Kind::leg;
    case BodyPart::arm:
    case BodyPart::clavicle:
    case BodyPart::fin:
      if (name.back) return LimbPair::Kind::leg;
      return name.part == BodyPart::fin && !name.front ? LimbPair::Kind::unknown
                                                       : LimbPair::Kind::arm;
    default:
      return LimbPair::Kind::unknown;
  }
}

std::string quoted_name(const Character& character, int node) {
  return in_quotes(character.nodes[static_cast<Index>(node)].name);
}

/// Joint children that could carry the body on: no controls, no end markers, not half of a pair.
std::vector<int> central_children(const SkeletonShape& shape, int node) {
  std::vector<int> out;
  for (const int child : shape.children[static_cast<Index>(node)]) {
    const NameFacts& name = shape.name[static_cast<Index>(child)];
    const bool paired = std::any_of(
        shape.pairs.begin(), shape.pairs.end(),
        [&](const MirrorPair& pair) { return pair.left == child || pair.right == child; });
    if (shape.is_joint[static_cast<Index>(child)] &&
        !shape.is_mechanism[static_cast<Index>(child)] && !paired && !name.control && !name.end &&
        name.side == Side::none)
      out.push_back(child);
  }
  return out;
}

std::vector<int> path_from_root(const Character& character, int node) {
  int root = node;
  while (character.nodes[static_cast<Index>(root)].parent >= 0)
    root = character.nodes[static_cast<Index>(root)].parent;
  return path_down(character, root, node);
}

/// How far from each node the surface reaches that goes with it and with the joints below it.
std::vector<double> surface_reach(const Character& character, const SkeletonShape& shape) {
  std::vector<double> out(character.nodes.size(), 0.0);
  for (Index v = 0; v < shape.rest.size(); ++v)
    for (int node = character.joints[character.influences[v].joint[0]].node; node >= 0;
         node = character.nodes[static_cast<Index>(node)].parent) {
      const auto n = static_cast<Index>(node);
      out[n] = std::max(out[n], glm::distance(shape.position[n], glm::dvec3(shape.rest[v])));
    }
  return out;
}

/// Whether two joints are limbs by their names and by how far what they move reaches, whatever
/// joints are below them.
bool is_limb_of_one_joint(const SkeletonShape& shape, const std::vector<double>& reach,
                          const MirrorPair& pair) {
  const NameFacts& name = shape.name[static_cast<Index>(pair.left)];
  if (!pair.named || !is_limb_name(name.part) || name.control || name.end || name.helper)
    return false;
  // A clavicle alone is an arm only where it moves one.
  const double least = (name.part == BodyPart::clavicle ? kLimbReach : kOneJointReach) * shape.size;
  return std::min(reach[static_cast<Index>(pair.left)], reach[static_cast<Index>(pair.right)]) >=
         least;
}

/// The deepest node above (or at) both.
int common_ancestor(const Character& character, int a, int b) {
  const auto path_a = path_from_root(character, a), path_b = path_from_root(character, b);
  int common = -1;
  for (Index k = 0; k < std::min(path_a.size(), path_b.size()) && path_a[k] == path_b[k]; ++k)
    common = path_a[k];
  return common;
}

/// From the uppermost limbs on: the heaviest branch between them, followed while it does not fork.
int head_by_topology(const SkeletonShape& shape, int attach) {
  auto branches = central_children(shape, attach);
  if (branches.empty()) return -1;
  int node = *std::max_element(branches.begin(), branches.end(), [&](int a, int b) {
    return shape.weight_below[static_cast<Index>(a)] < shape.weight_below[static_cast<Index>(b)];
  });
  for (auto next = central_children(shape, node);
       next.size() == 1 && shape.children[static_cast<Index>(node)].size() == 1;
       next = central_children(shape, node))
    node = next.front();
  return node;
}

/// The joint that a node stands for: itself, or the heaviest of its children that stand where it
/// does, as a mesh does below its object; -1 for none.
int joint_of_node(const SkeletonShape& shape, Index node) {
  if (shape.is_joint[node]) return static_cast<int>(node);
  int best = -1;
  for (const int child : shape.children[node]) {
    const auto c = static_cast<Index>(child);
    if (!(shape.weight[c] > 0.0) ||
        glm::distance(shape.position[c], shape.position[node]) > 0.001 * shape.size)
      continue;
    if (best < 0 || shape.weight[c] > shape.weight[static_cast<Index>(best)]) best = child;
  }
  return best;
}

/// What is called a head, the heaviest with what hangs from it first: the first of a chain of heads
/// carries the others.
std::vector<int> heads_by_name(const SkeletonShape& shape) {
  std::vector<int> heads;
  for (Index n = 0; n < shape.name.size(); ++n) {
    const NameFacts& name = shape.name[n];
    if (name.part != BodyPart::head || name.side != Side::none || name.end || name.control ||
        shape.is_mechanism[n])
      continue;
    if (const int joint = joint_of_node(shape, n); joint >= 0) heads.push_back(joint);
  }
  std::ranges::stable_sort(heads, std::greater(),
                           [&](int head) { return shape.weight_below[static_cast<Index>(head)]; });
  return heads;
}

/// The last joint that is called a neck, or its heaviest child, which carries the head then; -1 for
/// none.
int head_by_neck(const SkeletonShape& shape) {
  int neck = -1;
  for (Index n = 0; n < shape.name.size(); ++n) {
    const NameFacts& name = shape.name[n];
    if (name.part == BodyPart::neck && name.side == Side::none && !name.end && !name.control &&
        !shape.is_mechanism[n] && shape.is_joint[n])
      neck = static_cast<int>(n);  // parents stand before their children
  }
  if (neck < 0) return -1;
  int head = neck;
  double most = 0.0;
  for (const int child : shape.children[static_cast<Index>(neck)]) {
    const auto c = static_cast<Index>(child);
    if (!shape.is_joint[c] || shape.name[c].end || shape.is_mechanism[c] ||
        shape.weight_below[c] <= most)
      continue;
    most = shape.weight_below[c];
    head = child;
  }
  return head;
}

/// The joint that everything called a part of a face hangs from, and nothing called a part of the
/// body; -1 for none.
int head_by_face(const Character& character, const SkeletonShape& shape) {
  int head = -1;
  for (Index n = 0; n < shape.name.size(); ++n) {
    const NameFacts& name = shape.name[n];
    if (name.part != BodyPart::face || name.control || shape.is_mechanism[n] ||
        !shape.is_joint[n] || !(shape.weight_below[n] > 0.0))
      continue;
    int carrier = character.nodes[n].parent;
    while (carrier >= 0 && (!shape.is_joint[static_cast<Index>(carrier)] ||
                            shape.name[static_cast<Index>(carrier)].part == BodyPart::face))
      carrier = character.nodes[static_cast<Index>(carrier)].parent;
    if (carrier < 0 || (head >= 0 && carrier != head)) return -1;
    head = carrier;
  }
  for (Index n = 0; n < shape.name.size(); ++n) {
    const BodyPart part = shape.name[n].part;
    if (part != BodyPart::none && part != BodyPart::face && part != BodyPart::head &&
        shape.weight_below[n] > 0.0 && static_cast<int>(n) != head &&
        is_ancestor(character, head, static_cast<int>(n)))
      return -1;
  }
  return head;
}

class EndFinder {
 public:
  EndFinder(const Character& character, const SkeletonShape& shape,
            const std::vector<LimbPair>& limbs)
      : character_(character), shape_(shape), limbs_(limbs) {}

  SpineEnds find() {
    if (find_single_chain()) return std::move(out_);
    // The heaviest that is called a head, unless it hangs beside the body, as a skull may.
    std::optional<SpineEnds> first;
    for (const int head : heads_by_name(shape_)) {
      out_ = {};
      out_.head = head;
      const auto h = static_cast<Index>(head);
      const bool own = shape_.name[h].part == BodyPart::head;
      say("head: " + quoted_name(character_, own ? head : character_.nodes[h].parent) +
          " by its name");
      find_hip();
      if (out_.hip >= 0) return std::move(out_);
      if (!first) first = out_;
    }
    if (first) return std::move(*first);
    find_head();
    if (out_.head >= 0) find_hip();
    return std::move(out_);
  }

 private:
  void say(const std::string& reason) { out_.reasons.push_back(reason); }
  bool is_mechanism(int node) const { return shape_.is_mechanism[static_cast<Index>(node)]; }
  /// A joint, of which neither its own name nor the others' say that it is a control.
  bool is_of_body(int node) const {
    return shape_.is_joint[static_cast<Index>(node)] &&
           !shape_.name[static_cast<Index>(node)].control && !is_mechanism(node);
  }

  /// A skeleton without a fork has one reading: all of it.
  bool find_single_chain() {
    std::vector<int> joints;
    for (Index n = 0; n < shape_.is_joint.size(); ++n)
      if (is_of_body(static_cast<int>(n))) joints.push_back(static_cast<int>(n));
    for (Index k = 1; k < joints.size(); ++k)
      if (!is_ancestor(character_, joints[k - 1], joints[k])) return false;
    if (joints.size() < 2) return false;
    // Without names a few joints in a row are a hinge as well as a spine: a chest's lid, a door.
    constexpr Index kLeastWithoutNames = 4;
    if (joints.size() < kLeastWithoutNames && std::ranges::none_of(joints, [&](int joint) {
          return shape_.name[static_cast<Index>(joint)].part != BodyPart::none;
        }))
      return false;
    out_.hip = joints.front();
    out_.head = joints.back();
    const auto is_head = [&](int node) {
      return shape_.name[static_cast<Index>(node)].part == BodyPart::head;
    };
    if (is_head(out_.hip)) {
      std::swap(out_.hip, out_.head);
    } else if (const int head = head_by_name(shape_); head >= 0) {
      out_.head = head;  // what lies beyond is a jaw, a tongue, a hat
    }
    say("spine: the skeleton is one chain of " + std::to_string(joints.size()) + " joints");
    return true;
  }

  void find_head() {
    // Two pairs of limbs on one line fix the body between them; the head lies beyond the upper.
    int upper = -1, lower = -1;
    for (const LimbPair& limb : limbs_) {
      if (upper < 0 || is_ancestor(character_, upper, limb.pair.parent)) upper = limb.pair.parent;
      if (lower < 0 || is_ancestor(character_, limb.pair.parent, lower)) lower = limb.pair.parent;
    }
    if (limbs_.size() == 2 && upper == lower) {
      find_head_of_parted_body();
      if (out_.head >= 0) return;
    }
    if (limbs_.size() < 2 || upper == lower || !is_ancestor(character_, lower, upper)) {
      out_.head = head_by_neck(shape_);
      if (out_.head >= 0) {
        say("head: " + quoted_name(character_, out_.head) + ", by the name of the neck");
        return;
      }
      out_.head = head_by_face(character_, shape_);
      if (out_.head >= 0) {
        say("head: " + quoted_name(character_, out_.head) + ", which carries the face");
        return;
      }
      out_.doubt = "no joint is named head, and fewer than two pairs of limbs to infer it from";
      return;
    }
    out_.head = head_by_topology(shape_, upper);
    if (is_head_with_ears(upper, out_.head)) {
      out_.head = upper;
      say("head: " + quoted_name(character_, upper) +
          ", which a pair hangs from above two pairs of limbs");
      return;
    }
    if (out_.head < 0) {
      out_.doubt = "nothing hangs between the upper limbs on " + quoted_name(character_, upper);
      return;
    }
    say("head: " + quoted_name(character_, out_.head) + ", the branch between the limbs of " +
        quoted_name(character_, upper));
  }

  /// Whether the pair on the uppermost joint that limbs hang from are ears: no name calls them
  /// limbs, two pairs more hang from joints below it, and beyond it is nothing, or a jaw alone
  /// (`beyond`; -1 for none) between ears that stand up.
  bool is_head_with_ears(int upper, int beyond) const {
    const bool is_jaw = beyond >= 0 && character_.nodes[static_cast<Index>(beyond)].parent == upper;
    if (beyond >= 0 && !is_jaw) return false;
    std::vector<int> below;
    for (const LimbPair& limb : limbs_) {
      const int parent = limb.pair.parent;
      if (parent == upper && is_limb_name(shape_.name[static_cast<Index>(limb.pair.left)].part))
        return false;
      if (parent == upper && is_jaw && !stands_up(limb.pair.left)) return false;
      if (parent != upper && is_ancestor(character_, parent, upper) &&
          std::ranges::find(below, parent) == below.end())
        below.push_back(parent);
    }
    return below.size() >= 2;
  }

  /// Whether a branch rises as far as it reaches aside.
  bool stands_up(int root) const {
    const auto r = static_cast<Index>(root);
    const glm::dvec3 way =
        shape_.position[static_cast<Index>(shape_.farthest[r])] - shape_.position[r];
    return way.y > 0.0 && way.y * way.y >= way.x * way.x;
  }

  /// Pelvis and ribcage hang beside each other from one joint: the head is on the branch that goes
  /// on between its limbs, where only one does.
  void find_head_of_parted_body() {
    const int a = limbs_[0].pair.parent, b = limbs_[1].pair.parent;
    const int common = common_ancestor(character_, a, b);
    if (a == b || common < 0 || !shape_.is_joint[static_cast<Index>(common)]) return;
    const int head_a = head_by_topology(shape_, a), head_b = head_by_topology(shape_, b);
    if ((head_a < 0) == (head_b < 0)) return;
    out_.head = std::max(head_a, head_b);
    say("head: " + quoted_name(character_, out_.head) + ", the branch between the limbs of " +
        quoted_name(character_, head_a < 0 ? b : a));
  }

  /// A skeleton that is built from the chest: hips that are called so hang from the way to the
  /// head, a good piece of the body away. Where the legs hang from that way themselves, what is
  /// called hips carries a tail.
  int hip_below_chest(const std::vector<int>& path_to_head) const {
    const int legs = leg_parent();
    for (Index n = 0; n < shape_.name.size(); ++n) {
      const int node = static_cast<int>(n);
      const NameFacts& name = shape_.name[n];
      if (name.part != BodyPart::hip || name.end || !is_of_body(node)) continue;
      const int common = common_ancestor(character_, node, out_.head);
      if (common < 0 || common == node || common == out_.head || common == legs) continue;
      const auto c = static_cast<Index>(common);
      if (!shape_.is_joint[c] || is_scene_root(shape_, common) ||
          std::find(path_to_head.begin(), path_to_head.end(), common) == path_to_head.end())
        continue;
      if (glm::distance(shape_.position[n], shape_.position[c]) > kBuiltFromChest * shape_.size)
        return node;
    }
    return -1;
  }

  void find_hip() {
    const auto path = path_from_root(character_, out_.head);
    for (const int node : path) {
      const NameFacts& name = shape_.name[static_cast<Index>(node)];
      if (name.part == BodyPart::hip && !name.control && !is_mechanism(node) && node != out_.head) {
        out_.hip = node;
        return say("hips: " + quoted_name(character_, node) + " by its name");
      }
    }
    if (const int hip = hip_below_chest(path); hip >= 0) {
      out_.hip = hip;
      return say("hips: " + quoted_name(character_, hip) +
                 " by its name; the skeleton is built from the chest");
    }
    const int legs = leg_parent();
    const int meet = legs < 0 ? -1 : common_ancestor(character_, legs, out_.head);
    const int start = meet < 0 ? path.front() : meet;
    const auto begin = std::find(path.begin(), path.end(), start);
    const auto found = std::find_if(begin, path.end(), [&](int node) {
      return is_of_body(node) && !is_scene_root(shape_, node);
    });
    if (found == path.end() || *found == out_.head) {
      if (find_body_below_head()) return;
      out_.doubt = "no joint between the root and the head " + quoted_name(character_, out_.head) +
                   " could be the hips";
      return;
    }
    out_.hip = *found;
    const char* why = legs < 0          ? ", the first joint of the body on the way to the head"
                      : *found == start ? ", where the legs meet the way to the head"
                                        : ", the first joint inside the body above the legs";
    say("hips: " + quoted_name(character_, out_.hip) + why);
  }

  /// A snake that is built from its head: the body is the long branch that hangs from it.
  bool find_body_below_head() {
    const auto head = static_cast<Index>(out_.head);
    const auto path = path_down(character_, out_.head, shape_.farthest[head]);
    const bool central = std::all_of(path.begin(), path.end(), [&](int node) {
      return shape_.name[static_cast<Index>(node)].side == Side::none;
    });
    if (path.size() < 3 || !central || shape_.reach[head] < kBodyReach * shape_.size) return false;
    out_.hip = path.back();
    say("hips: " + quoted_name(character_, out_.hip) +
        ", the far end of the body that hangs from the head");
    return true;
  }

  /// Limbs without telling names that hang from no joint on the way to the head, farther from the
  /// head than those that do: the legs of a body whose pelvis and belly hang beside each other.
  /// Their parent; -1 for none.
  int parted_leg_parent() const {
    const auto head = shape_.position[static_cast<Index>(out_.head)];
    const auto distance = [&](const LimbPair& limb) {
      return glm::distance(head, 0.5 * (shape_.position[static_cast<Index>(limb.pair.left)] +
                                        shape_.position[static_cast<Index>(limb.pair.right)]));
    };
    int parted = -1;
    double beside_spine = 0.0, apart = 0.0;
    for (const LimbPair& limb : limbs_) {
      if (limb.kind == LimbPair::Kind::leg) return -1;
      if (limb.kind == LimbPair::Kind::arm) continue;
      if (shape_.is_joint[static_cast<Index>(limb.pair.parent)] &&
          is_ancestor(character_, limb.pair.parent, out_.head)) {
        beside_spine = std::max(beside_spine, distance(limb));
      } else if (distance(limb) > apart &&
                 shape_.weight_below[static_cast<Index>(limb.pair.left)] > 0.0) {
        apart = distance(limb);
        parted = limb.pair.parent;
      }
    }
    return apart > beside_spine && beside_spine > 0.0 ? parted : -1;
  }

  /// Where the legs hang: those by name, else the lowest limbs on the tree.
  int leg_parent() const {
    if (const int parted = parted_leg_parent(); parted >= 0) return parted;
    int lowest = -1;
    bool by_name = false;
    for (const LimbPair& limb : limbs_) {
      const bool named = limb.kind == LimbPair::Kind::leg;
      if (limb.kind == LimbPair::Kind::arm || (by_name && !named)) continue;
      // Legs on a root of their own say nothing of where on the body they start.
      if (common_ancestor(character_, limb.pair.parent, out_.head) < 0) continue;
      if (lowest < 0 || (named && !by_name) || is_ancestor(character_, limb.pair.parent, lowest))
        lowest = limb.pair.parent;
      by_name |= named;
    }
    return lowest;
  }

  const Character& character_;
  const SkeletonShape& shape_;
  const std::vector<LimbPair>& limbs_;
  SpineEnds out_;
};

}  // namespace

std::vector<LimbPair> find_limbs(const Character& character, const SkeletonShape& shape, int head) {
  std::vector<LimbPair> out;
  const auto add = [&](const MirrorPair& pair, LimbPair::Kind kind) {
    if (head >= 0 &&
        (is_ancestor(character, head, pair.parent) || is_ancestor(character, pair.left, head) ||
         is_ancestor(character, pair.right, head)))
      return;  // on the head, or the neck itself
    const bool on_a_limb = std::any_of(out.begin(), out.end(), [&](const LimbPair& limb) {
      return is_ancestor(character, limb.pair.left, pair.parent) ||
             is_ancestor(character, limb.pair.right, pair.parent);
    });
    if (!on_a_limb) out.push_back({pair, kind});
  };
  for (const MirrorPair& pair : shape.pairs) {
    const NameFacts& name = shape.name[static_cast<Index>(pair.left)];
    const bool by_name = pair.named && is_limb_name(name.part);
    const double least = (by_name ? kNamedLimbReach : kLimbReach) * shape.size;
    const bool other = name.control || name.end || name.part == BodyPart::face ||
                       name.part == BodyPart::breast || name.part == BodyPart::finger;
    if (!other && std::min(shape.reach[static_cast<Index>(pair.left)],
                           shape.reach[static_cast<Index>(pair.right)]) >= least)
      add(pair, pair.named ? kind_of(name) : LimbPair::Kind::unknown);
  }
  // Box figures have arms and legs of one joint each.
  std::vector<double> reach;
  for (const auto kind : {LimbPair::Kind::arm, LimbPair::Kind::leg}) {
    if (std::ranges::any_of(out, [&](const LimbPair& limb) { return limb.kind == kind; })) continue;
    if (reach.empty()) reach = surface_reach(character, shape);
    for (const MirrorPair& pair : shape.pairs)
      if (kind_of(shape.name[static_cast<Index>(pair.left)]) == kind &&
          is_limb_of_one_joint(shape, reach, pair))
        add(pair, kind);
  }
  // A mechanism's limbs beside those that move the surface are none.
  const auto moves = [&](const LimbPair& limb) {
    return shape.weight_below[static_cast<Index>(limb.pair.left)] > 0.0 ||
           shape.weight_below[static_cast<Index>(limb.pair.right)] > 0.0;
  };
  for (const auto kind : {LimbPair::Kind::arm, LimbPair::Kind::leg})
    if (std::any_of(out.begin(), out.end(),
                    [&](const LimbPair& limb) { return limb.kind == kind && moves(limb); }))
      std::erase_if(out, [&](const LimbPair& limb) { return limb.kind == kind && !moves(limb); });
  return out;
}

int head_by_name(const SkeletonShape& shape) {
  const std::vector<int> heads = heads_by_name(shape);
  return heads.empty() ? -1 : heads.front();
}

SpineEnds find_spine_ends(const Character& character, const SkeletonShape& shape,
                          const std::vector<LimbPair>& limbs) {
  return EndFinder(character, shape, limbs).find();
}

bool is_scene_root(const SkeletonShape& shape, int node) {
  const auto n = static_cast<Index>(node);
  if (shape.weight[n] > 0.0) return false;
  const double slack = 0.02 * shape.size;
  const glm::dvec3 p = shape.position[n];
  const bool inside = glm::all(glm::greaterThanEqual(p, shape.low - slack)) &&
                      glm::all(glm::lessThanEqual(p, shape.high + slack));
  return !inside || glm::length(p) <= 0.01 * shape.size;
}

}  // namespace backbend::skin
