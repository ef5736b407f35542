// A blow that lands from one frame to the next turns the spine, too; a flip turns the spine alone.
#include "validate/clips/arm_leap.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>
#include <map>

#include "skin/character/matrix_facts.h"
#include "tests/skin/stick_figure.h"
#include "validate/clips/clip_measure.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

/// Degrees that a joint turns by about +X from frame 20 on, `back` frames later again at rest; 0:
/// it stays.
struct Leap {
  double deg = 0.0;
  Index back = 0;
};

/// A stick figure that sways a little, some of whose joints leap.
struct Figure {
  skin::Character character = skin::stick_figure(3);
  skin::Clip clip;

  explicit Figure(const std::map<std::string, Leap>& leaps) {
    constexpr Index kFrames = 40;
    const auto& nodes = character.nodes;
    for (const skin::Node& node : nodes) {
      clip.joint.push_back(node.name);
      clip.parent.push_back(node.parent);
      clip.rest.push_back(node.world_from_node);
    }
    for (Index f = 0; f < kFrames; ++f) {
      clip.time.push_back(static_cast<double>(f) / 30.0);
      clip.frame_number.push_back(static_cast<int>(f));
      std::vector<glm::dmat4> world;
      for (const skin::Node& node : nodes) {
        const bool root = node.parent < 0;
        const glm::dmat4 above =
            root ? glm::dmat4(1.0) : nodes[static_cast<Index>(node.parent)].world_from_node;
        double deg = std::sin(0.1 * static_cast<double>(f));
        if (const auto leap = leaps.find(node.name); leap != leaps.end())
          if (f >= 20 && (leap->second.back == 0 || f < 20 + leap->second.back))
            deg += leap->second.deg;
        const glm::dmat4 local = glm::inverse(above) * node.world_from_node *
                                 glm::rotate(glm::dmat4(1.0), glm::radians(deg), {1, 0, 0});
        world.push_back(root ? local : world[static_cast<Index>(node.parent)] * local);
      }
      clip.world.insert(clip.world.end(), world.begin(), world.end());
    }
    clip.sweeps = {{"blow", 0, kFrames}};
  }

  RigRecord measured() const {
    const Stage stage(character, skin::find_anatomy(character));
    const ClipBody body(stage.character(), stage.anatomy(), clip, {});
    Progress progress(Progress::Style::none);
    return measure_clip(stage, clip, body, nullptr, progress);
  }
  /// With a control of the spine on record, still throughout.
  Figure with_control() const {
    Figure out = *this;
    out.clip.control = {"extension"};
    out.clip.control_value.assign(out.clip.frame_count(), 0.0);
    return out;
  }
  Index jumps() const { return measured().sweeps.front().flips.jumps.size(); }
};

TEST(ArmLeap, OfAHandExplainsAThirdOfItInTheHips) {
  EXPECT_EQ(Figure({}).jumps(), 0u);
  EXPECT_EQ(Figure({{"hips", {9.0}}}).jumps(), 1u);
  EXPECT_EQ(Figure({{"hips", {9.0}}, {"arm.L", {25.0}}}).jumps(), 1u);
  const Figure blow({{"hips", {9.0}}, {"arm.L", {60.0}}});
  EXPECT_EQ(blow.jumps(), 0u);
  const RigRecord record = blow.measured();
  std::string notes;
  for (const std::string& note : record.recording->notes) notes += note + "\n";
  EXPECT_NE(notes.find("blow, frame 20: hips jumps by 9"), std::string::npos) << notes;
  EXPECT_NE(notes.find("with hand.L, which turns by"), std::string::npos) << notes;
}

TEST(ArmLeap, OfAHandThatIsHeldInPlaceExplainsNothing) {
  // The arm turns back what the hips turn it by: against the chest it leaps, in the world it rests.
  EXPECT_EQ(Figure({{"hips", {9.0}}, {"arm.L", {-9.0}}, {"arm.R", {-9.0}}}).jumps(), 1u);
  EXPECT_EQ(Figure({{"hips", {12.0}}, {"arm.L", {-60.0}}, {"hand.L", {48.0}}}).jumps(), 1u);
}

TEST(ArmLeap, OfTheOtherArmExplainsAsMuchInAClavicle) {
  EXPECT_EQ(Figure({{"clavicle.R", {10.0}}}).jumps(), 1u);
  EXPECT_EQ(Figure({{"clavicle.R", {10.0}}, {"arm.L", {5.0}}}).jumps(), 1u);
  EXPECT_EQ(Figure({{"clavicle.R", {10.0}}, {"arm.L", {12.0}}}).jumps(), 0u);
  EXPECT_EQ(Figure({{"clavicle.R", {10.0}}, {"arm.R", {12.0}}}).jumps(), 1u);
  // Both clavicles at once, with arms that are held where they are or not.
  EXPECT_EQ(Figure({{"clavicle.R", {10.0}}, {"clavicle.L", {10.0}}}).jumps(), 1u);
  EXPECT_EQ(
      Figure(
          {{"clavicle.R", {10.0}}, {"clavicle.L", {10.0}}, {"arm.R", {-10.0}}, {"arm.L", {-10.0}}})
          .jumps(),
      1u);
}

TEST(ArmLeap, ExplainsNothingInTheSpineNorALegAnything) {
  EXPECT_EQ(Figure({{"spine_2", {10.0}}, {"arm.L", {60.0}}}).jumps(), 1u);
  EXPECT_EQ(Figure({{"head", {10.0}}, {"arm.L", {60.0}}}).jumps(), 1u);
  EXPECT_EQ(Figure({{"spine_3", {10.0}}, {"shin.R", {60.0}}}).jumps(), 1u);
  EXPECT_EQ(Figure({{"hips", {10.0}}, {"shin.R", {60.0}}, {"foot.R", {60.0}}}).jumps(), 1u);
}

TEST(ArmLeap, ExplainsNothingWhereControlsAreRecorded) {
  const Figure blow({{"hips", {9.0}}, {"arm.L", {60.0}}});
  EXPECT_EQ(blow.jumps(), 0u);
  EXPECT_GE(blow.with_control().jumps(), 1u);
}

TEST(ArmLeap, ExplainsNoWideFlipAndNoPop) {
  EXPECT_EQ(Figure({{"hips", {20.0}}, {"arm.L", {90.0}}}).jumps(), 1u);
  EXPECT_GE(Figure({{"hips", {10.0, 1}}, {"arm.L", {60.0, 1}}}).jumps(), 1u);
}

}  // namespace
}  // namespace backbend::validate
