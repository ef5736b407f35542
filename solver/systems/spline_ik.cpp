#include "solver/systems/spline_ik.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "solver/curves/box_course.h"
#include "solver/curves/walk.h"
#include "solver/math/bezier.h"
#include "solver/math/box_arc.h"
#include "solver/math/rotation.h"
#include "solver/rig/box_solver.h"
#include "solver/rig/chain_measures.h"
#include "solver/rig/option_reader.h"
#include "solver/systems/box_transport.h"
#include "solver/systems/hip_chest.h"
#include "solver/systems/system_base.h"

namespace backbend::solver {
namespace {

using glm::dquat;
using glm::dvec3;

enum class Twist { fk_roll, spread };
enum class YScale { fit_curve, none };

class SplineIk final : public FormulaSystem, public BoxSolver {
 public:
  SplineIk(const SystemSpec& spec, const RestChain& chain)
      : SplineIk(spec, chain, OptionReader(spec)) {}

  std::vector<double> controls_for(const BodyPose& body, Mapping mapping) const override {
    std::vector<double> control(channels_.size(), 0.0);
    hip_chest_.set_body(body, mapping, control);
    return control;
  }

  std::string why_not_on_boxes() const override {
    if (twist_ == Twist::spread) return "twist = \"spread\" has no interval form yet";
    if (y_scale_ == YScale::none) return "y_scale_mode = \"none\" has no interval form yet";
    if (resolution_ > 0) return "a curve of straight pieces has no interval form yet";
    if (depth_[0] == 0.0 || depth_[1] == 0.0)
      return "with a depth of 0 the curve has no velocity at its end, and a proof needs one";
    return {};
  }

  std::vector<BoxReal> controls_for(const BodyBox& body, Mapping mapping) const override {
    std::vector<BoxReal> control(channels_.size(), BoxReal(0.0));
    hip_chest_.set_body(body, mapping, control);
    return control;
  }

  void solve_box(std::span<const BoxReal> control, BoxPose& pose) const override {
    pose.rate.clear();
    lay_box<BoxRoll>(control, [&](const BoxRoll& frame, const BoxVector&) {
      pose.rate.push_back(frame.rates());
    });
    pose.rate.push_back(pose.rate.back());
  }

  std::string why_no_places() const override { return {}; }

  void place_box(std::span<const BoxReal> control, BoxPlaces& places) const override {
    places.turn.clear();
    places.position.clear();
    const HipChest::BoxEnds ends =
        lay_box<BoxTransport>(control, [&](const BoxTransport& frame, const BoxVector& joint) {
          places.turn.push_back(frame.turn());
          places.position.push_back(joint);
        });
    places.turn.push_back(places.turn.back());
    places.position.push_back(ends.cv[3]);
    const dvec3 rest_hip = hip_chest_.rest_cv()[0], rest_chest = hip_chest_.rest_cv()[3];
    places.hip = {ends.hip_turn, rest_hip, ends.cv[0]};
    places.chest = {ends.chest_turn, rest_chest, ends.cv[3]};
    places.arms = {places.turn.back(), rest_chest, places.position.back()};
    places.ends_on_chest = true;
    places.arms_follow_chest = false;
  }

  std::string why_no_course() const override { return {}; }

  void course_over(const BodyBox& body, Mapping mapping, std::size_t,
                   BoxCourse& course) const override {
    const BoxTangents curve = bezier_tangents(hip_chest_.ends(controls_for(body, mapping)).cv);
    course = course_at_shares(curve, curve.length().value, arc_fraction_);
  }

  /// The part of the curve that the chain takes, straight on where it is longer.
  std::vector<dvec3> intended_curve(std::span<const double> control,
                                    std::size_t count) const override {
    const Curve curve = Curve::bezier(hip_chest_.ends(control).cv);
    if (y_scale_ == YScale::fit_curve) return equal_arc_points(curve, count);
    std::vector<dvec3> joint, point(count);
    const double used = walk_from(curve, bone_, 0.0, joint).to_arc;
    for (std::size_t i = 0; i < count; ++i) {
      point[i] = curve.at_arc(used * (double(i) / double(count - 1))).position;
    }
    return point;
  }

 private:
  SplineIk(const SystemSpec& spec, const RestChain& chain, OptionReader read)
      : bones_(read.integer("bones", 10, 1, 200)),
        twist_(read.choice<Twist>("twist", {"fk_roll", "spread"})),
        y_scale_(y_scale_of(read, twist_)),
        resolution_(read.integer("resolution_u", 0, 0, 1024)),
        depth_(depth_of(read)),
        hip_chest_(chain, spec.system, depth_) {
    name_ = spec.system;
    take_options(read);
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

  /// Lays the bones over a box of poses; `visit` gets each with the joint that it starts from.
  template <class Frame, class Visit>
  HipChest::BoxEnds lay_box(std::span<const BoxReal> control, const Visit& visit) const {
    const HipChest::BoxEnds ends = hip_chest_.ends(control);
    const BoxArc arc(ends.cv, 64);
    Frame frame(ends.hip_turn, hip_chest_.rest_direction());
    BoxReal from(0.0);
    for (int k = 0; k < bones_; ++k) {
      const BoxReal to =
          k + 1 == bones_ ? BoxReal(1.0) : arc.parameter_at_share(arc_fraction_[k + 1]);
      const BoxVector bone = bezier_chord(ends.cv, from, to);
      frame.go(unit(bone));
      visit(frame, bezier_point(ends.cv, from));
      from = to;
    }
    return ends;
  }

  /// The default is that of the package whose twist it is: Blender's constraint scales the bones to
  /// fit the curve, Maya's handle leaves them as long as they are.
  static YScale y_scale_of(OptionReader& read, Twist twist) {
    if (twist == Twist::fk_roll) return read.choice<YScale>("y_scale_mode", {"fit_curve", "none"});
    return read.word("y_scale_mode", {"none", "fit_curve"}) == 0 ? YScale::none : YScale::fit_curve;
  }

  static std::array<double, 2> depth_of(OptionReader& read) {
    const auto depth = read.numbers("depth", {0.4, 0.4}, 2, 0.0, 10.0);
    return {depth[0], depth[1]};
  }

  void build_rest() {
    const dvec3 hip = hip_chest_.rest_cv()[0], chest = hip_chest_.rest_cv()[3];
    bone_.assign(bones_, hip_chest_.rest_length() / bones_);
    for (int k = 0; k <= bones_; ++k) arc_fraction_.push_back(double(k) / bones_);
    SpinePose rest;
    fill(std::vector<double>(channels_.size(), 0.0), Detail::all, rest);
    for (int k = 0; k <= bones_; ++k) {
      rest.position[k] = k == bones_ ? chest : hip + arc_fraction_[k] * (chest - hip);
      rest.turn[k] = kNoTurn;
    }
    rest.hip = {kNoTurn, hip, hip};
    rest.chest = rest.arms = {kNoTurn, chest, chest};
    rest_ = std::move(rest);
  }

  /// What the bones are laid on: the Bezier, or the straight pieces between points at equal steps
  /// of its parameter that Blender draws of it.
  Curve drawn(const std::array<dvec3, 4>& cv) const {
    const Curve curve = Curve::bezier(cv);
    if (resolution_ == 0) return curve;
    std::vector<dvec3> point;
    for (int i = 0; i <= resolution_; ++i) point.push_back(curve.point(double(i) / resolution_));
    return Curve::polyline(point);
  }

  /// Places the joints; `margin` gets what each bone's end lacks to a jump, radians. Returns the
  /// length of curve that the chain takes.
  double place(const Curve& curve, std::vector<dvec3>& joint, std::vector<double>& margin) const {
    if (y_scale_ == YScale::none) {
      WalkDetail walked_at;
      const double used = walk_from(curve, bone_, 0.0, joint, &walked_at).to_arc;
      margin = std::move(walked_at.margin);
      return used;
    }
    joint.resize(bones_ + 1);
    margin.assign(bones_ + 1, kPi);
    std::vector<double> arc(arc_fraction_);
    for (double& a : arc) a *= curve.length();
    curve.points_at_arcs(arc, joint);
    for (int k = 0; k < bones_; ++k) {
      // A bone whose piece of curve folds back on itself shrinks, and at nothing may point
      // anywhere.
      const double piece = arc[k + 1] - arc[k];
      const double left = piece > 0.0 ? 2.0 * glm::distance(joint[k], joint[k + 1]) / piece : 0.0;
      margin[k + 1] = std::min(margin[k], kPi * std::min(1.0, left * left));
    }
    return curve.length();
  }

  void fill(std::span<const double> control, Detail detail, SpinePose& pose) const override {
    const HipChest::Ends ends = hip_chest_.ends(control);
    const Curve curve = drawn(ends.cv);
    std::vector<double> place_margin;
    const double used = place(curve, pose.position, place_margin);

    std::vector<dvec3> direction(bones_);
    for (int k = 0; k < bones_; ++k) {
      const dvec3 bone = pose.position[k + 1] - pose.position[k];
      const double length = glm::length(bone);
      direction[k] = length > 0.0 ? bone / length : dvec3(0.0);
    }
    pose.turn.resize(bones_ + 1);
    pose.flip_margin.resize(bones_ + 1);
    const std::span<dquat> frame(pose.turn.data(), bones_);
    transport_along(ends.hip, direction, frame, std::span(pose.flip_margin.data(), bones_));
    const double fold_margin = pose.flip_margin[bones_ - 1];
    for (int k = 0; k < bones_; ++k) {
      // A bone turns with the joint at its far end.
      pose.flip_margin[k] = std::min(pose.flip_margin[k], place_margin[k + 1]);
    }
    double residual = 0.0;
    if (twist_ == Twist::spread) {
      const dquat last = frame[bones_ - 1];
      const dquat left = glm::conjugate(last) * ends.chest;
      residual = wrap(swing_twist(left, kAxisX).twist_angle);
      for (int k = 0; k < bones_; ++k) {
        // The first bone keeps hip's roll, the last takes all that is left.
        const double share = bones_ > 1 ? double(k) / (bones_ - 1) : 1.0;
        frame[k] = frame[k] * turn_about(kAxisX, share * residual);
        if (share > 0.0 && share < 1.0) {
          pose.flip_margin[k] = std::min(pose.flip_margin[k], kPi - std::abs(residual));
        }
      }
    }
    const dquat back = glm::conjugate(hip_chest_.rest_frame());
    for (dquat& f : frame) f = glm::normalize(f * back);
    pose.turn[bones_] = pose.turn[bones_ - 1];
    pose.flip_margin[bones_] = pose.flip_margin[bones_ - 1];

    const dvec3 hip = hip_chest_.rest_cv()[0], chest = hip_chest_.rest_cv()[3];
    pose.hip = {ends.hip_turn, hip, ends.cv[0]};
    pose.chest = {ends.chest_turn, chest, ends.cv[3]};
    pose.arms = {pose.turn.back(), chest, pose.position.back()};
    pose.flags.clear();
    if (fold_margin < 1e-9) pose.flags.emplace_back("a bone doubles back on the one before");
    if (used > curve.length() * (1.0 + 1e-12)) {
      pose.flags.emplace_back("the bones are longer than the curve and run past its end");
    }
    MeasureWriter measures(pose);
    if (detail == Detail::joints) return;
    measures.add("curve_length", curve.length());
    measures.add("rest_curve_length", hip_chest_.rest_length());
    measures.add("used_length", used);
    add_chain_measures(pose.position, measures);
    measures.add("tip_gap", glm::length(pose.position.back() - ends.cv[3]));
    measures.add("residual_twist_deg", degrees(residual));
    measures.add("chest_gap_deg", degrees(angle_between(pose.turn.back(), ends.chest_turn)));
    measures.add("flip_margin_deg",
                 degrees(*std::min_element(pose.flip_margin.begin(), pose.flip_margin.end())));
  }

  int bones_;
  Twist twist_;
  YScale y_scale_;
  int resolution_;  // 0: the curve itself
  std::array<double, 2> depth_;
  HipChest hip_chest_;
  std::vector<double> bone_;
};

}  // namespace

std::unique_ptr<SpineSystem> build_spline_ik(const SystemSpec& spec, const RestChain& chain) {
  return std::make_unique<SplineIk>(spec, chain);
}

}  // namespace backbend::solver
