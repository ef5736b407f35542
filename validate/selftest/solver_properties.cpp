#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <glm/gtc/quaternion.hpp>
#include <glm/trigonometric.hpp>
#include <random>

#include "solver/math/rotation.h"
#include "validate/live/external_rig.h"
#include "validate/metrics/chain/chain.h"
#include "validate/selftest/properties.h"

namespace backbend::validate {
namespace {

using solver::BodyPose;
using solver::RestChain;
using solver::SpinePose;
using solver::SpineSystem;

/// Uniform in [-1, 1), the same on every machine.
double draw(std::mt19937& random) {
  return 2.0 * static_cast<double>(random()) / 4294967296.0 - 1.0;
}

/// Bends well inside the reach of every system, away from flips.
BodyPose some_pose(std::mt19937& random) {
  BodyPose pose;
  const double bend = 0.6 * draw(random);
  (bend > 0 ? pose.extension : pose.flexion) = std::abs(bend);
  pose.side = 0.5 * draw(random);
  pose.twist = 0.6 * draw(random);
  return pose;
}

std::string text_of(const BodyPose& pose) {
  return PoseDegrees{glm::degrees(pose.extension), glm::degrees(pose.flexion),
                     glm::degrees(pose.side), glm::degrees(pose.twist)}
      .text();
}

/// The largest distance between two poses of one chain: positions as a share of `length`, turns in
/// radians, whichever is larger. NaN where either is not finite.
double distance(const SpinePose& a, const SpinePose& b, double length) {
  double worst = 0.0;
  const auto take = [&](double value) {
    if (!(value <= worst)) worst = value;
  };
  for (std::size_t i = 0; i < a.joint_count(); ++i) {
    take(glm::length(a.position[i] - b.position[i]) / length);
    const glm::dquat between = glm::conjugate(a.turn[i]) * b.turn[i];
    take(2.0 *
         std::atan2(glm::length(glm::dvec3(between.x, between.y, between.z)), std::abs(between.w)));
  }
  return worst;
}

SpinePose moved(SpinePose pose, const glm::dquat& turn, const glm::dvec3& move) {
  for (glm::dvec3& p : pose.position) p = move + turn * p;
  for (glm::dquat& q : pose.turn) q = turn * q * glm::conjugate(turn);
  return pose;
}

class SolverProperties {
 public:
  SolverProperties(const Stage& stage, const Stage& again, const RigPlan& rig, std::size_t cases)
      : chain_(stage.rest_chain()),
        rig_(rig),
        cases_(cases),
        length_(chain_length(chain_.joint)),
        system_(stage.build(rig.spec)),
        again_(again.build(rig.spec)) {}

  std::vector<Property> all() const {
    // Another program's rig cannot be built anew elsewhere, larger or mirrored; its numbers may be
    // of single precision.
    if (is_external(rig_.spec))
      return {at_rest(ExternalRig::kSamePose), finite_and_unit(),
              pure("the same in any order and from a program that was started again",
                   ExternalRig::kSamePose)};
    return {at_rest(0.0), finite_and_unit(),  anywhere(),
            scaled(),     mirrored_in_left(), pure("the same in any order and on any thread", 0.0)};
  }

 private:
  Tally tally(const std::string& name, double bound, const std::string& unit) const {
    return {"solver", name, rig_.name, bound, unit};
  }
  static SpinePose solve(const SpineSystem& system, const BodyPose& pose, std::size_t i) {
    return system.solve(
        system.controls_for(pose, i % 2 == 0 ? solver::Mapping::chest : solver::Mapping::spread));
  }

  Property at_rest(double bound) const {
    Tally rest = tally("at rest it is at rest", bound, "of length, rad");
    std::vector<double> control;
    for (const solver::Channel& channel : system_->channels()) control.push_back(channel.rest);
    rest.add(distance(system_->solve(control), system_->rest(), length_), "rest");
    return rest.property();
  }

  /// Any angle at all, up to two turns.
  Property finite_and_unit() const {
    Tally unit = tally("finite, with unit turns, for any angle", 1e-12, "");
    std::mt19937 random(1);
    for (std::size_t i = 0; i < cases_; ++i) {
      std::vector<double> control;
      for (const solver::Channel& channel : system_->channels()) {
        control.push_back(
            channel.kind == solver::Channel::Kind::rotation ? glm::radians(720.0 * draw(random))
            : channel.kind == solver::Channel::Kind::translation ? 0.3 * length_ * draw(random)
                                                                 : channel.rest);
      }
      const SpinePose pose = system_->solve(control);
      double worst = 0.0;
      for (std::size_t j = 0; j < pose.joint_count(); ++j) {
        const double off = std::abs(glm::length(pose.turn[j]) - 1.0);
        const bool finite =
            std::isfinite(pose.position[j].x + pose.position[j].y + pose.position[j].z);
        if (!(off <= worst)) worst = off;
        if (!finite) worst = std::nan("");
      }
      unit.add(worst, "random controls, case " + std::to_string(i));
    }
    return unit.property();
  }

  Property anywhere() const {
    // Rounding of the world's coordinates, magnified by the conditioning of a chase.
    Tally same = tally("moved and turned, the rig moves and turns", 1e-10, "of length, rad");
    const glm::dquat turn = glm::normalize(glm::dquat(0.3, -0.5, 0.7, 0.2));
    const glm::dvec3 move = length_ * glm::dvec3(5, 6, 7);
    RestChain there = chain_;
    for (glm::dvec3& p : there.joint) p = move + turn * p;
    there.left = turn * chain_.left;
    const auto system = solver::build_system(rig_.spec, there);
    std::mt19937 random(2);
    for (std::size_t i = 0; i < cases_; ++i) {
      const BodyPose pose = some_pose(random);
      same.add(
          distance(moved(solve(*system_, pose, i), turn, move), solve(*system, pose, i), length_),
          text_of(pose));
    }
    return same.property();
  }

  Property scaled() const {
    Tally exact = tally("64 times as large, every number is 64 times it", 0.0, "of length, rad");
    RestChain large = chain_;
    for (glm::dvec3& p : large.joint) p *= 64.0;
    const auto system = solver::build_system(rig_.spec, large);
    std::mt19937 random(3);
    for (std::size_t i = 0; i < cases_; ++i) {
      const BodyPose pose = some_pose(random);
      SpinePose expected = solve(*system_, pose, i);
      for (glm::dvec3& p : expected.position) p *= 64.0;
      exact.add(distance(expected, solve(*system, pose, i), 64.0 * length_), text_of(pose));
    }
    return exact.property();
  }

  Property mirrored_in_left() const {
    Tally same = tally("mirrored, left and right swap", 1e-10, "of length, rad");
    const glm::dvec3 left = glm::normalize(chain_.left), origin = chain_.joint.front();
    RestChain other = chain_;
    for (glm::dvec3& p : other.joint) p -= 2.0 * glm::dot(p - origin, left) * left;
    const auto system = solver::build_system(rig_.spec, other);
    std::mt19937 random(4);
    for (std::size_t i = 0; i < cases_; ++i) {
      const BodyPose pose = some_pose(random);
      BodyPose swapped = pose;
      swapped.side = -pose.side;
      swapped.twist = -pose.twist;
      same.add(distance(mirrored(solve(*system_, pose, i), left, origin),
                        solve(*system, swapped, i), length_),
               text_of(pose));
    }
    return same.property();
  }

  Property pure(const std::string& name, double bound) const {
    Tally same = tally(name, bound, "of length, rad");
    std::mt19937 random(5);
    std::vector<BodyPose> poses(cases_);
    for (BodyPose& pose : poses) pose = some_pose(random);
    std::vector<SpinePose> apart(cases_);
    oneapi::tbb::parallel_for(std::size_t{0}, cases_, [&](std::size_t i) {
      apart[cases_ - 1 - i] = solve(*again_, poses[cases_ - 1 - i], i % 2);
    });
    for (std::size_t i = 0; i < cases_; ++i) {
      const SpinePose alone = solve(*system_, poses[i], (cases_ - 1 - i) % 2);
      const bool equal = alone.position == apart[i].position && alone.turn == apart[i].turn;
      same.add(equal ? 0.0 : std::max(1e-300, distance(alone, apart[i], length_)),
               text_of(poses[i]));
    }
    return same.property();
  }

  RestChain chain_;
  RigPlan rig_;
  std::size_t cases_;
  double length_;
  std::unique_ptr<SpineSystem> system_, again_;
};

}  // namespace

std::vector<Property> solver_properties(const Stage& stage, const Stage& again, const RigPlan& rig,
                                        std::size_t cases) {
  return SolverProperties(stage, again, rig, cases).all();
}

}  // namespace backbend::validate
