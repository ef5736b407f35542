#include "validate/calibrate/calibration_body.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

namespace backbend::validate {
namespace {

constexpr int kRings = 160, kSides = 40;  // of the torso
constexpr double kHips = 0.9, kNeck = 1.5, kRadius = 0.1;
constexpr double kShoulders = 1.42, kArmRadius = 0.04, kArmLength = 0.6;

/// Builds the tube's character joint by joint and surface by surface.
class TubeBuilder {
 public:
  skin::Character character;
  skin::Anatomy anatomy;

  explicit TubeBuilder(int bones) {
    character.name = character.file_name = "tube of " + std::to_string(bones) + " bones";
    for (int i = 0; i <= bones; ++i)
      anatomy.spine.push_back(
          add_joint("spine" + std::to_string(i), i - 1, {0, height_of(i, bones), 0}));
    anatomy.chest_index = static_cast<std::size_t>(bones);
    anatomy.head = add_joint("head", bones, {0, kNeck + 0.1, 0});
    anatomy.spine.push_back(anatomy.head);
    anatomy.left_arm = add_arm("l", 1.0, bones);
    anatomy.right_arm = add_arm("r", -1.0, bones);
    anatomy.height = 1.8;
    anatomy.spine_length = kNeck - kHips;
    add_torso(bones);
    add_arm_surface(1.0, anatomy.left_arm[1]);
    add_arm_surface(-1.0, anatomy.right_arm[1]);
    character.place_count = static_cast<std::uint32_t>(character.bind_position.size());
  }

 private:
  static double height_of(int joint, int bones) { return kHips + (kNeck - kHips) * joint / bones; }

  int add_joint(const std::string& name, int parent, const glm::dvec3& at) {
    skin::Node node;
    node.name = name;
    node.parent = parent;
    node.world_from_node = glm::translate(glm::dmat4(1.0), at);
    node.parent_from_node =
        parent < 0
            ? node.world_from_node
            : glm::inverse(character.nodes[static_cast<std::size_t>(parent)].world_from_node) *
                  node.world_from_node;
    const int index = static_cast<int>(character.nodes.size());
    character.joints.push_back({index, glm::inverse(node.world_from_node)});
    character.nodes.push_back(std::move(node));
    return index;
  }

  std::vector<int> add_arm(const std::string& side, double sign, int chest) {
    const int clavicle = add_joint("clavicle_" + side, chest, {0.02 * sign, kShoulders, 0});
    const int upper =
        add_joint("upperarm_" + side, clavicle, {(kRadius + 0.02) * sign, kShoulders, 0});
    const int hand =
        add_joint("hand_" + side, upper, {(kRadius + kArmLength) * sign, kShoulders, 0});
    return {clavicle, upper, hand};
  }

  void add_vertex(const glm::dvec3& p, const glm::dvec3& n, int below, int above, double share) {
    character.place.push_back(static_cast<std::uint32_t>(character.place.size()));
    character.bind_position.push_back(glm::vec3(p));
    character.bind_normal.push_back(glm::vec3(n));
    skin::Influences influences;
    const bool upper_first = share > 0.5;
    influences.joint = {static_cast<std::uint16_t>(upper_first ? above : below),
                        static_cast<std::uint16_t>(upper_first ? below : above)};
    influences.weight = {static_cast<float>(std::max(share, 1.0 - share)),
                         static_cast<float>(std::min(share, 1.0 - share))};
    character.influences.push_back(influences);
  }

  /// A closed tube along an axis; `weigh` gives two joints and the share of the second.
  template <typename Weigh>
  void add_tube(const glm::dvec3& from, const glm::dvec3& axis, double length, double radius,
                int rings, int sides, Weigh weigh) {
    const auto first = static_cast<std::uint32_t>(character.bind_position.size());
    const glm::dvec3 a = std::abs(axis.y) > 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 b = glm::cross(axis, a);
    const auto add = [&](const glm::dvec3& p, const glm::dvec3& n) {
      const auto [below, above, share] = weigh(p);
      add_vertex(p, n, below, above, share);
    };
    for (int r = 0; r <= rings; ++r)
      for (int k = 0; k < sides; ++k) {
        const double angle = 2.0 * kPi * k / sides;
        const glm::dvec3 normal = a * std::cos(angle) + b * std::sin(angle);
        add(from + axis * (length * r / rings) + radius * normal, normal);
      }
    add(from, -axis);
    add(from + axis * length, axis);
    const auto at = [&](int r, int k) {
      return first + static_cast<std::uint32_t>(r * sides + k % sides);
    };
    const std::uint32_t bottom = at(rings + 1, 0), top = bottom + 1;
    for (int r = 0; r < rings; ++r)
      for (int k = 0; k < sides; ++k) {
        character.triangles.push_back({at(r, k), at(r, k + 1), at(r + 1, k)});
        character.triangles.push_back({at(r, k + 1), at(r + 1, k + 1), at(r + 1, k)});
      }
    for (int k = 0; k < sides; ++k) {
      character.triangles.push_back({bottom, at(0, k + 1), at(0, k)});
      character.triangles.push_back({top, at(rings, k), at(rings, k + 1)});
    }
  }

  void add_torso(int bones) {
    const double bone = (kNeck - kHips) / bones;
    add_tube({0, kHips - 0.1, 0}, {0, 1, 0}, kNeck - kHips + 0.2, kRadius, kRings, kSides,
             [&](const glm::dvec3& p) {
               const double along = std::clamp((p.y - kHips) / bone - 0.5, 0.0, bones - 0.0);
               const int below = std::min(static_cast<int>(along), bones - 1);
               return std::tuple(below, below + 1, along - below);
             });
  }
  void add_arm_surface(double sign, int joint) {
    add_tube({kRadius * sign, kShoulders, 0}, {sign, 0, 0}, kArmLength, kArmRadius, 20, 12,
             [&](const glm::dvec3&) { return std::tuple(joint, joint, 0.0); });
  }
};

}  // namespace

CalibrationBody::CalibrationBody(skin::Character character, skin::Anatomy anatomy)
    : stage_(std::move(character), std::move(anatomy)),
      metrics_(stage_.character(), stage_.anatomy(), stage_.driver()) {}

std::unique_ptr<CalibrationBody> tube_body(int bones) {
  TubeBuilder builder(bones);
  return std::make_unique<CalibrationBody>(std::move(builder.character),
                                           std::move(builder.anatomy));
}

solver::BodyPose random_pose(Draw& draw) {
  solver::BodyPose pose;
  if (draw.coin())
    pose.extension = radians_from(draw.uniform(0, 120));
  else
    pose.flexion = radians_from(draw.uniform(0, 90));
  pose.side = radians_from(draw.uniform(-45, 45));
  pose.twist = radians_from(draw.uniform(-60, 60));
  return pose;
}

}  // namespace backbend::validate
