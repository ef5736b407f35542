#include "validate/live/rig_protocol.h"

#include <gtest/gtest.h>

#include <cmath>

#include "validate/live/control_mapping.h"
#include "validate/sweeps/external_spec.h"
#include "validate/sweeps/suite.h"

namespace backbend::validate {
namespace {

const std::string kRest = "[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,2,0,1]";

std::string hello_with(const std::string& channels, const std::string& joints,
                       const std::string& more = "") {
  return "{\"schema\": \"backbend.rig/1\", \"channels\": [" + channels + "], \"joints\": [" +
         joints + "]" + more + "}";
}

std::string joint(const std::string& name, int parent) {
  return "{\"name\": \"" + name + "\", \"parent\": " + std::to_string(parent) +
         ", \"rest\": " + kRest + "}";
}

std::string why_refused(const std::string& line) {
  try {
    parse_hello(line);
  } catch (const ProtocolError& error) {
    return error.what();
  }
  return "";
}

TEST(RigHello, SaysWhatARigIs) {
  const RigHello hello = parse_hello(
      hello_with("{\"name\": \"a.rx\"}, {\"name\": \"b\", \"kind\": \"scalar\", \"rest\": 1.5}",
                 joint("hips", -1) + "," + joint("chest", 0),
                 ", \"up\": \"Z\", \"metres_per_unit\": 0.01, \"pure\": false"));
  ASSERT_EQ(hello.channels.size(), 2u);
  EXPECT_EQ(hello.channels[0].kind, solver::Channel::Kind::rotation);
  EXPECT_EQ(hello.channels[1].kind, solver::Channel::Kind::scalar);
  EXPECT_EQ(hello.channels[1].rest, 1.5);
  EXPECT_EQ(hello.joints[1].parent, 0);
  EXPECT_EQ(hello.joints[1].rest[3][1], 2.0);
  EXPECT_TRUE(hello.z_up);
  EXPECT_EQ(hello.metres_per_unit, 0.01);
  EXPECT_FALSE(hello.pure);
  EXPECT_FALSE(hello.selects);
}

TEST(RigHello, IsRefusedNamingThePlace) {
  const std::string channel = "{\"name\": \"a\"}", hips = joint("hips", -1);
  EXPECT_NE(why_refused("{\"schema\": \"backbend.rig/7\"}").find("backbend.rig/7"),
            std::string::npos);
  EXPECT_EQ(why_refused(hello_with(channel + "," + channel, hips)),
            "hello: channels/1/name: 'a' is there twice");
  EXPECT_EQ(
      why_refused(hello_with(channel, hips + "," + joint("hips", 0))),
      "hello: joints/1/name: 'hips' is there twice; a joint that shares its name is called by "
      "its number in the glTF file, such as #12");
  EXPECT_EQ(why_refused(hello_with(channel, hips + "," + joint("chest", 1))),
            "hello: joints/1/parent: 1 is not a joint before this one (-1: none)");
  EXPECT_EQ(why_refused(hello_with(channel, "{\"name\": \"hips\"}")),
            "hello: joints/0/rest: missing");
  EXPECT_NE(why_refused(hello_with("", hips)).find("channels: missing, empty"), std::string::npos);
  EXPECT_NE(why_refused(hello_with(channel, hips, ", \"up\": \"X\"")).find("Y or Z"),
            std::string::npos);
  EXPECT_NE(why_refused(hello_with(channel, hips, ", \"metres_per_unit\": 0")).find("above 0"),
            std::string::npos);
  EXPECT_NE(why_refused("{\"error\": \"no \\u001b licence\"}").find("no   licence"),
            std::string::npos);
}

TEST(RigHello, IsToldFromWhatAProgramPrintsBefore) {
  EXPECT_TRUE(is_hello(hello_with("", "")));
  EXPECT_TRUE(is_hello("{\"error\": \"x\"}"));
  for (const char* chatter : {"Blender 3.4.1", "", "{", "{\"warning\": 1}", "[1]"})
    EXPECT_FALSE(is_hello(chatter)) << chatter;
}

TEST(RigAnswer, IsAsManyPosesAsWereAskedFor) {
  check_answer("{\"answer\": 3}", 3);
  EXPECT_THROW(check_answer("{\"answer\": 2}", 3), ProtocolError);
  EXPECT_THROW(check_answer("Warning: something", 3), ProtocolError);
  EXPECT_THROW(check_selected("{\"selected\": [1, 2]}", 1, 3), ProtocolError);
}

TEST(RigAnswer, NamesPoseAndJointOfANumberThatIsNone) {
  std::vector<double> values;
  for (int matrix = 0; matrix < 4; ++matrix)
    for (int i = 0; i < 16; ++i) values.push_back(i % 5 == 0 ? 1.0 : 0.0);
  const std::vector<std::string> names = {"hips", "chest"};
  EXPECT_EQ(unpack_joints(pack_values(values), names).size(), 4u);
  values[3 * 16 + 12] = std::nan("");
  try {
    unpack_joints(pack_values(values), names);
    FAIL();
  } catch (const ProtocolError& error) {
    EXPECT_STREQ(error.what(), "pose 1 of the batch, joint 'chest': a number that is not finite");
  }
  values[3 * 16 + 12] = 0.0;
  values[15] = 0.99999994;  // as Blender's inverse kinematics leaves it
  EXPECT_EQ(unpack_joints(pack_values(values), names)[0][3][3], 1.0);
  values[3] = 0.5;  // row by row
  EXPECT_THROW(unpack_joints(pack_values(values), names), ProtocolError);
}

TEST(RigHello, MayHavePointsAndTheirTriangles) {
  const std::string channel = "{\"name\": \"a\"}";
  const std::string hips = "{\"name\": \"hips\", \"rest\": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}";
  const RigHello hello = parse_hello(
      hello_with(channel, hips, ", \"points\": [0,0,0, 1,0,0, 0,2.5,0], \"triangles\": [0, 2, 1]"));
  ASSERT_EQ(hello.points.size(), 3u);
  EXPECT_EQ(hello.points[2], glm::vec3(0.0f, 2.5f, 0.0f));
  ASSERT_EQ(hello.triangles.size(), 1u);
  EXPECT_EQ(hello.triangles[0], glm::uvec3(0, 2, 1));
  EXPECT_TRUE(parse_hello(hello_with(channel, hips)).points.empty());
  for (const auto& [more, words] :
       {std::pair(", \"points\": [1, 2]", "points: must be a list of numbers, three for each"),
        std::pair(", \"points\": [0, 0, 1e99]", "points: 0: must be finite"),
        std::pair(", \"points\": [0, 0, \"x\"]", "points: 0: must be finite"),
        std::pair(", \"points\": [0,0,0], \"triangles\": [0, 0, 1]", "triangles: 0: '1' is not"),
        std::pair(", \"points\": [0,0,0], \"triangles\": [0, 0, -1]", "triangles: 0: '-1' is not"),
        std::pair(", \"triangles\": [0, 0, 0]", "triangles: 0: '0' is not the number of a point")})
    EXPECT_NE(why_refused(hello_with(channel, hips, more)).find(words), std::string::npos) << more;
}

TEST(RigAnswer, NamesPoseAndPointOfANumberThatIsNone) {
  std::vector<float> values(2 * 2 * 3, 0.5f);
  const auto bytes = [&] {
    return std::span(reinterpret_cast<const std::uint8_t*>(values.data()),
                     values.size() * sizeof(float));
  };
  EXPECT_EQ(unpack_points(bytes(), 2).size(), 4u);
  values[9] = std::numeric_limits<float>::infinity();
  try {
    unpack_points(bytes(), 2);
    FAIL();
  } catch (const ProtocolError& error) {
    EXPECT_STREQ(error.what(), "pose 1 of the batch, point 1: a number that is not finite");
  }
  EXPECT_EQ(ask_line(7), "{\"ask\": 7}\n");
  EXPECT_EQ(ask_line(7, true), "{\"ask\": 7, \"points\": true}\n");
}

TEST(ExternalSpec, SplitsACommandWithoutAShell) {
  using Words = std::vector<std::string>;
  EXPECT_EQ(split_command("mayapy  'my server.py' \"a b\"c \\' $HOME *"),
            (Words{"mayapy", "my server.py", "a bc", "'", "$HOME", "*"}));
  EXPECT_THROW(split_command("python3 'open"), solver::RigError);
  EXPECT_THROW(split_command("   "), solver::RigError);
}

TEST(ExternalSpec, IsReadFromTheTextThatItGives) {
  for (const char* text :
       {"blender:a folder/hero.blend", "maya:hero.ma", "command:python3 my_rig.py --flag x"}) {
    const RigPlan plan = read_rig(text);
    EXPECT_TRUE(is_external(plan.spec));
    EXPECT_EQ(rig_text(plan.spec), text);
  }
  EXPECT_EQ(read_rig("blender:a folder/hero.blend").name, "hero");
  EXPECT_EQ(read_rig("command:python3 -B my_rig.py skeleton.json").name, "my_rig");
  EXPECT_THROW(read_rig("blender:"), SuiteError);
}

TEST(ControlMapping, TakesTheOppositeOfABendForTheOtherWay) {
  const ControlMapping mapping = parse_mapping(
      "{\"channels\": {\"flexion\": [{\"control\": \"c\", \"channel\": \"rx\", \"per_degree\": "
      "0.5}]}}",
      "m");
  ASSERT_EQ(mapping.targets("extension").size(), 1u);
  EXPECT_EQ(mapping.targets("extension")[0].channel, "c.rx");
  EXPECT_EQ(mapping.targets("extension")[0].per_degree, -0.5);
  EXPECT_TRUE(mapping.targets("twist").empty());
}

TEST(ControlMapping, SharesASidecarsChannelEqually) {
  const ControlMapping mapping =
      mapping_of({{"twist", "spine_01", "Y", 1}, {"twist", "spine_02", "Y", -1}});
  ASSERT_EQ(mapping.targets("twist").size(), 2u);
  EXPECT_EQ(mapping.targets("twist")[0].channel, "spine_01.ry");
  EXPECT_EQ(mapping.targets("twist")[1].per_degree, -0.5);
}

}  // namespace
}  // namespace backbend::validate
