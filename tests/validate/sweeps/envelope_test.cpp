#include "validate/sweeps/envelope.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "validate/sweeps/suite.h"

namespace backbend::validate {
namespace {

TEST(Envelope, HoldsItsBorderAndNothingBeyond) {
  const Envelope human = *find_envelope("human");
  EXPECT_TRUE(human.contains(parse_pose("extension=60")));
  EXPECT_FALSE(human.contains(parse_pose("extension=60.1")));
  EXPECT_TRUE(human.contains(parse_pose("side=-45")));
  EXPECT_FALSE(human.contains(parse_pose("extension=10,twist=61")));
  EXPECT_FALSE(human.contains(parse_pose("hip=1")));
  EXPECT_FALSE(human.contains(parse_pose("stretch=-1")));
}

TEST(Envelope, OfAComparisonIsTheWholeSweep) {
  EXPECT_TRUE(find_envelope("sweep")->contains(parse_pose("extension=180,twist=720")));
  EXPECT_FALSE(find_envelope("horse").has_value());
}

TEST(Envelope, EveryKindOfBodyHasOneByItsNameAndADrivenNeckItsOwn) {
  for (const auto kind : {skin::BodyKind::human, skin::BodyKind::animal, skin::BodyKind::long_neck,
                          skin::BodyKind::snake}) {
    EXPECT_EQ(envelope_for(kind, false).name, skin::name_of(kind));
    EXPECT_EQ(envelope_for(kind, true).name, "neck");
  }
}

/// The extreme values that a sweep's own poses reach in a channel.
std::pair<double, double> reach(const std::vector<Sweep>& sweeps, std::string_view channel) {
  double least = 0.0, most = 0.0;
  for (const Sweep& sweep : sweeps) {
    if (!moves_alone(sweep, channel)) continue;
    for (std::size_t i = 0; i < sweep.pose_count(); ++i) {
      least = std::min(least, *sweep.pose_at(sweep.control_at(i)).find(channel));
      most = std::max(most, *sweep.pose_at(sweep.control_at(i)).find(channel));
    }
  }
  return {least, most};
}

TEST(StandardSweeps, ReachWhatTheSpecificationAsks) {
  const std::vector<Sweep> sweeps = standard_sweeps(*find_envelope("human"));
  EXPECT_EQ(reach(sweeps, "extension"), std::make_pair(0.0, 120.0));
  EXPECT_EQ(reach(sweeps, "flexion"), std::make_pair(0.0, 90.0));
  EXPECT_EQ(reach(sweeps, "side"), std::make_pair(-45.0, 45.0));
  EXPECT_EQ(reach(sweeps, "twist"), std::make_pair(-90.0, 90.0));
}

TEST(StandardSweeps, EndAtAPoseThatLiesAtTheEndOfEveryEnvelope) {
  for (const std::string& name : envelope_names()) {
    const Envelope envelope = *find_envelope(name);
    const std::vector<Sweep> sweeps = standard_sweeps(envelope);
    for (const std::string_view channel : kBendChannels) {
      const auto [least, most] = reach(sweeps, channel);
      EXPECT_GE(most, envelope.needs(channel) - 1e-9) << name << " " << channel;
      if (channel == "side" || channel == "twist") {
        EXPECT_NEAR(least, -most, 1e-9) << name << " " << channel;
      }
    }
    for (const Sweep& sweep : sweeps) {
      EXPECT_EQ(sweep.pose_at(sweep.to_deg).hip, 0.0) << sweep.name;
      EXPECT_EQ(sweep.pose_at(sweep.to_deg).stretch, 0.0) << sweep.name;
    }
  }
}

TEST(CornerSweeps, GoFromRestToEachCornerOfTheEnvelopeAndOfItsFaces) {
  const Envelope human = *find_envelope("human");
  const std::vector<Sweep> sweeps = corner_sweeps(human);
  std::set<std::string> ends;
  for (const Sweep& sweep : sweeps) {
    EXPECT_TRUE(sweep.corner);
    EXPECT_EQ(sweep.pose_at(0).text(), "rest") << sweep.name;
    EXPECT_EQ(sweep.pose_count(), 11u) << sweep.name;
    const PoseDegrees end = sweep.pose_at(sweep.control_at(sweep.pose_count() - 1));
    EXPECT_TRUE(human.contains(end)) << sweep.name;
    ends.insert(end.text());
  }
  // 2 bends x 2 sides x 2 twists, and two channels at a time: 4 + 4 + 4.
  EXPECT_EQ(sweeps.size(), 20u);
  EXPECT_EQ(ends.size(), 20u);
  EXPECT_TRUE(ends.contains("extension 60, side -45, twist 60"));
  EXPECT_TRUE(ends.contains("flexion 90, side 45, twist -60"));
  EXPECT_TRUE(ends.contains("side -45, twist -60"));
}

TEST(CornerSweeps, LeaveOutWhatTheEnvelopeDoesNotAskFor) {
  EXPECT_EQ(corner_sweeps({"back", 60, 0, 45, 0, false, ""}).size(), 2u);
  EXPECT_TRUE(corner_sweeps({"back", 60, 0, 0, 0, false, ""}).empty());
  EXPECT_TRUE(corner_sweeps(*find_envelope("sweep")).empty());
}

TEST(CornerSweeps, OfAComparisonGoAsFarAsItsSweeps) {
  Suite suite;
  suite.sweeps = {channel_sweep("extension", 0, 180, 2), channel_sweep("side", -60, 60, 4)};
  suite.corners = true;
  const std::vector<Sweep> sweeps = sweeps_for(suite, *find_envelope("sweep"));
  ASSERT_EQ(sweeps.size(), 4u);
  EXPECT_EQ(sweeps.back().pose_at(sweeps.back().to_deg).text(), "extension 180, side -60");
  suite.corners = false;
  EXPECT_EQ(sweeps_for(suite, *find_envelope("sweep")).size(), 2u);
}

}  // namespace
}  // namespace backbend::validate
