// Motion read from files: glTF animations, backbend.clip/1, MDD and PC2.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/gtc/quaternion.hpp>
#include <limits>
#include <numbers>
#include <random>

#include "skin/clip/clip.h"
#include "tests/skin/gltf_fixture.h"

namespace backbend::skin {
namespace {

using nlohmann::json;

constexpr double kPi = std::numbers::pi;
// Values pass through float once: half a unit in the last place of numbers up to 4.
constexpr double kFloatTolerance = 3e-7;

/// A rotation about Z, x y z w, with a sign of choice.
std::vector<float> about_z(double degrees, float sign = 1.0f) {
  const double half = degrees * kPi / 360.0;
  return {0.0f, 0.0f, sign * static_cast<float>(std::sin(half)),
          sign * static_cast<float>(std::cos(half))};
}

/// One animated property of a node of the strip.
void animate(GltfFixture& file, int node, const std::string& path, const std::string& interpolation,
             const std::vector<float>& time, const std::vector<float>& value) {
  const std::size_t width = path == "rotation" ? 4 : 3;
  const int input = file.add(time, kFloat, "SCALAR", 1);
  const int output = file.add(value, kFloat, width == 4 ? "VEC4" : "VEC3", width);
  if (!file.root.contains("animations"))
    file.root["animations"] = {
        {{"name", "act"}, {"channels", json::array()}, {"samplers", json::array()}}};
  json& animation = file.root["animations"][0];
  animation["samplers"].push_back(
      {{"input", input}, {"output", output}, {"interpolation", interpolation}});
  animation["channels"].push_back({{"sampler", animation["samplers"].size() - 1},
                                   {"target", {{"node", node}, {"path", path}}}});
}

std::vector<float> joined(std::initializer_list<std::vector<float>> parts) {
  std::vector<float> out;
  for (const auto& part : parts) out.insert(out.end(), part.begin(), part.end());
  return out;
}

Clip read_clip_of(const GltfFixture& file) {
  const TemporaryFolder folder;
  return read_clip(file.write_glb(folder));
}

std::size_t joint(const Clip& clip, const std::string& name) {
  return static_cast<std::size_t>(std::find(clip.joint.begin(), clip.joint.end(), name) -
                                  clip.joint.begin());
}

/// Turn of a joint about Z in a frame, degrees.
double angle(const Clip& clip, std::size_t frame, const std::string& name) {
  const glm::dmat4& m = clip.world[frame * clip.joint_count() + joint(clip, name)];
  return std::atan2(m[0][1], m[0][0]) * 180.0 / kPi;
}

TEST(GltfClip, FramesAreTheKeysHoweverUnevenTheyStand) {
  GltfFixture file = strip();
  animate(file, 1, "rotation", "LINEAR", {0.0f, 0.03f, 0.11f},
          joined({about_z(0), about_z(30), about_z(10)}));
  const Clip clip = read_clip_of(file);
  ASSERT_EQ(clip.frame_count(), 3u);
  EXPECT_NEAR(clip.time[1], 0.03, 1e-8);
  EXPECT_NEAR(angle(clip, 1, "chest"), 30.0, 1e-5);
  EXPECT_NEAR(angle(clip, 2, "chest"), 10.0, 1e-5);
  EXPECT_EQ(clip.sweeps.size(), 1u);
  EXPECT_EQ(clip.sweeps[0].name, "act");
}

TEST(GltfClip, LinearRotationsTakeTheShorterWayWhateverTheSignOfTheirKeys) {
  GltfFixture file = strip();
  // 0.3 s apart: the player makes up what lies between, here ten frames' steps of 6 degrees.
  animate(file, 1, "rotation", "LINEAR", {0.0f, 0.3f}, joined({about_z(-30), about_z(30, -1.0f)}));
  const Clip clip = read_clip_of(file);
  ASSERT_GE(clip.frame_count(), 10u);
  const double last = static_cast<double>(clip.frame_count() - 1);
  for (std::size_t f = 0; f < clip.frame_count(); ++f)
    EXPECT_NEAR(angle(clip, f, "chest"), -30.0 + 60.0 * static_cast<double>(f) / last, 1e-4) << f;
}

TEST(GltfClip, PutsMoveTurnAndScaleTogetherInThatOrder) {
  GltfFixture file = strip();
  animate(file, 0, "translation", "LINEAR", {0.0f, 0.05f}, {0, 0, 0, 1, 2, 3});
  animate(file, 0, "rotation", "LINEAR", {0.0f, 0.05f}, joined({about_z(0), about_z(90)}));
  animate(file, 0, "scale", "LINEAR", {0.0f, 0.05f}, {1, 1, 1, 2, 3, 4});
  const Clip clip = read_clip_of(file);
  const glm::dmat4 hip =
      clip.world[(clip.frame_count() - 1) * clip.joint_count() + joint(clip, "hip")];
  const glm::dvec3 expected[] = {{0, 2, 0}, {-3, 0, 0}, {0, 0, 4}, {1, 2, 3}};
  for (int c = 0; c < 4; ++c) EXPECT_LT(glm::distance(glm::dvec3(hip[c]), expected[c]), 1e-5) << c;
}

TEST(GltfClip, StepsHoldTheirValueUntilTheNextKey) {
  GltfFixture file = strip();
  animate(file, 1, "rotation", "STEP", {0.0f, 0.05f}, joined({about_z(0), about_z(90)}));
  animate(file, 0, "translation", "LINEAR", {0.0f, 0.025f, 0.05f}, {0, 0, 0, 1, 0, 0, 2, 0, 0});
  const Clip clip = read_clip_of(file);
  ASSERT_EQ(clip.frame_count(), 3u);
  EXPECT_NEAR(angle(clip, 1, "chest"), 0.0, 1e-6);
  EXPECT_NEAR(angle(clip, 2, "chest"), 90.0, 1e-5);
}

TEST(GltfClip, APauseInWhichEverythingHoldsNeedsNoFrames) {
  GltfFixture file = strip();
  animate(file, 1, "rotation", "STEP", {0.0f, 3.0f}, joined({about_z(0), about_z(90)}));
  animate(file, 0, "translation", "LINEAR", {0.0f, 3.0f}, {1, 0, 0, 1, 0, 0});
  EXPECT_EQ(read_clip_of(file).frame_count(), 2u);
}

TEST(GltfClip, CubicsAreHermiteCurvesOfTheirTangents) {
  GltfFixture file = strip();
  // From 0 to 1 over a second with tangents 2 and 0: p(1/2) = 1/8 of the first tangent + 1/2.
  animate(file, 0, "translation", "CUBICSPLINE", {0.0f, 1.0f},
          {0, 0, 0, /*value*/ 0, 0, 0, /*out*/ 2, 0, 0, /*in*/ 0, 0, 0, 1, 0, 0, 0, 0, 0});
  const Clip clip = read_clip_of(file);
  ASSERT_EQ(clip.frame_count(), 31u);  // a second of 1/30
  const std::size_t half = 15;
  EXPECT_NEAR(clip.world[half * clip.joint_count() + joint(clip, "hip")][3][0], 0.75,
              kFloatTolerance);
}

TEST(GltfClip, KeysNearerThanAnyPlayerShowsAreOneFrameTheLaterOne) {
  GltfFixture file = strip();
  animate(file, 1, "rotation", "LINEAR", {0.0f, 0.05f, 0.0501f, 0.1f},
          joined({about_z(0), about_z(0), about_z(90), about_z(90)}));
  const Clip clip = read_clip_of(file);
  ASSERT_EQ(clip.frame_count(), 3u);
  EXPECT_NEAR(angle(clip, 1, "chest"), 90.0, 1e-5);
}

TEST(GltfClip, EveryAnimationIsASweepOfItsOwnUnlessOneIsNamed) {
  GltfFixture file = strip();
  animate(file, 1, "rotation", "LINEAR", {0.0f, 0.05f}, joined({about_z(0), about_z(5)}));
  json second = file.root["animations"][0];
  second["name"] = "other";
  file.root["animations"].push_back(second);
  const Clip both = read_clip_of(file);
  ASSERT_EQ(both.sweeps.size(), 2u);
  EXPECT_EQ(both.sweeps[1].first, 2u);
  const TemporaryFolder folder;
  const Clip one = read_clip(file.write_glb(folder), {"other", 24.0});
  ASSERT_EQ(one.sweeps.size(), 1u);
  EXPECT_EQ(one.sweeps[0].name, "other");
  EXPECT_TRUE(one.has_body);
}

TEST(GltfClip, AnimationsOfOneNameAreToldApart) {
  GltfFixture file = strip();
  animate(file, 1, "rotation", "LINEAR", {0.0f, 0.05f}, joined({about_z(0), about_z(5)}));
  file.root["animations"].push_back(file.root["animations"][0]);
  const TemporaryFolder folder;
  EXPECT_EQ(read_clip(file.write_glb(folder), {"act (2)", 24.0}).sweeps.size(), 1u);
}

TEST(GltfClip, AWrongChoiceNamesTheChoices) {
  GltfFixture file = strip();
  animate(file, 1, "rotation", "LINEAR", {0.0f, 0.05f}, joined({about_z(0), about_z(5)}));
  for (int k = 1; k < 10; ++k) file.root["animations"].push_back(file.root["animations"][0]);
  const TemporaryFolder folder;
  try {
    read_clip(file.write_glb(folder), {"walk", 24.0});
    FAIL() << "was read";
  } catch (const CharacterError& error) {
    const std::string told = error.what();
    EXPECT_NE(told.find("no animation 'walk'; it has 'act', 'act (2)'"), std::string::npos) << told;
    EXPECT_NE(told.find("'act (8)' and 2 more"), std::string::npos) << told;
  }
}

struct Broken {
  const char* name;
  std::function<void(json& animation, GltfFixture& file)> spoil;
  const char* place;
  const char* cause;
};

void PrintTo(const Broken& broken, std::ostream* out) { *out << broken.name; }

class BrokenAnimation : public testing::TestWithParam<Broken> {};

TEST_P(BrokenAnimation, IsRefusedWithItsPlaceAndCause) {
  GltfFixture file = strip();
  animate(file, 1, "rotation", "LINEAR", {0.0f, 0.05f}, joined({about_z(0), about_z(5)}));
  GetParam().spoil(file.root["animations"][0], file);
  try {
    read_clip_of(file);
    FAIL() << "was read";
  } catch (const CharacterError& error) {
    const std::string told = error.what();
    EXPECT_NE(told.find(GetParam().place), std::string::npos) << told;
    EXPECT_NE(told.find(GetParam().cause), std::string::npos) << told;
  }
}

INSTANTIATE_TEST_SUITE_P(
    GltfClip, BrokenAnimation,
    testing::Values(
        Broken{"NodeOutOfRange",
               [](json& a, GltfFixture&) { a["channels"][0]["target"]["node"] = 99; },
               "/animations/0/channels/0/target/node", "node 99 does not exist"},
        Broken{"SamplerOutOfRange", [](json& a, GltfFixture&) { a["channels"][0]["sampler"] = 7; },
               "/animations/0/channels/0/sampler", "sampler 7 does not exist"},
        Broken{"AccessorOutOfRange", [](json& a, GltfFixture&) { a["samplers"][0]["input"] = 500; },
               "/animations/0/samplers/0/input", "accessor 500 does not exist"},
        Broken{"UnknownInterpolation",
               [](json& a, GltfFixture&) { a["samplers"][0]["interpolation"] = "BEZIER"; },
               "/animations/0/samplers/0/interpolation", "'BEZIER' is none"},
        Broken{"CubicWithoutTangents",
               [](json& a, GltfFixture&) { a["samplers"][0]["interpolation"] = "CUBICSPLINE"; },
               "/animations/0/samplers/0/output", "2 values for 2 keys, expected 3 each"},
        Broken{"TimesFall",
               [](json& a, GltfFixture& f) {
                 a["samplers"][0]["input"] =
                     f.add(std::vector<float>{1.0f, 0.5f}, kFloat, "SCALAR", 1);
               },
               "/animations/0/samplers/0/input", "key 1 does not lie after"},
        Broken{"TimeNotANumber",
               [](json& a, GltfFixture& f) {
                 a["samplers"][0]["input"] =
                     f.add(std::vector<float>{0.0f, std::numeric_limits<float>::quiet_NaN()},
                           kFloat, "SCALAR", 1);
               },
               "/input", "is not a number"},
        Broken{"RotationOfNoLength",
               [](json& a, GltfFixture& f) {
                 a["samplers"][0]["output"] = f.add(std::vector<float>(8, 0.0f), kFloat, "VEC4", 4);
               },
               "/animations/0/samplers/0/output", "key 0 is not a rotation"},
        Broken{"TooManyKeys",
               [](json& a, GltfFixture& f) {
                 f.root["accessors"][a["samplers"][0]["input"].get<std::size_t>()]["count"] =
                     4000000000u;
                 f.root["accessors"][a["samplers"][0]["output"].get<std::size_t>()]["count"] =
                     4000000000u;
               },
               "/accessors/", "more than"},
        Broken{"NodeWithAMatrix",
               [](json&, GltfFixture& f) {
                 f.root["nodes"][1] = {
                     {"name", "chest"},
                     {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 1}}};
               },
               "/animations/0/channels/0/target/node", "has a matrix"},
        Broken{"GapThatNoMemoryHolds",
               [](json& a, GltfFixture& f) {
                 a["samplers"][0]["input"] =
                     f.add(std::vector<float>{0.0f, 3e38f}, kFloat, "SCALAR", 1);
               },
               "/animations/0", "more than are read"},
        Broken{"NothingAnimated",
               [](json& a, GltfFixture&) { a["channels"][0]["target"]["path"] = "weights"; },
               "/animations", "no animation that moves a joint"}),
    [](const auto& each) { return std::string(each.param.name); });

// backbend.clip/1 ------------------------------------------------------------------------------

std::vector<float> identity(float x = 0, float y = 0, float z = 0) {
  return {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1};
}

json clip_header() {
  return {{"schema", "backbend.clip/1"},
          {"joints", {{{"name", "hips"}, {"parent", -1}}, {{"name", "chest"}, {"parent", 0}}}},
          {"poses", {{{"time", 0.0}}, {{"time", 0.5}}}}};
}

std::vector<std::uint8_t> encoded(const json& head, const std::vector<float>& numbers) {
  const std::string text = head.dump() + "\n";
  std::vector<std::uint8_t> out(text.begin(), text.end());
  out.resize(text.size() + 4 * numbers.size());
  std::memcpy(out.data() + text.size(), numbers.data(), 4 * numbers.size());
  return out;
}

std::vector<float> four_matrices() {
  return joined({identity(), identity(0, 1, 0), identity(2, 0, 0), identity(2, 3, 4)});
}

TEST(BackbendClip, HoldsAMatrixForEveryJointOfEveryPose) {
  const Clip clip = parse_backbend_clip("a.clip", encoded(clip_header(), four_matrices()));
  ASSERT_EQ(clip.frame_count(), 2u);
  EXPECT_EQ(clip.joint, (std::vector<std::string>{"hips", "chest"}));
  EXPECT_EQ(glm::dvec3(clip.world[3][3]), glm::dvec3(2, 3, 4));
  EXPECT_EQ(clip.time[1], 0.5);
}

TEST(BackbendClip, UnitsAndAxesBecomeMetresAndYUp) {
  json head = clip_header();
  head["up"] = "Z";
  head["metres_per_unit"] = 0.01;
  head["points"] = 1;
  std::vector<float> numbers = four_matrices();
  numbers.insert(numbers.end(), {0, 0, 100, 0, -100, 0});
  const Clip clip = parse_backbend_clip("a.clip", encoded(head, numbers));
  // (2, 3, 4) with Z up is 4 high and 3 towards the back, which is -Z.
  EXPECT_NEAR(glm::distance(glm::dvec3(clip.world[3][3]), glm::dvec3(0.02, 0.04, -0.03)), 0.0,
              1e-15);
  EXPECT_EQ(clip.point[0], glm::vec3(0, 1, 0));
  EXPECT_EQ(clip.point[1], glm::vec3(0, 0, 1));
}

TEST(BackbendClip, PosesCarryTheirSweepAndControls) {
  json head = clip_header();
  head["poses"] = {{{"sweep", "twist"}, {"controls", {{"twist", -2.0}}}},
                   {{"sweep", "side"}, {"controls", {{"side", 4.0}}}}};
  const Clip clip = parse_backbend_clip("a.clip", encoded(head, four_matrices()));
  ASSERT_EQ(clip.sweeps.size(), 2u);
  EXPECT_EQ(clip.sweeps[1].name, "side");
  ASSERT_EQ(clip.control, (std::vector<std::string>{"twist", "side"}));
  EXPECT_EQ(clip.control_value[0], -2.0);
  EXPECT_TRUE(std::isnan(clip.control_value[1]));
  EXPECT_EQ(clip.control_value[3], 4.0);
}

TEST(BackbendClip, RefusesWhatItCannotUse) {
  const auto refused = [](const std::function<void(json&)>& spoil, const std::string& words) {
    json head = clip_header();
    spoil(head);
    try {
      parse_backbend_clip("a.clip", encoded(head, four_matrices()));
      ADD_FAILURE() << "was read: " << words;
    } catch (const CharacterError& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  };
  refused([](json& h) { h["schema"] = "backbend.clip/9"; }, "/schema: 'backbend.clip/9'");
  refused([](json& h) { h["up"] = "X"; }, "/up: 'X'");
  refused([](json& h) { h["metres_per_unit"] = 0; }, "/metres_per_unit: not above 0");
  refused([](json& h) { h["joints"][1]["parent"] = 7; }, "/joints/1/parent");
  refused([](json& h) { h["joints"][1]["parent"] = 1; }, "/joints/1/parent");
  refused([](json& h) { h["joints"][1]["parent"] = "hips"; }, "/joints/1/parent: not a number");
  refused([](json& h) { h["joints"][0].erase("name"); }, "/joints/0/name: missing");
  refused([](json& h) { h["joints"][0]["rest"] = {1, 2}; }, "/joints/0/rest: not 16 numbers");
  refused([](json& h) { h["joints"][0]["rest"] = identity(); }, "1 of 2 have no rest");
  refused([](json& h) { h["poses"] = json::array(); }, "/poses: missing or empty");
  refused([](json& h) { h["poses"][1]["time"] = 0.0; }, "/poses/1/time");
  refused([](json& h) { h["poses"][1]["controls"] = {{"a", "b"}}; }, "/poses/1/controls/a");
  refused([](json& h) { h["points"] = 1e9; }, "/points");
  refused([](json& h) { h["points"] = 67108864; }, "bytes of numbers, expected");
  refused([](json& h) { h["poses"].push_back({{"time", 1.0}}); }, "256 bytes of numbers");
}

TEST(BackbendClip, RefusesNumbersThatAreNone) {
  std::vector<float> numbers = four_matrices();
  numbers[17] = std::numeric_limits<float>::infinity();
  EXPECT_THROW(parse_backbend_clip("a.clip", encoded(clip_header(), numbers)), CharacterError);
}

// Point caches ---------------------------------------------------------------------------------

void put_word(std::vector<std::uint8_t>& out, std::uint32_t word, bool big_endian) {
  for (int k = 0; k < 4; ++k)
    out.push_back(static_cast<std::uint8_t>(word >> (8 * (big_endian ? 3 - k : k))));
}
void put_float(std::vector<std::uint8_t>& out, float value, bool big_endian) {
  std::uint32_t word;
  std::memcpy(&word, &value, 4);
  put_word(out, word, big_endian);
}

std::vector<std::uint8_t> mdd() {
  std::vector<std::uint8_t> out;
  put_word(out, 2, true);  // frames
  put_word(out, 1, true);  // points
  for (const float value : {0.0f, 0.25f, 1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f})
    put_float(out, value, true);
  return out;
}

std::vector<std::uint8_t> pc2() {
  const std::string magic = "POINTCACHE2";
  std::vector<std::uint8_t> out(magic.begin(), magic.end());
  out.push_back(0);
  put_word(out, 1, false);
  put_word(out, 1, false);       // points
  put_float(out, 12.0f, false);  // first frame
  put_float(out, 0.5f, false);   // frames from sample to sample
  put_word(out, 2, false);       // samples
  for (const float value : {1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f}) put_float(out, value, false);
  return out;
}

TEST(PointCache, MddIsBigEndianWithATimeForEachFrame) {
  const Clip clip = parse_mdd("a.mdd", mdd());
  ASSERT_EQ(clip.frame_count(), 2u);
  EXPECT_EQ(clip.time[1], 0.25);
  EXPECT_EQ(clip.point[1], glm::vec3(4, 5, 6));
}

TEST(PointCache, Pc2CountsFrames) {
  const Clip clip = parse_pc2("a.pc2", pc2(), 24.0);
  ASSERT_EQ(clip.frame_count(), 2u);
  EXPECT_EQ(clip.time[0], 0.5);
  EXPECT_NEAR(clip.time[1] - clip.time[0], 0.5 / 24.0, 1e-15);
  EXPECT_EQ(clip.point[1], glm::vec3(4, 5, 6));
}

/// 2^62 + 41708 points of 12 bytes: as many bytes, in 64 bits, as there are.
TEST(PointCache, Pc2IsNotDeceivedByASizeThatOverflows) {
  std::vector<std::uint8_t> file = pc2();
  file.resize(16);
  put_word(file, 2147437308u, false);  // points
  put_float(file, 0.0f, false);
  put_float(file, 1.0f, false);
  put_word(file, 2147529989u, false);  // samples
  file.resize(32 + 12 * 41708);
  try {
    parse_pc2("a.pc2", file, 24.0);
    FAIL();
  } catch (const CharacterError& error) {
    EXPECT_EQ(std::string(error.what()),
              "a.pc2: header: 2147529989 frames of 2147437308 points do not fit a file of 500528 "
              "bytes");
  }
}

/// Three frames of four points, coordinate k being 0.5 k - 3, one of them another value.
std::vector<std::uint8_t> cache(bool is_mdd, std::size_t other = 99, float value = 0.0f,
                                std::vector<float> time = {0.5f, 0.75f, 2.0f}) {
  std::vector<std::uint8_t> out;
  if (is_mdd) {
    put_word(out, 3, true);
    put_word(out, 4, true);
    for (const float t : time) put_float(out, t, true);
  } else {
    const std::string magic = "POINTCACHE2";
    out.assign(magic.begin(), magic.end());
    out.push_back(0);
    put_word(out, 1, false);
    put_word(out, 4, false);
    put_float(out, time[0], false);
    put_float(out, time[1], false);
    put_word(out, 3, false);
  }
  for (std::size_t k = 0; k < 36; ++k)
    put_float(out, k == other ? value : 0.5f * static_cast<float>(k) - 3.0f, is_mdd);
  return out;
}

TEST(PointCache, HoldsEveryPointOfEveryFrame) {
  for (const bool is_mdd : {true, false}) {
    const Clip clip =
        is_mdd ? parse_mdd("a.mdd", cache(true)) : parse_pc2("a.pc2", cache(false), 25.0);
    const double time[][3] = {{0.5 / 25.0, 1.25 / 25.0, 2.0 / 25.0}, {0.5, 0.75, 2.0}};
    ASSERT_EQ(clip.frame_count(), 3u);
    for (std::size_t f = 0; f < 3; ++f) EXPECT_DOUBLE_EQ(clip.time[f], time[is_mdd][f]);
    ASSERT_EQ(clip.point_count, 4u);
    ASSERT_EQ(clip.point.size(), 12u);
    for (std::size_t p = 0; p < 12; ++p)
      for (int axis = 0; axis < 3; ++axis)
        EXPECT_EQ(clip.point[p][axis], 0.5f * static_cast<float>(3 * p) + 0.5f * axis - 3.0f);
    ASSERT_EQ(clip.sweeps.size(), 1u);
    EXPECT_EQ(clip.sweeps[0].first, 0u);
    EXPECT_EQ(clip.sweeps[0].count, 3u);
    EXPECT_EQ(clip.source, is_mdd ? "MDD point cache" : "PC2 point cache");
  }
}

TEST(PointCache, NamesTheFrameAndPointThatIsNoNumberAndTheTimeThatDoesNotRise) {
  const auto told = [](bool is_mdd, const std::vector<std::uint8_t>& bytes) -> std::string {
    try {
      is_mdd ? parse_mdd("a", bytes) : parse_pc2("a", bytes, 24.0);
      return "";
    } catch (const CharacterError& error) {
      return error.what();
    }
  };
  for (const bool is_mdd : {true, false})
    for (std::size_t k = 0; k < 36; ++k) {
      const std::size_t p = k / 3;
      EXPECT_EQ(told(is_mdd, cache(is_mdd, k, std::numeric_limits<float>::infinity())),
                "a: frame " + std::to_string(p / 4) + ", point " + std::to_string(p % 4) +
                    ": not finite");
    }
  for (const float bad : {0.5f, 0.25f, std::numeric_limits<float>::quiet_NaN()})
    EXPECT_EQ(told(true, cache(true, 99, 0.0f, {0.5f, bad, 2.0f})),
              "a: time of frame 1: does not lie after the one before it");
  for (const float bad : {0.0f, -1.0f, std::numeric_limits<float>::infinity()})
    EXPECT_EQ(told(false, cache(false, 99, 0.0f, {0.5f, bad})),
              "a: header: first frame and sampling are not numbers above 0");
  EXPECT_EQ(told(false, cache(false, 99, 0.0f, {std::numeric_limits<float>::quiet_NaN(), 1.0f})),
            "a: header: first frame and sampling are not numbers above 0");
  // A step that is lost beside its first frame.
  EXPECT_EQ(told(false, cache(false, 99, 0.0f, {1e30f, 1.0f})),
            "a: time of frame 1: does not lie after the one before it");
  std::vector<std::uint8_t> version = cache(false);
  version[12] = 2;
  EXPECT_EQ(told(false, version), "a: header: version 2, expected 1");
  version = cache(false);
  version[3] = 'x';
  EXPECT_EQ(told(false, version), "a: header: cut short");
}

TEST(PointCache, EveryCutAndEveryLieOfItsCountsIsRefused) {
  for (const bool is_mdd : {true, false}) {
    const std::vector<std::uint8_t> whole = is_mdd ? mdd() : pc2();
    const auto parse = [&](const std::vector<std::uint8_t>& bytes) {
      if (is_mdd)
        parse_mdd("a", bytes);
      else
        parse_pc2("a", bytes, 24.0);
    };
    EXPECT_NO_THROW(parse(whole));
    for (std::size_t size = 0; size < whole.size(); ++size)
      EXPECT_THROW(parse({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)}),
                   CharacterError)
          << size;
    for (const std::size_t count_at :
         is_mdd ? std::vector<std::size_t>{0, 4} : std::vector<std::size_t>{16, 28})
      for (const std::uint8_t byte : {0x00, 0x7F, 0xFF}) {
        std::vector<std::uint8_t> lie = whole;
        std::fill(lie.begin() + static_cast<std::ptrdiff_t>(count_at),
                  lie.begin() + static_cast<std::ptrdiff_t>(count_at) + 4, byte);
        EXPECT_THROW(parse(lie), CharacterError) << count_at;
      }
  }
}

TEST(Clip, AnyByteOfAnyFormMayBeWrongWithoutHarm) {
  std::mt19937 rng(3);
  GltfFixture gltf = strip();
  animate(gltf, 1, "rotation", "LINEAR", {0.0f, 0.05f}, joined({about_z(0), about_z(5)}));
  const TemporaryFolder folder;
  const std::vector<std::pair<std::string, std::vector<std::uint8_t>>> forms = {
      {"a.glb", gltf.glb()},
      {"a.clip", encoded(clip_header(), four_matrices())},
      {"a.mdd", mdd()},
      {"a.pc2", pc2()}};
  for (const auto& [name, whole] : forms)
    for (int i = 0; i < 60; ++i) {
      std::vector<std::uint8_t> bytes = whole;
      for (int k = 0; k < 3; ++k)
        bytes[rng() % bytes.size()] = static_cast<std::uint8_t>(rng() & 0xFF);
      write_file(folder / name, bytes);
      try {
        const Clip clip = read_clip(folder / name);
        EXPECT_EQ(clip.world.size(), clip.frame_count() * clip.joint_count());
        EXPECT_EQ(clip.point.size(), clip.frame_count() * clip.point_count);
      } catch (const CharacterError& error) {
        EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
      }
    }
}

}  // namespace
}  // namespace backbend::skin
