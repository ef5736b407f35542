// What a stage shows of a file.
#include "validate/stage/stage.h"

#include <gtest/gtest.h>

#include "tests/skin/stick_figure.h"

namespace backbend::validate {
namespace {

TEST(Stage, ShowsTheFigureWhoseSpineItMovesAndNoOther) {
  skin::Character both = skin::stick_figure();
  const std::size_t own_triangles = both.triangles.size();
  const auto own_vertices = static_cast<std::uint32_t>(both.vertex_count());
  // A second one, behind the first in the file and 3 beside it; a part for each.
  const skin::Character one = both;
  std::vector<int> copy(one.nodes.size(), -1);
  for (std::size_t n = 1; n < one.nodes.size(); ++n) {
    const skin::Node& node = one.nodes[n];
    copy[n] =
        skin::add_node(both, "other_" + node.name, copy[static_cast<std::size_t>(node.parent)],
                       glm::dvec3(node.world_from_node[3]) + glm::dvec3(3.0, 0.0, 0.0));
    skin::stick_vertex(both, copy[n]);
  }
  const auto triangles = static_cast<std::uint32_t>(own_triangles);
  both.parts = {{"first", 0, 0, triangles, 0, own_vertices},
                {"second", 0, triangles, triangles, own_vertices, own_vertices}};
  ASSERT_EQ(both.triangles.size(), 2 * own_triangles);

  const auto shown = [&](const std::string& hip, const std::string& head) {
    skin::AnatomyHints hints;
    hints.hip = hip;
    hints.chest = head;
    return std::make_unique<Stage>(both, skin::find_anatomy(both, hints));
  };
  const auto first_stage = shown("hips", "spine_2"),
             second_stage = shown("other_hips", "other_spine_2");
  const skin::Character &first = first_stage->character(), &second = second_stage->character();
  // Cameras look at the one that is shown.
  EXPECT_LT(first_stage->bounds(first_stage->rest()).high.x, 1.5);
  EXPECT_GT(second_stage->bounds(second_stage->rest()).low.x, 1.5);
  EXPECT_EQ(first.triangles, one.triangles);
  EXPECT_EQ(first.vertex_count(), both.vertex_count());
  EXPECT_EQ(first.parts[0].triangle_count, triangles);
  EXPECT_EQ(first.parts[1].triangle_count, 0u);
  ASSERT_EQ(second.triangles.size(), own_triangles);
  EXPECT_EQ(second.triangles[0], one.triangles[0] + own_vertices);
  EXPECT_EQ(second.parts[0].triangle_count, 0u);
  EXPECT_EQ(second.parts[1].first_triangle, 0u);
  EXPECT_EQ(second.parts[1].triangle_count, triangles);
}

}  // namespace
}  // namespace backbend::validate
