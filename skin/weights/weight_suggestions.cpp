#include "skin/weights/weight_suggestions.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "skin/character/printable.h"

namespace backbend::skin {
namespace {

constexpr std::size_t kMost = 4;  // joints of a vertex that every engine takes

/// What a change of each vertex's weights amounts to: `share_of(v)` is the share of the weight of
/// vertex v that changes hands, 0 for none.
template <typename Share>
WeightSuggestion tally(const Character& character, const Share& share_of) {
  WeightSuggestion out;
  for (std::size_t v = 0; v < character.vertex_count(); ++v) {
    const double share = share_of(v);
    if (share <= 0.0) continue;
    if (out.count++ == 0) out.vertex = static_cast<std::uint32_t>(v);
    out.moves = std::max(out.moves, share);
  }
  return out;
}

std::string name_of(const Character& character, int node) {
  return in_quotes(character.nodes[static_cast<std::size_t>(node)].name);
}

}  // namespace

std::vector<WeightSuggestion> suggest_weights(const Character& character,
                                              const WeightHygiene& hygiene) {
  std::vector<WeightSuggestion> out;
  const auto add = [&](WeightSuggestion suggestion, const char* code, const std::string& change) {
    if (suggestion.count == 0) return;
    suggestion.code = code;
    suggestion.change = change;
    out.push_back(std::move(suggestion));
  };
  if (hygiene.off_sum > 0)
    out.push_back({"renormalise",
                   "divide each vertex's weights by their sum (" + number_text(hygiene.worst_sum) +
                       " at worst)",
                   hygiene.off_sum, false, std::nullopt, std::abs(1.0 - hygiene.worst_sum)});
  if (!character.unweighted.empty())
    out.push_back({"weight_unweighted",
                   "give vertices without weights those of their nearest weighted neighbours",
                   character.unweighted.size(), false, character.unweighted.front(), 1.0});

  for (const Bleed& bleed : hygiene.bleed)
    out.push_back({"remove_bleed",
                   "take " + name_of(character, bleed.node) + " off " +
                       plural(bleed.places, "place") +
                       " apart from its area, and give the rest to the joints there",
                   bleed.places, true, bleed.vertex, bleed.largest});

  add(tally(character,
            [&](std::size_t v) {
              double share = 0.0;
              for (const float w : character.influences[v].weight)
                if (w > 0.0f && w < kTinyWeight) share += w;
              return share;
            }),
      "prune_tiny", "drop weights below " + number_text(kTinyWeight, 2) + " and renormalise");
  add(tally(character,
            [&](std::size_t v) {  // largest first
              double share = 0.0;
              for (std::size_t k = kMost; k < kMaxInfluences; ++k)
                share += character.influences[v].weight[k];
              return share;
            }),
      "keep_four", "keep the 4 largest weights of each vertex and renormalise");
  if (hygiene.asymmetric > 0)
    out.push_back(
        {"mirror", "copy the better painted side's weights to the other; they differ by over 5 %",
         hygiene.asymmetric, true, hygiene.worst_asymmetric_vertex, hygiene.worst_asymmetry});
  return out;
}

std::string suggestions_text(const std::vector<WeightSuggestion>& suggestions) {
  std::string out;
  for (const WeightSuggestion& one : suggestions) {
    out += "  " + one.code + std::string(one.code.size() < 18 ? 18 - one.code.size() : 1, ' ') +
           one.change + ": " +
           (one.places ? plural(one.count, "place") : plural(one.count, "vertex", "vertices")) +
           (one.vertex ? " (vertex " + std::to_string(*one.vertex) + ")" : "") + ", up to " +
           number_text(std::round(1000.0 * one.moves) / 10.0, 3) + " % of one's weight\n";
  }
  return out.empty() ? "  nothing to change" : out + "  nothing was changed";
}

std::string suggestions_json(const std::string& file,
                             const std::vector<WeightSuggestion>& suggestions) {
  using nlohmann::json;
  json list = json::array();
  for (const WeightSuggestion& one : suggestions)
    list.push_back({{"code", one.code},
                    {"change", one.change},
                    {one.places ? "places" : "vertices", one.count},
                    {"vertex", one.vertex ? json(*one.vertex) : json(nullptr)},
                    {"largest_share", one.moves}});
  const json root = {{"schema", "backbend.suggest/1"}, {"file", file}, {"suggestions", list}};
  return root.dump(2, ' ', false, json::error_handler_t::replace);
}

}  // namespace backbend::skin
