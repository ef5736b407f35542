#include "solver/systems/neck.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "solver/curves/box_course.h"
#include "solver/curves/curve.h"
#include "solver/math/rotation.h"
#include "solver/rig/box_solver.h"
#include "solver/rig/chain_measures.h"
#include "solver/rig/option_reader.h"
#include "solver/systems/system_base.h"

namespace backbend::solver {
namespace {

using glm::dquat;
using glm::dvec3;

struct Vertebra {
  std::string name;
  dquat rest{1, 0, 0, 0};
  dvec3 rest_at{0.0};
  dquat local{1, 0, 0, 0};                                // rest frame in the parent's
  dvec3 offset{0.0};                                      // rest pivot in the parent's frame
  double z = 0.0, base_y = 0.0, top_y = 0.0, roll = 0.0;  // shares of the controls
};

/// A stored frame as a rotation. Throws where its axes are not orthonormal to 1e-3: six digits in a
/// file are, a scaled or sheared joint is not.
dquat rotation_of(const RestFrame& frame) {
  const glm::dmat3 m(frame.rig_from_joint);
  for (int i = 0; i < 3; ++i) {
    const double size = glm::length(m[i]), slant = glm::dot(m[i], m[(i + 1) % 3]);
    if (!(std::abs(size - 1.0) < 1e-3) || !(std::abs(slant) < 1e-3)) {
      throw RigError("neck: the axes of '" + frame.name + "' are not orthonormal");
    }
  }
  if (!(glm::determinant(m) > 0.0)) {
    throw RigError("neck: the axes of '" + frame.name + "' are left-handed");
  }
  return glm::normalize(glm::quat_cast(m));
}

/// The seed's axes from a bone's: X back along the bone, Y to the right, Z out of the back.
dquat neck_axes(const dquat& bone_frame) {
  const double half = std::sqrt(0.5);
  return bone_frame * dquat(0.0, 0.0, half, -half);
}

class Neck final : public FormulaSystem, public BoxSolver {
  enum ChannelIndex { kBaseZ, kBaseY, kTopY, kRoll, kParent, kParentMove = kParent + 3 };

 public:
  Neck(const SystemSpec& spec, const RestChain& chain) : head_first_(!chain.frame.empty()) {
    name_ = spec.system;
    if (head_first_) {
      read_frames(chain);
    } else {
      read_joints(chain);
    }
    const int driven = int(vertebra_.size()) - 1;
    OptionReader read(spec);
    const bool normalised = read.word("gains", {"literal", "normalised"}) == 1;
    const int roll_count = read.integer("roll_count", driven + 1, driven, 1000);
    std::vector<double> z(driven), base(driven), top(driven);
    for (int i = 0; i < driven; ++i) {
      const double t = driven > 1 ? double(i) / (driven - 1) : 1.0;
      z[i] = 1.0 / 8.0;
      top[i] = 0.25 * t * t;
      base[i] = 0.25 * std::exp(-(3.5 * t - 1.0) * (3.5 * t - 1.0));
    }
    z = read_region(read, "z_weights", z, normalised, sum_z_);
    base = read_region(read, "base_weights", base, normalised, sum_base_);
    top = read_region(read, "top_weights", top, normalised, sum_top_);
    if (read.find("limits")) {
      limit_ = read.numbers("limits", {}, 4, 0.0, 3600.0);
    }
    read.keep("limits", limit_);
    for (double& limit : limit_) limit = radians(limit);
    take_options(read);

    for (int i = 1; i <= driven; ++i) {
      Vertebra& v = vertebra_[i];
      const Vertebra& parent = vertebra_[i - 1];
      v.z = z[i - 1];
      v.base_y = base[i - 1];
      v.top_y = top[i - 1];
      // The head, i = driven, takes the whole roll.
      v.roll = 1.0 - double(driven - i) / roll_count;
      v.local = glm::conjugate(parent.rest) * v.rest;
      v.offset = glm::conjugate(parent.rest) * (v.rest_at - parent.rest_at);
    }
    for (const char* name : {"base_z", "base_y", "top_y", "roll"}) {
      channels_.push_back({name, Channel::Kind::rotation, 0.0});
    }
    add_rotation("parent");
    add_translation("parent_move");
    name_joints();
    build_rest();
  }

  /// Channels are divided by their gains: the head turns by what is asked. All of a bend on the top
  /// control, or half on each; sideways and about the neck there is one control.
  std::vector<double> controls_for(const BodyPose& body, Mapping mapping) const override {
    return shared_out(body.extension - body.flexion, body.side, body.twist, mapping);
  }

  std::vector<BoxReal> controls_for(const BodyBox& body, Mapping mapping) const override {
    return shared_out(body.back, body.side, body.twist, mapping);
  }

  std::string why_not_on_boxes() const override {
    return limit_.empty() ? "" : "with limits its channels are clamped, which has no interval form";
  }

  void solve_box(std::span<const BoxReal> c, BoxPose& pose) const override {
    pose.rate.resize(vertebra_.size());
    walk<BoxMath>(c, [&](std::size_t i, const BoxTurn& turn, const BoxVector&) {
      pose.rate[output_of(i)] = turn.rate;
    });
  }

  std::string why_no_places() const override { return {}; }

  void place_box(std::span<const BoxReal> c, BoxPlaces& places) const override {
    const std::size_t count = vertebra_.size();
    places.turn.resize(count);
    places.position.resize(count);
    walk<BoxMath>(c, [&](std::size_t i, const BoxTurn& turn, const BoxVector& at) {
      places.turn[output_of(i)] = turn;
      places.position[output_of(i)] = at;
    });
    const std::size_t base = output_of(0), head = output_of(count - 1);
    places.hip = {places.turn[base], vertebra_.front().rest_at, places.position[base]};
    places.chest = {places.turn[head], vertebra_.back().rest_at, places.position[head]};
    places.arms = places.chest;
    places.ends_on_chest = places.arms_follow_chest = true;
  }

  std::string why_no_course() const override { return {}; }

  /// Its bones keep their lengths, so the curve's knots are the same at every pose.
  void course_over(const BodyBox& body, Mapping mapping, std::size_t points,
                   BoxCourse& course) const override {
    const std::vector<BoxReal> control = controls_for(body, mapping);
    std::vector<dvec3> pivot;
    for (const Vertebra& v : vertebra_) pivot.push_back(v.rest_at);
    std::vector<double> share = polyline_arcs(pivot);
    for (double& s : share) s /= share.back();
    std::vector<std::vector<BoxVector>> step;
    for (std::size_t i = 1; i < pivot.size(); ++i) step.push_back(steps_seen_from(i, control));
    const CurveMap map(CurveMap::Kind::interpolating, pivot.size(),
                       make_knots(pivot, KnotRule::chord));
    course = course_through_joints(map, points, share, step);
    course.from_last = head_first_;
  }

  std::string_view why_without(BodyChannel) const override {
    return "its four channels bend and roll the vertebrae above a parent that stays";
  }

  /// The natural cubic through the pivots, base first: a neck has no curve of its own.
  std::vector<dvec3> intended_curve(std::span<const double> control,
                                    std::size_t count) const override {
    SpinePose pose;
    fill(control, Detail::joints, pose);
    if (head_first_) std::reverse(pose.position.begin(), pose.position.end());
    if (pose.position.size() == 2) return equal_arc_points(Curve::polyline(pose.position), count);
    return equal_arc_points(
        Curve::interpolating(pose.position, make_knots(pose.position, KnotRule::chord)), count);
  }

 private:
  template <class Real>
  std::vector<Real> shared_out(const Real& back, const Real& side, const Real& twist,
                               Mapping mapping) const {
    const auto through = [](const Real& angle, double gain) {
      return gain > 0.0 ? angle / gain : Real(0.0);
    };
    const double top = mapping == Mapping::chest ? 1.0 : 0.5;
    std::vector<Real> control(channels_.size(), 0.0);
    control[kBaseZ] = through(side, sum_z_);
    control[kBaseY] = through((1.0 - top) * back, sum_base_);
    control[kTopY] = through(top * back, sum_top_);
    control[kRoll] = -twist;
    return control;
  }

  /// The vertebrae from the fixed parent up: `visit` gets number, turn from rest and place.
  template <class Math, class Visit>
  void walk(std::span<const typename Math::Real> c, const Visit& visit) const {
    using Turn = typename Math::Turn;
    using Vector = typename Math::Vector;
    const Vertebra& fixed = vertebra_.front();
    Turn frame = fixed.rest * from_euler_xyz(c[kParent], c[kParent + 1], c[kParent + 2]);
    Vector at = fixed.rest_at + Vector(c[kParentMove], c[kParentMove + 1], c[kParentMove + 2]);
    visit(0, normalize(frame * glm::conjugate(fixed.rest)), at);
    for (std::size_t i = 1; i < vertebra_.size(); ++i) {
      const Vertebra& v = vertebra_[i];
      const Turn carried = frame * share_of<Turn>(v, c);
      at = at + carried * Vector(v.offset);
      frame = normalize(carried * v.local);
      const Turn rolled = frame * turn_about(kAxisX, v.roll * c[kRoll]);
      visit(i, normalize(rolled * glm::conjugate(v.rest)), at);
    }
  }

  /// The steps up to all vertebrae but the first, in the frame that carries the one up to `own`.
  std::vector<BoxVector> steps_seen_from(std::size_t own, std::span<const BoxReal> c) const {
    std::vector<BoxVector> step(vertebra_.size() - 1);
    BoxTurn turn;
    for (std::size_t i = own; i < vertebra_.size(); ++i) {
      if (i > own) turn = turn * vertebra_[i - 1].local * share_of<BoxTurn>(vertebra_[i], c);
      step[i - 1] = turn * BoxVector(vertebra_[i].offset);
    }
    turn = BoxTurn();
    for (std::size_t i = own - 1; i > 0; --i) {
      turn = turn * conjugate(share_of<BoxTurn>(vertebra_[i + 1], c)) *
             glm::conjugate(vertebra_[i].local);
      step[i - 1] = turn * BoxVector(vertebra_[i].offset);
    }
    return step;
  }

  /// Base Y and top Y share an axis; Z comes last, about the parent's axes at its pivot.
  template <class Turn, class Controls>
  static Turn share_of(const Vertebra& v, const Controls& c) {
    return turn_about(kAxisZ, v.z * c[kBaseZ]) *
           turn_about(kAxisY, v.base_y * c[kBaseY] + v.top_y * c[kTopY]);
  }

  void read_frames(const RestChain& chain) {
    if (chain.frame.size() < 2) {
      throw RigError(name_ + ": the rest file has " + std::to_string(chain.frame.size()) +
                     " vertebrae, expected a fixed parent and one or more driven ones");
    }
    for (auto frame = chain.frame.rbegin(); frame != chain.frame.rend(); ++frame) {
      Vertebra v;
      v.name = frame->name;
      v.rest = rotation_of(*frame);
      v.rest_at = dvec3(frame->rig_from_joint[3]);
      vertebra_.push_back(std::move(v));
    }
    for (std::size_t i = 1; i < vertebra_.size(); ++i) {
      if (vertebra_[i].rest_at == vertebra_[i - 1].rest_at) {
        throw RigError(name_ + ": '" + vertebra_[i].name + "' and '" + vertebra_[i - 1].name +
                       "' are in one place");
      }
    }
  }

  void read_joints(const RestChain& chain) {
    check_chain(chain, name_, 2);
    const std::size_t last = chain.joint.size() - 1;
    for (std::size_t i = 0; i <= last; ++i) {
      Vertebra v;
      v.name = i == 0 ? "parent" : "vertebra_" + std::to_string(i);
      const std::size_t bone = std::min(i, last - 1);
      v.rest = neck_axes(rest_frame(chain.joint[bone + 1] - chain.joint[bone], chain.left));
      v.rest_at = chain.joint[i];
      vertebra_.push_back(std::move(v));
    }
  }

  /// A list of shares, base first, one for each driven vertebra, whose sum is the control's gain.
  static std::vector<double> read_region(OptionReader& read, const std::string& key,
                                         const std::vector<double>& fallback, bool normalised,
                                         double& sum) {
    std::vector<double> share = read.numbers(key, fallback, fallback.size(), 0.0, 1000.0);
    sum = 0.0;
    for (const double s : share) sum += s;
    if (!normalised) return share;
    if (!(sum > 0.0)) read.refuse(key, "has no share above 0 to normalise");
    for (double& s : share) s /= sum;
    sum = 1.0;
    return share;
  }

  std::size_t output_of(std::size_t vertebra) const {
    return head_first_ ? vertebra_.size() - 1 - vertebra : vertebra;
  }

  void name_joints() {
    const std::size_t count = vertebra_.size();
    joint_names_.resize(count);
    joint_parents_.resize(count);
    std::vector<dvec3> place;
    for (const Vertebra& v : vertebra_) place.push_back(v.rest_at);
    const std::vector<double> arc = polyline_arcs(place);
    arc_fraction_.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      joint_names_[output_of(i)] = vertebra_[i].name;
      joint_parents_[output_of(i)] = i == 0 ? -1 : int(output_of(i - 1));
      arc_fraction_[output_of(i)] = arc[i] / arc.back();
    }
  }

  void build_rest() {
    const std::vector<double> control(channels_.size(), 0.0);
    SpinePose rest;
    fill(control, Detail::all, rest);
    for (std::size_t i = 0; i < vertebra_.size(); ++i) {
      rest.position[output_of(i)] = vertebra_[i].rest_at;
      rest.turn[output_of(i)] = kNoTurn;
    }
    const dvec3 base = vertebra_.front().rest_at, head = vertebra_.back().rest_at;
    rest.hip = {kNoTurn, base, base};
    rest.chest = rest.arms = {kNoTurn, head, head};
    rest_ = std::move(rest);
  }

  void fill(std::span<const double> c, Detail detail, SpinePose& pose) const override {
    std::array<double, kParentMove + 3> own;
    bool limited[4];
    std::copy_n(c.begin(), own.size(), own.begin());
    for (std::size_t i = 0; i < 4; ++i) {
      if (!limit_.empty()) own[i] = std::clamp(c[i], -limit_[i], limit_[i]);
      limited[i] = own[i] != c[i];
    }
    const std::size_t count = vertebra_.size();
    pose.position.resize(count);
    pose.turn.resize(count);

    walk<PoseMath>(own, [&](std::size_t i, const dquat& turn, const dvec3& at) {
      pose.position[output_of(i)] = at;
      pose.turn[output_of(i)] = turn;
    });
    double worst_joint = 0.0;
    for (std::size_t i = 1; i < count; ++i) {
      worst_joint =
          std::max(worst_joint, angle_between(share_of<dquat>(vertebra_[i], own), kNoTurn));
    }
    pose.flip_margin.clear();  // sums of angles about fixed axes have no singular pose
    const dvec3 base = vertebra_.front().rest_at, head = vertebra_.back().rest_at;
    pose.hip = {pose.turn[output_of(0)], base, pose.position[output_of(0)]};
    pose.chest = {pose.turn[output_of(count - 1)], head, pose.position[output_of(count - 1)]};
    pose.arms = pose.chest;

    pose.flags.clear();
    for (int i = 0; i < 4; ++i) {
      if (limited[i]) pose.flags.push_back("'" + channels_[i].name + "' is past its limit");
    }
    MeasureWriter measures(pose);
    if (detail == Detail::joints) return;
    add_chain_measures(pose.position, measures);
    measures.add("head_turn_deg", degrees(angle_between(pose.hip.turn, pose.chest.turn)));
    measures.add("max_joint_deg", degrees(worst_joint));
    measures.add("gain_z", sum_z_);
    measures.add("gain_base_y", sum_base_);
    measures.add("gain_top_y", sum_top_);
  }

  bool head_first_;
  std::vector<Vertebra> vertebra_;  // the fixed parent, then base to head
  double sum_z_ = 0.0, sum_base_ = 0.0, sum_top_ = 0.0;
  std::vector<double> limit_;  // radians, of the first four channels; empty: none
};

}  // namespace

std::unique_ptr<SpineSystem> build_neck(const SystemSpec& spec, const RestChain& chain) {
  return std::make_unique<Neck>(spec, chain);
}

}  // namespace backbend::solver
