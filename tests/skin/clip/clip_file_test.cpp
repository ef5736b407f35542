// Every member of a backbend.clip/1 header comes out where it belongs, in metres and +Y up.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "skin/clip/clip.h"
#include "tests/skin/gltf_fixture.h"

namespace backbend::skin {
namespace {

using nlohmann::json;

constexpr std::size_t kJoints = 3, kFrames = 5, kPoints = 2;

/// An affine matrix of uneven numbers that binary fractions hold.
std::vector<double> numbers_of(std::size_t seed) {
  std::vector<double> out;
  for (std::size_t k = 0; k < 16; ++k)
    out.push_back(k % 4 == 3 ? (k == 15 ? 1.0 : 0.0)
                             : 0.125 * static_cast<double>((seed * 7 + k * k * 3 + k) % 37) - 2.0 +
                                   (k % 5 == 0 ? 8.0 : 0.0));
  return out;
}
glm::dmat4 matrix_of(const std::vector<double>& numbers) {
  glm::dmat4 out;
  for (int k = 0; k < 16; ++k) out[k / 4][k % 4] = numbers[static_cast<std::size_t>(k)];
  return out;
}
glm::dvec3 point_of(std::size_t p) {
  const double x = static_cast<double>(p);
  return {0.5 * x + 1.0, 2.0 - 0.25 * x, 3.0 + x};
}

json header() {
  json joints = json::array();
  for (std::size_t j = 0; j < kJoints; ++j)
    joints.push_back({{"name", "joint" + std::to_string(j)},
                      {"parent", j == 0   ? -1
                                 : j == 1 ? 2
                                          : 0},
                      {"rest", numbers_of(100 + j)}});
  return {{"schema", "backbend.clip/1"},
          {"frames_per_second", 30},
          {"joints", joints},
          {"points", kPoints},
          {"spine", {"joint0", "joint2"}},
          {"arms", {{"left", {"joint1"}}, {"right", {"joint2", "joint1"}}}},
          {"source", {{"program", "Blender 4"}, {"file", "hero.blend"}}},
          {"poses",
           {{{"sweep", "bend"}, {"controls", {{"b", 1.5}, {"a", -2.0}}}},
            {{"sweep", "bend"}, {"controls", {{"c", 4.0}}}},
            {{"sweep", "twist"}, {"time", 0.01}, {"controls", {{"a", 8.0}}}},
            {{"time", 0.02}},
            {{"time", 0.03125}}}}};
}

std::vector<std::uint8_t> encoded(const json& head) {
  std::vector<float> numbers;
  for (std::size_t m = 0; m < kFrames * kJoints; ++m)
    for (const double n : numbers_of(m)) numbers.push_back(static_cast<float>(n));
  for (std::size_t p = 0; p < kFrames * kPoints; ++p)
    for (int axis = 0; axis < 3; ++axis) numbers.push_back(static_cast<float>(point_of(p)[axis]));
  const std::string text = head.dump() + "\n";
  std::vector<std::uint8_t> out(text.begin(), text.end());
  out.resize(text.size() + 4 * numbers.size());
  std::memcpy(out.data() + text.size(), numbers.data(), 4 * numbers.size());
  return out;
}

TEST(BackbendClip, BringsEveryMemberToItsPlace) {
  for (const bool z_up : {false, true}) {
    json head = header();
    if (z_up) head["up"] = "Z";
    const double unit = z_up ? 0.25 : 1.0;
    if (z_up) head["metres_per_unit"] = unit;
    const Clip clip = parse_backbend_clip("a.clip", encoded(head));
    const auto turned = [&](const glm::dvec3& v) { return z_up ? glm::dvec3(v.x, v.z, -v.y) : v; };
    const auto expect_matrix = [&](const glm::dmat4& read, std::size_t seed) {
      const glm::dmat4 wrote = matrix_of(numbers_of(seed));
      for (int c = 0; c < 4; ++c) {
        EXPECT_EQ(glm::dvec3(read[c]), (c == 3 ? unit : 1.0) * turned(glm::dvec3(wrote[c])));
        EXPECT_EQ(read[c][3], c == 3 ? 1.0 : 0.0);
      }
    };
    EXPECT_TRUE(clip.in_metres);
    ASSERT_EQ(clip.joint, (std::vector<std::string>{"joint0", "joint1", "joint2"}));
    EXPECT_EQ(clip.parent, (std::vector<int>{-1, 2, 0}));
    ASSERT_EQ(clip.rest.size(), kJoints);
    for (std::size_t j = 0; j < kJoints; ++j) expect_matrix(clip.rest[j], 100 + j);
    ASSERT_EQ(clip.world.size(), kFrames * kJoints);
    for (std::size_t m = 0; m < clip.world.size(); ++m) expect_matrix(clip.world[m], m);
    ASSERT_EQ(clip.point_count, kPoints);
    ASSERT_EQ(clip.point.size(), kFrames * kPoints);
    for (std::size_t p = 0; p < clip.point.size(); ++p)
      EXPECT_EQ(glm::dvec3(clip.point[p]), unit * turned(point_of(p)));
    EXPECT_EQ(clip.spine, (std::vector<std::string>{"joint0", "joint2"}));
    EXPECT_EQ(clip.left_arm, std::vector<std::string>{"joint1"});
    EXPECT_EQ(clip.right_arm, (std::vector<std::string>{"joint2", "joint1"}));
    EXPECT_EQ(clip.source, "Blender 4, hero.blend");
    const double time[] = {0.0, 1.0 / 30.0, 0.01, 0.02, 0.03125};
    ASSERT_EQ(clip.time.size(), kFrames);
    for (std::size_t f = 0; f < kFrames; ++f) EXPECT_DOUBLE_EQ(clip.time[f], time[f]);
    const struct {
      const char* name;
      std::size_t first, count;
    } sweeps[] = {{"bend", 0, 2}, {"twist", 2, 1}, {"clip", 3, 2}};
    ASSERT_EQ(clip.sweeps.size(), std::size(sweeps));
    for (std::size_t s = 0; s < 3; ++s) {
      EXPECT_EQ(clip.sweeps[s].name, sweeps[s].name);
      EXPECT_EQ(clip.sweeps[s].first, sweeps[s].first);
      EXPECT_EQ(clip.sweeps[s].count, sweeps[s].count);
    }
    ASSERT_EQ(clip.control, (std::vector<std::string>{"a", "b", "c"}));
    const double none = std::nan("");
    const double value[] = {-2.0, 1.5,  none, none, none, 4.0,  8.0, none,
                            none, none, none, none, none, none, none};
    ASSERT_EQ(clip.control_value.size(), std::size(value));
    for (std::size_t k = 0; k < std::size(value); ++k) {
      EXPECT_EQ(std::isnan(clip.control_value[k]), std::isnan(value[k])) << k;
      if (!std::isnan(value[k])) {
        EXPECT_EQ(clip.control_value[k], value[k]) << k;
      }
    }
  }
}

TEST(BackbendClip, OfOneSweepHoldsItsFramesAndNoOther) {
  const TemporaryFolder folder;
  write_file(folder / "a.clip", encoded(header()));
  const Clip all = read_clip(folder / "a.clip");
  EXPECT_EQ(all.name, "a");
  EXPECT_EQ(all.file_name, "a.clip");
  EXPECT_NE(all.content_hash_low, 0u);
  EXPECT_NE(all.content_hash_low, all.content_hash_high);
  for (const ClipSweep& sweep : all.sweeps) {
    const Clip one = read_clip(folder / "a.clip", {sweep.name, 24.0});
    ASSERT_EQ(one.sweeps.size(), 1u);
    EXPECT_EQ(one.sweeps[0].name, sweep.name);
    EXPECT_EQ(one.sweeps[0].first, 0u);
    EXPECT_EQ(one.sweeps[0].count, sweep.count);
    ASSERT_EQ(one.time.size(), sweep.count);
    ASSERT_EQ(one.world.size(), sweep.count * kJoints);
    ASSERT_EQ(one.point.size(), sweep.count * kPoints);
    ASSERT_EQ(one.control_value.size(), sweep.count * 3);
    for (std::size_t f = 0; f < sweep.count; ++f) {
      const std::size_t from = sweep.first + f;
      EXPECT_EQ(one.time[f], all.time[from]);
      for (std::size_t j = 0; j < kJoints; ++j)
        EXPECT_EQ(one.world[f * kJoints + j], all.world[from * kJoints + j]);
      for (std::size_t p = 0; p < kPoints; ++p)
        EXPECT_EQ(one.point[f * kPoints + p], all.point[from * kPoints + p]);
      for (std::size_t c = 0; c < 3; ++c) {
        const double here = one.control_value[3 * f + c], there = all.control_value[3 * from + c];
        EXPECT_TRUE(here == there || (std::isnan(here) && std::isnan(there)));
      }
    }
  }
  EXPECT_THROW(read_clip(folder / "a.clip", {"walk", 24.0}), CharacterError);
}

TEST(BackbendClip, IsReadWithAsLittleAsItsHeaderSays) {
  json head = header();
  for (const char* key : {"joints", "spine", "arms", "frames_per_second"}) head.erase(key);
  head["source"].erase("program");
  std::vector<std::uint8_t> bytes = encoded(head);
  // Points alone: the matrices' numbers are not there.
  const std::size_t text = head.dump().size() + 1;
  bytes.erase(bytes.begin() + static_cast<long>(text),
              bytes.begin() + static_cast<long>(text + 4 * 16 * kFrames * kJoints));
  const Clip clip = parse_backbend_clip("a.clip", bytes);
  EXPECT_EQ(clip.joint_count(), 0u);
  EXPECT_EQ(clip.source, "hero.blend");
  EXPECT_DOUBLE_EQ(clip.time[1], 1.0 / 24.0);
  for (std::size_t p = 0; p < clip.point.size(); ++p)
    EXPECT_EQ(glm::dvec3(clip.point[p]), point_of(p));
  bytes.push_back(0);
  EXPECT_THROW(parse_backbend_clip("a.clip", bytes), CharacterError);
}

TEST(BackbendClip, RefusesEveryMemberThatIsNoneNamingIt) {
  const auto refused = [](const std::function<void(json&)>& spoil, const std::string& words) {
    json head = header();
    spoil(head);
    try {
      parse_backbend_clip("a.clip", encoded(head));
      ADD_FAILURE() << "was read: " << words;
    } catch (const CharacterError& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  };
  refused([](json& h) { h["frames_per_second"] = 0; }, "/frames_per_second: not above 0");
  refused([](json& h) { h["frames_per_second"] = "24"; }, "/frames_per_second: not a number");
  refused([](json& h) { h["metres_per_unit"] = -1; }, "/metres_per_unit: not above 0");
  refused([](json& h) { h["joints"][1]["parent"] = -2; }, "/joints/1/parent: no joint");
  refused([](json& h) { h["joints"][1]["parent"] = 0.5; }, "/joints/1/parent: no joint");
  refused([](json& h) { h["joints"][1]["parent"] = 3; }, "/joints/1/parent: no joint");
  refused([](json& h) { h["joints"][2]["name"] = ""; }, "/joints/2/name: missing");
  refused([](json& h) { h["joints"][2].erase("rest"); }, "/joints: 1 of 3 have no rest");
  refused([](json& h) { h["joints"][2]["rest"] = std::vector<double>(16, 0.0); },
          "/joints/2/rest: cannot be inverted");
  refused([](json& h) { h["joints"][2]["rest"][5] = "x"; }, "/joints/2/rest: not a finite");
  refused([](json& h) { h["joints"][2]["rest"].push_back(0); }, "/joints/2/rest: not 16");
  refused([](json& h) { h["joints"][0] = 4; }, "/joints/0: not an object");
  refused([](json& h) { h["points"] = -1; }, "/points: no count");
  refused([](json& h) { h["points"] = 1.5; }, "/points: no count");
  refused([](json& h) { h["points"] = 67108865; }, "/points: no count");
  refused([](json& h) { h["points"] = kPoints + 1; },
          "bytes of numbers, expected 1140 for 5 poses");
  refused([](json& h) { h["spine"] = "joint0"; }, "/spine: not a list");
  refused([](json& h) { h["spine"][1] = 7; }, "/spine/1: not a text");
  refused([](json& h) { h["arms"] = json::array(); }, "/arms: not an object");
  refused([](json& h) { h["source"] = "Maya"; }, "/source: not an object");
  refused([](json& h) { h["poses"][4]["time"] = 0.02; }, "/poses/4/time: does not lie after");
  refused([](json& h) { h["poses"][1]["sweep"] = 3; }, "/poses/1/sweep: not a text");
  refused([](json& h) { h.erase("joints"), h.erase("points"); }, "neither joints nor points");
  refused(
      [](json& h) {
        for (int k = 0; k < 254; ++k) h["poses"][3]["controls"]["k" + std::to_string(k)] = k;
      },
      "/poses/3/controls: more than 256 in all");
  json head = header();
  for (int k = 0; k < 253; ++k) head["poses"][3]["controls"]["k" + std::to_string(k)] = k;
  EXPECT_EQ(parse_backbend_clip("a.clip", encoded(head)).control.size(), 256u);
}

}  // namespace
}  // namespace backbend::skin
