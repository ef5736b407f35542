#include "skin/character/weld.h"

#include <bit>

namespace backbend::skin {
namespace {

std::uint64_t mixed(std::uint64_t x) {  // the finaliser of MurmurHash3, public domain
  x ^= x >> 33;
  x *= 0xFF51AFD7ED558CCDull;
  x ^= x >> 33;
  x *= 0xC4CEB9FE1A85EC53ull;
  return x ^ (x >> 33);
}

std::uint64_t hash(const glm::vec3& p) {
  // Adding 0 turns -0 into 0, so that equal points hash alike.
  const auto bits = [](float x) { return std::uint64_t{std::bit_cast<std::uint32_t>(x + 0.0f)}; };
  return mixed(mixed(bits(p.x) | bits(p.y) << 32) ^ bits(p.z));
}

}  // namespace

Places weld(std::span<const glm::vec3> point) {
  constexpr std::uint32_t kEmpty = 0xFFFFFFFFu;
  const std::size_t slots = std::bit_ceil(2 * point.size() + 1);
  std::vector<std::uint32_t> first(slots, kEmpty);  // open addressing: a vertex of each place
  Places out;
  out.place.resize(point.size());
  for (std::size_t v = 0; v < point.size(); ++v) {
    std::size_t slot = hash(point[v]) & (slots - 1);
    while (first[slot] != kEmpty && point[first[slot]] != point[v]) slot = (slot + 1) & (slots - 1);
    if (first[slot] == kEmpty) {
      first[slot] = static_cast<std::uint32_t>(v);
      out.place[v] = out.count++;
    } else {
      out.place[v] = out.place[first[slot]];
    }
  }
  return out;
}

}  // namespace backbend::skin
