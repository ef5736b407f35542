#include "solver/systems/even.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <mutex>
#include <optional>

#include "solver/math/rotation.h"
#include "solver/rig/box_solver.h"
#include "solver/rig/chain_measures.h"
#include "solver/rig/option_reader.h"
#include "solver/systems/even_limits.h"
#include "solver/systems/even_options.h"
#include "solver/systems/even_reach.h"
#include "solver/systems/even_shape.h"
#include "solver/systems/fk_bones.h"
#include "solver/systems/system_base.h"

namespace backbend::solver {
namespace {

using glm::dquat;
using glm::dvec3;

class Even final : public FormulaSystem, public BoxSolver {
  enum ChannelIndex { kUpper = 3, kStretch = 9, kCompression };

 public:
  Even(const SystemSpec& spec, const RestChain& chain) : Even(spec, chain, OptionReader(spec)) {}

  std::vector<double> controls_for(const BodyPose& body, Mapping mapping) const override {
    std::vector<double> control = fk_controls_for(body, mapping);
    control.push_back(stretchiness_ > 0.0 ? body.stretch : 1.0);
    control.push_back(0.0);
    return control;
  }

  bool has_fixed_gain() const override { return limited_ || !reach_->off(); }

  std::vector<BoxReal> controls_for(const BodyBox& body, Mapping mapping) const override {
    std::vector<BoxReal> control = fk_controls(body.twist, -body.side, -body.back, mapping);
    control.emplace_back(1.0);
    control.emplace_back(0.0);
    return control;
  }

  void solve_box(std::span<const BoxReal> control, BoxPose& pose) const override {
    const BoxTurn lower =
        euler_turn(bone_.axes[0], from_euler_xyz(control[0], control[1], control[2]));
    pose.rate.resize(std::size_t(bones_) + 1);
    if (has_fixed_gain()) {
      std::fill(pose.rate.begin(), pose.rate.end(), rates_on_paper(lower, control));
      return;
    }
    for (int k = 0; k <= bones_; ++k) {
      pose.rate[std::size_t(k)] =
          (lower * shape_.frame(k, control.subspan(kUpper, kUpperChannels))).rate;
    }
  }

  std::string why_no_places() const override {
    if (limited_) return "with limits the places of its joints are not enclosed over boxes yet";
    if (!reach_->off())
      return "with reach the places of its joints are not enclosed over boxes yet";
    return {};
  }

  /// At its own length, which is what a body pose without stretch asks for.
  void place_box(std::span<const BoxReal> control, BoxPlaces& places) const override {
    const BoxTurn lower =
        euler_turn(bone_.axes[0], from_euler_xyz(control[0], control[1], control[2]));
    const auto upper = control.subspan(kUpper, kUpperChannels);
    const dvec3 root = drawn_.front();
    places.turn.clear();
    places.position.assign(std::size_t(bones_) + 1, {});
    shape_.shifts(upper, places.position);
    for (int k = 0; k <= bones_; ++k) {
      places.turn.push_back(lower * shape_.frame(k, upper));
      BoxVector& at = places.position[std::size_t(k)];
      at = root + lower * (BoxVector(shape_.rest_joint()[std::size_t(k)] - root) + at);
    }
    places.hip = {BoxTurn(), root, places.position.front()};
    places.chest = {places.turn.back(), drawn_.back(), places.position.back()};
    places.arms = places.chest;
    places.ends_on_chest = places.arms_follow_chest = true;
  }

  std::string why_no_course() const override { return why_no_places(); }

  void course_over(const BodyBox& body, Mapping mapping, std::size_t points,
                   BoxCourse& course) const override {
    const std::vector<BoxReal> control = controls_for(body, mapping);
    course = shape_.course(std::span(control).subspan(kUpper, kUpperChannels), points);
  }

  std::string_view why_without(BodyChannel channel) const override {
    if (channel == BodyChannel::hip) return kNoHipControl;
    if (stretchiness_ == 0.0) return "with stretchiness 0 the spine keeps its length";
    return {};
  }

  std::vector<dvec3> intended_curve(std::span<const double> control,
                                    std::size_t count) const override {
    assert(count >= 2);
    const Bend bend = bend_of(control);
    const EvenShape& shape = shape_at_steps(count);
    std::vector<dquat> frame(count);
    std::vector<dvec3> point(count);
    shape.solve(bend.shares(), &bend.field, frame, point);
    place(shape, control, point);
    return point;
  }

 private:
  Even(const SystemSpec& spec, const RestChain& chain, OptionReader read)
      : places_(read_even_places(read)),
        bones_(places_.bones()),
        limited_(read.word("limits", {"none", "human"}) == 1),
        share_ends_(limited_ ? places_.frame : std::vector<double>{1.0}),
        weights_(read_even_weights(read)),
        bone_(chain, spec.system),
        drawn_(chain.joint),
        shape_(drawn_, bone_.axes[1], bone_.axes[2], weights_, places_, share_ends_),
        joint_end_(places_.frame) {
    arms_on_top_ = read.word("arms", {"effector", "top"}) == 1;
    stretchiness_ = read.number("stretchiness", 0.0, 0.0, 1.0);
    max_ratio_ = read.number("max_ratio", 100.0, 1.0, 100.0);
    lead_ = read.number("lead", 0.0, 0.0, 1.0);
    no_squash_ = read.flag("no_squash", false);
    const double reach = read.number("reach", 0.0, 0.0, 1.0);
    max_joint_ = radians(read.number("max_joint_angle", 45.0, 1.0, 180.0));
    name_ = spec.system;
    take_options(read);
    if (limited_ && reach > 0.0) {
      read.refuse("reach", "cannot be combined with limits: it bends joints past them");
    }
    if (options_.contains("joints") && (limited_ || reach > 0.0)) {
      read.refuse("joints",
                  "cannot be combined with limits or reach, which share among equal bones");
    }
    measure_weights();
    set_bounds(reach);

    for (const char* control : {"lower", "middle", "top"}) add_rotation(control);
    add_scalar("stretch", 1.0);
    add_scalar("compression", 0.0);
    std::vector<std::string> names;
    for (int k = 0; k < bones_; ++k) names.push_back("spine_" + std::to_string(k + 1));
    names.push_back("tip");
    name_chain(std::move(names));
    arc_fraction_ = places_.joint;
    std::vector<double> control;
    for (const Channel& c : channels_) control.push_back(c.rest);
    SpinePose rest;
    fill(control, Detail::all, rest);
    rest_ = std::move(rest);
  }

  /// With reach or limits: the theorems' bound of each channel of Middle and Top (docs/even.md,
  /// theorem 4 and section 6), times how fast the channel itself moves. Lower turns all rigidly.
  BoxRates rates_on_paper(const BoxTurn& lower, std::span<const BoxReal> control) const {
    BoxRates rate{};
    for (std::size_t j = 0; j < rate.size(); ++j) {
      Interval sum(lower.rate[j]);
      for (int ch = 0; ch < kUpperChannels; ++ch) {
        const Interval& slope = control[std::size_t(kUpper + ch)].slope[j];
        sum = sum + Interval(std::max(std::abs(slope.lo), std::abs(slope.hi))) *
                        Interval(channel_bound_[ch]);
      }
      rate[j] = sum.hi;
    }
    return rate;
  }

  void measure_weights() {
    double from = 0.0;
    for (const double to : joint_end_) {
      UpperChannels step{};
      for (int ch = 0; ch < kUpperChannels; ++ch) {
        step[ch] = weights_.of(ch)(to) - weights_.of(ch)(from);
        peak_step_[ch] = std::max(peak_step_[ch], step[ch]);
      }
      joint_step_.push_back(step);
      from = to;
    }
  }

  void set_bounds(double reach) {
    reach_.emplace(reach, max_joint_, peak_step_, bones_);
    if (limited_) {
      std::vector<RangeOfMotion> range;
      double from = 0.0;
      for (const double to : joint_end_) {
        range.push_back(human_range(from, to));
        from = to;
      }
      limits_.emplace(weights_, joint_end_, range);
    }
    const auto& j = bone_.rest.joint;
    const double top = glm::length(j[3] - j[2]) / shape_.length();
    const double middle = top + glm::length(j[2] - j[1]) / shape_.length();
    for (int ch = 0; ch < kUpperChannels; ++ch) {
      // Under limits a Top channel also moves Middle's shares.
      channel_bound_[ch] = limited_
                               ? (ch < 3 ? 1.0 : EvenLimits::gain_bound())
                               : reach_->gain_bound(ch, weights_.of(ch), ch < 3 ? middle : top);
      gain_bound_ = std::max(gain_bound_, channel_bound_[ch]);
    }
  }

  /// The spine cut at `count` points at equal steps, kept: no pose changes it, and it takes longer
  /// to cut than to bend.
  const EvenShape& shape_at_steps(std::size_t count) const {
    const std::lock_guard lock(at_steps_lock_);
    const auto known = at_steps_.find(count);
    if (known != at_steps_.end()) return known->second;
    return at_steps_
        .try_emplace(count, drawn_, bone_.axes[1], bone_.axes[2], weights_,
                     equal_bones(int(count) - 1), share_ends_)
        .first->second;
  }

  /// How a pose bends the spine below Lower's turn.
  struct Bend {
    std::array<AngleShare, 1> one{};
    EvenLimits::Result limited{};  // with limits, its shares instead
    ReachField field{};

    std::span<const AngleShare> shares() const {
      if (limited.share.empty()) return one;
      return limited.share;
    }
  };

  Bend bend_of(std::span<const double> control) const {
    Bend bend;
    UpperChannels& upper = bend.one[0].scale;
    std::copy_n(control.begin() + kUpper, kUpperChannels, upper.begin());
    if (limits_) bend.limited = limits_->apply(upper);
    if (!reach_->off()) {
      const EvenShape::Moments m = shape_.moments(bend.shares());
      const double length = shape_.length();
      bend.field = reach_->field((three_bone_shift(control) - m.chest_shift) / length,
                                 {m.bump[0] / length, m.bump[1] / length}, upper);
    }
    return bend;
  }

  /// How far the three-bone tip moves from rest before Lower turns it; exactly 0 at rest.
  dvec3 three_bone_shift(std::span<const double> c) const {
    const auto& j = bone_.rest.joint;
    const dquat middle = euler_turn(bone_.axes[1], from_euler_xyz(c[3], c[4], c[5]));
    const dquat top = middle * euler_turn(bone_.axes[2], from_euler_xyz(c[6], c[7], c[8]));
    return turned_by(middle, j[2] - j[1]) + turned_by(top, j[3] - j[2]);
  }

  dquat lower_of(std::span<const double> control) const {
    return euler_turn(bone_.axes[0], from_euler_xyz(control[0], control[1], control[2]));
  }

  /// Lengths in units of the rest length: what the animator asks for, and what the spine takes.
  struct Length {
    double asked, used, ratio;
    bool clamped;
  };
  Length length_of(std::span<const double> control) const {
    constexpr double kMostCompression = 0.99;
    const double stretch = std::max(control[kStretch], 0.0);
    const double compression = std::clamp(control[kCompression], 0.0, kMostCompression);
    double ratio = std::min(1.0 + stretchiness_ * (stretch - 1.0), max_ratio_);
    if (no_squash_) ratio = std::max(ratio, 1.0);
    // With stretchiness 0 the spine keeps its length whatever is asked: there is nothing to lead.
    const double asked = stretchiness_ > 0.0 ? stretch : 1.0;
    return {asked, ratio * (1.0 - compression), ratio,
            stretch != control[kStretch] || compression != control[kCompression]};
  }

  /// Turns shifts of points at equal steps (EvenShape::solve) into their places: stretched about
  /// the hips, moved by what `lead` asks, turned by Lower.
  void place(const EvenShape& shape, std::span<const double> control,
             std::span<dvec3> point) const {
    const Length length = length_of(control);
    const dquat lower = lower_of(control);
    const dvec3 root = drawn_.front();
    const std::vector<dvec3>& rest = shape.rest_joint();
    const dvec3 whole = (rest.back() - root) + point.back();
    const dvec3 led = (lead_ * (length.asked - length.used)) * whole;
    for (std::size_t k = 0; k < point.size(); ++k) {
      const dvec3 arm = (rest[k] - root) + point[k];
      const dvec3 moved = point[k] + (length.used - 1.0) * arm + led;
      point[k] = rest[k] + (moved + turned_by(lower, (rest[k] - root) + moved));
    }
  }

  void fill(std::span<const double> control, Detail detail, SpinePose& pose) const override {
    const Bend bend = bend_of(control);
    pose.position.resize(bones_ + 1);
    pose.turn.resize(bones_ + 1);
    pose.flip_margin.clear();  // no pose is singular
    shape_.solve(bend.shares(), &bend.field, pose.turn, pose.position);
    place(shape_, control, pose.position);
    const dquat lower = lower_of(control);
    for (dquat& turn : pose.turn) turn = glm::normalize(lower * turn);

    pose.hip = {kNoTurn, drawn_.front(), pose.position.front()};
    // Top rides on the chest. What it asks for is what the tip carries unless a limit forbids it.
    pose.chest = {pose.turn.back(), drawn_.back(), pose.position.back()};
    if (limits_) {
      const double* c = control.data();
      pose.chest.turn =
          glm::normalize(lower * (euler_turn(bone_.axes[1], from_euler_xyz(c[3], c[4], c[5])) *
                                  euler_turn(bone_.axes[2], from_euler_xyz(c[6], c[7], c[8]))));
    }
    pose.arms = {arms_on_top_ ? pose.chest.turn : pose.turn.back(), drawn_.back(),
                 pose.position.back()};

    pose.flags.clear();
    const Length length = length_of(control);
    if (length.clamped)
      pose.flags.emplace_back("a length control is past its range and was clamped");
    pose.flags.insert(pose.flags.end(), bend.limited.flags.begin(), bend.limited.flags.end());
    MeasureWriter measures(pose);
    if (detail == Detail::all) measure(control, bend, length, pose, measures);
  }

  void measure(std::span<const double> control, const Bend& bend, const Length& length,
               const SpinePose& pose, MeasureWriter& out) const {
    add_chain_measures(pose.position, out);
    out.add("curve_length", length.used * shape_.length());
    out.add("rest_curve_length", shape_.length());
    out.add("ratio", length.ratio);
    out.add("volume", length.used > 0.0 ? 1.0 / std::sqrt(length.used) : 1.0);

    double joint = angle_between(lower_of(control), pose.turn[0]), chord = 0.0;
    for (int k = 0; k < bones_; ++k) {
      joint = std::max(joint, angle_between(pose.turn[k], pose.turn[k + 1]));
      const dvec3 rest = shape_.rest_joint()[k + 1] - shape_.rest_joint()[k];
      const dvec3 now = pose.position[k + 1] - pose.position[k];
      chord = std::max(chord, angle_between(pose.turn[k] * rest, now));
    }
    out.add("max_joint_deg", degrees(joint));
    out.add("joint_bound_deg", degrees(joint_bound(bend)));
    out.add("gain_bound", gain_bound_);
    out.add("chord_gap_deg", degrees(chord));
    const dvec3 last = pose.position.back() - pose.position[bones_ - 1];
    out.add("aim_gap_deg", degrees(angle_between(last, pose.chest.turn * bone_.axes[2][0])));
    const dquat drift = glm::conjugate(pose.chest.turn) * pose.arms.turn;
    out.add("arm_drift_twist_deg",
            degrees(std::abs(wrap(swing_twist(drift, bone_.axes[2][0]).twist_angle))));
    out.add("chest_gap_deg", degrees(angle_between(pose.turn.back(), pose.chest.turn)));
    const dvec3 asked = bone_.rest.joint[3] + three_bone_shift(control);
    const dvec3 tip = drawn_.front() + (asked - drawn_.front()) +
                      turned_by(lower_of(control), asked - drawn_.front());
    out.add("reach_gap", glm::length(tip - pose.position.back()));
    if (limits_) {
      double lost = 0.0;
      for (const double l : bend.limited.lost) lost = std::max(lost, std::abs(l));
      out.add("limit_loss_deg", degrees(lost));
      out.add("joints_at_limit", bend.limited.joints_at_limit);
    }
  }

  /// Upper bound of every joint's angle, hips and tip included: the sum of what each channel, and
  /// the reach, do over it.
  double joint_bound(const Bend& bend) const {
    const std::span<const AngleShare> share = bend.shares();
    double most = 0.0;
    for (std::size_t j = 0; j < joint_step_.size(); ++j) {
      const AngleShare& own = share[share.size() == 1 ? 0 : j];
      double sum = 0.0;
      for (int ch = 0; ch < kUpperChannels; ++ch) {
        sum += joint_step_[j][ch] * std::abs(own.scale[ch]);
      }
      most = std::max(most, sum);
    }
    return std::min(most + reach_->joint_share(bend.field), kPi);
  }

  EvenPlaces places_;
  int bones_;
  bool limited_;
  std::vector<double> share_ends_;
  EvenWeights weights_;
  FkBones bone_;
  std::vector<dvec3> drawn_;
  EvenShape shape_;
  mutable std::mutex at_steps_lock_;
  mutable std::map<std::size_t, EvenShape> at_steps_;  // by their number of points
  std::vector<double> joint_end_;
  std::vector<UpperChannels> joint_step_;  // weight over each joint
  UpperChannels peak_step_{};
  std::optional<EvenReach> reach_;
  std::optional<EvenLimits> limits_;
  UpperChannels channel_bound_{};  // of a frame's turn per turn of the channel
  double max_joint_ = 0.0, gain_bound_ = 1.0;
  bool arms_on_top_ = false, no_squash_ = false;
  double stretchiness_ = 0.0, max_ratio_ = 100.0, lead_ = 0.0;
};

}  // namespace

std::unique_ptr<SpineSystem> build_even(const SystemSpec& spec, const RestChain& chain) {
  return std::make_unique<Even>(spec, chain);
}

}  // namespace backbend::solver
