#pragma once
#include "solver/systems/system_base.h"
#include "validate/clips/clip_body.h"

namespace backbend::validate {

/// A baked clip as a spine system: its one control is the frame, and its poses are the clip's. So
/// everything that measures a rig measures a clip. Rest is no frame of it, but frame kRest: what
/// the body was bound to, whatever pose the clip begins in.
///
/// The chain runs from the hips to the base of the neck. What it was meant to follow nobody says;
/// its intended curve is the smooth one through its own joints.
class ClipSystem : public solver::SystemBase {
 public:
  static constexpr double kRest = -1.0;

  ClipSystem(const skin::Character& character, const skin::Anatomy& anatomy, const ClipBody& body);
  /// One pose that is not the clip's own, such as the ideal bend of a frame.
  ClipSystem(const skin::Character& character, const skin::Anatomy& anatomy,
             const std::vector<glm::dmat4>& world_from_node);

  solver::SpinePose solve(std::span<const double> control) const override;
  std::vector<double> controls_for(const solver::BodyPose&, solver::Mapping) const override {
    return {kRest};
  }
  std::vector<glm::dvec3> intended_curve(std::span<const double> control,
                                         std::size_t count) const override;

  const solver::SpinePose& pose(std::size_t frame) const { return pose_[frame]; }
  /// Twist from hips to chest, summed joint by joint: tells 200 degrees from -160.
  double twist_deg(std::size_t frame) const;
  /// By how much one joint turns against the mean of itself and its neighbours, rest taken off:
  /// half of what a joint turns alone, nothing for an even bend: chain_corner().
  double corner_deg(std::size_t frame, int& joint) const;

 private:
  void build(const skin::Character& character, const skin::Anatomy& anatomy);
  void add(const skin::Character& character, const std::vector<glm::dmat4>& world);

  std::vector<int> node_;  // of each joint of the chain
  std::vector<solver::SpinePose> pose_;
};

/// World matrices of a frame with its spine bent evenly: the same chest against the hips, the turn
/// shared by the spine's joints by length; everything else keeps its place on its parent.
std::vector<glm::dmat4> even_bend(const skin::Character& character, const skin::Anatomy& anatomy,
                                  const ClipSystem& system, const ClipBody& body,
                                  std::size_t frame);

}  // namespace backbend::validate
