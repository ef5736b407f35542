// Weights of a body: along its chains as described, softened as far as asked, and whole bodies
// from solids that are known.
#include "skin/body/body_weights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <set>

#include "skin/body/body_build.h"
#include "skin/body/body_grid.h"
#include "skin/body/body_subdivide.h"
#include "skin/body/index.h"

namespace backbend::skin {
namespace {

/// A rod of radius 0.06 through `axis`, its joints at `places`, hanging from one another.
BodyDescription rod(const std::vector<glm::dvec3>& axis, const std::vector<glm::dvec3>& places) {
  BodyDescription body;
  BodySolid part;
  part.axis = axis;
  part.soften = 0.0;
  const double length = BodyCurve(axis).length();
  part.sections = {{0.0, 0.06, 0.06, 0.06, 0.06, 2}, {length, 0.06, 0.06, 0.06, 0.06, 2}};
  part.cap = {0.06, 0.06};
  for (std::size_t i = 0; i < places.size(); ++i) {
    const int n = static_cast<int>(i);
    body.joints.push_back({"j" + std::to_string(n), n - 1, n, places[i]});
    part.joints.push_back(n);
  }
  body.groups.push_back({"all", 0.0, {part}});
  body.symmetric = false;
  return body;
}

double weight_of(const Influences& in, int joint) {
  double sum = 0.0;
  for (std::size_t k = 0; k < kMaxInfluences; ++k)
    if (in.joint[k] == joint && in.weight[k] > 0.0f) sum += in.weight[k];
  return sum;
}

std::vector<Influences> weigh(const BodyDescription& body, const HalfMesh& mesh) {
  return body_weights(mesh, BodyShape(body), body, [] {});
}

/// Joint i holds what has been reached at it and not at the next.
double expected_weight(double s, const std::vector<double>& arc, const std::vector<double>& half,
                       std::size_t i) {
  const auto reached = [&](std::size_t k) {
    if (k == 0) return 1.0;
    if (k == arc.size()) return 0.0;
    return std::clamp(0.5 + 0.5 * (s - arc[k]) / half[k], 0.0, 1.0);
  };
  return reached(i) - reached(i + 1);
}

TEST(BodyWeights, WithoutSofteningGoFromJointToJointOfAStraightChain) {
  const std::vector<glm::dvec3> axis = {{1, 0, 0.2}, {1, 0.9, 0.2}};
  const struct {
    std::vector<double> arc;
    std::vector<double> transition, half;
  } cases[] = {
      {{0.05, 0.35, 0.45, 0.8}, {}, {0.0, 0.05, 0.05, 0.175}},  // half of the shorter bone
      {{0.05, 0.35, 0.45, 0.8}, {0.11, 0.03, 0.08}, {0.0, 0.11, 0.03, 0.08}},
      {{0.05, 0.35, 0.45, 0.8}, {0.11}, {0.0, 0.11, 0.05, 0.175}},
      {{0.1, 0.6}, {}, {0.0, 0.25}},
      {{0.1, 0.6}, {0.12}, {0.0, 0.12}},
      {{0.3}, {}, {0.0}},
  };
  for (const auto& c : cases) {
    std::vector<glm::dvec3> places;
    for (const double s : c.arc) places.emplace_back(1, s, 0.2);
    BodyDescription body = rod(axis, places);
    body.groups[0].parts[0].transition = c.transition;
    const HalfMesh mesh = grid_surface(BodyShape(body), {1, 0.3, 0.2}, 0.025);
    const std::vector<Influences> weights = weigh(body, mesh);
    ASSERT_EQ(weights.size(), mesh.position.size());
    // Arcs count from the first joint along the bones; 1e-3 of the largest and less is dropped.
    for (std::size_t v = 0; v < weights.size(); ++v)
      for (std::size_t i = 0; i < c.arc.size(); ++i)
        ASSERT_NEAR(weight_of(weights[v], static_cast<int>(i)),
                    expected_weight(mesh.position[v].y, c.arc, c.half, i), 2.1e-3)
            << mesh.position[v].y << " joint " << i;
  }
}

TEST(BodyWeights, OfABentChainGoByItsCurve) {
  const std::vector<glm::dvec3> places = {
      {1, 0, 0}, {1, 0.3, 0.02}, {1, 0.55, 0.12}, {1, 0.75, 0.35}, {1, 0.85, 0.6}};
  BodyDescription body = rod(places, places);
  const BodyCurve curve(places);
  const HalfMesh mesh = grid_surface(BodyShape(body), places[1], 0.025);
  const std::vector<Influences> weights = weigh(body, mesh);
  std::vector<double> arc, half(1, 0.0);
  for (const glm::dvec3& p : places) arc.push_back(curve.nearest(p).arc);
  for (std::size_t i = 1; i < arc.size(); ++i)
    half.push_back(0.5 *
                   std::min(arc[i] - arc[i - 1], i + 1 < arc.size() ? arc[i + 1] - arc[i] : 9.0));
  for (std::size_t v = 0; v < weights.size(); ++v)
    for (std::size_t i = 0; i < arc.size(); ++i)
      ASSERT_NEAR(weight_of(weights[v], static_cast<int>(i)),
                  expected_weight(curve.nearest(mesh.position[v]).arc, arc, half, i), 2.1e-3);
}

TEST(BodyWeights, SoftenAsFarAsAskedAndKeepTheirSum) {
  const std::vector<glm::dvec3> axis = {{1, 0, 0.2}, {1, 1.2, 0.2}};
  for (const double soften : {0.04, 0.08}) {
    BodyDescription body = rod(axis, {{1, 0.1, 0.2}, {1, 0.6, 0.2}});
    body.groups[0].parts[0].transition = {1e-6};
    body.groups[0].parts[0].soften = soften;
    const HalfMesh mesh = grid_surface(BodyShape(body), {1, 0.3, 0.2}, 0.02);
    const std::vector<Influences> weights = weigh(body, mesh);
    // A step that is spread: twice the integral of what is left of the one side, times the distance
    // from the step, over both sides is the variance. Sorted along the rod.
    std::vector<std::pair<double, double>> along;
    for (std::size_t v = 0; v < weights.size(); ++v) {
      const double first = weight_of(weights[v], 0), second = weight_of(weights[v], 1);
      ASSERT_NEAR(first + second, 1.0, 1e-6);
      along.emplace_back(mesh.position[v].y, second);
    }
    std::sort(along.begin(), along.end());
    double variance = 0.0;
    for (std::size_t i = 0; i + 1 < along.size(); ++i) {
      const double y = 0.5 * (along[i].first + along[i + 1].first) - 0.6,
                   w = 0.5 * (along[i].second + along[i + 1].second);
      variance += 2.0 * (along[i + 1].first - along[i].first) * (y < 0.0 ? -y * w : y * (1.0 - w));
    }
    // A grid's thin triangles conduct somewhat better than even ones: measured 9 % further.
    EXPECT_NEAR(std::sqrt(variance), soften, 0.15 * soften);
  }
}

TEST(BodyWeights, FollowTheSolidThatOwnsAPlaceAndItsTwinOnTheOtherSide) {
  // An arm to the left with a twin to the right, and a middle that is its own.
  BodyDescription body;
  body.joints = {
      {"middle", -1, 0, {0, 0, 0}}, {"arm_L", 0, 2, {0.2, 0, 0}}, {"arm_R", 0, 1, {-0.2, 0, 0}}};
  BodySolid middle, arm;
  middle.shape = BodySolid::Shape::ellipsoid;
  middle.radii = {0.16, 0.2, 0.18};
  middle.joints = {0};
  middle.soften = 0.0;
  arm.shape = BodySolid::Shape::cone;
  arm.axis = {{0.1, 0.02, 0}, {0.6, 0.1, 0.05}};
  arm.radius = {0.08, 0.05};
  arm.joints = {1};
  arm.mirrored = true;
  arm.soften = 0.0;
  body.groups.push_back({"all", 0.0, {middle, arm}});
  const BodyShape shape(body);
  const HalfMesh mesh = grid_surface(shape, {0, 0, 0}, 0.03);
  std::size_t of_arm = 0, of_middle = 0;
  const std::vector<Influences> hard = weigh(body, mesh);
  for (std::size_t v = 0; v < hard.size(); ++v) {
    const bool own = shape.owner(mesh.position[v]) == 1;
    of_arm += own;
    of_middle += !own;
    ASSERT_EQ(weight_of(hard[v], own ? 1 : 0), 1.0);
  }
  EXPECT_GT(of_arm, 100u);
  EXPECT_GT(of_middle, 100u);
  // Softened over a long way what the arms share of the middle's plane is shared evenly.
  for (BodySolid& part : body.groups[0].parts) part.soften = 0.25;
  const std::vector<Influences> soft = weigh(body, mesh);
  std::size_t shared = 0;
  for (std::size_t v = 0; v < soft.size(); ++v) {
    const double left = weight_of(soft[v], 1), right = weight_of(soft[v], 2);
    EXPECT_NEAR(left + right + weight_of(soft[v], 0), 1.0, 1e-6);
    if (mesh.on_plane(static_cast<int>(v))) {
      EXPECT_NEAR(left, right, 1e-6);
      shared += left > 0.01;
    } else {
      EXPECT_GE(left, right - 1e-6);
    }
  }
  EXPECT_GT(shared, 10u);
}

TEST(FourLargest, TakesWhatTheFifthHasFromAllAndScalesTheRest) {
  Influences in;
  in.joint = {7, 3, 9, 1, 4};
  in.weight = {0.4f, 0.25f, 0.2f, 0.1f, 0.05f};
  const Influences out = four_largest(in);
  const double left = 0.95 - 4 * 0.05;
  const double expected[] = {0.35 / left, 0.2 / left, 0.15 / left, 0.05 / left};
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(out.joint[k], in.joint[k]);
    EXPECT_NEAR(out.weight[k], expected[k], 1e-6);
  }
  for (std::size_t k = 4; k < kMaxInfluences; ++k) EXPECT_EQ(out.weight[k], 0.0f);
  // Of equal weights the lower joint stands first; a thousandth of the largest is nothing.
  in = {};
  in.joint = {8, 2, 5, 6};
  in.weight = {0.4998f, 0.4998f, 0.0004f};
  const Influences two = four_largest(in);
  EXPECT_EQ(two.joint[0], 2);
  EXPECT_EQ(two.joint[1], 8);
  EXPECT_EQ(two.weight[0], 0.5f);
  EXPECT_EQ(two.weight[1], 0.5f);
  EXPECT_EQ(two.weight[2], 0.0f);
}

/// Loop's masks on the whole surface, vertex by vertex from its definition.
TEST(SubdivideWeights, AreLoopsMasksOnTheWholeSurface) {
  for (const double x : {0.0, 0.9}) {
    BodyDescription body;
    BodySolid part;
    part.shape = BodySolid::Shape::ellipsoid;
    part.center = {x, 0.1, -0.2};
    part.radii = {0.3, 0.25, 0.2};
    part.joints = {0};
    body.joints = {{"m", -1, 0, {0, 0, 0}},
                   {"a_L", 0, 2, {0.1, 0, 0}},
                   {"a_R", 0, 1, {-0.1, 0, 0}},
                   {"n", 0, 3, {0, 0.1, 0}}};
    body.groups.push_back({"all", 0.0, {part}});
    const BodyShape shape(body);
    HalfMesh mesh = grid_surface(shape, part.center, 0.09);
    const HalfMesh coarse = mesh;
    // Some weights, symmetric in the plane.
    std::vector<Influences> weights;
    for (const glm::dvec3& p : coarse.position) {
      const double right = p.x == 0.0 ? 0.2 + 0.1 * std::sin(9.0 * p.y) : 0.05,
                   left = p.x == 0.0 ? right : 0.3 + 0.1 * std::cos(8.0 * p.z + p.x),
                   other = 0.15 + 0.1 * std::sin(7.0 * p.y);
      Influences w;
      w.joint = {0, 1, 2, 3};
      w.weight = {static_cast<float>(1.0 - left - right - other), static_cast<float>(left),
                  static_cast<float>(right), static_cast<float>(other)};
      weights.push_back(w);
    }
    std::vector<std::array<int, 2>> edge_of;
    subdivide(mesh, shape, edge_of);
    const std::vector<Influences> fine = subdivide_weights(coarse, weights, edge_of, body);
    ASSERT_EQ(fine.size(), mesh.position.size());

    // The whole: vertex v, and n + v for the image of one off the plane.
    const int n = static_cast<int>(coarse.position.size());
    const auto twin = [&](int v) { return coarse.on_plane(v) ? v : n + v; };
    std::map<int, std::set<int>> ring;
    std::map<std::pair<int, int>, std::vector<int>> opposite;
    const auto add = [&](int a, int b, int c) {
      const int t[3] = {a, b, c};
      for (int k = 0; k < 3; ++k) {
        const int p = t[k], q = t[(k + 1) % 3];
        ring[p].insert({q, t[(k + 2) % 3]});
        opposite[{std::min(p, q), std::max(p, q)}].push_back(t[(k + 2) % 3]);
      }
    };
    for (const auto& t : coarse.triangle) {
      add(t[0], t[1], t[2]);
      if (x == 0.0) add(twin(t[0]), twin(t[2]), twin(t[1]));
    }
    const auto weight = [&](int v, int joint) {
      const int swapped = joint == 1 ? 2 : joint == 2 ? 1 : joint;
      return v < n ? weight_of(weights[z(v)], joint) : weight_of(weights[z(v - n)], swapped);
    };
    for (int v = 0; v < static_cast<int>(fine.size()); ++v)
      for (int joint = 0; joint < 4; ++joint) {
        double expected = 0.0;
        if (v < n) {
          const double count = static_cast<double>(ring[v].size());
          const double c = 0.375 + 0.25 * std::cos(2.0 * 3.14159265358979323846 / count);
          const double beta = (0.625 - c * c) / count;
          expected = (1.0 - count * beta) * weight(v, joint);
          for (const int other : ring[v]) expected += beta * weight(other, joint);
        } else {
          const auto [a, b] = edge_of[z(v - n)];
          const auto& far = opposite[{std::min(a, b), std::max(a, b)}];
          ASSERT_EQ(far.size(), 2u);
          expected = 0.375 * (weight(a, joint) + weight(b, joint)) +
                     0.125 * (weight(far[0], joint) + weight(far[1], joint));
        }
        ASSERT_NEAR(weight_of(fine[z(v)], joint), expected, 1e-6) << v << " " << joint;
      }
  }
}

// Whole bodies -----------------------------------------------------------------------------------

TEST(BodyBuild, OfABallBesideThePlaneIsThatBallAndNotMirrored) {
  BodyDescription body;
  BodySolid part;
  part.shape = BodySolid::Shape::ellipsoid;
  part.center = {0.9, 0.2, -0.3};
  part.radii = glm::dvec3(0.3);
  part.joints = {0};
  body.joints = {{"root", -1, 0, {0.95, 0.25, -0.3}}};
  body.groups.push_back({"all", 0.0, {part}});
  body.symmetric = false;
  body.cell = 0.04;
  body.vertices = 700;
  const SkinnedHalf half = build_half(body, {});
  EXPECT_NEAR(static_cast<double>(half.mesh.position.size()), 700.0, 70.0);
  EXPECT_EQ(half.normal.size(), half.mesh.position.size());
  EXPECT_EQ(half.weights.size(), half.mesh.position.size());
  for (std::size_t v = 0; v < half.normal.size(); ++v) {
    const glm::dvec3 out = half.mesh.position[v] - part.center;
    EXPECT_NEAR(glm::length(out), 0.3, 1e-6);
    EXPECT_LT(glm::distance(half.normal[v], out / 0.3), 1e-5);
    EXPECT_EQ(half.weights[v].weight[0], 1.0f);
  }
  BodyOptions asked;
  asked.vertices = 350;
  EXPECT_NEAR(static_cast<double>(build_half(body, asked).mesh.position.size()), 350.0, 50.0);
  // A core that lies inside stands for a root that does not.
  body.joints[0].at = {0.1, 0, 0};
  EXPECT_THROW(build_half(body, {}), CharacterError);
  body.joints.push_back({"inside", 0, 1, {0.9, 0.2, -0.2}});
  body.core = 1;
  EXPECT_NEAR(static_cast<double>(build_half(body, {}).mesh.position.size()), 700.0, 70.0);
}

TEST(BodyBuild, CountsTunnelsOfBodiesThatAreNotMirrored) {
  // A ring of four bars around (1, 0, 0.2).
  BodyDescription body;
  BodySolid bar;
  bar.shape = BodySolid::Shape::cone;
  bar.radius = glm::dvec2(0.06);
  bar.joints = {0};
  bar.blend = 0.0;
  const glm::dvec3 corner[] = {{1, -0.2, 0}, {1, 0.2, 0}, {1, 0.2, 0.4}, {1, -0.2, 0.4}};
  std::vector<BodySolid> parts;
  for (int k = 0; k < 4; ++k) {
    bar.axis = {corner[k], corner[(k + 1) % 4]};
    parts.push_back(bar);
  }
  body.joints = {{"root", -1, 0, corner[0]}};
  body.groups.push_back({"all", 0.0, parts});
  body.symmetric = false;
  body.cell = 0.03;
  body.vertices = 600;
  body.file_name = "ring.toml";
  try {
    build_half(body, {});
    FAIL() << "a ring passed for a body";
  } catch (const CharacterError& error) {
    EXPECT_NE(std::string(error.what())
                  .find("ring.toml: the surface has tunnels (Euler "
                        "characteristic 0, 2 expected)"),
              std::string::npos)
        << error.what();
  }
  body.tunnels = true;
  EXPECT_NO_THROW(build_half(body, {}));
}

TEST(BodyBuild, OfAMirroredBodyGivesTheHalfWithNormalsInThePlane) {
  BodyDescription body;
  BodySolid part;
  part.shape = BodySolid::Shape::ellipsoid;
  part.center = {0.0, 0.2, -0.3};
  part.radii = {0.3, 0.2, 0.25};
  part.joints = {0};
  body.joints = {{"root", -1, 0, part.center}};
  body.groups.push_back({"all", 0.0, {part}});
  body.cell = 0.04;
  body.vertices = 700;
  const SkinnedHalf half = build_half(body, {});
  std::size_t border = 0;
  for (std::size_t v = 0; v < half.normal.size(); ++v) {
    EXPECT_NEAR(glm::length(half.normal[v]), 1.0, 1e-12);
    if (half.mesh.position[v].x != 0.0) continue;
    ++border;
    EXPECT_EQ(half.normal[v].x, 0.0);
  }
  EXPECT_GT(border, 20u);
  // Twice the half, less what both share.
  EXPECT_NEAR(2.0 * static_cast<double>(half.mesh.position.size()) - static_cast<double>(border),
              700.0, 70.0);
}

}  // namespace
}  // namespace backbend::skin
