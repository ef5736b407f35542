#pragma once
// A round body on a straight spine, for which every mesh metric has a known answer.
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "skin/character/matrix_facts.h"
#include "solver/rig/spine_pose.h"
#include "validate/metrics/surface/bend_intent.h"
#include "validate/metrics/surface/mesh.h"
#include "validate/metrics/surface/slice_metrics.h"
#include "validate/metrics/surface/spine_slices.h"

namespace backbend::validate::testing {

/// A closed tube of length 1 along +Y around a chain of equal bones, with linear-blend weights that
/// change linearly from the middle of one bone to the middle of the next.
class Tube {
 public:
  int rings = 192, sides = 48, bones;
  double radius;
  std::vector<glm::vec3> position, normal;
  std::vector<glm::uvec3> triangle;
  std::vector<std::uint32_t> place;
  std::vector<std::uint8_t> torso;
  std::vector<std::vector<double>> weight;  // [vertex][bone]
  std::vector<glm::dvec3> spine;
  solver::SpinePose rest;

  explicit Tube(int bone_count, double tube_radius = 0.1) : bones(bone_count), radius(tube_radius) {
    for (int i = 0; i <= bones; ++i) spine.push_back({0.0, static_cast<double>(i) / bones, 0.0});
    for (int r = 0; r <= rings; ++r)
      for (int k = 0; k < sides; ++k) {
        const double angle = 2.0 * kPi * k / sides, y = static_cast<double>(r) / rings;
        add({radius * std::cos(angle), y, -radius * std::sin(angle)},
            {std::cos(angle), 0, -std::sin(angle)});
      }
    add({0, 0, 0}, {0, -1, 0});
    add({0, 1, 0}, {0, 1, 0});
    const auto at = [&](int r, int k) { return static_cast<std::uint32_t>(r * sides + k % sides); };
    for (int r = 0; r < rings; ++r)
      for (int k = 0; k < sides; ++k) {
        triangle.push_back({at(r, k), at(r, k + 1), at(r + 1, k)});
        triangle.push_back({at(r, k + 1), at(r + 1, k + 1), at(r + 1, k)});
      }
    const std::uint32_t bottom = at(rings, sides - 1) + 1, top = bottom + 1;
    for (int k = 0; k < sides; ++k) {
      triangle.push_back({bottom, at(0, k + 1), at(0, k)});
      triangle.push_back({top, at(rings, k), at(rings, k + 1)});
    }
    rest = pose_of([](double) { return glm::dvec3(0.0); }, 0.0);
  }

  RestMesh mesh() const {
    return {position, normal, triangle, place, static_cast<std::uint32_t>(position.size()),
            torso,    {},     spine};
  }

  /// A chain whose tangent turns by `bend(s)` (a rotation vector, s in 0..1), joints on the curve
  /// it draws, twisted linearly by `twist` from hips to chest.
  solver::SpinePose pose_of(const std::function<glm::dvec3(double)>& bend, double twist) const {
    solver::SpinePose pose;
    for (int i = 0; i <= bones; ++i) {
      pose.position.push_back(curve_point(bend, static_cast<double>(i) / bones));
      const double middle = std::min((i + 0.5) / bones, 1.0 - 0.5 / bones);
      pose.turn.push_back(rotation(bend(middle)) * rotation(glm::dvec3(0, twist * middle, 0)));
    }
    pose.hip = {rotation(bend(0.0)), spine.front(), pose.position.front()};
    pose.chest = {rotation(bend(1.0)) * rotation(glm::dvec3(0, twist, 0)), spine.back(),
                  pose.position.back()};
    pose.arms = pose.chest;
    return pose;
  }
  static std::vector<glm::dvec3> curve(const std::function<glm::dvec3(double)>& bend,
                                       int points = 257) {
    std::vector<glm::dvec3> out;
    for (int i = 0; i < points; ++i)
      out.push_back(curve_point(bend, static_cast<double>(i) / (points - 1)));
    return out;
  }

  /// Skinned positions; each bone carries its own rest frame to its place in the pose.
  std::vector<glm::vec3> skin(const solver::SpinePose& pose) const {
    std::vector<glm::vec3> out;
    for (std::size_t v = 0; v < position.size(); ++v) {
      glm::dvec3 sum(0.0);
      for (int b = 0; b < bones; ++b)
        if (weight[v][b] != 0.0)
          sum += weight[v][b] *
                 (pose.position[b] + pose.turn[b] * (glm::dvec3(position[v]) - rest.position[b]));
      out.push_back(glm::vec3(sum));
    }
    return out;
  }
  std::vector<glm::vec3> skin_normals(const solver::SpinePose& pose) const {
    std::vector<glm::vec3> out;
    for (std::size_t v = 0; v < normal.size(); ++v) {
      glm::dvec3 sum(0.0);
      for (int b = 0; b < bones; ++b) sum += weight[v][b] * (pose.turn[b] * glm::dvec3(normal[v]));
      out.push_back(glm::vec3(glm::normalize(sum)));
    }
    return out;
  }

 private:
  void add(const glm::dvec3& p, const glm::dvec3& n) {
    place.push_back(static_cast<std::uint32_t>(position.size()));
    position.push_back(glm::vec3(p));
    normal.push_back(glm::vec3(n));
    torso.push_back(1);
    std::vector<double> w(bones, 0.0);
    const double along = std::clamp(p.y * bones - 0.5, 0.0, bones - 1.0);
    const int below = std::min(static_cast<int>(along), std::max(0, bones - 2));
    w[below] = 1.0 - (along - below);
    if (bones > 1) w[below + 1] = along - below;
    weight.push_back(w);
  }
  static glm::dvec3 curve_point(const std::function<glm::dvec3(double)>& bend, double s) {
    // Integral of the turned tangent by the midpoint rule: exact to 1e-7 for the bends tested.
    constexpr int kSteps = 512;
    glm::dvec3 p(0.0);
    for (int i = 0; i < kSteps; ++i)
      p += rotation(bend(s * (i + 0.5) / kSteps)) * glm::dvec3(0, s / kSteps, 0);
    return p;
  }
};

/// What binds a tube to its bones, as a character says it.
struct TubeBinding {
  std::vector<skin::Influences> influences;
  const Tube& tube;

  explicit TubeBinding(const Tube& t) : tube(t) {
    for (const std::vector<double>& weight : tube.weight) {
      skin::Influences& own = influences.emplace_back();
      std::size_t i = 0;
      for (std::size_t b = 0; b < weight.size(); ++b) {
        if (weight[b] == 0.0) continue;
        own.joint[i] = static_cast<std::uint16_t>(b);
        own.weight[i++] = static_cast<float>(weight[b]);
      }
    }
  }
  skin::JointMatrices joints(const solver::SpinePose& pose) const {
    std::vector<skin::SkinJoint> joint;
    std::vector<glm::dmat4> world;
    for (int b = 0; b < tube.bones; ++b) {
      const auto i = static_cast<std::size_t>(b);
      joint.push_back({b, glm::dmat4(1.0)});
      world.push_back(skin::rigid_matrix(pose.turn[i], tube.rest.position[i], pose.position[i]));
    }
    return skin::joint_matrices(joint, world);
  }
};

/// A tube with its slices, and everything measured on one pose.
struct SlicedTube {
  Tube tube;
  SpineLine line;
  std::vector<float> coordinate;
  SpineSlices slices;
  SlicePose rest_slices;
  MeshRest mesh_rest;

  explicit SlicedTube(Tube t, int count = 64)
      : tube(std::move(t)),
        line(tube.spine),
        coordinate(spine_coordinate(tube.mesh(), line)),
        slices(cut_slices(tube.mesh(), line, coordinate, {1, 0, 0}, count)),
        rest_slices(pose_slices(slices, tube.position)),
        mesh_rest(prepare_mesh(tube.mesh(), line, coordinate, slices)) {}

  BendIntent intent(const solver::SpinePose& pose, const std::function<glm::dvec3(double)>& bend,
                    double twist = 0.0) const {
    const auto curve = Tube::curve(bend),
               rest_curve = Tube::curve([](double) { return glm::dvec3(0.0); });
    return bend_intent(slices, rest_slices, {pose, curve, rest_curve, twist, 1.0 / tube.bones});
  }
  int window() const { return slice_window(slices, tube.bones); }
  SliceMeasures measure(const std::vector<glm::vec3>& position, const BendIntent& in) const {
    return measure_slices(slices, rest_slices, pose_slices(slices, position), in, window());
  }
};

/// A bend of `angle` radians backwards about +X, evenly spread.
inline std::function<glm::dvec3(double)> even_bend(double angle) {
  return [angle](double s) { return glm::dvec3(angle * s, 0, 0); };
}

}  // namespace backbend::validate::testing
