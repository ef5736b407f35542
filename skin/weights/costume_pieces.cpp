#include "skin/weights/costume_pieces.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "skin/character/point_cells.h"
#include "skin/weights/prop_parts.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;

constexpr Index kFewestOfPiece = 6;     // places
constexpr double kSideOfOwn = 0.6;      // of a joint's distance from the middle
constexpr double kOffPiece = 0.08;      // of the body's size, between a piece and its joints' areas
constexpr double kTouchesPiece = 0.04;  // ... and between the nearest ends of both
constexpr double kAllOfJoint = 0.9;     // of a joint's weight
constexpr double kNearSteps = 2.0;  // joints along the skeleton to what a piece lies on, at least
constexpr double kFarShare = 0.5;   // of what it lies on, kFarJoints away

/// Shells that go as one, and the joints that move most on them.
struct Piece {
  std::vector<Index> places;
  std::set<int> joints;
};

class PieceFinder {
 public:
  PieceFinder(const Character& character, const Anatomy& anatomy, const SkinPlaces& places,
              const Mirror& mirror, const std::vector<int>& image)
      : character_(character), places_(places), mirror_(mirror), image_(image) {
    on_chain_.assign(character.nodes.size(), false);
    for (const auto* chain : {&anatomy.spine, &anatomy.left_arm, &anatomy.right_arm,
                              &anatomy.left_leg, &anatomy.right_leg})
      for (const int node : *chain) on_chain_[static_cast<Index>(node)] = true;
  }

  void find(FaultMap& wrong_side, FaultMap& far) {
    list_pieces();
    for (Index k = 0; k < pieces_.size(); ++k) {
      const Piece& piece = pieces_[k];
      if (piece.places.size() < kFewestOfPiece || piece.joints.empty() ||
          piece.joints.count(-1) > 0)
        continue;
      if (is_across(piece)) {
        for (const Index p : piece.places)
          add_fault(places_, wrong_side, places_.main[p],
                    image_[static_cast<Index>(places_.main[p])], own_weight(p), own_distance(p), p);
      } else if (const int below = lies_far_on(k); below >= 0 && is_misbound(k)) {
        for (const Index p : piece.places)
          add_fault(places_, far, places_.main[p], below, own_weight(p), own_distance(p), p);
      }
    }
  }

 private:
  double own_weight(Index p) const { return places_.weight_at(p, places_.main[p]); }
  double own_distance(Index p) const {
    return glm::distance(places_.at(places_.main[p]), places_.point[p]);
  }

  void list_pieces() {
    std::vector<Piece> shells(places_.shell_size.size());
    for (Index p = 0; p < places_.shell.size(); ++p) {
      Piece& shell = shells[places_.shell[p]];
      shell.places.push_back(p);
      shell.joints.insert(places_.main[p]);
    }
    // Each shell's piece, by a shell of it.
    std::vector<Index> piece(shells.size());
    std::iota(piece.begin(), piece.end(), Index{0});
    const auto root = [&](Index shell) {
      while (piece[shell] != shell) shell = piece[shell] = piece[piece[shell]];
      return shell;
    };
    const auto is_loose = [&](Index shell) {
      return shell != places_.largest_shell && shells[shell].joints.size() == 1;
    };
    for (Index p = 0; p < places_.shell.size(); ++p) {
      if (!is_loose(places_.shell[p])) continue;
      for (Index e = places_.linked.first[p]; e < places_.linked.first[p + 1]; ++e) {
        const Index q = places_.linked.of[e];
        if (is_loose(places_.shell[q]) && places_.main[q] == places_.main[p])
          piece[root(places_.shell[q])] = root(places_.shell[p]);
      }
    }
    // The shells of a prop are one piece whether they touch or not: arrows in a quiver.
    const std::vector<int> prop = prop_parts(character_, places_);
    std::map<int, Index> first_shell;  // of each prop, by its node
    for (Index part = 0; part < prop.size(); ++part) {
      if (prop[part] < 0) continue;
      const Index first = character_.parts[part].first_vertex;
      for (Index v = first; v < first + character_.parts[part].vertex_count; ++v)
        if (const Index shell = places_.shell[character_.place[v]]; is_loose(shell))
          piece[root(shell)] = root(first_shell.insert({prop[part], shell}).first->second);
    }
    piece_of_.assign(shells.size(), 0);
    std::vector<Index> number(shells.size(), shells.size());
    for (Index s = 0; s < shells.size(); ++s) {
      Index& at = number[root(s)];
      if (at == shells.size()) {
        at = pieces_.size();
        pieces_.emplace_back();
      }
      piece_of_[s] = at;
      if (s == places_.largest_shell) continue;  // the body: a piece without places
      Piece& to = pieces_[at];
      to.places.insert(to.places.end(), shells[s].places.begin(), shells[s].places.end());
      to.joints.insert(shells[s].joints.begin(), shells[s].joints.end());
    }
  }

  /// Whether all of a piece lies across the middle from all of its joints, and about as far out.
  bool is_across(const Piece& piece) const {
    const auto aside = [&](const glm::dvec3& p) {
      return glm::dot(p - mirror_.middle, mirror_.left);
    };
    double here = 0.0, own = 0.0;
    for (const Index p : piece.places) {
      const int node = places_.main[p];
      const double joint = aside(places_.at(node));
      if (image_[static_cast<Index>(node)] == node || !(joint * aside(places_.point[p]) < 0.0))
        return false;
      here += std::abs(aside(places_.point[p]));
      own += std::abs(joint);
    }
    return here > kSideOfOwn * own;
  }

  /// The joint that moves most of what a piece lies on, where that is far along the skeleton from
  /// each of its joints; else -1.
  int lies_far_on(Index k) const {
    std::map<int, Index> below;
    Index all = 0;
    for (const Index p : pieces_[k].places)
      for (Index e = places_.linked.first[p]; e < places_.linked.first[p + 1]; ++e) {
        const Index q = places_.linked.of[e];
        if (piece_of_[places_.shell[q]] == k || places_.main[q] < 0) continue;
        ++below[places_.main[q]];
        ++all;
      }
    if (below.empty()) return -1;
    for (const int joint : pieces_[k].joints) {
      Index far = 0;
      for (const auto& [other, count] : below) {
        const double steps = places_.steps_between(other, joint);
        if (steps < kNearSteps) return -1;
        if (steps >= kFarJoints) far += count;
      }
      if (static_cast<double>(far) < kFarShare * static_cast<double>(all)) return -1;
    }
    return std::ranges::max_element(below, {}, [](const auto& each) { return each.second; })->first;
  }

  /// Whether each of a piece's joints is away from it, or hangs from a joint that is away from the
  /// piece and from where its branch starts; of a joint that moves only this piece the joint itself
  /// says nothing, for a prop may have its pivot anywhere. Of a joint that hangs from none of the
  /// body nothing is said.
  bool is_misbound(Index k) const {
    return std::ranges::all_of(pieces_[k].joints, [&](int joint) {
      int start = joint, above = joint;  // the branch's, and what it hangs from
      while (above >= 0 && !on_chain_[static_cast<Index>(above)]) {
        start = above;
        above = places_.parent[static_cast<Index>(above)];
      }
      if (above < 0) return false;
      const bool own = is_its_own(k, joint);
      if (!own && is_away(k, area_beside(joint, places_.points_on_bones(joint), k))) return true;
      if (above == joint) return false;
      const std::vector<glm::dvec3> area = area_beside(above, {places_.at(above)}, k);
      return is_away(k, area) && ((own && start == joint) ||
                                  distance_to(area, places_.at(start)) >= kOffPiece * places_.size);
    });
  }

  /// Whether a joint moves only this piece, and lies within it (a rigid head reaches far from its
  /// joint, and the end of its bone is unknown) or is on neither spine nor limbs (a prop's).
  bool is_its_own(Index k, int joint) const {
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
    double weight = 0.0;
    for (const Index p : pieces_[k].places) {
      weight += places_.weight_at(p, joint);
      low = glm::min(low, places_.point[p]);
      high = glm::max(high, places_.point[p]);
    }
    if (weight < kAllOfJoint * places_.total[static_cast<Index>(joint)]) return false;
    const glm::dvec3 at = places_.at(joint);
    return !on_chain_[static_cast<Index>(joint)] ||
           (glm::all(glm::greaterThanEqual(at, low)) && glm::all(glm::lessThanEqual(at, high)));
  }

  /// Whether most of a piece is away from an area, and none of it touches that.
  bool is_away(Index k, const std::vector<glm::dvec3>& area) const {
    std::vector<double> off;
    for (const Index p : pieces_[k].places) off.push_back(distance_to(area, places_.point[p]));
    const auto middle = off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2);
    std::ranges::nth_element(off, middle);
    return *middle >= kOffPiece * places_.size &&
           std::ranges::min(off) >= kTouchesPiece * places_.size;
  }

  /// `bones`, and where their joint weighs most on the body; of other pieces only those that reach
  /// to the bones, or to one that does (a limb is of many), for others may be bound as wrongly as
  /// this one.
  std::vector<glm::dvec3> area_beside(int joint, const std::vector<glm::dvec3>& bones,
                                      Index k) const {
    std::vector<glm::dvec3> area = bones;
    std::map<Index, std::vector<glm::dvec3>> apart;  // of each piece that is not joined yet
    for (Index p = 0; p < places_.main.size(); ++p) {
      if (places_.main[p] != joint || piece_of_[places_.shell[p]] == k) continue;
      auto& to =
          places_.shell[p] == places_.largest_shell ? area : apart[piece_of_[places_.shell[p]]];
      to.push_back(places_.point[p]);
    }
    std::vector<glm::dvec3> reached = bones;
    for (bool is_more = true; is_more;) {
      is_more = false;
      const PointCells cells(reached, kOffPiece * places_.size);
      std::erase_if(apart, [&](const auto& piece) {
        const auto reaches = [&](const glm::dvec3& point) {
          return cells.nearest(point) < cells.size();
        };
        if (!std::ranges::any_of(piece.second, reaches)) return false;
        for (auto* to : {&area, &reached})
          to->insert(to->end(), piece.second.begin(), piece.second.end());
        return is_more = true;
      });
    }
    return area;
  }

  static double distance_to(const std::vector<glm::dvec3>& area, const glm::dvec3& point) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const glm::dvec3& each : area) nearest = std::min(nearest, glm::distance(each, point));
    return nearest;
  }

  const Character& character_;
  const SkinPlaces& places_;
  const Mirror& mirror_;
  const std::vector<int>& image_;
  std::vector<bool> on_chain_;  // of each node: of spine, arms and legs
  std::vector<Piece> pieces_;
  std::vector<Index> piece_of_;  // of each shell
};

}  // namespace

void find_misbound_pieces(const Character& character, const Anatomy& anatomy,
                          const SkinPlaces& places, const Mirror& mirror,
                          const std::vector<int>& image, FaultMap& wrong_side, FaultMap& far) {
  PieceFinder(character, anatomy, places, mirror, image).find(wrong_side, far);
}

}  // namespace backbend::skin
