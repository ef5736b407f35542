#include "validate/watch/file_watch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <thread>

#include "tests/temporary_folder.h"
#include "validate/carry/input_files.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

// Long enough for any machine where something is to come, short where nothing is.
constexpr milliseconds kPatience{20000}, kNothing{150};

/// Told of changes (false) and looking for them (true).
class FileWatching : public testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    fs::create_directories(folder_);
    write("one");
  }

  void write(const std::string& text) const { std::ofstream(file_) << text; }
  using Files = std::vector<fs::path>;

  const TemporaryFolder temporary_;
  const fs::path folder_ = temporary_ / "watched", file_ = folder_ / "hero.glb";
};

TEST_P(FileWatching, TellsWhichFileHoldsSomethingElse) {
  const fs::path other = folder_ / "hero.backbend.toml";
  FileWatch watch(GetParam());
  watch.look_at({file_, other});
  EXPECT_EQ(watch.wait(kNothing), Files{});
  write("two");
  EXPECT_EQ(watch.wait(kPatience), Files{file_});
  EXPECT_EQ(watch.wait(kNothing), Files{});  // told once
  std::ofstream(other) << "new";
  EXPECT_EQ(watch.wait(kPatience), Files{other});
  EXPECT_EQ(watch.why_polled().empty(), !GetParam());
}

TEST_P(FileWatching, AFileThatIsSavedAsItWasHasNotChanged) {
  FileWatch watch(GetParam());
  watch.look_at({file_});
  write("one");
  fs::last_write_time(file_, fs::file_time_type::clock::now());
  EXPECT_EQ(watch.wait(milliseconds(900)), Files{});
}

TEST_P(FileWatching, AFileThatComesInThePlaceOfTheOldOneIsOneChange) {
  FileWatch watch(GetParam());
  watch.look_at({file_});
  std::ofstream(folder_ / "hero.tmp") << "two";
  fs::rename(file_, folder_ / "hero.glb~");
  std::this_thread::sleep_for(milliseconds(30));  // an editor between two steps
  fs::rename(folder_ / "hero.tmp", file_);
  EXPECT_EQ(watch.wait(kPatience), Files{file_});
  EXPECT_TRUE(fs::exists(file_));
  EXPECT_EQ(watch.wait(kNothing), Files{});
}

TEST_P(FileWatching, TellsOfAFileThatIsGoneAndOfItsReturn) {
  FileWatch watch(GetParam());
  watch.look_at({file_});
  fs::remove(file_);
  EXPECT_EQ(watch.wait(kPatience), Files{file_});
  write("one");
  EXPECT_EQ(watch.wait(kPatience), Files{file_});
}

TEST_P(FileWatching, AFolderThatIsReplacedIsWatchedOn) {
  FileWatch watch(GetParam());
  watch.look_at({file_});
  fs::rename(folder_, folder_.string() + "_old");
  fs::create_directories(folder_);
  write("two");
  EXPECT_EQ(watch.wait(kPatience), Files{file_});
  write("three");
  EXPECT_EQ(watch.wait(kPatience), Files{file_});
  fs::remove_all(folder_.string() + "_old");
}

INSTANTIATE_TEST_SUITE_P(Ways, FileWatching, testing::Bool(), [](const auto& info) {
  return std::string(info.param ? "Looking" : "Told");
});

TEST(FileWatch, WaitsForAFileThatIsStillBeingWritten) {
  const TemporaryFolder folder;
  const fs::path file = folder / "hero.glb";
  std::ofstream(file) << "one";
  FileWatch watch;
  watch.look_at({file});
  std::thread writer([&] {
    std::ofstream out(file);
    for (int part = 0; part < 5; ++part) {
      out << "part " << part << std::flush;
      std::this_thread::sleep_for(milliseconds(100));
    }
  });
  EXPECT_EQ(watch.wait(kPatience).size(), 1u);
  const auto size = fs::file_size(file);
  writer.join();
  EXPECT_EQ(fs::file_size(file), size);  // it was whole when it was told of
  EXPECT_TRUE(watch.wait(kNothing).empty());
}

TEST(FileWatch, SaysWhyAFolderThatIsNotToldOfIsLookedAt) {
  FileWatch watch;
  watch.look_at({"/proc/self/status"});  // a file system that tells nothing is no reason by itself
  FileWatch asked(true);
  asked.look_at({"/tmp/hero.glb"});
  EXPECT_EQ(asked.why_polled(), "requested");
}

TEST(InputFiles, AreTheCharacterItsSidecarItsProjectAndWhatAGltfNames) {
  const TemporaryFolder folder;
  using Files = std::vector<fs::path>;
  EXPECT_EQ(input_files(folder / "hero.glb"),
            (Files{folder / "hero.glb", folder / "hero.backbend.toml", folder / "backbend.toml"}));
  std::ofstream(folder / "hero.gltf")
      << R"({"buffers": [{"uri": "hero%201.bin"}, {"uri": "data:,x"}, {"uri": "../out.bin"}, 3],
             "images": [{"uri": "skin.png"}, {"bufferView": 0}]})";
  const Files files = input_files(folder / "hero.gltf");
  ASSERT_EQ(files.size(), 5u);
  EXPECT_EQ(files[3].filename(), "hero 1.bin");
  EXPECT_EQ(files[4].filename(), "skin.png");
  std::ofstream(folder / "hero.gltf") << "half of a sa";
  EXPECT_EQ(input_files(folder / "hero.gltf").size(), 3u);
}

}  // namespace
}  // namespace backbend::validate
