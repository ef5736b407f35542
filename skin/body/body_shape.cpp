#include "skin/body/body_shape.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>

namespace backbend::skin {
namespace {

constexpr double kFar = 1e6;    // "no solid yet"
constexpr double kStep = 2e-5;  // metres; central differences are good to 1e-6 of the slope here
constexpr double kMelt = 1.0 / 6.0 + 1e-9;  // of its blend, that smooth_min() takes at most
constexpr double kFlatCap = 1e-3;           // metres: a cap of length 0 is a dome this low

Lanes smooth_min(Lanes a, Lanes b, double blend) {
  if (!(blend > 0.0)) return smaller(a, b);
  const Lanes h = larger(blend - absolute(a - b), 0.0) / blend;
  return smaller(a, b) - h * h * h * blend / 6.0;
}

Lanes box_distance(const glm::dvec3& low, const glm::dvec3& high, const LaneVector& p) {
  const auto outside = [](double from, double to, Lanes x) {
    return larger(larger(from - x, x - to), 0.0);
  };
  return length(LaneVector(outside(low.x, high.x, p.x), outside(low.y, high.y, p.y),
                           outside(low.z, high.z, p.z)));
}

Lanes ellipsoid(const BodySolid& part, const LaneVector& p) {
  const LaneVector off = p - part.center;
  const auto along = [&](int axis) {
    return dot(LaneVector(part.world_from_ellipsoid[axis]), off);
  };
  const LaneVector q(along(0) / part.radii.x, along(1) / part.radii.y, along(2) / part.radii.z);
  const LaneVector steep(q.x / part.radii.x, q.y / part.radii.y, q.z / part.radii.z);
  const Lanes k = length(q), slope = length(steep);
  const double center = -std::min({part.radii.x, part.radii.y, part.radii.z});
  return select(Lanes(1e-9) > k, center, k * (k - 1.0) / slope);
}

/// The exact distance to two balls and the cone that touches both.
Lanes round_cone(const BodySolid& part, const LaneVector& p) {
  const glm::dvec3 along = part.axis[1] - part.axis[0];
  const double l2 = glm::dot(along, along), dr = part.radius.x - part.radius.y;
  const double a2 = l2 - dr * dr;
  const LaneVector off = p - part.axis[0];
  const Lanes y = dot(off, along), z = y - l2;
  const LaneVector across = Lanes(l2) * off - y * LaneVector(along);
  const Lanes x2 = dot(across, across), y2 = y * y * l2, z2 = z * z * l2;
  const Lanes k = (dr > 0 ? 1.0 : dr < 0 ? -1.0 : 0.0) * dr * dr * x2;
  const auto sign = [](Lanes v) {
    return select(v > 0.0, 1.0, select(Lanes(0.0) > v, -1.0, Lanes(0.0)));
  };
  const Lanes at_second = square_root(x2 + z2) / l2 - part.radius.y;
  const Lanes at_first = square_root(x2 + y2) / l2 - part.radius.x;
  const Lanes between = (square_root(x2 * a2 / l2) + y * dr) / l2 - part.radius.x;
  return select(sign(z) * a2 * z2 > k, at_second, select(k > sign(y) * a2 * y2, at_first, between));
}

Lanes::Mask is_two(Lanes n) { return Lanes(1e-9) > absolute(n - 2.0); }

/// std::pow() on each lane; once where all are the same.
Lanes each_power(Lanes x, Lanes n) {
  double base[Lanes::kCount], exponent[Lanes::kCount];
  x.store(base);
  n.store(exponent);
  double out[Lanes::kCount];
  for (int i = 0; i < Lanes::kCount; ++i) {
    const bool again = i > 0 && base[i] == base[0] && exponent[i] == exponent[0];
    out[i] = again ? out[0] : std::pow(base[i], exponent[i]);
  }
  return Lanes::load(out);
}

Lanes power(Lanes x, Lanes n) {
  const Lanes::Mask two = is_two(n);
  return all(two) ? x * x : select(two, x * x, each_power(x, n));
}

}  // namespace

BodyShape::BodyShape(const BodyDescription& description)
    : description_(description.groups), fold_(description.fold) {
  low_ = glm::dvec3(kFar);
  high_ = glm::dvec3(-kFar);
  for (const BodyGroup& group : description_) {
    Group g{solids_.size(), group.parts.size(), group.blend, glm::dvec3(kFar), glm::dvec3(-kFar)};
    for (const BodySolid& part : group.parts) {
      Solid solid;
      solid.part = &part;
      solid.low = glm::dvec3(kFar);
      solid.high = glm::dvec3(-kFar);
      const auto include = [&solid](const glm::dvec3& center, double radius) {
        solid.low = glm::min(solid.low, center - radius);
        solid.high = glm::max(solid.high, center + radius);
      };
      if (part.shape == BodySolid::Shape::loft) {
        solid.curve = BodyCurve(part.axis);
        std::vector<double> at, outer, inner, front, back, square;
        for (const BodySection& s : part.sections) {
          at.push_back(s.at);
          outer.push_back(s.outer);
          inner.push_back(s.inner);
          front.push_back(s.front);
          back.push_back(s.back);
          square.push_back(s.square);
        }
        solid.outer = BodyProfile(at, outer);
        solid.inner = BodyProfile(at, inner);
        solid.front = BodyProfile(at, front);
        solid.back = BodyProfile(at, back);
        solid.square = BodyProfile(at, square);
        constexpr int kSamples = 64;
        for (int i = 0; i <= kSamples; ++i) {
          const double s = at.front() + (at.back() - at.front()) * i / kSamples;
          double slope = 0.0;
          // A superellipse of any exponent lies in its bounding rectangle.
          const double u = std::max(solid.outer(s, &slope), solid.inner(s, &slope));
          const double v = std::max(solid.front(s, &slope), solid.back(s, &slope));
          include(solid.curve.at(s), 1.02 * std::hypot(u, v));
        }
        include(solid.curve.at(at.front() - part.cap.x), 0.0);
        include(solid.curve.at(at.back() + part.cap.y), 0.0);
      } else if (part.shape == BodySolid::Shape::ellipsoid) {
        include(part.center, std::max({part.radii.x, part.radii.y, part.radii.z}));
      } else {
        include(part.axis[0], part.radius.x);
        include(part.axis[1], part.radius.y);
      }
      g.low = glm::min(g.low, solid.low);
      g.high = glm::max(g.high, solid.high);
      solids_.push_back(std::move(solid));
    }
    double widest = 0.0;
    for (const BodySolid& part : group.parts) {
      if (part.use == BodySolid::Use::add) g.melt += kMelt * part.blend;
      widest = std::max(widest, part.blend);
    }
    g.aside = g.melt + widest;
    low_ = glm::min(low_, g.low);
    high_ = glm::max(high_, g.high);
    groups_.push_back(g);
  }
  high_.x = std::max(high_.x, -low_.x);
  low_.x = -high_.x;
  double widest = 0.0;
  for (const Group& group : groups_) {
    aside_ += kMelt * group.blend;
    widest = std::max(widest, group.blend);
  }
  aside_ += widest;
}

Lanes BodyShape::loft(const Solid& solid, const LaneVector& p) const {
  const BodySolid& part = *solid.part;
  const double first = part.sections.front().at, last = part.sections.back().at;
  const BodyCurve::Feet foot = solid.curve.feet(p);
  const Lanes along = foot.arc, s = clamped(along, first, last);
  const LaneVector &tangent = foot.tangent, off = p - foot.at;
  const LaneVector front = part.front;
  const LaneVector v = normalized(front - dot(front, tangent) * tangent);
  LaneVector u = cross(tangent, v);
  u = select(Lanes(0.0) > dot(u, part.side), Lanes(-1.0) * u, u);
  const Lanes a = dot(off, u), b = dot(off, v);

  Lanes across_slope, deep_slope, unused;
  const Lanes across =
      BodyProfile::choose(a >= Lanes(0.0), solid.outer, solid.inner, s, &across_slope);
  const Lanes deep = BodyProfile::choose(b >= Lanes(0.0), solid.front, solid.back, s, &deep_slope);
  const Lanes n = BodyProfile::choose(a >= Lanes(0.0), solid.square, solid.square, s, &unused);

  // k(p) is 1 on the surface; (k - 1) / |grad k| is the distance to first order.
  const Lanes a_size = absolute(a), b_size = absolute(b);
  const Lanes au = a_size / across, bv = b_size / deep;
  const Lanes pu = power(au, n), pv = power(bv, n), sum = pu + pv;
  const Lanes::Mask two = is_two(n);
  const Lanes root = square_root(sum);
  const Lanes k1 = all(two) ? root : select(two, root, each_power(sum, 1.0 / n));
  const Lanes per = select(sum > 0.0, k1 / sum, 0.0);
  Lanes gu = select(au > 0.0, per * pu / a_size, 0.0);
  Lanes gv = select(bv > 0.0, per * pv / b_size, 0.0);
  // Along the axis k changes with k itself; further out that would shorten the distance, so the
  // slope that it has on the surface is taken.
  Lanes gs = per * (pu * across_slope / across + pv * deep_slope / deep) / larger(k1, 1.0);
  Lanes k = k1;
  const Lanes::Mask before = Lanes(first) > along, beyond = before | (along > last);
  if (any(beyond)) {
    const Lanes height =
        select(before, std::max(part.cap.x, kFlatCap), std::max(part.cap.y, kFlatCap));
    const Lanes e = absolute(along - s) / height;
    const Lanes dome = square_root(k1 * k1 + e * e);
    k = select(beyond, dome, k);
    gu = select(beyond, gu * (k1 / dome), gu);
    gv = select(beyond, gv * (k1 / dome), gv);
    gs = select(beyond, e / (dome * height), gs);  // sizes are constant beyond the ends
  }
  const Lanes distance = (k - 1.0) / square_root(gu * gu + gv * gv + gs * gs);
  const Lanes on_axis = select(beyond, 1.0, sum);
  return select(Lanes(1e-12) > on_axis, Lanes(-1.0) * smaller(across, deep), distance);
}

Lanes BodyShape::solid_value(const Solid& solid, const LaneVector& at, Lanes apart) const {
  Lanes d = 0.0;
  switch (solid.part->shape) {
    case BodySolid::Shape::loft:
      d = loft(solid, at);
      break;
    case BodySolid::Shape::ellipsoid:
      d = ellipsoid(*solid.part, at);
      break;
    case BodySolid::Shape::cone:
      d = round_cone(*solid.part, at);
      break;
  }
  // First-order distances fall short far away; the box keeps culling by it exact.
  return select(apart > 0.0, larger(d, apart), d);
}

Lanes BodyShape::group_in_order(const Group& group, const LaneVector& p, const LaneVector& folded,
                                std::size_t from, Lanes d) const {
  for (std::size_t i = from; i < group.first + group.count; ++i) {
    const Solid& solid = solids_[i];
    const double blend = solid.part->blend;
    const LaneVector& at = solid.part->mirrored ? folded : p;
    const Lanes apart = box_distance(solid.low, solid.high, at);
    if (solid.part->use == BodySolid::Use::add) {
      const Lanes::Mask far = apart > d + blend;
      if (all(far)) continue;
      d = select(far, d, smooth_min(d, solid_value(solid, at, apart), blend));
    } else {
      const Lanes::Mask far = d - blend > Lanes(-1.0) * apart;
      if (all(far)) continue;
      const Lanes without = smooth_min(Lanes(-1.0) * d, solid_value(solid, at, apart), blend);
      d = select(far, d, Lanes(-1.0) * without);
    }
  }
  return d;
}

Lanes BodyShape::group_value(const Group& group, const LaneVector& p,
                             const LaneVector& folded) const {
  // Solids that stand before the one nearby and are too far away to melt into it are left out: the
  // tip of a finger needs no palm.
  Lanes least = kFar;  // what is left out comes to no less
  for (std::size_t i = group.first; i < group.first + group.count; ++i) {
    const Solid& solid = solids_[i];
    if (solid.part->use != BodySolid::Use::add) break;
    const LaneVector& at = solid.part->mirrored ? folded : p;
    const Lanes apart = box_distance(solid.low, solid.high, at);
    if (all(apart > group.aside)) {
      least = smaller(least, apart) - kMelt * solid.part->blend;
      continue;
    }
    if (i == group.first) break;
    const Lanes d = solid_value(solid, at, apart);
    if (all(least > d + solid.part->blend)) return group_in_order(group, p, folded, i + 1, d);
    break;
  }
  return group_in_order(group, p, folded, group.first, kFar);
}

Lanes BodyShape::values(const LaneVector& signed_p) const {
  const LaneVector p(absolute(signed_p.x), signed_p.y, signed_p.z);
  // Mirrored solids meet in a rounded crease instead of a sharp one.
  const Lanes x = select(Lanes(fold_) > p.x, (p.x * p.x + fold_ * fold_) / (2.0 * fold_), p.x);
  const LaneVector folded(x, p.y, p.z);
  // Groups that stand before the one nearby and are too far away to melt into it are left out: a
  // hand needs no trunk.
  Lanes least = kFar;  // what is left out comes to no less
  for (std::size_t i = 0; i < groups_.size(); ++i) {
    const Group& group = groups_[i];
    const Lanes apart = distance(group, p, folded);
    if (all(apart > group.melt + aside_)) {
      least = smaller(least, apart - group.melt) - kMelt * group.blend;
      continue;
    }
    if (i == 0) break;
    const Lanes d = group_value(group, p, folded);
    // Nor would it have been passed over beside them.
    if (all((least > d + group.blend) & (least + group.blend > apart))) {
      return joined_in_order(p, folded, i + 1, d);
    }
    break;
  }
  return joined_in_order(p, folded, 0, kFar);
}

Lanes BodyShape::distance(const Group& group, const LaneVector& p, const LaneVector& folded) {
  return smaller(box_distance(group.low, group.high, p),
                 box_distance(group.low, group.high, folded));
}

Lanes BodyShape::joined_in_order(const LaneVector& p, const LaneVector& folded, std::size_t from,
                                 Lanes body) const {
  for (std::size_t i = from; i < groups_.size(); ++i) {
    const Group& group = groups_[i];
    const Lanes::Mask far = distance(group, p, folded) > body + group.blend;
    if (all(far)) continue;
    body = select(far, body, smooth_min(body, group_value(group, p, folded), group.blend));
  }
  return body;
}

double BodyShape::value(const glm::dvec3& p) const { return values(LaneVector(p))[0]; }

namespace {

/// A place and the six beside it that tell the slope there.
struct Stencil {
  LaneVector first, second;

  explicit Stencil(const glm::dvec3& p) {
    first = {{p.x, p.x + kStep, p.x - kStep, p.x}, {p.y, p.y, p.y, p.y + kStep}, p.z};
    second = {p.x, {p.y - kStep, p.y, p.y, p.y}, {p.z, p.z + kStep, p.z - kStep, p.z}};
  }
};

}  // namespace

glm::dvec3 BodyShape::slope(Lanes first, Lanes second) {
  return {(first[1] - first[2]) / (2.0 * kStep), (first[3] - second[0]) / (2.0 * kStep),
          (second[1] - second[2]) / (2.0 * kStep)};
}

glm::dvec3 BodyShape::gradient(const glm::dvec3& p) const {
  const Stencil around(p);
  return slope(values(around.first), values(around.second));
}

glm::dvec3 BodyShape::project(glm::dvec3 p, double reach) const {
  const glm::dvec3 start = p;
  for (int step = 0; step < 8; ++step) {
    const Stencil around(p);
    const Lanes first = values(around.first);
    const double d = first[0];
    if (std::abs(d) < 1e-7) break;
    glm::dvec3 g = slope(first, values(around.second));
    if (p.x == 0.0) g.x = 0.0;
    const double slope2 = glm::dot(g, g);
    if (slope2 < 1e-4) break;
    p -= g * (d / slope2);
    const glm::dvec3 moved = p - start;
    const double length = glm::length(moved);
    if (length > reach) return start + moved * (reach / length);
  }
  return p;
}

std::size_t BodyShape::owner(const glm::dvec3& signed_p) const {
  const LaneVector p(glm::dvec3(std::abs(signed_p.x), signed_p.y, signed_p.z));
  double best = std::numeric_limits<double>::infinity();
  std::size_t owner = 0;
  for (std::size_t i = 0; i < solids_.size(); ++i) {
    const Solid& solid = solids_[i];
    if (solid.part->use != BodySolid::Use::add || solid.part->joints.empty()) continue;
    const Lanes apart = box_distance(solid.low, solid.high, p);
    if (apart[0] > best) continue;
    const double d = solid_value(solid, p, apart)[0];
    if (d < best) {
      best = d;
      owner = i;
    }
  }
  return owner;
}

}  // namespace backbend::skin
