// Motion comes from files of every program, and a sidecar counts for it as for the character.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "tests/temporary_folder.h"
#include "tests/validate/import_fixture.h"
#include "validate/clips/clip_run.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;

class ClipFiles : public ::testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }

  static Report judged(const fs::path& clip, const fs::path& character = {},
                       const std::vector<std::string>& spine = {"j0", "j1", "j2", "j3"}) {
    ClipRequest request;
    request.character = character;
    request.clip = clip;
    request.hints.spine = spine;
    Progress quiet(Progress::Style::none);
    return run_clip(request, quiet);
  }

  const TemporaryFolder folder_;
};

/// Every metric of `of` is in `in`, too, and says the same of every frame.
void expect_same_figures(const Report& in, const Report& of) {
  ASSERT_EQ(in.rigs.at(0).sweeps.size(), 1u);
  ASSERT_EQ(of.rigs.at(0).sweeps.size(), 1u);
  const SweepSeries &all = in.rigs[0].sweeps[0], &few = of.rigs[0].sweeps[0];
  ASSERT_EQ(all.control_deg.size(), few.control_deg.size());
  EXPECT_FALSE(few.metric.empty());
  for (const auto& [name, values] : few.metric) {
    SCOPED_TRACE(name);
    ASSERT_TRUE(all.metric.contains(name));
    for (std::size_t f = 0; f < values.size(); ++f) {
      // Keys are stored as floats of other units; degrees and percents of up to 100.
      const double value = all.metric.at(name)[f];
      if (std::isfinite(values[f])) {
        EXPECT_NEAR(value, values[f], 1e-3) << "frame " << f;
      } else {
        EXPECT_FALSE(std::isfinite(value)) << "frame " << f;
      }
    }
  }
}

// One second from 0 to 90 degrees, thirty times a second as a player shows it.
constexpr std::size_t kFrames = 31;

TEST_F(ClipFiles, OneMotionHasTheSameFiguresFromFbxColladaAndBvh) {
  const Report fbx = judged(write("t.fbx", tower_fbx()));
  const Report dae = judged(write("t.dae", tower_dae()));
  const Report bvh = judged(write("t.bvh", tower_bvh()));
  EXPECT_EQ(fbx.rigs.at(0).sweeps.at(0).control_deg.size(), kFrames);
  EXPECT_EQ(fbx.rigs.at(0).sweeps.at(0).sweep, "bend");
  expect_same_figures(fbx, dae);
  expect_same_figures(fbx, bvh);
  // Where there is a body, it is measured, too.
  EXPECT_TRUE(fbx.rigs[0].sweeps[0].metric.contains("slice_area"));
  EXPECT_FALSE(bvh.rigs[0].sweeps[0].metric.contains("slice_area"));
  EXPECT_NE(bvh.title.find("chain only"), std::string::npos) << bvh.title;
}

TEST_F(ClipFiles, ASkeletonsMotionIsJudgedOnTheBodyBesideIt) {
  // The skeleton counts in fifths of a metre: only its turns can be meant.
  const Report own = judged(write("t.fbx", tower_fbx()));
  const Report lent = judged(write("walk.bvh", tower_bvh()), write("hero.dae", tower_dae()));
  expect_same_figures(own, lent);
  expect_same_figures(lent, own);
  EXPECT_EQ(lent.characters.at(0).file, "hero.dae");
}

constexpr const char* kSidecar =
    "schema = \"backbend.sidecar/1\"\n[skeleton]\nspine = [\"0\", \"1\", \"2\", \"3\"]\n"
    "namespaces = [\"hero:\"]\n[space]\nmetres_per_unit = 0.01\n";

TEST_F(ClipFiles, ASidecarCountsForTheMotionOutOfTheCharactersOwnFile) {
  const Report bare = judged(write("t.fbx", tower_fbx()));
  const fs::path hero = write("hero.fbx", tower_fbx({.name = "hero:"}));
  const Report free = judged(hero, {}, {"hero:0", "hero:1", "hero:2", "hero:3"});
  write("hero.backbend.toml", kSidecar);
  const Report confirmed = judged(hero, {}, {});
  EXPECT_EQ(confirmed.characters.at(0).spine, (std::vector<std::string>{"0", "1", "2", "3"}));
  EXPECT_NEAR(confirmed.characters[0].spine_length, 0.01 * free.characters.at(0).spine_length,
              1e-9);
  expect_same_figures(bare, free);
  expect_same_figures(confirmed, free);  // angles and shares know no unit
  EXPECT_NE(confirmed.characters[0].hash, free.characters[0].hash);
}

TEST_F(ClipFiles, ASidecarCountsForMotionFromAnotherFile) {
  const Report own = judged(write("t.dae", tower_dae()));
  const fs::path hero = write("hero.dae", tower_dae({.name = "hero:"}));
  const fs::path walk = write("walk.dae", tower_dae({.name = "hero:"}) + "<!-- another -->\n");
  write("hero.backbend.toml", kSidecar);
  const Report lent = judged(walk, hero, {});
  expect_same_figures(own, lent);
  // It stands as the character does: followed as it is, not by its turns alone.
  for (const std::string& note : lent.characters.at(0).notes)
    EXPECT_EQ(note.find("otherwise"), std::string::npos) << note;
}

TEST_F(ClipFiles, ASidecarCountsForASkeletonWithoutABody) {
  const fs::path walk = write("walk.bvh", tower_bvh());
  const auto spine = [&] { return judged(walk, {}, {}).characters.at(0).spine; };
  EXPECT_EQ(spine().front(), "j0");  // found: one chain without a fork
  write("walk.backbend.toml",
        "schema = \"backbend.sidecar/1\"\n[skeleton]\nspine = [\"j1\", \"j2\", \"j3\"]\n");
  EXPECT_EQ(spine(), (std::vector<std::string>{"j1", "j2", "j3"}));
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST_F(ClipFiles, AFrameIsMeasuredAgainstRestWhateverPoseTheClipBeginsIn) {
  const fs::path hero = write("hero.dae", tower_dae());
  const std::string whole = tower_bvh();
  const std::string bent =
      replaced(replaced(whole, "Frames: 3", "Frames: 2"), "0 0 0 0 0 0 0 0 0 0 0 0 0 0 0\n", "");
  const Report from_rest = judged(write("whole.bvh", whole), hero);
  const Report from_bent = judged(write("bent.bvh", bent), hero);
  const SweepSeries &all = from_rest.rigs.at(0).sweeps.at(0),
                    &half = from_bent.rigs.at(0).sweeps[0];
  EXPECT_LT(half.control_deg.size(), all.control_deg.size());
  for (const auto& [name, values] : all.metric) {
    ASSERT_TRUE(half.metric.contains(name)) << name;
    // The same pose, sampled between keys that floats hold.
    if (std::isfinite(values.back())) {
      EXPECT_NEAR(half.metric.at(name).back(), values.back(), 1e-4) << name;
    }
  }
}

TEST_F(ClipFiles, WhatIsNoClipIsRefusedInOneLine) {
  std::string still = tower_fbx();
  still.erase(still.find(" AnimationStack: 500"),
              still.find(" AnimationLayer: 501") - still.find(" AnimationStack: 500"));
  for (const fs::path& file :
       {write("empty.bvh", ""), write("words.fbx", "no FBX\n"), write("still.fbx", still),
        write("cut.bvh", tower_bvh().substr(0, 300)), folder_ / "absent.bvh"}) {
    try {
      judged(file);
      ADD_FAILURE() << file << " was read";
    } catch (const skin::CharacterError& error) {
      const std::string told = error.what();
      EXPECT_EQ(told.rfind(file.string() + ": ", 0), 0u) << told;
      EXPECT_EQ(told.find('\n'), std::string::npos) << told;
    }
  }
}

}  // namespace
}  // namespace backbend::validate
