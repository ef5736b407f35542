#include "skin/gltf/vertex_weights.h"

#include <algorithm>
#include <cmath>

#include "skin/character/printable.h"

namespace backbend::skin {

Influences canonical_influences(std::span<const WeightEntry> entries, double slack,
                                std::size_t vertex, WeightTally& tally) {
  struct Share {
    std::uint32_t joint;
    double weight;
  };
  std::vector<Share> shares;
  shares.reserve(entries.size());
  bool negative = false, duplicate = false;
  for (const WeightEntry& entry : entries) {
    negative |= entry.weight < 0.0f;
    if (!(entry.weight > 0.0f)) continue;
    const auto same = std::find_if(shares.begin(), shares.end(),
                                   [&](const Share& s) { return s.joint == entry.joint; });
    duplicate |= same != shares.end();
    if (same != shares.end())
      same->weight += entry.weight;
    else
      shares.push_back({entry.joint, entry.weight});
  }
  ++tally.vertices;
  tally.negative += negative;
  tally.duplicates += duplicate;

  std::sort(shares.begin(), shares.end(), [](const Share& a, const Share& b) {
    return a.weight != b.weight ? a.weight > b.weight : a.joint < b.joint;
  });
  double sum = 0.0;
  for (const Share& share : shares) sum += share.weight;
  Influences out;
  if (shares.empty()) return out;
  if (std::abs(sum - 1.0) > slack) {
    ++tally.renormalised;
    if (std::abs(sum - 1.0) > std::abs(tally.worst_sum - 1.0)) {
      tally.worst_sum = sum;
      tally.worst_vertex = vertex;
    }
  }
  double kept = sum;
  if (shares.size() > kMaxInfluences) {
    kept = 0.0;
    shares.resize(kMaxInfluences);
    for (const Share& share : shares) kept += share.weight;
    ++tally.cut;
    tally.worst_cut = std::max(tally.worst_cut, 1.0 - kept / sum);
  }
  for (std::size_t k = 0; k < shares.size(); ++k) {
    out.joint[k] = static_cast<std::uint16_t>(shares[k].joint);
    out.weight[k] = static_cast<float>(shares[k].weight / kept);
  }
  return out;
}

std::vector<Warning> weight_warnings(const WeightTally& tally, bool by_rule) {
  std::vector<Warning> out;
  const auto of_all = " of " + std::to_string(tally.vertices) + " vertices";
  if (tally.renormalised > 0)
    out.push_back(
        {"weights_renormalised",
         "weights of " + std::to_string(tally.renormalised) + of_all + " do not sum to 1 (worst " +
             number_text(tally.worst_sum) + ", vertex " + std::to_string(tally.worst_vertex) +
             "): " + (by_rule ? "normalised, as all readers of this format do" : "renormalised")});
  if (tally.negative > 0)
    out.push_back({"weights_negative", "negative weights at " + std::to_string(tally.negative) +
                                           of_all + ": taken as 0"});
  if (tally.cut > 0)
    out.push_back({"influences_cut",
                   std::to_string(tally.cut) + of_all + " have more than " +
                       std::to_string(kMaxInfluences) + " joints: the largest were kept, at most " +
                       number_text(100.0 * tally.worst_cut, 3) + " % of a vertex dropped"});
  if (tally.duplicates > 0)
    out.push_back({"joint_repeated", std::to_string(tally.duplicates) + of_all +
                                         " name one joint more than once: merged"});
  return out;
}

}  // namespace backbend::skin
