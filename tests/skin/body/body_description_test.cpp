// Every key of a body description is read into its place, and what is wrong is refused by line.
#include "skin/body/body_description.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "tests/skin/body_figure.h"

namespace backbend::skin {
namespace {

constexpr const char* kEveryKey = R"(schema = "backbend.body/1"
name = "all"
vertices = 1234
cell = 0.011
fold = 0.012
finest = 0.4
coarsest = 1.25
material = { name = "wax", color = [0.125, 0.25, 0.5], roughness = 0.75 }
joints = [
  { name = "root", at = [0, 1, 0] },
  { name = "hand_L", parent = "arm_L", at = [0.5, 1.5, 0.25] },
  { name = "arm_L", parent = "neck_3", at = [0.25, 1.5, 0.125] },
]
[[chain]]
name = "neck"
count = 4
parent = "root"
through = [[0, 1.1, 0], [0, 1.7, 0]]
[[group]]
name = "trunk"
blend = 0.031
[[group.part]]
shape = "loft"
axis = ["root", "neck_2..neck_4"]
sections = [[0, 0.1], [0.1, 0.2, 0.3], [0.2, 0.4, 0.5, 0.6], [0.3, 0.1, 0.2, 0.3, 0.4],
            [0.4, 0.2, 0.25, 0.3, 0.35, 4]]
square = 3
joints = ["root", "neck_1..neck_3"]
transition = 0.05
soften = 0.015
blend = 0.016
[[group.part]]
shape = "ellipsoid"
center = [1, 2, 3]
radii = [0.1, 0.2, 0.3]
turn = [0, 0, 90]
cut = true
[[group]]
name = "limbs"
[[group.part]]
shape = "cone"
axis = ["arm_L", "hand_L"]
radius = [0.07, 0.04]
joints = ["arm_L", "hand_L"]
transition = [0.06]
[[group.part]]
shape = "cone"
axis = [[0, 0, 0], [0, 1, 0]]
radius = 0.05
mirrored = true
[[group.part]]
shape = "loft"
axis = [[0, 0, 0], [1, 0, 0]]
sections = [[0, 0.1, 0.2], [1, 0.2, 0.1]]
cap = [0.01, 0.02]
side = [0, 2, 0]
front = [0, 0, 3]
)";

TEST(BodyDescription, ReadsEveryKeyIntoItsPlace) {
  const BodyDescription body = read_text(kEveryKey);
  EXPECT_EQ(body.name, "all");
  EXPECT_EQ(body.file_name, "figure.toml");
  EXPECT_EQ(body.vertices, 1234);
  EXPECT_EQ(body.cell, 0.011);
  EXPECT_EQ(body.fold, 0.012);
  EXPECT_EQ(body.finest, 0.4);
  EXPECT_EQ(body.coarsest, 1.25);
  EXPECT_EQ(body.material.name, "wax");
  EXPECT_EQ(body.material.base_color, glm::vec4(0.125f, 0.25f, 0.5f, 1.0f));
  EXPECT_EQ(body.material.roughness, 0.75f);

  const struct {
    const char *name, *parent, *twin;
    glm::dvec3 at;
  } joints[] = {{"root", "", "root", {0, 1, 0}},
                {"neck_1", "root", "neck_1", {0, 1.1, 0}},
                {"neck_2", "neck_1", "neck_2", {0, 1.3, 0}},
                {"neck_3", "neck_2", "neck_3", {0, 1.5, 0}},
                {"arm_L", "neck_3", "arm_R", {0.25, 1.5, 0.125}},
                {"hand_L", "arm_L", "hand_R", {0.5, 1.5, 0.25}},
                {"neck_4", "neck_3", "neck_4", {0, 1.7, 0}},
                {"arm_R", "neck_3", "arm_L", {-0.25, 1.5, 0.125}},
                {"hand_R", "arm_R", "hand_L", {-0.5, 1.5, 0.25}}};
  ASSERT_EQ(body.joints.size(), std::size(joints));
  const auto index = [&](const std::string& name) {
    for (std::size_t i = 0; i < body.joints.size(); ++i)
      if (body.joints[i].name == name) return static_cast<int>(i);
    return -1;
  };
  for (const auto& expected : joints) {
    const int i = index(expected.name);
    ASSERT_GE(i, 0) << expected.name;
    const BodyJoint& joint = body.joints[static_cast<std::size_t>(i)];
    EXPECT_EQ(joint.parent, index(expected.parent)) << expected.name;
    EXPECT_LT(joint.parent, i);
    EXPECT_EQ(joint.twin, index(expected.twin)) << expected.name;
    EXPECT_LT(glm::distance(joint.at, expected.at), 1e-12) << expected.name;
  }

  ASSERT_EQ(body.groups.size(), 2u);
  EXPECT_EQ(body.groups[0].name, "trunk");
  EXPECT_EQ(body.groups[0].blend, 0.031);
  EXPECT_EQ(body.groups[1].blend, BodyGroup{}.blend);
  ASSERT_EQ(body.groups[0].parts.size(), 2u);
  const BodySolid& loft = body.groups[0].parts[0];
  EXPECT_EQ(loft.shape, BodySolid::Shape::loft);
  EXPECT_EQ(loft.use, BodySolid::Use::add);
  EXPECT_FALSE(loft.mirrored);
  EXPECT_EQ(loft.blend, 0.016);
  EXPECT_EQ(loft.soften, 0.015);
  ASSERT_EQ(loft.axis.size(), 4u);  // a run of joints gives its points, outwards
  const double heights[] = {1.0, 1.3, 1.5, 1.7};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(loft.axis[i].y, heights[i], 1e-12);
  EXPECT_EQ(loft.joints,
            (std::vector{index("root"), index("neck_1"), index("neck_2"), index("neck_3")}));
  EXPECT_EQ(loft.transition, (std::vector{0.05, 0.05, 0.05}));  // one at each joint but the first
  const BodySection sections[] = {{0.0, 0.1, 0.1, 0.1, 0.1, 3},
                                  {0.1, 0.2, 0.2, 0.3, 0.3, 3},
                                  {0.2, 0.4, 0.4, 0.5, 0.6, 3},
                                  {0.3, 0.1, 0.2, 0.3, 0.4, 3},
                                  {0.4, 0.2, 0.25, 0.3, 0.35, 4}};
  ASSERT_EQ(loft.sections.size(), std::size(sections));
  for (std::size_t i = 0; i < loft.sections.size(); ++i) {
    const BodySection &read = loft.sections[i], &wrote = sections[i];
    EXPECT_EQ(read.at, wrote.at);
    EXPECT_EQ(read.outer, wrote.outer) << i;
    EXPECT_EQ(read.inner, wrote.inner) << i;
    EXPECT_EQ(read.front, wrote.front) << i;
    EXPECT_EQ(read.back, wrote.back) << i;
    EXPECT_EQ(read.square, wrote.square) << i;
  }
  EXPECT_DOUBLE_EQ(loft.cap.x, 0.07);  // of the smaller half axis
  EXPECT_DOUBLE_EQ(loft.cap.y, 0.14);
  EXPECT_EQ(loft.side, BodySolid{}.side);

  const BodySolid& cut = body.groups[0].parts[1];
  EXPECT_EQ(cut.shape, BodySolid::Shape::ellipsoid);
  EXPECT_EQ(cut.use, BodySolid::Use::cut);
  EXPECT_EQ(cut.center, glm::dvec3(1, 2, 3));
  EXPECT_EQ(cut.radii, glm::dvec3(0.1, 0.2, 0.3));
  EXPECT_LT(glm::distance(cut.world_from_ellipsoid * glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0)),
            1e-15);
  EXPECT_EQ(cut.blend, BodySolid{}.blend);
  EXPECT_EQ(cut.soften, BodySolid{}.soften);
  EXPECT_TRUE(cut.joints.empty());
  EXPECT_TRUE(cut.transition.empty());

  ASSERT_EQ(body.groups[1].parts.size(), 3u);
  const BodySolid &arm = body.groups[1].parts[0], &post = body.groups[1].parts[1],
                  &bar = body.groups[1].parts[2];
  EXPECT_EQ(arm.shape, BodySolid::Shape::cone);
  EXPECT_EQ(arm.radius, glm::dvec2(0.07, 0.04));
  EXPECT_TRUE(arm.mirrored);  // its joints are the left's
  EXPECT_EQ(arm.transition, std::vector{0.06});
  EXPECT_EQ(arm.axis[1], glm::dvec3(0.5, 1.5, 0.25));
  EXPECT_EQ(post.radius, glm::dvec2(0.05));
  EXPECT_TRUE(post.mirrored);
  EXPECT_EQ(bar.cap, glm::dvec2(0.01, 0.02));
  EXPECT_EQ(bar.side, glm::dvec3(0, 2, 0));
  EXPECT_EQ(bar.front, glm::dvec3(0, 0, 3));
  EXPECT_FALSE(bar.mirrored);
}

TEST(BodyDescription, HasItsDefaultsWhereAKeyIsLeftOut) {
  const BodyDescription plain;
  const BodyDescription body = read_text(
      "schema = \"backbend.body/1\"\njoints = [{ name = \"root\", at = [0, 0, 0] }]\n"
      "[[group]]\nname = \"one\"\n[[group.part]]\nshape = \"ellipsoid\"\n"
      "center = [0, 0, 0]\nradii = [1, 1, 1]\n");
  EXPECT_EQ(body.name, "figure");
  EXPECT_EQ(body.vertices, plain.vertices);
  EXPECT_EQ(body.cell, plain.cell);
  EXPECT_EQ(body.fold, plain.fold);
  EXPECT_EQ(body.finest, plain.finest);
  EXPECT_EQ(body.coarsest, plain.coarsest);
  EXPECT_EQ(body.material.name, "clay");
  EXPECT_EQ(body.groups[0].parts[0].world_from_ellipsoid, glm::dmat3(1.0));
}

TEST(BodyDescription, RefusesWhatIsOutOfItsRange) {
  const struct {
    const char *what, *instead, *message;
  } cases[] = {
      {"vertices = 1234", "vertices = 499", ":3: `vertices` is below 500"},
      {"fold = 0.012", "fold = 0", ":5: `fold` is not above 0"},
      {"finest = 0.4", "finest = 1.3", "`finest` is not above 0 and at most `coarsest`"},
      {"finest = 0.4", "finest = 0", "`finest` is not above 0"},
      {"finest = 0.4", "finest = 1e8", ":6: expected a number within +-1e7"},
      {"color = [0.125, ", "color = [0, 0.125, ", ":8: expected [x, y, z]"},
      {"name = \"wax\"", "name = \"\"", ":8: expected a text"},
      {"name = \"root\", at", "nam = \"root\", at", "unknown key `nam`"},
      {"{ name = \"root\", at = [0, 1, 0] }", "{ name = \"root\" }", ":10: `at` is missing"},
      {"{ name = \"root\", at", "{ name = \"root\", parent = \"neck_4\", at", "does not hang"},
      {"parent = \"neck_3\", at", "at", "expected one joint without a parent, found 3"},
      {"at = [0.25, 1.5, 0.125]", "at = [0, 1.5, 0.125]", "`arm_L` is on the left: x above 0"},
      {"count = 4", "count = 1", ":16: `count` is not 2..2000"},
      {"count = 4", "count = 2001", ":16: `count` is not 2..2000"},
      {"[[0, 1.1, 0], [0, 1.7, 0]]", "[[0, 1.1, 0]]", ":18: expected two or more points"},
      {"[[0, 1.1, 0], [0, 1.7, 0]]", "[[0, 1.1, 0], [0, 1.1, 0]]", ":18: two points are the same"},
      {"blend = 0.031", "blend = -0.031", "`blend` is a length, not below 0"},
      {"\"neck_2..neck_4\"]", "\"neck_4..neck_2\"]", "the second joint does not hang from"},
      {"\"neck_2..neck_4\"]", "\"neck_2..neck_9\"]", "no joint `neck_9`"},
      {"joints = [\"root\", \"neck_1..neck_3\"]", "joints = [\"root\", \"root\"]",
       "two joints of the chain stand at the same place"},
      {"[[0, 0.1], ", "[[0], ", "a section is [at, radius]"},
      {"[[0, 0.1], ", "[[0, 0, 0, 0, 0, 2, 0], ", "a section is [at, radius]"},
      {"[0.1, 0.2, 0.3]", "[0.0, 0.2, 0.3]", "sections do not rise"},
      {"square = 3", "square = 0.9", "`square` is not 1..8"},
      {"square = 3", "square = 8.1", "`square` is not 1..8"},
      {"transition = 0.05", "transition = 0", "expected a length above 0"},
      {"transition = [0.06]", "transition = [-1]", "expected a length above 0"},
      {"radii = [0.1, 0.2, 0.3]", "radii = [0.1, 0.2]", "expected three radii"},
      {"radii = [0.1, 0.2, 0.3]", "radii = [0.1, 0.2, 0]", "expected a length above 0"},
      {"axis = [\"arm_L\", \"hand_L\"]", "axis = [\"arm_L\", \"hand_L\", [0, 0, 0]]",
       "a cone has two points"},
      {"radius = [0.07, 0.04]", "radius = [0.07, 0.04, 0.1]", "expected one or two radii"},
      {"cap = [0.01, 0.02]", "cap = [0.01]", "expected [start, end]"},
      {"front = [0, 0, 3]", "front = [3, 0, 0.1]", "`front` runs along the axis"},
      {"sections = [[0, 0.1, 0.2], [1, 0.2, 0.1]]", "sections = []", "a loft without sections"},
      {"shape = \"loft\"\naxis = [\"root\"", "shape = \"loft\"\ncut = true\naxis = [\"root\"",
       "the first part of a group cannot be a cut"},
  };
  for (const auto& c : cases) {
    std::string text = kEveryKey;
    const std::size_t at = text.find(c.what);
    ASSERT_NE(at, std::string::npos) << c.what;
    text.replace(at, std::string(c.what).size(), c.instead);
    try {
      read_text(text);
      ADD_FAILURE() << c.instead << " passed";
    } catch (const CharacterError& error) {
      EXPECT_NE(std::string(error.what()).find(c.message), std::string::npos)
          << c.instead << " gave: " << error.what();
    }
  }
  // An axis that runs along `front` in its middle alone.
  std::string middle = kEveryKey;
  const std::string axis = "axis = [[0, 0, 0], [1, 0, 0]]";
  middle.replace(middle.find(axis), axis.size(),
                 "axis = [[0, 0, 0], [0, 3, 0], [0, 3, 0.5], [0, 3, 1], [0, 3, 1.5], [0, 6, 1.5]]");
  EXPECT_THROW(read_text(middle), CharacterError);
  // The ends of the ranges themselves are taken.
  std::string text = kEveryKey;
  for (const auto& [what, instead] :
       {std::pair("vertices = 1234", "vertices = 500"), std::pair("finest = 0.4", "finest = 1.25"),
        std::pair("square = 3", "square = 8"), std::pair("count = 4", "count = 2000"),
        std::pair("blend = 0.031", "blend = 0")})
    text.replace(text.find(what), std::string(what).size(), instead);
  EXPECT_NO_THROW(read_text(text));
}

}  // namespace
}  // namespace backbend::skin
