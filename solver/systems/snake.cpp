#include "solver/systems/snake.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "solver/curves/box_course.h"
#include "solver/curves/box_tangents.h"
#include "solver/curves/path_frames.h"
#include "solver/curves/walk.h"
#include "solver/math/rotation.h"
#include "solver/rig/box_solver.h"
#include "solver/rig/chain_measures.h"
#include "solver/rig/option_reader.h"
#include "solver/systems/box_transport.h"
#include "solver/systems/system_base.h"

namespace backbend::solver {
namespace {

using glm::dquat;
using glm::dvec3;

/// The place of CV i in the parameter of a clamped uniform cubic over 0..1: the mean of its knots.
double greville(int i, int count) {
  const double spans = count - 3;
  const auto knot = [&](int k) { return std::clamp(double(k - 3), 0.0, spans); };
  return (knot(i + 1) + knot(i + 2) + knot(i + 3)) / (3.0 * spans);
}

double interpolated(std::span<const double> at, std::span<const double> value, double u) {
  if (u <= at.front()) return value.front();
  for (std::size_t i = 1; i < at.size(); ++i) {
    if (u > at[i]) continue;
    return value[i - 1] + (value[i] - value[i - 1]) * ((u - at[i - 1]) / (at[i] - at[i - 1]));
  }
  return value.back();
}

class Snake final : public FormulaSystem, public BoxSolver {
  enum ChannelIndex { kSlide, kAmplitude, kFrequency, kOffset, kStretchy, kLead, kFirstList };

 public:
  Snake(const SystemSpec& spec, const RestChain& chain) : Snake(spec, chain, OptionReader(spec)) {}

  const std::vector<PathFrames::Place>& controls_at_rest() const { return rest_place_; }

  /// A snake has no chest control: the bend is laid on the controls' detail keys, evenly along the
  /// body (spread) or along its upper half (chest), the twist on the twist keys likewise.
  std::vector<double> controls_for(const BodyPose& body, Mapping mapping) const override {
    std::vector<double> control;
    for (const Channel& channel : channels_) control.push_back(channel.rest);
    // An empty pose is the rest to the last bit.
    const int bent = body.extension == body.flexion && body.side == 0.0 ? 0 : controls_;
    dvec3 at(0.0), before(0.0);
    for (int i = 0; i < bent; ++i) {
      const PathFrames::Place& place = rest_place_[i];
      if (i == 0) {
        at = before = place.position;
      } else {
        // The curve's ends point along its first and last steps: those have none and all of it.
        const double w = bend_share(i, mapping);
        const dquat frame(place.frame);
        const dquat bend = from_euler_xyz(-w * (body.extension - body.flexion), w * body.side, 0.0);
        at += frame * bend * glm::conjugate(frame) * (place.position - before);
        before = place.position;
      }
      const dvec3 detail = glm::transpose(place.frame) * (at - place.position);
      for (int axis = 0; axis < 3; ++axis) control[detail_ + 3 * i + axis] = detail[axis];
    }
    for (std::size_t k = 0; k < key_u_.size(); ++k) {
      control[twist_ + k] = share(key_u_[k], mapping) * body.twist;
    }
    return control;
  }

  std::string why_not_on_boxes() const override {
    if (nearest_) return "closest = \"nearest\" has no interval form yet";
    if (channels_[kLead].rest != 0.0) return "lead has no interval form yet";
    return {};
  }

  std::string why_fixed(std::string_view control) const override {
    const bool ribbon = control.substr(0, 7) == "ribbon.";
    if (!ribbon && control != "slide" && control != "stretchy" && control != "lead") return {};
    return "has no interval form yet, and stays at rest in a proof";
  }

  std::vector<BoxReal> controls_for(const BodyBox& body, Mapping mapping) const override {
    std::vector<BoxReal> control;
    for (const Channel& channel : channels_) control.emplace_back(channel.rest);
    BoxVector moved(dvec3(0.0));
    for (int i = 1; i < controls_; ++i) {
      const PathFrames::Place& place = rest_place_[i];
      moved = moved + bent_step(body, mapping, i) - BoxVector(rest_step(i));
      const BoxVector detail = glm::transpose(place.frame) * moved;
      control[std::size_t(detail_ + 3 * i)] = detail.x;
      control[std::size_t(detail_ + 3 * i + 1)] = detail.y;
      control[std::size_t(detail_ + 3 * i + 2)] = detail.z;
    }
    for (std::size_t k = 0; k < key_u_.size(); ++k)
      control[twist_ + k] = BoxReal(share(key_u_[k], mapping)) * body.twist;
    return control;
  }

  void solve_box(std::span<const BoxReal> c, BoxPose& pose) const override {
    std::vector<BoxVector> step;
    BoxVector before(dvec3(0.0));
    for (int i = 0; i < controls_; ++i) {
      const PathFrames::Place& place = rest_place_[i];
      const auto detail = c.subspan(std::size_t(detail_ + 3 * i), 3);
      std::array<BoxReal, 3> local{detail[0], detail[1], detail[2]};
      const BoxReal phase = (BoxReal(start_u_[i]) + BoxReal(0.01) * c[kOffset]) * c[kFrequency];
      local[std::size_t(axis_)] =
          local[std::size_t(axis_)] + c[kAmplitude] * c[std::size_t(blend_ + i)] * sine(phase);
      const BoxVector moved = place.frame * BoxVector(local[0], local[1], local[2]);
      if (i > 0) step.push_back(BoxVector(rest_step(i)) + (moved - before));
      before = moved;
    }
    const auto twist = c.subspan(std::size_t(twist_), key_u_.size());
    turn_over(step, twist, pose);
    pose.only_rolls = moved_alone(c, std::size_t(twist_), twist.size());
  }

  /// From the steps that the pose bends: summed up to details and taken apart again, each would be
  /// as wide as all before it.
  void solve_body_box(const BodyBox& body, Mapping mapping, BoxPose& pose) const override {
    std::vector<BoxReal> twist;
    for (const double u : key_u_) twist.push_back(BoxReal(share(u, mapping)) * body.twist);
    turn_over(bent_steps(body, mapping), twist, pose);
    pose.only_rolls = moved_alone(std::array{body.twist, body.back, body.side}, 0);
  }

  std::string why_no_places() const override { return {}; }
  std::string why_no_skin() const override { return BoxSolver::why_no_places(); }

  /// Its bones keep their lengths, and the head is both chest and arms: more is not enclosed.
  void place_box(std::span<const BoxReal>, BoxPlaces& places) const override {
    const BoxTurn turn = BoxTurn::undefined();
    const BoxVector place = BoxVector::undefined();
    places.turn.assign(std::size_t(joints_), turn);
    places.position.assign(std::size_t(joints_), place);
    places.hip = {turn, rest_.position.front(), place};
    places.chest = places.arms = {turn, rest_.position.back(), place};
    BoxReal length(0.0);
    for (const double bone : rest_bone_) length = length + BoxReal(bone);
    places.length = length;
    places.ends_on_chest = places.arms_follow_chest = true;
  }

  std::string why_no_course() const override { return {}; }

  void course_over(const BodyBox& body, Mapping mapping, std::size_t,
                   BoxCourse& course) const override {
    const std::vector<BoxVector> step = bent_steps(body, mapping);
    course = walked_course(BoxTangents(bspline_legs(step), panels_for(step)), rest_bone_);
  }

  std::string_view why_without(BodyChannel) const override {
    return "a body on a path has no hips and chest to set against each other";
  }

  std::vector<dvec3> intended_curve(std::span<const double> control,
                                    std::size_t count) const override {
    const Body body = draw(control);
    std::vector<dvec3> joint;
    const Walk walk = walk_body(control, body, joint, nullptr);
    std::vector<dvec3> point(count);
    for (std::size_t i = 0; i < count; ++i) {
      const double f = double(i) / double(count - 1);
      const double s = std::clamp(control[kStretchy], 0.0, 1.0);
      const double from = (1.0 - s) * walk.from_arc;
      const double to = s * body.curve.length() + (1.0 - s) * walk.to_arc;
      point[i] = body.on_ribbon(body.curve.at_arc(from + (to - from) * f));
    }
    return point;
  }

  /// `twist = [[control, degrees], ...]`: keys at any controls, straight between them, 0 at both
  /// ends of the body unless an end has a key.
  bool read_pose_key(std::string_view key, const OptionValue& value,
                     std::span<double> control) const override {
    const auto* rows = std::get_if<std::vector<std::vector<double>>>(&value);
    if (key != "twist" || !rows) return false;
    std::vector<double> at{0.0, 1.0}, turn{0.0, 0.0};
    for (const auto& row : *rows) {
      if (row.size() != 2) throw OptionError("twist", "a twist key is [control, degrees]");
      const double which = row[0];
      if (which != std::floor(which) || which < 0 || which >= controls_ ||
          !(std::abs(row[1]) <= 1e6)) {
        throw OptionError("twist", "twist key [" + number_text(which) + ", " + number_text(row[1]) +
                                       "]: expected a control 0 to " +
                                       std::to_string(controls_ - 1) + " and an angle");
      }
      const double u = greville(int(which), controls_);
      const auto place = std::lower_bound(at.begin(), at.end(), u);
      const auto index = place - at.begin();
      if (*place != u) {
        at.insert(place, u);
        turn.insert(turn.begin() + index, 0.0);
      }
      turn[index] = radians(row[1]);
    }
    for (std::size_t k = 0; k < key_u_.size(); ++k) {
      control[twist_ + k] = interpolated(at, turn, key_u_[k]);
    }
    return true;
  }

 private:
  /// What a place on the body, 0 tail to 1 head, has of a bend or twist of the whole.
  static double share(double u, Mapping mapping) {
    return mapping == Mapping::spread ? u : std::max(0.0, 2.0 * u - 1.0);
  }
  /// The same of the step to control `i`, from 1.
  double bend_share(int i, Mapping mapping) const {
    return share((i - 1.0) / (controls_ - 2), mapping);
  }

  dvec3 rest_step(int i) const { return rest_place_[i].position - rest_place_[i - 1].position; }

  BoxVector bent_step(const BodyBox& body, Mapping mapping, int i) const {
    const BoxReal w(bend_share(i, mapping));
    const glm::dmat3& frame = rest_place_[i].frame;
    const BoxTurn bend = from_euler_xyz(-(w * body.back), w * body.side, BoxReal(0.0));
    return frame * (bend * (glm::transpose(frame) * BoxVector(rest_step(i))));
  }

  std::vector<BoxVector> bent_steps(const BodyBox& body, Mapping mapping) const {
    std::vector<BoxVector> step;
    for (int i = 1; i < controls_; ++i) step.push_back(bent_step(body, mapping, i));
    return step;
  }

  /// The interpolated() twist at a place `u` over a box, 0 to 1. Of use for its slopes.
  BoxReal twist_over(std::span<const BoxReal> key, const BoxReal& u) const {
    const auto at = [&](std::size_t i) {
      if (implicit_start_ && i == 0) return BoxReal(0.0);
      if (implicit_end_ && i + 1 == twist_u_.size()) return BoxReal(0.0);
      return key[implicit_start_ ? i - 1 : i];
    };
    BoxReal all;
    bool first = true;
    for (std::size_t i = 1; i < twist_u_.size(); ++i) {
      const double from = twist_u_[i - 1], to = twist_u_[i];
      if (u.value.hi < from || u.value.lo > to) continue;
      BoxReal f = (u - BoxReal(from)) / BoxReal(Interval(to) - from);
      f.value = common(f.value, Interval(0.0, 1.0));
      const BoxReal own = at(i - 1) + f * (at(i) - at(i - 1));
      all = first ? own : hull(all, own);
      first = false;
    }
    return first ? BoxReal::undefined() : all;
  }

  /// As many panels as make a panel's turn no wider than the box.
  static int panels_for(const std::vector<BoxVector>& step) {
    constexpr double kTurnOfAPiece = 0.2, kFewest = 8.0, kMost = 48.0;
    double widest = 0.0;
    for (const BoxVector& s : step) {
      for (std::size_t j = 0; j < kBoxVariables; ++j)
        widest = std::max(widest, (length(s.slope(j)) / length(s.value())).hi);
    }
    return int(std::clamp(kTurnOfAPiece / widest, kFewest, kMost));
  }

  /// How fast the joints of a body turn whose controls are these steps apart.
  void turn_over(const std::vector<BoxVector>& step, std::span<const BoxReal> twist,
                 BoxPose& pose) const {
    pose.rate.assign(std::size_t(joints_), BoxTurn::undefined().rate);
    const BoxTangents tangents(bspline_legs(step), panels_for(step));
    if (!tangents.is_finite()) return;
    const BoxReal pieces(double(controls_ - 3));
    BoxRoll frame(BoxTurn(start_), kAxisX);
    std::optional joint = BoxTangents::Joint{};
    for (std::size_t k = 0; k < pose.rate.size(); ++k) {
      if (k > 0) joint = tangents.walked(*joint, rest_bone_[k - 1]);
      if (!joint) return;
      const BoxTangents::Place place = tangents.at(*joint);
      if (k == 0) {
        frame.go(place.tangent);
      } else {
        frame.go(place.tangent, joint->turned);
      }
      pose.rate[k] = frame.rates(twist_over(twist, place.piece / pieces));
    }
  }

  Snake(const SystemSpec& spec, const RestChain& chain, OptionReader read)
      : joints_(read.integer("joints", 100, 2, 1000)),
        controls_(read.integer("controls", 16, 4, 200)),
        drawn_(path_of(spec, chain)),
        frames_(drawn_.curve, drawn_.up) {
    name_ = spec.system;
    length_ = read.number("length", drawn_.body_length, 1e-9, 1e9);
    axis_ = int(read.word("axis", {"x", "y", "z"}));
    nearest_ = read.word("closest", {"walk", "nearest"}) == 1;
    const double lead = read.number("lead", 0.0, 0.0, 1.0);
    std::vector<double> greville_u;
    for (int i = 0; i < controls_; ++i) greville_u.push_back(greville(i, controls_));
    key_u_ = read.numbers("twist_u", greville_u, 0, 0.0, 1.0);
    for (std::size_t k = 1; k < key_u_.size(); ++k) {
      if (!(key_u_[k] > key_u_[k - 1])) read.refuse("twist_u", "must rise from key to key");
    }
    take_options(read);
    if (length_ > drawn_.curve.length() * (1.0 + 1e-12)) {
      read.refuse("length", "is " + number_text(length_) + ", longer than the path (" +
                                number_text(drawn_.curve.length()) + ")");
    }
    // A key at each end, if the list has none there: no twist.
    twist_u_ = key_u_;
    if (twist_u_.empty() || twist_u_.front() > 0.0) {
      twist_u_.insert(twist_u_.begin(), 0.0);
      implicit_start_ = true;
    }
    if (twist_u_.back() < 1.0) {
      twist_u_.push_back(1.0);
      implicit_end_ = true;
    }
    for (int i = 0; i < controls_; ++i) {
      start_u_.push_back(std::min(1.0, i * (length_ / (controls_ - 1)) / drawn_.curve.length()));
      rest_place_.push_back(frames_.at(start_u_.back()));
    }

    for (const char* name : {"slide", "amplitude", "frequency", "offset", "stretchy"}) {
      add_scalar(name);
    }
    add_scalar("lead", lead);
    blend_ = int(channels_.size());
    for (int i = 0; i < controls_; ++i) add_scalar("blend." + std::to_string(i), 1.0);
    detail_ = int(channels_.size());
    for (int i = 0; i < controls_; ++i) {
      for (const char axis : {'x', 'y', 'z'}) {
        channels_.push_back(
            {std::string("detail.") + axis + std::to_string(i), Channel::Kind::translation, 0.0});
      }
    }
    ribbon_ = int(channels_.size());
    for (int i = 0; i < controls_; ++i) {
      for (const char axis : {'x', 'y', 'z'}) {
        channels_.push_back(
            {std::string("ribbon.") + axis + std::to_string(i), Channel::Kind::translation, 0.0});
      }
    }
    twist_ = int(channels_.size());
    for (std::size_t k = 0; k < key_u_.size(); ++k) {
      channels_.push_back({"twist." + std::to_string(k), Channel::Kind::rotation, 0.0});
    }
    std::vector<std::string> names;
    for (int k = 0; k < joints_; ++k) names.push_back("snake_" + std::to_string(k + 1));
    name_chain(std::move(names));
    build_rest();
  }

  struct DrawnPath {
    Curve curve;
    dvec3 up;
    double body_length;
  };
  static DrawnPath path_of(const SystemSpec& spec, const RestChain& chain) {
    constexpr double kDefaultLength = 30.0;
    std::vector<dvec3> point = chain.path.point;
    dvec3 up = chain.path.up;
    double body = kDefaultLength;
    if (point.empty()) {
      check_chain(chain, spec.system, 2);
      point = chain.joint;
      const double length = polyline_arcs(point).back();
      // Room to slide: three lengths straight on.
      const dvec3 ahead = glm::normalize(point.back() - point[point.size() - 2]);
      for (int i = 1; i <= 12; ++i)
        point.push_back(chain.joint.back() + (0.25 * i * length) * ahead);
      up = glm::cross(glm::normalize(point[1] - point[0]), chain.left);
      body = length;
    }
    if (point.size() < 2) {
      throw RigError(spec.system + ": the path has one point, expected two or more");
    }
    Curve curve = Curve::bspline(point);
    if (!(curve.length() > 0.0) || !std::isfinite(curve.length())) {
      throw RigError(spec.system + ": the path is a single point, or not finite");
    }
    if (!(glm::length(up) > 0.0) || !std::isfinite(glm::length(up))) up = dvec3(0.0, 1.0, 0.0);
    return {std::move(curve), up, body};
  }

  struct Body {
    Curve curve;
    std::vector<dvec3> cv;          // the controls
    dquat start{1, 0, 0, 0};        // frame of the first control: X along the path
    bool clamped = false;           // slide
    bool aliased = false;           // waves shorter than two controls
    std::optional<Curve> deformed;  // the ribbon's curve, where its own offsets move it

    const Curve& ribbon() const { return deformed ? *deformed : curve; }
    /// Where the ribbon has what the body's curve has at `place`.
    dvec3 on_ribbon(const CurvePoint& place) const {
      if (!deformed) return place.position;
      return deformed->point(place.u) + place.overrun * deformed->tangent(place.u);
    }
  };

  Body draw(std::span<const double> c) const {
    const double slide = std::clamp(c[kSlide], 0.0, 1.0);
    const double room = 1.0 - start_u_.back();
    std::vector<dvec3> cv(controls_), ribbon(controls_);
    bool deformed = false;
    dquat start(1, 0, 0, 0);
    for (int i = 0; i < controls_; ++i) {
      const double u = start_u_[i] + slide * room;
      const PathFrames::Place place = frames_.at(u);
      const double swing =
          c[kAmplitude] * c[blend_ + i] * std::sin((u + 0.01 * c[kOffset]) * c[kFrequency]);
      dvec3 local(c[detail_ + 3 * i], c[detail_ + 3 * i + 1], c[detail_ + 3 * i + 2]);
      local[axis_] += swing;
      cv[i] = place.position + place.frame * local;
      const dvec3 own(c[ribbon_ + 3 * i], c[ribbon_ + 3 * i + 1], c[ribbon_ + 3 * i + 2]);
      ribbon[i] = cv[i] + place.frame * own;
      deformed |= own != dvec3(0.0);
      if (i == 0) {
        start = glm::normalize(
            glm::quat_cast(glm::dmat3(place.frame[2], place.frame[0], place.frame[1])));
      }
    }
    Curve curve = Curve::bspline(cv);
    const bool aliased = c[kAmplitude] != 0.0 && std::abs(c[kFrequency]) * start_u_[1] >= kPi;
    Body body{std::move(curve), std::move(cv), start, slide != c[kSlide], aliased, {}};
    if (deformed) body.deformed = Curve::bspline(ribbon);
    return body;
  }

  Walk walk_body(std::span<const double> c, const Body& body, std::vector<dvec3>& joint,
                 WalkDetail* detail) const {
    const double lead = std::clamp(c[kLead], 0.0, 1.0);
    if (lead == 0.0) return walk_from(body.curve, rest_bone_, 0.0, joint, detail);
    const std::vector<dvec3> reversed(body.cv.rbegin(), body.cv.rend());
    return walk_led(body.curve, Curve::bspline(reversed), rest_bone_, lead, 0.0, joint, detail);
  }

  void build_rest() {
    std::vector<double> control;
    for (const Channel& channel : channels_) control.push_back(channel.rest);
    const Body body = draw(control);
    std::vector<dvec3> joint(joints_);
    for (int k = 0; k < joints_; ++k) {
      const CurvePoint place =
          body.curve.at_fraction(k + 1 == joints_ ? 1.0 : double(k) / (joints_ - 1));
      joint[k] = place.position;
      rest_u_.push_back(place.u);
      arc_fraction_.push_back(double(k) / (joints_ - 1));
      rest_tangent_.push_back(place.tangent);
    }
    for (int k = 0; k + 1 < joints_; ++k)
      rest_bone_.push_back(glm::length(joint[k + 1] - joint[k]));
    rest_frame_.resize(joints_);
    start_ = body.start;
    transport_along(start_, rest_tangent_, rest_frame_);
    SpinePose rest;
    fill(control, Detail::all, rest);
    rest.position = std::move(joint);
    std::fill(rest.turn.begin(), rest.turn.end(), kNoTurn);
    rest.hip = {kNoTurn, rest.position.front(), rest.position.front()};
    rest.chest = rest.arms = {kNoTurn, rest.position.back(), rest.position.back()};
    rest_ = std::move(rest);
  }

  void fill(std::span<const double> c, Detail detail, SpinePose& pose) const override {
    const Body body = draw(c);
    WalkDetail walked_at;
    walk_body(c, body, pose.position, &walked_at);
    const double stretchy = std::clamp(c[kStretchy], 0.0, 1.0);
    const bool collapsed = !(body.curve.length() > 1e-12 * length_);

    std::vector<double> twist_value;
    if (implicit_start_) twist_value.push_back(0.0);
    twist_value.insert(twist_value.end(), c.begin() + twist_, c.begin() + twist_ + key_u_.size());
    if (implicit_end_) twist_value.push_back(0.0);

    std::vector<dvec3> tangent(joints_);
    std::vector<double> ribbon_u(joints_);
    bool overran = false;
    for (int k = 0; k < joints_; ++k) {
      const CurvePoint walked = body.curve.at_arc(walked_at.arc[k]);
      const double walked_u = nearest_ ? body.curve.closest_parameter(pose.position[k]) : walked.u;
      const double u = stretchy * rest_u_[k] + (1.0 - stretchy) * walked_u;
      // Past the end the ribbon has no parameter: the walked chain's overrun is kept in full when
      // nothing stretches.
      const double overrun = (1.0 - stretchy) * walked.overrun;
      overran |= std::abs(overrun) > 1e-9 * length_;
      ribbon_u[k] = u;
      tangent[k] = body.ribbon().tangent(u);
      pose.position[k] = body.ribbon().point(u) + overrun * tangent[k];
    }
    pose.turn.resize(joints_);
    pose.flip_margin.resize(joints_);
    transport_along(body.start, tangent, pose.turn, pose.flip_margin);
    for (int k = 0; k < joints_; ++k) {
      // A ribbon that stretches in full does not ask where the walked joints are.
      const double walk_margin = stretchy < 1.0 ? walked_at.margin[k] : kPi;
      pose.flip_margin[k] = collapsed ? 0.0 : std::min(pose.flip_margin[k], walk_margin);
    }
    for (int k = 0; k < joints_; ++k) {
      const double twist = interpolated(twist_u_, twist_value, ribbon_u[k]);
      pose.turn[k] =
          glm::normalize(pose.turn[k] * turn_about(kAxisX, twist) * glm::conjugate(rest_frame_[k]));
    }

    const auto rest_at = [&](std::size_t k) {
      return rest_.position.empty() ? pose.position[k] : rest_.position[k];
    };
    pose.hip = {pose.turn.front(), rest_at(0), pose.position.front()};
    pose.chest = {pose.turn.back(), rest_at(joints_ - 1), pose.position.back()};
    pose.arms = pose.chest;
    pose.flags.clear();
    if (collapsed) pose.flags.emplace_back("the body curve is a single point");
    if (body.clamped) pose.flags.emplace_back("'slide' is past 0 to 1 and was clamped");
    if (body.aliased) {
      pose.flags.emplace_back(
          "the slither's waves are shorter than two controls: it cannot show them");
    }
    if (overran) pose.flags.emplace_back("the body is longer than its curve and runs past the end");
    if (frames_.up_is_lost()) {
      pose.flags.emplace_back("up lies along the path's start: another direction stands in");
    }
    MeasureWriter measures(pose);
    if (detail == Detail::all) measure(body, pose, measures);
  }

  void measure(const Body& body, const SpinePose& pose, MeasureWriter& out) const {
    double least = 1e300, most = 0.0;
    for (int k = 0; k + 1 < joints_; ++k) {
      const double spacing = glm::length(pose.position[k + 1] - pose.position[k]);
      least = std::min(least, spacing);
      most = std::max(most, spacing);
    }
    out.add("path_length", drawn_.curve.length());
    out.add("body_length", body.curve.length());
    out.add("min_spacing", least);
    out.add("max_spacing", most);
    add_chain_measures(pose.position, out);
    out.add("end_gap", glm::length(pose.position.back() - body.ribbon().point(1.0)));
    out.add("start_gap", glm::length(pose.position.front() - body.ribbon().point(0.0)));
  }

  int joints_, controls_;
  DrawnPath drawn_;
  PathFrames frames_;
  double length_ = 0.0;
  int axis_ = 0;
  bool nearest_ = false;
  int blend_ = 0, detail_ = 0, ribbon_ = 0, twist_ = 0;  // first channels
  std::vector<double> start_u_;                          // of the controls, path arc fraction
  std::vector<PathFrames::Place> rest_place_;            // of the controls, without a slide
  std::vector<double> key_u_;                            // of the twist channels
  std::vector<double> twist_u_;                          // the same with both ends
  bool implicit_start_ = false, implicit_end_ = false;
  std::vector<double> rest_u_, rest_bone_;
  dquat start_{1, 0, 0, 0};  // of the first control's frame at rest
  std::vector<dvec3> rest_tangent_;
  std::vector<dquat> rest_frame_;
};

}  // namespace

std::unique_ptr<SpineSystem> build_snake(const SystemSpec& spec, const RestChain& chain) {
  return std::make_unique<Snake>(spec, chain);
}

std::vector<PathFrames::Place> snake_at_rest(const SystemSpec& spec, const RestChain& chain) {
  return Snake(spec, chain).controls_at_rest();
}

}  // namespace backbend::solver
