// The reader and writer behind `backbend solve`: what it accepts, what it says about what it
// refuses.
#include "solver/rig/solve_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "solver/rig/nearest_name.h"
#include "solver/rig/option_reader.h"
#include "tests/solver/rig_fixture.h"
#include "tests/source_folder.h"
#include "tests/temporary_folder.h"

namespace backbend::solver {
namespace {

using nlohmann::json;

const std::filesystem::path kAcceptFolder = source_folder() / "tests/accept";

const std::string kCurveRig = "[rig]\nsystem = \"curve\"\n";
const std::string kChain = "[chain]\njoints = [[0,0,0],[0,2,0],[0,4,0],[0,6,0]]\n";

SolveFile parse(const std::string& text) {
  return parse_solve_file(text, "pose.toml", kAcceptFolder);
}

/// The message that parsing `text` ends with; empty if it does not.
std::string refusal_of(const std::string& text) {
  try {
    parse(text);
  } catch (const RigError& trouble) {
    return trouble.what();
  }
  return {};
}

void expect_says(const std::string& text, const std::vector<std::string>& parts) {
  const std::string message = refusal_of(text);
  for (const std::string& part : parts) {
    EXPECT_NE(message.find(part), std::string::npos) << "no '" << part << "' in: " << message;
  }
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

// ---- what is read ----

TEST(SolveFile, ReadsControlsInEveryForm) {
  const SolveFile a = parse(kCurveRig + kChain + "[pose]\ntop = [10, 20, -30]\n");
  const SolveFile b =
      parse(kCurveRig + kChain + "[pose]\ntop = { rx = 10, ry = 20.0, rz = -30 }\n");
  const SolveFile c =
      parse(kCurveRig + kChain + "[pose]\ntop.rx = 10\ntop.ry = 20\ntop.rz = -30\n");
  EXPECT_EQ(a.control, b.control);
  EXPECT_EQ(a.control, c.control);
  EXPECT_EQ(a.control,
            (std::vector<double>{0, 0, 0, 0, 0, 0, radians(10), radians(20), radians(-30)}));
  EXPECT_EQ(parse(kCurveRig + kChain).control, std::vector<double>(9, 0.0));
}

TEST(SolveFile, TranslationsAreLengthsAndAnglesNeverWrap) {
  const SolveFile f = parse("[rig]\nsystem = \"isner\"\n" + kChain +
                            "[pose]\nchest = [0, 0, -400]\nchest_move = [0, -1, -2]\n");
  EXPECT_EQ(f.control[5], radians(-400));
  EXPECT_EQ(f.control[10], -1.0);
  EXPECT_EQ(f.control[11], -2.0);
}

TEST(SolveFile, AFileIsReadFromDiskAndItsErrorsNameIt) {
  const TemporaryFolder folder;
  const auto path = folder / "pose.toml";
  std::ofstream(path) << kCurveRig << kChain << "[pose]\ntopp = [0, 0, 1]\n";
  try {
    read_solve_file(path);
    ADD_FAILURE() << "not refused";
  } catch (const RigError& trouble) {
    EXPECT_TRUE(std::string(trouble.what()).starts_with(path.string() + ":6: ")) << trouble.what();
  }
  std::filesystem::remove(path);
  EXPECT_THROW(read_solve_file(path), RigError);
  EXPECT_THROW(read_solve_file(folder.path()), RigError);
}

// ---- what is refused, and how it is said ----

TEST(SolveFile, NamesLineAndNearestNameOfUnknownKeys) {
  expect_says("[rig]\nsystem = \"curve\"\nbnes = 10\n" + kChain,
              {"pose.toml:3: ", "'bnes'", "did you mean 'bones'?"});
  expect_says("[rig]\nsystem = \"curv\"\n" + kChain, {"pose.toml:2: ", "did you mean 'curve'?"});
  expect_says(kCurveRig + kChain + "[pose]\ntopp = [0,0,0]\n",
              {"pose.toml:6: ", "did you mean 'top'?"});
  expect_says(kCurveRig + kChain + "[pose]\ntop.rw = 3\n",
              {"pose.toml:6: ", "unknown channel 'top.rw'"});
  expect_says(kCurveRig + "[chain]\njoint = [[0,0,0]]\n",
              {"pose.toml:4: ", "did you mean 'joints'?"});
  expect_says(kCurveRig + kChain + "[poses]\n", {"pose.toml:5: ", "did you mean 'pose'?"});
  expect_says(kCurveRig + kChain + "[pose]\nqqqqqqq = 1\n",
              {"unknown control 'qqqqqqq'", "known: lower, middle, top"});
}

TEST(SolveFile, RefusesTranslationAndScaleOfRotationOnlyControlsByName) {  // R48
  expect_says(kCurveRig + kChain + "[pose]\ntop.ty = 1\n",
              {"pose.toml:6: ", "control 'top' only rotates", "'ty'", "translation"});
  expect_says(kCurveRig + kChain + "[pose]\nmiddle = { sx = 2 }\n",
              {"control 'middle' only rotates", "'sx'", "scale"});
  expect_says(kCurveRig + kChain + "[pose]\nlower_move = [0, 1, 0]\n",
              {"control 'lower' only rotates", "'move'", "translation"});
  expect_says(kCurveRig + kChain + "[pose]\ntop = [0,0,0, 0,1,0]\n",
              {"6 values", "translation and scale are locked"});
}

TEST(SolveFile, RefusesWrongTypesAndNumbersThatAreNone) {
  expect_says("[rig]\nsystem = \"curve\"\nbones = \"ten\"\n" + kChain,
              {"pose.toml:3: ", "\"ten\"", "expected a number, 1 to 64"});
  expect_says("[rig]\nsystem = \"curve\"\nbones = 0\n" + kChain,
              {"pose.toml:3: ", "is 0", "1 to 64"});
  expect_says("[rig]\nsystem = \"curve\"\nbasis = \"bsplin\"\n" + kChain,
              {"pose.toml:3: ", "did you mean \"bspline\"?"});
  expect_says("[rig]\nsystem = \"curve\"\nbones = nan\n" + kChain, {"pose.toml:3: ", "nan"});
  expect_says(kCurveRig + kChain + "[pose]\ntop = [0, inf, 0]\n", {"pose.toml:6: ", "inf"});
  expect_says(kCurveRig + kChain + "[pose]\ntop = \"up\"\n", {"pose.toml:6: ", "not a number"});
  expect_says(kCurveRig + kChain + "[pose]\ntop = [0, 1]\n", {"2 values, expected 3"});
  expect_says(kCurveRig + kChain + "[pose]\ntop = [0, 1e300, 0]\n", {"1e+300", "within"});
  expect_says(kCurveRig + "[chain]\njoints = [[0,0,0],[0,2]]\n", {"pose.toml:4: ", "[x, y, z]"});
  expect_says(kCurveRig + "[chain]\njoints = [[0,0,0],[0,1e200,0]]\n", {"pose.toml:4: "});
  expect_says(kCurveRig + "[chain]\njoints = [[0,0,0],[0,0,0]]\n", {"pose.toml:3: ", "coincide"});
  // A third of the way and two thirds are one place on it: the middle control has no bone.
  for (const std::string system : {"three_bone", "curve", "even"}) {
    expect_says("[rig]\nsystem = \"" + system + "\"\n[chain]\njoints = [[0,2,0],[0,1,0],[0,2,0]]\n",
                {"pose.toml:3: ", system, "doubles back", "control 2"});
  }
  expect_says(kCurveRig + "[chain]\njoints = []\n", {"pose.toml:3: ", "0 joints"});
  expect_says(kCurveRig, {"pose.toml:", "0 joints"});
  expect_says("pose = 3\n" + kCurveRig + kChain, {"'pose' must be a table"});
  expect_says("[rig]\nsystem = 7\n", {"pose.toml:2: ", "'system' must be a word"});
  expect_says("[rig]\n", {"no system"});
  expect_says("[chain]\n", {"no [rig] table"});
  expect_says("[rig\n", {"pose.toml:1: "});
  expect_says("[rig]\nsystem = \"curve\"\nbones = 1979-05-27\n" + kChain, {"pose.toml:3: "});
}

TEST(SolveFile, RestFilesStayBesideTheRig) {
  const std::string neck = "[rig]\nsystem = \"neck\"\n[chain]\nrest = ";
  expect_says(neck + "\"../solver_cases.json\"\n", {"pose.toml:4: ", "beside"});
  expect_says(neck + "\"/etc/passwd\"\n", {"pose.toml:4: ", "beside"});
  expect_says(neck + "\"absent.json\"\n", {"pose.toml:4: ", "absent.json", "no such file"});
  expect_says(neck + "\"solver_cases.json\"\n", {"pose.toml:4: ", "vertebrae"});
  EXPECT_EQ(refusal_of(neck + "\"mSaurus_neck.json\"\n"), "");
}

TEST(SolveFile, RestFilesHoldThreeNumbersARow) {
  const TemporaryFolder folder;
  const auto said = [&](const std::string& row) {
    std::ofstream(folder / "rest.json")
        << R"({"vertebrae": [{"name": "C1", "row1_x_axis": [1, 0, 0], "row2_y_axis": [0, 1, 0],)"
        << R"("row3_z_axis": [0, 0, 1], "row4_position": )" << row << "}]}";
    try {
      parse_solve_file("[rig]\nsystem = \"neck\"\n[chain]\nrest = \"rest.json\"\n", "pose.toml",
                       folder.path());
    } catch (const RigError& trouble) {
      return std::string(trouble.what());
    }
    return std::string();
  };
  for (const char* row :
       {"[0, 1e300, 0]", "[0, 0, -2e9]", "[0, \"1\", 0]", "[0, 1]", "[0, 1, 2, 3]", "3", "null"}) {
    const std::string message = said(row);
    EXPECT_NE(message.find("('C1'): \"row4_position\" must be three numbers"), std::string::npos)
        << row << ": " << message;
  }
  EXPECT_EQ(said("[0, 1, 0]").find("row4_position"), std::string::npos);
}

// ---- what is written ----

TEST(PoseJson, HasTheSchemaEveryOptionAndNumbersThatReadBack) {
  const SolveFile file = parse(kCurveRig + "bones = 3\n" + kChain + "[pose]\ntop = [10, 20, 30]\n");
  const json pose = json::parse(solve_to_json(file));
  EXPECT_EQ(pose["schema"], "backbend.pose/1");
  EXPECT_EQ(pose["system"], "curve");
  const json expected = {{"arms", "effector"}, {"basis", "bspline"}, {"bones", 3.0},
                         {"follow", "chase"},  {"knots", "chord"},   {"length", "nulls"},
                         {"roll", "top"}};
  EXPECT_EQ(pose["options"], expected);
  const SpinePose solved = file.system->solve(file.control);
  ASSERT_EQ(pose["joints"].size(), 4u);
  EXPECT_EQ(pose["joints"][0]["name"], "bone_1");
  EXPECT_TRUE(pose["joints"][0]["parent"].is_null());
  EXPECT_EQ(pose["joints"][3]["parent"], 2);
  for (std::size_t i = 0; i < 4; ++i) {
    const json& p = pose["joints"][i]["position"];
    EXPECT_EQ(glm::dvec3(p[0], p[1], p[2]), solved.position[i]);  // to the last bit
    const json& q = pose["joints"][i]["turn"];
    EXPECT_EQ(glm::dquat(q[0], q[1], q[2], q[3]), solved.turn[i]);
  }
  EXPECT_EQ(pose["measures"]["curve_length"].get<double>(), rigs::measure(solved, "curve_length"));
  EXPECT_TRUE(pose["flags"].empty());
}

TEST(PoseJson, SweepsGiveOneObjectALineWithTheControlValue) {
  const SolveFile file = parse(kCurveRig + kChain + "[pose]\nmiddle = [0, 0, -20]\n");
  std::istringstream lines(sweep_to_json_lines(file, "top.rz=0:-30:-10"));
  std::string line;
  std::vector<double> seen;
  while (std::getline(lines, line)) {
    const json pose = json::parse(line);
    seen.push_back(pose["control"]["top.rz"]);
    std::vector<double> control = file.control;
    control[8] = radians(seen.back());
    const SpinePose solved = file.system->solve(control);
    EXPECT_EQ(pose["joints"][10]["position"][2].get<double>(), solved.position[10].z);
  }
  EXPECT_EQ(seen, (std::vector<double>{0, -10, -20, -30}));
}

TEST(PoseText, ListsEveryJointAndMeasure) {
  const SolveFile file = parse("[rig]\nsystem = \"three_bone\"\n" + kChain);
  const std::string text = solve_to_text(file);
  for (const char* word : {"lower", "middle", "top", "tip", "6.000000", "max_turn_deg 0"}) {
    EXPECT_NE(text.find(word), std::string::npos) << word << " in\n" << text;
  }
}

// ---- keys ----

const std::string kKeyed = kCurveRig + kChain +
                           "[pose]\nlower = [0, 5, 0]\n"
                           "[[key]]\ntime = 1\npose = { top = [0, 0, 0] }\n"
                           "[[key]]\ntime = 3\npose = { top = [0, 0, 60], lower = [0, 25, 0] }\n"
                           "[[key]]\ntime = 4\n[key.pose]\ntop.rz = 780\n";

TEST(SolveKeys, HalfwayBetweenTwoKeysIsHalfwayBetweenTheirAngles) {  // R8
  const SolveFile file = parse(kKeyed);
  const std::size_t rz = rigs::channel(*file.system, "top.rz");
  const std::size_t ry = rigs::channel(*file.system, "lower.ry");
  EXPECT_EQ(file.control_at(2.0)[rz], radians(30.0));
  EXPECT_EQ(file.control_at(2.0)[ry], radians(15.0));
  EXPECT_NEAR(file.control_at(3.5)[rz], radians(420.0), 1e-12) << "two turns on are two turns";
  // Exactly the keys at their times, and the end ones outside them.
  for (const SolveFile::Key& key : file.key) EXPECT_EQ(file.control_at(key.time), key.control);
  EXPECT_EQ(file.control_at(-1e9), file.key.front().control);
  EXPECT_EQ(file.control_at(1e9), file.key.back().control);
  EXPECT_EQ(file.control, file.key.front().control) << "without a time, the first key";
  EXPECT_EQ(parse(kCurveRig + kChain).control_at(7.0), parse(kCurveRig + kChain).control);
}

TEST(SolveKeys, PlayAsASweepOfTime) {
  const SolveFile file = parse(kKeyed);
  std::istringstream lines(sweep_to_json_lines(file, "time=1:3:0.5"));
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    const json pose = json::parse(line);
    const double time = pose["control"]["time"];
    EXPECT_EQ(time, 1.0 + 0.5 * count);
    const SpinePose solved = file.system->solve(file.control_at(time));
    EXPECT_EQ(pose["joints"][10]["position"][2].get<double>(), solved.position[10].z);
  }
  EXPECT_EQ(count, 5);
  EXPECT_THROW(sweep_to_json_lines(parse(kCurveRig + kChain), "time=0:1:1"), RigError);
}

TEST(SolveKeys, AreRefusedByLineWhereTheyMakeNoSense) {
  const std::string start = kCurveRig + kChain;  // four lines
  expect_says(start + "[[key]]\npose = {}\n", {"pose.toml:5", "no time"});
  expect_says(start + "[[key]]\ntime = 1\n[[key]]\ntime = 1\n", {"pose.toml:8", "not after"});
  expect_says(start + "[[key]]\ntime = nan\n", {"pose.toml:6", "time"});
  expect_says(start + "[[key]]\ntime = \"now\"\n", {"pose.toml:6", "number"});
  expect_says(start + "[key]\ntime = 1\n", {"pose.toml:5", "[[key]]"});
  expect_says(start + "[[key]]\ntme = 1\n", {"pose.toml:6", "'tme'", "time"});
  expect_says(start + "[[key]]\ntime = 1\npose = { tap = [0,0,1] }\n", {"pose.toml:7", "top"});
}

// ---- sweeps ----

TEST(ControlSweep, IncludesBothEndsAndDoesNotDrift) {
  const auto system = rigs::build("curve");
  const ControlSweep s = parse_sweep(*system, "top.rz=0:1:0.1");
  ASSERT_EQ(s.written.size(), 11u);
  EXPECT_EQ(s.written.back(), 1.0);
  EXPECT_EQ(parse_sweep(*system, "top.rz=0:0.3:0.1").written.size(), 4u);  // 0.3 / 0.1 is under 3
  EXPECT_EQ(s.value.back(), radians(1.0));
  EXPECT_EQ(s.channel, 8u);
  EXPECT_EQ(parse_sweep(*system, "top.rz=0:10:4").written, (std::vector<double>{0, 4, 8}));
  EXPECT_EQ(parse_sweep(*system, "top.rz=5:5:1").written, (std::vector<double>{5}));
  const auto isner = rigs::build("isner");
  EXPECT_EQ(parse_sweep(*isner, "chest_move.y=0:-2:-1").value, (std::vector<double>{0, -1, -2}));
}

TEST(ControlSweep, RefusesWhatIsNone) {
  const auto system = rigs::build("curve");
  for (const char* text : {"", "top.rz", "top.rz=", "top.rz=0:1", "top.rz=0:1:", "top.rz=0:1:0",
                           "top.rz=0:1:-1", "top.rz=0:nan:1", "top.rz=0:1:1:1", "top.rz=0:1e9:1e-3",
                           "top.qq=0:1:1", "=0:1:1", "top.rz=0:1:inf", "top.rz= 0:1:1"}) {
    EXPECT_THROW(parse_sweep(*system, text), RigError) << text;
  }
  try {
    parse_sweep(*system, "topp.rz=0:1:1");
  } catch (const RigError& trouble) {
    EXPECT_NE(std::string(trouble.what()).find("did you mean 'top.rz'?"), std::string::npos)
        << trouble.what();
  }
}

// ---- options and names ----

TEST(OptionReader, RecordsEveryDefaultAndRefusesWhatNobodyRead) {
  const SystemSpec spec{"thing", {{"count", 3.0}, {"list", std::vector<double>{1, 2}}}};
  OptionReader read(spec);
  EXPECT_EQ(read.integer("count", 1, 0, 9), 3);
  EXPECT_TRUE(read.flag("flag", true));
  EXPECT_EQ(read.word("word", {"first", "second"}), 0u);
  EXPECT_EQ(read.numbers("list", {}, 2), (std::vector<double>{1, 2}));
  EXPECT_EQ(read.rows("rows", {{1, 2}}).size(), 1u);
  const auto all = read.finish();
  EXPECT_EQ(all.size(), 5u);
  EXPECT_EQ(std::get<std::string>(all.at("word")), "first");

  OptionReader fewer(spec);
  fewer.integer("counts", 1, 0, 9);
  fewer.numbers("list", {});
  try {
    fewer.finish();
    ADD_FAILURE() << "'count' was not read";
  } catch (const OptionError& trouble) {
    EXPECT_EQ(trouble.key, "count");
    EXPECT_NE(std::string(trouble.what()).find("did you mean 'counts'?"), std::string::npos);
  }
}

TEST(OptionReader, RefusesEveryWrongKind) {
  const SystemSpec spec{"thing",
                        {{"b", true}, {"d", 1.5}, {"s", "word"}, {"l", std::vector<double>{1, 2}}}};
  OptionReader read(spec);
  EXPECT_THROW(read.number("b", 0, 0, 1), OptionError);
  EXPECT_THROW(read.integer("d", 0, 0, 9), OptionError);
  EXPECT_THROW(read.number("d", 0, 2, 3), OptionError);
  EXPECT_THROW(read.flag("d", false), OptionError);
  EXPECT_THROW(read.word("s", {"other"}), OptionError);
  EXPECT_THROW(read.word("d", {"other"}), OptionError);
  EXPECT_THROW(read.numbers("s", {}), OptionError);
  EXPECT_THROW(read.numbers("l", {}, 3), OptionError);
  EXPECT_THROW(read.numbers("l", {}, 2, 0, 1), OptionError);
  EXPECT_THROW(read.rows("l", {}), OptionError);
}

TEST(NearestName, FindsSlipsAndStaysSilentOtherwise) {
  const std::vector<std::string_view> names = {"bones", "basis", "follow", "length"};
  EXPECT_EQ(nearest_name("bone", names), "bones");
  EXPECT_EQ(nearest_name("obnes", names), "bones");  // a swap is one slip
  EXPECT_EQ(nearest_name("lenght", names), "length");
  EXPECT_EQ(nearest_name("zzzz", names), "");
  EXPECT_EQ(nearest_name("xy", names), "");  // a short word is near no long one
  EXPECT_EQ(nearest_name(std::string(100000, 'a'), names), "");
  EXPECT_EQ(nearest_name("x", std::vector<std::string>{}), "");
  const std::vector<std::string> systems = {"curve", "isner", std::string(1000, 'x')};
  EXPECT_EQ(nearest_name("isnr", systems), "isner");
  EXPECT_EQ(nearest_name(std::string(256, 'x'), systems), "");
  EXPECT_EQ(did_you_mean("isnr", systems), ", did you mean 'isner'?");
  EXPECT_EQ(did_you_mean("cat", systems), "");
}

}  // namespace
}  // namespace backbend::solver
