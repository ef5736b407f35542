#include "validate/hunt/point_records.h"

#include <nlohmann/json.hpp>

namespace backbend::validate {

using nlohmann::json;

std::vector<std::uint8_t> pack_points(std::span<const SearchPoint> points) {
  json all = json::array();
  for (const SearchPoint& point : points) all.push_back({point.at, point.badness, point.motion});
  return json::to_cbor(all);
}

bool unpack_points(std::span<const std::uint8_t> bytes, std::span<SearchPoint> points) {
  const json all = json::from_cbor(bytes.begin(), bytes.end(), true, false);
  if (!all.is_array() || all.size() != points.size()) return false;
  std::vector<SearchPoint> seen(points.begin(), points.end());
  try {
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (all[i].at(0).get<std::vector<double>>() != seen[i].at) return false;
      all[i].at(1).get_to(seen[i].badness);
      all[i].at(2).get_to(seen[i].motion);
    }
  } catch (const json::exception&) {
    return false;
  }
  std::ranges::move(seen, points.begin());
  return true;
}

}  // namespace backbend::validate
