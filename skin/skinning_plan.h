#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "skin/linear_blend.h"
#include "skin/skinning.h"

namespace backbend::skin {

/// A character laid out for skinning many poses: the same bits as skin() with the linear method.
///
/// Vertices that the same (up to four) joints move stand together, eight to a block, so that one
/// blend of matrices serves eight vertices at once; the few others are done one by one. Built once
/// per character, then immutable: skin() may be called on many threads, and uses TBB itself.
class SkinningPlan {
 public:
  explicit SkinningPlan(const Character& character);

  /// As backbend::skin::skin(). `out` is resized; reuse it from pose to pose to save its making.
  void skin(const std::vector<glm::dmat4>& world_from_node, PosedMesh& out) const;

  /// Lanes of blocks that repeat a vertex, as a share of all vertices.
  double padded_share() const;
  /// Vertices that stand in no block, as a share of all.
  double single_share() const;

 private:
  struct Block {
    std::array<std::uint16_t, 4> joint{};
    std::array<std::uint32_t, 8> vertex{};
    std::uint8_t joint_count = 0;  // 1..4
    std::uint8_t lane_count = 0;   // vertices; the lanes behind them repeat the last
    bool in_a_row = false;         // eight vertices that follow each other
    std::size_t first = 0;         // into data_
  };
  void add_block(const Character& character, std::span<const std::uint32_t> vertices);

  std::size_t vertex_count_ = 0;
  std::size_t node_count_ = 0;
  std::vector<SkinJoint> joints_;
  std::vector<Block> blocks_;
  // Eight floats each: x, y, z, normal x, y, z, then one weight for each joint.
  std::vector<float> data_;
  struct Single {
    std::uint32_t vertex;
    Influences influences;
    glm::vec3 position, normal;
  };
  std::vector<Single> singles_;
};

}  // namespace backbend::skin
