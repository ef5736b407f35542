#include "validate/metrics/surface/proxy_weights.h"

#include <algorithm>
#include <cmath>

#include "validate/metrics/surface/spine_coordinate.h"
#include "validate/metrics/surface/torso.h"

namespace backbend::validate {
namespace {

/// Index into Character::joints of each spine joint, hips first, up to the base of the neck;
/// nothing if one of the `driven` first ones has none.
std::optional<std::vector<std::uint16_t>> spine_joints(const skin::Character& character,
                                                       const skin::Anatomy& anatomy,
                                                       std::size_t driven) {
  std::vector<std::uint16_t> joints;
  for (std::size_t i = 0; i < std::max(driven, anatomy.neck_index + 1); ++i) {
    const auto found =
        std::ranges::find(character.joints, anatomy.spine[i], &skin::SkinJoint::node);
    if (found != character.joints.end())
      joints.push_back(static_cast<std::uint16_t>(found - character.joints.begin()));
    else if (i < driven)
      return std::nullopt;
  }
  return joints;
}

struct Entry {
  std::uint16_t joint;
  float weight;
};

/// The heaviest entries that fit, heaviest first, in the sum that all of them had.
skin::Influences packed(std::vector<Entry> entries) {
  std::ranges::stable_sort(entries, std::greater<>(), &Entry::weight);
  double all = 0.0, kept = 0.0;
  const std::size_t count =
      std::min(entries.size(), static_cast<std::size_t>(skin::kMaxInfluences));
  for (std::size_t i = 0; i < entries.size(); ++i) {
    all += entries[i].weight;
    if (i < count) kept += entries[i].weight;
  }
  skin::Influences out;
  for (std::size_t i = 0; i < count; ++i) {
    out.joint[i] = entries[i].joint;
    out.weight[i] = static_cast<float>(entries[i].weight * (all / kept));
  }
  return out;
}

}  // namespace

std::optional<std::vector<skin::Influences>> proxy_weights(const skin::Character& character,
                                                           const skin::Anatomy& anatomy,
                                                           const skin::SpineDriver& driver,
                                                           const skin::PosedMesh& rest) {
  const std::vector<double>& fraction = driver.joint_fractions();
  const auto spine = spine_joints(character, anatomy, fraction.size());
  if (!spine || fraction.size() < 2) return std::nullopt;
  const std::vector<std::uint8_t> torso = torso_mask(character, anatomy, rest.position);
  const std::vector<float> share = spine_shares(character, anatomy);
  const RestMesh mesh{
      rest.position, rest.normal, character.triangles,      character.place, character.place_count,
      torso,         share,       driver.rest_chain().joint};
  const std::vector<float> coordinate =
      spine_coordinate(mesh, SpineLine(driver.rest_chain().joint));

  std::vector<skin::Influences> out = character.influences;
  for (std::size_t v = 0; v < out.size(); ++v) {
    const double s = coordinate[character.place[v]];
    if (!std::isfinite(s)) continue;
    std::vector<Entry> entries;
    double of_spine = 0.0;
    for (int k = 0; k < skin::kMaxInfluences; ++k) {
      const Entry entry{out[v].joint[k], out[v].weight[k]};
      if (!(entry.weight > 0.0f)) continue;
      const auto found = std::ranges::find(*spine, entry.joint);
      // Above the chest nothing bends: whose the weight is there changes nothing.
      const bool above = found - spine->begin() >= std::ssize(fraction);
      if (found != spine->end() && !(above && s >= 1.0))
        of_spine += entry.weight;
      else
        entries.push_back(entry);
    }
    if (of_spine == 0.0) continue;
    const auto above = std::ranges::upper_bound(fraction, s);
    const std::size_t high = std::clamp<std::size_t>(
        static_cast<std::size_t>(above - fraction.begin()), 1, fraction.size() - 1);
    const double low_at = fraction[high - 1], high_at = fraction[high];
    const double upper =
        high_at > low_at ? std::clamp((s - low_at) / (high_at - low_at), 0.0, 1.0) : 1.0;
    if (upper < 1.0)
      entries.push_back({(*spine)[high - 1], static_cast<float>(of_spine * (1.0 - upper))});
    if (upper > 0.0) entries.push_back({(*spine)[high], static_cast<float>(of_spine * upper)});
    out[v] = packed(std::move(entries));
  }
  return out;
}

}  // namespace backbend::validate
