#include "render/trace/refit_quality.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <glm/common.hpp>
#include <limits>
#include <numeric>

namespace backbend::render {
namespace {

constexpr std::size_t kGroup = 32;
// A pose is judged by so many groups at least, spread evenly over the mesh: all of them would cost
// as much as the refit itself.
constexpr std::size_t kLeastGroups = 1024;
constexpr int kMortonBits = 10;  // per axis

struct Box {
  glm::vec3 low{std::numeric_limits<float>::max()}, high{std::numeric_limits<float>::lowest()};

  void add(const glm::vec3& p) { low = glm::min(low, p), high = glm::max(high, p); }
  void add(const Box& b) { low = glm::min(low, b.low), high = glm::max(high, b.high); }
  double half_surface() const {
    const glm::dvec3 d = glm::dvec3(high) - glm::dvec3(low);
    return d.x * d.y + d.y * d.z + d.z * d.x;
  }
};

Box box_of(const glm::uvec3& triangle, std::span<const glm::vec3> position) {
  Box box;
  for (int corner = 0; corner < 3; ++corner) box.add(position[triangle[corner]]);
  return box;
}

// Two zero bits before each of the lower ten.
std::uint32_t every_third_bit(std::uint32_t x) {
  x = (x | (x << 16)) & 0x030000ffu;
  x = (x | (x << 8)) & 0x0300f00fu;
  x = (x | (x << 4)) & 0x030c30c3u;
  return (x | (x << 2)) & 0x09249249u;
}

std::uint32_t morton_code(const glm::vec3& unit) {
  constexpr float kCells = 1 << kMortonBits;
  const auto cell = [](float at) {
    return static_cast<std::uint32_t>(std::clamp(at * kCells, 0.0f, kCells - 1.0f));
  };
  return every_third_bit(cell(unit.x)) | every_third_bit(cell(unit.y)) << 1 |
         every_third_bit(cell(unit.z)) << 2;
}

}  // namespace

RefitQuality::RefitQuality(std::span<const glm::uvec3> triangle,
                           std::span<const glm::vec3> rest_position)
    : triangle_(triangle), order_(triangle.size()) {
  Box all;
  for (const glm::vec3& p : rest_position) all.add(p);
  const glm::vec3 scale = 1.0f / glm::max(all.high - all.low, glm::vec3(1e-30f));
  std::vector<std::uint32_t> code(triangle.size());
  for (std::size_t i = 0; i < triangle.size(); ++i) {
    const Box box = box_of(triangle[i], rest_position);
    code[i] = morton_code((0.5f * (box.low + box.high) - all.low) * scale);
  }
  std::iota(order_.begin(), order_.end(), 0u);
  std::stable_sort(order_.begin(), order_.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return code[a] < code[b]; });
  rest_looseness_ = looseness(rest_position);
}

double RefitQuality::looseness(std::span<const glm::vec3> position) const {
  const std::size_t all_groups = (order_.size() + kGroup - 1) / kGroup;
  const std::size_t stride = std::max(all_groups / kLeastGroups, std::size_t{1});
  const std::size_t groups = (all_groups + stride - 1) / stride;
  // Kept by group and summed in order, so that the sum is the same for any number of threads.
  std::vector<double> around(groups), within(groups);
  tbb::parallel_for(std::size_t{0}, groups, [&](std::size_t group) {
    Box whole;
    const std::size_t first = group * stride * kGroup;
    const std::size_t end = std::min(order_.size(), first + kGroup);
    for (std::size_t i = first; i < end; ++i) {
      const Box box = box_of(triangle_[order_[i]], position);
      whole.add(box);
      within[group] += box.half_surface();
    }
    around[group] = whole.half_surface();
  });
  const double inside = std::accumulate(within.begin(), within.end(), 0.0);
  return inside > 0.0 ? std::accumulate(around.begin(), around.end(), 0.0) / inside : 0.0;
}

double RefitQuality::growth(std::span<const glm::vec3> position) const {
  const double now = looseness(position);
  return rest_looseness_ > 0.0 && now > 0.0 ? now / rest_looseness_ : 1.0;
}

}  // namespace backbend::render
