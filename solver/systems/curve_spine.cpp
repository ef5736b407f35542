#include "solver/systems/curve_spine.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "solver/curves/box_course.h"
#include "solver/curves/box_curve.h"
#include "solver/curves/box_tangents.h"
#include "solver/curves/curve_chain.h"
#include "solver/math/fast_trigonometry.h"
#include "solver/math/rotation.h"
#include "solver/rig/box_solver.h"
#include "solver/rig/chain_measures.h"
#include "solver/rig/crowd.h"
#include "solver/rig/option_reader.h"
#include "solver/systems/box_transport.h"
#include "solver/systems/fk_bones.h"
#include "solver/systems/system_base.h"

namespace backbend::solver {
namespace {

using glm::dquat;
using glm::dvec3;

enum class Roll { top, full };
enum class Arms { effector, top };

class CurveSpine final : public FormulaSystem, public CrowdSolver, public BoxSolver {
 public:
  CurveSpine(const SystemSpec& spec, const RestChain& chain) : bones_(chain, spec.system) {
    name_ = spec.system;
    OptionReader read(spec);
    // The words in the order of CurveMap::Kind.
    kind_ = read.choice<CurveMap::Kind>("basis", {"bspline", "interpolate", "linear"});
    const auto rule = read.choice<KnotRule>("knots", {"chord", "uniform", "centripetal"});
    bone_count_ = std::size_t(read.integer("bones", 10, 1, int(kMostBones)));
    follow_ = read.choice<Follow>("follow", {"chase", "on_curve"});
    length_ = read.choice<BoneLength>("length", {"nulls", "rest", "null_sum", "arc", "close"});
    roll_ = read.choice<Roll>("roll", {"top", "full"});
    arms_ = read.choice<Arms>("arms", {"effector", "top"});
    take_options(read);

    for (const char* control : {"lower", "middle", "top"}) add_rotation(control);
    std::vector<std::string> names;
    for (std::size_t i = 1; i <= bone_count_; ++i) names.push_back("bone_" + std::to_string(i));
    names.push_back("tip");
    name_chain(names);

    const auto points = FkBones::five_points(bones_.rest);
    map_.emplace(kind_, points.size(), make_knots(points, rule));
    const Curve curve = draw(bones_.rest);
    rest_curve_length_ = curve.length();
    build_rest(curve);
    measure_arc_fraction();
  }

  void solve_crowd(const CrowdControls& control, PoseRange range, CrowdPose& out) const override {
    OneByOne single(*this);
    const bool four_at_once = range.last - range.first >= 4 && follow_ == Follow::chase &&
                              roll_ == Roll::top && length_ != BoneLength::null_sum &&
                              length_ != BoneLength::close;
    if (!four_at_once) {
      for (std::size_t i = range.first; i < range.last; ++i) single.solve(control, i, out);
      return;
    }
    for (std::size_t next = range.first; next < range.last; next += 4) {
      const std::size_t first = std::min(next, range.last - 4);  // the last four may overlap
      const int good = solve_four(control, first, out);
      for (std::size_t lane = 0; lane < 4; ++lane) {
        if (!(good >> lane & 1)) single.solve(control, first + lane, out);
      }
    }
  }

  std::vector<double> controls_for(const BodyPose& body, Mapping mapping) const override {
    return fk_controls_for(body, mapping);
  }

  std::string why_not_on_boxes() const override {
    if (kind_ == CurveMap::Kind::polyline) return "basis = \"linear\" has no interval form yet";
    if (follow_ == Follow::on_curve) return "follow = \"on_curve\" has no interval form yet";
    if (length_ == BoneLength::close) return "length = \"close\" has no interval form yet";
    if (roll_ == Roll::full) return "roll = \"full\" has no interval form yet";
    return {};
  }

  std::vector<BoxReal> controls_for(const BodyBox& body, Mapping mapping) const override {
    return fk_controls(body.twist, -body.side, -body.back, mapping);
  }

  void solve_box(std::span<const BoxReal> control, BoxPose& pose) const override {
    pose.rate.clear();
    const FkBones::BoxPose bones = bones_.pose(control);
    lay_box<BoxRoll>(tangents_over(bones), bones.turn[0], control[6],
                     [&](const BoxRoll& frame, const BoxReal& roll, const BoxChase&) {
                       pose.rate.push_back(frame.rates(roll));
                     });
    pose.rate.push_back(pose.rate.back());
    pose.only_rolls = moved_alone(control, 6);
  }

  std::string why_no_places() const override { return {}; }

  void place_box(std::span<const BoxReal> control, BoxPlaces& places) const override {
    places.turn.clear();
    const FkBones::BoxPose bones = bones_.pose(control);
    const BoxTangents tangents = tangents_over(bones);
    const BoxCurve curve(map_->draw(FkBones::five_points(bones)), 64);
    const BoxReal even = tangents.length() / BoxReal(static_cast<double>(bone_count_));
    places.position.assign(1, curve.start());
    lay_box<BoxTransport>(
        tangents, bones.turn[0], control[6],
        [&](const BoxTransport& frame, const BoxReal& roll, const BoxChase& chain) {
          const std::size_t i = places.turn.size();
          places.turn.push_back(frame.turn() * turn_about(bones_.axes[0][0], roll) * uncarry_[i]);
          const BoxVector goal = curve.point_at_share(double(i + 1) / double(bone_count_));
          places.position.push_back(goal + (even * chain.past()) * chain.aim());
        });
    places.turn.push_back(places.turn.back());
    places.length = tangents.length() * bone_over(tangents);
    places.hip = {BoxTurn(), bones_.rest.joint[0], bones.joint[0]};
    places.chest = {bones.turn[2], bones_.rest.joint[3], bones.joint[3]};
    places.arms_follow_chest = arms_ == Arms::top;
    places.arms = places.arms_follow_chest ? places.chest
                                           : BoxMotion{places.turn.back(), rest_.position.back(),
                                                       places.position.back()};
    places.ends_on_chest = false;
  }

  std::string why_no_course() const override { return {}; }

  void course_over(const BodyBox& body, Mapping mapping, std::size_t,
                   BoxCourse& course) const override {
    const BoxTangents tangents = tangents_over(bones_.pose(controls_for(body, mapping)));
    course = chased_course(tangents, bone_count_, bone_over(tangents));
  }

  std::string_view why_without(BodyChannel channel) const override {
    return channel == BodyChannel::hip ? kNoHipControl : "its controls turn and do not move";
  }

  std::vector<dvec3> intended_curve(std::span<const double> control,
                                    std::size_t count) const override {
    return equal_arc_points(draw(bones_.pose(control)), count);
  }

 private:
  struct Solved {
    FkBones::Pose bones;
    CurveChain chain;
    /// Of each bone without roll: from the lower control's rest frame to the bone's frame.
    std::array<dquat, kMostBones> carry;
    std::array<double, kMostBones> least_margin;  // what carry's arcs leave before doubling back
    double residual = 0.0;  // twist from the last bone's frame to Top's, after the shortest arc
    double aim_gap = 0.0;   // between the last bone and Top's X
  };

  /// The chain over a box of poses, in units of an even bone: the curve's length over bone_count_.
  /// `visit` gets each bone's Frame (BoxRoll or BoxTransport) with its roll, and the chase that has
  /// gone to its end.
  template <class Frame, class Visit>
  void lay_box(const BoxTangents& tangents, const BoxTurn& lower, const BoxReal& roll,
               const Visit& visit) const {
    const BoxReal bone = bone_over(tangents);
    Frame frame(lower, bones_.axes[0][0]);
    BoxChase chain;
    for (std::size_t i = 0; i < bone_count_; ++i) {
      const double from = double(i) / double(bone_count_);
      const double to = double(i + 1) / double(bone_count_);
      chain.go(tangents.mean_between(from, to), bone);
      frame.go(chain.aim());
      visit(frame, BoxReal(to) * roll, chain);
    }
  }

  BoxTangents tangents_over(const FkBones::BoxPose& bones) const {
    return BoxTangents(map_->legs(FkBones::five_steps(bones)), 32);
  }

  /// A bone's length over the curve's length divided by bone_count_. A gap between two nulls is the
  /// mean tangent between them times their share.
  BoxReal bone_over(const BoxTangents& tangents) const {
    const auto gap = [&](int i) {
      return tangents.mean_between(double(i - 1) / (kNullCount - 1), double(i) / (kNullCount - 1))
          .length();
    };
    switch (length_) {
      case BoneLength::rest:
        return BoxReal(rest_curve_length_) / tangents.length();
      case BoneLength::arc:
        return 1.0;
      case BoneLength::null_sum: {
        BoxReal sum(0.0);
        for (int i = 1; i < kNullCount; ++i) sum = sum + gap(i);
        return sum / BoxReal(double(kNullCount - 1));
      }
      default:
        return gap(1);
    }
  }

  Curve draw(const FkBones::Pose& bones) const { return map_->draw(FkBones::five_points(bones)); }

  /// Frames along the chain by shortest arcs from the lower control's. All in rig space, so that a
  /// planar pose keeps its plane to the last bit. A doubling back turns about the frame's Z.
  void carry_frames(Solved& s) const {
    dvec3 along = bones_.axis(s.bones, 0, 0);
    dquat carry = s.bones.turn[0];
    double least_sum = 2.0, margin = kPi;
    for (std::size_t i = 0; i < bone_count_; ++i) {
      const dvec3& aim = s.chain.direction[i];
      const dvec3 sum = along + aim;
      const double size = glm::length(sum);
      if (size < least_sum) {  // a sharper turn than any before: the sum is twice its half's cosine
        least_sum = size;
        margin = 2.0 * std::atan2(size, glm::length(along - aim));
      }
      // shortest_arc() where the two do not all but double back.
      const dquat arc = size > 0.1 ? dquat(0.5 * size, glm::cross(along, aim) * (1.0 / size))
                                   : shortest_arc(along, aim, carry * bones_.axes[0][2]);
      carry = arc * carry;
      along = aim;
      s.carry[i] = carry;
      s.least_margin[i] = margin;
    }
  }

  /// What is left between the last bone's frame and Top's.
  void compare_with_top(Solved& s) const {
    const dvec3& along = s.chain.direction[bone_count_ - 1];
    const dquat& carry = s.carry[bone_count_ - 1];
    const dvec3 top = bones_.axis(s.bones, 2, 0);
    s.aim_gap = angle_between(along, top);
    const dquat reached = shortest_arc(along, top, carry * bones_.axes[0][2]) * carry;
    // Both frames now share their X axis: what is left between their Y axes is twist.
    const dvec3 y = reached * bones_.axes[0][1], z = reached * bones_.axes[0][2];
    const dvec3 top_y = bones_.axis(s.bones, 2, 1);
    s.residual = std::atan2(glm::dot(top_y, z), glm::dot(top_y, y));
  }

  /// Four poses from number `first` on, side by side, by the same steps as solve_into(). Returns in
  /// bit i whether lane i was an ordinary pose; what stands in `out` for others is of no use.
  int solve_four(const CrowdControls& control, std::size_t first, CrowdPose& out) const {
    std::array<Lanes, 9> own;
    for (std::size_t c = 0; c < own.size(); ++c) {
      own[c] = Lanes::load(control.value.data() + c * control.count + first);
    }
    int good;
    const FkBones::PoseLanes bones = bones_.pose(own, good);
    const auto& j = bones.joint;
    const Lanes half(0.5);
    const std::array<LaneVector, 5> five = {j[0], half * (j[0] + j[1]), half * (j[1] + j[2]),
                                            half * (j[2] + j[3]), j[3]};
    std::array<ArcLanes::Piece, ArcLanes::kMostPieces> drawn;
    const auto pieces = std::span(drawn).first(map_->piece_count());
    map_->draw(five, pieces);
    ArcLanes arcs;
    good &= arcs.measure(pieces);
    const Lanes length = arcs.length(), count(static_cast<double>(bone_count_));
    const LaneVector start = pieces.front()[0];

    Lanes bone = length / count;  // BoneLength::arc
    if (length_ == BoneLength::rest) bone = Lanes(rest_curve_length_ / double(bone_count_));
    if (length_ == BoneLength::nulls) {
      const LaneVector null = arcs.point_at(length * (1.0 / double(kNullCount - 1)));
      bone = solver::length(null - start) * double(kNullCount - 1) / count;
    }

    const Lanes roll = own[6];
    good &= (absolute(half * roll) >= Lanes(0.5 * kFastTrigonometryReach)).bits() ^ 15;
    const LaneVector axis(bones_.axes[0][0]);
    LaneVector joint = start, along = bones.turn[0] * axis;
    LaneTurn carry = bones.turn[0], turn;
    const Lanes near = Lanes(1e-12) * length;
    write_joint(out, 0, first, joint);
    for (std::size_t i = 0; i < bone_count_; ++i) {
      const LaneVector goal = i + 1 == bone_count_
                                  ? pieces.back()[3]
                                  : arcs.point_at(length * (double(i + 1) / double(bone_count_)));
      const LaneVector to_goal = goal - joint;
      const Lanes distance = solver::length(to_goal);
      good &= (distance > near).bits();
      const LaneVector aim = (Lanes(1.0) / distance) * to_goal;
      joint = joint + bone * aim;
      const LaneVector sum = along + aim;
      const Lanes size = solver::length(sum);
      good &= (size > Lanes(0.1)).bits();
      carry = LaneTurn(half * size, (Lanes(1.0) / size) * cross(along, aim)) * carry;
      along = aim;

      Lanes sine, cosine;
      sin_cos(half * roll / count * double(i + 1), sine, cosine);
      turn = renormalised(carry * LaneTurn(cosine, sine * axis) * LaneTurn(uncarry_[i]));
      write_turn(out, i, first, turn);
      write_joint(out, i + 1, first, joint);
    }
    write_turn(out, bone_count_, first, turn);
    const bool on_top = arms_ == Arms::top;
    write_joint(out, bone_count_ + 1, first, on_top ? j[3] : joint);  // the row of the arms
    write_turn(out, bone_count_ + 1, first, on_top ? bones.turn[2] : turn);
    std::fill_n(out.flagged().begin() + std::ptrdiff_t(first), 4, std::uint8_t(0));
    return good;
  }

  static void write_joint(CrowdPose& out, std::size_t j, std::size_t first, const LaneVector& v) {
    v.x.store(&out.position(j, 0)[first]);
    v.y.store(&out.position(j, 1)[first]);
    v.z.store(&out.position(j, 2)[first]);
  }
  static void write_turn(CrowdPose& out, std::size_t j, std::size_t first, const LaneTurn& q) {
    q.w.store(&out.turn(j, 0)[first]);
    q.x.store(&out.turn(j, 1)[first]);
    q.y.store(&out.turn(j, 2)[first]);
    q.z.store(&out.turn(j, 3)[first]);
  }

  void build_rest(const Curve& curve) {
    Solved s;
    s.bones = bones_.rest;
    lay_chain(curve, bone_count_, follow_, length_, rest_curve_length_, s.chain);
    carry_frames(s);
    compare_with_top(s);
    rest_residual_ = s.residual;
    for (std::size_t i = 0; i < bone_count_; ++i) uncarry_.push_back(glm::conjugate(s.carry[i]));
    rest_.position = s.chain.joint;
    const std::vector<double> still(channels_.size(), 0.0);
    fill(still, curve, s, Detail::all, rest_);
    std::fill(rest_.turn.begin(), rest_.turn.end(), kNoTurn);
    rest_.hip.turn = rest_.chest.turn = rest_.arms.turn = kNoTurn;
    warn_of_unequal_bones();
  }

  void warn_of_unequal_bones() {
    double length[3];
    for (int k = 0; k < 3; ++k) {
      length[k] = glm::length(bones_.rest.joint[k + 1] - bones_.rest.joint[k]);
    }
    const auto [least, most] = std::minmax_element(length, length + 3);
    if (*most > 4.0 * *least) {
      rest_.flags.push_back("one of the three bones is " + number_text(*most / *least) +
                            " times as long as another: expect an uneven bend");
    }
  }

  /// Twist to hand out over the chain, the whole at its top.
  double whole_roll(std::span<const double> control, const Solved& s) const {
    const double middle_rx = control[3], top_rx = control[6];
    if (roll_ == Roll::top) return top_rx;
    // The turn is known modulo a full one; the Euler channels, which never wrap, say which.
    return unwrap(s.residual - rest_residual_, middle_rx + top_rx);
  }

  /// Writes the bones' turns from rest: carried, with their share of the roll about the lower
  /// control's rest axis.
  void write_turns(double roll, const Solved& s, std::vector<dquat>& turn) const {
    const dvec3 axis = bones_.axes[0][0];
    const double half_share = 0.5 * roll / double(bone_count_);
    const bool fast = std::abs(0.5 * roll) < 0.5 * kFastTrigonometryReach;
    constexpr std::size_t kBlock = 4;
    for (std::size_t first = 0; first < bone_count_; first += kBlock) {
      double half[kBlock], sine[kBlock], cosine[kBlock];
      for (std::size_t k = 0; k < kBlock; ++k) half[k] = half_share * double(first + k + 1);
      if (fast) {
        sin_cos_block<kBlock>(half, sine, cosine);
      } else {
        for (std::size_t k = 0; k < kBlock; ++k)
          sine[k] = std::sin(half[k]), cosine[k] = std::cos(half[k]);
      }
      for (std::size_t k = 0; k < kBlock && first + k < bone_count_; ++k) {
        const dquat twist(cosine[k], sine[k] * axis);
        turn[first + k] = renormalised(s.carry[first + k] * twist * uncarry_[first + k]);
      }
    }
    turn[bone_count_] = turn[bone_count_ - 1];
  }

  void fill(std::span<const double> control, Detail detail, SpinePose& pose) const override {
    Solved s;
    s.bones = bones_.pose(control);
    const Curve curve = draw(s.bones);
    lay_chain(curve, bone_count_, follow_, length_, rest_curve_length_, s.chain);
    carry_frames(s);
    if (detail == Detail::all || roll_ == Roll::full) compare_with_top(s);
    fill(control, curve, s, detail, pose);
  }

  void fill(std::span<const double> control, const Curve& curve, const Solved& s, Detail detail,
            SpinePose& pose) const {
    const std::size_t last = bone_count_;
    pose.position.assign(s.chain.joint.begin(), s.chain.joint.end());
    pose.turn.resize(last + 1);
    pose.flip_margin.resize(last + 1);
    const double roll = whole_roll(control, s);
    double unwrap_margin = kPi;
    if (roll_ == Roll::full) {
      unwrap_margin = std::min(kPi - std::abs(roll - control[3] - control[6]), kPi - s.aim_gap);
    }
    write_turns(roll, s, pose.turn);
    for (std::size_t i = 0; i < last; ++i) {
      pose.flip_margin[i] = std::min(s.least_margin[i], unwrap_margin);
    }
    pose.flip_margin[last] = pose.flip_margin[last - 1];

    pose.hip = {kNoTurn, bones_.rest.joint[0], s.bones.joint[0]};
    pose.chest = {s.bones.turn[2], bones_.rest.joint[3], s.bones.joint[3]};
    pose.arms = arms_ == Arms::top
                    ? pose.chest
                    : RigidMotion{pose.turn[last], rest_.position[last], pose.position[last]};

    pose.flags.clear();
    const double overrun = std::max(0.0, s.chain.overrun);
    if (overrun > s.chain.bone_length) {
      pose.flags.push_back("the chain runs past the curve's end by a bone or more");
    }
    if (s.chain.aimless) pose.flags.push_back("a bone stands on its goal and keeps its direction");
    if (s.chain.unclosed) pose.flags.push_back("no bone length meets the curve's end");

    MeasureWriter measures(pose);
    if (detail == Detail::joints) return;
    measures.add("curve_length", curve.length());
    measures.add("rest_curve_length", rest_curve_length_);
    measures.add("bone_length", s.chain.bone_length);
    measures.add("length_by_first_null", length_by_first_null(curve));
    measures.add("length_by_null_sum", length_by_null_sum(curve));
    add_chain_measures(pose.position, measures);
    measures.add("tip_gap", glm::length(pose.position[last] - curve.point(1.0)));
    measures.add("overrun", overrun);
    measures.add("aim_gap_deg", degrees(s.aim_gap));
    const double left = s.residual - rest_residual_ - roll;
    measures.add("arm_drift_twist_deg", degrees(std::abs(wrap(left))));
    measures.add("roll_deg", degrees(roll));
  }

  FkBones bones_;
  CurveMap::Kind kind_;
  Follow follow_;
  BoneLength length_;
  Roll roll_;
  Arms arms_;
  std::size_t bone_count_;
  std::optional<CurveMap> map_;  // from the five points to the curve, knots frozen at rest
  double rest_curve_length_ = 0.0;
  double rest_residual_ = 0.0;
  std::vector<dquat> uncarry_;  // inverse of each bone's carry at rest
};

}  // namespace

std::unique_ptr<SpineSystem> build_curve_spine(const SystemSpec& spec, const RestChain& chain) {
  return std::make_unique<CurveSpine>(spec, chain);
}

}  // namespace backbend::solver
