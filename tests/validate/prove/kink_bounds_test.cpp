#include "validate/prove/kink_bounds.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <random>
#include <string>

#include "solver/math/rotation.h"
#include "solver/rig/box_solver.h"
#include "tests/validate/prove/uniform.h"
#include "validate/metrics/chain/chain.h"
#include "validate/metrics/surface/body_metrics.h"
#include "validate/prove/proof.h"

namespace backbend::validate {
namespace {

using solver::BoxCourse;
using solver::Interval;
using testing::uniform;

struct Rig {
  const char* system;
  std::map<std::string, solver::OptionValue> options;
  std::vector<glm::dvec3> joint;
  solver::Mapping mapping;

  std::unique_ptr<solver::SpineSystem> build() const {
    solver::SystemSpec spec;
    spec.system = system;
    spec.options = options;
    solver::RestChain chain;
    chain.joint = joint;
    chain.left = {1, 0, 0};
    return solver::build_system(spec, chain);
  }
};

// Corners of the second one stand at every third of nine bones, of the third one inside bones. The
// last one begins as MakeHuman's does: from the hips forward, and then up.
const std::vector<glm::dvec3> kStraight = {{0, 0, 0}, {0, 0.4, 0}, {0, 0.7, 0}, {0, 1, 0}},
                              kThirds = {{0, 0, 0}, {0, 1, 0}, {0, 1.996, 0.09}, {0, 2.996, 0.09}},
                              kBent = {{0, 0, 0}, {0, 1, 0.2}, {0.1, 2, -0.1}, {0, 3, 0.2}},
                              kHooked = {{0, 0, 0}, {0, 0.5, 0}, {0, 1, 0.6}, {0, 2.5, 0.8}},
                              kForward = {{0, 0, 0},
                                          {0, 0.03, 0.15},
                                          {0, 0.23, 0.07},
                                          {0, 0.39, 0.1},
                                          {0, 0.85, 0}};

std::vector<Rig> rigs() {
  const auto word = [](const char* text) { return std::string(text); };
  const std::vector<double> uneven{0.2, 0.7};
  using solver::Mapping;
  return {{"even", {}, kStraight, Mapping::chest},
          {"even", {{"bones", 7.0}}, kStraight, Mapping::spread},
          {"even", {{"bones", 9.0}}, kThirds, Mapping::chest},
          {"even", {{"bones", 8.0}}, kThirds, Mapping::spread},
          {"isner", {}, kStraight, Mapping::chest},
          {"isner", {{"length", word("stretchy")}}, kBent, Mapping::spread},
          {"isner", {{"placement", word("inclusive")}, {"vertebrae", 9.0}}, kBent, Mapping::chest},
          {"isner", {{"vertebrae", 3.0}}, kStraight, Mapping::chest},
          {"spline_ik", {}, kStraight, Mapping::chest},
          {"spline_ik", {{"bones", 4.0}}, kStraight, Mapping::chest},
          {"spline_ik", {{"bones", 3.0}, {"depth", uneven}}, kStraight, Mapping::spread},
          {"spline_ik", {{"depth", uneven}, {"bones", 6.0}}, kBent, Mapping::spread},
          {"stretchy", {}, kStraight, Mapping::chest},
          {"stretchy", {{"bones", 6.0}}, kStraight, Mapping::chest},
          {"stretchy", {{"stretchiness", 0.0}, {"bones", 8.0}}, kBent, Mapping::spread},
          {"stretchy", {{"form", word("carve")}}, kBent, Mapping::chest},
          {"stretchy",
           {{"form", word("carve")}, {"stretchiness", 0.5}, {"bones", 9.0}},
           kStraight,
           Mapping::spread},
          {"curve", {}, kStraight, Mapping::chest},
          {"curve", {}, kStraight, Mapping::spread},
          {"curve", {{"bones", 5.0}}, kBent, Mapping::chest},
          {"curve", {{"bones", 20.0}}, kHooked, Mapping::spread},
          {"curve", {{"length", word("rest")}}, kStraight, Mapping::spread},
          {"curve", {{"length", word("null_sum")}, {"bones", 4.0}}, kBent, Mapping::chest},
          {"curve", {{"length", word("arc")}, {"bones", 12.0}}, kBent, Mapping::spread},
          {"curve", {{"basis", word("interpolate")}}, kStraight, Mapping::chest},
          {"snake", {{"joints", 12.0}}, kBent, Mapping::chest},
          {"snake", {{"joints", 25.0}, {"controls", 7.0}}, kBent, Mapping::spread},
          {"three_bone", {}, kStraight, Mapping::chest},
          {"three_bone", {}, kBent, Mapping::spread},
          {"neck", {}, kStraight, Mapping::chest},
          {"neck", {}, kHooked, Mapping::spread},
          {"matrix_blend", {}, kStraight, Mapping::chest},
          {"matrix_blend", {{"bones", 3.0}}, kBent, Mapping::chest},
          {"matrix_blend", {{"pivot_pos", 0.0}}, kStraight, Mapping::chest},
          {"matrix_blend", {{"pivot_pos", 0.0}, {"bones", 4.0}}, kBent, Mapping::chest},
          {"matrix_blend", {{"pivot_pos", 2.0}, {"bones", 9.0}}, kHooked, Mapping::spread},
          {"even", {}, kBent, Mapping::chest},
          {"even", {{"bones", 11.0}}, kHooked, Mapping::spread},
          {"even", {}, kForward, Mapping::chest},
          {"even", {{"bones", 8.0}}, kForward, Mapping::spread}};
}

/// The most that BB010 can be, where every joint has this excess at rest, degrees.
double most_kink(const BoxCourse& course, double rest_deg, std::size_t points) {
  const std::vector<glm::dvec3> rest(course.stretch.size() + 1,
                                     glm::dvec3(solver::radians(rest_deg), 0.0, 0.0));
  return kink_over(course, rest, points).hi;
}

/// Whether a chain that chases its curve stands where its course says.
void expect_beside(const BoxCourse& course, const solver::SpineSystem& system,
                   std::span<const double> control, const solver::SpinePose& pose) {
  constexpr std::size_t kPoints = 256;  // a bone
  const std::size_t bones = course.stretch.size(), points = bones * kPoints;
  const std::vector<glm::dvec3> curve = system.intended_curve(control, points + 1);
  const double length = chain_length(curve);
  for (std::size_t k = 1; k <= bones; ++k) {
    const glm::dvec3 bone = pose.position[k] - pose.position[k - 1];
    const glm::dvec3 past = pose.position[k] - curve[k * kPoints];
    const double size = glm::length(bone);
    EXPECT_NEAR(glm::length(glm::cross(past, bone)) / (size * length), 0.0, 1e-9);
    EXPECT_GE(glm::dot(past, bone) / (size * length), course.beside->past[k].lo - 1e-6);
    EXPECT_LE(glm::dot(past, bone) / (size * length), course.beside->past[k].hi + 1e-6);
    EXPECT_GE(size / length, course.beside->bone.lo - 1e-6);
    EXPECT_LE(size / length, course.beside->bone.hi + 1e-6);
  }
  const auto nearest = std::min_element(curve.begin() + std::ptrdiff_t(points / 2), curve.end(),
                                        [&](const glm::dvec3& a, const glm::dvec3& b) {
                                          return glm::distance(a, pose.position[bones]) <
                                                 glm::distance(b, pose.position[bones]);
                                        });
  const double end = double(nearest - curve.begin()) / double(points) - 1.0;
  EXPECT_GE(end, course.beside->end.lo - 1.0 / double(points));
  EXPECT_LE(end, course.beside->end.hi + 1.0 / double(points));
}

/// BACKBEND_PROOF_POSES=100000 runs the battery of docs/batteries.md.
TEST(KinkBounds, NoPoseOfABoxHasALargerKinkThanItsBound) {
  const char* asked = std::getenv("BACKBEND_PROOF_POSES");
  const std::size_t boxes = asked ? std::size_t(std::atol(asked)) / 3 / rigs().size() : 80;
  std::mt19937 random(23);
  for (const Rig& rig : rigs()) {
    SCOPED_TRACE(std::string(rig.system) + std::to_string(rig.options.size()) +
                 (rig.mapping == solver::Mapping::spread ? ", spread" : ""));
    const auto system = rig.build();
    const RigAtRest rest = rig_at_rest(*system);
    const std::vector<glm::dvec3> excess = rest_excess(system->rest(), rest.curve);
    const solver::BoxSolver& solver = box_solver_of(*system);
    const ProofBox whole = read_box("envelope", *find_envelope("human"), *system);
    const PoseOfBox controls(whole, *system, rig.mapping);
    std::size_t bounded = 0, told = 0, lengths = 0;
    double nearest = 1e300;  // of a bound to a kink that it holds for
    for (std::size_t i = 0; i < boxes; ++i) {
      SubBox part;
      const double width = std::array{0.0, 0.1, 1.0, 4.0}[i % 4];
      const double reach = std::array{60.0, 100.0, 20.0}[i / 4 % 3];
      for (std::size_t j = 0; j < part.low.size(); ++j) {
        part.low[j] = reach * uniform(random);
        part.high[j] = part.low[j] + width;
      }
      BoxCourse course;
      solver.course_over(body_over(whole, part), rig.mapping, rest.curve.size(), course);
      const auto [least, most] = kink_over(course, excess, rest.curve.size());
      bounded += std::isfinite(most);
      for (int sample = 0; sample < 3; ++sample) {
        std::array<double, kProofAxes> pose{};
        for (std::size_t j = 0; j < pose.size(); ++j)
          pose[j] = part.low[j] + width * (0.5 + 0.5 * uniform(random));
        const std::vector<double> control = controls.at(pose);
        const solver::SpinePose spine = system->solve(control);
        const auto intended = system->intended_curve(control, rest.curve.size());
        const ChainMeasures measured = measure_chain({spine, system->rest(), intended, rest.curve});
        EXPECT_LE(measured.kink_deg, most + 1e-6);
        EXPECT_GE(measured.kink_deg, least - 1e-6);
        if (measured.kink_deg > 0.005) nearest = std::min(nearest, most / measured.kink_deg);
        told += most < 10.0 * measured.kink_deg + 0.5;
        if (course.beside && std::isfinite(most)) expect_beside(course, *system, control, spine);
        // Where the unit is the same at every pose, bones are as long as they are said to be.
        if (course.beside || course.unit.lo < course.unit.hi || course.unit.lo != 1.0) continue;
        const double unit = std::string(rig.system) == "even" ? chain_length(rig.joint) : 1.0;
        for (std::size_t k = 0; k < course.stretch.size(); ++k) {
          const double bone = glm::distance(spine.position[k], spine.position[k + 1]) / unit;
          EXPECT_GE(bone, course.stretch[k].bone.lo - 1e-9);
          EXPECT_LE(bone, course.stretch[k].bone.hi + 1e-9);
          ++lengths;
        }
      }
    }
    EXPECT_GT(bounded, boxes / 3);
    EXPECT_GT(told, boxes / 3);  // bounds that say something
    const bool of_fixed_unit =
        std::string(rig.system) == "even" || std::string(rig.system) == "snake";
    EXPECT_LT(nearest, of_fixed_unit ? 40.0 : std::string(rig.system) == "isner" ? 2.5 : 6.0);
    EXPECT_GE(lengths, of_fixed_unit ? 9 * boxes : 0);
  }
}

/// The lengths of the chords against which the check holds the bones: found by looking, not by
/// measure_chain().
std::vector<double> chord_lengths(std::span<const glm::dvec3> joint,
                                  std::span<const glm::dvec3> curve) {
  const auto at = [&](double arc) {
    std::size_t i = 1;
    double left = arc;
    for (; i + 1 < curve.size() && left > glm::distance(curve[i - 1], curve[i]); ++i)
      left -= glm::distance(curve[i - 1], curve[i]);
    return curve[i - 1] + left * glm::normalize(curve[i] - curve[i - 1]);
  };
  const double whole = chain_length(curve);
  // In steps that become smaller around the nearest place so far.
  const auto nearest = [&](const glm::dvec3& p, double arc) {
    for (double step = whole / 64.0; step > 1e-13; step *= 0.7) {
      double best = arc;
      for (const double other : {arc - step, arc + step}) {
        if (other >= 0.0 && other <= whole &&
            glm::distance(at(other), p) < glm::distance(at(best), p))
          best = other;
      }
      arc = best;
    }
    return arc;
  };
  const double first = nearest(joint.front(), 0.0), last = nearest(joint.back(), whole);
  std::vector<double> length;
  double passed = 0.0;
  for (std::size_t k = 0; k + 1 < joint.size(); ++k) {
    const double from = passed / chain_length(joint);
    passed += glm::distance(joint[k], joint[k + 1]);
    const double to = passed / chain_length(joint);
    length.push_back(
        glm::distance(at(first + (last - first) * from), at(first + (last - first) * to)));
  }
  return length;
}

/// How far an end of a chord that is `size` long may be from the check's, as an angle in degrees
/// between two of them.
double astray_deg(const BoxCourse::Held::Joint& joint) {
  double sum = 0.0;
  for (std::size_t side = 0; side < 2; ++side)
    sum += joint.astray[side] / length(joint.chord[side].value()).lo;
  return 1.1 * solver::degrees(sum);
}

TEST(KinkBounds, ChordsOfAHeldChainTurnAsTheCheckSeesThem) {
  std::size_t asked = 0;
  for (const Rig& rig : rigs()) {
    std::mt19937 random(31);  // its boxes, whatever other rigs there are
    const auto system = rig.build();
    const RigAtRest rest = rig_at_rest(*system);
    const ProofBox whole = read_box("envelope", *find_envelope("human"), *system);
    const PoseOfBox controls(whole, *system, rig.mapping);
    for (std::size_t i = 0; i < 12; ++i) {
      // Of some width, and at its corners: there what a place moves by counts in full.
      constexpr double kWidth = 0.1;
      SubBox part;
      for (std::size_t j = 0; j < part.low.size(); ++j) {
        part.low[j] = 60.0 * uniform(random);
        part.high[j] = part.low[j] + kWidth;
      }
      BoxCourse course;
      box_solver_of(*system).course_over(body_over(whole, part), rig.mapping, rest.curve.size(),
                                         course);
      if (!course.held) break;
      SCOPED_TRACE(std::string(rig.system) + std::to_string(rig.options.size()));
      for (int corner = 0; corner < 8; ++corner) {
        std::array<double, kProofAxes> pose = part.low;
        for (std::size_t j = 0; j < pose.size(); ++j) pose[j] += corner >> j & 1 ? kWidth : 0.0;
        const std::vector<double> control = controls.at(pose);
        const auto intended = system->intended_curve(control, rest.curve.size());
        const solver::SpinePose spine = system->solve(control);
        const ChainMeasures measured = measure_chain({spine, system->rest(), intended, rest.curve});
        const std::size_t bones = course.held->joint.size() + 1;
        const std::vector<double> chords = chord_lengths(spine.position, intended);
        for (std::size_t k = 0; k + 1 < bones; ++k) {
          const auto& [bone, chord, turn, astray] = course.held->joint[k];
          const auto turns = [](const std::array<solver::BoxVector, 2>& way) {
            return length(arc_between(unit(way[0]), unit(way[1]))).value;
          };
          const double slack = astray_deg(course.held->joint[k]);
          EXPECT_GE(measured.intended_deg[k + 1], solver::degrees(turns(chord).lo) - slack - 1e-7);
          EXPECT_LE(measured.intended_deg[k + 1], solver::degrees(turns(chord).hi) + slack + 1e-7);
          // A neck of three bones at 60 degrees is far from even on its curve; what a chord over a
          // corner turns by depends on where exactly it ends.
          const bool of_corners = !course.stretch.empty();
          const double widest = bones == 3             ? 5.0
                                : of_corners           ? 1.0
                                : rig.joint == kHooked ? 0.4
                                                       : 0.3;
          EXPECT_LT(solver::degrees(turns(chord).width()), widest);
          EXPECT_GE(measured.turn_deg[k + 1], solver::degrees(turns(bone).lo) - 1e-7);
          EXPECT_LE(measured.turn_deg[k + 1], solver::degrees(turns(bone).hi) + 1e-7);
          if (astray[0] == 0.0) {
            const Interval across = length(chord[0].value());
            EXPECT_GE(chords[k], across.lo - 1e-9);
            EXPECT_LE(chords[k], across.hi + 1e-9);
            EXPECT_LT(across.width(), 0.004);
          }
          ++asked;
        }
      }
    }
  }
  EXPECT_GT(asked, 9u * 12u * 8u);
}

/// A neck that is read from frames has its head first.
TEST(KinkBounds, AChainThatIsReadFromItsLastJointHasTheSameBounds) {
  const Rig rig{"neck", {}, kHooked, solver::Mapping::chest};
  const auto upward = rig.build();
  solver::SystemSpec spec;
  spec.system = "neck";
  solver::RestChain frames;
  for (std::size_t i = kHooked.size(); i-- > 0;) {
    solver::RestFrame frame{"v" + std::to_string(i), glm::dmat4(1.0)};
    const glm::dvec3 along = glm::normalize(kHooked[std::min(i + 1, std::size_t{3})] -
                                            kHooked[std::min(i, std::size_t{2})]);
    const glm::dvec3 right(-1.0, 0.0, 0.0);
    frame.rig_from_joint[0] = glm::dvec4(-along, 0.0);
    frame.rig_from_joint[1] = glm::dvec4(right, 0.0);
    frame.rig_from_joint[2] = glm::dvec4(glm::cross(right, along), 0.0);
    frame.rig_from_joint[3] = glm::dvec4(kHooked[i], 1.0);
    frames.frame.push_back(frame);
  }
  const auto downward = solver::build_system(spec, frames);
  // What the rest has at one joint, in the order of the joints, is added there.
  const auto kink = [&](const solver::SpineSystem& system, std::vector<double> rest_deg) {
    const ProofBox whole = read_box("envelope", *find_envelope("human"), system);
    const SubBox part{{20.0, -10.0, 5.0}, {22.0, -8.0, 7.0}};
    BoxCourse course;
    box_solver_of(system).course_over(body_over(whole, part), rig.mapping, 257, course);
    std::vector<glm::dvec3> rest;
    for (const double deg : rest_deg) rest.emplace_back(solver::radians(deg), 0.0, 0.0);
    return kink_over(course, rest, 257).hi;
  };
  const double none = kink(*upward, {0, 0, 0, 0}), low = kink(*upward, {0, 5, 0, 0}),
               high = kink(*upward, {0, 0, 5, 0});
  ASSERT_GT(none, 0.0);
  ASSERT_GT(std::abs(low - high), 1e-3);
  EXPECT_NEAR(kink(*downward, {0, 0, 0, 0}), none, 1e-6);
  EXPECT_NEAR(kink(*downward, {0, 0, 5, 0}), low, 1e-6);
  EXPECT_NEAR(kink(*downward, {0, 5, 0, 0}), high, 1e-6);
}

/// A quarter of a circle, near enough, and six even bones on it.
BoxCourse on_circle() {
  const double handle = 4.0 / 3.0 * std::tan(solver::kPi / 8.0);
  const solver::BoxTangents curve =
      solver::bezier_tangents({solver::BoxVector(glm::dvec3(1, 0, 0)), glm::dvec3(1, handle, 0),
                               glm::dvec3(handle, 1, 0), glm::dvec3(0, 1, 0)});
  const std::vector<double> share = {0.0, 1 / 6.0, 2 / 6.0, 3 / 6.0, 4 / 6.0, 5 / 6.0, 1.0};
  return solver::course_at_shares(curve, curve.length().value, share);
}

TEST(KinkBounds, BonesThatAimFromEverFurtherPastTheirPlacesTurnByThatMuchOfABend) {
  const double bend_deg = 15.0;
  // Each joint stands further past its place by `growth` of a bone.
  const auto kink = [](double growth, double end) {
    BoxCourse course = on_circle();
    course.beside = BoxCourse::Beside{1 / 6.0, {}, end / 6.0, 0.0};
    for (int k = 0; k < 7; ++k) course.beside->past.push_back(k * growth / 6.0);
    return most_kink(course, 0.0, 257);
  };
  // Held against places that reach the curve's end each bone lags by its own share of a bend.
  for (const double growth : {0.001, 0.01}) {
    EXPECT_GT(kink(growth, 0.0), growth * bend_deg);
    EXPECT_GT(kink(-growth, 0.0), growth * bend_deg);
    EXPECT_LT(kink(growth, 0.0), 2.0 * growth * bend_deg);
    EXPECT_LT(kink(-growth, 0.0), 2.0 * growth * bend_deg);
  }
  // A chain that falls short is held against places that lag as its bones do.
  EXPECT_LT(kink(-0.001, -0.006), 1.6 * 0.001 * bend_deg);
  EXPECT_GT(kink(0.001, -0.006), 3.0 * 0.001 * bend_deg);
  // Too far beside the curve nothing is said.
  EXPECT_TRUE(std::isinf(kink(0.5, 0.0)));
}

BoxCourse arcs(std::vector<double> length, double bend) {
  BoxCourse course;
  for (const double arc : length) course.stretch.push_back(solver::stretch_along(arc, bend));
  return course;
}

TEST(KinkBounds, EqualArcsOfABentCurveLeaveLittleRoomForAKink) {
  // Arcs of 1 that turn by up to 6 degrees: a bone is shorter than its arc by 5 in 10,000 at most.
  const BoxCourse gentle = arcs({1, 1, 1, 1}, solver::radians(6.0));
  EXPECT_NEAR(gentle.stretch[0].bone.lo, 1.0 - std::pow(solver::radians(3.0), 2) / 6.0, 1e-9);
  const double most = most_kink(gentle, 0.0, 257);
  EXPECT_GT(most, 0.001);
  EXPECT_LT(most, 0.1);
  // What the rest pose has counts in full, and a sharper curve leaves more room.
  EXPECT_NEAR(most_kink(gentle, 0.5, 257), most + 0.5, 1e-6);
  EXPECT_GT(most_kink(arcs({1, 1, 1, 1}, solver::radians(30.0)), 0.0, 257), 20.0 * most);
  // With fewer points the check sees a rougher curve.
  EXPECT_GT(most_kink(gentle, 0.0, 17), 2.0 * most);
}

TEST(KinkBounds, ACornerInsideABoneCostsMoreThanOneAtItsEnd) {
  const double corner = solver::radians(10.0);
  BoxCourse at_end = arcs({1, 1, 1, 1}, 0.01), inside = at_end;
  at_end.stretch[1] = solver::stretch_along(1.0, 0.01, corner);
  inside.stretch[1] = solver::stretch_over_corners(1.0, 0.01, corner);
  EXPECT_NEAR(inside.stretch[1].bone.lo, std::cos(0.5 * (corner + 0.01)), 1e-9);
  const double smooth = most_kink(arcs({1, 1, 1, 1}, 0.01), 0.0, 257);
  EXPECT_LT(smooth, most_kink(at_end, 0.0, 257));
  EXPECT_LT(most_kink(at_end, 0.0, 257), most_kink(inside, 0.0, 257));
}

TEST(KinkBounds, WhatMayTurnTooFarHasNoBound) {
  EXPECT_TRUE(std::isinf(most_kink(arcs({1, 1, 1, 1}, 2.5), 0.0, 257)));
  EXPECT_TRUE(std::isinf(most_kink(arcs({1, 0.001, 1, 1}, 0.6), 0.0, 257)));
  BoxCourse unknown = arcs({1, 1, 1, 1}, 0.1);
  unknown.stretch[2].bend = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(std::isinf(most_kink(unknown, 0.0, 257)));
  EXPECT_TRUE(std::isinf(solver::stretch_under(1.0, 2.0).bend));
  // Nothing is said of the length of what may turn too far.
  EXPECT_EQ(solver::stretch_along(1.0, 2.5).bone.lo, 0.0);
  EXPECT_EQ(solver::stretch_over_corners(1.0, 1.0, 1.5).bone.lo, 0.0);
  EXPECT_FALSE(solver::stretch_under(1.0, 2.0).arc.is_finite());
}

TEST(KinkBounds, TheArcOverABoneIsNoLongerThanOnACircle) {
  for (const double turn : {1e-6, 0.1, 1.0}) {
    const double bone = 2.0 * std::sin(0.5 * turn) / turn;  // of an arc of 1 that turns so
    const BoxCourse::Stretch under = solver::stretch_under(bone, turn);
    EXPECT_NEAR(under.arc.hi, 1.0, 1e-6);
    EXPECT_GE(under.arc.hi, 1.0 - 1e-15);
    EXPECT_EQ(under.arc.lo, bone);
    const BoxCourse::Stretch along = solver::stretch_along(1.0, turn);
    EXPECT_LE(along.bone.lo, bone);
    EXPECT_NEAR(along.bone.lo, bone, 1e-3);
  }
}

}  // namespace
}  // namespace backbend::validate
