#include "validate/files/project.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/temporary_folder.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;

const ProjectKeys kKeys = {{"",
                            {{"rig", ProjectKind::text},
                             {"spp", ProjectKind::number},
                             {"quick", ProjectKind::flag},
                             {"joint-map", ProjectKind::texts},
                             {"history", ProjectKind::text}}},
                           {"check", {{"rig", ProjectKind::text}, {"quick", ProjectKind::flag}}},
                           {"history", {{"nights", ProjectKind::number}}}};

Project parse(const std::string& text) { return parse_project(text, "/show/backbend.toml", kKeys); }

std::string refusal(const std::string& text) {
  try {
    parse(text);
    return "";
  } catch (const ProjectError& error) {
    return error.what();
  }
}

using Words = std::vector<std::string>;

TEST(Project, ValuesAreTheWordsThatACommandLineWouldSayThemWith) {
  const Project project = parse(
      "spp = 64\nquick = false\njoint-map = [\"a=b\", \"c=d\"]\n[check]\nrig = \"isner\"\n"
      "quick = true\n");
  EXPECT_EQ(project.find("render", "spp")->words, Words{"64"});
  EXPECT_EQ(project.find("render", "spp")->line, 1u);
  EXPECT_EQ(project.find("render", "quick")->words, Words{"false"});
  EXPECT_EQ(project.find("check", "joint-map")->words, (Words{"a=b", "c=d"}));
  EXPECT_EQ(project.find("check", "rig")->words, Words{"isner"});
  EXPECT_EQ(project.find("check", "rig")->line, 5u);
  EXPECT_EQ(parse("spp = 0.25").find("check", "spp")->words, Words{"0.25"});
  EXPECT_EQ(parse("joint-map = \"a=b\"").find("check", "joint-map")->words, Words{"a=b"});
}

TEST(Project, ACommandsOwnTableCountsBeforeTheTop) {
  const Project project = parse("quick = false\n[check]\nquick = true\n");
  EXPECT_EQ(project.find("check", "quick")->words, Words{"true"});
  EXPECT_EQ(project.find("render", "quick")->words, Words{"false"});
  EXPECT_EQ(project.find("check", "rig"), nullptr);
}

TEST(Project, ANameMayBeAnOptionsAndACommands) {
  EXPECT_EQ(parse("history = \"h.jsonl\"").find("nightly", "history")->words, Words{"h.jsonl"});
  EXPECT_EQ(parse("[history]\nnights = 30").find("history", "nights")->words, Words{"30"});
}

TEST(Project, EveryRefusalNamesFileLineAndCause) {
  EXPECT_EQ(refusal("spp = 4\n\nrigg = \"even\""),
            "/show/backbend.toml:3: 'rigg': not a project option, did you mean 'rig'?; "
            "backbend config shows all");
  EXPECT_EQ(refusal("[chek]\nrig = \"even\""),
            "/show/backbend.toml:1: [chek]: not a command with project options, did you "
            "mean 'check'?");
  EXPECT_EQ(refusal("[check]\nspp = 4"),
            "/show/backbend.toml:2: 'spp': not a project option in [check]; backbend "
            "config shows all");
  const std::pair<const char*, const char*> kinds[] = {
      {"rig = 4", "'rig' must be text in quotes"},
      {"rig = \"\"", "'rig' must not be empty"},
      {"rig = \"a\\u0000b\"", "'rig' holds a zero byte"},
      {"spp = \"4\"", "'spp' must be a number"},
      {"spp = nan", "'spp' must be a number"},
      {"quick = 1", "'quick' must be true or false"},
      {"joint-map = []", "'joint-map' must not be empty"},
      {"joint-map = [1]", "'joint-map' must be text in quotes, or a list of such"},
      {"[rig]\nsystem = \"even\"", "[rig]: not a command with project options"}};
  for (const auto& [text, cause] : kinds)
    EXPECT_EQ(refusal(text), std::string("/show/backbend.toml:1: ") + cause) << text;
  EXPECT_EQ(refusal("rig = \"even\"\nrig = ").rfind("/show/backbend.toml:2: ", 0), 0u);
}

class FindProject : public testing::Test {
 protected:
  fs::path write(const fs::path& name) {
    fs::create_directories((root_ / name).parent_path());
    std::ofstream(root_ / name) << "spp = 4\n";
    return root_ / name;
  }
  const TemporaryFolder root_;
};

TEST_F(FindProject, TheNearestAboveAFileOrFolderCounts) {
  const fs::path outer = write("backbend.toml"), inner = write("show/backbend.toml");
  write("show/a/hero.glb");
  EXPECT_EQ(find_project(root_ / "show/a/hero.glb"), inner);
  EXPECT_EQ(find_project(root_ / "show/a"), inner);
  EXPECT_EQ(find_project(root_ / "show/backbend.toml"), inner);
  EXPECT_EQ(find_project(root_ / "nowhere/hero.glb"), outer);  // its own command says it is missing
}

TEST_F(FindProject, AFoldersLinksAreResolvedAndAFilesAreNot) {
  const fs::path show = write("show/backbend.toml");
  write("store/backbend.toml");
  write("store/hero.glb");
  fs::create_directories(root_ / "show/a");
  fs::create_directory_symlink(root_ / "show/a", root_ / "elsewhere");
  fs::create_symlink(root_ / "store/hero.glb", root_ / "show/a/hero.glb");
  EXPECT_EQ(find_project(root_ / "elsewhere/hero.glb"), show);
  EXPECT_EQ(find_project(root_ / "elsewhere"), show);
}

TEST_F(FindProject, AFolderOfThatNameIsNoProject) {
  const fs::path outer = write("backbend.toml");
  fs::create_directories(root_ / "show/backbend.toml");
  EXPECT_EQ(find_project(root_ / "show/hero.glb"), outer);
}

TEST_F(FindProject, MoreThanAMebibyteIsRefused) {
  const fs::path file = write("backbend.toml");
  EXPECT_NO_THROW(read_project(file, kKeys));
  std::ofstream(file) << "spp = 4\n#" << std::string((1 << 20) + 1, 'x') << "\n";
  EXPECT_THROW(read_project(file, kKeys), ReadError);
}

}  // namespace
}  // namespace backbend::validate
