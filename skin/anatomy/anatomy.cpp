#include "skin/anatomy/anatomy.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <iterator>
#include <limits>
#include <map>
#include <set>

#include "skin/anatomy/anatomy_hints.h"
#include "skin/anatomy/arm_attachment.h"
#include "skin/anatomy/chain_arc.h"
#include "skin/anatomy/facing.h"
#include "skin/anatomy/import_checks.h"
#include "skin/anatomy/loose_joints.h"
#include "skin/anatomy/other_figures.h"
#include "skin/anatomy/rig_templates.h"
#include "skin/anatomy/skeleton_shape.h"
#include "skin/anatomy/spine_finder.h"
#include "skin/character/ancestor.h"
#include "skin/character/matrix_facts.h"
#include "skin/character/printable.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;

// Limbs whose roots are this near (of the size) stand in the same place.
constexpr double kSameLimb = 0.03;

class Finder {
 public:
  Finder(const Character& character, const AnatomyHints& hints)
      : character_(character),
        hints_(hints),
        shape_(measure_skeleton(character)),
        aside_(character.nodes.size(), false) {}

  Anatomy find() {
    limbs_ = find_limbs(character_, shape_, head_by_name(shape_));
    find_spine();
    set_other_figures_aside();
    find_arms_and_legs();
    prefer_the_chain_with_limbs();
    find_tail();
    find_facing(character_, shape_, hints_, out_);
    name_sides();
    find_neck();
    find_chest();
    find_followers();
    set_scene_aside();
    measure();
    doubt_import();
    return std::move(out_);
  }

 private:
  void say(const std::string& reason) { out_.reasons.push_back(reason); }
  std::string name(int node) const {
    return in_quotes(character_.nodes[static_cast<Index>(node)].name);
  }

  [[noreturn]] void refuse(const std::string& doubt) const {
    std::string line = character_.file_name + ": uncertain spine: " + doubt;
    for (const std::string& reason : out_.reasons) line += "; " + reason;
    throw CharacterError(line + "; specify --hip and --chest, or --spine");
  }

  /// Positions of the first `count` joints of a chain.
  std::vector<glm::dvec3> points(const std::vector<int>& chain, Index count) const {
    std::vector<glm::dvec3> out;
    for (Index k = 0; k < count; ++k) out.push_back(shape_.position[static_cast<Index>(chain[k])]);
    return out;
  }
  double length(const std::vector<int>& chain) const {
    return arc_length(points(chain, chain.size()));
  }

  void find_spine() {
    SpineEnds ends = find_spine_ends(character_, shape_, limbs_);
    if (ends.head >= 0)  // ears and horns, where no name told the head before
      std::erase_if(limbs_, [&](const LimbPair& limb) {
        return is_ancestor(character_, ends.head, limb.pair.parent);
      });
    const HintedSpine hinted = resolve_spine_hints(character_, hints_);
    if (!hinted.chain.empty()) {
      out_.spine = hinted.chain;
      out_.head = out_.spine.back();
      return say("spine: as given");
    }
    if (const auto named = template_of_names(hinted)) {
      ends = {named->hip, named->head, {}, ""};
      template_neck_ = named->neck;
      ends.reasons.push_back("names: as " + std::string(named->title) + " has them: hips " +
                             name(named->hip) + ", base of the neck " + name(named->neck) +
                             ", head " + name(named->head));
    }
    if (hinted.hip >= 0) ends.hip = hinted.hip;
    if (hinted.chest >= 0 && !is_ancestor(character_, hinted.chest, ends.head))
      ends.head = hinted.chest;  // nothing is known beyond it
    out_.reasons = std::move(ends.reasons);
    if (ends.hip < 0 || ends.head < 0) refuse(ends.doubt);
    if (hinted.hip >= 0) say("hips: " + name(ends.hip) + " as given");
    if (hinted.chest >= 0) say("chest: " + name(hinted.chest) + " as given");
    // Downwards in most skeletons, upwards where they are built from the head, up and down again
    // where they are built from the chest.
    const auto path = central_path(ends.hip, ends.head);
    if (path.size() < 2)
      refuse("the head " + name(ends.head) + " does not hang from the hips " + name(ends.hip));
    if (hinted.chest >= 0 && std::find(path.begin() + 1, path.end(), hinted.chest) == path.end())
      refuse("the chest " + name(hinted.chest) + " is not above the hips " + name(ends.hip));
    for (const int node : path)
      if (node == path.front() || node == path.back() || shape_.is_joint[static_cast<Index>(node)])
        out_.spine.push_back(node);
    out_.head = out_.spine.back();
    if (hinted.hip < 0 && hinted.chest < 0) refuse_scattered_names();
  }

  /// path_between(), empty where it would have to lead over a limb.
  std::vector<int> central_path(int hip, int head) const {
    auto path = path_between(character_, hip, head);
    if (is_ancestor(character_, hip, head) || is_ancestor(character_, head, hip)) return path;
    for (const int node : path) {
      const bool paired = std::any_of(
          shape_.pairs.begin(), shape_.pairs.end(),
          [&](const MirrorPair& pair) { return pair.left == node || pair.right == node; });
      if (paired || shape_.name[static_cast<Index>(node)].side != Side::none) return {};
    }
    return path;
  }

  /// The naming convention of the joints: the one that was given, else one that fits by itself.
  std::optional<TemplateMatch> template_of_names(const HintedSpine& hinted) const {
    if (!hints_.rig_template.empty()) return require_template(character_, hints_.rig_template);
    if (hinted.hip >= 0 || hinted.chest >= 0) return std::nullopt;
    return find_template(character_);
  }

  /// A skeleton whose hierarchy was lost: joints that are called spine and neck stand beside the
  /// way to the head, and none on it; or one, where the head hangs from the hips themselves.
  void refuse_scattered_names() const {
    const auto is_back = [&](Index n) {
      const NameFacts& facts = shape_.name[n];
      return shape_.is_joint[n] && facts.side == Side::none && !facts.control && !facts.end &&
             (facts.part == BodyPart::spine || facts.part == BodyPart::neck);
    };
    const bool is_bare = out_.spine.size() == 2;
    const auto at = [&](int node) {
      return origin(character_.nodes[static_cast<Index>(node)].world_from_node);
    };
    const glm::dvec3 hips = at(out_.spine.front()), way = at(out_.head) - hips;
    int beside = -1, count = 0;
    for (Index n = 0; n < shape_.name.size(); ++n) {
      if (!is_back(n)) continue;
      const int node = static_cast<int>(n);
      if (on_spine(node)) {
        if (is_bare) continue;  // the hips may be called spine
        return;
      }
      const double along = glm::dot(at(node) - hips, way) / glm::dot(way, way);
      if (is_bare && !(along > 0.1 && along < 1.0)) continue;  // a tail's, a hat's
      beside = node;
      ++count;
    }
    if (count >= (is_bare ? 1 : 2))
      refuse("joints such as " + name(beside) + " do not stand between the hips " +
             name(out_.spine.front()) + " and the head " + name(out_.head) +
             ": was the hierarchy lost in the export?");
  }

  /// The uppermost node above `node` (or itself) that the hips do not hang from; -1 where `node`
  /// stands above the hips.
  int branch_beside_hips(int node) const {
    int branch = -1;
    for (; node >= 0 && !is_ancestor(character_, node, out_.spine.front());
         node = character_.nodes[static_cast<Index>(node)].parent)
      branch = node;
    return branch;
  }

  /// A file may hold several figures, a rider and a horse. A branch beside the spine with two pairs
  /// of limbs at two joints (a dragon's wings may share one) is one of its own where the spine's
  /// has two pairs as well: its limbs, its tail and its joints belong to nothing that this spine
  /// moves.
  void set_other_figures_aside() {
    const auto is_own = [&](const LimbPair& limb) {
      const int parent = limb.pair.parent;
      return !shape_.is_joint[static_cast<Index>(parent)] ||
             is_ancestor(character_, parent, out_.spine.front()) ||
             std::ranges::any_of(out_.spine,
                                 [&](int node) { return is_ancestor(character_, node, parent); });
    };
    std::vector<LimbPair> own;
    std::ranges::copy_if(limbs_, std::back_inserter(own), is_own);
    if (own.size() < 2) return;
    // A second skeleton in the same place is the same figure's, as exporters write for each mesh.
    const auto is_apart = [&](const LimbPair& limb) {
      return std::ranges::none_of(own, [&](const LimbPair& other) {
        return glm::distance(shape_.position[static_cast<Index>(limb.pair.left)],
                             shape_.position[static_cast<Index>(other.pair.left)]) <
               kSameLimb * shape_.size;
      });
    };
    std::map<int, std::set<int>> shoulders_of;  // of each branch beside the spine
    for (const LimbPair& limb : limbs_)
      if (!is_own(limb) && is_apart(limb) &&
          shape_.weight_below[static_cast<Index>(limb.pair.left)] > 0.0)
        shoulders_of[branch_beside_hips(limb.pair.parent)].insert(limb.pair.parent);
    for (const auto& [branch, shoulders] : shoulders_of) {
      if (shoulders.size() < 2) continue;
      out_.other_figures.push_back(branch);
      say("another figure: " + name(branch) + " has limbs of its own, and is left out");
    }
    aside_ = nodes_of_other_figures(character_, out_);
    std::erase_if(limbs_, [&](const LimbPair& limb) { return is_other_figure(limb.pair.parent); });
    if (out_.other_figures.empty()) return;
    std::vector<bool> left_out = vertices_of_other_figures(character_, out_);
    for (Index v = 0; v < left_out.size(); ++v) left_out[v] = left_out[v] || shape_.is_scene[v];
    measure_box(shape_, left_out);
  }

  /// Scenery that follows no joint, such as a floor.
  void set_scene_aside() {
    for (Index n = 0; n < shape_.is_scenery.size(); ++n) {
      const int node = static_cast<int>(n);
      const bool goes_along = std::ranges::any_of(
          out_.followers, [&](const Follower& each) { return each.node == node; });
      if (!shape_.is_scenery[n] || goes_along || is_other_figure(node)) continue;
      out_.other_figures.push_back(node);
      say(name(node) +
          " is left out as scenery: no joint is above it, and it reaches out of the body's box");
    }
  }

  bool is_other_figure(int node) const { return aside_[static_cast<Index>(node)]; }

  /// From a limb's root outwards to the hand or foot: where it forks into fingers, or ends.
  std::vector<int> limb_chain(int root) const {
    std::vector<int> chain{root};
    double length = 0.0;
    for (;;) {
      const auto tip = static_cast<Index>(chain.back());
      if (shape_.name[tip].part == BodyPart::hand) break;
      std::vector<int> next;
      for (const int child : shape_.children[tip]) {
        const NameFacts& child_name = shape_.name[static_cast<Index>(child)];
        if (shape_.is_joint[static_cast<Index>(child)] && !child_name.end && !child_name.control &&
            !child_name.helper && child_name.part != BodyPart::finger)
          next.push_back(child);
      }
      if (next.empty()) break;
      // Where some branches move the surface, the others are a mechanism's.
      const auto moves = [&](int child) {
        return shape_.weight_below[static_cast<Index>(child)] > 0.0;
      };
      if (std::any_of(next.begin(), next.end(), moves))
        std::erase_if(next, [&](int child) { return !moves(child); });
      const auto extent = [&](int node) {
        return shape_.reach[static_cast<Index>(node)] +
               glm::distance(shape_.position[tip], shape_.position[static_cast<Index>(node)]);
      };
      std::stable_sort(next.begin(), next.end(),
                       [&](int a, int b) { return extent(a) > extent(b); });
      // A fork into branches of like length is a hand; a stub beside the limb is a helper.
      if (next.size() > 1 &&
          (extent(next[1]) > 0.5 * extent(next[0]) || extent(next[0]) < 0.25 * length))
        break;
      length += glm::distance(shape_.position[tip], shape_.position[static_cast<Index>(next[0])]);
      chain.push_back(next[0]);
    }
    return chain;
  }

  double limb_reach(const LimbPair& limb) const {
    return shape_.reach[static_cast<Index>(limb.pair.left)];
  }

  /// Along the spine: where the limbs' common parent stands on it, else where they pass closest.
  double limb_arc(const LimbPair& limb) const {
    const auto on_spine = std::find(out_.spine.begin(), out_.spine.end(), limb.pair.parent);
    if (on_spine != out_.spine.end())
      return arc_length(points(out_.spine, static_cast<Index>(on_spine - out_.spine.begin()) + 1));
    return nearest_arc(points(out_.spine, out_.spine.size()),
                       0.5 * (shape_.position[static_cast<Index>(limb.pair.left)] +
                              shape_.position[static_cast<Index>(limb.pair.right)]));
  }

  void find_arms_and_legs() {
    // Names first: of several pairs called arms, the one that reaches farthest.
    const LimbPair* arms = nullptr;
    const LimbPair* legs = nullptr;
    std::vector<const LimbPair*> unknown;
    for (const LimbPair& limb : limbs_) {
      if (limb.kind == LimbPair::Kind::unknown) {
        unknown.push_back(&limb);
        continue;
      }
      const LimbPair*& slot = limb.kind == LimbPair::Kind::arm ? arms : legs;
      if (!slot || limb_reach(limb) > limb_reach(*slot)) slot = &limb;
    }
    // Limbs without telling names are sorted along the spine: legs lowest, arms highest.
    std::stable_sort(unknown.begin(), unknown.end(), [&](const LimbPair* a, const LimbPair* b) {
      return limb_arc(*a) < limb_arc(*b);
    });
    const double middle = 0.5 * length(out_.spine);
    if (unknown.size() == 1 && !arms && !legs) {
      (limb_arc(*unknown.front()) > middle ? arms : legs) = unknown.front();
    } else if (!unknown.empty()) {
      if (!legs) legs = unknown.front();
      if (!arms && unknown.back() != legs) arms = unknown.back();
    }
    arm_pair_ = arms ? arms->pair : MirrorPair{};
    leg_pair_ = legs ? legs->pair : MirrorPair{};
    if (arms) {
      out_.left_arm = limb_chain(arms->pair.left);
      out_.right_arm = limb_chain(arms->pair.right);
      find_clavicles_beside_the_arms();
    }
    if (legs) {
      out_.left_leg = limb_chain(legs->pair.left);
      out_.right_leg = limb_chain(legs->pair.right);
    }
    const auto hinted = resolve_arm_hints(character_, hints_);
    if (!hinted.left.empty()) out_.left_arm = hinted.left;
    if (!hinted.right.empty()) out_.right_arm = hinted.right;
    arms_given_ = !hinted.left.empty() || !hinted.right.empty();
  }

  /// Clavicles that the arms do not hang from, as exports of a rig's deforming joints alone have
  /// them: both roots of their own, or both on a mechanism.
  void find_clavicles_beside_the_arms() {
    const int left = clavicle_beside(out_.left_arm.front(), Side::left);
    const int right = clavicle_beside(out_.right_arm.front(), Side::right);
    if (left < 0 || right < 0) return;
    for (auto [chain, clavicle] :
         {std::pair(&out_.left_arm, left), std::pair(&out_.right_arm, right)}) {
      const bool replaces =
          shape_.name[static_cast<Index>(chain->front())].part == BodyPart::clavicle;
      if (replaces)
        chain->front() = clavicle;
      else
        chain->insert(chain->begin(), clavicle);
    }
  }

  /// The joint with most weight that is called clavicle beside an arm's root that is not, or that
  /// is and moves nothing itself; -1 for none.
  int clavicle_beside(int root, Side side) const {
    const NameFacts& own = shape_.name[static_cast<Index>(root)];
    const bool idle = shape_.weight[static_cast<Index>(root)] <= 0.0;
    const bool mechanism = own.part == BodyPart::clavicle && idle;
    if (!mechanism && own.part != BodyPart::arm) return -1;
    int best = -1;
    for (Index n = 0; n < shape_.name.size(); ++n) {
      const int node = static_cast<int>(n);
      const NameFacts& facts = shape_.name[n];
      if (facts.part != BodyPart::clavicle || facts.side != side || facts.control || facts.helper ||
          facts.front || facts.back || !(shape_.weight[n] > 0.0) || node == root ||
          is_ancestor(character_, node, root) || is_other_figure(node))
        continue;
      // Below the root there is the rest of the arm; a mechanism carries its clavicle in its place.
      if (mechanism ? !is_copy(character_, root, node) : is_ancestor(character_, root, node))
        continue;
      if (best < 0 || shape_.weight[n] > shape_.weight[static_cast<Index>(best)]) best = node;
    }
    return best;
  }

  bool hangs_from_spine(const MirrorPair& pair) const {
    return std::any_of(out_.spine.begin() + 1, out_.spine.end(),
                       [&](int node) { return is_ancestor(character_, node, pair.parent); });
  }

  /// A fish: limbs hang from the chain behind the hips, none from the way to the head. Its body,
  /// and what bends, is that chain.
  void prefer_the_chain_with_limbs() {
    if (!hints_.chest.empty() || !hints_.spine.empty() || arm_pair_.parent < 0) return;
    if (hangs_from_spine(arm_pair_)) return;
    const int hip = out_.spine.front();
    if (arm_pair_.parent == hip || !is_ancestor(character_, hip, arm_pair_.parent)) return;
    auto path = path_down(character_, hip, arm_pair_.parent);
    for (auto next = forward_children(path.back()); next.size() == 1;
         next = forward_children(path.back()))
      path.push_back(next.front());
    if (length(path) <= 2.0 * length(out_.spine)) return;
    say("spine: the chain from " + name(hip) + " to " + name(path.back()) +
        ", which carries the limbs; the way to the head " + name(out_.head) + " carries none");
    out_.spine = std::move(path);
    body_behind_hips_ = true;
  }

  /// Joint children without a side, controls left out.
  std::vector<int> forward_children(int node) const {
    std::vector<int> out;
    for (const int child : shape_.children[static_cast<Index>(node)]) {
      const NameFacts& facts = shape_.name[static_cast<Index>(child)];
      if (shape_.is_joint[static_cast<Index>(child)] && facts.side == Side::none &&
          !facts.control && child != arm_pair_.left && child != arm_pair_.right)
        out.push_back(child);
    }
    return out;
  }

  void find_tail() {
    if (body_behind_hips_) return;
    int root = -1;
    for (Index n = 0; n < shape_.name.size() && root < 0; ++n)
      if (shape_.name[n].part == BodyPart::tail && shape_.is_joint[n] && !shape_.name[n].control &&
          !is_other_figure(static_cast<int>(n)))
        root = static_cast<int>(n);
    if (root < 0 || on_spine(root)) return;
    // What stands between the body and the first joint called tail belongs to it.
    for (int above = character_.nodes[static_cast<Index>(root)].parent;
         above >= 0 && !is_ancestor(character_, above, out_.spine.front()) && !on_spine(above) &&
         shape_.is_joint[static_cast<Index>(above)];
         above = character_.nodes[static_cast<Index>(above)].parent)
      root = above;
    out_.tail = limb_chain(root);
  }

  bool on_spine(int node) const {
    return std::find(out_.spine.begin(), out_.spine.end(), node) != out_.spine.end();
  }

  /// Pairs without left or right in their names are resolved once left is known.
  void name_sides() {
    const auto straighten = [&](const MirrorPair& pair, std::vector<int>& left,
                                std::vector<int>& right) {
      if (pair.parent < 0 || pair.named || left.empty() || right.empty()) return;
      const glm::dvec3 across = shape_.position[static_cast<Index>(left.back())] -
                                shape_.position[static_cast<Index>(right.back())];
      if (glm::dot(across, out_.left) < 0.0) std::swap(left, right);
    };
    if (!arms_given_) straighten(arm_pair_, out_.left_arm, out_.right_arm);
    straighten(leg_pair_, out_.left_leg, out_.right_leg);
    if (out_.left_arm.empty())
      say("arms: none");
    else if (arms_given_)
      say("arms: as given");
    else
      say("arms: " + name(out_.left_arm.front()) + " and " + name(out_.right_arm.front()) +
          (arm_pair_.named ? " by their names" : ", mirrored branches high on the spine"));
  }

  /// The joint where the neck starts: by name, else the first above the arms, else the end.
  void find_neck() {
    const auto last = out_.spine.size() - 1;
    out_.neck_index = last;
    neck_why_ = ", the end of the chain";
    const auto found = [&](Index index, const char* why) {
      out_.neck_index = index;
      neck_why_ = why;
    };
    if (body_behind_hips_ || last == 1) return;
    for (Index k = 1; k <= last; ++k) {
      // A common rig's names are borrowed by others that have more joints in the neck.
      if (out_.spine[k] == template_neck_) return found(k, ", the base of the neck");
      if (shape_.name[static_cast<Index>(out_.spine[k])].part == BodyPart::neck)
        return found(k, ", the first joint called neck");
    }
    if (out_.left_arm.empty() || out_.right_arm.empty()) return;
    const LimbPair arms{{character_.nodes[static_cast<Index>(out_.left_arm.front())].parent,
                         out_.left_arm.front(), out_.right_arm.front(), false},
                        LimbPair::Kind::arm};
    const double arms_at = limb_arc(arms);
    for (Index k = 1; k <= last; ++k)
      if (arc_length(points(out_.spine, k + 1)) > arms_at + 1e-6 * shape_.size)
        return found(k, ", the first joint above the arms");
  }

  /// Why the arms' attachment makes `index` of the spine the chest.
  std::string why_chest(const ArmAttachment& arms, Index index) const {
    const auto spine_name = [&](int k) { return name(out_.spine[static_cast<Index>(k)]); };
    const int root = out_.left_arm.empty() ? out_.right_arm.front() : out_.left_arm.front();
    const int parent = character_.nodes[static_cast<Index>(root)].parent;
    if (arms.by_place)
      return ", the spine joint nearest to where the arms start; they hang from " +
             (parent < 0 ? std::string("nothing") : name(parent)) +
             (parent == out_.spine.front() ? ", the hips" : ", beside the spine");
    if (arms.left >= 0 && arms.right >= 0 && arms.left != arms.right)
      return ", the lower of the joints that the arms hang from; " +
             spine_name(std::max(arms.left, arms.right)) +
             " goes on from it, so that neither shoulder leaves the other";
    const bool one = out_.left_arm.empty() || out_.right_arm.empty();
    std::string why = one ? ", which the arm hangs from" : ", which both arms hang from";
    if (parent != out_.spine[index]) why += ", by way of " + name(parent);
    return why;
  }

  /// The joint that both arms hang from: it ends the driven chain, and neck and head go on from it.
  void find_chest() {
    const auto last = out_.spine.size() - 1;
    const auto drive_to = [&](Index index, const std::string& why) {
      out_.chest_index = std::clamp<Index>(index, 1, last);
      say("chest: " + name(out_.spine[out_.chest_index]) + why);
    };
    if (!hints_.chest.empty()) {
      out_.chest = resolve_spine_hints(character_, hints_).chest;
      const auto at = std::find(out_.spine.begin(), out_.spine.end(), out_.chest);
      out_.chest_index = static_cast<Index>(at - out_.spine.begin());
      out_.neck_index = std::max(out_.neck_index, out_.chest_index);
      return;
    }
    const ArmAttachment arms =
        find_arm_attachment(character_, out_.spine, out_.left_arm, out_.right_arm,
                            template_neck_ >= 0 ? static_cast<int>(out_.neck_index) : -1);
    const int hang = arms.lowest();
    if (hang < 0) return drive_to(out_.neck_index, neck_why_ + "; no arms to infer it from");
    if (hang == 0 ||
        !(arc_length(points(out_.spine, static_cast<Index>(hang) + 1)) > 1e-6 * shape_.size)) {
      // With legs that hang from elsewhere the torso is there, too: a neck was taken for it.
      if (hints_.spine.empty() && hints_.hip.empty() && !out_.left_leg.empty() &&
          !is_ancestor(character_, out_.spine.front(), out_.left_leg.front()))
        doubt("the arms start where the spine from " + name(out_.spine.front()) + " to " +
              name(out_.spine.back()) +
              " starts: it may be the neck; --hip, --chest or --spine choose another");
      return drive_to(out_.neck_index, neck_why_ +
                                           "; the arms start at the hips, which leaves no "
                                           "spine below them");
    }
    const auto index = static_cast<Index>(hang);
    const BodyPart above = shape_.name[static_cast<Index>(out_.spine[index])].part;
    if (arms.by_place && last == 1 && (above == BodyPart::neck || above == BodyPart::head) &&
        hints_.spine.empty() && hints_.hip.empty())
      doubt("only " + name(out_.spine[index]) + " is above " + name(out_.spine.front()) +
            ", which the arms start at: nothing bends between hips and chest; --hip, --chest or "
            "--spine choose another");
    out_.chest = out_.spine[index];
    drive_to(index, why_chest(arms, index));
    if (body_behind_hips_) {
      out_.chest_index = last;
      say("driven: on from there to " + name(out_.spine[last]) +
          ", the end of the chain: a fish bends behind its fins");
    }
  }

  /// Loose joints with weight (IK feet, a jaw on the root) go with the driven joint they touch.
  void find_followers() {
    std::vector<bool> driven(character_.nodes.size(), false);
    for (const auto* chain : {&out_.spine, &out_.left_arm, &out_.right_arm, &out_.left_leg,
                              &out_.right_leg, &out_.tail})
      for (const int node : *chain) driven[static_cast<Index>(node)] = true;
    for (Index n = 0; n < driven.size(); ++n)  // parents stand first
      if (const int parent = character_.nodes[n].parent; parent >= 0)
        driven[n] = driven[n] || driven[static_cast<Index>(parent)];

    // What is one limb but no chain in the file goes with its root.
    for (const auto* chain : {&out_.left_arm, &out_.right_arm})
      for (Index k = 1; k < chain->size(); ++k) {
        const int above = (*chain)[k - 1], below = (*chain)[k];
        if (is_ancestor(character_, above, below)) continue;
        out_.followers.push_back({below, above});
        say("loose joint " + name(below) + " goes with " + name(above) + ", the clavicle");
      }
    for (const Follower& loose :
         find_loose_joints(character_, shape_, driven, aside_, out_.spine.front(), out_.reasons))
      out_.followers.push_back(loose);
  }

  void doubt(const std::string& what) {
    if (!hints_.confirmed) out_.doubts.push_back(what);
  }

  /// Nothing is sure of a body that does not fit its skeleton.
  void doubt_import() {
    for (const ImportFact& fact : check_import(character_)) {
      doubt(fact.message);
      say(fact.code + ": " + fact.message);
    }
  }

  void measure() {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    const std::vector<bool> is_other = vertices_of_other_figures(character_, out_);
    for (Index v = 0; v < shape_.rest.size(); ++v) {
      if (is_other[v]) continue;
      const double along = glm::dot(glm::dvec3(shape_.rest[v]), out_.up);
      low = std::min(low, along);
      high = std::max(high, along);
    }
    out_.height = high - low;
    out_.spine_length = arc_length(points(out_.spine, out_.chest_index + 1));
    if (!(out_.spine_length > 1e-6 * shape_.size))
      refuse("the chain from " + name(out_.spine.front()) + " to " +
             name(out_.spine[out_.chest_index]) + " has no length");
  }

  const Character& character_;
  const AnatomyHints& hints_;
  SkeletonShape shape_;
  std::vector<bool> aside_;  // of each node: of another figure
  std::vector<LimbPair> limbs_;
  MirrorPair arm_pair_, leg_pair_;
  int template_neck_ = -1;  // the base of the neck where a known rig's names say so
  std::string neck_why_;    // why neck_index is the base of the neck
  bool arms_given_ = false;
  bool body_behind_hips_ = false;
  Anatomy out_;
};

}  // namespace

Anatomy find_anatomy(const Character& character, const AnatomyHints& hints) {
  return Finder(character, hints).find();
}

}  // namespace backbend::skin
