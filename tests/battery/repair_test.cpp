// Weights repaired on the bundled human: faults that are planted must go, and nothing else.
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <fstream>

#include "skin/body/body.h"
#include "tests/battery/repair_case.h"
#include "tests/skin/gltf_fixture.h"
#include "tests/source_folder.h"
#include "tests/temporary_folder.h"
#include "validate/repair/repair_text.h"

namespace backbend::battery {
namespace {

using Index = std::size_t;
using skin::Character;

const Character& human() {
  static const Character body = [] {
    skin::BodyOptions options;
    options.vertices = 3000;
    return welded(skin::make_body(
        skin::read_body_description(source_folder() / "scenes" / "characters" / "human.toml"),
        options));
  }();
  return body;
}

struct Planted {
  const char* kind;
  double size;
  std::uint64_t seed = 1;
};
void PrintTo(const Planted& planted, std::ostream* out) {
  *out << planted.kind << " " << planted.size;
}

class RepairOf : public testing::TestWithParam<Planted> {};

/// Plants a fault in the human, repairs it and expects its findings gone and none added.
RepairScore repaired(const Planted& planted) {
  Character body = human();
  const skin::Anatomy anatomy = skin::find_anatomy(body);
  validate::Draw draw(planted.seed, 1);
  const WeightFault fault = plant(body, anatomy, planted.kind, planted.size, draw);
  EXPECT_FALSE(fault.joints.empty());
  const TemporaryFolder folder;
  RepairScore score = score_repair(human(), body, fault, folder / "case", 40, 7);
  EXPECT_EQ(score.refused, "");
  EXPECT_GT(score.planted, 0u) << "a fault that nobody sees proves nothing";
  EXPECT_EQ(score.left, 0u);
  EXPECT_EQ(score.added, 0u);
  EXPECT_EQ(score.new_at_poses, 0u);
  EXPECT_GT(score.touched, 0u);
  return score;
}

TEST_P(RepairOf, RemovesThePlantedFaultAndAddsNone) {
  const RepairScore score = repaired(GetParam());
  // One vertex in fifty that had no fault, at most.
  EXPECT_LE(50 * score.beyond, score.vertices);
  EXPECT_LE(score.off_after, 0.5 * score.off_before);
}

TEST(ScatteredPoses, LieBetweenTheEndsOfTheEnvelopeAndReachNearThem) {
  const validate::Envelope human_range = *validate::find_envelope("human");
  double extension = 0, flexion = 0, left = 0, right = 0, twist = 0;
  for (const validate::PoseDegrees& pose : validate::scattered_poses(human_range, 200)) {
    EXPECT_EQ(std::min(pose.extension, pose.flexion), 0.0);
    extension = std::max(extension, pose.extension);
    flexion = std::max(flexion, pose.flexion);
    left = std::max(left, pose.side);
    right = std::max(right, -pose.side);
    twist = std::max(twist, std::abs(pose.twist));
  }
  // 200 of them leave no gap of a twentieth at either end of a channel.
  for (const auto& [found, end] : {std::pair(extension, human_range.extension),
                                   {flexion, human_range.flexion},
                                   {left, human_range.side},
                                   {right, human_range.side},
                                   {twist, human_range.twist}}) {
    EXPECT_LE(found, end);
    EXPECT_GT(found, 0.95 * end);
  }
}

INSTANTIATE_TEST_SUITE_P(Faults, RepairOf,
                         testing::Values(Planted{"wrong side", 20}, Planted{"bleed to head", 30},
                                         Planted{"bleed to hand", 30}, Planted{"unweighted", 20},
                                         Planted{"vertebrae swapped", 2},
                                         Planted{"half torso one up", 100},
                                         Planted{"mirrored half", 100}));

TEST(Repair, BlendsAHardBorder) {
  // Nobody can know how wide the blend was: one that passes is enough.
  const RepairScore score = repaired({"rigid ring", 2});
  EXPECT_EQ(score.beyond, 0u);
  EXPECT_LT(score.off_after, score.off_before);
}

TEST(Repair, ClosesASeam) {
  // Both sides of a split vertex move alike again, whichever of them was taken.
  repaired({"seam", 30});
}

TEST(Repair, OfAHealthyBodyChangesNothingAndSaysSo) {
  const TemporaryFolder folder;
  const auto file = folder / "human.glb";
  skin::write_file(file, encoded(human()));
  validate::Progress progress(validate::Progress::Style::none);
  const validate::WeightRepair repair = validate::repair_weights(file, {}, progress);
  EXPECT_TRUE(repair.glb.empty());
  EXPECT_EQ(repair.touched_count, 0u);
  EXPECT_EQ(repair.measurements, 1u);
  EXPECT_NE(validate::repair_text(repair).find("nothing to repair"), std::string::npos);
}

TEST(Repair, WritesTheSameBytesForOneThreadAndMany) {
  Character body = human();
  validate::Draw draw(1, 1);
  plant(body, skin::find_anatomy(body), "bleed to head", 30, draw);
  const TemporaryFolder folder;
  const auto file = folder / "human.glb";
  skin::write_file(file, encoded(body));
  const auto glb_with = [&](std::size_t threads) {
    const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism,
                                            threads);
    validate::Progress progress(validate::Progress::Style::none);
    return validate::repair_weights(file, {}, progress).glb;
  };
  const auto one = glb_with(1);
  EXPECT_FALSE(one.empty());
  EXPECT_EQ(one, glb_with(4));
}

TEST(Repair, KeepsTheNumberOfJointsOfAVertex) {
  Character body = human();
  limit_influences(body, 3);
  validate::Draw draw(1, 1);
  plant(body, skin::find_anatomy(body), "unweighted", 20, draw);
  for (skin::Influences& each : body.influences) each = influences_of(weights_of(each), 3);
  const TemporaryFolder folder;
  const auto file = folder / "human.glb";
  WeightFault fault;
  std::vector<std::uint8_t> bytes = encoded(body);
  skin::write_file(file, bytes);
  validate::Progress progress(validate::Progress::Style::none);
  const validate::WeightRepair repair = validate::repair_weights(file, {}, progress);
  for (const skin::Influences& each : repair.influences) EXPECT_EQ(each.weight[3], 0.0f);
}

}  // namespace
}  // namespace backbend::battery
