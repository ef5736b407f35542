#include "skin/anatomy_hints.h"

#include <algorithm>
#include <numeric>

#include "skin/printable.h"
#include "skin/skeleton_shape.h"

namespace backbend::skin {
namespace {

/// Single-letter edits from one word to another (Levenshtein).
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t k = 1; k <= b.size(); ++k) {
      const std::size_t change = diagonal + (a[i - 1] == b[k - 1] ? 0 : 1);
      diagonal = row[k];
      row[k] = std::min({row[k] + 1, row[k - 1] + 1, change});
    }
  }
  return row.back();
}

std::vector<int> chain_of(const Character& character, const std::vector<std::string>& names,
                          const char* what) {
  std::vector<int> chain;
  for (const std::string& name : names) {
    const int node = node_named(character, name);
    if (!chain.empty() && path_down(character, chain.back(), node).size() < 2)
      throw CharacterError(character.file_name + ": " + what + ": " + in_quotes(name) +
                           " does not hang from " +
                           in_quotes(character.nodes[static_cast<std::size_t>(chain.back())].name));
    chain.push_back(node);
  }
  return chain;
}

}  // namespace

int node_named(const Character& character, const std::string& name) {
  int found = -1;
  const Node* nearest = nullptr;
  std::size_t least = 0;
  for (std::size_t n = 0; n < character.nodes.size(); ++n) {
    const Node& node = character.nodes[n];
    if (node.name == name) {
      if (found >= 0)
        throw CharacterError(character.file_name + ": several joints are called " +
                             in_quotes(name));
      found = static_cast<int>(n);
    }
    if (found >= 0 || name.size() > 256 || node.name.size() > 256) continue;
    const std::size_t distance = edit_distance(name, node.name);
    if (!nearest || distance < least) {
      nearest = &node;
      least = distance;
    }
  }
  if (found < 0)
    throw CharacterError(character.file_name + ": no joint is called " + in_quotes(name) +
                         (nearest ? "; the nearest is " + in_quotes(nearest->name) : ""));
  return found;
}

HintedSpine resolve_spine_hints(const Character& character, const AnatomyHints& hints) {
  HintedSpine out;
  if (!hints.hip.empty()) out.hip = node_named(character, hints.hip);
  if (!hints.chest.empty()) out.chest = node_named(character, hints.chest);
  out.chain = chain_of(character, hints.spine, "--spine");
  if (out.chain.size() == 1)
    throw CharacterError(character.file_name + ": --spine: one joint is no chain");
  if (!out.chain.empty() && out.chest >= 0 &&
      std::find(out.chain.begin() + 1, out.chain.end(), out.chest) == out.chain.end())
    throw CharacterError(character.file_name + ": --chest: " + in_quotes(hints.chest) +
                         " is not in the spine given");
  return out;
}

HintedArms resolve_arm_hints(const Character& character, const AnatomyHints& hints) {
  return {chain_of(character, hints.left_arm, "--arms"),
          chain_of(character, hints.right_arm, "--arms")};
}

}  // namespace backbend::skin
