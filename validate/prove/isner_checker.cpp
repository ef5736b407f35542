#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "solver/math/interval.h"
#include "validate/prove/claim_checker.h"
#include "validate/prove/moving_curve.h"
#include "validate/prove/moving_pose.h"
#include "validate/prove/proof.h"

namespace backbend::validate {
namespace {

using solver::Interval;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// sin(t h) / sin(h) and its derivative by c = cos(h), both monotone in c on 0 < c <= 1.
struct Share {
  Interval value, slope;
};
Share share_of(const Interval& c, double t) {
  // Closer to 1 the formulas lose digits; the limits at c = 1 bound from the other side.
  constexpr double kNear = 0.999;
  const auto value = [&](double at) {
    const Interval h = solver::arc_cosine(at);
    return sine(Interval(t) * h) / sine(h);
  };
  const auto slope = [&](double at) {
    const Interval h = solver::arc_cosine(at);
    return (value(at) * Interval(at) - Interval(t) * cosine(Interval(t) * h)) / square(sine(h));
  };
  const Interval limit_slope =
      -(Interval(t) * (Interval(1.0) - square(Interval(t))) / Interval(3.0));
  const double low = std::min(c.lo, kNear);
  Share share;
  share.value = {c.hi > kNear ? t : value(c.hi).lo, value(low).hi};
  share.slope = {slope(low).lo, c.hi > kNear ? limit_slope.hi : slope(c.hi).hi};
  return share;
}

/// A unit quaternion w, x, y, z.
using Quaternion = std::array<Interval, 4>;

/// Rz Ry Rx of half angles' sines and cosines, by x, y, z.
Quaternion product(const Vec& s, const Vec& c) {
  return {c[2] * c[1] * c[0] + s[2] * s[1] * s[0], c[2] * c[1] * s[0] - s[2] * s[1] * c[0],
          c[2] * s[1] * c[0] + s[2] * c[1] * s[0], s[2] * c[1] * c[0] - c[2] * s[1] * s[0]};
}

/// Where Y goes by a unit quaternion: 1 - 2 (x^2 + z^2) along Y.
Vec y_turned(const Quaternion& q) {
  const Interval two(2.0);
  return {two * (q[1] * q[2] - q[0] * q[3]), Interval(1.0) - two * (square(q[1]) + square(q[3])),
          two * (q[2] * q[3] + q[0] * q[1])};
}
/// Its derivative as q moves by d.
Vec y_turned_slope(const Quaternion& q, const Quaternion& d) {
  const Interval two(2.0);
  return {two * (d[1] * q[2] + q[1] * d[2] - d[0] * q[3] - q[0] * d[3]),
          Interval(-4.0) * (q[1] * d[1] + q[3] * d[3]),
          two * (d[2] * q[3] + q[2] * d[3] + d[0] * q[1] + q[0] * d[1])};
}

class IsnerChecker final : public ClaimChecker {
 public:
  IsnerChecker(const ProofQuestion& q, const solver::SpineSystem& system)
      : fraction_(system.arc_fraction()), legs_(q, depth_of(system)) {
    const auto& options = system.options();
    const auto word = [&](const char* key) { return std::get<std::string>(options.at(key)); };
    check_body_channels(q);
    if (word("aim") != "project") checker_knows(q, "aim = \"project\" only");
    if (word("slerp") != "shortest") checker_knows(q, "slerp = \"shortest\" only");
    fixed_ = word("length") == "fixed";
    varies_ = varying_channels(q.box);
  }

  double gain_over(const SubBox& part) const override {
    const MovingChannels channels(part);
    // Channels in the order extension, side, twist are -rz, -ry, rx.
    constexpr std::size_t kEuler[3] = {2, 1, 0};
    constexpr double kSign[3] = {-1.0, -1.0, 1.0};
    Vec angle, middle;
    for (std::size_t j = 0; j < 3; ++j) {
      angle[kEuler[j]] = Interval(kSign[j]) * channels.angle[j].value;
      middle[kEuler[j]] = Interval(kSign[j]) * channels.angle[j].center;
    }
    Turned box, center;
    if (!turn(angle, box) || !turn(middle, center)) return kInfinite;
    const MovingCurve curve(legs_.over(channels), channels.reach, kPanels);
    if (!curve.length().value.is_finite()) return kInfinite;
    glm::dmat3 axes = legs_.axes();
    double most = 0.0;
    for (const double t : fraction_) {
      const auto place = place_at(curve, t);
      if (!place) return kInfinite;
      axes = axes_along(curve.velocity_about(*place), axes);
      const MovingVector x = unit(curve.velocity(*place, axes));
      MovingVector up;
      std::array<Vec, 3> by_euler;
      raise(center, t, up.center, by_euler);
      raise(box, t, up.value, by_euler);
      for (std::size_t j = 0; j < 3; ++j) up.by[j] = Interval(kSign[j]) * by_euler[kEuler[j]];
      sharpen(up, channels.reach);
      up = on_axes(axes, from_axes(legs_.axes(), up));
      MovingVector side = cross(x, up);
      sharpen(side, channels.reach);
      const Interval sine = size(side.value);
      const Vec y = cross(Interval(1.0) / sine * side.value, x.value);
      for (std::size_t j = 0; j < 3; ++j) {
        if (!varies_[j]) continue;
        const Interval about = dot(y, side.by[j]) / sine;
        const Interval gain = square_root(size_squared(x.by[j]) + square(about));
        if (!gain.is_finite()) return kInfinite;
        most = std::max(most, gain.hi);
      }
    }
    return most * (1.0 + 1e-12);
  }

 private:
  static constexpr int kPanels = 32;

  static std::vector<double> depth_of(const solver::SpineSystem& system) {
    return std::get<std::vector<double>>(system.options().at("depth"));
  }

  /// The chest control's turn in its own axes, and its derivatives by the Euler angles x, y, z.
  struct Turned {
    Quaternion turn;
    std::array<Quaternion, 3> by;
  };

  static bool turn(const Vec& angle, Turned& p) {
    Vec hs, hc;
    for (std::size_t k = 0; k < 3; ++k) {
      hs[k] = sine(Interval(0.5) * angle[k]);
      hc[k] = cosine(Interval(0.5) * angle[k]);
    }
    p.turn = product(hs, hc);
    for (std::size_t k = 0; k < 3; ++k) {
      Vec ds = hs, dc = hc;
      ds[k] = Interval(0.5) * hc[k];
      dc[k] = Interval(-0.5) * hs[k];
      p.by[k] = product(ds, dc);
    }
    if (p.turn[0].hi < 0.0) {  // the same turn, the shorter way
      for (Interval& part : p.turn) part = -part;
      for (Quaternion& by : p.by)
        for (Interval& part : by) part = -part;
    }
    return p.turn[0].lo > 0.0;  // else there may be two shortest ways
  }

  /// Y turned by the t-th part of the chest's turn.
  static void raise(const Turned& turned, double t, Vec& up, std::array<Vec, 3>& up_by) {
    const auto& [q, by] = turned;
    if (t == 1.0) {
      up = y_turned(q);
      for (std::size_t k = 0; k < 3; ++k) up_by[k] = y_turned_slope(q, by[k]);
      return;
    }
    const Interval c(q[0].lo, std::min(1.0, q[0].hi));
    const Share share = share_of(c, t);
    const Interval cos_part = cosine(Interval(t) * solver::arc_cosine(c));
    const Quaternion part{cos_part, share.value * q[1], share.value * q[2], share.value * q[3]};
    up = y_turned(part);
    for (std::size_t k = 0; k < 3; ++k) {
      const Interval turned = share.slope * by[k][0];
      const Quaternion d{
          Interval(t) * share.value * by[k][0], turned * q[1] + share.value * by[k][1],
          turned * q[2] + share.value * by[k][2], turned * q[3] + share.value * by[k][3]};
      up_by[k] = y_turned_slope(part, d);
    }
  }

  std::optional<MovingCurve::Place> place_at(const MovingCurve& curve, double t) const {
    const MovingNumber &whole = curve.length(), rest(Interval(legs_.length()));
    if (t == 0.0) return curve.start();
    if (!fixed_ || whole.value.hi <= rest.value.lo)
      return t == 1.0 ? curve.end() : curve.place_at(Interval(t) * whole);
    if (whole.value.lo > rest.value.hi) return curve.place_at(Interval(t) * rest);
    // Either may be the shorter.
    MovingNumber used(smaller(whole.value, rest.value), smaller(whole.center, rest.center), {});
    for (std::size_t j = 0; j < 3; ++j) used.by[j] = hull(whole.by[j], 0.0);
    return curve.place_at(Interval(t) * used);
  }

  std::vector<double> fraction_;
  HipChestLegs legs_;
  bool fixed_ = true;
  std::array<bool, 3> varies_{};
};

}  // namespace

std::unique_ptr<ClaimChecker> isner_checker(const ProofQuestion& question,
                                            const solver::SpineSystem& system) {
  return std::make_unique<IsnerChecker>(question, system);
}

}  // namespace backbend::validate
