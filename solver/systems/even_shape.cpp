#include "solver/systems/even_shape.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "solver/math/gauss_legendre.h"
#include "solver/math/rotation.h"
#include "solver/systems/even_integral.h"

namespace backbend::solver {

glm::dvec3 turned_by(const glm::dquat& q, const glm::dvec3& v) {
  const glm::dvec3 u(q.x, q.y, q.z);
  const glm::dvec3 a = glm::cross(u, v);
  return 2.0 * (q.w * a + glm::cross(u, a));
}

namespace {

using glm::dvec3;

constexpr std::array<int, 3> kNodesOfRule{8, 12, 16};
// The turning of a panel (sum over channels of peak slope times angle times width, radians) up to
// which a rule's error stays below 3e-14 of the spine, measured against 16 nodes on panels of a
// sixth. The last one holds to a turning of 12, which is 720 degrees on all six channels.
constexpr std::array<double, 2> kTurningOfRule{0.6, 4.5};
// A reach field turns by half a radian at most over a panel.
constexpr double kTurningOfField = 0.5;

/// `at` sorted, values closer than 1e-12 made one (the first stays).
void sort_unique(std::vector<double>& at) {
  std::sort(at.begin(), at.end());
  at.erase(std::unique(at.begin(), at.end(), [](double a, double b) { return b - a < 1e-12; }),
           at.end());
}

/// `v` turned about X, then Y, then Z, each by `angle(axis)`. An axis without a turn costs nothing.
template <class Angle>
BoxVector turned_by_euler(BoxVector v, const Angle& angle) {
  BoxReal* const part[3] = {&v.x, &v.y, &v.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const BoxReal turn = angle(axis);
    if (turn.value.is_zero()) continue;
    const BoxReal s = sine(turn), c = cosine(turn);
    BoxReal& a = *part[(axis + 1) % 3];
    BoxReal& b = *part[(axis + 2) % 3];
    const BoxReal a_turned = c * a - s * b;
    b = s * a + c * b;
    a = a_turned;
  }
  return v;
}

std::size_t segment_at(const std::vector<double>& corner, double s) {
  std::size_t i = 1;
  while (i + 1 < corner.size() && s > corner[i]) ++i;
  return i;
}

}  // namespace

EvenShape::EvenShape(std::span<const dvec3> drawn, const glm::dmat3& middle_axes,
                     const glm::dmat3& top_axes, const EvenWeights& weights, EvenPlaces places,
                     std::vector<double> share_ends)
    : places_(std::move(places)),
      bones_(places_.bones()),
      middle_axes_(middle_axes),
      top_axes_(top_axes),
      middle_from_top_(glm::transpose(middle_axes) * top_axes),
      aligned_(middle_from_top_ == glm::dmat3(1.0)),
      weights_(weights),
      share_end_(std::move(share_ends)) {
  assert(drawn.size() >= 2 && bones_ >= 1 && share_end_.back() == 1.0);
  std::vector<double> corner{0.0};
  for (std::size_t i = 1; i < drawn.size(); ++i) {
    corner.push_back(corner.back() + glm::length(drawn[i] - drawn[i - 1]));
  }
  length_ = corner.back();
  for (double& c : corner) c /= length_;
  corner.back() = 1.0;

  rest_joint_.push_back(drawn.front());
  for (int k = 1; k < bones_; ++k) {
    const double s = places_.joint[std::size_t(k)];
    const std::size_t i = segment_at(corner, s);
    const double f = (s - corner[i - 1]) / (corner[i] - corner[i - 1]);
    rest_joint_.push_back(drawn[i - 1] + f * (drawn[i] - drawn[i - 1]));
  }
  rest_joint_.push_back(drawn.back());
  cut_panels(drawn, corner);
  place_frames();
  place_panel_middles();
  for (int r = 0; r < kRules; ++r) tabulate(r);
}

void EvenShape::cut_panels(std::span<const dvec3> drawn, const std::vector<double>& corner) {
  std::vector<double> cut = places_.joint;
  for (const EvenWeight* w :
       {&weights_.middle_bend, &weights_.middle_twist, &weights_.top_bend, &weights_.top_twist}) {
    for (const double knot : w->knots()) cut.push_back(knot);
  }
  cut.insert(cut.end(), corner.begin(), corner.end());
  cut.insert(cut.end(), share_end_.begin(), share_end_.end());
  sort_unique(cut);
  // Panels wider than a tenth turn too much for one rule when there are few bones.
  constexpr double kWidest = 0.1;
  std::vector<double> edge{0.0};
  for (std::size_t i = 1; i < cut.size(); ++i) {
    const int parts = int(std::ceil((cut[i] - cut[i - 1]) / kWidest - 1e-9));
    for (int p = 1; p < parts; ++p) {
      edge.push_back(cut[i - 1] + (cut[i] - cut[i - 1]) * (double(p) / parts));
    }
    edge.push_back(cut[i]);
  }
  edge.back() = 1.0;

  int next_joint = 1;
  for (std::size_t i = 1; i < edge.size(); ++i) {
    Panel panel;
    panel.from = edge[i - 1];
    panel.to = edge[i];
    const double middle = 0.5 * (panel.from + panel.to);
    const std::size_t segment = segment_at(corner, middle);
    const dvec3 tangent = glm::normalize(drawn[segment] - drawn[segment - 1]);
    panel.in_top = glm::transpose(top_axes_) * tangent;
    panel.in_middle = EvenIntegral::to_middle(*this, panel.in_top);
    panel.middle = weights_.at(middle);
    const auto low = weights_.at(panel.from), high = weights_.at(panel.to);
    for (int f = 0; f < 4; ++f) {
      panel.reach[f] = high[f] == 0.0 ? Reach::none : low[f] == 1.0 ? Reach::full : Reach::part;
    }
    panel.share = 0;
    while (middle > share_end_[panel.share]) ++panel.share;
    panel.ends_bone = std::abs(panel.to - places_.joint[std::size_t(next_joint)]) < 1e-12;
    if (panel.ends_bone) ++next_joint;
    panel_.push_back(panel);
    widest_ = std::max(widest_, panel.to - panel.from);
  }
  assert(next_joint == bones_ + 1);
}

void EvenShape::place_frames() {
  for (int first = 0; first <= bones_; first += 4) {
    std::array<std::array<double, 4>, 4> weight;
    for (int i = 0; i < 4; ++i) {
      const double s = places_.frame[std::size_t(std::min(first + i, bones_))];
      weight[i] = weights_.at(s);
      int share = 0;
      while (s > share_end_[share]) ++share;
      frame_share_.push_back(share);
    }
    for (int f = 0; f < 4; ++f) {
      for (int i = 0; i < 4; ++i) frame_weight_.push_back(weight[i][f]);
    }
  }
}

void EvenShape::place_panel_middles() {
  for (std::size_t first = 0; first < panel_.size(); first += 4) {
    const auto panel = [&](int i) -> const Panel& {
      return panel_[std::min(first + std::size_t(i), panel_.size() - 1)];
    };
    for (int i = 0; i < 4; ++i) panel_share_.push_back(panel(i).share);
    for (int f = 0; f < 4; ++f) {
      for (int i = 0; i < 4; ++i) panel_weight_.push_back(panel(i).middle[f]);
    }
  }
}

void EvenShape::tabulate(int r) {
  const int n = kNodesOfRule[r];
  rule_[r].nodes = n;
  std::vector<double> node, gauss;
  gauss_legendre(n, node, gauss);
  std::vector<double>& table = rule_[r].table;
  table.resize(panel_.size() * kRows * n);
  double* row = table.data();
  for (const Panel& p : panel_) {
    for (int i = 0; i < n; ++i) {
      const double s = p.from + (p.to - p.from) * node[i];
      const auto w = weights_.at(s);
      for (int f = 0; f < 4; ++f) row[f * n + i] = w[f];
      row[4 * n + i] = gauss[i] * (p.to - p.from) * length_;
      for (int b = 0; b < 2; ++b) row[(5 + b) * n + i] = reach_bump(b, s);
    }
    row += kRows * n;
  }
}

double EvenShape::panel_turning(std::span<const AngleShare> share) const {
  double turning = 0.0;
  for (const AngleShare& s : share) {
    double here = 0.0;
    for (int ch = 0; ch < kUpperChannels; ++ch) {
      here += weights_.of(ch).peak_slope() * std::abs(s.scale[ch]);
    }
    turning = std::max(turning, here * widest_);
  }
  return turning;
}

BoxTurn EvenShape::frame(int k, std::span<const BoxReal> upper) const {
  assert(share_end_.size() == 1 && upper.size() == kUpperChannels);
  const double s = places_.frame[std::size_t(k)];
  return upper_frame(middle_axes_, top_axes_, [&](int first, const glm::dmat3& axes) {
    const auto angle = [&](int i) {
      return BoxReal(weights_.of(first + i)(s)) * upper[std::size_t(first + i)];
    };
    return euler_turn(axes, from_euler_xyz(angle(0), angle(1), angle(2)));
  });
}

void EvenShape::shifts(std::span<const BoxReal> upper, std::span<BoxVector> shift) const {
  assert(share_end_.size() == 1 && upper.size() == kUpperChannels);
  AngleShare most;
  for (std::size_t ch = 0; ch < kUpperChannels; ++ch) most.scale[ch] = upper[ch].value.most();
  const double turning = panel_turning({&most, 1});
  const Rule& rule = rule_[turning <= kTurningOfRule[0] ? 0 : turning <= kTurningOfRule[1] ? 1 : 2];
  const auto n = std::size_t(rule.nodes);
  BoxVector total;
  shift[0] = total;
  std::size_t joint = 0;
  const double* row = rule.table.data();
  for (const Panel& panel : panel_) {
    for (std::size_t i = 0; i < n; ++i) {
      const auto turned = [&](std::size_t first, const BoxVector& v) {
        return turned_by_euler(v, [&](std::size_t axis) {
          const std::size_t ch = first + axis;
          return BoxReal(row[EvenWeights::index_of(ch) * n + i]) * upper[ch];
        });
      };
      const BoxVector in_middle = middle_from_top_ * turned(3, BoxVector(panel.in_top));
      const BoxVector moved = turned(0, in_middle) - BoxVector(panel.in_middle);
      total = total + BoxReal(row[4 * n + i]) * moved;
    }
    if (panel.ends_bone) shift[++joint] = middle_axes_ * total;
    row += kRows * n;
  }
}

EvenShape::Moments EvenShape::moments(std::span<const AngleShare> share) const {
  const EvenIntegral integral(*this, share);
  return panel_turning(share) <= kTurningOfRule[1] ? integral.moments<3>(rule_[1])
                                                   : integral.moments<4>(rule_[2]);
}

void EvenShape::solve(std::span<const AngleShare> share, const ReachField* field,
                      std::span<glm::dquat> frame, std::span<dvec3> shift) const {
  assert(share.size() == share_end_.size());
  assert(frame.size() == rest_joint_.size() && shift.size() == rest_joint_.size());
  const EvenIntegral integral(*this, share);
  integral.frames(frame);
  const double turning = panel_turning(share);
  if (field && !field->none()) {
    for (int k = 0; k < bones_; ++k) {
      frame[k] = turn_by_vector(field->at(places_.frame[std::size_t(k)])) * frame[k];
    }
    if (turning + kTurningOfField <= kTurningOfRule[1]) {
      return integral.shifts<3>(rule_[1], *field, shift);
    }
    return integral.shifts<4>(rule_[2], *field, shift);
  }
  if (turning == 0.0) {
    // One turn for the whole spine only if there is none: every share starts from 0 at the hips.
    std::fill(shift.begin(), shift.end(), dvec3(0.0));
    return;
  }
  if (turning <= kTurningOfRule[0]) return integral.shifts<2>(rule_[0], shift);
  if (turning <= kTurningOfRule[1]) return integral.shifts<3>(rule_[1], shift);
  integral.shifts<4>(rule_[2], shift);
}

}  // namespace backbend::solver
