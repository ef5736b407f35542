// A glTF animation of every kind of track on a chain of turned and scaled nodes, against the
// specification's formulas written another way; and which parts of it are judged.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

#include "skin/clip/clip.h"
#include "tests/skin/gltf_fixture.h"

namespace backbend::skin {
namespace {

using nlohmann::json;

struct Track {
  int node;
  std::string path, interpolation;
  std::vector<float> time, value;

  std::size_t width() const { return path == "rotation" ? 4 : 3; }
  glm::dvec4 at(std::size_t number) const {
    glm::dvec4 out(0.0);
    for (std::size_t c = 0; c < width(); ++c)
      out[static_cast<int>(c)] = static_cast<double>(value[number * width() + c]);
    return out;
  }
  /// By de Casteljau's construction for cubics, by the angle between them for rotations.
  glm::dvec4 value_at(double t) const {
    std::size_t k = 0;
    while (k + 1 < time.size() && t >= static_cast<double>(time[k + 1])) ++k;
    const bool cubic = interpolation == "CUBICSPLINE";
    const auto key = [&](std::size_t i) { return at(cubic ? 3 * i + 1 : i); };
    glm::dvec4 out = key(k);
    if (k + 1 < time.size() && t > static_cast<double>(time[k]) && interpolation != "STEP") {
      const double d = static_cast<double>(time[k + 1]) - static_cast<double>(time[k]),
                   u = (t - static_cast<double>(time[k])) / d;
      if (cubic) {
        const glm::dvec4 a = key(k), b = a + d / 3.0 * at(3 * k + 2), e = key(k + 1),
                         c = e - d / 3.0 * at(3 * k + 3);
        const auto mid = [u](const glm::dvec4& p, const glm::dvec4& q) { return p + u * (q - p); };
        out = mid(mid(mid(a, b), mid(b, c)), mid(mid(b, c), mid(c, e)));
      } else if (path != "rotation") {
        out = key(k) + u * (key(k + 1) - key(k));
      } else {
        const glm::dvec4 a = glm::normalize(key(k));
        glm::dvec4 b = glm::normalize(key(k + 1));
        if (glm::dot(a, b) < 0.0) b = -b;
        const double angle = std::acos(std::min(glm::dot(a, b), 1.0));
        out = (std::sin((1.0 - u) * angle) * a + std::sin(u * angle) * b) / std::sin(angle);
      }
    }
    return path == "rotation" ? glm::normalize(out) : out;
  }
};

struct Trs {
  glm::dvec4 translation{0.0}, rotation{0, 0, 0, 1}, scale{1.0};
  glm::dmat4 matrix() const {
    return glm::translate(glm::dmat4(1.0), glm::dvec3(translation)) *
           glm::mat4_cast(glm::dquat(rotation.w, rotation.x, rotation.y, rotation.z)) *
           glm::scale(glm::dmat4(1.0), glm::dvec3(scale));
  }
};

/// The strip's nodes as a chain with rests of their own: top (a matrix), hip, chest, finger.
GltfFixture chain(const std::vector<Track>& tracks, std::vector<Trs>& rest) {
  GltfFixture file = strip();
  rest.assign(5, {});
  rest[0].translation = {0.2, 0.9, -0.1, 0};
  rest[0].rotation = glm::normalize(glm::dvec4(0.1, 0.3, -0.2, 0.9));
  rest[0].scale = {1.1, 0.8, 1.3, 0};
  rest[1].translation = {0.05, 1.0, 0.15, 0};
  rest[1].rotation = glm::normalize(glm::dvec4(-0.4, 0.1, 0.2, 0.8));
  rest[3].translation = {0.3, 0.4, 0.6, 0};
  rest[4].translation = {0.7, -0.2, 0.5, 0};
  rest[4].rotation = glm::normalize(glm::dvec4(0.2, -0.1, 0.5, 0.7));
  rest[4].scale = {1.0, 2.0, 1.0, 0};
  const auto list = [](const glm::dvec4& v, int count) {
    json out = json::array();
    for (int c = 0; c < count; ++c) out.push_back(v[c]);
    return out;
  };
  auto& nodes = file.root["nodes"];
  for (const std::size_t n : {0u, 1u}) {
    nodes[n]["translation"] = list(rest[n].translation, 3);
    nodes[n]["rotation"] = list(rest[n].rotation, 4);
    nodes[n]["scale"] = list(rest[n].scale, 3);
  }
  nodes.push_back({{"name", "finger"}, {"translation", list(rest[3].translation, 3)}});
  nodes[1]["children"] = {3};
  json matrix = json::array();
  const glm::dmat4 top = rest[4].matrix();
  for (int k = 0; k < 16; ++k) matrix.push_back(top[k / 4][k % 4]);
  nodes.push_back({{"name", "top"}, {"matrix", matrix}, {"children", {0}}});
  file.root["scenes"][0]["nodes"] = {4, 2};
  json animation = {{"name", "act"}, {"channels", json::array()}, {"samplers", json::array()}};
  for (const Track& track : tracks) {
    const int input = file.add(track.time, kFloat, "SCALAR", 1);
    const int output =
        file.add(track.value, kFloat, track.width() == 4 ? "VEC4" : "VEC3", track.width());
    animation["samplers"].push_back(
        {{"input", input}, {"output", output}, {"interpolation", track.interpolation}});
    animation["channels"].push_back({{"sampler", animation["samplers"].size() - 1},
                                     {"target", {{"node", track.node}, {"path", track.path}}}});
  }
  file.root["animations"] = json::array({animation});
  return file;
}

Clip read(const GltfFixture& file) {
  const TemporaryFolder folder;
  return read_clip(file.write_glb(folder));
}

const std::vector<Track> kTracks = {
    {0, "translation", "CUBICSPLINE", {0.1f, 0.35f, 0.9f}, {9,     9,    9,    0.2f,  0.9f,
                                                            -0.1f, 1.5f, -2,   0.7f,  //
                                                            -1,    3,    2,    0.6f,  1.4f,
                                                            0.3f,  2.5f, 1,    -3,  //
                                                            0.4f,  -1,   1.2f, -0.2f, 0.8f,
                                                            1.1f,  9,    9,    9}},
    {1,
     "rotation",
     "LINEAR",
     {0.2f, 0.5f, 0.6f},
     {0.1f, 0.2f, -0.3f, 0.9f, -0.5f, 0.3f, 0.2f, -0.7f, 0.0f, -0.4f, 0.1f, 0.8f}},
    {0, "scale", "STEP", {0.15f, 0.4f}, {1.1f, 0.8f, 1.3f, 0.7f, 1.6f, 0.9f}},
    {3, "rotation", "CUBICSPLINE", {0.0f, 0.8f}, {9,    9,    9,  9,    0.1f,  0.1f,
                                                  0.3f, 0.9f, 1,  -2,   0.5f,  0.2f,  //
                                                  0.4f, 1,    -1, 0.6f, -0.2f, 0.5f,
                                                  0.1f, 0.8f, 9,  9,    9,     9}},
    {3, "scale", "LINEAR", {0.25f, 0.7f}, {1.0f, 1.2f, 0.9f, 1.5f, 0.6f, 2.0f}},
    {1, "translation", "LINEAR", {0.3f}, {0.1f, 1.1f, 0.2f}}};

TEST(GltfClip, OfEveryKindOfTrackIsWhatTheSpecificationSaysAtEveryFrame) {
  std::vector<Trs> rest;
  const Clip clip = read(chain(kTracks, rest));
  ASSERT_GT(clip.frame_count(), 20u);
  const std::vector<std::string> names = {"hip", "chest", "body", "finger", "top"};
  const int parent[] = {4, 0, -1, 1, -1};
  for (std::size_t f = 0; f < clip.frame_count(); ++f) {
    std::vector<Trs> local = rest;
    for (const Track& track : kTracks) {
      Trs& to = local[static_cast<std::size_t>(track.node)];
      (track.path == "translation" ? to.translation
       : track.path == "scale"     ? to.scale
                                   : to.rotation) = track.value_at(clip.time[f]);
    }
    for (std::size_t n = 0; n < names.size(); ++n) {
      glm::dmat4 expected = local[n].matrix();
      for (int p = parent[n]; p >= 0; p = parent[p])
        expected = local[static_cast<std::size_t>(p)].matrix() * expected;
      const auto j = static_cast<std::size_t>(
          std::find(clip.joint.begin(), clip.joint.end(), names[n]) - clip.joint.begin());
      ASSERT_LT(j, clip.joint_count());
      const glm::dmat4& read = clip.world[f * clip.joint_count() + j];
      for (int c = 0; c < 4; ++c)
        ASSERT_LT(glm::distance(read[c], expected[c]), 1e-6)
            << names[n] << " at " << clip.time[f] << " column " << c;
    }
  }
  for (std::size_t n = 0; n < names.size(); ++n) {
    const auto j = static_cast<std::size_t>(
        std::find(clip.joint.begin(), clip.joint.end(), names[n]) - clip.joint.begin());
    glm::dmat4 expected = rest[n].matrix();
    for (int p = parent[n]; p >= 0; p = parent[p])
      expected = rest[static_cast<std::size_t>(p)].matrix() * expected;
    EXPECT_EQ(clip.file_node[j], static_cast<int>(n));
    for (int c = 0; c < 4; ++c) EXPECT_LT(glm::distance(clip.rest[j][c], expected[c]), 1e-6);
  }
}

TEST(GltfClip, LooksAtEveryKeyAndAtWhatIsPlayedBetweenThoseFarApart) {
  std::vector<Trs> rest;
  const Clip clip = read(chain(kTracks, rest));
  std::vector<double> expected;
  const double keys[] = {0.0, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9};
  for (const double key : keys) expected.push_back(static_cast<double>(static_cast<float>(key)));
  // All gaps are of a tenth of a second and less, but for rounding: 0.4 .. 0.5 and those behind may
  // be a hair more than that, and are played then, at 30 frames a second.
  std::vector<double> told;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (i > 0 && expected[i] - expected[i - 1] > 0.1)
      for (int k = 1; k < 4; ++k)
        told.push_back(expected[i - 1] + (expected[i] - expected[i - 1]) * k / 4.0);
    told.push_back(expected[i]);
  }
  ASSERT_EQ(clip.time.size(), told.size());
  for (std::size_t f = 0; f < told.size(); ++f) EXPECT_NEAR(clip.time[f], told[f], 1e-12) << f;
}

TEST(GltfClip, PlaysAGapOnlyWhereSomethingMovesInIt) {
  const std::vector<float> time = {0.0f, 0.5f, 1.25f, 1.25f + 0.09f, 1.5f};
  const auto frames = [&](const std::string& interpolation, std::vector<float> value) {
    std::vector<Trs> rest;
    return read(chain({{0, "translation", interpolation, time, std::move(value)}}, rest)).time;
  };
  // It moves in the second gap alone: 0.75 s, which are 23 steps of 1/30 s or less.
  const std::vector<float> once = {1, 2, 3, 1, 2, 3, 1, 2, 4, 1, 2, 4, 1, 2, 4};
  const std::vector<double> played = frames("LINEAR", once);
  ASSERT_EQ(played.size(), 5u + 22u);
  for (std::size_t f = 1; f <= 23; ++f)
    EXPECT_NEAR(played[1 + f] - played[f], 0.75 / 23.0, 1e-9) << f;
  EXPECT_EQ(played[1], 0.5);
  EXPECT_EQ(played.back(), 1.5);
  EXPECT_EQ(frames("STEP", once).size(), 5u);
  // In the first: 15 steps. In the last, 0.16 s: five. In the third, 0.09 s: baked, none.
  EXPECT_EQ(frames("LINEAR", {0, 2, 3, 1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 2, 3}).size(), 5u + 14u);
  EXPECT_EQ(frames("LINEAR", {1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 0, 3}).size(), 5u + 4u);
  EXPECT_EQ(frames("LINEAR", {1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 7, 3, 1, 7, 3}).size(), 5u);
  // A cubic's tangents may move what its values do not: every gap is played.
  std::vector<float> cubic;
  for (int k = 0; k < 5; ++k) cubic.insert(cubic.end(), {0, 0, 0, 1, 2, 3, 0, 0, 0});
  EXPECT_EQ(frames("CUBICSPLINE", cubic).size(), 5u + 14u + 22u + 4u);
}

TEST(GltfClip, PlaysNothingBehindATracksLastKey) {
  std::vector<Trs> rest;
  const std::vector<Track> tracks = {
      {0,
       "translation",
       "CUBICSPLINE",
       {0.0f, 0.05f},
       {0, 0, 0, 1, 2, 3, 1, 1, 1, 1, 1, 1, 4, 5, 6, 0, 0, 0}},
      {1, "translation", "LINEAR", {0.0f, 1.0f}, {1, 2, 3, 1, 2, 3}}};
  EXPECT_EQ(read(chain(tracks, rest)).frame_count(), 3u);
}

TEST(GltfClip, TakesKeysOfSeveralTracksLessThanAMillisecondApartForOne) {
  std::vector<Trs> rest;
  const std::vector<Track> tracks = {
      {0, "translation", "LINEAR", {0.0f, 0.05f, 0.08f}, {0, 0, 0, 1, 0, 0, 2, 0, 0}},
      {1, "translation", "LINEAR", {0.0f, 0.0508f, 0.0815f}, {0, 0, 0, 1, 0, 0, 2, 0, 0}}};
  const Clip clip = read(chain(tracks, rest));
  const double expected[] = {0.0, 0.0508f, 0.08f, 0.0815f};
  ASSERT_EQ(clip.time.size(), std::size(expected));
  for (std::size_t f = 0; f < clip.time.size(); ++f) EXPECT_EQ(clip.time[f], expected[f]);
}

}  // namespace
}  // namespace backbend::skin
