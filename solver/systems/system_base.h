#pragma once
#include <map>
#include <string>
#include <vector>

#include "solver/rig/option_range.h"
#include "solver/rig/spine_system.h"

namespace backbend::solver {

class OptionReader;

/// What every system keeps and only shows: a builder fills the fields, solve() reads them.
class SystemBase : public SpineSystem, public RangedOptions {
 public:
  std::string_view name() const override { return name_; }
  const std::map<std::string, OptionValue>& options() const override { return options_; }
  const std::map<std::string, OptionRange>& option_ranges() const override { return ranges_; }
  const std::vector<Channel>& channels() const override { return channels_; }
  const std::vector<std::string>& joint_names() const override { return joint_names_; }
  const std::vector<int>& joint_parents() const override { return joint_parents_; }
  const SpinePose& rest() const override { return rest_; }
  const std::vector<double>& arc_fraction() const override { return arc_fraction_; }

 protected:
  /// Takes what was read, and the ranges that were asked for. Throws as OptionReader::finish().
  void take_options(const OptionReader& read);
  /// Adds `control.rx`, `control.ry`, `control.rz`.
  void add_rotation(const std::string& control);
  /// Adds `control.x`, `control.y`, `control.z`.
  void add_translation(const std::string& control);
  void add_scalar(const std::string& name, double rest = 0.0);

  /// Sets the joints: these names, each the child of the one before.
  void name_chain(std::vector<std::string> names);
  /// Sets arc_fraction_ from the rest positions: the share of the polyline's length up to each
  /// joint.
  void measure_arc_fraction();

  /// True if every channel is at rest: the pose is then rest() itself, exactly.
  bool is_at_rest(std::span<const double> control) const;

  std::string name_;
  std::map<std::string, OptionValue> options_;
  std::map<std::string, OptionRange> ranges_;
  std::vector<Channel> channels_;
  std::vector<std::string> joint_names_;
  std::vector<int> joint_parents_;
  SpinePose rest_;
  std::vector<double> arc_fraction_;
};

/// A system that computes its pose from the controls by formulas. Untouched it is rest() itself,
/// exactly and not to rounding.
class FormulaSystem : public SystemBase {
 public:
  SpinePose solve(std::span<const double> control) const final;
  void solve_into(std::span<const double> control, Detail detail, SpinePose& pose) const final;

 protected:
  /// Fills all of `pose`, whose memory may have been used before. One value per channel.
  virtual void fill(std::span<const double> control, Detail detail, SpinePose& pose) const = 0;
};

/// Throws RigError unless the chain has `least` joints or more, all finite, no two neighbours in
/// one place (closer than 1e-9 of the chain's length).
void check_chain(const RestChain& chain, const std::string& system, std::size_t least);

/// Length of the polyline up to each point; the last is the whole.
std::vector<double> polyline_arcs(const std::vector<glm::dvec3>& point);

/// The four joints of the three bones that a chain stands for: its own if it has four, else cut
/// from its polyline at equal thirds of arc.
std::vector<glm::dvec3> three_bones_of(const RestChain& chain);

}  // namespace backbend::solver
