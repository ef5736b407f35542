#include "validate/metrics/surface/mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "tests/validate/tube_fixture.h"

namespace backbend::validate {
namespace {

using testing::even_bend;
using testing::SlicedTube;
using testing::Tube;

MeshMeasures surface(const SlicedTube& t, const std::vector<glm::vec3>& position,
                     const std::vector<glm::vec3>& normal, const BendIntent& intent) {
  return measure_mesh(t.mesh_rest, position, {normal, {}}, intent, 1.0 / t.tube.bones);
}

/// Turns the frames of all joints above (and with) one by a rotation vector, about that joint.
void turn_above(solver::SpinePose& pose, int joint, const glm::dvec3& turn) {
  const glm::dquat q = rotation(turn);
  const glm::dvec3 pivot = pose.position[joint];
  for (std::size_t i = joint; i < pose.position.size(); ++i) {
    pose.position[i] = pivot + q * (pose.position[i] - pivot);
    pose.turn[i] = q * pose.turn[i];
  }
}

TEST(Mesh, MovedAsAWholeItMeasuresIdeal) {
  const SlicedTube t(Tube(10));
  const glm::dquat turn = rotation({0.9, -0.4, 1.7});
  std::vector<glm::vec3> position, normal;
  for (std::size_t v = 0; v < t.tube.position.size(); ++v) {
    position.push_back(glm::vec3(turn * glm::dvec3(t.tube.position[v]) + glm::dvec3(1, 2, 3)));
    normal.push_back(glm::vec3(turn * glm::dvec3(t.tube.normal[v])));
  }
  const BendIntent intent =
      no_intent(t.slices, t.rest_slices, {turn, glm::dvec3(0.0), glm::dvec3(1, 2, 3)});
  const MeshMeasures m = surface(t, position, normal, intent);
  // Triangles are 5 mm small; positions of size 3 resolve 2e-7 of them: 1e-4 in strain.
  EXPECT_LT(m.stretch, 1.0 + 2e-4);
  EXPECT_LT(m.strain, 2e-4 / 0.05);
  EXPECT_EQ(m.inverted, 0u);
  EXPECT_LT(m.dihedral_deg, 0.1);
  EXPECT_LT(std::abs(m.volume_change), 1e-5);
  const SliceMeasures s = t.measure(position, intent);
  EXPECT_LT(s.kink_worst_deg, 1e-3);
  EXPECT_LT(s.twist_jump_worst_deg, 1e-2);
  EXPECT_NEAR(s.least_area_ratio, 1.0, 1e-5);
  EXPECT_EQ(s.folded, 0.0);
  EXPECT_EQ(s.infeasible, 0.0);
}

TEST(Mesh, WithoutATorsoHasNoStrainToTell) {
  const SlicedTube t(Tube(10));
  RestMesh mesh = t.tube.mesh();
  const std::vector<std::uint8_t> none(t.tube.torso.size(), 0);
  mesh.torso = none;
  const MeshRest rest = prepare_mesh(mesh, t.line, t.coordinate, t.slices);
  EXPECT_EQ(rest.torso_area, 0.0);
  EXPECT_EQ(rest.area, t.mesh_rest.area);
  std::vector<glm::vec3> position = t.tube.position;
  for (glm::vec3& p : position) p *= 1.25f;
  const BendIntent intent = no_intent(t.slices, t.rest_slices);
  const MeshMeasures m = measure_mesh(rest, position, {t.tube.normal, {}}, intent, 0.1);
  EXPECT_TRUE(std::isnan(m.strain_most));
  EXPECT_EQ(m.strain_vertex, MeshMeasures{}.strain_vertex);
  EXPECT_NEAR(m.stretch, 1.25, 1e-4);  // the whole surface has one, all the same
  EXPECT_NEAR(m.volume_change, 1.25 * 1.25 * 1.25 - 1.0, 1e-4);
  EXPECT_EQ(strain_map(rest, position, intent, 0.1), std::vector<float>(position.size(), 0.0f));
}

TEST(Mesh, IsMeantToTwistByWhatIsAskedOverTheSpinesLength) {
  const SlicedTube t(Tube(10));
  for (const double twist : {-2.5, 0.4, 5.0}) {  // more than half a turn, too
    const solver::SpinePose pose = t.tube.pose_of(even_bend(0.6), twist);
    EXPECT_NEAR(t.intent(pose, even_bend(0.6), twist).twist, twist, 1e-6) << twist;
  }
}

TEST(Mesh, CountsEachVertexThatIsNotANumberOnce) {
  const SlicedTube t(Tube(10));
  const BendIntent intent = no_intent(t.slices, t.rest_slices);
  std::vector<glm::vec3> position = t.tube.position, normal = t.tube.normal;
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  position.front().x = position.back().z = position[7].y = kInfinity;
  normal.front().z = normal[9].y = -kInfinity;
  normal.back() = glm::vec3(std::numeric_limits<float>::quiet_NaN());
  const MeshMeasures m = surface(t, position, normal, intent);
  EXPECT_EQ(m.not_finite, 4u);
  EXPECT_TRUE(std::isnan(m.stretch) || m.stretch == MeshMeasures{}.stretch);
  // Each component by itself, in lanes of eight and in what is left over after them.
  for (const std::size_t v : {std::size_t{0}, position.size() / 2, position.size() - 1})
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<glm::vec3> one = t.tube.position;
      one[v][axis] = kInfinity;
      EXPECT_EQ(surface(t, one, t.tube.normal, intent).not_finite, 1u) << v << ' ' << axis;
    }
}

TEST(Mesh, UniformScaleIsItsOwnStretch) {
  const SlicedTube t(Tube(10));
  std::vector<glm::vec3> position = t.tube.position;
  for (glm::vec3& p : position) p *= 1.25f;
  const MeshMeasures m = surface(t, position, t.tube.normal, no_intent(t.slices, t.rest_slices));
  EXPECT_NEAR(m.stretch, 1.25, 1e-4);
  EXPECT_NEAR(m.volume_change, 1.25 * 1.25 * 1.25 - 1.0, 1e-4);
  EXPECT_NEAR(t.measure(position, no_intent(t.slices, t.rest_slices)).least_area_ratio, 1.25 * 1.25,
              1e-4);
}

TEST(Mesh, AStretchThatIsAskedForIsNoStrain) {
  const SlicedTube t(Tube(10));
  std::vector<glm::vec3> position = t.tube.position;
  for (glm::vec3& p : position) p.y *= 1.3f;
  BendIntent intent = no_intent(t.slices, t.rest_slices);
  EXPECT_NEAR(surface(t, position, t.tube.normal, intent).strain, 0.3 / 0.05, 0.01);
  intent.stretch = 1.3;
  EXPECT_NEAR(surface(t, position, t.tube.normal, intent).strain, 1.0, 0.01);
  intent.stretch = 1.15;  // twice what was asked for
  EXPECT_NEAR(surface(t, position, t.tube.normal, intent).strain, 2.0, 0.01);
}

TEST(CandyWrapper, HalfAndHalfAcrossATwistLeavesTheSquaredCosineOfHalfOfIt) {
  const SlicedTube t(Tube(2));
  for (double twist_deg : {45.0, 90.0, 120.0, 170.0}) {
    const double twist = radians_from(twist_deg);
    solver::SpinePose pose = t.tube.rest;
    for (std::size_t i = 1; i < pose.turn.size(); ++i) pose.turn[i] = rotation({0, twist, 0});
    const SliceMeasures m = t.measure(t.tube.skin(pose), no_intent(t.slices, t.rest_slices));
    const double expected = std::pow(std::cos(0.5 * twist), 2);
    // The slices stand 1/70 apart: the nearest is not quite half way.
    EXPECT_NEAR(m.least_area_ratio, expected, 0.01 * expected + 2e-3) << twist_deg;
    EXPECT_NEAR(m.area_slice, 31.5, 1.1);
  }
}

TEST(Mesh, ASmoothBendStretchesAsABeamDoes) {
  const SlicedTube t(Tube(24));
  for (double bend : {0.5, 1.2, 2.4}) {
    const solver::SpinePose pose = t.tube.pose_of(even_bend(bend), 0.0);
    const BendIntent intent = t.intent(pose, even_bend(bend));
    const MeshMeasures m = surface(t, t.tube.skin(pose), t.tube.skin_normals(pose), intent);
    EXPECT_NEAR(m.stretch, 1.0 + bend * t.tube.radius, 0.05 * bend * t.tube.radius) << bend;
    EXPECT_NEAR(m.strain, 1.0, 0.6) << bend;
    EXPECT_EQ(m.inverted, 0u);
    const SliceMeasures s = t.measure(t.tube.skin(pose), intent);
    EXPECT_LT(s.kink_worst_deg, 0.1) << bend;
    EXPECT_NEAR(s.infeasible, bend * t.tube.radius, 0.02 * bend * t.tube.radius) << bend;
    EXPECT_GT(s.least_area_ratio, 0.99) << bend;
    EXPECT_EQ(s.folded, 0.0) << bend;
  }
}

TEST(MeshKink, OfOneDegreeInTwentyFourJointsStandsOutOfEveryCleanBend) {
  const SlicedTube t(Tube(24));
  double clean = 0.0, least = 1e9;
  for (double bend : {0.0, 0.8, 1.6, 2.4}) {
    const solver::SpinePose pose = t.tube.pose_of(even_bend(bend), 0.0);
    const BendIntent intent = t.intent(pose, even_bend(bend));
    clean = std::max(clean, t.measure(t.tube.skin(pose), intent).kink_worst_deg);
    for (int joint : {5, 9, 12, 17}) {
      solver::SpinePose bad = pose;
      turn_above(bad, joint, {radians_from(1.0), 0, 0});
      const SliceMeasures m = t.measure(t.tube.skin(bad), intent);
      least = std::min(least, m.kink_worst_deg);
      EXPECT_NEAR(t.slices.slice[m.kink_slice].s, joint / 24.0, 1.1 / 24.0) << bend;
    }
  }
  EXPECT_LT(clean, 0.2);
  EXPECT_GT(least, 1.5 * clean);
}

TEST(MeshKink, IsMeasuredWhereTheSpineMovesTheBodyHoweverShortThatIs) {
  SlicedTube t(Tube(2));
  EXPECT_EQ(t.window(), 10);  // a sixth of 64 slices: a bone spans more
  for (std::size_t r = 0; r < 40; ++r) t.slices.slice[r].spine_share = 0.0;  // legs move these
  // Three windows and a direction's reach of three at either end have to fit into the 24 left.
  EXPECT_EQ(t.window(), 5);
  const SliceMeasures rest = t.measure(t.tube.position, no_intent(t.slices, t.rest_slices));
  EXPECT_NEAR(rest.kink_worst_deg, 0.0, 1e-3);  // float positions
  EXPECT_NEAR(rest.twist_jump_worst_deg, 0.0, 1e-3);
  EXPECT_GE(rest.kink_slice, 40);
}

TEST(MeshKink, PairedWithAnotherRigOnlyTheDifferenceIsLeft) {
  const SlicedTube t(Tube(6));
  const solver::SpinePose pose = t.tube.pose_of(even_bend(2.0), 0.0);
  const BendIntent intent = t.intent(pose, even_bend(2.0));
  solver::SpinePose bad = pose;
  turn_above(bad, 3, {radians_from(4.0), 0, 0});
  const SliceMeasures a = t.measure(t.tube.skin(pose), intent);
  const SliceMeasures b = t.measure(t.tube.skin(bad), intent);
  double same = 0.0, different = 0.0;
  for (double k : paired_kink(a, a, t.window()))
    if (!std::isnan(k)) same = std::max(same, k);
  for (double k : paired_kink(b, a, t.window()))
    if (!std::isnan(k)) different = std::max(different, k);
  EXPECT_EQ(same, 0.0);
  EXPECT_GT(different, 1.0);
}

TEST(MeshTwistJump, OfOneJointRolledAgainstItsNeighboursIsFoundAtItsPlace) {
  const SlicedTube t(Tube(24));
  const double twist = radians_from(60.0);
  const solver::SpinePose clean = t.tube.pose_of(even_bend(1.0), twist);
  const BendIntent intent = t.intent(clean, even_bend(1.0), twist);
  const double quiet = t.measure(t.tube.skin(clean), intent).twist_jump_worst_deg;
  EXPECT_LT(quiet, 0.2);
  solver::SpinePose bad = clean;
  bad.turn[12] = bad.turn[12] * rotation({0, radians_from(5.0), 0});
  const SliceMeasures m = t.measure(t.tube.skin(bad), intent);
  EXPECT_GT(m.twist_jump_worst_deg, 2.0);
  EXPECT_NEAR(t.slices.slice[m.twist_jump_slice].s, 12.5 / 24, 2.1 / 24);
}

TEST(MeshTwist, IsMeasuredOverTheWindow) {
  const SlicedTube t(Tube(24));
  const double twist = radians_from(90.0);
  const solver::SpinePose pose = t.tube.pose_of(even_bend(0.7), twist);
  const SliceMeasures m = t.measure(t.tube.skin(pose), t.intent(pose, even_bend(0.7), twist));
  EXPECT_NEAR(m.twist_deg[32], 90.0 * t.window() * t.slices.spacing, 0.3);
}

TEST(Mesh, WeightsThatSumToLessThanOneShrinkVolumeAndSlices) {
  Tube tube(10);
  for (auto& weights : tube.weight)
    for (double& w : weights) w *= 0.97;
  const SlicedTube t(std::move(tube));
  const MeshMeasures m =
      surface(t, t.tube.skin(t.tube.rest), t.tube.normal, no_intent(t.slices, t.rest_slices));
  EXPECT_NEAR(m.volume_change, 0.97 * 0.97 * 0.97 - 1.0, 1e-3);
  EXPECT_NEAR(
      t.measure(t.tube.skin(t.tube.rest), no_intent(t.slices, t.rest_slices)).least_area_ratio,
      0.97 * 0.97, 1e-3);
}

TEST(Mesh, OneVertexBoundToAWrongBoneIsTheWorstOfAll) {
  Tube tube(10);
  const std::size_t wrong = 100 * 48 + 7;
  tube.weight[wrong].assign(10, 0.0);
  tube.weight[wrong][0] = 1.0;
  const SlicedTube bad(tube), good(Tube(10));
  const solver::SpinePose pose = bad.tube.pose_of(even_bend(1.5), 0.0);
  const BendIntent intent = bad.intent(pose, even_bend(1.5));
  const MeshMeasures clean =
      surface(good, good.tube.skin(pose), good.tube.skin_normals(pose), intent);
  const MeshMeasures m = surface(bad, bad.tube.skin(pose), bad.tube.skin_normals(pose), intent);
  EXPECT_LT(clean.strain, 3.0);
  EXPECT_GT(m.strain, 50.0);
  EXPECT_NEAR(m.strain_vertex, static_cast<int>(wrong), 49);
  const std::vector<float> map = strain_map(bad.mesh_rest, bad.tube.skin(pose), intent, 0.1);
  EXPECT_EQ(std::max_element(map.begin(), map.end()) - map.begin() <
                static_cast<std::ptrdiff_t>(bad.tube.position.size()),
            true);
  EXPECT_EQ(*std::max_element(map.begin(), map.end()), map[wrong]);
}

TEST(Mesh, RigidWeightsAmplifyStrainAtSmallAnglesAsAtLarge) {
  Tube tube(8, 0.14);
  for (auto& weights : tube.weight) {
    const auto strongest = std::max_element(weights.begin(), weights.end()) - weights.begin();
    weights.assign(weights.size(), 0.0);
    weights[static_cast<std::size_t>(strongest)] = 1.0;
  }
  const SlicedTube bad(tube), good(Tube(8, 0.14));
  double smallest = 1e9, largest = 0.0;
  for (double bend : {radians_from(40.0), radians_from(80.0), radians_from(140.0)}) {
    const solver::SpinePose pose = bad.tube.pose_of(even_bend(bend), 0.0);
    const BendIntent intent = bad.intent(pose, even_bend(bend));
    const double g = surface(bad, bad.tube.skin(pose), bad.tube.skin_normals(pose), intent).strain;
    smallest = std::min(smallest, g);
    largest = std::max(largest, g);
    EXPECT_LT(surface(good, good.tube.skin(pose), good.tube.skin_normals(pose), intent).strain,
              3.0);
  }
  EXPECT_GT(smallest, 11.0);
  EXPECT_LT(largest, 2.5 * smallest);
}

TEST(Mesh, AStepAroundABrowAtRestIsNoFoldWhereItTips) {
  Tube tube(10);
  constexpr double kBrow = 0.6, kTip = 0.15;  // where the body widens, and how far that tips
  for (glm::vec3& p : tube.position)
    if (p.y > kBrow) p = {3.0f * p.x, p.y, 3.0f * p.z};
  const SlicedTube t(std::move(tube));
  std::vector<glm::vec3> tipped = t.tube.position;
  const glm::dmat3 turn(rotation(glm::dvec3(kTip, 0, 0)));
  const glm::dvec3 about(0, kBrow, 0);
  for (glm::vec3& p : tipped)
    if (p.y > kBrow) p = glm::vec3(about + turn * (glm::dvec3(p) - about));
  EXPECT_EQ(t.measure(tipped, no_intent(t.slices, t.rest_slices)).folded, 0.0);
}

TEST(Mesh, FoldsAreToldWhereALineCrossesTwoSlicesInARow) {
  SlicedTube sliced(Tube(10));
  EXPECT_EQ(why_no_folds(sliced.slices, sliced.rest_slices), "");
  for (std::size_t r = 1; r < sliced.slices.slice.size(); r += 2)
    sliced.slices.slice[r].ring.clear();
  EXPECT_NE(why_no_folds(sliced.slices, sliced.rest_slices), "");
}

TEST(Mesh, MoreBendThanTheBodyIsThickIsInfeasibleAndFolds) {
  const SlicedTube t(Tube(24, 0.14));
  // The whole bend in the middle third: curvature 8 per unit, times 0.14 is 1.12.
  const auto bend = [](double s) {
    return glm::dvec3(8.0 / 3.0 * std::clamp(3.0 * s - 1.0, 0.0, 1.0), 0, 0);
  };
  const solver::SpinePose pose = t.tube.pose_of(bend, 0.0);
  const BendIntent intent = t.intent(pose, bend);
  const SliceMeasures m = t.measure(t.tube.skin(pose), intent);
  EXPECT_NEAR(m.infeasible, 1.12, 0.03);
  EXPECT_GT(m.folded, 0.0);
  EXPECT_NEAR(t.slices.slice[m.fold_slice].s, 0.5, 0.2);
  EXPECT_GT(surface(t, t.tube.skin(pose), t.tube.skin_normals(pose), intent).inverted, 0u);
}

TEST(Mesh, AnOpenMeshHasNoVolumeAndSaysWhy) {
  Tube tube(10);
  tube.triangle.pop_back();
  const SlicedTube t(std::move(tube));
  EXPECT_NE(t.mesh_rest.open_reason.find("3 open edges"), std::string::npos)
      << t.mesh_rest.open_reason;
  EXPECT_TRUE(
      std::isnan(surface(t, t.tube.position, t.tube.normal, no_intent(t.slices, t.rest_slices))
                     .volume_change));
  EXPECT_TRUE(SlicedTube(Tube(10)).mesh_rest.open_reason.empty());
}

TEST(Mesh, ATurnedTriangleIsInvertedOnlyIfItWasNotAtRest) {
  Tube tube(10);
  const SlicedTube t(tube);
  std::vector<glm::vec3> normal = t.tube.normal;
  normal[2000] *= -1.0f;
  normal[2001] *= -1.0f;
  normal[2048] *= -1.0f;
  EXPECT_GT(surface(t, t.tube.position, normal, no_intent(t.slices, t.rest_slices)).inverted, 0u);
  tube.normal = normal;
  const SlicedTube from_rest(tube);
  EXPECT_EQ(surface(from_rest, tube.position, normal, no_intent(t.slices, t.rest_slices)).inverted,
            0u);
}

// A game's boxes are shaded flat in one file and smooth in the next: the surface is the same.
TEST(Mesh, WhereJointsAreKnownShadingDoesNotTellWhichTrianglesAreTurnedOver) {
  std::mt19937 random(5);
  const auto spread = [&] {
    return static_cast<float>(static_cast<double>(random()) / 4294967295.0 - 0.5);
  };
  Tube smooth(24, 0.14), rough(24, 0.14);
  for (glm::vec3& n : rough.normal) n = glm::normalize(n + glm::vec3(spread(), spread(), spread()));
  for (glm::vec3& n : rough.normal) n = -n;
  // The whole bend in the middle third, more than the body is thick.
  const auto bend = [](double s) {
    return glm::dvec3(4.0 * std::clamp(3.0 * s - 1.0, 0.0, 1.0), 0, 0);
  };
  const solver::SpinePose pose = smooth.pose_of(bend, 0.4);
  const auto measured = [&](const Tube& tube, bool joints_known) {
    SlicedTube t(tube);
    const testing::TubeBinding bound(t.tube);
    const skin::JointMatrices rest = bound.joints(t.tube.rest);
    const MeshBinding binding{t.tube.position, bound.influences, rest};
    t.mesh_rest = prepare_mesh(t.tube.mesh(), t.line, t.coordinate, t.slices, {},
                               joints_known ? &binding : nullptr);
    const std::vector<glm::mat3> turns = face_turns(bound.joints(pose));
    const std::vector<glm::vec3> normal = t.tube.skin_normals(pose);
    return measure_mesh(t.mesh_rest, t.tube.skin(pose),
                        {normal, joints_known ? turns : std::vector<glm::mat3>{}},
                        t.intent(pose, bend), 1.0 / t.tube.bones);
  };
  const MeshMeasures own = measured(smooth, true);
  EXPECT_GT(own.inverted_area, 0.02);
  EXPECT_EQ(measured(rough, true).inverted_area, own.inverted_area);
  EXPECT_EQ(measured(rough, true).inverted_vertex, own.inverted_vertex);
  EXPECT_EQ(measured(rough, false).inverted, 0u);  // they stand against their normals at rest
  EXPECT_NEAR(measured(smooth, false).inverted_area, own.inverted_area, 0.2 * own.inverted_area);
}

TEST(Mesh, TrianglesThatJointsMirrorFaceAsTheyShould) {
  SlicedTube t{Tube(4)};
  testing::TubeBinding bound(t.tube);
  const auto mirrored = [&](const glm::dvec3& scale) {
    std::vector<skin::SkinJoint> joints(4, {0, glm::dmat4(1.0)});
    return skin::joint_matrices(joints, std::vector{glm::scale(glm::dmat4(1.0), scale)});
  };
  for (const glm::dvec3& scale :
       {glm::dvec3(1, 1, 1), glm::dvec3(-1, 1, 1), glm::dvec3(-1, -1, -2), glm::dvec3(1, 0.2, 3)}) {
    const skin::JointMatrices rest = mirrored(scale);
    Tube tube(4);
    for (glm::vec3& p : tube.position) p *= glm::vec3(scale);
    RestMesh mesh = tube.mesh();
    const MeshBinding binding{t.tube.position, bound.influences, rest};
    const MeshRest made = prepare_mesh(mesh, t.line, t.coordinate, t.slices, {}, &binding);
    std::size_t upright = 0;
    for (const MeshRest::Block& block : made.block)
      upright += static_cast<std::size_t>(std::popcount(block.upright));
    EXPECT_EQ(upright, made.triangles) << scale.x << ' ' << scale.y << ' ' << scale.z;
  }
}

TEST(Mesh, AnEdgeFoldedByAnAngleIsThatDihedralChange) {
  // Two triangles that share an edge along Y; the second is turned about it.
  Tube frame(4);
  std::vector<glm::vec3> position{{0, 0.4f, 0}, {0, 0.6f, 0}, {0.1f, 0.5f, 0}, {-0.1f, 0.5f, 0}};
  const std::vector<glm::vec3> normal(4, glm::vec3(0, 0, 1));
  const std::vector<glm::uvec3> triangle{{0, 2, 1}, {0, 1, 3}};
  const std::vector<std::uint32_t> place{0, 1, 2, 3};
  const std::vector<std::uint8_t> torso(4, 1);
  const RestMesh mesh{position, normal, triangle, place, 4, torso, {}, frame.spine};
  const SpineLine line(frame.spine);
  const auto coordinate = spine_coordinate(mesh, line);
  const SpineSlices slices = cut_slices(mesh, line, coordinate, {1, 0, 0}, 8);
  const MeshRest rest = prepare_mesh(mesh, line, coordinate, slices);
  for (double deg : {0.0, 30.0, 100.0, 170.0, -120.0}) {
    const double angle = radians_from(deg);
    position[3] = {static_cast<float>(-0.1 * std::cos(angle)), 0.5f,
                   static_cast<float>(0.1 * std::sin(angle))};
    EXPECT_NEAR(measure_mesh(rest, position, {normal, {}},
                             no_intent(slices, pose_slices(slices, position)), 0.25)
                    .dihedral_deg,
                std::abs(deg), 0.05);
  }
}

TEST(Mesh, WhatIsNotANumberIsCountedAndNothingElseSaid) {
  const SlicedTube t(Tube(4));
  std::vector<glm::vec3> position = t.tube.position;
  position[5].y = std::nanf("");
  position[9].x = INFINITY;
  EXPECT_EQ(surface(t, position, t.tube.normal, no_intent(t.slices, t.rest_slices)).not_finite, 2u);
}

TEST(PartDrift, IsHowFarTwoMotionsTakeThePartApart) {
  const SlicedTube t(Tube(4));
  const solver::RigidMotion chest{rotation({0.4, 0.2, -0.9}), {0, 1, 0}, {0.3, 0.8, 0.1}};
  std::vector<std::uint8_t> part(t.tube.position.size(), 0);
  for (std::size_t v = 100; v < 200; ++v) part[v] = 1;
  EXPECT_EQ(part_drift(t.tube.position, part, chest, chest).distance, 0.0);
  // Shifted: all by as much.
  solver::RigidMotion arms = chest;
  arms.posed_origin += glm::dvec3(0.02, 0.0, 0.0);
  EXPECT_NEAR(part_drift(t.tube.position, part, arms, chest).distance, 0.02, 1e-12);
  // Turned by an angle about a line: a chord of twice its half's sine at the part's farthest
  // vertex, whatever lies beyond it elsewhere.
  const double angle = 0.3;
  arms = chest;
  arms.turn = chest.turn * rotation({0.0, angle, 0.0});  // about the tube's own axis through origin
  const auto aside = [&](std::size_t v) {
    return std::hypot(t.tube.position[v].x, t.tube.position[v].z);
  };
  double farthest = 0.0;
  for (std::size_t v = 100; v < 200; ++v)
    farthest = std::max(farthest, static_cast<double>(aside(v)));
  const PartDrift drift = part_drift(t.tube.position, part, arms, chest);
  EXPECT_NEAR(drift.distance, 2.0 * std::sin(0.5 * angle) * farthest, 1e-7);
  ASSERT_TRUE(drift.vertex >= 100 && drift.vertex < 200);
  EXPECT_NEAR(aside(static_cast<std::size_t>(drift.vertex)), farthest, 1e-6);
  arms.posed_origin.x = std::nan("");
  EXPECT_TRUE(std::isnan(part_drift(t.tube.position, part, arms, chest).distance));
}

}  // namespace
}  // namespace backbend::validate
