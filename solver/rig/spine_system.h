#pragma once
#include <glm/mat4x4.hpp>
#include <map>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "solver/rig/spine_pose.h"

namespace backbend::solver {

/// A rig, chain or pose that cannot be used. what() is the whole line the user sees.
struct RigError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A joint's rest frame as a file stored it: columns are its axes and its place in rig space.
struct RestFrame {
  std::string name;
  glm::dmat4 rig_from_joint{1.0};
};

/// A path that a body moves along: CVs of a clamped uniform cubic B-spline, and which way is up.
struct PathSpec {
  std::vector<glm::dvec3> point;  // empty: no path was given
  glm::dvec3 up{0.0, 1.0, 0.0};
};

/// The drawn chain that a rig is built on: joints from the hips up (two or more), in rig space.
/// `left` is the character's left: bone frames at rest have X along the bone, Z nearest to `left`,
/// Y = Z x X, which points forward on an upright spine.
///
/// A character gives joints and left. The other fields serve systems that are drawn otherwise, and
/// are empty where the file says nothing: `curve` the CVs of a rest curve (stretchy), `frame` the
/// vertebrae of a rest file in the file's order (neck), `path` the path of the snake.
struct RestChain {
  std::vector<glm::dvec3> joint;
  glm::dvec3 left{1.0, 0.0, 0.0};
  std::vector<glm::dvec3> curve{};
  std::vector<RestFrame> frame{};
  PathSpec path{};
};

using OptionValue =
    std::variant<bool, double, std::string, std::vector<double>, std::vector<std::vector<double>>>;

/// Which system, and every option that was given a value; the rest take their defaults.
struct SystemSpec {
  std::string system;
  std::map<std::string, OptionValue> options;
};

/// One number an animator can set, named `control.channel`: `top.rz`, `chest_move.y`, `slide`.
struct Channel {
  enum class Kind { rotation, translation, scalar };
  std::string name;
  Kind kind = Kind::rotation;  // rotation: radians, never wrapped
  double rest = 0.0;
};

/// The control that a channel belongs to: "chest" of "chest.rx".
inline std::string control_of(const std::string& channel) {
  return channel.substr(0, channel.find('.'));
}

/// A body pose in the names that riggers use, radians; the signs are ours (docs/conventions.md).
/// Extension is a backbend, side bends to the character's left, twist turns it to its left.
///
/// Two channels need controls that not every system has (SpineSystem::why_without): `hip` tips the
/// pelvis forward under a chest that stays, so that the spine bends back as in an extension;
/// `stretch` moves the chest along the line from the hips at rest until it stands this many times
/// as far from them: below 1 it compresses the spine.
struct BodyPose {
  double extension = 0.0;
  double flexion = 0.0;
  double side = 0.0;
  double twist = 0.0;
  double hip = 0.0;
  double stretch = 1.0;
};

/// Channels of a body pose that a system may have no control for.
enum class BodyChannel { hip, stretch };

/// How a body pose reaches the controls (never mixed within a comparison). `chest`: all of it on
/// the top control (chest in place). `spread`: half on the middle, half on the top control (chest
/// also moved to where the three-bone tip would be).
enum class Mapping { chest, spread };

/// How much of a pose is wanted: joints only (with flip margins, flags and attachments), or its
/// measures too.
enum class Detail { joints, all };

/// A spine rig built on a rest chain. Immutable: solve() is a pure function of the controls, the
/// same on any thread, in any order, at any time.
class SpineSystem {
 public:
  virtual ~SpineSystem() = default;

  virtual std::string_view name() const = 0;
  /// Every option with its value, defaults included, in alphabetical order.
  virtual const std::map<std::string, OptionValue>& options() const = 0;
  /// The controls' channels, in the order that solve() takes their values.
  virtual const std::vector<Channel>& channels() const = 0;
  /// One name per joint of the pose.
  virtual const std::vector<std::string>& joint_names() const = 0;
  /// Parent of each joint, -1 for none.
  virtual const std::vector<int>& joint_parents() const = 0;
  /// The pose of the untouched rig: positions are the rest joints, turns the identity.
  virtual const SpinePose& rest() const = 0;
  /// Where each joint stands along the rest chain, 0 hips .. 1 chest, by arc length.
  virtual const std::vector<double>& arc_fraction() const = 0;

  /// The pose for one value per channel (radians, lengths). Degenerate values give the documented
  /// fallback and a flag; the result is always finite for finite input.
  virtual SpinePose solve(std::span<const double> control) const = 0;
  /// solve() into a pose whose memory is used again: for sweeps of many poses. Without detail the
  /// measures may be left empty; all else is the same, bit for bit.
  virtual void solve_into(std::span<const double> control, Detail, SpinePose& pose) const {
    pose = solve(control);
  }

  /// Says that these poses are about to be asked for, each the values of one solve(): a system that
  /// answers many at once faster than one by one computes them now. Changes no result.
  virtual void prepare(std::span<const std::vector<double>>, Detail) const {}

  /// The channel values that stand for a body pose under a mapping.
  virtual std::vector<double> controls_for(const BodyPose& body, Mapping mapping) const = 0;
  /// Why controls_for() leaves a channel out; empty where the system has a control for it.
  virtual std::string_view why_without(BodyChannel) const { return {}; }
  /// The bends of a body pose that no control moves: `twist: the mapping names no control for
  /// it`. Empty where all reach the rig, which is so for every rig but a studio's own.
  virtual std::string why_not_mapped(const BodyPose&) const { return {}; }

  /// The curve the chain is meant to follow in this pose: `count` points (>= 2) at equal arc
  /// steps, hips first. Kinks are judged against its turning.
  virtual std::vector<glm::dvec3> intended_curve(std::span<const double> control,
                                                 std::size_t count) const = 0;

  /// Reads a pose key that is not simply one value per channel: a list of keyed twists, say. The
  /// value is as in the file (degrees). Writes the channels that it sets and returns true; false
  /// if the key is not of this kind. Throws OptionError for a bad value.
  ///
  /// Needed by few: `key = number` sets the channel `key`; `key = [a, b, c]`, or lists of lists,
  /// set every channel named `key.*` in order; `key = {rz = 30}` sets `key.rz`.
  virtual bool read_pose_key(std::string_view, const OptionValue&, std::span<double>) const {
    return false;
  }
};

/// Builds a system on a chain. Throws RigError for an unknown system or option, a value out of
/// range (naming the allowed ones and the nearest name) or a degenerate chain.
std::unique_ptr<SpineSystem> build_system(const SystemSpec& spec, const RestChain& chain);

/// One line of `backbend list rigs`.
struct SystemInfo {
  std::string_view name;
  std::string_view summary;
};
std::span<const SystemInfo> list_systems();

}  // namespace backbend::solver
