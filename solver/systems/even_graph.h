#pragma once
#include <array>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "solver/rig/spine_system.h"

namespace backbend::solver {

/// An `even` spine as another program can build it: products of Euler turns whose angles are
/// channels times constants, and one sum of turned steps. Rig space, lengths in the chain's unit.
///
/// With Z the rest axes of the controls, c their channels and R(c) = Rz Ry Rx,
///   S(w)  = Z1 R(w c_middle) Z1^-1 Z2 R(w c_top) Z2^-1     w: a weight for each of the six
///   channels L     = Z0 R(c_lower) Z0^-1 joint = origin + L (sum of S(w_i) step_i, i < samples),
///   turned from rest by L S(w)
/// docs/export.md says the same for the JSON that is written of it.
struct EvenGraph {
  /// Middle's and Top's rx, ry, rz.
  using Weights = std::array<double, 6>;

  struct Control {
    std::string name;  // lower, middle, top
    double at = 0.0;   // arc fraction that it stands at
    glm::dvec3 place{0.0};
    glm::dmat3 axes{1.0};     // rest frame in columns: X along its bone, Y forward, Z left
    double bone = 0.0;        // length of the bone that it stands for
    std::size_t samples = 0;  // the first so many steps lead from the origin to it
  };
  struct Sample {
    double at = 0.0;
    Weights weight{};
    glm::dvec3 step{0.0};  // what it adds to the spine, at rest
  };
  struct Joint {
    double at = 0.0;        // arc fraction that it stands at
    double frame_at = 0.0;  // and that its frame is read at
    Weights weight{};
    glm::dvec3 place{0.0};
    std::size_t samples = 0;
  };

  glm::dvec3 origin{0.0};
  double length = 0.0;  // of the spine
  std::array<Control, 3> control;
  std::vector<Sample> sample;  // hips first
  std::vector<Joint> joint;    // those of the system, hips first

  /// Turns and places of the joints for lower, middle, top x (rx, ry, rz), radians.
  struct Pose {
    std::vector<glm::dquat> turn;
    std::vector<glm::dvec3> place;
  };
  Pose pose(std::span<const double> control) const;
};

/// How far a graph is from the spine that it stands for.
struct GraphDistance {
  int poses = 0;
  double place = 0.0;     // the farthest joint, as a share of the spine's length
  double turn_deg = 0.0;  // the largest turn between a joint and its own
};

/// Throws RigError, naming the system, for one that is no product of Euler turns: all but `even`.
void check_has_graph(const SystemSpec& spec);

/// The graph of an `even` rig with `steps_per_length` Gauss-Legendre nodes over the spine, at least
/// one between two joints. Throws RigError as build_system() does, for another system, and for
/// options that no such product has: reach, limits, stretchiness.
EvenGraph even_graph(const SystemSpec& spec, const RestChain& chain, int steps_per_length);

/// Against the system itself: all nine channels drawn evenly from +-180 degrees, the same poses
/// each time, every one in eight of them with each channel at an end.
GraphDistance distance_from_solver(const EvenGraph& graph, const SpineSystem& system, int poses);

/// The graph with the fewest steps whose joints stay within `most` of the spine's length of their
/// places over `poses` such poses.
EvenGraph even_graph_within(const SystemSpec& spec, const RestChain& chain, double most, int poses,
                            GraphDistance& distance);

}  // namespace backbend::solver
