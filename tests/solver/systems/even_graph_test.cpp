#include "solver/systems/even_graph.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "solver/math/rotation.h"

namespace backbend::solver {
namespace {

const RestChain kCurved{{{0, 0, 0}, {0.1, 1, 0.2}, {0, 2.1, 0.5}, {0, 3, 0.3}, {0.1, 4, 0.2}}};

std::vector<double> some_pose() {
  std::vector<double> control;
  for (const double angle : {20, -30, 40, 70, -110, 160, -50, 95, -140}) {
    control.push_back(radians(angle));
  }
  control.push_back(1.0);
  control.push_back(0.0);
  return control;
}

SystemSpec joints_at(std::vector<double> joint) { return {"even", {{"joints", std::move(joint)}}}; }

void expect_refused(const SystemSpec& spec, const std::string& word) {
  try {
    even_graph(spec, kCurved, 20);
    FAIL() << word;
  } catch (const RigError& error) {
    EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
  }
}

TEST(EvenJoints, AtEqualStepsAreTheEqualBonesToTheLastBit) {
  std::vector<double> joint;
  for (int k = 0; k <= 10; ++k) joint.push_back(k / 10.0);
  const SpinePose at = build_system(joints_at(joint), kCurved)->solve(some_pose());
  const SpinePose equal = build_system({"even", {}}, kCurved)->solve(some_pose());
  EXPECT_EQ(at.position, equal.position);
  EXPECT_EQ(at.turn, equal.turn);
}

TEST(EvenJoints, StandOnTheSameSpineWhereverTheyAre) {
  const auto system = build_system(joints_at({0, 0.25, 0.5, 0.75, 1}), kCurved);
  const SpinePose pose = system->solve(some_pose());
  // The curve at equal steps, of the same spine with ten bones.
  const std::vector<glm::dvec3> curve =
      build_system({"even", {}}, kCurved)->intended_curve(some_pose(), 5);
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_LT(glm::distance(pose.position[k], curve[k]), 1e-12) << k;
  }
  EXPECT_EQ(system->arc_fraction(), (std::vector<double>{0, 0.25, 0.5, 0.75, 1}));
}

TEST(EvenJoints, CarryTheFrameHalfABoneAhead) {
  // Ten bones: bone 2 carries the frame at 0.25. Of two bones the joint at 0 carries it, too.
  SystemSpec two = joints_at({0, 0.5, 1});
  two.options["bones"] = 2.0;
  const SpinePose pose = build_system(two, kCurved)->solve(some_pose());
  const SpinePose ten = build_system({"even", {}}, kCurved)->solve(some_pose());
  EXPECT_LT(angle_between(pose.turn[0], ten.turn[2]), 1e-12);
  EXPECT_LT(angle_between(pose.turn[1], ten.turn[7]), 1e-12);
  EXPECT_LT(angle_between(pose.turn[2], ten.turn[10]), 1e-12);
}

TEST(EvenJoints, AreRefusedWhereTheyDoNotRiseFromZeroToOne) {
  for (const std::vector<double>& bad : std::vector<std::vector<double>>{
           {0.0}, {0.1, 1.0}, {0.0, 0.9}, {0.0, 0.5, 0.5, 1.0}, {0.0, 0.6, 0.5, 1.0}, {0.0, 2.0}}) {
    EXPECT_THROW(build_system(joints_at(bad), kCurved), RigError);
  }
  SystemSpec reaching = joints_at({0, 0.5, 1});
  reaching.options["reach"] = 1.0;
  EXPECT_THROW(build_system(reaching, kCurved), RigError);
}

TEST(EvenGraph, ComesToTheSolversSpineWithMoreSteps) {
  const SystemSpec spec = joints_at({0, 0.2, 0.7, 1});
  const auto system = build_system(spec, kCurved);
  const GraphDistance few = distance_from_solver(even_graph(spec, kCurved, 10), *system, 200);
  const GraphDistance many = distance_from_solver(even_graph(spec, kCurved, 200), *system, 200);
  EXPECT_GT(few.place, 1e-5);
  EXPECT_LT(many.place, 1e-6);
  EXPECT_LT(few.turn_deg, 1e-9);  // turns are products, whatever the steps
}

TEST(EvenGraph, TakesTheFewestStepsThatAreNearEnough) {
  const SystemSpec spec = joints_at({0, 0.2, 0.7, 1});
  GraphDistance distance;
  const EvenGraph graph = even_graph_within(spec, kCurved, 3e-4, 500, distance);
  EXPECT_LE(distance.place, 3e-4);
  const auto system = build_system(spec, kCurved);
  for (int steps = 4;; ++steps) {
    const EvenGraph fewer = even_graph(spec, kCurved, steps);
    if (fewer.sample.size() == graph.sample.size()) break;
    EXPECT_GT(distance_from_solver(fewer, *system, 500).place, 3e-4) << steps;
  }
}

TEST(EvenGraph, StandsAtRestExactlyWhereItWasDrawn) {
  const EvenGraph graph = even_graph(joints_at({0, 0.2, 0.7, 1}), kCurved, 20);
  const EvenGraph::Pose rest = graph.pose(std::vector<double>(9, 0.0));
  for (std::size_t k = 0; k < graph.joint.size(); ++k) {
    EXPECT_LT(glm::distance(rest.place[k], graph.joint[k].place), 1e-12 * graph.length);
    EXPECT_EQ(rest.turn[k], kNoTurn);
  }
  // Controls stand at the starts of the three bones, where the steps up to them lead.
  for (const EvenGraph::Control& control : graph.control) {
    glm::dvec3 at = graph.origin;
    for (std::size_t i = 0; i < control.samples; ++i) at += graph.sample[i].step;
    EXPECT_LT(glm::distance(at, control.place), 1e-12 * graph.length) << control.name;
  }
}

TEST(EvenGraph, RefusesWhatIsNoProductOfTurns) {
  expect_refused({"curve", {}}, "even");
  expect_refused({"even", {{"reach", 0.5}}}, "reach");
  expect_refused({"even", {{"limits", std::string("human")}}}, "limits");
  expect_refused({"even", {{"stretchiness", 0.5}}}, "stretchiness");
}

}  // namespace
}  // namespace backbend::solver
