#include "validate/model/search_text.h"

#include <gtest/gtest.h>

namespace backbend::validate {
namespace {

PoseHunt hunt() {
  PoseHunt out;
  out.evaluations = 177;
  out.box = "side -45..45";
  out.worst = {{"BB030", "ratio", "side 45", 0.9, 0.75, false, -1}};
  return out;
}

TEST(HuntSummary, OfNoFindSaysHowManyPosesWereSearchedAndNoMore) {
  EXPECT_EQ(hunt_summary(hunt()), "searched 177 poses of side -45..45");
  EXPECT_EQ(hunt_summary({}), "");
}

TEST(HuntSummary, NamesEachFindAndWhatTheSweepsShowAsBad) {
  PoseHunt some = hunt();
  some.worst.push_back({"BB011", "deg", "side 40", 31.5, 25, true, 3});
  some.worst.push_back({"BB036", "deg", "side 45", 16, 15, true, -1});
  EXPECT_EQ(hunt_summary(some),
            "searched 177 poses of side -45..45: BB011 mesh kink 31.5 deg (limit 25) at side 40; "
            "over the limit as in the sweeps, which judge it: BB036");
}

TEST(HuntSummary, SaysWhyNothingWasSearched) {
  PoseHunt none;
  none.notes = {"rig 'mine' remembers earlier poses"};
  EXPECT_EQ(hunt_summary(none), "not searched: rig 'mine' remembers earlier poses");
}

TEST(VolumeSummary, KeepsCertifiedAndSearchedApart) {
  CleanVolume volume{"side -45..45", true, 0.99996, 1.0, 0.0, 8.0, "", 59, 58, 0.92228};
  // Rounded down: 99.996 % is not all of it.
  EXPECT_EQ(certified_summary(volume),
            "certified 99.99 % (no joint jumps or turns more than 8 times as fast as a channel; no "
            "jump in 100 %)");
  EXPECT_EQ(sampled_summary(volume),
            "58 of 59 random poses clean (95 % sure: at least 92.22 % of the volume)");
  EXPECT_EQ(volume_summary(volume),
            certified_summary(volume) + "; searched: " + sampled_summary(volume));
  EXPECT_EQ(volume_summary({}), "");
}

}  // namespace
}  // namespace backbend::validate
