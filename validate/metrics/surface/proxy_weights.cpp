#include "validate/metrics/surface/proxy_weights.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "skin/character/matrix_facts.h"
#include "validate/metrics/surface/connected_pieces.h"
#include "validate/metrics/surface/spine_coordinate.h"
#include "validate/metrics/surface/torso.h"

namespace backbend::validate {
namespace {

constexpr float kAlone = 0.98f;      // of a vertex's weight, for a joint to move it alone
constexpr double kStandsOff = 0.02;  // of the height, off the body: clothes lie closer

/// The skin's joints that are those of the spine: each spine joint itself, and what stands in its
/// place and goes with it, as a `_bind` joint of no length.
struct SpineJoints {
  std::vector<std::uint16_t> joint;  // one for each spine joint, hips first, up to the neck's base
  std::vector<int> index;            // of each joint of the skin: into `joint`; -1: another's
};

/// Nothing if one of the `driven` first spine joints has no joint of the skin.
std::optional<SpineJoints> spine_joints(const skin::Character& character,
                                        const skin::Anatomy& anatomy,
                                        const std::vector<int>& motion, std::size_t driven) {
  const auto place = [&](std::size_t node) {
    return skin::origin(character.nodes[node].world_from_node);
  };
  SpineJoints out;
  out.index.assign(character.joints.size(), -1);
  for (std::size_t i = 0; i < std::max(driven, anatomy.neck_index + 1); ++i) {
    const auto spine = static_cast<std::size_t>(anatomy.spine[i]);
    std::optional<std::size_t> chosen;
    for (std::size_t j = 0; j < out.index.size(); ++j) {
      const auto node = static_cast<std::size_t>(character.joints[j].node);
      const bool twin =
          out.index[j] < 0 && motion[node] == motion[spine] &&
          std::ranges::find(anatomy.spine, character.joints[j].node) == anatomy.spine.end() &&
          glm::distance(place(node), place(spine)) <= 1e-6 * anatomy.spine_length;
      if (node != spine && !twin) continue;
      out.index[j] = static_cast<int>(out.joint.size());
      if (!chosen || node == spine) chosen = j;
    }
    if (chosen)
      out.joint.push_back(static_cast<std::uint16_t>(*chosen));
    else if (i < driven)
      return std::nullopt;
  }
  return out;
}

/// The driven spine joint that moves each vertex all but alone; -1 where none does.
std::vector<int> lone_joints(const skin::Character& character, const SpineJoints& spine,
                             std::size_t driven) {
  std::vector<int> out;
  for (const skin::Influences& influences : character.influences) {
    const auto heaviest = std::ranges::max_element(influences.weight) - influences.weight.begin();
    const auto k = static_cast<std::size_t>(heaviest);
    const int joint = spine.index[influences.joint[k]];
    const bool alone = influences.weight[k] >= kAlone && joint < static_cast<int>(driven);
    out.push_back(alone ? joint : -1);
  }
  return out;
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
  const auto spine = spine_joints(character, anatomy, driver.node_motions(), fraction.size());
  if (!spine || fraction.size() < 2) return std::nullopt;
  const std::vector<std::uint8_t> torso = torso_mask(character, anatomy, rest.position);
  const std::vector<float> share = spine_shares(character, anatomy);
  const RestMesh mesh{
      rest.position, rest.normal, character.triangles,      character.place, character.place_count,
      torso,         share,       driver.rest_chain().joint};
  const std::vector<float> coordinate =
      spine_coordinate(mesh, SpineLine(driver.rest_chain().joint));

  const std::vector<std::uint8_t> prop = standing_props(
      character.triangles, character.place, lone_joints(character, *spine, fraction.size()),
      fraction, coordinate, rest.position, kStandsOff * anatomy.height);
  std::vector<skin::Influences> out = character.influences;
  for (std::size_t v = 0; v < out.size(); ++v) {
    if (prop[v]) continue;
    const double s = coordinate[character.place[v]];
    if (!std::isfinite(s)) continue;
    std::vector<Entry> entries;
    double of_spine = 0.0;
    for (int k = 0; k < skin::kMaxInfluences; ++k) {
      const Entry entry{out[v].joint[k], out[v].weight[k]};
      if (!(entry.weight > 0.0f)) continue;
      const int found = spine->index[entry.joint];
      // Above the chest nothing bends: whose the weight is there changes nothing.
      const bool above = found >= static_cast<int>(fraction.size());
      if (found >= 0 && !(above && s >= 1.0))
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
      entries.push_back({spine->joint[high - 1], static_cast<float>(of_spine * (1.0 - upper))});
    if (upper > 0.0) entries.push_back({spine->joint[high], static_cast<float>(of_spine * upper)});
    out[v] = packed(std::move(entries));
  }
  return out;
}

}  // namespace backbend::validate
