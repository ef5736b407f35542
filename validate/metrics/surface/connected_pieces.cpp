#include "validate/metrics/surface/connected_pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "skin/character/point_cells.h"

namespace backbend::validate {
namespace {

/// What moves a piece, and where along the spine it is.
struct Reach {
  static constexpr int kNotSeen = -2, kSeveral = -1;
  int joint = kNotSeen;  // of the chain
  double from = std::numeric_limits<double>::infinity(), to = -from;
};

/// Of each piece, at its name.
std::vector<Reach> reach_of_pieces(std::span<const std::uint32_t> piece,
                                   std::span<const std::uint32_t> place,
                                   std::span<const int> joint_of_vertex,
                                   std::span<const float> coordinate) {
  std::vector<Reach> reach(piece.size());
  for (std::size_t v = 0; v < place.size(); ++v) {
    Reach& of_piece = reach[piece[place[v]]];
    if (of_piece.joint == Reach::kNotSeen) of_piece.joint = joint_of_vertex[v];
    if (of_piece.joint != joint_of_vertex[v]) of_piece.joint = Reach::kSeveral;
    const double at = coordinate[place[v]];
    if (std::isnan(at)) continue;
    of_piece.from = std::min(of_piece.from, at);
    of_piece.to = std::max(of_piece.to, at);
  }
  return reach;
}

/// Whether one joint moves a piece, and the piece is where that joint is.
bool is_at_its_joint(const Reach& reach, std::span<const double> fraction) {
  constexpr double kNear = 0.2;
  if (reach.joint < 0) return false;
  const double joint = fraction[static_cast<std::size_t>(reach.joint)];
  return joint > reach.from - kNear && joint < reach.to + kNear;
}

}  // namespace

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
  constexpr double kMost = 0.6;
  const auto places = static_cast<std::uint32_t>(coordinate.size());
  const std::vector<std::uint32_t> piece = connected_pieces(triangle, place, places);
  const std::vector<Reach> reach = reach_of_pieces(piece, place, joint_of_vertex, coordinate);
  std::vector<std::uint8_t> rigid(place.size());
  for (std::size_t v = 0; v < place.size(); ++v) {
    const Reach& here = reach[piece[place[v]]];
    rigid[v] = is_at_its_joint(here, fraction) &&
                       std::min(here.to, 1.0) - std::max(here.from, 0.0) <= kMost
                   ? 1
                   : 0;
  }
  return rigid;
}

std::vector<std::uint8_t> standing_props(std::span<const glm::uvec3> triangle,
                                         std::span<const std::uint32_t> place,
                                         std::span<const int> joint_of_vertex,
                                         std::span<const double> fraction,
                                         std::span<const float> coordinate,
                                         std::span<const glm::vec3> position, double off) {
  constexpr std::uint32_t kFewest = 6;
  const auto places = static_cast<std::uint32_t>(coordinate.size());
  const std::vector<std::uint32_t> piece = connected_pieces(triangle, place, places);
  const std::vector<Reach> reach = reach_of_pieces(piece, place, joint_of_vertex, coordinate);
  std::vector<std::uint32_t> count(places, 0), standing(places, 0);  // of each piece, at its name
  for (const std::uint32_t at : piece) ++count[at];
  const auto largest = std::ranges::max_element(count) - count.begin();
  const auto may_be = [&](std::uint32_t at) {
    return at != largest && count[at] >= kFewest && is_at_its_joint(reach[at], fraction);
  };
  std::vector<std::uint8_t> props(place.size(), 0);
  if (std::ranges::none_of(piece, may_be)) return props;

  std::vector<glm::dvec3> point(places);
  for (std::size_t v = 0; v < place.size(); ++v) point[place[v]] = position[v];
  const skin::PointCells cells(point, off);
  for (std::uint32_t at = 0; at < places; ++at)
    if (may_be(piece[at]) && cells.nearest(point[at], [&](std::size_t other) {
          return piece[other] != piece[at];
        }) == cells.size())
      ++standing[piece[at]];
  for (std::size_t v = 0; v < place.size(); ++v) {
    const std::uint32_t at = piece[place[v]];
    props[v] = may_be(at) && 2 * standing[at] >= count[at] ? 1 : 0;
  }
  return props;
}

}  // namespace backbend::validate
