#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "skin/deform/linear_blend.h"
#include "skin/deform/skinning.h"

namespace backbend::skin {

/// A character laid out for skinning many poses: the same bits as skin() with the linear method.
///
/// The mesh is cut into tiles of vertices that follow each other, the work of one thread. In a
/// tile, vertices that the same (up to four) joints move stand together, eight to a block, so that
/// one blend of matrices serves eight vertices at once, and blocks of the same joints follow each
/// other as a run, whose matrices are spread out once; the few others are done one by one. Built
/// once per character, then immutable: skin() may be called on many threads, and uses TBB itself.
class SkinningPlan {
 public:
  explicit SkinningPlan(const Character& character);

  /// As backbend::skin::skin(). `out` is resized; reuse it from pose to pose to save its making.
  void skin(std::span<const glm::dmat4> world_from_node, PosedMesh& out) const;
  /// The same into memory of the caller's, one place for each vertex.
  void skin(std::span<const glm::dmat4> world_from_node, std::span<glm::vec3> position,
            std::span<glm::vec3> normal) const;

  /// Lanes of blocks that repeat a vertex, as a share of all vertices.
  double padded_share() const;
  /// Vertices that stand in no block, as a share of all.
  double single_share() const;

 private:
  // Vertices are counted from their tile's first.
  using Lanes = std::array<std::uint16_t, 8>;  // a block of fewer vertices repeats its last
  struct Run {                                 // blocks that the same joints move
    std::array<std::uint16_t, 4> joint{};      // ascending
    std::uint8_t joint_count = 0;              // 1..4
    std::uint16_t rows = 0;       // blocks of eight vertices that follow each other, then
    std::uint16_t scattered = 0;  // blocks of any
  };
  struct Single {  // a vertex that up to four joints move, ascending
    std::array<float, 4> weight{};
    glm::vec3 position, normal;
    std::array<std::uint16_t, 4> joint{};
    std::uint16_t vertex = 0;
    std::uint8_t joint_count = 0;  // 1..4
  };
  struct Other {  // moved by none, or by more
    Influences influences;
    glm::vec3 position, normal;
    std::uint16_t vertex = 0;
  };
  struct Tile {  // where its share of the lists begins; it ends where the next one begins
    std::size_t run = 0, row = 0, scattered = 0, data = 0, single = 0, other = 0;
  };
  void begin_tile();
  void add_block(const Character& character, std::uint32_t first,
                 std::span<const std::uint32_t> vertices);
  void add_single(const Character& character, std::uint32_t first, std::uint32_t vertex);
  void add_tile(const Character& character, std::uint32_t first, std::uint32_t last);
  template <int kJoints, bool kUneven>
  const float* skin_run(const JointMatrices& joints, const Run& run, const std::uint16_t* row,
                        const Lanes* scattered, const float* data, glm::vec3* position,
                        glm::vec3* normal) const;
  template <bool kUneven>
  void skin_tile(const JointMatrices& joints, std::size_t tile, glm::vec3* position,
                 glm::vec3* normal) const;

  std::size_t vertex_count_ = 0;
  std::size_t node_count_ = 0;
  std::size_t tile_ = 0;  // vertices of each tile but the last
  std::vector<SkinJoint> joints_;
  std::vector<Tile> tiles_;  // one more than there are
  std::vector<Run> runs_;
  std::vector<std::uint16_t> rows_;  // the first vertex of each block in a row
  std::vector<Lanes> scattered_;
  std::size_t padded_ = 0;  // lanes that repeat a vertex
  // Eight floats each: x, y, z, normal x, y, z, then one weight for each joint.
  std::vector<float> data_;
  std::vector<Single> singles_;
  std::vector<Other> others_;
};

}  // namespace backbend::skin
