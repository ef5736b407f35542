#include "validate/measure/compound_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/quaternion.hpp>

#include "tests/validate/spoiled_rig.h"
#include "validate/measure/measure.h"

namespace backbend::validate {
namespace {

const solver::RestChain kChain{
    {{0, 0, 0}, {0, 1, 0}, {0, 2, 0}, {0, 3, 0}, {0, 4, 0}, {0, 5, 0}, {0, 6, 0}}, {1, 0, 0}};

/// A cell of pose space wider than the lattice's, whose middle lies on none of its lines.
constexpr double kHalfWidth_deg = 9.0;

/// `even`, but for a joint that turns by 90 degrees around one pose.
Spoiled flips_only_at(const PoseDegrees& place) {
  auto even = solver::build_system({"even", {}}, kChain);
  const std::vector<double> centre = controls_at(*even, place, solver::Mapping::chest);
  return {std::move(even), [centre](std::span<const double> control, solver::SpinePose& pose) {
            double farthest = 0.0;
            for (std::size_t i = 0; i < centre.size(); ++i)
              farthest = std::max(farthest, std::abs(control[i] - centre[i]));
            if (farthest > glm::radians(kHalfWidth_deg)) return;
            pose.turn[3] =
                pose.turn[3] * glm::angleAxis(glm::radians(90.0), glm::dvec3(0.0, 1.0, 0.0));
          }};
}

Envelope standard_box() {
  const Envelope human = *find_envelope("human");
  return search_box(human, standard_sweeps(human));
}

TEST(CompoundSearch, LooksAsFarAsSweepsAndEnvelopeGo) {
  const Envelope box = standard_box();
  EXPECT_EQ(box.extension, 120.0);
  EXPECT_EQ(box.flexion, 90.0);
  EXPECT_EQ(box.side, 45.0);
  EXPECT_EQ(box.twist, 90.0);
  EXPECT_EQ(search_box(*find_envelope("cartoon"), standard_sweeps(*find_envelope("human"))).side,
            75.0);
}

TEST(CompoundSearch, FindsAJumpThatOnlyACompoundPoseShows) {
  const PoseDegrees place = parse_pose("extension=80,side=20,twist=50");
  const Spoiled rig = flips_only_at(place);
  const FoundJumps found = search_compound(rig, solver::Mapping::chest, standard_box());
  EXPECT_EQ(found.summary.paths, 90);  // 7 sides x 13 twists without the single channels' own
  EXPECT_EQ(found.summary.poses, 90 * 43);
  EXPECT_GE(found.summary.with_jumps, 1);
  EXPECT_EQ(found.summary.unsure, 0);
  ASSERT_FALSE(found.around.empty());
  // The sweep that is measured in its place passes a pose that flips.
  const Sweep& around = found.around.front();
  EXPECT_TRUE(around.corner);
  bool passes = false;
  for (std::size_t i = 0; i < around.pose_count(); ++i) {
    const PoseDegrees pose = around.pose_at(around.control_at(i));
    passes = passes || (std::abs(pose.extension - 80) < kHalfWidth_deg &&
                        std::abs(pose.side - 20) < kHalfWidth_deg &&
                        std::abs(pose.twist - 50) < kHalfWidth_deg);
  }
  EXPECT_TRUE(passes) << around.name;
}

TEST(CompoundSearch, IsSilentOnTheSameRigWithoutTheFault) {
  const auto even = solver::build_system({"even", {}}, kChain);
  const FoundJumps found = search_compound(*even, solver::Mapping::chest, standard_box());
  EXPECT_EQ(found.summary.with_jumps, 0);
  EXPECT_EQ(found.summary.unsure, 0);
  EXPECT_TRUE(found.around.empty());
}

TEST(CompoundSearch, FindsWhereFractionsOfTheShortestTurnGoTheOtherWayRound) {
  // matrix_blend: continuous on every single channel below half a turn, not in compound ones.
  const auto blend = solver::build_system({"matrix_blend", {}}, kChain);
  const Envelope box{"", 180, 0, 60, 180, true, ""};
  const FoundJumps found = search_compound(*blend, solver::Mapping::chest, box);
  EXPECT_GT(found.summary.with_jumps, 0);
  EXPECT_LE(found.around.size(), 2u);
}

TEST(CompoundSearch, OfASingleChannelHasNothingToSearch) {
  const auto even = solver::build_system({"even", {}}, kChain);
  const Envelope box{"", 120, 0, 0, 0, true, ""};
  EXPECT_EQ(search_compound(*even, solver::Mapping::chest, box).summary.paths, 0);
}

}  // namespace
}  // namespace backbend::validate
