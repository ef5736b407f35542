#include "validate/hunt/control_box.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/temporary_folder.h"
#include "validate/files/output_folder.h"

namespace backbend::validate {
namespace {

class BoxFile : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& text) {
    const auto file = folder_ / name;
    std::ofstream(file) << text;
    return file;
  }
  std::string refusal(const std::string& name, const std::string& text) {
    try {
      read_box(write(name, text));
    } catch (const ReadError& error) {
      return error.what();
    }
    return "accepted";
  }

 private:
  const TemporaryFolder folder_;
};

TEST(ControlBox, OfAnEnvelopeReachesItsEndsAndJoinsExtensionWithFlexion) {
  const ControlBox box = find_box("envelope", *find_envelope("human"));
  EXPECT_EQ(box.text(), "extension 0..60, flexion 0..90, side -45..45, twist -60..60");
  const double low[] = {0, 0, 0}, high[] = {1, 1, 1};
  EXPECT_EQ(box.pose_at(low).text(), "flexion 90, side -45, twist -60");
  EXPECT_EQ(box.pose_at(high).text(), "extension 60, side 45, twist 60");
  const std::vector<double> rest = box.point_of({});
  EXPECT_DOUBLE_EQ(rest[0], 0.6);  // 90 of 150 degrees
  EXPECT_EQ(box.pose_at(rest).text(), "rest");
}

TEST(ControlBox, OfTheOtherWordsReachesAsFarAsTheirSweeps) {
  const Envelope human = *find_envelope("human");
  EXPECT_EQ(find_box("sweep", human).text(),
            "extension 0..120, flexion 0..90, side -45..45, twist -90..90");
  EXPECT_EQ(find_box("stress", human).text(),
            "extension 0..180, flexion 0..180, side -120..120, twist -360..360");
}

TEST_F(BoxFile, HoldsWhatHasNoWidthAndMovesTheRest) {
  const ControlBox box =
      read_box(write("box.toml", "extension = [20, 60]\ntwist = [30, 30]\nstretch = [-5, 10]\n"));
  ASSERT_EQ(box.axes.size(), 2u);
  const double middle[] = {0.5, 0.0};
  EXPECT_EQ(box.pose_at(middle).text(), "extension 40, twist 30, stretch -5");
}

TEST_F(BoxFile, MayBeJson) {
  EXPECT_EQ(read_box(write("box.json", R"({"flexion": [0, 45.5], "side": [-10, 20]})")).text(),
            "flexion 0..45.5, side -10..20");
}

TEST_F(BoxFile, MayHaveItsTableHeldChannelsAndExtensionBelowZeroForFlexion) {
  EXPECT_EQ(read_box(write("box.toml", "[box]\nextension = [-30, 20]\nside = [0, 10]\ntwist = 5\n"))
                .text(),
            "extension 0..20, flexion 0..30, side 0..10, twist 5");
  EXPECT_EQ(read_box("extension=-30:-10,side=5").text(), "flexion 10..30, side 5");
}

TEST_F(BoxFile, IsRefusedByNameAndLine) {
  EXPECT_NE(refusal("a.toml", "side = [0, 10]\ntwist = [30, -30]\n")
                .find("a.toml:2: 'twist' is inverted: 30 is above -30"),
            std::string::npos);
  EXPECT_NE(refusal("b.toml", "side = [0, inf]\n").find("b.toml:1: 'side' must end between"),
            std::string::npos);
  EXPECT_NE(refusal("c.toml", "side = [5, 5]\n").find("the box is empty"), std::string::npos);
  EXPECT_NE(refusal("d.toml", "").find("the box is empty"), std::string::npos);
  EXPECT_NE(refusal("e.toml", "sied = [0, 1]\n").find("no channel 'sied', did you mean 'side'"),
            std::string::npos);
  EXPECT_NE(refusal("f.toml", "side = '3'\n").find("'side' must be [from, to]"), std::string::npos);
  EXPECT_NE(
      refusal("g.toml", "extension = [-10, 10]\nflexion = [0, 5]\n").find("must be 0 or more"),
      std::string::npos);
  EXPECT_NE(refusal("h.toml", "extension = [10, 20]\nflexion = [0, 20]\n").find("both begin at 0"),
            std::string::npos);
  EXPECT_NE(refusal("i.toml", "stretch = [-99, 0]\n").find("leaves no spine"), std::string::npos);
  EXPECT_NE(refusal("j.toml", "side = [0, 10\n").find("j.toml:"), std::string::npos);
  EXPECT_NE(refusal("k.json", "[1, 2]").find("k.json: not a JSON object"), std::string::npos);
  EXPECT_NE(refusal("l.toml", "side = [nan, 1]\n").find("must end between"), std::string::npos);
}

TEST(ControlBox, OfAnUnknownWordNamesTheNearest) {
  try {
    find_box("envelop", *find_envelope("human"));
    FAIL();
  } catch (const ReadError& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean 'envelope'"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace backbend::validate
