// The body channels that not every system has: a tipped hip and a stretch.
#include "tests/solver/rig_fixture.h"

namespace backbend::solver {
namespace {

using namespace rigs;

/// Systems with a hip and a chest of their own, each also in its other form.
std::vector<std::unique_ptr<SpineSystem>> hip_and_chest_systems() {
  std::vector<std::unique_ptr<SpineSystem>> out;
  for (const auto& [name, options] :
       std::vector<std::pair<std::string, Options>>{{"isner", {}},
                                                    {"isner", {{"length", "stretchy"}}},
                                                    {"spline_ik", {}},
                                                    {"stretchy", {}},
                                                    {"matrix_blend", {}},
                                                    {"matrix_blend", {{"style", "mgear"}}}})
    out.push_back(build(name, options));
  return out;
}

TEST(BodyPose, ATippedHipLeansForwardUnderAChestThatStays) {
  const double a = radians(25);
  for (const auto& system : hip_and_chest_systems())
    for (const Mapping mapping : {Mapping::chest, Mapping::spread}) {
      const SpinePose pose = system->solve(system->controls_for({.hip = a}, mapping));
      // The pelvis's way up, +Y at rest, tips toward +Z, which is forward.
      expect_near(pose.hip.turn * dvec3(0, 1, 0), {0, std::cos(a), std::sin(a)}, 1e-12);
      // Rigify's swings about the pivot in the middle of the spine.
      const bool swings = system->options().contains("pivot_pos");
      EXPECT_EQ(glm::length(pose.hip.posed_origin) > 0.1, swings);
      if (!swings) expect_near(pose.hip.posed_origin, {0, 0, 0}, 1e-12);
      expect_near(pose.chest.posed_origin, {0, 6, 0}, 1e-12);
      EXPECT_LT(angle_between(pose.chest.turn, kNoTurn), 1e-12) << system->name();
      // Between hips and chest it is the bend of an extension by as much.
      const SpinePose back = system->solve(system->controls_for({.extension = a}, mapping));
      const dquat tipped = glm::conjugate(pose.hip.turn) * pose.chest.turn;
      EXPECT_LT(angle_between(tipped, glm::conjugate(back.hip.turn) * back.chest.turn), 1e-7)
          << system->name();
      EXPECT_TRUE(system->why_without(BodyChannel::hip).empty());
    }
}

TEST(BodyPose, AStretchMovesTheChestAlongTheSpineAndNothingElse) {
  for (const auto& system : hip_and_chest_systems())
    for (const double factor : {0.6, 0.9, 1.0, 1.4}) {
      const SpinePose pose =
          system->solve(system->controls_for({.stretch = factor}, Mapping::chest));
      expect_near(pose.chest.posed_origin, {0, 6.0 * factor, 0}, 1e-9);
      expect_near(pose.hip.posed_origin, {0, 0, 0}, 1e-12);
      EXPECT_LT(angle_between(pose.chest.turn, kNoTurn), 1e-12) << system->name();
      EXPECT_TRUE(system->why_without(BodyChannel::stretch).empty());
    }
}

TEST(BodyPose, AStretchAddsToWhatABendMoves) {
  const BodyPose bent{.extension = 0.7}, both{.extension = 0.7, .stretch = 1.25};
  for (const char* name : {"isner", "spline_ik", "stretchy"}) {
    const auto system = build(name);
    const auto chest = [&](const BodyPose& body) {
      return system->solve(system->controls_for(body, Mapping::spread)).chest.posed_origin;
    };
    expect_near(chest(both) - chest(bent), {0, 1.5, 0}, 1e-9);
  }
}

TEST(BodyPose, EvenStretchesByAsMuchAsItIsAllowedTo) {
  const auto even = build("even", {{"stretchiness", 1.0}});
  const SpinePose pose = even->solve(even->controls_for({.stretch = 1.3}, Mapping::chest));
  expect_near(pose.position.back(), {0, 7.8, 0}, 1e-9);
  EXPECT_TRUE(even->why_without(BodyChannel::stretch).empty());
  EXPECT_FALSE(build("even")->why_without(BodyChannel::stretch).empty());
}

TEST(BodyPose, SystemsWithoutSuchControlsSaySoAndLeaveTheChannelsOut) {
  const BodyPose bent{.extension = 0.4, .side = 0.2, .twist = 0.3};
  BodyPose more = bent;
  more.hip = 0.5;
  more.stretch = 1.2;
  for (const char* name : {"three_bone", "curve", "even", "neck"}) {
    RestChain chain = straight();
    if (name == std::string("neck")) {
      for (int i = 1; i <= 4; ++i) {  // head first, the fixed one last
        glm::dmat4 frame(1.0);
        frame[3] = {-10.0 * (4 - i), 0, 0, 1};
        chain.frame.push_back({"vertebra_" + std::to_string(i), frame});
      }
    }
    const auto system = build(name, {}, chain);
    EXPECT_FALSE(system->why_without(BodyChannel::hip).empty()) << name;
    EXPECT_FALSE(system->why_without(BodyChannel::stretch).empty()) << name;
    for (const Mapping mapping : {Mapping::chest, Mapping::spread})
      EXPECT_EQ(system->controls_for(more, mapping), system->controls_for(bent, mapping)) << name;
  }
}

TEST(BodyPose, AnEmptyOneIsTheRestToTheLastBit) {
  for (const auto& system : hip_and_chest_systems())
    for (const Mapping mapping : {Mapping::chest, Mapping::spread})
      EXPECT_EQ(system->controls_for({}, mapping), rest_controls(*system)) << system->name();
}

}  // namespace
}  // namespace backbend::solver
