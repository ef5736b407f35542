#include "render/trace/ray_device.h"

#if BACKBEND_EMBREE == 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <immintrin.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>
#include <string>
#include <type_traits>

#include "render/trace/refit_quality.h"
#include "render/trace/scene.h"

namespace backbend::render {
namespace {

template <auto release>
struct Release {
  template <class T>
  void operator()(T* handle) const {
    release(handle);
  }
};
using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, Release<rtcReleaseDevice>>;
using EmbreeScene = std::unique_ptr<std::remove_pointer_t<RTCScene>, Release<rtcReleaseScene>>;
using Geometry = std::unique_ptr<std::remove_pointer_t<RTCGeometry>, Release<rtcReleaseGeometry>>;

// One device for the process. The instruction set is pinned: another one may round hits otherwise.
// Threads are those of TBB, and of the arena that calls.
RTCDevice device() {
  static const Device instance(rtcNewDevice("isa=avx2,threads=0"));
  if (!instance) throw RenderError("the ray device did not start: this program needs AVX2");
  return instance.get();
}

void expect_no_error(const char* doing) {
  const RTCError error = rtcGetDeviceError(device());
  if (error == RTC_ERROR_NONE) return;
  const char* reason = error == RTC_ERROR_OUT_OF_MEMORY     ? "out of memory"
                       : error == RTC_ERROR_UNSUPPORTED_CPU ? "this CPU is not supported"
                                                            : "the device reports an error";
  throw RenderError(std::string("ray device, ") + doing + ": " + reason + " (code " +
                    std::to_string(static_cast<int>(error)) + ")");
}

// What the eight rays of a packet have met so far. Embree keeps whichever of two equally distant
// hits it visits last, which depends on the tree; this keeps the lowest triangle.
#if BACKBEND_EMBREE == 4
struct NearestContext {
  RTCRayQueryContext embree;
  float distance[8];
  std::uint32_t triangle[8];
};
#else
struct NearestContext {
  RTCIntersectContext embree;
  float distance[8];
  std::uint32_t triangle[8];
};
#endif

void keep_lowest_triangle(const RTCFilterFunctionNArguments* args) {
  auto* context = reinterpret_cast<NearestContext*>(args->context);
  const unsigned n = args->N;
  for (unsigned lane = 0; lane < n; ++lane) {
    if (args->valid[lane] == 0) continue;
    const unsigned ray = RTCRayN_id(args->ray, n, lane);
    const float distance = RTCRayN_tfar(args->ray, n, lane);
    const std::uint32_t triangle = RTCHitN_primID(args->hit, n, lane);
    const bool has_hit = context->triangle[ray] != RTC_INVALID_GEOMETRY_ID;
    if (has_hit && (distance > context->distance[ray] ||
                    (distance == context->distance[ray] && triangle > context->triangle[ray]))) {
      args->valid[lane] = 0;
      continue;
    }
    context->distance[ray] = distance;
    context->triangle[ray] = triangle;
    // Boxes that begin at this very distance may round to just beyond it; they must still be looked
    // into, so the ray stays a little longer than its hit.
    RTCRayN_tfar(args->ray, n, lane) = distance * (1.0f + 4e-6f);
  }
}

void load_lane(float (&lane)[8], const RayBatch::Column& column, std::size_t first) {
  store(lane, load(column.data() + first));
}

void load_rays(RTCRay8& packet, const RayBatch& rays, std::size_t first) {
  load_lane(packet.org_x, rays.origin_x, first);
  load_lane(packet.org_y, rays.origin_y, first);
  load_lane(packet.org_z, rays.origin_z, first);
  load_lane(packet.dir_x, rays.direction_x, first);
  load_lane(packet.dir_y, rays.direction_y, first);
  load_lane(packet.dir_z, rays.direction_z, first);
  load_lane(packet.tfar, rays.far, first);
  for (unsigned lane = 0; lane < 8; ++lane) {
    packet.tnear[lane] = 0.0f;
    packet.time[lane] = 0.0f;
    packet.mask[lane] = ~0u;
    packet.id[lane] = lane;
    packet.flags[lane] = 0;
  }
}

// Where the calling thread's rays are kept; null: nowhere.
thread_local RayRecord* recording = nullptr;

void keep_rays(RayRecord::Kind kind, const RayBatch& rays, std::size_t begin, std::size_t end) {
  RayRecord& to = *recording;
  // Whole packets, so that they are traced again as the same packets.
  const std::size_t first = to.far.size(), count = end - begin, whole = (count + 7) / 8 * 8;
  to.batches.push_back({kind, first, count});
  const auto keep = [begin, whole](std::vector<float>& column, const RayBatch::Column& from) {
    const auto* start = from.data() + begin;
    column.insert(column.end(), start, start + whole);
  };
  keep(to.origin_x, rays.origin_x);
  keep(to.origin_y, rays.origin_y);
  keep(to.origin_z, rays.origin_z);
  keep(to.direction_x, rays.direction_x);
  keep(to.direction_y, rays.direction_y);
  keep(to.direction_z, rays.direction_z);
  keep(to.far, rays.far);
}

// -1 for the lanes that hold a ray, as Embree wants them.
void set_valid(int (&valid)[8], std::size_t remaining) {
  for (std::size_t lane = 0; lane < 8; ++lane) valid[lane] = lane < remaining ? -1 : 0;
}

}  // namespace

namespace {

// A refitted tree that has come apart by more than this is slower than building another one costs.
// Bodies whose spine bends by 180 degrees go up to 1.43 and are met as fast as in a tree of their
// own; flung apart by 1.5, a single sample of 512 x 512 pixels pays for the building
// (docs/batteries.md).
constexpr double kMostGrowth = 1.5;

/// One tree with the buffers it was built from.
struct Tree {
  EmbreeScene scene;
  Geometry geometry;
  glm::vec3* vertex = nullptr;  // owned by the geometry

  Tree(std::span<const glm::uvec3> triangle, std::span<const glm::vec3> position);
  void refit(std::span<const glm::vec3> position);
};

Tree::Tree(std::span<const glm::uvec3> triangle, std::span<const glm::vec3> position)
    : scene(rtcNewScene(device())), geometry(rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_TRIANGLE)) {
  rtcSetGeometryBuildQuality(geometry.get(), RTC_BUILD_QUALITY_REFIT);
  vertex = static_cast<glm::vec3*>(rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX,
                                                           0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3),
                                                           position.size()));
  rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                             triangle.data(), 0, sizeof(glm::uvec3), triangle.size());
  expect_no_error("taking the mesh");
  std::memcpy(vertex, position.data(), position.size_bytes());
#if BACKBEND_EMBREE == 4
  rtcSetGeometryEnableFilterFunctionFromArguments(geometry.get(), true);
#endif
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometryByID(scene.get(), geometry.get(), 0);
  // A refitted geometry needs a scene that expects change; its own tree is built at MEDIUM quality.
  rtcSetSceneFlags(scene.get(), static_cast<RTCSceneFlags>(
#if BACKBEND_EMBREE == 4
                                    RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS |
#else
                                    RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION |
#endif
                                    // Without it one ray in ten that meets an edge exactly slips
                                    // between the triangles.
                                    RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC));
  rtcSetSceneBuildQuality(scene.get(), RTC_BUILD_QUALITY_LOW);
  rtcCommitScene(scene.get());
  expect_no_error("building the tree");
}

void Tree::refit(std::span<const glm::vec3> position) {
  std::memcpy(vertex, position.data(), position.size_bytes());
  rtcUpdateGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0);
  rtcCommitGeometry(geometry.get());
  rtcCommitScene(scene.get());
  expect_no_error("refitting the tree");
}

}  // namespace

struct RayScene::Impl {
  std::span<const glm::uvec3> triangle;
  std::size_t vertex_count;
  RefitQuality quality;
  Tree of_rest;                   // refitted
  std::unique_ptr<Tree> of_pose;  // built for a pose that the other does not fit; else null

  RTCScene scene() const { return of_pose ? of_pose->scene.get() : of_rest.scene.get(); }
};

RayScene::RayScene(std::span<const glm::uvec3> triangle, std::span<const glm::vec3> rest_position)
    : impl_(new Impl{triangle,
                     rest_position.size(),
                     {triangle, rest_position},
                     {triangle, rest_position},
                     nullptr}) {}

RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

void RayScene::set_pose(std::span<const glm::vec3> position) {
  if (position.size() != impl_->vertex_count)
    throw RenderError("a pose has " + std::to_string(position.size()) + " positions, the mesh " +
                      std::to_string(impl_->vertex_count));
  impl_->of_pose.reset();
  if (impl_->quality.growth(position) > kMostGrowth) {
    impl_->of_pose = std::make_unique<Tree>(impl_->triangle, position);
  } else {
    impl_->of_rest.refit(position);
  }
}

bool RayScene::is_refitted() const { return impl_->of_pose == nullptr; }

void RayScene::nearest(const RayBatch& rays, std::size_t count, Coherence coherence, HitBatch& hits,
                       std::span<const std::uint8_t> may_hit) const {
  const auto is_skipped = [may_hit](std::size_t first) {
    return !may_hit.empty() && may_hit[first / 8 % may_hit.size()] == 0;
  };
  NearestContext context;
#if BACKBEND_EMBREE == 4
  rtcInitRayQueryContext(&context.embree);
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = static_cast<RTCRayQueryFlags>((coherence == Coherence::camera
                                                       ? RTC_RAY_QUERY_FLAG_COHERENT
                                                       : RTC_RAY_QUERY_FLAG_INCOHERENT) |
                                                  RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER);
  arguments.context = &context.embree;
  arguments.filter = keep_lowest_triangle;
#else
  rtcInitIntersectContext(&context.embree);
  context.embree.flags = coherence == Coherence::camera ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT
                                                        : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  context.embree.filter = keep_lowest_triangle;
#endif
  alignas(32) int valid[8];
  RTCRayHit8 packet;
  for (std::size_t first = 0; first < count; first += 8) {
    if (is_skipped(first)) {
      store(&hits.triangle[first], splat(HitBatch::kNoTriangle));
      continue;
    }
    load_rays(packet.ray, rays, first);
    for (unsigned lane = 0; lane < 8; ++lane) {
      packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
      packet.hit.primID[lane] = RTC_INVALID_GEOMETRY_ID;
      packet.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
      context.distance[lane] = -1.0f;
      context.triangle[lane] = RTC_INVALID_GEOMETRY_ID;
    }
    set_valid(valid, count - first);
#if BACKBEND_EMBREE == 4
    rtcIntersect8(valid, impl_->scene(), &packet, &arguments);
#else
    rtcIntersect8(valid, impl_->scene(), &context.embree, &packet);
#endif
    std::memcpy(hits.triangle.data() + first, packet.hit.primID, sizeof packet.hit.primID);
  }
  if (recording == nullptr) return;
  const auto kind =
      coherence == Coherence::camera ? RayRecord::Kind::camera : RayRecord::Kind::scattered;
  for (std::size_t first = 0; first < count; first += 8) {
    // Packets that were traced one after another are one batch.
    std::size_t end = first;
    while (end < count && !is_skipped(end)) end += 8;
    if (end > first) keep_rays(kind, rays, first, std::min(end, count));
    first = end;
  }
  recording->hits[static_cast<std::size_t>(kind)] += static_cast<std::size_t>(std::count_if(
      hits.triangle.begin(), hits.triangle.begin() + static_cast<std::ptrdiff_t>(count),
      [](std::int32_t triangle) { return triangle != HitBatch::kNoTriangle; }));
}

void RayScene::occluded(const RayBatch& rays, std::size_t count, std::uint8_t* blocked) const {
#if BACKBEND_EMBREE == 4
  RTCRayQueryContext context;
  rtcInitRayQueryContext(&context);
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_INCOHERENT;
  arguments.context = &context;
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
#endif
  alignas(32) int valid[8];
  RTCRay8 packet;
  for (std::size_t first = 0; first < count; first += 8) {
    load_rays(packet, rays, first);
    set_valid(valid, count - first);
#if BACKBEND_EMBREE == 4
    rtcOccluded8(valid, impl_->scene(), &packet, &arguments);
#else
    rtcOccluded8(valid, impl_->scene(), &context, &packet);
#endif
    for (std::size_t lane = 0; lane < 8; ++lane)
      blocked[first + lane] = packet.tfar[lane] < 0.0f ? 1 : 0;
  }
  if (recording == nullptr) return;
  keep_rays(RayRecord::Kind::shadow, rays, 0, count);
  recording->hits[static_cast<std::size_t>(RayRecord::Kind::shadow)] +=
      static_cast<std::size_t>(std::count(blocked, blocked + count, 1));
}

std::size_t RayRecord::ray_count(Kind kind) const {
  return std::accumulate(batches.begin(), batches.end(), std::size_t{0},
                         [kind](std::size_t sum, const Batch& batch) {
                           return sum + (batch.kind == kind ? batch.count : 0);
                         });
}

RecordRays::RecordRays(RayRecord& into) { recording = &into; }
RecordRays::~RecordRays() { recording = nullptr; }

std::span<const RayWay> ray_ways() {
#if BACKBEND_EMBREE == 4
  static constexpr RayWay kWays[] = {RayWay::single, RayWay::packet};
#else
  static constexpr RayWay kWays[] = {RayWay::single, RayWay::packet, RayWay::stream};
#endif
  return kWays;
}

std::string_view name_of(RayWay way) {
  return way == RayWay::single ? "one by one" : way == RayWay::packet ? "eight wide" : "streams";
}

struct BareRayScene::Impl {
  EmbreeScene scene;
  Geometry geometry;
};

BareRayScene::BareRayScene(std::span<const glm::uvec3> triangle,
                           std::span<const glm::vec3> position, TreeQuality quality)
    : impl_(std::make_unique<Impl>()) {
  impl_->scene.reset(rtcNewScene(device()));
  impl_->geometry.reset(rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_TRIANGLE));
  RTCGeometry geometry = impl_->geometry.get();
  void* vertex = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                         sizeof(glm::vec3), position.size());
  void* index = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                        sizeof(glm::uvec3), triangle.size());
  expect_no_error("taking the mesh");
  std::memcpy(vertex, position.data(), position.size_bytes());
  std::memcpy(index, triangle.data(), triangle.size_bytes());
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(impl_->scene.get(), geometry, 0);
  rtcSetSceneFlags(impl_->scene.get(), RTC_SCENE_FLAG_ROBUST);  // as the renderer's own
  rtcSetSceneBuildQuality(impl_->scene.get(), quality == TreeQuality::high
                                                  ? RTC_BUILD_QUALITY_HIGH
                                                  : RTC_BUILD_QUALITY_MEDIUM);
  rtcCommitScene(impl_->scene.get());
  expect_no_error("building the tree");
}
BareRayScene::~BareRayScene() = default;

namespace {

void clear(RTCHit& hit) {
  hit.geomID = RTC_INVALID_GEOMETRY_ID;
  hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
}

void load_ray(RTCRay& ray, const RayRecord& record, std::size_t i) {
  ray.org_x = record.origin_x[i];
  ray.org_y = record.origin_y[i];
  ray.org_z = record.origin_z[i];
  ray.dir_x = record.direction_x[i];
  ray.dir_y = record.direction_y[i];
  ray.dir_z = record.direction_z[i];
  ray.tnear = ray.time = 0.0f;
  ray.tfar = record.far[i];
  ray.mask = ~0u;
  ray.id = ray.flags = 0;
}

void load_packet(RTCRay8& packet, const RayRecord& record, std::size_t first) {
  const auto lanes = [first](float(&lane)[8], const std::vector<float>& column) {
    store(lane, load(column.data() + first));
  };
  lanes(packet.org_x, record.origin_x);
  lanes(packet.org_y, record.origin_y);
  lanes(packet.org_z, record.origin_z);
  lanes(packet.dir_x, record.direction_x);
  lanes(packet.dir_y, record.direction_y);
  lanes(packet.dir_z, record.direction_z);
  lanes(packet.tfar, record.far);
  for (unsigned lane = 0; lane < 8; ++lane) {
    packet.tnear[lane] = packet.time[lane] = 0.0f;
    packet.mask[lane] = ~0u;
    packet.id[lane] = packet.flags[lane] = 0;
  }
}

/// Asks a scene, in either version of the device's words.
class Asker {
 public:
  Asker(RTCScene scene, bool coherent) : scene_(scene) {
#if BACKBEND_EMBREE == 4
    const RTCRayQueryFlags flags =
        coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    rtcInitIntersectArguments(&nearest_);
    nearest_.flags = flags;
    rtcInitOccludedArguments(&any_);
    any_.flags = flags;
#else
    rtcInitIntersectContext(&context_);
    context_.flags =
        coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
#endif
  }

#if BACKBEND_EMBREE == 4
  void nearest(RTCRayHit& ray) { rtcIntersect1(scene_, &ray, &nearest_); }
  void any(RTCRay& ray) { rtcOccluded1(scene_, &ray, &any_); }
  void nearest(const int* valid, RTCRayHit8& rays) {
    rtcIntersect8(valid, scene_, &rays, &nearest_);
  }
  void any(const int* valid, RTCRay8& rays) { rtcOccluded8(valid, scene_, &rays, &any_); }
#else
  void nearest(RTCRayHit& ray) { rtcIntersect1(scene_, &context_, &ray); }
  void any(RTCRay& ray) { rtcOccluded1(scene_, &context_, &ray); }
  void nearest(const int* valid, RTCRayHit8& rays) {
    rtcIntersect8(valid, scene_, &context_, &rays);
  }
  void any(const int* valid, RTCRay8& rays) { rtcOccluded8(valid, scene_, &context_, &rays); }
  void nearest(std::span<RTCRayHit> rays) {
    rtcIntersect1M(scene_, &context_, rays.data(), static_cast<unsigned>(rays.size()),
                   sizeof(RTCRayHit));
  }
  void any(std::span<RTCRay> rays) {
    rtcOccluded1M(scene_, &context_, rays.data(), static_cast<unsigned>(rays.size()),
                  sizeof(RTCRay));
  }
#endif

 private:
  RTCScene scene_;
#if BACKBEND_EMBREE == 4
  RTCIntersectArguments nearest_;
  RTCOccludedArguments any_;
#else
  RTCIntersectContext context_;
#endif
};

bool met(const RTCRay& ray) { return ray.tfar < 0.0f; }
bool met(const RTCRayHit& ray) { return ray.hit.geomID != RTC_INVALID_GEOMETRY_ID; }

std::size_t trace_one_by_one(Asker& asker, const RayRecord& record, const RayRecord::Batch& batch) {
  std::size_t hits = 0;
  RTCRayHit ray;
  for (std::size_t i = batch.first; i < batch.first + batch.count; ++i) {
    load_ray(ray.ray, record, i);
    if (batch.kind == RayRecord::Kind::shadow) {
      asker.any(ray.ray);
      hits += met(ray.ray) ? 1 : 0;
    } else {
      clear(ray.hit);
      asker.nearest(ray);
      hits += met(ray) ? 1 : 0;
    }
  }
  return hits;
}

std::size_t trace_eight_wide(Asker& asker, const RayRecord& record, const RayRecord::Batch& batch) {
  std::size_t hits = 0;
  alignas(32) int valid[8];
  RTCRayHit8 packet;
  for (std::size_t i = 0; i < batch.count; i += 8) {
    load_packet(packet.ray, record, batch.first + i);
    for (unsigned lane = 0; lane < 8; ++lane)
      packet.hit.geomID[lane] = packet.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
    set_valid(valid, batch.count - i);
    const bool shadow = batch.kind == RayRecord::Kind::shadow;
    if (shadow) {
      asker.any(valid, packet.ray);
    } else {
      asker.nearest(valid, packet);
    }
    for (unsigned lane = 0; lane < 8; ++lane) {
      const bool hit = shadow ? packet.ray.tfar[lane] < 0.0f
                              : packet.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID;
      hits += valid[lane] != 0 && hit ? 1 : 0;
    }
  }
  return hits;
}

#if BACKBEND_EMBREE != 4
std::size_t trace_streams(Asker& asker, const RayRecord& record, const RayRecord::Batch& batch) {
  constexpr std::size_t kStream = 256;
  std::array<RTCRayHit, kStream> nearest;
  std::array<RTCRay, kStream> any;
  std::size_t hits = 0;
  for (std::size_t i = 0; i < batch.count; i += kStream) {
    const std::size_t n = std::min(kStream, batch.count - i);
    const auto count = [&](auto rays) {
      for (const auto& ray : rays) hits += met(ray) ? 1 : 0;
    };
    if (batch.kind == RayRecord::Kind::shadow) {
      for (std::size_t k = 0; k < n; ++k) load_ray(any[k], record, batch.first + i + k);
      asker.any(std::span(any).first(n));
      count(std::span(any).first(n));
    } else {
      for (std::size_t k = 0; k < n; ++k) {
        load_ray(nearest[k].ray, record, batch.first + i + k);
        clear(nearest[k].hit);
      }
      asker.nearest(std::span(nearest).first(n));
      count(std::span(nearest).first(n));
    }
  }
  return hits;
}
#endif

}  // namespace

std::size_t BareRayScene::trace(const RayRecord& record, RayRecord::Kind kind, RayWay way,
                                bool coherent) const {
  Asker asker(impl_->scene.get(), coherent);
  std::size_t hits = 0;
  for (const RayRecord::Batch& batch : record.batches) {
    if (batch.kind != kind) continue;
    if (way == RayWay::single) hits += trace_one_by_one(asker, record, batch);
    if (way == RayWay::packet) hits += trace_eight_wide(asker, record, batch);
#if BACKBEND_EMBREE != 4
    if (way == RayWay::stream) hits += trace_streams(asker, record, batch);
#endif
  }
  return hits;
}

FlushDenormals::FlushDenormals() : saved_(_mm_getcsr()) {
  constexpr unsigned kFlushToZero = 0x8000, kDenormalsAreZero = 0x0040;
  _mm_setcsr(saved_ | kFlushToZero | kDenormalsAreZero);
}
FlushDenormals::~FlushDenormals() { _mm_setcsr(saved_); }

int ray_device_version() {
  return static_cast<int>(rtcGetDeviceProperty(device(), RTC_DEVICE_PROPERTY_VERSION));
}

}  // namespace backbend::render
