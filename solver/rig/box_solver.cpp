#include "solver/rig/box_solver.h"

namespace backbend::solver {

std::array<bool, kBoxVariables> moved_alone(std::span<const BoxReal> control, std::size_t first,
                                            std::size_t count) {
  std::array<bool, kBoxVariables> moved{}, others{};
  for (std::size_t c = 0; c < control.size(); ++c) {
    const bool own = c >= first && c < first + count;
    for (std::size_t j = 0; j < moved.size(); ++j)
      if (!control[c].slope[j].is_zero()) (own ? moved : others)[j] = true;
  }
  for (std::size_t j = 0; j < moved.size(); ++j) moved[j] = moved[j] && !others[j];
  return moved;
}

}  // namespace backbend::solver
