#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "skin/character/closest_point.h"
#include "skin/character/matrix_facts.h"
#include "validate/live/external_rig.h"
#include "validate/metrics/math/rotation.h"
#include "validate/metrics/surface/surface_points.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

constexpr std::string_view kMeshOfRig = "mesh_of_rig";
// A joint that is farther from a point by some length must fit its motion better by this share of
// it: arms go with the chest, and bones that bend inside fit none of their own points closely.
constexpr double kFar = 0.2;
// A second joint is taken where it explains so much of what the first leaves.
constexpr double kHelps = 0.5;

/// Poses that tell joints apart: each bend alone, both ways, and all at once.
std::vector<solver::BodyPose> telling_poses() {
  std::vector<solver::BodyPose> poses;
  for (const double angle : {20.0, 45.0}) {
    const double a = radians_from(angle);
    poses.push_back({.extension = a});
    poses.push_back({.flexion = a});
    for (const double sign : {1.0, -1.0}) {
      poses.push_back({.side = sign * a});
      poses.push_back({.twist = sign * a});
    }
    poses.push_back({.extension = 0.7 * a, .side = 0.5 * a, .twist = -0.6 * a});
  }
  return poses;
}

/// The joints that move the rig's points, read off their motion.
class Binding {
 public:
  /// `motion`: of each pose, of each joint, from rest; `place`: of each pose, of each point.
  Binding(const skin::Character& character, std::vector<int> nodes,
          std::vector<std::vector<glm::dmat4>> motion)
      : character_(character), nodes_(std::move(nodes)), motion_(std::move(motion)) {
    std::vector<int> of_node(character.nodes.size(), -1);
    for (Index j = 0; j < nodes_.size(); ++j)
      of_node[static_cast<Index>(nodes_[j])] = static_cast<int>(j);
    parent_.assign(nodes_.size(), -1);
    children_.resize(nodes_.size());
    for (Index j = 0; j < nodes_.size(); ++j) {
      int up = character.nodes[static_cast<Index>(nodes_[j])].parent;
      while (up >= 0 && of_node[static_cast<Index>(up)] < 0)
        up = character.nodes[static_cast<Index>(up)].parent;
      if (up < 0) continue;
      parent_[j] = of_node[static_cast<Index>(up)];
      children_[static_cast<Index>(parent_[j])].push_back(j);
    }
  }

  skin::Influences of(const glm::dvec3& rest, const std::vector<glm::dvec3>& places) const {
    const auto poses = static_cast<double>(places.size());
    std::vector<double> off(nodes_.size());
    Index best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (Index j = 0; j < nodes_.size(); ++j) {
      double sum = 0.0;
      for (Index i = 0; i < places.size(); ++i) {
        const glm::dvec3 d = moved(i, j, rest) - places[i];
        sum += glm::dot(d, d);
      }
      off[j] = std::sqrt(sum / poses);
      if (const double here = off[j] + kFar * distance(j, rest); here < least) {
        least = here;
        best = j;
      }
    }
    // Blended with the joint above or one below, whichever explains more.
    Index second = best;
    double share = 0.0, left = kHelps * off[best];
    std::vector<Index> around = children_[best];
    if (parent_[best] >= 0) around.push_back(static_cast<Index>(parent_[best]));
    for (const Index k : around) {
      double along = 0.0, squared = 0.0, sum = 0.0;
      for (Index i = 0; i < places.size(); ++i) {
        const glm::dvec3 a = moved(i, best, rest), way = moved(i, k, rest) - a;
        along += glm::dot(places[i] - a, way);
        squared += glm::dot(way, way);
      }
      if (!(squared > 0.0)) continue;
      const double t = std::clamp(along / squared, 0.0, 1.0);
      for (Index i = 0; i < places.size(); ++i) {
        const glm::dvec3 a = moved(i, best, rest);
        const glm::dvec3 d = a + t * (moved(i, k, rest) - a) - places[i];
        sum += glm::dot(d, d);
      }
      if (const double here = std::sqrt(sum / poses); here < left && t > 0.0) {
        left = here;
        share = t;
        second = k;
      }
    }
    skin::Influences out;
    const bool swap = share > 0.5;
    out.joint[0] = static_cast<std::uint16_t>(swap ? second : best);
    out.weight[0] = static_cast<float>(swap ? share : 1.0 - share);
    if (share > 0.0) {
      out.joint[1] = static_cast<std::uint16_t>(swap ? best : second);
      out.weight[1] = 1.0f - out.weight[0];
    }
    if (!(out.weight[1] > 0.0f)) out.joint[1] = 0;
    return out;
  }

 private:
  glm::dvec3 moved(Index pose, Index joint, const glm::dvec3& rest) const {
    return glm::dvec3(motion_[pose][joint] * glm::dvec4(rest, 1.0));
  }
  glm::dvec3 place(Index joint) const {
    return skin::origin(character_.nodes[static_cast<Index>(nodes_[joint])].world_from_node);
  }
  double distance(Index joint, const glm::dvec3& p) const {
    double least = glm::distance(p, place(joint));
    for (const Index child : children_[joint])
      least = std::min(least, skin::distance_to_segment(p, place(joint), place(child)));
    return least;
  }

  const skin::Character& character_;
  std::vector<int> nodes_;
  std::vector<std::vector<glm::dmat4>> motion_;
  std::vector<int> parent_;
  std::vector<std::vector<Index>> children_;
};

/// Points at one place share a number.
void number_places(const std::vector<glm::vec3>& points, skin::Character& out) {
  std::map<std::array<float, 3>, std::uint32_t> seen;
  out.place.clear();
  for (const glm::vec3& p : points)
    out.place.push_back(seen.emplace(std::array{p.x + 0.0f, p.y + 0.0f, p.z + 0.0f},
                                     static_cast<std::uint32_t>(seen.size()))
                            .first->second);
  out.place_count = static_cast<std::uint32_t>(seen.size());
}

}  // namespace

bool has_mesh_of_rig(const skin::Character& character) {
  return std::ranges::any_of(
      character.warnings, [](const skin::Warning& warning) { return warning.code == kMeshOfRig; });
}

std::optional<skin::Character> ExternalRig::own_mesh() const {
  if (gives_points() || hello().points.empty() || hello().triangles.empty() ||
      has_mesh_of_rig(character_))
    return std::nullopt;
  std::vector<std::vector<double>> controls;
  for (const solver::BodyPose& pose : telling_poses()) controls.push_back(controls_for(pose));
  const Answers answers = fetch(controls, true);
  keep(controls, Answers(answers));
  std::vector<int> nodes;
  for (Index n = 0; n < character_.nodes.size(); ++n)
    if (asked_[n] >= 0) nodes.push_back(static_cast<int>(n));
  std::vector<std::vector<glm::dmat4>> motion;
  for (const solver::SpinePose& pose : answers.poses) {
    motion.emplace_back();
    for (const int n : nodes)
      motion.back().push_back(
          pose.body->world_from_node[static_cast<Index>(n)] *
          glm::inverse(character_.nodes[static_cast<Index>(n)].world_from_node));
  }
  skin::Character out = character_;
  out.joints.clear();
  for (const int n : nodes)
    out.joints.push_back(
        {n, glm::inverse(character_.nodes[static_cast<Index>(n)].world_from_node)});
  const Binding binding(character_, nodes, std::move(motion));
  out.bind_position.clear();
  for (const glm::vec3& point : hello().points)
    out.bind_position.emplace_back(world_from_rig_ * glm::dvec4(point, 1.0));
  out.influences.assign(out.bind_position.size(), {});
  oneapi::tbb::parallel_for(Index{0}, out.bind_position.size(), [&](Index v) {
    std::vector<glm::dvec3> places;
    for (const Points& points : answers.points) places.emplace_back((*points)[v]);
    out.influences[v] = binding.of(out.bind_position[v], places);
  });
  out.triangles = hello().triangles;
  out.uv.clear();
  out.images.clear();
  out.materials.resize(std::min<Index>(1, out.materials.size()));
  for (skin::Material& material : out.materials)
    material.base_color_image = material.metallic_roughness_image = material.normal_image = -1;
  skin::Part part;
  part.name = "the rig's mesh";
  part.triangle_count = static_cast<std::uint32_t>(out.triangles.size());
  part.vertex_count = static_cast<std::uint32_t>(out.bind_position.size());
  out.parts = {part};
  number_places(out.bind_position, out);
  out.bind_normal = surface_normals(out, out.bind_position);
  out.unweighted.clear();
  out.renormalised_vertices = 0;
  out.worst_weight_sum = 1.0;
  out.worst_weight_vertex = -1;
  out.warnings.push_back(
      {std::string(kMeshOfRig),
       "the mesh is the rig's own, " + std::to_string(out.bind_position.size()) +
           " points that are not the vertices of " + character_.file_name +
           "; which joint moves each is read off its motion, so weights are not judged"});
  return out;
}

}  // namespace backbend::validate
