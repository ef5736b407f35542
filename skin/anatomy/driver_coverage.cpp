#include "skin/anatomy/driver_coverage.h"

#include <algorithm>

namespace backbend::skin {

DriverCoverage driver_coverage(const Character& character, const Anatomy& anatomy) {
  const std::size_t count = character.nodes.size();
  const std::vector<bool> is_static = SpineDriver(character, anatomy).static_nodes();
  const std::vector<Region> region = vertex_regions(character, anatomy);
  const std::vector<Region> region_of = node_regions(character, anatomy);
  std::vector<bool> driven(count, false);
  const auto mark = [&](const std::vector<int>& chain) {
    for (const int node : chain) driven[static_cast<std::size_t>(node)] = true;
  };
  for (const auto* chain : {&anatomy.spine, &anatomy.left_arm, &anatomy.right_arm,
                            &anatomy.left_leg, &anatomy.right_leg, &anatomy.tail})
    mark(*chain);

  std::vector<double> on_torso(count, 0.0), on_all(count, 0.0);
  double torso = 0.0, all = 0.0;
  for (std::size_t v = 0; v < character.vertex_count(); ++v)
    for (std::size_t k = 0; k < kMaxInfluences; ++k) {
      const double weight = character.influences[v].weight[k];
      if (!(weight > 0.0)) continue;
      const auto node =
          static_cast<std::size_t>(character.joints[character.influences[v].joint[k]].node);
      all += weight;
      on_all[node] += weight;
      if (region[v] != Region::torso) continue;
      torso += weight;
      on_torso[node] += weight;
    }

  DriverCoverage out;
  for (std::size_t n = 0; n < count; ++n) {
    if (is_static[n] && on_all[n] > 0.0) {
      out.unreached.push_back(static_cast<int>(n));
      out.unreached_share += on_all[n] / all;
    } else if (!driven[n] && region_of[n] == Region::torso && on_torso[n] > 0.0) {
      out.helpers.push_back(static_cast<int>(n));
      out.helper_share += on_torso[n] / torso;
    }
  }
  return out;
}

}  // namespace backbend::skin
