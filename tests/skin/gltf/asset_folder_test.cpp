#include "skin/gltf/asset_folder.h"

#include <gtest/gtest.h>

#include "skin/character/character.h"
#include "tests/skin/gltf_fixture.h"

namespace backbend::skin {
namespace {

TEST(AssetFolder, ReadsRegularFilesUpToTheSizeAsked) {
  const TemporaryFolder folder;
  write_file(folder / "none", {});
  write_file(folder / "four", {1, 2, 0, 255});
  EXPECT_TRUE(read_regular_file(folder / "none").empty());
  EXPECT_TRUE(read_regular_file(folder / "none", 0).empty());
  EXPECT_EQ(read_regular_file(folder / "four", 4), (std::vector<std::uint8_t>{1, 2, 0, 255}));
  EXPECT_THROW(read_regular_file(folder / "four", 3), CharacterError);
  EXPECT_THROW(read_regular_file(folder / "", 3), CharacterError);
  EXPECT_THROW(read_regular_file(folder / "missing"), CharacterError);
}

TEST(AssetFolder, NamesAGitLfsPointerAndTheCommandThatFetchesTheFile) {
  const TemporaryFolder folder;
  const std::string pointer =
      "version https://example.org/spec/v1\noid sha256:4d7a214614ab2935c943f9e0ff69d22eadbb8f32b125"
      "8daaa5e2ca24d17e2393\nsize 12345\n";
  const auto bytes = [](const std::string& text) {
    return std::vector<std::uint8_t>(text.begin(), text.end());
  };
  write_file(folder / "hero.glb", bytes(pointer));
  try {
    read_regular_file(folder / "hero.glb");
    FAIL() << "it was read";
  } catch (const CharacterError& error) {
    EXPECT_EQ(error.what(),
              (folder / "hero.glb").string() + ": is a Git LFS pointer; run git lfs pull");
  }
  // A file that only begins like one, and one that is too large to be one.
  write_file(folder / "text", bytes("version https://example.org/spec/v1\n"));
  write_file(folder / "large", bytes(pointer + std::string(1024, ' ')));
  EXPECT_NO_THROW(read_regular_file(folder / "text"));
  EXPECT_NO_THROW(read_regular_file(folder / "large"));
}

TEST(AssetFolder, DecodesWholeEscapesAndLeavesBrokenOnesAsTheyStand) {
  EXPECT_EQ(percent_decoded("a%20b%2Fc%C3%a9%41"),
            "a b/c\xc3\xa9"
            "A");
  EXPECT_EQ(percent_decoded("%09%90%9f%Af%fA%Fa"), "\x09\x90\x9f\xaf\xfa\xfa");
  for (const char* as_it_is : {"", "%", "%4", "100%", "%4g", "%g4", "%@0", "%0:", "%`1", "plain"})
    EXPECT_EQ(percent_decoded(as_it_is), as_it_is);
  EXPECT_EQ(percent_decoded("%%41"), "%A");
  EXPECT_EQ(percent_decoded("%2541"), "%41");  // once, not twice
}

TEST(AssetFolder, StaysInsideItself) {
  const TemporaryFolder outer;
  const std::filesystem::path folder = outer / "asset";
  std::filesystem::create_directories(folder / "textures");
  write_file(folder / "textures" / "skin.png", {1});
  write_file(outer / "secret", {1});
  write_file(outer / "asset2", {1});
  std::filesystem::create_symlink(folder / "textures" / "skin.png", folder / "inside");
  std::filesystem::create_symlink(outer / "secret", folder / "outside");
  std::filesystem::create_symlink(outer / "asset2", folder / "beside");  // begins like the folder
  const auto target = std::filesystem::canonical(folder / "textures" / "skin.png");
  EXPECT_EQ(path_inside(folder, "textures/skin.png"), target);
  EXPECT_EQ(path_inside(folder, "./textures/skin.png"), target);
  EXPECT_EQ(path_inside(folder, "inside"), target);
  for (const std::string& uri : {std::string(), std::string("outside"), std::string("beside"),
                                 std::string("../secret"), std::string("textures/../../secret"),
                                 (outer / "secret").string(), std::string("file:textures/skin.png"),
                                 std::string("missing"), std::string("inside\0.png", 11)})
    EXPECT_THROW(path_inside(folder, uri), CharacterError) << uri;
  write_file(folder / "textures" / "a:b", {1});  // a colon after a slash is no scheme
  EXPECT_NO_THROW(path_inside(folder, "textures/a:b"));
}

}  // namespace
}  // namespace backbend::skin
