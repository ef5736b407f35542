#pragma once
#include <cstdint>
#include <vector>

namespace backbend::skin {

/// Where a glTF file stores the weights of a run of vertices.
struct WeightSource {
  std::uint32_t first_vertex = 0, vertex_count = 0;  // into Character::influences
  std::vector<int> joints, weights;  // accessors: JOINTS_0 and WEIGHTS_0, JOINTS_1 ...
  std::vector<std::uint32_t> joint;  // by the number that the file gives a joint: which of
                                     // Character::joints
};

}  // namespace backbend::skin
