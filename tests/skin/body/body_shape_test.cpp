// Solids whose distance is known in closed form or by trying, alone and melted together.
#include "skin/body/body_shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <random>

#include "tests/skin/half_mesh.h"
#include "tests/source_folder.h"

namespace backbend::skin {
namespace {

double value_of(std::vector<BodySolid> parts, const glm::dvec3& p) {
  const BodyDescription body = body_of(std::move(parts));
  return BodyShape(body).value(p);
}
/// A few hundred places around x = 3, clear of the mirror plane.
std::vector<glm::dvec3> places() {
  std::vector<glm::dvec3> out;
  for (int i = 0; i < 300; ++i)
    out.emplace_back(3.0 + 1.1 * std::sin(1.7 * i), 1.2 * std::sin(2.3 * i + 1.0),
                     1.3 * std::sin(0.9 * i + 2.0));
  return out;
}

TEST(BodyShape, OfABallIsTheDistanceFromItsSkin) {
  const BodyDescription body = body_of({ball({3, 0.1, -0.2}, 0.4)});
  const BodyShape shape(body);
  for (const glm::dvec3& p : places())
    EXPECT_NEAR(shape.value(p), glm::distance(p, glm::dvec3(3, 0.1, -0.2)) - 0.4, 1e-12);
  EXPECT_NEAR(shape.value({3, 0.1, -0.2}), -0.4, 1e-12);
  EXPECT_EQ(shape.low(), glm::dvec3(-3.4, 0.1 - 0.4, -0.2 - 0.4));
  EXPECT_EQ(shape.high(), glm::dvec3(3.4, 0.1 + 0.4, -0.2 + 0.4));
}

TEST(BodyShape, StandsInABoxThatIsTheSameOnBothSides) {
  BodySolid cone, loft;
  cone.shape = BodySolid::Shape::cone;
  cone.axis = {{-0.1, 0.5, 0.2}, {0.1, 0.9, 0.3}};
  cone.radius = {0.3, 0.1};
  EXPECT_EQ(BodyShape(body_of({cone})).low(), glm::dvec3(-0.4, 0.5 - 0.3, 0.2 - 0.3));
  EXPECT_EQ(BodyShape(body_of({cone})).high(), glm::dvec3(0.4, 0.9 + 0.1, 0.2 + 0.3));
  // A loft's holds its corners and its domes, and not much more.
  loft.axis = {{1, 0, 0}, {1, 2, 0}};
  loft.sections = {{0.25, 0.3, 0.1, 0.2, 0.4, 8}, {1.5, 0.2, 0.25, 0.15, 0.1, 8}};
  loft.cap = {0.6, 0.7};
  const BodyDescription body = body_of({loft});
  const BodyShape shape(body);
  EXPECT_LT(shape.low().y, 0.25 - 0.6 + 1e-12);
  EXPECT_GT(shape.low().y, 0.25 - 0.65);
  EXPECT_GT(shape.high().y, 1.5 + 0.7 - 1e-12);
  EXPECT_LT(shape.high().y, 1.5 + 0.75);
  EXPECT_GT(shape.high().x, 1.3);
  EXPECT_LT(shape.high().x, 1.0 + 1.03 * 0.5);
  EXPECT_EQ(shape.low().x, -shape.high().x);
  EXPECT_LT(shape.low().z, -0.4);
  EXPECT_GT(shape.low().z, -1.03 * 0.5);
}

TEST(BodyShape, OfARoundConeIsThatOfAllItsBalls) {
  const struct {
    glm::dvec3 a, b;
    glm::dvec2 radius;
  } cones[] = {{{3, 0, 0}, {3.5, 0.4, -0.3}, {0.3, 0.1}},
               {{3, 0, 0}, {3.5, 0.4, -0.3}, {0.1, 0.3}},
               {{2.7, -0.5, 0.2}, {3.1, 0.6, 0.2}, {0.25, 0.25}}};
  for (const auto& cone : cones) {
    BodySolid part;
    part.shape = BodySolid::Shape::cone;
    part.axis = {cone.a, cone.b};
    part.radius = cone.radius;
    const BodyDescription body = body_of({part});
    const BodyShape shape(body);
    for (const glm::dvec3& p : places()) {
      double nearest = INFINITY;
      for (int k = 0; k <= 2000; ++k) {
        const double t = k / 2000.0;
        nearest = std::min(nearest, glm::distance(p, glm::mix(cone.a, cone.b, t)) -
                                        glm::mix(cone.radius.x, cone.radius.y, t));
      }
      EXPECT_NEAR(shape.value(p), nearest, 1e-6);
    }
  }
}

/// Expects zero on the skin, and beside it the distance along the normal to first order.
void expect_skin(const BodyShape& shape, const glm::dvec3& p, const glm::dvec3& normal) {
  EXPECT_NEAR(shape.value(p), 0.0, 1e-9);
  EXPECT_NEAR(shape.value(p + 1e-4 * normal), 1e-4, 2e-6);
  EXPECT_NEAR(shape.value(p - 1e-4 * normal), -1e-4, 2e-6);
  const glm::dvec3 gradient = shape.gradient(p);
  EXPECT_LT(glm::distance(gradient, normal), 2e-3);
  const glm::dvec3 back = shape.project(p + 0.01 * normal, 0.1);
  EXPECT_NEAR(shape.value(back), 0.0, 1e-7);
  EXPECT_LT(glm::distance(back, p), 0.003);
  EXPECT_NEAR(glm::distance(shape.project(p + 0.01 * normal, 0.004), p + 0.01 * normal), 0.004,
              1e-12);
}

TEST(BodyShape, OfAnEllipsoidIsRightOnItsSkinHoweverItIsTurned) {
  const glm::dvec3 radii(0.3, 0.5, 0.8), center(3, 0.2, 0.1);
  BodySolid part = ball(center, 1.0);
  part.radii = radii;
  part.world_from_ellipsoid = glm::mat3_cast(glm::dquat(glm::dvec3(0.3, -0.7, 1.1)));
  const BodyDescription body = body_of({part});
  const BodyShape shape(body);
  for (int i = 0; i < 40; ++i) {
    const double a = 0.7 * i, z = std::sin(1.3 * i);
    const glm::dvec3 on(std::cos(a) * std::sqrt(1 - z * z), std::sin(a) * std::sqrt(1 - z * z), z);
    expect_skin(shape, center + part.world_from_ellipsoid * (on * radii),
                glm::normalize(part.world_from_ellipsoid * (on / radii)));
  }
}

TEST(BodyShape, OfALoftIsItsSuperellipseBetweenTheEndsAndADomeBeyond) {
  for (const double n : {2.0, 3.0}) {
    BodySolid part;  // along +Y from (3, 0, 0); outwards is +X
    part.axis = {{3, 0, 0}, {3, 1, 0}};
    part.sections = {{0.1, 0.2, 0.15, 0.3, 0.25, n}, {0.9, 0.2, 0.15, 0.3, 0.25, n}};
    part.cap = {0.05, 0.1};
    const BodyDescription body = body_of({part});
    const BodyShape shape(body);
    for (int i = 0; i < 48; ++i) {
      const double a = 2.0 * 3.14159265358979 * (i + 0.5) / 48;
      const double c = std::cos(a), s = std::sin(a);
      const double ru = c > 0 ? 0.2 : 0.15, rv = s > 0 ? 0.3 : 0.25;
      const double u = std::copysign(std::pow(std::abs(c), 2.0 / n), c) * ru;
      const double v = std::copysign(std::pow(std::abs(s), 2.0 / n), s) * rv;
      const auto slope = [n](double x, double r) {
        return std::copysign(std::pow(std::abs(x) / r, n - 1.0) / r, x);
      };
      const glm::dvec3 normal = glm::normalize(glm::dvec3(slope(u, ru), 0.0, slope(v, rv)));
      for (const double y : {0.2, 0.5, 0.8}) expect_skin(shape, {3 + u, y, v}, normal);
      // The domes: half ellipsoids as high as the caps.
      for (const double up : {-0.6, -0.3, 0.3, 0.6}) {
        const double across = std::sqrt(1.0 - up * up), height = up < 0 ? 0.05 : 0.1;
        const double y = (up < 0 ? 0.1 : 0.9) + up * height;
        const glm::dvec3 on(3 + across * u, y, across * v);
        EXPECT_NEAR(shape.value(on), 0.0, 1e-9) << up;
        if (n == 2.0) {
          const glm::dvec3 out(across * u / (ru * ru), up / height, across * v / (rv * rv));
          expect_skin(shape, on, glm::normalize(out));
        }
      }
    }
    EXPECT_NEAR(shape.value({3, 0.05, 0}), 0.0, 1e-9);
    EXPECT_NEAR(shape.value({3, 1.0, 0}), 0.0, 1e-9);
    EXPECT_NEAR(shape.value({3, 0.5, 0}), -0.2, 0.06);
  }
}

TEST(BodyShape, OfATaperingLoftGoesLevelFromSizeToSize) {
  BodySolid part;
  part.axis = {{3, 0, 0}, {3, 1, 0}};
  part.sections = {{0.0, 0.3, 0.3, 0.3, 0.3, 2}, {1.0, 0.1, 0.1, 0.1, 0.1, 2}};
  const BodyDescription body = body_of({part});
  const BodyShape shape(body);
  for (const double y : {0.1, 0.3, 0.5, 0.7, 0.9})
    for (const double a : {0.4, 1.9, 3.3, 5.1}) {
      const double radius = 0.3 - 0.2 * y * y * (3 - 2 * y), slope = -1.2 * y * (1 - y);
      const glm::dvec3 out(std::cos(a), 0, std::sin(a));
      expect_skin(shape, glm::dvec3(3, y, 0) + radius * out,
                  glm::normalize(out - glm::dvec3(0, slope, 0)));
    }
}

TEST(BodyShape, MeltsSolidsTogetherOverTheirBlendAndNoFurther) {
  BodySolid second = ball({3.5, 0, 0}, 0.2);
  second.blend = 0.12;
  const std::vector<BodySolid> both{ball({3, 0, 0}, 0.2), second};
  for (const glm::dvec3& p : places()) {
    const double a = glm::distance(p, glm::dvec3(3, 0, 0)) - 0.2;
    const double b = glm::distance(p, glm::dvec3(3.5, 0, 0)) - 0.2;
    const double near = std::max(0.12 - std::abs(a - b), 0.0) / 0.12;
    EXPECT_NEAR(value_of(both, p), std::min(a, b) - near * near * near * 0.12 / 6.0, 1e-12);
  }
  EXPECT_NEAR(value_of(both, {3.25, 0, 0}), 0.05 - 0.02, 1e-12);  // half way: a sixth of it
  // The same between groups, over the group's own blend.
  BodyDescription groups = body_of({ball({3, 0, 0}, 0.2)});
  groups.groups.push_back({"more", 0.24, {ball({3.5, 0, 0}, 0.2)}});
  EXPECT_NEAR(BodyShape(groups).value({3.25, 0, 0}), 0.05 - 0.04, 1e-12);
}

TEST(BodyShape, TakesACutAway) {
  BodySolid bite = ball({3.2, 0, 0}, 0.2);
  bite.use = BodySolid::Use::cut;
  const std::vector<BodySolid> bitten{ball({3, 0, 0}, 0.3), bite};
  for (const glm::dvec3& p : places())
    EXPECT_NEAR(value_of(bitten, p),
                std::max(glm::distance(p, glm::dvec3(3, 0, 0)) - 0.3,
                         0.2 - glm::distance(p, glm::dvec3(3.2, 0, 0))),
                1e-12);
}

TEST(BodyShape, IsItsOwnMirrorImageAndRoundsTheCreaseOverTheFold) {
  BodySolid side = ball({0.1, 0, 0}, 0.3);
  side.mirrored = true;
  BodyDescription body = body_of({side});
  body.fold = 0.05;
  const BodyShape shape(body);
  for (const glm::dvec3& p : places()) {
    const glm::dvec3 q = p - glm::dvec3(3, 0, 0);
    EXPECT_EQ(shape.value(q), shape.value({-q.x, q.y, q.z}));
    if (std::abs(q.x) >= 0.05) {
      EXPECT_NEAR(shape.value(q), glm::distance({std::abs(q.x), q.y, q.z}, side.center) - 0.3,
                  1e-12);
    }
  }
  // In the plane it is as wide as half the fold aside, and level.
  EXPECT_NEAR(shape.value({0, 0.5, 0}), std::hypot(0.1 - 0.025, 0.5) - 0.3, 1e-12);
  EXPECT_NEAR(shape.gradient({0, 0.5, 0}).x, 0.0, 1e-9);
  EXPECT_EQ(shape.project({0, 0.4, 0.1}, 0.3).x, 0.0);
}

TEST(BodyShape, GivesEachPlaceToTheSolidWithJointsThatItIsDeepestIn) {
  std::vector<BodySolid> parts{ball({3, 0, 0}, 0.3), ball({3.4, 0, 0}, 0.2), ball({3.2, 0, 0}, 0.3),
                               ball({3.2, 0, 0}, 0.3)};
  parts[0].joints = {0};
  parts[1].joints = {1};
  parts[2].use = BodySolid::Use::cut;
  parts[2].joints = {0};
  const BodyDescription body = body_of(parts);
  const BodyShape shape(body);
  EXPECT_EQ(shape.part_count(), 4u);
  for (const glm::dvec3& p : places()) {
    const double a = glm::distance(p, parts[0].center) - 0.3,
                 b = glm::distance(p, parts[1].center) - 0.2;
    EXPECT_EQ(shape.owner(p), b < a ? 1u : 0u);
    EXPECT_EQ(shape.owner({-p.x, p.y, p.z}), b < a ? 1u : 0u);
  }
}

TEST(BodyShape, GivesFourPlacesAtOnceTheBitsOfEachAlone) {
  const BodyShape shape(read_body_description(source_folder() / "scenes/characters/human.toml"));
  std::mt19937 rng(3);
  const auto anywhere = [&] {
    std::uniform_real_distribution<double> x(shape.low().x, shape.high().x);
    std::uniform_real_distribution<double> y(shape.low().y, shape.high().y);
    std::uniform_real_distribution<double> z(shape.low().z, shape.high().z);
    return glm::dvec3(x(rng), y(rng), z(rng));
  };
  for (int i = 0; i < 2000; ++i) {
    glm::dvec3 p[4];
    for (glm::dvec3& each : p) each = anywhere();
    // All over the body, all on one solid's skin, or both.
    if (i % 3 > 0) p[0] = shape.project(p[0], 0.5);
    for (int k = 1; k < 4 && i % 3 == 1; ++k) p[k] = p[0] + 1e-3 * p[k];
    const Lanes together =
        shape.values(LaneVector({p[0].x, p[1].x, p[2].x, p[3].x}, {p[0].y, p[1].y, p[2].y, p[3].y},
                                {p[0].z, p[1].z, p[2].z, p[3].z}));
    for (int k = 0; k < 4; ++k) EXPECT_EQ(together[k], shape.value(p[k])) << i << " " << k;
  }
}

TEST(BodyShape, LeavesOutWhatStandsTooFarAwayToMelt) {
  // The ball nearby stands last, behind others of its group and other groups; what it comes to is
  // the nearest of all, whichever of them were asked.
  BodyDescription body = body_of({ball({1, 0, 0}, 0.2), ball({2, 0, 0}, 0.2)});
  body.groups.push_back({"more", 0.05, {ball({3, 0, 0}, 0.2), ball({4, 0, 0}, 0.2)}});
  body.groups.push_back({"last", 0.05, {ball({5, 0, 0}, 0.2), ball({6, 0, 0}, 0.2)}});
  const BodyShape shape(body);
  for (double x = 0.7; x < 6.4; x += 0.01) {
    const double apart = std::abs(x - std::clamp(std::round(x), 1.0, 6.0));
    // Half way between two balls they melt.
    if (x > 1.0 && x < 6.0 && apart > 0.46) continue;
    EXPECT_NEAR(shape.value({x, 0, 0}), apart - 0.2, 1e-12) << x;
  }
}

}  // namespace
}  // namespace backbend::skin
