#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "skin/anatomy/mirror_image.h"
#include "skin/weights/skin_places.h"

namespace backbend::skin {

/// A body's left and right, place against place and joint against joint, at rest: what can be
/// compared between them, and with what. A body may be posed or dressed on one side (a raised arm,
/// hair, a scarf): where it does not mirror itself as a whole, joints are left out around which it
/// does not.
class BodySides {
 public:
  /// Keeps references to all three.
  BodySides(const Character& character, const Anatomy& anatomy, const SkinPlaces& places);

  const Mirror& mirror() const { return mirror_; }
  /// Of each node: the one on the other side, itself in the middle.
  const std::vector<int>& joint_images() const { return joint_image_; }
  /// Of each place: the weights of the surface at its mirror image, of the place there (within
  /// 0.2 % of the size), else mixed from the corners of the nearest triangle around the nearest
  /// place (within 1 %); empty where the body has no other side there.
  const std::vector<PlaceWeights>& images() const { return images_; }
  /// Whether a joint is of the spine, a clavicle or an upper arm: what the spine's motion shows.
  /// Feet, fingers, tails and ears of many a healthy character differ.
  bool is_asked(int node) const;
  /// Whether the hips hang from a joint: it stays behind when the spine moves.
  bool above_hips(int node) const;
  /// Whether a place has no counterpart by its joints: it moves with one that stands elsewhere on
  /// the other side, or most with one around which the body does not mirror itself.
  bool is_left_out(std::size_t place) const;
  /// Why left and right cannot be compared; empty where they can.
  const std::string& not_comparable() const { return not_comparable_; }
  /// Whether the surface can, whatever the skeleton: 95 % of its places have an image, or three
  /// quarters of the torso's are around joints of whose places so many have one.
  bool surface_is_comparable() const { return surface_is_comparable_; }
  /// Whether 95 % of the places that count have a place at their image. Sides that are not built
  /// alike were painted one by one, and are never quite alike.
  bool built_alike() const { return built_alike_; }

 private:
  void find_images();
  void find_odd_joints();
  void compare_surfaces();
  double find_uneven_joints();
  bool moves_with_odd(const PlaceWeights& weights) const;
  int odd_joint_that_counts() const;

  const Character& character_;
  const Anatomy& anatomy_;
  const SkinPlaces& places_;
  const Mirror mirror_;
  const std::vector<int> joint_image_;
  std::vector<PlaceWeights> images_;
  std::vector<bool> has_place_;  // of each place: whether its image is a place
  std::vector<bool> odd_;        // of each node: whether it stands elsewhere on the other side
  std::vector<bool> uneven_;     // of each node: whether the body does not mirror itself there
  std::string not_comparable_;
  bool surface_is_comparable_ = false, built_alike_ = false;
};

}  // namespace backbend::skin
