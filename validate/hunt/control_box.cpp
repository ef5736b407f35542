#include "validate/hunt/control_box.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "solver/rig/nearest_name.h"
#include "validate/files/output_folder.h"
#include "validate/measure/compound_search.h"
#include "validate/sweeps/channel_ranges.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kBend = "bend";
constexpr double kFarthest = 3600.0;  // as of a suite's sweeps

void set(PoseDegrees& pose, std::string_view axis, double value) {
  if (axis == kBend) {
    pose.extension = std::max(value, 0.0);
    pose.flexion = std::max(-value, 0.0);
  } else {
    *pose.find(axis) = value;
  }
}

double get(const PoseDegrees& pose, std::string_view axis) {
  return axis == kBend ? pose.extension - pose.flexion : *pose.find(axis);
}

using Entry = ChannelRange;

[[noreturn]] void fail(const std::string& place, const std::string& why) {
  throw ReadError(place + ": " + why);
}

void check(const Entry& entry) {
  const std::vector<std::string> channels(std::begin(kChannels), std::end(kChannels));
  const std::string named = "'" + entry.channel + "'";
  if (std::ranges::find(channels, entry.channel) == channels.end())
    fail(entry.place, "no channel " + named + solver::did_you_mean(entry.channel, channels));
  for (const double end : {entry.low, entry.high})
    if (!std::isfinite(end) || std::abs(end) > kFarthest)
      fail(entry.place, named + " must end between -" + number_text(kFarthest) + " and " +
                            number_text(kFarthest));
  if (entry.low > entry.high)
    fail(entry.place, named + " is inverted: " + number_text(entry.low) + " is above " +
                          number_text(entry.high));
  if ((entry.channel == "extension" || entry.channel == "flexion") && entry.low < 0.0)
    fail(entry.place,
         named + " must be 0 or more; below 0 it is the other of extension and flexion");
  if (entry.channel == "stretch" && !(entry.low > kLeastStretch))
    fail(entry.place, named + " leaves no spine; it must stay above " + number_text(kLeastStretch) +
                          " per cent");
}

ControlBox box_of(const std::string& name, const std::vector<Entry>& entries) {
  ControlBox box;
  box.name = name;
  const auto find = [&](std::string_view channel) {
    return std::ranges::find(entries, channel, &Entry::channel);
  };
  const auto add = [&](std::string_view axis, double low, double high) {
    if (low < high)
      box.axes.push_back({std::string(axis), low, high});
    else
      set(box.held, axis, low);
  };
  const auto extension = find("extension"), flexion = find("flexion");
  if (extension != entries.end() && flexion != entries.end()) {
    const auto moved = [](const Entry& entry) { return entry.high > 0.0; };
    if (moved(*extension) && moved(*flexion) && (extension->low > 0.0 || flexion->low > 0.0))
      fail(flexion->place, "extension and flexion must both begin at 0: no pose bends both ways");
    const bool forward = moved(*flexion);
    add(kBend, forward ? -flexion->high : extension->low,
        moved(*extension) ? extension->high : -flexion->low);
  } else if (extension != entries.end()) {
    add(kBend, extension->low, extension->high);
  } else if (flexion != entries.end()) {
    add(kBend, -flexion->high, -flexion->low);
  }
  for (const char* channel : {"side", "twist", "hip", "stretch"})
    if (const auto entry = find(channel); entry != entries.end())
      add(channel, entry->low, entry->high);
  if (box.axes.empty()) fail(name, "the box is empty: no channel moves in it");
  return box;
}

ControlBox box_of(const std::string& name, const Envelope& reach) {
  std::vector<Entry> entries;
  entries.push_back({"extension", 0.0, reach.extension, name});
  entries.push_back({"flexion", 0.0, reach.flexion, name});
  entries.push_back({"side", -reach.side, reach.side, name});
  entries.push_back({"twist", -reach.twist, reach.twist, name});
  return box_of(name, entries);
}

}  // namespace

PoseDegrees ControlBox::pose_at(std::span<const double> unit) const {
  PoseDegrees pose = held;
  for (std::size_t i = 0; i < axes.size(); ++i)
    set(pose, axes[i].name, std::lerp(axes[i].low, axes[i].high, unit[i]));
  return pose;
}

std::vector<double> ControlBox::point_of(const PoseDegrees& pose) const {
  std::vector<double> point;
  for (const BoxAxis& axis : axes)
    point.push_back(std::clamp((get(pose, axis.name) - axis.low) / axis.width(), 0.0, 1.0));
  return point;
}

std::map<std::string, std::pair<double, double>> ControlBox::channels() const {
  std::map<std::string, std::pair<double, double>> out;
  for (const BoxAxis& axis : axes) {
    if (axis.name != kBend) {
      out[axis.name] = {axis.low, axis.high};
      continue;
    }
    if (axis.high > 0.0) out["extension"] = {std::max(axis.low, 0.0), axis.high};
    if (axis.low < 0.0) out["flexion"] = {std::max(-axis.high, 0.0), -axis.low};
  }
  return out;
}

std::string ControlBox::text() const {
  std::string text;
  const auto moved = channels();
  for (const std::string_view channel : kChannels) {
    std::string ends;
    if (const auto found = moved.find(std::string(channel)); found != moved.end())
      ends = number_text(found->second.first) + ".." + number_text(found->second.second);
    else if (*held.find(channel) != 0.0)
      ends = number_text(*held.find(channel));
    if (!ends.empty()) text += (text.empty() ? "" : ", ") + std::string(channel) + " " + ends;
  }
  return text;
}

std::vector<std::string> box_words() { return {"envelope", "stress", "sweep"}; }

ControlBox find_box(const std::string& word, const Envelope& envelope) {
  if (word == "sweep") return box_of(word, search_box(envelope, standard_sweeps(envelope)));
  if (word == "envelope")
    // Where everything that is swept counts, that is the envelope.
    return box_within(envelope, standard_sweeps(envelope));
  if (word == "stress") return box_of(word, reach_of(*find_envelope("sweep"), stress_sweeps()));
  return read_box(word);
}

ControlBox box_within(const Envelope& envelope, const std::vector<Sweep>& sweeps) {
  return box_of("envelope", reach_of(envelope, sweeps));
}

ControlBox read_box(const fs::path& file) {
  std::error_code none;
  const bool is_text = file.string().find('=') != std::string::npos;
  if (!is_text && !fs::exists(file, none) && !file.has_extension()) {
    const std::string word = file.string();
    throw ReadError("no box '" + word + "'" + solver::did_you_mean(word, box_words()) +
                    " (envelope | stress | sweep, or a file of channel = [least, most])");
  }
  std::vector<Entry> entries =
      is_text ? ranges_in_text(file.string(), "box '" + file.string() + "'") : ranges_in_file(file);
  split_flexion(entries);
  for (const Entry& entry : entries) check(entry);
  return box_of(file.string(), entries);
}

}  // namespace backbend::validate
