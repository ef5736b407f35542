#include "solver/systems/matrix_blend.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "solver/curves/bent_chain.h"
#include "solver/curves/curve.h"
#include "solver/math/rotation.h"
#include "solver/rig/box_solver.h"
#include "solver/rig/chain_measures.h"
#include "solver/rig/option_reader.h"
#include "solver/systems/hip_chest.h"
#include "solver/systems/rigify_spine.h"
#include "solver/systems/system_base.h"

namespace backbend::solver {
namespace {

using glm::dquat;
using glm::dvec3;

enum class Style { rigify, mgear };

class MatrixBlend final : public FormulaSystem, public BoxSolver {
 public:
  MatrixBlend(const SystemSpec& spec, const RestChain& chain)
      : MatrixBlend(spec, chain, OptionReader(spec)) {}

  std::vector<double> controls_for(const BodyPose& body, Mapping mapping) const override {
    std::vector<double> control(channels_.size(), 0.0);
    hip_chest_.set_body(body, mapping, control);
    // Rigify's chest control bends the chain and is carried by it: it is moved to stretch alone.
    if (style_ == Style::rigify) {
      const dvec3 move = (body.stretch - 1.0) * (hip_chest_.rest_cv()[3] - hip_chest_.rest_cv()[0]);
      for (int i = 0; i < 3; ++i) control[9 + i] = move[i];
    }
    return control;
  }

  std::string why_not_on_boxes() const override {
    if (style_ == Style::rigify) return {};
    return "style = \"mgear\" has no interval form yet";
  }

  std::vector<BoxReal> controls_for(const BodyBox& body, Mapping) const override {
    std::vector<BoxReal> control(channels_.size(), BoxReal(0.0));
    control[3] = body.twist;
    control[4] = -body.side;
    control[5] = -body.back;
    return control;
  }

  void solve_box(std::span<const BoxReal> c, BoxPose& pose) const override {
    BoxPlaces places;
    place_box(c, places);
    pose.rate.clear();
    for (const BoxTurn& t : places.turn) pose.rate.push_back(t.rate);
  }

  std::string why_no_places() const override { return {}; }

  void place_box(std::span<const BoxReal> c, BoxPlaces& places) const override {
    const auto [hips, chest] = controls_over(c);
    places.turn.clear();
    if (halves_) {
      halves_->lay(hips, chest, places.position, places.turn);
    } else {
      const BoxVector step = (chest.move - hips.move) / BoxReal(double(bones_));
      places.position = {BoxVector(drawn_.front()) + hips.move};
      for (int k = 0; k < bones_; ++k) {
        places.turn.push_back(
            k + 1 < bones_ ? slerp_short(hips.turn, chest.turn, (double(k) + 1.0) / double(bones_))
                           : chest.turn);
        places.position.push_back(places.position.back() +
                                  places.turn.back() * BoxVector(drawn_[k + 1] - drawn_[k]) + step);
      }
      places.turn.push_back(places.turn.back());
    }
    const dvec3 rest_hip = hip_chest_.rest_cv()[0], rest_chest = hip_chest_.rest_cv()[3];
    places.hip = {hips.turn, rest_hip, places.position.front()};
    places.chest = {chest.turn, rest_chest, places.position.back()};
    places.arms = {places.turn.back(), rest_chest, places.position.back()};
    places.ends_on_chest = true;
    places.arms_follow_chest = !halves_;
  }

  std::string why_no_course() const override { return {}; }

  void course_over(const BodyBox& body, Mapping mapping, std::size_t points,
                   BoxCourse& course) const override {
    // Of a body pose's controls only the chest's turn is set.
    const BoxTurn chest = controls_over(controls_for(body, mapping))[1].turn;
    if (halves_) {
      course = held_course(halves_->bent(chest, points));
      return;
    }
    // The chain and the finer one start at the hips.
    BentChain chain;
    chain.turn = chest;
    const auto cut = [](const std::vector<dvec3>& joint) {
      std::vector<BentChain::Step> steps;
      for (std::size_t k = 0; k + 1 < joint.size(); ++k)
        steps.push_back({joint[k + 1] - joint[k], double(k + 1) / double(joint.size() - 1)});
      return steps;
    };
    chain.bone = cut(drawn_);
    chain.fine = cut(equal_arc_points(Curve::polyline(drawn_), points));
    course = held_course(chain);
  }

  std::vector<dvec3> intended_curve(std::span<const double> control,
                                    std::size_t count) const override {
    const HipChest::Ends ends = hip_chest_.ends(control);
    if (style_ == Style::mgear) return equal_arc_points(Curve::bezier(ends.cv), count);
    if (halves_) return halves_->fine_chain(hips_of(ends), chest_of(ends), count);
    // The chain with its bones cut ever finer: the turn grows evenly along it.
    const Curve path = Curve::polyline(drawn_);
    std::vector<dvec3> point;
    bend(ends, equal_arc_points(path, count), point, nullptr);
    return point;
  }

 private:
  using ControlBox = RigifySpine::ControlOf<BoxMath>;

  /// Of hips and chest.
  std::array<ControlBox, 2> controls_over(std::span<const BoxReal> c) const {
    return {ControlBox{hip_chest_.turn(c, 0), {c[6], c[7], c[8]}},
            ControlBox{hip_chest_.turn(c, 3), {c[9], c[10], c[11]}}};
  }

  MatrixBlend(const SystemSpec& spec, const RestChain& chain, OptionReader read)
      : bones_(read.integer("bones", 10, 1, 200)),
        style_(read.choice<Style>("style", {"rigify", "mgear"})),
        pivot_(pivot_of(read, bones_, style_)),
        hip_chest_(chain, spec.system, {1.0 / 3.0, 1.0 / 3.0}) {
    name_ = spec.system;
    take_options(read);
    draw(chain);
    if (pivot_ > 0) halves_.emplace(drawn_, pivot_, z_axis(hip_chest_.rest_frame()));
    add_rotation("hip");
    add_rotation("chest");
    add_translation("hip_move");
    add_translation("chest_move");
    std::vector<std::string> names;
    for (int k = 0; k < bones_; ++k) names.push_back("bone_" + std::to_string(k + 1));
    names.push_back("tip");
    name_chain(std::move(names));
    build_rest();
  }

  /// Rigify refuses a spine of fewer than three bones, or a pivot at an end of it.
  static std::size_t pivot_of(OptionReader& read, int bones, Style style) {
    if (style == Style::mgear) {
      if (read.find("pivot_pos")) read.refuse("pivot_pos", "is only of style = \"rigify\"");
      return 0;
    }
    return std::size_t(
        read.integer("pivot_pos", bones < 3 ? 0 : bones / 2, 0, bones < 3 ? 0 : bones - 1));
  }

  /// The rest joints: the drawn ones where there are as many, else cut from them at equal steps.
  /// mGear's are on the straight line of its handles.
  void draw(const RestChain& chain) {
    const dvec3 hip = hip_chest_.rest_cv()[0], chest = hip_chest_.rest_cv()[3];
    const bool own = style_ == Style::rigify && int(chain.joint.size()) == bones_ + 1;
    const Curve path =
        Curve::polyline(style_ == Style::rigify ? chain.joint : std::vector<dvec3>{hip, chest});
    drawn_ = own ? chain.joint : equal_arc_points(path, std::size_t(bones_) + 1);
    drawn_.front() = hip;
    drawn_.back() = chest;
    const std::vector<double> arc = polyline_arcs(drawn_);
    for (int k = 0; k <= bones_; ++k)
      arc_fraction_.push_back(own ? arc[k] / arc.back() : double(k) / bones_);
  }

  static RigifySpine::Control hips_of(const HipChest::Ends& ends) {
    return {ends.hip_turn, ends.hip_move};
  }
  static RigifySpine::Control chest_of(const HipChest::Ends& ends) {
    return {ends.chest_turn, ends.chest_move};
  }

  /// One chain from the hips: of n bones, bone k has (k + 1) / n of the turn from hip to chest, and
  /// an n-th of what chest moves more than hip.
  static void bend(const HipChest::Ends& ends, std::span<const dvec3> rest,
                   std::vector<dvec3>& joint, std::vector<dquat>* turn) {
    const std::size_t bones = rest.size() - 1;
    const dvec3 step = (ends.chest_move - ends.hip_move) / double(bones);
    joint.resize(bones + 1);
    joint[0] = ends.cv[0];
    for (std::size_t k = 0; k < bones; ++k) {
      const dquat q =
          slerp_short(ends.hip_turn, ends.chest_turn, (double(k) + 1.0) / double(bones));
      joint[k + 1] = joint[k] + q * (rest[k + 1] - rest[k]) + step;
      if (turn) (*turn)[k] = q;
    }
  }

  void build_rest() {
    const dvec3 hip = hip_chest_.rest_cv()[0], chest = hip_chest_.rest_cv()[3];
    SpinePose rest;
    fill(std::vector<double>(channels_.size(), 0.0), Detail::all, rest);
    rest.position = drawn_;
    std::fill(rest.turn.begin(), rest.turn.end(), kNoTurn);
    rest.hip = {kNoTurn, hip, hip};
    rest.chest = rest.arms = {kNoTurn, chest, chest};
    rest_ = std::move(rest);
  }

  void fill(std::span<const double> control, Detail detail, SpinePose& pose) const override {
    const HipChest::Ends ends = hip_chest_.ends(control);
    pose.turn.resize(bones_ + 1);
    pose.flip_margin.resize(bones_ + 1);
    double to_half_turn = kPi - angle_between(ends.hip_turn, ends.chest_turn);
    bool upless = false;
    if (halves_) {
      // Each control's turn is shared out from rest: neither knows of the other.
      to_half_turn = kPi - std::max(angle_between(kNoTurn, ends.hip_turn),
                                    angle_between(kNoTurn, ends.chest_turn));
      halves_->lay(hips_of(ends), chest_of(ends), pose);
    } else if (style_ == Style::rigify) {
      bend(ends, drawn_, pose.position, &pose.turn);
      for (int k = 0; k < bones_; ++k) {
        pose.turn[k] = glm::normalize(pose.turn[k]);
        pose.flip_margin[k] = k + 1 < bones_ ? to_half_turn : kPi;
      }
      pose.turn[bones_] = pose.turn[bones_ - 1];
      pose.flip_margin[bones_] = kPi;
    } else {
      upless = ride_curve(ends, to_half_turn, pose);
    }

    const dvec3 hip = hip_chest_.rest_cv()[0], chest = hip_chest_.rest_cv()[3];
    pose.hip = {ends.hip_turn, hip, halves_ ? pose.position.front() : ends.cv[0]};
    pose.chest = {ends.chest_turn, chest,
                  style_ == Style::rigify ? pose.position.back() : ends.cv[3]};
    pose.arms = {pose.turn.back(), chest, pose.position.back()};
    pose.flags.clear();
    if (upless)
      pose.flags.emplace_back(
          "an up vector lies along the curve: the shortest arc takes its place");
    if (to_half_turn < 1e-9) {
      pose.flags.emplace_back(
          halves_ ? "a control is half a turn from rest: either way round is as short"
                  : "hip and chest are half a turn apart: either way round is as short");
    }
    MeasureWriter measures(pose);
    if (detail == Detail::joints) return;
    add_chain_measures(pose.position, measures);
    measures.add("tip_gap", glm::length(pose.position.back() - pose.chest.posed_origin));
    measures.add("chest_gap_deg", degrees(angle_between(pose.turn.back(), ends.chest_turn)));
    measures.add("flip_margin_deg",
                 degrees(*std::min_element(pose.flip_margin.begin(), pose.flip_margin.end())));
  }

  /// mGear's joints on the curve. True where an up vector had to be replaced.
  bool ride_curve(const HipChest::Ends& ends, double to_half_turn, SpinePose& pose) const {
    const Curve curve = Curve::bezier(ends.cv);
    const dquat back = glm::conjugate(hip_chest_.rest_frame());
    bool upless = false;
    pose.position.resize(bones_ + 1);
    for (int k = 0; k <= bones_; ++k) {
      const double t = double(k) / bones_;
      const CurvePoint place = curve.at_fraction(t);
      const dquat q = slerp_short(ends.hip, ends.chest, t);
      // The blend's side axis stays the side; X is aimed along the curve.
      const dvec3 across = glm::cross(z_axis(q), place.tangent);
      const double sine = glm::length(across);
      dquat frame = q;
      if (sine > 1e-12) {
        const dvec3 y = across / sine;
        frame = glm::quat_cast(glm::dmat3(place.tangent, y, glm::cross(place.tangent, y)));
      } else if (place.tangent != dvec3(0.0)) {
        frame = transport(q, place.tangent);
        upless = true;
      }
      pose.position[k] = place.position;
      pose.turn[k] = glm::normalize(frame * back);
      const double margin = std::asin(std::min(1.0, sine));
      pose.flip_margin[k] = k > 0 && k < bones_ ? std::min(margin, to_half_turn) : margin;
    }
    return upless;
  }

  int bones_;
  Style style_;
  std::size_t pivot_;  // 0: one chain from the hips
  HipChest hip_chest_;
  std::vector<dvec3> drawn_;
  std::optional<RigifySpine> halves_;
};

}  // namespace

std::unique_ptr<SpineSystem> build_matrix_blend(const SystemSpec& spec, const RestChain& chain) {
  return std::make_unique<MatrixBlend>(spec, chain);
}

}  // namespace backbend::solver
