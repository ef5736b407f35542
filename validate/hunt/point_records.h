#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "validate/hunt/pose_search.h"

namespace backbend::validate {

/// Points that were looked at as bytes, bit for bit (NaN stays NaN).
std::vector<std::uint8_t> pack_points(std::span<const SearchPoint> points);

/// Fills what was seen at `points` from such bytes. False, and nothing changed, where the bytes are
/// not readable or of other points.
bool unpack_points(std::span<const std::uint8_t> bytes, std::span<SearchPoint> points);

}  // namespace backbend::validate
