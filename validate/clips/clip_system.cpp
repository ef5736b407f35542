#include "validate/clips/clip_system.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_inverse.hpp>

#include "skin/character/matrix_facts.h"
#include "solver/curves/curve.h"
#include "validate/metrics/chain/chain.h"
#include "validate/metrics/chain/chain_corner.h"
#include "validate/metrics/surface/rigid_fit.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;
using skin::origin;

}  // namespace

ClipSystem::ClipSystem(const skin::Character& character, const skin::Anatomy& anatomy,
                       const ClipBody& body) {
  build(character, anatomy);
  for (Index f = 0; f < body.frame_count(); ++f) add(character, body.world_from_node(f));
}

ClipSystem::ClipSystem(const skin::Character& character, const skin::Anatomy& anatomy,
                       const std::vector<glm::dmat4>& world_from_node) {
  build(character, anatomy);
  add(character, world_from_node);
}

void ClipSystem::build(const skin::Character& character, const skin::Anatomy& anatomy) {
  name_ = "clip";
  add_scalar("frame", kRest);
  std::vector<std::string> names;
  for (Index k = 0; k <= anatomy.chest_index; ++k) {
    const skin::Node& node = character.nodes[static_cast<Index>(anatomy.spine[k])];
    const glm::dvec3 place = origin(node.world_from_node);
    // Two joints in one place are one joint of the chain, as in SpineDriver: the upper turns it.
    if (k > 0 && glm::distance(place, rest_.position.back()) <= 1e-6 * anatomy.spine_length) {
      node_.back() = anatomy.spine[k];
      continue;
    }
    rest_.position.push_back(place);
    rest_.turn.emplace_back(1, 0, 0, 0);
    node_.push_back(anatomy.spine[k]);
    names.push_back(node.name);
  }
  rest_.chest.rest_origin = rest_.chest.posed_origin = rest_.position.back();
  rest_.hip.rest_origin = rest_.hip.posed_origin = rest_.position.front();
  rest_.arms = rest_.chest;
  name_chain(std::move(names));
  measure_arc_fraction();
}

void ClipSystem::add(const skin::Character& character, const std::vector<glm::dmat4>& world) {
  solver::SpinePose pose = rest_;
  for (Index k = 0; k < node_.size(); ++k) {
    const auto n = static_cast<Index>(node_[k]);
    pose.position[k] = origin(world[n]);
    pose.turn[k] = nearest_rotation(glm::dmat3(world[n]) *
                                    glm::inverse(glm::dmat3(character.nodes[n].world_from_node)));
  }
  // The last joint is the neck's; the chain ends with its last bone.
  pose.turn.back() = pose.turn[pose.turn.size() - 2];
  pose.hip.turn = pose.turn.front();
  pose.hip.posed_origin = pose.position.front();
  pose.chest.turn = pose.turn.back();
  pose.chest.posed_origin = pose.position.back();
  pose.arms = pose.chest;
  pose_.push_back(std::move(pose));
}

solver::SpinePose ClipSystem::solve(std::span<const double> control) const {
  if (control[0] < 0.0) return rest_;
  return pose_[static_cast<Index>(
      std::clamp(std::round(control[0]), 0.0, static_cast<double>(pose_.size() - 1)))];
}

std::vector<glm::dvec3> ClipSystem::intended_curve(std::span<const double> control,
                                                   std::size_t count) const {
  const solver::SpinePose pose = solve(control);
  const double size = chain_length(rest_.position);
  bool apart = true;
  for (Index k = 1; k < pose.position.size(); ++k)
    apart = apart && glm::distance(pose.position[k - 1], pose.position[k]) > 1e-9 * size;
  if (!apart) return std::vector<glm::dvec3>(count, glm::dvec3(std::nan("")));
  return solver::equal_arc_points(
      solver::Curve::interpolating(
          pose.position, solver::make_knots(pose.position, solver::KnotRule::centripetal)),
      count);
}

double ClipSystem::twist_deg(std::size_t frame) const {
  const solver::SpinePose& pose = pose_[frame];
  double sum = 0.0;
  for (Index k = 1; k + 1 < pose.turn.size(); ++k) {
    const glm::dvec3 axis =
        pose.turn[k - 1] * glm::normalize(rest_.position[k + 1] - rest_.position[k]);
    sum += degrees(twist_about(pose.turn[k] * glm::conjugate(pose.turn[k - 1]), axis));
  }
  return sum;
}

double ClipSystem::corner_deg(std::size_t frame, int& joint) const {
  return chain_corner(pose_[frame], rest_, joint);
}

std::vector<glm::dmat4> even_bend(const skin::Character& character, const skin::Anatomy& anatomy,
                                  const ClipSystem& system, const ClipBody& body,
                                  std::size_t frame) {
  const solver::SpinePose& pose = system.pose(frame);
  const std::vector<glm::dmat4>& posed = body.world_from_node(frame);
  // The whole turn, with the full twists that the joints add up to.
  glm::dvec3 whole(0.0);
  for (Index k = 1; k < pose.turn.size(); ++k)
    whole += turn_between(pose.turn[k - 1], pose.turn[k]);
  const glm::dvec3 principal = rotation_vector(pose.chest.turn * glm::conjugate(pose.hip.turn));
  const double angle = glm::length(principal);
  glm::dvec3 shared = principal;
  if (angle > 0.0) {
    const glm::dvec3 axis = principal / angle;
    shared += axis * (2.0 * kPi * std::round((glm::dot(whole, axis) - angle) / (2.0 * kPi)));
  }
  std::vector<double> share(character.nodes.size(), -1.0);
  double sum = 0.0;
  const auto place = [&](Index k) {
    return origin(character.nodes[static_cast<Index>(anatomy.spine[k])].world_from_node);
  };
  for (Index k = 1; k < anatomy.chest_index; ++k) {
    sum += 0.5 * glm::distance(place(k - 1), place(k + 1));
    share[static_cast<Index>(anatomy.spine[k])] = sum;
  }
  std::vector<glm::dmat4> out;
  for (Index n = 0; n < character.nodes.size(); ++n) {
    const int parent = character.nodes[n].parent;
    if (parent < 0) {
      out.push_back(posed[n]);
      continue;
    }
    const auto p = static_cast<Index>(parent);
    glm::dmat4 world = out[p] * (glm::affineInverse(posed[p]) * posed[n]);
    if (share[n] >= 0.0 && sum > 0.0) {
      const glm::dvec3 here = origin(world);
      world = glm::dmat4(glm::mat3_cast(rotation(shared * (share[n] / sum)) * pose.hip.turn)) *
              character.nodes[n].world_from_node;
      world[3] = glm::dvec4(here, 1.0);
    }
    out.push_back(world);
  }
  return out;
}

}  // namespace backbend::validate
