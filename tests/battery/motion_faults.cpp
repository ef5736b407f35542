#include "tests/battery/motion_faults.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "skin/character/matrix_facts.h"
#include "validate/metrics/math/rotation.h"

namespace backbend::battery {
namespace {

using Index = std::size_t;

class Planter {
 public:
  Planter(Motion& motion, const skin::Character& body, const skin::Anatomy& anatomy,
          const std::vector<int>& chain)
      : motion(motion), body(body), anatomy(anatomy), chain(chain) {}

  glm::dvec3 rest_place(int node) const {
    return skin::origin(body.nodes[static_cast<Index>(node)].world_from_node);
  }
  /// Turns a node and all that hangs from it about the node, by a rotation vector in the frame that
  /// its parent has carried along from the world at rest.
  void turn(Index frame, int node, const glm::dvec3& vector) const {
    change(frame, node, [&](const glm::dvec3& place) {
      return skin::rigid_matrix(validate::rotation(vector), place, place);
    });
  }
  /// Moves it by a vector in that frame.
  void shift(Index frame, int node, const glm::dvec3& way) const {
    change(frame, node, [&](const glm::dvec3&) {
      glm::dmat4 out(1.0);
      out[3] = glm::dvec4(way, 1.0);
      return out;
    });
  }
  /// The bone's direction at a joint of the chain.
  glm::dvec3 bone(Index k) const {
    const Index low = std::min(k, chain.size() - 2);
    return glm::normalize(rest_place(chain[low + 1]) - rest_place(chain[low]));
  }
  const std::string& name(int node) const { return body.nodes[static_cast<Index>(node)].name; }

  Motion& motion;
  const skin::Character& body;
  const skin::Anatomy& anatomy;
  const std::vector<int>& chain;

 private:
  /// A motion given at rest, in world space, as one of the node against its parent.
  template <typename Make>
  void change(Index frame, int node, const Make& make) const {
    const auto n = static_cast<Index>(node);
    const int parent = body.nodes[n].parent;
    const glm::dmat4 parent_rest =
        parent < 0 ? glm::dmat4(1.0) : body.nodes[static_cast<Index>(parent)].world_from_node;
    glm::dmat4& local = motion.local[frame][n];
    const glm::dmat4 carried = parent_rest * local;  // the node, had its parent stayed
    local = glm::inverse(parent_rest) * make(skin::origin(carried)) * carried;
  }
};

double eased(double t) { return t * t * (3.0 - 2.0 * t); }

}  // namespace

const std::vector<MotionFaultKind>& motion_fault_kinds() {
  static const std::vector<MotionFaultKind> kinds = {
      {"kink", "deg", {5, 10, 15, 25, 40}, 10, true},
      {"roll", "deg", {5, 10, 20, 40}, 10, true},
      {"step", "deg", {5, 8, 10, 20, 30, 60}, 10, true},
      {"pop", "deg", {8, 10, 15, 25, 40, 90, 180}, 10, true},
      {"clavicle pop", "deg", {8, 10, 15, 25, 40}, 10, true},
      {"flip that holds", "deg", {40, 90, 135, 179.8}, 90, false},
      {"flip of one frame", "deg", {40, 90, 135, 179.8}, 90, false},
      {"slow shift of an arm", "cm", {1, 2, 3, 5}, 3, true},
      {"slow shift of a vertebra", "cm", {1, 2, 3, 5}, 3, true},
      {"clavicle drift", "deg", {1, 1.8, 5, 10, 30}, 1, true},
  };
  return kinds;
}

MotionFault plant(Motion& motion, const skin::Character& body, const skin::Anatomy& anatomy,
                  const std::vector<int>& chain, std::string_view kind, double size,
                  validate::Draw& draw) {
  MotionFault fault;
  fault.kind = kind;
  fault.size = size;
  for (const MotionFaultKind& each : motion_fault_kinds())
    if (each.name == kind) {
      fault.unit = each.unit;
      fault.plain = size >= each.plain_from;
    }
  const Planter on(motion, body, anatomy, chain);
  const Index frames = motion.frame_count();
  if (frames < 20 || chain.size() < 2) return fault;
  // A joint above the hips, and a frame with motion on both sides of it.
  const Index k = 1 + draw.index(chain.size() - 1);
  const int node = chain[k];
  const Index at = 8 + draw.index(frames - 16);
  const double radians = validate::radians_from(size);
  const auto blame = [&](int which) { fault.joints.insert(on.name(which)); };
  const auto blame_around = [&](Index i) {
    for (Index j = i == 0 ? 0 : i - 1; j <= std::min(i + 1, chain.size() - 1); ++j) blame(chain[j]);
  };
  const auto widest = [&](Index f) {  // 0 at both ends, 1 in the middle
    return 0.5 - 0.5 * std::cos(2.0 * validate::kPi * static_cast<double>(f) /
                                static_cast<double>(frames - 1));
  };
  const bool has_arms = !anatomy.left_arm.empty() && !anatomy.right_arm.empty();

  if (kind == "kink" || kind == "roll") {
    if (chain.size() < 4) return fault;
    const Index inner = 1 + draw.index(chain.size() - 2);  // neither end
    const glm::dvec3 axis = kind == "kink" ? anatomy.left : on.bone(inner);
    for (Index f = 0; f < frames; ++f) {
      on.turn(f, chain[inner], axis * (radians * widest(f)));
      if (kind == "roll") {
        on.turn(f, chain[inner + 1], -axis * (radians * widest(f)));
      } else {
        const double share = radians * widest(f) / static_cast<double>(chain.size() - 2);
        for (Index j = 1; j < chain.size(); ++j)
          if (j != inner) on.turn(f, chain[j], -axis * share);
      }
    }
    blame_around(inner);
    fault.frame = static_cast<int>(frames / 2);
    fault.lasting = true;
  } else if (kind == "step" || kind == "flip that holds") {
    const glm::dvec3 axis = kind == "step" ? draw.direction() : on.bone(k);
    for (Index f = at; f < frames; ++f) on.turn(f, node, axis * radians);
    blame(node);
    fault.frame = static_cast<int>(at);
    fault.jump = true;
  } else if (kind == "pop" || kind == "flip of one frame") {
    const glm::dvec3 axis = kind == "pop" ? draw.direction() : on.bone(k);
    on.turn(at, node, axis * radians);
    blame(node);
    fault.frame = static_cast<int>(at);
    fault.jump = true;
  } else if (kind == "clavicle pop") {
    if (!has_arms) return fault;
    const int arm = (draw.coin() ? anatomy.left_arm : anatomy.right_arm).front();
    on.turn(at, arm, draw.direction() * radians);
    blame(arm);
    fault.frame = static_cast<int>(at);
    fault.jump = true;
  } else if (kind == "slow shift of an arm" || kind == "slow shift of a vertebra") {
    if (kind == "slow shift of an arm" && !has_arms) return fault;
    // A human's height stands for the unit, which few files name.
    const double unit = anatomy.height / 1.75;
    const int which = kind == "slow shift of an arm"
                          ? (draw.coin() ? anatomy.left_arm : anatomy.right_arm).front()
                          : node;
    const glm::dvec3 way = draw.direction() * (0.01 * size * unit);
    const Index span = std::min<Index>(20, frames - at - 1);
    for (Index f = at; f < frames; ++f)
      on.shift(f, which,
               way * eased(std::min(1.0, static_cast<double>(f - at) / static_cast<double>(span))));
    blame(which);
    if (which == node) blame_around(k);
    if (which == node)
      for (const auto* arm : {&anatomy.left_arm, &anatomy.right_arm})
        if (!arm->empty()) blame(arm->front());
    fault.frame = static_cast<int>(at);
    fault.lasting = true;
  } else if (kind == "clavicle drift") {
    if (!has_arms || motion.control.empty()) return fault;
    const glm::dvec3 axis = draw.direction();
    for (Index f = 0; f < frames; ++f)
      for (const auto* arm : {&anatomy.left_arm, &anatomy.right_arm})
        on.turn(f, arm->front(), axis * (-radians * widest(f)));
    blame(anatomy.left_arm.front());
    blame(anatomy.right_arm.front());
    blame(chain.back());
    fault.frame = static_cast<int>(frames / 2);
    fault.lasting = true;
  }
  return fault;
}

}  // namespace backbend::battery
