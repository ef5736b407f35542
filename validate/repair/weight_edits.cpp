#include "validate/repair/weight_edits.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <set>
#include <utility>

#include "skin/character/closest_point.h"
#include "skin/character/matrix_facts.h"
#include "skin/character/printable.h"
#include "skin/weights/mirror_weights.h"
#include "skin/weights/weight_inpaint.h"
#include "validate/metrics/surface/proxy_weights.h"
#include "validate/metrics/surface/spine_coordinate.h"
#include "validate/metrics/surface/torso.h"
#include "validate/stage/stage.h"

namespace backbend::validate {

using Index = std::size_t;
using skin::JointShares;

namespace {

constexpr double kReached = 0.002;  // of a vertex's weight: where a fault fades to nothing
constexpr double kRises = 0.02;     // ... and how far a fading weight may rise again
constexpr double kUnlike = 0.05;    // between a vertex and its mirror image: the same fault goes on
constexpr double kUnmoved = 0.002;  // smaller changes are not made
constexpr double kSymmetric = 0.02;      // between the rim and its mirror image, in the median
constexpr double kImagesHealthy = 0.02;  // of a region's images, at most, may be in it themselves
constexpr double kPairBelongs = 0.6;  // of the weight that goes over, where the partner is at home
constexpr double kPairKept = 0.05;    // of a vertex's weight, for a joint to be at home

/// A part of the surface whose weights are to be found, and what is still known of them.
struct Region {
  std::vector<skin::InpaintNode> nodes;
  std::vector<std::set<int>> banned;  // of each: skeleton nodes that must not weigh there
  std::vector<JointShares> removed;   // of each: what was taken away
  std::map<std::uint32_t, Index> number;

  Index add(std::uint32_t node) {
    const auto [entry, is_new] = number.try_emplace(node, nodes.size());
    if (is_new) {
      nodes.push_back({node, {}, 0.0});
      banned.emplace_back();
      removed.emplace_back();
    }
    return entry->second;
  }
};

double sum_of(const JointShares& shares) {
  double sum = 0.0;
  for (const auto& [joint, share] : shares) sum += share;
  return sum;
}

JointShares whole(JointShares shares) {
  const double sum = sum_of(shares);
  if (sum < 1e-6) return {};
  for (auto& [joint, share] : shares) share /= sum;
  return shares;
}

}  // namespace

struct WeightEdits::Parts {
  Parts(const skin::Character& character, const skin::Anatomy& anatomy,
        const WritableWeights& writable)
      : character(character),
        anatomy(anatomy),
        writable(writable),
        rest(skin::rest_mesh(character)),
        graph(skin::weight_graph(character, rest.position)),
        mirror(skin::surface_mirror(character, anatomy, graph.position)),
        image(skin::mirrored_nodes(character, mirror)) {
    for (const std::uint32_t v : graph.vertex)
      weights.push_back(skin::shares_of(character.influences[v]));
  }

  int skeleton_node(std::uint16_t joint) const { return character.joints[joint].node; }
  std::string name(int node) const {
    return skin::in_quotes(character.nodes[static_cast<Index>(node)].name);
  }
  double weight_of(std::uint32_t n, int node) const {
    double sum = 0.0;
    for (const auto& [joint, share] : weights[n])
      if (skeleton_node(joint) == node) sum += share;
    return sum;
  }
  glm::dvec3 at(int node) const {
    return skin::origin(character.nodes[static_cast<Index>(node)].world_from_node);
  }
  double aside(const glm::dvec3& p) const { return glm::dot(p - mirror.middle, mirror.left); }

  /// What the file can hold of a vertex's weights: joints of its skin, as many as it has places
  /// for. Zeros where nothing is left.
  skin::Influences fitted(Index vertex, const JointShares& shares) const {
    const auto group = static_cast<Index>(writable.group[vertex]);
    JointShares fit;
    for (const auto& [joint, share] : shares) {
      const auto& joints = writable.joints[group];
      if (std::binary_search(joints.begin(), joints.end(), joint)) {
        fit[joint] += share;
        continue;
      }
      // The same bone bound anew in another skin.
      const auto twin = std::find_if(joints.begin(), joints.end(), [&](std::uint16_t other) {
        return skeleton_node(other) == skeleton_node(joint);
      });
      if (twin != joints.end()) fit[*twin] += share;
    }
    return skin::influences_of(fit, writable.most[group]);
  }

  /// The edit that gives nodes these weights; nothing where it changes nothing.
  std::optional<WeightEdit> edit(const std::string& how,
                                 const std::map<std::uint32_t, JointShares>& changed) const {
    WeightEdit out{how, character.influences};
    Index count = 0;
    for (Index v = 0; v < character.vertex_count(); ++v) {
      const auto found = changed.find(graph.node[v]);
      if (found == changed.end() || found->second.empty() || writable.group[v] < 0) continue;
      const skin::Influences fit = fitted(v, found->second);
      if (!(fit.weight[0] > 0.0f)) continue;
      if (skin::share_moved(skin::shares_of(fit), skin::shares_of(character.influences[v])) <
          kUnmoved)
        continue;
      out.influences[v] = fit;
      ++count;
    }
    if (count == 0) return std::nullopt;
    out.what += " " + skin::plural(count, "vertex", "vertices");
    return out;
  }

  JointShares allowed(JointShares shares, const std::set<int>& banned) const {
    std::erase_if(shares,
                  [&](const auto& each) { return banned.count(skeleton_node(each.first)); });
    return whole(std::move(shares));
  }

  std::map<std::uint32_t, JointShares> inpainted(const Region& region) const {
    std::map<std::uint32_t, JointShares> out;
    const auto solved = skin::inpaint_weights(graph, weights, region.nodes);
    for (Index i = 0; i < solved.size(); ++i) {
      JointShares fit = allowed(solved[i], region.banned[i]);
      if (fit.empty()) fit = region.nodes[i].kept;
      if (!fit.empty()) out[region.nodes[i].node] = std::move(fit);
    }
    return out;
  }

  /// What the healthy other side has, where the body around the region is symmetric and the other
  /// side is not at fault, too.
  std::optional<std::map<std::uint32_t, JointShares>> mirrored(const Region& region) {
    if (mirrored_.empty()) {
      mirrored_ = skin::mirrored_weights(character, mirror, graph, weights);
      mirrored_node_ = skin::mirrored_graph_nodes(mirror, graph);
    }
    std::map<std::uint32_t, JointShares> out;
    Index sick = 0;
    std::vector<double> apart;
    for (Index i = 0; i < region.nodes.size(); ++i) {
      const std::uint32_t n = region.nodes[i].node;
      const JointShares fit = allowed(mirrored_[n], region.banned[i]);
      if (fit.empty()) return std::nullopt;
      if (mirrored_node_[n] < graph.node_count() && region.number.count(mirrored_node_[n]) > 0)
        ++sick;
      for (const std::uint32_t m : graph.neighbours(n))
        if (region.number.count(m) == 0)
          apart.push_back(mirrored_[m].empty() ? 1.0 : skin::share_moved(mirrored_[m], weights[m]));
      out[n] = fit;
    }
    if (static_cast<double>(sick) > kImagesHealthy * static_cast<double>(region.nodes.size()))
      return std::nullopt;
    if (apart.empty()) return std::nullopt;
    std::nth_element(apart.begin(), apart.begin() + static_cast<std::ptrdiff_t>(apart.size() / 2),
                     apart.end());
    if (apart[apart.size() / 2] > kSymmetric) return std::nullopt;
    return out;
  }

  /// What was taken from a joint goes to its partner on the other side, where that is at home.
  std::optional<std::map<std::uint32_t, JointShares>> paired(const Region& region) const {
    std::map<std::uint32_t, JointShares> out;
    double moved = 0.0, at_home = 0.0;
    for (Index i = 0; i < region.nodes.size(); ++i) {
      const skin::InpaintNode& each = region.nodes[i];
      JointShares shares;
      const double left = 1.0 - sum_of(region.removed[i]);
      for (const auto& [joint, share] : each.kept) shares[joint] += left * share;
      for (const auto& [joint, share] : region.removed[i]) {
        const int partner = image[static_cast<Index>(skeleton_node(joint))];
        const auto found = std::ranges::find(character.joints, partner, &skin::SkinJoint::node);
        if (partner == skeleton_node(joint) || found == character.joints.end()) return std::nullopt;
        const auto to = static_cast<std::uint16_t>(found - character.joints.begin());
        const auto known = each.kept.find(to);
        moved += share;
        if ((known != each.kept.end() && known->second >= kPairKept) ||
            nearest_bone(graph.position[each.node]) == partner)
          at_home += share;
        shares[to] += share;
      }
      out[each.node] = whole(std::move(shares));
    }
    if (at_home < kPairBelongs * moved) return std::nullopt;
    return out;
  }

  struct Bone {
    int node;
    glm::dvec3 from, to;
  };
  /// From each skeleton node with weight to its children with weight.
  const std::vector<Bone>& bones() const {
    if (!bones_.empty()) return bones_;
    std::set<int> weighted;
    for (const skin::SkinJoint& joint : character.joints) weighted.insert(joint.node);
    for (const int node : weighted) {
      bool has_child = false;
      for (Index n = 0; n < character.nodes.size(); ++n)
        if (character.nodes[n].parent == node && weighted.count(static_cast<int>(n)) > 0) {
          bones_.push_back({node, at(node), at(static_cast<int>(n))});
          has_child = true;
        }
      if (!has_child) bones_.push_back({node, at(node), at(node)});
    }
    return bones_;
  }
  int nearest_bone(const glm::dvec3& p) const {
    int best = -1;
    double least = 1e300;
    for (const Bone& bone : bones())
      if (const double far = skin::distance_to_segment(p, bone.from, bone.to); far < least) {
        least = far;
        best = bone.node;
      }
    return best;
  }

  /// The nodes at which a joint's weight is the fault's: those named, and down from them while it
  /// fades.
  std::vector<std::uint32_t> reach_of(const skin::WeightFault& fault, bool other_side) const {
    std::map<std::uint32_t, double> level;
    std::vector<std::uint32_t> pending;
    const auto place = [&](std::uint32_t n, double low) {
      if (level.emplace(n, low).second) pending.push_back(n);
    };
    std::set<std::uint32_t> places;
    for (const std::uint32_t v : fault.vertices) places.insert(character.place[v]);
    for (Index v = 0; v < character.vertex_count(); ++v)
      if (places.count(character.place[v]) > 0 && weight_of(graph.node[v], fault.node) > 0.0)
        place(graph.node[v], weight_of(graph.node[v], fault.node));
    const double own_side = aside(at(fault.node));
    while (!pending.empty()) {
      const std::uint32_t n = pending.back();
      pending.pop_back();
      const double low = level.at(n);
      for (const std::uint32_t m : graph.neighbours(n)) {
        const double w = weight_of(m, fault.node);
        if (w < kReached || w > low + kRises) continue;
        if (other_side && own_side * aside(graph.position[m]) >= 0.0) continue;
        place(m, std::min(low, w));
      }
    }
    std::vector<std::uint32_t> out;
    for (const auto& [n, low] : level) out.push_back(n);
    return out;
  }

  /// The region of several faults: at each node their joints are taken off.
  Region without(const std::vector<skin::WeightFault>& faults, bool other_side) const {
    Region region;
    for (const skin::WeightFault& fault : faults)
      for (const std::uint32_t n : reach_of(fault, other_side))
        region.banned[region.add(n)].insert(fault.node);
    for (Index i = 0; i < region.nodes.size(); ++i) {
      skin::InpaintNode& each = region.nodes[i];
      for (const auto& [joint, share] : weights[each.node]) {
        const bool gone = region.banned[i].count(skeleton_node(joint)) > 0;
        (gone ? region.removed[i] : each.kept)[joint] = share;
      }
      each.confidence = std::clamp(sum_of(each.kept), 0.0, 1.0);
      each.kept = whole(std::move(each.kept));
    }
    return region;
  }

  /// Clean weights of the torso: the spine's share of each vertex spread between the two joints
  /// that it stands between. Empty where the character can have none.
  const std::vector<skin::Influences>& proxy() {
    if (!proxy_made_) {
      proxy_made_ = true;
      const skin::SpineDriver driver(character, anatomy);
      if (auto made = proxy_weights(character, anatomy, driver, rest)) proxy_ = std::move(*made);
      fractions_ = driver.joint_fractions();
      const std::vector<std::uint8_t> torso = torso_mask(character, anatomy, rest.position);
      const std::vector<float> share = spine_shares(character, anatomy);
      const RestMesh mesh{rest.position,
                          rest.normal,
                          character.triangles,
                          character.place,
                          character.place_count,
                          torso,
                          share,
                          driver.rest_chain().joint};
      coordinate_ = spine_coordinate(mesh, SpineLine(driver.rest_chain().joint));
    }
    return proxy_;
  }

  /// How much of a change a vertex takes whose place along the spine is in a stretch, or up to
  /// `fade` beyond it: 1 inside, 0 outside.
  double inside(Index vertex, double from, double to, double fade) const {
    const double s = coordinate_[character.place[vertex]];
    if (!std::isfinite(s)) return 0.0;
    const double beyond = std::max({from - s, s - to, 0.0});
    if (beyond >= fade) return 0.0;
    const double t = 1.0 - beyond / fade;
    return t * t * (3.0 - 2.0 * t);
  }

  std::optional<WeightEdit> spread(double from, double to, double fade, double share) {
    if (proxy().empty()) return std::nullopt;
    std::map<std::uint32_t, JointShares> changed;
    for (std::uint32_t n = 0; n < graph.node_count(); ++n) {
      const Index v = graph.vertex[n];
      const double take = share * inside(v, from, to, fade);
      if (!(take > 0.0)) continue;
      JointShares mixed;
      for (const auto& [joint, weight] : weights[n]) mixed[joint] += (1.0 - take) * weight;
      for (const auto& [joint, weight] : skin::shares_of(proxy_[v])) mixed[joint] += take * weight;
      changed[n] = std::move(mixed);
    }
    return edit("spread the spine's share (" + skin::number_text(100.0 * share, 3) + " %) at",
                changed);
  }

  /// Weights drawn towards a smooth continuation of those around; `confidence`: in what they are.
  std::optional<WeightEdit> smoothed(double from, double to, double fade, double confidence) {
    proxy();  // makes the coordinate
    Region region;
    for (std::uint32_t n = 0; n < graph.node_count(); ++n) {
      const double take = inside(graph.vertex[n], from, to, fade);
      if (!(take > 0.0)) continue;
      const Index i = region.add(n);
      region.nodes[i].kept = weights[n];
      region.nodes[i].confidence = 1.0 - (1.0 - confidence) * take;
    }
    if (region.nodes.empty()) return std::nullopt;
    return edit("smoothed (" + skin::number_text(100.0 * confidence, 1) + " % kept) at",
                inpainted(region));
  }

  /// How much further from the bones of its joints an edit puts weight, over the vertices that it
  /// changes: negative where weight comes nearer to where it belongs.
  double remoteness(const WeightEdit& edit) const {
    double sum = 0.0;
    const auto add = [&](Index v, double sign) {
      const skin::Influences& influences =
          sign > 0.0 ? edit.influences[v] : character.influences[v];
      for (Index k = 0; k < skin::kMaxInfluences && influences.weight[k] > 0.0f; ++k)
        sum += sign * influences.weight[k] *
               distance_to_bone(skeleton_node(influences.joint[k]), graph.position[graph.node[v]]);
    };
    for (Index v = 0; v < character.vertex_count(); ++v) {
      if (edit.influences[v].joint == character.influences[v].joint &&
          edit.influences[v].weight == character.influences[v].weight)
        continue;
      add(v, 1.0);
      add(v, -1.0);
    }
    return sum;
  }
  double distance_to_bone(int node, const glm::dvec3& p) const {
    double least = 1e300;
    for (const Bone& bone : bones())
      if (bone.node == node)
        least = std::min(least, skin::distance_to_segment(p, bone.from, bone.to));
    return least < 1e300 ? least : glm::distance(p, at(node));
  }

  const skin::Character& character;
  const skin::Anatomy& anatomy;
  const WritableWeights& writable;
  skin::PosedMesh rest;
  skin::WeightGraph graph;
  skin::Mirror mirror;
  std::vector<int> image;
  std::vector<JointShares> weights;  // of each node

  mutable std::vector<Bone> bones_;
  std::vector<JointShares> mirrored_;
  std::vector<std::uint32_t> mirrored_node_;
  bool proxy_made_ = false;
  std::vector<skin::Influences> proxy_;
  std::vector<float> coordinate_;  // of each place
  std::vector<double> fractions_;  // of each driven spine joint
};

namespace {

void add(std::vector<WeightEdit>& edits, std::optional<WeightEdit> edit) {
  if (edit) edits.push_back(std::move(*edit));
}

}  // namespace

WeightEdits::WeightEdits(const skin::Character& character, const skin::Anatomy& anatomy,
                         const WritableWeights& writable)
    : parts_(std::make_unique<Parts>(character, anatomy, writable)) {}
WeightEdits::~WeightEdits() = default;

std::vector<WeightEdit> WeightEdits::unknown(const std::vector<std::uint32_t>& vertices) {
  Region region;
  for (const std::uint32_t v : vertices) region.add(parts_->graph.node[v]);
  std::vector<WeightEdit> out;
  if (!region.nodes.empty()) add(out, parts_->edit("inpainted", parts_->inpainted(region)));
  return out;
}

std::vector<WeightEdit> WeightEdits::foreign(const std::vector<skin::WeightFault>& faults,
                                             bool other_side) {
  const Region region = parts_->without(faults, other_side);
  std::vector<WeightEdit> out;
  if (region.nodes.empty()) return out;
  std::string names;
  std::set<int> nodes;
  for (const skin::WeightFault& fault : faults)
    if (nodes.insert(fault.node).second)
      names += (names.empty() ? "" : ", ") + parts_->name(fault.node);
  if (auto mirrored = parts_->mirrored(region))
    add(out, parts_->edit("without " + names + ", from the other side:", *mirrored));
  if (other_side)
    if (auto paired = parts_->paired(region))
      add(out, parts_->edit("from " + names + " to the partner on this side:", *paired));
  add(out, parts_->edit("without " + names + ", inpainted", parts_->inpainted(region)));
  return out;
}

std::vector<WeightEdit> WeightEdits::seams(const std::vector<skin::WeightFault>& faults) {
  const skin::Character& character = parts_->character;
  std::set<std::uint32_t> places;
  for (const skin::WeightFault& fault : faults)
    for (const std::uint32_t v : fault.vertices) places.insert(character.place[v]);
  // With the copies joined, what the surface on both sides makes of the seam.
  skin::Character joined = character;
  std::map<std::uint32_t, std::vector<std::uint32_t>> nodes_of;  // of each place
  std::map<std::uint32_t, std::uint32_t> first;
  for (std::uint32_t v = 0; v < character.vertex_count(); ++v) {
    if (places.count(character.place[v]) == 0) continue;
    auto& known = nodes_of[character.place[v]];
    const std::uint32_t n = parts_->graph.node[v];
    if (std::find(known.begin(), known.end(), n) == known.end()) known.push_back(n);
    joined.influences[v] = character.influences[first.emplace(character.place[v], v).first->second];
  }
  const Parts whole_surface(joined, parts_->anatomy, parts_->writable);
  Region region;
  for (const auto& [place, v] : first) region.add(whole_surface.graph.node[v]);
  const auto smooth = whole_surface.inpainted(region);
  std::map<std::uint32_t, JointShares> copied, inpainted;
  for (const auto& [place, nodes] : nodes_of) {
    const auto found = smooth.find(whole_surface.graph.node[first.at(place)]);
    if (found == smooth.end()) continue;
    const std::uint32_t best =
        *std::min_element(nodes.begin(), nodes.end(), [&](std::uint32_t a, std::uint32_t b) {
          return skin::share_moved(parts_->weights[a], found->second) <
                 skin::share_moved(parts_->weights[b], found->second);
        });
    for (const std::uint32_t n : nodes) {
      if (n != best) copied[n] = parts_->weights[best];
      inpainted[n] = found->second;
    }
  }
  std::vector<WeightEdit> out;
  add(out, parts_->edit("one side of the seam copied to the other at", copied));
  add(out, parts_->edit("the seam inpainted at", inpainted));
  return out;
}

std::vector<WeightEdit> WeightEdits::asymmetry(const std::vector<skin::WeightFault>& faults) {
  const skin::Character& character = parts_->character;
  const auto mirrored =
      skin::mirrored_weights(character, parts_->mirror, parts_->graph, parts_->weights);
  const auto image = skin::mirrored_graph_nodes(parts_->mirror, parts_->graph);
  std::set<std::uint32_t> places;
  for (const skin::WeightFault& fault : faults)
    for (const std::uint32_t v : fault.vertices) places.insert(character.place[v]);
  std::set<std::uint32_t> region;
  for (Index v = 0; v < character.vertex_count(); ++v) {
    const std::uint32_t n = parts_->graph.node[v];
    if (places.count(character.place[v]) == 0) continue;
    region.insert(n);
    if (image[n] < parts_->graph.node_count()) region.insert(image[n]);
  }
  // On from the places that were named: what the check leaves out (forearms, hands) differs, too.
  std::vector<std::uint32_t> pending(region.begin(), region.end());
  while (!pending.empty()) {
    const std::uint32_t n = pending.back();
    pending.pop_back();
    for (const std::uint32_t m : parts_->graph.neighbours(n))
      if (!mirrored[m].empty() && skin::share_moved(mirrored[m], parts_->weights[m]) > kUnlike &&
          region.insert(m).second)
        pending.push_back(m);
  }
  std::vector<WeightEdit> out;
  for (const bool to_left : {true, false}) {
    std::map<std::uint32_t, JointShares> changed;
    for (const std::uint32_t n : region)
      if ((parts_->aside(parts_->graph.position[n]) > 0.0) == to_left && !mirrored[n].empty())
        changed[n] = mirrored[n];
    add(out, parts_->edit(to_left ? "the right side's weights mirrored to the left at"
                                  : "the left side's weights mirrored to the right at",
                          changed));
  }
  // Which side is the healthy one: the one that leaves weight nearer to its bones.
  std::stable_sort(out.begin(), out.end(), [&](const WeightEdit& a, const WeightEdit& b) {
    return parts_->remoteness(a) < parts_->remoteness(b);
  });
  return out;
}

std::vector<WeightEdit> WeightEdits::order(const std::vector<skin::WeightFault>& faults) {
  std::vector<WeightEdit> out;
  for (const skin::WeightFault& fault : faults) {
    if (fault.other < 0 || fault.other == fault.node) continue;
    std::map<std::uint32_t, JointShares> changed;
    for (std::uint32_t n = 0; n < parts_->graph.node_count(); ++n) {
      JointShares swapped;
      bool has = false;
      for (const auto& [joint, share] : parts_->weights[n]) {
        const int node = parts_->skeleton_node(joint);
        const int to = node == fault.node ? fault.other : node == fault.other ? fault.node : -1;
        if (to < 0) {
          swapped[joint] += share;
          continue;
        }
        const auto found = std::ranges::find(parts_->character.joints, to, &skin::SkinJoint::node);
        if (found == parts_->character.joints.end()) continue;
        swapped[static_cast<std::uint16_t>(found - parts_->character.joints.begin())] += share;
        has = true;
      }
      if (has) changed[n] = std::move(swapped);
    }
    add(out, parts_->edit("weights of " + parts_->name(fault.node) + " and " +
                              parts_->name(fault.other) + " swapped at",
                          changed));
  }
  parts_->proxy();
  const auto& fraction = parts_->fractions_;
  double from = 2.0, to = -1.0;
  for (const skin::WeightFault& fault : faults)
    for (Index k = 0; k < fraction.size(); ++k)
      if (parts_->anatomy.spine[k] == fault.node || parts_->anatomy.spine[k] == fault.other) {
        from = std::min(from, fraction[k == 0 ? 0 : k - 1]);
        to = std::max(to, fraction[std::min(k + 1, fraction.size() - 1)]);
      }
  if (from < to) {
    const double fade = 0.5 / static_cast<double>(fraction.size() - 1);
    for (const double share : {1.0, 0.5}) add(out, parts_->spread(from, to, fade, share));
    for (WeightEdit& edit : stretch(from, to)) out.push_back(std::move(edit));
  }
  return out;
}

std::vector<WeightEdit> WeightEdits::borders(const std::vector<skin::WeightFault>& faults) {
  parts_->proxy();
  const auto& fraction = parts_->fractions_;
  const std::vector<int>& spine = parts_->anatomy.spine;
  std::vector<WeightEdit> out;
  for (const skin::WeightFault& fault : faults) {
    const auto k = static_cast<Index>(std::ranges::find(spine, fault.other) - spine.begin());
    if (k == 0 || k >= fraction.size()) continue;
    const double below = fraction[k] - fraction[k - 1],
                 above = k + 1 < fraction.size() ? fraction[k + 1] - fraction[k] : below;
    for (const double bones : {0.25, 0.5})
      for (WeightEdit& edit : stretch(fraction[k] - bones * below, fraction[k] + bones * above))
        out.push_back(std::move(edit));
  }
  return out;
}

std::vector<WeightEdit> WeightEdits::stretch(double from, double to) {
  parts_->proxy();
  const auto& fraction = parts_->fractions_;
  std::vector<WeightEdit> out;
  if (fraction.size() < 2) return out;
  const double fade = 0.5 / static_cast<double>(fraction.size() - 1);
  for (const double confidence : {0.02, 0.002, 0.0})
    add(out, parts_->smoothed(from, to, fade, confidence));
  for (const double share : {0.25, 0.5, 1.0}) add(out, parts_->spread(from, to, fade, share));
  return out;
}

}  // namespace backbend::validate
