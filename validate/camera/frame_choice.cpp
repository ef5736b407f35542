#include "validate/camera/frame_choice.h"

#include <charconv>
#include <numeric>
#include <stdexcept>
#include <string>

#include "validate/model/report.h"

namespace backbend::validate {
namespace {

struct Range {
  int first, last, step;
};

[[noreturn]] void refuse(std::string_view range) {
  throw std::invalid_argument(
      "'" + std::string(range) +
      "': invalid frames; expected A, A-B or A-BxSTEP with A <= B and STEP >= 1, "
      "separated by commas");
}

Range parse_range(std::string_view text) {
  const char* at = text.data();
  const char* const end = at + text.size();
  const auto number = [&] {
    int value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc{} || value < 0) refuse(text);
    at = next;
    return value;
  };
  const auto passes = [&](char mark) {
    const bool is_there = at != end && *at == mark;
    if (is_there) ++at;
    return is_there;
  };
  Range range{};
  range.first = range.last = number();
  range.step = 1;
  if (passes('-')) {
    range.last = number();
    if (passes('x')) range.step = number();
  }
  if (at != end || range.last < range.first || range.step < 1) refuse(text);
  return range;
}

}  // namespace

std::vector<std::size_t> chosen_frames(std::string_view ranges, const Shard& shard,
                                       std::size_t count) {
  std::vector<int> numbers(count);
  std::iota(numbers.begin(), numbers.end(), kFirstFrame);
  return chosen_frames(ranges, shard, numbers);
}

std::vector<std::size_t> chosen_frames(std::string_view ranges, const Shard& shard,
                                       std::span<const int> numbers) {
  std::vector<bool> is_chosen(numbers.size(), ranges.empty());
  while (!ranges.empty()) {
    const std::size_t comma = ranges.find(',');
    const std::string_view text = ranges.substr(0, comma);
    const Range range = parse_range(text);
    const int last = range.first + (range.last - range.first) / range.step * range.step;
    bool any = false;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      if (numbers[i] < range.first || numbers[i] > last) continue;
      if ((numbers[i] - range.first) % range.step != 0) continue;
      is_chosen[i] = any = true;
    }
    if (!any || range.first < numbers.front() || last > numbers.back())
      throw std::invalid_argument("'" + std::string(text) + "': the sequence has the frames " +
                                  std::to_string(numbers.front()) + " to " +
                                  std::to_string(numbers.back()));
    if (comma == std::string_view::npos) break;
    ranges.remove_prefix(comma + 1);
    if (ranges.empty()) refuse("");
  }
  std::vector<std::size_t> chosen;
  std::size_t item = 0;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (is_chosen[i] && shard.owns(item++)) chosen.push_back(i);
  return chosen;
}

}  // namespace backbend::validate
