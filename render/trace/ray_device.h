#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "render/image/lanes.h"

namespace backbend::render {

/// Rays as arrays, so that eight of them go to the ray device without being shuffled.
/// Directions need not be unit length; `far` is in units of the direction. Rays are indexed from 0;
/// a batch holds at most kCapacity of them, and Compress may write seven past the last.
struct RayBatch {
  static constexpr std::size_t kCapacity = 2048;
  using Column = std::array<float, kCapacity + 8>;
  alignas(32) Column origin_x, origin_y, origin_z;
  alignas(32) Column direction_x, direction_y, direction_z;
  alignas(32) Column far;

  /// Eight rays from a multiple of 8 on.
  void set_packet(std::size_t first, const Vec8& origin, const Vec8& direction,
                  Float8 far_distance) {
    store(&origin_x[first], origin.x);
    store(&origin_y[first], origin.y);
    store(&origin_z[first], origin.z);
    store(&direction_x[first], direction.x);
    store(&direction_y[first], direction.y);
    store(&direction_z[first], direction.z);
    store(&far[first], far_distance);
  }
  /// The lanes that `kept` keeps, from any place on.
  void append(std::size_t first, const Compress& kept, const Vec8& origin, const Vec8& direction,
              Float8 far_distance) {
    kept.write(&origin_x[first], origin.x);
    kept.write(&origin_y[first], origin.y);
    kept.write(&origin_z[first], origin.z);
    kept.write(&direction_x[first], direction.x);
    kept.write(&direction_y[first], direction.y);
    kept.write(&direction_z[first], direction.z);
    kept.write(&far[first], far_distance);
  }
  Vec8 packet_origin(std::size_t first) const {
    return {load(&origin_x[first]), load(&origin_y[first]), load(&origin_z[first])};
  }
  Vec8 packet_direction(std::size_t first) const {
    return {load(&direction_x[first]), load(&direction_y[first]), load(&direction_z[first])};
  }
};

/// The nearest triangle along each ray of a batch, or kNoTriangle.
struct HitBatch {
  static constexpr std::int32_t kNoTriangle = -1;
  alignas(32) std::array<std::int32_t, RayBatch::kCapacity> triangle;

  Int8 packet(std::size_t first) const { return load(&triangle[first]); }
};

/// Rays of one camera tile agree on their way through the tree; all others do not.
enum class Coherence { camera, scattered };

/// Triangles in the ray device: a tree built once for the rest pose and refitted for every other;
/// where a pose has torn it too far apart, one is built for that pose.
///
/// The tree's shape depends on the pose and the rest pose alone, so a frame never depends on the
/// frames before it. Of triangles hit at one and the same distance the lowest index wins.
class RayScene {
 public:
  /// Builds the tree. `triangle` must outlive this. Throws RenderError where the device cannot (no
  /// AVX2, out of memory).
  RayScene(std::span<const glm::uvec3> triangle, std::span<const glm::vec3> rest_position);
  ~RayScene();
  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;

  /// Moves the vertices. `position` must be finite, one per vertex.
  void set_pose(std::span<const glm::vec3> position);
  /// Whether the pose is met by the rest pose's tree.
  bool is_refitted() const;
  /// Nearest hits of the first `count` rays. Overwrites lanes past `count` up to a multiple of 8.
  /// Packets whose entry in `may_hit` is 0, over and over from its start, are known to miss and not
  /// traced; an empty one asks for all.
  void nearest(const RayBatch& rays, std::size_t count, Coherence coherence, HitBatch& hits,
               std::span<const std::uint8_t> may_hit = {}) const;
  /// blocked[i] = 1 where ray i meets any triangle before its `far`, else 0. Writes whole packets.
  void occluded(const RayBatch& rays, std::size_t count, std::uint8_t* blocked) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Rays that were traced, in their batches and their order.
struct RayRecord {
  enum class Kind { camera, scattered, shadow };
  struct Batch {
    Kind kind;
    std::size_t first, count;  // into the columns; `first` is a multiple of 8
  };
  std::vector<Batch> batches;
  std::vector<float> origin_x, origin_y, origin_z, direction_x, direction_y, direction_z, far;
  std::array<std::size_t, 3> hits{};  // rays of each kind that met something

  std::size_t ray_count(Kind kind) const;
};

/// Keeps every ray that this thread traces for as long as it lives.
class RecordRays {
 public:
  explicit RecordRays(RayRecord& into);
  ~RecordRays();
  RecordRays(const RecordRays&) = delete;
  RecordRays& operator=(const RecordRays&) = delete;
};

/// How the bare device is asked for rays: one by one, eight side by side, or as streams of 256.
enum class RayWay { single, packet, stream };
/// Embree 4 has no streams.
std::span<const RayWay> ray_ways();
std::string_view name_of(RayWay way);

/// How much work goes into a bare tree.
enum class TreeQuality { medium, high };

/// The ray device with nothing around it, as a measure: a tree built once that cannot be refitted,
/// and the nearest hit that the device itself chooses.
class BareRayScene {
 public:
  BareRayScene(std::span<const glm::uvec3> triangle, std::span<const glm::vec3> position,
               TreeQuality quality);
  ~BareRayScene();
  /// Traces the rays of one kind of a record, `coherent` or not as far as the device is told, and
  /// gives the number of those that met something.
  std::size_t trace(const RayRecord& record, RayRecord::Kind kind, RayWay way, bool coherent) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The version of the ray device that runs: 10000 major + 100 minor + patch.
int ray_device_version();

/// Puts the thread into flush-to-zero mode for as long as it lives: Embree asks for it, and every
/// thread that shades must be in one and the same mode for images to be equal.
class FlushDenormals {
 public:
  FlushDenormals();
  ~FlushDenormals();
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
  unsigned saved_;
};

}  // namespace backbend::render
