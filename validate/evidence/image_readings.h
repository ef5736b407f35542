#pragma once
#include <array>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "validate/camera/photographer.h"

namespace backbend::validate {

// What small pictures say about a pose. Every reading looks at pixels only: no joint, no finding
// and no figure of geometry reaches it.

/// One pose as image metrics see it: first hits only, 320x240 pixels, from three sides.
struct PoseViews {
  struct View {
    std::string_view camera;
    render::Frame frame;
  };
  std::vector<View> view;  // always the same cameras in the same order; empty: not looked at
  // The rest line from hips to chest, by which the layer Pref says how high on the torso a pixel
  // is.
  glm::dvec3 hips{0.0}, chest{0.0};
};
/// `previous`, the pose before in a sweep, gives the pictures their motion layer; null: none.
PoseViews take_views(Photographer& photographer, const PosedCharacter& posed,
                     const PosedCharacter* previous = nullptr);
/// About the most that one of their pixels spans on the figure, for cameras that see this box.
double view_pixel(const render::Bounds& box);

/// The largest reading over the cameras that can tell.
struct ImageReading {
  double value = std::numeric_limits<double>::quiet_NaN();  // NaN: no camera can tell
  std::string_view camera;
  double pixels = 0.0;  // that show it, in that camera
};

/// Mean angle between the normal layers, degrees, over the pixels that show a surface in both.
ImageReading normal_change(const PoseViews& a, const PoseViews& b);
/// How far the picture's surface has moved since the pose before, pixels: 99 of 100 pixels by less.
/// Needs the motion layer.
ImageReading motion(const PoseViews& views);
/// What is left of the motion once each pixel's motion a pose earlier is taken off, pixels, 99 of
/// 100 by less. Both need their motion layers.
ImageReading motion_change(const PoseViews& before, const PoseViews& now);
/// A bend sharper than the clean rig's: by how many degrees the tilt of the torso's surface against
/// the clean picture's changes from one eighth of the spine to the next but one. Smooth differences
/// between two rigs change slowly along the spine; a kink does not. `camera`: only this one looks;
/// empty: the one that sees most.
ImageReading tilt_jump(const PoseViews& posed, const PoseViews& clean,
                       std::string_view camera = {});
/// How much narrower the torso is than in the clean picture where it is worst, percent of its
/// width.
ImageReading narrowing(const PoseViews& posed, const PoseViews& clean);
/// How far either arm's matte has moved between the pictures, pixels: by its centre or by 95 of 100
/// points of its outline, whichever is more.
ImageReading arm_shift(const PoseViews& posed, const PoseViews& carried);
/// How far the figure's outline has moved, pixels: 95 of 100 of its points by less.
ImageReading outline_shift(const PoseViews& a, const PoseViews& b);

/// How far each step of a sweep stands out: its motion_change() less the median of the five steps
/// around it, in robust standard deviations of the whole sweep (research/reports.md 1.3). One value
/// a pose; the first two have no motion to change and score 0, as do sweeps of fewer than ten
/// others, which tell nothing about themselves. Steps whose excess is below kLeastPopPx score
/// below kPopScore, however quiet the sweep.
std::vector<double> pop_scores(std::span<const double> change);

// From where on each reading is called visible. Above what clean rigs show on real characters:
// docs/calibration.md, the rows of pictures.
inline constexpr double kPopScore = 8.0;
inline constexpr double kLeastPopPx = 0.25;
inline constexpr double kVisibleMotionPx = 0.5;
inline constexpr double kVisibleTiltDeg = 4.0;
inline constexpr double kVisibleNarrowing = 10.0;
inline constexpr double kVisibleArmPx = 0.5;

}  // namespace backbend::validate
