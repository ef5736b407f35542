#include "solver/systems/even_integral.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "solver/math/fast_trigonometry.h"

namespace backbend::solver {
namespace {

using glm::dvec3;

/// Which weight function a channel follows: middle bend, middle twist, top bend, top twist.
constexpr int function_of(int channel) {
  return (channel < 3 ? 0 : 2) + (channel % 3 == 0 ? 1 : 0);
}

/// The spin by the sum of two angles.
template <class Spin>
Spin together(const Spin& a, const Spin& b) {
  return {a.sine * b.cosine + a.cosine * b.sine, a.cosine * b.cosine - a.sine * b.sine};
}

double sum(Lanes a) { return (a[0] + a[1]) + (a[2] + a[3]); }

struct TurnLanes {
  Lanes w, x, y, z;
};

TurnLanes operator*(const TurnLanes& a, const TurnLanes& b) {
  return {
      a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
      a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

}  // namespace

glm::dquat turn_by_vector(const dvec3& v) {
  const double half = 0.5 * glm::length(v);
  const double ratio = half > 0.0 ? std::sin(half) / (2.0 * half) : 0.5;
  return {std::cos(half), ratio * v.x, ratio * v.y, ratio * v.z};
}

EvenIntegral::EvenIntegral(const EvenShape& shape, std::span<const AngleShare> share)
    : shape_(shape), share_(share) {
  for (const AngleShare& s : share) {
    for (int ch = 0; ch < kUpperChannels; ++ch) {
      // A weight is at most 1.
      most_[ch] = std::max(most_[ch], std::abs(s.base[ch]) + std::abs(s.scale[ch]));
    }
  }
  for (int ch = 0; ch < kUpperChannels; ++ch) {
    double scale = 0.0;
    for (const AngleShare& s : share) scale = std::max(scale, std::abs(s.scale[ch]));
    near_[ch] = 0.5 * shape.widest_ * shape.weights_.of(ch).peak_slope() * scale <= kTinyAngle;
  }
  if (share.size() > 1) return;
  for (int ch = 0; ch < kUpperChannels; ++ch) {
    if (most_[ch] > 0.0) full_[ch] = spin(Lanes(share[0].base[ch] + share[0].scale[ch]), most_[ch]);
  }
}

/// `most` bounds every lane. Which of the sines is taken does not show: small angles have the same
/// bits in both.
EvenIntegral::Spin EvenIntegral::spin(Lanes angle, double most) {
  Spin s;
  if (most <= kSmallAngle) {
    sin_cos_small(angle, s.sine, s.cosine);
  } else if (most <= kFastTrigonometryReach) {
    sin_cos(angle, s.sine, s.cosine);
  } else {
    s.sine = Lanes(std::sin(angle[0]), std::sin(angle[1]), std::sin(angle[2]), std::sin(angle[3]));
    s.cosine =
        Lanes(std::cos(angle[0]), std::cos(angle[1]), std::cos(angle[2]), std::cos(angle[3]));
  }
  return s;
}

EvenIntegral::Vector EvenIntegral::to_middle(const EvenShape& shape, const Vector& v) {
  if (shape.aligned_) return v;
  const glm::dmat3& m = shape.middle_from_top_;
  return {Lanes(m[0][0]) * v.x + Lanes(m[1][0]) * v.y + Lanes(m[2][0]) * v.z,
          Lanes(m[0][1]) * v.x + Lanes(m[1][1]) * v.y + Lanes(m[2][1]) * v.z,
          Lanes(m[0][2]) * v.x + Lanes(m[1][2]) * v.y + Lanes(m[2][2]) * v.z};
}

dvec3 EvenIntegral::to_middle(const EvenShape& shape, const dvec3& v) {
  const Vector turned = to_middle(shape, Vector{v.x, v.y, v.z});
  return {turned.x[0], turned.y[0], turned.z[0]};
}

Lanes EvenIntegral::angles(int channel, const double* weight, const int* own) const {
  const Lanes w = Lanes::load(weight + 4 * function_of(channel));
  if (share_.size() == 1)
    return Lanes(share_[0].base[channel]) + Lanes(share_[0].scale[channel]) * w;
  const auto of = [&](int lane) -> const AngleShare& { return share_[own[lane]]; };
  const auto gather = [&](UpperChannels AngleShare::*part) {
    return Lanes((of(0).*part)[channel], (of(1).*part)[channel], (of(2).*part)[channel],
                 (of(3).*part)[channel]);
  };
  return gather(&AngleShare::base) + gather(&AngleShare::scale) * w;
}

void EvenIntegral::spin_middles(std::size_t first, Middles& out) const {
  for (int ch = 0; ch < kUpperChannels; ++ch) {
    if (most_[ch] == 0.0 || !near_[ch]) continue;
    const Spin s =
        spin(angles(ch, &shape_.panel_weight_[4 * first], &shape_.panel_share_[first]), most_[ch]);
    s.sine.store(out.sine[ch]);
    s.cosine.store(out.cosine[ch]);
  }
}

void EvenIntegral::frames(std::span<glm::dquat> frame) const {
  const double* weight = shape_.frame_weight_.data();
  const int* own = shape_.frame_share_.data();
  for (std::size_t k = 0; k < frame.size(); k += 4, weight += 16, own += 4) {
    const auto control = [&](int first, const glm::dmat3& axes) {
      Spin half[3];
      for (int i = 0; i < 3; ++i) {
        const int ch = first + i;
        half[i] = {Lanes(0.0), Lanes(1.0)};
        if (most_[ch] == 0.0) continue;
        half[i] = spin(Lanes(0.5) * angles(ch, weight, own), 0.5 * most_[ch]);
      }
      const auto& [x, y, z] = half;
      const Lanes zy = z.cosine * y.cosine, zs = z.sine * y.sine;
      const Lanes cs = z.cosine * y.sine, sc = z.sine * y.cosine;
      const Lanes ex = zy * x.sine - zs * x.cosine, ey = cs * x.cosine + sc * x.sine;
      const Lanes ez = sc * x.cosine - cs * x.sine;
      const auto along = [&](int row) {
        return Lanes(axes[0][row]) * ex + Lanes(axes[1][row]) * ey + Lanes(axes[2][row]) * ez;
      };
      return TurnLanes{zy * x.cosine + zs * x.sine, along(0), along(1), along(2)};
    };
    const TurnLanes turn = upper_frame(shape_.middle_axes_, shape_.top_axes_, control);
    for (std::size_t i = 0; i < std::min<std::size_t>(4, frame.size() - k); ++i) {
      frame[k + i] = {turn.w[int(i)], turn.x[int(i)], turn.y[int(i)], turn.z[int(i)]};
    }
  }
}

template <int Groups, class Visitor>
void EvenIntegral::each_panel(const EvenShape::Rule& rule, Visitor& visitor) const {
  constexpr int kNodes = 4 * Groups;
  const bool one = share_.size() == 1;
  const double* row = rule.table.data();
  Middles middles;
  for (std::size_t p = 0; p < shape_.panel_.size(); ++p) {
    const EvenShape::Panel& panel = shape_.panel_[p];
    const int lane = int(p % 4);
    if (lane == 0) spin_middles(p, middles);
    const AngleShare& own = share_[one ? 0 : panel.share];
    for (int g = 0; g < Groups; ++g) {
      const double* at = row + 4 * g;
      // The spin of a channel at these nodes; null where it turns nothing.
      Spin here;
      const auto spin_of = [&](int ch) -> const Spin* {
        if (most_[ch] == 0.0) return nullptr;
        const int function = function_of(ch);
        if (one && panel.reach[function] == EvenShape::Reach::none) return nullptr;
        if (one && panel.reach[function] == EvenShape::Reach::full) return &full_[ch];
        const Lanes weight = Lanes::load(at + kNodes * function);
        if (near_[ch]) {
          Spin on;
          sin_cos_tiny(Lanes(own.scale[ch]) * (weight - Lanes(panel.middle[function])), on.sine,
                       on.cosine);
          here = together(Spin{middles.sine[ch][lane], middles.cosine[ch][lane]}, on);
        } else {
          here = spin(Lanes(own.base[ch]) + Lanes(own.scale[ch]) * weight, most_[ch]);
        }
        return &here;
      };
      const auto euler = [&](int first, Vector& v) {
        if (const Spin* s = spin_of(first)) {
          v = {v.x, s->cosine * v.y - s->sine * v.z, s->sine * v.y + s->cosine * v.z};
        }
        if (const Spin* s = spin_of(first + 1)) {
          v = {s->cosine * v.x + s->sine * v.z, v.y, s->cosine * v.z - s->sine * v.x};
        }
        if (const Spin* s = spin_of(first + 2)) {
          v = {s->cosine * v.x - s->sine * v.y, s->sine * v.x + s->cosine * v.y, v.z};
        }
      };
      Vector v{panel.in_top.x, panel.in_top.y, panel.in_top.z};
      euler(3, v);
      v = to_middle(shape_, v);
      euler(0, v);
      const dvec3& rest = panel.in_middle;
      visitor.group(panel, at + 4 * kNodes, kNodes,
                    Vector{v.x - Lanes(rest.x), v.y - Lanes(rest.y), v.z - Lanes(rest.z)});
    }
    visitor.end(panel);
    row += EvenShape::kRows * kNodes;
  }
}

template <int Groups>
void EvenIntegral::shifts(const EvenShape::Rule& rule, std::span<dvec3> shift) const {
  struct Visitor {
    const glm::dmat3& axes;
    std::span<dvec3> shift;
    int joint = 0;
    Vector total{0.0, 0.0, 0.0};
    void group(const EvenShape::Panel&, const double* table, int, const Vector& delta) {
      const Lanes gauss = Lanes::load(table);
      total.x += gauss * delta.x;
      total.y += gauss * delta.y;
      total.z += gauss * delta.z;
    }
    void end(const EvenShape::Panel& panel) {
      if (panel.ends_bone) shift[++joint] = axes * dvec3(sum(total.x), sum(total.y), sum(total.z));
    }
  } visitor{shape_.middle_axes_, shift};
  shift[0] = dvec3(0.0);
  each_panel<Groups>(rule, visitor);
}

template <int Groups>
void EvenIntegral::shifts(const EvenShape::Rule& rule, const ReachField& field,
                          std::span<dvec3> shift) const {
  struct Visitor {
    const glm::dmat3& axes;
    std::span<dvec3> shift;
    dvec3 a, b;  // the field's vectors in Middle's frame
    int joint = 0;
    Vector total{0.0, 0.0, 0.0};
    void group(const EvenShape::Panel& panel, const double* table, int stride,
               const Vector& delta) {
      const Lanes gauss = Lanes::load(table);
      const Lanes lean = Lanes::load(table + stride), bend = Lanes::load(table + 2 * stride);
      const Lanes fx = lean * Lanes(a.x) + bend * Lanes(b.x);
      const Lanes fy = lean * Lanes(a.y) + bend * Lanes(b.y);
      const Lanes fz = lean * Lanes(a.z) + bend * Lanes(b.z);
      const Lanes half = Lanes(0.5) * square_root(fx * fx + fy * fy + fz * fz);
      Lanes sine, w;
      sin_cos(half, sine, w);
      const Lanes ratio = select(half > Lanes(0.0), sine / (half + half), Lanes(0.5));
      const Lanes ux = ratio * fx, uy = ratio * fy, uz = ratio * fz;
      const Lanes vx = Lanes(panel.in_middle.x) + delta.x, vy = Lanes(panel.in_middle.y) + delta.y,
                  vz = Lanes(panel.in_middle.z) + delta.z;
      const Lanes cx = uy * vz - uz * vy, cy = uz * vx - ux * vz, cz = ux * vy - uy * vx;
      const Lanes two(2.0);
      total.x += gauss * (delta.x + two * (w * cx + (uy * cz - uz * cy)));
      total.y += gauss * (delta.y + two * (w * cy + (uz * cx - ux * cz)));
      total.z += gauss * (delta.z + two * (w * cz + (ux * cy - uy * cx)));
    }
    void end(const EvenShape::Panel& panel) {
      if (panel.ends_bone) shift[++joint] = axes * dvec3(sum(total.x), sum(total.y), sum(total.z));
    }
  };
  const glm::dmat3 middle_from_rig = glm::transpose(shape_.middle_axes_);
  Visitor visitor{shape_.middle_axes_, shift, middle_from_rig * field.v[0],
                  middle_from_rig * field.v[1]};
  shift[0] = dvec3(0.0);
  each_panel<Groups>(rule, visitor);
}

template <int Groups>
EvenShape::Moments EvenIntegral::moments(const EvenShape::Rule& rule) const {
  struct Visitor {
    Vector total[3] = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    void group(const EvenShape::Panel& panel, const double* table, int stride,
               const Vector& delta) {
      const Lanes gauss = Lanes::load(table);
      const Vector v{Lanes(panel.in_middle.x) + delta.x, Lanes(panel.in_middle.y) + delta.y,
                     Lanes(panel.in_middle.z) + delta.z};
      const auto add = [](Vector& to, Lanes weight, const Vector& of) {
        to.x += weight * of.x;
        to.y += weight * of.y;
        to.z += weight * of.z;
      };
      add(total[0], gauss, delta);
      add(total[1], gauss * Lanes::load(table + stride), v);
      add(total[2], gauss * Lanes::load(table + 2 * stride), v);
    }
    void end(const EvenShape::Panel&) {}
  } visitor;
  each_panel<Groups>(rule, visitor);
  const auto in_rig = [&](const Vector& v) {
    return shape_.middle_axes_ * dvec3(sum(v.x), sum(v.y), sum(v.z));
  };
  return {in_rig(visitor.total[0]), {in_rig(visitor.total[1]), in_rig(visitor.total[2])}};
}

template void EvenIntegral::shifts<2>(const EvenShape::Rule&, std::span<dvec3>) const;
template void EvenIntegral::shifts<3>(const EvenShape::Rule&, std::span<dvec3>) const;
template void EvenIntegral::shifts<4>(const EvenShape::Rule&, std::span<dvec3>) const;
template void EvenIntegral::shifts<3>(const EvenShape::Rule&, const ReachField&,
                                      std::span<dvec3>) const;
template void EvenIntegral::shifts<4>(const EvenShape::Rule&, const ReachField&,
                                      std::span<dvec3>) const;
template EvenShape::Moments EvenIntegral::moments<3>(const EvenShape::Rule&) const;
template EvenShape::Moments EvenIntegral::moments<4>(const EvenShape::Rule&) const;

}  // namespace backbend::solver
