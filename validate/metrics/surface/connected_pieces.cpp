#include "validate/metrics/surface/connected_pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "skin/character/point_cells.h"

namespace backbend::validate {

std::vector<std::uint32_t> connected_pieces(std::span<const glm::uvec3> triangle,
                                            std::span<const std::uint32_t> place,
                                            std::uint32_t place_count) {
  std::vector<std::uint32_t> piece(place_count);
  std::iota(piece.begin(), piece.end(), 0u);
  const auto place_of = [&](std::uint32_t v) { return place.empty() ? v : place[v]; };
  const auto root = [&](std::uint32_t at) {
    while (piece[at] != at) at = piece[at] = piece[piece[at]];
    return at;
  };
  for (const glm::uvec3& t : triangle)
    for (int i = 1; i < 3; ++i) piece[root(place_of(t[i]))] = root(place_of(t[0]));
  for (std::uint32_t at = 0; at < place_count; ++at) piece[at] = root(at);
  return piece;
}

std::vector<std::uint8_t> rigid_pieces(std::span<const glm::uvec3> triangle,
                                       std::span<const std::uint32_t> place,
                                       std::span<const int> joint_of_vertex,
                                       std::span<const double> fraction,
                                       std::span<const float> coordinate) {
  constexpr double kMost = 0.6, kNear = 0.2;
  constexpr int kNotSeen = -2, kSeveral = -1;
  struct Reach {
    int joint = kNotSeen;
    double from = std::numeric_limits<double>::infinity(), to = -from;
  };
  const auto places = static_cast<std::uint32_t>(coordinate.size());
  const std::vector<std::uint32_t> piece = connected_pieces(triangle, place, places);
  std::vector<Reach> reach(places);  // of each piece, at its name
  for (std::size_t v = 0; v < place.size(); ++v) {
    Reach& of_piece = reach[piece[place[v]]];
    if (of_piece.joint == kNotSeen) of_piece.joint = joint_of_vertex[v];
    if (of_piece.joint != joint_of_vertex[v]) of_piece.joint = kSeveral;
    const double at = coordinate[place[v]];
    if (std::isnan(at)) continue;
    of_piece.from = std::min(of_piece.from, at);
    of_piece.to = std::max(of_piece.to, at);
  }
  const auto is_plate = [&](const Reach& of_piece) {
    if (of_piece.joint < 0) return false;
    const double joint = fraction[static_cast<std::size_t>(of_piece.joint)];
    return joint > of_piece.from - kNear && joint < of_piece.to + kNear &&
           std::min(of_piece.to, 1.0) - std::max(of_piece.from, 0.0) <= kMost;
  };
  std::vector<std::uint8_t> rigid(place.size());
  for (std::size_t v = 0; v < place.size(); ++v)
    rigid[v] = is_plate(reach[piece[place[v]]]) ? 1 : 0;
  return rigid;
}

std::vector<std::uint8_t> standing_props(std::span<const glm::uvec3> triangle,
                                         std::span<const std::uint32_t> place,
                                         std::uint32_t place_count,
                                         std::span<const int> joint_of_vertex,
                                         std::span<const glm::vec3> position, double off) {
  constexpr std::uint32_t kFewest = 6;
  constexpr int kNotSeen = -2, kSeveral = -1;
  struct Facts {
    int joint = kNotSeen;
    std::uint32_t places = 0, standing = 0;
  };
  const std::vector<std::uint32_t> piece = connected_pieces(triangle, place, place_count);
  std::vector<Facts> facts(place_count);  // of each piece, at its name
  std::vector<glm::dvec3> point(place_count);
  for (std::size_t v = 0; v < place.size(); ++v) {
    int& joint = facts[piece[place[v]]].joint;
    joint = joint == kNotSeen || joint == joint_of_vertex[v] ? joint_of_vertex[v] : kSeveral;
    point[place[v]] = position[v];
  }
  for (const std::uint32_t at : piece) ++facts[at].places;
  const auto largest = static_cast<std::uint32_t>(
      std::ranges::max_element(facts, {}, &Facts::places) - facts.begin());
  const auto may_be = [&](std::uint32_t at) {
    return facts[at].joint >= 0 && at != largest && facts[at].places >= kFewest;
  };
  std::vector<std::uint8_t> props(place.size(), 0);
  if (std::ranges::none_of(piece, may_be)) return props;

  const skin::PointCells cells(point, off);
  for (std::uint32_t at = 0; at < place_count; ++at)
    if (may_be(piece[at]) && cells.nearest(point[at], [&](std::size_t other) {
          return piece[other] != piece[at];
        }) == cells.size())
      ++facts[piece[at]].standing;
  for (std::size_t v = 0; v < place.size(); ++v) {
    const std::uint32_t at = piece[place[v]];
    props[v] = may_be(at) && 2 * facts[at].standing >= facts[at].places ? 1 : 0;
  }
  return props;
}

}  // namespace backbend::validate
