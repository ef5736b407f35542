#include <algorithm>
#include <cmath>

#include "validate/metrics/image/image.h"

namespace backbend::validate {
namespace {

/// One dimension of the distance transform: out[q] = min over p of (q - p)^2 + f[p].
class LowerEnvelope {
 public:
  explicit LowerEnvelope(std::size_t size) : parabola_(size), from_(size + 1) {}

  void transform(std::span<const double> f, std::span<double> out) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    std::size_t count = 0;
    for (std::size_t q = 0; q < f.size(); ++q) {
      if (f[q] == kInfinity) continue;
      const double x = static_cast<double>(q);
      double start = -kInfinity;
      while (count > 0) {
        const std::size_t p = parabola_[count - 1];
        const double v = static_cast<double>(p);
        start = ((f[q] + x * x) - (f[p] + v * v)) / (2.0 * (x - v));
        if (start > from_[count - 1]) break;
        --count;
      }
      if (count == 0) start = -kInfinity;
      parabola_[count] = q;
      from_[count++] = start;
    }
    if (count == 0) {
      std::ranges::fill(out, kInfinity);
      return;
    }
    std::size_t k = 0;
    for (std::size_t q = 0; q < f.size(); ++q) {
      const double x = static_cast<double>(q);
      while (k + 1 < count && from_[k + 1] < x) ++k;
      const double gap = x - static_cast<double>(parabola_[k]);
      out[q] = gap * gap + f[parabola_[k]];
    }
  }

 private:
  std::vector<std::size_t> parabola_;
  std::vector<double> from_;
};

Mask outline(const Mask& mask) {
  Mask out{mask.width, mask.height, std::vector<std::uint8_t>(mask.inside.size(), 0)};
  const auto inside = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < mask.width && y < mask.height &&
           mask.inside[static_cast<std::size_t>(y) * mask.width + x];
  };
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      out.inside[static_cast<std::size_t>(y) * mask.width + x] =
          inside(x, y) &&
          !(inside(x - 1, y) && inside(x + 1, y) && inside(x, y - 1) && inside(x, y + 1));
  return out;
}

/// The part of a picture that holds all that is inside of two masks.
struct Part {
  int left = 0, top = 0, right = 0, bottom = 0;  // the last two are outside of it

  Part(const Mask& a, const Mask& b) : left(a.width), top(a.height) {
    for (int y = 0; y < a.height; ++y)
      for (int x = 0; x < a.width; ++x) {
        const std::size_t i = static_cast<std::size_t>(y) * a.width + x;
        if (!(a.inside[i] | b.inside[i])) continue;
        left = std::min(left, x);
        right = std::max(right, x + 1);
        top = std::min(top, y);
        bottom = std::max(bottom, y + 1);
      }
  }
  Mask of(const Mask& mask) const {
    Mask out{right - left, bottom - top, {}};
    out.inside.reserve(static_cast<std::size_t>(out.width) * out.height);
    for (int y = top; y < bottom; ++y) {
      const auto row = mask.inside.begin() + static_cast<std::ptrdiff_t>(y) * mask.width;
      out.inside.insert(out.inside.end(), row + left, row + right);
    }
    return out;
  }
};

/// The value that 95 of 100 do not exceed.
double most_of(std::vector<double>& values) {
  const double rank = std::ceil(0.95 * static_cast<double>(values.size()));
  const auto index = static_cast<std::ptrdiff_t>(std::max(1.0, rank)) - 1;
  std::nth_element(values.begin(), values.begin() + index, values.end());
  return values[static_cast<std::size_t>(index)];
}

}  // namespace

std::size_t Mask::count() const {
  return static_cast<std::size_t>(std::ranges::count(inside, std::uint8_t{1}));
}

Mask silhouette(const ImageView& image, int channel, float threshold) {
  require_alike(image, image, channel + 1);
  Mask mask{image.width, image.height, {}};
  mask.inside.reserve(image.pixel_count());
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      mask.inside.push_back(image.at(x, y, channel) >= threshold);
  return mask;
}

double overlap(const Mask& a, const Mask& b) {
  if (a.width != b.width || a.height != b.height) throw ImageError("masks of different sizes");
  std::size_t both = 0, either = 0;
  for (std::size_t i = 0; i < a.inside.size(); ++i) {
    both += a.inside[i] & b.inside[i];
    either += a.inside[i] | b.inside[i];
  }
  if (either == 0) return std::numeric_limits<double>::quiet_NaN();
  return static_cast<double>(both) / static_cast<double>(either);
}

std::vector<double> squared_distance(const Mask& mask) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::size_t width = static_cast<std::size_t>(mask.width);
  const std::size_t height = static_cast<std::size_t>(mask.height);
  std::vector<double> out(width * height);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = mask.inside[i] ? 0.0 : kInfinity;
  LowerEnvelope envelope(std::max(width, height));
  std::vector<double> column(height), column_out(height), row_out(width);
  for (std::size_t x = 0; x < width; ++x) {
    for (std::size_t y = 0; y < height; ++y) column[y] = out[y * width + x];
    envelope.transform(column, column_out);
    for (std::size_t y = 0; y < height; ++y) out[y * width + x] = column_out[y];
  }
  for (std::size_t y = 0; y < height; ++y) {
    const std::span<double> row(out.data() + y * width, width);
    envelope.transform(row, row_out);
    std::ranges::copy(row_out, row.begin());
  }
  return out;
}

OutlineDistance outline_distance(const Mask& a, const Mask& b) {
  if (a.width != b.width || a.height != b.height) throw ImageError("masks of different sizes");
  OutlineDistance out;
  const Mask whole[2] = {outline(a), outline(b)};
  if (whole[0].count() == 0 || whole[1].count() == 0) {
    out.largest = out.most = std::numeric_limits<double>::quiet_NaN();
    return out;
  }
  // Both outlines lie in the part, so no distance between them is another there; all are square
  // roots of whole numbers, found exactly.
  const Part part(whole[0], whole[1]);
  const Mask outlines[2] = {part.of(whole[0]), part.of(whole[1])};
  for (int side = 0; side < 2; ++side) {
    const std::vector<double> distance = squared_distance(outlines[1 - side]);
    std::vector<double> values;
    for (std::size_t i = 0; i < distance.size(); ++i) {
      if (!outlines[side].inside[i]) continue;
      const double d = std::sqrt(distance[i]);
      values.push_back(d);
      if (d > out.largest || out.x < 0) {
        const auto width = static_cast<std::size_t>(outlines[side].width);
        out.largest = d;
        out.x = part.left + static_cast<int>(i % width);
        out.y = part.top + static_cast<int>(i / width);
      }
    }
    out.most = std::max(out.most, most_of(values));
  }
  return out;
}

}  // namespace backbend::validate
