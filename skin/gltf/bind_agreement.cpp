#include "skin/gltf/bind_agreement.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "skin/character/matrix_facts.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;

constexpr double kSandwich = 0.05;     // the joints around one agree this much better than it does
constexpr Index kCandidates = 64;      // joints that are tried as the one that most agree with
constexpr double kOneInTheSkin = 0.9;  // of the joints agree: the skin was bound as it stands

/// The angle of the turn that leads from `a` to `b`, whatever their scale.
double angle_between(const glm::dmat4& a, const glm::dmat4& b) {
  glm::dmat3 p(a), q(b);
  for (int c = 0; c < 3; ++c) {
    p[c] = glm::normalize(p[c]);
    q[c] = glm::normalize(q[c]);
  }
  const glm::dmat3 turn = glm::transpose(p) * q;
  const double cosine = 0.5 * (turn[0][0] + turn[1][1] + turn[2][2] - 1.0);
  const glm::dvec3 axis(turn[1][2] - turn[2][1], turn[2][0] - turn[0][2], turn[0][1] - turn[1][0]);
  return std::atan2(0.5 * glm::length(axis), cosine) * 180.0 / 3.14159265358979323846;
}

}  // namespace

double BodyBox::size() const {
  const glm::dvec3 sides = high - low;
  return std::max({sides.x, sides.y, sides.z});
}

glm::dmat4 rest_motion(const Character& character, Index joint) {
  const SkinJoint& one = character.joints[joint];
  return character.nodes[static_cast<Index>(one.node)].world_from_node * one.joint_from_mesh;
}

double apart(const glm::dmat4& a, const glm::dmat4& b, const BodyBox& box) {
  double most = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec4 p(corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                       corner & 4 ? box.high.z : box.low.z, 1.0);
    most = std::max(most, glm::distance(glm::dvec3(a * p), glm::dvec3(b * p)));
  }
  return most;
}

std::vector<BindOff> find_bind_off(const std::vector<Node>& nodes,
                                   const std::vector<BoundJoint>& joints, const BodyBox& box) {
  std::vector<BindOff> out;
  if (joints.size() < 3) return out;  // two that differ: either may be right
  std::vector<int> joint_of(nodes.size(), -1);
  for (Index j = 0; j < joints.size(); ++j)
    joint_of[static_cast<Index>(joints[j].node)] = static_cast<int>(j);
  std::vector<int> above(joints.size(), -1);  // the nearest joint of this skin above each
  std::vector<std::vector<int>> below(joints.size());
  for (Index j = 0; j < joints.size(); ++j) {
    int node = nodes[static_cast<Index>(joints[j].node)].parent;
    while (node >= 0 && joint_of[static_cast<Index>(node)] < 0)
      node = nodes[static_cast<Index>(node)].parent;
    if (node < 0) continue;
    above[j] = joint_of[static_cast<Index>(node)];
    below[static_cast<Index>(above[j])].push_back(static_cast<int>(j));
  }

  // The motion that most joints share.
  const double agree = kMotionsAgree * box.size() * longest_axis(joints.front().world_from_mesh);
  Index most = 0, middle = 0;
  const Index step = std::max<Index>(1, joints.size() / kCandidates);
  for (Index c = 0; c < joints.size(); c += step) {
    Index count = 0;
    for (const BoundJoint& joint : joints)
      count += apart(joint.world_from_mesh, joints[c].world_from_mesh, box) <= agree;
    if (count > most) {
      most = count;
      middle = c;
    }
  }
  const glm::dmat4& common = joints[middle].world_from_mesh;
  const auto common_to = [&](Index j) {
    return apart(joints[j].world_from_mesh, common, box) <= agree;
  };

  // Whether one motion carries a joint to where another one does: both turn about that place.
  const auto same_place = [&](int node, const glm::dmat4& a, const glm::dmat4& b) {
    const glm::dvec3 place = origin(nodes[static_cast<Index>(node)].world_from_node);
    const glm::dvec4 in_mesh = glm::inverse(a) * glm::dvec4(place, 1.0);
    return glm::distance(glm::dvec3(b * in_mesh), place) <= 0.1 * agree;
  };

  const Index strangers = joints.size() - most;
  for (Index j = 0; j < joints.size(); ++j) {
    const glm::dmat4& own = joints[j].world_from_mesh;
    const glm::dmat4* agreed = nullptr;
    // A joint whose children all turned about their own origins stands in another pose than they
    // do: it carries those origins to where they are.
    const bool posed = std::ranges::all_of(below[j], [&](int child) {
      const BoundJoint& lower = joints[static_cast<Index>(child)];
      return same_place(lower.node, lower.world_from_mesh, own);
    });
    if (above[j] >= 0) {
      // Hips that were turned about the way to the spine, which was turned back: the legs, which
      // stand elsewhere, show it.
      const auto elsewhere = std::ranges::count_if(below[j], [&](int child) {
        const int node = joints[static_cast<Index>(child)].node;
        return glm::distance(origin(nodes[static_cast<Index>(node)].world_from_node),
                             origin(nodes[static_cast<Index>(joints[j].node)].world_from_node)) >
               agree;
      });
      if (posed && elsewhere > 1) continue;
      const glm::dmat4& parent = joints[static_cast<Index>(above[j])].world_from_mesh;
      const double off = apart(own, parent, box);
      for (const int child : below[j])
        if (off > agree && apart(joints[static_cast<Index>(child)].world_from_mesh, parent, box) <=
                               std::max(0.1 * agree, kSandwich * off))
          agreed = &parent;
      // A branch whose root is off shows on the branches beside it alike; the chain decides.
    } else if (!common_to(j)) {
      const bool carried = std::all_of(below[j].begin(), below[j].end(), [&](int child) {
        return common_to(static_cast<Index>(child));
      });
      if (carried && !posed) agreed = &common;
    }
    // A last joint that is turned about its own origin stands in a pose: nothing tells otherwise.
    if (!agreed && !common_to(j) && below[j].empty() && strangers == 1 &&
        !same_place(joints[j].node, common, own) &&
        static_cast<double>(most) >= kOneInTheSkin * static_cast<double>(joints.size() - 1))
      agreed = &common;
    if (agreed) out.push_back({joints[j].node, angle_between(*agreed, own), *agreed});
  }
  // Below a joint that is off, its children seem to stand apart from it as well, but agree with the
  // one above it: they are right.
  const auto is_off = [&](int joint) {
    return std::any_of(out.begin(), out.end(), [&](const BindOff& one) {
      return one.node == joints[static_cast<Index>(joint)].node;
    });
  };
  std::vector<BindOff> kept;
  for (const BindOff& one : out) {
    const int j = joint_of[static_cast<Index>(one.node)];
    const int parent = above[static_cast<Index>(j)];
    const bool beside_the_fault = parent >= 0 && is_off(parent) &&
                                  common_to(static_cast<Index>(j)) &&
                                  !common_to(static_cast<Index>(parent));
    if (!beside_the_fault) kept.push_back(one);
  }
  return kept;
}

}  // namespace backbend::skin
