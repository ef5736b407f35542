#include "solver/math/even_weight.h"

#include <algorithm>
#include <cassert>

namespace backbend::solver {

EvenWeight EvenWeight::trapezoid(double from, double to) {
  assert(0.0 <= from && from < to && to <= 1.0);
  const double ramp = (to - from) / 8.0;
  const double peak = 1.0 / (to - from - ramp);  // ramps hold half the area of the plateau's height
  const double low = 0.5 * peak * ramp;          // W at the end of the first ramp
  const double r2 = ramp * ramp, r3 = r2 * ramp;
  EvenWeight w;
  w.peak_ = peak;
  if (from > 0.0) w.piece_.push_back({0.0, {}});
  // Slope peak (3 x^2 - 2 x^3) with x = (s - from) / ramp, integrated.
  w.piece_.push_back({from, {0.0, 0.0, 0.0, peak / r2, -0.5 * peak / r3}});
  w.piece_.push_back({from + ramp, {low, peak, 0.0, 0.0, 0.0}});
  // Slope peak (1 - 3 x^2 + 2 x^3), x = (s - (to - ramp)) / ramp.
  w.piece_.push_back({to - ramp, {1.0 - low, peak, 0.0, -peak / r2, 0.5 * peak / r3}});
  if (to < 1.0) w.piece_.push_back({to, {1.0, 0.0, 0.0, 0.0, 0.0}});
  return w;
}

EvenWeight EvenWeight::from_density(std::span<const double> density) {
  assert(!density.empty());
  EvenWeight w;
  if (density.size() == 1) {
    w.piece_.push_back({0.0, {0.0, 1.0, 0.0, 0.0, 0.0}});
    w.peak_ = 1.0;
    return w;
  }
  const std::size_t last = density.size() - 1;
  const double step = 1.0 / double(last);
  double area = 0.0;
  for (std::size_t i = 0; i < last; ++i) area += 0.5 * step * (density[i] + density[i + 1]);
  assert(area > 0.0);
  double done = 0.0;
  for (std::size_t i = 0; i < last; ++i) {
    const double here = density[i] / area, next = density[i + 1] / area;
    w.piece_.push_back({double(i) * step, {done, here, 0.5 * (next - here) / step, 0.0, 0.0}});
    done += 0.5 * step * (here + next);
    w.peak_ = std::max({w.peak_, here, next});
  }
  return w;
}

const EvenWeight::Piece& EvenWeight::piece_at(double s) const {
  std::size_t i = piece_.size() - 1;
  while (i > 0 && s < piece_[i].from) --i;
  return piece_[i];
}

double EvenWeight::operator()(double s) const {
  if (s <= 0.0) return 0.0;
  if (s >= 1.0) return 1.0;
  const Piece& p = piece_at(s);
  const double x = s - p.from;
  const auto& c = p.coefficient;
  return std::clamp(c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * c[4]))), 0.0, 1.0);
}

double EvenWeight::slope(double s) const {
  if (s < 0.0 || s > 1.0) return 0.0;
  const Piece& p = piece_at(s);
  const double x = s - p.from;
  const auto& c = p.coefficient;
  return c[1] + x * (2.0 * c[2] + x * (3.0 * c[3] + x * 4.0 * c[4]));
}

double EvenWeight::peak_slope(double from, double to) const {
  // Between knots the slope rises, falls or stays. What it jumps by at one is rounding.
  double peak = std::max(slope(from), slope(to));
  for (const Piece& p : piece_) {
    if (p.from > from && p.from < to) peak = std::max(peak, slope(p.from));
  }
  return std::min(peak, peak_);
}

std::vector<double> EvenWeight::knots() const {
  std::vector<double> knot;
  for (const Piece& p : piece_) knot.push_back(p.from);
  knot.push_back(1.0);
  return knot;
}

}  // namespace backbend::solver
