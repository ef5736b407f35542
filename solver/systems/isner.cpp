#include "solver/systems/isner.h"

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>
#include <optional>
#include <type_traits>

#include "solver/curves/box_course.h"
#include "solver/curves/curve.h"
#include "solver/math/bezier.h"
#include "solver/math/box_arc.h"
#include "solver/math/rotation.h"
#include "solver/rig/box_solver.h"
#include "solver/rig/chain_measures.h"
#include "solver/rig/option_reader.h"
#include "solver/systems/fk_bones.h"
#include "solver/systems/system_base.h"

namespace backbend::solver {
namespace {

using glm::dquat;
using glm::dvec3;

enum class Placement { interior, inclusive };
enum class Length { fixed, stretchy };
enum class Aim { project, shortest_arc, none };
enum class Slerp { shortest, raw };

class Isner final : public FormulaSystem, public BoxSolver {
  /// Channels in the order of solve().
  enum ChannelIndex {
    kHip = 0,
    kChest = 3,
    kHipMove = 6,
    kChestMove = 9,
    kHipDepth = 12,
    kChestDepth
  };

 public:
  Isner(const SystemSpec& spec, const RestChain& chain) : bones_(chain, spec.system) {
    name_ = spec.system;
    OptionReader read(spec);
    const int vertebrae = read.integer("vertebrae", 5, 1, 64);
    placement_ = read.choice<Placement>("placement", {"interior", "inclusive"});
    depth_ = read.numbers("depth", {0.4, 0.4}, 2, 0.0, 10.0);
    length_ = read.choice<Length>("length", {"fixed", "stretchy"});
    aim_ = read.choice<Aim>("aim", {"project", "shortest_arc", "none"});
    slerp_ = read.choice<Slerp>("slerp", {"shortest", "raw"});
    take_options(read);
    if (placement_ == Placement::inclusive && vertebrae < 2) {
      read.refuse("vertebrae", "is 1, expected 2 or more with placement \"inclusive\"");
    }

    hip_ = chain.joint.front();
    chest_ = chain.joint.back();
    rest_length_ = glm::length(chest_ - hip_);
    if (!(rest_length_ > 1e-6 * polyline_arcs(chain.joint).back())) {
      throw RigError(spec.system + ": the chain's ends coincide: hip and chest need a distance");
    }
    axes_ = rest_axes(chest_ - hip_, chain.left);

    add_rotation("hip");
    add_rotation("chest");
    add_translation("hip_move");
    add_translation("chest_move");
    add_scalar("hip_depth", depth_[0]);
    add_scalar("chest_depth", depth_[1]);
    place_vertebrae(vertebrae);
    build_rest();
  }

  std::vector<double> controls_for(const BodyPose& body, Mapping mapping) const override {
    std::vector<double> control;
    for (const Channel& channel : channels_) control.push_back(channel.rest);
    const std::vector<double> top = fk_controls_for(body, Mapping::chest);
    std::copy(top.end() - 3, top.end(), control.begin() + kChest);
    control[kHip + 2] = body.hip;
    dvec3 move = (body.stretch - 1.0) * (chest_ - hip_);
    if (mapping == Mapping::spread)
      move += bones_.pose(fk_controls_for(body, mapping)).joint[3] - bones_.rest.joint[3];
    for (int i = 0; i < 3; ++i) control[kChestMove + i] = move[i];
    return control;
  }

  std::string why_not_on_boxes() const override {
    if (slerp_ == Slerp::raw) return "slerp = \"raw\" has no interval form yet";
    if (aim_ != Aim::none && (depth_[0] == 0.0 || depth_[1] == 0.0)) {
      return "with a depth of 0 the curve has no velocity at its end, and a proof needs one";
    }
    return {};
  }

  std::vector<BoxReal> controls_for(const BodyBox& body, Mapping mapping) const override {
    std::vector<BoxReal> control;
    for (const Channel& channel : channels_) control.emplace_back(channel.rest);
    const std::span all(control);
    bones_.set_chest(body, mapping, all.subspan(kChest, 3), all.subspan(kChestMove, 3));
    return control;
  }

  void solve_box(std::span<const BoxReal> control, BoxPose& pose) const override {
    const Ends<BoxMath> e = ends<BoxMath>(control);
    const std::array<BoxVector, 4> cv = points(e);
    pose.rate.resize(arc_fraction_.size());
    std::optional<BoxArc> arc;
    if (aim_ != Aim::none) arc.emplace(cv);
    for (std::size_t i = 0; i < arc_fraction_.size(); ++i) {
      const double t = arc_fraction_[i];
      const BoxTurn q = t == 0.0 ? e.hip : t == 1.0 ? e.chest : slerp_short(e.hip, e.chest, t);
      if (aim_ == Aim::none) {
        pose.rate[i] = q.rate;
        continue;
      }
      const BoxVector velocity = bezier_derivative(cv, parameter(*arc, t));
      pose.rate[i] = aim_ == Aim::shortest_arc ? aimed(q, unit(velocity)).rate
                                               : rates_of_aim(velocity, q * axes_[1]);
    }
  }

  std::string why_no_places() const override { return {}; }

  void place_box(std::span<const BoxReal> control, BoxPlaces& places) const override {
    const Ends<BoxMath> e = ends<BoxMath>(control);
    const std::array<BoxVector, 4> cv = points(e);
    const BoxArc arc(cv);
    places.turn.clear();
    places.position.clear();
    for (const double t : arc_fraction_) {
      const BoxTurn q = t == 0.0 ? e.hip : t == 1.0 ? e.chest : slerp_short(e.hip, e.chest, t);
      const BoxReal u = parameter(arc, t);
      places.position.push_back(bezier_point(cv, u));
      const BoxVector velocity = bezier_derivative(cv, u);
      places.turn.push_back(aim_ == Aim::none ? q : aimed(q, unit(velocity)));
    }
    places.hip = {e.hip, hip_, e.hip_at};
    places.chest = {e.chest, chest_, e.chest_at};
    places.arms = {places.turn.back(), rest_.position.back(), places.position.back()};
    places.ends_on_chest = places.arms_follow_chest = false;
  }

  std::string why_no_course() const override { return {}; }

  void course_over(const BodyBox& body, Mapping mapping, std::size_t,
                   BoxCourse& course) const override {
    const BoxTangents curve = bezier_tangents(points(ends<BoxMath>(controls_for(body, mapping))));
    const Interval length = curve.length().value;
    course = course_at_shares(
        curve, length_ == Length::fixed ? smaller(length, rest_length_) : length, arc_fraction_);
  }

  /// The Bezier over the used length: what lies past it carries no vertebra.
  std::vector<dvec3> intended_curve(std::span<const double> control,
                                    std::size_t count) const override {
    const Curve curve = draw(ends(control));
    const double used = used_length(curve);
    std::vector<dvec3> point(count);
    for (std::size_t i = 0; i < count; ++i) {
      point[i] = curve.at_arc(used * double(i) / double(count - 1)).position;
    }
    return point;
  }

 private:
  template <class Math>
  struct Ends {
    typename Math::Turn hip, chest;                // from rest
    typename Math::Vector hip_along, chest_along;  // the controls' X axes
    typename Math::Vector hip_at, chest_at;
    typename Math::Real hip_depth, chest_depth;  // lengths
  };

  template <class Math = PoseMath>
  Ends<Math> ends(std::span<const typename Math::Real> c) const {
    const auto moved = [&](int i) { return typename Math::Vector(c[i], c[i + 1], c[i + 2]); };
    const auto turned = [&](int i) {
      return euler_turn(axes_, from_euler_xyz(c[i], c[i + 1], c[i + 2]));
    };
    const typename Math::Turn hip = turned(kHip), chest = turned(kChest);
    const typename Math::Vector along(axes_[0]);
    const auto carried = [&](const typename Math::Turn& turn, int i) {
      if constexpr (std::is_same_v<Math, PoseMath>)
        return turn * along;
      else  // a control's RX leaves its X axis where it is, which intervals do not see
        return euler_turn(axes_, from_euler_xyz(typename Math::Real(0.0), c[i + 1], c[i + 2])) *
               along;
    };
    return {hip,
            chest,
            carried(hip, kHip),
            carried(chest, kChest),
            hip_ + moved(kHipMove),
            chest_ + moved(kChestMove),
            c[kHipDepth] * rest_length_,
            c[kChestDepth] * rest_length_};
  }

  /// The Bezier's.
  template <class Math>
  std::array<typename Math::Vector, 4> points(const Ends<Math>& e) const {
    return {e.hip_at, e.hip_at + e.hip_depth * e.hip_along,
            e.chest_at - e.chest_depth * e.chest_along, e.chest_at};
  }

  /// orient() over a box, but for what aims nowhere.
  BoxTurn aimed(const BoxTurn& q, const BoxVector& tangent) const {
    if (aim_ == Aim::shortest_arc) return shortest_arc(q * axes_[0], tangent, q * axes_[2]) * q;
    const BoxVector across = cross(tangent, q * axes_[1]), z = unit(across);
    const BoxVector frame[3] = {tangent, cross(z, tangent), z};
    // Where that frame takes the axes of rig space.
    const auto taken = [&](int i) {
      return BoxReal(axes_[0][i]) * frame[0] + BoxReal(axes_[1][i]) * frame[1] +
             BoxReal(axes_[2][i]) * frame[2];
    };
    return turn_to_axes(taken(0), taken(1), taken(2));
  }

  Curve draw(const Ends<PoseMath>& e) const { return Curve::bezier(points(e)); }

  /// Where arc fraction t of the used length is, over a box of poses.
  BoxReal parameter(const BoxArc& arc, double t) const {
    if (t == 0.0) return 0.0;
    const bool fixed = length_ == Length::fixed, fits = arc.length().value.hi <= rest_length_;
    if (t == 1.0) {
      if (!fixed || fits) return 1.0;
      return smaller(arc.parameter_at(rest_length_), 1.0);
    }
    if (!fixed || fits) return arc.parameter_at_share(t);
    const BoxReal used = smaller(arc.length(), rest_length_);
    return smaller(arc.parameter_at(BoxReal(t) * used), 1.0);
  }

  double used_length(const Curve& curve) const {
    return length_ == Length::fixed ? std::min(curve.length(), rest_length_) : curve.length();
  }

  /// Arc fraction and slerp weight of each joint, one and the same number (spec 4.3).
  void place_vertebrae(int vertebrae) {
    std::vector<std::string> names;
    for (int i = 0; i < vertebrae; ++i) {
      names.push_back("vertebra_" + std::to_string(i + 1));
      arc_fraction_.push_back(placement_ == Placement::interior ? double(i + 1) / (vertebrae + 1)
                                                                : double(i) / (vertebrae - 1));
    }
    if (placement_ == Placement::interior) {
      names.push_back("top_vertebra");
      arc_fraction_.push_back(1.0);
    }
    name_chain(names);
  }

  void build_rest() {
    std::vector<double> control;
    for (const Channel& channel : channels_) control.push_back(channel.rest);
    fill(control, Detail::all, rest_);
    std::fill(rest_.turn.begin(), rest_.turn.end(), kNoTurn);
    rest_.hip.turn = rest_.chest.turn = rest_.arms.turn = kNoTurn;
    // The axis is straight, but one piece of a Bezier gives it back with rounding.
    for (std::size_t i = 0; i < arc_fraction_.size(); ++i) {
      rest_.position[i] = hip_ + arc_fraction_[i] * (chest_ - hip_);
    }
    rest_.arms.rest_origin = rest_.arms.posed_origin = rest_.position.back();
  }

  /// A vertebra's turn from rest, and how far it is from a singular pose.
  struct Oriented {
    dquat turn;
    double margin;
    bool fell_back;
  };
  Oriented orient(const dquat& hip, const dquat& chest, double t, const dvec3& tangent) const {
    const dquat q =
        slerp_ == Slerp::shortest ? slerp_short(hip, chest, t) : slerp_raw(hip, chest, t);
    // The slerp itself jumps where its two ways round are equally long; its ends never do.
    double margin = kPi;
    if (t > 0.0 && t < 1.0) {
      margin = slerp_ == Slerp::shortest ? kPi - angle_between(hip, chest)
                                         : 2.0 * kPi - 4.0 * std::atan2(glm::length(chest - hip),
                                                                        glm::length(chest + hip));
    }
    if (aim_ == Aim::none || tangent == dvec3(0.0)) return {q, margin, aim_ != Aim::none};
    const dvec3 along = q * axes_[0], left = q * axes_[2];
    if (aim_ == Aim::shortest_arc) {
      margin = std::min(margin, kPi - angle_between(along, tangent));
      return {glm::normalize(shortest_arc(along, tangent, left) * q), margin, false};
    }
    const dvec3 side = glm::cross(tangent, q * axes_[1]);
    const double sine = glm::length(side);
    margin = std::min(margin, std::asin(std::min(1.0, sine)));
    // With the up vector on the tangent to the last digit, no side is right. The pose itself counts
    // as past the flip, so that a sweep which lands on it shows it.
    const bool singular = !(sine > 1e-12);
    const dvec3 z =
        singular ? glm::normalize(glm::dot(left, tangent) * tangent - left) : side / sine;
    const glm::dmat3 turn = glm::dmat3(tangent, glm::cross(z, tangent), z) * glm::transpose(axes_);
    return {glm::normalize(glm::quat_cast(turn)), margin, singular};
  }

  /// How far the curve is from having no direction at `place`, as a margin in radians. The tangent
  /// follows a control that moves by a rest length at 6 / |C'| through the curve's shape and at its
  /// curvature through the place's own way along it, all in rest lengths. Up to 50 times the
  /// control's move that is bending (of body poses to 180 degrees of extension and twist and 60 to
  /// the side, nine in ten stay below 30 everywhere); past it the margin falls from half a turn
  /// with the square.
  ///
  /// A spine drawn without depth has no velocity at its ends, and a direction all the same: it is
  /// singular only for the depth itself, and counts as far from any flip.
  double cusp_margin(const Curve& curve, const CurvePoint& place) const {
    constexpr double kBending = 50.0;
    const dvec3 velocity = curve.derivative(place.u) / rest_length_;
    const double speed = glm::length(velocity);
    if (!(speed > 0.0)) return place.u > 0.0 && place.u < 1.0 ? 0.0 : kPi;
    double gain = 6.0 / speed;
    if (place.overrun == 0.0) {
      const dvec3 along = velocity / speed;
      const dvec3 bend = curve.second_derivative(place.u) / rest_length_;
      gain += glm::length(glm::cross(along, bend)) / speed / speed;
    }
    const double share = std::min(1.0, kBending / gain);
    return kPi * share * share;
  }

  void fill(std::span<const double> control, Detail detail, SpinePose& pose) const override {
    const Ends<PoseMath> e = ends(control);
    const Curve curve = draw(e);
    const double used = used_length(curve);
    const std::size_t count = arc_fraction_.size();
    pose.position.resize(count);
    pose.turn.resize(count);
    pose.flip_margin.resize(count);
    bool fell_back = false;
    for (std::size_t i = 0; i < count; ++i) {
      const double t = arc_fraction_[i];
      const CurvePoint place = curve.at_arc(used * t);
      Oriented o = orient(e.hip, e.chest, t, place.tangent);
      if (aim_ != Aim::none) o.margin = std::min(o.margin, cusp_margin(curve, place));
      pose.position[i] = place.position;
      pose.turn[i] = o.turn;
      pose.flip_margin[i] = o.margin;
      fell_back |= o.fell_back;
    }
    const dvec3 rest_top = rest_.position.empty() ? pose.position.back() : rest_.position.back();
    pose.hip = {e.hip, hip_, e.hip_at};
    pose.chest = {e.chest, chest_, e.chest_at};
    pose.arms = {pose.turn.back(), rest_top, pose.position.back()};

    pose.flags.clear();
    if (fell_back)
      pose.flags.push_back(
          "an up vector lies along the curve: its vertebra is shown as just flipped");
    if (used < curve.length() * (1.0 - 1e-12)) {
      pose.flags.push_back(
          "the curve is longer than the spine: the top vertebra stops short of the chest");
    }

    MeasureWriter measures(pose);
    if (detail == Detail::joints) return;
    measures.add("curve_length", curve.length());
    measures.add("rest_curve_length", rest_length_);
    measures.add("used_length", used);
    add_chain_measures(pose.position, measures);
    measures.add("tip_gap", glm::length(pose.position.back() - e.chest_at));
    measures.add("chest_gap_deg", degrees(angle_between(pose.turn.back(), pose.chest.turn)));
    measures.add("flip_margin_deg",
                 degrees(*std::min_element(pose.flip_margin.begin(), pose.flip_margin.end())));
  }

  FkBones bones_;  // only to know where a three-bone tip would be (Mapping::spread)
  Placement placement_;
  std::vector<double> depth_;
  Length length_;
  Aim aim_;
  Slerp slerp_;
  dvec3 hip_, chest_;
  double rest_length_ = 0.0;
  glm::dmat3 axes_;  // hip and chest at rest: X along the spine, Y forward, Z left
};

}  // namespace

std::unique_ptr<SpineSystem> build_isner(const SystemSpec& spec, const RestChain& chain) {
  return std::make_unique<Isner>(spec, chain);
}

}  // namespace backbend::solver
