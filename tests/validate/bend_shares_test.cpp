#include "validate/clips/bend_shares.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "validate/metrics/rotation.h"

namespace backbend::validate {
namespace {

constexpr std::size_t kJoints = 5, kFrames = 61;

/// A backbend of two degrees a frame, shared by five joints; `uneven` gives the upper ones more.
std::vector<glm::dvec3> sweep(double uneven = 0.0) {
  std::vector<glm::dvec3> out;
  for (std::size_t f = 0; f < kFrames; ++f)
    for (std::size_t k = 0; k < kJoints; ++k)
      out.emplace_back(radians_from(-0.4 * static_cast<double>(f) *
                                    (1.0 + uneven * (static_cast<double>(k) - 2.0))),
                       0.0, 0.0);
  return out;
}

ShareExcess worst(const std::vector<glm::dvec3>& turn, bool from_rest = true) {
  const std::vector<ShareExcess> all = share_excess(turn, kJoints, from_rest);
  return *std::max_element(all.begin(), all.end(), [](const ShareExcess& a, const ShareExcess& b) {
    return a.deg - a.limit_deg < b.deg - b.limit_deg;
  });
}

TEST(ShareExcess, NoRigIsBlamedForAnUnevenBend) {
  for (const double uneven : {0.0, 0.1, 0.25, 0.4}) EXPECT_LT(worst(sweep(uneven)).deg, 1e-6);
}

TEST(ShareExcess, AKinkIsFoundAtItsJointByItsSizeWhereverItBegins) {
  for (const double size_deg : {10.0, 30.0})
    for (const std::size_t from : {0u, 35u, 50u})
      for (const glm::dvec3& axis : {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0)}) {
        std::vector<glm::dvec3> turn = sweep();
        for (std::size_t f = from; f < kFrames; ++f)
          turn[f * kJoints + 3] = rotation_vector(rotation(turn[f * kJoints + 3]) *
                                                  rotation(axis * radians_from(size_deg)));
        const ShareExcess found = worst(turn);
        EXPECT_EQ(found.joint, 3) << size_deg << " from " << from;
        EXPECT_NEAR(found.deg, size_deg, 0.02 * size_deg) << from;
        EXPECT_GT(found.deg, found.limit_deg);
        EXPECT_GT(glm::dot(glm::normalize(found.turn), axis),
                  0.9);  // the bend turns it by up to 24 deg
      }
}

TEST(ShareExcess, PostureThatIsHeldIsNoKinkOfCapturedMotion) {
  std::vector<glm::dvec3> turn = sweep();
  for (std::size_t f = 0; f < kFrames; ++f) turn[f * kJoints + 3].x += radians_from(20.0);
  EXPECT_LT(worst(turn, false).deg, 1e-6);
}

TEST(ShareExcess, JointsThatKeepNoSharesRaiseTheLimit) {
  std::vector<glm::dvec3> turn = sweep();
  for (std::size_t f = 0; f < kFrames; ++f)
    turn[f * kJoints + 1].x += radians_from(10.0 * std::sin(0.3 * static_cast<double>(f)));
  const ShareExcess found = worst(turn);
  EXPECT_LT(found.deg, found.limit_deg);
}

TEST(ShareExcess, TwoJointsAndFourFramesTellNothing) {
  EXPECT_EQ(share_excess(std::vector<glm::dvec3>(20), 2, true).front().deg, 0.0);
  EXPECT_EQ(share_excess(std::vector<glm::dvec3>(20), 5, true).front().deg, 0.0);
}

}  // namespace
}  // namespace backbend::validate
