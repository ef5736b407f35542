#include "validate/files/ledger.h"

#include <gtest/gtest.h>

#include <bit>
#include <limits>
#include <memory>

#include "tests/temporary_folder.h"
#include "validate/files/folder_trace.h"
#include "validate/files/output_folder.h"
#include "validate/measure/records.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;
using Mode = Ledger::Mode;

class LedgerTest : public testing::Test {
 protected:
  Ledger ledger(const std::string& folder, Mode mode = Mode::alone,
                const std::string& stamp = "s") {
    return Ledger(root_ / folder, stamp, mode, Shard{}, true);
  }
  fs::path only_part(const std::string& folder) {
    fs::path found;
    for (const auto& entry : fs::directory_iterator(root_ / folder / kPartsFolder)) found = entry;
    return found;
  }
  const TemporaryFolder temporary_;
  const fs::path root_ = temporary_.path();
};

const Ledger::Bytes kResult = {1, 2, 0, 255, '\n', 3};

TEST_F(LedgerTest, FindsWhatItKeptAndNothingElse) {
  const Ledger run = ledger("run");
  run.keep("unit one", kResult);
  EXPECT_EQ(run.find("unit one"), kResult);
  EXPECT_EQ(run.find("unit two"), std::nullopt);
  EXPECT_EQ(ledger("run", Mode::alone, "other inputs").find("unit one"), std::nullopt);
}

TEST_F(LedgerTest, AFileThatIsGoneBeforeItIsKeptIsAFaultOfTheDiskNotOfTheInput) {
  EXPECT_THROW(ledger("run").keep("unit", {}, {"frames/a.png"}), WriteError);
  EXPECT_FALSE(fs::exists(root_ / "run" / kPartsFolder));
}

TEST_F(LedgerTest, TakesNoDamagedPart) {
  const Ledger run = ledger("run");
  run.keep("unit", kResult);
  const std::vector<std::uint8_t> whole = read_bytes(only_part("run"));
  const OutputFolder folder(root_ / "run" / kPartsFolder);
  const std::string name = only_part("run").filename().string();
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::vector<std::uint8_t> damaged = whole;
    damaged[at] ^= 0x20;
    folder.write(name, damaged);
    EXPECT_EQ(run.find("unit"), std::nullopt) << "byte " << at;
    folder.write(name, std::span(whole).first(at));
    EXPECT_EQ(run.find("unit"), std::nullopt) << "cut at " << at;
  }
  folder.write(name, whole);
  EXPECT_EQ(run.find("unit"), kResult);
}

TEST_F(LedgerTest, TakesAPartOnlyWithItsFilesAsTheyWere) {
  const OutputFolder folder(root_ / "run");
  folder.write("frames/a.png", "picture");
  const Ledger run = ledger("run");
  run.keep("unit", {}, {"frames/a.png"});
  EXPECT_TRUE(run.find("unit"));
  folder.write("frames/a.png", "pictura");
  EXPECT_FALSE(run.find("unit"));
  fs::remove(root_ / "run/frames/a.png");
  EXPECT_FALSE(run.find("unit"));
}

TEST_F(LedgerTest, GathersPartsWithTheirFilesAndRefusesThoseOfAnotherJob) {
  OutputFolder(root_ / "a").write("frames/a.png", "picture");
  ledger("a").keep("unit a", kResult, {"frames/a.png"});
  ledger("b").keep("unit b", {});
  EXPECT_EQ(gather_parts(root_ / "a", root_ / "all", "s"), 1u);
  EXPECT_EQ(gather_parts(root_ / "b", root_ / "all", "s"), 1u);
  EXPECT_EQ(gather_parts(root_ / "b", root_ / "all", "s"), 1u);  // again is once
  EXPECT_EQ(read_text(root_ / "all/frames/a.png"), "picture");
  EXPECT_EQ(ledger("all", Mode::merge).find("unit a"), kResult);
  EXPECT_TRUE(ledger("all", Mode::merge).find("unit b"));
  ledger("c", Mode::alone, "t").keep("unit c", {});
  EXPECT_THROW(gather_parts(root_ / "c", root_ / "all", "s"), MixedPartsError);
}

TEST_F(LedgerTest, NeverReachesOutOfTheRunFolder) {
  OutputFolder(root_).write("secret", "x");
  OutputFolder(root_ / "run").write("in", "x");
  ledger("run").keep("unit", {}, {"../secret"});
  EXPECT_FALSE(ledger("run").find("unit"));
  EXPECT_EQ(gather_parts(root_ / "run", root_ / "deeper/out", "s"), 0u);
  EXPECT_FALSE(fs::exists(root_ / "deeper/secret"));
}

TEST_F(LedgerTest, RemovesItsPartsAndNothingElse) {
  const OutputFolder run(root_ / "run");
  run.write("parts/media/0.png", "a frame that only a video needs");
  run.write("parts/torso.obj", "the user's own");
  run.write("frames/a.png", "picture");
  ledger("run").keep("unit one", {}, {"parts/media/0.png"});
  ledger("run").keep("unit two", kResult, {"frames/a.png"});
  remove_parts(root_ / "run");
  EXPECT_FALSE(fs::exists(root_ / "run/parts/media"));
  EXPECT_EQ(only_part("run").filename(), "torso.obj");
  EXPECT_EQ(read_text(root_ / "run/frames/a.png"), "picture");
  fs::remove(root_ / "run/parts/torso.obj");
  remove_parts(root_ / "run");
  EXPECT_FALSE(fs::exists(root_ / "run/parts"));
}

TEST_F(LedgerTest, LeftoversOfKilledWritersGoAndNamedFilesStay) {
  const OutputFolder run(root_ / "run");
  run.write("frames/a.png", "picture");
  const auto left_by_a_killed_writer = [&](const fs::path& file, const std::string& half) {
    const fs::path temporary =
        file.parent_path() / run.temporary_for(file).path().filename();  // gone, like its writer
    run.write(temporary, half);
    return root_ / "run" / temporary;
  };
  const fs::path left = left_by_a_killed_writer("frames/b.png", "half a pict");
  const fs::path beside = left_by_a_killed_writer("report.md", "half a rep");
  ASSERT_TRUE(fs::exists(left) && fs::exists(beside));
  remove_leftovers(root_ / "run", false);
  EXPECT_FALSE(fs::exists(beside));
  EXPECT_TRUE(fs::exists(left));
  remove_leftovers(root_ / "run");
  EXPECT_FALSE(fs::exists(left));
  EXPECT_EQ(read_text(root_ / "run/frames/a.png"), "picture");
}

TEST(Shards, OwnEveryItemExactlyOnce) {
  for (const int count : {1, 2, 3, 7}) {
    for (std::size_t item = 0; item < 50; ++item) {
      int owners = 0;
      for (int index = 1; index <= count; ++index) owners += Shard{index, count}.owns(item);
      EXPECT_EQ(owners, 1);
    }
  }
}

TEST_F(LedgerTest, LetsShardsShareAFolderAndNobodyElse) {
  {
    const FolderLock one(root_, FolderLock::Kind::shared), two(root_, FolderLock::Kind::shared);
    EXPECT_THROW(FolderLock(root_, FolderLock::Kind::exclusive), BusyError);
  }
  const FolderLock alone(root_, FolderLock::Kind::exclusive);
  EXPECT_THROW(FolderLock(root_, FolderLock::Kind::shared), BusyError);
}

TEST_F(LedgerTest, TakesAwayAnEmptyFolderThatItMadeButNotTheOneThatAnotherRunHolds) {
  const fs::path run = root_ / "runs/tonight";
  {
    const FolderTrace refused(run);
    fs::create_directories(run);
  }
  EXPECT_FALSE(fs::exists(root_ / "runs"));
  auto sent_away = std::make_unique<FolderTrace>(run);
  fs::create_directories(run);  // by the other, which began at the same time
  const FolderLock other(run, FolderLock::Kind::exclusive);
  sent_away.reset();
  EXPECT_TRUE(fs::exists(run));
}

TEST(Records, ComeBackBitForBitNotANumberToo) {
  std::vector<PoseRecord> poses(2);
  poses[0].at(MetricId::strain) = {1.0 / 3.0, 4711};
  poses[0].at(MetricId::volume) = {-0.0, -1};
  poses[0].at(MetricId::gain) = {std::numeric_limits<double>::denorm_min(), 0};
  poses[0].arms = {1e-300, -2.5, 1e300, 0.1};
  poses[0].bounds.add({0.1, -0.2, 1e17});
  std::vector<PoseRecord> back(2);
  unpack_poses(pack_poses(poses), back);
  for (std::size_t p = 0; p < 2; ++p) {
    for (std::size_t m = 0; m < kMetricCount; ++m) {
      const double was = poses[p].metric[m].value, is = back[p].metric[m].value;
      EXPECT_TRUE(std::isnan(was)
                      ? std::isnan(is)
                      : std::bit_cast<std::uint64_t>(was) == std::bit_cast<std::uint64_t>(is));
      EXPECT_EQ(poses[p].metric[m].place, back[p].metric[m].place);
    }
    EXPECT_EQ(poses[p].bounds.low, back[p].bounds.low);
    EXPECT_EQ(poses[p].bounds.high, back[p].bounds.high);
    EXPECT_EQ(poses[p].arms.aim_deg, back[p].arms.aim_deg);
    EXPECT_EQ(poses[p].arms.shift, back[p].arms.shift);
  }
  std::vector<PoseRecord> other(3);
  EXPECT_THROW(unpack_poses(pack_poses(poses), other), std::runtime_error);
}

TEST(Records, KeepEveryFactOfASearchForJumps) {
  FlipReport flips;
  flips.jumps.push_back({.t = 0.25,
                         .before = 0.2,
                         .after = 0.3,
                         .kind = FlipClass::pop,
                         .joints = {{3, 180.0, 0.5, {0, 1, 0}, std::nan("")}}});
  flips.steep.push_back({2, 0.5, 9.5});
  flips.gain = {1.0, std::nan("")};
  flips.interval_gain = {0.1, 0.2};
  flips.least_margin_deg = {5.0};
  flips.least_margin_t = {0.7};
  flips.smallest_deg = 1.0;
  flips.smallest_gap = 1e-6;
  flips.samples = 123456789;
  flips.finite = false;
  flips.not_finite_t = 0.9;
  flips.certified = false;
  const FlipReport back = unpack_flips(pack_flips(flips));
  ASSERT_EQ(back.jumps.size(), 1u);
  EXPECT_EQ(back.jumps[0].kind, FlipClass::pop);
  EXPECT_EQ(back.jumps[0].after, 0.3);
  ASSERT_EQ(back.jumps[0].joints.size(), 1u);
  EXPECT_EQ(back.jumps[0].joints[0].axis, glm::dvec3(0, 1, 0));
  EXPECT_TRUE(std::isnan(back.jumps[0].joints[0].axis_to_bone_deg));
  EXPECT_EQ(back.steep[0].gain, 9.5);
  EXPECT_TRUE(std::isnan(back.gain[1]));
  EXPECT_EQ(back.interval_gain, flips.interval_gain);
  EXPECT_EQ(back.least_margin_deg, flips.least_margin_deg);
  EXPECT_EQ(back.least_margin_t, flips.least_margin_t);
  EXPECT_EQ(back.samples, flips.samples);
  EXPECT_EQ(back.smallest_gap, flips.smallest_gap);
  EXPECT_EQ(back.not_finite_t, flips.not_finite_t);
  EXPECT_FALSE(back.finite);
  EXPECT_FALSE(back.certified);
}

}  // namespace
}  // namespace backbend::validate
