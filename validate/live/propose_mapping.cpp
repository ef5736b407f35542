#include "validate/live/propose_mapping.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "skin/character/printable.h"
#include "validate/live/external_rig.h"
#include "validate/metrics/chain/chain.h"
#include "validate/metrics/math/rotation.h"
#include "validate/metrics/surface/rigid_fit.h"
#include "validate/sweeps/sweep.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

constexpr double kTried_deg = 20.0;
// A property that turns the chest by less does something else.
constexpr double kLeastArrived_deg = 0.5;
// Of the angle that a control is turned by: what must arrive about the channel's axis, what may
// arrive about the others of that, and what the hips may turn.
constexpr double kLeastShare = 0.5, kMostAcross = 0.5, kMostHips = 0.1;
// A control that bends so many joints is one for the whole spine. And how far apart along it, in
// joints, two controls bend that are two of a chain.
constexpr double kSeveral = 1.5, kApart = 0.5;
// A control that is held above the chest turns it by the same share about every axis, and a joint
// above it by all: how far the shares may be apart, and what counts as all.
constexpr double kSameShare = 0.05, kWhole = 0.95;

// Extension, side, twist.
constexpr std::array<std::string_view, 3> kAxes = {"extension", "side", "twist"};

/// What one channel of the rig does to the spine. `The angle` is what a rotation was turned by; of
/// a property, which may be in any unit, what arrived at the chest.
struct ControlResponse {
  std::string control;
  std::string axis, property;    // one of them is empty
  double step = 0.0;             // of a property: by how much it was changed
  double arrived_deg = 0.0;      // of a property
  glm::dvec3 share{0.0};         // about kAxes, of the angle
  std::vector<glm::dvec3> turn;  // of each bone against the one below, of the angle
  double hips = 0.0;             // of the angle

  /// How many joints take part: 1 where all turn alike, 1/n where one does all.
  double over() const {
    double sum = 0.0, squares = 0.0;
    for (const glm::dvec3& each : turn) {
      sum += glm::length(each);
      squares += glm::dot(each, each);
    }
    return squares > 0.0 ? sum * sum / squares / static_cast<double>(turn.size()) : 0.0;
  }
  /// Where along the spine it bends, in joints.
  double middle() const {
    double sum = 0.0, moment = 0.0;
    for (Index k = 0; k < turn.size(); ++k) {
      sum += glm::length(turn[k]);
      moment += glm::length(turn[k]) * static_cast<double>(k);
    }
    return sum > 0.0 ? moment / sum : 0.0;
  }
  bool bends_several() const {
    const auto joints = static_cast<double>(turn.size());
    return over() * joints >= std::min(kSeveral, 0.75 * joints);
  }
  bool stands_for(int axis_of_body) const {
    glm::dvec3 across = share;
    across[axis_of_body] = 0.0;
    const double along = std::abs(share[axis_of_body]);
    return (property.empty() || arrived_deg >= kLeastArrived_deg) && along >= kLeastShare &&
           glm::length(across) <= kMostAcross * along && hips <= kMostHips;
  }
};

/// How well one control stands for a channel: what arrives, over how much of the spine.
double quality(const ControlResponse& response, int axis) {
  const double along = std::abs(response.share[axis]);
  return std::min(along, 1.0 / along) * (0.5 + response.over());
}

class Prober {
 public:
  Prober(const solver::SystemSpec& spec, const skin::Character& character,
         const skin::Anatomy& anatomy)
      : rig_(spec, character, anatomy, ExternalRig::ToBeTried{}), node_(character.nodes) {
    above_.assign(anatomy.spine.begin() + static_cast<std::ptrdiff_t>(anatomy.chest_index) + 1,
                  anatomy.spine.end());
    const std::vector<glm::dvec3>& joint = rig_.rest().position;
    const glm::dvec3 left = anatomy.left, whole = joint.back() - joint.front();
    const glm::dvec3 along = glm::normalize(whole - left * glm::dot(whole, left));
    axis_ = {-left, -glm::cross(left, along), along};
    for (const solver::Channel& channel : rig_.channels()) rest_.push_back(channel.rest);
    // A bone that bends inside stands in the chain with its segments: the middle one speaks for it.
    std::vector<std::string> bone;
    for (const std::string& name : rig_.joint_names())
      bone.push_back(name.substr(0, name.rfind(".seg")));
    for (Index k = 0; k < bone.size();) {
      Index end = k;
      while (end < bone.size() && bone[end] == bone[k]) ++end;
      middle_.push_back((k + end) / 2);
      k = end;
    }
  }

  const ExternalRig& rig() const { return rig_; }

  std::vector<ControlResponse> responses() const {
    std::vector<std::vector<double>> asked;
    std::vector<ControlResponse> out;
    for (Index c = 0; c < rest_.size(); ++c) {
      const std::string& name = rig_.channels()[c].name;
      const std::size_t dot = name.rfind('.');
      if (dot == std::string::npos) continue;  // a sidecar names a control and its channel
      ControlResponse response;
      response.control = name.substr(0, dot);
      const std::string channel = name.substr(dot + 1);
      double by = radians_from(kTried_deg);
      if (rig_.channels()[c].kind == solver::Channel::Kind::scalar) {
        response.property = channel;
        response.step = by = step_of(rig_.declared(c));
      } else if (channel == "rx" || channel == "ry" || channel == "rz") {
        response.axis = static_cast<char>(channel[1] - 'a' + 'A');
      } else {
        continue;
      }
      out.push_back(std::move(response));
      asked.push_back(rest_);
      asked.back()[c] += by;
    }
    rig_.prepare(asked, solver::Detail::joints);
    for (Index i = 0; i < out.size(); ++i) {
      double angle = radians_from(kTried_deg);
      if (!out[i].property.empty()) {
        angle = glm::length(sum_of_turns(rig_.pose(asked[i], solver::Detail::joints)));
        out[i].arrived_deg = degrees(angle);
        if (out[i].arrived_deg < kLeastArrived_deg) continue;
      }
      read(asked[i], angle, out[i]);
    }
    return out;
  }

  /// All of a channel's controls together, at 30 degrees of the channel.
  ControlResponse together(const std::vector<skin::SidecarControl>& controls) const {
    constexpr double kAsked_deg = 30.0;
    std::vector<double> asked = rest_;
    for (const auto& [body_channel, targets] : mapping_of(controls).channels)
      for (const ControlTarget& target : targets)
        for (Index c = 0; c < asked.size(); ++c)
          if (rig_.channels()[c].name == target.channel) {
            const double by = kAsked_deg * target.per_degree;
            asked[c] +=
                rig_.channels()[c].kind == solver::Channel::Kind::scalar ? by : radians_from(by);
          }
    ControlResponse out;
    read(asked, radians_from(kAsked_deg), out);
    return out;
  }

  /// The most of a rotation's turn that arrives at a joint of the spine above the chest.
  double arrives_above(const ControlResponse& response) const {
    const std::string channel =
        response.control + ".r" + static_cast<char>(response.axis[0] - 'X' + 'x');
    std::vector<double> asked = rest_;
    for (Index c = 0; c < asked.size(); ++c)
      if (rig_.channels()[c].name == channel) asked[c] += radians_from(kTried_deg);
    const solver::SpinePose pose = rig_.pose(asked, solver::Detail::all);
    double most = 0.0;
    for (const int node : pose.body ? above_ : std::vector<int>{}) {
      const auto n = static_cast<Index>(node);
      const glm::dquat turn = nearest_rotation(
          glm::dmat3(pose.body->world_from_node[n] * glm::inverse(node_[n].world_from_node)));
      most = std::max(most, glm::length(rotation_vector(glm::conjugate(pose.hip.turn) * turn)));
    }
    return most / radians_from(kTried_deg);
  }

 private:
  /// By how much a property is changed: half of the way to an end of its range, else by 1.
  static double step_of(const RigChannel& property) {
    if (std::isfinite(property.max) && property.max > property.rest)
      return 0.5 * (property.max - property.rest);
    if (std::isfinite(property.min) && property.min < property.rest)
      return 0.5 * (property.min - property.rest);
    return 1.0;
  }

  /// `angle` in radians.
  void read(const std::vector<double>& control, double angle, ControlResponse& out) const {
    const solver::SpinePose pose = rig_.pose(control, solver::Detail::joints);
    const glm::dvec3 sum = sum_of_turns(pose) / angle;
    for (Index b = 1; b < middle_.size(); ++b)
      out.turn.push_back(
          rotation_vector(glm::conjugate(pose.turn[middle_[b - 1]]) * pose.turn[middle_[b]]) /
          angle);
    for (int a = 0; a < 3; ++a) out.share[a] = glm::dot(sum, axis_[static_cast<Index>(a)]);
    out.hips = glm::length(rotation_vector(pose.hip.turn)) / angle;
  }

  ExternalRig rig_;
  const std::vector<skin::Node>& node_;
  std::vector<int> above_;  // nodes of the spine above the chest
  std::array<glm::dvec3, 3> axis_{};
  std::vector<double> rest_;
  std::vector<Index> middle_;  // of each bone, into the chain
};

/// One of `sharing` controls of a channel.
skin::SidecarControl control_of(const ControlResponse& response, int axis, Index sharing) {
  skin::SidecarControl out;
  out.channel = kAxes[static_cast<Index>(axis)];
  out.control = response.control;
  out.axis = response.axis;
  out.property = response.property;
  const double along = response.share[axis];
  if (response.property.empty())
    out.sign = along < 0.0 ? -1 : 1;
  else
    out.per_degree = response.step / (along * response.arrived_deg * static_cast<double>(sharing));
  return out;
}

/// The best of those that pass; the first of equal ones.
template <class Passes, class Value>
const ControlResponse* best_of(const std::vector<ControlResponse>& responses, const Passes& passes,
                               const Value& value) {
  const ControlResponse* best = nullptr;
  for (const ControlResponse& each : responses)
    if (passes(each) && (best == nullptr || value(each) > value(*best) + 1e-9)) best = &each;
  return best;
}

/// Controls that bend one place each: one for each place.
std::vector<const ControlResponse*> chain_of(const std::vector<ControlResponse>& responses,
                                             int axis) {
  std::vector<const ControlResponse*> sorted, chain;
  for (const ControlResponse& each : responses)
    if (each.stands_for(axis)) sorted.push_back(&each);
  std::ranges::stable_sort(sorted, {}, [](const ControlResponse* each) { return each->middle(); });
  for (const ControlResponse* each : sorted) {
    // A joint of the chain, in joints of the spine: bones that bend inside have several.
    const bool again = !chain.empty() && each->middle() - chain.back()->middle() < kApart;
    if (!again)
      chain.push_back(each);
    else if (quality(*each, axis) > quality(*chain.back(), axis) + 1e-9)
      chain.back() = each;
  }
  return chain;
}

/// The controls that stand for an axis: one that bends several joints, first of all `preferred`,
/// else a chain of those that bend one place each.
std::vector<const ControlResponse*> controls_of(const std::vector<ControlResponse>& responses,
                                                int axis, const std::string& preferred) {
  const auto value = [&](const ControlResponse& each) { return quality(each, axis); };
  const auto bends = [&](const ControlResponse& each) {
    return each.stands_for(axis) && each.bends_several();
  };
  const ControlResponse* one = best_of(
      responses,
      [&](const ControlResponse& each) { return each.control == preferred && bends(each); }, value);
  if (one == nullptr) one = best_of(responses, bends, value);
  if (one != nullptr) return {one};
  return chain_of(responses, axis);
}

/// Of one control that stands for all three channels: the share of its turn that arrives at the
/// chest, where that is the same about every axis, as it is where the control is held above the
/// chest. Else 1: what is lost about one axis alone is the rig's.
double share_of_held(const std::array<std::vector<const ControlResponse*>, 3>& chosen) {
  double least = 1.0, most = 0.0;
  for (Index axis = 0; axis < 3; ++axis) {
    if (chosen[axis].size() != 1 || !chosen[axis][0]->property.empty() ||
        chosen[axis][0]->control != chosen[0][0]->control)
      return 1.0;
    const double share = std::abs(chosen[axis][0]->share[static_cast<int>(axis)]);
    least = std::min(least, share);
    most = std::max(most, share);
  }
  return most < kWhole && most - least <= kSameShare ? 0.5 * (least + most) : 1.0;
}

}  // namespace

std::vector<skin::SidecarControl> ProposedMapping::controls() const {
  std::vector<skin::SidecarControl> out;
  for (const ProposedChannel& channel : channels)
    if (!channel.opposite) out.insert(out.end(), channel.controls.begin(), channel.controls.end());
  return out;
}

ProposedMapping propose_mapping(const solver::SystemSpec& spec, const skin::Character& character,
                                const skin::Anatomy& anatomy) {
  const Prober prober(spec, character, anatomy);
  std::vector<ControlResponse> responses, properties;
  for (ControlResponse& each : prober.responses())
    (each.property.empty() ? responses : properties).push_back(std::move(each));
  ProposedMapping out;
  out.rig = prober.rig().who();
  std::map<std::string, double> whole;  // controls for the whole spine: their quality for all axes
  for (const ControlResponse& each : responses) {
    whole.emplace(each.control, 0.0);
    for (int axis = 0; axis < 3; ++axis)
      if (each.stands_for(axis) && each.bends_several()) whole[each.control] += quality(each, axis);
  }
  out.tried = whole.size();
  out.properties_tried = properties.size();
  std::vector<std::pair<double, std::string>> ranked;
  for (const auto& [control, value] : whole)
    if (value > 0.0) ranked.emplace_back(-value, control);
  std::ranges::sort(ranked);
  for (Index i = 1; i < std::min<Index>(ranked.size(), 4); ++i)
    out.others.push_back(ranked[i].second);

  std::array<std::vector<const ControlResponse*>, 3> chosen;
  for (int axis = 0; axis < 3; ++axis) {
    auto& some = chosen[static_cast<Index>(axis)];
    some = controls_of(responses, axis, ranked.empty() ? "" : ranked.front().second);
    if (some.empty()) some = controls_of(properties, axis, "");
  }
  double held = share_of_held(chosen);
  if (held < 1.0 && std::ranges::any_of(chosen, [&](const auto& one) {
        return prober.arrives_above(*one.front()) < kWhole;
      }))
    held = 1.0;  // nowhere does all of it arrive: the rig loses it
  out.held_above = held < 1.0 ? held : 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto& some = chosen[static_cast<Index>(axis)];
    ProposedChannel channel;
    channel.channel = kAxes[static_cast<Index>(axis)];
    for (const ControlResponse* each : some) {
      channel.controls.push_back(control_of(*each, axis, some.size()));
      if (held < 1.0) {  // per_degree has the sign
        skin::SidecarControl& last = channel.controls.back();
        last.per_degree = std::exchange(last.sign, 1) / held;
      }
    }
    if (channel.controls.empty()) {
      out.missing.push_back(channel.channel);
      if (axis == 0) out.missing.emplace_back("flexion");
      continue;
    }
    const ControlResponse all = prober.together(channel.controls);
    channel.share = all.share[axis];
    channel.over = all.over();
    out.channels.push_back(channel);
    if (axis == 0) {
      channel.channel = "flexion";
      channel.opposite = true;
      for (skin::SidecarControl& each : channel.controls) {
        each.channel = "flexion";
        each.sign = -each.sign;
        each.per_degree = -each.per_degree;
      }
      out.channels.push_back(std::move(channel));
    }
  }
  if (out.channels.empty())
    throw solver::RigError(out.rig + ": none of its " + std::to_string(out.tried) +
                           " controls, turned by " + number_text(kTried_deg) +
                           " degrees about each axis, turns the chest against the hips" +
                           (properties.empty() ? "" : ", and none of its properties does"));
  return out;
}

std::string proposal_text(const ProposedMapping& proposal) {
  std::string text = "controls of " + skin::printable(proposal.rig) + ", " +
                     std::to_string(proposal.tried) + " turned by " + number_text(kTried_deg) +
                     " degrees about each axis" +
                     (proposal.properties_tried == 0
                          ? ""
                          : ", and " + std::to_string(proposal.properties_tried) + " properties") +
                     "\n";
  for (const ProposedChannel& channel : proposal.channels) {
    text += "  " + channel.channel + std::string(11 - channel.channel.size(), ' ');
    if (channel.opposite) {
      text += "the other way round\n";
      continue;
    }
    for (Index i = 0; i < channel.controls.size(); ++i) {
      const skin::SidecarControl& each = channel.controls[i];
      text += (i > 0 ? ", " : "") + skin::printable(each.control) + " " +
              (!each.property.empty()   ? skin::printable(each.property)
               : each.per_degree != 0.0 ? each.axis
                                        : (each.sign < 0 ? "-" : "+") + each.axis) +
              (each.per_degree != 0.0 ? " " + number_text(each.per_degree) + " a degree" : "");
    }
    if (channel.controls.size() > 1) text += ", shared equally";
    text += ": " + number_text(100.0 * channel.share, 0) + " % arrive at the chest, over " +
            number_text(100.0 * channel.over, 0) + " % of the joints\n";
  }
  if (proposal.held_above > 0.0)
    text += "             held above the chest, which gets " +
            number_text(100.0 * proposal.held_above, 0) +
            " % of its turn about every axis: scaled, so that the chest turns as asked\n";
  for (const std::string& channel : proposal.missing)
    text += "  " + channel + std::string(11 - channel.size(), ' ') +
            "no control turns the chest so: not measured\n";
  if (!proposal.others.empty()) {
    text += "  others     ";
    for (Index i = 0; i < proposal.others.size(); ++i)
      text += (i > 0 ? ", " : "") + skin::printable(proposal.others[i]);
    text += "\n";
  }
  return text;
}

std::string proposal_json(const ProposedMapping& proposal) {
  nlohmann::ordered_json channels = nlohmann::ordered_json::object();
  for (const ProposedChannel& channel : proposal.channels) {
    if (channel.opposite) continue;
    for (const skin::SidecarControl& each : channel.controls)
      channels[channel.channel].push_back(
          {{"control", each.control},
           {"channel", each.own_channel()},
           {"per_degree", each.per_degree != 0.0
                              ? each.per_degree
                              : each.sign / static_cast<double>(channel.controls.size())}});
  }
  return nlohmann::ordered_json{{"channels", channels}}.dump(
      2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace backbend::validate
