#include "validate/evidence/image_readings.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "skin/anatomy/anatomy.h"
#include "validate/metrics/image/image.h"
#include "validate/metrics/math/median.h"
#include "validate/metrics/math/rotation.h"

namespace backbend::validate {
namespace {

/// Small enough for every pose of a night, large enough that a hand is some pixels wide.
constexpr int kWidth = 320, kHeight = 240;
constexpr std::array<std::string_view, 3> kCameras = {"profile", "front", "three_quarter"};

render::Settings primary_settings() {
  render::Settings settings;
  settings.width = kWidth;
  settings.height = kHeight;
  settings.samples = 1;
  settings.mode = render::Mode::primary;
  settings.ground = false;
  settings.rest_and_motion = true;
  settings.mattes = false;  // of one hit a pixel, objectId says all that they would
  settings.object_id = true;
  settings.threads = 1;  // poses go side by side
  return settings;
}

ImageView view_of(const render::Frame& frame, std::string_view first_channel) {
  const render::Layer* layer = frame.find(first_channel);
  if (layer == nullptr) return {};
  return {frame.width, frame.height, static_cast<int>(layer->names.size()), layer->data};
}

Mask figure(const render::Frame& frame) { return silhouette(view_of(frame, "R"), 3); }

/// The region of each pixel: 1 more than its number, 0 where the figure is not.
ImageView regions(const render::Frame& frame) { return view_of(frame, "objectId"); }

/// Pixels that show a region.
Mask region(const render::Frame& frame, skin::Region shown) {
  const ImageView ids = regions(frame);
  const float id = 1.0f + static_cast<float>(shown);
  Mask mask{frame.width, frame.height, std::vector<std::uint8_t>(ids.pixel_count(), 0)};
  for (std::size_t i = 0; i < mask.inside.size(); ++i) mask.inside[i] = ids.data[i] == id ? 1 : 0;
  return mask;
}

glm::dvec2 centre(const Mask& mask) {
  const std::vector<float> coverage(mask.inside.begin(), mask.inside.end());
  return matte_centre({mask.width, mask.height, 1, coverage}, 0);
}

double region_shift(const render::Frame& a, const render::Frame& b, skin::Region shown) {
  const Mask mask_a = region(a, shown), mask_b = region(b, shown);
  const double by_centre = glm::distance(centre(mask_a), centre(mask_b));  // NaN: seen in one only
  const double by_outline = outline_distance(mask_a, mask_b).most;
  return std::isnan(by_centre) || std::isnan(by_outline) ? std::numeric_limits<double>::quiet_NaN()
                                                         : std::max(by_centre, by_outline);
}

constexpr int kBins = 16;  // of the torso, hips to chest
/// Fewer pixels give no steady mean.
constexpr double kFewestPixels = 48.0;

/// The torso's pixels by their height on the body at rest.
struct TorsoProfile {
  std::array<double, kBins> pixels{};
  std::array<glm::dvec3, kBins> normal{};  // mean, unit; zero where there are too few pixels
};

TorsoProfile torso_profile(const PoseViews& views, const render::Frame& frame) {
  const Mask torso = region(frame, skin::Region::torso);
  const ImageView normal = view_of(frame, "N.X"), rest = view_of(frame, "Pref.X");
  const glm::dvec3 along = views.chest - views.hips;
  const double length = glm::dot(along, along);
  TorsoProfile out;
  for (std::size_t i = 0; i < torso.inside.size(); ++i) {
    if (torso.inside[i] == 0) continue;
    const float *r = rest.data.data() + 3 * i, *n = normal.data.data() + 3 * i;
    const double s = glm::dot(glm::dvec3(r[0], r[1], r[2]) - views.hips, along) / length;
    if (!(s >= 0.0 && s < 1.0)) continue;
    const auto bin = static_cast<std::size_t>(s * kBins);
    out.pixels[bin] += 1.0;
    out.normal[bin] += glm::dvec3(n[0], n[1], n[2]);
  }
  for (std::size_t b = 0; b < kBins; ++b) {
    const double size = glm::length(out.normal[b]);
    out.normal[b] =
        out.pixels[b] >= kFewestPixels && size > 0.0 ? out.normal[b] / size : glm::dvec3(0.0);
  }
  return out;
}

/// The turn from one unit vector to another as a rotation vector, degrees.
glm::dvec3 tilt(const glm::dvec3& from, const glm::dvec3& to) {
  const glm::dvec3 axis = glm::cross(from, to);
  const double sine = glm::length(axis);
  if (!(sine > 0.0)) return glm::dvec3(0.0);
  return axis * (degrees(std::atan2(sine, glm::dot(from, to))) / sine);
}

struct BinReading {
  double value = std::numeric_limits<double>::quiet_NaN();
  double pixels = 0.0;

  void offer(double other, double count) {
    if (std::isnan(other) || other <= value) return;
    value = other;
    pixels = count;
  }
};

BinReading largest_tilt_jump(const TorsoProfile& posed, const TorsoProfile& clean) {
  BinReading out;
  const auto seen = [&](std::size_t b) {
    return glm::length(posed.normal[b]) > 0.0 && glm::length(clean.normal[b]) > 0.0;
  };
  const auto pair = [&](std::size_t b) {  // of two bins
    return 0.5 * (tilt(clean.normal[b], posed.normal[b]) +
                  tilt(clean.normal[b + 1], posed.normal[b + 1]));
  };
  for (std::size_t b = 0; b + 5 <= kBins; ++b) {
    if (!seen(b) || !seen(b + 1) || !seen(b + 3) || !seen(b + 4)) continue;
    out.offer(glm::distance(pair(b), pair(b + 3)), posed.pixels[b + 2]);
  }
  return out;
}

BinReading largest_narrowing(const TorsoProfile& posed, const TorsoProfile& clean) {
  BinReading out;
  for (std::size_t b = 0; b < kBins; ++b)
    if (clean.pixels[b] >= kFewestPixels)
      out.offer(100.0 * (1.0 - posed.pixels[b] / clean.pixels[b]),
                std::abs(clean.pixels[b] - posed.pixels[b]));
  return out;
}

/// A layer that says where a pixel's surface was, as how far it has moved since.
std::vector<float> moved(const render::Frame& frame) {
  const ImageView motion = view_of(frame, "motion.X");
  std::vector<float> out(motion.data.begin(), motion.data.end());
  for (float& value : out) value = -value;
  return out;
}

/// Places at rest that are nearer than this count as the same spot of the surface: some pixels.
double near_at_rest(const PoseViews& views) {
  return 0.12 * glm::distance(views.hips, views.chest);
}

bool same_spot(const ImageView& a, int ax, int ay, const ImageView& b, int bx, int by,
               double near) {
  double square = 0.0;
  for (int c = 0; c < 3; ++c) {
    const double step = a.at(ax, ay, c) - b.at(bx, by, c);
    square += step * step;
  }
  return square < near * near;
}

/// The regions of a picture without its inner edges, where one part of a surface ends before
/// another: what lies behind moves otherwise.
std::vector<float> whole_regions(const PoseViews& views, const render::Frame& frame) {
  const double near = near_at_rest(views);
  const ImageView region = regions(frame), rest = view_of(frame, "Pref.X");
  std::vector<float> out(region.pixel_count(), 0.0f);
  for (int y = 0; y < frame.height; ++y)
    for (int x = 0; x < frame.width; ++x) {
      if (region.at(x, y, 0) == 0.0f) continue;  // most of the picture is no figure
      bool whole = true;
      for (int v = std::max(0, y - 1); v <= std::min(frame.height - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(frame.width - 1, x + 1); ++u)
          whole = whole && same_spot(rest, x, y, rest, u, v, near);
      if (whole) out[static_cast<std::size_t>(y) * frame.width + x] = region.at(x, y, 0);
    }
  return out;
}

/// Those of `now` where `before` shows the same spot of the surface; 0 where something else was in
/// front of it.
std::vector<float> seen_before(const PoseViews& views, const render::Frame& before,
                               const render::Frame& now, const ImageView& now_moved) {
  const ImageView rest = view_of(now, "Pref.X"), rest_before = view_of(before, "Pref.X");
  std::vector<float> out = whole_regions(views, now);
  for (int y = 0; y < now.height; ++y)
    for (int x = 0; x < now.width; ++x) {
      float& shown = out[static_cast<std::size_t>(y) * now.width + x];
      if (shown == 0.0f) continue;
      const auto u = static_cast<int>(std::lround(x - now_moved.at(x, y, 0)));
      const auto v = static_cast<int>(std::lround(y - now_moved.at(x, y, 1)));
      const bool seen = u >= 0 && v >= 0 && u < now.width && v < now.height &&
                        same_spot(rest, x, y, rest_before, u, v, near_at_rest(views));
      if (!seen) shown = 0.0f;
    }
  return out;
}

double lengths_p99(const render::Frame& frame, double* visible) {
  const std::vector<float> motion = moved(frame);
  const ImageView region = regions(frame);
  std::vector<double> length;
  for (std::size_t i = 0; i < region.pixel_count(); ++i)
    if (region.data[i] != 0.0f) length.push_back(std::hypot(motion[2 * i], motion[2 * i + 1]));
  if (length.empty()) return std::numeric_limits<double>::quiet_NaN();
  *visible = static_cast<double>(
      std::ranges::count_if(length, [](double each) { return each > kVisibleMotionPx; }));
  const auto at = length.begin() + static_cast<std::ptrdiff_t>(0.99 * double(length.size() - 1));
  std::ranges::nth_element(length, at);
  return *at;
}

/// The view that reads the most. NaN readings are skipped.
template <typename Read>
ImageReading largest(const PoseViews& views, Read read) {
  ImageReading out;
  for (std::size_t i = 0; i < views.view.size(); ++i) {
    double pixels = 0.0;
    const double value = read(i, pixels);
    if (std::isnan(value) || value <= out.value) continue;
    out = {value, views.view[i].camera, pixels};
  }
  return out;
}

/// A pixel whose normal turned by more is seen to change (research/reports.md 1.2, first step).
constexpr float kVisibleTurnDeg = 5.0f;

/// Pixels whose normal differs visibly.
double turned_pixels(const NormalDifference& turned) {
  return static_cast<double>(
      std::ranges::count_if(turned.map, [](float angle) { return angle > kVisibleTurnDeg; }));
}
double turned_pixels(const render::Frame& a, const render::Frame& b) {
  return turned_pixels(normal_difference(view_of(a, "N.X"), view_of(b, "N.X")));
}

}  // namespace

double view_pixel(const render::Bounds& box) { return glm::length(box.high - box.low) / kHeight; }

PoseViews take_views(Photographer& photographer, const PosedCharacter& posed,
                     const PosedCharacter* previous) {
  static const render::Settings settings = primary_settings();
  const std::vector<glm::dvec3>& joint = photographer.stage().rest_chain().joint;
  photographer.pose(posed, {}, previous);
  PoseViews out;
  out.hips = joint.front();
  out.chest = joint.back();
  for (const std::string_view camera : kCameras)
    out.view.push_back({camera, photographer.shoot(camera, settings)});
  return out;
}

ImageReading normal_change(const PoseViews& a, const PoseViews& b) {
  return largest(a, [&](std::size_t i, double& pixels) {
    const NormalDifference turned =
        normal_difference(view_of(a.view[i].frame, "N.X"), view_of(b.view[i].frame, "N.X"));
    pixels = turned_pixels(turned);
    return turned.statistics.mean;
  });
}

ImageReading motion(const PoseViews& views) {
  return largest(views, [&](std::size_t i, double& pixels) {
    return lengths_p99(views.view[i].frame, &pixels);
  });
}

ImageReading motion_change(const PoseViews& before, const PoseViews& now) {
  return largest(now, [&](std::size_t i, double& pixels) {
    const render::Frame &a = before.view[i].frame, &b = now.view[i].frame;
    const std::vector<float> was = moved(a), is = moved(b);
    const ImageView now_moved{b.width, b.height, 2, is};
    const std::vector<float> whole = whole_regions(before, a),
                             seen = seen_before(before, a, b, now_moved);
    const PixelStatistics left =
        motion_residual({a.width, a.height, 2, was}, now_moved, now_moved,
                        {a.width, a.height, 1, whole}, {b.width, b.height, 1, seen}, 2);
    pixels = static_cast<double>(left.count);
    return left.p99;
  });
}

ImageReading tilt_jump(const PoseViews& posed, const PoseViews& clean, std::string_view camera) {
  return largest(posed, [&](std::size_t i, double& pixels) {
    if (!camera.empty() && posed.view[i].camera != camera)
      return std::numeric_limits<double>::quiet_NaN();
    const BinReading found = largest_tilt_jump(torso_profile(posed, posed.view[i].frame),
                                               torso_profile(clean, clean.view[i].frame));
    pixels = found.pixels;
    return found.value;
  });
}

ImageReading narrowing(const PoseViews& posed, const PoseViews& clean) {
  return largest(posed, [&](std::size_t i, double& pixels) {
    const BinReading found = largest_narrowing(torso_profile(posed, posed.view[i].frame),
                                               torso_profile(clean, clean.view[i].frame));
    pixels = found.pixels;
    return found.value;
  });
}

ImageReading arm_shift(const PoseViews& posed, const PoseViews& carried) {
  return largest(posed, [&](std::size_t i, double& pixels) {
    const render::Frame &a = posed.view[i].frame, &b = carried.view[i].frame;
    pixels = turned_pixels(a, b);
    // fmax: where no camera sees one arm (NaN), the other counts.
    return std::fmax(region_shift(a, b, skin::Region::arm_left),
                     region_shift(a, b, skin::Region::arm_right));
  });
}

ImageReading outline_shift(const PoseViews& a, const PoseViews& b) {
  ImageReading out = largest(a, [&](std::size_t i, double&) {
    return outline_distance(figure(a.view[i].frame), figure(b.view[i].frame)).most;
  });
  for (std::size_t i = 0; i < a.view.size(); ++i)
    if (a.view[i].camera == out.camera)
      out.pixels = turned_pixels(a.view[i].frame, b.view[i].frame);
  return out;
}

std::vector<double> pop_scores(std::span<const double> change) {
  constexpr std::size_t kFirst = 2, kFewest = 10;
  std::vector<double> out(change.size(), 0.0);
  if (change.size() < kFirst + kFewest) return out;
  std::vector<double> excess;
  for (std::size_t i = kFirst; i < change.size(); ++i) {
    const std::size_t first = std::max(kFirst, i - 2), end = std::min(i + 3, change.size());
    std::vector<double> around(change.begin() + static_cast<std::ptrdiff_t>(first),
                               change.begin() + static_cast<std::ptrdiff_t>(end));
    excess.push_back(change[i] - upper_median(around));
  }
  std::ranges::copy(robust_scores(excess, kLeastPopPx / kPopScore),
                    out.begin() + static_cast<std::ptrdiff_t>(kFirst));
  return out;
}

}  // namespace backbend::validate
