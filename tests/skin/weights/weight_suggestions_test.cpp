#include "skin/weights/weight_suggestions.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/skin/stick_figure.h"

namespace backbend::skin {
namespace {

TEST(WeightSuggestions, NameEachChangeThatHygieneCallsForAndNoOther) {
  Character figure = stick_figure();
  const Anatomy anatomy = find_anatomy(figure);
  const auto find = [&](const std::string& code) -> std::optional<WeightSuggestion> {
    for (const auto& one : suggest_weights(figure, judge_weights(figure, anatomy)))
      if (one.code == code) return one;
    return std::nullopt;
  };
  EXPECT_FALSE(find("prune_tiny"));
  EXPECT_FALSE(find("keep_four"));
  EXPECT_FALSE(find("renormalise"));
  ASSERT_GT(figure.joints.size(), 6u);

  Influences many;
  many.joint = {0, 1, 2, 3, 4, 5};
  many.weight = {0.5f, 0.25f, 0.125f, 0.0625f, 0.05859375f, 0.00390625f};  // sums to 1
  figure.influences[3] = figure.influences[5] = many;
  for (const char* code : {"prune_tiny", "keep_four"}) {
    const auto found = find(code);
    ASSERT_TRUE(found) << code;
    EXPECT_EQ(found->count, 2u);
    EXPECT_FALSE(found->places);
    EXPECT_EQ(found->vertex, 3u);
    EXPECT_EQ(found->moves, std::string(code) == "keep_four" ? 0.0625 : 0.00390625);
  }

  figure.renormalised_vertices = 2;
  figure.worst_weight_sum = 0.75;
  const auto sums = find("renormalise");
  ASSERT_TRUE(sums);
  EXPECT_EQ(sums->count, 2u);
  EXPECT_EQ(sums->vertex, std::nullopt);  // which they were is not kept
  EXPECT_EQ(sums->moves, 0.25);
}

/// All of them at once, in the order in which they should be done.
class AllSuggestions : public ::testing::Test {
 protected:
  std::vector<WeightSuggestion> all() const {
    Character figure = stick_figure();
    figure.unweighted = {7, 8, 9};
    figure.influences[3].joint = {0, 1};
    figure.influences[3].weight = {0.99609375f, 0.00390625f};
    WeightHygiene hygiene;
    hygiene.off_sum = 1234;
    hygiene.worst_sum = 1.5;
    hygiene.bleed = {{stick_node(figure, "neck"), 1, 4, 0.0625f},
                     {stick_node(figure, "head"), 2, 5, 0.125f}};
    hygiene.asymmetric = 6;
    hygiene.worst_asymmetric_vertex = 10;
    hygiene.worst_asymmetry = 0.5;
    return suggest_weights(figure, hygiene);
  }
};

TEST_F(AllSuggestions, AreOneLineEach) {
  EXPECT_EQ(
      suggestions_text(all()),
      "  renormalise       divide each vertex's weights by their sum (1.5 at worst): 1 234 "
      "vertices, up to 50 % of one's weight\n"
      "  weight_unweighted give vertices without weights those of their nearest weighted "
      "neighbours: 3 vertices (vertex 7), up to 100 % of one's weight\n"
      "  remove_bleed      take 'neck' off 1 place apart from its area, and give the rest to "
      "the joints there: 1 place (vertex 4), up to 6.3 % of one's weight\n"
      "  remove_bleed      take 'head' off 2 places apart from its area, and give the rest to "
      "the joints there: 2 places (vertex 5), up to 12.5 % of one's weight\n"
      "  prune_tiny        drop weights below 0.01 and renormalise: 1 vertex (vertex 3), up to "
      "0.4 % of one's weight\n"
      "  mirror            copy the better painted side's weights to the other; they differ by "
      "over 5 %: 6 places (vertex 10), up to 50 % of one's weight\n"
      "  nothing was changed");
  EXPECT_EQ(suggestions_text({}), "  nothing to change");
}

TEST_F(AllSuggestions, AreJsonWithTheSameFacts) {
  const auto told = nlohmann::json::parse(suggestions_json("a.glb", all()));
  EXPECT_EQ(told["schema"], "backbend.suggest/1");
  EXPECT_EQ(told["file"], "a.glb");
  const auto& list = told["suggestions"];
  ASSERT_EQ(list.size(), 6u);
  EXPECT_EQ(list[0]["code"], "renormalise");
  EXPECT_EQ(list[0]["vertices"], 1234);
  EXPECT_TRUE(list[0]["vertex"].is_null());
  EXPECT_EQ(list[1]["vertex"], 7);
  EXPECT_EQ(list[3]["places"], 2);
  EXPECT_FALSE(list[3].contains("vertices"));
  EXPECT_EQ(list[3]["largest_share"], 0.125);
  EXPECT_EQ(list[5]["change"].get<std::string>().find("copy the better painted side"), 0u);
}

}  // namespace
}  // namespace backbend::skin
