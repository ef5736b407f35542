#include "skin/body/body.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <algorithm>

#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <map>
#include <set>
#include <string>

#include "skin/anatomy/anatomy.h"
#include "skin/body/body_curve.h"
#include "skin/body/body_shape.h"
#include "skin/body/body_weights.h"
#include "skin/deform/skinning.h"
#include "tests/skin/body_figure.h"
#include "tests/source_folder.h"

namespace backbend::skin {
namespace {

/// Every edge runs once each way: closed, manifold, all triangles facing the same side; then
/// V - E + F = 2 says one shell without tunnels.
void expect_closed(const Character& body) {
  std::map<std::pair<unsigned, unsigned>, int> sides;
  for (const glm::uvec3& t : body.triangles) {
    for (int k = 0; k < 3; ++k) ++sides[{t[k], t[(k + 1) % 3]}];
  }
  std::size_t wrong = 0;
  for (const auto& [side, count] : sides) {
    const auto back = sides.find({side.second, side.first});
    if (count != 1 || back == sides.end() || back->second != 1) ++wrong;
  }
  EXPECT_EQ(wrong, 0u);
  const auto edges = static_cast<long>(sides.size() / 2);
  EXPECT_EQ(
      static_cast<long>(body.vertex_count()) - edges + static_cast<long>(body.triangles.size()), 2);
  std::vector<bool> used(body.vertex_count(), false);
  for (const glm::uvec3& t : body.triangles) used[t.x] = used[t.y] = used[t.z] = true;
  EXPECT_TRUE(std::all_of(used.begin(), used.end(), [](bool u) { return u; }));
}

double body_volume(const Character& body) {
  double sum = 0.0;
  for (const glm::uvec3& t : body.triangles) {
    const glm::dvec3 a(body.bind_position[t.x]), b(body.bind_position[t.y]),
        c(body.bind_position[t.z]);
    sum += glm::dot(a, glm::cross(b, c)) / 6.0;
  }
  return sum;
}

/// The smallest angle of all triangles, degrees.
double smallest_angle_deg(const Character& body) {
  double smallest = 180.0;
  for (const glm::uvec3& t : body.triangles) {
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3 p(body.bind_position[t[k]]);
      const glm::dvec3 a = glm::dvec3(body.bind_position[t[(k + 1) % 3]]) - p;
      const glm::dvec3 b = glm::dvec3(body.bind_position[t[(k + 2) % 3]]) - p;
      smallest = std::min(smallest,
                          glm::degrees(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b))));
    }
  }
  return smallest;
}

/// To the last bit: positions, normals and, joint for joint, weights.
void expect_symmetric(const Character& body) {
  const auto key = [](const glm::vec3& p) { return std::array<float, 3>{p.x + 0.0f, p.y, p.z}; };
  std::map<std::array<float, 3>, std::size_t> at;
  for (std::size_t v = 0; v < body.vertex_count(); ++v) at[key(body.bind_position[v])] = v;
  const auto twin_name = [](std::string name) {
    if (name.size() > 2 && name[name.size() - 2] == '_') {
      if (name.back() == 'L')
        name.back() = 'R';
      else if (name.back() == 'R')
        name.back() = 'L';
    }
    return name;
  };
  const auto named_weights = [&](std::size_t v, bool mirrored) {
    std::map<std::string, float> out;
    for (std::size_t k = 0; k < kMaxInfluences; ++k) {
      const Influences& w = body.influences[v];
      if (w.weight[k] <= 0.0f) continue;
      const std::string& name =
          body.nodes[static_cast<std::size_t>(body.joints[w.joint[k]].node)].name;
      out[mirrored ? twin_name(name) : name] += w.weight[k];
    }
    return out;
  };
  std::size_t alone = 0, uneven = 0;
  for (std::size_t v = 0; v < body.vertex_count(); ++v) {
    glm::vec3 p = body.bind_position[v];
    p.x = -p.x;
    const auto twin = at.find(key(p));
    if (twin == at.end()) {
      ++alone;
      continue;
    }
    const glm::vec3 n = body.bind_normal[twin->second];
    if (glm::vec3(-n.x, n.y, n.z) != body.bind_normal[v]) ++uneven;
    if (named_weights(v, true) != named_weights(twin->second, false)) ++uneven;
  }
  EXPECT_EQ(alone, 0u);
  EXPECT_EQ(uneven, 0u);
}

/// One in float within four roundings, no more than four, largest first.
void expect_weights(const Character& body) {
  for (std::size_t v = 0; v < body.vertex_count(); ++v) {
    const Influences& w = body.influences[v];
    float sum = 0.0f;
    for (std::size_t k = 0; k < kMaxInfluences; ++k) {
      sum += w.weight[k];
      ASSERT_GE(w.weight[k], 0.0f);
      ASSERT_LE(w.weight[k], w.weight[k > 0 ? k - 1 : 0]);
      ASSERT_TRUE(k < 4 || w.weight[k] == 0.0f) << "vertex " << v;
    }
    ASSERT_NEAR(sum, 1.0f, 3e-7f) << "vertex " << v;
  }
}

float weight_of(const Character& body, std::size_t vertex, const std::string& joint) {
  const Influences& w = body.influences[vertex];
  for (std::size_t k = 0; k < kMaxInfluences; ++k) {
    if (w.weight[k] > 0.0f &&
        body.nodes[static_cast<std::size_t>(body.joints[w.joint[k]].node)].name == joint) {
      return w.weight[k];
    }
  }
  return 0.0f;
}

TEST(Body, IsOneClosedShellThatFacesOutwards) {
  const Character body = make_body(figure());
  expect_closed(body);
  EXPECT_GT(body_volume(body), 0.0);
  // Even triangles: none is a sliver (an equilateral one has 60 degrees).
  EXPECT_GT(smallest_angle_deg(body), 10.0);
  for (const glm::uvec3& t : body.triangles) {
    const glm::vec3 &a = body.bind_position[t.x], &b = body.bind_position[t.y],
                    &c = body.bind_position[t.z];
    const glm::vec3 sum = body.bind_normal[t.x] + body.bind_normal[t.y] + body.bind_normal[t.z];
    ASSERT_GT(glm::dot(glm::cross(b - a, c - a), sum), 0.0f);
  }
}

TEST(Body, IsItsOwnMirrorImageToTheLastBit) { expect_symmetric(make_body(figure())); }

TEST(Body, WeightsSumToOneWithFourJointsAtMost) { expect_weights(make_body(figure())); }

TEST(Body, StandsAtRestWhereItWasBound) {
  const Character body = make_body(figure());
  const PosedMesh rest = rest_mesh(body);
  for (std::size_t v = 0; v < body.vertex_count(); ++v) {
    ASSERT_LT(glm::distance(rest.position[v], body.bind_position[v]), 1e-6f);
  }
}

TEST(Body, IsTheSameForAnyNumberOfThreads) {
  std::vector<Character> made;
  for (const std::size_t threads : {1, 2, 5}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    made.push_back(make_body(figure()));
  }
  for (std::size_t i = 1; i < made.size(); ++i) {
    EXPECT_EQ(made[i].bind_position, made[0].bind_position);
    EXPECT_EQ(made[i].bind_normal, made[0].bind_normal);
    EXPECT_EQ(made[i].triangles, made[0].triangles);
    for (std::size_t v = 0; v < made[0].vertex_count(); ++v) {
      ASSERT_EQ(made[i].influences[v].joint, made[0].influences[v].joint);
      ASSERT_EQ(made[i].influences[v].weight, made[0].influences[v].weight);
    }
  }
}

TEST(Body, HasAboutTheVerticesThatWereAskedFor) {
  for (const int wanted : {1000, 4000}) {
    EXPECT_NEAR(static_cast<double>(make_body(figure(), {wanted}).vertex_count()), wanted,
                0.12 * wanted);
  }
}

TEST(Body, IsCutInFourWhereManyVerticesAreAskedForAndStaysSound) {
  // 64000 is above what is remeshed directly: a mesh of 16000 is cut once.
  const Character body = make_body(figure(), {64000});
  EXPECT_NEAR(static_cast<double>(body.vertex_count()), 64000, 0.12 * 64000);
  expect_closed(body);
  expect_symmetric(body);
  expect_weights(body);
}

TEST(Body, KeepsTheLegsWeightsApart) {
  const Character body = make_body(figure());
  std::size_t seen = 0;
  for (std::size_t v = 0; v < body.vertex_count(); ++v) {
    // Two softening lengths (0.02 each) below the crotch nothing of the other leg is left.
    if (body.bind_position[v].y > 0.7f) continue;
    ++seen;
    const char* other = body.bind_position[v].x > 0.0f ? "leg_R" : "leg_L";
    ASSERT_EQ(weight_of(body, v, other), 0.0f);
    ASSERT_EQ(weight_of(body, v, "spine_1"), 0.0f);
  }
  EXPECT_GT(seen, 100u);
}

TEST(Body, ChangesFromSpineJointToSpineJointAsSmoothlyAsTheBonesAllow) {
  // From bone centre to bone centre: a weight rises by 1 over 0.15 m. Heat can only flatten that.
  // 1.35: the slope on the skin, which leans against the spine by up to 25 degrees here, and the
  // four-weight limit's renormalisation.
  const Character body = make_body(figure());
  for (const glm::uvec3& t : body.triangles) {
    for (int k = 0; k < 3; ++k) {
      const glm::vec3 &a = body.bind_position[t[k]], &b = body.bind_position[t[(k + 1) % 3]];
      if (std::min(a.y, b.y) < 1.1f || std::max(a.y, b.y) > 1.35f) continue;
      if (std::max(std::abs(a.x), std::abs(b.x)) > 0.16f) continue;
      for (const char* joint : {"hips", "spine_1", "spine_2", "chest"}) {
        const float change =
            std::abs(weight_of(body, t[k], joint) - weight_of(body, t[(k + 1) % 3], joint));
        ASSERT_LE(change, 1.35f * std::abs(a.y - b.y) / 0.15f + 0.01f) << joint;
      }
    }
  }
}

TEST(Body, OfOneEllipsoidIsThatEllipsoid) {
  const Character body = make_body(read_text(R"(schema = "backbend.body/1"
vertices = 3000
cell = 0.02
joints = [{ name = "root", at = [0, 0, 0] }]
[[group]]
name = "all"
[[group.part]]
shape = "ellipsoid"
center = [0, 0, 0]
radii = [0.3, 0.2, 0.4]
joints = ["root"]
)"));
  const glm::dvec3 radii(0.3, 0.2, 0.4);
  for (std::size_t v = 0; v < body.vertex_count(); ++v) {
    const glm::dvec3 p(body.bind_position[v]);
    ASSERT_NEAR(glm::length(p / radii), 1.0, 2e-6);  // projected to 1e-7 m; then float
    ASSERT_LT(glm::distance(glm::dvec3(body.bind_normal[v]), glm::normalize(p / (radii * radii))),
              1e-4);
  }
  // Inscribed triangles of edge L lose about L^2 / (4 R) of depth: L = 0.025, R >= 0.1.
  EXPECT_NEAR(body_volume(body), 4.0 / 3.0 * 3.14159265 * 0.3 * 0.2 * 0.4, 0.01 * 0.1005);
}

TEST(Body, RefusesSolidsThatLeaveATunnel) {
  // Two bars between two posts on each side: a frame.
  const std::string frame = R"(schema = "backbend.body/1"
vertices = 2000
cell = 0.02
joints = [{ name = "root", at = [0, 0, 0] }]
[[group]]
name = "all"
[[group.part]]
shape = "ellipsoid"
center = [0, 0, 0]
radii = [0.1, 0.1, 0.1]
joints = ["root"]
[[group.part]]
shape = "cone"
axis = [[0, 0, 0], [0, 0.5, 0]]
radius = 0.06
[[group.part]]
shape = "cone"
axis = [[0, 0.5, 0], [0, 0.5, 0.5]]
radius = 0.06
[[group.part]]
shape = "cone"
axis = [[0, 0.5, 0.5], [0, 0, 0]]
radius = 0.06
)";
  try {
    make_body(read_text(frame));
    FAIL() << "a ring passed for a body";
  } catch (const CharacterError& error) {
    EXPECT_NE(std::string(error.what()).find("figure.toml"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("Euler characteristic 0"), std::string::npos);
  }
}

TEST(Body, RefusesARootOutsideItsSolids) {
  EXPECT_THROW(make_body(read_text(figure_text("at = [0, 1.0, 0]", "at = [0, 2.5, 0]"))),
               CharacterError);
}

TEST(BodyDescription, NamesFileLineAndKeyOfWhatItCannotUse) {
  struct Case {
    const char *what, *replace, *message;
  };
  const Case cases[] = {
      {"fold = 0.01", "folds = 0.01", "figure.toml:5: unknown key `folds`"},
      {"backbend.body/1", "backbend.body/9", "figure.toml:1: `schema` is not"},
      {"cell = 0.03", "cell = -1", "figure.toml:4: `cell` is not above 0"},
      {"cell = 0.03", "cell = nan", "figure.toml:4: expected a number"},
      {"parent = \"hips\", at = [0, 1.15", "parent = \"hip\", at = [0, 1.15",
       "figure.toml:8: `spine_1` does not hang from the root"},
      {"name = \"spine_1\", ", "name = \"hips\", ", "figure.toml:8: a second joint `hips`"},
      {"at = [0.2, 1.45, 0]", "at = [-0.2, 1.45, 0]", "figure.toml:11: `arm_L` is on the left"},
      {"at = [0, 1.30, 0]", "at = [0.1, 1.30, 0]",
       "figure.toml:9: `spine_2` is neither in the middle"},
      {"at = [0, 1.30, 0]", "at = [0, 1.30]", "figure.toml:9: expected [x, y, z]"},
      {"shape = \"cone\"", "shape = \"cube\"", "`shape` is none of loft, ellipsoid, cone"},
      {"[0.3, 0.14, 0.11]", "[0.7, 0.14, 0.11]", "sections do not rise"},
      {"[0.3, 0.14, 0.11]", "[0.3, 0.14, -0.11]", "expected a length above 0"},
      {"joints = [\"arm_L\"]", "joints = [\"wing_L\"]", "no joint `wing_L`"},
      {"radius = [0.07, 0.04]", "radius = [0.9, 0.04]", "one end of the cone swallows the other"},
      {"vertices = 2000", "vertices = [", "figure.toml:"},
  };
  for (const Case& c : cases) {
    try {
      read_text(figure_text(c.what, c.replace));
      ADD_FAILURE() << c.replace << " passed";
    } catch (const CharacterError& error) {
      EXPECT_NE(std::string(error.what()).find(c.message), std::string::npos)
          << c.replace << " gave: " << error.what();
    }
  }
  EXPECT_THROW(read_body_description("/nowhere/figure.toml"), CharacterError);
}

TEST(BodyDescription, GivesEveryLeftJointItsTwin) {
  const BodyDescription body = figure();
  ASSERT_EQ(body.joints.size(), 10u);
  for (std::size_t i = 0; i < body.joints.size(); ++i) {
    const BodyJoint& joint = body.joints[i];
    const BodyJoint& twin = body.joints[static_cast<std::size_t>(joint.twin)];
    EXPECT_EQ(twin.twin, static_cast<int>(i));
    EXPECT_EQ(twin.at, joint.at * glm::dvec3(-1, 1, 1));
    EXPECT_LT(joint.parent, static_cast<int>(i));
  }
}

TEST(BodyDescription, PutsAChainAtEqualDistancesOnItsCurve) {
  const std::string chain =
      "[[chain]]\nname = \"tail\"\nparent = \"hips\"\ncount = 5\n"
      "through = [[0, 1.0, -0.2], [0, 1.0, -0.6]]\n[[group]]\nname = \"trunk\"";
  const BodyDescription body = read_text(figure_text("[[group]]\nname = \"trunk\"", chain));
  double z = -0.2;
  for (const BodyJoint& joint : body.joints) {
    if (joint.name.rfind("tail_", 0) != 0) continue;
    EXPECT_NEAR(joint.at.z, z, 1e-12) << joint.name;
    z -= 0.1;
  }
  EXPECT_NEAR(z, -0.7, 1e-12);
}

TEST(BodyCurve, OnACircleFindsTheNearestPointByItsAngle) {
  // A quarter circle of radius 1 through nine points: the spline leaves it by less than 1e-4 (its
  // natural ends are straight, so the error is largest there; measured 7e-4 on the outer bones).
  std::vector<glm::dvec3> points;
  for (int i = 0; i <= 8; ++i) {
    const double angle = 0.5 * 3.14159265358979 * i / 8;
    points.emplace_back(0.0, std::sin(angle), std::cos(angle));
  }
  const BodyCurve curve(points);
  EXPECT_NEAR(curve.length(), 0.5 * 3.14159265358979, 1e-3);
  for (const double radius : {0.6, 1.0, 1.7}) {
    for (const double angle : {0.4, 0.8, 1.1}) {
      const auto foot = curve.nearest({0.0, radius * std::sin(angle), radius * std::cos(angle)});
      EXPECT_NEAR(foot.arc, angle, 2e-3);
      EXPECT_LT(glm::distance(foot.tangent, glm::dvec3(0, std::cos(angle), -std::sin(angle))),
                1e-2);
    }
  }
}

TEST(BodyCurve, OfManyPointsFindsWhatTryingThemAllFinds) {
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 60; ++i) points.emplace_back(0.0, std::sin(0.3 * i), 0.2 * i);
  const BodyCurve curve(points);
  int inside = 0;
  for (int i = 0; i < 200; ++i) {
    const glm::dvec3 p(0.3 * std::sin(i * 1.7), 1.6 * std::sin(i * 0.37), 0.06 * i);
    const auto foot = curve.nearest(p);
    if (foot.arc <= 0.0 || foot.arc >= curve.length()) continue;  // it goes on beyond its ends
    ++inside;
    double best = INFINITY;
    for (int k = 0; k <= 20000; ++k) {
      best = std::min(best, glm::distance(p, curve.at(curve.length() * k / 20000)));
    }
    EXPECT_NEAR(glm::distance(p, foot.at), best, 1e-5) << i;
  }
  EXPECT_GT(inside, 150);
}

TEST(BodyShape, IsUntouchedByASolidFurtherAwayThanItsBlend) {
  const BodyDescription body = figure();
  const BodyShape whole(body);
  BodyDescription bare = body;
  bare.groups.pop_back();
  const BodyShape trunk(bare);
  // At the top of the trunk the limbs are more than their blend of 0.05 further off than the trunk.
  const glm::dvec3 far(0.0, 1.52, 0.05);
  EXPECT_EQ(whole.value(far), trunk.value(far));
  EXPECT_LT(whole.value({0.12, 0.5, 0.0}), 0.0);
  EXPECT_GT(trunk.value({0.12, 0.5, 0.0}), 0.0);
}

TEST(FourLargest, ChangesWithoutAStepWhereTheFifthOvertakesTheFourth) {
  const auto five = [](float fourth, float fifth) {
    Influences in;
    in.joint = {0, 1, 2, 3, 4};
    in.weight = {0.4f, 0.3f, 0.1f, fourth, fifth};
    return four_largest(in);
  };
  const Influences before = five(0.100001f, 0.099999f), after = five(0.1f, 0.1f);
  for (std::size_t k = 0; k < 2; ++k) EXPECT_NEAR(before.weight[k], after.weight[k], 1e-4f);
  EXPECT_NEAR(before.weight[3], 0.0f, 1e-4f);
}

// One build for all that is said about a bundled character: it takes seconds.
struct Bundled {
  const char* file;
  double length;  // along its longest axis, metres
  std::size_t spine_joints;
};
class BundledBody : public testing::TestWithParam<Bundled> {};

TEST_P(BundledBody, IsSoundSymmetricAndItsSpineIsFound) {
  const auto path = source_folder() / "scenes/characters" / GetParam().file;
  const Character body = make_body(read_body_description(path));
  EXPECT_NEAR(static_cast<double>(body.vertex_count()), 20000, 1000);
  expect_closed(body);
  expect_symmetric(body);
  expect_weights(body);
  EXPECT_GT(body_volume(body), 0.0);
  EXPECT_GT(smallest_angle_deg(body), 3.0);
  glm::vec3 low(1e9f), high(-1e9f);
  for (const glm::vec3& p : body.bind_position) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  EXPECT_NEAR(std::max(high.y - low.y, high.z - low.z), GetParam().length,
              0.02 * GetParam().length);
  for (std::size_t v = 0; v < body.vertex_count(); ++v) {
    if (std::abs(body.bind_position[v].x) < 0.02f) continue;
    const bool left = body.bind_position[v].x > 0.0f;
    for (const char* limb : {"shin_", "foot_", "hand_", "forearm_", "hindfoot_", "forefoot_"}) {
      ASSERT_EQ(weight_of(body, v, std::string(limb) + (left ? "R" : "L")), 0.0f) << limb << v;
    }
  }
  const Anatomy anatomy = find_anatomy(body);
  EXPECT_EQ(anatomy.chest_index + 1, GetParam().spine_joints);
}

INSTANTIATE_TEST_SUITE_P(Scenes, BundledBody,
                         testing::Values(Bundled{"human.toml", 1.75, 6},
                                         Bundled{"dinosaur.toml", 9.9, 6},
                                         Bundled{"snake.toml", 3.25, 101}),
                         [](const auto& info) {
                           const std::string file = info.param.file;
                           return file.substr(0, file.find('.'));
                         });

}  // namespace
}  // namespace backbend::skin
