#pragma once
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "solver/math/box_number.h"
#include "solver/rig/spine_system.h"

namespace backbend::solver {

struct BoxCourse;  // solver/curves/box_course.h

/// A body pose of BodyPose over a box; `back` is extension less flexion, radians.
struct BodyBox {
  BoxReal back, side, twist;
};

/// What is known of a rig at every pose of a box.
struct BoxPose {
  /// Of each joint's world rotation, in the order of SpineSystem::joint_names(). Infinite where it
  /// may be undefined, or jump, somewhere in the box; a finite rate is proof that it does neither.
  std::vector<BoxRates> rate;
  /// Variables that do nothing but roll each joint about its bone, by its share of them: rates are
  /// the same however wide the box is along them.
  std::array<bool, kBoxVariables> only_rolls{};
};

/// Variables that move some of the `count` controls from number `first` on, and no other control.
std::array<bool, kBoxVariables> moved_alone(std::span<const BoxReal> control, std::size_t first,
                                            std::size_t count = 1);

/// RigidMotion over a box of poses.
struct BoxMotion {
  BoxTurn turn;
  glm::dvec3 rest_origin{0.0};
  BoxVector posed_origin;
};

/// SpinePose over a box of poses: where a rig's joints, and what hangs from them, may be.
struct BoxPlaces {
  std::vector<BoxTurn> turn;        // of each joint, from rest
  std::vector<BoxVector> position;  // of each joint
  BoxMotion hip, chest, arms;
  std::optional<BoxReal> length;  // of the chain, where more is known than its joints' places say
  // What is so by construction, which enclosures of both sides could not tell.
  bool ends_on_chest = false;      // the last joint stands at the chest's origin
  bool arms_follow_chest = false;  // the arms go rigidly with the chest control
};

/// A SpineSystem is one of these too if its solver runs on boxes of poses: the same formulas as
/// solve(), as templates, with enclosures in the place of numbers. What is enclosed is the exact
/// value of the formulas, of which solve() gives a rounding; a rig's options and its rest frames
/// count as exact as they are stored.
class BoxSolver {
 public:
  /// Why the rig with these options cannot be run on boxes; empty: it can.
  virtual std::string why_not_on_boxes() const { return {}; }
  /// Whether rates per unit of a control are the same over boxes of any size: bounds from paper, so
  /// that splitting a box proves nothing more.
  virtual bool has_fixed_gain() const { return false; }
  /// The width in degrees of the smallest boxes that a search needs: narrower where enclosures of
  /// the system are wide.
  virtual double smallest_box() const { return 1.0; }
  /// As SpineSystem::controls_for().
  virtual std::vector<BoxReal> controls_for(const BodyBox& body, Mapping mapping) const = 0;
  /// Why a control cannot vary over a box; empty: it can.
  virtual std::string why_fixed(std::string_view) const { return {}; }
  /// The rig for one value per channel. Needs !why_not_on_boxes().
  virtual void solve_box(std::span<const BoxReal> control, BoxPose& pose) const = 0;
  /// The rig for a body pose: solve_box(controls_for()), or narrower where controls lose what the
  /// pose says.
  virtual void solve_body_box(const BodyBox& body, Mapping mapping, BoxPose& pose) const {
    solve_box(controls_for(body, mapping), pose);
  }

  /// Why nothing of its places can be enclosed; empty: something can.
  virtual std::string why_no_places() const {
    return "the places of its joints are not enclosed over boxes yet";
  }
  /// Why not every joint's place and turn can be enclosed, of which a skin is made; empty: they
  /// can.
  virtual std::string why_no_skin() const { return why_no_places(); }
  /// The rig for one value per channel, of a body pose's box. What is not enclosed is not finite.
  /// Needs !why_no_places().
  virtual void place_box(std::span<const BoxReal>, BoxPlaces&) const {}

  /// Why it is not known how the chain lies on intended_curve(); empty: it is.
  virtual std::string why_no_course() const {
    return "how its chain lies on its curve is not enclosed over boxes yet";
  }
  /// The chain on the curve of intended_curve(), which is asked for `points` points. Needs
  /// !why_no_course().
  virtual void course_over(const BodyBox&, Mapping, std::size_t /*points*/, BoxCourse&) const {}

 protected:
  ~BoxSolver() = default;
};

}  // namespace backbend::solver
