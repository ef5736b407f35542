#pragma once
#include <glm/mat4x4.hpp>
#include <span>
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "skin/character/character.h"

namespace backbend::validate {

/// The parts of a character that go rigidly with hips, chest or one vertebra whatever the spine
/// does: a head, a hand, a thigh. Nothing on them changes but their place.
class RigidParts {
 public:
  /// Of a character that the driver moves. Keeps what it needs.
  RigidParts(const skin::Character& character, const skin::SpineDriver& driver);

  /// The part of each vertex; -1 where joints of several parts move it.
  const std::vector<int>& of_vertex() const { return of_vertex_; }

  /// Whether these nodes, one matrix per node of the character, take every part as one rigid body.
  /// Always so where the driver moves them; a studio's own rig may move the limbs, too.
  bool hold(std::span<const glm::dmat4> world_from_node) const;

 private:
  struct Joint {
    std::size_t node;
    int part;
    glm::dmat4 node_from_rest;  // inverse of world_from_node at rest
  };
  std::vector<Joint> joint_;  // those that have vertices of their own
  std::vector<int> of_vertex_;
  std::size_t parts_ = 0;
  double size_ = 0.0;  // the largest coordinate of a joint at rest
};

}  // namespace backbend::validate
