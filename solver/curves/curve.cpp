#include "solver/curves/curve.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "solver/math/box_number.h"
#include "solver/rig/spine_system.h"

namespace backbend::solver {
namespace {

using glm::dvec3;

double even_knot(std::ptrdiff_t i, std::size_t cv_count, int degree) {
  return std::clamp(double(i - degree), 0.0, double(cv_count) - degree);
}

/// The blossom of a B-spline span at (a, b, c): its polar form, whose corners are Bezier points.
dvec3 blossom(std::span<const dvec3> cv, int span, int degree, const std::array<double, 3>& at) {
  std::array<dvec3, 4> d{};
  for (int i = 0; i <= degree; ++i) d[i] = cv[span + i];
  for (int r = 1; r <= degree; ++r) {
    for (int i = degree; i >= r; --i) {
      const double low = even_knot(span + i, cv.size(), degree);
      const double high = even_knot(span + i + degree + 1 - r, cv.size(), degree);
      const double f = (at[r - 1] - low) / (high - low);
      d[i] = (1.0 - f) * d[i - 1] + f * d[i];
    }
  }
  return d[degree];
}

std::array<dvec3, 4> line(const dvec3& a, const dvec3& b) {
  return {a, a + (b - a) * (1.0 / 3.0), a + (b - a) * (2.0 / 3.0), b};
}

}  // namespace

std::vector<double> make_knots(std::span<const dvec3> point, KnotRule rule) {
  if (point.size() < 2) throw RigError("an interpolating curve needs two points or more");
  std::vector<double> knot(point.size(), 0.0);
  for (std::size_t i = 1; i < point.size(); ++i) {
    const double gap = glm::length(point[i] - point[i - 1]);
    if (!(gap > 0.0)) {
      throw RigError("curve points " + std::to_string(i - 1) + " and " + std::to_string(i) +
                     " coincide: no curve can be drawn through them");
    }
    const double step = rule == KnotRule::chord     ? gap
                        : rule == KnotRule::uniform ? 1.0
                                                    : std::sqrt(gap);
    knot[i] = knot[i - 1] + step;
  }
  return knot;
}

CubicPiece& Curve::add_piece(double u0, double u1) {
  CubicPiece& piece = piece_.grow();
  piece.u0 = u0;
  piece.u1 = u1;
  return piece;
}

void Curve::measure() {
  arc_.clear();
  length_ = measure_pieces(piece_.all(), arc_);
}

Curve Curve::bezier(const std::array<dvec3, 4>& cv) {
  Curve curve;
  curve.add_piece(0.0, 1.0).cv = cv;
  curve.measure();
  return curve;
}

Curve Curve::bspline(std::span<const dvec3> cv) {
  assert(cv.size() >= 2);
  if (cv.size() == 2) return bezier(line(cv[0], cv[1]));
  if (cv.size() == 3) {
    const dvec3 a = cv[0] + (cv[1] - cv[0]) * (2.0 / 3.0);
    const dvec3 b = cv[2] + (cv[1] - cv[2]) * (2.0 / 3.0);
    return bezier({cv[0], a, b, cv[2]});
  }
  Curve curve;
  const int spans = int(cv.size()) - 3;
  for (int k = 0; k < spans; ++k) {
    const double a = k, b = k + 1;
    curve.add_piece(a / spans, b / spans).cv = {
        blossom(cv, k, 3, {a, a, a}), blossom(cv, k, 3, {a, a, b}), blossom(cv, k, 3, {a, b, b}),
        blossom(cv, k, 3, {b, b, b})};
  }
  curve.measure();
  return curve;
}

Curve Curve::interpolating(std::span<const dvec3> point, std::span<const double> knot) {
  assert(point.size() >= 2 && point.size() == knot.size());
  const std::size_t last = point.size() - 1;
  // Second derivatives from the tridiagonal system of a natural spline (zero at both ends), by
  // forward elimination and back substitution.
  std::vector<dvec3> second(point.size(), dvec3(0.0));
  std::vector<double> upper(point.size(), 0.0);
  for (std::size_t i = 1; i < last; ++i) {
    const double h0 = knot[i] - knot[i - 1], h1 = knot[i + 1] - knot[i];
    const dvec3 right = 6.0 * ((point[i + 1] - point[i]) / h1 - (point[i] - point[i - 1]) / h0);
    const double pivot = 2.0 * (h0 + h1) - h0 * upper[i - 1];
    upper[i] = h1 / pivot;
    second[i] = (right - h0 * second[i - 1]) / pivot;
  }
  for (std::size_t i = last; i-- > 1;) second[i] -= upper[i] * second[i + 1];

  Curve curve;
  const double range = knot[last] - knot[0];
  for (std::size_t i = 0; i < last; ++i) {
    const double h = knot[i + 1] - knot[i];
    const dvec3 chord = (point[i + 1] - point[i]) / h;
    const dvec3 d0 = chord - (h / 6.0) * (2.0 * second[i] + second[i + 1]);
    const dvec3 d1 = chord + (h / 6.0) * (second[i] + 2.0 * second[i + 1]);
    curve.add_piece((knot[i] - knot[0]) / range, (knot[i + 1] - knot[0]) / range).cv = {
        point[i], point[i] + (h / 3.0) * d0, point[i + 1] - (h / 3.0) * d1, point[i + 1]};
  }
  curve.measure();
  return curve;
}

Curve Curve::polyline(std::span<const dvec3> point) {
  assert(point.size() >= 2);
  const std::size_t last = point.size() - 1;
  Curve curve;
  for (std::size_t i = 0; i < last; ++i) {
    curve.add_piece(double(i) / double(last), double(i + 1) / double(last)).cv =
        line(point[i], point[i + 1]);
  }
  curve.measure();
  return curve;
}

CurveMap::CurveMap(Kind kind, std::size_t point_count, std::span<const double> knot)
    : point_count_(point_count) {
  // The curve of a unit vector at one point and zero elsewhere has that point's weights for places.
  std::vector<dvec3> unit(point_count, dvec3(0.0));
  for (std::size_t k = 0; k < point_count; ++k) {
    unit[k] = dvec3(1.0, 0.0, 0.0);
    const Curve curve = kind == Kind::bspline         ? Curve::bspline(unit)
                        : kind == Kind::interpolating ? Curve::interpolating(unit, knot)
                                                      : Curve::polyline(unit);
    unit[k] = dvec3(0.0);
    const auto pieces = curve.pieces();
    weight_.resize(pieces.size() * 4 * point_count);
    range_.resize(pieces.size());
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      range_[i] = {pieces[i].u0, pieces[i].u1};
      for (std::size_t j = 0; j < 4; ++j) {
        weight_[(i * 4 + j) * point_count + k] = pieces[i].cv[j].x;
      }
    }
  }
}

Curve CurveMap::draw(std::span<const dvec3> point) const {
  assert(point.size() == point_count_);
  Curve curve;
  const double* w = weight_.data();
  for (const Range& range : range_) {
    CubicPiece& piece = curve.add_piece(range.u0, range.u1);
    for (dvec3& cv : piece.cv) {
      cv = w[0] * point[0];
      for (std::size_t k = 1; k < point_count_; ++k) cv += w[k] * point[k];
      w += point_count_;
    }
  }
  curve.measure();
  return curve;
}

std::vector<std::array<BoxVector, 4>> CurveMap::draw(std::span<const BoxVector> point) const {
  assert(point.size() == point_count_);
  std::vector<std::array<BoxVector, 4>> piece(range_.size());
  const double* w = weight_.data();
  for (auto& cvs : piece) {
    for (BoxVector& cv : cvs) {
      for (std::size_t k = 0; k < point_count_; ++k)
        if (w[k] != 0.0) cv = cv + BoxReal(w[k]) * point[k];
      w += point_count_;
    }
  }
  return piece;
}

std::vector<std::array<BoxVector, 3>> CurveMap::legs(std::span<const BoxVector> step) const {
  assert(step.size() + 1 == point_count_);
  std::vector<std::array<BoxVector, 3>> piece(range_.size());
  const double* w = weight_.data();
  for (auto& legs : piece) {
    for (BoxVector& leg : legs) {
      leg = BoxVector(dvec3(0.0));
      // A step moves all points after it.
      double after = 0.0;
      for (std::size_t k = step.size(); k > 0; --k) {
        after += w[point_count_ + k] - w[k];
        // What cancels but for its rounding.
        if (std::abs(after) > 1e-15) leg = leg + BoxReal(after) * step[k - 1];
      }
      w += point_count_;
    }
    w += point_count_;
  }
  return piece;
}

void CurveMap::draw(std::span<const LaneVector> point, std::span<ArcLanes::Piece> piece) const {
  assert(point.size() == point_count_ && piece.size() == range_.size());
  const double* w = weight_.data();
  for (ArcLanes::Piece& p : piece) {
    for (LaneVector& cv : p) {
      cv = w[0] * point[0];
      for (std::size_t k = 1; k < point_count_; ++k) cv += w[k] * point[k];
      w += point_count_;
    }
  }
}

Curve::Local Curve::locate(double u) const {
  const auto after =
      std::upper_bound(piece_.begin(), piece_.end(), u,
                       [](double value, const CubicPiece& p) { return value < p.u1; });
  const std::size_t i = std::min(std::size_t(after - piece_.begin()), piece_.size() - 1);
  const CubicPiece& p = piece_[i];
  return {int(i), std::clamp((u - p.u0) / (p.u1 - p.u0), 0.0, 1.0)};
}

double Curve::to_u(const Local& at) const {
  const CubicPiece& p = piece_[std::size_t(at.piece)];
  return p.u0 + (p.u1 - p.u0) * at.t;
}

dvec3 Curve::point(double u) const {
  const Local at = locate(u);
  return piece_[std::size_t(at.piece)].point(at.t);
}

dvec3 Curve::derivative(double u) const {
  const Local at = locate(u);
  const CubicPiece& p = piece_[std::size_t(at.piece)];
  return p.derivative(at.t) / (p.u1 - p.u0);
}

dvec3 Curve::second_derivative(double u) const {
  const Local at = locate(u);
  const CubicPiece& p = piece_[std::size_t(at.piece)];
  const double range = p.u1 - p.u0;
  return p.second_derivative(at.t) / (range * range);
}

dvec3 Curve::tangent(double u) const { return tangent_at(locate(u)); }

dvec3 Curve::tangent_at(const Local& at) const {
  const CubicPiece& piece = piece_[std::size_t(at.piece)];
  const dvec3 d = piece.derivative(at.t);
  const double speed = glm::length(d);
  const double least = 1e-12 * piece.size();
  if (speed > least) return d / speed;
  // The derivative vanishes: with C2, C3 the next ones it is t C2 + t^2 C3 / 2 near here, so the
  // curve leaves along C2 and arrives against it.
  const bool arrives = at.t == 1.0;
  const dvec3 second = piece.second_derivative(at.t);
  if (glm::length(second) > least) return glm::normalize(arrives ? -second : second);
  const auto& b = piece.cv;
  const dvec3 third = b[3] - 3.0 * b[2] + 3.0 * b[1] - b[0];
  if (glm::length(third) > least) return glm::normalize(third);
  // A piece that is one point has its neighbour's direction: the next, else the one before.
  for (std::size_t i = std::size_t(at.piece) + 1; i < piece_.size(); ++i) {
    if (piece_[i].size() > 0.0) return tangent_at({int(i), 0.0});
  }
  for (int i = at.piece - 1; i >= 0; --i) {
    if (piece_[std::size_t(i)].size() > 0.0) return tangent_at({i, 1.0});
  }
  return dvec3(0.0);
}

double Curve::arc_at(double u) const {
  const Local at = locate(u);
  for (std::size_t i = arc_.size(); i-- > 0;) {
    const ArcPart& part = arc_[i];
    if (part.piece != at.piece || part.t0 > at.t) continue;
    return part.start + std::clamp(part.arc(part.x(at.t)), 0.0, part.length);
  }
  return 0.0;
}

const ArcPart& Curve::part_at(double s) const {
  const ArcPart* part = arc_.begin();
  if (arc_.size() <= 8) {
    while (part + 1 != arc_.end() && s >= part[1].start) ++part;
    return *part;
  }
  const auto after = std::upper_bound(
      arc_.begin(), arc_.end(), s, [](double value, const ArcPart& a) { return value < a.start; });
  return after == arc_.begin() ? *part : *(after - 1);
}

Curve::Local Curve::invert(double s) const {
  const ArcPart& part = part_at(s);
  return {part.piece, part.t(backbend::solver::invert(part, s - part.start))};
}

CurvePoint Curve::at_arc(double s) const {
  CurvePoint p;
  if (s <= 0.0 || s >= length_) {
    const bool start = s <= 0.0;
    const Local at = start ? Local{0, 0.0} : Local{int(piece_.size()) - 1, 1.0};
    p.u = start ? 0.0 : 1.0;
    p.overrun = start ? s : s - length_;
    p.tangent = tangent_at(at);
    p.position = (start ? piece_.front().cv[0] : piece_.back().cv[3]) + p.overrun * p.tangent;
    return p;
  }
  const Local at = invert(s);
  p.position = piece_[std::size_t(at.piece)].point(at.t);
  p.tangent = tangent_at(at);
  p.u = to_u(at);
  return p;
}

Curve::Step Curve::step_past_end(const dvec3& centre, double distance) const {
  // A straight line leaves the sphere where |from_centre + overrun tangent| = distance.
  const CurvePoint end = at_arc(length_);
  const dvec3 from_centre = end.position - centre;
  const double along = glm::dot(from_centre, end.tangent);
  const double inside = distance * distance - glm::dot(from_centre, from_centre);
  const double root = std::sqrt(std::max(0.0, along * along + inside));
  // Of the two forms of the larger root, the one that does not cancel.
  const double overrun = along > 0.0 ? inside / (along + root) : root - along;
  const bool one_point = end.tangent == dvec3(0.0);
  const double arc = length_ + (one_point ? 0.0 : std::max(0.0, overrun));
  return {at_arc(arc), arc};
}

Curve::Step Curve::step_to_distance(const dvec3& centre, double from_arc, double distance) const {
  // The distance to `centre` grows no faster than the arc length, so a step by what is missing
  // never passes the first meeting. A least step keeps a curve that circles the meeting's sphere
  // from stopping it; what it may jump over is a touch of under a millionth of the distance.
  // What is shorter than the arc length is exact to cannot be looked for: it is taken as an arc.
  if (distance < 1e-12 * length_) return {at_arc(from_arc + distance), from_arc + distance};
  const double least_step = 1e-3 * distance, enough = 4e-16 * distance;
  double low = from_arc, high = from_arc;
  Step step{at_arc(high), high};
  double missing = distance - glm::length(step.place.position - centre);
  const auto go = [&](double arc) {
    high = arc;
    step = {at_arc(arc), arc};
    missing = distance - glm::length(step.place.position - centre);
  };
  while (missing > enough) {
    if (high >= length_) return step_past_end(centre, distance);
    low = high;
    go(std::min(high + std::max(missing, least_step), length_));
  }
  // Between low (inside) and high (outside): Newton's method within the bracket. The slope of the
  // distance is the cosine between the tangent and the way from the centre.
  double outside = high;
  for (int i = 0; i < 64 && std::abs(missing) > enough; ++i) {
    (missing > 0.0 ? low : outside) = high;
    const double cosine = glm::dot(step.place.tangent, step.place.position - centre) /
                          glm::length(step.place.position - centre);
    double next = high + missing / cosine;
    if (!(next > low && next < outside)) next = 0.5 * (low + outside);
    if (next == high || next == low || next == outside) break;
    go(next);
  }
  return step;
}

double Curve::closest_parameter(const dvec3& p) const {
  constexpr int kSamples = 16;  // the squared distance has at most five stationary points a piece
  double best = std::numeric_limits<double>::infinity(), best_u = 0.0;
  for (const CubicPiece& piece : piece_) {
    const double reach = (3.0 / kSamples) * piece.size();  // from one sample to the next, at most
    for (int i = 0; i <= kSamples; ++i) {
      double t = double(i) / kSamples;
      double low = std::max(0.0, t - 1.0 / kSamples), high = std::min(1.0, t + 1.0 / kSamples);
      const dvec3 seed = piece.point(t) - p;
      if (glm::dot(seed, seed) > 2.0 * (best + reach * reach)) continue;
      for (int k = 0; k < 40; ++k) {
        const dvec3 away = piece.point(t) - p;
        const dvec3 d = piece.derivative(t);
        const double slope = glm::dot(away, d);
        (slope > 0.0 ? high : low) = t;
        const double bend = glm::dot(d, d) + glm::dot(away, piece.second_derivative(t));
        double next = t - slope / bend;
        if (!(bend > 0.0) || !(next >= low && next <= high)) next = 0.5 * (low + high);
        if (next == t) break;
        t = next;
      }
      const dvec3 away = piece.point(t) - p;
      const double squared = glm::dot(away, away);
      if (squared < best) {
        best = squared;
        best_u = piece.u0 + (piece.u1 - piece.u0) * t;
      }
    }
  }
  return best_u;
}

void Curve::points_at_arcs(std::span<const double> s, std::span<dvec3> out) const {
  assert(s.size() == out.size());
  for (std::size_t first = 0; first < s.size(); first += 4) {
    const std::size_t count = std::min<std::size_t>(4, s.size() - first);
    std::array<const ArcPart*, 4> part;
    std::array<double, 4> goal, x;
    for (std::size_t k = 0; k < 4; ++k) {
      const double arc = s[first + std::min(k, count - 1)];
      part[k] = &part_at(arc);
      goal[k] = arc - part[k]->start;
    }
    invert_four(part, goal, x);
    for (std::size_t k = 0; k < count; ++k) {
      const double arc = s[first + k];
      out[first + k] = arc > 0.0 && arc < length_
                           ? piece_[std::size_t(part[k]->piece)].point(part[k]->t(x[k]))
                       : arc == 0.0     ? piece_.front().cv[0]
                       : arc == length_ ? piece_.back().cv[3]
                                        : at_arc(arc).position;
    }
  }
}

std::vector<dvec3> equal_arc_points(const Curve& curve, std::size_t count) {
  assert(count >= 2);
  std::vector<double> arc(count);
  for (std::size_t i = 0; i < count; ++i) arc[i] = curve.length() * (double(i) / double(count - 1));
  std::vector<dvec3> point(count);
  curve.points_at_arcs(arc, point);
  return point;
}

}  // namespace backbend::solver
