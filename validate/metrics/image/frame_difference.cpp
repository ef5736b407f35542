#include "validate/metrics/image/frame_difference.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "validate/metrics/math/nan.h"

namespace backbend::validate {
namespace {

/// The layer as an image, or an empty view; `channels` are those that the question needs.
ImageView view_of(const render::Frame& frame, const char* first_channel, std::size_t channels) {
  const render::Layer* layer = frame.find(first_channel);
  if (layer == nullptr || layer->names.size() < channels) return {};
  return {frame.width, frame.height, static_cast<int>(layer->names.size()), layer->data};
}

std::vector<std::string> channel_names(const render::Frame& frame) {
  std::vector<std::string> names;
  for (const render::Layer& layer : frame.layers)
    names.insert(names.end(), layer.names.begin(), layer.names.end());
  std::ranges::sort(names);
  return names;
}

bool same_bits(const render::Frame& a, const render::Frame& b) {
  return std::ranges::equal(
      a.layers, b.layers, [](const render::Layer& left, const render::Layer& right) {
        return left.names == right.names && left.data.size() == right.data.size() &&
               std::memcmp(left.data.data(), right.data.data(), left.data.size() * sizeof(float)) ==
                   0;
      });
}

enum class Decides { no, at_most, at_least };

/// Collects the answers to the questions about one layer.
class Questions {
 public:
  Questions(bool has_a, bool has_b, std::vector<PictureMeasure>& out)
      : has_a_(has_a), has_b_(has_b), out_(out) {}

  bool in_both() const { return has_a_ && has_b_; }
  void answer(const std::string& name, const std::string& unit, double value,
              Decides decides = Decides::no, double limit = 0.0) {
    PictureMeasure measure{name, unit, value};
    if (decides != Decides::no) measure.limit = limit;
    if (has_a_ != has_b_ || (in_both() && !std::isfinite(value))) {
      measure.verdict = Verdict::not_measured;
    } else if (in_both()) {
      const bool good =
          decides == Decides::no || (decides == Decides::at_most ? value <= limit : value >= limit);
      measure.verdict = good ? Verdict::pass : Verdict::fail;
    }
    out_.push_back(std::move(measure));
  }

 private:
  bool has_a_, has_b_;
  std::vector<PictureMeasure>& out_;
};

void compare_colors(const render::Frame& a, const render::Frame& b, const PictureLimits& limits,
                    FrameDifference& out) {
  const ImageView left = view_of(a, "R", 3), right = view_of(b, "R", 3);
  const ImageView left_variance = view_of(a, "variance.R", 3),
                  right_variance = view_of(b, "variance.R", 3);
  Questions questions(left.channels > 0, right.channels > 0, out.measures);
  PerceptualDifference display;
  if (questions.in_both()) {
    out.picture = perceptual_difference_hdr(left, right);
    display = perceptual_difference(left, right);
    if (left_variance.channels > 0 && right_variance.channels > 0) {
      // The variance layers have three channels, colours may have four.
      const auto colors = [](const ImageView& image) {
        std::vector<float> data;
        data.reserve(image.pixel_count() * 3);
        for (std::size_t p = 0; p < image.pixel_count(); ++p)
          for (int c = 0; c < 3; ++c) data.push_back(image.data[p * image.channels + c]);
        return data;
      };
      const std::vector<float> first = colors(left), second = colors(right);
      out.noise = noise_test({left.width, left.height, 3, first}, left_variance,
                             {right.width, right.height, 3, second}, right_variance);
    }
  }
  const Decides decides = out.noise ? Decides::no : Decides::at_most;
  questions.answer("perceptual_hdr_mean", "", out.picture.mean, decides, limits.perceptual);
  questions.answer("perceptual_hdr_largest", "", out.picture.largest);
  questions.answer("perceptual_mean", "", display.mean);
  questions.answer("perceptual_largest", "", display.largest);
  if (out.noise) {
    PictureMeasure within{"within_noise", "share", out.noise->passed, 0.9975};
    within.verdict = !std::isfinite(out.noise->passed) ? Verdict::not_measured
                     : out.noise->alike                ? Verdict::pass
                                                       : Verdict::fail;
    out.measures.push_back(within);
  }
}

void compare_normals(const render::Frame& a, const render::Frame& b, const PictureLimits& limits,
                     FrameDifference& out) {
  const ImageView left = view_of(a, "N.X", 3), right = view_of(b, "N.X", 3);
  Questions questions(left.channels > 0, right.channels > 0, out.measures);
  PixelStatistics angle;
  if (questions.in_both()) angle = normal_difference(left, right).statistics;
  questions.answer("normal_mean", "deg", angle.mean, Decides::at_most, limits.normal_deg);
  questions.answer("normal_p999", "deg", angle.p999);
  questions.answer("normal_largest", "deg", angle.largest);
}

/// Where the figure is: by its matte where there is one, for a backdrop has alpha, too; else by
/// alpha. Nothing where neither is there.
std::optional<Mask> figure_of(const render::Frame& frame) {
  const ImageView matte = view_of(frame, "CryptoAsset00.r", 2);
  if (matte.channels > 0) {
    Mask mask{frame.width, frame.height, std::vector<std::uint8_t>(matte.pixel_count())};
    for (std::size_t p = 0; p < mask.inside.size(); ++p) {
      const float* id_and_share = matte.data.data() + p * matte.channels;
      mask.inside[p] = id_and_share[0] != 0.0f && id_and_share[1] >= 0.5f;
    }
    return mask;
  }
  const ImageView color = view_of(frame, "R", 4);
  if (color.channels == 0) return std::nullopt;
  return silhouette(color, 3);
}

void compare_silhouettes(const render::Frame& a, const render::Frame& b,
                         const PictureLimits& limits, FrameDifference& out) {
  const std::optional<Mask> first = figure_of(a), second = figure_of(b);
  // Two pictures of nothing, or of nothing else, have no silhouette to ask about.
  const std::size_t all = static_cast<std::size_t>(a.width) * a.height;
  const bool nothing = first && second && first->count() == second->count() &&
                       (first->count() == 0 || first->count() == all);
  double shared = kNan;
  OutlineDistance distance{kNan, kNan, -1, -1};
  if (first && second && !nothing) {
    shared = overlap(*first, *second);
    distance = outline_distance(*first, *second);
  }
  Questions questions(first && !nothing, second && !nothing, out.measures);
  // Sampling noise takes single pixels to either side of half covered: the outline is then known to
  // a pixel, and what share of a figure that is depends on its size alone.
  questions.answer("silhouette_overlap", "share", shared,
                   out.noise ? Decides::no : Decides::at_least, limits.overlap);
  questions.answer("outline_p95", "px", distance.most, Decides::at_most,
                   out.noise ? std::max(1.0, limits.outline_px) : limits.outline_px);
  questions.answer("outline_largest", "px", distance.largest);
}

/// The view angle of a pixel, radians: what neighbouring pixels of surface that faces the camera
/// are apart, over their depth. NaN where there are none.
double pixel_angle_of(const ImageView& position, const ImageView& depth, const Mask& figure) {
  std::vector<double> angle;
  for (int y = 0; y < position.height; ++y)
    for (int x = 0; x + 1 < position.width; ++x) {
      const std::size_t p = static_cast<std::size_t>(y) * position.width + x;
      if (figure.inside[p] == 0 || figure.inside[p + 1] == 0) continue;
      const double step = std::hypot(position.at(x + 1, y, 0) - position.at(x, y, 0),
                                     position.at(x + 1, y, 1) - position.at(x, y, 1),
                                     position.at(x + 1, y, 2) - position.at(x, y, 2));
      if (depth.at(x, y, 0) > 0.0f) angle.push_back(step / depth.at(x, y, 0));
    }
  if (angle.empty()) return kNan;
  const auto tenth = angle.begin() + static_cast<std::ptrdiff_t>(angle.size() / 10);
  std::ranges::nth_element(angle, tenth);
  return *tenth;
}

/// What 99.9 % of the figure is less curved than, radians per unit; NaN where the layers for it are
/// not there.
double curvature_of(const render::Frame& frame) {
  const ImageView position = view_of(frame, "P.X", 3), normal = view_of(frame, "N.X", 3),
                  depth = view_of(frame, "Z", 1);
  const std::optional<Mask> figure = figure_of(frame);
  if (position.channels == 0 || normal.channels == 0 || depth.channels == 0 || !figure) return kNan;
  const std::vector<float> number(figure->inside.begin(), figure->inside.end());
  return surface_curvature(position, normal, {frame.width, frame.height, 1, number}, depth,
                           pixel_angle_of(position, depth, *figure))
      .statistics.p999;
}

void compare_curvatures(const render::Frame& a, const render::Frame& b, FrameDifference& out) {
  const double first = curvature_of(a), second = curvature_of(b);
  // A picture of something flat has no share to give.
  Questions questions(first > 0.0, second > 0.0, out.measures);
  if (questions.in_both()) questions.answer("curvature_b_over_a", "ratio", second / first);
}

}  // namespace

Verdict FrameDifference::verdict() const {
  if (identical) return Verdict::pass;
  bool any = false, gap = false;
  for (const PictureMeasure& measure : measures) {
    if (measure.verdict == Verdict::fail) return Verdict::fail;
    gap = gap || measure.verdict == Verdict::not_measured;
    any = any || measure.verdict == Verdict::pass;
  }
  return gap || !any ? Verdict::not_measured : Verdict::pass;
}

FrameDifference frame_difference(const render::Frame& a, const render::Frame& b,
                                 const PictureLimits& limits) {
  if (a.width != b.width || a.height != b.height)
    throw ImageError("pictures of " + std::to_string(a.width) + "x" + std::to_string(a.height) +
                     " and " + std::to_string(b.width) + "x" + std::to_string(b.height) +
                     " pixels cannot be compared");
  FrameDifference out;
  const std::vector<std::string> in_a = channel_names(a), in_b = channel_names(b);
  std::ranges::set_difference(in_a, in_b, std::back_inserter(out.only_a));
  std::ranges::set_difference(in_b, in_a, std::back_inserter(out.only_b));
  out.identical = out.only_a.empty() && out.only_b.empty() && same_bits(a, b);
  compare_colors(a, b, limits, out);
  compare_normals(a, b, limits, out);
  compare_silhouettes(a, b, limits, out);
  compare_curvatures(a, b, out);
  return out;
}

}  // namespace backbend::validate
