#include "solver/systems/stretchy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "solver/curves/box_course.h"
#include "solver/curves/box_walk.h"
#include "solver/curves/curve.h"
#include "solver/curves/walk.h"
#include "solver/math/bezier.h"
#include "solver/math/box_arc.h"
#include "solver/math/rotation.h"
#include "solver/rig/box_solver.h"
#include "solver/rig/chain_measures.h"
#include "solver/rig/option_reader.h"
#include "solver/systems/box_transport.h"
#include "solver/systems/fk_bones.h"
#include "solver/systems/hip_chest.h"
#include "solver/systems/system_base.h"

namespace backbend::solver {
namespace {

using glm::dquat;
using glm::dvec3;
using Cvs = std::array<dvec3, 4>;

enum class Form { bones, carve };
enum class Carve { span, literal };
enum class PastEnd { clamp, extend };
enum class TwistWay { none, spread };

constexpr double kMostCompression = 0.99;

class Stretchy final : public FormulaSystem, public BoxSolver {
  /// Twelve channels place the curve either way; the scalars follow.
  enum ChannelIndex { kStretchiness = HipChest::kChannels, kLead, kCompression, kSlide };

 public:
  Stretchy(const SystemSpec& spec, const RestChain& chain)
      : by_cvs_(!chain.curve.empty()), left_(chain.left) {
    name_ = spec.system;
    OptionReader read(spec);
    bones_ = read.integer("bones", 20, 1, 200);
    form_ = read.choice<Form>("form", {"bones", "carve"});
    carve_ = read.choice<Carve>("carve", {"span", "literal"});
    past_end_ = read.choice<PastEnd>("past_end", {"clamp", "extend"});
    twist_ = read.choice<TwistWay>("twist", {"none", "spread"});
    max_ratio_ = read.number("max_ratio", 100.0, 1.0, 100.0);
    no_squash_ = read.flag("no_squash", false);
    const double stretchiness = read.number("stretchiness", 1.0, 0.0, 1.0);
    const double lead = read.number("lead", 0.0, 0.0, 1.0);
    depth_ = read.numbers("depth", {0.4, 0.4}, 2, 0.0, 10.0);
    take_options(read);

    if (by_cvs_) {
      read_curve(chain);
    } else {
      read_joints(chain);
    }
    add_scalar("stretchiness", stretchiness);
    add_scalar("lead", lead);
    add_scalar("compression", 0.0);
    add_scalar("slide", 0.0);
    std::vector<std::string> names;
    for (int k = 0; k < bones_; ++k) names.push_back("bone_" + std::to_string(k + 1));
    names.push_back("tip");
    name_chain(std::move(names));
    build_rest();
  }

  std::vector<double> controls_for(const BodyPose& body, Mapping mapping) const override {
    std::vector<double> control = rest_control();
    if (!by_cvs_) {
      hip_chest_->set_body(body, mapping, control);
      return control;
    }
    // Chest turns about the curve's end and takes the CV before it along.
    const std::vector<double> top = fk_controls_for(body, Mapping::chest);
    const dquat turn =
        end_frame_ * from_euler_xyz(top[6], top[7], top[8]) * glm::conjugate(end_frame_);
    const dvec3 bent = mapping == Mapping::spread
                           ? stand_in_->pose(fk_controls_for(body, mapping)).joint[3]
                           : rest_cv_[3];
    const dvec3 end = bent + (body.stretch - 1.0) * (rest_cv_[3] - rest_cv_[0]);
    const Cvs cv{rest_cv_[0], rest_cv_[1], end + turn * (rest_cv_[2] - rest_cv_[3]), end};
    for (int i = 0; i < 4; ++i) {
      for (int axis = 0; axis < 3; ++axis) control[3 * i + axis] = cv[i][axis];
    }
    return control;
  }

  std::string why_not_on_boxes() const override {
    if (by_cvs_) return "a curve drawn by its CVs has no interval form yet";
    if (channels_[kLead].rest != 0.0) return "lead has no interval form yet";
    if (form_ == Form::carve && past_end_ == PastEnd::extend)
      return "past_end = \"extend\" has no interval form yet";
    if (depth_[0] == 0.0 || depth_[1] == 0.0)
      return "with a depth of 0 the curve has no velocity at its end, and a proof needs one";
    return {};
  }

  /// Each bone that is walked widens the next one's place.
  double smallest_box() const override { return form_ == Form::bones ? 0.3 : 1.0; }

  std::vector<BoxReal> controls_for(const BodyBox& body, Mapping mapping) const override {
    std::vector<BoxReal> control;
    for (const Channel& channel : channels_) control.emplace_back(channel.rest);
    hip_chest_->set_body(body, mapping, control);
    return control;
  }

  void solve_box(std::span<const BoxReal> control, BoxPose& pose) const override {
    pose.rate.clear();
    lay_box<BoxRoll>(control, [&](const BoxRoll& frame, const BoxVector&, const BoxReal& twist) {
      pose.rate.push_back(frame.rates(twist));
    });
    pose.rate.push_back(pose.rate.back());
    pose.only_rolls = moved_alone(control, 3);
  }

  std::string why_no_places() const override { return {}; }

  void place_box(std::span<const BoxReal> control, BoxPlaces& places) const override {
    places.turn.clear();
    places.position.clear();
    const LaidBox laid = lay_box<BoxTransport>(
        control, [&](const BoxTransport& frame, const BoxVector& joint, const BoxReal& twist) {
          const std::size_t k = places.turn.size();
          BoxTurn turn = frame.turn() * start_frame_;
          if (twist_ == TwistWay::spread) turn = turn * turn_about(kAxisX, twist);
          places.turn.push_back(turn * glm::conjugate(rest_bone_frame_[k]));
          places.position.push_back(joint);
        });
    places.turn.push_back(places.turn.back());
    places.position.push_back(laid.tip);
    places.hip = {laid.ends.hip_turn, rest_cv_[0], laid.ends.cv[0]};
    places.chest = {laid.ends.chest_turn, rest_cv_[3], laid.ends.cv[3]};
    places.arms = {places.turn.back(), rest_.position.back(), laid.tip};
    places.ends_on_chest = places.arms_follow_chest = false;
  }

  std::string_view why_without(BodyChannel channel) const override {
    if (by_cvs_ && channel == BodyChannel::hip)
      return "a curve drawn by its CVs has no hip control";
    return {};
  }

  std::string why_no_course() const override { return {}; }

  void course_over(const BodyBox& body, Mapping mapping, std::size_t,
                   BoxCourse& course) const override {
    const std::vector<BoxReal> control = controls_for(body, mapping);
    const BoxTangents curve = bezier_tangents(hip_chest_->ends(control).cv);
    const Taken taken = taken_over(control, curve.length());
    course = form_ == Form::bones
                 ? walked_course(curve, rest_bone_, taken.shortened.value)
                 : course_at_shares(curve, taken.whole ? curve.length().value : taken.used.value,
                                    arc_fraction_);
  }

  /// The part of the curve that the chain takes.
  std::vector<dvec3> intended_curve(std::span<const double> control,
                                    std::size_t count) const override {
    const Drawn drawn = draw(control);
    const Cut cut = cut_of(control, drawn.curve);
    double from = cut.u1 * drawn.curve.length(), to = cut.u2 * drawn.curve.length();
    if (form_ == Form::bones) {
      std::vector<dvec3> joint;
      const Walk walk = lay_bones(drawn, cut, joint, nullptr);
      from = walk.from_arc;
      to = walk.to_arc;
    } else if (past_end_ == PastEnd::clamp) {
      from = std::clamp(from, 0.0, drawn.curve.length());
      to = std::clamp(to, 0.0, drawn.curve.length());
    }
    std::vector<dvec3> point(count);
    for (std::size_t i = 0; i < count; ++i) {
      point[i] = drawn.curve.at_arc(from + (to - from) * (double(i) / double(count - 1))).position;
    }
    return point;
  }

 private:
  /// How much of its curve the chain takes, over a box of poses.
  struct Taken {
    BoxReal shortened;  // of bone lengths
    BoxReal used;       // length of curve, of a carved chain
    bool whole;         // all of it, whatever its length
  };
  Taken taken_over(std::span<const BoxReal> c, const BoxReal& length) const {
    const auto within = [](const BoxReal& x, double low, double high) {
      return x.value.lo >= low && x.value.hi <= high;
    };
    // A control past its range is clamped, which is not enclosed; nor are lead and slide.
    const bool ordinary = within(c[kStretchiness], 0.0, 1.0) && c[kLead].value.is_zero() &&
                          within(c[kCompression], 0.0, kMostCompression) &&
                          c[kSlide].value.is_zero();
    const BoxReal rest(rest_length_);
    BoxReal ratio = ((length - rest) * c[kStretchiness] + rest) / rest;
    ratio = smaller(ratio, max_ratio_);
    if (no_squash_) ratio = -smaller(-ratio, -1.0);
    const BoxReal shortened =
        ordinary ? ratio * (BoxReal(1.0) - c[kCompression]) : BoxReal::undefined();
    // Stretched as its curve is, the chain takes all of it, whatever its length.
    const BoxReal& own = c[kStretchiness];
    const bool whole = ordinary && form_ == Form::carve && carve_ == Carve::span &&
                       within(own, 1.0, 1.0) && c[kCompression].value.is_zero() &&
                       length.value.hi <= max_ratio_ * rest_length_ &&
                       (!no_squash_ || length.value.lo >= rest_length_);
    const BoxReal used = carve_ == Carve::span ? smaller(shortened * rest, length)
                                               : smaller(shortened, 1.0) * length;
    return {shortened, used, whole};
  }

  struct LaidBox {
    HipChest::BoxEnds ends;
    BoxVector tip;
  };
  /// The chain over a box of poses; `visit` gets each bone with the joint that it starts from and
  /// the twist about it.
  template <class Frame, class Visit>
  LaidBox lay_box(std::span<const BoxReal> c, const Visit& visit) const {
    const HipChest::BoxEnds ends = hip_chest_->ends(c);
    const BoxArc arc(ends.cv, 256);
    const BoxWalk walk(ends.cv);
    const Taken taken = taken_over(c, arc.length());
    const BoxReal twist = c[3] - c[0];
    Frame frame(ends.hip_turn, hip_chest_->rest_direction());
    BoxReal from(0.0);
    for (int k = 0; k < bones_; ++k) {
      BoxReal to;
      if (form_ == Form::bones) {
        to = walk.step(from, taken.shortened * rest_bone_[k]);
      } else if (taken.whole) {
        to = k + 1 == bones_ ? BoxReal(1.0) : arc.parameter_at_share((k + 1.0) / bones_);
      } else {
        to = smaller(arc.parameter_at(BoxReal((k + 1.0) / bones_) * taken.used), 1.0);
      }
      const BoxVector bone = walk.chord(from, to);
      frame.go(unit(bone));
      visit(frame, walk.point(from),
            twist_ == TwistWay::spread ? BoxReal((k + 1.0) / bones_) * twist : BoxReal(0.0));
      from = to;
    }
    return {ends, walk.point(from)};
  }

  void read_curve(const RestChain& chain) {
    if (chain.curve.size() != 4) {
      throw RigError(name_ + ": the rest curve has " + std::to_string(chain.curve.size()) +
                     " CVs, expected the 4 of a cubic Bezier");
    }
    for (int i = 0; i < 4; ++i) {
      rest_cv_[i] = chain.curve[i];
      for (int axis = 0; axis < 3; ++axis) {
        channels_.push_back({std::string("curve.") + "xyz"[axis] + std::to_string(i),
                             Channel::Kind::translation, rest_cv_[i][axis]});
      }
    }
    const double length = Curve::bezier(rest_cv_).length();
    if (!(length > 0.0) || !std::isfinite(length)) {
      throw RigError(name_ + ": the rest curve is a single point, or not finite");
    }
    // Only to know where a three-bone tip would be: the bones stand at thirds of the curve.
    RestChain bones{equal_arc_points(Curve::bezier(rest_cv_), 4), chain.left, {}, {}, {}};
    stand_in_.emplace(bones, name_);
  }

  void read_joints(const RestChain& chain) {
    hip_chest_.emplace(chain, name_, std::array{depth_[0], depth_[1]});
    rest_cv_ = hip_chest_->rest_cv();
    add_rotation("hip");
    add_rotation("chest");
    add_translation("hip_move");
    add_translation("chest_move");
  }

  std::vector<double> rest_control() const {
    std::vector<double> control;
    for (const Channel& channel : channels_) control.push_back(channel.rest);
    return control;
  }

  void build_rest() {
    const Curve curve = Curve::bezier(rest_cv_);
    rest_length_ = curve.length();
    std::vector<dvec3> joint = equal_arc_points(curve, std::size_t(bones_) + 1);
    rest_direction_.resize(bones_);
    for (int k = 0; k < bones_; ++k) {
      rest_bone_.push_back(glm::length(joint[k + 1] - joint[k]));
      if (!(rest_bone_[k] > 0.0)) {
        throw RigError(name_ + ": bone " + std::to_string(k + 1) + " has no length at rest");
      }
      rest_direction_[k] = (joint[k + 1] - joint[k]) / rest_bone_[k];
    }
    start_frame_ = by_cvs_ ? rest_frame(curve.tangent(0.0), left_) : hip_chest_->rest_frame();
    end_frame_ = by_cvs_ ? rest_frame(curve.tangent(1.0), left_) : hip_chest_->rest_frame();
    rest_bone_frame_.resize(bones_);
    transport_along(start_frame_, rest_direction_, rest_bone_frame_);
    for (int k = 0; k <= bones_; ++k) arc_fraction_.push_back(double(k) / bones_);

    SpinePose rest;
    fill(rest_control(), Detail::all, rest);
    rest.position = std::move(joint);
    std::fill(rest.turn.begin(), rest.turn.end(), kNoTurn);
    rest.hip = {kNoTurn, rest_cv_[0], rest_cv_[0]};
    rest.chest = {kNoTurn, rest_cv_[3], rest_cv_[3]};
    rest.arms = {kNoTurn, rest.position.back(), rest.position.back()};
    rest_ = std::move(rest);
  }

  struct Drawn {
    Curve curve;
    Cvs cv;
    dquat hip{1, 0, 0, 0}, chest{1, 0, 0, 0};  // turns of the controls
    double twist = 0.0;                        // of chest against hip, never wrapped
    double margin = kPi;  // of the hip's turn, where the curve gives it: radians to doubling back
  };

  Drawn draw(std::span<const double> c) const {
    if (!by_cvs_) {
      const HipChest::Ends e = hip_chest_->ends(c);
      return {Curve::bezier(e.cv), e.cv, e.hip_turn, e.chest_turn, e.twist};
    }
    Cvs cv;
    for (int i = 0; i < 4; ++i) cv[i] = {c[3 * i], c[3 * i + 1], c[3 * i + 2]};
    Drawn drawn{Curve::bezier(cv), cv};
    // The curve's ends turn as their tangents do, by the shortest arc.
    const dvec3 from = drawn.curve.tangent(0.0), to = drawn.curve.tangent(1.0);
    if (from != dvec3(0.0)) {
      drawn.hip = transport(start_frame_, from) * glm::conjugate(start_frame_);
      drawn.chest = transport(end_frame_, to) * glm::conjugate(end_frame_);
      drawn.margin = kPi - angle_between(x_axis(start_frame_), from);
    }
    return drawn;
  }

  /// How much of the curve the chain takes, and how it got there.
  struct Cut {
    double ratio;        // of bone lengths
    double shortened;    // ratio with compression
    double lead, slide;  // slide as far as the curve has room
    double u1, u2;       // arc fractions, before they are clamped to 0..1
    bool collapsed, clamped;
  };

  Cut cut_of(std::span<const double> c, const Curve& curve) const {
    const double s = std::clamp(c[kStretchiness], 0.0, 1.0);
    const double compression = std::clamp(c[kCompression], 0.0, kMostCompression);
    Cut cut{};
    cut.lead = std::clamp(c[kLead], 0.0, 1.0);
    cut.clamped = s != c[kStretchiness] || compression != c[kCompression] || cut.lead != c[kLead];
    const double length = curve.length();
    cut.ratio = std::min(((length - rest_length_) * s + rest_length_) / rest_length_, max_ratio_);
    if (no_squash_) cut.ratio = std::max(cut.ratio, 1.0);
    cut.shortened = cut.ratio * (1.0 - compression);
    cut.collapsed = !(length > 1e-12 * rest_length_);
    double fraction = cut.shortened;
    if (form_ == Form::bones || carve_ == Carve::span) {
      fraction = cut.collapsed ? 1.0 : cut.shortened * (rest_length_ / length);
    }
    cut.u1 = cut.lead * (1.0 - fraction);
    cut.u2 = fraction + cut.lead * (1.0 - fraction);
    // Sliding must not change the length, so it stops where an end of the chain meets the curve's.
    const double low = std::min(-cut.u1, 0.0), high = std::max(1.0 - cut.u2, 0.0);
    cut.slide = std::clamp(c[kSlide], low, high);
    cut.clamped = cut.clamped || cut.slide != c[kSlide];
    cut.u1 += cut.slide;
    cut.u2 += cut.slide;
    return cut;
  }

  Walk lay_bones(const Drawn& drawn, const Cut& cut, std::vector<dvec3>& joint,
                 WalkDetail* detail) const {
    std::vector<double> bone(rest_bone_);
    for (double& b : bone) b *= cut.shortened;
    const Curve backwards = Curve::bezier({drawn.cv[3], drawn.cv[2], drawn.cv[1], drawn.cv[0]});
    return walk_led(drawn.curve, backwards, bone, cut.lead, cut.slide * drawn.curve.length(), joint,
                    detail);
  }

  void carve(const Curve& curve, const Cut& cut, std::vector<dvec3>& joint) const {
    double from = cut.u1, to = cut.u2;
    if (past_end_ == PastEnd::clamp) {
      from = std::clamp(from, 0.0, 1.0);
      to = std::clamp(to, 0.0, 1.0);
    }
    joint.resize(bones_ + 1);
    for (int k = 0; k <= bones_; ++k) {
      // Ends exactly where the cut says; u1 + (u2 - u1) need not be u2.
      const double u = k == bones_ ? to : from + (to - from) * (double(k) / bones_);
      joint[k] = curve.at_fraction(u).position;
    }
  }

  void fill(std::span<const double> control, Detail detail, SpinePose& pose) const override {
    const Drawn drawn = draw(control);
    const Cut cut = cut_of(control, drawn.curve);
    WalkDetail walked_at;
    if (form_ == Form::bones) {
      lay_bones(drawn, cut, pose.position, &walked_at);
    } else {
      carve(drawn.curve, cut, pose.position);
    }

    std::vector<dvec3> direction(bones_);
    for (int k = 0; k < bones_; ++k) {
      if (cut.collapsed) {
        // No curve to follow: the rest's directions stand in, and bones keep their lengths.
        direction[k] = drawn.hip * rest_direction_[k];
        if (form_ == Form::bones) {
          pose.position[k + 1] = pose.position[k] + (cut.shortened * rest_bone_[k]) * direction[k];
        }
        continue;
      }
      const dvec3 bone = pose.position[k + 1] - pose.position[k];
      const double length = glm::length(bone);
      direction[k] = length > 0.0 ? bone / length : dvec3(0.0);
    }
    pose.turn.resize(bones_ + 1);
    const std::span<dquat> frame(pose.turn.data(), bones_);
    pose.flip_margin.resize(bones_ + 1);
    transport_along(glm::normalize(drawn.hip * start_frame_), direction, frame,
                    std::span(pose.flip_margin.data(), bones_));
    pose.flip_margin[bones_] = pose.flip_margin[bones_ - 1];
    for (int k = 0; k <= bones_; ++k) {
      // A bone turns with the joint at its far end.
      const double walk_margin =
          form_ == Form::bones ? walked_at.margin[std::min(k + 1, bones_)] : kPi;
      pose.flip_margin[k] =
          cut.collapsed ? 0.0 : std::min({pose.flip_margin[k], drawn.margin, walk_margin});
    }
    for (int k = 0; k < bones_; ++k) {
      if (twist_ == TwistWay::spread) {
        frame[k] = frame[k] * turn_about(kAxisX, drawn.twist * ((k + 1.0) / bones_));
      }
      frame[k] = glm::normalize(frame[k] * glm::conjugate(rest_bone_frame_[k]));
    }
    pose.turn[bones_] = pose.turn[bones_ - 1];

    pose.hip = {glm::normalize(drawn.hip), rest_cv_[0], drawn.cv[0]};
    pose.chest = {glm::normalize(drawn.chest), rest_cv_[3], drawn.cv[3]};
    pose.arms = {pose.turn.back(),
                 rest_.position.empty() ? pose.position.back() : rest_.position.back(),
                 pose.position.back()};
    pose.flags.clear();
    if (cut.collapsed)
      pose.flags.emplace_back("the curve is a single point: the rest's directions stand in");
    if (cut.clamped) pose.flags.emplace_back("a length control is past its range and was clamped");
    if (form_ == Form::carve && past_end_ == PastEnd::clamp && cut.u2 - cut.u1 > 1.0 + 1e-12) {
      pose.flags.emplace_back("the spine is longer than its curve: it was cut at the curve's ends");
    }
    MeasureWriter measures(pose);
    if (detail == Detail::all) measure(drawn, cut, pose, measures);
  }

  void measure(const Drawn& drawn, const Cut& cut, const SpinePose& pose,
               MeasureWriter& out) const {
    const dvec3 start = drawn.cv[0], end = drawn.cv[3];
    out.add("curve_length", drawn.curve.length());
    out.add("rest_curve_length", rest_length_);
    out.add("ratio", cut.ratio);
    out.add("volume", cut.shortened > 0.0 ? 1.0 / std::sqrt(cut.shortened) : 1.0);
    out.add("u1", cut.u1);
    out.add("u2", cut.u2);
    out.add("start_gap", glm::length(pose.position.front() - start));
    out.add("end_gap", glm::length(pose.position.back() - end));
    add_chain_measures(pose.position, out);
    out.add("bone_length", glm::length(pose.position[1] - pose.position[0]));
    out.add("tip_gap", glm::length(pose.position.back() - end));
    out.add("chest_gap_deg", degrees(angle_between(pose.turn.back(), pose.chest.turn)));
  }

  bool by_cvs_;
  dvec3 left_;
  int bones_ = 20;
  Form form_;
  Carve carve_;
  PastEnd past_end_;
  TwistWay twist_;
  double max_ratio_ = 100.0;
  bool no_squash_ = false;
  std::vector<double> depth_;
  Cvs rest_cv_{};
  dquat start_frame_{1, 0, 0, 0}, end_frame_{1, 0, 0, 0};  // of the rest curve
  double rest_length_ = 0.0;
  std::vector<double> rest_bone_;
  std::vector<dvec3> rest_direction_;
  std::vector<dquat> rest_bone_frame_;
  std::optional<HipChest> hip_chest_;  // drawn as joints
  std::optional<FkBones> stand_in_;    // drawn as CVs: where a three-bone tip would be
};

}  // namespace

std::unique_ptr<SpineSystem> build_stretchy(const SystemSpec& spec, const RestChain& chain) {
  return std::make_unique<Stretchy>(spec, chain);
}

}  // namespace backbend::solver
