// What made a finding: planted changes on a small figure, hidden among harmless ones.
#include "validate/why/why.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "skin/body/body.h"
#include "tests/battery/body_variants.h"
#include "tests/battery/weight_faults.h"
#include "tests/battery/why_cases.h"
#include "tests/skin/body_figure.h"
#include "validate/verdicts/checks.h"

namespace backbend::battery {
namespace {

using namespace validate;

const skin::Character& why_figure() {
  static const skin::Character body = welded(skin::make_body(skin::figure()));
  return body;
}
skin::AnatomyHints hints() {
  skin::AnatomyHints out;
  out.hip = "hips";
  out.chest = "chest";
  return out;
}
Version version(const char* label, skin::Character body, const char* rig = "even") {
  return {label, std::move(body), hints(), std::nullopt, read_rig(rig)};
}
skin::Character with_weight_fault(double size = 50) {
  skin::Character body = why_figure();
  Draw draw(3, 1);
  plant(body, skin::find_anatomy(body, hints()), "half torso one up", size, draw);
  return body;
}
WhyPair why_of(Version before, Version after) {
  Progress none(Progress::Style::none);
  return why(VersionPair(std::move(before), std::move(after)), {}, none);
}

TEST(Why, NamesTheWeightsWithTheirJointAndVertices) {
  const skin::Character spoiled = with_weight_fault();
  const WhyPair found = why_of(version("a", why_figure()), version("b", spoiled));
  EXPECT_EQ(found.changed, bit(Ingredient::weights));
  ASSERT_FALSE(found.findings.empty());
  for (const WhyFinding& each : found.findings) {
    EXPECT_EQ(each.ingredients, bit(Ingredient::weights)) << each.key;
    ASSERT_FALSE(each.vertices.empty());
    for (const std::uint32_t v : each.vertices) {
      const auto a = weights_of(why_figure().influences[v]), b = weights_of(spoiled.influences[v]);
      EXPECT_NE(a, b) << v;
    }
  }
}

TEST(Why, IsNotMisledByVerticesInAnotherOrderOrAnotherBindSpace) {
  skin::Character spoiled = with_weight_fault();
  Draw draw(5, 1);
  shuffle_vertices(spoiled, draw);
  change_bind_space(spoiled, glm::scale(glm::dmat4(1.0), glm::dvec3(2.0)));
  const VersionPair pair(version("a", why_figure()), version("b", spoiled));
  EXPECT_EQ(pair.changed() & bit(Ingredient::bind), 0u);
  EXPECT_EQ(pair.changed() & bit(Ingredient::skeleton), 0u);
  EXPECT_DOUBLE_EQ(pair.coverage(), 1.0);
  Progress none(Progress::Style::none);
  const WhyPair found = why(pair, {}, none);
  ASSERT_FALSE(found.findings.empty());
  for (const WhyFinding& each : found.findings)
    EXPECT_EQ(each.ingredients, bit(Ingredient::weights)) << each.key;
}

/// A vertical cut through the body's middle.
void cut(skin::Character& body) { split_vertices(body, glm::dvec3(0.0), {1.0, 0.0, 0.2}); }

TEST(Why, IsNotMisledByVerticesThatAnExportSplitOrMerged) {
  skin::Character spoiled = with_weight_fault(), split = why_figure();
  cut(split);
  ASSERT_GT(split.vertex_count(), why_figure().vertex_count() + 10);
  Draw draw(6, 1);
  shuffle_vertices(spoiled, draw);
  skin::Character split_spoiled = with_weight_fault();
  cut(split_spoiled);
  for (const auto& [before, after] :
       {std::pair(why_figure(), split_spoiled), std::pair(split, spoiled)}) {
    const VersionPair pair(version("a", before), version("b", after));
    EXPECT_DOUBLE_EQ(pair.coverage(), 1.0);
    Progress none(Progress::Style::none);
    const WhyPair found = why(pair, {}, none);
    ASSERT_FALSE(found.findings.empty());
    for (const WhyFinding& each : found.findings)
      EXPECT_EQ(each.ingredients, bit(Ingredient::weights)) << each.key;
  }
  EXPECT_TRUE(why_of(version("a", why_figure()), version("b", split)).findings.empty());
  EXPECT_TRUE(why_of(version("a", split), version("b", why_figure())).findings.empty());
}

TEST(Why, TellsVerticesThatWereMovedAndRenumberedFromChangedWeights) {
  skin::Character moved = why_figure();
  // A belt of the torso pushed up by more than its vertices are apart.
  for (glm::vec3& p : moved.bind_position)
    if (p.y > 1.05f && p.y < 1.25f) p.y += 0.08f;
  Draw draw(8, 1);
  shuffle_vertices(moved, draw);
  const VersionPair pair(version("a", why_figure()), version("b", moved));
  EXPECT_EQ(pair.changed(), bit(Ingredient::mesh));
  EXPECT_DOUBLE_EQ(pair.coverage(), 1.0);
}

TEST(Why, BooksAValueAtItsLimitToWhatMadeItAndNotToAHair) {
  const char* rig = "curve:basis=linear";
  skin::Character hair = why_figure();
  for (glm::vec3& p : hair.bind_position)
    if (p.y > 1.05f && p.y < 1.25f) p.z += 1e-4f;
  const Failures plain = failures_of(version("a", why_figure(), rig), {}),
                 other = failures_of(version("b", hair, rig), {});
  int tried = 0;
  for (const auto& [key, finding] : plain) {
    if (tried > 0) break;
    if (find_check(finding.code)->subject != Subject::mesh || !other.contains(key)) continue;
    const Finding& changed = other.at(key);
    if (finding.value == changed.value || finding.limit != changed.limit) continue;
    // The limit lies between the two values: the hair decides whether the check fails.
    const bool hair_is_worse = excess(*find_check(finding.code), changed.value, finding.limit) >
                               excess(*find_check(finding.code), finding.value, finding.limit);
    const double single = find_check(finding.code)->limit;
    WhySettings settings;
    settings.limits[finding.code] = 0.5 * (finding.value + changed.value) * single / finding.limit;
    const skin::Character &less = hair_is_worse ? why_figure() : hair,
                          &more = hair_is_worse ? hair : why_figure();
    if (failures_of(version("a", less, rig), settings).contains(key)) continue;
    Progress none(Progress::Style::none);
    const WhyPair found =
        why(VersionPair(version("a", less), version("b", more, rig)), settings, none);
    for (const WhyFinding& each : found.findings) {
      if (each.key != key) continue;
      EXPECT_EQ(each.ingredients, bit(Ingredient::options)) << key;
      ++tried;
    }
  }
  EXPECT_GT(tried, 0);
}

TEST(Why, NamesTheOptionAndLeavesTheOthersOut) {
  const WhyPair found =
      why_of(version("a", why_figure(), "curve:bones=10"),
             version("b", why_figure(), "curve:bones=11,length=rest,follow=chase"));
  EXPECT_EQ(found.changed, bit(Ingredient::options));
  bool by_length = false;
  for (const WhyFinding& each : found.findings) {
    EXPECT_EQ(each.ingredients, bit(Ingredient::options));
    by_length |= each.options == std::vector<std::string>{"length"};
  }
  EXPECT_TRUE(by_length);
}

TEST(Why, HasNothingToSayOfHarmlessChanges) {
  skin::Character other = why_figure();
  Draw draw(5, 1);
  shuffle_vertices(other, draw);
  rename_joints(other, 0);
  skin::AnatomyHints none_said = hints();
  EXPECT_TRUE(why_of(version("a", why_figure()), version("b", why_figure())).findings.empty());
  Version renamed = version("b", other);
  // Under their new names.
  const skin::Anatomy anatomy = skin::find_anatomy(why_figure(), hints());
  renamed.hints.hip = other.nodes[static_cast<std::size_t>(anatomy.spine.front())].name;
  renamed.hints.chest = other.nodes[static_cast<std::size_t>(anatomy.chest)].name;
  const WhyPair found = why_of(version("a", why_figure()), renamed);
  EXPECT_TRUE(found.findings.empty());
  EXPECT_EQ(found.changed & bit(Ingredient::skeleton), 0u);
  EXPECT_EQ(found.changed & bit(Ingredient::weights), 0u);
}

TEST(Why, MixturesOfAllAndNoneAreTheVersionsThemselves) {
  const VersionPair pair(version("a", why_figure()), version("b", with_weight_fault()));
  EXPECT_EQ(pair.mixed(0).label, "a");
  EXPECT_EQ(pair.mixed(pair.changed()).label, "b");
  const Failures alone =
      failures_of(pair.mixed(bit(Ingredient::weights) | bit(Ingredient::mesh)), {});
  const Failures whole = failures_of(pair.after(), {});
  ASSERT_EQ(alone.size(), whole.size());
  for (const auto& [key, finding] : whole) EXPECT_EQ(alone.at(key).value, finding.value) << key;
}

TEST(Why, RefusesBodiesThatShareTooFewVertices) {
  skin::Character other = why_figure();
  subdivide(other);
  for (glm::vec3& p : other.bind_position) p *= glm::vec3(1.3f, 1.0f, 1.3f);
  try {
    VersionPair(version("a.glb", why_figure()), version("b.glb", other));
    FAIL();
  } catch (const skin::CharacterError& error) {
    EXPECT_NE(std::string(error.what()).find("b.glb: only"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("90 %"), std::string::npos);
  }
}

Failures failing(double value) {
  Finding finding;
  finding.code = "BB010";
  finding.sweep = "extension";
  finding.value = value;
  finding.limit = 2.0;
  if (value <= 2.0) return {};
  return {{"BB010 extension", finding}};
}

TEST(FirstBad, IsFoundInTheLogarithmOfTheCount) {
  for (std::size_t count : {3, 7, 40, 64}) {
    for (std::size_t bad = 1; bad < count; ++bad) {
      const auto found = first_bad(count, [&](std::size_t i) { return failing(i >= bad ? 9 : 1); });
      ASSERT_TRUE(found.has_value());
      EXPECT_EQ(found->bad, bad);
      EXPECT_EQ(found->good, bad - 1);
      EXPECT_LE(found->steps, static_cast<std::size_t>(std::ceil(std::log2(count)))) << count;
    }
  }
}

TEST(FirstBad, SkipsWhatCannotBeMeasuredAndSaysSo) {
  const auto found = first_bad(10, [&](std::size_t i) -> Failures {
    if (i == 4 || i == 5) throw skin::CharacterError("v" + std::to_string(i) + ": broken");
    return failing(i >= 5 ? 9 : 1);
  });
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->good, 3u);
  EXPECT_EQ(found->bad, 6u);
  EXPECT_EQ(found->skipped.size(), 2u);
}

TEST(FirstBad, IsNoneWhereTheLastIsAsGoodAsTheFirst) {
  EXPECT_FALSE(first_bad(5, [](std::size_t) { return failing(1); }).has_value());
  EXPECT_FALSE(first_bad(5, [](std::size_t) { return failing(9); }).has_value());
}

}  // namespace
}  // namespace backbend::battery
