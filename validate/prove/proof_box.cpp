#include "validate/prove/proof_box.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "solver/math/rotation.h"
#include "solver/rig/nearest_name.h"
#include "validate/files/output_folder.h"
#include "validate/sweeps/channel_ranges.h"

namespace backbend::validate {
namespace {

constexpr double kMostDegrees = 36000.0;  // a hundred turns
constexpr std::string_view kBodyAxes[kProofAxes] = {"extension", "side", "twist"};

ProofBox body_box(const std::string& name, const Envelope& e) {
  return {name,
          false,
          {{"extension", -e.flexion, e.extension},
           {"side", -e.side, e.side},
           {"twist", -e.twist, e.twist}}};
}

std::size_t control_index(const solver::SpineSystem& system, const std::string& name) {
  const auto& channels = system.channels();
  const auto found = std::find_if(channels.begin(), channels.end(),
                                  [&](const solver::Channel& c) { return c.name == name; });
  return std::size_t(found - channels.begin());
}

/// Puts what a user named in order: body channels in theirs, the missing ones at 0.
ProofBox ordered(std::vector<ProofAxis> named, const std::string& text,
                 const solver::SpineSystem& system) {
  ProofBox box{text, false, {}};
  const auto is_body = [](const ProofAxis& a) {
    return std::find(std::begin(kBodyAxes), std::end(kBodyAxes), a.channel) != std::end(kBodyAxes);
  };
  std::vector<std::string> known(std::begin(kBodyAxes), std::end(kBodyAxes));
  for (const solver::Channel& c : system.channels()) known.push_back(c.name);
  for (const ProofAxis& a : named) {
    if (!is_body(a) && control_index(system, a.channel) == system.channels().size()) {
      throw ProofError("box '" + text + "': no channel '" + a.channel + "'" +
                       solver::did_you_mean(a.channel, known));
    }
    box.of_controls = box.of_controls || !is_body(a);
  }
  if (named.empty()) throw ProofError("box '" + text + "': names no channel");
  if (box.of_controls) {
    for (const ProofAxis& a : named) {
      if (is_body(a)) {
        throw ProofError("box '" + text +
                         "': body channels and the rig's own controls cannot be mixed");
      }
    }
    if (named.size() > kProofAxes) {
      throw ProofError("box '" + text + "': names " + std::to_string(named.size()) +
                       " controls, expected " + std::to_string(kProofAxes) + " at most");
    }
    box.axis = std::move(named);
  } else {
    for (const std::string_view channel : kBodyAxes) {
      ProofAxis own{std::string(channel), 0.0, 0.0};
      for (const ProofAxis& a : named)
        if (a.channel == channel) own = a;
      box.axis.push_back(own);
    }
  }
  return box;
}

/// A box that a user wrote, as text or in a file.
ProofBox written(const std::string& text, const solver::SpineSystem& system) {
  std::vector<ProofAxis> axes;
  try {
    std::vector<ChannelRange> ranges = text.find('=') != std::string::npos
                                           ? ranges_in_text(text, "box '" + text + "'")
                                           : ranges_in_file(text);
    join_flexion(ranges);
    for (const ChannelRange& range : ranges) axes.push_back({range.channel, range.low, range.high});
  } catch (const ReadError& error) {
    throw ProofError(error.what());
  }
  return ordered(std::move(axes), text, system);
}

}  // namespace

std::string ProofBox::text() const {
  std::string all;
  for (const ProofAxis& a : axis) {
    if (!all.empty()) all += ", ";
    all += a.channel + " " + number_text(a.low);
    if (a.varies()) all += ".." + number_text(a.high);
  }
  return all;
}

void check_box(const ProofBox& box, const std::string& where) {
  bool varies = false;
  for (const ProofAxis& a : box.axis) {
    if (!std::isfinite(a.low) || !std::isfinite(a.high)) {
      throw ProofError(where + ": '" + a.channel + "' is not finite");
    }
    if (a.low > a.high) {
      throw ProofError(where + ": '" + a.channel + "' goes from " + number_text(a.low) + " to " +
                       number_text(a.high) + "; the smaller value comes first");
    }
    if (std::max(std::abs(a.low), std::abs(a.high)) > kMostDegrees) {
      throw ProofError(where + ": '" + a.channel + "' goes past " + number_text(kMostDegrees) +
                       ", the most that a proof takes");
    }
    varies = varies || a.varies();
  }
  if (!varies) throw ProofError(where + ": the box is empty: no channel varies");
}

ProofBox read_box(const std::string& text, const Envelope& envelope,
                  const solver::SpineSystem& system) {
  ProofBox box;
  const Envelope all = *find_envelope("sweep");
  if (text == "envelope") {
    box = body_box(text, envelope);
  } else if (text == "sweep") {
    box = body_box(text, reach_of(all, standard_sweeps(envelope)));
  } else if (text == "stress") {
    box = body_box(text, reach_of(all, stress_sweeps()));
  } else if (text.find('=') != std::string::npos || std::filesystem::exists(text)) {
    box = written(text, system);
  } else {
    throw ProofError("no box '" + text +
                     "': expected envelope, stress, sweep, a TOML file with a "
                     "[box] table, or text like extension=0:180,side=0");
  }
  check_box(box, "box '" + text + "'");
  return box;
}

SubBox whole_of(const ProofBox& box) {
  SubBox all;
  for (std::size_t j = 0; j < box.axis.size(); ++j) {
    all.low[j] = box.axis[j].low;
    all.high[j] = box.axis[j].high;
  }
  return all;
}

std::array<SubBox, 2> halves(const SubBox& box, int axis) {
  const auto j = std::size_t(axis);
  std::array<SubBox, 2> half{box, box};
  half[0].high[j] = half[1].low[j] = 0.5 * box.low[j] + 0.5 * box.high[j];
  return half;
}

int widest_axis(const SubBox& box, double least, const std::array<bool, kProofAxes>& idle) {
  int widest = -1;
  double most = least;
  for (int j = 0; j < kProofAxes; ++j) {
    const double width = box.high[std::size_t(j)] - box.low[std::size_t(j)];
    if (width > most * (1.0 + 1e-12) && !idle[std::size_t(j)]) {
      most = width;
      widest = j;
    }
  }
  return widest;
}

double share_of(const SubBox& part, const ProofBox& whole) {
  double share = 1.0;
  for (std::size_t j = 0; j < whole.axis.size(); ++j) {
    if (whole.axis[j].varies()) share *= (part.high[j] - part.low[j]) / whole.axis[j].width();
  }
  return share;
}

PoseOfBox::PoseOfBox(const ProofBox& box, const solver::SpineSystem& system,
                     solver::Mapping mapping)
    : box_(box), system_(system), mapping_(mapping) {
  if (!box.of_controls) return;
  for (const ProofAxis& a : box.axis) channel_.push_back(control_index(system, a.channel));
}

std::vector<double> PoseOfBox::at(const std::array<double, kProofAxes>& pose) const {
  if (!box_.of_controls) {
    return system_.controls_for(
        PoseDegrees{std::max(pose[0], 0.0), std::max(-pose[0], 0.0), pose[1], pose[2]}.radians(),
        mapping_);
  }
  std::vector<double> control;
  for (const solver::Channel& c : system_.channels()) control.push_back(c.rest);
  for (std::size_t j = 0; j < channel_.size(); ++j) {
    const bool angle = system_.channels()[channel_[j]].kind == solver::Channel::Kind::rotation;
    control[channel_[j]] = angle ? solver::radians(pose[j]) : pose[j];
  }
  return control;
}

std::string pose_text(const ProofBox& box, const std::array<double, kProofAxes>& pose) {
  std::string all;
  for (std::size_t j = 0; j < box.axis.size(); ++j) {
    std::string channel = box.axis[j].channel;
    double value = pose[j];
    if (channel == "extension" && value < 0.0) {
      channel = "flexion";
      value = -value;
    }
    if (!all.empty()) all += ", ";
    all += channel + " " + number_text(value, 5);
  }
  return all;
}

}  // namespace backbend::validate
