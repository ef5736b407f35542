#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "solver/math/interval.h"
#include "validate/prove/claim_checker.h"
#include "validate/prove/plane_curve.h"
#include "validate/prove/proof.h"

namespace backbend::validate {
namespace {

using solver::Interval;
using Vec = std::array<Interval, 3>;

constexpr double kInfinite = std::numeric_limits<double>::infinity();

Vec operator+(const Vec& a, const Vec& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Vec operator-(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec operator*(const Interval& f, const Vec& v) { return {f * v[0], f * v[1], f * v[2]}; }
Interval dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Interval size(const Vec& a) { return square_root(square(a[0]) + square(a[1]) + square(a[2])); }
Vec cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

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
      : fraction_(system.arc_fraction()) {
    const auto& options = system.options();
    const auto word = [&](const char* key) { return std::get<std::string>(options.at(key)); };
    const auto refuse = [](const std::string& why) {
      throw ProofError("isner: the checker knows " + why);
    };
    if (q.box.of_controls) refuse("body channels only, not the rig's own controls");
    if (q.mapping != solver::Mapping::chest) refuse("the mapping chest only");
    if (word("aim") != "project") refuse("aim = \"project\" only");
    if (word("slerp") != "shortest") refuse("slerp = \"shortest\" only");
    fixed_ = word("length") == "fixed";
    depth_ = std::get<std::vector<double>>(options.at("depth"));
    for (std::size_t j = 0; j < 3; ++j) varies_[j] = q.box.axis[j].varies();
  }

  double gain_over(const SubBox& part) const override {
    // Channels in the order extension, side, twist are -rz, -ry, rx.
    constexpr std::size_t kEuler[3] = {2, 1, 0};
    constexpr double kSign[3] = {-1.0, -1.0, 1.0};
    const Interval degree = solver::kPiInterval / Interval(180.0);
    Vec angle, radius, middle;
    for (std::size_t j = 0; j < 3; ++j) {
      const Interval range = Interval(part.low[j], part.high[j]) * degree;
      const double at = range.middle();
      angle[kEuler[j]] = kSign[j] < 0.0 ? -range : range;
      middle[kEuler[j]] = kSign[j] * at;
      radius[kEuler[j]] =
          hull(Interval(range.hi) - Interval(at), Interval(at) - Interval(range.lo)).hi;
    }
    Posed box;
    if (!pose(angle, box)) return kInfinite;
    Posed center;
    if (!pose(middle, center)) return kInfinite;
    // What the derivatives say of values is sharper than the values themselves.
    const auto sharpen = [&](Interval& value, const Interval& at,
                             const std::array<Interval, 3>& by) {
      Interval spread(0.0);
      for (std::size_t k = 0; k < 3; ++k) spread += Interval(by[k].most()) * radius[k];
      value = common(value, at + Interval(-spread.hi, spread.hi));
    };
    for (std::size_t i = 0; i < 3; ++i) {
      sharpen(box.chest[i], center.chest[i],
              {box.chest_by[0][i], box.chest_by[1][i], box.chest_by[2][i]});
    }
    const ChestCurve curve({depth_[0], depth_[1]}, box.chest[0]);
    double most = 0.0;
    for (const double t : fraction_) {
      const auto place = place_at(curve, t);
      if (!place) return kInfinite;
      Vec up, up_middle;
      std::array<Vec, 3> up_by;
      raise(center.turn, center.turn_by, t, up_middle, up_by);
      raise(box.turn, box.turn_by, t, up, up_by);
      for (std::size_t i = 0; i < 3; ++i) {
        sharpen(up[i], up_middle[i], {up_by[0][i], up_by[1][i], up_by[2][i]});
      }
      const Interval u = place->u, alpha = curve.alpha(u), beta = curve.beta(u);
      const Vec velocity = Vec{alpha, 0.0, 0.0} + beta * box.chest;
      const Interval speed = size(velocity);
      const Vec x = Interval(1.0) / speed * velocity;
      const Vec side = cross(x, up);
      const Interval sine = size(side);
      const Vec z = Interval(1.0) / sine * side, y = cross(z, x);
      for (std::size_t j = 0; j < 3; ++j) {
        if (!varies_[j]) continue;
        const std::size_t k = kEuler[j];
        const Interval u_by = place->slope * box.chest_by[k][0];
        const Vec velocity_by = Vec{curve.alpha_slope(u) * u_by, 0.0, 0.0} +
                                curve.beta_slope(u) * u_by * box.chest + beta * box.chest_by[k];
        const Interval along = dot(x, velocity_by);
        const Vec x_by = Interval(1.0) / speed * (velocity_by - along * x);
        const Vec side_by = cross(x_by, up) + cross(x, up_by[k]);
        const Interval about = dot(y, side_by) / sine;
        const Interval gain =
            square_root(square(x_by[0]) + square(x_by[1]) + square(x_by[2]) + square(about));
        if (!gain.is_finite()) return kInfinite;
        most = std::max(most, gain.hi);
      }
    }
    return most * (1.0 + 1e-12);
  }

 private:
  /// The chest control's turn, its X axis, and their derivatives by the Euler angles x, y, z.
  struct Posed {
    Quaternion turn;
    std::array<Quaternion, 3> turn_by;
    Vec chest;
    std::array<Vec, 3> chest_by;
  };

  static bool pose(const Vec& angle, Posed& p) {
    Vec s, c, hs, hc;
    for (std::size_t k = 0; k < 3; ++k) {
      s[k] = sine(angle[k]);
      c[k] = cosine(angle[k]);
      hs[k] = sine(Interval(0.5) * angle[k]);
      hc[k] = cosine(Interval(0.5) * angle[k]);
    }
    p.turn = product(hs, hc);
    for (std::size_t k = 0; k < 3; ++k) {
      Vec ds = hs, dc = hc;
      ds[k] = Interval(0.5) * hc[k];
      dc[k] = Interval(-0.5) * hs[k];
      p.turn_by[k] = product(ds, dc);
    }
    if (p.turn[0].hi < 0.0) {  // the same turn, the shorter way
      for (Interval& part : p.turn) part = -part;
      for (Quaternion& by : p.turn_by)
        for (Interval& part : by) part = -part;
    }
    p.chest = {c[2] * c[1], s[2] * c[1], -s[1]};
    p.chest_by[0] = {0.0, 0.0, 0.0};
    p.chest_by[1] = {-(c[2] * s[1]), -(s[2] * s[1]), -c[1]};
    p.chest_by[2] = {-(s[2] * c[1]), c[2] * c[1], 0.0};
    return p.turn[0].lo > 0.0;  // else there may be two shortest ways
  }

  /// Y turned by the t-th part of the chest's turn.
  static void raise(const Quaternion& q, const std::array<Quaternion, 3>& by, double t, Vec& up,
                    std::array<Vec, 3>& up_by) {
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

  std::optional<ChestCurve::Place> place_at(const ChestCurve& curve, double t) const {
    const ChestCurve::Length& whole = curve.whole();
    if (!whole.value.is_finite()) return std::nullopt;
    if (t == 0.0) return ChestCurve::Place{0.0, 0.0};
    const bool fits = !fixed_ || whole.value.hi <= 1.0, passes = fixed_ && whole.value.lo > 1.0;
    if (t == 1.0) {
      if (fits) return ChestCurve::Place{1.0, 0.0};
      auto place = curve.at({1.0, 1.0, 0.0});
      if (!place) return place;
      if (!passes) place->slope = hull(place->slope, 0.0);
      place->u = {std::min(1.0, place->u.lo), std::min(1.0, place->u.hi)};
      return place;
    }
    ChestCurve::Length used = whole;
    if (passes) used = {1.0, 1.0, 0.0};
    if (!fits && !passes) {
      used = {smaller(whole.value, 1.0), smaller(whole.center, 1.0), hull(whole.slope, 0.0)};
    }
    const Interval part(t);
    return curve.at({part * used.value, part * used.center, part * used.slope});
  }

  std::vector<double> fraction_, depth_;
  bool fixed_ = true;
  std::array<bool, 3> varies_{};
};

}  // namespace

std::unique_ptr<ClaimChecker> isner_checker(const ProofQuestion& question,
                                            const solver::SpineSystem& system) {
  return std::make_unique<IsnerChecker>(question, system);
}

}  // namespace backbend::validate
