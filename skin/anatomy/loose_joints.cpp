#include "skin/anatomy/loose_joints.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <map>
#include <memory>

#include "skin/anatomy/arm_attachment.h"
#include "skin/character/ancestor.h"
#include "skin/character/printable.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;

// A loose joint that stands this near to a driven one (share of the size) belongs to it.
constexpr double kTouches = 0.03;
// ... and this near to one of its name is that one's copy.
constexpr double kSameJoint = 0.001;
// Of a joint's weight that lies on places of another, to belong to it: less is a crumb.
constexpr double kShares = 0.02;

/// How much of each node's weight lies on places that another node moves, too.
class SharedWeight {
 public:
  explicit SharedWeight(const Character& character) {
    // Vertices at one place belong together whatever mesh they are of.
    std::vector<std::vector<std::pair<int, double>>> at(character.place_count);
    for (Index v = 0; v < character.place.size(); ++v)
      for (Index k = 0; k < kMaxInfluences; ++k) {
        const Influences& influences = character.influences[v];
        if (!(influences.weight[k] > 0.0f)) continue;
        const int node = character.joints[influences.joint[k]].node;
        auto& list = at[character.place[v]];
        const auto known =
            std::find_if(list.begin(), list.end(), [&](const auto& e) { return e.first == node; });
        if (known == list.end())
          list.emplace_back(node, influences.weight[k]);
        else
          known->second = std::max<double>(known->second, influences.weight[k]);
      }
    for (const auto& list : at)
      for (const auto& [a, weight_a] : list)
        for (const auto& [b, weight_b] : list)
          if (a != b) shared_[a][b] += std::min(weight_a, weight_b);
  }
  /// What each other node shares with this one.
  const std::map<int, double>& of(int node) const {
    static const std::map<int, double> none;
    const auto found = shared_.find(node);
    return found == shared_.end() ? none : found->second;
  }

 private:
  std::map<int, std::map<int, double>> shared_;
};

/// `Hips.001` and `Hips_1` are copies of `Hips`.
std::string without_number(const std::string& name) {
  Index end = name.size();
  while (end > 0 && name[end - 1] >= '0' && name[end - 1] <= '9') --end;
  if (end == name.size() || end < 2) return name;
  return name[end - 1] == '.' || name[end - 1] == '_' ? name.substr(0, end - 1) : name;
}

class LooseJoints {
 public:
  LooseJoints(const Character& character, const SkeletonShape& shape,
              const std::vector<bool>& driven, const std::vector<bool>& aside, int hip,
              std::vector<std::string>& reasons)
      : character_(character),
        shape_(shape),
        driven_(driven),
        aside_(aside),
        hip_(hip),
        reasons_(reasons),
        carried_(driven) {}

  std::vector<Follower> find() {
    Index before;
    do {  // what goes with one loose joint may lead another
      before = out_.size();
      for (Index n = 0; n < carried_.size(); ++n) {
        const int parent = character_.nodes[n].parent;
        if (!carried_[n] && parent >= 0) carried_[n] = carried_[static_cast<Index>(parent)];
        if (carried_[n] || !is_loose(n)) continue;
        if (const int original = copied_above(n); original >= 0)
          follow(n, original, ", whose copy it hangs from");
        else if (const int leader = touched(n); leader >= 0)
          follow(n, leader, ", which it touches");
        else if (const int other = shares_most(n); other >= 0)
          follow(n, other, ", which moves the same places");
      }
    } while (out_.size() > before);
    follow_copies();
    return std::move(out_);
  }

 private:
  std::string name(int node) const {
    return in_quotes(character_.nodes[static_cast<Index>(node)].name);
  }

  /// A joint with weight that the body does not hang from. Joints above it that move nothing may
  /// carry half a body's mechanism: each that moves something is placed by itself.
  bool is_loose(Index n) const {
    return shape_.is_joint[n] && shape_.weight[n] > 0.0 && !aside_[n] &&
           !is_ancestor(character_, static_cast<int>(n), hip_);
  }

  /// The driven joint that a mechanism's joint above this one is the copy of.
  int copied_above(Index n) const {
    for (int above = character_.nodes[n].parent; above >= 0;
         above = character_.nodes[static_cast<Index>(above)].parent)
      for (Index m = 0; m < driven_.size(); ++m)
        if (driven_[m] && is_copy(character_, above, static_cast<int>(m)))
          return static_cast<int>(m);
    return -1;
  }

  void follow(Index n, int leader, const char* why) {
    carried_[n] = true;
    out_.push_back({static_cast<int>(n), leader});
    reasons_.push_back("loose joint " + name(static_cast<int>(n)) + " goes with " + name(leader) +
                       why);
  }

  int touched(Index n) const {
    double nearest = kTouches * shape_.size;
    int leader = -1;
    for (Index m = 0; m < driven_.size(); ++m) {
      const double distance = glm::distance(shape_.position[m], shape_.position[n]);
      if (!driven_[m] || distance >= nearest) continue;
      nearest = distance;
      leader = static_cast<int>(m);
    }
    return leader;
  }

  int shares_most(Index n) {
    if (!(shape_.weight[n] > 0.0)) return -1;
    if (!shared_) shared_ = std::make_unique<SharedWeight>(character_);
    double most = kShares * shape_.weight[n];
    int leader = -1;
    for (const auto& [node, weight] : shared_->of(static_cast<int>(n))) {
      if (!carried_[static_cast<Index>(node)] || weight <= most) continue;
      most = weight;
      leader = node;
    }
    return leader;
  }

  /// Below a copy's hips, its other joints go with their own originals.
  void follow_copies() {
    if (out_.empty()) return;
    std::vector<bool> loose(driven_.size(), false);
    for (const Follower& one : out_) loose[static_cast<Index>(one.node)] = true;
    std::multimap<std::string, int> originals;
    for (Index m = 0; m < driven_.size(); ++m)
      if (driven_[m])
        originals.emplace(without_number(character_.nodes[m].name), static_cast<int>(m));
    for (Index n = 0; n < driven_.size(); ++n) {
      const int parent = character_.nodes[n].parent;
      if (driven_[n] || loose[n] || parent < 0 || !loose[static_cast<Index>(parent)]) continue;
      loose[n] = true;
      const auto [first, last] = originals.equal_range(without_number(character_.nodes[n].name));
      for (auto each = first; each != last; ++each) {
        if (glm::distance(shape_.position[static_cast<Index>(each->second)], shape_.position[n]) >
            kSameJoint * shape_.size)
          continue;
        follow(n, each->second, ", its original");
        break;
      }
    }
  }

  const Character& character_;
  const SkeletonShape& shape_;
  const std::vector<bool>& driven_;
  const std::vector<bool>& aside_;
  const int hip_;
  std::vector<std::string>& reasons_;
  std::vector<bool> carried_;
  std::unique_ptr<SharedWeight> shared_;
  std::vector<Follower> out_;
};

}  // namespace

std::vector<Follower> find_loose_joints(const Character& character, const SkeletonShape& shape,
                                        const std::vector<bool>& driven,
                                        const std::vector<bool>& aside, int hip,
                                        std::vector<std::string>& reasons) {
  return LooseJoints(character, shape, driven, aside, hip, reasons).find();
}

}  // namespace backbend::skin
