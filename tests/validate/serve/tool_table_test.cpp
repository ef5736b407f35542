#include "validate/serve/tool_table.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <optional>

#include "tests/temporary_folder.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Words = std::vector<std::string>;

/// A folder with a character, a file outside, and a link to that.
class ToolWords : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder_ / "root");
    std::ofstream(folder_ / "outside.glb") << "x";
    std::ofstream(folder_ / "root/hero.glb") << "x";
    fs::create_symlink(folder_ / "outside.glb", folder_ / "root/link.glb");
    files_.emplace(std::vector{folder_ / "root"});
  }

  Words words(std::string_view tool, const json& arguments, bool may_write = false) const {
    return words_of(*find_tool(tool), arguments, *files_, may_write);
  }

  const TemporaryFolder folder_;
  std::optional<FileAccess> files_;
};

TEST_F(ToolWords, AreACommandLineInWhichNoValueIsAnOptionAndNothingIsWritten) {
  EXPECT_EQ(words("check", {{"character", "hero.glb"}, {"rig", "curve"}}),
            (Words{"check", "--json", "--rig", "curve", "-o", "-", "--", "hero.glb"}));
  EXPECT_EQ(words("repair", {{"character", "hero.glb"}}),
            (Words{"repair", "--json", "--dry-run", "--", "hero.glb"}));
  EXPECT_EQ(words("picture", {{"character", "hero.glb"}, {"width", 320}, {"samples", 4}}),
            (Words{"render", "-o", "-", "--spp", "4", "--res", "320x360", "--", "hero.glb"}));
  EXPECT_EQ(words("compare", {{"a", "curve:bones=12"}, {"b", "isner"}}),
            (Words{"compare", "--json", "-o", "-", "--", "curve:bones=12", "isner"}));
}

TEST_F(ToolWords, NameAnOutputOnlyWhereWritingIsAllowedAndNothingIsThere) {
  const json arguments = {{"character", "hero.glb"}, {"output", "new.glb"}};
  EXPECT_THROW(words("repair", arguments), ArgumentError);
  EXPECT_EQ(words("repair", arguments, true),
            (Words{"repair", "--json", "-o", "new.glb", "--", "hero.glb"}));
  for (const char* there : {"hero.glb", "link.glb", "../new.glb"})
    EXPECT_THROW(words("repair", {{"character", "hero.glb"}, {"output", there}}, true), AccessError)
        << there;
}

TEST_F(ToolWords, NameNoFileOutsideTheFolders) {
  for (const std::string& name :
       {std::string("../outside.glb"), (folder_ / "outside.glb").string(), std::string("link.glb"),
        std::string("a/../../outside.glb"), std::string("/dev/null")}) {
    EXPECT_THROW(words("inspect", {{"character", name}}), AccessError) << name;
    EXPECT_THROW(words("compare", {{"a", name}, {"b", "even"}}), AccessError) << name;
  }
  EXPECT_THROW(words("check", {{"character", "hero.glb"}, {"rig", "../rig.toml"}}), AccessError);
  EXPECT_THROW(words("inspect", {{"character", std::string("hero.glb\0", 9)}}), ArgumentError);
  EXPECT_THROW(words("inspect", {{"character", "--help"}}), ArgumentError);
}

TEST_F(ToolWords, StartNoProgram) {
  std::ofstream(folder_ / "root/live.toml")
      << "[rig]\nsystem = \"external\"\nprogram = \"command\"\ncommand = \"true\"\n";
  for (const char* rig : {"command:true", "blender:hero.blend", "live.toml"}) {
    EXPECT_THROW(words("check", {{"character", "hero.glb"}, {"rig", rig}}), ArgumentError) << rig;
    EXPECT_THROW(words("compare", {{"a", rig}, {"b", "even"}}), ArgumentError) << rig;
  }
}

TEST_F(ToolWords, OfWrongArgumentsSayWhichAndWhatWasExpected) {
  const auto told = [this](const json& arguments) {
    try {
      words("picture", arguments);
    } catch (const ArgumentError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(told(json::object()), "'character': is missing");
  EXPECT_EQ(told({{"character", 1}}), "'character': expected a string");
  EXPECT_NE(told({{"charcter", "x"}}).find("did you mean 'character'"), std::string::npos);
  for (const json& width : {json(63), json(1921), json(-1), json(18446744073709551615ull)})
    EXPECT_EQ(told({{"character", "hero.glb"}, {"width", width}}), "'width': expected 64 to 1920");
  EXPECT_EQ(told({{"character", "hero.glb"}, {"width", 80.5}}), "'width': expected a whole number");
}

TEST(Tools, HaveASchemaWithOutputsOnlyWhereTheServerMayWrite) {
  for (const Tool& tool : all_tools()) {
    const json reading = tool_description(tool, false), writing = tool_description(tool, true);
    EXPECT_FALSE(reading["inputSchema"]["properties"].contains("output")) << tool.name;
    EXPECT_EQ(reading["annotations"]["readOnlyHint"], true) << tool.name;
    EXPECT_EQ(writing["inputSchema"]["properties"].contains("output"),
              writing["annotations"]["readOnlyHint"] == false)
        << tool.name;
    EXPECT_FALSE(reading["inputSchema"]["additionalProperties"].get<bool>());
  }
}

}  // namespace
}  // namespace backbend::validate
