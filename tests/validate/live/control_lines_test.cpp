#include "validate/live/control_lines.h"

#include <gtest/gtest.h>

#include <vector>

namespace backbend::validate {
namespace {

using Kind = solver::Channel::Kind;

const std::vector<ChannelValue> kValues = {{"hero:chest_ctl.rx", Kind::rotation, -90.5},
                                           {"spine.z", Kind::translation, 0.25},
                                           {"spine.bend \"back\"", Kind::scalar, 2.0}};

TEST(ControlLines, SetBonesOfOtherArmaturesMovesAndPropertiesInBlender) {
  const auto lines = control_lines("Blender 3.4.1", kValues);
  ASSERT_EQ(lines.size(), 1u);
  const std::string& line = lines.at("blender");
  for (const char* part :
       {"import bpy, math; ", "c = bpy.data.objects[\"hero\"].pose.bones[\"chest_ctl\"]; ",
        "c.rotation_euler[0] = math.radians(-90.5)",
        "c = bpy.context.object.pose.bones[\"spine\"]; c.location[2] = 0.25",
        "c[\"bend \\\"back\\\"\"] = 2"})
    EXPECT_NE(line.find(part), std::string::npos) << part << "\n" << line;
}

TEST(ControlLines, SetAttributesInMaya) {
  const auto lines = control_lines("Maya 2025", kValues);
  EXPECT_EQ(lines.at("maya"),
            "from maya import cmds; cmds.setAttr(\"hero:chest_ctl.rotateX\", -90.5); "
            "cmds.setAttr(\"spine.translateZ\", 0.25); "
            "cmds.setAttr(\"spine.bend \\\"back\\\"\", 2)");
}

TEST(ControlLines, AreNoneAtRestAndForProgramsWhoseLanguageIsNotKnown) {
  EXPECT_TRUE(control_lines("Blender 3.4.1", std::vector<ChannelValue>{}).empty());
  EXPECT_TRUE(control_lines("example_rig.py", kValues).empty());
}

}  // namespace
}  // namespace backbend::validate
