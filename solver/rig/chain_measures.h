#pragma once
#include <span>
#include <string_view>

#include "solver/rig/spine_pose.h"

namespace backbend::solver {

/// Writes a pose's measures in order, reusing what the pose holds from an earlier solve: no memory
/// is touched when the same system solves into the same pose again.
class MeasureWriter {
 public:
  explicit MeasureWriter(SpinePose& pose) : pose_(pose) {}
  ~MeasureWriter() { pose_.measures.resize(next_); }
  MeasureWriter(const MeasureWriter&) = delete;
  MeasureWriter& operator=(const MeasureWriter&) = delete;

  void add(std::string_view name, double value);

 private:
  SpinePose& pose_;
  std::size_t next_ = 0;
};

/// The bend of a chain of joints: what every system reports about its bones.
struct ChainBend {
  double length = 0.0;        // sum of the bones
  double max_turn = 0.0;      // largest angle between consecutive bones, radians
  double mean_turn = 0.0;     // over the inner joints, radians
  std::size_t max_joint = 0;  // the joint of max_turn
};
/// Zero-length bones are skipped: the bones on either side meet at their place.
ChainBend measure_chain(std::span<const glm::dvec3> joint);

/// Adds `chain_length`, `max_turn_deg`, `mean_turn_deg` and `max_over_mean_turn` (1 on a chain that
/// does not bend: less than 1e-9 rad on average).
void add_chain_measures(std::span<const glm::dvec3> joint, MeasureWriter& out);

}  // namespace backbend::solver
