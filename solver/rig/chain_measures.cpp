#include "solver/rig/chain_measures.h"

#include <glm/geometric.hpp>

#include "solver/math/rotation.h"

namespace backbend::solver {

void MeasureWriter::add(std::string_view name, double value) {
  if (next_ == pose_.measures.size()) pose_.measures.emplace_back();
  Measure& measure = pose_.measures[next_++];
  if (measure.name != name) measure.name = name;
  measure.value = value;
}

ChainBend measure_chain(std::span<const glm::dvec3> joint) {
  ChainBend bend;
  glm::dvec3 before(0.0);
  std::size_t bones = 0;
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < joint.size(); ++i) {
    const glm::dvec3 bone = joint[i + 1] - joint[i];
    const double length = glm::length(bone);
    if (!(length > 0.0)) continue;
    bend.length += length;
    if (bones++ > 0) {
      const double turn = angle_between(before, bone);
      sum += turn;
      if (turn > bend.max_turn) {
        bend.max_turn = turn;
        bend.max_joint = i;
      }
    }
    before = bone;
  }
  bend.mean_turn = bones > 1 ? sum / double(bones - 1) : 0.0;
  return bend;
}

void add_chain_measures(std::span<const glm::dvec3> joint, MeasureWriter& out) {
  const ChainBend bend = measure_chain(joint);
  out.add("chain_length", bend.length);
  out.add("max_turn_deg", degrees(bend.max_turn));
  out.add("mean_turn_deg", degrees(bend.mean_turn));
  out.add("max_over_mean_turn", bend.mean_turn > 1e-9 ? bend.max_turn / bend.mean_turn : 1.0);
}

}  // namespace backbend::solver
