#include "validate/judge/judge.h"
#include "validate/judge/joint_places.h"
#include "validate/judge/judge_input.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <set>

#include "skin/body/body.h"
#include "skin/gltf/gltf_reader.h"
#include "tests/skin/shared_characters.h"
#include "tests/source_folder.h"
#include "tests/validate/spoiled_rig.h"
#include "validate/calibrate/calibration_body.h"
#include "validate/calibrate/faults.h"
#include "validate/files/data_folder.h"
#include "validate/judge/verdict.h"
#include "validate/night/run.h"
#include "validate/stage/ideal_bend.h"
#include "validate/verdicts/exit_code.h"

namespace backbend::validate {
namespace {

/// A straight spine of eight bones in a round body.
const Stage& tube() {
  static const auto body = tube_body(8);
  static const Stage stage(body->character(), skin::AnatomyHints{});
  return stage;
}

std::vector<Sweep> one_of_each() {
  return {channel_sweep("extension", 0, 90, 30), channel_sweep("side", -40, 40, 20),
          channel_sweep("twist", -60, 60, 30)};
}

RigRecord measured(const std::string& rig) {
  return measure_chain_only(tube(), read_rig(rig), solver::Mapping::chest, one_of_each(),
                            *find_envelope("human"));
}

double worst(const RigRecord& rig, MetricId metric) {
  double most = 0.0;
  for (const SweepRecord& sweep : rig.sweeps)
    for (const PoseRecord& pose : sweep.poses) {
      const double value = pose.at(metric).value;
      if (!(value <= most)) most = value;  // NaN is kept
    }
  return most;
}

/// The one value of a rig; NaN where none was noted.
double return_to_rest(const RigRecord& rig) {
  for (const SweepRecord& sweep : rig.sweeps)
    for (const PoseRecord& pose : sweep.poses)
      if (pose.rest_noted) return pose.at(MetricId::return_to_rest).value;
  return std::numeric_limits<double>::quiet_NaN();
}

RigRecord spoiled(Spoiled::Fault fault) {
  RigRecord rig = measured("even");
  rig.system = std::make_unique<Spoiled>(std::move(rig.system), std::move(fault));
  measure_behaviour(tube(), rig);
  return rig;
}

/// How far the controls of `even` stand from rest, summed.
double sum_of(std::span<const double> control) {
  static const RigRecord even = measured("even");
  double sum = 0.0;
  for (std::size_t i = 0; i < control.size(); ++i)
    sum += control[i] - even.system->channels()[i].rest;
  return sum;
}

/// The sweeps of a stressed body that need a hip or a chest to move.
RigRecord pulled(const std::string& rig) {
  return measure_chain_only(
      tube(), read_rig(rig), solver::Mapping::chest,
      {channel_sweep("hip", -40, 40, 20), channel_sweep("stretch", -30, 30, 15)},
      *find_envelope("sweep"));
}

TEST(HipAndStretch, OfARigWithoutTheirControlsAreNotApplicableAndNeverAFinding) {
  for (const char* name : {"curve", "even", "three_bone"}) {
    const RigRecord rig = pulled(name);
    const LimitSet limits;
    EXPECT_TRUE(judge_rig(rig, {tube(), limits, *find_envelope("sweep"), "tube"}).empty()) << name;
    for (const Coverage& each : coverage_of(rig)) {
      EXPECT_EQ(each.not_measured, 0) << each.code;
      EXPECT_EQ(each.measured + each.not_applicable, each.planned) << each.code;
      // Of both sweeps only the pose at rest is one that the rig can take.
      EXPECT_LE(each.measured, 2) << each.code;
      if (each.code == "BB001") {
        EXPECT_EQ(each.not_applicable, 2);
      }
    }
  }
  for (const Coverage& each : coverage_of(pulled("isner")))
    if (each.code == "BB001" || each.code == "BB010") {
      EXPECT_EQ(each.measured, each.planned) << each.code;
    }
}

TEST(HipAndStretch, AStretchThatTheRigIsBuiltForIsNoFault) {
  for (const char* name :
       {"stretchy", "stretchy:stretchiness=0.5", "even:stretchiness=1", "isner:length=stretchy"}) {
    const RigRecord rig = pulled(name);
    for (const PoseRecord& pose : rig.sweeps[1].poses) {
      EXPECT_TRUE(pose.taken) << name;
      EXPECT_LT(pose.at(MetricId::length_change).value, 1.0) << name << ", " << pose.body.text();
      EXPECT_LT(pose.at(MetricId::chain_kink).value, 0.5) << name << ", " << pose.body.text();
    }
  }
  // The length that is asked for is that of the curve, and only where a stretch is.
  const RigRecord rig = pulled("isner:length=stretchy");
  const auto curve = rig.system->intended_curve(rig.sweeps[1].poses.back().control, kCurvePoints);
  EXPECT_EQ(asked_length(rig_at_rest(*rig.system), curve, false), 1.0);
  EXPECT_NEAR(asked_length(rig_at_rest(*rig.system), curve, true), 1.3, 1e-6);
}

TEST(HipAndStretch, TheIdealBendHasTheSameChestAgainstTheHips) {
  EXPECT_EQ(IdealBend(parse_pose("hip=30,twist=5")).pose.text(), "extension 30, twist 5");
  EXPECT_EQ(IdealBend(parse_pose("flexion=40,hip=30")).pose.text(), "flexion 10");
  EXPECT_EQ(IdealBend(parse_pose("extension=40")).spec.options.size(), 0u);
  EXPECT_EQ(IdealBend(parse_pose("stretch=10")).spec.options.count("stretchiness"), 1u);
}

TEST(Behaviour, OfTheEvenSpineIsCleanAndWhollyMeasured) {
  const RigRecord rig = measured("even");
  EXPECT_LT(worst(rig, MetricId::mirror), 1e-6);
  EXPECT_EQ(return_to_rest(rig), 0.0);
  EXPECT_LT(worst(rig, MetricId::predictability), 0.01);
  EXPECT_LT(worst(rig, MetricId::chain_twist_jump), 3.0);
  EXPECT_EQ(worst(rig, MetricId::non_finite), 0.0);
  EXPECT_GT(worst(rig, MetricId::range_of_motion), 0.5);
  for (const Coverage& each : coverage_of(rig)) EXPECT_EQ(each.not_measured, 0) << each.code;
}

TEST(Behaviour, OfASpineThatIsNotStraightIsNoMirrorAsymmetryOfTheRig) {
  skin::Character character = tube_body(8)->character();
  const skin::Anatomy& anatomy = tube().anatomy();
  for (std::size_t k = 1; k < anatomy.chest_index; ++k) {  // to the left and back again
    const auto node = static_cast<std::size_t>(anatomy.spine[k]);
    const double aside = (k % 3 == 0 ? -0.01 : 0.006) * anatomy.spine_length;
    character.nodes[node].world_from_node[3] += glm::dvec4(aside * anatomy.left, 0.0);
  }
  const Stage stage(character, skin::AnatomyHints{});
  const std::vector<PoseDegrees> ends = {PoseDegrees{}, parse_pose("flexion=90,side=45,twist=60")};
  const std::vector<Sweep> corner = {path_sweep("corner", ends, 15)};
  RigRecord rig = measure_chain_only(stage, read_rig("even"), solver::Mapping::chest, corner,
                                     *find_envelope("human"));
  EXPECT_LT(worst(rig, MetricId::mirror), 1e-6);
  // What the rig itself does is still seen.
  ASSERT_NE(rig.in_plane, nullptr);
  const auto lean = [](std::span<const double> control, solver::SpinePose& pose) {
    if (sum_of(control) != 0.0) pose.position[4].x += 0.02;
  };
  rig.in_plane = std::make_unique<Spoiled>(std::move(rig.in_plane), lean);
  rig.system = std::make_unique<Spoiled>(std::move(rig.system), lean);
  measure_behaviour(stage, rig);
  EXPECT_GT(worst(rig, MetricId::mirror), 1.0);
}

TEST(Behaviour, AJointThatLeansToOneSideIsAMirrorAsymmetryOfTwiceItsLean) {
  const double length = chain_length(measured("even").system->rest().position);
  const RigRecord rig = spoiled([&](std::span<const double> control, solver::SpinePose& pose) {
    if (sum_of(control) != 0.0) pose.position[4].x += 0.01 * length;
  });
  EXPECT_NEAR(worst(rig, MetricId::mirror), 2.0, 1e-6);
  const PoseRecord& bent = rig.sweeps[0].poses.back();
  EXPECT_EQ(bent.at(MetricId::mirror).place, 4);
  EXPECT_EQ(return_to_rest(rig), 0.0);
}

TEST(Behaviour, WhatStaysWhenEveryControlIsBackIsFound) {
  const double length = chain_length(measured("even").system->rest().position);
  const RigRecord rig = spoiled([&](std::span<const double>, solver::SpinePose& pose) {
    pose.position[6].y += 0.002 * length;
  });
  EXPECT_NEAR(return_to_rest(rig), 0.2, 1e-9);
  EXPECT_EQ(rig.sweeps[0].poses[0].at(MetricId::return_to_rest).place, 6);
  // It fails once, not once a sweep.
  const LimitSet limits;
  const auto findings = judge_rig(rig, {tube(), limits, *find_envelope("human"), "tube"});
  EXPECT_EQ(std::ranges::count(findings, "BB044", &Finding::code), 1);
}

TEST(Behaviour, ReturnToRestIsSolvedAndCountedOnceForARig) {
  const RigRecord even = measured("even");
  std::vector<double> neutral;
  for (const solver::Channel& channel : even.system->channels()) neutral.push_back(channel.rest);
  std::atomic<int> solves = 0;
  const auto count = [&](std::span<const double> control, solver::SpinePose&) {
    if (std::ranges::equal(control, neutral)) ++solves;
  };
  const RigRecord rig = spoiled(count);
  // Of 13 poses three are at rest, each solved for itself, its mirror image and the response.
  EXPECT_EQ(solves, 1 + 3 * 3);
  int noted = 0;
  for (const SweepRecord& sweep : rig.sweeps)
    for (const PoseRecord& pose : sweep.poses)
      noted += static_cast<int>(std::isfinite(pose.at(MetricId::return_to_rest).value));
  EXPECT_EQ(noted, 1);
  const auto coverage = coverage_of(rig);
  const auto counted = std::ranges::find(coverage, "BB044", &Coverage::code);
  ASSERT_NE(counted, coverage.end());
  EXPECT_EQ(counted->planned, 1);
  EXPECT_EQ(counted->measured, 1);
  EXPECT_EQ(std::ranges::find(coverage, "BB010", &Coverage::code)->planned, 14);
}

TEST(Behaviour, AnEndThatTurnsAboutAnotherAxisThanItsControlIsUnpredictable) {
  const RigRecord rig = spoiled([&](std::span<const double> control, solver::SpinePose& pose) {
    // A bend that leaks a third of itself into twist.
    pose.turn.back() = pose.turn.back() * rotation(glm::dvec3(0, sum_of(control) / 3.0, 0));
  });
  EXPECT_GT(worst(rig, MetricId::predictability), 10.0);
}

TEST(JudgeInput, NamesTheStrayVertexAndTheUnweightedOne) {
  const auto body = tube_body(8);
  skin::Character character = body->character();
  const std::size_t stray = 700;  // in the belly, bound to a hand
  bind_vertex(character.influences[stray], static_cast<std::uint16_t>(character.joints.size() - 1));
  character.unweighted = {41};
  character.worst_weight_sum = 0.97;
  character.renormalised_vertices = 3;
  const Stage stage(character, skin::AnatomyHints{});
  const LimitSet limits;
  const Envelope envelope = *find_envelope("human");
  const JudgeContext context{stage, limits, envelope, "tube.glb"};
  const RigRecord rig = measured("even");
  const InputReading weights = read_input(stage);
  const BodyMetrics metrics(stage.character(), stage.anatomy(), stage.driver());
  const std::vector<Finding> findings = judge_input(rig, context, weights, metrics, true).findings;
  ASSERT_GE(findings.size(), 3u);  // what hangs on a hand is far from it as well
  EXPECT_EQ(findings[0].code, "BB060");
  EXPECT_NEAR(findings[0].value, 3.0, 1e-9);
  EXPECT_EQ(findings[1].code, "BB061");
  EXPECT_EQ(findings[1].vertex, 41);
  EXPECT_EQ(findings[2].code, "BB062");
  EXPECT_EQ(findings[2].vertex, static_cast<int>(stray));
  for (const Finding& finding : findings) {
    EXPECT_EQ(finding.owner, finding.code < "BB063" ? Owner::input : Owner::weights);
    EXPECT_EQ(finding.verdict, Verdict::fail);
  }
  // A rig is not to blame for the file.
  for (const Finding& finding : judge_input(rig, context, weights, metrics, false).findings)
    EXPECT_EQ(finding.verdict, Verdict::stress);
  // The same body without the faults.
  const JudgeContext clean{tube(), limits, envelope, "tube.glb"};
  EXPECT_TRUE(judge_input(rig, clean, read_input(tube()), metrics, true).findings.empty());
}

const skin::Anatomy& tube_anatomy() {
  static const skin::Anatomy anatomy = skin::find_anatomy(tube_body(8)->character());
  return anatomy;
}

/// What is said of joints' places where some of the tube's are moved, in shares of the spine's
/// length, and bound there.
std::vector<Finding> places_with(std::size_t first, std::size_t last, const glm::dvec3& shift,
                                 bool move_nothing = false) {
  skin::Character character = tube_body(8)->character();
  const skin::Anatomy& anatomy = tube_anatomy();
  const auto node = [&](int n) -> const skin::Node& {
    return character.nodes[static_cast<std::size_t>(n)];
  };
  for (auto& each : character.joints) {
    bool above = false;
    for (int n = each.node; n >= 0; n = node(n).parent) above |= n == anatomy.spine[first];
    if (!move_nothing || !above) continue;
    const int below = anatomy.spine[first - 1];  // holds their weight
    each.joint_from_mesh = glm::inverse(node(below).world_from_node) *
                           node(each.node).world_from_node * each.joint_from_mesh;
    each.node = below;
  }
  for (std::size_t k = first; k <= last; ++k) {
    glm::dmat4& world = character.nodes[static_cast<std::size_t>(anatomy.spine[k])].world_from_node;
    const glm::dmat4 before = world;
    world[3] += glm::dvec4(shift * anatomy.spine_length, 0.0);
    for (auto& each : character.joints)
      if (each.node == anatomy.spine[k])
        each.joint_from_mesh = glm::inverse(world) * before * each.joint_from_mesh;
  }
  skin::AnatomyHints hints;
  hints.hip = node(anatomy.spine.front()).name;
  hints.chest = node(anatomy.spine[anatomy.chest_index]).name;
  const Stage stage(character, hints);
  const LimitSet limits;
  const Envelope envelope = *find_envelope("human");
  const BodyMetrics metrics(stage.character(), stage.anatomy(), stage.driver());
  std::vector<Finding> found = judge_input(measured("even"), {stage, limits, envelope, "tube.glb"},
                                           read_input(stage), metrics, true)
                                   .findings;
  std::erase_if(found, [](const Finding& each) { return each.code < "BB071"; });
  return found;
}

TEST(JudgeInput, AJointOfTheSpineBesideTheBodysMiddleIsNamedAndBlamed) {
  const skin::Anatomy& anatomy = tube_anatomy();
  const glm::dvec3 left = anatomy.left;
  const std::string name =
      tube_body(8)->character().nodes[static_cast<std::size_t>(anatomy.spine[4])].name;
  for (const double side : {1.0, -1.0}) {
    const std::vector<Finding> found = places_with(4, 4, left * (0.1 * side));
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].code, "BB071");
    EXPECT_EQ(found[0].joint, name);
    EXPECT_EQ(found[0].owner, Owner::skeleton);
    EXPECT_EQ(found[0].verdict, Verdict::fail);
    EXPECT_NE(found[0].detail.find(side > 0 ? "to the left" : "to the right"), std::string::npos);
  }
  EXPECT_TRUE(places_with(4, 4, left * 0.01).empty());
  EXPECT_TRUE(places_with(4, 4, anatomy.forward * 0.1).empty());
}

TEST(JudgeInput, ASpineOutsideTheBodyIsNamedAndBlamed) {
  const skin::Anatomy& anatomy = tube_anatomy();
  for (const double side : {1.0, -1.0}) {
    const glm::dvec3 way = anatomy.forward * side;
    const std::vector<Finding> found = places_with(0, anatomy.chest_index, way * 0.3);
    ASSERT_EQ(found.size(), 3u) << side;  // three joints of a check are findings
    for (const Finding& each : found) {
      EXPECT_EQ(each.code, "BB073");
      EXPECT_FALSE(each.joint.empty());
      EXPECT_EQ(each.owner, Owner::skeleton);
      EXPECT_EQ(each.verdict, Verdict::fail);
    }
    EXPECT_TRUE(places_with(0, anatomy.chest_index, way * 0.1).empty());
  }
}

TEST(JudgeInput, ASpineWhoseEndMovesNothingMayReachOutOfTheBody) {
  const skin::Anatomy& anatomy = tube_anatomy();
  const glm::dvec3 way = anatomy.forward * 0.3;
  ASSERT_FALSE(places_with(anatomy.chest_index, anatomy.chest_index, way).empty());
  EXPECT_TRUE(places_with(anatomy.chest_index, anatomy.chest_index, way, true).empty());
}

TEST(JudgeInput, ASpineInFrontOfAFigureOfBonesIsNotCalledOutside) {
  const skin::Character human = skin::make_body(
      skin::read_body_description(source_folder() / "scenes/characters/human.toml"), {4000});
  const skin::Anatomy anatomy = skin::find_anatomy(human);
  const auto is_outside = [&](double thickness, double behind) {
    skin::Character character = human;  // its torso below the chest drawn to a column behind it
    for (std::size_t v = 0; v < character.vertex_count(); ++v) {
      const int node = character.joints[character.influences[v].joint[0]].node;
      const auto on = std::find(anatomy.spine.begin(), anatomy.spine.end(), node);
      if (on - anatomy.spine.begin() >= static_cast<std::ptrdiff_t>(anatomy.chest_index)) continue;
      const glm::dvec3 column =
          glm::dvec3(character.nodes[static_cast<std::size_t>(node)].world_from_node[3]) -
          behind * anatomy.height * anatomy.forward;
      const glm::dvec3 off = glm::dvec3(character.bind_position[v]) - column;
      const glm::dvec3 along = glm::dot(off, anatomy.up) * anatomy.up;
      character.bind_position[v] = glm::vec3(column + along + thickness * (off - along));
    }
    const Stage stage(character, skin::AnatomyHints{});
    const LimitSet limits;
    const BodyMetrics metrics(stage.character(), stage.anatomy(), stage.driver());
    const std::vector<Finding> found =
        judge_input(measured("even"), {stage, limits, *find_envelope("human"), "human"},
                    read_input(stage), metrics, true)
            .findings;
    return std::ranges::find(found, "BB073", &Finding::code) != found.end();
  };
  EXPECT_FALSE(is_outside(0.25, 0.06));
  EXPECT_TRUE(is_outside(0.6, 0.12));
}

TEST(JudgeInput, ASpineOutsideAFishIsNamedThoughTheFishIsThin) {
  REQUIRE_CHARACTER("shark.glb");
  skin::Character shark = skin::read_character(skin::shared_character("shark.glb"));
  const skin::Anatomy anatomy = skin::find_anatomy(shark);
  const glm::dmat4 shift = glm::translate(glm::dmat4(1.0), (0.1 * anatomy.height) * anatomy.up);
  for (skin::Node& node : shark.nodes) node.world_from_node = shift * node.world_from_node;
  for (auto& joint : shark.joints)
    joint.joint_from_mesh = joint.joint_from_mesh * glm::inverse(shift);
  const Stage stage(shark, skin::AnatomyHints{});
  const LimitSet limits;
  const BodyMetrics metrics(stage.character(), stage.anatomy(), stage.driver());
  const std::vector<Finding> found =
      judge_input(measured("even"), {stage, limits, *find_envelope("animal"), "shark"},
                  read_input(stage), metrics, true)
          .findings;
  EXPECT_NE(std::ranges::find(found, "BB073", &Finding::code), found.end());
}

TEST(JudgeInput, ABodyBesideItsSkeletonIsNamedWithTheShift) {
  const skin::Character human = skin::make_body(
      skin::read_body_description(source_folder() / "scenes/characters/human.toml"), {4000});
  const skin::Anatomy anatomy = skin::find_anatomy(human);
  const std::vector<std::pair<glm::dvec3, std::string>> ways = {
      {anatomy.up, "below"}, {anatomy.forward, "behind"}, {-anatomy.left, "to the left of"}};
  for (const auto& [way, word] : ways) {
    skin::Character character = human;
    const glm::dmat4 shift =
        glm::translate(glm::dmat4(1.0), way * (0.1 * anatomy.height));  // of the skeleton alone
    for (skin::Node& node : character.nodes) node.world_from_node = shift * node.world_from_node;
    for (auto& joint : character.joints)
      joint.joint_from_mesh = joint.joint_from_mesh * glm::inverse(shift);
    const Stage stage(character, skin::AnatomyHints{});
    const LimitSet limits;
    const BodyMetrics metrics(stage.character(), stage.anatomy(), stage.driver());
    const std::vector<Finding> found =
        judge_input(measured("even"), {stage, limits, *find_envelope("human"), "tube.glb"},
                    read_input(stage), metrics, true)
            .findings;
    const auto beside = std::ranges::find(found, "BB074", &Finding::code);
    ASSERT_NE(beside, found.end()) << word;
    EXPECT_EQ(beside->verdict, Verdict::fail);
    EXPECT_EQ(beside->owner, Owner::skeleton);
    EXPECT_NEAR(beside->geometry.at("millimetres"), 100.0 * anatomy.height, 30.0) << word;
    EXPECT_NE(beside->detail.find(word + " their bones"), std::string::npos) << beside->detail;
  }
}

TEST(JudgeInput, OfABodyWithoutLimbsNoJointIsCalledAside) {
  const auto body = tube_body(8);
  skin::Anatomy anatomy = skin::find_anatomy(body->character());
  for (auto* limb : {&anatomy.left_arm, &anatomy.right_arm, &anatomy.left_leg, &anatomy.right_leg})
    limb->clear();
  const Stage stage(body->character(), anatomy);
  const BodyMetrics metrics(stage.character(), stage.anatomy(), stage.driver());
  for (const JointPlace& place : joint_places(stage, metrics)) EXPECT_TRUE(std::isnan(place.aside));
}

TEST(JudgeInput, AJointPastItsNeighbourIsNamed) {
  const glm::dvec3 up = tube_anatomy().up;
  const std::vector<Finding> above = places_with(4, 4, up * 0.18),
                             below = places_with(4, 4, up * -0.18);
  for (const std::vector<Finding>* found : {&above, &below}) {
    ASSERT_FALSE(found->empty());
    for (const Finding& each : *found) EXPECT_EQ(each.code, "BB072");
  }
  EXPECT_TRUE(places_with(4, 4, up * 0.06).empty());
}

TEST(CompoundLoad, IsTheRootOfTheSumOfSquaresOfWhatEachChannelNeeds) {
  const Envelope human = *find_envelope("human");  // 60, 90, 45, 60
  EXPECT_EQ(compound_load(human, parse_pose("extension=60")), 1.0);
  EXPECT_EQ(compound_load(human, parse_pose("extension=30,side=10")), 1.0);  // inside of 1
  EXPECT_NEAR(compound_load(human, parse_pose("extension=60,side=-45,twist=60")), std::sqrt(3.0),
              1e-12);
  EXPECT_NEAR(compound_load(human, parse_pose("flexion=90,twist=30")), std::sqrt(1.25), 1e-12);
  EXPECT_EQ(compound_load(human, parse_pose("extension=90,side=45")), 1.0);  // not required
  EXPECT_EQ(compound_load(*find_envelope("sweep"), parse_pose("extension=60,side=45")), 1.0);
}

TEST(LimitAt, GrowsWithTheLoadWhereTheMeshIsMeasuredAndNowhereElse) {
  EXPECT_EQ(limit_at("BB011", 25.0, 1.0), 25.0);
  EXPECT_EQ(limit_at("BB011", 25.0, 1.5), 37.5);   // an angle
  EXPECT_EQ(limit_at("BB034", 2.0, 1.5), 4.5);     // a share of area
  EXPECT_EQ(limit_at("BB030", 0.75, 1.5), 0.625);  // what a slice keeps
  for (const char* code : {"BB001", "BB002", "BB010", "BB014", "BB020", "BB022", "BB050"})
    EXPECT_EQ(limit_at(code, 3.0, 1.7), 3.0) << code;
}

TEST(Headroom, OfAChannelThatNoSweepMovesIsNotMeasured) {
  const LimitSet limits;
  const Envelope human = *find_envelope("human");
  const RigRecord rig = measured("even");  // extension 0..90, side +-40, twist +-60; no flexion
  const std::vector<Headroom> rows = headroom_of(rig, {tube(), limits, human, "tube"}, {});
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_TRUE(rows[0].covered());
  EXPECT_EQ(rows[1].channel, "flexion");
  EXPECT_FALSE(rows[1].measured);
  EXPECT_FALSE(rows[1].covered());
  EXPECT_EQ(rows[2].tested_to_deg, 40.0);
  EXPECT_FALSE(rows[2].covered());  // 45 are needed
  EXPECT_TRUE(rows[3].covered());
  EXPECT_FALSE(corners_of(rig, {tube(), limits, human, "tube"}, {}).covered());
}

TEST(Headroom, OfSideAndTwistIsTheNearerOfBothWays) {
  const LimitSet limits;
  const Envelope human = *find_envelope("human");
  const RigRecord rig = measure_chain_only(tube(), read_rig("even"), solver::Mapping::chest,
                                           {channel_sweep("side", -10, 45, 5)}, human);
  const std::vector<Headroom> rows = headroom_of(rig, {tube(), limits, human, "tube"}, {});
  const auto side = std::ranges::find(rows, "side", &Headroom::channel);
  ASSERT_NE(side, rows.end());
  EXPECT_EQ(side->tested_to_deg, 10.0);
  EXPECT_FALSE(side->covered());
}

TEST(Headroom, DoesNotCountWhatOnlyTheSkeletonIsToBlameFor) {
  const LimitSet limits;
  const Envelope human = *find_envelope("human");
  RigRecord rig = measured("even");
  rig.has_mesh = true;
  rig.surface.has_kinks = true;
  for (PoseRecord& pose : rig.sweeps[0].poses)
    pose.at(MetricId::mesh_kink) = {pose.control_deg, 3};  // 25 is the limit: over it from 30 on
  const JudgeContext context{tube(), limits, human, "tube"};
  EXPECT_EQ(headroom_of(rig, context, {})[0].clean_to_deg, 0.0);
  Finding finding;
  finding.code = "BB011";
  finding.at.sweep = 0;
  finding.owner = Owner::skeleton;
  finding.verdict = Verdict::stress;
  finding.inside_envelope = true;
  EXPECT_EQ(headroom_of(rig, context, {finding})[0].clean_to_deg, 60.0);  // 90 lies outside
  finding.owner = Owner::weights;
  finding.verdict = Verdict::fail;
  EXPECT_EQ(headroom_of(rig, context, {finding})[0].clean_to_deg, 0.0);
}

TEST(Coverage, AsksAChainOfFewJointsForNoTwistJump) {
  for (const char* name : {"three_bone", "even:bones=4", "even:bones=5", "curve"}) {
    const RigRecord rig = measured(name);
    const std::vector<Coverage> all = coverage_of(rig);
    const auto jump = std::ranges::find(all, "BB014", &Coverage::code);
    ASSERT_NE(jump, all.end());
    const bool few = rig.system->rest().position.size() < kLeastTwistJumpJoints;
    EXPECT_EQ(few, std::string(name) == "three_bone" || std::string(name) == "even:bones=4");
    EXPECT_EQ(jump->not_applicable, few ? jump->planned : 0) << name;
  }
}

/// The bundled human under the thesis's rig, whose arms drift when it bends and leans at once.
RunRequest drifting_run() {
  RunRequest request;
  request.suite = read_suite(data_folder() / "scenes" / "nightly.toml");
  request.suite.rigs = {read_rig("curve")};
  request.suite.mappings = {solver::Mapping::chest};
  request.suite.sweeps = {channel_sweep("extension", 60, 90, 30)};
  request.suite.pictures.enabled = false;
  request.suite.calibration = {};
  request.suite.hunt = {};
  request.image_pass = false;
  request.today = "2026-11-21";
  return request;
}

Report report_of(const RunRequest& request) {
  Progress progress(Progress::Style::none);
  return run_suite(request, progress);
}

std::size_t count(const Report& report, const std::string& code, Verdict verdict) {
  return static_cast<std::size_t>(std::count_if(
      report.findings.begin(), report.findings.end(),
      [&](const Finding& finding) { return finding.code == code && finding.verdict == verdict; }));
}

TEST(Waivers, InARunTurnFailuresIntoWaivedOnesUntilTheyExpire) {
  RunRequest request = drifting_run();
  const Report plain = report_of(request);
  ASSERT_EQ(plain.exit_code, kExitFindings);
  std::set<std::string> failing;
  for (const Finding& finding : plain.findings)
    if (finding.verdict == Verdict::fail) failing.insert(finding.code);
  for (const std::string& code : failing) {
    Waiver waiver;
    waiver.code = code;
    waiver.owner = "ann";
    waiver.reason = "known";
    waiver.expires = "2026-11-21";
    request.suite.rules.waivers.push_back(waiver);
  }
  const Report waived = report_of(request);
  EXPECT_EQ(waived.exit_code, kExitOk);
  EXPECT_EQ(waived.findings.size(), plain.findings.size());  // they stay visible
  for (const std::string& code : failing)
    EXPECT_EQ(count(waived, code, Verdict::waived), count(plain, code, Verdict::fail)) << code;

  request.today = "2026-11-22";  // the day after
  const Report expired = report_of(request);
  EXPECT_EQ(expired.exit_code, kExitFindings);
  const auto says_expired = [](const std::string& reason) {
    return reason.find("expired on 2026-11-21") != std::string::npos;
  };
  EXPECT_TRUE(std::any_of(expired.reasons.begin(), expired.reasons.end(), says_expired));
}

TEST(Reasons, NameTheChecksThatWereNotMeasured) {
  Report report;
  RigResult rig;
  rig.rig = "even";
  rig.role = Role::proposed;
  rig.coverage = {{"BB002", 9, 9, 0, 0}, {"BB012", 9, 0, 0, 9}, {"BB030", 9, 5, 4, 0}};
  report.rigs.push_back(rig);
  conclude(report);
  EXPECT_EQ(report.exit_code, kExitNotMeasured);
  ASSERT_EQ(report.reasons.size(), 1u);
  EXPECT_EQ(
      report.reasons.front(),
      "even: not everything that decides was measured: BB030 cross-section collapse (4 of 9)");
}

TEST(Verdicts, OnACharacterThatIsUncertainAreNeitherPassNorFail) {
  Report report;
  RigResult rig;
  rig.rig = "even";
  rig.coverage = {{"BB010", 9, 9, 0, 0}};
  Finding kink;
  kink.code = "BB010";
  kink.rig = rig.rig;
  kink.verdict = Verdict::fail;
  for (const char* name : {"sure", "fails", "passes"}) {
    report.characters.emplace_back().name = rig.character = name;
    report.rigs.push_back(rig);
  }
  kink.at = {1, 0, 3};
  kink.character = "fails";
  report.findings = {kink};
  report.characters[1].doubts = {"up is -Z", "its size"};
  report.characters[2].doubts = {"up is +Z"};
  conclude(report);
  EXPECT_EQ(report.rigs[0].verdict, Verdict::pass);
  EXPECT_EQ(report.rigs[1].verdict, Verdict::not_measured);
  EXPECT_EQ(report.rigs[2].verdict, Verdict::not_measured);
  EXPECT_EQ(report.findings.front().verdict, Verdict::stress);  // shown
  EXPECT_EQ(report.verdict, Verdict::not_measured);
  EXPECT_EQ(report.exit_code, kExitNotMeasured);
  ASSERT_EQ(report.reasons.size(), 2u);
  EXPECT_EQ(report.reasons.front(),
            "fails: not judged before backbend inspect --save confirms it: up is -Z; its size");
}

TEST(Reasons, OfRigsThatAReportNamesAlikeAreEachItsOwn) {
  Report report;
  RigResult rig;
  rig.character = "tube";
  rig.rig = "even";
  rig.mapping = "chest";
  rig.coverage = {{"BB010", 9, 9, 0, 0}};
  report.rigs = {rig, rig};
  Finding kink;
  kink.code = "BB010";
  kink.at = {1, 0, 3};
  kink.character = rig.character;
  kink.rig = rig.rig;
  kink.mapping = rig.mapping;
  kink.verdict = Verdict::fail;
  report.findings = {kink};
  conclude(report);
  EXPECT_EQ(report.rigs[0].verdict, Verdict::pass);
  EXPECT_EQ(report.rigs[1].verdict, Verdict::fail);
}

TEST(Findings, OfSweepsWithOneNameAreEachAtTheirOwnPoses) {
  RigRecord rig =
      measure_chain_only(tube(), read_rig("even"), solver::Mapping::chest,
                         {channel_sweep("side", -40, 40, 40), channel_sweep("side", -40, 40, 10)},
                         *find_envelope("human"));
  ASSERT_EQ(rig.sweeps[0].sweep.name, rig.sweeps[1].sweep.name);
  rig.sweeps[1].poses[7].at(MetricId::chain_kink) = {90.0, 3};  // the first has three poses
  const LimitSet limits;
  const std::vector<Finding> found =
      judge_rig(rig, {tube(), limits, *find_envelope("human"), "tube"});
  const auto kink = std::ranges::find(found, "BB010", &Finding::code);
  ASSERT_NE(kink, found.end());
  EXPECT_EQ(kink->at, (PoseRef{-1, 1, 7}));
  EXPECT_EQ(sweep_of(rig, *kink), &rig.sweeps[1]);
}

TEST(Limits, OfASuiteMoveTheVerdictAndNeverACanarys) {
  RunRequest request = drifting_run();
  request.suite.sweeps = {channel_sweep("extension", 0, 120, 10)};
  RigPlan canary = read_rig("isner");
  canary.name = "canary";
  canary.role = Role::canary;
  canary.duty = CanaryDuty{"BB001", "extension", "top_vertebra",      solver::Mapping::chest,
                           114.3,   0.3,         {"matrix_blend", {}}};
  request.suite.rigs.push_back(canary);
  for (const char* code : {"BB001", "BB020"})
    request.suite.rules.limits.push_back(
        {code, "", {1000.0, LimitLayer::show, "here", "ann", "everything goes"}});
  const Report report = report_of(request);
  EXPECT_EQ(count(report, "BB020", Verdict::fail), 0u);
  ASSERT_EQ(report.canaries.size(), 1u);
  EXPECT_TRUE(report.canaries[0].ok()) << report.canaries[0].detail;
}

}  // namespace
}  // namespace backbend::validate
