#include "validate/evidence/page_mesh.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <optional>

#include "tests/validate/report_sample.h"
#include "validate/report/html.h"

namespace backbend::validate {
namespace {

constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();
constexpr std::size_t kHead = 32, kPalette = 768;

std::uint32_t integer(const std::vector<std::uint8_t>& bytes, std::size_t at, int size) {
  std::uint32_t value = 0;
  for (int i = size - 1; i >= 0; --i) value = value << 8 | bytes[at + static_cast<std::size_t>(i)];
  return value;
}
float real(const std::vector<std::uint8_t>& bytes, std::size_t at) {
  return std::bit_cast<float>(integer(bytes, at, 4));
}

TEST(PageMesh, KeepsPositionsToHalfAStepOfTheirBox) {
  const std::vector<glm::vec3> position{{-1, 0, 0.25f}, {0.3f, 1.7f, 0.25f}, {1, 2, 0.25f}};
  const auto bytes = encode_mesh_pose(position, {}, 0, 1);
  ASSERT_EQ(bytes.size(), kHead + kPalette + 20 + 4);  // 3 x 6 and 3 bytes, each padded to 4
  EXPECT_EQ(integer(bytes, 4, 4), 3u);
  for (std::size_t v = 0; v < 3; ++v)
    for (int k = 0; k < 3; ++k) {
      const auto axis = static_cast<std::size_t>(k);
      const float low = real(bytes, 8 + 4 * axis), size = real(bytes, 20 + 4 * axis);
      const std::uint32_t step = integer(bytes, kHead + kPalette + 6 * v + 2 * axis, 2);
      // Half a step, and the rounding of the two float operations.
      EXPECT_NEAR(low + size * static_cast<float>(step) / 65535.0f, position[v][k],
                  size / 65535.0f / 2 + 1e-6f);
    }
}

TEST(PageMesh, GivesWhatWasNotMeasuredItsOwnColour) {
  const std::vector<glm::vec3> position(5, glm::vec3(0));
  const std::vector<float> heat{0, 2.5f, 5, 99, kNotANumber};
  const auto bytes = encode_mesh_pose(position, heat, 0, 5);
  const std::size_t at = kHead + kPalette + 32;  // 5 x 6 bytes, padded
  EXPECT_EQ(bytes[at + 0], 1);
  EXPECT_EQ(bytes[at + 1], 128);  // half of 254 steps, after the first
  EXPECT_EQ(bytes[at + 2], 255);
  EXPECT_EQ(bytes[at + 3], 255);
  EXPECT_EQ(bytes[at + 4], 0);
  // Without heat, or on a scale without length, nothing is measured.
  EXPECT_EQ(encode_mesh_pose(position, {}, 0, 5)[at], 0);
  EXPECT_EQ(encode_mesh_pose(position, heat, 5, 5)[at], 0);
  // Colour 0 is none of the scale's colours.
  for (std::size_t i = 1; i < 256; ++i)
    EXPECT_FALSE(std::equal(bytes.begin() + kHead, bytes.begin() + kHead + 3,
                            bytes.begin() + static_cast<std::ptrdiff_t>(kHead + 3 * i)));
}

TEST(PageMesh, SurvivesPositionsThatAreNotNumbers) {
  const std::vector<glm::vec3> position{{0, 0, 0}, {kNotANumber, 1, 1}, {1, 1, 1}};
  const auto bytes = encode_mesh_pose(position, {}, 0, 1);
  EXPECT_EQ(real(bytes, 20), 1.0f);
  EXPECT_EQ(integer(bytes, kHead + kPalette + 6, 2), 0u);
  EXPECT_EQ(integer(bytes, kHead + kPalette + 12, 2), 65535u);
  EXPECT_EQ(encode_mesh_pose({}, {}, 0, 1).size(), kHead + kPalette);
}

TEST(PageMesh, WritesIndicesInTwoBytesWhereTheyFit) {
  const std::vector<glm::uvec3> triangle{{0, 1, 65535}};
  const auto narrow = encode_mesh_triangles(triangle, 65536);
  EXPECT_EQ(narrow.size(), 12u + 8);  // 6 bytes, padded
  EXPECT_EQ(integer(narrow, 8, 4), 1u);
  EXPECT_EQ(integer(narrow, 16, 2), 65535u);
  const auto wide = encode_mesh_triangles(triangle, 65537);
  EXPECT_EQ(wide.size(), 12u + 12);
  EXPECT_EQ(integer(wide, 20, 4), 65535u);
}

TEST(PageMesh, TravelsInsideThePageOfBothForms) {
  const Report report = sample_report();
  const auto bytes = [](const std::string& path) { return std::optional(sample_mesh(path)); };
  const std::string with = render_html(report, bytes).at("index.html");
  EXPECT_NE(with.find("\"meshes/human.triangles\":\"data:application/octet-stream;base64,QkJUMQ"),
            std::string::npos)
      << "QkJUMQ is BBT1";
  EXPECT_EQ(with.find("data:image"), std::string::npos);
  EXPECT_EQ(render_html(report).at("index.html").find("base64,QkJ"), std::string::npos);
}

}  // namespace
}  // namespace backbend::validate
