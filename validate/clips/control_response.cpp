#include "validate/clips/control_response.h"

#include <algorithm>
#include <cmath>

#include "skin/character/matrix_facts.h"
#include "validate/clips/clip_frames.h"
#include "validate/metrics/math/rotation.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

// Degrees of control: where a channel is read, what moves a channel at all, and what stands still.
constexpr double kReadAt = 30.0, kMoves = 5.0, kStill = 0.5;
// Degrees of bend that a pose at rest may have.
constexpr double kBent = 5.0;

/// Turns of the joints from hips to chest, each against the one below, rest taken off, added up:
/// world axes of rest, radians.
glm::dvec3 spine_turn(const ClipBody& body, const skin::Anatomy& anatomy, Index frame) {
  glm::dvec3 sum(0.0);
  for (Index k = 1; k <= anatomy.chest_index; ++k)
    sum += rotation_vector(glm::conjugate(body.turn(frame, anatomy.spine[k - 1])) *
                           body.turn(frame, anatomy.spine[k]));
  return sum;
}

/// The only control that moves over a sweep; -1 for none or several.
int only_control(const skin::Clip& clip, const skin::ClipSweep& range) {
  int only = -1;
  for (Index c = 0; c < clip.control.size(); ++c) {
    double low = control_value(clip, range.first, c), high = low;
    for (Index f = range.first; f < range.first + range.count; ++f) {
      low = std::fmin(low, control_value(clip, f, c));
      high = std::fmax(high, control_value(clip, f, c));
    }
    if (!(high - low > kStill)) continue;
    if (only >= 0 || high - low < kMoves) return -1;
    only = static_cast<int>(c);
  }
  return only;
}

}  // namespace

std::optional<ChannelResponse> control_response(const skin::Clip& clip,
                                                const skin::ClipSweep& range,
                                                const skin::Anatomy& anatomy,
                                                const skin::Character& character,
                                                const ClipBody& body) {
  const int control = only_control(clip, range);
  if (control < 0 || !(glm::length(anatomy.left) > 0.5)) return std::nullopt;
  ChannelResponse out;
  out.channel = clip.control[static_cast<Index>(control)];
  const bool bends_back = out.channel == "extension",
             bends = bends_back || out.channel == "flexion";
  if (!bends && out.channel != "side" && out.channel != "twist") return std::nullopt;

  // The frame nearest to rest, and the one nearest to kReadAt from there.
  Index rest = range.first, read = range.first;
  const auto value = [&](Index f) { return control_value(clip, f, static_cast<Index>(control)); };
  for (Index f = range.first; f < range.first + range.count; ++f)
    if (std::abs(value(f)) < std::abs(value(rest))) rest = f;
  const auto off = [&](Index f) { return std::abs(std::abs(value(f) - value(rest)) - kReadAt); };
  for (Index f = range.first; f < range.first + range.count; ++f)
    if (off(f) < off(read)) read = f;
  out.pose = read - range.first;
  out.asked_deg = value(read) - value(rest);
  if (!(std::abs(out.asked_deg) >= kMoves)) return std::nullopt;

  const auto at = [&](int node) {
    return skin::origin(character.nodes[static_cast<Index>(node)].world_from_node);
  };
  const glm::dvec3 chest = at(anatomy.spine[anatomy.chest_index]) - at(anatomy.spine.front());
  const glm::dvec3 along = glm::normalize(chest - anatomy.left * glm::dot(chest, anatomy.left));
  const glm::dvec3 turn = spine_turn(body, anatomy, read) - spine_turn(body, anatomy, rest);
  if (!std::isfinite(glm::dot(turn, turn)) || !std::isfinite(glm::dot(along, along)))
    return std::nullopt;
  const glm::dvec3 axis = bends                    ? anatomy.left
                          : out.channel == "twist" ? along
                                                   : glm::cross(anatomy.left, along);
  const double about = degrees(glm::dot(turn, axis));
  out.other_deg = degrees(glm::length(turn - axis * glm::dot(turn, axis)));
  if (bends)
    out.arrived_deg = bends_back ? -about : about;
  else
    out.arrived_deg = std::copysign(about, out.asked_deg);
  return out;
}

double bend_at_rest(const skin::Clip& clip, const skin::Anatomy& anatomy, const ClipBody& body) {
  if (clip.control.empty()) return 0.0;
  for (Index f = 0; f < clip.frame_count(); ++f) {
    bool rests = true;
    for (Index c = 0; c < clip.control.size(); ++c)
      rests = rests && std::abs(control_value(clip, f, c)) <= kStill;
    if (!rests) continue;
    const double bent = degrees(glm::length(spine_turn(body, anatomy, f)));
    return bent >= kBent ? bent : 0.0;
  }
  return 0.0;
}

}  // namespace backbend::validate
