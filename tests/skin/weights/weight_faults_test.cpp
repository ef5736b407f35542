// Faults of weights planted on real characters are found and named with their size; their healthy
// variants have none. The table of what was found is printed.
#include "skin/weights/weight_faults.h"
#include "skin/weights/skin_places.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_inverse.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <set>

#include "skin/anatomy/body_kind.h"
#include "skin/anatomy/import_checks.h"
#include "skin/anatomy/mirror_image.h"
#include "skin/character/weld.h"
#include "skin/deform/skinning.h"
#include "skin/gltf/gltf_reader.h"
#include "tests/skin/planted_weights.h"
#include "tests/skin/shared_characters.h"
#include "tests/skin/stick_figure.h"

namespace backbend::skin {
namespace {

// As the table of checks has them: BB063 to BB069 and BB075, as shares.
constexpr double kWrongSide = 0.07, kFar = 0.05, kAsymmetry = 0.2, kOrder = 0.06, kSeam = 0.2,
                 kBindOff = 0.001, kHardBorder = 0.5, kOffBones = 0.04;

bool is_clean(const Character& character) {
  const Anatomy anatomy = find_anatomy(character);
  const WeightFaults faults = find_weight_faults(character, anatomy);
  const auto off = joints_bound_off(character);
  return faults.wrong_side.worst() <= kWrongSide && faults.far.worst() <= kFar &&
         faults.asymmetry.worst() <= kAsymmetry && faults.order.worst() <= kOrder &&
         faults.seams.worst() <= kSeam && faults.borders.worst() <= kHardBorder &&
         faults.levels.worst() <= kOffBones &&
         (off.empty() || off.front().shift <= kBindOff * anatomy.height);
}

bool names(const WeightAnswer& answer, double limit, int node) {
  for (const WeightFault& fault : answer.faults)
    if (fault.value > limit && (fault.node == node || fault.other == node)) return true;
  return false;
}

/// From the hips to the chest, of length 1.
glm::dvec3 torso_axis(const Character& character, const Anatomy& anatomy) {
  const auto at = [&](std::size_t k) {
    return glm::dvec3(
        character.nodes[static_cast<std::size_t>(anatomy.spine[k])].world_from_node[3]);
  };
  return glm::normalize(at(anatomy.chest_index) - at(0));
}

/// Tries of one kind and size, and how many were found.
std::map<std::pair<std::string, double>, std::pair<int, int>>& table() {
  static std::map<std::pair<std::string, double>, std::pair<int, int>> rows;
  return rows;
}
void count(const std::string& kind, double size, bool found) {
  auto& [hits, tries] = table()[{kind, size}];
  hits += found;
  ++tries;
}

class PlantedWeights : public ::testing::TestWithParam<const char*> {
 public:
  static void TearDownTestSuite() {
    for (const auto& [row, hits] : table())
      std::printf("  %-28s %6.2f  %d of %d\n", row.first.c_str(), row.second, hits.first,
                  hits.second);
  }
};

TEST_P(PlantedWeights, OfHealthyVariantsAreClean) {
  REQUIRE_CHARACTER(GetParam());
  const Character character = read_character(shared_character(GetParam()));
  const auto clean = [&](const char* kind, double size, const Character& variant) {
    const bool is = is_clean(variant);
    count(std::string("clean, flagged: ") + kind, size, !is);
    const WeightFaults faults = find_weight_faults(variant, find_anatomy(variant));
    EXPECT_TRUE(is) << kind << " " << size << ": " << faults.wrong_side.worst() << " "
                    << faults.far.worst() << " " << faults.asymmetry.worst() << " "
                    << faults.order.worst() << " " << faults.seams.worst() << " "
                    << faults.borders.worst() << " " << faults.levels.worst();
  };
  clean("as it is", 0, character);
  clean("smoothed, times", 2, smoothed(character, 2));
  for (const std::size_t places : {500u, 2000u, 5000u})
    if (character.place_count > places)
      clean("decimated, places", static_cast<double>(places), decimated(character, places));
  clean("subdivided, times", 1, subdivided(character));
  const Anatomy anatomy = find_anatomy(character);
  for (const std::size_t joints : {10u, 16u, 24u})
    if (joints > anatomy.chest_index + 1)
      clean("spine of so many joints", static_cast<double>(joints),
            with_dense_spine(character, anatomy, joints));
  for (const double factor : {0.01, 2.54, 100.0})
    clean("scaled", factor, scaled(character, factor));
}

TEST_P(PlantedWeights, AreFoundOnRealCharacters) {
  REQUIRE_CHARACTER(GetParam());
  const Character character = read_character(shared_character(GetParam()));
  const Anatomy anatomy = find_anatomy(character);
  if (anatomy.left_arm.size() < 3 || anatomy.right_arm.size() < 3 || anatomy.chest_index < 2)
    GTEST_SKIP() << "no arms to plant on";
  // The first arm joint below the clavicle that moves most: twist helpers move little.
  std::map<int, double> weight;
  for (const Influences& influences : character.influences)
    for (std::size_t k = 0; k < kMaxInfluences; ++k)
      weight[character.joints[influences.joint[k]].node] += influences.weight[k];
  std::size_t upper = 1;
  if (weight[anatomy.left_arm[2]] > 2.0 * weight[anatomy.left_arm[1]]) upper = 2;
  const int vertebra = anatomy.spine[std::max<std::size_t>(1, anatomy.chest_index / 2)];
  const int next = anatomy.spine[std::max<std::size_t>(1, anatomy.chest_index / 2) + 1];
  // An animal's head may hang beside its vertebrae, and wide weights may reach down to them.
  bool head_is_apart = body_kind(character, anatomy).kind == BodyKind::human;
  for (const Influences& influences : character.influences) {
    double on_head = 0.0, on_vertebra = 0.0;
    for (std::size_t k = 0; k < kMaxInfluences; ++k) {
      const int node = character.joints[influences.joint[k]].node;
      if (node == anatomy.head) on_head += influences.weight[k];
      if (node == vertebra) on_vertebra += influences.weight[k];
    }
    head_is_apart = head_is_apart && (on_head < 0.01 || on_vertebra < 0.01);
  }
  const auto planted = [&](int from, int to, double share, int on = 0) {
    Character spoiled = character;
    move_weight(spoiled, anatomy, from, to, share, on);
    return spoiled;
  };
  const auto faults_of = [&](const Character& spoiled) {
    return find_weight_faults(spoiled, anatomy);
  };
  for (const double share : {0.05, 0.1, 0.2, 0.5}) {
    const bool gross = share >= 0.1;
    const int other_arm = anatomy.right_arm[upper];
    const WeightFaults side = faults_of(planted(anatomy.left_arm[upper], other_arm, share));
    bool found = names(side.wrong_side, kWrongSide, other_arm) ||
                 names(side.asymmetry, kAsymmetry, other_arm) || names(side.far, kFar, other_arm);
    count("arm on the other side's", share, found);
    if (gross) {
      EXPECT_TRUE(found) << share;
    }
    if (gross && side.wrong_side.worst() > 0.0) {
      EXPECT_LE(side.wrong_side.worst(), 1.1 * share);   // of a body that is nearly symmetric
      EXPECT_GE(side.wrong_side.worst(), 0.75 * share);  // no place has all of its weight there
    }
    const WeightFaults hand = faults_of(planted(vertebra, anatomy.left_arm.back(), share));
    found = names(hand.far, kFar, anatomy.left_arm.back());
    count("vertebra on a hand", share, found);
    if (gross) {
      EXPECT_TRUE(found) << share;
    }
    if (anatomy.head >= 0)
      count("vertebra on the head", share,
            names(faults_of(planted(vertebra, anatomy.head, share)).far, kFar, anatomy.head));
    for (const auto& [kind, node] :
         {std::pair("patch of a vertebra on the head", anatomy.head),
          std::pair("patch of a vertebra on a thigh",
                    anatomy.left_leg.empty() ? -1 : anatomy.left_leg.front()),
          std::pair("patch of a vertebra on a hand", anatomy.left_arm.back())}) {
      if (node < 0 || weight[node] <= 0.0) continue;
      Character spoiled = character;
      spill_weight(spoiled, vertebra, node, share);
      found = names(faults_of(spoiled).far, kFar, node);
      count(kind, share, found);
      // Thighs begin beside the lowest vertebrae. Half of the weight makes an area of its own.
      if (gross && share < 0.5 && node == anatomy.head && head_is_apart) {
        EXPECT_TRUE(found) << kind << " " << share;
      }
    }
    const WeightFaults root = faults_of(planted(anatomy.left_arm[2], anatomy.spine[0], share));
    count("arm on the hips", share,
          names(root.far, kFar, anatomy.spine[0]) ||
              names(root.asymmetry, kAsymmetry, anatomy.spine[0]));
    const WeightFaults up = faults_of(planted(vertebra, next, share, 1));
    if (up.asymmetry.not_applicable.empty()) {
      found = names(up.asymmetry, kAsymmetry, vertebra) || names(up.asymmetry, kAsymmetry, next);
      count("left half one vertebra up", share, found);
      if (share >= 0.5) {
        EXPECT_TRUE(found) << share;
      }
      const int clavicle = anatomy.left_arm[0];
      const WeightFaults moved = faults_of(planted(clavicle, vertebra, share));
      found = names(moved.asymmetry, kAsymmetry, clavicle);
      count("clavicle on a vertebra", share, found);
      if (share >= 0.5) {
        EXPECT_TRUE(found) << share;
      }
    } else {
      EXPECT_NE(up.asymmetry.not_applicable.find("symmetric"), std::string::npos);
    }
  }
  for (std::size_t k = 1; k < anatomy.chest_index; ++k) {
    Character spoiled = character;
    swap_weights(spoiled, anatomy.spine[k], anatomy.spine[k + 1]);
    double all = 0.0;
    for (const auto& [node, sum] : weight) all += sum;
    const auto at = [&](std::size_t joint) {
      return glm::dvec3(
          character.nodes[static_cast<std::size_t>(anatomy.spine[joint])].world_from_node[3]);
    };
    // A tip that moves next to nothing has no middle to speak of, nor do joints in one place, and
    // a tail fin ends where it begins.
    if (k + 2 == anatomy.spine.size()) continue;
    if (glm::distance(at(k), at(k + 1)) < 0.05 * anatomy.spine_length) continue;
    if (std::min(weight[anatomy.spine[k]], weight[anatomy.spine[k + 1]]) < 0.003 * all) continue;
    const bool found = names(faults_of(spoiled).order, kOrder, anatomy.spine[k]);
    count("neighbours swapped", 1, found);
    EXPECT_TRUE(found) << k;
  }
  for (const double angle : {1.0, 2.0, 5.0, 10.0})
    for (const int node : {vertebra, anatomy.left_arm[0]}) {
      Character spoiled = character;
      turn_bind(spoiled, node, angle);
      const auto off = joints_bound_off(spoiled);
      const bool found =
          !off.empty() && off.front().node == node && off.front().shift > kBindOff * anatomy.height;
      count("bind pose off, degrees", angle, found);
      if (angle >= 5.0) {
        EXPECT_TRUE(found) << angle;
      }
      if (found) {
        EXPECT_NEAR(off.front().angle_deg, angle, 0.05 * angle);
      }
    }
}

TEST_P(PlantedWeights, AVertebraSmearedWhollyIntoItsNeighbourIsNamed) {
  REQUIRE_CHARACTER(GetParam());
  const Character character = read_character(shared_character(GetParam()));
  const Anatomy anatomy = find_anatomy(character);
  const auto at = [&](std::size_t k) {
    return glm::dvec3(
        character.nodes[static_cast<std::size_t>(anatomy.spine[k])].world_from_node[3]);
  };
  if (std::string(GetParam()) == "bunny.glb")
    GTEST_SKIP() << "a torso so wide that the surface does not tell one bone from the next";
  for (std::size_t k = 2; k < anatomy.chest_index; ++k) {
    // Nor does it of short bones.
    if (glm::distance(at(k), at(k + 1)) < 0.2 * anatomy.spine_length) continue;
    for (const std::size_t to : {k - 1, k + 1}) {
      Character spoiled = character;
      move_weight(spoiled, anatomy, anatomy.spine[k], anatomy.spine[to], 1.0);
      const WeightFaults faults = find_weight_faults(spoiled, anatomy);
      const bool found = names(faults.order, kOrder, anatomy.spine[k]) ||
                         names(faults.order, kOrder, anatomy.spine[to]);
      count("vertebra smeared wholly", 1, found);
      EXPECT_TRUE(found) << k << " into " << to;
    }
  }
}

/// Each vertex that two joints share goes wholly to the one that has more of it.
Character with_hard_border(const Character& character, int lower, int upper) {
  Character out = character;
  for (Influences& influences : out.influences) {
    std::array<float, kMaxInfluences>& weight = influences.weight;
    std::size_t low = kMaxInfluences, high = kMaxInfluences;
    for (std::size_t k = 0; k < kMaxInfluences && weight[k] > 0.0f; ++k) {
      if (character.joints[influences.joint[k]].node == lower) low = k;
      if (character.joints[influences.joint[k]].node == upper) high = k;
    }
    if (low == kMaxInfluences || high == kMaxInfluences) continue;
    const std::size_t from = weight[low] < weight[high] ? low : high;
    weight[from == low ? high : low] += weight[from];
    influences.joint[from] = influences.joint[from == low ? high : low];
    weight[from] = 0.0f;
    // Unused places stand last.
    for (std::size_t k = from; k + 1 < kMaxInfluences && weight[k + 1] > 0.0f; ++k) {
      std::swap(weight[k], weight[k + 1]);
      std::swap(influences.joint[k], influences.joint[k + 1]);
    }
  }
  return out;
}

TEST_P(PlantedWeights, AHardBorderBetweenVertebraeThatBlendElsewhereIsNamed) {
  REQUIRE_CHARACTER(GetParam());
  const Character character = read_character(shared_character(GetParam()));
  const Anatomy anatomy = find_anatomy(character);
  if (body_kind(character, anatomy).kind != BodyKind::human)
    GTEST_SKIP() << "few vertices along its bones, or few bones with weight";
  int asked = 0;
  for (std::size_t k = 1; k < anatomy.chest_index; ++k) {
    const int lower = anatomy.spine[k], upper = anatomy.spine[k + 1];
    const WeightFaults faults =
        find_weight_faults(with_hard_border(character, lower, upper), anatomy);
    ASSERT_EQ(faults.borders.not_applicable, "");
    ++asked;
    const bool found = names(faults.borders, kHardBorder, lower);
    count("hard border", 1, found);
    EXPECT_TRUE(found) << k << ": " << faults.borders.worst();
  }
  EXPECT_GT(asked, 0);
}

TEST(HardBorders, AreNotAskedOfABodyThatIsBoundRigidlyThroughout) {
  REQUIRE_CHARACTER("mh_male_13k.glb");
  Character character = read_character(shared_character("mh_male_13k.glb"));
  const Anatomy anatomy = find_anatomy(character);
  for (Influences& influences : character.influences) {
    influences.weight = {};
    influences.weight[0] = 1.0f;
  }
  const WeightAnswer borders = find_weight_faults(character, anatomy).borders;
  EXPECT_TRUE(borders.faults.empty());
  EXPECT_NE(borders.not_applicable.find("are soft"), std::string::npos);
}

/// The skin's joint of a node, which it may get here.
std::uint16_t skin_joint(Character& character, int node) {
  const auto found = std::find_if(character.joints.begin(), character.joints.end(),
                                  [&](const SkinJoint& each) { return each.node == node; });
  const auto at = static_cast<std::uint16_t>(found - character.joints.begin());
  if (found == character.joints.end()) character.joints.push_back({node, {}});
  return at;
}

TEST_P(PlantedWeights, WeightLeftToAJointAboveTheHipsIsNamed) {
  REQUIRE_CHARACTER(GetParam());
  Character character = read_character(shared_character(GetParam()));
  const Anatomy anatomy = find_anatomy(character);
  const int above = character.nodes[static_cast<std::size_t>(anatomy.spine[0])].parent;
  ASSERT_GE(above, 0);
  skin_joint(character, above);
  const int vertebra = anatomy.spine[std::max<std::size_t>(1, anatomy.chest_index / 2)];
  const std::size_t places = move_weight(character, anatomy, vertebra, above, 0.2);
  // Bodies of few vertices leave such a joint a patch that is as large as a vertebra's.
  if (character.place_count < 1500 || static_cast<double>(places) < 0.05 * character.place_count)
    GTEST_SKIP() << "a vertebra of " << places << " places";
  EXPECT_TRUE(names(find_weight_faults(character, anatomy).far, kFar, above));
}

/// Gives a joint a share of a vertex's weight; the others keep their proportions.
void give(Influences& in, std::uint16_t joint, float share) {
  for (float& weight : in.weight) weight *= 1.0F - share;
  // Largest first, and the first unused place ends the list.
  std::size_t k = 0;
  while (k + 1 < in.weight.size() && in.weight[k] >= share) ++k;
  std::copy_backward(in.weight.begin() + static_cast<std::ptrdiff_t>(k), in.weight.end() - 1,
                     in.weight.end());
  std::copy_backward(in.joint.begin() + static_cast<std::ptrdiff_t>(k), in.joint.end() - 1,
                     in.joint.end());
  in.joint[k] = joint;
  in.weight[k] = share;
}

/// A body with its root in the skin, and places of it that are given weight of that root.
struct RootPatch {
  Character character = decimated(read_character(shared_character("mh_male_13k.glb")), 2000);
  Anatomy anatomy = find_anatomy(character);
  std::vector<glm::vec3> place = rest_mesh(character).position;  // the body faces +Z
  int above = character.nodes[static_cast<std::size_t>(anatomy.spine[0])].parent;
  std::uint16_t root = skin_joint(character, above);
  std::size_t places = 0;

  double share() const {
    return static_cast<double>(places) / static_cast<double>(character.place_count);
  }
  /// The vertex that a joint of the spine moves and that lies furthest along a direction.
  glm::vec3 furthest(std::size_t joint, const glm::vec3& direction) const {
    glm::vec3 best(0.0F);
    float most = -1e9F;
    for (std::size_t v = 0; v < place.size(); ++v)
      if (character.joints[character.influences[v].joint[0]].node == anatomy.spine[joint] &&
          glm::dot(place[v], direction) > most) {
        most = glm::dot(place[v], direction);
        best = place[v];
      }
    return best;
  }
  bool is_named(const glm::vec3& middle, float reach, bool on_both_sides, float weight) {
    Character spoiled = character;
    places = 0;
    for (std::size_t v = 0; v < place.size(); ++v) {
      const glm::vec3 at(on_both_sides ? std::abs(place[v].x) : place[v].x, place[v].y, place[v].z);
      if (glm::distance(at, middle) > reach) continue;
      give(spoiled.influences[v], root, weight);
      ++places;
    }
    return names(find_weight_faults(spoiled, anatomy).far, kFar, above);
  }
};

TEST(WeightLeftToAJointAboveTheHips, IsNamedOnAFewPlacesWhereBothSidesDoNotHaveItAlike) {
  REQUIRE_CHARACTER("mh_male_13k.glb");
  RootPatch patch;
  ASSERT_GE(patch.above, 0);
  const glm::vec3 side = patch.furthest(3, {1, 0, 0});
  EXPECT_TRUE(patch.is_named(side, 0.07F, false, 0.2F)) << patch.places;
  ASSERT_GE(patch.places, 12u);
  ASSERT_LT(patch.share(), 0.02);
  // As low bodies leave it along the belly.
  EXPECT_FALSE(patch.is_named(side, 0.04F, true, 0.2F)) << patch.places;
  ASSERT_GE(patch.places, 6u);
  ASSERT_LT(patch.share(), 0.009);
}

TEST(WeightLeftToAJointAboveTheHips, IsNamedOnBothSidesAndOnTheNeckWhereItIsHeld) {
  REQUIRE_CHARACTER("mh_male_13k.glb");
  RootPatch patch;
  ASSERT_GE(patch.above, 0);
  const glm::vec3 side = patch.furthest(3, {1, 0, 0});
  EXPECT_TRUE(patch.is_named(side, 0.07F, true, 0.1F)) << patch.places;
  ASSERT_LT(patch.share(), 0.02);
  // Smoothing spreads what a belly has, thinly.
  EXPECT_FALSE(patch.is_named(side, 0.07F, true, 0.07F)) << patch.places;
  const glm::vec3 nape = patch.furthest(patch.anatomy.chest_index + 1, {0, 0, -1});
  EXPECT_TRUE(patch.is_named(nape, 0.07F, false, 0.2F)) << patch.places;
}

/// Puts a joint elsewhere, with the mesh and what hangs from it where they were.
void put_joint(Character& character, int node, const glm::dvec3& by) {
  const auto n = static_cast<std::size_t>(node);
  const glm::dmat4 old = character.nodes[n].world_from_node;
  const glm::dmat4 now = glm::translate(glm::dmat4(1.0), by) * old;
  character.nodes[n].world_from_node = now;
  for (SkinJoint& joint : character.joints)
    if (joint.node == node) joint.joint_from_mesh = glm::inverse(now) * old * joint.joint_from_mesh;
}

TEST(Asymmetry, OfTheTorsoIsFoundWhereHandsStandDifferently) {
  REQUIRE_CHARACTER("mh_male_13k.glb");
  const Character plain = read_character(shared_character("mh_male_13k.glb"));
  const Anatomy anatomy = find_anatomy(plain);
  Character hands = plain;
  const glm::dvec3 by = 0.03 * anatomy.height * anatomy.forward;
  put_joint(hands, anatomy.left_arm.back(), by);
  EXPECT_EQ(find_weight_faults(hands, anatomy).asymmetry.not_applicable, "");
  EXPECT_LE(find_weight_faults(hands, anatomy).asymmetry.worst(), kAsymmetry);
  for (std::size_t k = anatomy.chest_index; k-- > 0;)
    move_weight(hands, anatomy, anatomy.spine[k], anatomy.spine[k + 1], 1.0, 1);
  EXPECT_GT(find_weight_faults(hands, anatomy).asymmetry.worst(), kAsymmetry);
  // A spine that stands aside has no two sides to compare.
  Character aside = plain;
  put_joint(aside, anatomy.spine[2], 0.03 * anatomy.height * anatomy.left);
  EXPECT_NE(find_weight_faults(aside, anatomy).asymmetry.not_applicable, "");
}

TEST(Asymmetry, OfTheTorsoIsFoundBesideAJointThatHasNoOtherSide) {
  REQUIRE_CHARACTER("mh_male_13k.glb");
  const Character plain = read_character(shared_character("mh_male_13k.glb"));
  const Anatomy anatomy = find_anatomy(plain);
  // A rope on the left of the back: half of the weight of what is near it.
  const auto with_rope = [&](double reach, double share) {
    Character out = plain;
    const glm::dvec3 at(plain.nodes[static_cast<std::size_t>(anatomy.spine[1])].world_from_node[3]);
    const glm::dvec3 rope = at + anatomy.height * (0.06 * anatomy.left - 0.05 * anatomy.forward);
    const int node = add_node(out, "rope", anatomy.spine[1], rope);
    const SkinJoint& known = plain.joints.front();
    const glm::dmat4 world_from_mesh =
        plain.nodes[static_cast<std::size_t>(known.node)].world_from_node * known.joint_from_mesh;
    out.joints.push_back(
        {node, glm::affineInverse(out.nodes[static_cast<std::size_t>(node)].world_from_node) *
                   world_from_mesh});
    const auto joint = static_cast<std::uint16_t>(out.joints.size() - 1);
    const std::vector<glm::vec3> rest = rest_mesh(plain).position;
    for (std::size_t v = 0; v < rest.size(); ++v)
      if (glm::distance(glm::dvec3(rest[v]), rope) < reach * anatomy.height)
        give(out.influences[v], joint, static_cast<float>(share));
    return out;
  };
  Character roped = with_rope(0.06, 0.5);
  EXPECT_EQ(find_weight_faults(roped, anatomy).asymmetry.not_applicable, "");
  EXPECT_LE(find_weight_faults(roped, anatomy).asymmetry.worst(), kAsymmetry);
  for (std::size_t k = anatomy.chest_index; k-- > 0;)
    move_weight(roped, anatomy, anatomy.spine[k], anatomy.spine[k + 1], 1.0, 1);
  EXPECT_GT(find_weight_faults(roped, anatomy).asymmetry.worst(), kAsymmetry);
  // Not where it holds much of the body.
  const std::string told =
      find_weight_faults(with_rope(2.0, 0.5), anatomy).asymmetry.not_applicable;
  EXPECT_NE(told.find("'rope' has no mirror image"), std::string::npos) << told;
}

TEST(Asymmetry, OfTheTorsoIsFoundUnderALimbWhoseSidesAreNotAlike) {
  REQUIRE_CHARACTER("mh_male_13k.glb");
  const Character plain = read_character(shared_character("mh_male_13k.glb"));
  const Anatomy anatomy = find_anatomy(plain);
  const std::vector<glm::vec3> rest = rest_mesh(plain).position;
  // A gauntlet on the left, or a hunch: what these joints move stands out by a share of the height.
  const auto swollen = [&](const std::vector<int>& joints, double by) {
    Character out = plain;
    for (std::size_t v = 0; v < out.influences.size(); ++v) {
      const auto& in = out.influences[v];
      if (glm::dot(glm::dvec3(rest[v]), anatomy.left) < 0.0) continue;
      for (std::size_t k = 0; k < in.weight.size(); ++k)
        if (std::ranges::count(joints, out.joints[in.joint[k]].node) > 0)
          out.bind_position[v] += glm::vec3(by * anatomy.height * in.weight[k] * anatomy.up);
    }
    return out;
  };
  std::vector<int> arm{*(anatomy.left_arm.end() - 2)};  // from the elbow on, with the fingers
  for (std::size_t n = 0; n < plain.nodes.size(); ++n)
    if (std::ranges::count(arm, plain.nodes[n].parent) > 0) arm.push_back(static_cast<int>(n));
  Character gauntlet = swollen(arm, 0.05);
  EXPECT_EQ(find_weight_faults(gauntlet, anatomy).asymmetry.not_applicable, "");
  EXPECT_LE(find_weight_faults(gauntlet, anatomy).asymmetry.worst(), kAsymmetry);
  for (std::size_t k = anatomy.chest_index; k-- > 0;)
    move_weight(gauntlet, anatomy, anatomy.spine[k], anatomy.spine[k + 1], 1.0, 1);
  EXPECT_GT(find_weight_faults(gauntlet, anatomy).asymmetry.worst(), kAsymmetry);
  // A torso whose sides are not alike says nothing.
  const std::string told =
      find_weight_faults(swollen(anatomy.spine, 0.03), anatomy).asymmetry.not_applicable;
  EXPECT_NE(told.find("the body is not symmetric"), std::string::npos) << told;
}

TEST(Asymmetry, OnFewPlacesOfACoarseMeshIsAFaultWhereItIsPlain) {
  REQUIRE_CHARACTER("alpaca.glb");
  Character coarse = read_character(shared_character("alpaca.glb"));
  const Anatomy anatomy = find_anatomy(coarse);
  const Mirror mirror = mirror_of(coarse, anatomy);
  const std::vector<glm::vec3> rest = rest_mesh(coarse).position;
  const int left = anatomy.left_arm[0], right = anatomy.right_arm[0];
  const int chest = anatomy.spine[anatomy.chest_index];
  // Both clavicles move eight places each, and one of them eight in the middle.
  move_weight(coarse, anatomy, left, chest, 1.0);
  move_weight(coarse, anatomy, right, chest, 1.0);
  const glm::dvec3 joint(coarse.nodes[static_cast<std::size_t>(left)].world_from_node[3]);
  std::map<double, glm::dvec3> aside, middle;  // by how far from the clavicle
  for (const glm::vec3& place : rest) {
    const glm::dvec3 at(place);
    const double off = glm::dot(at - mirror.middle, mirror.left);
    if (off > 0.02 * anatomy.height) aside[glm::distance(at, joint)] = at;
    if (std::abs(off) < 1e-5 * anatomy.height) middle[glm::distance(at, joint)] = at;
  }
  ASSERT_GE(middle.size(), 8u);
  const double in_mesh = glm::distance(coarse.bind_position.front(), coarse.bind_position.back()) /
                         glm::distance(rest.front(), rest.back());  // its unit against the world's
  const auto with = [&](float on_left, float on_right, int node_of_middle = -1, int count = 8,
                        bool alike = true) {
    Character out = coarse;
    for (std::size_t v = 0; v < rest.size() && !alike; ++v) {
      const glm::dvec3 at(rest[v]);
      if (glm::dot(at - mirror.middle, mirror.left) < 0.0)
        out.bind_position[v] +=
            glm::vec3(in_mesh * 0.003 * anatomy.height * std::sin(40.0 * at.y / anatomy.height));
    }
    const auto give_near = [&](const std::map<double, glm::dvec3>& places, bool mirrored, int node,
                               float share) {
      for (auto place = places.begin(); place != std::next(places.begin(), count); ++place)
        for (std::size_t v = 0; v < rest.size(); ++v)
          if (glm::distance(glm::dvec3(rest[v]), mirrored ? mirror(place->second) : place->second) <
              1e-4 * anatomy.height)
            give(out.influences[v], skin_joint(out, node), share);
    };
    give_near(aside, false, left, on_left);
    give_near(aside, true, right, on_right);
    if (node_of_middle >= 0) give_near(middle, false, node_of_middle, 0.6F);
    return find_weight_faults(out, anatomy);
  };
  EXPECT_LE(with(0.6F, 0.6F).asymmetry.worst(), kAsymmetry);
  // Automatic weights differ so.
  EXPECT_LE(with(0.6F, 0.4F).asymmetry.worst(), kAsymmetry);
  EXPECT_TRUE(names(with(0.6F, 0.3F).asymmetry, kAsymmetry, right));
  EXPECT_TRUE(names(with(0.4F, 0.2F, -1, 24).asymmetry, kAsymmetry, right));
  // Sides that are not built alike were painted one by one.
  EXPECT_EQ(with(0.4F, 0.2F, -1, 24, false).asymmetry.not_applicable, "");
  EXPECT_LE(with(0.4F, 0.2F, -1, 24, false).asymmetry.worst(), kAsymmetry);
  EXPECT_TRUE(names(with(0.6F, 0.2F, -1, 24, false).asymmetry, kAsymmetry, right));
  // What is in the middle lies on neither side.
  for (const int node : {left, right}) {
    const WeightFaults faults = with(0.6F, 0.6F, node);
    EXPECT_TRUE(names(faults.asymmetry, kAsymmetry, node == left ? right : left));
    EXPECT_FALSE(names(faults.wrong_side, kWrongSide, node));
  }
}

TEST(OffBones, AreVertebraeThatEachHaveTheWeightsOfTheNext) {
  for (const char* file :
       {"mh_male_13k.glb", "mh_female_cmu_13k.glb", "quaternius_female_24k.glb", "bunny.glb"}) {
    SCOPED_TRACE(file);
    REQUIRE_CHARACTER(file);
    const Character character = read_character(shared_character(file));
    const Anatomy anatomy = find_anatomy(character);
    EXPECT_EQ(find_weight_faults(character, anatomy).levels.worst(), 0.0);
    const std::size_t chest = anatomy.chest_index;
    Character up = character, down = character;
    for (std::size_t k = chest; k-- > 0;)
      move_weight(up, anatomy, anatomy.spine[k], anatomy.spine[k + 1], 1.0);
    for (std::size_t k = 1; k <= chest; ++k)
      move_weight(down, anatomy, anatomy.spine[k], anatomy.spine[k - 1], 1.0);
    for (const Character* moved : {&up, &down}) {
      const WeightAnswer levels = find_weight_faults(*moved, anatomy).levels;
      ASSERT_EQ(levels.faults.size(), 1u);
      EXPECT_GT(levels.worst(), 0.06);
      const auto index = [&](int node) {
        return std::ranges::find(anatomy.spine, node) - anatomy.spine.begin();
      };
      const WeightFault& fault = levels.faults.front();
      EXPECT_EQ(index(fault.other) - index(fault.node), moved == &up ? -1 : 1);
    }
  }
}

TEST(OffBones, AreNotVertebraeThatLeadNowhere) {
  REQUIRE_CHARACTER("mh_male_13k.glb");
  Character coarse = read_character(shared_character("mh_male_13k.glb"));
  const Anatomy anatomy = find_anatomy(coarse);
  const std::size_t chest = anatomy.chest_index;
  move_weight(coarse, anatomy, anatomy.spine[1], anatomy.spine[0], 1.0);
  for (std::size_t k = 2; k < chest; ++k)
    move_weight(coarse, anatomy, anatomy.spine[k], anatomy.spine[chest], 1.0);
  move_weight(coarse, anatomy, anatomy.spine[0], anatomy.spine[chest - 1], 0.3);
  EXPECT_EQ(find_weight_faults(coarse, anatomy).levels.worst(), 0.0);
  // Where it leads it counts: the weights of the hips are far below its bone.
  move_weight(coarse, anatomy, anatomy.spine[0], anatomy.spine[chest - 1], 0.8);
  EXPECT_GT(find_weight_faults(coarse, anatomy).levels.worst(), kOffBones);
}

TEST(OffBones, AreAskedOfTheBoneBelowEachJointWhereTheSpineHangsFromItsChest) {
  REQUIRE_CHARACTER("mh_male_13k.glb");
  Character hanging = read_character(shared_character("mh_male_13k.glb"));
  const Anatomy anatomy = find_anatomy(hanging);
  for (std::size_t k = 0; k < anatomy.chest_index; ++k)
    hanging.nodes[static_cast<std::size_t>(anatomy.spine[k])].parent = anatomy.spine[k + 1];
  hanging.nodes[static_cast<std::size_t>(anatomy.chest)].parent = -1;
  EXPECT_GT(find_weight_faults(hanging, anatomy).levels.worst(), kOffBones);
  for (std::size_t k = anatomy.chest_index; k-- > 0;)
    move_weight(hanging, anatomy, anatomy.spine[k], anatomy.spine[k + 1], 1.0);
  EXPECT_LE(find_weight_faults(hanging, anatomy).levels.worst(), kOffBones);
}

/// A ball of places that one joint moves, bound at rest.
void add_ball(Character& character, const glm::vec3& middle, float radius, int node) {
  constexpr int kAround = 12, kUp = 7;
  const auto first = static_cast<std::uint32_t>(character.vertex_count());
  character.joints.push_back(
      {node, glm::affineInverse(character.nodes[static_cast<std::size_t>(node)].world_from_node)});
  Influences influences;
  influences.joint[0] = static_cast<std::uint16_t>(character.joints.size() - 1);
  influences.weight[0] = 1.0F;
  for (int i = 0; i < kUp; ++i)
    for (int k = 0; k < kAround; ++k) {
      const float up = 3.0F * (static_cast<float>(i) + 0.5F) / kUp - 1.5F;
      const float around = 6.2831853F * static_cast<float>(k) / kAround;
      const glm::vec3 way(std::cos(up) * std::cos(around), std::sin(up),
                          std::cos(up) * std::sin(around));
      character.bind_position.push_back(middle + radius * way);
      character.bind_normal.push_back(way);
      character.influences.push_back(influences);
      character.place.push_back(character.place_count++);
      const auto at = [&](int row, int column) {
        return first + static_cast<std::uint32_t>(row * kAround + column % kAround);
      };
      if (i + 1 == kUp) continue;
      character.triangles.emplace_back(at(i, k), at(i, k + 1), at(i + 1, k));
      character.triangles.emplace_back(at(i, k + 1), at(i + 1, k + 1), at(i + 1, k));
    }
}

/// A stick figure whose body is of balls: chest, upper arms that rise to the head, shins of three
/// and feet that hang from the hips, as feet with a target of their own do. The head's ball is
/// bound to `head`.
Character ball_figure(const char* head) {
  Character character = stick_figure(3);
  const auto node = [&](const char* name) { return stick_node(character, name); };
  for (const char* name : {"foot.L", "foot.R"})
    character.nodes[static_cast<std::size_t>(node(name))].parent = node("hips");
  add_ball(character, {0.0F, 1.15F, 0.0F}, 0.2F, node("spine_3"));
  add_ball(character, {0.0F, 1.7F, 0.12F}, 0.28F, node(head));
  for (const char side : {'L', 'R'}) {
    const float left = side == 'L' ? 1.0F : -1.0F;
    const auto on = [&](const char* name) {
      return node((std::string(name) + "." + side).c_str());
    };
    add_ball(character, {0.33F * left, 1.53F, 0.12F}, 0.1F, on("arm"));
    add_ball(character, {0.7F * left, 1.35F, 0.0F}, 0.05F, on("hand"));
    for (const float down : {0.4F, 0.23F, 0.06F})  // the first at the knee
      add_ball(character, {0.1F * left, down, 0.0F}, 0.05F, on("shin"));
    add_ball(character, {0.1F * left, -0.02F, 0.06F}, 0.03F, on("foot"));
  }
  return character;
}

TEST(FarInfluence, OfAHeadOrAShinThatIsOfPiecesIsNone) {
  const auto is_far = [](const Character& character, const char* name) {
    const WeightAnswer far = find_weight_faults(character, find_anatomy(character)).far;
    return std::ranges::any_of(far.faults, [&](const WeightFault& fault) {
      return fault.node == stick_node(character, name) && fault.value > kFar;
    });
  };
  for (const char* name : {"head", "shin.L", "shin.R"})
    EXPECT_FALSE(is_far(ball_figure("head"), name)) << name;
  EXPECT_TRUE(is_far(ball_figure("shin.R"), "shin.R"));
}

TEST(FarInfluence, OfAPropInAHandIsNoneWhereverItsPivotIs) {
  const Character character = ball_figure("head");
  for (const glm::dvec3& pivot : {glm::dvec3(0.7, 0.6, 0.6), glm::dvec3(0.7, 1.35, 0.0)})
    for (const bool in_hand : {true, false}) {  // or at the other hand
      Character armed = character;
      const int prop = add_node(armed, "prop", stick_node(armed, "hand.L"), pivot);
      add_ball(armed, {in_hand ? 0.78F : -0.78F, 1.35F, 0.0F}, 0.03F, prop);
      EXPECT_EQ(names(find_weight_faults(armed, find_anatomy(armed)).far, kFar, prop), !in_hand)
          << pivot.y;
    }
}

TEST(FarInfluence, OfAPropOfSeveralShellsIsJudgedAsOne) {
  // A spear of two shells: one at a hand, one that touches a shin.
  const auto is_named = [](float hand, bool one_part) {
    Character armed = ball_figure("head");
    const int spear =
        add_node(armed, "spear", stick_node(armed, "hand.L"), glm::dvec3(0.7, 1.35, 0.0));
    const auto add = [&](const glm::vec3& at) {
      Part part;
      part.first_vertex = static_cast<std::uint32_t>(armed.vertex_count());
      part.first_triangle = static_cast<std::uint32_t>(armed.triangles.size());
      add_ball(armed, at, 0.03F, spear);
      part.vertex_count = static_cast<std::uint32_t>(armed.vertex_count()) - part.first_vertex;
      part.triangle_count =
          static_cast<std::uint32_t>(armed.triangles.size()) - part.first_triangle;
      armed.parts.push_back(part);
    };
    add({0.78F * hand, 1.35F, 0.0F});
    add({0.18F, 0.23F, 0.0F});
    if (one_part) {
      const Part tip = armed.parts.back();
      armed.parts.pop_back();
      armed.parts.back().vertex_count += tip.vertex_count;
      armed.parts.back().triangle_count += tip.triangle_count;
    }
    return names(find_weight_faults(armed, find_anatomy(armed)).far, kFar, spear);
  };
  for (const bool one_part : {true, false}) {  // exporters write a part for each material
    EXPECT_FALSE(is_named(1.0F, one_part));
    EXPECT_TRUE(is_named(-1.0F, one_part));  // at the other hand
  }
}

TEST(FarInfluence, OfAnObjectThatHangsOnAJointIsThatOfTheJoint) {
  // Head and hat are meshes without a skin, each on a node below a node below a joint.
  const auto is_far = [](const char* carrier, bool as_skins) {
    Character figure = ball_figure("spine_3");
    const auto object = [&](const char* name, int joint, const glm::vec3& at, float radius) {
      const int group = add_node(figure, name, joint, glm::dvec3(at));
      const int node = add_node(figure, std::string(name) + "_mesh", group, glm::dvec3(at));
      Part part;
      part.first_vertex = static_cast<std::uint32_t>(figure.vertex_count());
      part.first_triangle = static_cast<std::uint32_t>(figure.triangles.size());
      add_ball(figure, at, radius, node);
      part.vertex_count = static_cast<std::uint32_t>(figure.vertex_count()) - part.first_vertex;
      part.triangle_count =
          static_cast<std::uint32_t>(figure.triangles.size()) - part.first_triangle;
      figure.parts.push_back(part);
      if (as_skins) return node;  // as baked
      figure.joints.back().joint_from_mesh = glm::dmat4(1.0);
      for (std::size_t v = part.first_vertex; v < figure.vertex_count(); ++v)
        figure.bind_position[v] -= at;
      return node;
    };
    object("head_object", stick_node(figure, "head"), {0.0F, 1.95F, 0.12F}, 0.25F);
    const int hat = add_node(figure, "hat", stick_node(figure, carrier), glm::dvec3(0, 1.9, 0));
    figure.joints.push_back({hat, glm::translate(glm::dmat4(1.0), glm::dvec3(0, -1.9, 0))});
    const int mesh = object("hat_object", hat, {0.0F, 2.25F, 0.12F}, 0.1F);
    return names(find_weight_faults(figure, find_anatomy(figure)).far, kFar, mesh);
  };
  for (const bool as_skins : {false, true}) {
    EXPECT_FALSE(is_far("head", as_skins));
    EXPECT_TRUE(is_far("hips", as_skins));
  }
}

TEST(FarInfluence, OfAJointThatLeadsHardlyAnywhereIsNoAreaOfItsOwn) {
  REQUIRE_CHARACTER("mh_male_13k.glb");
  // A hip bone's largest weight after smoothing is 0.45: a patch of 0.29 is more than half of it.
  Character character =
      smoothed(decimated(read_character(shared_character("mh_male_13k.glb")), 2000), 2);
  const Anatomy anatomy = find_anatomy(character);
  const int hip_bone = anatomy.right_leg.front();
  const std::uint16_t joint = skin_joint(character, hip_bone);
  const std::vector<glm::vec3> place = rest_mesh(character).position;
  EXPECT_FALSE(names(find_weight_faults(character, anatomy).far, kFar, hip_bone));
  const glm::vec3 middle(0.08F, 1.23F, 0.12F);  // the left of the chest
  std::size_t places = 0;
  for (std::size_t v = 0; v < place.size(); ++v)
    if (glm::distance(place[v], middle) < 0.12F) {
      give(character.influences[v], joint, 0.29F);
      ++places;
    }
  ASSERT_GE(places, 12u);
  const WeightFaults faults = find_weight_faults(character, anatomy);
  EXPECT_TRUE(names(faults.far, kFar, hip_bone) || names(faults.wrong_side, kWrongSide, hip_bone));
}

/// The first triangle once more, as a part of its own that one joint moves.
void add_patch(Character& character, int node) {
  character.parts.push_back({"patch", 0, static_cast<std::uint32_t>(character.triangles.size()), 1,
                             static_cast<std::uint32_t>(character.vertex_count()), 3});
  const glm::uvec3 corners = character.triangles.front();
  const auto first = static_cast<std::uint32_t>(character.vertex_count());
  character.triangles.emplace_back(first, first + 1, first + 2);
  Influences whole;
  whole.joint[0] = static_cast<std::uint16_t>(character.joints.size());
  whole.weight[0] = 1.0F;
  character.joints.push_back({node, {}});
  for (int k = 0; k < 3; ++k) {
    character.bind_position.push_back(character.bind_position[corners[k]]);
    character.bind_normal.push_back(character.bind_normal[corners[k]]);
    if (!character.uv.empty()) character.uv.push_back(character.uv[corners[k]]);
    character.influences.push_back(whole);
    character.place.push_back(character.place[corners[k]]);
  }
}

/// The vertices that `chosen` takes and the triangles between them once more, as a part of its own
/// that lies 1 % of the height in front of the body (which faces +Z). Its first vertex.
template <class Chosen>
std::size_t add_piece(Character& character, double height, const Chosen& chosen) {
  const std::size_t first = character.vertex_count(), triangles = character.triangles.size();
  const std::vector<glm::vec3> rest = rest_mesh(character).position;
  std::map<std::uint32_t, std::uint32_t> copy_of, copy_of_place;
  for (std::uint32_t v = 0; v < first; ++v) {
    if (!chosen(rest[v])) continue;
    copy_of[v] = static_cast<std::uint32_t>(character.vertex_count());
    character.bind_position.push_back(character.bind_position[v] +
                                      glm::vec3(0.0F, 0.0F, 0.01F * static_cast<float>(height)));
    character.bind_normal.push_back(character.bind_normal[v]);
    if (!character.uv.empty()) character.uv.push_back(character.uv[v]);
    character.influences.push_back(character.influences[v]);
    const auto [place, is_new] = copy_of_place.insert(
        {character.place[v], static_cast<std::uint32_t>(character.place_count)});
    character.place_count += is_new;
    character.place.push_back(place->second);
  }
  for (std::size_t t = 0; t < triangles; ++t) {
    const glm::uvec3 corner = character.triangles[t];
    if (copy_of.count(corner.x) && copy_of.count(corner.y) && copy_of.count(corner.z))
      character.triangles.emplace_back(copy_of[corner.x], copy_of[corner.y], copy_of[corner.z]);
  }
  character.parts.push_back({"piece", 0, static_cast<std::uint32_t>(triangles),
                             static_cast<std::uint32_t>(character.triangles.size() - triangles),
                             static_cast<std::uint32_t>(first),
                             static_cast<std::uint32_t>(character.vertex_count() - first)});
  return first;
}

TEST(WeightLeftToAJointAboveTheHips, IsNamedWhereItIsMuchOfTheTorsoThoughLittleOfAll) {
  REQUIRE_CHARACTER("mh_male_13k.glb");
  RootPatch patch;
  ASSERT_GE(patch.above, 0);
  const auto head = static_cast<float>(
      patch.character.nodes[static_cast<std::size_t>(patch.anatomy.head)].world_from_node[3].y);
  for (int layer = 0; layer < 6; ++layer)  // a mask of many places
    add_piece(patch.character, patch.anatomy.height,
              [&](const glm::vec3& at) { return at.y > head; });
  patch.place = rest_mesh(patch.character).position;
  const glm::vec3 side = patch.furthest(3, {1, 0, 0});
  EXPECT_TRUE(patch.is_named(side, 0.085F, true, 0.2F)) << patch.places;
  ASSERT_LT(patch.share(), 0.009);
  EXPECT_FALSE(patch.is_named(side, 0.085F, true, 0.09F)) << patch.places;
}

TEST(FarInfluence, OfAPieceOfCostumeCountsWhereItIsNotBoundSoAsAWhole) {
  REQUIRE_CHARACTER("mh_male_13k.glb");
  const Character natural = decimated(read_character(shared_character("mh_male_13k.glb")), 4000);
  Character dressed = with_dense_spine(natural, find_anatomy(natural), 16);
  const Anatomy anatomy = find_anatomy(dressed);
  const auto node_at = [&](int node) {
    return glm::vec3(dressed.nodes[static_cast<std::size_t>(node)].world_from_node[3]);
  };
  const int low = anatomy.spine[anatomy.chest_index / 4];
  const int high = anatomy.spine[anatomy.chest_index - 2];
  const auto height = static_cast<float>(anatomy.height);
  const std::size_t first = add_piece(dressed, anatomy.height, [&](const glm::vec3& at) {
    return at.z > node_at(low).z && std::abs(at.x - node_at(low).x) < 0.06F * height &&
           std::abs(at.y - node_at(low).y) < 0.04F * height;
  });
  EXPECT_FALSE(names(find_weight_faults(dressed, anatomy).far, kFar, high));
  const auto joint = static_cast<std::uint16_t>(
      std::find_if(dressed.joints.begin(), dressed.joints.end(),
                   [&](const SkinJoint& each) { return each.node == high; }) -
      dressed.joints.begin());
  const std::vector<glm::vec3> rest = rest_mesh(dressed).position;
  for (const bool whole : {true, false}) {
    Character bound = dressed;
    std::size_t places = 0;
    for (std::size_t v = first; v < bound.vertex_count(); ++v) {
      if (!whole && rest[v].x > node_at(low).x) continue;
      Influences& in = bound.influences[v];
      in.joint = {in.joint[0], joint};
      in.weight = {0.85F, 0.15F};
      ++places;
    }
    ASSERT_GE(places, 20u);
    EXPECT_EQ(names(find_weight_faults(bound, anatomy).far, kFar, high), !whole) << places;
  }
}

TEST(FarInfluence, OfASkirtThatMovesAsTheBodyBelowItIsNone) {
  REQUIRE_CHARACTER("mh_male_13k.glb");
  const Character natural = read_character(shared_character("mh_male_13k.glb"));
  Character dressed = with_dense_spine(natural, find_anatomy(natural), 16);
  const Anatomy anatomy = find_anatomy(dressed);
  const glm::vec3 hips =
      dressed.nodes[static_cast<std::size_t>(anatomy.spine[0])].world_from_node[3];
  const auto height = static_cast<float>(anatomy.height);
  // The left thigh's weight fades up the belly's left, over a quarter of the height.
  const auto thigh = static_cast<std::uint16_t>(
      std::find_if(dressed.joints.begin(), dressed.joints.end(),
                   [&](const SkinJoint& each) { return each.node == anatomy.left_leg.front(); }) -
      dressed.joints.begin());
  const std::vector<glm::vec3> rest = rest_mesh(dressed).position;
  const auto is_belly = [&](const glm::vec3& at) {
    return at.z > hips.z && at.x > hips.x && at.x < hips.x + 0.1F * height && at.y > hips.y &&
           at.y < hips.y + 0.25F * height;
  };
  for (std::size_t v = 0; v < rest.size(); ++v) {
    if (!is_belly(rest[v])) continue;
    Influences& in = dressed.influences[v];
    const float share = 0.45F * (1.0F - (rest[v].y - hips.y) / (0.25F * height));
    in.joint = {in.joint[0], thigh};
    in.weight = {1.0F - share, share};
  }
  ASSERT_LE(find_weight_faults(dressed, anatomy).far.worst(), kFar);
  add_piece(dressed, anatomy.height,
            [&](const glm::vec3& at) { return is_belly(at) && at.y > hips.y + 0.05F * height; });
  EXPECT_LE(find_weight_faults(dressed, anatomy).far.worst(), kFar);
}

TEST(FarInfluence, OfAPatchThatTheOtherSideHasNowhereNearIsNamedBesideTheJointsArea) {
  REQUIRE_CHARACTER("mh_male_13k.glb");
  const Character character = read_character(shared_character("mh_male_13k.glb"));
  const Anatomy anatomy = find_anatomy(character);
  // The thighs; the legs' first joints start where the hips do.
  const int left = anatomy.left_leg[1], right = anatomy.right_leg[1];
  const auto joint = [&](int node) {
    return static_cast<std::uint16_t>(
        std::find_if(character.joints.begin(), character.joints.end(),
                     [&](const SkinJoint& each) { return each.node == node; }) -
        character.joints.begin());
  };
  const std::vector<glm::vec3> rest = rest_mesh(character).position;
  const glm::vec3 vertebra =
      character.nodes[static_cast<std::size_t>(anatomy.spine[3])].world_from_node[3];
  const auto height = static_cast<float>(anatomy.height);
  const glm::vec3 middle = vertebra + glm::vec3(0.07F, 0.0F, 0.05F) * height;
  for (const bool both : {false, true}) {
    Character spoiled = character;
    std::size_t places = 0;
    for (std::size_t v = 0; v < rest.size(); ++v) {
      const glm::vec3 at(both ? std::abs(rest[v].x) : rest[v].x, rest[v].y, rest[v].z);
      const float far = glm::distance(at, middle) / (0.06F * height);
      if (far >= 1.0F) continue;
      give(spoiled.influences[v], joint(rest[v].x > 0.0F ? left : right),
           0.15F * (1.0F - far * far));
      ++places;
    }
    ASSERT_GE(places, 30u);
    EXPECT_EQ(names(find_weight_faults(spoiled, anatomy).far, kFar, left), !both) << places;
  }
}

/// Gives each side of the body, from a vertex on, the weights of the other.
void exchange_sides(Character& character, const Anatomy& anatomy, std::size_t first = 0) {
  const std::vector<int> image = mirrored_nodes(character, mirror_of(character, anatomy));
  for (std::size_t v = first; v < character.vertex_count(); ++v)
    for (int k = 0; k < kMaxInfluences; ++k) {
      Influences& influences = character.influences[v];
      const int node = character.joints[influences.joint[k]].node;
      const auto other = std::ranges::find(character.joints, image[static_cast<std::size_t>(node)],
                                           &SkinJoint::node);
      if (influences.weight[k] > 0.0f && other != character.joints.end())
        influences.joint[k] = static_cast<std::uint16_t>(other - character.joints.begin());
    }
}

TEST(WrongSide, OfLimbsWhoseWeightsAreSwappedIsNamed) {
  REQUIRE_CHARACTER("mh_male_13k.glb");
  Character character = read_character(shared_character("mh_male_13k.glb"));
  const Anatomy anatomy = find_anatomy(character);
  exchange_sides(character, anatomy);
  const WeightAnswer wrong = find_weight_faults(character, anatomy).wrong_side;
  for (const auto* limb : {&anatomy.left_arm, &anatomy.right_arm, &anatomy.left_leg})
    EXPECT_TRUE(std::ranges::any_of(*limb, [&](int node) { return names(wrong, 0.9, node); }));
  EXPECT_FALSE(names(wrong, kWrongSide, anatomy.spine[2]));
}

TEST(WrongSide, OfAJointThatStandsInTheMiddleIsThatOfTheNext) {
  REQUIRE_CHARACTER("shark.glb");
  Character character = read_character(shared_character("shark.glb"));
  // The fins' first joints stand in the middle; a hair across it, as after a turn in floats.
  const int fins[] = {planted_node(character, "front_fin_0_l"),
                      planted_node(character, "front_fin_0_r")};
  put_joint(character, fins[0], {-1e-4, 0.0, 0.0});
  put_joint(character, fins[1], {1e-4, 0.0, 0.0});
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_LE(find_weight_faults(character, anatomy).wrong_side.worst(), kWrongSide);
  Character swapped = character;
  swap_weights(swapped, fins[0], fins[1]);
  EXPECT_TRUE(names(find_weight_faults(swapped, anatomy).wrong_side, 0.4, fins[0]));
  // What the other fin holds of a fin's side is found all the same.
  const glm::vec3 middle(
      character.nodes[static_cast<std::size_t>(planted_node(character, "front_fin_2_l"))]
          .world_from_node[3]);
  const std::vector<glm::vec3> rest = rest_mesh(character).position;
  for (std::size_t v = 0; v < rest.size(); ++v)
    if (glm::distance(rest[v], middle) < 0.1F * static_cast<float>(anatomy.height))
      give(character.influences[v], skin_joint(character, fins[1]), 0.5F);
  EXPECT_TRUE(names(find_weight_faults(character, anatomy).wrong_side, 0.4, fins[1]));
}

/// Where the vertebra halfway up to the chest stands.
glm::vec3 middle_vertebra(const Character& character, const Anatomy& anatomy) {
  const int vertebra = anatomy.spine[anatomy.chest_index / 2];
  return character.nodes[static_cast<std::size_t>(vertebra)].world_from_node[3];
}

TEST(FarInfluence, OfAPatchThatAFarJointMovesAloneIsNamed) {
  for (const char* file : {"mh_male_13k.glb", "quaternius_female_24k.glb"}) {
    SCOPED_TRACE(file);
    REQUIRE_CHARACTER(file);
    const Character character = read_character(shared_character(file));
    const Anatomy anatomy = find_anatomy(character);
    const std::vector<glm::vec3> rest = rest_mesh(character).position;
    const auto height = static_cast<float>(anatomy.height);
    const glm::vec3 middle =
        middle_vertebra(character, anatomy) + glm::vec3(0.02F, 0.0F, 0.07F) * height;
    // The hand, and the head; of the belly as much as a hand covers, and as the whole of it.
    for (const int node : {anatomy.left_arm.back(), anatomy.head})
      for (const float radius : {0.05F, 0.09F})
        for (const float share : {0.5F, 1.0F}) {
          Character spoiled = character;
          std::size_t places = 0;
          for (std::size_t v = 0; v < rest.size(); ++v) {
            if (glm::distance(rest[v], middle) >= radius * height) continue;
            give(spoiled.influences[v], skin_joint(spoiled, node), share);
            ++places;
          }
          ASSERT_GE(places, 30u);
          EXPECT_TRUE(names(find_weight_faults(spoiled, anatomy).far, kFar, node))
              << node << ", " << share << " of " << places;
        }
  }
}

TEST(FarInfluence, OfAPatchThatHoldsMoreOfAHandThanTheHandIsNamed) {
  REQUIRE_CHARACTER("mh_female_cmu_13k.glb");
  Character character = decimated(read_character(shared_character("mh_female_cmu_13k.glb")), 4000);
  const int hand = planted_node(character, "LeftHand");
  const auto largest = [&] {
    float most = 0.0F;
    for (const Influences& in : character.influences)
      for (std::size_t k = 0; k < kMaxInfluences; ++k)
        if (character.joints[in.joint[k]].node == hand) most = std::max(most, in.weight[k]);
    return most;
  };
  // So smooth that no place is the hand's by half.
  for (int times = 0; largest() >= 0.5F && times < 10; ++times) character = smoothed(character, 1);
  ASSERT_LT(largest(), 0.5F);
  const Anatomy anatomy = find_anatomy(character);
  const std::vector<glm::vec3> rest = rest_mesh(character).position;
  const auto reach = 0.14F * static_cast<float>(anatomy.height);
  const glm::vec3 belly = middle_vertebra(character, anatomy) + glm::vec3(0.0F, 0.0F, 0.6F * reach);
  const auto held = [&](const Character& body) {
    double sum = 0.0;
    for (const Influences& in : body.influences)
      for (std::size_t k = 0; k < kMaxInfluences; ++k)
        if (body.joints[in.joint[k]].node == hand) sum += in.weight[k];
    return sum;
  };
  Character spoiled = character;
  for (std::size_t v = 0; v < rest.size(); ++v) {
    const float far = glm::distance(rest[v], belly) / reach;
    if (far >= 1.0F) continue;
    // Of both hands alike: what only one side has would be found by that.
    const float share = 0.3F * (1.0F - far * far);
    give(spoiled.influences[v], skin_joint(spoiled, hand), share / (1.0F - share));
    give(spoiled.influences[v], skin_joint(spoiled, planted_node(character, "RightHand")), share);
  }
  ASSERT_GT(held(spoiled), 2.0 * held(character));
  const WeightAnswer far = find_weight_faults(spoiled, anatomy).far;
  const auto fault = std::ranges::find(far.faults, hand, &WeightFault::node);
  ASSERT_NE(fault, far.faults.end());
  EXPECT_GT(fault->value, 0.25);  // the patch's middle is named, not only its rim
}

TEST(FarInfluence, OfAPatchThatIsAsHeavyAsTheJointAnywhereIsNamed) {
  REQUIRE_CHARACTER("mh_female_cmu_13k.glb");
  Character character = decimated(read_character(shared_character("mh_female_cmu_13k.glb")), 4000);
  const Anatomy anatomy = find_anatomy(character);
  // A wrist that moves little of a hand: the fingers hold the rest.
  const int hand = planted_node(character, "LeftHand");
  move_weight(character, anatomy, hand, planted_node(character, "LeftForeArm"), 0.7);
  EXPECT_FALSE(names(find_weight_faults(character, anatomy).far, kFar, hand));
  spill_weight(character, anatomy.spine[anatomy.chest_index / 2], hand, 0.3);
  EXPECT_TRUE(names(find_weight_faults(character, anatomy).far, kFar, hand));
}

TEST(FarInfluence, OfFourPlacesIsNamedWhereItIsHeavyAndOfTwoThatTheJointMovesAlone) {
  // 40 % of a hand are about what the vertebra below keeps on the human: neither leads everywhere.
  for (const char* file : {"mh_male_13k.glb", "bunny.glb"}) {
    SCOPED_TRACE(file);
    REQUIRE_CHARACTER(file);
    const Character character = read_character(shared_character(file));
    const Anatomy anatomy = find_anatomy(character);
    const std::vector<glm::vec3> rest = rest_mesh(character).position;
    const glm::vec3 belly = middle_vertebra(character, anatomy) +
                            glm::vec3(0.0F, 0.0F, 0.1F * static_cast<float>(anatomy.height));
    std::map<float, std::uint32_t> place_at;  // by its distance
    for (std::size_t v = 0; v < rest.size(); ++v)
      place_at[glm::distance(rest[v], belly)] = character.place[v];
    for (const int places : {2, 4})
      for (const float share : {0.1F, 0.4F, 0.9F}) {
        std::set<std::uint32_t> chosen;
        for (auto at = place_at.begin(); static_cast<int>(chosen.size()) < places; ++at)
          chosen.insert(at->second);
        Character spoiled = character;
        const int hand = anatomy.left_arm.back();
        for (std::size_t v = 0; v < rest.size(); ++v)
          if (chosen.count(character.place[v]))
            give(spoiled.influences[v], skin_joint(spoiled, hand), share);
        EXPECT_EQ(names(find_weight_faults(spoiled, anatomy).far, kFar, hand),
                  (places == 4 && share > 0.2F) || share > 0.6F)
            << places << " places, " << share;
      }
  }
}

TEST(FarInfluence, OfAPieceOfCostumeIsNamedWhereAllThatItLiesOnIsFarFromItsJoint) {
  REQUIRE_CHARACTER("mh_male_13k.glb");
  const Character character = read_character(shared_character("mh_male_13k.glb"));
  const Anatomy anatomy = find_anatomy(character);
  const glm::vec3 hips =
      character.nodes[static_cast<std::size_t>(anatomy.spine.front())].world_from_node[3];
  const auto height = static_cast<float>(anatomy.height);
  // A pouch in front of the belly, bound as a whole.
  const auto with_pouch = [&](int node) {
    Character dressed = character;
    const std::size_t first = add_piece(dressed, anatomy.height, [&](const glm::vec3& at) {
      return at.z > hips.z && glm::distance(at, hips) < 0.12F * height;
    });
    for (std::size_t v = first; v < dressed.vertex_count(); ++v)
      give(dressed.influences[v], skin_joint(dressed, node), 1.0F);
    const WeightAnswer far = find_weight_faults(dressed, anatomy).far;
    for (const WeightFault& fault : far.faults) EXPECT_LT(fault.distance, anatomy.height);
    return names(far, kFar, node);
  };
  EXPECT_FALSE(with_pouch(anatomy.spine.front()));
  EXPECT_FALSE(with_pouch(anatomy.spine[1]));
  EXPECT_TRUE(with_pouch(anatomy.head));
  EXPECT_TRUE(with_pouch(anatomy.left_arm.back()));
}

/// A copy of the surface within `radius` (of the height) of its place nearest to `beside`, as a
/// piece bound to a joint.
Character with_bound_piece(const Character& character, double height, const glm::vec3& beside,
                           float radius, int node) {
  const std::vector<glm::vec3> rest = rest_mesh(character).position;
  const glm::vec3 middle = *std::ranges::min_element(
      rest, {}, [&](const glm::vec3& at) { return glm::distance(at, beside); });
  Character dressed = character;
  const std::size_t first = add_piece(dressed, height, [&](const glm::vec3& at) {
    return glm::distance(at, middle) < radius * static_cast<float>(height);
  });
  EXPECT_GE(dressed.vertex_count() - first, 12u);
  for (std::size_t v = first; v < dressed.vertex_count(); ++v) {
    dressed.influences[v] = {};
    give(dressed.influences[v], skin_joint(dressed, node), 1.0F);
  }
  return dressed;
}

TEST(OrderAlongTheSpine, IsNotAskedOfPiecesOfCostume) {
  REQUIRE_CHARACTER("mh_male_13k.glb");
  const Character character = read_character(shared_character("mh_male_13k.glb"));
  const Anatomy anatomy = find_anatomy(character);
  const int held_by = anatomy.spine[anatomy.chest_index - 1];
  const auto height = static_cast<float>(anatomy.height);
  Character dressed = character;
  for (const float side : {0.1F, -0.1F})  // pouches at both thighs that the upper back holds
    dressed = with_bound_piece(dressed, anatomy.height, {side * height, 0.42F * height, 0.05F},
                               0.1F, held_by);
  EXPECT_LE(find_weight_faults(dressed, anatomy).order.worst(), kOrder);
  swap_weights(dressed, held_by, anatomy.spine[anatomy.chest_index - 2]);
  EXPECT_GT(find_weight_faults(dressed, anatomy).order.worst(), kOrder);
}

TEST(OrderAlongTheSpine, IsNotAskedOfATorsoOfOnePiece) {
  REQUIRE_CHARACTER("quaternius_female_24k.glb");
  const Character character = read_character(shared_character("quaternius_female_24k.glb"));
  const Anatomy anatomy = find_anatomy(character);
  ASSERT_EQ(anatomy.chest_index, 3u);
  Character spoiled = character;
  move_weight(spoiled, anatomy, anatomy.spine[2], anatomy.spine[3], 1.0);
  EXPECT_GT(find_weight_faults(spoiled, anatomy).order.worst(), kOrder);
  move_weight(spoiled, anatomy, anatomy.spine[1], anatomy.spine[3], 1.0);
  EXPECT_LE(find_weight_faults(spoiled, anatomy).order.worst(), kOrder);
}

TEST(OrderAlongTheSpine, IsNotAskedOfAHelperThatStandsWhereTheHipsDo) {
  REQUIRE_CHARACTER("quaternius_female_24k.glb");
  Character character = read_character(shared_character("quaternius_female_24k.glb"));
  const Anatomy anatomy = find_anatomy(character);
  move_weight(character, anatomy, anatomy.spine[1], anatomy.spine[2], 1.0);
  EXPECT_GT(find_weight_faults(character, anatomy).order.worst(), kOrder);
  const auto node = [&](std::size_t k) -> Node& {
    return character.nodes[static_cast<std::size_t>(anatomy.spine[k])];
  };
  node(1).world_from_node[3] = node(0).world_from_node[3];
  EXPECT_LE(find_weight_faults(character, find_anatomy(character)).order.worst(), kOrder);
}

TEST(OrderAlongTheSpine, IsNotAskedOfARootThatTheHipsHangFrom) {
  REQUIRE_CHARACTER("quaternius_female_24k.glb");
  Character character = read_character(shared_character("quaternius_female_24k.glb"));
  const Anatomy anatomy = find_anatomy(character);
  move_weight(character, anatomy, anatomy.spine[1], anatomy.spine[2], 1.0);
  Node& hips = character.nodes[static_cast<std::size_t>(anatomy.spine[0])];
  Node& root = character.nodes[static_cast<std::size_t>(anatomy.spine[1])];
  root.parent = hips.parent;
  hips.parent = anatomy.spine[1];
  EXPECT_LE(find_weight_faults(character, anatomy).order.worst(), kOrder);
}

TEST(FarInfluence, OfAPieceOfCostumeIsNamedWhateverJointFarFromItHoldsIt) {
  for (const char* file :
       {"mh_male_13k.glb", "quaternius_female_24k.glb", "mh_female_cmu_13k.glb"}) {
    SCOPED_TRACE(file);
    REQUIRE_CHARACTER(file);
    const Character character = read_character(shared_character(file));
    const Anatomy anatomy = find_anatomy(character);
    const glm::vec3 belly = middle_vertebra(character, anatomy) +
                            glm::vec3(0.0F, 0.0F, 0.08F * static_cast<float>(anatomy.height));
    const auto named = [&](int node) {
      return names(find_weight_faults(
                       with_bound_piece(character, anatomy.height, belly, 0.06F, node), anatomy)
                       .far,
                   kFar, node);
    };
    EXPECT_FALSE(named(anatomy.spine[anatomy.chest_index / 2]));
    for (const int node : {anatomy.head, anatomy.left_arm.back(), anatomy.left_leg[2]})
      EXPECT_TRUE(named(node)) << node;
  }
}

TEST(FarInfluence, OfAPieceOnItsOwnJointIsNamedWhereThatHangsFromAFarOne) {
  for (const char* file : {"mh_male_13k.glb", "quaternius_female_24k.glb"}) {
    SCOPED_TRACE(file);
    REQUIRE_CHARACTER(file);
    const Character character = read_character(shared_character(file));
    const Anatomy anatomy = find_anatomy(character);
    const int hips = anatomy.spine.front();
    for (const int parent : {hips, anatomy.spine[anatomy.chest_index]}) {
      Character tailed = character;
      Node tail = character.nodes[static_cast<std::size_t>(hips)];
      tail.name = "tail";
      tail.parent = parent;
      const int node = static_cast<int>(tailed.nodes.size());
      tailed.nodes.push_back(tail);
      tailed.joints.push_back({node, glm::affineInverse(tail.world_from_node)});
      const glm::vec3 behind = glm::vec3(tail.world_from_node[3]) -
                               glm::vec3(0.0F, 0.0F, 0.08F * static_cast<float>(anatomy.height));
      const WeightAnswer far =
          find_weight_faults(with_bound_piece(tailed, anatomy.height, behind, 0.07F, node), anatomy)
              .far;
      EXPECT_EQ(names(far, kFar, node), parent != hips);
    }
  }
}

TEST(FarInfluence, OfTheHeadIsNotWhereAHatIsBoundMoreFirmlyThanTheHead) {
  REQUIRE_CHARACTER("bunny.glb");  // its head has two thirds of its weight at most
  const Character character = read_character(shared_character("bunny.glb"));
  const Anatomy anatomy = find_anatomy(character);
  const auto height = static_cast<float>(anatomy.height);
  for (const float up : {0.7F, 0.85F}) {
    const Character dressed = with_bound_piece(
        character, anatomy.height, {0.0F, up * height, -0.1F * height}, 0.09F, anatomy.head);
    EXPECT_LE(find_weight_faults(dressed, anatomy).far.worst(), kFar) << up;
  }
}

TEST(WrongSide, OfAPieceThatTheOtherSidesJointHoldsIsNamed) {
  for (const char* file : {"mh_male_13k.glb", "mh_female_cmu_13k.glb"}) {
    SCOPED_TRACE(file);
    REQUIRE_CHARACTER(file);
    const Character character = read_character(shared_character(file));
    const Anatomy anatomy = find_anatomy(character);
    const glm::vec3 shoulder =
        character.nodes[static_cast<std::size_t>(anatomy.left_arm[1])].world_from_node[3];
    for (const auto* arm : {&anatomy.left_arm, &anatomy.right_arm}) {
      const Character dressed =
          with_bound_piece(character, anatomy.height, shoulder, 0.05F, (*arm)[1]);
      EXPECT_EQ(names(find_weight_faults(dressed, anatomy).wrong_side, kWrongSide, (*arm)[1]),
                arm == &anatomy.right_arm);
    }
  }
}

TEST(FarInfluence, OfSleevesAndGlovesThatHoldEachOthersWeightsIsNamed) {
  for (const char* file : {"mh_male_13k.glb", "quaternius_female_24k.glb"}) {
    SCOPED_TRACE(file);
    REQUIRE_CHARACTER(file);
    const Character character = read_character(shared_character(file));
    const Anatomy anatomy = find_anatomy(character);
    const auto at = [&](int node) {
      return glm::vec3(character.nodes[static_cast<std::size_t>(node)].world_from_node[3]);
    };
    const float aside = std::abs(at(anatomy.left_arm[2]).x);  // the elbow
    const auto height = static_cast<float>(anatomy.height);
    for (const bool jacket : {true, false}) {
      Character dressed = character;
      const std::size_t first = add_piece(dressed, anatomy.height, [&](const glm::vec3& p) {
        if (!jacket)
          return std::abs(p.x) > aside + 0.05F * height && p.y > at(anatomy.spine.front()).y;
        return p.y > at(anatomy.spine.front()).y + 0.1F * height && p.y < at(anatomy.head).y &&
               std::abs(p.x) < aside + 0.05F * height;
      });
      ASSERT_GT(dressed.vertex_count() - first, 300u);
      EXPECT_LE(find_weight_faults(dressed, anatomy).far.worst(), kFar) << jacket;
      exchange_sides(dressed, anatomy, first);
      EXPECT_GT(find_weight_faults(dressed, anatomy).far.worst(), 0.9) << jacket;
    }
  }
}

TEST(FarInfluence, IsNotFurtherAlongJointsThatStandInOnePlace) {
  for (const char* file : {"bunny.glb", "mh_female_cmu_13k.glb", "mh_male_13k.glb"}) {
    SCOPED_TRACE(file);
    REQUIRE_CHARACTER(file);
    Character character = read_character(shared_character(file));
    const Anatomy anatomy = find_anatomy(character);
    // What each joint off the spine moves is given to one of no length that rides on it.
    for (SkinJoint& joint : character.joints) {
      if (std::ranges::find(anatomy.spine, joint.node) != anatomy.spine.end()) continue;
      Node leaf = character.nodes[static_cast<std::size_t>(joint.node)];
      leaf.name += "_deform";
      leaf.parent = joint.node;
      joint.node = static_cast<int>(character.nodes.size());
      character.nodes.push_back(leaf);
    }
    EXPECT_LE(find_weight_faults(character, anatomy).far.worst(), kFar);
  }
}

TEST(Costume, IsToldByWhatTheVertebraeUpToTheChestHold) {
  Character character = stick_figure(3);
  const auto node = [&](const char* name) { return stick_node(character, name); };
  const auto first = static_cast<std::uint32_t>(character.vertex_count());
  add_ball(character, {0.0F, 1.2F, 0.0F}, 0.1F, node("spine_1"));  // a soft body: two joints
  const std::uint16_t upper = skin_joint(character, node("spine_2"));
  for (std::size_t v = first; v < character.vertex_count(); v += 2)
    give(character.influences[v], upper, 0.5F);
  const auto belt = static_cast<std::uint32_t>(character.vertex_count());
  add_ball(character, {0.0F, 1.0F, 0.0F}, 0.1F, node("spine_1"));
  for (int k = 0; k < 24; ++k)  // a head of many pieces
    add_ball(character, {0.02F * static_cast<float>(k), 1.7F, 0.0F}, 0.1F, node("head"));
  const SkinPlaces places(character, find_anatomy(character));
  EXPECT_TRUE(places.costume[places.shell[character.place[belt]]]);
  EXPECT_FALSE(places.costume[places.shell[character.place[first]]]);
}

TEST(StepsAlongTheSkeleton, FromAJointThatHoldsAVertebrasWeightAreThoseFromTheVertebra) {
  Character character = stick_figure(3);
  const int lower = stick_node(character, "spine_1"), upper = stick_node(character, "spine_3");
  const Anatomy anatomy = find_anatomy(character);
  const double steps = SkinPlaces(character, anatomy).steps_between(lower, upper);
  EXPECT_GT(steps, 0.0);
  for (SkinJoint& joint : character.joints)
    for (const int vertebra : {lower, upper})
      if (joint.node == vertebra)
        joint.node = add_node(character, "deform_" + std::to_string(vertebra), vertebra,
                              glm::dvec3(0.0, 1.0, 0.1));
  const auto deform = [&](int vertebra) {
    return stick_node(character, "deform_" + std::to_string(vertebra));
  };
  EXPECT_EQ(SkinPlaces(character, anatomy).steps_between(deform(lower), deform(upper)), steps);
  // Beside a vertebra that has weight of its own such a joint is one of its own.
  stick_vertex(character, upper);
  EXPECT_EQ(SkinPlaces(character, anatomy).steps_between(deform(lower), deform(upper)),
            steps + 1.0);
}

TEST(WeightFaults, OfAFigureAreTheSameBesideAnotherOne) {
  REQUIRE_CHARACTER("mh_male_13k.glb");
  Character character = read_character(shared_character("mh_male_13k.glb"));
  const Anatomy anatomy = find_anatomy(character);
  exchange_sides(character, anatomy);
  for (const bool beside : {false, true}) {
    Character both = character;
    if (beside) {  // the same figure again, three times as large and far away
      const auto nodes = static_cast<int>(character.nodes.size());
      const auto joints = static_cast<std::uint16_t>(character.joints.size());
      const auto vertices = static_cast<std::uint32_t>(character.vertex_count());
      const glm::dmat4 move =
          glm::scale(glm::translate(glm::dmat4(1.0), {9.0, 0.0, 0.0}), glm::dvec3(3.0));
      for (Node node : character.nodes) {
        node.name = "other_" + node.name;
        if (node.parent >= 0) node.parent += nodes;
        node.world_from_node = move * node.world_from_node;
        both.nodes.push_back(node);
      }
      for (SkinJoint joint : character.joints) {
        joint.node += nodes;
        both.joints.push_back(joint);
      }
      for (std::uint32_t v = 0; v < vertices; ++v) {
        both.bind_position.push_back(character.bind_position[v]);
        both.bind_normal.push_back(character.bind_normal[v]);
        if (!character.uv.empty()) both.uv.push_back(character.uv[v]);
        Influences influences = character.influences[v];
        for (std::uint16_t& joint : influences.joint) joint += joints;
        both.influences.push_back(influences);
        both.place.push_back(character.place[v] + character.place_count);
      }
      both.place_count += character.place_count;
      for (const glm::uvec3& t : character.triangles) both.triangles.push_back(t + vertices);
      Part part = character.parts.front();
      part.name = "other";
      part.first_vertex = vertices;
      part.vertex_count = vertices;
      part.first_triangle = static_cast<std::uint32_t>(character.triangles.size());
      part.triangle_count = static_cast<std::uint32_t>(character.triangles.size());
      both.parts.push_back(part);
    }
    const Anatomy found = find_anatomy(both);
    EXPECT_EQ(found.other_figures.size(), beside ? 1u : 0u);
    EXPECT_NEAR(found.height, anatomy.height, 1e-6);
    const WeightFaults alone = find_weight_faults(character, anatomy);
    const WeightFaults faults = find_weight_faults(both, found);
    ASSERT_FALSE(faults.wrong_side.faults.empty());
    for (const auto answer : {&WeightFaults::wrong_side, &WeightFaults::far,
                              &WeightFaults::asymmetry, &WeightFaults::order}) {
      ASSERT_EQ((faults.*answer).faults.size(), (alone.*answer).faults.size());
      EXPECT_EQ((faults.*answer).not_applicable, (alone.*answer).not_applicable);
      for (std::size_t k = 0; k < (alone.*answer).faults.size(); ++k) {
        EXPECT_EQ((faults.*answer).faults[k].node, (alone.*answer).faults[k].node);
        EXPECT_EQ((faults.*answer).faults[k].value, (alone.*answer).faults[k].value);
        EXPECT_EQ((faults.*answer).faults[k].places, (alone.*answer).faults[k].places);
      }
    }
  }
}

TEST(Seams, AreWhereTwoSurfacesEndAndNotWherePropsTouch) {
  REQUIRE_CHARACTER("mh_male_13k.glb");
  const Character character = read_character(shared_character("mh_male_13k.glb"));
  const Anatomy anatomy = find_anatomy(character);
  const auto worst = [&](bool props) {
    Character patched = character;
    for (int k = 1; k <= 2; ++k) {
      int node = anatomy.spine[static_cast<std::size_t>(k)];
      if (props) {
        node = static_cast<int>(patched.nodes.size());
        Node prop = patched.nodes[static_cast<std::size_t>(anatomy.spine[0])];
        prop.name = "prop" + std::to_string(k);
        prop.parent = anatomy.spine[0];
        patched.nodes.push_back(prop);
      }
      add_patch(patched, node);
    }
    return find_weight_faults(patched, find_anatomy(patched)).seams.worst();
  };
  const double before = find_weight_faults(character, anatomy).seams.worst();
  EXPECT_GT(worst(false), 0.99);
  EXPECT_EQ(worst(true), before);
}

/// The worst seam of a stick figure with two triangles more, one that follows a spine joint (or
/// `first`) and one that follows the head. Corners are numbers of points that lie apart from all
/// else.
double seam_between(const glm::uvec3& of_spine, const glm::uvec3& of_head,
                    const char* first = "spine_1") {
  Character character = stick_figure();
  add_node(character, "eyelid", stick_node(character, "head"), {0.0, 1.6, 0.1});
  const auto point = [](unsigned number) {
    return glm::vec3(number % 2 == 0 ? 0.0F : 0.1F, 1.2F + 0.05F * static_cast<float>(number / 2),
                     0.3F);
  };
  for (const auto& [corners, joint] : {std::pair(of_spine, first), std::pair(of_head, "head")}) {
    stick_vertex(character, stick_node(character, joint));
    for (int k = 0; k < 3; ++k)
      character.bind_position[character.triangles.back()[k]] = point(corners[k]);
  }
  const Places places = weld(character.bind_position);
  character.place = places.place;
  character.place_count = places.count;
  character.parts = {{"body", 0, 0, static_cast<std::uint32_t>(character.triangles.size()), 0,
                      static_cast<std::uint32_t>(character.vertex_count())}};
  return find_weight_faults(character, find_anatomy(character)).seams.worst();
}

TEST(Seams, AreWhereASurfaceGoesOnOverAnEdge) {
  EXPECT_EQ(seam_between({0, 1, 2}, {3, 4, 5}), 0.0) << "apart";
  EXPECT_EQ(seam_between({0, 1, 2}, {2, 1, 3}), 1.0) << "side by side";
  EXPECT_EQ(seam_between({0, 1, 2}, {1, 2, 3}), 1.0) << "side by side, one turned over";
  EXPECT_EQ(seam_between({0, 1, 2}, {0, 2, 1}), 1.0) << "two sides of one sheet";
  EXPECT_EQ(seam_between({0, 1, 2}, {2, 3, 4}), 0.0) << "in a point";
  EXPECT_EQ(seam_between({0, 1, 2}, {1, 2, 0}), 0.0) << "one upon the other";
}

TEST(Seams, AreNoneBetweenJointsThatHangFromTheHead) {
  EXPECT_EQ(seam_between({0, 1, 2}, {2, 1, 3}, "eyelid"), 0.0);
  EXPECT_EQ(seam_between({0, 1, 2}, {2, 1, 3}, "neck"), 1.0);
}

/// The body in pieces that no vertices join: each triangle moves with the joint that moves its
/// first corner most, but for what the joints of `soft` move most, which keeps its weights.
Character in_plates(const Character& body, const std::set<int>& soft) {
  Character out = body;
  out.bind_position.clear();
  out.bind_normal.clear();
  out.uv.clear();
  out.influences.clear();
  out.triangles.clear();
  std::map<std::pair<std::uint32_t, std::uint16_t>, std::uint32_t> numbers;
  for (const glm::uvec3& triangle : body.triangles) {
    const std::uint16_t joint = body.influences[triangle[0]].joint[0];
    glm::uvec3 corners;
    for (int k = 0; k < 3; ++k) {
      const auto number = static_cast<std::uint32_t>(out.bind_position.size());
      const auto [at, is_new] = numbers.insert({{triangle[k], joint}, number});
      corners[k] = at->second;
      if (!is_new) continue;
      out.bind_position.push_back(body.bind_position[triangle[k]]);
      out.bind_normal.push_back(body.bind_normal[triangle[k]]);
      Influences influences = body.influences[triangle[k]];
      if (!soft.contains(body.joints[joint].node)) {
        influences = {};
        influences.joint[0] = joint;
        influences.weight[0] = 1.0F;
      }
      out.influences.push_back(influences);
    }
    out.triangles.push_back(corners);
  }
  const Places places = weld(out.bind_position);
  out.place = places.place;
  out.place_count = places.count;
  out.parts = {{"body", 0, 0, static_cast<std::uint32_t>(out.triangles.size()), 0,
                static_cast<std::uint32_t>(out.vertex_count())}};
  return out;
}

TEST(Plates, OfAMannequinPartWhereTheyMeet) {
  REQUIRE_CHARACTER("mh_male_13k.glb");
  const Character body = read_character(shared_character("mh_male_13k.glb"));
  const Anatomy anatomy = find_anatomy(body);
  std::set<int> soft(anatomy.spine.begin(), anatomy.spine.end());
  soft.erase(anatomy.spine[1]);
  soft.erase(anatomy.spine[2]);
  const Character mannequin = in_plates(body, soft);
  const WeightFaults faults = find_weight_faults(mannequin, find_anatomy(mannequin));
  for (const WeightAnswer* answer : {&faults.seams, &faults.borders}) {
    EXPECT_TRUE(answer->faults.empty()) << answer->worst();
    EXPECT_NE(answer->not_applicable.find("plates"), std::string::npos) << answer->not_applicable;
  }
  // One part of a body that is not cut elsewhere.
  for (std::size_t n = 0; n < body.nodes.size(); ++n)
    if (const int node = static_cast<int>(n); node != anatomy.spine[1]) soft.insert(node);
  const Character torn = in_plates(body, soft);
  EXPECT_GT(find_weight_faults(torn, find_anatomy(torn)).seams.worst(), kSeam);
}

TEST(Asymmetry, IsNoneWhereShellsTouchOnBothSides) {
  // A sleeve's side lies on the torso's, and rounding decides which of the two stands further out.
  Character figure = stick_figure();
  const auto lay = [&](const char* joint, double x, double off) {
    for (int row = 0; row < 40; ++row) {
      stick_vertex(figure, stick_node(figure, joint));
      for (int k = 0; k < 3; ++k)
        figure.bind_position[figure.triangles.back()[k]] =
            glm::vec3(x + off, 1.1 + 0.01 * row + 0.005 * (k % 2), 0.3 + 0.02 * k);
    }
  };
  lay("spine_2", 0.15, 1e-6);
  lay("clavicle.L", 0.15, 0.0);
  lay("spine_2", -0.15, 0.0);
  lay("clavicle.R", -0.15, -1e-6);
  const Places places = weld(figure.bind_position);
  figure.place = places.place;
  figure.place_count = places.count;
  figure.parts = {{"body", 0, 0, static_cast<std::uint32_t>(figure.triangles.size()), 0,
                   static_cast<std::uint32_t>(figure.vertex_count())}};
  const WeightFaults faults = find_weight_faults(figure, find_anatomy(figure));
  EXPECT_EQ(faults.asymmetry.not_applicable, "");
  EXPECT_LE(faults.asymmetry.worst(), 0.01);
}

TEST(PlantedOnUnlikeSides, HalfATorsoOneVertebraUpIsFoundThoughNoVertexHasAMirrorImage) {
  REQUIRE_CHARACTER("mh_male_13k.glb");
  const Character character = decimated(read_character(shared_character("mh_male_13k.glb")), 1500);
  const Anatomy anatomy = find_anatomy(character);
  EXPECT_TRUE(find_weight_faults(character, anatomy).asymmetry.faults.empty());
  Character spoiled = character;
  move_weight(spoiled, anatomy, anatomy.spine[4], anatomy.spine[5], 1.0, 1);
  const WeightFaults faults = find_weight_faults(spoiled, anatomy);
  EXPECT_EQ(faults.asymmetry.not_applicable, "");
  EXPECT_TRUE(names(faults.asymmetry, 0.35, anatomy.spine[4]) ||
              names(faults.asymmetry, 0.35, anatomy.spine[5]));
}

TEST_P(PlantedWeights, AreFoundOnADenseSpine) {
  REQUIRE_CHARACTER(GetParam());
  const Character natural = read_character(shared_character(GetParam()));
  Anatomy anatomy = find_anatomy(natural);
  const bool upright = std::abs(glm::dot(anatomy.up, torso_axis(natural, anatomy))) > 0.7;
  if (anatomy.left_arm.size() < 3 || anatomy.chest_index + 1 >= 16 || !upright)
    GTEST_SKIP() << "no arms, dense as it is, or its arms do not hang clear of the body";
  const Character character = with_dense_spine(natural, anatomy, 16);
  anatomy = find_anatomy(character);
  ASSERT_GE(anatomy.chest_index, 12u);
  Character spoiled = character;
  const int low = anatomy.spine[anatomy.chest_index / 3], hand = anatomy.left_arm.back();
  for (std::size_t k = anatomy.chest_index / 3; k <= 2 * anatomy.chest_index / 3; ++k)
    move_weight(spoiled, anatomy, anatomy.spine[k], hand, 0.2);
  EXPECT_TRUE(names(find_weight_faults(spoiled, anatomy).far, kFar, hand));
  // A low joint's weights and a high one's are swapped.
  spoiled = character;
  const int high = anatomy.spine[2 * anatomy.chest_index / 3 + 1];
  swap_weights(spoiled, low, high);
  EXPECT_GT(find_weight_faults(spoiled, anatomy).order.worst(), kOrder);
}

INSTANTIATE_TEST_SUITE_P(Files, PlantedWeights,
                         ::testing::Values("mh_male_13k.glb", "mh_female_cmu_13k.glb",
                                           "quaternius_female_24k.glb", "bunny.glb",
                                           "cesium_man.glb", "apatosaurus.glb", "alpaca.glb",
                                           "snake.glb", "shark.glb"));

}  // namespace
}  // namespace backbend::skin
