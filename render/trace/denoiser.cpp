#include "render/trace/denoiser.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "render/image/lanes.h"
#include "render/image/threads.h"
#include "render/trace/ray_device.h"

namespace backbend::render {
namespace {

constexpr int kReach = 5;  // pixels
constexpr int kPatch = 1;
constexpr int kBorder = kReach + kPatch;
constexpr int kRows = 8;  // filtered together; what they need stays in the cache
// Differences up to this many times the noise count as noise.
constexpr float kColorScale = 0.7f;
constexpr float kTolerance = 4.0f;          // where a colour's distance stops counting
constexpr float kLeastVariance = 1e-6f;     // of colours: below a step of 8-bit sRGB
constexpr float kNormalScale = 1 / 0.18f;   // over the squared difference of unit normals
constexpr float kAlbedoScale = 1 / 0.015f;  // over the squared difference of colours
constexpr float kDepthStep = 0.012f;        // of the depth itself

/// A plane with a border that repeats the edge, so that windows need no clipping, and rows that end
/// on a multiple of eight.
struct Plane {
  int width, height, padded, stride;
  std::vector<float> data;

  Plane(int w, int h)
      : width(w),
        height(h),
        padded((w + 7) / 8 * 8),
        stride(padded + 2 * kBorder),
        data(static_cast<std::size_t>(stride) * (h + 2 * kBorder)) {}
  float* row(int y) {
    return data.data() + static_cast<std::size_t>(y + kBorder) * stride + kBorder;
  }
  const float* row(int y) const {
    return data.data() + static_cast<std::size_t>(y + kBorder) * stride + kBorder;
  }
  void repeat_edges() {
    for (int y = 0; y < height; ++y) {
      float* at = row(y);
      std::fill(at - kBorder, at, at[0]);
      std::fill(at + width, at + padded + kBorder, at[width - 1]);
    }
    for (int i = 1; i <= kBorder; ++i) {
      std::copy_n(row(0) - kBorder, stride, row(-i) - kBorder);
      std::copy_n(row(height - 1) - kBorder, stride, row(height - 1 + i) - kBorder);
    }
  }
};
using Planes = std::array<Plane, 3>;

Planes planes_from(std::span<const float> triples, int width, int height) {
  Planes planes{Plane(width, height), Plane(width, height), Plane(width, height)};
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x)
        planes[c].row(y)[x] = triples[(static_cast<std::size_t>(y) * width + x) * 3 + c];
    }
    planes[c].repeat_edges();
  }
  return planes;
}

Plane plane_from(std::span<const float> values, int width, int height) {
  Plane plane(width, height);
  for (int y = 0; y < height; ++y)
    std::copy_n(values.data() + static_cast<std::size_t>(y) * width, width, plane.row(y));
  plane.repeat_edges();
  return plane;
}

// Variance of a half's mean: from the halves' difference, evened out over 5 x 5 pixels, for one
// pixel's difference says little.
Plane variance_of(const Plane& a, const Plane& b) {
  constexpr int kEven = 2;
  Plane variance(a.width, a.height);
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      float sum = 0.0f;
      for (int dy = -kEven; dy <= kEven; ++dy) {
        for (int dx = -kEven; dx <= kEven; ++dx) {
          const float d = a.row(y + dy)[x + dx] - b.row(y + dy)[x + dx];
          sum += d * d;
        }
      }
      variance.row(y)[x] = sum / (2.0f * (2 * kEven + 1) * (2 * kEven + 1));
    }
  }
  variance.repeat_edges();
  return variance;
}

// 1 at no distance, 0 from distance 1 on.
Float8 falling(Float8 distance) {
  const Float8 left = max(1.0f - distance, splat(0.0f));
  return left * left;
}

/// Memory for one row, each entry a multiple of eight floats.
struct RowSums {
  std::vector<float> weight, red, green, blue;
  explicit RowSums(int padded) : weight(padded), red(padded), green(padded), blue(padded) {}

  void add(int x, Float8 by, const Planes& from, int y, int dx) {
    const auto sum = [x](std::vector<float>& to, Float8 value) {
      store(&to[x], load(&to[x]) + value);
    };
    sum(weight, by);
    sum(red, by * load(from[0].row(y) + x + dx));
    sum(green, by * load(from[1].row(y) + x + dx));
    sum(blue, by * load(from[2].row(y) + x + dx));
  }
  std::array<float, 3> mean(int x) const {
    // A pixel's own weight is 1, so no sum is empty.
    return {red[x] / weight[x], green[x] / weight[x], blue[x] / weight[x]};
  }
};

struct Filter {
  int width, height;
  Planes a, b, variance, albedo, normal;
  Plane depth;

  Float8 color_distance(const Planes& guide, int x, int y, int dx, int dy) const;
  Float8 feature_weight(int x, int y, int dx, int dy) const;
  void filter_rows(int first, int end, Denoised& out) const;
};

// Squared distance of two pixels' colours over what noise explains.
Float8 Filter::color_distance(const Planes& guide, int x, int y, int dx, int dy) const {
  Float8 sum = splat(0.0f);
  for (int c = 0; c < 3; ++c) {
    const Float8 d = load(guide[c].row(y) + x) - load(guide[c].row(y + dy) + x + dx);
    const Float8 here = load(variance[c].row(y) + x);
    const Float8 there = load(variance[c].row(y + dy) + x + dx);
    const Float8 noise = kColorScale * kColorScale * (here + there);
    sum += (d * d - (here + min(here, there))) / (noise + kLeastVariance);
  }
  return sum;
}

Float8 Filter::feature_weight(int x, int y, int dx, int dy) const {
  const auto distance = [&](const Planes& of) {
    Float8 sum = splat(0.0f);
    for (int c = 0; c < 3; ++c) {
      const Float8 d = load(of[c].row(y) + x) - load(of[c].row(y + dy) + x + dx);
      sum += d * d;
    }
    return sum;
  };
  const Float8 here = load(depth.row(y) + x), there = load(depth.row(y + dy) + x + dx);
  const Float8 step = (here - there) / (kDepthStep * min(here, there));
  return falling(distance(albedo) * kAlbedoScale) * falling(distance(normal) * kNormalScale) *
         falling(step * step);
}

// Rows from `first` to before `end` together: the distances of a row's single pixels serve the
// patches of three rows.
void Filter::filter_rows(int first, int end, Denoised& out) const {
  const int padded = depth.padded, count = end - first;
  // Distances of single pixels by row, from one patch above the first row, with one patch to the
  // left and right; of one row's patches summed over their columns.
  const auto stride = static_cast<std::size_t>(padded) + 16;
  std::vector<float> pixel_a(stride * static_cast<std::size_t>(count + 2 * kPatch));
  std::vector<float> pixel_b(pixel_a.size()), by_a(stride), by_b(stride);
  std::vector<RowSums> of_a(static_cast<std::size_t>(count), RowSums(padded)), of_b = of_a;
  constexpr float kPerTerm = 1.0f / (3.0f * (2 * kPatch + 1) * (2 * kPatch + 1));
  const auto for_each_packet = [&](const auto& act) {
    for (int x = -kPatch; x < padded + kPatch; x += 8)
      act(std::min(x, padded + kPatch - 8));  // the last packet is moved back into the border
  };
  for (int dy = -kReach; dy <= kReach; ++dy) {
    for (int dx = -kReach; dx <= kReach; ++dx) {
      for (int row = 0; row < count + 2 * kPatch; ++row) {
        const std::size_t at_row = static_cast<std::size_t>(row) * stride + kPatch;
        for_each_packet([&](int x) {
          const std::size_t at = at_row + x;
          store(&pixel_a[at], color_distance(a, x, first - kPatch + row, dx, dy));
          store(&pixel_b[at], color_distance(b, x, first - kPatch + row, dx, dy));
        });
      }
      for (int row = 0; row < count; ++row) {
        const int y = first + row;
        for_each_packet([&](int x) {
          Float8 sum_a = splat(0.0f), sum_b = splat(0.0f);
          for (int patch = 0; patch <= 2 * kPatch; ++patch) {
            const std::size_t at = static_cast<std::size_t>(row + patch) * stride + kPatch + x;
            sum_a += load(&pixel_a[at]);
            sum_b += load(&pixel_b[at]);
          }
          store(&by_a[x + kPatch], sum_a);
          store(&by_b[x + kPatch], sum_b);
        });
        const auto patch_weight = [&](const std::vector<float>& columns, int x) {
          const Float8 sum = load(&columns[x]) + load(&columns[x + 1]) + load(&columns[x + 2]);
          return falling(max(sum, splat(0.0f)) * (kPerTerm / kTolerance));
        };
        for (int x = 0; x < padded; x += 8) {
          const Float8 feature = feature_weight(x, y, dx, dy);
          of_a[row].add(x, feature * patch_weight(by_b, x), a, y + dy, dx);
          of_b[row].add(x, feature * patch_weight(by_a, x), b, y + dy, dx);
        }
      }
    }
  }
  for (int y = first; y < end; ++y) {
    for (int x = 0; x < width; ++x) {
      const std::array<float, 3> from_a = of_a[y - first].mean(x), from_b = of_b[y - first].mean(x);
      const std::size_t pixel = static_cast<std::size_t>(y) * width + x;
      float squared = 0.0f;
      for (int c = 0; c < 3; ++c) {
        out.color[pixel * 3 + c] = 0.5f * (from_a[c] + from_b[c]);
        squared += 0.25f * (from_a[c] - from_b[c]) * (from_a[c] - from_b[c]);
      }
      out.error[pixel] = squared / 3.0f;
    }
  }
}

// The difference of two halves at one pixel says little of its error; that of 5 x 5 says more.
void settle_errors(Denoised& out, int width, int height) {
  const Plane squared = plane_from(out.error, width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      float sum = 0.0f;
      for (int dy = -2; dy <= 2; ++dy)
        for (int dx = -2; dx <= 2; ++dx) sum += squared.row(y + dy)[x + dx];
      out.error[static_cast<std::size_t>(y) * width + x] = std::sqrt(sum / 25.0f);
    }
  }
}

}  // namespace

Denoised denoise(const DenoiseInput& in) {
  const int width = in.width, height = in.height;
  Planes a = planes_from(in.half_a, width, height), b = planes_from(in.half_b, width, height);
  Planes variance{variance_of(a[0], b[0]), variance_of(a[1], b[1]), variance_of(a[2], b[2])};
  const Filter filter{width,
                      height,
                      std::move(a),
                      std::move(b),
                      std::move(variance),
                      planes_from(in.albedo, width, height),
                      planes_from(in.normal, width, height),
                      plane_from(in.depth, width, height)};
  const auto pixels = static_cast<std::size_t>(width) * height;
  Denoised out{std::vector<float>(pixels * 3), std::vector<float>(pixels)};
  on_threads(in.threads, [&] {
    tbb::parallel_for(0, (height + kRows - 1) / kRows, [&](int strip) {
      const FlushDenormals flush;  // the same arithmetic on every thread
      filter.filter_rows(strip * kRows, std::min(height, (strip + 1) * kRows), out);
    });
  });
  settle_errors(out, width, height);
  return out;
}

}  // namespace backbend::render
