#include "skin/body/body_shape.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>

namespace backbend::skin {
namespace {

constexpr double kFar = 1e6;       // "no solid yet"
constexpr double kStep = 2e-5;     // metres; central differences are good to 1e-6 of the slope here
constexpr double kFlatCap = 1e-3;  // metres: a cap of length 0 is a dome this low

double smooth_min(double a, double b, double blend) {
  const double h = blend > 0.0 ? std::max(blend - std::abs(a - b), 0.0) / blend : 0.0;
  return std::min(a, b) - h * h * h * blend / 6.0;
}

double box_distance(const glm::dvec3& low, const glm::dvec3& high, const glm::dvec3& p) {
  return glm::length(glm::max(glm::max(low - p, p - high), glm::dvec3(0.0)));
}

double ellipsoid(const BodySolid& part, const glm::dvec3& p) {
  const glm::dvec3 local = (p - part.center) * part.world_from_ellipsoid;  // transpose times
  const glm::dvec3 q = local / part.radii;
  const double k = glm::length(q), slope = glm::length(q / part.radii);
  if (k < 1e-9) return -std::min({part.radii.x, part.radii.y, part.radii.z});
  return k * (k - 1.0) / slope;
}

/// The exact distance to two balls and the cone that touches both.
double round_cone(const BodySolid& part, const glm::dvec3& p) {
  const glm::dvec3 along = part.axis[1] - part.axis[0];
  const double l2 = glm::dot(along, along), dr = part.radius.x - part.radius.y;
  const double a2 = l2 - dr * dr;
  const glm::dvec3 off = p - part.axis[0];
  const double y = glm::dot(off, along), z = y - l2;
  const glm::dvec3 across = off * l2 - along * y;
  const double x2 = glm::dot(across, across), y2 = y * y * l2, z2 = z * z * l2;
  const double k = (dr > 0 ? 1.0 : dr < 0 ? -1.0 : 0.0) * dr * dr * x2;
  const auto sign = [](double v) { return v > 0 ? 1.0 : v < 0 ? -1.0 : 0.0; };
  if (sign(z) * a2 * z2 > k) return std::sqrt(x2 + z2) / l2 - part.radius.y;
  if (sign(y) * a2 * y2 < k) return std::sqrt(x2 + y2) / l2 - part.radius.x;
  return (std::sqrt(x2 * a2 / l2) + y * dr) / l2 - part.radius.x;
}

struct Size {
  double radius, slope;  // half axis on this side, and its change along the axis
};

double power(double x, double n) { return std::abs(n - 2.0) < 1e-9 ? x * x : std::pow(x, n); }

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
    low_ = glm::min(low_, g.low);
    high_ = glm::max(high_, g.high);
    groups_.push_back(g);
  }
  high_.x = std::max(high_.x, -low_.x);
  low_.x = -high_.x;
}

double BodyShape::loft(const Solid& solid, const glm::dvec3& p) const {
  const BodySolid& part = *solid.part;
  const double first = part.sections.front().at, last = part.sections.back().at;
  const BodyCurve::Foot foot = solid.curve.nearest(p);
  const double along = foot.arc, s = std::clamp(along, first, last);
  const glm::dvec3 &tangent = foot.tangent, off = p - foot.at;
  const glm::dvec3 v = glm::normalize(part.front - glm::dot(part.front, tangent) * tangent);
  glm::dvec3 u = glm::cross(tangent, v);
  if (glm::dot(u, part.side) < 0.0) u = -u;
  const double a = glm::dot(off, u), b = glm::dot(off, v);

  Size across{}, deep{};
  across.radius = (a >= 0.0 ? solid.outer : solid.inner)(s, &across.slope);
  deep.radius = (b >= 0.0 ? solid.front : solid.back)(s, &deep.slope);
  double unused = 0.0;
  const double n = solid.square(s, &unused);

  // k(p) is 1 on the surface; (k - 1) / |grad k| is the distance to first order.
  const double au = std::abs(a) / across.radius, bv = std::abs(b) / deep.radius;
  const double pu = power(au, n), pv = power(bv, n), sum = pu + pv;
  if (sum < 1e-12 && along == s) return -std::min(across.radius, deep.radius);
  const double k1 = std::abs(n - 2.0) < 1e-9 ? std::sqrt(sum) : std::pow(sum, 1.0 / n);
  const double per = sum > 0.0 ? k1 / sum : 0.0;
  double gu = au > 0.0 ? per * pu / std::abs(a) : 0.0;
  double gv = bv > 0.0 ? per * pv / std::abs(b) : 0.0;
  // Along the axis k changes with k itself; further out that would shorten the distance, so the
  // slope that it has on the surface is taken.
  double gs =
      per * (pu * across.slope / across.radius + pv * deep.slope / deep.radius) / std::max(k1, 1.0);
  double k = k1;
  if (along != s) {
    const double height = std::max(along < first ? part.cap.x : part.cap.y, kFlatCap);
    const double e = std::abs(along - s) / height;
    k = std::sqrt(k1 * k1 + e * e);
    gu *= k1 / k;
    gv *= k1 / k;
    gs = e / (k * height);  // sizes are constant beyond the ends
  }
  return (k - 1.0) / std::sqrt(gu * gu + gv * gv + gs * gs);
}

double BodyShape::solid_value(const Solid& solid, const glm::dvec3& p,
                              const glm::dvec3& folded) const {
  const glm::dvec3& at = solid.part->mirrored ? folded : p;
  double d = 0.0;
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
  const double apart = box_distance(solid.low, solid.high, at);
  return apart > 0.0 ? std::max(d, apart) : d;
}

double BodyShape::value(const glm::dvec3& signed_p) const {
  const glm::dvec3 p(std::abs(signed_p.x), signed_p.y, signed_p.z);
  // Mirrored solids meet in a rounded crease instead of a sharp one.
  const double x = p.x < fold_ ? (p.x * p.x + fold_ * fold_) / (2.0 * fold_) : p.x;
  const glm::dvec3 folded(x, p.y, p.z);
  double body = kFar;
  for (const Group& group : groups_) {
    const double far = std::min(box_distance(group.low, group.high, p),
                                box_distance(group.low, group.high, folded));
    if (far > body + group.blend) continue;
    double d = kFar;
    for (std::size_t i = group.first; i < group.first + group.count; ++i) {
      const Solid& solid = solids_[i];
      const double blend = solid.part->blend;
      const double apart = box_distance(solid.low, solid.high, solid.part->mirrored ? folded : p);
      if (solid.part->use == BodySolid::Use::add) {
        if (apart > d + blend) continue;
        d = smooth_min(d, solid_value(solid, p, folded), blend);
      } else {
        if (-apart < d - blend) continue;
        d = -smooth_min(-d, solid_value(solid, p, folded), blend);
      }
    }
    body = smooth_min(body, d, group.blend);
  }
  return body;
}

glm::dvec3 BodyShape::gradient(const glm::dvec3& p) const {
  glm::dvec3 g;
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 ahead = p, behind = p;
    ahead[axis] += kStep;
    behind[axis] -= kStep;
    g[axis] = (value(ahead) - value(behind)) / (2.0 * kStep);
  }
  return g;
}

glm::dvec3 BodyShape::project(glm::dvec3 p, double reach) const {
  const glm::dvec3 start = p;
  for (int step = 0; step < 8; ++step) {
    const double d = value(p);
    if (std::abs(d) < 1e-7) break;
    glm::dvec3 g = gradient(p);
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
  const glm::dvec3 p(std::abs(signed_p.x), signed_p.y, signed_p.z);
  double best = std::numeric_limits<double>::infinity();
  std::size_t owner = 0;
  for (std::size_t i = 0; i < solids_.size(); ++i) {
    const Solid& solid = solids_[i];
    if (solid.part->use != BodySolid::Use::add || solid.part->joints.empty()) continue;
    if (box_distance(solid.low, solid.high, p) > best) continue;
    const double d = solid_value(solid, p, p);
    if (d < best) {
      best = d;
      owner = i;
    }
  }
  return owner;
}

}  // namespace backbend::skin
