#include "skin/weights/body_sides.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <limits>
#include <map>

#include "skin/character/ancestor.h"
#include "skin/character/closest_point.h"
#include "skin/character/point_cells.h"
#include "skin/character/printable.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;

// Lengths are shares of the body's largest side.
constexpr Index kArmJoints = 2;         // of an arm: clavicle and upper arm
constexpr double kMirrored = 0.95;      // of places, to speak of a symmetric surface
constexpr double kLeastEven = 0.75;     // of the torso's places, around joints that mirror so
constexpr double kMirrorSlack = 0.002;  // between a place and its image
constexpr double kSamePlace = 1e-5;     // between places where shells touch
constexpr double kSurfaceSlack = 0.01;  // ... and the surface, where no place has one
constexpr double kJointSlack = 0.01;    // between a joint and its image
constexpr double kMostOdd = 0.3;        // of spine and arms, on joints without an image

}  // namespace

BodySides::BodySides(const Character& character, const Anatomy& anatomy, const SkinPlaces& places)
    : character_(character),
      anatomy_(anatomy),
      places_(places),
      mirror_(surface_mirror(character, anatomy, places.point)),
      joint_image_(mirrored_nodes(character, mirror_)) {
  if (!(places.size > 0.0)) return;
  find_images();
  find_odd_joints();
  compare_surfaces();
  if (const int node = odd_joint_that_counts(); node >= 0)
    not_comparable_ = "the skeleton is not symmetric: joint " +
                      in_quotes(character_.nodes[static_cast<Index>(node)].name) +
                      " has no mirror image";
}

bool BodySides::is_asked(int node) const {
  const auto on = [&](const std::vector<int>& chain, Index count) {
    const auto end = chain.begin() + static_cast<std::ptrdiff_t>(std::min(count, chain.size()));
    return std::find(chain.begin(), end, node) != end;
  };
  return on(anatomy_.spine, anatomy_.spine.size()) || on(anatomy_.left_arm, kArmJoints) ||
         on(anatomy_.right_arm, kArmJoints);
}

bool BodySides::above_hips(int node) const {
  return node != anatomy_.spine.front() && is_ancestor(character_, node, anatomy_.spine.front());
}

bool BodySides::is_left_out(Index place) const {
  const int main = places_.main[place];
  return (main >= 0 && uneven_[static_cast<Index>(main)]) ||
         moves_with_odd(places_.weights[place]) || moves_with_odd(images_[place]);
}

void BodySides::find_images() {
  double length = 0.0;
  for (Index p = 0; p < places_.point.size(); ++p)
    for (Index e = places_.edges.first[p]; e < places_.edges.first[p + 1]; ++e)
      length += glm::distance(places_.point[p], places_.point[places_.edges.of[e]]);
  const double mean_edge =
      places_.edges.of.empty() ? 0.0 : length / static_cast<double>(places_.edges.of.size());
  const PointCells cells(places_.point, std::max(kMirrorSlack * places_.size, mean_edge));
  std::vector<std::vector<Index>> triangles(places_.point.size());
  for (Index t = 0; t < character_.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k)
      triangles[character_.place[character_.triangles[t][k]]].push_back(t);
  images_.resize(places_.point.size());
  has_place_.assign(places_.point.size(), false);
  for (Index p = 0; p < places_.point.size(); ++p) {
    const glm::dvec3 at = mirror_(places_.point[p]);
    const Index nearest = cells.nearest(at);
    if (nearest == places_.point.size()) continue;
    if (const double off = glm::distance(places_.point[nearest], at);
        off <= kMirrorSlack * places_.size) {
      // Where shells touch, several places lie there: this one's image is the one most like it.
      double least = std::numeric_limits<double>::infinity();
      cells.each_within(at, off + kSamePlace * places_.size, [&](Index q) {
        const double unlike =
            weight_difference(places_.weights[p], places_.weights[q], &joint_image_).share;
        if (unlike >= least) return;
        least = unlike;
        images_[p] = places_.weights[q];
      });
      has_place_[p] = true;
      continue;
    }
    TrianglePoint best;
    best.distance = kSurfaceSlack * places_.size;
    const glm::uvec3* found = nullptr;
    const auto look_around = [&](Index place) {
      for (const Index t : triangles[place]) {
        const glm::uvec3& corner = character_.triangles[t];
        const auto corner_at = [&](int k) { return places_.point[character_.place[corner[k]]]; };
        const TrianglePoint on = closest_on_triangle(at, corner_at(0), corner_at(1), corner_at(2));
        if (on.distance >= best.distance) continue;
        best = on;
        found = &corner;
      }
    };
    look_around(nearest);
    for (Index e = places_.edges.first[nearest]; e < places_.edges.first[nearest + 1]; ++e)
      look_around(places_.edges.of[e]);
    if (found == nullptr) continue;
    std::map<int, double> mixed;
    for (int k = 0; k < 3; ++k)
      for (const NodeWeight& w : places_.weights[character_.place[(*found)[k]]])
        mixed[w.node] += best.share[static_cast<Index>(k)] * w.weight;
    for (const auto& [node, weight] : mixed) images_[p].push_back({node, weight});
  }
}

/// Joints with weight that stand elsewhere on the other side, or have no other side: a hand that
/// was bound a little apart, a rope on the back. A joint above the hips moves nothing by where it
/// is.
void BodySides::find_odd_joints() {
  odd_.assign(joint_image_.size(), false);
  for (Index n = 0; n < joint_image_.size(); ++n) {
    const auto node = static_cast<int>(n);
    if (places_.total[n] <= kLeastArea * places_.all || above_hips(node)) continue;
    // One that is its own image stands off the middle by half of the way there.
    const double way = joint_image_[n] == node ? 0.5 : 1.0;
    odd_[n] = way * glm::distance(mirror_(places_.at(node)), places_.at(joint_image_[n])) >
              kJointSlack * places_.size;
  }
}

bool BodySides::moves_with_odd(const PlaceWeights& weights) const {
  return std::ranges::any_of(weights, [&](const NodeWeight& w) {
    return w.weight >= kCounts && odd_[static_cast<Index>(w.node)];
  });
}

/// The odd joint without which a body cannot be compared side by side: a vertebra, or the one
/// that moves most where odd joints move kMostOdd of the places of spine and arms; -1 for none.
int BodySides::odd_joint_that_counts() const {
  for (const int node : anatomy_.spine)
    if (odd_[static_cast<Index>(node)]) return node;
  std::vector<double> moved(odd_.size(), 0.0);
  Index asked = 0, odd = 0;
  for (const PlaceWeights& weights : places_.weights) {
    if (std::ranges::none_of(
            weights, [&](const NodeWeight& w) { return w.weight >= kCounts && is_asked(w.node); }))
      continue;
    ++asked;
    if (!moves_with_odd(weights)) continue;
    ++odd;
    for (const NodeWeight& w : weights)
      if (odd_[static_cast<Index>(w.node)]) moved[static_cast<Index>(w.node)] += w.weight;
  }
  if (static_cast<double>(odd) <= kMostOdd * static_cast<double>(asked)) return -1;
  return static_cast<int>(std::ranges::max_element(moved) - moved.begin());
}

/// Which share of the places has a mirror image, but for what moves with odd joints; where that
/// is not enough, around which joints it is.
void BodySides::compare_surfaces() {
  uneven_.assign(joint_image_.size(), false);
  const auto share_of = [](Index part, Index whole) {
    return static_cast<double>(part) / static_cast<double>(std::max<Index>(whole, 1));
  };
  Index asked = places_.own_count, mirrored = 0;
  for (Index p = 0; p < images_.size(); ++p)
    if (moves_with_odd(places_.weights[p]))
      --asked;
    else
      mirrored += !images_[p].empty();
  const double share = share_of(mirrored, asked);
  surface_is_comparable_ = share >= kMirrored || find_uneven_joints() >= kLeastEven;
  if (!surface_is_comparable_)
    not_comparable_ = "the body is not symmetric: " + number_text(100.0 * share, 3) +
                      " % of its places have a mirror image, " + number_text(100.0 * kMirrored, 3) +
                      " % are needed";
  Index even = 0, with_place = 0;
  for (Index p = 0; p < images_.size(); ++p) {
    if (places_.weights[p].empty() || is_left_out(p)) continue;
    ++even;
    with_place += has_place_[p];
  }
  built_alike_ = share_of(with_place, even) >= kMirrored;
}

/// Finds the joints that move most of places of which less than kMirrored have an image, both
/// sides' together. The share of the torso's places, hips among them, that other joints move.
double BodySides::find_uneven_joints() {
  struct Count {
    Index all = 0, mirrored = 0;
  };
  std::vector<Count> count(joint_image_.size());
  for (Index p = 0; p < images_.size(); ++p) {
    const int main = places_.main[p];
    if (main < 0 || moves_with_odd(places_.weights[p])) continue;
    // Of both sides together; a joint in the middle is its own image.
    for (const int node : {main, joint_image_[static_cast<Index>(main)]}) {
      Count& each = count[static_cast<Index>(node)];
      ++each.all;
      each.mirrored += !images_[p].empty();
    }
  }
  const auto is_even = [](const Count& each) {
    return static_cast<double>(each.mirrored) >= kMirrored * static_cast<double>(each.all);
  };
  for (Index n = 0; n < uneven_.size(); ++n) uneven_[n] = !is_even(count[n]);
  Index torso = 0, even = 0;
  for (Index k = 0; k <= anatomy_.chest_index; ++k) {
    const auto node = static_cast<Index>(anatomy_.spine[k]);
    torso += count[node].all;
    if (!uneven_[node]) even += count[node].all;
  }
  return torso == 0 ? 0.0 : static_cast<double>(even) / static_cast<double>(torso);
}

}  // namespace backbend::skin
