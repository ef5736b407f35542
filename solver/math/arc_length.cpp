#include "solver/math/arc_length.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>

#include "solver/math/arc_lanes.h"
#include "solver/math/bezier.h"
#include "solver/math/lanes.h"

namespace backbend::solver {
namespace {

using glm::dvec3;

constexpr int kTerms = ArcPart::kTerms;
constexpr int kPairs = 8;  // 16 Gauss points, in pairs +-x
constexpr double kNode[kPairs] = {
    0.0950125098376374402, 0.2816035507792589132, 0.4580167776572273863, 0.6178762444026437484,
    0.7554044083550030339, 0.8656312023878317439, 0.9445750230732325761, 0.9894009349916499326};
constexpr double kWeight[kPairs] = {
    0.1894506104550684963, 0.1826034150449235889, 0.1691565193950025382, 0.1495959888165767321,
    0.1246289712555338721, 0.0951585116824927848, 0.0622535239386478929, 0.0271524594117540949};

/// What turns speeds at the nodes into the arc length's coefficients. Even Legendre terms see only
/// the sums of a pair of speeds, odd ones only the differences.
struct Tables {
  double even_term[kTerms][kPairs];  // [k / 2][pair]: Legendre coefficient k of the speed
  double odd_term[kTerms][kPairs];   // [(k - 1) / 2][pair]
  double to_odd[kTerms][kTerms];     // [power][k / 2]: integral of P_k, k even, by x, x^3, ..
  double to_even[kTerms][kTerms];    // [power][(k - 1) / 2]: k odd, by x^2, x^4, ..

  Tables() {
    for (int i = 0; i < kPairs; ++i) {
      double before = 0.0, p = 1.0;
      for (int k = 0; k < 2 * kTerms; ++k) {
        double& term = k % 2 ? odd_term[k / 2][i] : even_term[k / 2][i];
        term = 0.5 * (2 * k + 1) * kWeight[i] * p;
        const double next = ((2 * k + 1) * kNode[i] * p - k * before) / (k + 1);
        before = p;
        p = next;
      }
    }
    // Coefficients of P_k by powers of x, from the three-term recurrence.
    double p[2 * kTerms][2 * kTerms + 1] = {};
    p[0][0] = 1.0;
    p[1][1] = 1.0;
    for (int k = 1; k + 1 < 2 * kTerms; ++k) {
      for (int d = 0; d <= k; ++d) {
        p[k + 1][d + 1] += (2 * k + 1) * p[k][d] / (k + 1);
        p[k + 1][d] -= k * p[k - 1][d] / (k + 1);
      }
    }
    for (int k = 0; k < 2 * kTerms; ++k) {
      for (int power = 0; power < kTerms; ++power) {
        const int d = 2 * power + k % 2;  // the term that integrates to x^(d + 1)
        double& term = k % 2 ? to_even[power][k / 2] : to_odd[power][k / 2];
        term = p[k][d] / (d + 1);
      }
    }
  }
};
const Tables kTables;

template <class Real>
Real arc_at(const ArcSeries<Real>& s, Real x) {
  // Four chains instead of one: the same sum in a third of the time.
  const Real y = x * x, z = y * y;
  const Real o0 = s.odd[0] + z * (s.odd[2] + z * (s.odd[4] + z * s.odd[6]));
  const Real o1 = s.odd[1] + z * (s.odd[3] + z * (s.odd[5] + z * s.odd[7]));
  const Real e0 = s.even[0] + z * (s.even[2] + z * (s.even[4] + z * s.even[6]));
  const Real e1 = s.even[1] + z * (s.even[3] + z * (s.even[5] + z * s.even[7]));
  return s.at_zero + (x * (o0 + y * o1) + y * (e0 + y * e1));
}

/// Expands the speed, the root of quartic s.q, into s. Returns the size of the series' tail.
template <class Real>
Real expand(ArcSeries<Real>& s) {
  Real sum[kPairs], difference[kPairs];
  for (int i = 0; i < kPairs; ++i) {
    const double x = kNode[i], y = x * x;
    const Real even = s.q[0] + Real(y) * (s.q[2] + Real(y) * s.q[4]);
    const Real odd = Real(x) * (s.q[1] + Real(y) * s.q[3]);
    const Real right = square_root(above_zero(even + odd));
    const Real left = square_root(above_zero(even - odd));
    sum[i] = right + left;
    difference[i] = right - left;
  }
  Real even[kTerms], odd[kTerms];  // Legendre coefficients of the speed
  for (int k = 0; k < kTerms; ++k) {
    even[k] = Real(kTables.even_term[k][0]) * sum[0];
    odd[k] = Real(kTables.odd_term[k][0]) * difference[0];
    for (int i = 1; i < kPairs; ++i) {
      even[k] += Real(kTables.even_term[k][i]) * sum[i];
      odd[k] += Real(kTables.odd_term[k][i]) * difference[i];
    }
  }
  // P_k has no power above x^k, so row p begins at k = p.
  Real odds = 0.0, evens = 0.0;
  for (int p = kTerms; p-- > 0;) {
    s.odd[p] = Real(kTables.to_odd[p][p]) * even[p];
    s.even[p] = Real(kTables.to_even[p][p]) * odd[p];
    for (int k = p + 1; k < kTerms; ++k) {
      s.odd[p] += Real(kTables.to_odd[p][k]) * even[k];
      s.even[p] += Real(kTables.to_even[p][k]) * odd[k];
    }
    odds += s.odd[p];
    evens += s.even[p];
  }
  s.length = Real(2.0) * even[0];
  s.at_zero = odds - evens;  // arc length 0 at x = -1

  // Beyond three times the mean slope the guess's cubic would overshoot.
  const Real most = Real(6.0) / s.length;
  const Real first = square_root(above_zero(s.q[0] - s.q[1] + s.q[2] - s.q[3] + s.q[4]));
  const Real last = square_root(above_zero(s.q[0] + s.q[1] + s.q[2] + s.q[3] + s.q[4]));
  s.first_slope = select(first * most > Real(1.0), Real(1.0) / first, most);
  s.last_slope = select(last * most > Real(1.0), Real(1.0) / last, most);
  return absolute(even[kTerms - 1]) + absolute(odd[kTerms - 1]);
}

/// x at arc length `goal`, 0 < goal < length: from a cubic through both ends with their slopes,
/// Halley's method within a bracket. A step under 1e-5 leaves an error of its cube.
template <class Real>
Real invert_series(const ArcSeries<Real>& s, Real goal) {
  const Real f = goal / s.length, g = Real(1.0) - f;
  Real x = f * f * (Real(3.0) - Real(2.0) * f) * Real(2.0) - Real(1.0) +
           f * g * (s.first_slope * g - s.last_slope * f) * s.length;
  Real low = -1.0, high = 1.0;
  auto done = Real(0.0) > Real(1.0);
  for (int i = 0; i < 64; ++i) {
    const Real error = arc_at(s, x) - goal;
    const auto over = error > Real(0.0);
    high = select(over, x, high);
    low = select(over, low, x);
    const Real v2 = s.q[0] + x * (s.q[1] + x * (s.q[2] + x * (s.q[3] + x * s.q[4])));
    const Real slope =
        s.q[1] + x * (Real(2.0) * s.q[2] + x * (Real(3.0) * s.q[3] + x * (Real(4.0) * s.q[4])));
    const Real v4 = Real(4.0) * v2;
    Real next = x - error * v4 / (v4 * square_root(above_zero(v2)) - error * slope);
    next = select((next >= low) & (next <= high), next, Real(0.5) * (low + high));
    const Real step = absolute(next - x);
    x = select(done, x, next);
    done = done | (step <= Real(1e-5));
    if (all(done)) break;
  }
  return x;
}

/// |derivative|^2 of a piece by powers of x, where t = middle + half x, times half^2: the squared
/// speed per x.
/// `Vector` is dvec3, or LaneVector for four pieces at once.
template <class Real, class Vector>
std::array<Real, 5> speed_squared(const std::array<Vector, 4>& b, double middle, double half) {
  const Vector d0 = 3.0 * (b[1] - b[0]), d1 = 6.0 * ((b[2] - b[1]) - (b[1] - b[0])),
               d2 = 3.0 * ((b[3] - b[2]) - 2.0 * (b[2] - b[1]) + (b[1] - b[0]));
  const Vector a = half * (d0 + middle * (d1 + middle * d2));
  const Vector e = (half * half) * (d1 + (2.0 * middle) * d2);
  const Vector f = (half * half * half) * d2;
  return {dot(a, a), 2.0 * dot(a, e), dot(e, e) + 2.0 * dot(a, f), 2.0 * dot(e, f), dot(f, f)};
}

/// A series' tail, as a share of the piece's size, beyond which the piece is cut finer.
constexpr double kTailOfPiece = 5e-12;

/// Parts that a piece starts with: four ranges at least, so that all lanes have work and most need
/// no second look.
int cuts_of(std::size_t pieces) { return pieces == 1 ? 4 : pieces < 4 ? 2 : 1; }

template <class Real, class Vector>
Vector point_of(const std::array<Vector, 4>& cv, Real t) {
  const Real s = Real(1.0) - t;
  return (s * s * s) * cv[0] + (Real(3.0) * s * s * t) * cv[1] + (Real(3.0) * s * t * t) * cv[2] +
         (t * t * t) * cv[3];
}

/// Part of a piece still to be measured.
struct Range {
  int piece;
  double t0, t1;
};

/// Measures four ranges side by side, in order; a range whose series falls too slowly is cut in
/// four. Fewer than four are padded with the last.
double measure_four(std::span<const CubicPiece> pieces, std::span<const Range> range, double start,
                    int depth, ArcTable& table) {
  constexpr int kDeepest = 12;  // 4^-12 of a piece: what a cusp still misses there is below 1e-12
  ArcSeries<Lanes> four;
  double q[5][Lanes::kCount];
  for (std::size_t i = 0; i < Lanes::kCount; ++i) {
    const Range& r = range[std::min(i, range.size() - 1)];
    const auto c = speed_squared<double>(pieces[std::size_t(r.piece)].cv, 0.5 * (r.t0 + r.t1),
                                         0.5 * (r.t1 - r.t0));
    for (int p = 0; p < 5; ++p) q[p][i] = c[std::size_t(p)];
  }
  for (int p = 0; p < 5; ++p) four.q[p] = Lanes::load(q[p]);
  double tail[Lanes::kCount];
  expand(four).store(tail);

  double odd[kTerms][Lanes::kCount], even[kTerms][Lanes::kCount];
  double length[Lanes::kCount], at_zero[Lanes::kCount], first[Lanes::kCount], last[Lanes::kCount];
  for (int p = 0; p < kTerms; ++p) {
    four.odd[p].store(odd[p]);
    four.even[p].store(even[p]);
  }
  four.length.store(length);
  four.at_zero.store(at_zero);
  four.first_slope.store(first);
  four.last_slope.store(last);

  for (std::size_t i = 0; i < range.size(); ++i) {
    const Range& r = range[i];
    const double size = pieces[std::size_t(r.piece)].size() * (r.t1 - r.t0);
    if (tail[i] > kTailOfPiece * size && depth < kDeepest) {
      const double step = 0.25 * (r.t1 - r.t0);
      Range quarter[4];
      for (int k = 0; k < 4; ++k) quarter[k] = {r.piece, r.t0 + k * step, r.t0 + (k + 1) * step};
      start = measure_four(pieces, quarter, start, depth + 1, table);
      continue;
    }
    ArcPart& part = table.grow();
    part.piece = r.piece;
    part.t0 = r.t0;
    part.t1 = r.t1;
    part.start = start;
    part.length = length[i];
    part.at_zero = at_zero[i];
    for (std::size_t p = 0; p < kTerms; ++p) {
      part.odd[p] = odd[p][i];
      part.even[p] = even[p][i];
    }
    for (std::size_t p = 0; p < 5; ++p) part.speed_squared[p] = q[p][i];
    part.first_slope = first[i];
    part.last_slope = last[i];
    start += length[i];
  }
  return start;
}

template <class Real, class Load>
ArcSeries<Real> series_of(Load load) {
  ArcSeries<Real> s;
  s.length = load([](const ArcPart& p) { return p.length; });
  s.at_zero = load([](const ArcPart& p) { return p.at_zero; });
  s.first_slope = load([](const ArcPart& p) { return p.first_slope; });
  s.last_slope = load([](const ArcPart& p) { return p.last_slope; });
  for (std::size_t i = 0; i < kTerms; ++i) {
    s.odd[i] = load([i](const ArcPart& p) { return p.odd[i]; });
    s.even[i] = load([i](const ArcPart& p) { return p.even[i]; });
  }
  for (std::size_t i = 0; i < 5; ++i)
    s.q[i] = load([i](const ArcPart& p) { return p.speed_squared[i]; });
  return s;
}

}  // namespace

dvec3 CubicPiece::point(double t) const { return point_of(cv, t); }

dvec3 CubicPiece::derivative(double t) const { return bezier_derivative(cv, t); }

dvec3 CubicPiece::second_derivative(double t) const {
  return 6.0 * ((1.0 - t) * (cv[2] - 2.0 * cv[1] + cv[0]) + t * (cv[3] - 2.0 * cv[2] + cv[1]));
}

double CubicPiece::size() const {
  const auto sum = [](const dvec3& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); };
  return sum(cv[1] - cv[0]) + sum(cv[2] - cv[1]) + sum(cv[3] - cv[2]);
}

double ArcPart::arc(double x) const {
  return arc_at(series_of<double>([this](auto field) { return field(*this); }), x);
}

double measure_pieces(std::span<const CubicPiece> pieces, ArcTable& table) {
  const int cuts = cuts_of(pieces.size());
  Range range[4];
  std::size_t count = 0;
  double length = 0.0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    for (int k = 0; k < cuts; ++k) {
      range[count++] = {int(i), double(k) / cuts, double(k + 1) / cuts};
      const bool last = i + 1 == pieces.size() && k + 1 == cuts;
      if (count == 4 || last) {
        length = measure_four(pieces, std::span(range).first(count), length, 0, table);
        count = 0;
      }
    }
  }
  return length;
}

double invert(const ArcPart& part, double goal) {
  if (!(goal > 0.0)) return -1.0;
  if (!(goal < part.length)) return 1.0;
  return invert_series(series_of<double>([&](auto field) { return field(part); }), goal);
}

void invert_four(const std::array<const ArcPart*, 4>& part, const std::array<double, 4>& goal,
                 std::array<double, 4>& x) {
  const auto s = series_of<Lanes>([&](auto field) {
    return Lanes(field(*part[0]), field(*part[1]), field(*part[2]), field(*part[3]));
  });
  invert_series(s, Lanes::load(goal.data())).store(x.data());
  for (std::size_t i = 0; i < 4; ++i) {
    if (!(goal[i] > 0.0))
      x[i] = -1.0;
    else if (!(goal[i] < part[i]->length))
      x[i] = 1.0;
  }
}

int ArcLanes::measure(std::span<const Piece> piece) {
  assert(!piece.empty() && piece.size() <= kMostPieces);
  piece_ = piece;
  cuts_ = cuts_of(piece.size());
  parts_ = 0;
  length_ = Lanes(0.0);
  int good = 15;
  const auto size = [](const LaneVector& v) {
    return absolute(v.x) + absolute(v.y) + absolute(v.z);
  };
  for (const Piece& p : piece) {
    const Lanes whole = size(p[1] - p[0]) + size(p[2] - p[1]) + size(p[3] - p[2]);
    for (int k = 0; k < cuts_; ++k) {
      const double t0 = double(k) / cuts_, t1 = double(k + 1) / cuts_;
      ArcSeries<Lanes>& series = part_[std::size_t(parts_)];
      const auto q = speed_squared<Lanes>(p, 0.5 * (t0 + t1), 0.5 * (t1 - t0));
      for (std::size_t i = 0; i < 5; ++i) series.q[i] = q[i];
      const Lanes tail = expand(series);
      good &= (tail <= Lanes(kTailOfPiece) * (whole * Lanes(t1 - t0))).bits();
      start_[std::size_t(parts_++)] = length_;
      length_ += series.length;
    }
  }
  return good & (length_ > Lanes(0.0)).bits();
}

LaneVector ArcLanes::point_at(Lanes s) const {
  // Each lane is on one part; nearly always all are on the same.
  std::array<Lanes::Mask, kMostParts> on;  // part k or a later one
  int low = 0, high = 0;
  for (int k = 1; k < parts_; ++k) {
    on[std::size_t(k)] = s >= start_[std::size_t(k)];
    if (on[std::size_t(k)].bits() == 15) low = k;
    if (on[std::size_t(k)].bits() != 0) high = k;
  }
  ArcSeries<Lanes> mixed;
  const ArcSeries<Lanes>* series = &part_[std::size_t(low)];
  const Piece* piece = &piece_[std::size_t(low / cuts_)];
  Piece mixed_piece;
  const auto from = [&](int part) { return Lanes(double(part % cuts_) / cuts_); };
  const auto to = [&](int part) { return Lanes(double(part % cuts_ + 1) / cuts_); };
  Lanes start = start_[std::size_t(low)], t0 = from(low), t1 = to(low);
  if (low != high) {
    mixed = *series;
    mixed_piece = *piece;
    for (int k = low + 1; k <= high; ++k) {
      const Lanes::Mask here = on[std::size_t(k)];
      const ArcSeries<Lanes>& own = part_[std::size_t(k)];
      const auto take = [&](Lanes& to_field, Lanes field) {
        to_field = select(here, field, to_field);
      };
      take(mixed.length, own.length);
      take(mixed.at_zero, own.at_zero);
      for (int i = 0; i < kTerms; ++i) take(mixed.odd[i], own.odd[i]);
      for (int i = 0; i < kTerms; ++i) take(mixed.even[i], own.even[i]);
      for (int i = 0; i < 5; ++i) take(mixed.q[i], own.q[i]);
      take(mixed.first_slope, own.first_slope);
      take(mixed.last_slope, own.last_slope);
      take(start, start_[std::size_t(k)]);
      take(t0, from(k));
      take(t1, to(k));
      const Piece& other = piece_[std::size_t(k / cuts_)];
      for (std::size_t i = 0; i < 4; ++i) mixed_piece[i] = select(here, other[i], mixed_piece[i]);
    }
    series = &mixed;
    piece = &mixed_piece;
  }
  const Lanes goal = s - start;
  Lanes x = invert_series(*series, goal);
  x = select(series->length > goal, x, Lanes(1.0));
  x = select(goal > Lanes(0.0), x, Lanes(-1.0));
  const Lanes t = Lanes(0.5) * ((t0 + t1) + (t1 - t0) * x);
  return point_of(*piece, t);
}

}  // namespace backbend::solver
