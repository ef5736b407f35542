#include "validate/prove/plane_chain.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "solver/math/rotation.h"
#include "solver/rig/spine_system.h"

namespace backbend::validate {
namespace {

using glm::dvec3;
using solver::Interval;

constexpr int kPanels = 512;

struct Case {
  solver::SystemSpec spec;
  std::unique_ptr<PlaneChain> chain;
};

std::vector<Case> cases() {
  const std::vector<double> depth{0.3, 0.6};
  const std::string carve = "carve", arc = "arc";
  std::vector<Case> out;
  out.push_back({{"spline_ik", {{"depth", depth}, {"bones", 6.0}}}, chain_of_shares(6, 0.3, 0.6)});
  out.push_back({{"stretchy", {{"depth", depth}, {"bones", 7.0}, {"form", carve}}},
                 chain_of_shares(7, 0.3, 0.6)});
  out.push_back({{"stretchy", {{"depth", depth}, {"bones", 9.0}}}, chain_of_steps(9, 0.3, 0.6)});
  out.push_back(
      {{"curve", {{"bones", 10.0}}}, chain_that_chases(10, {0.2, 0.5, 0.3}, ChasedLength::nulls)});
  out.push_back({{"curve", {{"bones", 5.0}, {"length", arc}}},
                 chain_that_chases(5, {0.2, 0.5, 0.3}, ChasedLength::arc)});
  return out;
}

std::vector<PlaneBone> bones_at(const PlaneChain& chain, double kappa) {
  return chain.bones(Interval(kappa - 1e-13, kappa + 1e-13), kPanels);
}

TEST(PlaneChain, HasTheDirectionsOfThePlainSolversBones) {
  for (const Case& each : cases()) {
    solver::RestChain rest;
    rest.joint = {{0, 0, 0}, {0, 0.2, 0}, {0, 0.7, 0}, {0, 1, 0}};
    // Their curve is drawn from hips to chest, wherever the joints between stand.
    if (each.spec.system != "curve") rest.joint = {{0, 0, 0}, {0.1, 0.3, 0.1}, {-0.2, 0.9, 0.3}};
    const dvec3 axis = glm::normalize(rest.joint.back() - rest.joint.front());
    const auto system = solver::build_system(each.spec, rest);
    for (const double extension : {0.0, 0.3, 0.8, 1.3}) {
      const solver::SpinePose pose =
          system->solve(system->controls_for({.extension = extension}, solver::Mapping::chest));
      const dvec3 chest = pose.chest.turn * axis;
      const auto bones = bones_at(*each.chain, glm::dot(axis, chest));
      ASSERT_EQ(bones.size() + 1, pose.position.size()) << each.spec.system;
      for (std::size_t k = 0; k < bones.size(); ++k) {
        EXPECT_LT(bones[k].a.width() + bones[k].b.width(), 1e-4);
        const dvec3 found =
            glm::normalize(bones[k].a.middle() * axis + bones[k].b.middle() * chest);
        const dvec3 bone = glm::normalize(pose.position[k + 1] - pose.position[k]);
        EXPECT_LT(glm::distance(found, bone), 1e-4)
            << each.spec.system << " bone " << k << " at " << extension;
      }
    }
  }
}

TEST(PlaneChain, ItsDerivativesAreThoseOfItsBones) {
  constexpr double kStep = 1e-2;
  for (const Case& each : cases()) {
    for (const double kappa : {0.9, 0.5, 0.1}) {
      const auto bones = bones_at(*each.chain, kappa), less = bones_at(*each.chain, kappa - kStep),
                 more = bones_at(*each.chain, kappa + kStep);
      ASSERT_TRUE(!bones.empty() && !less.empty() && !more.empty()) << each.spec.system;
      for (std::size_t k = 0; k < bones.size(); ++k) {
        const auto expect = [&](const Interval& slope, const Interval& low, const Interval& high) {
          EXPECT_LT(slope.width(), 5e-3) << each.spec.system << " bone " << k;
          EXPECT_NEAR(slope.middle(), (high.middle() - low.middle()) / (2.0 * kStep), 5e-4)
              << each.spec.system << " bone " << k << " at " << kappa;
        };
        expect(bones[k].a_by, less[k].a, more[k].a);
        expect(bones[k].b_by, less[k].b, more[k].b);
      }
    }
  }
}

/// Over a wide interval the bones of every kappa in it are enclosed.
TEST(PlaneChain, EnclosesEveryKappa) {
  for (const Case& each : cases()) {
    const auto wide = each.chain->bones(Interval(0.6, 0.602), 64);
    ASSERT_FALSE(wide.empty()) << each.spec.system;
    for (const double kappa : {0.6 + 1e-12, 0.6007, 0.602 - 1e-12}) {
      const auto bones = bones_at(*each.chain, kappa);
      for (std::size_t k = 0; k < bones.size(); ++k) {
        EXPECT_TRUE(wide[k].a.holds(bones[k].a.middle())) << each.spec.system << " bone " << k;
        EXPECT_TRUE(wide[k].b.holds(bones[k].b.middle())) << each.spec.system << " bone " << k;
        EXPECT_TRUE(wide[k].b_by.holds(bones[k].b_by.middle())) << each.spec.system;
      }
    }
  }
}

}  // namespace
}  // namespace backbend::validate
