#include "validate/files/output_folder.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

#include "tests/temporary_folder.h"
#include "validate/files/child_process.h"
#include "validate/files/hash.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;

class Folder : public testing::Test {
 protected:
  std::size_t entries() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(path_), fs::directory_iterator()));
  }
  // Another for each test: a process knows the folders that it has written to.
  const TemporaryFolder temporary_;
  const fs::path path_ = temporary_.path();
};

TEST_F(Folder, IsNotMadeBeforeSomethingIsWritten) {
  const OutputFolder folder(path_ / "new");
  EXPECT_FALSE(fs::exists(path_ / "new"));
  folder.write("deep/file.txt", std::string_view("text"));
  EXPECT_EQ(read_text(path_ / "new" / "deep" / "file.txt"), "text");
}

TEST_F(Folder, LeavesNothingBesideTheFile) {
  const OutputFolder folder(path_);
  folder.write("a.txt", std::string_view("one"));
  folder.write("a.txt", std::string_view("two"));
  EXPECT_EQ(read_text(path_ / "a.txt"), "two");
  EXPECT_EQ(entries(), 1u);
}

TEST_F(Folder, ReplacesAPlantedLinkInsteadOfFollowingIt) {
  std::ofstream(path_ / "victim") << "untouched";
  fs::create_symlink(path_ / "victim", path_ / "out.txt");
  OutputFolder(path_).write("out.txt", std::string_view("ours"));
  EXPECT_EQ(read_text(path_ / "victim"), "untouched");
  EXPECT_FALSE(fs::is_symlink(path_ / "out.txt"));
}

TEST_F(Folder, RefusesALinkInThePlaceOfAFolderOfItsOwn) {
  fs::create_directories(path_ / "elsewhere");
  fs::create_directory_symlink(path_ / "elsewhere", path_ / "frames");
  try {
    OutputFolder(path_).write("frames/a.exr", std::string_view("ours"));
    FAIL() << "what the link points to was written to";
  } catch (const WriteError& error) {
    EXPECT_FALSE(error.temporary());
    EXPECT_NE(std::string(error.what()).find((path_ / "frames").string() + ": is a link"),
              std::string::npos)
        << error.what();
  }
  EXPECT_TRUE(fs::is_empty(path_ / "elsewhere"));
}

TEST_F(Folder, MayBeNamedThroughALink) {
  fs::create_directories(path_ / "disk");
  fs::create_directory_symlink(path_ / "disk", path_ / "out");
  OutputFolder(path_ / "out").write("frames/a.exr", std::string_view("ours"));
  EXPECT_EQ(read_text(path_ / "disk/frames/a.exr"), "ours");
}

TEST_F(Folder, RefusesAnotherThatIsPutInItsPlaceWhileItIsWritten) {
  const OutputFolder folder(path_ / "run");
  folder.write("a.txt", std::string_view("one"));
  fs::create_directories(path_ / "elsewhere");
  fs::rename(path_ / "run", path_ / "moved");
  fs::create_directory_symlink(path_ / "elsewhere", path_ / "run");
  EXPECT_THROW(folder.write("b.txt", std::string_view("two")), WriteError);
  EXPECT_THROW(OutputFolder(path_ / "run").write("b.txt", std::string_view("two")), WriteError);
  EXPECT_TRUE(fs::is_empty(path_ / "elsewhere"));
  EXPECT_EQ(read_text(path_ / "moved/a.txt"), "one");
  OutputFolder(path_ / "run").prepare();  // the next run of this process
  folder.write("b.txt", std::string_view("two"));
  EXPECT_EQ(read_text(path_ / "elsewhere/b.txt"), "two");
}

TEST_F(Folder, RefusesNamesThatLeadOutOfIt) {
  EXPECT_THROW(OutputFolder(path_ / "in").write("../a.txt", std::string_view("x")), WriteError);
  EXPECT_THROW(OutputFolder(path_ / "in").write(path_ / "a.txt", std::string_view("x")),
               WriteError);
  EXPECT_FALSE(fs::exists(path_ / "a.txt"));
}

TEST_F(Folder, NamesWhatAnotherProgramWroteWhereverTheFolderIsMovedMeanwhile) {
  const auto wrote = [&](const fs::path& file) { std::ofstream(file) << "frames"; };
  const OutputFolder folder(path_ / "run");
  {
    OutputFolder::Temporary file = folder.temporary_for("media/a.mp4");
    wrote(file.path());
    fs::rename(path_ / "run", path_ / "moved");
    fs::create_directories(path_ / "run" / "media");
    file.commit();
  }
  EXPECT_EQ(read_text(path_ / "moved/media/a.mp4"), "frames");
  EXPECT_TRUE(fs::is_empty(path_ / "run/media"));
  { wrote(OutputFolder(path_ / "new").temporary_for("a.mp4").path()); }
  EXPECT_TRUE(fs::is_empty(path_ / "new")) << "what was not committed is left";
}

TEST_F(Folder, SaysWhyAFileCannotBeWritten) {
  std::ofstream(path_ / "file") << "";
  try {
    OutputFolder(path_ / "file" / "inside").write("x", std::string_view("y"));
    FAIL() << "a folder was made inside a file";
  } catch (const WriteError& error) {
    EXPECT_FALSE(error.temporary());
    EXPECT_NE(std::string(error.what()).find("inside"), std::string::npos) << error.what();
  }
}

TEST_F(Folder, ReportsAFullDiskAsTemporary) {
  EXPECT_TRUE(WriteError("x", ENOSPC).temporary());
  EXPECT_TRUE(WriteError("x", EIO).temporary());
  EXPECT_FALSE(WriteError("x", EACCES).temporary());
}

TEST_F(Folder, DoesNotWaitOnAPipe) {
  ASSERT_EQ(::mkfifo((path_ / "pipe").c_str(), 0600), 0);
  EXPECT_THROW(read_bytes(path_ / "pipe"), ReadError);
  EXPECT_THROW(read_bytes(path_), ReadError);
  EXPECT_THROW(read_bytes(path_ / "absent"), ReadError);
}

TEST_F(Folder, RefusesToReadMoreThanItWasAskedTo) {
  std::ofstream(path_ / "big") << std::string(100, 'x');
  EXPECT_THROW(read_bytes(path_ / "big", 99), ReadError);
  EXPECT_EQ(read_bytes(path_ / "big", 100).size(), 100u);
}

TEST(Child, IsFedAndItsExitCodeKept) {
  ::signal(SIGPIPE, SIG_IGN);  // as the program does: a child may be gone before it is fed
  const auto feed = [](const auto& give) {
    const std::string text = "3";
    give(std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
  };
  EXPECT_EQ(run_child({"sh", "-c", "read x; echo bad >&2; exit $x"}, feed).exit_code, 3);
  EXPECT_EQ(run_child({"sh", "-c", "read x; echo bad >&2; exit $x"}, feed).complaint, "bad\n");
  EXPECT_EQ(run_child({"sh", "-c", "kill -9 $$"}, feed).exit_code, 128 + 9);
  EXPECT_THROW(run_child({"backbend-no-such-program"}, feed), ReadError);
}

TEST(Child, ThatGoesAwayEarlyIsNoCrash) {
  const auto feed = [](const auto& give) {
    const std::vector<std::uint8_t> block(1 << 20, 0);
    for (int i = 0; i < 8; ++i) give(block);
  };
  ::signal(SIGPIPE, SIG_IGN);
  EXPECT_EQ(run_child({"true"}, feed).exit_code, 0);
}

TEST(ContentHash, IsThatOfTheReferenceImplementation) {
  // XXH3-128 of no bytes, from the xxHash specification's sanity table.
  EXPECT_EQ(content_hash(std::string_view("")), "99aa06d3014798d86001c324468d497f");
}

}  // namespace
}  // namespace backbend::validate
