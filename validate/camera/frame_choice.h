#pragma once
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "validate/files/ledger.h"

namespace backbend::validate {

/// Places, counted from 0 and ascending, of the frames that `ranges` names in a sequence of `count`
/// frames from 1001 on: `1001-1010x2,1020` is every second from 1001 to 1010, and 1020. Empty: all.
/// `shard` then takes its share of them. Throws std::invalid_argument saying what was expected,
/// also for a frame that the sequence has not.
std::vector<std::size_t> chosen_frames(std::string_view ranges, const Shard& shard,
                                       std::size_t count);

/// The same of frames that have these numbers, ascending. A range may pass over numbers that are
/// not there, but not beyond the first and the last, and holds at least one.
std::vector<std::size_t> chosen_frames(std::string_view ranges, const Shard& shard,
                                       std::span<const int> numbers);

}  // namespace backbend::validate
