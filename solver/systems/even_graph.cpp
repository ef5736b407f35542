#include "solver/systems/even_graph.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "solver/math/gauss_legendre.h"
#include "solver/math/rotation.h"
#include "solver/systems/even_options.h"
#include "solver/systems/fk_bones.h"
#include "solver/systems/system_base.h"

namespace backbend::solver {
namespace {

using glm::dquat;
using glm::dvec3;

/// What a sum of turned steps cannot do.
void check_options(const SpineSystem& system) {
  const auto number = [&](const char* key) { return std::get<double>(system.options().at(key)); };
  const auto refuse = [&](const std::string& key, const std::string& why) {
    throw RigError(std::string(system.name()) + ": option '" + key +
                   "' cannot be exported: " + why);
  };
  if (number("reach") > 0.0) refuse("reach", "it solves for the chest's place in every pose");
  if (std::get<std::string>(system.options().at("limits")) != "none")
    refuse("limits", "it shares each channel out among the joints in every pose");
  if (number("stretchiness") > 0.0) refuse("stretchiness", "the exported spine keeps its length");
}

EvenGraph::Weights graph_weights_at(const EvenWeights& weights, double s) {
  EvenGraph::Weights out{};
  for (int channel = 0; channel < kUpperChannels; ++channel)
    out[std::size_t(channel)] = weights.of(channel)(s);
  return out;
}

/// The drawn polyline by arc fraction.
class DrawnLine {
 public:
  explicit DrawnLine(const std::vector<dvec3>& joint)
      : joint_(joint), corner_(polyline_arcs(joint)) {
    length_ = corner_.back();
    for (double& c : corner_) c /= length_;
  }
  double length() const { return length_; }
  const std::vector<double>& corners() const { return corner_; }
  dvec3 tangent(double s) const {
    const std::size_t i = segment(s);
    return glm::normalize(joint_[i] - joint_[i - 1]);
  }
  dvec3 point(double s) const {
    const std::size_t i = segment(s);
    return glm::mix(joint_[i - 1], joint_[i], (s - corner_[i - 1]) / (corner_[i] - corner_[i - 1]));
  }

 private:
  std::size_t segment(double s) const {
    std::size_t i = 1;
    while (i + 1 < corner_.size() && s > corner_[i]) ++i;
    return i;
  }
  const std::vector<dvec3>& joint_;
  std::vector<double> corner_;
  double length_ = 0.0;
};

/// Where sums are read and the line turns: ascending, 0 first, 1 last, none twice.
std::vector<double> cuts(std::vector<double> at) {
  constexpr double kSame = 1e-9;
  std::sort(at.begin(), at.end());
  at.erase(std::unique(at.begin(), at.end(), [](double a, double b) { return b - a < kSame; }),
           at.end());
  at.back() = 1.0;
  return at;
}

std::size_t samples_below(const EvenGraph& graph, double s) {
  return std::size_t(std::ranges::count_if(
      graph.sample, [&](const EvenGraph::Sample& sample) { return sample.at < s; }));
}

/// Draws of one seed, the same on every machine.
class Draw {
 public:
  double between(double low, double high) {
    return low + (high - low) * (double(random_() >> 11) * 0x1p-53);
  }
  bool coin() { return random_() >> 63; }

 private:
  std::mt19937_64 random_{20240};
};

}  // namespace

void check_has_graph(const SystemSpec& spec) {
  if (spec.system != "even")
    throw RigError(spec.system + ": only 'even' is a product of Euler turns that can be exported");
}

EvenGraph even_graph(const SystemSpec& spec, const RestChain& chain, int steps_per_length) {
  check_has_graph(spec);
  const std::unique_ptr<SpineSystem> system = build_system(spec, chain);
  check_options(*system);
  OptionReader read(spec);
  const EvenWeights weights = read_even_weights(read);
  const EvenPlaces places = read_even_places(read);
  const FkBones bones(chain, spec.system);
  const DrawnLine line(chain.joint);

  EvenGraph graph;
  graph.origin = chain.joint.front();
  graph.length = line.length();
  std::vector<double> at = places.joint;
  at.insert(at.end(), line.corners().begin(), line.corners().end());
  const char* const names[] = {"lower", "middle", "top"};
  for (std::size_t k = 0; k < 3; ++k) {
    EvenGraph::Control& control = graph.control[k];
    control.name = names[k];
    control.axes = bones.axes[k];
    control.bone = glm::distance(bones.rest.joint[k], bones.rest.joint[k + 1]);
    // Four joints are the three bones' own; other chains are cut at thirds of their arc.
    control.at = chain.joint.size() == 4 ? line.corners()[k] : double(k) / 3.0;
    control.place = bones.rest.joint[k];
    at.push_back(control.at);
  }
  at = cuts(std::move(at));
  std::vector<double> node, weight;
  for (std::size_t i = 1; i < at.size(); ++i) {
    const double width = at[i] - at[i - 1];
    gauss_legendre(std::max(1, int(std::ceil(width * steps_per_length - 1e-9))), node, weight);
    for (std::size_t n = 0; n < node.size(); ++n) {
      const double s = at[i - 1] + width * node[n];
      graph.sample.push_back(
          {s, graph_weights_at(weights, s), (weight[n] * width * line.length()) * line.tangent(s)});
    }
  }
  for (EvenGraph::Control& control : graph.control)
    control.samples = samples_below(graph, control.at);
  for (std::size_t k = 0; k < places.joint.size(); ++k)
    graph.joint.push_back({places.joint[k], places.frame[k],
                           graph_weights_at(weights, places.frame[k]), line.point(places.joint[k]),
                           samples_below(graph, places.joint[k])});
  return graph;
}

EvenGraph::Pose EvenGraph::pose(std::span<const double> c) const {
  assert(c.size() >= 9);
  const auto upper = [&](const Weights& w) {
    return euler_turn(control[1].axes, from_euler_xyz(w[0] * c[3], w[1] * c[4], w[2] * c[5])) *
           euler_turn(control[2].axes, from_euler_xyz(w[3] * c[6], w[4] * c[7], w[5] * c[8]));
  };
  const dquat lower = euler_turn(control[0].axes, from_euler_xyz(c[0], c[1], c[2]));
  std::vector<dvec3> sum{dvec3(0.0)};
  for (const Sample& each : sample) sum.push_back(sum.back() + upper(each.weight) * each.step);
  Pose out;
  for (const Joint& each : joint) {
    out.turn.push_back(lower * upper(each.weight));
    out.place.push_back(origin + lower * sum[each.samples]);
  }
  return out;
}

GraphDistance distance_from_solver(const EvenGraph& graph, const SpineSystem& system, int poses) {
  GraphDistance out;
  out.poses = poses;
  Draw draw;
  std::vector<double> control(system.channels().size());
  for (std::size_t i = 0; i < control.size(); ++i) control[i] = system.channels()[i].rest;
  SpinePose exact;
  for (int p = 0; p < poses; ++p) {
    for (std::size_t i = 0; i < 9; ++i)
      control[i] = p % 8 == 0 ? (draw.coin() ? kPi : -kPi) : draw.between(-kPi, kPi);
    const EvenGraph::Pose pose = graph.pose(control);
    system.solve_into(control, Detail::joints, exact);
    for (std::size_t k = 0; k < pose.turn.size(); ++k) {
      out.turn_deg = std::max(out.turn_deg, degrees(angle_between(pose.turn[k], exact.turn[k])));
      out.place =
          std::max(out.place, glm::distance(pose.place[k], exact.position[k]) / graph.length);
    }
  }
  return out;
}

EvenGraph even_graph_within(const SystemSpec& spec, const RestChain& chain, double most, int poses,
                            GraphDistance& distance) {
  constexpr int kMostSteps = 256;  // the integral of the steepest weights, too, is within by then
  const std::unique_ptr<SpineSystem> system = build_system(spec, chain);
  std::size_t before = 0;
  for (int steps = 4;; ++steps) {
    EvenGraph graph = even_graph(spec, chain, steps);
    const bool is_new = graph.sample.size() != before;
    before = graph.sample.size();
    if (!is_new && steps < kMostSteps) continue;
    distance = distance_from_solver(graph, *system, poses);
    if (distance.place <= most || steps >= kMostSteps) return graph;
  }
}

}  // namespace backbend::solver
