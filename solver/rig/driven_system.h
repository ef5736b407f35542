#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "solver/rig/spine_system.h"
#include "solver/rig/system_controller.h"

namespace backbend::solver {

/// An element of a rig's own controller: `output[row]` is the sum of the inputs' numbers, in order,
/// times that row's weights.
struct DrivingElement {
  std::string name;
  std::vector<std::string> inputs;  // controls or other elements
  std::vector<std::vector<double>> weights;
  /// Per row the channel of the rig that it is added to, in degrees or lengths; empty where only
  /// other elements read it.
  std::vector<std::string> drives;
};

/// A rig with controls of its maker's own, which drive the rig's channels through weighted
/// elements: a few controls for any count of joints (research/seeds.md W9, R111 to R118). What a
/// control adds comes on top of what the channel itself is set to.
///
/// Channels are the rig's, then one per number of each control: `bend`, or `bend.1`, `bend.2` for
/// more than one. All else is the rig's.
class DrivenSystem : public SpineSystem {
 public:
  /// Throws RigError as SystemController does; for `drives` of another count than rows, a channel
  /// that the rig does not have (with the nearest name), and a control named like one of the rig's.
  DrivenSystem(std::unique_ptr<SpineSystem> rig, std::vector<SystemControl> controls,
               const std::vector<DrivingElement>& elements);

  const SpineSystem& rig() const { return *rig_; }
  /// The values of the rig's own channels, with what the controls add. Throws RigError, as solve()
  /// does, where that is further than a pose file may set them (largest_written()).
  std::vector<double> rig_control(std::span<const double> control) const;
  /// What is evaluated before the rig, in order: `shares <- bend`, `shares drives top.rz`; then how
  /// many elements a change of each control evaluates again.
  std::vector<std::string> explain() const;

  std::string_view name() const override { return rig_->name(); }
  const std::map<std::string, OptionValue>& options() const override { return rig_->options(); }
  const std::vector<Channel>& channels() const override { return channels_; }
  const std::vector<std::string>& joint_names() const override { return rig_->joint_names(); }
  const std::vector<int>& joint_parents() const override { return rig_->joint_parents(); }
  const SpinePose& rest() const override { return rest_; }
  const std::vector<double>& arc_fraction() const override { return rig_->arc_fraction(); }
  SpinePose solve(std::span<const double> control) const override;
  void solve_into(std::span<const double> control, Detail detail, SpinePose& pose) const override;
  /// The rig's own channels; its maker's controls stay at rest.
  std::vector<double> controls_for(const BodyPose& body, Mapping mapping) const override;
  std::string_view why_without(BodyChannel channel) const override {
    return rig_->why_without(channel);
  }
  std::vector<glm::dvec3> intended_curve(std::span<const double> control,
                                         std::size_t count) const override;
  bool read_pose_key(std::string_view key, const OptionValue& value,
                     std::span<double> control) const override;

 private:
  struct Drive {
    std::string element;
    std::size_t row = 0, channel = 0;
    double scale = 1.0;  // from the file's unit to the channel's
  };

  std::unique_ptr<SpineSystem> rig_;
  std::vector<SystemControl> controls_;
  SystemController controller_;
  std::vector<Channel> channels_;
  std::vector<Drive> drives_;
  SpinePose rest_;
};

}  // namespace backbend::solver
