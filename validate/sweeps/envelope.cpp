#include "validate/sweeps/envelope.h"

#include <algorithm>
#include <cmath>

namespace backbend::validate {
namespace {

/// Rows are hips to chest, except `neck`.
std::vector<Envelope> envelopes() {
  return {
      // Voluntary range of a fit adult (research: specification 8).
      {"human", 60, 90, 45, 60, false, "voluntary range of a fit adult"},
      // Four legs carry the back between them: a galloping cat or hound rounds it further than it
      // hollows it, and the ribs let it turn least.
      {"animal", 30, 60, 45, 30, false, "what a galloping animal does with its back"},
      // The heavier the body, the less its back bends: the neck is what moves.
      {"long_neck", 20, 30, 30, 20, false, "a heavy back under a long neck that does the moving"},
      // Vertebrae that lock against twist and bend sideways most: one wide turn over the body.
      {"snake", 45, 45, 90, 30, false, "vertebrae that bend sideways and lock against twist"},
      // Looks back over its shoulder, and reaches the ground.
      {"neck", 60, 90, 60, 60, false, "a neck that looks behind itself and reaches the ground"},
      // Room for what animators ask of cartoons.
      {"cartoon", 120, 120, 75, 120, false, "what animators ask of cartoons"},
      {"creature", 45, 60, 60, 45, false, "a body between a human's and an animal's"},
      {"sweep", 0, 0, 0, 0, true, "all that is swept counts"},
  };
}

/// A corner sweep, its leading channel the one that goes furthest.
Sweep sweep_to(const PoseDegrees& corner) {
  constexpr int kIntervals = 10;
  std::string_view leading = kBendChannels.front();
  for (const std::string_view channel : kBendChannels)
    if (std::abs(*corner.find(channel)) > std::abs(*corner.find(leading))) leading = channel;
  const double end = *corner.find(leading);
  Sweep sweep = channel_sweep(leading, 0, end, std::abs(end) / kIntervals);
  sweep.name = "corner";
  for (const std::string_view channel : kBendChannels) {
    const double value = *corner.find(channel);
    *sweep.per_degree.find(channel) = value / end;
    if (value != 0.0) sweep.name += " " + std::string(channel) + " " + number_text(value);
  }
  sweep.corner = true;
  sweep.watched = false;  // too few poses to follow
  return sweep;
}

}  // namespace

double Envelope::needs(std::string_view channel) const {
  if (channel == "extension") return extension;
  if (channel == "flexion") return flexion;
  if (channel == "side") return side;
  return channel == "twist" ? twist : 0.0;
}

bool Envelope::contains(const PoseDegrees& pose) const {
  if (whole_sweep) return true;
  constexpr double kSlack = 1e-9;  // a pose on the border is inside whatever its last bit says
  return std::all_of(std::begin(kChannels), std::end(kChannels), [&](std::string_view channel) {
    return std::abs(*pose.find(channel)) <= needs(channel) + kSlack;
  });
}

std::string Envelope::text() const {
  if (whole_sweep) return "everything that is swept";
  std::string text;
  for (const std::string_view channel : kBendChannels)
    text += std::string(channel) + " " + number_text(needs(channel)) + ", ";
  return text + "and their corners";
}

std::optional<Envelope> find_envelope(std::string_view name) {
  for (const Envelope& envelope : envelopes())
    if (envelope.name == name) return envelope;
  return std::nullopt;
}

std::vector<std::string> envelope_names() {
  std::vector<std::string> names;
  for (const Envelope& envelope : envelopes()) names.push_back(envelope.name);
  return names;
}

Envelope envelope_for(skin::BodyKind kind, bool neck_is_driven) {
  if (neck_is_driven) return *find_envelope("neck");
  return *find_envelope(skin::name_of(kind));
}

std::vector<Sweep> standard_sweeps(const Envelope& envelope) {
  const auto to = [&](std::string_view channel, double usual) {
    return std::max(usual, envelope.needs(channel));
  };
  // To a whole number of steps: the end itself must be a pose.
  const auto both_ways = [&](std::string_view channel, double usual, double step) {
    const double end = to(channel, usual), steps = std::ceil(end / step - 1e-9);
    return channel_sweep(channel, -end, end, end / steps);
  };
  const auto one_way = [&](std::string_view channel, double usual, double step) {
    const double end = to(channel, usual), steps = std::ceil(end / step - 1e-9);
    return channel_sweep(channel, 0, end, end / steps);
  };
  return {one_way("extension", 120, 2), one_way("flexion", 90, 2), both_ways("side", 45, 3),
          both_ways("twist", 90, 3)};
}

Envelope reach_of(const Envelope& envelope, const std::vector<Sweep>& sweeps) {
  if (!envelope.whole_sweep) return envelope;
  const auto reach = [&](std::string_view channel) {
    double most = 0.0;
    for (const Sweep& sweep : sweeps)
      if (moves_alone(sweep, channel))
        most = std::max({most, std::abs(sweep.from_deg), std::abs(sweep.to_deg)});
    return most;
  };
  return {envelope.name, reach("extension"), reach("flexion"), reach("side"), reach("twist"),
          true,          envelope.reason};
}

std::vector<Sweep> corner_sweeps(const Envelope& envelope) {
  std::vector<Sweep> sweeps;
  const double bends[] = {envelope.extension, -envelope.flexion, 0.0};
  const double sides[] = {envelope.side, -envelope.side, 0.0};
  const double twists[] = {envelope.twist, -envelope.twist, 0.0};
  // The 27 combinations of an end, the other end and rest: those with two channels or more off
  // rest. The last entry of each list is rest; an end of 0 is none of its own.
  for (std::size_t b = 0; b < 3; ++b) {
    for (std::size_t s = 0; s < 3; ++s) {
      for (std::size_t t = 0; t < 3; ++t) {
        const int moved = (b < 2) + (s < 2) + (t < 2);
        const bool none =
            (b < 2 && bends[b] == 0.0) || (s < 2 && sides[s] == 0.0) || (t < 2 && twists[t] == 0.0);
        if (moved < 2 || none) continue;
        sweeps.push_back(
            sweep_to({std::max(bends[b], 0.0), std::max(-bends[b], 0.0), sides[s], twists[t]}));
      }
    }
  }
  return sweeps;
}

bool moves_alone(const Sweep& sweep, std::string_view channel) {
  if (!sweep.through.empty() || sweep.channel != channel) return false;
  return std::ranges::all_of(kChannels, [&](std::string_view each) {
    return *sweep.start.find(each) == 0.0 &&
           *sweep.per_degree.find(each) == (each == channel ? 1.0 : 0.0);
  });
}

}  // namespace backbend::validate
