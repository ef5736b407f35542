#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "skin/anatomy/sidecar.h"
#include "validate/stage/stage.h"
#include "validate/sweeps/suite.h"

namespace backbend::validate {

/// The parts that a version is made of, and the program that measured a run: it is never mixed.
enum class Ingredient : std::uint8_t { skeleton, bind, mesh, weights, options, mapping, program };
inline constexpr int kIngredients = 7;
std::string_view name_of(Ingredient ingredient);

/// Ingredients as bits: 1 << Ingredient.
using IngredientSet = unsigned;
inline IngredientSet bit(Ingredient ingredient) { return 1u << static_cast<unsigned>(ingredient); }
/// In the order of the enumeration.
std::vector<Ingredient> members(IngredientSet set);

/// A character under a rig, as it was at some time.
struct Version {
  std::string label;  // as the user named it
  skin::Character character;
  skin::AnatomyHints hints;
  std::optional<skin::Sidecar> sidecar;
  RigPlan rig;
};

/// Loads a version and refuses what `check` would. Throws skin::CharacterError.
Version load_version(const std::string& file, const skin::AnatomyHints& hints, const RigPlan& rig);

/// Two versions, and what corresponds in them.
///
/// Joints correspond by name, else by their place at rest; vertices by their number where the
/// triangles are the same, else by match_vertices(). A bind matrix is taken for what it adds
/// to the skeleton at rest: a joint that was moved and bound again is a change of the skeleton
/// alone. A mesh stored in another space counts as unchanged if its bind matrices compensate for
/// it.
class VersionPair {
 public:
  /// Throws skin::CharacterError where less than 90 % of either's vertices have a partner among the
  /// other's: by the triangles, or within a two-hundredth of the height.
  VersionPair(Version before, Version after);

  const Version& before() const { return before_; }
  const Version& after() const { return after_; }
  /// Ingredients that differ beyond rounding.
  IngredientSet changed() const { return changed_; }
  /// The share of vertices that correspond: 1 where both have the same triangles, in whatever
  /// order.
  double coverage() const { return coverage_; }

  /// The vertices of the later mesh whose weights differ, by the joint whose share changes most
  /// (its name in the later version).
  const std::map<std::string, std::vector<std::uint32_t>>& changed_weights() const {
    return changed_weights_;
  }
  /// The keys of the rig's options that differ.
  const std::vector<std::string>& changed_options() const { return changed_options_; }
  /// One line on what differs in an ingredient: `212 vertices, spine04, spine05`.
  std::string difference(Ingredient ingredient) const;

  /// What is taken of an ingredient that is mixed; by default all of it.
  struct Parts {
    std::optional<std::vector<std::string>> weights;  // joints of changed_weights()
    std::optional<std::vector<std::string>> options;  // keys of changed_options()
  };
  /// The earlier version with these ingredients of the later one. All and none are the versions as
  /// they are, bit for bit.
  Version mixed(IngredientSet of_after, const Parts& parts) const;
  Version mixed(IngredientSet of_after) const { return mixed(of_after, {}); }

 private:
  void match_joints();
  void match_vertices();
  void compare();

  struct Joint {
    int before = -1, after = -1;  // into each version's joints; -1: it has none
  };

  Version before_, after_;
  std::vector<Joint> joints_;
  std::vector<int> joint_of_before_, joint_of_after_;  // of each version's joints: into joints_
  std::vector<int> node_of_before_, node_of_after_;    // the other's node, -1: none
  std::vector<std::uint32_t> before_of_after_,
      after_of_before_;                              // vertices; empty: the same numbers
  std::vector<glm::vec3> rest_before_, rest_after_;  // world space
  double coverage_ = 1.0;
  bool same_mesh_ = true;  // where vertices have other numbers: the same mesh in another order
  IngredientSet changed_ = 0;
  std::map<std::string, std::vector<std::uint32_t>> changed_weights_;
  std::vector<std::string> changed_options_, moved_joints_, rebound_joints_;
  std::size_t moved_vertices_ = 0;
};

}  // namespace backbend::validate
