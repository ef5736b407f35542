#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "validate/measure/measure.h"

namespace backbend::validate {

/// Results of units of work as bytes, and back, bit for bit (NaN stays NaN). What is planned, not
/// measured, of a pose (controls, angle) is not stored. Reading throws std::runtime_error where the
/// bytes do not hold what is asked for.
std::vector<std::uint8_t> pack_poses(std::span<const PoseRecord> poses);
void unpack_poses(std::span<const std::uint8_t> bytes, std::span<PoseRecord> poses);

std::vector<std::uint8_t> pack_flips(const FlipReport& flips);
FlipReport unpack_flips(std::span<const std::uint8_t> bytes);

/// What the small pictures of consecutive poses show.
struct ImageSteps {
  std::vector<double> change, step, pop;
};
std::vector<std::uint8_t> pack_steps(const ImageSteps& steps);
ImageSteps unpack_steps(std::span<const std::uint8_t> bytes);

std::vector<std::uint8_t> pack_witness(const ImageWitness& witness);
ImageWitness unpack_witness(std::span<const std::uint8_t> bytes);

}  // namespace backbend::validate
