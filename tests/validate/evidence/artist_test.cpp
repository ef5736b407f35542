#include "validate/evidence/artist.h"

#include <gtest/gtest.h>

namespace backbend::validate {
namespace {

skin::Sidecar with(std::vector<skin::SidecarControl> controls) {
  skin::Sidecar sidecar;
  sidecar.controls = std::move(controls);
  return sidecar;
}

PoseDegrees pose(double extension, double flexion, double side, double twist) {
  return {extension, flexion, side, twist};
}

TEST(ArtistLines, SetEachChannelOnItsControlWithItsSign) {
  const skin::Sidecar sidecar =
      with({{"extension", "chest_ctl", "X", -1}, {"twist", "chest_ctl", "Y", 1}});
  const auto lines = artist_lines(sidecar, pose(60, 0, 0, 30));
  EXPECT_EQ(lines.at("maya"),
            "from maya import cmds; cmds.setAttr(\"chest_ctl.rotateX\", -60); "
            "cmds.setAttr(\"chest_ctl.rotateY\", 30)");
  const std::string& blender = lines.at("blender");
  EXPECT_NE(blender.find("pose.bones[\"chest_ctl\"]"), std::string::npos);
  EXPECT_NE(blender.find("rotation_euler[0] = math.radians(-60)"), std::string::npos);
  EXPECT_NE(blender.find("rotation_euler[1] = math.radians(30)"), std::string::npos);
}

TEST(ArtistLines, ShareAChannelAmongItsControlsAndAddUpWhatMeetsOnOne) {
  const skin::Sidecar sidecar =
      with({{"extension", "mid", "X", 1}, {"extension", "top", "X", 1}, {"side", "top", "X", 1}});
  EXPECT_EQ(artist_lines(sidecar, pose(80, 0, 5, 0)).at("maya"),
            "from maya import cmds; cmds.setAttr(\"mid.rotateX\", 40); "
            "cmds.setAttr(\"top.rotateX\", 45)");
}

TEST(ArtistLines, TakeFlexionForTheOppositeOfExtension) {
  EXPECT_EQ(artist_lines(with({{"extension", "c", "X", -1}}), pose(0, 30, 0, 0)).at("maya"),
            "from maya import cmds; cmds.setAttr(\"c.rotateX\", 30)");
  EXPECT_EQ(artist_lines(with({{"flexion", "c", "Z", 1}}), pose(30, 0, 0, 0)).at("maya"),
            "from maya import cmds; cmds.setAttr(\"c.rotateZ\", -30)");
}

TEST(ArtistLines, SayNothingRatherThanHalfAPose) {
  const skin::Sidecar sidecar = with({{"extension", "chest_ctl", "X", -1}});
  EXPECT_TRUE(artist_lines(sidecar, pose(60, 0, 0, 30)).empty());
  EXPECT_TRUE(artist_lines(sidecar, pose(0, 0, 0, 0)).empty());
  EXPECT_TRUE(artist_lines({}, pose(60, 0, 0, 0)).empty());
}

TEST(ArtistLines, KeepAHostileNameInsideItsQuotes) {
  const auto lines =
      artist_lines(with({{"extension", "\"); import os; (\"\n\\", "X", 1}}), pose(1, 0, 0, 0));
  EXPECT_EQ(lines.at("maya"),
            "from maya import cmds; cmds.setAttr(\"\\\"); import os; (\\\"\\n\\\\.rotateX\", 1)");
  EXPECT_EQ(artist_script("x = 1", "BB010\nimport os"), "# BB010\\nimport os\nx = 1\n");
}

}  // namespace
}  // namespace backbend::validate
