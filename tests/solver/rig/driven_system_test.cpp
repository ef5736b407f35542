// Controls of a pose file's own that drive the rig's channels, and chains that are drawn again
// under it: W9, R28 and W5 of research/seeds.md as a user reaches them.
#include "solver/rig/driven_system.h"

#include "solver/rig/evaluation_order.h"
#include "solver/rig/solve_file.h"
#include "tests/solver/rig_fixture.h"

namespace backbend::solver {
namespace {

using namespace rigs;

const std::string kRig =
    "[rig]\nsystem = \"even\"\n"
    "[chain]\njoints = [[0,0,0],[0,1,0],[0,2,0.1],[0,3,0]]\n";
const std::string kShares =
    "[[control]]\nname = \"bend\"\n"
    "[[element]]\nname = \"shares\"\ninputs = [\"bend\"]\nweights = [[0.25], [0.75]]\n"
    "drives = [\"middle.rz\", \"top.rz\"]\n";

SolveFile parsed(const std::string& text) { return parse_solve_file(text, "pose.toml", "."); }

std::string refusal(const std::string& text) {
  try {
    parsed(text);
  } catch (const RigError& trouble) {
    return trouble.what();
  }
  return {};
}

std::string joints_of(const std::string& json) {
  const std::size_t from = json.find("\"joints\""), to = json.find("\"measures\"");
  return json.substr(from, to - from);
}

TEST(DrivenSystem, SharesAControlOutOverTheChannelsThatItDrives) {
  const SolveFile driven = parsed(kRig + kShares + "[pose]\nbend = -40\n\"top.rz\" = -6\n");
  const SolveFile plain = parsed(kRig + "[pose]\n\"middle.rz\" = -10\n\"top.rz\" = -36\n");
  const auto &a = driven.system->solve(driven.control), b = plain.system->solve(plain.control);
  ASSERT_EQ(a.joint_count(), b.joint_count());
  for (std::size_t i = 0; i < a.joint_count(); ++i) {
    expect_near(a.position[i], b.position[i], 1e-12);
    EXPECT_LT(angle_between(a.turn[i], b.turn[i]), 1e-7);
  }
}

TEST(DrivenSystem, AtRestIsTheRigAtRestToTheLastBit) {
  EXPECT_EQ(joints_of(solve_to_json(parsed(kRig + kShares))),
            joints_of(solve_to_json(parsed(kRig))));
}

TEST(DrivenSystem, IsSweptByItsOwnControls) {
  const SolveFile driven = parsed(kRig + kShares);
  const std::string lines = sweep_to_json_lines(driven, "bend=0:-90:-45");
  EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 3);
  const std::string last = lines.substr(lines.rfind("\n", lines.size() - 2) + 1);
  EXPECT_NE(last.find("\"control\":{\"bend\":-90"), std::string::npos) << last.substr(0, 200);
  EXPECT_EQ(joints_of(last),
            joints_of(solve_to_json(parsed(kRig + kShares + "[pose]\nbend = -90\n"))));
}

TEST(DrivenSystem, PlaysKeysOfItsControls) {
  const std::string keys = "[[key]]\ntime = 0\n[[key]]\ntime = 10\n[key.pose]\nbend = -80\n";
  const SolveFile driven = parsed(kRig + kShares + keys);
  EXPECT_DOUBLE_EQ(driven.control_at(5.0).back(), -40.0);
}

TEST(DrivenSystem, ChainsElementsAndTakesControlsOfSeveralNumbers) {
  const std::string chained =
      "[[control]]\nname = \"bend\"\nrest = [0, 0]\n"
      "[[element]]\nname = \"late\"\ninputs = [\"sum\"]\nweights = [[0.5]]\ndrives = [\"top.rz\"]\n"
      "[[element]]\nname = \"sum\"\ninputs = [\"bend\"]\nweights = [[1, 2]]\n";
  const SolveFile file = parsed(kRig + chained + "[pose]\nbend = [10, 20]\n");
  const auto* driven = dynamic_cast<const DrivenSystem*>(file.system.get());
  ASSERT_NE(driven, nullptr);
  const std::vector<double> control = driven->rig_control(file.control);
  const auto& channels = driven->rig().channels();
  for (std::size_t i = 0; i < channels.size(); ++i)
    EXPECT_NEAR(control[i], channels[i].name == "top.rz" ? radians(25.0) : channels[i].rest, 1e-12)
        << channels[i].name;
  const std::vector<std::string> steps = evaluation_order(*file.system);
  ASSERT_GE(steps.size(), 4u);
  EXPECT_EQ(steps[0], "element sum <- bend");
  EXPECT_EQ(steps[1], "element late <- sum");
  EXPECT_EQ(steps[2], "add 'late' to top.rz");
  EXPECT_EQ(steps[3], "a change of bend evaluates 2 of 2 elements again");
}

TEST(DrivenSystem, RefusesWhatCannotBeEvaluatedByName) {
  const auto element = [](const std::string& rest) {
    return kRig + "[[control]]\nname = \"bend\"\n[[element]]\nname = \"e\"\n" + rest;
  };
  EXPECT_EQ(refusal(element("inputs = [\"bned\"]\nweights = [[1]]\n")),
            "pose.toml:7: element 'e': unknown input 'bned'; did you mean 'bend'?");
  EXPECT_EQ(refusal(element("inputs = [\"bend\"]\nweights = [[1, 2]]\n")),
            "pose.toml:7: element 'e': 1 numbers come in, 2 weights a row");
  EXPECT_EQ(refusal(element("inputs = [\"bend\"]\nweights = [[1]]\ndrives = [\"top.rzz\"]\n"))
                .substr(0, 61),
            "pose.toml:7: element 'e': the rig has no channel 'top.rzz'; d");
  EXPECT_EQ(refusal(element("inputs = [\"bend\"]\nweights = [[1]]\ndrives = [\"top.rz\", "
                            "\"top.rx\"]\n")),
            "pose.toml:7: element 'e': drives 2 channels with 1 rows of weights");
  EXPECT_EQ(refusal(element("inputs = [\"e\"]\nweights = [[1]]\n")),
            "pose.toml:7: elements depend on each other in a circle: 'e' <- 'e'");
  EXPECT_EQ(refusal(kRig + "[[control]]\nname = \"bend\"\n"),
            "pose.toml:5: [[control]] without [[element]] drives nothing");
  EXPECT_EQ(refusal(kRig + "[[control]]\nname = \"top\"\n[[element]]\nname = \"e\"\ninputs = "
                           "[\"top\"]\nweights = [[1]]\n"),
            "pose.toml:7: control 'top': the rig has a control of this name");
  EXPECT_EQ(refusal(kRig + "[[control]]\nname = \"a.b\"\n"),
            "pose.toml:6: 'name' of [[control]] expects a letter, then letters, digits and _");
}

TEST(DrivenSystem, DrivesNoChannelFurtherThanAFileMaySetIt) {
  const SolveFile file = parsed(kRig + kShares + "[pose]\nbend = 2e6\n");
  try {
    file.system->solve(file.control);
    FAIL() << "solved";
  } catch (const RigError& trouble) {
    EXPECT_EQ(std::string(trouble.what()), "element 'shares' drives top.rz beyond +-1e+06");
  }
}

TEST(Redrawn, ALiveRigFollowsItsChainAndAFrozenOneKeepsItsOwn) {
  const std::string edited = "[redrawn]\njoints = [[0,0,0],[0,1.5,0],[0,3,0.4],[0,4,0]]\n";
  const std::string pose = "[pose]\n\"top.rz\" = -50\n";
  const auto with_drawing = [&](const std::string& word) {
    std::string text = kRig;
    return text.insert(text.find("[chain]"), "drawing = \"" + word + "\"\n") + edited + pose;
  };
  std::string on_edited = kRig;
  on_edited.replace(on_edited.find("[chain]"), std::string::npos, edited);
  on_edited.replace(on_edited.find("[redrawn]"), 9, "[chain]");
  const std::string frozen = solve_to_json(parsed(with_drawing("frozen")));
  EXPECT_EQ(frozen, solve_to_json(parsed(kRig + pose)));
  EXPECT_EQ(frozen, solve_to_json(parsed(kRig + edited + pose))) << "the default";
  const std::string live = solve_to_json(parsed(with_drawing("live")));
  EXPECT_NE(live, frozen);
  EXPECT_EQ(live, solve_to_json(parsed(on_edited + pose)));
  EXPECT_EQ(refusal(with_drawing("alive")),
            "pose.toml:3: 'drawing' expects \"frozen\" or \"live\"");
}

}  // namespace
}  // namespace backbend::solver
