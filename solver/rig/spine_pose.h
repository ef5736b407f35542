#pragma once
#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <string>
#include <vector>

namespace backbend::solver {

/// How something that hangs from the spine moves from rest to pose: a rigid motion in rig space.
///
/// `turn` is the world rotation from rest to pose (unit), `rest_origin` the point that it turns
/// about, as it stood at rest, and `posed_origin` where that point stands now.
struct RigidMotion {
  glm::dquat turn{1.0, 0.0, 0.0, 0.0};
  glm::dvec3 rest_origin{0.0};
  glm::dvec3 posed_origin{0.0};

  glm::dvec3 apply(const glm::dvec3& at_rest) const {
    return posed_origin + turn * (at_rest - rest_origin);
  }
};

/// A number that a system reports about one pose; angles in degrees where the name ends in _deg.
struct Measure {
  std::string name;
  double value = 0.0;
};

/// What a rig that moves more than its spine says of a pose: a studio's own, which knows where
/// every joint of the character goes. World space of the character.
struct WholeBody {
  std::vector<glm::dmat4> world_from_node;  // of each node of the character's skeleton
  std::vector<glm::vec3> surface;           // of each vertex of the character; empty: not known
};

/// A solved spine. Every array but `stretch` holds joint_count() entries, hips first (neck and
/// snake: in the order of their source, see SpineSystem::joint_names()).
///
/// Rig space is right-handed; lengths in the unit of the rest chain.
struct SpinePose {
  std::vector<glm::dvec3> position;  // joint origins
  std::vector<glm::dquat> turn;      // world rotation from rest to pose, unit
  std::vector<double> flip_margin;   // radians to the nearest singular pose; empty: none exists
  RigidMotion hip;                   // what pelvis and legs follow
  RigidMotion chest;                 // the chest control's own motion: what the animator asked for
  RigidMotion arms;                  // what the arm roots follow in this system
  std::vector<Measure> measures;     // in a fixed order for each system
  std::vector<std::string> flags;    // documented fallbacks that this pose needed
  // Joints beyond the chain that a studio's own rig moves itself, each in the space of the joint
  // that it hangs from, with its own axes at rest. Empty: they follow the chain.
  std::vector<RigidMotion> hanging;
  // Null: the rest of the body follows the chain (skin::SpineDriver).
  std::shared_ptr<const WholeBody> body;

  std::size_t joint_count() const { return position.size(); }
};

}  // namespace backbend::solver
