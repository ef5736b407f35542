#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <utility>
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "skin/character/character.h"

namespace backbend::skin {

/// The weights of one place on nodes.
struct NodeWeight {
  int node = -1;
  double weight = 0.0;
};
using PlaceWeights = std::vector<NodeWeight>;

/// A vertex's weights by node: joints of several skins on one node are summed.
PlaceWeights weights_of(const Character& character, std::size_t vertex);

/// Half the sum of the differences between two places' weights, 0..1, and the joint with the
/// largest; `image` leads from the first one's joints to the second's (null: to themselves).
struct WeightDifference {
  double share = 0.0;
  int most = -1, least = -1;  // where the second has most more and most less than the first
};
WeightDifference weight_difference(const PlaceWeights& a, const PlaceWeights& b,
                                   const std::vector<int>* image);

/// The neighbours of each place, one after another, ascending.
struct PlaceNeighbours {
  std::vector<std::size_t> first, of;  // of place p: of[first[p]] to of[first[p + 1] - 1]
  PlaceNeighbours() = default;
  PlaceNeighbours(const std::vector<std::pair<std::size_t, std::size_t>>& pairs,
                  std::size_t places);
};

/// Less of a vertex's weight is a crumb.
inline constexpr double kCounts = 0.01;
/// Less of all weight has no middle to speak of.
inline constexpr double kLeastArea = 0.002;
/// Joints along the skeleton that make one far from another.
inline constexpr double kFarJoints = 3.0;

/// A character's skin by place, at rest, as the faults of its weights are looked for: vertices at
/// one rest place are one, with the weights of the first. World space, lengths in the file's unit.
/// Places of another figure in the file are without weights, and do not count for the size.
struct SkinPlaces {
  SkinPlaces(const Character& character, const Anatomy& anatomy);

  std::vector<std::uint32_t> vertex;    // the first of each place
  std::vector<glm::dvec3> point;        // of each place, at rest
  std::vector<PlaceWeights> weights;    // of each place; none where it came without
  std::vector<int> main;                // the node that weighs most
  std::vector<double> total;            // weight of each node, in places
  std::vector<int> parent;              // of each node; of a loose joint what it goes with
  std::vector<int> on_spine;            // of each node: index into the spine; -1 for none
  std::vector<glm::dvec3> chain;        // the spine's joints
  std::vector<double> arc;              // ... and their places along it
  std::vector<double> along, beside;    // of each place that the spine moves: along it, off it
  PlaceNeighbours edges, linked;        // along the surface; and from shell to shell, too
  std::vector<std::size_t> shell;       // of each place: a piece that no edges join to others
  std::vector<std::size_t> shell_size;  // of each shell, in places
  std::size_t largest_shell = 0;        // by places with weight
  // Of each shell: a piece bound as a whole, six places or more of the same weights; none where
  // such pieces hold most of what the vertebrae up to the chest hold: the body is made of them.
  std::vector<bool> costume;
  std::size_t own_count = 0;  // places that are not another figure's
  double all = 0.0;           // the sum of all weights
  double size = 0.0;          // the body's largest side
  double half_width = 0.0;    // of the torso, from the chain to the surface

  glm::dvec3 at(int node) const;
  double weight_at(std::size_t place, int node) const;
  /// The joint that weighs most on a place beside `node`; -1 for none.
  int heaviest_but(std::size_t place, int node) const;
  /// Joints on the way from one to another along the skeleton, an object that hangs on one being of
  /// that: none where two stand in one place or one holds the weight of a weightless vertebra
  /// beside it, and along a spine of many joints, where three are a short way, by its length
  /// (kFarJoints are 0.4 of it, and the torso's half width). Infinite between two trees.
  double steps_between(int a, int b) const;
  /// Points along a joint's bones, its own place first.
  std::vector<glm::dvec3> points_on_bones(int node) const;

 private:
  void measure_torso();
  glm::dvec3 point_at(double arc_length) const;
  void find_hung_objects();
  double step_above(int node) const;
  void list_edges();
  void find_shells();
  void find_costume();
  void link_shells(std::vector<std::pair<std::size_t, std::size_t>>& pairs) const;

  const Character& character_;
  const Anatomy& anatomy_;
  double spine_step_ = 1.0;     // as far along the spine counts as one joint of another chain
  std::vector<bool> leads_on_;  // of each node: whether a joint with weight hangs from it
  std::vector<bool> hangs_;     // of each node: whether it only hangs an object on a joint
};

}  // namespace backbend::skin
