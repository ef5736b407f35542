#include "tests/battery/motion.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <nlohmann/json.hpp>
#include <set>

#include "skin/character/matrix_facts.h"
#include "tests/battery/body_variants.h"
#include "validate/clips/clip_body.h"
#include "validate/files/import.h"
#include "validate/metrics/math/rotation.h"

namespace backbend::battery {
namespace {

using Index = std::size_t;
using skin::Character;

/// A transform between two others: places and axes' lengths in straight lines, turns the short way.
glm::dmat4 between(const glm::dmat4& a, const glm::dmat4& b, double t) {
  const auto lengths = [](const glm::dmat4& m) {
    return glm::dvec3(glm::length(m[0]), glm::length(m[1]), glm::length(m[2]));
  };
  const auto turn = [&](const glm::dmat4& m) {
    const glm::dvec3 l = lengths(m);
    return glm::quat_cast(
        glm::dmat3(glm::dvec3(m[0]) / l.x, glm::dvec3(m[1]) / l.y, glm::dvec3(m[2]) / l.z));
  };
  const glm::dvec3 length = glm::mix(lengths(a), lengths(b), t);
  const glm::dmat3 axes = glm::mat3_cast(glm::slerp(turn(a), turn(b), t));
  glm::dmat4 out(1.0);
  for (int c = 0; c < 3; ++c) out[c] = glm::dvec4(axes[c] * length[c], 0.0);
  out[3] = glm::mix(a[3], b[3], t);
  return out;
}

std::vector<std::uint8_t> clip_file(const nlohmann::json& header,
                                    const std::vector<std::vector<glm::dmat4>>& world) {
  const std::string text = header.dump() + "\n";
  std::vector<std::uint8_t> out(text.begin(), text.end());
  for (const auto& frame : world)
    for (const glm::dmat4& m : frame)
      for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r) {
          const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(m[c][r]));
          for (int k = 0; k < 4; ++k) out.push_back(static_cast<std::uint8_t>(bits >> (8 * k)));
        }
  return out;
}

nlohmann::json numbers(const glm::dmat4& m) {
  nlohmann::json out = nlohmann::json::array();
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r) out.push_back(m[c][r]);
  return out;
}

/// Where in the times, and how far to the next.
std::pair<Index, double> place_in(const std::vector<double>& time, Index first, Index count,
                                  double t) {
  Index at = first;
  while (at + 2 < first + count && time[at + 1] <= t) ++at;
  const double step = time[at + 1] - time[at];
  return {at, std::clamp((t - time[at]) / step, 0.0, 1.0)};
}

std::vector<double> sampled_times(double from, double to, double rate, double slow) {
  std::vector<double> out;
  const double seconds = (to - from) / slow;
  const auto count = static_cast<Index>(std::floor(seconds * rate + 1e-9)) + 1;
  for (Index f = 0; f < count; ++f) out.push_back(static_cast<double>(f) / rate);
  return out;
}

}  // namespace

std::vector<glm::dmat4> world_of(const Character& body, const std::vector<glm::dmat4>& local) {
  std::vector<glm::dmat4> world(local.size());
  for (Index n = 0; n < local.size(); ++n) {
    const int parent = body.nodes[n].parent;
    world[n] = parent < 0 ? local[n] : world[static_cast<Index>(parent)] * local[n];
  }
  return world;
}

Motion sweep_motion(const Character& body, const skin::Anatomy& anatomy,
                    const std::vector<int>& chain, const SweepPlan& plan) {
  Motion out;
  out.name = "sweep";
  std::vector<double> arc = {0.0};
  const auto place = [&](Index k) {
    return skin::origin(body.nodes[static_cast<Index>(chain[k])].world_from_node);
  };
  for (Index k = 1; k < chain.size(); ++k)
    arc.push_back(arc.back() + glm::distance(place(k - 1), place(k)));
  const glm::dvec3 axis =
      validate::radians_from(1.0) *
      (-plan.extension * anatomy.left + plan.side * anatomy.forward + plan.twist * anatomy.up);
  const auto count = static_cast<Index>(plan.seconds * plan.frames_per_second) + 1;
  const std::pair<const char*, double> controls[] = {{"extension", std::max(plan.extension, 0.0)},
                                                     {"flexion", std::max(-plan.extension, 0.0)},
                                                     {"side", plan.side},
                                                     {"twist", plan.twist}};
  if (plan.record_controls)
    for (const auto& [name, degrees] : controls)
      if (degrees != 0.0) out.control.emplace_back(name);
  for (Index f = 0; f < count; ++f) {
    const double t = static_cast<double>(f) / static_cast<double>(count - 1);
    const double ease = 0.5 - 0.5 * std::cos(2.0 * validate::kPi * t);
    out.time.push_back(static_cast<double>(f) / plan.frames_per_second);
    std::vector<glm::dmat4> local;
    for (const skin::Node& node : body.nodes) local.push_back(node.parent_from_node);
    glm::dquat below(1.0, 0.0, 0.0, 0.0);
    for (Index k = 1; k < chain.size(); ++k) {
      const glm::dquat turn = validate::rotation(axis * (ease * arc[k] / arc.back()));
      const auto node = static_cast<Index>(chain[k]);
      // The turn against the joint below, about this joint's own place at rest.
      const glm::dmat4 turned =
          skin::rigid_matrix(glm::conjugate(below) * turn, place(k), place(k)) *
          body.nodes[node].world_from_node;
      const int parent = body.nodes[node].parent;
      local[node] =
          parent < 0
              ? turned
              : glm::inverse(body.nodes[static_cast<Index>(parent)].world_from_node) * turned;
      below = turn;
    }
    out.local.push_back(std::move(local));
    std::vector<double> values;
    if (plan.record_controls)
      for (const auto& [name, degrees] : controls)
        if (degrees != 0.0) values.push_back(ease * degrees);
    out.control_deg.push_back(std::move(values));
  }
  return out;
}

skin::Clip load_motion(const std::filesystem::path& file, const std::string& animation) {
  return skin::read_gltf_clip(validate::load_document(file), {animation, 24.0});
}

Motion retargeted(const Character& body, const skin::Anatomy& anatomy, const skin::Clip& clip) {
  const validate::ClipBody laid(body, anatomy, clip, {});
  Motion out;
  out.name = clip.name;
  const skin::ClipSweep& sweep = clip.sweeps.front();
  for (Index f = sweep.first; f < sweep.first + sweep.count; ++f) {
    out.time.push_back(clip.time[f] - clip.time[sweep.first]);
    const std::vector<glm::dmat4>& world = laid.world_from_node(f);
    std::vector<glm::dmat4> local;
    for (Index n = 0; n < world.size(); ++n) {
      const int parent = body.nodes[n].parent;
      local.push_back(parent < 0 ? world[n]
                                 : glm::inverse(world[static_cast<Index>(parent)]) * world[n]);
    }
    out.local.push_back(std::move(local));
    out.control_deg.emplace_back();
  }
  return out;
}

Motion resampled(const Motion& motion, double from, double to, double rate, double slow) {
  Motion out;
  out.name = motion.name;
  out.control = motion.control;
  out.time = sampled_times(from, to, rate, slow);
  for (const double time : out.time) {
    const auto [at, t] = place_in(motion.time, 0, motion.frame_count(), from + slow * time);
    std::vector<glm::dmat4> local;
    for (Index n = 0; n < motion.local[at].size(); ++n)
      local.push_back(between(motion.local[at][n], motion.local[at + 1][n], t));
    out.local.push_back(std::move(local));
    std::vector<double> values;
    for (Index k = 0; k < motion.control.size(); ++k)
      values.push_back(glm::mix(motion.control_deg[at][k], motion.control_deg[at + 1][k], t));
    out.control_deg.push_back(std::move(values));
  }
  return out;
}

skin::Clip resampled(const skin::Clip& clip, double from, double to, double rate, double slow) {
  skin::Clip out = clip;
  const skin::ClipSweep& sweep = clip.sweeps.front();
  out.time = sampled_times(from, to, rate, slow);
  out.world.clear();
  const Index joints = clip.joint_count();
  for (const double time : out.time) {
    const auto [at, t] =
        place_in(clip.time, sweep.first, sweep.count, clip.time[sweep.first] + from + slow * time);
    for (Index j = 0; j < joints; ++j)
      out.world.push_back(
          between(clip.world[at * joints + j], clip.world[(at + 1) * joints + j], t));
  }
  out.sweeps = {{sweep.name, 0, out.time.size()}};
  return out;
}

std::vector<std::uint8_t> clip_bytes(const Character& body, const Motion& motion) {
  nlohmann::json header = {{"schema", "backbend.clip/1"}, {"up", "Y"}, {"points", 0}};
  header["joints"] = nlohmann::json::array();
  for (const skin::Node& node : body.nodes)
    header["joints"].push_back({{"name", node.name.empty() ? "unnamed" : node.name},
                                {"parent", node.parent},
                                {"rest", numbers(node.world_from_node)}});
  header["poses"] = nlohmann::json::array();
  std::vector<std::vector<glm::dmat4>> world;
  for (Index f = 0; f < motion.frame_count(); ++f) {
    nlohmann::json pose = {{"sweep", motion.name}, {"time", motion.time[f]}};
    for (Index k = 0; k < motion.control.size(); ++k)
      pose["controls"][motion.control[k]] = motion.control_deg[f][k];
    header["poses"].push_back(std::move(pose));
    world.push_back(world_of(body, motion.local[f]));
  }
  return clip_file(header, world);
}

std::vector<std::uint8_t> clip_bytes(const skin::Clip& clip) {
  nlohmann::json header = {{"schema", "backbend.clip/1"}, {"up", "Y"}, {"points", 0}};
  header["joints"] = nlohmann::json::array();
  for (Index j = 0; j < clip.joint_count(); ++j) {
    nlohmann::json joint = {{"name", clip.joint[j]}, {"parent", clip.parent[j]}};
    if (!clip.rest.empty()) joint["rest"] = numbers(clip.rest[j]);
    header["joints"].push_back(std::move(joint));
  }
  header["poses"] = nlohmann::json::array();
  std::vector<std::vector<glm::dmat4>> world;
  for (Index f = 0; f < clip.frame_count(); ++f) {
    header["poses"].push_back({{"sweep", clip.sweeps.front().name}, {"time", clip.time[f]}});
    const auto first = clip.world.begin() + static_cast<std::ptrdiff_t>(f * clip.joint_count());
    world.emplace_back(first, first + static_cast<std::ptrdiff_t>(clip.joint_count()));
  }
  return clip_file(header, world);
}

std::vector<std::uint8_t> animated_glb(const Character& body, const Motion& motion) {
  skin::GlbAnimation animation;
  animation.name = motion.name;
  for (Index f = 0; f < motion.frame_count(); ++f) {
    animation.time.push_back(static_cast<float>(motion.time[f]));
    animation.world_from_node.push_back(world_of(body, motion.local[f]));
  }
  return encoded(body, &animation);
}

}  // namespace backbend::battery
